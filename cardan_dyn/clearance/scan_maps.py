"""Scan maps: what clearance in a joint would do, over speeds and designs."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from analytic.impact import Start

from ..arrays import Array
from ..checks import mapping, several, text
from ..errors import ArgumentError
from ..frozen import read_only
from .arguments import scene_of, speed_of
from .joint_arguments import Lengths, Stiffnesses
from .scan_results import JointScan
from .scanning import Scanner

if TYPE_CHECKING:
    import pandas

    from ..scene.scene import Scene


@dataclass(frozen=True, eq=False)
class ScanMap:
    """Scans of a joint over speeds and designs: estimates, no simulation.

    Attributes:
        name: of the joint, or of the link that is a cross.
        speed: of the drive `(S,)` [rad/s].
        held: joints to their positions `(D,)`, one for each design [rad or m].
        units: of these positions, `rad` or `m`.
        scans: for each design, what is said of the joint at each speed.
    """

    name: str
    speed: Array
    held: Mapping[str, Array]
    units: Mapping[str, str]
    scans: tuple[tuple[JointScan, ...], ...]

    @property
    def peak(self) -> Array:
        """Greatest force of a bearing, of an impact or without clearance `(D, S)` [N]."""
        return self._of("peak")

    @property
    def rigid_peak(self) -> Array:
        """Greatest force of a bearing without clearance `(D, S)` [N]."""
        return self._of("rigid_peak")

    @property
    def severity(self) -> Array:
        """Greatest peak of the impacts, 0 where nothing strikes `(D, S)` [N]."""
        return self._of("severity")

    @property
    def impacts(self) -> Array:
        """Impacts in a turn of the drive `(D, S)`."""
        return self._of("impacts_per_turn")

    @property
    def impact_power(self) -> Array:
        """Kinetic energy of all impacts, per time `(D, S)` [W]."""
        return self._of("impact_power")

    def _of(self, name: str) -> Array:
        return np.array([[getattr(item, name) for item in row] for row in self.scans], dtype=float)

    def rows(self) -> list[dict[str, Any]]:
        """Return a row for each design and speed, by column, SI units."""
        return [
            {
                **{name: float(values[index]) for name, values in self.held.items()},
                "speed": float(speed),
                "rigid_peak": item.rigid_peak,
                "peak": item.peak,
                "impacts_per_turn": item.impacts_per_turn,
                "impact_power": item.impact_power,
                **_worst(item),
                "verdict": item.verdict,
            }
            for index, row in enumerate(self.scans)
            for speed, item in zip(self.speed, row, strict=True)
        ]

    def to_dataframe(self) -> pandas.DataFrame:
        """Return a row for each design and speed, SI units.

        Columns of a single reversal, such as `tau`, are those of the greatest impact.
        """
        import pandas

        return pandas.DataFrame(self.rows())

    def __iter__(self) -> Iterator[JointScan]:
        """Iterate over all scans, the speeds of a design in turn."""
        return (item for row in self.scans for item in row)

    def __str__(self) -> str:
        lines = [f"clearance in {self.name}, estimated by theory"]
        for row in self.rows():
            design = ", ".join(f"{name} {row[name]:.4g} {self.units[name]}" for name in self.held)
            numbers = f"{row['peak']:.4g} N instead of {row['rigid_peak']:.4g} N; {row['verdict']}"
            lines.append(f"- {design}, {row['speed']:g} rad/s: {numbers}")
        return "\n".join(lines)

    __repr__ = __str__


def scan_map(
    scene: Scene,
    speed: ArrayLike,
    joint: str,
    *,
    held: Mapping[str, ArrayLike],
    clearance: Lengths,
    stiffness: Stiffnesses,
    radius: Lengths | None = None,
    bearings: str | Collection[str] | None = None,
    damping_ratio: float = 0.0,
    start: Start = "release",
    rotor: float | None = None,
) -> ScanMap:
    """Estimate what clearance in a joint would do at several speeds and designs: theory alone.

    Args:
        scene: see `scan`.
        speed: of the drive, one or `(S,)` [rad/s].
        joint: see `scan`: that is `joints` there.
        held: joints that the scene holds, to their positions, one or `(D,)`: a bend angle, or
            whatever else designs differ in. Several joints go through theirs together.
        clearance: see `scan`, as all that follows.
        stiffness: likewise.
        radius: likewise.
        bearings: likewise.
        damping_ratio: likewise.
        start: likewise.
        rotor: likewise.

    Raises:
        ArgumentError: there is no speed or position, lengths differ, or a joint is not held.
        CardanError: as `scan`.
    """
    scene_of(scene)
    name = text("joint", joint)
    every = [speed_of(value) for value in several("speed", speed)]
    designs = {
        key: several(f"held[{key!r}]", values) for key, values in mapping("held", held).items()
    }
    counts = {len(values) for values in designs.values()}
    if len(counts) != 1:
        raise ArgumentError("held gives no positions, or joints different numbers of them")
    for key in designs:
        if key not in scene.held:
            raise ArgumentError(f"{key!r} is not held by the scene, and cannot take positions")
    scans = []
    for index in range(counts.pop()):
        design = scene.replace(held={key: values[index] for key, values in designs.items()})
        scanner = Scanner(
            design, name, bearings, clearance, stiffness, radius, damping_ratio, start, rotor
        )
        scans.append(tuple(scanner.scan(value)[name] for value in every))
    kept = {key: read_only(values) for key, values in designs.items()}
    named = scene.mechanism.coordinates.named
    units = {key: "m" if named[key].slides else "rad" for key in designs}
    return ScanMap(name, read_only(np.array(every)), kept, units, tuple(scans))


def _worst(scanned: JointScan) -> dict[str, float]:
    """Return numbers of the greatest impact, NaN where nothing strikes."""
    columns = ("position", "tau", "turn_through", "flown", "deviation", "impact_speed")
    return {name: getattr(scanned.worst, name, float("nan")) for name in columns}
