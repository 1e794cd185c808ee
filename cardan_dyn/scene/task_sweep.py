"""Task sweep: the result of a scene with a task, with the efforts of its actuated joints."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np

from ..core.dynamics.inverse_dynamics import UNIQUE_TOLERANCE
from ..core.problem.acting import Acting
from ..core.results.case_line import Lead
from ..core.results.sweep import Sweep
from ..core.results.table import Table, Variable
from ..kit.arrays import EPS, Array, spread
from ..kit.errors import IndeterminateError, choices
from ..kit.frozen import FrozenDict, frozen, made, read_only
from .tasks import Task, missed, points_led

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ..core.mechanism.mechanism import Mechanism
    from ..core.results.derivative import Derivative, Swept
    from ..core.results.point_motion import Points
    from .task_derivative import TaskDerivative


class Given(NamedTuple):
    """How rows of a task move.

    Attributes:
        tasks: whose they are.
        rows: their names.
        position, speed, acceleration: `(..., m)`, which broadcast with the samples.
        condition: condition number of following them, or what returns it.
        followed: returns the sweep of what follows them.
    """

    tasks: tuple[Task, ...]
    rows: tuple[str, ...]
    position: Array
    speed: Array
    acceleration: Array
    condition: Array | Callable[[], Array]
    followed: Callable[[], Swept]


class Followed(NamedTuple):
    """How a mechanism follows a task, at N samples.

    Attributes:
        given: what it follows.
        x, turns: `(N, size)` coordinates of the mechanism, and whole turns that they lack.
        v, a: `(N, a)` velocities and accelerations of the actuated joints.
        shape: of the samples.
        held: held joints to other positions, see `Targets`.
    """

    given: Given
    x: Array
    turns: Array
    v: Array
    a: Array
    shape: tuple[int, ...]
    held: FrozenDict[str, Array]


class TaskSweep(Sweep):
    """Joint wrenches, efforts and motion of a scene whose task moves as given.

    It is a `Sweep` of the machine: `drives`, `position`, `drive_effort` and the like are those of
    its actuated joints, or of those among them that decide the motion; wrenches are the machine's,
    and the task carries nothing. A `derivative` tells what a number changes while the task stays as
    given; that of `of_machine`, while the motion of these joints stays as it is. Of efforts that
    are shared, neither tells anything. Near configurations
    where actuated joints lose hold of the mechanism, `condition` tells how uncertain efforts are,
    and `task_condition` does so of rates where the task ends its reach.

    Attributes:
        rows: names of the rows of the task.
        actuated_unique: actuated joint to whether its effort follows from the laws of motion. Where
            more joints are actuated than decide the motion, efforts are shared so that the sum of
            their squares times the scene's weights is least; wrenches that depend on it are not
            unique, and efforts of actuated joints that are no drives are among the `loads`.
    """

    rows: tuple[str, ...]
    actuated_unique: Mapping[str, bool]
    _given: Given
    _shares: Mapping[str, Array]

    def __init__(
        self,
        *,
        given: Given,
        shares: Mapping[str, Array],
        actuated_unique: Mapping[str, bool],
        **of_sweep: Any,
    ) -> None:
        # `shares` are efforts of actuated joints that are no drives; the rest as in `Sweep`.
        for values in given[2:5]:
            read_only(values)
        self.rows, self.actuated_unique = given.rows, actuated_unique
        self._given, self._shares = given, shares
        super().__init__(**of_sweep)

    def __reduce__(self) -> tuple[object, ...]:
        _, arguments = super().__reduce__()
        kind, given, known = cast("tuple[Any, ...]", arguments)
        own = {
            "given": self._given._replace(condition=self.task_condition),
            "shares": self._shares,
            "actuated_unique": self.actuated_unique,
        }
        return made, (kind, {**given, **own}, known)

    @classmethod
    def of(
        cls,
        given: Given,
        actuated: tuple[str, ...],
        weights: Mapping[str, float],
        solved: Callable[[Acting], Sweep],
        acting: Acting,
    ) -> TaskSweep:
        """Return a sweep of a task.

        Args:
            given: how its rows move.
            actuated: names of the joints that carry its efforts, its drives among them.
            weights: of the squares of their efforts.
            solved: returns a sweep of the machine.
            acting: what acts on it besides.

        Raises:
            IndeterminateError: efforts are not unique, and the scene is strict.
        """
        sweep = solved(acting)
        unique, of_couplings, shares = sweep.unique, sweep.coupling_unique, {}
        actuated_unique = dict.fromkeys(actuated, True)
        drives = sweep.drives
        others = [name for name in actuated if name not in drives]
        if others:
            # Rates of all actuated joints per unit of each drive: they transmit efforts as well.
            ratio = sweep.motion.ratio
            of_each = [np.stack([ratio(name, drive) for name in actuated], -1) for drive in drives]
            rates = np.stack(of_each, -1)
            weighed = rates / np.array([weights[name] for name in actuated])[:, None]
            needed = np.moveaxis(rates, -1, -2) @ weighed
            effort = sweep.drive_effort.reshape(*sweep.shape, -1, 1)
            efforts = (weighed @ np.linalg.solve(needed, effort))[..., 0]
            shares = {name: efforts[..., actuated.index(name)] for name in others}
            flags = _unique(sweep, solved, acting, others, rates, actuated)
            unique, of_couplings, actuated_unique = flags
            if sweep.problem.strict and not all(actuated_unique.values()):
                chosen = [name for name, is_unique in actuated_unique.items() if not is_unique]
                raise IndeterminateError(
                    f"{sweep.mechanism.name}: more joints are actuated than decide the motion, so "
                    f"that the laws of motion leave open how {choices(chosen)} share their effort; "
                    "actuate fewer, or leave strict out to have the least norm",
                    components={name: ["effort"] for name in chosen},
                )
            sweep = solved(_loaded(acting, shares))
        return cls(
            given=given,
            shares=frozen(shares),
            actuated_unique=frozen(actuated_unique),
            problem=sweep._problem,
            held=sweep._held,
            acting=sweep._acting,
            source=sweep._source,
            unique=np.array(unique),
            coupling_moment=sweep.coupling_moment,
            coupling_unique=frozen(of_couplings),
            condition=sweep._condition,
            proven=sweep._proven,
        )

    @property
    def of_machine(self) -> Sweep:
        """The same of the machine, on which efforts of actuated joints that are no drives act."""
        return Sweep(
            problem=self._problem,
            held=self._held,
            acting=self._acting,
            source=self._source,
            unique=np.array(self.unique),
            coupling_moment=self.coupling_moment,
            coupling_unique=self.coupling_unique,
            condition=self._condition,
            proven=self._proven,
            solver=self._solved_by,
        )

    def derivative(self, *parameters: str) -> Derivative | Mapping[str, Derivative]:
        """Return how the results change with numbers while the task stays as given, exactly.

        The actuated joints then move otherwise: `of_machine.derivative(...)` holds their motion.

        Args:
            parameters: as of `Sweep.derivative`; in place of drives rows of the task, such as
                `tip.x`, `speed:tip.x` and `acceleration:tip.x`, but for the rotation of a pose.

        Returns:
            As `Sweep.derivative`. Residuals of loops are bounds: those of the derivatives by the
            number and by the motion of the drives, summed up.

        Raises:
            ArgumentError: as `Sweep.derivative`.
            ModelError: likewise; or what rows of the task mean depends on the number.
        """
        found = self._derivatives(parameters)
        several = len(parameters) > 1 or "*" in parameters[0]
        return frozen(found) if several else found[parameters[0]]

    def gradient(self, weights: Mapping[str, ArrayLike], *parameters: str) -> Mapping[str, float]:
        """Return how a weighted sum of results changes while the task stays as given.

        Arguments and errors as of `Sweep.gradient`; it is found forwards, in the time of
        `derivative`.
        """
        from ..core.results.derivative import weighed

        by = self._derivatives(parameters)
        weighted = [*weighed(self._swept(parameters), weights)]
        slopes = {name: item.weighed(weighted, name in parameters) for name, item in by.items()}
        return frozen({name: slope for name, slope in slopes.items() if slope is not None})

    def _derivatives(self, parameters: tuple[str, ...]) -> Mapping[str, TaskDerivative]:
        from .task_derivative import task_derivatives  # Few sweeps are differentiated.

        of = self._swept(parameters)
        given = self._given
        return task_derivatives(of, given.followed(), given.tasks, self.rows, parameters)

    def _swept(self, parameters: tuple[object, ...]) -> Swept:
        shared = [name for name, is_unique in self.actuated_unique.items() if not is_unique]
        # What holds a joint is not looked at one by one.
        return super()._swept(parameters)._replace(shared=shared and [*shared, *self.held])

    @cached_property
    def task_position(self) -> Array:
        """Positions of the rows `(N, m)` [rad or m]; `(N,)` of a single one."""
        return self._spread(self._given.position)

    @cached_property
    def task_speed(self) -> Array:
        """Their speeds [rad/s or m/s], like `task_position`."""
        return self._spread(self._given.speed)

    @cached_property
    def task_acceleration(self) -> Array:
        """Their accelerations [rad/s² or m/s²], likewise."""
        return self._spread(self._given.acceleration)

    def _spread(self, values: Array) -> Array:
        """Return values `(..., m)` in the shape of the samples, without an axis for one row."""
        every = np.array(spread(values, (*self.shape, len(self.rows))))
        return read_only(every[..., 0] if len(self.rows) == 1 else every)

    @cached_property
    def task_condition(self) -> Array:
        """Condition number `(N,)` of positions and rates of the actuated joints.

        It grows towards singular configurations of the first kind, where the task ends its reach;
        `condition` does towards those of the second kind. See there for how it counts.
        """
        condition = self._given.condition
        values = condition() if callable(condition) else condition
        return read_only(spread(values, self.shape))

    @cached_property
    def near_reach(self) -> str:
        """In words where the task ends its reach, or passes a singular configuration on its way.

        At the end, joints turn back: another motion with the same task may go through, into another
        assembly mode; sweeps do not. Between two samples on different sides of configurations where
        the actuated joints lose hold, any way goes through one.
        """
        condition, texts = np.ravel(self.task_condition), []
        worst = int(np.argmax(condition))
        if EPS * condition[worst] > EPS**0.5:  # Half of the digits of rates are left then.
            texts.append(
                f"the task is at the end of its reach at {self._at(worst)}: joints stay in their "
                f"assembly mode and turn back there, with rates uncertain by {condition[worst]:.0e}"
                " roundings; other rows of the task may lead through"
            )
        if self._crossed.size:
            first = int(self._crossed[0])
            texts.append(
                f"between {self._at(first)} and {self._at(first + 1)} the task passes a singular "
                "configuration of the second kind: actuated joints lose hold of it on the way, "
                "where forces grow without limit"
            )
        return "; ".join(texts)

    @property
    def _crossed(self) -> Array:
        """Samples behind which singular configurations of the machine lie, before the next one."""
        if len(self.shape) != 1 or len(self.actuated_unique) > len(self.drives):
            return np.zeros(0, dtype=int)  # Without an order, or others hold what is lost there.
        kinematics = self._solver.assembly.kinematics
        x = self.motion.rows
        before = kinematics.evaluate(x[:-1])
        same = kinematics.same_side(kinematics.evaluate(x[1:]), before.inverses)
        return np.flatnonzero(~same)

    def _at(self, sample: int) -> str:
        """Return which sample it is and where the task is there."""
        rows = spread(self._given.position, (*self.shape, len(self.rows)))
        at = ", ".join(
            f"{name} = {value:.4g} {unit_of_row(self.mechanism, name)}"
            for name, value in zip(self.rows, rows.reshape(-1, len(self.rows))[sample], strict=True)
        )
        return f"sample {sample} ({at})"

    @cached_property
    def task_residual(self) -> float:
        """Greatest error of the rows, where the machine's own coordinates place its links.

        It is an angle [rad], or a length as a fraction of `Mechanism.characteristic_length`; what
        follows the task has no part in it.
        """
        every = spread(self._given.position, (*self.shape, len(self.rows)))
        return missed(self._given.tasks, every, self)

    @cached_property
    def actuated_effort(self) -> Mapping[str, Array]:
        """Actuated joint to its effort `(N,)` [N·m or N], like `drive_effort`.

        Raises:
            ModelError: the outputs of the scene leave it out.
        """
        of_drives = self.drive_effort.reshape(*self.shape, -1)
        efforts = {name: of_drives[..., k] for k, name in enumerate(self.drives)}
        efforts |= dict(self._shares)
        return frozen({name: read_only(efforts[name]) for name in self.actuated_unique})

    @property
    def led_points(self) -> dict[str, tuple[str, Array]]:
        """Links of which the task leads a point, to that point `(3,)`, as `points` of results."""
        return points_led(self._given.tasks)

    @property
    def leads(self) -> list[Lead]:
        """Rows of the task, see `Sweep.leads`."""
        position, speed = (
            np.reshape(values, (*self.shape, -1))
            for values in (self.task_position, self.task_speed)
        )
        return [
            Lead(row, unit_of_row(self.mechanism, row) == "m", position[..., k], speed[..., k])
            for k, row in enumerate(self.rows)
        ]

    def table(self, *, motion: bool = True, points: Points = ()) -> Table:
        """Return all results as a table, with positions, speeds and accelerations of the task.

        Arguments as of `Sweep.table`.
        """
        return with_task(super().table(motion=motion, points=points), self)


def with_task(table: Table, result: Any) -> Table:
    """Return a table of a result with positions, speeds and accelerations of its task."""
    dims = (*table.samples, "task")
    per = {"position": "", "speed": "/s", "acceleration": "/s²"}
    units = [unit_of_row(result.mechanism, row) for row in result.rows]
    variables = [
        (
            f"task_{name}",
            Variable(
                dims,
                getattr(result, f"task_{name}").reshape(*result.shape, -1),
                tuple(unit + rate for unit in units),
                f"{name} of the task",
                True,
            ),
        )
        for name, rate in per.items()
    ]
    labels = {**table.labels, "task": result.rows}
    return replace(table, variables=[*table.variables, *variables], labels=labels)


def unit_of_row(mechanism: Mechanism, row: str) -> str:
    """Return the unit of a row of a task, `rad` or `m`, by its name."""
    if row in mechanism.drivable:
        return mechanism.drivable[row].unit
    return "rad" if row.rpartition(".")[2].startswith("turn_") else "m"


def _loaded(acting: Acting, more: Mapping[str, Array | float]) -> Acting:
    """Return what acts, with efforts at some joints besides."""
    loads = dict(acting.joint_loads)
    for name, effort in more.items():
        loads[name] = np.asarray(loads.get(name, 0.0) + effort)
    return acting._replace(joint_loads=frozen(loads))


def _unique(
    sweep: Sweep,
    solved: Callable[[Acting], Sweep],
    acting: Acting,
    others: list[str],
    rates: Array,
    actuated: tuple[str, ...],
) -> tuple[Array, dict[str, bool], dict[str, bool]]:
    """Return which components of wrenches `(k, 6)`, couplings and efforts no sharing changes.

    Args:
        sweep: in which drives alone carry the efforts.
        solved: returns a sweep of the machine.
        acting: what acts in it.
        others: actuated joints that are no drives.
        rates: `(..., a, n)` of all actuated joints per unit of each drive.
        actuated: their names.
    """
    unique, of_couplings = np.array(sweep.unique), dict(sweep.coupling_unique)
    of_drives = np.zeros(len(sweep.drives), dtype=bool)
    for name in others:
        changed = solved(_loaded(acting, {name: 1.0}))
        pairs = zip(changed.values(), sweep.values(), strict=True)
        every = [
            np.concatenate([after.force - before.force, after.moment - before.moment], axis=-1)
            for after, before in pairs
        ]
        sizes = np.abs(every).reshape(len(every), math.prod(sweep.shape), 6).max(axis=1)
        unique &= sizes <= UNIQUE_TOLERANCE * sizes.max(initial=0.0)
        for coupling, moment in changed.coupling_moment.items():
            apart = np.abs(moment - sweep.coupling_moment[coupling]).max()
            of_couplings[coupling] &= bool(apart <= UNIQUE_TOLERANCE)
        turned = np.abs(rates[..., actuated.index(name), :]).reshape(-1, len(of_drives)).max(axis=0)
        of_drives |= turned > UNIQUE_TOLERANCE * turned.max(initial=0.0)
    flags = dict(zip(sweep.drives, ~of_drives, strict=True))
    return unique, of_couplings, {name: bool(flags.get(name, False)) for name in actuated}
