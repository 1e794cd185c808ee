"""Plan: what a scene computes per sample, and what it leaves out and why."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..core.dynamics.problem_solver import ProblemSolver
from ..core.kinematics.loops.groups import Group
from ..core.mechanism.mechanism import Mechanism


@dataclass(frozen=True, eq=False, repr=False)
class Plan:
    """What a scene does per sample, and how it is simulated; `print` shows it.

    Attributes:
        steps: what a sweep does, in order.
        skipped: what is left out, and why.
        simulation: by which methods the scene is simulated.
    """

    steps: list[str]
    skipped: list[str]
    simulation: str

    def __str__(self) -> str:
        lines = [f"{index}. {step}" for index, step in enumerate(self.steps, start=1)]
        if self.skipped:
            lines += ["skipped:", *(f"- {reason}" for reason in self.skipped)]
        lines.append(f"simulated by: {self.simulation}")
        return "\n".join(lines)

    def __repr__(self) -> str:
        return str(self)

    def _repr_html_(self) -> str:
        from ..kit.markup import element, listed  # Imported here: only notebooks show it.

        skipped = element("p", "skipped:") + listed("ul", self.skipped) if self.skipped else ""
        how = element("p", f"simulated by: {self.simulation}")
        return f"<div>{listed('ol', self.steps)}{skipped}{how}</div>"


def plan_of(solver: ProblemSolver, simulation: str) -> Plan:
    """Return what a sweep of a scene does and leaves out, and how the scene is simulated.

    Args:
        solver: of the scene.
        simulation: see `Plan`.
    """
    problem, groups, needed = solver.problem, solver.assembly.groups, solver.assembly.needed
    mechanism, has_weight = problem.mechanism, bool(np.any(problem.gravity))
    steps, skipped = [], []
    on_loops = {body for group in groups if group.loops for body in group.bodies}
    for index, group in enumerate(groups):
        task = _task(mechanism, group, on_loops)
        if index not in needed.motion:
            skipped.append(f"{task}: no output needs it")
        elif group.loops or group.couplings:
            steps.append(task)
            if index not in needed.forces:
                skipped.append(f"closure forces of: {task}: no output needs them")
    if problem.elements:
        kinds = [type(element).__name__ for element in problem.elements]
        counted = (f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds))
        steps.append(f"forces of elements: {', '.join(counted)}")
    if solver.has_mass:
        weight = "weight, and inertia" if has_weight else "inertia"
        steps.append(f"inverse dynamics: {weight} where the drives have speed or acceleration")
    else:
        skipped.append("inverse dynamics: no body has mass")
    if not has_weight:
        skipped.append("weight: the scene has no gravity")
    if needed.forces:
        order = "against the order of motion" if len(needed.forces) > 1 else "at once"
        steps.append(f"closure forces of {len(needed.forces)} group(s), {order}")
        steps.append("wrenches of: " + ", ".join(problem.outputs))
    else:
        steps.append("drive efforts by virtual work")
    bodies = "" if needed.efforts_alone else ", balance of bodies"
    steps.append(f"residuals: loops, rates{bodies}, power")
    return Plan(steps, skipped, simulation)


def _task(mechanism: Mechanism, group: Group, on_loops: set[int]) -> str:
    """Return which loops and couplings a group closes, and what they decide.

    That is joints, or single coordinates where others of the joint are driven, held or left open.

    Args:
        mechanism: the mechanism.
        group: the group.
        on_loops: bodies (0-based) on the loops of all groups.
    """
    closed = [mechanism.loops[index].joint for index in group.loops]
    closed += [mechanism.couplings[index].name for index in group.couplings]
    columns = {int(column) for column in group.passives}
    decided: list[str] = []
    for name, span in mechanism.coordinates.velocity_columns.items():
        own = columns.intersection(range(span.start, span.stop))
        is_whole = len(own) == mechanism.joints[name].nv
        decided += [name] if is_whole else mechanism.coordinates.names_of(own)
    if not closed:
        carried = sorted(
            joint.name
            for joint in mechanism.joints.values()
            if joint.parts and joint.id - 1 in group.inertial_bodies
        )
        where = "on no loop" if on_loops.isdisjoint(group.inertial_bodies) else "by themselves"
        return f"bodies {where}: {', '.join(carried)}"
    task = f"close {', '.join(closed)}: decides {', '.join(decided) or 'nothing'}"
    if group.idle:
        task += f"; {len(group.idle)} idle rod(s), which do not turn about their lines"
    return task
