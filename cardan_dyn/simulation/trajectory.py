"""Trajectory: what a simulation returns, with its wrenches where and when they are asked for."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..arrays import Array
from ..checks import numbers, whole
from ..dynamics.problem_solver import ProblemSolver
from ..dynamics.velocity_ratios import VelocityRatios
from ..errors import (
    AccuracyError,
    ArgumentError,
    AssemblyError,
    CardanError,
    SingularConfigurationError,
)
from ..frozen import frozen, read_only
from ..kinematics.tolerances import CLOSURE_TOLERANCE
from ..problem.samples import Acting, acting_on
from ..results.collect import Scattered, sweep_of
from ..results.motion import Motion
from ..results.sweep import Sweep
from .contact_following import Touch
from .continuity import Continuity, States
from .energy import WeightEnergy, element_power, gained, open_efforts
from .events import Happened
from .forces import Forces
from .runs import OfDrives, Rows, Run
from .trajectory_tables import Tabled

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

_GREATEST_ERROR = 1e-6
"""Effort residual above which accelerations and wrenches are refused. Away from singular
configurations it is rounding times the condition number."""

_NEARLY_SINGULAR = 1e4
"""Condition from which on wrong accelerations are those of a singular configuration."""

_EXACT_TIMES = 33
"""Times up to a period, at most, between which exact states are compared first."""

_ROUNDED = 2e-15
"""Error of a drive's position by which it may be off however little it moves [rad or m]."""

_FAR_BEYOND = 1e3
"""Energy residual, in tolerances of a step, above which notes tell of it..."""
_FAINT = 1e-9
"""...and the least residual of which they tell."""


_STEPS_PER_PERIOD = 64
"""Steps over which the power of a motion that repeats is integrated by Gauss's rule."""


class Course(NamedTuple):
    """How a simulation went.

    Attributes:
        method: how it was solved.
        reason: why it ended before its time; empty if it did not.
        events: those that happened.
        notes: what a user should know of it.
        prescribed: names of the drives whose motion was prescribed.
        evaluations: how often accelerations were computed.
        start: coordinates `(size,)`, all turns counted, and velocities `(nv,)` at time 0.
        tolerance: of states, as a fraction of the way of a coordinate; inf for steps of a given
            length, whose errors are the user's, and where pins strike between the steps.
        least_way: least way [rad, or lengths of the mechanism] that the tolerance is relative to.
        touches: of pins with play, in the order in which they ended.
        rtol: relative tolerance of a step; inf where steps have a given length.
    """

    method: str
    reason: str
    events: tuple[Happened, ...]
    notes: tuple[str, ...]
    prescribed: tuple[str, ...]
    evaluations: int
    start: tuple[Array, Array]
    tolerance: float
    least_way: float
    touches: tuple[Touch, ...] = ()
    rtol: float = np.inf


class Motions:
    """The motion that the states of a run are proven by, of the drives alone and of all joints."""

    def __init__(self, solver: ProblemSolver, run: Run, course: Course) -> None:
        """Keep the run; each motion is followed when states are first read.

        Args:
            solver: of the scene.
            run: what a method found.
            course: how it went.
        """
        self._run, self._course = run, course
        coordinates = solver.problem.mechanism.coordinates
        columns, rates = coordinates.scalars
        # Rules for positions between times need speeds that are bounded.
        bounded = ~np.isin(rates, list(run.boundless))
        self._columns, self._rates = columns[bounded], rates[bounded]
        self._units = coordinates.scale[self._columns]
        drives = solver.problem.independent
        self._driven = coordinates.columns_of(drives), coordinates.rates_of(drives)

    def states(self, rows: Rows) -> States:
        """Return the states of all turns and slides, in rad and fractions of the length.

        But for angles that are read off rotations.
        """
        x = (rows.x + 2.0 * np.pi * rows.turns)[:, self._columns]
        v, a = (rates[:, self._rates] for rates in (rows.v, rows.a))
        return States(*(values * self._units for values in (x, v, a)))

    @cached_property
    def of_drives(self) -> Continuity:
        """Motion of the drives alone."""
        run = self._run

        def look(times: Array) -> States:
            drives = run.drives_alone(times)
            if drives is None:  # Only where there are any is it asked.
                raise AccuracyError("the run knows nothing of drives alone")
            return States(*drives)

        x, v = self._course.start
        columns, rates = self._driven
        is_exact = self._run.is_exact
        return self._continuity(look, (x[columns], v[rates]), closes_loops=not is_exact)

    @cached_property
    def of_all(self) -> Continuity:
        """Motion of all turns and slides."""
        x, v = self._course.start
        start = x[self._columns] * self._units, v[self._rates] * self._units
        return self._continuity(lambda times: self.states(self._run.rows(times)), start)

    def _continuity(
        self,
        look: Callable[[Array], States],
        start: tuple[Array, Array],
        *,
        closes_loops: bool = True,
    ) -> Continuity:
        run = self._run
        times = run.times
        if run.is_exact:
            times = np.linspace(0.0, min(run.period, float(times[-1])), _EXACT_TIMES)
        return Continuity(
            look,
            times,
            start,
            tolerance=self._course.tolerance,
            is_exact=run.is_exact,
            least=self._course.least_way if closes_loops else _ROUNDED / self._course.tolerance,
            period=run.period if run.period < run.times[-1] else np.inf,
        )


class Trajectory(Tabled):
    """Motion, energies and joint wrenches of a simulation over N times.

    `trajectory["bearing_out"]` is a `JointWrench` as that of a sweep; `at` gives the same
    simulation at any other times. Wrenches are computed when they are first read, by inverse
    dynamics with the accelerations that the simulation found: so `effort_residual`, what free
    drives would have to exert for this motion, proves it. Nothing in it can be changed.

    Attributes:
        time: times `(N,)` [s]: the steps of the method, or those that `at` was given.
        method: how it was solved.
        reason: why it ended before its time; empty if it did not.
        events: `(name, time)` of the events that happened.
        evaluations: how often accelerations were computed.
        touches: of pins with play and the walls of their bushes, in the order in which they ended.
    """

    def __init__(
        self,
        solver: ProblemSolver,
        run: Run,
        forces: Forces,
        course: Course,
        time: Array,
        motions: Motions | None = None,
    ) -> None:
        self._solver, self._run, self._forces, self._course = solver, run, forces, course
        self._motions = Motions(solver, run, course) if motions is None else motions
        self._problem = solver.problem
        self.time = read_only(time)
        self.method, self.reason = course.method, course.reason
        self.events = course.events
        self.evaluations, self.touches = course.evaluations, course.touches
        self._freeze()

    def __len__(self) -> int:
        return len(self.time)

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """What one should know of it, such as that the equations are stiff or ring.

        That the energy of the whole simulation is off by far more than its tolerance as well, which
        is computed when notes are first read.
        """
        notes, course = self._course.notes, self._course
        allowed = max(_FAR_BEYOND * course.rtol, _FAINT)
        if not np.isfinite(allowed):
            return notes
        whole = Trajectory(self._solver, self._run, self._forces, course, self._run.times)
        try:
            residual = whole.energy_residual
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
        made_of = self._solver, self._run, self._forces, self._course, self.time
        return Trajectory, made_of

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the times, `(N,)`."""
        return self.time.shape

    def __repr__(self) -> str:
        ended = f", ended by: {self.reason}" if self.reason else ""
        return (
            f"<Trajectory of {self.mechanism.name!r}: {len(self)} times from {self.time[0]:g} to "
            f"{self.time[-1]:g} s by {self.method}{ended}>"
        )

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
        t = np.minimum(values, end)
        made_of = self._solver, self._run, self._forces, self._course
        return Trajectory(*made_of, t, self._motions)

    def evenly(self, count: int) -> Trajectory:
        """Return the same simulation at equidistant times, as an animation shows it.

        Raises:
            ArgumentError: the count is no whole number above 0.
        """
        return self.at(np.linspace(0.0, float(self._run.times[-1]), whole("count", count)))

    @cached_property
    def _rows(self) -> Rows:
        rows = self._run.rows(self.time, self._drives_alone)
        if self._is_proven:
            self._prove(self._motions.of_all, self._motions.states(rows))
        return rows

    @cached_property
    def _drives_alone(self) -> OfDrives | None:
        drives = self._run.drives_alone(self.time)
        if drives is not None and self._is_proven:
            self._prove(self._motions.of_drives, States(*drives))
        return drives

    @property
    def _is_proven(self) -> bool:
        """Whether the method has a tolerance that states can be held to."""
        return bool(np.isfinite(self._course.tolerance))

    def _prove(self, motion: Continuity, states: States) -> None:
        """Refuse states that are not on the motion from the start.

        Raises:
            AccuracyError: they are not.
        """
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

        As a fraction of the way of a coordinate. Where steps have a tolerance, what rules over the
        times between them cannot tell is not counted. It is nan for steps of a given length and for
        pins with play, which are not held to it.
        """
        _ = self._rows
        return float(self.__dict__.get("_misfit", np.nan))

    @cached_property
    def _of_drives(self) -> OfDrives:
        if self._drives_alone is not None:
            return self._drives_alone
        coordinates, rows = self.mechanism.coordinates, self._rows
        columns, rates = (
            coordinates.columns_of(self.coordinates),
            coordinates.rates_of(self.coordinates),
        )
        x = rows.x[:, columns] + 2.0 * np.pi * rows.turns[:, columns]
        return OfDrives(x, rows.v[:, rates], rows.a[:, rates])

    @property
    def position(self) -> Array:
        """Positions of `coordinates` `(N,)` [rad or m], `(N, d)` if they are several."""
        return _squeezed(self._of_drives.x)

    @property
    def speed(self) -> Array:
        """Speeds of `coordinates` [rad/s or m/s], like `position`.

        NaN where a middle angle of a ball or floating base is at ±90° and the body turns so that
        the outer angles have no speed there.
        """
        exist = self._rows.exist if self._drives_alone is None else None
        if exist is None:
            return _squeezed(self._of_drives.v)
        rates = self.mechanism.coordinates.rates_of(self.coordinates)
        return _squeezed(np.where(exist[:, rates], self._of_drives.v, np.nan))

    @property
    def acceleration(self) -> Array:
        """Drive accelerations [rad/s² or m/s²], like `position`; proven, as wrenches are."""
        return self.sweep.acceleration

    @property
    def sweep(self) -> Sweep:
        """The motion as a sweep of the scene: wrenches, efforts and residuals at the times `t`.

        What is not known at singular configurations is NaN there, see `singular`.

        Raises:
            SingularConfigurationError: the drives do not decide the motion at any of the times.
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
        if self._solved[0] is not None:
            return self._solved[0].motion
        nothing = np.full((len(self), len(self.mechanism.coordinates.rate_scale), 1), np.nan)
        ratios = VelocityRatios.of(np.repeat(nothing, len(self.coordinates), axis=2))
        rows = self._rows
        a = np.full_like(rows.a, np.nan)
        return Motion(self.mechanism, self.coordinates, rows.x, rows.turns, rows.v, a, ratios)

    @property
    def singular(self) -> Array:
        """Whether the configuration is so close to singular that forces are not known `(N,)`.

        Wrenches, efforts, accelerations and velocity ratios are NaN at these times, the condition
        is infinite; positions, drive speeds and energies hold, other speeds lose digits.
        """
        return self._solved[1]

    @cached_property
    def _solved(self) -> tuple[Sweep | None, Array, CardanError]:
        """Return `sweep`, `singular`, and the last error; no sweep if all times are singular."""
        singular, error = np.zeros(len(self), dtype=bool), CardanError("no time is given")
        while True:
            known = np.nonzero(~singular)[0]
            if not known.size:
                return None, read_only(singular), error
            part = self if len(known) == len(self) else self._part(known)
            try:
                sweep = part._unproven
            except (SingularConfigurationError, AssemblyError) as found:
                # Closed as they are, but not decided by the drives.
                if found.sample is None or not part._is_closed(found.sample):
                    raise
                singular[known[found.sample]], error = True, found
                if isinstance(found, AssemblyError):
                    error = SingularConfigurationError(
                        f"at time {part.time[found.sample]:.6g} s the configuration is singular: "
                        "the drives do not decide the motion of all joints, so that wrenches "
                        "and accelerations are not known; leave such times out with at()",
                        sample=int(known[found.sample]),
                    )
                continue
            errors = part._effort_errors(sweep)
            lost = errors > _GREATEST_ERROR
            if not np.any(lost):
                break
            error = part._wrong_accelerations(sweep, errors)
            is_near = lost & ((sweep.condition > _NEARLY_SINGULAR) | part._locked)
            if np.any(lost & ~is_near) or sweep.idle_rods:
                raise error
            singular[known[is_near]] = True
        if np.any(singular):
            scattered = Scattered(known, self._run_motion(sweep, known), self._acting())
            sweep = scattered.sweep(sweep, self._of_drives.x)
        return sweep, read_only(singular), error

    @property
    def _locked(self) -> Array:
        """Whether outer axes of a free ball nearly coincide `(N,)`: angles have no rates."""
        locked, bodies = np.zeros(len(self), dtype=bool), self._rows.bodies
        for ball in bodies.mechanism.balls if bodies else ():
            locked |= np.array([ball.apart(x) for x in self._rows.x]) * _NEARLY_SINGULAR < 1.0
        return locked

    def _is_closed(self, index: int) -> bool:
        """Return whether loops are closed in a state."""
        state = self._solver.assembly.kinematics.evaluate(self._rows.x[[index]])
        return bool(state.residual[0] < CLOSURE_TOLERANCE)

    def _part(self, chosen: Array) -> Trajectory:
        """Return the same at some of its times."""
        part = self.at(self.time[chosen])
        drives = self._drives_alone
        if drives is not None:
            drives = OfDrives(*(values[chosen] for values in drives))
        known = {"_rows": self._rows.at(chosen), "_drives_alone": drives}
        part.__dict__.update(known)
        if "_misfit" in self.__dict__:
            part.__dict__["_misfit"] = self.__dict__["_misfit"]
        return part

    @cached_property
    def _unproven(self) -> Sweep:
        """The motion as a sweep at all times, whatever its residuals are.

        Raises:
            CardanError: as `Scene.sweep`.
        """
        positions = self._of_drives.x
        assembled = self._run.assembled(positions, self._rows)
        acting = self._acting()
        with np.errstate(over="ignore", invalid="ignore"):
            solution = self._solver.solve(assembled, acting)
        return sweep_of(self._solver, assembled, acting, solution)

    def _wrong_accelerations(self, sweep: Sweep, errors: Array) -> AccuracyError:
        """Return the error that refuses wrong accelerations.

        Args:
            sweep: at the times.
            errors: `(N,)`, see `effort_residual`.
        """
        worst = int(np.argmax(errors))
        if sweep.idle_rods:
            rods = "; ".join(" and ".join(rod) for rod in sweep.idle_rods)
            return AccuracyError(
                f"the rod between {rods} spins about its line and is not symmetric about it, "
                "so that its spin moves the drives; sweeps know nothing of spins: decide it by "
                "a universal joint instead of one of the balls",
                residual=float(errors[worst]),
            )
        return AccuracyError(
            f"at time {self.time[worst]:.6g} s the mechanism is so close to a singular "
            f"configuration (condition {sweep.condition[worst]:.1e}) that accelerations and "
            f"wrenches are wrong by {errors[worst]:.1e}; leave such times out with at()",
            time=float(self.time[worst]),
            residual=float(errors[worst]),
        )

    def _run_motion(self, sweep: Sweep, known: Array) -> Motion:
        """Return the motion at all times, of which some are solved.

        Args:
            sweep: at those.
            known: their indices.
        """
        motion, rows = sweep.motion, self._rows
        a, x, v = np.full_like(rows.a, np.nan), rows.x.copy(), rows.v.copy()
        turns = rows.turns.copy()
        x[known], turns[known] = motion._x, motion._turns
        v[known], a[known] = motion.v, motion.a
        ratios = motion._velocity_ratios
        values = np.full((len(self), ratios.values.shape[1]), np.nan)
        values[known] = ratios.values
        return Motion(
            self.mechanism, self.coordinates, x, turns, v, a, ratios._replace(values=values)
        )

    def _acting(self) -> Acting:
        """Return rates of the drives and what acts at the times."""
        problem = self._problem
        joints, links = self._forces.sampled(self.time, *self._counted())
        efforts = {name: np.asarray(effort) for name, effort in joints.items()}
        return acting_on(problem)._replace(
            speeds=self._of_drives.v,
            accelerations=self._of_drives.a,
            joint_loads=frozen(efforts),
            link_loads=frozen(links),
            time=self.time,
        )

    def _counted(self) -> tuple[Array, Array]:
        """Return coordinates with all turns, and velocities."""
        return self._rows.x + 2.0 * np.pi * self._rows.turns, self._rows.v

    @property
    def effort_residual(self) -> float:
        """Greatest effort of a free coordinate, as part of the greatest of inertia and loads.

        The equations of motion ask for none: it is what is wrong with the accelerations. Forces
        count as moments by the characteristic length.
        """
        return float(np.nanmax(self._effort_errors(self.sweep)))

    def _effort_errors(self, sweep: Sweep) -> Array:
        """Return `(N,)` the effort of the free coordinates, see `effort_residual`."""
        coordinates, drives = self.mechanism.coordinates, self.coordinates
        is_free = np.array([name not in self._course.prescribed for name in drives])
        scale = coordinates.rate_scale[coordinates.rates_of(drives)]
        efforts = np.abs(sweep.drive_effort.reshape(len(self), -1)) * scale
        return np.asarray(np.max(efforts[:, is_free], axis=1) / (self._effort_scale or 1.0))

    @cached_property
    def _effort_scale(self) -> float:
        """Greatest effort of all joints if no loop were closed, in which no singularity is felt.

        A moment that takes all kinetic energy within a radian counts as well.
        """
        mechanism = self.mechanism
        # Rates of angles that are near gimbal lock are great, whatever the body does.
        bodies = self._rows.bodies
        states = (bodies.x, bodies.v) if bodies else self._counted()
        moved = (bodies or self._rows).a
        of = bodies.mechanism if bodies else mechanism
        open_tree = open_efforts(of, self._problem.gravity, *states, moved)
        loads = self._forces.all_efforts(mechanism, self.time, *self._counted())
        efforts = np.maximum(open_tree, np.abs(loads)) * mechanism.coordinates.rate_scale
        return float(max(np.max(efforts, initial=0.0), np.max(self.kinetic_energy)))

    @cached_property
    def kinetic_energy(self) -> Array:
        """Kinetic energy of all bodies `(N,)` [J]."""
        bodies = self._rows.bodies
        if bodies is not None:
            energy = WeightEnergy(bodies.mechanism, self._problem.gravity)
            return read_only(energy.kinetic(bodies.x, bodies.v))
        return read_only(self._energy.kinetic(self._rows.x, self._rows.v))

    @cached_property
    def potential_energy(self) -> Array:
        """Potential energy of the weight and of springs `(N,)` [J]."""
        energy = self._energy.potential(self._rows.x)
        elements = self._problem.element_forces
        if elements is not None:
            energy = energy + elements.at(*self._counted(), self.time).potential_energy
        return read_only(energy)

    @property
    def _energy(self) -> WeightEnergy:
        return WeightEnergy(self.mechanism, self._problem.gravity)

    @cached_property
    def work(self) -> Array:
        """Work `(N,)` that all but weight and springs has done since time 0 [J].

        That is loads, actuators and prescribed drives, less what dampers and friction took.
        """
        steps, times, period = self._run.times, self.time, self._run.period
        if steps[-1] > period:
            # No work is left of a whole period, and one is resolved however many there are.
            steps, times = np.linspace(0.0, period, _STEPS_PER_PERIOD + 1), times % period
        return read_only(gained(self._power, steps, times, self._is_idle))

    @property
    def _is_idle(self) -> bool:
        """Whether nothing does work but weight and springs."""
        return self._forces.does_no_work and not self._course.prescribed

    def _power(self, times: Array) -> Array:
        """Return the power of loads and prescribed drives at times `(K,)` [W]."""
        there = self.at(times)
        if self._course.prescribed and np.any(there.singular):
            raise AccuracyError(
                "the work of prescribed drives is not known where they are singular"
            )
        x, v = there._counted()
        loads = self._forces.loads_alone().all_efforts(self.mechanism, times, x, v)
        power = np.einsum("nk,nk->n", loads, v)
        elements = self._problem.element_forces
        if elements is not None:
            power = power + element_power(elements, x, v, times)
        if self._course.prescribed:
            # What is wrong with an effort shows in the balance of energy, which takes it.
            efforts = there._unproven.drive_effort.reshape(len(times), -1)
            chosen = [self.coordinates.index(name) for name in self._course.prescribed]
            power += np.sum(efforts[:, chosen] * there._of_drives.v[:, chosen], axis=1)
        return np.asarray(power)

    @cached_property
    def energy_residual(self) -> float:
        """Greatest change of energy less work, as a fraction of `energy_scale`."""
        start = self.at([0.0])
        energy = self.kinetic_energy + self.potential_energy
        begun = start.kinetic_energy[0] + start.potential_energy[0]
        change = float(np.max(np.abs(energy - begun - self.work)))
        return change / self.energy_scale if change else 0.0

    @property
    def energy_scale(self) -> float:
        """Energy that can change [J].

        That is the greatest of what the motion had: kinetic energy, change of potential energy,
        work; but not less than what springs and loads would do where it passed over one radian, or
        the characteristic length, in which tolerances of positions are counted, and the weight of
        all bodies over that length. So motion that hardly moves is not measured by what rounding
        leaves of it.
        """
        start = self.at([0.0])
        return max(
            float(np.max(self.kinetic_energy)),
            float(np.max(np.abs(self.potential_energy - start.potential_energy[0]))),
            float(np.max(np.abs(self.work))),
            self._greatest_reach,
        )

    @property
    def _greatest_reach(self) -> float:
        """What weight, springs and loads would do [J], see `energy_residual`.

        Walls of contacts are left out, whose forces act over a small part of a radian.
        """
        mechanism, forces = self.mechanism, self._forces.without_contacts()
        weight = self._energy.weight * mechanism.characteristic_length
        if forces.is_nothing:
            return weight
        x, rest = self._counted()[0], np.zeros_like(self._rows.v)
        efforts = np.abs(forces.all_efforts(mechanism, self.time, x, rest))
        greatest = np.max(efforts * mechanism.coordinates.rate_scale, initial=0.0)
        return max(weight, float(greatest))


def _squeezed(values: Array) -> Array:
    """Return values `(N, d)` of the drives, `(N,)` of one."""
    return read_only(values[:, 0] if values.shape[1] == 1 else values)
