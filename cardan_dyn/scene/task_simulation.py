"""Task simulation: free coordinates move by themselves while a task moves as given.

The follower is simulated, driven by what follows the tasks, while forces balance along motions in
which the actuated joints rest: these carry what the tasks ask for. The trajectory is the machine's,
whose efforts, found from its own laws of motion, prove it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..core.dynamics.problem_solver import ProblemSolver
from ..core.elements.pin_contact import PinContact
from ..core.problem.arguments import by_coordinate, split_loads
from ..core.problem.coordinate_names import check_single
from ..core.results.table import Table
from ..kit.arrays import Array, squeezed
from ..kit.checks import mapping, positive
from ..kit.errors import (
    ArgumentError,
    AssemblyError,
    MobilityError,
    SimulationError,
    SingularConfigurationError,
    choices,
)
from ..kit.frozen import frozen, read_only
from ..motion.simulation.continuity import States
from ..motion.simulation.prescribed_motion import begun_at, prescribed_motion
from ..motion.simulation.runs import Run
from ..motion.simulation.setup import forces_of, with_all_loops
from ..motion.simulation.simulate import simulated
from ..motion.simulation.system import Motion, Rows
from ..motion.simulation.trajectory import Trajectory
from .task_in_time import drive_motions, row_states
from .task_motion import TaskMotion
from .task_sweep import with_task
from .tasks import Block, missed, points_led

if TYPE_CHECKING:
    from ..core.results.point_motion import Points


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
    motions = _motions(rows, motion, positive("duration", asked["duration"]))
    for label in {"position", "speed"} & asked.keys():
        if isinstance(asked[label], Mapping):
            for name in by_coordinate(problem.mechanism, label, asked[label]):
                check_single(problem.mechanism, name, f"a key of {label},")
    follower, blocks = moved.follower, [block for block, _ in moved.spans()][: -len(problem.free)]
    coordinates = follower.problem.mechanism.coordinates
    starts: dict[str, float] = {}
    for block in blocks:
        begun = follower.assembly.start[coordinates.columns_of(block.drives)]
        starts |= dict(zip(block.rows, block.rows_at(begun).tolist(), strict=True))
    given = begun_at(motions, starts)
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
        run = _OfMachine(course.run, moved, blocks)
        x, v = course.start
        setup = replace(course.setup, solver=machine, forces=forces, carried=moved.actuated)
        start = x[run.columns], v[run.rates]
        return TaskTrajectory(replace(course, setup=setup, run=run, start=start), found.time)

    driven: dict[str, Motion] = {}
    resting: list[str] = []
    for block in blocks:
        driven |= drive_motions(block, given)
        # Of six turns of a pose three are needed.
        resting += block.drives[3:6] if block.turned is not None else ()
    try:
        found = simulated(
            ProblemSolver(of_follower, follower),
            motion=driven,
            carried=(*moved.actuated, *resting),
            known=problem.mechanism.coordinates.named,
            **asked,
        )
    except SimulationError as error:
        ended: Any = error.trajectory
        raise SimulationError(
            f"{error}; the task is at {_rows_at(given, error.time)}",
            trajectory=of_machine(ended),
            time=error.time,
        ) from error
    except (AssemblyError, SingularConfigurationError) as error:
        if error.position is None:
            raise SingularConfigurationError(
                f"the task cannot begin where it is, {_rows_at(given, 0.0)}: {error}"
            ) from error
        begun = np.array([item(0.0)[0] for item in given.values()])
        raise moved.told(error, begun, ", where it begins") from error
    return of_machine(found)


def _motions(rows: tuple[str, ...], given: Any, duration: float) -> dict[str, Motion]:
    """Return how rows of a task move, see `Scene.simulate`."""
    given = mapping("motion", given)
    for name in given:
        if name not in rows:
            raise ArgumentError(
                f"motion[{name!r}]: it is no row of the task; rows: {choices(rows, name)}"
            )
    if missing := [name for name in rows if name not in given]:
        verb = "moves" if len(missing) == 1 else "move"
        raise ArgumentError(
            f"motion: nothing says how {choices(missing)} of the task {verb}; give "
            f"motion={{{missing[0]!r}: ...}}"
        )
    return {name: prescribed_motion(name, given[name], duration) for name in rows}


def _rows_at(motions: Mapping[str, Motion], time: float) -> str:
    return ", ".join(f"{name} = {item(time)[0]:.6g}" for name, item in motions.items())


class _OfMachine(Run):
    """A run of what follows tasks, as one of the machine.

    Attributes:
        columns, rates: where the machine's coordinates and velocities are among the follower's.
        tasks: the tasks.
        names: of their rows.
    """

    def __init__(self, run: Run, moved: TaskMotion, blocks: list[Block]) -> None:
        """Take a run.

        Args:
            run: of the follower.
            moved: how the tasks are followed.
            blocks: of the tasks.
        """
        self._run, self.tasks = run, moved.tasks
        self.names = tuple(name for block in blocks for name in block.rows)
        self.times, self.period, self.is_exact = run.times, run.period, run.is_exact
        own, other = (
            solver.problem.mechanism.coordinates for solver in (moved.machine, moved.follower)
        )
        self.columns = np.zeros(own.size, dtype=int)
        self.rates = np.zeros(own.rate_scale.size, dtype=int)
        for name, span in own.columns.items():
            self.columns[span] = np.r_[other.columns[name]]
        for name, span in own.velocity_columns.items():
            self.rates[span] = np.r_[other.velocity_columns[name]]
        self.boundless = frozenset(np.flatnonzero(np.isin(self.rates, [*run.boundless])).tolist())
        self._blocks = [
            (block, other.columns_of(block.drives), other.rates_of(block.drives))
            for block in blocks
        ]

    def late(self, times: Array) -> Array:
        """See `Run.late`."""
        return self._run.late(times)

    def rows(self, times: Array, drives: States | None = None) -> Rows:
        """See `Run.rows`."""
        rows = self._run.rows(times)
        x, turns = rows.x[:, self.columns], rows.turns[:, self.columns]
        v, a, exist = (part[:, self.rates] for part in (rows.v, rows.a, rows.exist))
        read = rows.read and (rows.read[0][:, self.columns], rows.read[1][:, self.rates])
        return Rows(x, turns, v, a, exist, read=read)

    def given(self, times: Array) -> States:
        """Return how rows of the tasks move at times `(N,)`."""
        rows, found = self._run.rows(times), []
        for block, columns, rates in self._blocks:
            states = States(rows.counted[:, columns], rows.v[:, rates], rows.a[:, rates])
            found.append(row_states(block, states))
        return States(*(np.concatenate(parts, axis=-1) for parts in zip(*found, strict=True)))


class TaskTrajectory(Trajectory):
    """Motion, energies and joint wrenches of a simulation in which a task moves as given.

    It is a `Trajectory` of the machine: what its actuated joints exert so that the task moves as
    given is `actuated_effort`, and the task itself carries nothing.
    """

    _run: _OfMachine

    @property
    def rows(self) -> tuple[str, ...]:
        """Names of the rows of the task."""
        return self._run.names

    @cached_property
    def _given(self) -> States:
        return self._run.given(self.time)

    @property
    def task_position(self) -> Array:
        """Positions of the rows `(N, k)` [rad or m]; `(N,)` of a single one."""
        return read_only(squeezed(self._given.x))

    @property
    def task_speed(self) -> Array:
        """Their speeds [rad/s or m/s], like `task_position`; of a rotation its angular velocity."""
        return read_only(squeezed(self._given.v))

    @property
    def task_acceleration(self) -> Array:
        """Their accelerations [rad/s² or m/s²], likewise."""
        return read_only(squeezed(self._given.a))

    @cached_property
    def task_residual(self) -> float:
        """Greatest error of the rows, see `TaskSweep.task_residual`."""
        return missed(self._run.tasks, self._given.x, self)

    @property
    def led_points(self) -> dict[str, tuple[str, Array]]:
        """Points that the task leads, see `TaskSweep.led_points`."""
        return points_led(self._run.tasks)

    @cached_property
    def actuated_effort(self) -> Mapping[str, Array]:
        """Actuated joint to its effort `(N,)` [N·m or N]; reading it raises what `sweep` does."""
        efforts = self.drive_effort.reshape(len(self), -1)
        return frozen(
            {name: read_only(efforts[:, self.coordinates.index(name)]) for name in self._prescribed}
        )

    def table(self, *, motion: bool = True, points: Points = ()) -> Table:
        """Return all results as a table, with positions, speeds and accelerations of the task.

        Arguments as of `Trajectory.table`.
        """
        return with_task(super().table(motion=motion, points=points), self)
