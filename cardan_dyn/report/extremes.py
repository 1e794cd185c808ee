"""Extremes: the greatest and least wrenches and efforts of a sweep, and where they occur."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..dynamics.problem_solver import ProblemSolver
from ..elements.link_loads import Wrench
from ..errors import ModelError
from ..figures.wrenches import QUANTITIES, determined, values_of
from ..frozen import Frozen
from ..results.sweep import Sweep
from ..scene.scene import Scene

_ROUNDING = 1e-12
"""Part of the greatest wrench up to which a value is rounding of none. Rounding is some eps times
the condition number; that of the sweep counts where it is greater."""
_SAME = 1e-9
"""Part of the greatest value by which extremes at several positions may differ: shafts with two
planes of symmetry have each twice in a turn."""
_WITH_AXIS = ("force", "axial", "shear", "torsion", "bending")
_WITHOUT = ("force", "moment")
"""Quantities of joints with an axis, and of others."""
_TURN = 2.0 * np.pi * (1.0 - _SAME)
_EQUAL = 1e-14
"""Part of a value that is its rounding."""
_STEPS = 34
"""Steps of the golden section. Each leaves 0.618 of the interval between two samples, together
1e-7: of an interval of 1°, what the square root of rounding allows to be told at all."""
_FIRST = 12
"""Steps after which the rest is a parabola: the third power of 1e-4 rad is rounding."""
_SMOOTH = 1e-2
"""Part of its height by which a parabola may miss a value: kinks miss by some tenths of it."""
_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
_MOST_PLACES = 8
"""Samples that are extreme within their neighbours, and between which the extreme is sought."""
_EVEN = 1e-6
"""By what fraction of a step the steps of a whole turn may differ."""
_REACH = 0.5
"""How far beyond the sample an extreme may be, as a part of the differences to its neighbours: a
parabola through the three is an eighth beyond."""


class Extreme(NamedTuple):
    """A quantity over the sweep: how great and how small it is, and where.

    Attributes:
        owner: name of the joint, drive, coupling or element.
        quantity: `force`, `axial`, `shear`, `moment`, `torsion`, `bending` of a `JointWrench`, or
            `drive effort`, `holding effort`, `coupling effort`, or what an element exerts.
        unit: of the values.
        greatest, least: values; the same where it is constant.
        greatest_at, least_at: `(n, d)` drive positions where these occur [rad or m]; empty where it
            is constant.
        determined: whether it follows from the laws of motion alone. If not, it was chosen by the
            `rule` of the sweep.
        located: whether it was sought between the samples; if not, it is the extreme of them.
    """

    owner: str
    quantity: str
    unit: str
    greatest: float
    greatest_at: Array
    least: float
    least_at: Array
    determined: bool
    located: bool

    @property
    def acts(self) -> bool:
        """Whether it is ever different from zero."""
        return bool(self.greatest or self.least)

    @property
    def size(self) -> float:
        """Greatest absolute value."""
        return max(abs(self.greatest), abs(self.least))


class Quantity(NamedTuple):
    """Something that is sought: whose and which it is, its unit, and how a sweep tells it."""

    owner: str
    name: str
    unit: str
    determined: bool
    values: Callable[[Sweep], Array]


def extremes(sweep: Sweep) -> list[Extreme]:
    """Return the extremes of the wrenches and efforts of a sweep, joint by joint.

    Those of a sweep with one drive at constant rates and loads are sought between its samples, at
    positions that are solved for it; of others they are the extremes of the samples.

    Args:
        sweep: over one dimension.

    Raises:
        CardanError: as `Scene.sweep`, between the samples.
    """
    quantities = list(quantities_of(sweep))
    samples = np.stack([item.values(sweep) for item in quantities])
    floor = _floors(sweep, quantities, samples)
    samples[np.abs(samples) <= floor[:, None]] = 0.0
    between = _Between.of(sweep, quantities, floor)
    if between is None:
        at = np.reshape(sweep.position, (len(sweep), -1))
        ends = (
            [_of_samples(at, values) for values in samples],
            [_of_samples(at, -values) for values in samples],
        )
    else:
        order = between.order
        ends = between.sought(samples[:, order], 1.0), between.sought(samples[:, order], -1.0)
    found = []
    for item, up, down in zip(quantities, *ends, strict=True):
        (greatest, greatest_at), (negative, least_at) = up, down
        is_constant = greatest + negative <= _SAME * max(abs(greatest), abs(negative))
        nowhere = np.zeros((0, greatest_at.shape[1]))
        found.append(
            Extreme(
                item.owner,
                item.name,
                item.unit,
                greatest + 0.0,  # Without the sign of a negative zero.
                nowhere if is_constant else greatest_at,
                greatest + 0.0 if is_constant else 0.0 - negative,
                nowhere if is_constant else least_at,
                item.determined,
                between is not None,
            )
        )
    return found


def fixed_case(sweep: Sweep) -> dict[str, Any] | None:
    """Return with which arguments a sweep with one drive goes on; None if they vary or several do.

    Args:
        sweep: over one dimension.
    """
    if len(sweep.coordinates) != 1 or sweep.free:
        return None
    given: dict[str, Any] = {"speed": sweep.speed, "acceleration": sweep.acceleration}
    given |= {"time": sweep.time, "gravity": np.atleast_2d(sweep.gravity)}
    rates: dict[str, Any] = {}
    for name, values in given.items():
        first = np.reshape(values, (-1, 3) if name == "gravity" else (-1,))
        if np.any(first != first[:1]):
            return None
        rates[name] = first[0]
    held = {name: _single(value) for name, value in sweep.held.items()}
    inertia = {name: _single(value) for name, value in sweep.inertia.items()}
    loads: dict[str, Any] = {}
    for name, load in sweep.loads.items():
        if isinstance(load, Wrench):
            if np.ndim(load.force) > 1 or np.ndim(load.moment) > 1:
                return None
            loads[name] = load
        else:
            loads[name] = _single(load)
    if any(value is None for part in (held, inertia, loads) for value in part.values()):
        return None
    rates |= {"held": held or None, "loads": loads or None, "inertia": inertia or None}
    return rates


def _single(values: object) -> float | None:
    """Return the value that all of them have; None if they differ."""
    every = np.ravel(np.asarray(values, dtype=float))
    return float(every[0]) if np.all(every == every[0]) else None


def quantities_of(sweep: Sweep) -> Iterator[Quantity]:
    """Return what is sought: of wrenches, then of drives, held joints, couplings and elements."""
    for joint in sweep.outputs:
        yield from _of_wrench(sweep, joint)
    units = {name: item.effort_unit for name, item in sweep.mechanism.drivable.items()}
    try:
        count = np.reshape(sweep.drive_effort, (len(sweep), -1)).shape[1]
    except ModelError:  # The outputs leave them out.
        count = 0
    for index, name in enumerate(sweep.coordinates[:count]):

        def driving(at: Sweep, index: int = index) -> Array:
            return np.reshape(at.drive_effort, (len(at), -1))[:, index]

        yield Quantity(name, "drive effort", units[name], True, driving)
    for name in sweep.holding_effort:

        def holding(at: Sweep, name: str = name) -> Array:
            return at.holding_effort[name]

        yield Quantity(name, "holding effort", units[name], True, holding)
    coupling_units = _coupling_units(sweep)
    for name in coupling_units:

        def coupled(at: Sweep, name: str = name) -> Array:
            return at.coupling_moment[name]

        yield Quantity(
            name, "coupling effort", coupling_units[name], sweep.coupling_unique[name], coupled
        )
    for index, element in enumerate(sweep.elements):
        for quantity in element.quantities:
            if quantity.components:
                continue

            def exerted(at: Sweep, index: int = index, field: str = quantity.field) -> Array:
                return np.asarray(getattr(at.element_force[index], field))

            unit = quantity.units or units.get(element.joints[0], "N·m")
            name = element.name or f"elements[{index}]"
            yield Quantity(name, quantity.field, str(unit), True, exerted)


def _coupling_units(sweep: Sweep) -> dict[str, str]:
    """Return couplings and the units of their efforts, as the table of the sweep tells them."""
    names = tuple(sweep.coupling_moment)
    if not names:
        return {}
    return dict(zip(names, sweep.table(motion=False).units["coupling_unit"][1], strict=True))


def _of_wrench(sweep: Sweep, joint: str) -> Iterator[Quantity]:
    """Return what is sought of a joint's wrench: along and across its axis if it has one."""
    wrench = sweep[joint]
    for name in _WITH_AXIS if wrench.has_axis else _WITHOUT:

        def values(at: Sweep, name: str = name) -> Array:
            return values_of(at[joint], name)

        yield Quantity(joint, name, QUANTITIES[name], determined(wrench, name), values)


def _floors(sweep: Sweep, quantities: list[Quantity], samples: Array) -> Array:
    """Return up to which size each quantity is rounding of the greatest wrench."""
    length = sweep.mechanism.characteristic_length
    to_moment = np.array([length if item.unit == "N" else 1.0 for item in quantities])
    sizes = np.max(np.abs(samples) * to_moment[:, None], axis=0, initial=0.0)
    # Where wrenches vanish, what they are sums of is as great as ever, and so is its rounding.
    condition = np.where(np.isfinite(sweep.condition), sweep.condition, 1.0)
    rounding = 8.0 * float(np.finfo(float).eps) * float(np.max(condition * sizes, initial=0.0))
    return np.asarray(max(_ROUNDING * float(np.max(sizes, initial=0.0)), rounding) / to_moment)


def _of_samples(at: Array, values: Array) -> tuple[float, Array]:
    """Return the greatest of values `(N,)`, and at which of the positions `(N, d)` it occurs."""
    greatest = float(np.max(values))
    first = int(np.argmax(values))
    same = np.flatnonzero(values >= greatest - _SAME * abs(greatest))
    apart = [first, *(int(index) for index in same if abs(int(index) - first) > 1)]
    return greatest, at[apart[:_MOST_PLACES]]


class _Golden(NamedTuple):
    """Golden sections: K intervals, two positions within each, and the values there.

    Attributes:
        at: `(4, K)` low end, left, right, high end.
        values: `(4, K)`; NaN at ends that were not computed.
    """

    at: Array
    values: Array


def _vertex(state: _Golden) -> tuple[Array, Array, Array]:
    """Return vertices of parabolas through the best of three points, their values and heights.

    NaN where a value is missing or the parabola has no vertex between the points.
    """
    falls = state.values[1] >= state.values[2]
    at, values = (np.where(falls, part[:3], part[1:]) for part in (state.at, state.values))
    before, after = at[0] - at[1], at[2] - at[1]
    low, high = values[0] - values[1], values[2] - values[1]
    with np.errstate(invalid="ignore", divide="ignore"):
        bend = (low / before - high / after) / (before - after)
        slope = low / before - bend * before
        step = -0.5 * slope / bend
        inside = (bend < 0.0) & (step > before) & (step < after)
        predicted = values[1] + step * (slope + bend * step)
    height = np.where(inside, values[1] - np.minimum(values[0], values[2]), np.nan)
    return np.where(inside, at[1] + step, np.nan), predicted, height


class _Between(Frozen):
    """Seeks extremes between the samples of a sweep with one drive and constant rates and loads."""

    def __init__(
        self,
        scene: Scene,
        case: Mapping[str, Any],
        quantities: list[Quantity],
        floor: Array,
        sweep: Sweep,
    ) -> None:
        position = np.ravel(sweep.position)
        self.order = np.unique(position, return_index=True)[1]
        self._at = position[self.order]
        turns = not sweep.mechanism.drivable[sweep.coordinates[0]].slides
        self._end = _end(self._at) if turns else float(self._at[-1])
        self._is_turn = turns and abs(self._at[-1] - self._at[0] - 2.0 * np.pi) < _SAME
        self._scene, self._case, self._quantities, self._floor = scene, case, quantities, floor
        self._freeze()

    @classmethod
    def of(cls, sweep: Sweep, quantities: list[Quantity], floor: Array) -> _Between | None:
        """Return it for a sweep; None where there is nothing between its samples."""
        case = fixed_case(sweep)
        if case is None or len(np.unique(sweep.position)) < 3:
            return None
        scene = Scene._of(ProblemSolver(sweep.problem))
        return cls(scene, case, quantities, floor, sweep)

    def sought(self, samples: Array, sign: float) -> list[tuple[float, Array]]:
        """Return the greatest of `sign` times each quantity, and where `(n, 1)` it occurs.

        Args:
            samples: `(K, N)` of K quantities in the order of positions.
            sign: 1, or -1 for the least.
        """
        values = sign * samples
        places = [_peaks(item) for item in values]
        rows = np.repeat(np.arange(len(values)), [len(item) for item in places])
        indices = np.concatenate(places)
        low = self._at[np.maximum(indices - 1, 0)]
        steps = np.append(self._at, self._end)
        high = steps[np.minimum(indices + 1, len(steps) - 1)]
        best, where = values[rows, indices], self._at[indices]
        varies = np.ptp(values, axis=1)[rows] > self._floor[rows]
        inside = np.flatnonzero(varies & (high > low))
        if len(inside):
            at, value = self._located(low[inside], high[inside], rows[inside], sign)
            # Of what differs by rounding alone the sample counts: its position is a round number.
            better = value > best[inside] + _EQUAL * np.abs(best[inside])
            best[inside[better]], where[inside[better]] = value[better], at[better]
        found = []
        for row in range(len(values)):
            own = np.flatnonzero(rows == row)
            greatest = float(np.max(best[own]))
            same = own[best[own] >= greatest - _SAME * abs(greatest)]
            spots = np.unique(where[same])
            if self._is_turn and spots[-1] - spots[0] > _TURN:
                spots = spots[:-1]  # The end of a turn is its start.
            found.append((greatest, spots[:, None]))
        return found

    def _located(self, low: Array, high: Array, rows: Array, sign: float) -> tuple[Array, Array]:
        """Return where the quantities of these rows are greatest between two positions each.

        Golden sections narrow the interval; where values then lie on a parabola, its vertex is it.
        """
        state = self._started(low, high, rows, sign)
        for _ in range(_FIRST):
            state = self._narrowed(state, rows, sign)
        vertex, predicted, height = _vertex(state)
        at = np.where(np.isfinite(vertex), vertex, state.at[1])
        value = self._values(at, rows, sign)
        smooth = np.abs(value - predicted) <= _SMOOTH * height
        others = np.flatnonzero(~smooth)
        if len(others):
            rest = _Golden(state.at[:, others], state.values[:, others])
            for _ in range(_STEPS - _FIRST):
                rest = self._narrowed(rest, rows[others], sign)
            best = np.argmax(rest.values[1:3], axis=0) + 1
            own = np.arange(len(others))
            at[others], value[others] = rest.at[best, own], rest.values[best, own]
        return at, value

    def _started(self, low: Array, high: Array, rows: Array, sign: float) -> _Golden:
        left, right = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
        both = self._values(np.concatenate([left, right]), np.tile(rows, 2), sign)
        unknown = np.full(len(rows), np.nan)
        values = np.stack([unknown, *np.split(both, 2), unknown])
        return _Golden(np.stack([low, left, right, high]), values)

    def _narrowed(self, state: _Golden, rows: Array, sign: float) -> _Golden:
        """Return the part of each interval in which the greatest value lies."""
        falls = state.values[1] >= state.values[2]
        kept, of_kept = (np.where(falls, part[:3], part[1:]) for part in (state.at, state.values))
        low, inner, high = kept
        width = high - low
        new = np.where(falls, high - _GOLDEN * width, low + _GOLDEN * width)
        of_new = self._values(new, rows, sign)
        at = np.where(falls, [low, new, inner, high], [low, inner, new, high])
        values = np.where(
            falls,
            [of_kept[0], of_new, of_kept[1], of_kept[2]],
            [of_kept[0], of_kept[1], of_new, of_kept[2]],
        )
        return _Golden(at, values)

    def _values(self, at: Array, rows: Array, sign: float) -> Array:
        """Return `sign` times the quantity of each row at a position of its own."""
        sweep, found = self._scene.sweep(at, **self._case), np.empty(len(at))
        for row in np.unique(rows):
            own = rows == row
            found[own] = self._quantities[row].values(sweep)[own]
        found[np.abs(found) <= self._floor[rows]] = 0.0
        return sign * found


def _end(at: Array) -> float:
    """Return where a range ends: a step after its last angle `(N,)` if that closes a turn."""
    steps, last = np.diff(at), float(at[-1])
    step = float(np.mean(steps))
    turns = (last + step - float(at[0])) / (2.0 * np.pi)
    is_even = bool(np.max(np.abs(steps - step)) < _EVEN * step)
    closes = round(turns) > 0 and abs(turns - round(turns)) * 2.0 * np.pi < _EVEN * step
    return last + step if is_even and closes else last


def _peaks(values: Array) -> Array:
    """Return samples beside which the greatest of values `(N,)` may lie, the greatest first."""
    if np.ptp(values) == 0.0:
        return np.zeros(1, dtype=int)
    before = np.concatenate([[-np.inf], values[:-1]])
    after = np.concatenate([values[1:], [-np.inf]])
    peaks = np.flatnonzero((values >= before) & (values >= after))
    beside = np.stack([before[peaks], after[peaks]])
    gaps = np.where(np.isfinite(beside), values[peaks] - beside, 0.0).sum(axis=0)
    greatest = float(np.max(values))
    reaching = peaks[values[peaks] + _REACH * gaps >= greatest - _SAME * abs(greatest)]
    order = np.argsort(-values[reaching], kind="stable")
    return np.asarray(reaching[order][:_MOST_PLACES])
