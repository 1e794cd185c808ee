"""Task simulation: free coordinates move by themselves while a task moves as given.

The follower is simulated, driven by what follows the tasks, while forces balance along motions in
which the actuated joints rest: these carry what the tasks ask for. The trajectory is the machine's,
whose efforts, found from its own laws of motion, prove it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..core.dynamics.problem_solver import ProblemSolver
from ..core.elements.pin_contact import PinContact
from ..core.mechanism.mechanism import Mechanism
from ..core.problem.arguments import split_loads
from ..kit.arrays import Array
from ..kit.checks import positive
from ..kit.errors import (
    ArgumentError,
    AssemblyError,
    MobilityError,
    SimulationError,
    SingularConfigurationError,
    choices,
)
from ..kit.frozen import frozen, read_only
from ..motion.simulation.prescribed_motion import begun_at, prescribed_motions
from ..motion.simulation.runs import Rows, Run
from ..motion.simulation.setup import forces_of, with_all_loops
from ..motion.simulation.simulate import simulated
from ..motion.simulation.trajectory import Course, Trajectory
from .task_motion import TaskMotion
from .tasks import Task, missed

_Motion = Callable[[float], tuple[float, float, float]]


def simulate_task(
    moved: TaskMotion, loads_of_scene: Mapping[str, object], motion: Any, **asked: Any
) -> TaskTrajectory:
    """Return the simulation of a scene with a task, see `TaskScene.simulate`.

    Args:
        moved: how tasks are followed.
        loads_of_scene: what acts, by names.
        motion: rows of the tasks to how they move.
        asked: other arguments of `Scene.simulate`.
    """
    problem = moved.machine.problem
    rows = moved.rows[: len(moved.rows) - len(problem.free)]
    if not problem.free:
        raise MobilityError(
            "nothing is free beside the task, and what is given in time needs no simulation: "
            "scene.sweep(position, speed, acceleration, time=t); name coordinates that move by "
            "themselves: free=[...]",
            mobility=0,
        )
    if any(isinstance(element, PinContact) for element in problem.elements):
        raise ArgumentError(
            "pins with clearance are not simulated while a task moves as given: drive the "
            "actuated joints instead, scene.machine.simulate"
        )
    motions, _ = prescribed_motions(
        rows, problem.free, motion, positive("duration", asked["duration"])
    )
    starts: dict[str, float] = {}
    for block, _ in moved.spans():
        if block.turned is not None:
            raise ArgumentError(
                f"the rotation of a pose is not simulated ({choices(block.rows)}): give its link "
                "by a PointTask and a DirectionTask, or the motion of all coordinates to sweep"
            )
        starts |= dict(zip(block.rows, block.start.tolist(), strict=True))
    given = begun_at(motions, starts)
    follower = moved.follower
    loads = split_loads(follower.problem.mechanism, loads_of_scene)
    of_follower = replace(
        follower.problem,
        free=problem.free,
        gravity=problem.gravity,
        elements=problem.elements,
        joint_loads=frozen(loads[0]),
        link_loads=frozen(loads[1]),
    )
    machine = with_all_loops(moved.machine)
    forces = forces_of(machine, asked.get("loads"))

    def of_machine(found: Trajectory) -> TaskTrajectory:
        course = found._course
        run = _OfMachine(course.run, *_common(machine, follower))
        x, v = course.start
        return TaskTrajectory(
            TaskCourse(
                **{
                    **course.__getstate__(),
                    "setup": replace(
                        course.setup,
                        solver=machine,
                        forces=forces,
                        motions=dict.fromkeys(moved.actuated),
                    ),
                    "run": run,
                    "start": (x[run.columns], v[run.rates]),
                },
                tasks=moved.tasks,
                motions=given,
            ),
            found.time,
        )

    # What follows a task counts from where the scene starts.
    shifted = {name: _Shifted(item, starts[name]) for name, item in given.items()}
    try:
        found = simulated(
            ProblemSolver(of_follower, follower),
            motion=shifted,
            carried=moved.actuated,
            **asked,
        )
    except SimulationError as error:
        raise SimulationError(
            f"{error}; rows of the task are {_rows_at(given, error.time)} there: it may be at the "
            "end of its reach, or actuated joints may lose hold of it",
            trajectory=of_machine(error.trajectory),
            time=error.time,
        ) from error
    except (AssemblyError, SingularConfigurationError) as error:
        raise type(error)(
            f"rows of the task are {_rows_at(given, 0.0)} at time 0, which the mechanism does not "
            f"reach from where the scene starts: {error}",
            **{**error.details, "finding": "", "hint": ""},
        ) from error
    return of_machine(found)


def _rows_at(motions: Mapping[str, _Motion], time: float) -> str:
    return ", ".join(f"{name} = {item(time)[0]:.6g}" for name, item in motions.items())


@dataclass(frozen=True)
class _Shifted:
    """How a row of a task moves from where the scene starts."""

    motion: _Motion
    start: float

    def __call__(self, time: float) -> tuple[float, float, float]:
        position, speed, acceleration = self.motion(time)
        return position - self.start, speed, acceleration


def _common(machine: ProblemSolver, follower: ProblemSolver) -> tuple[Array, Array]:
    """Return where coordinates and velocities of a machine are among those of its follower."""
    own, other = (
        solver.problem.mechanism.coordinates for solver in (machine, follower)
    )
    columns, rates = np.zeros((2, own.size), dtype=int)
    rates = np.zeros(len(own.rate_scale), dtype=int)
    for name, span in own.columns.items():
        columns[span] = np.r_[other.columns[name]]
    for name, span in own.velocity_columns.items():
        rates[span] = np.r_[other.velocity_columns[name]]
    return columns, rates


class _OfMachine:
    """A run of a follower, as one of its machine; see `Run`."""

    def __init__(self, run: Run, columns: Array, rates: Array) -> None:
        self._run, self.columns, self.rates = run, columns, rates
        self.times, self.period, self.is_exact = run.times, run.period, run.is_exact

    @property
    def boundless(self) -> frozenset[int]:
        """See `Run.boundless`."""
        own = {int(rate): index for index, rate in enumerate(self.rates)}
        return frozenset(own[rate] for rate in self._run.boundless if rate in own)

    def late(self, times: Array) -> Array:
        """See `Run.late`."""
        return self._run.late(times)

    def drives_alone(self, times: Array) -> None:
        """See `Run.drives_alone`."""

    def rows(self, times: Array, drives: Any = None) -> Rows:
        """See `Run.rows`."""
        rows = self._run.rows(times)
        exist = None if rows.exist is None else rows.exist[:, self.rates]
        x, turns = rows.x[:, self.columns], rows.turns[:, self.columns]
        return Rows(x, turns, rows.v[:, self.rates], rows.a[:, self.rates], exist)


@dataclass(frozen=True, eq=False, kw_only=True)
class TaskCourse(Course):
    """How a simulation of a task went, see `Course`.

    Attributes:
        tasks: the tasks.
        motions: their rows to how they move.
    """

    tasks: tuple[Task, ...]
    motions: Mapping[str, _Motion]


class TaskTrajectory(Trajectory):
    """Motion, energies and joint wrenches of a simulation in which a task moves as given.

    It is a `Trajectory` of the machine: what its actuated joints exert so that the task moves as
    given is `actuated_effort`, and the task itself carries nothing.
    """

    _course: TaskCourse

    @property
    def rows(self) -> tuple[str, ...]:
        """Names of the rows of the task."""
        return tuple(self._course.motions)

    @cached_property
    def _given(self) -> Array:
        motions = self._course.motions.values()
        return np.array([[item(time) for item in motions] for time in self.time.tolist()])

    @property
    def task_position(self) -> Array:
        """Positions of the rows `(N, k)` [rad or m]; `(N,)` of a single one."""
        return _squeezed(self._given[..., 0])

    @property
    def task_speed(self) -> Array:
        """Their speeds [rad/s or m/s], like `task_position`."""
        return _squeezed(self._given[..., 1])

    @property
    def task_acceleration(self) -> Array:
        """Their accelerations [rad/s² or m/s²], likewise."""
        return _squeezed(self._given[..., 2])

    @cached_property
    def task_residual(self) -> float:
        """Greatest error of the rows, see `TaskSweep.task_residual`."""
        return missed(self._course.tasks, self._given[..., 0], self)

    @cached_property
    def actuated_effort(self) -> Mapping[str, Array]:
        """Actuated joint to its effort `(N,)` [N·m or N]; raises what `sweep` raises."""
        efforts = self.drive_effort.reshape(len(self), -1)
        return frozen(
            {name: read_only(efforts[:, self.coordinates.index(name)]) for name in self._prescribed}
        )


def _squeezed(values: Array) -> Array:
    return read_only(values[:, 0] if values.shape[1] == 1 else values)
