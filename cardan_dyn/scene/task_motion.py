"""Task motion: how a machine moves as tasks say, by the efforts of its actuated joints.

Two problems are solved. The follower is driven by what follows the tasks: its loops decide how the
actuated joints move. The machine is driven by these, and begins where the follower has closed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cached_property, partial
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from ..core.dynamics.problem_solver import AssembledPositions, ProblemSolver
from ..core.kinematics.tolerances import REGULAR_CONDITION
from ..core.mechanism.mechanism import Mechanism
from ..core.problem.acting import Acting
from ..core.problem.arguments import checked
from ..core.problem.coordinate_names import each_coordinate
from ..core.problem.problem import Problem
from ..core.problem.samples import Targets, spanned, targets_of
from ..core.results.collect import sweep_of
from ..core.results.derivative import Swept
from ..core.results.motion import Motion
from ..kit.arrays import Array, consecutive, flat
from ..kit.checks import described, mapping, number, numbers
from ..kit.errors import (
    ArgumentError,
    AssemblyError,
    CardanError,
    MobilityError,
    SingularConfigurationError,
    as_position,
    as_text,
    choices,
)
from ..kit.frozen import Frozen, FrozenDict, frozen
from .assembling import configuration_of
from .task_sweep import Followed, Given, TaskSweep
from .tasks import KINDS, Block, Task, followers

if TYPE_CHECKING:
    from ..core.results.sweep import Sweep
    from ..core.transmission.workspace import Workspace

_FIRST = (
    "a singular configuration of the first kind, where the task ends the reach of the mechanism or "
    "its ways of working meet, and actuated joints would need infinite speed"
)
_SECOND = (
    "a singular configuration of the second kind, where the actuated joints do not hold the "
    "mechanism, whatever their efforts"
)


class TaskMotion(Frozen):
    """How a machine moves as tasks say. It does not change; threads may share it.

    Attributes:
        machine: solves the mechanism, driven by its actuated joints.
        tasks: the tasks.
        rows: names of their rows, in the order of positions, and of free coordinates, of which
            sweeps are given the positions as well.
        actuated: names of the joints that carry the effort.
        weights: by how much the square of each effort counts.
        follower: solves the mechanism with what follows the tasks, which drives it.
    """

    follower: ProblemSolver
    _blocks: list[Block]

    def __init__(
        self,
        machine: ProblemSolver,
        tasks: tuple[Task, ...],
        actuated: tuple[str, ...],
        weights: Mapping[str, float] | None = None,
        like: TaskMotion | None = None,
    ) -> None:
        """Find what follows the tasks.

        Args:
            machine: see the attribute.
            tasks: likewise.
            actuated: likewise.
            weights: those that are not as usual.
            like: motion of a scene that may differ in what does not move.

        Raises:
            MobilityError: there are too few rows, too many, or some depend on others.
            SingularConfigurationError: the scene starts where actuated joints cannot follow.
        """
        self.machine, self.tasks, self.actuated = machine, tasks, actuated
        self.weights = _weights(machine.problem.mechanism, actuated, weights)
        if like and like.tasks == tasks and like.machine.assembly is machine.assembly:
            self._blocks, self.follower = like._blocks, like.follower
        else:
            self._blocks, self.follower = _followed(machine, self.given)
        self.rows = tuple(name for block in self._blocks for name in block.rows)
        self._freeze()

    @property
    def given(self) -> tuple[Task, ...]:
        """All that sweeps are given: the tasks, and free coordinates."""
        return *self.tasks, *self.machine.problem.free

    @cached_property
    def _told_of(self) -> tuple[str, ...]:
        """Names of the coordinates that may drive the machine, whose rates are solved for."""
        return *self.actuated, *self.machine.problem.free

    def __reduce__(self) -> tuple[object, ...]:
        return TaskMotion, (self.machine, self.tasks, self.actuated, self.weights)

    def sweep(
        self,
        position: object,
        speed: object,
        acceleration: object,
        held: object,
        along_path: bool,
        acting: Callable[[Problem, object, object], Acting],
    ) -> TaskSweep:
        """Return the sweep of the machine where rows move as given.

        Args:
            position: of the rows `(..., m)`.
            speed: likewise.
            acceleration: likewise.
            held: held joints to other positions.
            along_path: see `Scene.sweep`.
            acting: returns what acts, with speeds and accelerations of the drives of a problem.

        Raises:
            CardanError: as `Scene.sweep`.
        """
        followed = self._follow(position, speed, acceleration, held, along_path)
        refused: SingularConfigurationError | None = None
        for machine in self._machines():
            try:
                return self._driven(machine, followed, acting)
            except SingularConfigurationError as error:
                refused = refused or error
        assert refused is not None
        raise refused

    def reachable(self, position: object, held: object) -> Array:
        """Return at which rows the mechanism can be, see `Scene.reachable`."""
        given, reached = self._values("position", position), np.array(False)
        for other in (False, True)[: 1 + self._has_pose]:
            columns = self._columns(given, False, other)
            targets = targets_of(self.follower.problem, columns, held)
            solver = self.follower.of_varied(targets.varied)
            reached = reached | solver.assembly.reachable(targets).reshape(targets.shape)
        return reached

    def workspace(self, *asked: Any) -> Workspace:
        """Return where two rows can be, see `TaskScene.workspace`."""
        from ..core.transmission.chart import Chart  # Few scripts ask for one.
        from ..core.transmission.workspace import Rows, workspace

        counted = [name for block in self._blocks for name in block.drives[: len(block.rows)]]
        chart = Chart(self.follower, self.machine.problem.independent, counted)
        start = self.follower.assembly.start[chart.columns]
        for block in self._blocks:
            if block.turned is not None and (
                turns := {*block.rows[3:]} & {*mapping("ranges", asked[0])}
            ):
                raise ArgumentError(
                    f"ranges: {choices(turns)} are of a rotation vector, along which no straight "
                    "line leads; give positions ranges, and rotations in at="
                )
        rows = Rows(self.rows, self._rows_at(start), lambda given: self._columns(given, False))
        return workspace(chart, rows, *asked)

    def range(self) -> tuple[float, float]:
        """Return between which positions the only row can move, see `Scene.motion_range`."""
        ((start,),) = (block.start for block in self._blocks)
        low, high = self.follower.assembly.motion_range()
        return low + float(start), high + float(start)

    def _machines(self) -> Iterator[ProblemSolver]:
        """Yield what solves the machine; where more joints are actuated, other drives as well."""
        yield self.machine
        problem = self.machine.problem
        if len(self.actuated) > len(problem.independent):
            problem = replace(problem, independent=self.actuated, listed=True)
            for machine in solvers(problem, self.machine):
                if machine.problem.independent != self.machine.problem.independent:
                    yield machine

    def _follow(
        self, position: object, speed: object, acceleration: object, held: object, along_path: bool
    ) -> Followed:
        """Return how the mechanism follows rows of the task; arguments as of `sweep`."""
        problem = self.follower.problem
        given = self._values("position", position)
        moving = self._values("speed", speed), self._values("acceleration", acceleration)
        acting = problem.acting
        if any(map(np.count_nonzero, moving)):
            every = [
                block.rates(*(values[..., own] for values in moving)) for block, own in self.spans()
            ]
            speeds, accelerations = map(_joined, zip(*every, strict=True))
            acting = acting._replace(speeds=speeds, accelerations=accelerations)
        columns = self._columns(given, along_path)
        targets = spanned(targets_of(problem, columns, held), acting, problem)
        self.machine.refuse_too_many(targets.size)
        solver = self.follower.of_varied(targets.varied)

        def moved(targets: Targets) -> tuple[AssembledPositions, Array, Array, Array]:
            assembled = solver.assembled_in_turn(targets, along_path)
            return assembled, *solver.moved(assembled, acting, self._rates)

        try:
            try:
                assembled, x, v, a = moved(targets)
            except (AssemblyError, SingularConfigurationError):
                if along_path or not self._has_pose:
                    raise
                # Other angles of the same poses are another way there.
                reached = solver.assembly.reachable(targets)[:, None]
                ways = columns, self._columns(given, False, other=True)
                near, others = (flat(way, targets.shape, trailing=1) for way in ways)
                columns = np.where(reached, near, others).reshape(*targets.shape, -1)
                targets = targets_of(problem, columns, held)
                assembled, x, v, a = moved(targets)
        except (AssemblyError, SingularConfigurationError) as error:
            if (sample := error.sample) is None:
                raise
            asked = flat(given, targets.shape, trailing=1)[sample]
            raise self.told(error, asked, f" (sample {sample} of {targets.size})") from None
        own = self._columns_of_machine
        turns, following = assembled.turns, (solver, assembled, x)
        swept = partial(_swept, *following, acting)
        of = Given(self.given, self.rows, given, *moving, partial(_condition, *following), swept)
        return Followed(of, x[:, own], turns[:, own], v, a, targets.shape, targets.held)

    def told(
        self, error: AssemblyError | SingularConfigurationError, asked: Array, where: str
    ) -> CardanError:
        """Return an error of the follower in terms of the first rows that were given somewhere."""
        count, mechanism = len(self.follower.problem.independent), self.machine.problem.mechanism
        which = f"{as_text(asked)}{where}"
        # What follows the tasks is no business of users.
        own = {"position": as_position(asked), "reach": None, "finding": "", "hint": ""}
        details = {**error.details, **own}
        rows = ", ".join(self.rows[: len(asked)])
        if isinstance(error, SingularConfigurationError):
            return SingularConfigurationError(
                f"the task, {rows}, cannot be followed to {which}: there or on the straight way "
                f"there is {_FIRST} (condition {error.condition:.1e})"
                f"{_moving(error, mechanism)}. Stay on one side of it, or begin beyond it with "
                "near=",
                **{**details, **_filtered(error, mechanism)},
            )
        nearest, reached = error.nearest, ""
        if nearest is not None and np.size(nearest) < count:
            details["nearest"] = None  # It is that of some of the drives.
        elif nearest is not None:
            nearest = self._rows_at(np.atleast_1d(nearest)[:count])
            reached = (
                f"; on the straight way there the nearest that was reached is {as_text(nearest)}"
            )
            details["nearest"] = as_position(nearest)
        return AssemblyError(
            f"the task, {rows}, is out of reach at {which}{reached}; change it, or begin with "
            "near= where the mechanism works in another way",
            **details,
        )

    def spans(self) -> Iterator[tuple[Block, slice]]:
        """Yield blocks, and which rows are theirs."""
        first = 0
        for block in self._blocks:
            yield block, slice(first, first + len(block.rows))
            first += len(block.rows)

    @property
    def _has_pose(self) -> bool:
        """Whether rows ask for rotations, to which several ways lead."""
        return any(block.turned is not None for block in self._blocks)

    def _columns(self, given: Array, along_path: bool, other: bool = False) -> Array:
        """Return positions of the follower's drives `(..., d)` of rows, see `Block.positions`."""
        return _joined(
            [block.positions(given[..., own], along_path, other) for block, own in self.spans()]
        )

    def _rows_at(self, columns: Array) -> Array:
        """Return rows `(m,)` at positions `(d,)` of the follower's drives."""
        counts = np.cumsum([len(block.drives) for block in self._blocks])
        parts = zip(self._blocks, np.split(columns, counts[:-1]), strict=True)
        return _joined([block.rows_at(part) for block, part in parts])

    def _values(self, name: str, value: object) -> Array:
        """Return positions, speeds or accelerations of rows as `(..., m)`."""
        array, count = numbers(name, value), len(self.rows)
        if not array.size:
            raise ArgumentError(f"{name} is empty")
        if not array.ndim:
            return array.repeat(count)
        if count == 1 and not (array.ndim > 1 and array.shape[-1] == 1):
            return array[..., None]
        if array.shape[-1] != count:
            raise ArgumentError(
                f"{name} has shape {array.shape}, expected a number or (..., {count}), a column "
                f"for each row of the task: {', '.join(self.rows)}"
            )
        return array

    @cached_property
    def _rates(self) -> Array:
        """Velocity coordinates of the follower that are those of `_told_of`."""
        return np.array(self.follower.problem.mechanism.coordinates.rates_of(self._told_of))

    @cached_property
    def _columns_of_machine(self) -> Array | slice:
        """Columns of the mechanism's coordinates among those of the follower's."""
        mechanism, other = self.machine.problem.mechanism, self.follower.problem.mechanism
        columns = np.empty(mechanism.coordinates.size, dtype=int)
        for name in mechanism.joints:
            own, span = mechanism.coordinates.columns[name], other.coordinates.columns[name]
            if own.stop - own.start != span.stop - span.start:
                raise ArgumentError(
                    f"joint {name!r} turns by several coordinates, and cannot be driven by them "
                    f"beside actuated joints: give its motion as task=cd.PoseTask(LINK)"
                )
            columns[own] = range(span.start, span.stop)
        return consecutive(columns)

    def _driven(
        self,
        machine: ProblemSolver,
        followed: Followed,
        acting_on: Callable[[Problem, object, object], Acting],
    ) -> TaskSweep:
        """Return the sweep of a machine whose actuated joints move as they have to.

        Raises:
            SingularConfigurationError: they do not decide where it is.
        """
        problem, coordinates = machine.problem, machine.problem.mechanism.coordinates
        drives = problem.independent
        columns = coordinates.columns_of(drives)
        rows = followed.x[:, columns] + 2.0 * np.pi * followed.turns[:, columns]
        moves = (
            rates[:, [*map(self._told_of.index, drives)]].reshape(*followed.shape, -1)
            if np.count_nonzero(rates)
            else 0.0
            for rates in (followed.v, followed.a)
        )
        acting = acting_on(problem, *moves)
        at = Targets(followed.shape, rows.reshape(*followed.shape, -1), followed.held)
        targets = spanned(at, acting, problem)
        solver = machine.of_varied(targets.varied)
        solver.refuse_too_many(targets.size)
        given = columns + coordinates.columns_of(targets.varied)

        def coordinates_near() -> tuple[Array, Array]:
            x, turns = (
                np.array(flat(every.reshape(*followed.shape, -1), targets.shape, trailing=1))
                for every in (followed.x, followed.turns)
            )
            x[:, given], turns[:, given] = targets.prescribed, 0.0
            return x, turns

        def solved(acting: Acting) -> Sweep:
            # They are closed already, so that Newton's method has nothing to do.
            try:
                near = solver.assembled_near(targets, *coordinates_near())
                return sweep_of(solver, near, acting)
            except (AssemblyError, SingularConfigurationError) as error:
                # What is closed can get lost only where the actuated joints do not hold it.
                if (sample := error.sample) is None:
                    raise
                x = coordinates_near()[0][sample : sample + 1]
                condition = float(solver.assembly.kinematics.evaluate(x).condition[0])
                if condition < REGULAR_CONDITION:
                    raise
                where = flat(followed.given.position, targets.shape, trailing=1)[sample]
                details = {**error.details, "position": as_position(where), "condition": condition}
                found = f": {error.finding}" * bool(error.finding)
                raise SingularConfigurationError(
                    f"the task is at {as_text(where)} (sample {sample}) in {_SECOND} (condition "
                    f"{condition:.1e}){found}; leave it out, or actuate other joints",
                    **details,
                ) from error

        return TaskSweep.of(followed.given, self.actuated, self.weights, solved, acting)


def _followed(machine: ProblemSolver, tasks: tuple[Task, ...]) -> tuple[list[Block], ProblemSolver]:
    """Return how followers of tasks are driven, and what closes a machine's loops with them.

    Raises:
        MobilityError: there are too few rows, too many, or some depend on others.
        SingularConfigurationError: the scene starts where actuated joints cannot follow.
    """
    start, of = configuration_of(machine), machine.problem
    mobility = len(of.independent)
    mechanism, blocks = followers(of.mechanism, tasks, start)
    rows = [name for block in blocks for name in block.rows]
    name = of.mechanism.name
    if twice := {row for row in rows if rows.count(row) > 1}:
        raise ArgumentError(f"the task names {choices(twice)} more than once")
    if len(rows) != mobility:
        apart = abs(len(rows) - mobility)
        advice = (
            f"{apart} too few: add axes of points, angles or names of coordinates, or hold joints"
            if len(rows) < mobility
            else f"{apart} too many: leave out what it cannot be given, such as axes of points"
        )
        asked = len(rows) - len(of.free)
        beside = f" beside what is free ({', '.join(of.free)})" if of.free else ""
        raise MobilityError(
            f"{name}: its motion has {mobility} degrees of freedom, and the task {asked} "
            f"row{'s' * (asked != 1)} ({', '.join(rows[:asked])}){beside}, {advice}",
            mobility=mobility,
        )
    closing = {loop.joint for loop in mechanism.loops}
    added = mechanism.joints.keys() - of.mechanism.joints.keys() - closing
    near: dict[str, Any] = {**of.held}
    for joint in added:
        near[joint] = (0.0, 0.0, 0.0, 1.0) if mechanism.joints[joint].type == "spherical" else 0.0
    for joint, at in start.items():
        # By its coordinates, where these make turns of a ball.
        each, values = of.mechanism.joints[joint].coordinates, np.ravel(at)
        turns = len(each) == len(values) > 1
        near = {**(dict(zip(each, values, strict=True)) if turns else {joint: at}), **near}
    try:
        problem = checked(
            mechanism,
            drive=[drive for block in blocks for drive in block.drives],
            held=of.held,
            near=near,
            outputs=(),
        )
        solver = ProblemSolver(problem)
    except SingularConfigurationError as error:
        raise SingularConfigurationError(
            f"{name}: the scene starts in {_FIRST} (condition {error.condition:.1e})"
            f"{_moving(error, of.mechanism)}. Start elsewhere with near=",
            **{**error.details, "finding": "", **_filtered(error, of.mechanism)},
        ) from error
    except MobilityError as error:
        free = [key for key in error.free if key in of.mechanism.drivable]
        left = f", and leave {choices(free)} undecided" if free else ""
        raise MobilityError(
            f"{name}: the rows of the task ({', '.join(rows)}) depend on each other{left}; give "
            "others",
            mobility=mobility,
            free=free,
        ) from error
    return blocks, solver


def _moving(error: SingularConfigurationError, mechanism: Mechanism) -> str:
    """Return in words what of a mechanism can move at a singular configuration of its follower."""
    moving = _filtered(error, mechanism)["moving"]
    return f": {choices(moving)} can move while the task rests" if moving else ""


def _filtered(
    error: SingularConfigurationError, mechanism: Mechanism
) -> dict[str, tuple[str, ...]]:
    """Return which coordinates of a mechanism an error of its follower names."""
    named = {"joints": error.joints, "moving": error.moving}
    known = mechanism.drivable
    return {role: tuple(name for name in every if name in known) for role, every in named.items()}


def solvers(problem: Problem, like: ProblemSolver | None = None) -> Iterator[ProblemSolver]:
    """Yield solvers of a problem, or, where it has too many drives, of as many of them as decide.

    Args:
        problem: with all actuated joints as drives.
        like: solver of a similar problem, see `ProblemSolver`.

    Raises:
        MobilityError, SingularConfigurationError: no such drives decide the motion.
    """
    actuated = problem.independent
    try:
        yield ProblemSolver(problem, like)
        return
    except MobilityError as error:
        if error.mobility is None or error.mobility == len(actuated):
            raise
        if error.mobility > len(actuated):
            raise MobilityError(
                f"{problem.mechanism.name}: its motion has {error.mobility} degrees of freedom, "
                f"and a task as many rows, whereas what is actuated or free has {len(actuated)} "
                f"({choices(actuated)}); actuate or hold {error.advice}",
                **error.details,
            ) from None
        if problem.free:
            raise MobilityError(
                f"{problem.mechanism.name}: {choices(problem.drives)} are actuated, more than "
                f"decide the motion beside what is free ({choices(problem.free)}), so that no law "
                f"says how they share their efforts; actuate {error.mobility - len(problem.free)}",
                mobility=error.mobility,
            ) from error
        refused: CardanError = error
        mobility = error.mobility
    first, found = actuated[:1], False
    with suppress(SingularConfigurationError):
        while len(first) <= mobility:
            try:
                solver = ProblemSolver(replace(problem, independent=first), like)
                mobility, found = len(first), True
                break
            except MobilityError as error:
                # The first of those that others leave undecided, since combinations may be many.
                more = [name for name in actuated if name in error.free and name not in first]
                if not more:
                    break
                first = (*first, more[0])
    if found:
        yield solver
    for drives in combinations(actuated, mobility):
        if found and set(drives) == set(first):
            continue
        try:
            solver = ProblemSolver(replace(problem, independent=drives), like)
        except (MobilityError, SingularConfigurationError) as error:
            refused = error
            continue
        found = True
        yield solver
    if not found:
        raise refused


def listed(mechanism: Mechanism, given: object) -> tuple[Task, ...]:
    """Return tasks, with names of coordinates one by one."""
    several = isinstance(given, Iterable) and not isinstance(given, str)
    tasks: list[Task] = []
    for item in given if several else (given,):  # type: ignore[attr-defined]
        if isinstance(item, str):
            tasks += each_coordinate(mechanism, (item,))
        elif isinstance(item, KINDS):
            tasks.append(item)
        else:
            raise ArgumentError(
                f"task has {described(item)}; expected "
                f"{', '.join(f'cd.{kind.__name__}' for kind in KINDS)} or names of coordinates"
            )
    if not tasks:
        raise ArgumentError("the task is empty: say what moves as given, such as cd.PointTask")
    return tuple(tasks)


def _weights(
    mechanism: Mechanism, actuated: tuple[str, ...], given: Mapping[str, float] | None
) -> FrozenDict[str, float]:
    """Return by how much the square of each actuated effort counts [1, of slides m²]."""
    length = mechanism.characteristic_length
    weights = {name: length**2 if mechanism.drivable[name].slides else 1.0 for name in actuated}
    for name, value in mapping("effort_weights", given).items():
        if name not in weights:
            raise ArgumentError(
                f"effort_weights: {name!r} is not actuated; actuated are {choices(actuated, name)}"
            )
        weights[name] = number(f"effort_weights[{name!r}]", value)
        if not weights[name] > 0.0:
            raise ArgumentError(f"effort_weights[{name!r}] is {value}; weights are positive")
    return frozen(weights)


def _swept(solver: ProblemSolver, assembled: AssembledPositions, x: Array, acting: Acting) -> Swept:
    problem, rates = solver.problem, partial(solver.rates_at, assembled, x, acting)
    where = x, assembled.turns, rates, assembled.shape
    motion = Motion(problem.mechanism, problem.independent, *where)
    return Swept(solver, acting, motion, np.zeros((0, 6)), {})


def _condition(solver: ProblemSolver, assembled: AssembledPositions, x: Array) -> Array:
    return solver.magnification_at(assembled, x).reshape(assembled.shape)


def _joined(parts: Sequence[Array]) -> Array:
    return np.concatenate(parts, axis=-1)
