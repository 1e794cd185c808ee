"""Pin map: clearance in the bearings of a universal joint, over speed and bend angle."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from analytic.impact import Start

from ..arrays import Array
from ..checks import mapping, several
from ..errors import ArgumentError
from ..frozen import read_only
from .arguments import damping_ratio_of, scene_of, speed_of, start_of
from .force_source import ForceSource
from .pin_bearings import PinScanner
from .pin_case import pin_case
from .pin_scan import PinScan

if TYPE_CHECKING:
    import pandas

    from ..scene.scene import Scene


@dataclass(frozen=True, eq=False)
class PinMap:
    """Scans of a universal joint over speeds and designs: estimates, no simulation.

    Attributes:
        name: of the joint, or of its cross.
        speed: of the drive `(S,)` [rad/s].
        held: joints to their positions `(D,)`, one for each design [rad or m].
        units: of these positions, `rad` or `m`.
        scans: for each design, a scan at each speed.
    """

    name: str
    speed: Array
    held: Mapping[str, Array]
    units: Mapping[str, str]
    scans: tuple[tuple[PinScan, ...], ...]

    @property
    def peak(self) -> Array:
        """Greatest force of a bearing, of an impact or without play `(D, S)` [N]."""
        return self._of("peak")

    @property
    def rigid_peak(self) -> Array:
        """Greatest force of a bearing without play `(D, S)` [N]."""
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
                "speed": item.speed,
                "rigid_peak": item.rigid_peak,
                "peak": item.peak,
                "impacts_per_turn": item.impacts_per_turn,
                "impact_power": item.impact_power,
                **_worst(item),
                "verdict": item.verdict,
            }
            for index, row in enumerate(self.scans)
            for item in row
        ]

    def to_dataframe(self) -> pandas.DataFrame:
        """Return a row for each design and speed, SI units.

        Columns of a single reversal, such as `tau`, are those of the greatest impact.
        """
        import pandas

        return pandas.DataFrame(self.rows())

    def __iter__(self) -> Iterator[PinScan]:
        """Iterate over all scans, the speeds of a design in turn."""
        return (item for row in self.scans for item in row)

    def __str__(self) -> str:
        lines = [f"clearance in bearings of {self.name}, estimated by theory"]
        for row in self.rows():
            design = ", ".join(f"{name} {row[name]:.4g} {self.units[name]}" for name in self.held)
            text = f"{row['peak']:.4g} N instead of {row['rigid_peak']:.4g} N; {row['verdict']}"
            lines.append(f"- {design}, {row['speed']:g} rad/s: {text}")
        return "\n".join(lines)

    __repr__ = __str__


def map_pins(
    scene: Scene,
    speeds: ArrayLike,
    joint: str,
    *,
    held: Mapping[str, ArrayLike],
    radius: float | Mapping[str, float],
    clearance: float | Mapping[str, float],
    stiffness: float | Mapping[str, float],
    bearings: str | Collection[str] | None = None,
    damping_ratio: float = 0.0,
    start: Start = "release",
    rotor: float | None = None,
) -> PinMap:
    """Estimate what play in pin bearings would do at several speeds and bend angles: theory alone.

    Args:
        scene: see `scan_pins`.
        speeds: of the drive `(S,)` [rad/s].
        joint: see `scan_pins`.
        held: joints that the scene holds, to their positions `(D,)`: a bend angle, or whatever
            else designs differ in. Several joints go through theirs together.
        radius: see `scan_pins`, as all that follows.
        clearance: likewise.
        stiffness: likewise.
        bearings: likewise.
        damping_ratio: likewise.
        start: likewise.
        rotor: likewise.

    Raises:
        ArgumentError: there is no speed or position, lengths differ, or a joint is not held.
        CardanError: as `scan_pins`.
    """
    scene_of(scene)
    every = [speed_of(value) for value in several("speeds", speeds)]
    designs = {
        name: several(f"held[{name!r}]", values) for name, values in mapping("held", held).items()
    }
    counts = {len(values) for values in designs.values()}
    if len(counts) != 1:
        raise ArgumentError("held gives no positions, or joints different numbers of them")
    for name in designs:
        if name not in scene.held:
            raise ArgumentError(f"{name!r} is not held by the scene, and cannot take positions")
    impact = {"damping_ratio": damping_ratio_of(damping_ratio), "start": start_of(start)}
    given = {"radius": radius, "clearance": clearance, "stiffness": stiffness}
    scans = []
    for index in range(counts.pop()):
        design = scene.replace(held={name: values[index] for name, values in designs.items()})
        source = ForceSource(design)
        case = pin_case(source.problem, joint, given, bearings)
        scanner = PinScanner(design, source, case, rotor)
        scans.append(tuple(scanner.scan(speed, impact) for speed in every))
    kept = {name: read_only(values) for name, values in designs.items()}
    named = scene.mechanism.coordinates.named
    units = {name: "m" if named[name].slides else "rad" for name in designs}
    return PinMap(joint, read_only(np.array(every)), kept, units, tuple(scans))


def _worst(scanned: PinScan) -> dict[str, float]:
    """Return numbers of the greatest impact, NaN where nothing strikes."""
    columns = ("position", "tau", "turn_through", "flown", "deviation", "impact_speed")
    return {name: getattr(scanned.worst, name, float("nan")) for name in columns}
