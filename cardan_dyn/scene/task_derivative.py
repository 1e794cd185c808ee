"""Task derivative: how a sweep changes with a number while the rows of its task stay as given."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import nullcontext, suppress
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..core.description.origins import PREFIX
from ..core.dynamics.differentiated import Change
from ..core.dynamics.parameters import OfColumn, OfOrigin
from ..core.results.derivative import Derivative, Swept, derivatives_of, refuse_turned
from ..kit.arrays import Array, flat
from ..kit.errors import ModelError, choices
from ..kit.frozen import frozen, read_only
from .tasks import AngleTask, PoseTask, Task

_OF_DRIVES = "", "speed:", "acceleration:"
"""What a drive's names as parameters begin with."""


class _Sum(NamedTuple):
    """A sum of changes, each of them times a number of each sample.

    Attributes:
        terms: weights `(N,)` and changes.
    """

    terms: Sequence[tuple[Array, Change]]

    def of(self, field: str, columns: Any = slice(None)) -> Array:
        """Return changes of a field, see `Change.of`."""
        each = (weights[:, None] * change.of(field, columns) for weights, change in self.terms)
        return np.asarray(sum(each))

    def picks(self, field: str, columns: Any = slice(None)) -> Array:
        """Return which columns of a field pick up self-stress, see `Change.picks`."""
        each = [of.picks(field, columns) for weights, of in self.terms if np.any(weights)]
        return np.any(each, axis=0) if each else np.zeros(1, dtype=bool)


class TaskDerivative(Derivative):
    """How the results of a sweep change with a number, per its unit, while its task stays as given.

    Drives move as the task then needs: it is the derivative of the machine by the number, and by
    positions, speeds and accelerations of its drives times how these change, which the loops of
    what follows the task tell. A row of the task as a number is what moves alone of all rows.
    """

    _terms: Sequence[tuple[Array, Derivative]]

    def __init__(self, parameter: str, of: Swept, terms: Sequence[tuple[Array, Derivative]]):
        change: Any = _Sum([(weights, item._change) for weights, item in terms])
        self._freeze(parameter=parameter, _of=of, _change=change, _terms=terms)

    @cached_property
    def actuated_effort(self) -> Mapping[str, Array]:
        """Actuated joint to the derivative of its effort `(N,)`; NaN where others share it.

        Raises:
            ModelError: the outputs of the scene leave it out.
        """
        problem, nothing = self._of.problem, read_only(np.full(self.shape, np.nan))
        shares = (name for name in self._of.shared if name not in problem.held)
        of_drives = {name: self._read(f"{name}.drive_effort") for name in problem.independent}
        return frozen(dict.fromkeys(shares, nothing) | of_drives)

    def weighed(self, weights: Sequence[tuple[str, int, Array]], is_asked: bool) -> float | None:
        """Return that of a sum of columns of fields, times weights `(N,)`; None if it is open.

        Raises:
            ModelError: likewise, and the parameter was asked for by its name.
        """
        if any(self._change.picks(field, [column]).any() for field, column, _ in weights):
            refuse_turned(self.parameter, is_asked)
            return None
        each = (own @ self._change.of(field, [column])[:, 0] for field, column, own in weights)
        return float(sum(each))

    @property
    def _residuals(self) -> tuple[float, float]:
        each = [
            (float(np.max(np.abs(weights), initial=0.0)), *item._residuals)
            for weights, item in self._terms
            if np.any(weights)
        ]
        # Bounds: the sum of how far loops open, and the worst of balances.
        return sum(size * loop for size, loop, _ in each), max((b for *_, b in each), default=0.0)


def task_derivatives(
    of: Swept, follower: Swept, tasks: Sequence[Task], rows: Sequence[str], names: Sequence[str]
) -> Mapping[str, TaskDerivative]:
    """Return derivatives by some numbers, see `TaskSweep.derivative`.

    Args:
        of: the sweep of the machine.
        follower: how the task is followed.
        tasks: the tasks.
        rows: names of their rows.
        names: of the numbers.

    Raises:
        ArgumentError, ModelError: as `Sweep.derivative`; or how the task is met depends on it.
    """
    drives, count = of.problem.independent, len(of.motion.x)
    of_rows = {f"{kind}{row}" for kind in _OF_DRIVES for row in rows}
    of_drives = [f"{kind}{drive}" for kind in _OF_DRIVES for drive in drives]
    others = [name for name in names if name not in of_rows]
    for name in set(of_drives).intersection(others):
        raise ModelError(
            f"{name!r}: drives move as the task says; name one of its rows, {choices(rows)}, or "
            "ask sweep.of_machine.derivative(...), which holds what moves as it is",
            name=name,
        )
    known = {} if not others else dict(of.parameters(others))
    numbers = [name for name in known if name not in of_drives]
    by = derivatives_of(of, [*others, *of_drives])
    found: dict[str, TaskDerivative] = {}
    for name in dict.fromkeys([*numbers, *(name for name in names if name in of_rows)]):
        terms = []
        if name in numbers:
            if name not in by:
                continue  # One of a pattern by which there is none.
            terms.append((np.ones(count), by[name]))
        if name in of_rows or isinstance(known[name], OfColumn | OfOrigin):
            with nullcontext() if name in names else suppress(ModelError):
                _refuse(tasks, name)
                motion = _followed(follower, name).motion
                reads = motion.position, motion.velocity, motion.acceleration
                for kind, read in zip(_OF_DRIVES, reads, strict=True):
                    terms += [(flat(read(d), of.motion.shape), by[f"{kind}{d}"]) for d in drives]
                found[name] = TaskDerivative(name, of, terms)
        else:
            found[name] = TaskDerivative(name, of, terms)
    return found


def _followed(follower: Swept, name: str) -> Derivative:
    """Return how what follows a task moves with a number.

    Raises:
        ModelError: it follows in a plane that the number leaves, or as a rod that spins idly, whose
            line depends on it. Where the number is held, it follows in space, and the line turns.
    """
    try:
        return derivatives_of(follower, [name])[name]
    except ModelError as error:
        if name in follower.problem.held:
            raise
        raise ModelError(
            f"{name!r}: what follows the task is made for where it stands, so that no derivative "
            f"is known; hold it there, held={{{name!r}: 0.0}}, whose derivative is the same, or "
            "ask sweep.of_machine.derivative(...), which holds the motion of the drives",
            name=name,
        ) from error


def _refuse(tasks: Sequence[Task], name: str) -> None:
    """Refuse numbers that change what rows mean, and rows that are no coordinates.

    Raises:
        ModelError: it is such a number.
    """
    place, _, component = name.removeprefix("speed:").removeprefix("acceleration:").rpartition(".")
    origin = place.removeprefix(PREFIX) if place.startswith(PREFIX) else ""
    for task in tasks:
        if isinstance(task, str):
            continue
        turns = isinstance(task, AngleTask) and origin and component in ("roll", "pitch", "yaw")
        carries = origin and origin in (task.link, getattr(task, "other", ""))
        of_pose = isinstance(task, PoseTask) and place == task.link and component[:5] == "turn_"
        if turns or carries or of_pose:
            raise ModelError(
                f"{name!r}: what rows of a {type(task).__name__} of {task.link!r} mean depends on "
                "it, or it is no coordinate, so that no derivative is known here; "
                "sweep.of_machine.derivative(...) holds the motion of the drives instead",
                name=name,
            )
