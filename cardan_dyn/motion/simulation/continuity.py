"""Continuity: whether states at times are those of one motion that begins where it was asked to.

Positions are the integrals of speeds over time. So states that belong to a wrong time, to another
assembly mode or to another number of turns are not on the motion that leads to them from the start.
This is judged by the states alone, by Hermite's rules for the times between them, and asks nothing
of how they were found; where they are too far apart for a rule, more of them are looked at.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...kit.arrays import EPS, Array

_SHARE = 0.5
"""Fraction of the difference of two rules by which states of a step method may be off: their steps
are as long as their tolerance allows, and forces that change at once are felt by every rule."""
_LEAST_SIZE = 1e-3
"""Least way of a coordinate, as a fraction of the greatest, that its errors are relative to."""
_MOST_HALVINGS = 30
"""How often times are halved: states that are still off then jump."""
_GAIN = 7.0
"""Halvings of a misfit, as a rule, by one of the time between states..."""
_HALVINGS_AT_ONCE = 3
"""...of which so many are done together where it is that great."""
_MOST_ADDED = 20_000
"""States that are looked at in all, beside the given ones."""
_NEAR, _FAR = 2, 4
"""Neighbouring states of the two rules."""


class States(NamedTuple):
    """Positions `x`, velocities `v` and accelerations `a` of m coordinates `(N, m)` at N times."""

    x: Array
    v: Array
    a: Array

    def over(self, unit: float) -> States:
        """Return the same in another unit of time [s]."""
        return States(self.x, self.v * unit, self.a * unit * unit)

    def at(self, chosen: Array) -> States:
        """Return some of them."""
        return States(*(values[chosen] for values in self))

    def joined(self, more: States, order: Array) -> States:
        """Return these and more, in an order."""
        pairs = zip(self, more, strict=True)
        return States(*(np.concatenate(pair)[order] for pair in pairs))


class Misfit(NamedTuple):
    """How far states are off the motion, as a fraction of the way of a coordinate; and when [s]."""

    size: float
    time: float


class Continuity:
    """One motion, by states at times that are close enough to each other.

    Attributes:
        tolerance: misfit beyond which states are not on the motion.
        worst: misfit of its own states.
    """

    def __init__(
        self,
        look: Callable[[Array], States],
        times: Array,
        start: tuple[Array, Array],
        *,
        tolerance: float,
        is_exact: bool,
        least: float = 0.0,
        period: float = np.inf,
    ) -> None:
        """Follow the motion from its start.

        Args:
            look: returns states at times `(N,)`, in units in which ways can be compared.
            times: ascending from 0 `(N,)`; of a motion that repeats, up to its period.
            start: positions and velocities `(m,)` with which it was to begin.
            tolerance: see the attribute.
            is_exact: whether states are exact, and not those of a method with a tolerance.
            least: way that errors are relative to where a coordinate moves less.
            period: after which velocities come back [s].
        """
        # Squares and higher powers of times are numbers in their own unit alone; by a power of two
        # no digit changes.
        self._unit = unit = float(np.ldexp(1.0, np.frexp(times[-1])[1]))
        self._look: Callable[[Array], States] = lambda inner: look(inner * unit).over(unit)
        self._is_exact, self.tolerance = is_exact, tolerance
        self._period, self._added, self._least_way = period / unit, 0, least
        states, times = look(times).over(unit), times / unit
        self._asked = times
        ways = _sizes(states.x - states.x[0])
        self._sizes = np.maximum(ways, least)
        # However short ways are, what is late is off by as much of them.
        self._fastest = float(np.max(np.abs(states.v) / ways, initial=0.0))
        # Slower ones add up to less than that way.
        self._rates = np.maximum(_sizes(states.v), least / times[-1] if times[-1] else 0.0)
        asked = start[0], start[1] * unit
        begun = [(states.x[0] - asked[0]) / self._sizes, (states.v[0] - asked[1]) / self._rates]
        self.worst = Misfit(_greatest(*begun), 0.0)
        self._least = float(np.max(np.diff(times), initial=0.0)) * 2.0**-_MOST_HALVINGS
        if self.worst.size <= tolerance:
            times, states, self.worst = self._followed(times, states)
        self._known = times, states
        self._way = states.x[-1] - states.x[0]
        """Way of a period."""
        if np.isfinite(period):
            back = (states.v[-1] - states.v[0]) / self._rates
            self.worst = max(self.worst, Misfit(_greatest(back), self._period))
        self.worst = self.worst._replace(time=self.worst.time * unit)

    def _followed(self, times: Array, states: States) -> tuple[Array, States, Misfit]:
        """Return times and states that are close enough to each other, and their worst misfit."""
        while True:
            misfits = self._between(times, states)
            worst = int(np.argmax(misfits)) if misfits.size else -1
            found = Misfit(float(misfits[worst]), float(times[worst + 1])) if misfits.size else None
            off = np.nonzero(misfits > self.tolerance)[0]
            widths = np.diff(times)[off]
            with np.errstate(over="ignore"):
                halvings = np.ceil(np.log2(misfits[off] / self.tolerance) / _GAIN)
            parts = 2 ** np.minimum(halvings, _HALVINGS_AT_ONCE).astype(int)
            more = parts - 1
            self._added += int(np.sum(more))
            if not off.size or np.min(widths) <= self._least or self._added > _MOST_ADDED:
                return times, states, found or Misfit(0.0, 0.0)
            part = np.arange(1, 1 + np.sum(more)) - np.repeat(np.cumsum(more) - more, more)
            middles = np.repeat(times[off], more) + np.repeat(widths / parts, more) * part
            order = np.argsort(np.concatenate([times, middles]), kind="stable")
            times = np.concatenate([times, middles])[order]
            states = states.joined(self._look(middles), order)

    def _between(self, times: Array, states: States) -> Array:
        """Return `(N - 1,)` by how much ways are not the integrals of speeds."""
        if len(times) < _NEAR:
            return np.zeros(0)
        steps = np.diff(times)[:, None]
        way = np.diff(states.x, axis=0)
        near = 0.5 * steps * (states.v[:-1] + states.v[1:])
        near -= steps**2 / 12.0 * np.diff(states.a, axis=0)
        far = _integrals(times, states)
        off = np.fmin(np.abs(way - near), np.abs(way - far))
        off -= self._rounding(times[1:], states.at(np.arange(1, len(times))))
        if not self._is_exact:
            off -= _SHARE * np.nan_to_num(np.abs(near - far))
        # Of halves less is allowed, or any speed would do if they were small enough.
        wide = np.diff(self._asked)[np.searchsorted(self._asked, times[:-1], side="right") - 1]
        return _worst_of_rows(np.maximum(off, 0.0) / self._sizes) * (wide / steps[:, 0])

    def _rounding(self, times: Array, states: States) -> Array:
        """Return what rounding of positions and times `(N,)` leaves open of positions `(N, m)`."""
        return 8.0 * EPS * (np.abs(states.x) + np.abs(states.v) * times[:, None])

    def left_open(self, times: Array, states: States, late: float) -> float:
        """Return what rounding makes of ways, as `worst`, which misfits leave out.

        Args:
            times: `(N,)` [s].
            states: at them.
            late: time by which they may be early or late beside its own rounding [s].
        """
        rounding = self._rounding(times / self._unit, states.over(self._unit)) / self._sizes
        return _greatest(rounding) + late / self._unit * self._fastest

    def misfit(self, times: Array, states: States) -> Misfit:
        """Return the worst misfit of states `(N, m)` at times `(N,)`, and of the motion to them."""
        if not self.worst.size <= self.tolerance:
            return self.worst
        times, states = times / self._unit, states.over(self._unit)
        turns, inside, self._added = np.zeros(len(times)), times, 0
        if np.isfinite(self._period):
            turns, inside = np.divmod(times, self._period)
        inside = np.clip(inside, 0.0, self._known[0][-1])
        folded = states._replace(x=states.x - turns[:, None] * self._way)
        late = States(states.v, states.a, states.a)
        rounding = [
            self._rounding(times, states) / self._sizes,
            self._rounding(times, late) / self._rates,
        ]
        misfits = self._from_neighbours(inside, folded, _worst_of_rows(*rounding))
        worst = int(np.argmax(misfits))
        return max(self.worst, Misfit(float(misfits[worst]), float(times[worst] * self._unit)))

    def _from_neighbours(self, times: Array, states: States, rounding: Array) -> Array:
        """Return `(N,)` how far states are off what the ones before and after them say."""
        misfits = _worst_of_rows(*self._differences(times, states, _NEAR)) - rounding
        bad = np.nonzero(misfits > self.tolerance)[0]
        for _ in range(_MOST_HALVINGS):
            if not bad.size:
                break
            off = self._off_both(times[bad], states.at(bad)) - rounding[bad]
            misfits[bad] = np.minimum(misfits[bad], off)
            bad = bad[misfits[bad] > self.tolerance]
            if not bad.size or not self._is_narrowed(times[bad]):
                break
        return np.maximum(misfits, 0.0)

    def _off_both(self, times: Array, states: States) -> Array:
        """Return `(N,)` how far states are off what fewer and more neighbours say.

        States of a step method between its steps have errors that narrower rules magnify: what
        the rules differ by is not counted, as in `_between`.
        """
        far = self._differences(times, states, _FAR)
        if self._is_exact:
            return _worst_of_rows(*far)
        near = self._differences(times, states, _NEAR)
        off = [
            np.fmin(np.abs(one), np.abs(two)) - _SHARE * np.nan_to_num(np.abs(one - two))
            for one, two in zip(near, far, strict=True)
        ]
        return _worst_of_rows(*(np.maximum(item, 0.0) for item in off))

    def _differences(self, times: Array, states: States, size: int) -> tuple[Array, ...]:
        """Return relative differences `(N, m)` from what neighbours say.

        Of positions, and of speeds: from other speeds or from the slopes of positions.
        """
        known, size = self._known, min(size, len(self._known[0]))
        if size < _NEAR:
            return ((states.x - known[1].x[0]) / self._sizes,)
        index = np.searchsorted(known[0], times, side="right") - size // 2
        nodes, (x, v, a) = known
        first = np.clip(index, 0, len(nodes) - size)
        x, slope = _hermite(nodes, (x, v, 0.5 * a), first, size, times)
        v, _ = _hermite(nodes, (v, a), first, size, times)
        # What positions may be off makes any slope where they are close together.
        gaps = np.diff(nodes)[np.clip(index + size // 2 - 1, 0, len(nodes) - 2)]
        may = (self.tolerance * self._least_way + self._rounding(times, states)) / gaps[:, None]
        slope = np.maximum(np.abs(states.v - slope) - may, 0.0)
        # Close to singular configurations, accelerations are worth less than positions.
        speed = np.minimum(np.abs(states.v - v), slope)
        return (states.x - x) / self._sizes, speed / self._rates

    def _is_narrowed(self, times: Array) -> bool:
        """Look at more states beside times; return whether they are on the motion, and are more."""
        known, states = self._known
        index = np.searchsorted(known, times, side="right") - 1
        index = np.unique(np.clip(index, 0, len(known) - _NEAR))
        widths = known[index + 1] - known[index]
        if np.min(widths) <= self._least or self._added > _MOST_ADDED:
            return False
        middles = known[index] + 0.5 * widths
        self._added += len(middles)
        order = np.argsort(np.concatenate([known, middles]), kind="stable")
        joined = np.concatenate([known, middles])[order]
        more = states.joined(self._look(middles), order)
        joined, more, worst = self._followed(joined, more)
        if worst.size > self.tolerance:
            return False
        self._known = joined, more
        return True


def _greatest(*values: Array) -> float:
    """Return the greatest absolute value; infinite where one is no number."""
    return max(
        float(np.max(np.nan_to_num(np.abs(item), nan=np.inf), initial=0.0)) for item in values
    )


def _worst_of_rows(*values: Array) -> Array:
    """Return `(N,)` the greatest absolute values of rows, infinite where one is no number."""
    each = [np.max(np.nan_to_num(np.abs(item), nan=np.inf), axis=1, initial=0.0) for item in values]
    return np.asarray(np.max(each, axis=0))


def _sizes(values: Array) -> Array:
    """Return the greatest absolute values of columns `(m,)`, none far below the others."""
    sizes = np.max(np.abs(values), axis=0, initial=0.0)
    greatest = float(np.max(sizes, initial=0.0))
    return np.asarray(np.maximum(sizes, _LEAST_SIZE * greatest if greatest > 0.0 else 1.0))


def _integrals(times: Array, states: States) -> Array:
    """Return the integrals `(N - 1, m)` of speeds between times, each by its neighbours as well."""
    count = len(times)
    size = min(_FAR, count)
    first = np.clip(np.arange(count - 1) - (size // 2 - 1), 0, count - size)
    chosen = first[:, None] + np.arange(size)
    spans = times[chosen[:, -1]] - times[chosen[:, 0]]
    places = (times[chosen] - times[:-1, None]) / spans[:, None]
    powers = np.arange(2 * size)
    moments = _powers(np.diff(times) / spans, 2 * size + 1)[:, 1:] / (powers + 1)
    of_values = _powers(places, 2 * size)
    of_slopes = np.zeros_like(of_values)
    of_slopes[:, 1:] = powers[1:, None] * of_values[:, :-1]
    system = np.concatenate([of_values, of_slopes], axis=2)
    try:
        weights = np.linalg.solve(system, moments[:, :, None])[:, :, 0]
    except np.linalg.LinAlgError:
        return np.full((count - 1, states.x.shape[1]), np.nan)
    whole = np.einsum("nk,nkm->nm", weights[:, :size], states.v[chosen])
    whole += spans[:, None] * np.einsum("nk,nkm->nm", weights[:, size:], states.a[chosen])
    return np.asarray(spans[:, None] * whole)


def _powers(values: Array, count: int) -> Array:
    """Return the powers 0, 1, … of values `(N, …)` as `(N, count, …)`."""
    result = np.repeat(values[:, None], count, axis=1)
    result[:, 0] = 1.0
    # Products take a tenth of the time of powers.
    return np.multiply.accumulate(result, axis=1)


def _hermite(
    times: Array, terms: tuple[Array, ...], first: Array, size: int, wanted: Array
) -> tuple[Array, Array]:
    """Return values and slopes `(N, m)` at wanted times, by Hermite's interpolation.

    Newton's form, whose divided differences count each of the times once for each term.

    Args:
        times: `(K,)` ascending.
        terms: of Taylor's series there, the values first, each `(K, m)`.
        first: index of the first of the times that are used `(N,)`.
        size: their number.
        wanted: times `(N,)`.
    """
    chosen, each = first[:, None] + np.arange(size), len(terms)
    nodes = np.repeat((times[chosen] - wanted[:, None]).T, each, axis=0)[:, :, None]
    known = [np.repeat(term[chosen].swapaxes(0, 1), each, axis=0) for term in terms]
    table, differences = known[0], [known[0][0]]
    with np.errstate(divide="ignore", invalid="ignore"):
        for order in range(1, each * size):
            gaps = nodes[order:] - nodes[:-order]
            table = (table[1:] - table[:-1]) / gaps
            if order < each:
                same = np.arange(len(gaps)) % each + order < each
                table[same] = known[order][: len(gaps)][same]
            differences.append(table[0])
    value, slope = np.zeros_like(differences[0]), np.zeros_like(differences[0])
    for difference, node in zip(reversed(differences), nodes[::-1], strict=True):
        slope = value - slope * node
        value = difference - value * node
    return value, slope
