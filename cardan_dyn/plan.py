"""Plan: which groups a scene solves for what it is asked, and what it leaves out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .coordinates import Coordinates
from .groups import Group
from .mechanism import Mechanism


@dataclass(frozen=True, eq=False)
class Needs:
    """What the wanted outputs need.

    Attributes:
        motion: numbers of the groups whose motion is solved.
        forces: numbers of those whose closure forces are solved.
        complete: bodies (0-based) on which every wrench is known.
        efforts_alone: whether no wrench is wanted, only the drive efforts.
    """

    motion: list[int]
    forces: set[int]
    complete: set[int]
    efforts_alone: bool


def needs(
    mechanism: Mechanism,
    coordinates: Coordinates,
    groups: list[Group],
    wanted: set[int] | None,
) -> Needs:
    """Return what the wrenches of some bodies' joints need.

    The closure forces of a group need those of every later group that loads one of its passive
    joints; its motion needs that of the groups which decide what moves its bodies.

    Args:
        mechanism: the mechanism.
        coordinates: layout of its coordinates.
        groups: from `partition`.
        wanted: bodies (0-based) whose joint wrenches are wanted; None for all, the empty set for
            the drive efforts alone.
    """
    everything = set(range(len(groups)))
    bodies = set(range(mechanism.model.njoints - 1))
    if not wanted:
        forces = everything if wanted is None else set()
        complete = bodies if wanted is None else set()
        return Needs(sorted(everything), forces, complete, wanted is not None)
    carriers: dict[int, set[int]] = {body: set() for body in bodies}
    for number, group in enumerate(groups):
        for body in group.bodies:
            carriers[body].add(number)
    owner = {
        column: part.index - 1
        for part in coordinates.parts
        for column in range(
            mechanism.model.idx_vs[part.index], mechanism.model.idx_vs[part.index] + part.size
        )
    }
    decider = {
        owner[int(column)]: number
        for number, group in enumerate(groups)
        for column in group.passives
    }
    forces = set()
    open_groups = [number for body in wanted for number in carriers[body]]
    while open_groups:
        number = open_groups.pop()
        if number not in forces:
            forces.add(number)
            for column in groups[number].passives:
                open_groups.extend(carriers[owner[int(column)]])
    motion: set[int] = set()
    open_groups = list(forces)
    while open_groups:
        number = open_groups.pop()
        if number not in motion:
            motion.add(number)
            group = groups[number]
            movers = {*group.bodies, *(owner[int(column)] for column in group.known)}
            open_groups.extend(decider[body] for body in movers if body in decider)
    complete = {body for body, numbers in carriers.items() if numbers and numbers <= forces}
    return Needs(sorted(motion), forces, complete, False)


def solved_couplings(groups: list[Group], needed: Needs) -> list[int]:
    """Return the numbers of the couplings whose moments are solved, ascending."""
    return sorted(number for place in needed.forces for number in groups[place].couplings)


@dataclass(frozen=True, eq=False)
class Plan:
    """What a scene does per sample, for people.

    Attributes:
        steps: what is done, in order.
        skipped: what is left out, and why.
    """

    steps: list[str]
    skipped: list[str]

    def __str__(self) -> str:
        lines = [f"{number}. {step}" for number, step in enumerate(self.steps, start=1)]
        if self.skipped:
            lines += ["skipped:", *(f"- {reason}" for reason in self.skipped)]
        return "\n".join(lines)


def plan_of(
    mechanism: Mechanism,
    coordinates: Coordinates,
    groups: list[Group],
    needed: Needs,
    outputs: tuple[str, ...],
    *,
    heavy: bool,
    weight: bool,
) -> Plan:
    """Return what a sweep of a scene does, and what it leaves out.

    Args:
        mechanism: the mechanism.
        coordinates: layout of its coordinates.
        groups: all groups of the scene.
        needed: which of them its outputs need.
        outputs: names of the joints whose wrenches are wanted.
        heavy: whether any body has mass.
        weight: whether there is gravity.
    """
    steps, skipped = [], []
    for number, group in enumerate(groups):
        text = _named(mechanism, coordinates, group)
        if number not in needed.motion:
            skipped.append(f"{text}: no output needs it")
        elif group.loops or group.couplings:
            steps.append(text)
            if number not in needed.forces:
                skipped.append(f"closure forces of: {text}: no output needs them")
    if heavy:
        acting = "weight and inertia" if weight else "inertia"
        steps.append(f"inverse dynamics: {acting}; inertia only in sweeps with speed")
    else:
        skipped.append("inverse dynamics: no body has mass")
    if not weight:
        skipped.append("weight: the scene has no gravity")
    if needed.forces:
        order = "against the order of motion" if len(needed.forces) > 1 else "at once"
        steps.append(f"closure forces of {len(needed.forces)} group(s), {order}")
        steps.append("wrenches of: " + ", ".join(outputs))
    else:
        steps.append("drive efforts by virtual work")
    bodies = "" if needed.efforts_alone else ", balance of bodies"
    steps.append(f"residuals: loops, rates{bodies}, power")
    return Plan(steps, skipped)


def _named(mechanism: Mechanism, coordinates: Coordinates, group: Group) -> str:
    """Return what a group closes and decides, by name."""
    closed = [mechanism.loops[number].joint for number in group.loops]
    closed += [mechanism.couplings[number].name for number in group.couplings]
    columns = {int(column) for column in group.passives}
    decided = [
        name
        for name, span in coordinates.velocities.items()
        if columns.intersection(range(span.start, span.stop))
    ]
    if not closed:
        carried = sorted(
            joint.name
            for joint in mechanism.joints.values()
            if joint.parts and joint.index - 1 in group.massive
        )
        return f"bodies on no loop: {', '.join(carried)}"
    return f"close {', '.join(closed)}: decides {', '.join(decided) or 'nothing'}"


def columns_of(groups: list[Group]) -> np.ndarray:
    """Return the passives of several groups."""
    parts = [group.passives for group in groups]
    return np.sort(np.concatenate([np.zeros(0, dtype=int), *parts]))
