"""Search: the periodic motions of a rotating scene at each of many speeds.

From rest, Newton's method leads to one at most speeds. Where that is not the motion of the linear
equation, or none is found, the branches through the range of speed about it are followed: from its
ends, from each motion that lies on none of them, and from where they cross. What passes a speed is
a motion there.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ....kit.arrays import ROUNDED, Array
from ....kit.periodic import next_size, resampled
from ....kit.time_left import Task
from ..model.modes import WhirlSense, averaged, modes
from ..model.motion_equation import motion_equation
from ..model.rotating_scene import RotatingScene
from .continuation import FORETOLD, Branch, Point, Way
from .harmonic_balance import Motions, found_near, swings
from .linear import linear_motions, resting
from .residuals import efforts_left

_BENT = 3e-3
"""Distance from the linear motion, as a fraction of a motion's size, from which on there may be
others, and that size, in units of the coordinates; modes about places that are nearer whirl alike.
"""
_FAR = 0.2
"""The same from which on there may be others wherever modes about the motion resonate; relative
distance from a forced resonance within which there may be others."""
_NEAREST, _WIDER, WIDEST = 0.1, 1.7, 0.5
"""Distance of the ends from a speed, as a fraction of it: the first, the ratio of the next, and the
last."""
_MOST_BRANCHES = 12
"""Through one range of speed."""


class MotionSearch:
    """Finds periodic motions of one rotating scene; branches are kept.

    Attributes:
        rotating: the scene.
        model: equation of its motions.
        missed: index of speeds without a motion to the reason, of the last search.
    """

    def __init__(self, rotating: RotatingScene, max_amplitude: float = 1.0) -> None:
        self.rotating, self.model = rotating, motion_equation(rotating, max_amplitude)
        self.missed: dict[int, str] = {}
        self._stretches: list[_Stretch] = []
        self._whirl: list[tuple[Array, float, WhirlSense]] = []
        self._rest = rotating.start[1:]

    def primary(self, speed: Array) -> list[Motions]:
        """Return one motion for each speed, that about rest; speeds without one are left out.

        Args:
            speed: `(S,)` [rad/s].
        """
        guess = np.tile(self._rest, (len(speed), self.model.count, 1))
        for rest in self.resting(speed):
            guess[rest.index] = rest.course.q
        return found_near(self.model, speed, guess)

    def every(self, speed: Array) -> list[Motions]:
        """Return all motions that are found at speeds; those without any are in `missed`.

        Args:
            speed: `(S,)` [rad/s].

        Raises:
            AccuracyError: the law of an element has a corner in a motion.
        """
        with Task("motions", 4) as task:
            found = self.primary(speed)
            task.tell(1)
            known = _Known(len(speed), self.rotating.units)
            for motions in found:
                known.begin(motions)
            asked = {index for item in found for index in self._with_others(item).tolist()}
            asked |= {index for index in range(len(speed)) if not known.at[index]}
            if asked and any(item.has_functions for item in self.rotating.scene.elements):
                # Where a law has corners, branches are long to follow, and all in vain.
                for motions in found:
                    efforts_left(motions)
            runs = _runs(speed[sorted(asked)])
            for done, (low, high) in enumerate(runs):
                task.tell(2 + 2 * done / len(runs))
                stretch = self._stretch(low, high)
                (inside,) = np.nonzero((speed >= stretch.low) & (speed <= stretch.high))
                found += stretch.motions(speed, inside, known)
        self.missed = {
            index: f"no periodic motion was found at a speed of {speed[index]:.12g} rad/s within "
            f"{self.model.most:g} rad (or characteristic lengths) of its mean; none is found where "
            "the law of an element has a corner in the motion: round it"
            for index in range(len(speed))
            if not known.at[index]
        }
        return found

    def smallest(self, speed: Array) -> tuple[list[Motions], Array]:
        """Return the smallest motion at each speed, and how many others there are `(S,)`.

        Args:
            speed: `(S,)` [rad/s]; those without a motion are in `missed`.
        """
        every = self.every(speed)
        counts = np.full(len(speed), -1)
        chosen = [np.zeros(len(of.index), dtype=bool) for of in every]
        rank = sorted(
            (size, number, row)
            for number, of in enumerate(every)
            for row, size in enumerate(swings(of.course.q, of.model.units).tolist())
        )
        for _, number, row in rank:
            index = every[number].index[row]
            counts[index] += 1
            chosen[number][row] = not counts[index]
        parts = [of.part(mask) for of, mask in zip(every, chosen, strict=True) if np.any(mask)]
        return parts, np.maximum(counts, 0)

    def towards_end(self, middle: float, width: float) -> list[Motions]:
        """Return motions at speeds ever farther from one, up to one like the linear one.

        Args:
            middle: speed [rad/s].
            width: distance of the first that is looked at, on its side [rad/s].
        """
        found: list[Motions] = []
        most = WIDEST * abs(middle)
        while True:
            width = np.sign(width) * min(abs(width), most)
            found += self.primary(np.array([middle + width]))
            is_straight = found and not self._bends(found[-1], FORETOLD, 0.0)[0]
            if is_straight or abs(width) >= most:
                return found
            width *= _WIDER

    def _with_others(self, motions: Motions) -> Array:
        """Return the indices of motions beside which there may be others."""
        bends = self._bends(motions)
        if not np.any(bends):
            return motions.index[bends]
        part = motions.part(bends)
        # Modes about a motion far from the linear one say little of where others resonate.
        return part.index[_resonates(part) | self._bends(part, _FAR)]

    def _bends(self, motions: Motions, share: float = _BENT, least: float = _BENT) -> Array:
        """Return whether motions differ from the linear ones, or cannot be alone `(S,)`."""
        size = swings(motions.course.q, motions.model.units)
        # Motions come in pairs of opposite signs, beside one of sign +1.
        bends = motions.sign < 0.0
        (large,) = np.nonzero((size > least) & ~bends)
        if large.size:
            part = motions.part(large)
            gap = np.abs(linear_motions(part) - part.course.q) / self.rotating.units
            bends[large] = np.max(gap, axis=(1, 2)) > share * size[large]
        return np.asarray(bends)

    def _stretch(self, low: float, high: float) -> _Stretch:
        """Return the range of speed about others, with the branches of motions beside it."""
        for stretch in self._stretches:
            if stretch.low <= low and high <= stretch.high:
                return stretch
        starts: list[Motions] = []
        ends = []
        for at, sense in ((low, -1.0), (high, 1.0)):
            found = self.towards_end(at, sense * _NEAREST * abs(at))
            starts += found
            ends.append(
                float(found[-1].course.speed[0]) if found else at + sense * WIDEST * abs(at)
            )
        stretch, speed = _Stretch(*ends), np.zeros(len(starts))
        known = _Known(len(starts), self.rotating.units)
        for index, item in enumerate(starts):
            known.begin(replace(item, index=np.array([index])))
            speed[index] = item.course.speed[0]
        # From the ends inwards.
        stretch.motions(speed, np.argsort(-np.abs(speed - 0.5 * (low + high))), known)
        self._stretches.append(stretch)
        return stretch

    def resting(self, speed: Array) -> list[Motions]:
        """Return the places at which mean efforts vanish while the free coordinates rest.

        They are motions of the equation without what forces it, and thus have neither resonances
        nor others beside them. Speeds without such a place within reach are left out.

        Args:
            speed: `(S,)` [rad/s].
        """
        found = resting(self.model, self._rest, speed)
        if found:
            # Where it rests at one speed is near to where it does at others.
            self._rest = np.median(found[0].course.q[:, 0], axis=0)
        return found

    def whirl(self, middle: Array, turns: float) -> WhirlSense:
        """Return what says how modes whirl about a place, or one so near that it hardly differs.

        Args:
            middle: of the free coordinates `(n,)`.
            turns: +1 or -1, in which the drive turns.
        """
        for place, sense, known in self._whirl:
            gap = np.max(np.abs(place - middle) / self.rotating.units)
            if sense == turns and gap <= _BENT:
                return known
        count = next_size(self.model.divisor * self.model.count)
        known = WhirlSense(self.rotating, middle, turns, count)
        self._whirl.append((middle, turns, known))
        return known


class _Known:
    """Motions at S speeds, without repetitions."""

    def __init__(self, count: int, units: Array) -> None:
        self.at: list[list[Point]] = [[] for _ in range(count)]
        self.lonely: list[list[Point]] = [[] for _ in range(count)]
        self._units = units

    def begin(self, motions: Motions) -> None:
        """Keep motions that lie on no branch as yet, one for each speed."""
        for row, index in enumerate(motions.index.tolist()):
            point = Point.of(motions, row)
            self.at[index], self.lonely[index] = [point], [point]

    def passed(self, motions: Motions) -> Array:
        """Return which motions on a branch are new, and keep them."""
        is_new = np.zeros(len(motions.index), dtype=bool)
        for row, index in enumerate(motions.index.tolist()):
            point = Point.of(motions, row)
            is_new[row] = not self.is_passed(index, point, np.sqrt(ROUNDED) * self._units)
            if is_new[row]:
                self.at[index].append(point)
        return is_new

    def is_passed(self, index: int, point: Point, gap: Array) -> bool:
        """Return whether a motion is that of a branch, up to a gap `(n,)`, which then is noted."""
        for known in self.at[index]:
            if point.is_same(known, gap):
                self.lonely[index] = [item for item in self.lonely[index] if item is not known]
                return True
        return False


class _Stretch:
    """Branches through a range of speed."""

    def __init__(self, low: float, high: float) -> None:
        self.low, self.high = low, high
        self._branches: list[Branch] = []

    def motions(self, speed: Array, inside: Array, known: _Known) -> list[Motions]:
        """Return the motions at speeds of given indices that were not known."""
        result, done = [], 0
        while True:
            for branch in self._branches[done:]:
                for motions in self._on(branch, speed, inside, known):
                    is_new = known.passed(motions)
                    if np.any(is_new):
                        result.append(motions.part(is_new))
            done = len(self._branches)
            index = next((index for index in inside.tolist() if known.lonely[index]), None)
            if index is None or done >= _MOST_BRANCHES:
                return result
            self.follow(known.lonely[index].pop())

    def follow(self, point: Point) -> None:
        """Follow the branch through a point, and those that cross it."""
        below, above = self.low < point.speed, point.speed < self.high
        new: list[tuple[Point, bool, Way | None]] = [(point, True, None)] if above else []
        new += [(point, False, None)] if below else []
        while new and len(self._branches) < _MOST_BRANCHES:
            start, is_up, way = new.pop(0)
            if way is not None and self._is_known(start):
                continue
            branch = self._branch(start, is_up, way)
            self._branches.append(branch)
            for place, across in branch.crossed():
                for aside in (across, -across):
                    beside = branch.beside(place, aside)
                    if beside is not None:
                        new.append((beside, True, aside))

    def _branch(self, start: Point, is_up: bool, way: Way | None = None) -> Branch:
        first, last = (self.low, self.high) if is_up else (self.high, self.low)
        return Branch(start, last, first=first, way=way, is_rough=True)

    def _is_known(self, point: Point) -> bool:
        """Return whether a branch passes a point."""
        return any(
            point.is_same(near, FORETOLD * self._swing(point))
            for branch in self._branches
            for near in branch.near(point.speed)
        )

    def _swing(self, point: Point) -> Array:
        """Return how far a motion goes from its mean, as much of each coordinate `(n,)`."""
        units = point.model.units
        return np.asarray(units * np.max(np.abs(point.q - np.mean(point.q, axis=0)) / units))

    def _on(self, branch: Branch, speed: Array, inside: Array, known: _Known) -> list[Motions]:
        """Return the motions in which a branch passes speeds of given indices, but known ones."""
        near = [
            (index, point)
            for index in inside.tolist()
            for point in branch.near(float(speed[index]))
            if not known.is_passed(index, point, FORETOLD * self._swing(point))
        ]
        if not near:
            return []
        count = max(len(point.q) for _, point in near)
        at = np.array([index for index, _ in near])
        q = np.stack([resampled(point.q, count) for _, point in near])
        found = found_near(near[0][1].model, speed[at], q)
        return [replace(motions, index=at[motions.index]) for motions in found]


def _runs(speed: Array) -> list[tuple[float, float]]:
    """Return the ends of runs of speeds that are near to each other."""
    if not speed.size:
        return []
    every = np.sort(speed)
    gaps = np.diff(every) > _NEAREST * np.abs(every[1:])
    firsts, lasts = np.append(True, gaps), np.append(gaps, True)
    return list(zip(every[firsts].tolist(), every[lasts].tolist(), strict=True))


def _resonates(motions: Motions) -> Array:
    """Return whether a natural frequency about motions is near a multiple of theirs `(S,)`."""
    found = modes(*averaged(motions.equation))
    base = np.abs(motions.course.speed) * 2.0 * np.pi / motions.model.period
    ratio = found.frequency / base[:, None]
    order = np.rint(ratio)
    # What is about a motion of sign -1 says little of where others have their resonance.
    window = np.where(motions.sign < 0.0, 1.0, _FAR)[:, None]
    return np.asarray(np.any((order >= 1.0) & (np.abs(ratio - order) <= window * order), axis=1))
