"""Critical speeds: where an order meets a natural frequency, or a motion is unstable."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..checks import flag
from ..errors import ArgumentError, VibrationError
from .campbell import Campbell, campbell_of
from .linear_motions import resting
from .motion_search import MotionSearch
from .periodic_grid import amplitudes
from .periodic_motion import limit
from .regions import Region, regions
from .result import Result, frame_of
from .rotating_scene import orders_of, rotating_scene, speeds_of
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
_PLACES, _ROUNDS = 13, 4
_LEAST_DAMPING = 1e-7
"""Damping ratio below which a resonance counts as undamped: its amplitude has no bound."""


class CriticalSpeed(NamedTuple):
    """One critical speed.

    Attributes:
        speed: of the drive [rad/s]: of the greatest amplitude of the order near the crossing where
            the mode is damped, else of the crossing; of the fastest growth of an instability.
        kind: `resonance`, or that of an instability, see `Floquet`.
        order: cycles per revolution of the drive; NaN for an instability.
        mode: number of the mode at the lowest speed, -1 for an instability.
        frequency: of the mode there [rad/s]; NaN for an instability.
        whirl: `forward`, `backward`, `planar`; empty for an instability.
        severity: greatest amplitude that the mode gives a free coordinate at that order [rad or
            m], infinite without damping, NaN where motions near it were not found, as they are
            larger than `within` allows; growth rate of an instability [1/s].
        amplification: amplification factor 1/(2ζ) of the mode; NaN for an instability.
        lower, upper: edges of an instability; speeds of half power of a resonance [rad/s].
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
        """Return what `save` writes."""
        return {
            **super().stored(),
            **{f"table.{name}": of for name, of in self.table.items()},
            **{f"campbell.{name}": of for name, of in self.campbell.stored().items()},
        }

    def to_dataframe(self) -> pandas.DataFrame:
        """Return a row for each critical speed."""
        units = ("rad/s", "", "1/rev", "", "rad/s", "", "rad, m, or 1/s", "1", "rad/s", "rad/s")
        rows = [row._asdict() for row in self.rows]
        return frame_of(rows, dict(zip(CriticalSpeed._fields, units, strict=True)))

    def plot(self) -> Figure:
        """Draw natural frequencies over speed with the orders, and the critical speeds."""
        from ..figures.critical_speeds import campbell

        points = [(row.speed, row.frequency) for row in self.rows if row.kind == "resonance"]
        return campbell(
            self.campbell.speed,
            self.campbell.frequency,
            orders=self.orders,
            whirl=self.campbell.whirl,
            critical=np.array(points).reshape(-1, 2) if points else None,
        )

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
        orders: cycles per revolution of the drive that are looked at; all up to 8 that force the
            free coordinates if None.
        drive: see `periodic_motion`.
        within: see `periodic_motion`.
        instabilities: whether unstable intervals are looked for.

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
    wanted = None if orders is None else orders_of(orders)
    search = MotionSearch(rotating_scene(scene, drive), limit("within", within))
    found = campbell_of(search, speeds)
    if wanted is None:
        wanted = _exciting(search, speeds)
    rows = [
        _resonance(search, found, order, mode, *crossing)
        for order in wanted
        for mode in range(found.frequency.shape[1])
        for crossing in _crossings(found, order, mode)
    ]
    if instabilities:
        known = stability(search, speeds)
        rows += [_unstable(item) for item in regions(search, speeds, known, search.period)]
    return CriticalSpeeds(
        scene=search.rotating.scene,
        low=float(speeds[0]),
        high=float(speeds[-1]),
        orders=wanted,
        rows=tuple(sorted(rows)),
        campbell=found,
    )


def _exciting(search: MotionSearch, speeds: Array) -> tuple[float, ...]:
    """Return the orders up to the highest that force the free coordinates.

    Raises:
        VibrationError: there is no motion.
    """
    sizes: dict[float, float] = {}
    for motions in search.primary(speeds[[0, len(speeds) // 2, -1]]):
        efforts = motions.middle.efforts(resting(motions.course))
        forcing = np.max(np.abs(amplitudes(efforts, 1)), axis=(0, 2))
        orders = 2.0 * np.pi / motions.model.period * np.arange(len(forcing))
        for order, size in zip(orders.tolist(), forcing.tolist(), strict=True):
            sizes[order] = max(size, sizes.get(order, 0.0))
    if not sizes:
        raise VibrationError(next(iter(search.missed.values())))
    greatest = max((size for order, size in sizes.items() if order), default=0.0)
    return tuple(
        order
        for order, size in sorted(sizes.items())
        if 0.0 < order <= _HIGHEST and size > _EXCITES * greatest
    )


def _crossings(found: Campbell, order: float, mode: int) -> list[tuple[float, float]]:
    """Return where an order meets a mode's frequency, between the speeds of the modes.

    Returns:
        speeds, each with how fast order and mode part there [rad/s per rad/s].
    """
    # Speeds without a motion lie at undamped resonances: their neighbours tell where.
    is_there = np.isfinite(found.frequency[:, mode])
    speed = found.speed[is_there]
    gap = order * np.abs(speed) - found.frequency[is_there, mode]
    meets = (gap[1:] * gap[:-1] < 0.0) | (gap[:-1] == 0.0)
    meets[-1:] |= gap[-1:] == 0.0
    places = np.nonzero(meets)[0]
    rise = np.diff(gap)[places]
    shares = np.where(gap[places] == 0.0, 0.0, -gap[places] / np.where(rise == 0.0, 1.0, rise))
    step = np.diff(speed)[places]
    return list(zip((speed[places] + shares * step).tolist(), np.abs(rise / step), strict=True))


def _resonance(
    search: MotionSearch, found: Campbell, order: float, mode: int, crossing: float, pace: float
) -> CriticalSpeed:
    """Return the critical speed near a crossing, at which order and mode part at a pace."""
    is_there = np.isfinite(found.frequency[:, mode])
    near = np.column_stack([found.frequency[:, mode], found.decay[:, mode]])[is_there]
    row = int(np.argmin(np.where(is_there, np.abs(found.speed - crossing), np.inf)))
    known = found.speed[is_there]
    frequency, decay = (float(np.interp(crossing, known, column)) for column in near.T)
    ratio = -decay / np.hypot(frequency, decay)
    speed, severity, half = crossing, np.inf, 0.0
    if ratio > _LEAST_DAMPING:
        # Gyroscopic modes run along with the order, which then stays near them for longer.
        half = min(-decay / max(pace, 1e-300), abs(crossing))
        speed, severity = _peak(
            search, order, crossing, _HALF_WIDTHS * half, found.shape[row], mode
        )
    return CriticalSpeed(
        speed=float(speed),
        kind="resonance",
        order=order,
        mode=mode,
        frequency=frequency,
        whirl=sense_name(float(found.whirl[row, mode])),
        severity=float(severity),
        amplification=float(0.5 / ratio) if ratio > _LEAST_DAMPING else np.inf,
        lower=float(speed - half),
        upper=float(speed + half),
    )


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
        mode=-1,
        frequency=np.nan,
        whirl="",
        severity=region.growth,
        amplification=np.nan,
        lower=region.lower,
        upper=region.upper,
    )
