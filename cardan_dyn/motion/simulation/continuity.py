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

from ...kit.arrays import EPS, NOTHING, Array

_SHARE = 0.5
"""Fraction of the difference of two rules by which states of a step method may be off: their steps
are as long as their tolerance allows, and forces that change at once are felt by every rule."""
MOST_STATES = 20_000
"""States that a motion returns by itself, and as many that are looked at beside given ones."""
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
        self.worst = Misfit(float(_worst_of_rows(*begun)), 0.0)
        # States that are still off so close to each other jump.
        self._least = NOTHING * float(np.max(np.diff(times), initial=0.0))
        if self.worst.size <= tolerance:
            times, states, self.worst = self._followed(times, states)
        self._known = times, states
        self._way = states.x[-1] - states.x[0]
        """Way of a period."""
        if np.isfinite(period):
            back = (states.v[-1] - states.v[0]) / self._rates
            self.worst = max(self.worst, Misfit(float(_worst_of_rows(back)), self._period))
        self.worst = self.worst._replace(time=self.worst.time * unit)

    def _followed(self, times: Array, states: States) -> tuple[Array, States, Misfit]:
        """Return times and states that are close enough to each other, and their worst misfit."""
        while True:
            misfits = self._between(times, states)
            off = np.flatnonzero(misfits > self.tolerance) - 1
            if not off.size or not self._can_halve(times, off):
                worst = int(np.argmax(misfits))
                return times, states, Misfit(float(misfits[worst]), float(times[worst]))
            times, states = self._halved(times, states, off)

    def _can_halve(self, times: Array, index: Array) -> bool:
        """Return whether more states may be looked at behind some times."""
        widths = times[index + 1] - times[index]
        return bool(np.min(widths) > self._least) and self._added <= MOST_STATES

    def _halved(self, times: Array, states: States, index: Array) -> tuple[Array, States]:
        """Return times and states with those in the middle behind some times."""
        middles = times[index] + 0.5 * (times[index + 1] - times[index])
        self._added += len(middles)
        pairs = zip(states, self._look(middles), strict=True)
        joined = (np.insert(known, index + 1, more, axis=0) for known, more in pairs)
        return np.insert(times, index + 1, middles), States(*joined)

    def _between(self, times: Array, states: States) -> Array:
        """Return `(N,)` by how much ways to states are not the integrals of speeds; 0 first."""
        if len(times) < _NEAR:
            return np.zeros(len(times))
        way, steps = np.diff(states.x, axis=0), np.diff(times)
        off = self._off(*(way - _integrals(times, states, size) for size in (_NEAR, _FAR)))
        off -= self._rounding(times[1:], states.at(np.arange(1, len(times))))
        # Of halves less is allowed, or any speed would do if they were small enough.
        wide = np.diff(self._asked)[np.searchsorted(self._asked, times[:-1], side="right") - 1]
        worst = _worst_of_rows(np.maximum(off, 0.0) / self._sizes) * (wide / steps)
        return np.append(0.0, worst)

    def _off(self, *rules: Array) -> Array:
        """Return by how much states are off what all rules say.

        States of a step method between its steps have errors that narrower rules magnify: what
        rules differ by is not counted.
        """
        off = np.fmin.reduce([np.abs(rule) for rule in rules])
        if not self._is_exact:
            off = off - _SHARE * np.nan_to_num(np.abs(rules[0] - rules[-1]))
        return np.maximum(off, 0.0)

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
        return (
            float(np.max(_worst_of_rows(rounding), initial=0.0)) + late / self._unit * self._fastest
        )

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

        def off(chosen: Array, sizes: tuple[int, ...]) -> Array:
            some = times[chosen], states.at(chosen)
            rules = zip(*(self._differences(*some, size) for size in sizes), strict=True)
            return _worst_of_rows(*(self._off(*rule) for rule in rules)) - rounding[chosen]

        misfits = off(np.arange(len(times)), (_NEAR,))
        while (bad := np.flatnonzero(misfits > self.tolerance)).size:
            misfits[bad] = np.minimum(misfits[bad], off(bad, (_NEAR, _FAR)))
            bad = bad[misfits[bad] > self.tolerance]
            if not bad.size or not self._is_narrowed(times[bad]):
                break
        return np.maximum(misfits, 0.0)

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
        ((x,), (slope,)) = _hermite(nodes, (x, v, 0.5 * a), first, size, times[:, None])
        ((v,), _) = _hermite(nodes, (v, a), first, size, times[:, None])
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
        if not self._can_halve(known, index):
            return False
        known, states, worst = self._followed(*self._halved(known, states, index))
        if worst.size > self.tolerance:
            return False
        self._known = known, states
        return True


def _worst_of_rows(*values: Array) -> Array:
    """Return `(N,)` the greatest absolute values of rows, infinite where one is no number."""
    every = np.concatenate(values, axis=-1)
    return np.asarray(np.max(np.nan_to_num(np.abs(every), nan=np.inf), axis=-1, initial=0.0))


def _sizes(values: Array) -> Array:
    """Return the greatest absolute values of columns `(m,)`, none nothing beside the others."""
    sizes = np.max(np.abs(values), axis=0, initial=0.0)
    greatest = float(np.max(sizes, initial=0.0))
    return np.asarray(np.maximum(sizes, NOTHING * greatest if greatest > 0.0 else 1.0))


def _integrals(times: Array, states: States, size: int) -> Array:
    """Return the integrals `(N - 1, m)` of speeds between times, by so many of their neighbours."""
    size = min(size, len(times))
    index = np.arange(len(times) - 1)
    first = np.clip(index - (size // 2 - 1), 0, len(times) - size)
    # As many nodes of Gauss integrate Hermite's polynomials exactly.
    nodes, weights = np.polynomial.legendre.leggauss(size)
    half = 0.5 * np.diff(times)[:, None]
    values, _ = _hermite(
        times, (states.v, states.a), first, size, times[:-1, None] + half * (1.0 + nodes)
    )
    return np.asarray(half * np.einsum("k,knm->nm", weights, values))


def _hermite(
    times: Array, terms: tuple[Array, ...], first: Array, size: int, wanted: Array
) -> tuple[Array, Array]:
    """Return values and slopes `(k, N, m)` at wanted times, by Hermite's interpolation.

    Newton's form, whose divided differences count each of the times once for each term.

    Args:
        times: `(K,)` ascending.
        terms: of Taylor's series there, the values first, each `(K, m)`.
        first: index of the first of the times that are used `(N,)`.
        size: their number.
        wanted: times `(N, k)`.
    """
    chosen, each = first[:, None] + np.arange(size), len(terms)
    nodes = np.repeat((times[chosen] - wanted[:, :1]).T, each, axis=0)[:, :, None]
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
    places = (wanted - wanted[:, :1]).T[:, :, None]
    value = slope = np.zeros((*places.shape[:2], differences[0].shape[1]))
    for difference, node in zip(reversed(differences), nodes[::-1], strict=True):
        slope = value + slope * (places - node)
        value = difference + value * (places - node)
    return value, slope
