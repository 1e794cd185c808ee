"""Critical speeds: where an order meets a natural frequency, or a motion is unstable."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..checks import flag, positives
from ..errors import ArgumentError, VibrationError
from .campbell import Campbell, campbell_of
from .crossings import Crossing, crossings
from .linear_motions import resting
from .motion_search import MotionSearch
from .periodic_grid import amplitudes, orders_of
from .periodic_motion import search_of
from .regions import Region, regions
from .result import Result, frame_of
from .rotating_scene import speeds_of
from .stability import stability
from .whirl import sense_name

if TYPE_CHECKING:
    import pandas

    from ..figures.style import Figure
    from ..scene.scene import Scene

_SPEEDS = 61
"""Speeds between the ends of a range at which modes are found."""
_EXCITES = 1e-9
"""Forcing of an order, as a fraction of the greatest of all, from which on it excites."""
_HIGHEST = 8
"""Highest order that is looked at unless others are asked for."""
_HALF_WIDTHS = 3.0
"""Range around a crossing in which the greatest amplitude is looked for, in half-power widths."""
_WIDEST = 0.5
"""The same at the most, as a fraction of the speed, where an order follows a frequency closely."""
_PLACES, _ROUNDS = 13, 4
"""Speeds at which that range is looked at, and rounds, each some five times as fine as the last."""
_ASIDE = 1e-3
"""Distance from an undamped resonance, as a fraction of the speed, at which motions are small."""
_LEAST_DAMPING = 1e-7
"""Damping ratio below which a resonance counts as undamped: its amplitude has no bound."""


class CriticalSpeed(NamedTuple):
    """One critical speed.

    Attributes:
        speed: of the drive [rad/s]: of the greatest amplitude of the order near the crossing where
            the mode is damped, else of the crossing; of the fastest growth of an instability.
        kind: `resonance`, or that of an instability, see `Floquet`.
        order: cycles per revolution of the drive; NaN for an instability.
        mode: number of the mode, from 1, by ascending frequency at the lowest speed, 0 for an
            instability; its column in `campbell` is one less.
        frequency: of the mode there [rad/s]; NaN for an instability.
        whirl: `forward`, `backward`, `planar`; empty for an instability.
        severity: greatest amplitude that the mode gives a free coordinate at that order [rad or
            m], infinite without damping, 0 where
            the order does not move the mode, NaN where motions near it were not found, as they are
            larger than `within` allows; growth rate of an instability [1/s].
        amplification: amplification factor 1/(2ζ) of the mode; NaN for an instability.
        lower, upper: edges of an instability; speeds of half power of a resonance, to first order
            in its damping ratio [rad/s].
    """

    speed: float
    kind: str
    order: float
    mode: int
    frequency: float
    whirl: str
    severity: float
    amplification: float
    lower: float
    upper: float


@dataclass(frozen=True, eq=False)
class CriticalSpeeds(Result):
    """Critical speeds in a range, ascending; iterate over them, or print their table.

    Attributes:
        scene: its drive at constant speed first.
        low, high: ends of the range [rad/s].
        orders: that were looked at.
        rows: the critical speeds.
        campbell: modes over the range.
    """

    scene: Scene
    low: float
    high: float
    orders: tuple[float, ...]
    rows: tuple[CriticalSpeed, ...]
    campbell: Campbell

    def __iter__(self) -> Any:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def table(self) -> dict[str, Array]:
        """Columns of the table, by the names of `CriticalSpeed`."""
        return {
            name: np.array([getattr(row, name) for row in self.rows])
            for name in CriticalSpeed._fields
        }

    def stored(self) -> dict[str, Any]:
        """Return what `save` writes, of the rows a column for each field."""
        stored = {name: value for name, value in super().stored().items() if name != "rows"}
        return {**stored, **{f"table.{name}": of for name, of in self.table.items()}}

    def to_dataframe(self) -> pandas.DataFrame:
        """Return a row for each critical speed."""
        units = ("rad/s", "", "1/rev", "", "rad/s", "", "rad, m, or 1/s", "1", "rad/s", "rad/s")
        rows = [row._asdict() for row in self.rows]
        return frame_of(rows, dict(zip(CriticalSpeed._fields, units, strict=True)))

    def plot(self) -> Figure:
        """Draw natural frequencies over speed with the orders, and the critical speeds."""
        points = [(row.speed, row.frequency) for row in self.rows if row.kind == "resonance"]
        return self.campbell.plot(self.orders, critical=points or None)

    def __str__(self) -> str:
        lines = [f"critical speeds from {self.low:g} to {self.high:g} rad/s"]
        for row in self.rows:
            if row.kind == "resonance":
                lines.append(
                    f"- {row.speed:.6g} rad/s: order {row.order:g} meets mode {row.mode} "
                    f"({row.whirl}, {row.frequency:.6g} rad/s), amplitude {row.severity:.3g}, "
                    f"Q {row.amplification:.3g}"
                )
            else:
                lines.append(
                    f"- {row.lower:.6g} to {row.upper:.6g} rad/s: {row.kind}, growth "
                    f"{row.severity:.3g}/s"
                )
        if not self.rows:
            lines.append("none")
        return "\n".join(lines)

    __repr__ = __str__


def critical_speeds(
    scene: Scene,
    speed: Any,
    *,
    orders: Any = None,
    drive: str | None = None,
    instabilities: bool = True,
    within: float = 1.0,
) -> CriticalSpeeds:
    """Find the critical speeds of a scene in a range of speed.

    Args:
        scene: see `periodic_motion`.
        speed: the two ends of the range, or speeds at which modes are found `(S,)` [rad/s].
        orders: cycles per revolution of the drive that are looked at, one or several; all up to 8
            that force the free coordinates if None. Orders that the motion does not have, such as
            2.5, have no severity.
        drive: see `periodic_motion`.
        instabilities: whether unstable intervals are looked for.
        within: see `periodic_motion`.

    Raises:
        VibrationError: no periodic motion was found.
        CardanError: see `periodic_motion`.
    """
    speeds, _ = speeds_of(speed)
    if len(speeds) < 2 or np.any(np.diff(speeds) <= 0.0) or speeds[0] * speeds[-1] < 0.0:
        raise ArgumentError("speed: give two or more ascending speeds of one sense")
    if len(speeds) == 2:
        speeds = np.linspace(speeds[0], speeds[1], _SPEEDS)
    instabilities = flag("instabilities", instabilities)
    given = None if orders is None else sorted(set(positives("orders", orders).tolist()))
    search = search_of(scene, drive, within)
    found = campbell_of(search, speeds)
    wanted = _exciting(search, speeds) if given is None else given
    rows = [
        _resonance(search, order, mode, crossing)
        for order in wanted
        for mode in range(found.frequency.shape[1])
        for crossing in crossings(search, found, order, mode)
    ]
    if instabilities:
        known = stability(search, speeds)
        rows += [_unstable(item) for item in regions(search, speeds, known, search.period)]
    return CriticalSpeeds(
        scene=search.rotating.scene,
        low=float(speeds[0]),
        high=float(speeds[-1]),
        orders=tuple(wanted),
        rows=tuple(sorted(rows)),
        campbell=found,
    )


def _exciting(search: MotionSearch, speeds: Array) -> list[float]:
    """Return the orders up to the highest that force the free coordinates.

    Raises:
        VibrationError: there is no motion.
    """
    sizes: dict[float, float] = {}
    for motions in search.primary(speeds[[0, len(speeds) // 2, -1]]):
        efforts = motions.middle.efforts(resting(motions.course))
        forcing = np.max(np.abs(amplitudes(efforts, 1)), axis=(0, 2))
        waves = orders_of(len(forcing), motions.model.period)
        for order, size in zip(waves.tolist(), forcing.tolist(), strict=True):
            sizes[order] = max(size, sizes.get(order, 0.0))
    if not sizes:
        raise VibrationError(next(iter(search.missed.values())))
    greatest = max((size for order, size in sizes.items() if order), default=0.0)
    return [
        order
        for order, size in sorted(sizes.items())
        if 0.0 < order <= _HIGHEST and size > _EXCITES * greatest
    ]


def _resonance(search: MotionSearch, order: float, mode: int, crossing: Crossing) -> CriticalSpeed:
    """Return the critical speed near a crossing."""
    ratio = -crossing.decay / np.hypot(crossing.frequency, crossing.decay)
    speed, severity, half = crossing.speed, np.inf, 0.0
    if ratio > _LEAST_DAMPING:
        # At half power, order and natural frequency are as far apart as the mode decays.
        half = abs(crossing.decay / crossing.slope) if crossing.slope else np.inf
        width = min(_HALF_WIDTHS * half, _WIDEST * abs(speed))
        speed, severity = _peak(search, order, speed, width, crossing.shapes, crossing.mode)
    elif not _is_excited(search, order, crossing):
        severity = 0.0
    return CriticalSpeed(
        speed=float(speed),
        kind="resonance",
        order=order,
        mode=mode + 1,
        frequency=crossing.frequency,
        whirl=sense_name(crossing.whirl),
        severity=float(severity),
        amplification=float(0.5 / ratio) if ratio > _LEAST_DAMPING else np.inf,
        lower=float(speed - half),
        upper=float(speed + half),
    )


def _is_excited(search: MotionSearch, order: float, crossing: Crossing) -> bool:
    """Return whether an order moves a mode without damping, by what it does beside the crossing."""
    beside = crossing.speed * (1.0 + _ASIDE * np.array([-1.0, 1.0]))
    shares = _shares(search, beside, order, crossing.shapes, crossing.mode)
    every = [
        _shares(search, beside, order, crossing.shapes, mode)
        for mode in range(len(crossing.shapes))
    ]
    return not np.all(shares <= _EXCITES * np.max(every, axis=0))


def _peak(
    search: MotionSearch, order: float, middle: float, width: float, shapes: Array, mode: int
) -> tuple[float, float]:
    """Return speed and size of a mode's greatest share in an order within a width of a speed.

    Args:
        search: of the scene.
        order: cycles per revolution.
        middle: speed in the middle of the range [rad/s].
        width: half of the range [rad/s].
        shapes: of all modes `(n, n)`.
        mode: whose share is meant.
    """
    sense, best = np.sign(middle), (middle, 0.0)
    for _ in range(_ROUNDS):
        places = np.linspace(middle - width, middle + width, _PLACES)
        places = places[places * sense > 0.0]
        sizes = _shares(search, places, order, shapes, mode)
        if not np.all(np.isfinite(sizes)):
            return float(middle), np.nan  # The greatest may be among those that were not found.
        top = int(np.argmax(sizes))
        best = float(places[top]), float(sizes[top])
        middle, width = best[0], 2.5 * width / (_PLACES - 1)
    return best


def _shares(search: MotionSearch, speeds: Array, order: float, shapes: Array, mode: int) -> Array:
    """Return the greatest amplitude `(S,)` of a coordinate that a mode has in an order.

    NaN where there is no motion. Arguments as of `_peak`.
    """
    sizes = np.full(len(speeds), np.nan)
    for motions in search.primary(speeds):
        waves = amplitudes(motions.course.q, 1)
        # Where the drive turns back, exp(i order φ) goes the other way in time than modes do.
        waves = np.where(motions.course.speed[:, None, None] < 0.0, waves.conj(), waves)
        wave = order * motions.model.period / (2.0 * np.pi)
        sizes[motions.index] = 0.0
        if abs(wave - round(wave)) < 1e-9 and round(wave) < waves.shape[1]:
            shares = waves[:, round(wave)] @ np.linalg.pinv(shapes).T
            sizes[motions.index] = np.abs(shares[:, mode]) * np.max(np.abs(shapes[:, mode]))
    return sizes


def _unstable(region: Region) -> CriticalSpeed:
    return CriticalSpeed(
        speed=region.speed,
        kind=region.kind,
        order=np.nan,
        mode=0,
        frequency=np.nan,
        whirl="",
        severity=region.growth,
        amplification=np.nan,
        lower=region.lower,
        upper=region.upper,
    )
