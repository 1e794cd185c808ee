"""Resonance: where an order meets a mode, and what the mode does there, along its branch.

Crossings are looked for in the modes about coordinates at rest, which are smooth functions of the
speed and cost next to nothing, so that a lattice of speeds can be fine. About a periodic motion,
which changes modes a little, a crossing is then found close to that one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property, partial
from itertools import pairwise
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np

from ....kit.arrays import EPS, NOTHING, ROUNDED, Array
from ....kit.errors import VibrationError
from ....kit.periodic import amplitudes
from ..model.modes import clear_senses, sense_name
from ..motions.continuation import Branch, Point, motions_of
from ..motions.linear import at_mean
from ..motions.search import WIDEST, MotionSearch
from ..motions.stability import stays
from .campbell import Campbell, campbell_of, followed, resting_campbell

_RATIO = 1.02
"""Of two speeds of the lattice that follow each other."""
_SLOW = 1e-3
"""Speed, as a fraction of the lowest natural frequency, at which modes are numbered."""
_CLOSE = 0.05
"""Distance of a crossing about a motion from that about rest, as a fraction of the speed, from
which on the motion is no small change."""
_HALF_WIDTHS = 3.0
"""Range around a crossing in which the greatest amplitude is looked for, in half-power widths."""
_ASIDE = 1e-3
"""Distance from an undamped resonance, as a fraction of the speed, at which motions are small."""
KNOWN, UNBOUNDED, OPEN = "known", "unbounded", "open"
"""What is known of a greatest value: itself, that there is none, or that it is no less."""


class Crossing(NamedTuple):
    """A speed at which an order meets a mode's frequency.

    Attributes:
        speed: of the drive [rad/s].
        slope: by how much order times speed grows faster than the frequency, per rad/s.
        values: eigenvalues of all modes there `(n,)` [1/s].
        shapes: of all modes `(n, n)`, a column for each.
        mode: its column there.
        whirl: its sense, see `Campbell.whirl`.
    """

    speed: float
    slope: float
    values: Array
    shapes: Array
    mode: int
    whirl: float

    @property
    def value(self) -> complex:
        """Eigenvalue of the mode [1/s]."""
        return complex(self.values[self.mode])

    @property
    def damping_ratio(self) -> float:
        """That of the mode, 0 where it is what rounding makes of a double eigenvalue."""
        ratio = -self.value.real / abs(self.value)
        return ratio if ratio > np.sqrt(EPS) else 0.0


def lattice(low: float, high: float) -> Array:
    """Return speeds `(S,)` between two, ascending, which are the same whatever the range."""
    first, last = sorted((abs(low), abs(high)))
    ends = np.log([first, last]) / np.log(_RATIO)
    speeds = _RATIO ** np.arange(np.ceil(ends[0]), np.floor(ends[1]) + 1.0)
    return np.unique(np.sign(high) * np.concatenate([[first], speeds, [last]]))


def numbered_campbell(
    search: MotionSearch, speeds: Array, aside: float = 0.0
) -> tuple[Campbell, Campbell]:
    """Return the modes about motions at speeds, and those about rest on the lattice.

    Both have the same numbers: by ascending frequency at next to no speed, backward before forward
    ones. The lattice begins there and goes on beyond the greatest speed.

    Args:
        search: of the scene.
        speeds: `(S,)` ascending, of one sense [rad/s].
        aside: how far beyond, as a fraction of the speed.

    Raises:
        VibrationError: see `campbell_of`.
    """
    found = campbell_of(search, speeds)
    first, last = sorted((abs(float(speeds[0])), abs(float(speeds[-1]))))
    sense = float(np.sign(speeds[-1]))
    begun = resting_campbell(search, sense * np.array([last, first])[:: -int(sense)]).frequency
    swings = begun[begun > 0.0]
    slow = min(first * (1.0 - aside), _SLOW * float(np.min(swings)) if swings.size else first)
    ends = sorted((sense * slow, sense * last * (1.0 + aside)))
    modes = _sorted_at_rest(resting_campbell(search, lattice(*ends)))
    return _numbered_alike(found, modes), modes


def _sorted_at_rest(found: Campbell) -> Campbell:
    """Return modes numbered by ascending frequency at their slowest speed."""
    if not found.there.size:
        return found
    row = int(found.there[np.argmin(np.abs(found.speed[found.there]))])
    frequency = found.frequency[row]
    scale = NOTHING * (float(np.max(frequency)) or 1.0)
    senses = clear_senses(found.whirl[row])
    return found.renumbered(np.lexsort((senses, np.round(frequency / scale))))


def _numbered_alike(found: Campbell, modes: Campbell) -> Campbell:
    """Return a diagram with the numbers that its modes have in another one."""
    own, others = found.there, modes.there
    if not own.size or not others.size:
        return found
    gaps = np.abs(found.speed[own][:, None] - modes.speed[others])
    at, near = np.unravel_index(int(np.argmin(gaps)), gaps.shape)
    return found.renumbered(followed(*modes.at(others[near]), *found.at(own[at])))


def crossings(search: MotionSearch, found: Campbell, order: float, mode: int) -> list[Crossing]:
    """Return where an order meets a mode about rest, ascending.

    Args:
        search: of the scene.
        found: its modes about rest at ascending speeds.
        order: cycles per revolution.
        mode: its column.
    """
    rests = []
    for speed, slope in between(found, order, mode):
        right = int(np.clip(np.searchsorted(found.speed, speed), 1, len(found.speed) - 1))
        row = int(np.nanargmin(np.abs(found.speed - speed) + 0.0 * found.frequency[:, mode]))
        begin = Crossing(speed, slope, *found.at(row), mode, float(found.whirl[row, mode]))
        ends = tuple(found.speed[right - 1 : right + 1].tolist())
        rests.append(_refined(partial(resting_campbell, search), begin, order, *ends) or begin)
    return rests


def crossing_about_motion(search: MotionSearch, order: float, rest: Crossing) -> Crossing:
    """Return a crossing about the periodic motions close to one about rest; that one if none is."""
    low, high = sorted(rest.speed * (1.0 + _CLOSE * np.array([-1.0, 1.0])))
    found = _refined(partial(campbell_of, search), rest, order, low, high)
    return found if found is not None and low < found.speed < high else rest


def between(found: Campbell, order: float, mode: int) -> list[tuple[float, float]]:
    """Return where an order meets a mode's frequency, interpolated, with the slopes of the gap."""
    return met(found.speed, order * np.abs(found.speed) - found.frequency[:, mode])


def met(speed: Array, gap: Array) -> list[tuple[float, float]]:
    """Return where a gap `(S,)` between ascending speeds is none, interpolated, with its slopes."""
    # Speeds without a motion lie at undamped resonances: their neighbours tell where.
    speed, gap = speed[np.isfinite(gap)], gap[np.isfinite(gap)]
    # A crossing at one of the speeds belongs to the interval that begins there, or to the last.
    is_met = (gap[:-1] == 0.0) | (gap[:-1] * gap[1:] < 0.0)
    is_met[-1:] |= gap[-1:] == 0.0
    places = np.nonzero(is_met)[0]
    slopes = np.diff(gap)[places] / np.diff(speed)[places]
    at = speed[places] - gap[places] / np.where(slopes == 0.0, 1.0, slopes)
    return list(zip(at.tolist(), slopes.tolist(), strict=True))


def _refined(
    modes_at: Callable[[Array], Campbell], begin: Crossing, order: float, low: float, high: float
) -> Crossing | None:
    """Return the crossing near another one, between two speeds; None without modes there."""
    at, gap, beside = begin.speed, np.inf, np.sqrt(ROUNDED)
    while True:
        # The speed itself first, and those beside it by which a slope is taken.
        places = at * (1.0 + beside * np.array([0.0, -1.0, 1.0]))
        try:
            here = modes_at(places)
        except VibrationError:
            return None
        if not np.all(np.isfinite(here.frequency)):
            return None
        mode = int(followed(begin.values, begin.shapes, *here.at(0))[begin.mode])
        gaps, before = order * np.abs(places) - here.frequency[:, mode], gap
        gap, slope = float(gaps[0]), float(np.diff(gaps[1:])[0] / (2.0 * beside * at))
        # What shrinks no more is rounding.
        is_met = abs(gap) <= ROUNDED * order * abs(at) or not abs(gap) < 0.5 * abs(before)
        if is_met or slope == 0.0:
            return Crossing(at, slope, *here.at(0), mode, float(here.whirl[0, mode]))
        at = min(max(at - gap / slope, low), high)


class CriticalSpeed(NamedTuple):
    """One critical speed.

    Attributes:
        speed: of the drive [rad/s]: of the greatest amplitude of the order along the branch of
            motions through the crossing, whatever the range; of the crossing itself where there is
            no peak, as where the order does not move the mode; of the fastest growth of an
            instability.
        kind: `resonance`, or that of an instability, see `Floquet`.
        order: cycles per revolution of the drive; NaN for an instability.
        mode: number of the mode, from 1, by ascending frequency at next to no speed, backward
            before forward whirl, 0 for an instability; its column in `campbell` is one less.
        frequency: order times size of the speed [rad/s]; NaN for an instability.
        whirl: `forward`, `backward`, `planar`; empty for an instability.
        severity: greatest amplitude that the mode alone gives a free coordinate at that order
            [rad or m], 0 where the order does not move the mode, NaN where no motion was found; of
            a mode without a peak of its own, at the crossing, as a remark says. `forced_response`
            has what other modes add or take away as well. Growth rate of an instability [1/s].
        outcome: `known`; `unbounded`: the equation is linear and has no damping, so that the
            severity is infinite; `open`: the branch of motions was not followed to its peak, or
            that was not met, as a remark says, or an instability goes on beyond the range, so that
            the severity is the greatest that was found and greater ones may exist.
        amplification: amplification factor 1/(2ζ) of the mode; NaN for an instability.
        lower, upper: edges of an instability; of a resonance, least and greatest speed about the
            peak at which the amplitude along the branch is above half power, 1/√2 of the peak
            [rad/s]. A branch that turns back before has its fold there, as a remark says; NaN where
            there is no peak, or half power was not met.
        rising, falling: where a resonance leans over, speeds at which a motion jumps to another
            one while the speed rises or falls slowly [rad/s]; NaN elsewhere.
        rising_severity, falling_severity: severity right before these jumps.
    """

    speed: float
    kind: str
    order: float
    mode: int
    frequency: float
    whirl: str
    severity: float
    outcome: str
    amplification: float
    lower: float = np.nan
    upper: float = np.nan
    rising: float = np.nan
    rising_severity: float = np.nan
    falling: float = np.nan
    falling_severity: float = np.nan

    @property
    def severity_text(self) -> str:
        """The severity as a text, with what is known of it."""
        if self.outcome == UNBOUNDED:
            return "without bound"
        if np.isnan(self.severity):
            return "not found"
        if not self.severity:
            return "0, not moved"
        return f"{'at least ' if self.outcome == OPEN else ''}{self.severity:.3g}"

    def jumps(self, unit: str, scale: float = 1.0) -> str:
        """Return a text of the jumps, empty if there are none.

        Args:
            unit: of speeds.
            scale: of speeds in that unit, per rad/s.
        """
        if np.isnan(self.rising) or np.isnan(self.falling):
            return ""
        return (
            f"jumps at {scale * self.rising:.6g} {unit} while the speed rises (from "
            f"{self.rising_severity:.3g}), at {scale * self.falling:.6g} {unit} while it falls "
            f"(from {self.falling_severity:.3g})"
        )


class Resonance(NamedTuple):
    """A mode at an order.

    Attributes:
        row: what the table says of it.
        crossing: of both.
        peak: the motion of the severity; None if there is none.
        notes: what is to be known besides.
    """

    row: CriticalSpeed
    crossing: Crossing
    peak: Point | None
    notes: tuple[str, ...]


def resonance(search: MotionSearch, order: float, mode: int, rest: Crossing) -> Resonance:
    """Return what a mode does near where an order meets it.

    Args:
        search: of the scene.
        order: cycles per revolution of the drive.
        mode: its column.
        rest: the crossing about coordinates at rest.
    """

    def told(
        crossing: Crossing, severity: float, outcome: str, *notes: str, **more: Any
    ) -> Resonance:
        """Without a peak, the critical speed is the crossing itself."""
        peak: Point | None = more.pop("peak", None)
        speed = crossing.speed if peak is None else peak.speed
        ratio = crossing.damping_ratio
        row = CriticalSpeed(
            speed=speed,
            kind="resonance",
            order=order,
            mode=mode + 1,
            frequency=order * abs(speed),
            whirl=sense_name(crossing.whirl),
            severity=severity,
            outcome=outcome,
            amplification=0.5 / ratio if ratio else np.inf,
            **more,
        )
        return Resonance(row, crossing, peak, notes)

    is_damped = rest.damping_ratio > 0.0
    if not _is_moved(search, order, rest, 0.0 if is_damped else _ASIDE):
        return told(crossing_about_motion(search, order, rest), 0.0, KNOWN)
    branches = _branches(search, rest)
    if not branches:
        return told(rest, np.nan, OPEN, "no small motion was found beside it, to be followed")
    is_whole, crossing = branches[0].is_whole, rest
    if is_whole and not branches[0].folds:
        about = crossing_about_motion(search, order, rest)
        crossing = about if about.damping_ratio > 0.0 else rest
    found = max(
        (_Stretch(branch, order, crossing) for branch in branches), key=lambda item: item.severity
    )
    if found.peak is None:
        there, _ = search.smallest(np.array([crossing.speed]))
        if not there:
            note = f"it has no peak of its own, and {search.missed[0]}"
            return told(crossing, np.nan, OPEN, note)
        note = "it has no peak of its own: its amplitude is the one at the crossing"
        # Nothing was missed on a branch that is whole.
        return told(crossing, found.share(Point.of(there[0])), KNOWN if is_whole else OPEN, note)
    if not is_whole and not is_damped and _is_linear(found.peak):
        return told(rest, np.inf, UNBOUNDED)
    ends: dict[str, float] = {}
    notes = found.notes(found.peak)
    if is_whole:
        ends, beside = found.half_power(found.peak)
        notes += beside
    else:
        reasons = "; ".join(dict.fromkeys(item.reason for item in branches if item.reason))
        notes += [f"the branch of its motions was not followed to its peak: {reasons}"]
    outcome = KNOWN if is_whole and found.is_met else OPEN
    ends |= found.jumps
    return told(crossing, found.severity, outcome, *notes, peak=found.peak, **ends)


def _width(crossing: Crossing) -> float:
    """Return how far from a crossing the peaks of small motions are at most [rad/s]."""
    # At half power, order and natural frequency are as far apart as the mode decays.
    half = abs(crossing.value.real / crossing.slope) if crossing.slope else np.inf
    return min(_HALF_WIDTHS * half, WIDEST * abs(crossing.speed))


def _is_linear(point: Point) -> bool:
    """Return whether the equation of small changes about a motion is that about rest."""
    (motions,) = motions_of([point])
    powers = abs(point.speed) ** np.array([2.0, 1.0, 0.0])
    here, rest = (
        np.stack([item.mass, item.damping, item.stiffness]) * powers[:, None, None, None, None]
        for item in (motions.equation, motions.model.along(at_mean(motions.course)))
    )
    return bool(np.max(np.abs(here - rest)) <= NOTHING * np.max(np.abs(rest)))


def shares_of(point: Point, order: float, shapes: Array) -> Array:
    """Return the greatest amplitude `(n,)` of a coordinate that each mode has in an order.

    Args:
        point: a motion.
        order: cycles per revolution of the drive.
        shapes: of the modes `(n, n)`.
    """
    waves = amplitudes(point.q)
    wave = order * point.model.period / (2.0 * np.pi)
    if abs(wave - round(wave)) > NOTHING or round(wave) >= len(waves):
        return np.zeros(shapes.shape[1])
    one = waves[round(wave)]
    # Where the drive turns back, exp(i order φ) goes the other way in time than modes do.
    shares = np.linalg.pinv(shapes) @ (one.conj() if point.speed < 0.0 else one)
    return np.asarray(np.abs(shares) * np.max(np.abs(shapes), axis=0))


def _is_moved(search: MotionSearch, order: float, crossing: Crossing, aside: float) -> bool:
    """Return whether an order moves a mode, by motions at a distance from the crossing."""
    places = crossing.speed * (1.0 + np.unique([-aside, aside]))
    own, every = np.zeros(len(places)), np.zeros(len(places))
    found = search.primary(places)
    for motions in found:
        for item, index in enumerate(motions.index.tolist()):
            point = Point.of(motions, item)
            shares = shares_of(point, order, crossing.shapes)
            own[index] = shares[crossing.mode]
            every[index] = max(NOTHING * np.max(shares), ROUNDED * np.max(np.abs(point.q)))
    # Where nothing was found, motions are large.
    return not found or bool(np.any(own > every))


def _branches(search: MotionSearch, crossing: Crossing) -> list[Branch]:
    """Return the branch through a crossing; where it is not whole, those from either side."""
    width = max(_width(crossing), _ASIDE * abs(crossing.speed))
    sides = (np.sign(crossing.speed) * width * np.array([-1.0, 1.0])).tolist()
    ends = [search.towards_end(crossing.speed, side) for side in sides]
    speeds = [
        float(end[-1].course.speed[0]) if end else crossing.speed + side
        for end, side in zip(ends, sides, strict=True)
    ]
    found: list[Branch] = []
    for start, last in zip(ends, speeds[::-1], strict=True):
        if start and not (found and found[0].is_whole):
            found.append(Branch(Point.of(start[-1]), last))
    return found


class _Stretch:
    """A branch about a crossing, with the share that the crossing's mode has in an order.

    Attributes:
        severity: greatest share; -inf where the mode has no peak of its own.
        peak: the motion there, if there is one.
        is_met: whether it is the peak itself, and not the nearest motion that is known.
    """

    def __init__(self, branch: Branch, order: float, crossing: Crossing) -> None:
        self._branch, self._order, self._crossing = branch, order, crossing
        shares = np.array([shares_of(point, order, crossing.shapes) for point in branch.points])
        own = shares[:, crossing.mode]
        speeds = np.array([point.speed for point in branch.points])
        is_peak, leads = _peaks(own), own >= np.max(shares, axis=1)
        is_inside = np.abs(speeds - crossing.speed) <= _width(crossing)
        chosen = leads if np.any(leads & is_peak) else leads | is_inside
        # Of two peaks, the one with the higher point beside it need not be the higher one.
        (places,) = np.nonzero(is_peak & chosen)
        tops = [(at, *branch.greatest(at, self.share)) for at in places.tolist()]
        if not branch.is_whole:
            (places,) = np.nonzero(chosen)
            tops += [(at, branch.points[at], True) for at in places.tolist()]
            tops += [(of.place, of.point, True) for of in branch.folds if chosen[of.place]]
        self._points, self._own = branch.points, own
        self.peak: Point | None
        self.severity, self._top, self.peak, self.is_met = max(
            ((self.share(point), at, point, is_met) for at, point, is_met in tops),
            key=itemgetter(0),
            default=(-np.inf, 0, None, True),
        )

    def share(self, point: Point) -> float:
        """Return what the mode has in a motion."""
        return float(shares_of(point, self._order, self._crossing.shapes)[self._crossing.mode])

    @cached_property
    def jumps(self) -> dict[str, float]:
        """The pair of folds that is nearest to the peak, by the fields of the table."""
        folds = self._branch.folds
        pairs = list(zip(folds[::2], folds[1::2], strict=False))
        found: dict[str, float] = {}
        if not pairs:
            return found
        for fold in min(pairs, key=lambda pair: min(abs(item.place - self._top) for item in pair)):
            speed = fold.point.speed
            name = "rising" if fold.sense * speed > 0.0 else "falling"
            found |= {name: speed, f"{name}_severity": self.share(fold.point)}
        return found

    def notes(self, peak: Point) -> list[str]:
        """Return what is to be known of the motions of the branch.

        Args:
            peak: the greatest of them.
        """
        notes = []
        if not self.is_met:
            notes.append("its peak was not met: its amplitude is that of the nearest motion")
        notes += [
            f"where its branch turns back at about {fold.point.speed:.6g} rad/s was not met: what "
            "is told of it is that of the nearest motion"
            for fold in self._branch.folds
            if not fold.is_met
        ]
        if not _lasts(peak):
            most = self._greatest_lasting()
            more = "" if most is None else f"; of those that a rig stays at, {most:.3g} was found"
            notes.append(f"its greatest amplitude is that of an unstable motion{more}")
        others = [
            f"{fold.point.speed:.6g} rad/s (from {self.share(fold.point):.3g})"
            for fold in self._branch.folds
            if fold.point.speed not in self.jumps.values()
        ]
        if others:
            notes.append(f"its branch turns back at {', '.join(others)} as well")
        return notes

    def _greatest_lasting(self) -> float | None:
        """Return the greatest share of motions that a rig stays at, None without any.

        Folds are the ends of stretches of such motions: those beside which there is one count.
        """
        found = [(share, [at]) for at, share in enumerate(self._own.tolist())]
        found += [
            (self.share(fold.point), [fold.place - 1, fold.place, fold.place + 1])
            for fold in self._branch.folds
        ]
        for share, places in sorted(found, reverse=True):
            if any(_lasts(self._points[at]) for at in places):
                return share
        return None

    def half_power(self, peak: Point) -> tuple[dict[str, float], list[str]]:
        """Return least and greatest speed of the stretch about the peak above half power.

        With what is to be known of them: NaN is an end that the branch does not reach.

        Args:
            peak: the greatest motion.
        """
        folds = {fold.place: fold.point for fold in self._branch.folds}
        points = [folds.get(at, point) for at, point in enumerate(self._points)]
        inside, notes = [peak, folds.get(self._top, peak)], []
        ends = {"lower": np.inf, "upper": -np.inf}
        for way in (points[: self._top][::-1], points[self._top + 1 :]):
            found, is_met = self._above_half_power([peak, *way])
            inside += found
            if not is_met:
                name = "lower" if way[-1].speed < peak.speed else "upper"
                ends[name] = np.nan
                notes.append(
                    f"{name} is not known: its branch was followed to {way[-1].speed:.6g} rad/s, "
                    "and not to half power"
                )
        for point in inside:
            # What is not known stays so.
            ends["lower"] = float(np.minimum(ends["lower"], point.speed))
            ends["upper"] = float(np.maximum(ends["upper"], point.speed))
        notes += [
            f"{name} is where its branch turns back, at {self.share(point):.3g}: the motion jumps "
            "there before it falls to half power"
            for name, end in ends.items()
            for point in folds.values()
            if point.speed == end
        ]
        return ends, notes

    def _above_half_power(self, points: Sequence[Point]) -> tuple[list[Point], bool]:
        """Return points above half power, the last one at it; and whether that was met."""
        level, inside = self.severity / np.sqrt(2.0), []
        for before, after in pairwise(points):
            if self.share(after) > level:
                inside.append(after)
                continue
            found = self._branch.reached(before, after, lambda point: self.share(point) - level)
            return ([*inside, found], True) if found else (inside, False)
        return inside, False


def _lasts(point: Point) -> bool:
    """Return whether a rig stays at a motion."""
    return bool(stays(motions_of([point])[0])[0])


def _peaks(sizes: Array) -> Array:
    """Return where sizes exceed those of both neighbours."""
    is_peak = np.zeros(len(sizes), dtype=bool)
    is_peak[1:-1] = (sizes[1:-1] >= sizes[:-2]) & (sizes[1:-1] > sizes[2:])
    return is_peak
