"""Trajectory: what a simulation returns, with its wrenches where and when they are asked for."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ...core.dynamics.open_tree import OpenTree
from ...core.dynamics.problem_solver import ProblemSolver
from ...core.dynamics.velocity_ratios import VelocityRatios
from ...core.elements.link_loads import Wrench
from ...core.elements.pin_contact import PinContact
from ...core.kinematics.deciding import decided_at
from ...core.kinematics.tolerances import CLOSURE_TOLERANCE
from ...core.problem.acting import Acting
from ...core.problem.samples import Targets, acting_on
from ...core.results.collect import scattered, sweep_of
from ...core.results.element_results import ElementResults
from ...core.results.motion import Motion
from ...core.results.prescribed import MotionResult
from ...core.results.sweep import Sweep
from ...core.results.table import Table, Variable
from ...core.results.wrench import JointWrench
from ...kit.arrays import EPS, NOTHING, ROUNDED, Array, squeezed
from ...kit.checks import numbers, whole
from ...kit.errors import (
    AccuracyError,
    ArgumentError,
    AssemblyError,
    CardanError,
    SingularConfigurationError,
)
from ...kit.frozen import frozen, made, read_only
from .contact_following import Touch
from .continuity import Continuity, States
from .energy import gained
from .events import Happened
from .free_balls import NEARLY
from .runs import Run
from .setup import Setup
from .system import Rows

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ...core.mechanism.mechanism import Mechanism
    from ...core.results.point_motion import Points
    from ...core.results.rods import RodForce


_EXACT, _INTEGRATED = 1e-8, 1e-5
"""Differences of positions from the integrals of speeds over time, as fractions of the way, that
are refused: of a quadrature, and of steps at most as exact as that."""
_OF_STEPS = 100.0
"""Such a difference of steps, in relative tolerances; and the absolute tolerances by which states
may be off, however little they move."""
_FAR_BEYOND = 1e3
"""Energy residual, in tolerances of a step, above which notes tell of it."""
_LOST = float(np.sqrt(ROUNDED))
"""Effort that accelerations leave unbalanced, as part of the greatest, above which wrenches are not
known."""
PER_PERIOD = 64
"""Times per turn or swing that a quadrature returns, and steps over which the power of a motion
that repeats is integrated by Gauss's rule."""
_ENERGIES = {
    "kinetic_energy": "kinetic energy of all bodies",
    "potential_energy": "potential energy of the weight and of springs",
    "work": "work of all but weight and springs since time 0",
}


@dataclass(frozen=True, eq=False)
class Course:
    """How a simulation went.

    Attributes:
        setup: what was simulated.
        run: its states.
        start: coordinates `(size,)`, all turns counted, and velocities `(nv,)` at time 0.
        method: how it was solved.
        reason: why it ended before its time; empty if it did not.
        events: those that happened.
        notes: what a user should know of it.
        evaluations: how often accelerations were computed.
        touches: of pins with clearance, in the order in which they ended.
    """

    setup: Setup
    run: Run
    start: tuple[Array, Array]
    method: str
    reason: str = ""
    events: tuple[Happened, ...] = ()
    notes: tuple[str, ...] = ()
    evaluations: int = 0
    touches: tuple[Touch, ...] = ()

    def __getstate__(self) -> dict[str, object]:
        # Proofs hold functions, and are made anew where a copy is read.
        return {name: getattr(self, name) for name in self.__dataclass_fields__}

    @property
    def rtol(self) -> float:
        """Relative tolerance of a step; inf where steps have a given length."""
        return self.setup.rtol if self.setup.step is None else np.inf

    @property
    def is_proven(self) -> bool:
        """Whether states are held to a tolerance.

        Errors of steps of a given length are the user's; pins strike between the steps.
        """
        return self.setup.step is None and not self.setup.contacts

    @property
    def tolerance(self) -> float:
        """Error of states, as a fraction of the way of a coordinate, that is refused."""
        return _EXACT if self.run.is_exact else max(_INTEGRATED, _OF_STEPS * self.setup.rtol)

    @property
    def _scalars(self) -> tuple[Array, Array, Array]:
        """Columns and rates of all turns and slides that are proven, and the units of ways."""
        coordinates = self.setup.mechanism.coordinates
        columns, rates = coordinates.scalars
        # Rules for positions between times need speeds that are bounded.
        bounded = ~np.isin(rates, list(self.run.boundless))
        return columns[bounded], rates[bounded], coordinates.scale[columns[bounded]]

    def states(self, rows: Rows) -> States:
        """Return the states of all turns and slides, in rad and fractions of the length.

        But for angles that are read off rotations.
        """
        columns, rates, units = self._scalars
        return States(
            rows.counted[:, columns] * units, rows.v[:, rates] * units, rows.a[:, rates] * units
        )

    @cached_property
    def of_drives(self) -> Continuity:
        """Motion of the drives alone; only where the run knows of it."""
        coordinates, drives = self.setup.mechanism.coordinates, self.setup.solver.problem
        columns = coordinates.columns_of(drives.independent)
        rates = coordinates.rates_of(drives.independent)

        def look(times: Array) -> States:
            return cast("States", self.run.drives_alone(times))

        start = self.start[0][columns], self.start[1][rates]
        return self._continuity(look, start, closes_loops=not self.run.is_exact)

    @cached_property
    def of_all(self) -> Continuity:
        """Motion of all turns and slides."""
        columns, rates, units = self._scalars
        start = self.start[0][columns] * units, self.start[1][rates] * units
        return self._continuity(lambda times: self.states(self.run.rows(times)), start)

    def _continuity(
        self,
        look: Callable[[Array], States],
        start: tuple[Array, Array],
        *,
        closes_loops: bool = True,
    ) -> Continuity:
        run, times = self.run, self.run.times
        if run.is_exact:
            times = np.linspace(0.0, min(run.period, float(times[-1])), PER_PERIOD // 2 + 1)
        off = ROUNDED if run.is_exact else _OF_STEPS * self.setup.atol
        return Continuity(
            look,
            times,
            start,
            tolerance=self.tolerance,
            is_exact=run.is_exact,
            least=(off if closes_loops else 8.0 * EPS) / self.tolerance,
            period=run.period if run.period < run.times[-1] else np.inf,
        )


def _of_sweep(name: str) -> Any:
    """Return a member of the sweep along a trajectory, under its own name."""
    return property(lambda trajectory: getattr(trajectory.sweep, name), doc=f"See `Sweep.{name}`.")


class Trajectory(MotionResult):
    """Motion, energies and joint wrenches of a simulation over N times.

    `trajectory["bearing_out"]` is a `JointWrench` as that of a sweep; `at` gives the same
    simulation at any other times. Wrenches, and all else that a `Sweep` has, are computed when they
    are first read, by inverse dynamics with the accelerations that the simulation found: so
    `effort_residual`, what free drives would have to exert for this motion, proves it; reading them
    raises what `sweep` raises. Nothing in it can be changed.

    Attributes:
        time: times `(N,)` [s]: the steps of the method, or those that `at` was given.
        method: how it was solved.
        reason: why it ended before its time; empty if it did not.
        events: `(name, time)` of the events that happened.
        evaluations: how often accelerations were computed.
        touches: of pins with clearance and their walls, in the order in which they ended.
        acceleration: of `coordinates` [rad/s² or m/s²], like `position`; proven, as wrenches are.
        wrench, rotation, origin: of a joint, see `Sweep`.
        unique, holding_effort, loads, gravity, condition, elastic_energy: see `Sweep`.
        loop_residual, balance_residual, power_residual, rate_residual: see `Sweep`.
    """

    acceleration: Array = _of_sweep("acceleration")
    balance_residual: float = _of_sweep("balance_residual")
    condition: Array = _of_sweep("condition")
    elastic_energy: Array = _of_sweep("elastic_energy")
    gravity: Array = _of_sweep("gravity")
    holding_effort: Mapping[str, Array] = _of_sweep("holding_effort")
    loads: Mapping[str, Array | Wrench] = _of_sweep("loads")
    loop_residual: float = _of_sweep("loop_residual")
    origin: Callable[[str], Array] = _of_sweep("origin")
    power_residual: float = _of_sweep("power_residual")
    rate_residual: float = _of_sweep("rate_residual")
    rotation: Callable[[str], Array] = _of_sweep("rotation")
    unique: Array = _of_sweep("unique")
    wrench: Callable[..., JointWrench] = _of_sweep("wrench")

    def __init__(self, course: Course, time: Array) -> None:
        self._course, self._run, self._forces = course, course.run, course.setup.forces
        self._solver = course.setup.solver
        self._problem = self._solver.problem
        self.time = read_only(time)
        self.method, self.reason = course.method, course.reason
        self.events = course.events
        self.evaluations, self.touches = course.evaluations, course.touches
        self._freeze()

    def __getitem__(self, joint: str) -> JointWrench:
        return self.sweep[joint]

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names of the joints whose wrenches are results."""
        return iter(self.outputs)

    def __contains__(self, joint: object) -> bool:
        return isinstance(joint, str) and joint in self.outputs

    def __len__(self) -> int:
        return len(self.time)

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """What one should know of it, such as that the equations are stiff or ring.

        That the energy of the whole simulation is off by far more than its tolerance as well, which
        is computed when notes are first read.
        """
        notes, course = self._course.notes, self._course
        allowed = max(_FAR_BEYOND * course.rtol, NOTHING)
        if not np.isfinite(allowed):
            return notes
        is_all = np.array_equal(self.time, self._run.times)
        of_all = self if is_all else type(self)(course, self._run.times)
        try:
            residual = of_all.energy_residual
        except CardanError as error:
            return (*notes, f"its energy could not be checked: {error}")
        if residual <= allowed:
            return notes
        return (
            *notes,
            f"inaccurate: energy and work differ by {residual:.1e}, where the tolerance of a step "
            f"is {course.rtol:.0e}; compare with a simulation of another rtol",
        )

    def __reduce__(self) -> tuple[object, ...]:
        # With its states: loops that are closed once more are closed to other roundings.
        try:
            known = {"_rows": self._rows, "_drives_alone": self._drives_alone}
        except CardanError:
            known = {}  # The copy is refused where it is read, as this is.
        known |= {
            name: self.__dict__[name]
            for name in ("work", "_misfit", "_begun")
            if name in self.__dict__
        }
        return made, (type(self), {"course": self._course, "time": self.time}, known)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the times, `(N,)`."""
        return self.time.shape

    def __repr__(self) -> str:
        ended = f", ended by: {self.reason}" if self.reason else ""
        if count := len(self._course.notes):
            ended += f"; {count} note{'s' * (count > 1)}"
        ended += "".join(f"; {text}" for text in self._beware())
        return (
            f"<Trajectory of {self.mechanism.name!r}: {len(self)} times from {self.time[0]:g} to "
            f"{self.time[-1]:g} s by {self.method}{ended}>"
        )

    def _beware(self) -> list[str]:
        """Return in words what is close to singular, and where limits are exceeded.

        A text takes no longer than the simulation: at more times than it has steps, nothing is told
        until it was asked for.
        """
        if "_solved" not in self.__dict__ and len(self) > len(self._run.times):
            return []
        try:
            told = list(self.sweep.beware)
        except CardanError as error:
            return [f"wrenches are not known: {error}"]
        if times := self.time[self.singular].tolist():
            first = f"singular at t = {times[0]:.6g} s"
            told.append(f"{first}, and at {len(times) - 1} more times" if times[1:] else first)
        return told

    def at(self, times: ArrayLike) -> Trajectory:
        """Return the same simulation at other times.

        Args:
            times: `(K,)` or a number, within the simulation [s].

        Raises:
            ArgumentError: not finite, or outside the simulation.
        """
        values = np.atleast_1d(numbers("times", times))
        if values.ndim != 1 or not values.size:
            raise ArgumentError(f"times has shape {values.shape}, expected (K,)")
        end = float(self._run.times[-1])
        if np.min(values) < 0.0 or np.max(values) > end * (1.0 + 1e-15):
            raise ArgumentError(
                f"times from {np.min(values):g} to {np.max(values):g} s reach beyond the "
                f"simulation, 0 to {end:g} s"
            )
        return type(self)(self._course, np.minimum(values, end))

    def evenly(self, count: int) -> Trajectory:
        """Return the same simulation at equidistant times, as an animation shows it.

        Raises:
            ArgumentError: the count is no whole number above 0.
        """
        return self.at(np.linspace(0.0, float(self._run.times[-1]), whole("count", count)))

    @cached_property
    def _rows(self) -> Rows:
        rows = self._run.rows(self.time, self._drives_alone)
        if self._course.is_proven:
            self._prove(self._course.of_all, self._course.states(rows))
        return rows

    @cached_property
    def _drives_alone(self) -> States | None:
        drives = self._run.drives_alone(self.time)
        if drives is not None and self._course.is_proven:
            self._prove(self._course.of_drives, drives)
        return drives

    def _prove(self, motion: Continuity, states: States) -> None:
        """Refuse states that are not on the motion from the start."""
        misfit = motion.misfit(self.time, states)
        self.__dict__["_misfit"] = max(self.__dict__.get("_misfit", 0.0), misfit.size)
        if not misfit.size <= motion.tolerance:
            raise AccuracyError(
                f"at time {misfit.time:.6g} s positions are not the integrals of speeds over time "
                f"from the start, but {misfit.size:.1e} of their way off: they belong to another "
                "time, turn or assembly mode; choose another method or a smaller rtol",
                residual=misfit.size,
                tolerance=motion.tolerance,
            )

    @property
    def time_residual(self) -> float:
        """Greatest difference of positions from the integrals of speeds over time, from the start.

        As a fraction of the way of a coordinate. What rounding of positions and times makes of it
        counts as well, in a quadrature also that of the time of each period. Where steps have a
        tolerance, what rules over the times between them cannot tell is not counted. It is nan for
        steps of a given length and for pins with clearance, which are not held to it.
        """
        states, course = self._course.states(self._rows), self._course
        if not course.is_proven:
            return np.nan
        late = float(np.max(self._run.late(self.time)))
        return float(self.__dict__["_misfit"]) + course.of_all.left_open(self.time, states, late)

    @cached_property
    def _of_drives(self) -> States:
        if self._drives_alone is not None:
            return self._drives_alone
        of, rows = self.mechanism.coordinates, self._rows
        columns, rates = of.columns_of(self.coordinates), of.rates_of(self.coordinates)
        return States(self.states[0][:, columns], rows.v[:, rates], rows.a[:, rates])

    @property
    def position(self) -> Array:
        """Positions of `coordinates` `(N,)` [rad or m], `(N, d)` if they are several."""
        return read_only(squeezed(self._of_drives.x))

    @property
    def speed(self) -> Array:
        """Speeds of `coordinates` [rad/s or m/s], like `position`.

        NaN where a middle angle of a ball or floating base is at ±90° and the body turns so that
        the outer angles have no speed there.
        """
        if self._drives_alone is not None:
            return read_only(squeezed(self._drives_alone.v))
        known = self._rows.exist[:, self.mechanism.coordinates.rates_of(self.coordinates)]
        return read_only(squeezed(np.where(known, self._of_drives.v, np.nan)))

    @property
    def sweep(self) -> Sweep:
        """The motion as a sweep of the scene: wrenches, efforts and residuals at the times.

        At a dead point of the free coordinates, what they do not decide is found by other ones:
        there velocity ratios alone are NaN, and the condition is that of the others. What is not
        known at singular configurations is NaN there, see `singular`.

        Raises:
            SingularConfigurationError: nothing decides the motion at any of the times.
            AccuracyError: all of them are close to such configurations.
            CardanError: as `Scene.sweep`.
        """
        sweep, _, error = self._solved
        if sweep is None:
            raise error
        return sweep

    @property
    def motion(self) -> Motion:
        """Positions, speeds and accelerations of all joints, as those of a sweep; see `singular`.

        Raises:
            CardanError: as `Scene.sweep`.
        """
        sweep = self._solved[0]
        return self._run_motion(()) if sweep is None else sweep.motion

    @property
    def singular(self) -> Array:
        """Whether the configuration is so close to singular that forces are not known `(N,)`.

        That is where a drive is in a dead point, or assembly modes meet; at a dead point of the
        free coordinates alone, other ones decide the motion, and forces are known. Wrenches,
        efforts of drives, accelerations and velocity ratios are NaN at these times, the condition
        is infinite; positions, drive speeds and energies hold, other speeds lose digits.
        """
        return read_only(self._solved[1] > _LOST)

    @cached_property
    def _solved(self) -> tuple[Sweep | None, Array, CardanError]:
        """Return `sweep`, None if all times are singular, effort errors `(N,)`, and the last error.

        Raises:
            AccuracyError: accelerations are wrong where nothing is close to singular.
        """
        errors, is_near, error = self._judged
        if np.any((errors > _LOST) & ~is_near):
            raise error
        parts: list[tuple[Array, Sweep]] = []
        own, left = np.ones(len(self), dtype=bool), np.flatnonzero((errors > ROUNDED) & is_near)
        while left.size:
            worst = int(np.argmax(errors[left]))
            tried = np.arange(len(left)) == worst
            if (by_others := self._part(left)._by_others(worst)) is None:
                # Where these coordinates are the best, they are as well where less is wrong.
                tried |= errors[left[worst]] <= _LOST
            else:
                other, found = by_others
                better = (found < errors[left]) & (found <= _LOST)
                if np.any(better):
                    parts.append((left[better], other._part(np.flatnonzero(better))._unproven))
                    errors[left[better]], own[left[better]] = found[better], False
                    tried |= better
            left = left[~tried]
        if np.all(own & (errors <= _LOST)):
            return self._unproven, errors, error
        if (known := np.flatnonzero(own & (errors <= _LOST))).size:
            parts.insert(0, (known, self._part(known)._unproven))
        if not parts:
            return None, errors, error
        positions, motion = self._of_drives.x, self._run_motion(parts)
        return scattered(self._solver, parts, motion, positions, self._acting()), errors, error

    @cached_property
    def _judged(self) -> tuple[Array, Array, CardanError]:
        """Return effort errors `(N,)`, where the configuration is close to singular, and the error.

        Errors are infinite where the coordinates do not decide the motion.
        """
        errors, near = np.full(len(self), np.inf), np.ones(len(self), dtype=bool)
        known, error = np.arange(len(self)), CardanError("no time is given")
        while known.size:
            part = self if len(known) == len(self) else self._part(known)
            try:
                sweep = part._unproven
            except (SingularConfigurationError, AssemblyError) as found:
                # Closed as they are, but not decided by the drives.
                if found.sample is None or not part._is_closed(found.sample):
                    raise
                error = found
                if isinstance(found, AssemblyError):
                    error = SingularConfigurationError(
                        f"at time {part.time[found.sample]:.6g} s the configuration is singular: "
                        "the drives do not decide the motion of all joints, so that wrenches "
                        "and accelerations are not known; leave such times out with at()",
                        sample=int(known[found.sample]),
                    )
                known = np.delete(known, found.sample)
                continue
            # Away from singular configurations, errors are rounding times the condition number.
            errors[known] = part._effort_errors(sweep)
            near[known] = ((sweep.condition * NEARLY > 1.0) | part._locked) & (not sweep.idle_rods)
            if np.any(errors[known] > _LOST):
                error = part._wrong_accelerations(sweep, errors[known])
            break
        return errors, near, error

    def _by_others(self, index: int) -> tuple[Trajectory, Array] | None:
        """Return the same by other free coordinates, and its effort errors `(N,)`.

        They decide the motion at one of the times; None where there are none.
        """
        setup = self._course.setup
        problem = decided_at(self._problem, self._rows.x[index])
        if problem is None or set(problem.free) == set(self._problem.free):
            return None
        try:
            setup = replace(setup, solver=ProblemSolver(problem))
            other = type(self)(replace(self._course, setup=setup), self.time)
            other.__dict__.update(_rows=self._rows, _drives_alone=None)
            return other, other._judged[0]
        except CardanError:
            return None

    @property
    def _locked(self) -> Array:
        """Whether outer axes of a free ball nearly coincide `(N,)`: angles have no rates."""
        locked = np.zeros(len(self), dtype=bool)
        for ball in self._run.balls:
            locked |= np.array([ball.apart(x) for x in self._rows.x]) < NEARLY
        return locked

    def _is_closed(self, index: int) -> bool:
        """Return whether loops are closed in a state."""
        state = self._solver.assembly.kinematics.evaluate(self._rows.x[[index]])
        return bool(state.residual[0] < CLOSURE_TOLERANCE)

    def _part(self, chosen: Array) -> Trajectory:
        """Return the same at some of its times."""
        part, drives = self.at(self.time[chosen]), self._drives_alone
        part.__dict__.update(
            _rows=self._rows.at(chosen), _drives_alone=drives and drives.at(chosen)
        )
        if "_misfit" in self.__dict__:
            part.__dict__["_misfit"] = self.__dict__["_misfit"]
        return part

    @cached_property
    def _unproven(self) -> Sweep:
        """The motion as a sweep at all times, whatever its residuals are."""
        positions, problem = self._of_drives.x, self._problem
        x, turns = self._rows.x.copy(), self._rows.turns.copy()
        columns = problem.mechanism.coordinates.columns_of(problem.independent)
        x[:, columns], turns[:, columns] = positions, 0.0
        assembled = self._solver.assembled_near(Targets.of_positions(positions), x, turns)
        with np.errstate(over="ignore", invalid="ignore"):
            return sweep_of(self._solver, assembled, self._acting())

    def _wrong_accelerations(self, sweep: Sweep, errors: Array) -> AccuracyError:
        """Return the error that refuses wrong accelerations."""
        worst = int(np.argmax(errors))
        if sweep.idle_rods:
            rods = "; ".join(" and ".join(rod) for rod in sweep.idle_rods)
            return AccuracyError(
                f"the rod between {rods} spins about its line and is not symmetric about it, "
                "so that its spin moves the drives; sweeps know nothing of spins: decide it by "
                "a universal joint instead of one of the balls",
                residual=float(errors[worst]),
            )
        is_near = sweep.condition[worst] * NEARLY > 1.0 or self._locked[worst]
        found = f"the condition is {sweep.condition[worst]:.1e}"
        reason = (
            f"the configuration is close to singular ({found})"
            if is_near
            else "they do not belong to what acts, such as where the law of an element jumps; the "
            f"configuration is not singular ({found})"
        )
        return AccuracyError(
            f"at time {self.time[worst]:.6g} s accelerations and wrenches are wrong by "
            f"{errors[worst]:.1e}: {reason}; leave such times out with at()",
            time=float(self.time[worst]),
            residual=float(errors[worst]),
        )

    def _run_motion(self, parts: Sequence[tuple[Array, Sweep]]) -> Motion:
        """Return the motion at all times, of which some are solved.

        Velocity ratios are those of these coordinates alone.
        """
        rows, count = self._rows, len(self)
        x, turns, v = rows.x.copy(), rows.turns.copy(), rows.v.copy()
        a = np.full_like(rows.a, np.nan)
        ratios = VelocityRatios.of(np.full((*v.shape, len(self.coordinates)), np.nan))
        for known, sweep in parts:
            motion = sweep.motion
            x[known], turns[known], v[known], a[known] = motion.x, motion.turns, motion.v, motion.a
            if sweep.coordinates == self.coordinates:
                values = np.full((count, motion.velocity_ratios.values.shape[1]), np.nan)
                values[known] = motion.velocity_ratios.values
                ratios = motion.velocity_ratios._replace(values=values)
        return Motion(self.mechanism, self.coordinates, x, turns, (v, a, ratios))

    def _acting(self) -> Acting:
        """Return rates of the drives and what acts at the times."""
        problem = self._problem
        # Where a load jumps, states that are closed anew may be on its other side.
        joints, links = self._forces.sampled(self.time, *(self._rows.read or self.states))
        efforts = {name: np.asarray(effort) for name, effort in joints.items()}
        return acting_on(problem)._replace(
            speeds=self._of_drives.v,
            accelerations=self._of_drives.a,
            joint_loads=frozen(efforts),
            link_loads=frozen(links),
            time=self.time,
        )

    @property
    def _prescribed(self) -> tuple[str, ...]:
        """Names of the drives whose motion was prescribed, or which carry what was."""
        setup = self._course.setup
        return setup.carried or tuple(setup.motions)

    @property
    def steps(self) -> Array:
        """Times `(S,)` of the method's own steps [s], whatever times `at` was given."""
        return read_only(self._run.times)

    @property
    def states(self) -> tuple[Array, Array]:
        """Coordinates `(N, size)`, all turns counted, and velocities `(N, nv)`; see `Motion`.

        Those of the method: no wrench is computed for them.
        """
        return self._rows.counted, self._rows.v

    @cached_property
    def element_force(self) -> ElementResults:
        """What the force elements exert, see `Sweep.element_force`; this needs no wrenches."""
        return ElementResults.of(self._problem, *self.states, self.time, self.shape)

    @cached_property
    def drive_effort(self) -> Array:
        """What the drives exert, as `Sweep.drive_effort`; zero of free ones, see `effort_residual`.

        Raises:
            CardanError: as `sweep`.
        """
        # By definition; what a sweep finds there is how wrong accelerations are.
        efforts = self.sweep.drive_effort.reshape(len(self), -1)
        return read_only(squeezed(np.where(self._is_free, 0.0, efforts)))

    @property
    def _is_free(self) -> Array:
        """Which coordinates nothing drives `(d,)`."""
        return np.array([name not in self._prescribed for name in self.coordinates])

    @property
    def effort_residual(self) -> float:
        """Greatest effort of a free coordinate, as part of the greatest of inertia and loads.

        Of loads and weight, what they do within a radian, or over the characteristic length.

        The equations of motion ask for none: it is what is wrong with the accelerations. Forces
        count as moments by the characteristic length.
        """
        sweep, errors, error = self._solved
        if sweep is None:
            raise error
        return float(np.max(errors[errors <= _LOST]))

    def _effort_errors(self, sweep: Sweep) -> Array:
        """Return `(N,)` the effort of the free coordinates, see `effort_residual`."""
        coordinates, drives = self.mechanism.coordinates, self.coordinates
        scale = coordinates.rate_scale[coordinates.rates_of(drives)]
        efforts = np.abs(sweep.drive_effort.reshape(len(self), -1)) * scale
        return np.asarray(np.max(efforts[:, self._is_free], axis=1) / (self._effort_scale or 1.0))

    @cached_property
    def _effort_scale(self) -> float:
        """Greatest effort of all joints if no loop were closed, in which no singularity is felt.

        A moment that takes all kinetic energy within a radian counts as well, and what weight,
        springs and loads could do within one: at rest nothing else is left.
        """
        mechanism = self.mechanism
        # Rates of angles that are near gimbal lock are great, whatever the body does.
        open_tree = self._open_tree.efforts(*self._rows.regular)
        loads = self._forces.all_efforts(self.time, *self.states)
        efforts = np.maximum(open_tree, np.abs(loads)) * mechanism.coordinates.rate_scale
        greatest = max(float(np.max(efforts, initial=0.0)), float(np.max(self.kinetic_energy)))
        return max(greatest, self._greatest_reach)

    @cached_property
    def kinetic_energy(self) -> Array:
        """Kinetic energy of all bodies `(N,)` [J]."""
        states = self._rows.regular
        return read_only(self._open_tree.kinetic(states.x, states.v))

    @cached_property
    def potential_energy(self) -> Array:
        """Potential energy of the weight and of springs `(N,)` [J]."""
        energy = OpenTree(self.mechanism, self._problem.gravity).potential(self._rows.x)
        elements = self._problem.element_forces
        if elements is not None:
            energy = energy + elements.at(*self.states, self.time).potential_energy
        return read_only(energy)

    @cached_property
    def _open_tree(self) -> OpenTree:
        # With balls, it has all that a tree is read from.
        mechanism = cast("Mechanism", self._run.regular or self.mechanism)
        return OpenTree(mechanism, self._problem.gravity)

    @cached_property
    def work(self) -> Array:
        """Work `(N,)` that all but weight and springs has done since time 0 [J].

        That is loads, actuators and prescribed drives, less what dampers and friction took.
        """
        steps, times, period = self._run.times, self.time, self._run.period
        if steps[-1] > period:
            # No work is left of a whole period, and one is resolved however many there are.
            steps, times = np.linspace(0.0, period, PER_PERIOD + 1), times % period
        is_idle = self._forces.does_no_work and not self._prescribed
        return read_only(gained(self._power, steps, times, is_idle))

    def _power(self, times: Array) -> Array:
        """Return the power of loads and prescribed drives at times `(K,)` [W]."""
        there = self.at(times)
        x, v = there.states
        loads = self._forces.with_elements(()).all_efforts(times, x, v)
        power = np.einsum("nk,nk->n", loads, v)
        elements = self._problem.element_forces
        if elements is not None:
            power = power + elements.supplied(x, v, times)
        if self._prescribed:
            # What is wrong with an effort shows in the balance of energy, which takes it.
            try:
                sweep = there._unproven
            except (SingularConfigurationError, AssemblyError) as error:
                if np.any(there.singular):
                    raise AccuracyError(
                        "the work of prescribed drives is not known where they are singular"
                    ) from error
                sweep = there.sweep
            efforts = sweep.drive_effort.reshape(len(times), -1)
            chosen = [self.coordinates.index(name) for name in self._prescribed]
            power += np.sum(efforts[:, chosen] * there._of_drives.v[:, chosen], axis=1)
        return np.asarray(power)

    @cached_property
    def energy_residual(self) -> float:
        """Greatest change of energy less work, as a fraction of `energy_scale`."""
        energy = self.kinetic_energy + self.potential_energy
        change = float(np.max(np.abs(energy - sum(self._begun) - self.work)))
        return change / self.energy_scale if change else 0.0

    @cached_property
    def _begun(self) -> tuple[float, float]:
        """Kinetic and potential energy at time 0 [J]."""
        start = self if self.time[0] == 0.0 else self.at([0.0])
        return float(start.kinetic_energy[0]), float(start.potential_energy[0])

    @property
    def energy_scale(self) -> float:
        """Energy that can change [J].

        That is the greatest of what the motion had: kinetic energy, change of potential energy,
        work; but not less than what springs and loads would do where it passed over one radian, or
        the characteristic length, in which tolerances of positions are counted, and the weight of
        all bodies over that length. So motion that hardly moves is not measured by what rounding
        leaves of it.
        """
        return max(
            float(np.max(self.kinetic_energy)),
            float(np.max(np.abs(self.potential_energy - self._begun[1]))),
            float(np.max(np.abs(self.work))),
            self._greatest_reach,
        )

    @property
    def _greatest_reach(self) -> float:
        """What weight, springs and loads would do within a radian [J], see `energy_scale`.

        Walls of contacts are left out, whose forces act over a small part of a radian.
        """
        mechanism = self.mechanism
        forces = self._forces.with_elements(
            [item for item in self.elements if not isinstance(item, PinContact)]
        )
        weight = self._open_tree.weight * mechanism.characteristic_length
        if forces.is_nothing:
            return weight
        x, rest = self.states[0], np.zeros_like(self._rows.v)
        efforts = np.abs(forces.all_efforts(self.time, x, rest))
        greatest = np.max(efforts * mechanism.coordinates.rate_scale, initial=0.0)
        return max(weight, float(greatest))

    def rod_force(self, link: str) -> RodForce:
        """Return the force along a rod between two balls, see `Sweep.rod_force`.

        Raises:
            CardanError: as `sweep`, and as `Sweep.rod_force`.
        """
        return self.sweep.rod_force(link)

    @property
    def joint_coordinates(self) -> Array:
        """Coordinates `(N, size)` of the method, for which no wrench is computed."""
        return self._rows.x

    @property
    def joint_velocities(self) -> Array:
        """Velocities `(N, nv)`, likewise; NaN where those of a ball's angles are not known."""
        return np.where(self._known_rates, self._rows.v, np.nan)

    @property
    def joint_accelerations(self) -> Array:
        """Accelerations `(N, nv)`, proven as wrenches are; NaN where velocities or these are."""
        return np.where(self._known_rates, self.motion.a, np.nan)

    @cached_property
    def _known_rates(self) -> Array:
        """Which velocities say how the bodies move `(N, nv)`.

        Where the outer axes of a ball coincide, its angles may have no speeds, or lose their digits
        in those of the body.
        """
        rows, known = self._rows, self._rows.exist.copy()
        for ball in self._run.balls:
            angles, rates = ball.columns, ball.rates_of
            for index, spin in enumerate(rows.regular.v[:, rates]):
                off = ball.spin(rows.x[index, angles], rows.v[index, rates]) - spin
                if not np.max(np.abs(off)) <= NOTHING * np.max(np.abs(spin)):
                    known[index, rates] = False
        return known

    def given(self) -> Table:
        """Return times and the motion of drives and free coordinates."""
        return self._over_time(self.sweep.given(), {})

    def table(self, *, motion: bool = True, points: Points = ()) -> Table:
        """Return all results as a table over `time`, energies and work included.

        It holds what the table of a sweep does, see `results.sweep`, and `kinetic_energy`,
        `potential_energy` (of the weight and of springs; `elastic_energy` is the part of springs)
        and `work` [J]. Attributes tell `method`, the three residuals of a trajectory, the `reason`
        for which it ended before its time, and as JSON its `notes` and `events`.

        Args:
            motion: whether to include the motion of the joints.
            points: see `to_dataframe`.

        Raises:
            CardanError: as `sweep`.
        """
        energies = {
            name: Variable(("time",), getattr(self, name), "J", label)
            for name, label in _ENERGIES.items()
        }
        swept = self._over_time(self.sweep.table(motion=motion), energies)
        variables = dict(swept.variables)
        if effort := variables.get("drive_effort"):
            variables["drive_effort"] = effort._replace(values=self.drive_effort)
        told = {
            "method": self.method,
            "reason": self.reason,
            "notes": json.dumps(self.notes, ensure_ascii=False),
            "events": json.dumps([[name, float(time)] for name, time in self.events]),
            "effort_residual": self.effort_residual,
            "energy_residual": self.energy_residual,
            "time_residual": self.time_residual,
        }
        table = replace(
            swept,
            variables=list(variables.items()),
            attributes={**swept.attributes, **told},
        )
        return self._with_points(table, points)

    def _over_time(self, swept: Table, energies: Mapping[str, Variable]) -> Table:
        """Return a table of the sweep with times along its dimension, `time` the first column.

        Energies come after the motion of the drives.
        """
        variables = {
            name: variable._replace(
                dims=tuple("time" if dim == "sample" else dim for dim in variable.dims)
            )
            for name, variable in swept.variables
        }
        leading = "time", "position", "speed", "acceleration"
        first = {name: variables.pop(name) for name in leading if name in variables}
        every = {**first, **energies, **variables}
        return replace(swept, variables=list(every.items()), samples={"time": len(self.time)})
