"""Trajectory: what a simulation returns, with its wrenches where and when they are asked for."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..arrays import Array
from ..checks import numbers
from ..dynamics.problem_solver import ProblemSolver
from ..errors import AccuracyError, ArgumentError
from ..frozen import frozen, read_only
from ..problem.samples import Acting, acting_on
from ..results.collect import sweep_of
from ..results.sweep import Sweep
from .contact_following import Touch
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
        touches: of pins with play, in the order in which they ended.
    """

    method: str
    reason: str
    events: tuple[Happened, ...]
    notes: tuple[str, ...]
    prescribed: tuple[str, ...]
    evaluations: int
    touches: tuple[Touch, ...] = ()


class Trajectory(Tabled):
    """Motion, energies and joint wrenches of a simulation over N times.

    `trajectory["bearing_out"]` is a `JointWrench` as that of a sweep; `at` gives the same
    simulation at any other times. Wrenches are computed when they are first read, by inverse
    dynamics with the accelerations that the simulation found: so `effort_residual`, what free
    drives would have to exert for this motion, proves it. Nothing in it can be changed.

    Attributes:
        t: times `(N,)` [s]: the steps of the method, or those that `at` was given.
        method: how it was solved.
        reason: why it ended before its time; empty if it did not.
        events: `(name, time)` of the events that happened.
        notes: what one should know of it, such as that the equations are stiff or ring.
        evaluations: how often accelerations were computed.
        touches: of pins with play and the walls of their bushes, in the order in which they ended.
    """

    def __init__(
        self, solver: ProblemSolver, run: Run, forces: Forces, course: Course, t: Array
    ) -> None:
        self._solver, self._run, self._forces, self._course = solver, run, forces, course
        self._problem = solver.problem
        self.t = read_only(t)
        self.method, self.reason = course.method, course.reason
        self.events, self.notes = course.events, course.notes
        self.evaluations, self.touches = course.evaluations, course.touches
        self._freeze()

    def __len__(self) -> int:
        return len(self.t)

    def __reduce__(self) -> tuple[object, ...]:
        made_of = self._solver, self._run, self._forces, self._course, self.t
        return Trajectory, made_of

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the times, `(N,)`."""
        return self.t.shape

    def __repr__(self) -> str:
        ended = f", ended by: {self.reason}" if self.reason else ""
        return (
            f"<Trajectory of {self.mechanism.name!r}: {len(self)} times from {self.t[0]:g} to "
            f"{self.t[-1]:g} s by {self.method}{ended}>"
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
        return Trajectory(self._solver, self._run, self._forces, self._course, t)

    def evenly(self, count: int) -> Trajectory:
        """Return the same simulation at equidistant times, as an animation shows it."""
        return self.at(np.linspace(0.0, float(self._run.times[-1]), count))

    @cached_property
    def _rows(self) -> Rows:
        return self._run.rows(self.t, self._drives_alone)

    @cached_property
    def _drives_alone(self) -> OfDrives | None:
        return self._run.drives_alone(self.t)

    @cached_property
    def _of_drives(self) -> OfDrives:
        if self._drives_alone is not None:
            return self._drives_alone
        coordinates, rows = self.mechanism.coordinates, self._rows
        columns, rates = coordinates.columns_of(self.drives), coordinates.rates_of(self.drives)
        x = rows.x[:, columns] + 2.0 * np.pi * rows.turns[:, columns]
        return OfDrives(x, rows.v[:, rates], rows.a[:, rates])

    @property
    def position(self) -> Array:
        """Drive positions `(N,)` [rad or m], `(N, d)` for d drives."""
        return _squeezed(self._of_drives.x)

    @property
    def speed(self) -> Array:
        """Drive speeds [rad/s or m/s], like `position`.

        NaN where a middle angle of a ball or floating base is at ±90° and the body turns so that
        the outer angles have no speed there.
        """
        exist = self._rows.exist if self._drives_alone is None else None
        if exist is None:
            return _squeezed(self._of_drives.v)
        rates = self.mechanism.coordinates.rates_of(self.drives)
        return _squeezed(np.where(exist[:, rates], self._of_drives.v, np.nan))

    @property
    def acceleration(self) -> Array:
        """Drive accelerations [rad/s² or m/s²], like `position`; proven, as wrenches are."""
        return self.sweep.acceleration

    @cached_property
    def _unproven(self) -> Sweep:
        """The motion as a sweep, whatever its residuals are.

        Raises:
            CardanError: as `Scene.sweep`.
        """
        positions = self._of_drives.x
        assembled = self._run.assembled(positions, self._rows)
        acting = self._acting()
        with np.errstate(over="ignore", invalid="ignore"):
            solution = self._solver.solve(assembled, acting)
        return sweep_of(self._solver, assembled, acting, solution)

    @cached_property
    def sweep(self) -> Sweep:
        """The motion as a sweep of the scene: wrenches, efforts and residuals at the times `t`.

        Raises:
            SingularConfigurationError: the drives do not decide the motion at a time.
            CardanError: as `Scene.sweep`.
        """
        sweep = self._unproven
        errors = self._effort_errors(sweep)
        if np.max(errors) > _GREATEST_ERROR:
            worst = int(np.argmax(errors))
            if sweep.idle_rods:
                rods = "; ".join(" and ".join(rod) for rod in sweep.idle_rods)
                raise AccuracyError(
                    f"the rod between {rods} spins about its line and is not symmetric about it, "
                    "so that its spin moves the drives; sweeps know nothing of spins: decide it by "
                    "a universal joint instead of one of the balls",
                    residual=float(errors[worst]),
                )
            raise AccuracyError(
                f"at time {self.t[worst]:.6g} s the mechanism is so close to a singular "
                f"configuration (condition {sweep.condition[worst]:.1e}) that accelerations and "
                f"wrenches are wrong by {errors[worst]:.1e}; leave such times out with at()",
                time=float(self.t[worst]),
                residual=float(errors[worst]),
            )
        return sweep

    def _acting(self) -> Acting:
        """Return rates of the drives and what acts at the times."""
        problem = self._problem
        joints, links = self._forces.sampled(self.t, *self._counted())
        efforts = {name: np.asarray(effort) for name, effort in joints.items()}
        return acting_on(problem)._replace(
            speeds=self._of_drives.v,
            accelerations=self._of_drives.a,
            joint_loads=frozen(efforts),
            link_loads=frozen(links),
            time=self.t,
        )

    def _counted(self) -> tuple[Array, Array]:
        """Return coordinates with all turns, and velocities."""
        return self._rows.x + 2.0 * np.pi * self._rows.turns, self._rows.v

    @property
    def effort_residual(self) -> float:
        """Greatest effort of a free drive, relative to the greatest that inertia and loads need.

        The equations of motion ask for none: it is what is wrong with the accelerations. Forces
        count as moments by the characteristic length.
        """
        return float(np.max(self._effort_errors(self.sweep)))

    def _effort_errors(self, sweep: Sweep) -> Array:
        """Return `(N,)` the effort of the free drives, see `effort_residual`."""
        coordinates, drives = self.mechanism.coordinates, self.drives
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
        loads = self._forces.all_efforts(mechanism, self.t, *self._counted())
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
            energy = energy + elements.at(*self._counted(), self.t).potential_energy
        return read_only(energy)

    @property
    def _energy(self) -> WeightEnergy:
        return WeightEnergy(self.mechanism, self._problem.gravity)

    @cached_property
    def work(self) -> Array:
        """Work `(N,)` that all but weight and springs has done since time 0 [J].

        That is loads, actuators and prescribed drives, less what dampers and friction took.
        """
        steps, times, period = self._run.times, self.t, self._run.period
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
        x, v = there._counted()
        loads = self._forces.loads_alone().all_efforts(self.mechanism, times, x, v)
        power = np.einsum("nk,nk->n", loads, v)
        elements = self._problem.element_forces
        if elements is not None:
            power = power + element_power(elements, self.mechanism, x, v, times)
        if self._course.prescribed:
            # What is wrong with an effort shows in the balance of energy, which takes it.
            efforts = there._unproven.drive_effort.reshape(len(times), -1)
            chosen = [self.drives.index(name) for name in self._course.prescribed]
            power += np.sum(efforts[:, chosen] * there._of_drives.v[:, chosen], axis=1)
        return np.asarray(power)

    @cached_property
    def energy_residual(self) -> float:
        """Greatest change of energy less work, as a fraction of the energy that can change.

        That is the greatest of what the motion had: kinetic energy, change of potential energy,
        work; but not less than what springs and loads would do where it passed over one radian, or
        the characteristic length, in which tolerances of positions are counted, and the weight of
        all bodies over that length. So motion that hardly moves is not measured by what rounding
        leaves of it.
        """
        start = self.at([0.0])
        energy = self.kinetic_energy + self.potential_energy
        begun = start.kinetic_energy[0] + start.potential_energy[0]
        change = energy - begun - self.work
        scale = max(
            float(np.max(self.kinetic_energy)),
            float(np.max(np.abs(self.potential_energy - start.potential_energy[0]))),
            float(np.max(np.abs(self.work))),
            self._greatest_reach,
        )
        return float(np.max(np.abs(change))) / scale if scale else 0.0

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
        efforts = np.abs(forces.all_efforts(mechanism, self.t, x, rest))
        greatest = np.max(efforts * mechanism.coordinates.rate_scale, initial=0.0)
        return max(weight, float(greatest))


def _squeezed(values: Array) -> Array:
    """Return values `(N, d)` of the drives, `(N,)` of one."""
    return read_only(values[:, 0] if values.shape[1] == 1 else values)
