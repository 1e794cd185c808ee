"""Setup: what a simulation is asked for, checked."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...core.dynamics.problem_solver import ProblemSolver
from ...core.elements.pin_contact import PinContact
from ...core.mechanism.mechanism import Mechanism
from ...core.problem.samples import acting_on
from ...kit.arrays import EPS, ROUNDED, Array
from ...kit.checks import flag, mapping, positive, whole
from ...kit.errors import ArgumentError
from .crossings import notes_of_rounding, refuse_rounding
from .events import Event, watched
from .forces import Forces, StateFunction, state_function
from .integration import FINEST
from .prescribed_motion import Written, begun_at, prescribed_motions
from .progress import Progress
from .recorded_contact import RecordedContact
from .start_state import closed_start, drive_positions, rounding_of_speeds
from .system import Motion

_BRIEFEST = float(np.finfo(float).tiny / EPS)
"""Least duration [s] whose smallest parts are numbers, and speed [rad/s or m/s] other than none."""
_FEWEST_STEPS = 200
"""Steps that a simulation takes at least where functions of users act: at rest, errors would allow
steps that leap over a pulse."""


@dataclass(frozen=True, eq=False)
class Setup:
    """A checked simulation; see `Scene.simulate`.

    Attributes:
        solver: of the scene, all of whose loops it closes.
        duration: [s].
        motions: prescribed drives to how they move.
        x, turns, v: closed coordinates and velocities at the start.
        forces: what acts beside the weight.
        rtol, atol: tolerances of a step; atol for angles and lengths as fractions.
        method: that is asked for, None if any suits.
        step: length of all steps [s]; None where the error decides.
        kinks: prescribed drives to the times [s] after which their acceleration is another.
        events: to be located.
        progress: shows how far it got.
        settle: whether fast modes rest at the start.
        max_touches: of pins in their bushes, after which it ends.
        carried: joints whose efforts make the prescribed drives move, and what rests while they
            act; none if these move by themselves.
        notes: what is known of it before it begins.
    """

    solver: ProblemSolver
    duration: float
    motions: dict[str, Motion]
    x: Array
    turns: Array
    v: Array
    forces: Forces
    rtol: float
    atol: float
    method: str | None
    step: float | None
    kinks: dict[str, tuple[float, ...]]
    events: list[Event]
    progress: Progress
    settle: bool
    max_touches: int
    carried: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def __getstate__(self) -> dict[str, Any]:
        # Results can be copied, whatever users' functions were called while they were found.
        functions = {"motions": dict.fromkeys(self.motions), "events": []}
        return {**self.__dict__, **functions, "progress": Progress(False, self.duration)}

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism."""
        return self.solver.problem.mechanism

    @property
    def start(self) -> tuple[Array, Array]:
        """Coordinates `(size,)`, all turns counted, and velocities `(nv,)` at time 0."""
        return self.x + 2.0 * np.pi * self.turns, self.v

    @property
    def drive_start(self) -> tuple[float, float]:
        """Position and speed of the first coordinate at time 0."""
        drive = self.mechanism.coordinates.named[self.solver.problem.independent[0]]
        x, v = self.start
        return float(x[drive.column]), float(v[drive.rate])

    @property
    def contacts(self) -> list[tuple[int, RecordedContact]]:
        """Pins with clearance, each with its index among the elements."""
        elements = enumerate(self.solver.problem.elements)
        return [(index, item) for index, item in elements if isinstance(item, RecordedContact)]

    @property
    def longest_step(self) -> float:
        """Longest step [s] that overlooks nothing of what users' functions do; inf without any."""
        has_functions = self.forces.has_functions or bool(self.motions)
        return self.duration / _FEWEST_STEPS if has_functions else np.inf


def with_all_loops(solver: ProblemSolver) -> ProblemSolver:
    """Return the solver that closes all loops, and keeps the outputs where they need all."""
    decided = set(solver.assembly.decided.tolist())
    if decided.issuperset(solver.problem.passive_columns.tolist()):
        return solver
    problem = solver.problem
    joints = tuple(problem.mechanism.joints)
    return ProblemSolver(replace(problem, outputs=joints, all_outputs=True))


def _with_recorded_contacts(solver: ProblemSolver) -> ProblemSolver:
    """Return a solver whose pins with clearance keep what one simulation finds out about them."""
    problem = solver.problem
    if not any(isinstance(element, PinContact) for element in problem.elements):
        return solver
    elements = tuple(
        RecordedContact.of(element) if isinstance(element, PinContact) else element
        for element in problem.elements
    )
    return ProblemSolver(replace(problem, elements=elements), like=solver)


def setup_of(
    scene_solver: ProblemSolver,
    *,
    duration: Any,
    position: Any = None,
    speed: Any = None,
    motion: Any = None,
    loads: Any = None,
    rtol: Any = 1e-10,
    atol: Any = None,
    method: Any = None,
    step: Any = None,
    settle: Any = False,
    events: Any = (),
    max_touches: Any = 100_000,
    progress: Any = None,
    carried: tuple[str, ...] = (),
    known: Collection[str] | None = None,
) -> Setup:
    """Return a simulation after all its arguments were checked, but for the method.

    These are those of `Scene.simulate`, but for `carried`, see `Setup`, and `known`, see `Forces`.

    Raises:
        ArgumentError, ModelError, AssemblyError, SingularConfigurationError: see `Scene.simulate`.
    """
    solver = _with_recorded_contacts(with_all_loops(scene_solver))
    problem = solver.problem
    duration = positive("duration", duration)
    if duration < _BRIEFEST:
        raise ArgumentError(
            f"duration is {duration:g} s, which numbers cannot divide into steps; the least is "
            f"{_BRIEFEST:.2g} s"
        )
    rtol = positive("rtol", rtol)
    if rtol < FINEST:
        raise ArgumentError(f"rtol is {rtol:g}, below rounding; the least is {FINEST:g}")
    if rtol >= 1.0:
        raise ArgumentError(f"rtol is {rtol:g}; expected a fraction, such as 1e-10")
    motions, starts = prescribed_motions(problem.drives, problem.free, motion, duration)
    positions = drive_positions(solver, position, starts)
    motions = begun_at(motions, dict(zip(problem.independent, positions.tolist(), strict=True)))
    farthest = float(np.max(np.abs(positions), initial=0.0))
    if not farthest * ROUNDED <= 1.0:
        raise ArgumentError(
            f"position is {farthest:.3g}, beyond {1.0 / ROUNDED:g}, of which numbers keep no place "
            "within a turn: leave whole turns out"
        )
    speeds = {name: item(0.0)[1] for name, item in motions.items()}
    with np.errstate(over="ignore", invalid="ignore"):  # Such speeds are refused right here.
        begun = closed_start(solver, positions, speed, speeds)
    v = np.where(np.abs(begun.v[0]) < _BRIEFEST, 0.0, begun.v[0])
    rounding = rounding_of_speeds(solver, begun)
    refuse_rounding(rounding)
    scale = problem.mechanism.coordinates.rate_scale
    refuse_distances(float(np.max(np.abs(begun.v[0]) / scale, initial=0.0)), duration)
    return Setup(
        solver=solver,
        duration=duration,
        motions=motions,
        x=begun.x[0].copy(),
        turns=begun.turns[0].copy(),
        v=v,
        forces=forces_of(solver, loads, known),
        rtol=rtol,
        atol=rtol if atol is None else positive("atol", atol),
        method=method,
        step=None if step is None else positive("step", step),
        kinks={name: item.kinks for name, item in motions.items() if isinstance(item, Written)},
        events=watched(events),
        progress=Progress(progress, duration),
        settle=flag("settle", settle),
        max_touches=whole("max_touches", max_touches),
        carried=carried,
        notes=tuple(notes_of_rounding(rounding, rtol)),
    )


def refuse_distances(fastest: float, duration: float, reach: float = 1.0) -> None:
    """Refuse speeds at which coordinates would lose their digits within a duration.

    Args:
        fastest: speed [rad/s, or lengths of the mechanism per second].
        duration: of the simulation [s].
        reach: of a swing to either side, if less than 1 [rad, or lengths of the mechanism]: places
            within it are told apart.

    Raises:
        ArgumentError: the way is too long.
    """
    reach = min(reach, 1.0)
    farthest = reach / ROUNDED
    if not fastest <= farthest / duration:
        swing = f" in a swing of {reach:.3g} rad" if reach < 1.0 else ""
        raise ArgumentError(
            f"a joint moves at up to {fastest:.3g} rad/s{swing} (of slides, rad are lengths of the "
            f"mechanism); within {duration:g} s that is a way of more than "
            f"{farthest:.3g} rad, of which numbers keep no place within a turn or swing: "
            "simulate a shorter time or a lower speed"
        )


def forces_of(
    solver: ProblemSolver, loads: Any = None, known: Collection[str] | None = None
) -> Forces:
    """Return what acts, with the loads of the simulation instead of those of the scene.

    Args:
        solver: of the scene.
        loads: see `Scene.simulate`.
        known: see `Forces`.

    Raises:
        ArgumentError, ModelError: see `Scene.simulate`.
    """
    problem = solver.problem
    functions: dict[str, StateFunction] = {}
    constant = {}
    for name, value in mapping("loads", loads).items():
        if callable(value):
            if name not in problem.mechanism.coordinates.named:
                problem.mechanism.link_frame(name)
            functions[name] = state_function(f"loads[{name!r}]", value)
        else:
            constant[name] = value
    acting = acting_on(problem, loads=constant)
    for name, effort in acting.joint_loads.items():
        if np.size(effort) != 1:
            raise ArgumentError(
                f"loads[{name!r}] has shape {np.shape(effort)}; a simulation takes one value, or a "
                "function of time"
            )
    for name, load in acting.link_loads.items():
        if load.force.size != 3 or load.moment.size != 3:
            raise ArgumentError(f"loads[{name!r}]: a simulation takes one wrench, or a function")
    loads_on = acting.joint_loads, acting.link_loads
    return Forces(problem.mechanism, *loads_on, functions, problem.elements, known)
