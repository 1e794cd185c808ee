"""Energy integral: the motion of a conservative mechanism with one free coordinate, by quadrature.

Its speed follows from its position, I φ̇² / 2 = K(φ), so that time is an integral over position:
dt = √(I / 2K) dφ. It is summed on panels that are halved until each is resolved, in ways that are
counted from where the kinetic energy K is least: so no digits are lost where it almost vanishes
beside an unstable equilibrium (a separatrix, on which the motion would take for ever). Elapsed time
grows with the way, so that every time has one place, which is bracketed. A thousand turns cost no
more than one, and energy does not drift.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from ...kit.arrays import EPS, Array
from ...kit.periodic import Fourier
from ...kit.roots import rising
from .continuity import States
from .energy_functions import EnergyFunctions, NotSuitableError

_SCANNED = 1024
"""Positions per period at which potential and energy are compared."""
_NODES = 20
"""Chebyshev nodes of a panel."""
_MOST_PANELS = 4096


class _Anchor(NamedTuple):
    """Where ways are counted from: an end of a swing, or where kinetic energy is least.

    Attributes:
        way: from the start [rad].
        kinetic: energy there; zero at an end [J].
        force: there; zero at a minimum of the kinetic energy [N·m].
        is_end: whether the motion turns back there.
    """

    way: float
    kinetic: float
    force: float
    is_end: bool


def _undecided() -> NotSuitableError:
    return NotSuitableError(
        "the energy is close to what passes a maximum of the potential",
        note="the energy is that of an unstable equilibrium but for rounding, which decides "
        "whether and when the mechanism passes it",
    )


class EnergyIntegral:
    """The motion of the drive as a function of time.

    Attributes:
        period: time of a turn or swing [s]; inf if the mechanism stays where it is.
        swings: whether it swings between two positions.
        reach: half the way of a swing [rad]; inf if there is none.
        doubt: time [s] by which rounding of inertia and force may move what follows, anew in each
            period: beside an unstable equilibrium it decides how long the mechanism stays there.
        fastest: greatest speed [rad/s].
    """

    def __init__(self, functions: EnergyFunctions, position: float, speed: float) -> None:
        """Integrate over a turn or a swing.

        Args:
            functions: of the mechanism.
            position: of the drive at time 0 [rad].
            speed: of the drive at time 0 [rad/s].

        Raises:
            NotSuitableError: a constant torque speeds the drive up without end, or energy is so
                close to what passes a maximum of the potential that rounding decides whether the
                mechanism passes it.
        """
        self._inertia = functions.inertia.shortened(1e-17)
        self._error, force = functions.error, functions.force.coefficients.copy()
        self._scale = float(np.max(np.abs(force)))
        if abs(force[0, 0]) <= self._error * self._scale:
            # Rounding, that would lift one unstable equilibrium above the same a turn before.
            force[0, 0] = 0.0
        self._force = Fourier(force, functions.force.frequency).shortened(1e-17)
        self._work = self._force.integral()
        self._is_pushed = bool(np.any(self._force.coefficients))
        if speed and not (self._is_pushed or np.finfo(float).tiny < EPS * speed * speed < 1e290):
            raise NotSuitableError("squares of the speed are no numbers")
        self._turn = 2.0 * np.pi / functions.inertia.frequency
        slope = self._inertia.derivative()
        rows = [self._inertia.coefficients, slope.coefficients]
        self._inertias = Fourier(np.concatenate(rows), functions.inertia.frequency)
        self._start, self._speed = position, speed
        self._energy = 0.5 * float(self._inertia.at(position)[0]) * speed * speed
        """Kinetic energy at the start."""
        self.swings, self.period, self.reach = False, np.inf, np.inf
        self.doubt = self.fastest = 0.0
        self._zeros = np.zeros(0)
        """Ways at which the force vanishes within a turn."""
        self._lost = self._stays = np.zeros(0)
        push = float(self._force.at(position)[0])
        if speed == 0.0 and abs(push) <= self._error * self._scale:
            bend = float(self._force.derivative().at(position)[0])
            # Nothing says when it leaves an unstable equilibrium, but that it would for ever stay.
            self.doubt = np.inf if bend > self._error * self._scale else 0.0
            return
        none = np.zeros(0)
        found, tops = self._extremes() if self._is_pushed else (none, none)
        self._at_start = _Anchor(0.0, self._energy, self._force_at(0.0), False)
        # Swings end within a turn, and what stands beyond their ends is within another one.
        turns = np.arange(-2.0, 3.0)[:, None]
        ways = (found + turns * self._turn).ravel().tolist()
        energies = self._kinetic_beside(self._at_start, found) if found.size else found
        gained = turns * (float(self._work.slope[0]) * self._turn)
        minima = [
            _Anchor(way, energy, 0.0, False)
            for way, energy in zip(ways, (energies + gained).ravel().tolist(), strict=True)
        ]
        maxima = (tops + turns * self._turn).ravel().tolist()
        ends = self._ends(minima, maxima)
        self.swings = ends is not None
        if ends is None:
            self._refuse_speeding_up()
            anchors = self._of_a_turn(minima)
        else:
            inner = [item for item in minima if ends[0].way < item.way < ends[1].way]
            anchors = [ends[0], *inner, ends[1]]
            self.reach = 0.5 * (ends[1].way - ends[0].way)
        passed = self._judge(minima, anchors)
        harmonics = max(self._inertia.coefficients.shape[1], self._force.coefficients.shape[1])
        # Chebyshev's series resolve a wave with pi nodes or more (Trefethen 2013, section 4).
        width = self._turn * _NODES / (np.pi * harmonics)
        self._elapsed = _Elapsed(self._both_beside, anchors, self._error, width)
        self.period = self._elapsed.total * (2.0 if self.swings else 1.0)
        self.fastest = self._elapsed.fastest
        self._lost, stays = np.array(passed).reshape(-1, 2).T
        self._stays = np.minimum(stays, self.period)
        self.doubt = float(self._lost @ self._stays)

    def _of_a_turn(self, minima: list[_Anchor]) -> list[_Anchor]:
        """Return the anchors of a turn in which the start is."""
        if not minima:
            return [self._at_start, self._at_start._replace(way=self._turn)]
        first = max(index for index, item in enumerate(minima) if item.way <= 0.0)
        return minima[first : first + len(self._zeros) // 2 + 1]

    def _both_beside(self, starts: Array, ways: Array) -> tuple[Array, Array]:
        """Return how much work is done beyond that of a constant force, and inertias."""
        starts = self._start + starts
        bent = self._work.bent(starts, ways)[0] if self._is_pushed else np.zeros(len(ways))
        return bent, self._inertia(starts + ways)[0]

    def _kinetic_beside(self, anchor: _Anchor, ways: Array) -> Array:
        """Return the kinetic energies `(N,)` at ways from an anchor."""
        starts = np.full(len(ways), self._start + anchor.way)
        bent = self._work.bent(starts, ways)[0]
        return np.asarray(anchor.kinetic + anchor.force * ways + bent)

    def _force_at(self, way: float) -> float:
        """Return the force at a way from the start, to all digits beside where it vanishes.

        Sums over harmonics lose them there; so periods of short swings are as exact as others.
        """
        if not self._zeros.size:
            return float(self._force.at(self._start + way)[0])
        distances = way - self._zeros
        distances -= self._turn * np.round(distances / self._turn)
        nearest = int(np.argmin(np.abs(distances)))
        return self._force_beside(float(self._zeros[nearest]), float(distances[nearest]))

    def _force_beside(self, zero: float, way: float) -> float:
        """Return the force at a way from where it vanishes."""
        starts = np.array([self._start + zero])
        return float(self._force.gained(starts, np.array([way]))[0, 0])

    def _extremes(self) -> tuple[Array, Array]:
        """Return ways within a turn at which the kinetic energy is least, and where greatest."""
        count = max(_SCANNED, 4 * self._work.coefficients.shape[1])
        step = self._turn / count
        # Half a period to both sides: ways from the start have most digits beside it.
        indices = np.arange(-(count // 2), count - count // 2)
        forces = self._force.on_grid(self._start, count)[0][indices]
        after = np.append(forces[1:], forces[0])
        changes = np.nonzero((forces < 0.0) != (after < 0.0))[0]
        sense = np.where(forces[changes] < 0.0, 1.0, -1.0)
        low, slope = step * indices[changes], self._force.derivative()

        def force(ways: Array, chosen: Array) -> tuple[Array, Array]:
            positions = self._start + ways
            return sense[chosen] * self._force(positions)[0], sense[chosen] * slope(positions)[0]

        self._zeros = rising(force, low, low + step)
        return self._zeros[sense > 0.0], self._zeros[sense < 0.0]

    def _ends(self, minima: list[_Anchor], maxima: list[float]) -> tuple[_Anchor, _Anchor] | None:
        """Return the ends of the swing, None if the drive turns through."""
        ends = []
        for sign in (-1.0, 1.0):
            if self._energy == 0.0 and sign * self._at_start.force < 0.0:
                ends.append(self._at_start._replace(is_end=True))
                continue
            blocked = [item for item in minima if sign * item.way > 0.0 and item.kinetic < 0.0]
            if not blocked:
                return None
            # It falls from the last place where it is greatest.
            first = min(blocked, key=lambda item: abs(item.way))
            tops = [abs(way) for way in maxima if 0.0 < sign * way < abs(first.way)]
            ends.append(self._end(sign, max(tops, default=0.0), first))
        return ends[0], ends[1]

    def _end(self, sign: float, inside: float, minimum: _Anchor) -> _Anchor:
        """Return where kinetic energy vanishes, from a distance from the start to a minimum."""

        def beside(anchor: _Anchor, sense: float) -> Callable[[Array, Array], tuple[Array, Array]]:
            def rising(distances: Array, chosen: Array) -> tuple[Array, Array]:
                ways = sense * distances
                starts = np.full(len(ways), self._start + anchor.way)
                force = anchor.force + self._force.gained(starts, ways)[0]
                kinetic = self._kinetic_beside(anchor, ways)
                # Kinetic energy falls on the way to the end, and rises from behind it.
                return (
                    (-kinetic, -sense * force)
                    if anchor.kinetic >= 0.0
                    else (kinetic, sense * force)
                )

            return rising

        low, high = np.array([inside]), np.array([abs(minimum.way)])
        way = sign * float(rising(beside(self._at_start, sign), low, high)[0])
        if abs(minimum.way - way) < abs(way):
            # Counted from the start, the end of what hardly turns back has no digits.
            low, high = np.zeros(1), np.array([abs(minimum.way) - inside])
            distance = float(rising(beside(minimum, -sign), low, high)[0])
            way = minimum.way - sign * distance
            return _Anchor(way, 0.0, self._force_beside(minimum.way, -sign * distance), True)
        return _Anchor(way, 0.0, self._force_at(way), True)

    def _refuse_speeding_up(self) -> None:
        """Refuse a constant torque."""
        trend = abs(float(self._work.slope[0]))
        if trend > self._error * max(self._scale, self._energy / self._turn):
            raise NotSuitableError("a constant torque speeds the drive up")

    def _judge(self, minima: list[_Anchor], anchors: list[_Anchor]) -> list[tuple[float, float]]:
        """Return which part of the energy rounding may decide at each place that is passed slowly.

        And how long the motion depends on it there, if it is that slow [s].
        """
        passed: list[tuple[float, float]] = []
        first, last = anchors[0], anchors[-1]
        # Beyond the ends stand the maxima that it does not pass.
        near = [max((m for m in minima if m.way < first.way), key=lambda m: m.way, default=None)]
        near += [min((m for m in minima if m.way > last.way), key=lambda m: m.way, default=None)]
        chosen = [item for item in anchors[:-1] if not item.is_end]
        passes = 2.0 if self.swings else 1.0
        weighed = [(item, passes) for item in chosen]
        weighed += [(item, 1.0) for item in near if item is not None and self.swings]
        slope = self._force.derivative()
        for item, times in weighed:
            position = self._start + item.way
            way = abs(item.way)
            if not self._work.slope[0]:
                # The same a turn before: the nearest of them is known best.
                way = abs((way + 0.5 * self._turn) % self._turn - 0.5 * self._turn)
            known = self._energy + self._scale * min(way, 1.0)
            lost = self._error * known / abs(item.kinetic) if item.kinetic else np.inf
            if lost >= 1.0:
                raise _undecided()
            bend = float(slope.at(position)[0])
            if bend > 0.0:
                rate = np.sqrt(bend / float(self._inertia.at(position)[0]))
                passed.append((times * lost, 1.0 / rate))
        return passed

    def late(self, times: Array) -> Array:
        """Return by how much what happens at times `(N,)` may be early or late [s].

        Every period is off by the same part of it, so that this grows with their number.
        """
        stays = np.minimum(self._stays[:, None], times)
        return np.asarray(self._error * times + self._lost @ stays * (1.0 + times / self.period))

    def at(self, times: Array) -> States:
        """Return the motion of the drive at times `(N,)` [s], each `(N,)`.

        Raises:
            AccuracyError: a position was not found.
        """
        if not np.isfinite(self.period):
            rest = np.zeros_like(times)
            return States(rest + self._start, rest, rest)
        # Backwards, the motion is the one forwards at times before the start.
        sign = -1.0 if self._speed < 0.0 else 1.0
        turns, left = np.divmod(self._elapsed.begun + sign * times, self.period)
        half = self._elapsed.total
        returns = left > half
        ways, speed = self._elapsed.inverted(np.where(returns, 2.0 * half - left, left))
        speed = np.where(returns, -sign, sign) * speed
        position = self._start + ways
        inertia, slope = self._inertias(position)
        push = self._force(position)[0] - 0.5 * slope * speed**2
        if not self.swings:
            position = position + self._turn * turns
        return States(position, speed, push / inertia)


class _Elapsed:
    """Time since the first anchor as a function of the way, and the way as one of time.

    Every way belongs to the anchor that is nearer. Distances from an end are q², as time grows with
    their root there, and q from other anchors. Over q, the pace dt/dq is a Chebyshev series on each
    panel.

    Attributes:
        total: time to the last anchor [s].
        begun: time at the start, way 0 [s].
        fastest: greatest speed [rad/s].
    """

    def __init__(
        self,
        beside: Callable[[Array, Array], tuple[Array, Array]],
        anchors: list[_Anchor],
        error: float,
        width: float,
    ) -> None:
        """Sum time up.

        Args:
            beside: see `EnergyIntegral._both_beside`.
            anchors: in ascending order, the last one where time ends.
            error: of the functions, relative.
            width: about that of the first panels [rad].

        Raises:
            NotSuitableError: the panels become too many.
        """
        self._beside = beside
        half = 0.5 * np.diff([item.way for item in anchors])
        doubled = np.repeat(np.arange(len(anchors)), 2)[1:-1]
        self._anchors = np.array([tuple(anchors[index]) for index in doubled], dtype=float).T
        """Way, kinetic energy, force, and whether it is an end, of the anchor of each piece."""
        self._sense = np.tile([1.0, -1.0], len(half))
        ways, is_end = self._anchors[0], self._anchors[3] > 0.0
        far = np.repeat(half, 2)
        self._reach = np.where(is_end, np.sqrt(far), far)
        pieces, low, high, series = self._resolved(error, np.ceil(far / width).astype(int))
        order = np.lexsort((self._sense[pieces] * low, pieces))
        self._pieces, self._low, self._high = pieces[order], low[order], high[order]
        self._series = series[order]
        self._sums = (
            chebyshev.chebint(self._series, lbnd=-1.0, axis=1)
            * (0.5 * (self._high - self._low))[:, None]
        )
        spent = np.sum(self._sums, axis=1)
        self._times = np.concatenate([[0.0], np.cumsum(spent)])
        self._spent, self.total = spent, float(self._times[-1])
        # Time of a panel and its derivative to the place on it, whose root is sought.
        paces = self._series * (0.5 * (self._high - self._low))[:, None]
        self._both = np.stack([self._sums, np.pad(paces, [(0, 0), (0, 1)])], axis=1)
        # By how much places on it at its ends change with the time, as a fraction of its own.
        signs = np.tile([1.0, -1.0], _NODES)[:_NODES]
        self._leaves = spent / np.sum(paces * signs, axis=1)
        self._arrives = spent / np.sum(paces, axis=1)
        # The start is in the last piece that begins before it.
        begins = np.where(self._sense > 0.0, ways, ways - far)
        piece = max(int(np.searchsorted(begins, 0.0, side="right")) - 1, 0)
        distance = abs(ways[piece])
        self.begun = self._at(piece, float(np.sqrt(distance) if is_end[piece] else distance))

    def _resolved(self, error: float, splits: Array) -> tuple[Array, Array, Array, Array]:
        """Return the pieces of panels, their ends in q, and the series `(M, n)` of their pace.

        Args:
            error: of the functions, relative.
            splits: how many panels each piece is begun with.
        """
        nodes = chebyshev.chebpts1(_NODES)
        to_series = np.linalg.inv(chebyshev.chebvander(nodes, _NODES - 1)).T
        pieces = np.repeat(np.arange(len(splits)), splits)
        places = np.concatenate([np.arange(count) for count in splits.tolist()])
        # As fractions of the reach, so that neighbours end at the same place.
        low = self._reach[pieces] * (places / splits[pieces])
        high = self._reach[pieces] * ((places + 1) / splits[pieces])
        done: list[tuple[Array, Array, Array, Array]] = []
        spent, count, self.fastest = 0.0, 0, 0.0
        while pieces.size:
            q = 0.5 * (low + high)[:, None] + 0.5 * (high - low)[:, None] * nodes
            paces = self._paces(np.repeat(pieces, _NODES), q.ravel()).reshape(q.shape)
            series = np.einsum("mj,jk->mk", paces, to_series)
            size = np.max(np.abs(series), axis=1)
            # The last fifth tells whether a panel is resolved.
            tail = np.max(np.abs(series[:, -(_NODES // 5) :]), axis=1)
            width = high - low
            whole = spent + float(np.sum(width * series[:, 0]))
            # What adds less than rounding to the whole time needs no digits of its own.
            fine = (tail <= 2.0 * error * size) | (tail * width <= 0.02 * error * whole)
            done.append((pieces[fine], low[fine], high[fine], series[fine]))
            spent += float(np.sum((width * series[:, 0])[fine]))
            count += len(pieces)
            if count > _MOST_PANELS:
                raise _undecided()
            pieces, low, high = pieces[~fine], low[~fine], high[~fine]
            middle = 0.5 * (low + high)
            pieces = np.concatenate([pieces, pieces])
            low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
        found = [np.concatenate(parts) for parts in zip(*done, strict=True)]
        return found[0], found[1], found[2], found[3]

    def _paces(self, pieces: Array, q: Array) -> Array:
        """Return times per q `(N,)` on pieces."""
        way, kinetic, force, is_end = self._anchors[:, pieces]
        distances, slopes = np.where(is_end, q * q, q), np.where(is_end, 2.0 * q, 1.0)
        ways = self._sense[pieces] * distances
        bent, inertia = self._beside(way, ways)
        kinetic = kinetic + force * ways + bent
        if np.min(kinetic) <= 0.0 or np.min(inertia) <= 0.0:
            raise _undecided()
        paces = np.sqrt(0.5 * inertia / kinetic) * slopes
        self.fastest = max(self.fastest, float(np.max(slopes / paces)))
        return np.asarray(paces)

    def _at(self, piece: int, q: float) -> float:
        """Return the time at a place of a piece."""
        own = np.nonzero(self._pieces == piece)[0]
        inside = own[(self._low[own] <= q) & (q <= self._high[own])]
        index = int(inside[0] if inside.size else own[np.argmax(self._high[own])])
        low, high = self._low[index], self._high[index]
        place = np.clip((2.0 * q - low - high) / (high - low), -1.0, 1.0)
        spent = float(chebyshev.chebval(place, self._sums[index]))
        if self._sense[piece] < 0.0:
            spent = self._spent[index] - spent
        return float(self._times[index] + spent)

    def inverted(self, times: Array) -> tuple[Array, Array]:
        """Return ways and speeds `(N,)` at times from 0 to the total.

        Raises:
            AccuracyError: one was not found.
        """
        panels = np.clip(
            np.searchsorted(self._times, times, side="right") - 1, 0, len(self._pieces) - 1
        )
        spent = np.clip(times - self._times[panels], 0.0, self._spent[panels])
        pieces = self._pieces[panels]
        sense = self._sense[pieces]
        spent = np.where(sense > 0.0, spent, self._spent[panels] - spent)
        both, whole = self._both[panels], self._spent[panels]

        def missing(places: Array, chosen: Array) -> tuple[Array, Array]:
            own = both if len(chosen) == len(both) else both[chosen]
            found = np.einsum("nck,nk->cn", own, chebyshev.chebvander(places, _NODES))
            return found[0] - spent[chosen], found[1]

        ends = np.ones(len(times))
        # The cubic polynomial that begins and ends as the place does.
        share = spent / whole
        left, bend = 1.0 - share, 2.0 * share * (1.0 - share)
        first = 2.0 * share - 1.0 + bend * (share - left)
        first += 0.5 * bend * (left * self._leaves[panels] - share * self._arrives[panels])
        places = rising(
            missing,
            -ends,
            ends,
            first=np.minimum(np.maximum(first, -1.0), 1.0),
            least=0.5 * EPS,
            none=0.5 * EPS * self._times[panels + 1],
        )
        half = 0.5 * (self._high - self._low)[panels]
        pace = np.einsum("nk,nk->n", self._series[panels], chebyshev.chebvander(places, _NODES - 1))
        q = self._low[panels] + half * (1.0 + places)
        way, _, _, is_end = self._anchors[:, pieces]
        distances = np.where(is_end, q * q, q)
        return way + sense * distances, np.where(is_end, 2.0 * q, 1.0) / pace
