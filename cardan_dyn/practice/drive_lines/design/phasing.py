"""Phasing: where the forks of the intermediate shafts have to stand."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from ....kit.arrays import ROUNDED, Array
from ....kit.checks import whole
from ....kit.errors import ArgumentError, ModelError, choices
from ....kit.extremes import greatest
from ..line.data import LineData
from ..line.fields import Entry, number
from ..line.geometry import residual_angles
from .fork_choice import Allowed, halved, least_residual, phases_of, tooth_offsets
from .fork_polygon import angle, distance, least_greatest
from .fork_search import Choice, minima
from .support_loads import SupportLoads, support_loads

Line = TypeVar("Line", bound=LineData)

OBJECTIVES = ("residual_angle", "bearing_force")
FINE, ROUGH = 240, 36
"""Positions in half a turn at which bearing forces are bounded, and at which a search starts."""


class Alternative(NamedTuple):
    """Another way to put the forks.

    Attributes:
        fork_offsets: `(n - 1,)` [rad].
        value: of the objective [rad or N].
    """

    fork_offsets: Array
    value: float


@dataclass(frozen=True, eq=False, repr=False)
class Phasing(Generic[Line]):
    """Forks that make an objective least.

    Attributes:
        line: the best line.
        given: the line that was given.
        objective: `residual_angle` or `bearing_force`.
        value: of the objective with the best forks [rad or N].
        given_value: with the forks as they were given [rad or N].
        bound: value that no choice of forks can be below [rad or N].
        proven: whether the value is the global optimum: it meets the bound up to rounding.
        method: how it was found, in words.
        alternatives: other forks, the best first: of equal value, or the next best ones. Of forks
            that stand freely these are other minima, of which closed forms know all.
    """

    line: Line
    given: Line
    objective: str
    value: float
    given_value: float
    bound: float
    proven: bool
    method: str
    alternatives: tuple[Alternative, ...]

    def __repr__(self) -> str:
        best, given = (in_words(self.objective, item) for item in (self.value, self.given_value))
        proven = "proven" if self.proven else "not proven"
        return (
            f"<Phasing of {self.line.name!r} by {self.objective}: {best}, given {given}; {proven}>"
        )

    @property
    def fork_offsets(self) -> Array:
        """Fork offsets of the best line `(n - 1,)`, -π/2 < offset <= π/2 [rad]."""
        return self.line.fork_offsets

    @property
    def residual_angles(self) -> Array:
        """Residual angles of the shafts behind all joints of the best line `(n,)` [rad]."""
        return residual_angles(self.line.uneven_angles, self.line.fork_phases)

    @property
    def angle_error(self) -> float:
        """Greatest lead of the best line's output over its input, asin tan²(β_E/2) [rad]."""
        return float(np.arcsin(np.tan(self.residual_angles[-1] / 2.0) ** 2))


def in_words(objective: str, value: float) -> str:
    """Return a value of an objective with its unit."""
    return f"{np.degrees(value):.4g}°" if objective == "residual_angle" else f"{value:.5g} N"


def with_forks(line: Line, offsets: Array) -> Line:
    """Return a line with other fork offsets `(n - 1,)` [rad]."""
    inner = [
        dataclasses.replace(shaft, fork_offset=float(offset))
        for shaft, offset in zip(line.shafts[1:-1], offsets, strict=True)
    ]
    return dataclasses.replace(line, shafts=(line.shafts[0], *inner, line.shafts[-1]))


def phasing(
    line: Line,
    objective: str = "residual_angle",
    *,
    shafts: Sequence[str | int] | None = None,
    bearings: Sequence[str] | None = None,
    torque: float | None = None,
    teeth: int | Mapping[str | int, int] | None = None,
    fixed: Sequence[str | int] | None = None,
    count: int = 8,
) -> Phasing[Line]:
    """Return where the forks have to stand so that an objective is least.

    The least residual angle of free forks is known in closed form, and that of forks on
    splines is found by branch and bound; both are the global optimum, which `proven` says.
    Bearing forces are searched for, unless all forks stand on splines and are few enough to be
    all tried; on 60 random lines no other search found forces less by more than 0.02 %. A fork
    is the same after half a turn, so offsets are told between ±90°.

    Args:
        line: the line.
        objective: `residual_angle`, the greatest of chosen shafts, or `bearing_force`, the
            greatest of chosen bearings over a revolution, quasi-static and without weight.
        shafts: names or numbers of the shafts whose residual angle counts; the output shaft
            unless given.
        bearings: names of the bearings whose forces count; all unless given.
        torque: of the input shaft, for bearing forces [N·m]; that of the line unless given.
        teeth: numbers of teeth of the splines on which forks can be turned, by shaft, or one
            for all intermediate shafts that are not fixed: offsets are the present one and steps
            of 360°/teeth from it. Forks of other shafts are free.
        fixed: names or numbers of the intermediate shafts whose forks stay as they are; unless
            given, coupling pieces of centred joints, which are one forging, but for those that
            `teeth` names.
        count: number of alternatives that are told, if there are as many.

    Raises:
        ArgumentError: an argument does not go with the others or is out of its range.
        ModelError: there is no such shaft or bearing; for bearing forces, a line that is not
            held, or whose forces statics leaves open.
    """
    task = fork_task(line, objective, shafts, bearings, torque, teeth, fixed, count)
    return phased(line, task)


class ForkTask(NamedTuple):
    """What is asked of forks, checked.

    Attributes:
        objective: `residual_angle` or `bearing_force`.
        corners: numbers of the joints behind which the residual angle counts.
        bearings: names of the bearings whose forces count; all if None.
        torque: of the input shaft, for bearing forces [N·m].
        allowed: what the fork of each intermediate shaft can take.
        most: number of alternatives that are told.
    """

    objective: str
    corners: list[int]
    bearings: Sequence[str] | None
    torque: float
    allowed: Allowed
    most: int


def fork_task(
    line: LineData,
    objective: str,
    shafts: Sequence[str | int] | None = None,
    bearings: Sequence[str] | None = None,
    torque: float | None = None,
    teeth: int | Mapping[str | int, int] | None = None,
    fixed: Sequence[str | int] | None = None,
    count: int = 8,
) -> ForkTask:
    """Return what is asked of forks; see `phasing`."""
    if objective not in OBJECTIVES:
        raise ArgumentError(
            f"objective {objective!r} is unknown; objectives: {choices(OBJECTIVES, objective)}"
        )
    is_force = objective == "bearing_force"
    others = {"shafts": shafts} if is_force else {"bearings": bearings, "torque": torque}
    for name, value in others.items():
        if value is not None:
            raise ArgumentError(
                f"{name} has no meaning for the objective {objective!r}; leave it out"
            )
    return ForkTask(
        objective,
        corners=_corners(line, shafts),
        bearings=bearings,
        torque=_input_torque(line, torque) if is_force else 0.0,
        allowed=_allowed_offsets(line, teeth, fixed),
        most=whole("count", count, most=1000),
    )


def phased(line: Line, task: ForkTask) -> Phasing[Line]:
    """Return the forks that meet a task best."""
    return (
        _least_force(line, task)
        if task.objective == "bearing_force"
        else _least_residual(line, task)
    )


def _allowed_offsets(
    line: LineData, teeth: int | Mapping[str | int, int] | None, fixed: Sequence[str | int] | None
) -> list[Array | None]:
    """Return what the fork of each intermediate shaft can take; see `Allowed`."""
    if line.count < 2:
        raise ArgumentError(
            "the line has one joint and no intermediate shaft; only lines of two joints and more "
            "have forks that can be put to each other"
        )
    inner = range(1, line.count)
    if isinstance(fixed, (str, int)):
        fixed = (fixed,)
    of_shaft: dict[int, int] = {}
    if isinstance(teeth, Mapping):
        of_shaft = {_shaft_index(line, shaft, inner): number for shaft, number in teeth.items()}
    if fixed is None:
        held = [index for index in line.centred if index not in of_shaft]
    else:
        held = [_shaft_index(line, shaft, inner) for shaft in fixed]
    if teeth is not None and not isinstance(teeth, Mapping):
        of_shaft = {index: teeth for index in inner if index not in held}
    twice = sorted(set(held) & set(of_shaft))
    if twice:
        raise ArgumentError(
            f"{line.shaft_names[twice[0]]} is fixed and has teeth; it can be one of them"
        )
    result: list[Array | None] = []
    for index, offset in zip(inner, line.fork_offsets, strict=True):
        number = 2 if index in held else of_shaft.get(index)
        if number is None:
            result.append(None)
        else:
            number = whole(f"teeth of {line.shaft_names[index]}", number, 2, 10_000)
            result.append(tooth_offsets(float(offset), number))
    return result


def _corners(line: LineData, shafts: Sequence[str | int] | None) -> list[int]:
    """Return the numbers of the joints before shafts; of the output shaft unless given."""
    if shafts is None:
        return [line.count]
    if isinstance(shafts, (str, int)):
        shafts = (shafts,)
    found = sorted({_shaft_index(line, shaft, range(1, line.count + 1)) for shaft in shafts})
    if not found:
        raise ArgumentError("shafts is empty; name the shafts that are to turn evenly")
    return found


def _shaft_index(line: LineData, shaft: str | int, valid: range) -> int:
    """Return the index of a shaft, which may be given by its name."""
    names = line.shaft_names
    if isinstance(shaft, (int, np.integer)) and not isinstance(shaft, bool) and shaft in valid:
        return int(shaft)
    listed = [names[index] for index in valid]
    if isinstance(shaft, str) and shaft in listed:
        return names.index(shaft)
    kind = "shaft behind a joint" if line.count in valid else "intermediate shaft"
    raise ModelError(
        f"there is no {kind} {shaft!r}; shafts: {choices(listed, shaft)}",
        name=shaft if isinstance(shaft, str) else None,
    )


def _input_torque(line: LineData, torque: float | None) -> float:
    """Return the torque of the input shaft, that of the line unless given [N·m]."""
    found = line.torque if torque is None else torque
    if found is None:
        raise ArgumentError("bearing forces need a torque; give torque, here or in the line")
    return number(found, Entry("quantity", "torque"), "torque", ArgumentError)


def _least_residual(line: Line, task: ForkTask) -> Phasing[Line]:
    """Return the forks with the least greatest residual angle of shafts."""
    corners, allowed = task.corners, task.allowed
    betas, planes, given = line.uneven_angles, line.geometry.plane_offsets, line.fork_offsets
    choice = least_residual(betas, planes, allowed, corners, given, task.most + 1)

    def values(phases: Array) -> Array:
        found = residual_angles(betas, phases)
        return np.asarray(found[..., np.array(corners) - 1].max(axis=-1))

    bound = float(angle(least_greatest(distance(betas), corners)))
    best = float(values(phases_of(choice.offsets, planes)).min())
    if choice.complete:
        # A choice in steps is its own bound; a closed form comes with one.
        bound = best if any(item is not None for item in allowed) else bound
    proven = bool(np.cos(bound) - np.cos(best) <= ROUNDED)
    return _phasing(line, task, choice, values, bound, proven)


def _least_force(line: Line, task: ForkTask) -> Phasing[Line]:
    """Return the forks with the least greatest bearing force over a revolution."""
    loads = support_loads(line, task.bearings)
    planes, given = line.geometry.plane_offsets, line.fork_offsets

    fine, rough = (
        partial(squares_of, loads, planes=planes, positions=positions)
        for positions in (FINE, ROUGH)
    )
    choice = minima(fine, rough, task.allowed, task.most + 1, given)
    choice = choice._replace(offsets=halved(choice.offsets))

    def values(phases: Array) -> Array:
        return abs(task.torque) * np.array([peak(loads, of_line) for of_line in phases])

    bound = float(values(phases_of(choice.offsets, planes)).min()) if choice.complete else 0.0
    return _phasing(line, task, choice, values, bound, choice.complete)


def squares_of(loads: SupportLoads, offsets: Array, planes: Array, positions: int) -> Array:
    """Return the squares of forces per torque of fork offsets `(c, n - 1)`, `(c, q)` [1/m²].

    At so many positions in half a turn, of all bearings.
    """
    phases = phases_of(offsets, planes)[:, None, :]
    squares = loads.squares(phases, np.arange(positions) * (np.pi / positions))
    return squares.reshape(len(offsets), -1)


def peak(loads: SupportLoads, phases: Array) -> float:
    """Return the greatest force of any bearing over a revolution per torque [1/m].

    Args:
        loads: of the bearings.
        phases: `(n,)` fork phases [rad].
    """
    squares = loads.squares(phases, np.arange(FINE) * (np.pi / FINE))
    return float(np.sqrt(greatest(squares)[0].max()))


def _phasing(
    line: Line, task: ForkTask, choice: Choice, values: Any, bound: float, proven: bool
) -> Phasing[Line]:
    """Return the best of a choice with the others; of equals, the one with the least change."""
    given = float(values(line.fork_phases[None])[0])
    # The given forks are among those that are allowed, and stay if none are better.
    offsets = np.vstack([choice.offsets, line.fork_offsets])
    found = np.append(values(phases_of(choice.offsets, line.geometry.plane_offsets)), given)
    merit = np.cos(found) if task.objective == "residual_angle" else -found
    is_equal = merit.max() - merit <= ROUNDED * np.abs(merit.max())
    change = np.abs(halved(offsets - line.fork_offsets)).max(axis=1)
    order = np.lexsort((np.where(is_equal, change, found), ~is_equal))
    if not is_equal[-1]:
        order = order[order < len(choice.offsets)]
    kept: list[int] = []
    for row in order:
        gaps = [np.abs(halved(offsets[row] - offsets[i])).max() for i in kept]
        if all(gap > 1e-9 for gap in gaps):
            kept.append(int(row))
    first, *others = kept[: task.most + 1]
    chosen = with_forks(line, halved(offsets[first]))
    return Phasing(
        line=chosen,
        given=line,
        objective=task.objective,
        value=float(values(chosen.fork_phases[None])[0]),
        given_value=given,
        bound=bound,
        proven=proven,
        method=choice.method,
        alternatives=tuple(Alternative(offsets[i], float(found[i])) for i in others),
    )
