"""Resonance: where an order meets a mode, and what the mode does there, along its branch.

Crossings are looked for in the modes about coordinates at rest, which are smooth functions of the
speed and cost next to nothing, so that a lattice of speeds can be fine. About a periodic motion,
which changes modes a little, a crossing is then found close to that one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...errors import VibrationError
from ..model.periodic_grid import amplitudes
from ..motions.continuation import Branch, Fold, Point
from ..motions.search import WIDEST, MotionSearch
from ..motions.stability import stays
from .campbell import Campbell, campbell_of, followed, resting_campbell

_RATIO = 1.02
"""Of two speeds of the lattice that follow each other."""
_SLOW = 1e-3
"""Speed, as a fraction of the lowest natural frequency, at which modes are numbered."""
_ALIKE = 1e-6
"""Relative difference of two frequencies that are one at rest."""
_CLOSE = 0.05
"""Distance of a crossing about a motion from that about rest, as a fraction of the speed, from
which on the motion is no small change."""
_BESIDE = 1e-4
"""Distance of two speeds between which slopes are taken, as a fraction of the speed."""
_MET = 1e-10
"""Gap between order and frequency, as a fraction of it, at which they meet."""
_STEPS = 8
_EXCITES = 1e-9
"""Share of a mode, as a fraction of the greatest of all modes at its order, from which on the order
moves it; there must be more than rounding of the whole motion."""
_ROUNDING = 1e-12
_HALF_WIDTHS = 3.0
"""Range around a crossing in which the greatest amplitude is looked for, in half-power widths."""
_ASIDE = 1e-3
"""Distance from an undamped resonance, as a fraction of the speed, at which motions are small."""
_LEAST_DAMPING = 1e-7
"""Damping ratio below which a resonance counts as undamped: its amplitude has no bound."""
_LEADS = 0.99
"""Share of a mode, as a fraction of the greatest of all modes at its order, from which on a peak is
that mode's own."""
_NONE_BESIDE = "no small motion was found on one of its sides, from which to follow it"


class Crossing(NamedTuple):
    """A speed at which an order meets a mode's frequency.

    Attributes:
        speed: of the drive [rad/s].
        slope: by how much order times speed grows faster than the frequency, per rad/s.
        frequency, decay: of the mode there [rad/s, 1/s].
        shapes: of all modes `(n, n)`, a column for each.
        values: their eigenvalues `(n,)` [1/s].
        mode: its column there.
        whirl: its sense, see `Campbell.whirl`.
    """

    speed: float
    slope: float
    frequency: float
    decay: float
    shapes: Array
    values: Array
    mode: int
    whirl: float


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
    rows = np.nonzero(np.all(np.isfinite(found.frequency), axis=1))[0]
    if not rows.size:
        return found
    row = int(rows[np.argmin(np.abs(found.speed[rows]))])
    frequency, whirl = found.frequency[row], np.round(found.whirl[row], 6)
    scale = _ALIKE * max(float(np.max(frequency)), 1e-300)
    return found.renumbered(np.lexsort((whirl, np.round(frequency / scale))))


def _numbered_alike(found: Campbell, modes: Campbell) -> Campbell:
    """Return a diagram with the numbers that its modes have in another one."""
    own, others = (
        np.nonzero(np.all(np.isfinite(item.frequency), axis=1))[0] for item in (found, modes)
    )
    if not own.size or not others.size:
        return found
    gaps = np.abs(found.speed[own][:, None] - modes.speed[others])
    at, near = np.unravel_index(int(np.argmin(gaps)), gaps.shape)
    row, of = int(own[at]), int(others[near])
    order = followed(modes.shape[of], _value(modes, of), found.shape[row], _value(found, row))
    return found.renumbered(order)


def crossings(search: MotionSearch, found: Campbell, order: float, mode: int) -> list[Crossing]:
    """Return where an order meets a mode about rest, ascending.

    Args:
        search: of the scene.
        found: its modes about rest at ascending speeds.
        order: cycles per revolution.
        mode: its column.
    """

    def modes_at(speeds: Array) -> Campbell:
        return resting_campbell(search, speeds)

    begun = [_interpolated(found, mode, *place) for place in between(found, order, mode)]
    return [
        _refined(modes_at, item, order, _interval(found.speed, item.speed)) or item
        for item in begun
    ]


def crossing_about_motion(search: MotionSearch, order: float, rest: Crossing) -> Crossing:
    """Return a crossing about the periodic motions close to one about rest; that one if none is."""

    def modes_at(speeds: Array) -> Campbell:
        return campbell_of(search, speeds)

    low, high = sorted(rest.speed * (1.0 + _CLOSE * np.array([-1.0, 1.0])))
    found = _refined(modes_at, rest, order, (low, high))
    return found if found is not None and low < found.speed < high else rest


def between(found: Campbell, order: float, mode: int) -> list[tuple[float, float]]:
    """Return where an order meets a mode's frequency, interpolated, with the slopes of the gap."""
    # Speeds without a motion lie at undamped resonances: their neighbours tell where.
    is_there = np.isfinite(found.frequency[:, mode])
    speed = found.speed[is_there]
    gap = order * np.abs(speed) - found.frequency[is_there, mode]
    # A crossing at one of the speeds belongs to the interval that begins there, or to the last.
    is_met = (gap[:-1] == 0.0) | (gap[:-1] * gap[1:] < 0.0)
    is_met[-1:] |= gap[-1:] == 0.0
    places = np.nonzero(is_met)[0]
    slopes = np.diff(gap)[places] / np.diff(speed)[places]
    at = speed[places] - gap[places] / np.where(slopes == 0.0, 1.0, slopes)
    return list(zip(at.tolist(), slopes.tolist(), strict=True))


def _refined(
    modes_at: Callable[[Array], Campbell],
    begin: Crossing,
    order: float,
    ends: tuple[float, float],
) -> Crossing | None:
    """Return the crossing near another one, between two speeds; None without modes there."""
    at, slope = begin.speed, begin.slope
    for _ in range(_STEPS):
        beside = np.sort(at * (1.0 + _BESIDE * np.array([-1.0, 0.0, 1.0])))
        try:
            here = modes_at(beside)
        except VibrationError:
            return None
        if not np.all(np.isfinite(here.frequency)):
            return None
        columns = followed(begin.shapes, begin.values, here.shape[1], _value(here, 1))
        column = int(columns[begin.mode])
        gap = order * np.abs(beside) - here.frequency[:, column]
        slope = float((gap[2] - gap[0]) / (beside[2] - beside[0]))
        if abs(gap[1]) <= _MET * order * abs(at) or slope == 0.0:
            break
        at = min(max(at - float(gap[1]) / slope, ends[0]), ends[1])
    return Crossing(
        speed=at,
        slope=slope,
        frequency=float(here.frequency[1, column]),
        decay=float(here.decay[1, column]),
        shapes=here.shape[1],
        values=_value(here, 1),
        mode=column,
        whirl=float(here.whirl[1, column]),
    )


def _interpolated(found: Campbell, mode: int, at: float, slope: float) -> Crossing:
    """Return a crossing by the modes of the diagram beside it."""
    is_there, row = np.isfinite(found.frequency[:, mode]), _nearest(found, mode, at)
    frequency, decay = (
        float(np.interp(at, found.speed[is_there], values[is_there, mode]))
        for values in (found.frequency, found.decay)
    )
    shapes, whirl = found.shape[row], float(found.whirl[row, mode])
    return Crossing(at, slope, frequency, decay, shapes, _value(found, row), mode, whirl)


def _nearest(found: Campbell, mode: int, at: float) -> int:
    """Return the row of a diagram, with a motion, that is next to a speed."""
    is_there = np.isfinite(found.frequency[:, mode])
    return int(np.argmin(np.where(is_there, np.abs(found.speed - at), np.inf)))


def _interval(speeds: Array, at: float) -> tuple[float, float]:
    """Return the speeds on both sides of one, of ascending ones."""
    right = int(np.clip(np.searchsorted(speeds, at), 1, len(speeds) - 1))
    return float(speeds[right - 1]), float(speeds[right])


def _value(found: Campbell, row: int) -> Array:
    """Return the eigenvalues `(n,)` of a row [1/s]."""
    return np.asarray(found.decay[row] + 1j * found.frequency[row])


class Jumps(NamedTuple):
    """Where a resonance that leans over loses its motion; NaN where it does not.

    Attributes:
        rising: speed at which a slowly rising one jumps [rad/s].
        rising_severity: amplitude there, see `Resonance.severity`.
        falling: speed at which a slowly falling one jumps [rad/s].
        falling_severity: amplitude there.
    """

    rising: float = np.nan
    rising_severity: float = np.nan
    falling: float = np.nan
    falling_severity: float = np.nan


class Resonance(NamedTuple):
    """A mode at an order.

    Attributes:
        crossing: of both.
        speed: of the greatest amplitude along the branch; of the crossing where the order does not
            move the mode, where it has no peak of its own, or none that was found [rad/s].
        severity: greatest amplitude of a free coordinate in the mode at the order [rad or m];
            0 where the order does not move it, infinite without damping, NaN if not found.
        damping_ratio: of the mode.
        lower, upper: speeds of half power [rad/s].
        jumps: of a resonance that leans over.
        peak: the motion of the greatest amplitude; None if there is none.
        is_lasting: whether a rig stays at that motion.
        error: of the rough model that was not held against sweeps, as a fraction of the efforts; 0
            where peak and jumps are those of the scene itself.
        reason: why the severity was not found, if it was not.
    """

    crossing: Crossing
    speed: float
    severity: float
    damping_ratio: float
    lower: float
    upper: float
    jumps: Jumps
    peak: Point | None
    is_lasting: bool
    error: float = 0.0
    reason: str = ""


def resonance(search: MotionSearch, order: float, rest: Crossing) -> Resonance:
    """Return what a mode does near where an order meets it.

    Args:
        search: of the scene.
        order: cycles per revolution of the drive.
        rest: the crossing about coordinates at rest.
    """
    ratio = _damping_ratio(rest)
    if ratio <= _LEAST_DAMPING:
        crossing = crossing_about_motion(search, order, rest)
        severity = np.inf if _is_moved(search, order, rest, _ASIDE) else 0.0
        return _plain(crossing, severity)
    if not _is_moved(search, order, rest, 0.0):
        return _plain(crossing_about_motion(search, order, rest), 0.0)
    branch = _branch(search, rest)
    if branch is None or not branch.is_whole:
        return _plain(rest, np.nan, branch.reason if branch is not None else _NONE_BESIDE)
    points, found = branch.points, branch.folds
    crossing = rest if found else crossing_about_motion(search, order, rest)
    if _damping_ratio(crossing) <= _LEAST_DAMPING:
        crossing = rest
    shares = np.array([shares_of(point, order, crossing.shapes) for point in points])
    own = shares[:, crossing.mode]

    def share(point: Point) -> float:
        return float(shares_of(point, order, crossing.shapes)[crossing.mode])

    half, width = _widths(crossing)
    is_inside = np.array([abs(point.speed - crossing.speed) <= width for point in points])
    leads = own >= _LEADS * np.max(shares, axis=1)
    top = _top(own, leads | (is_inside & ~np.any(leads & _peaks(own))))
    if top is None:
        there, _ = search.smallest(np.array([crossing.speed]))
        if there:
            return _plain(crossing, share(Point.of(there[0])))
        return _plain(crossing, np.nan, f"it has no peak of its own, and {search.missed[0]}")
    peak = branch.greatest(top, share)
    jumps = _jumps(found, top, share)
    speed, severity = peak.speed, share(peak)
    lower, upper = speed - half, speed + half
    if not np.isnan(jumps.rising):
        lower, upper = _half_power(branch, found, own, top, share, severity / np.sqrt(2.0))
    return Resonance(
        crossing=crossing,
        speed=speed,
        severity=severity,
        damping_ratio=_damping_ratio(crossing),
        lower=lower,
        upper=upper,
        jumps=jumps,
        peak=peak,
        is_lasting=bool(stays(peak.motions)[0]),
        error=max(item.error for item in (peak, *(fold.point for fold in found))),
    )


def _plain(crossing: Crossing, severity: float, reason: str = "") -> Resonance:
    """Return a resonance without a peak of its own: the critical speed is the crossing itself."""
    ratio, (half, _) = _damping_ratio(crossing), _widths(crossing)
    if ratio <= _LEAST_DAMPING:
        ratio = half = 0.0
    at = crossing.speed
    ends = at - half, at + half
    return Resonance(crossing, at, severity, ratio, *ends, Jumps(), None, True, reason=reason)


def _damping_ratio(crossing: Crossing) -> float:
    return float(-crossing.decay / np.hypot(crossing.frequency, crossing.decay))


def _widths(crossing: Crossing) -> tuple[float, float]:
    """Return half-power width of a crossing, and the width in which its peak is [rad/s]."""
    # At half power, order and natural frequency are as far apart as the mode decays.
    half = abs(crossing.decay / crossing.slope) if crossing.slope else np.inf
    return half, min(_HALF_WIDTHS * half, WIDEST * abs(crossing.speed))


def shares_of(point: Point, order: float, shapes: Array) -> Array:
    """Return the greatest amplitude `(n,)` of a coordinate that each mode has in an order.

    Args:
        point: a motion.
        order: cycles per revolution of the drive.
        shapes: of the modes `(n, n)`.
    """
    waves = amplitudes(point.q)
    wave = order * point.model.period / (2.0 * np.pi)
    if abs(wave - round(wave)) > 1e-9 or round(wave) >= len(waves):
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
            q = motions.course.q[item]
            point = Point(motions.model, float(places[index]), q, 1.0)
            shares = shares_of(point, order, crossing.shapes)
            own[index] = shares[crossing.mode]
            every[index] = max(_EXCITES * np.max(shares), _ROUNDING * np.max(np.abs(q)))
    # Where nothing was found, motions are large.
    return not found or bool(np.any(own > every))


def _branch(search: MotionSearch, crossing: Crossing) -> Branch | None:
    """Return the branch through a crossing; None if no motion was found to begin with."""
    _, width = _widths(crossing)
    sides = np.sign(crossing.speed) * np.array([-1.0, 1.0])
    start, last = (search.end(crossing.speed, side * width) for side in sides.tolist())
    if start is None or last is None:
        return None
    return Branch(search.models, Point.of(start), float(last.course.speed[0]))


def _peaks(sizes: Array) -> Array:
    """Return where sizes exceed those of both neighbours."""
    is_peak = np.zeros(len(sizes), dtype=bool)
    is_peak[1:-1] = (sizes[1:-1] >= sizes[:-2]) & (sizes[1:-1] > sizes[2:])
    return is_peak


def _top(sizes: Array, chosen: Array) -> int | None:
    """Return the greatest of the chosen peaks, None if there is none."""
    (places,) = np.nonzero(_peaks(sizes) & chosen)
    return int(places[np.argmax(sizes[places])]) if places.size else None


def _jumps(folds: list[Fold], top: int, share: Callable[[Point], float]) -> Jumps:
    """Return the pair of folds that is nearest to a peak."""
    pairs = list(zip(folds[::2], folds[1::2], strict=False))
    if not pairs:
        return Jumps()
    found: dict[str, float] = {}
    for fold in min(pairs, key=lambda pair: min(abs(fold.place - top) for fold in pair)):
        speed = fold.point.speed
        name = "rising" if fold.sense * speed > 0.0 else "falling"
        found |= {name: speed, f"{name}_severity": share(fold.point)}
    return Jumps(**found)


def _half_power(
    branch: Branch,
    folds: list[Fold],
    sizes: Array,
    top: int,
    share: Callable[[Point], float],
    level: float,
) -> tuple[float, float]:
    """Return least and greatest speed of the stretch about a peak that is above a level."""
    from scipy.optimize import brentq

    points = branch.points
    speeds = [fold.point.speed for fold in folds if share(fold.point) >= level]
    for sense in (-1, 1):
        at = top
        while 0 < at < len(points) - 1 and sizes[at] > level:
            speeds.append(points[at].speed)
            at += sense
        before, after = points[at - sense], points[at]
        if sizes[at] > level or (at - sense == top and sizes[top] <= level):
            speeds.append(after.speed)
            continue

        def excess(part: float, before: Point = before, after: Point = after) -> float:
            found = branch.between(before, after, part)
            return share(found or before) - level

        part = float(brentq(excess, 0.0, 1.0, xtol=1e-8))
        speeds.append((branch.between(before, after, part) or after).speed)
    return min(speeds), max(speeds)
