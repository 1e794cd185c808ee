"""Scan maps: what clearance in a joint would do, over speeds and designs."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from cardan_dyn.analytic.impact import Start

from ...core.problem.arguments import held_designs
from ...core.results.result import Result
from ...core.results.table import Table
from ...kit.arrays import Array
from ...kit.checks import several, text
from ...kit.errors import ArgumentError
from ...kit.frozen import read_only
from ...kit.time_left import Task
from .arguments import Lengths, Stiffnesses, scene_of, speed_of
from .row_tables import variable
from .scan_results import JointScan
from .scanning import Scanner

if TYPE_CHECKING:
    from ...scene.scene import Scene


@dataclass(frozen=True, eq=False)
class ScanMap(Result):
    """Scans of a joint over speeds and designs, no simulation.

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
        """Greatest force of a bearing of all that is known `(D, S)` [N], see `JointScan.peak`."""
        return self._of("peak")

    @property
    def least(self) -> Array:
        """Lower end of the interval in which it lies, NaN if none is known `(D, S)` [N]."""
        return self._of("least")

    @property
    def rigid_peak(self) -> Array:
        """Greatest force of a bearing without clearance `(D, S)` [N]."""
        return self._of("rigid_peak")

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

    def table(self) -> Table:
        """Return numbers by design and speed, SI units.

        Those of a single reversal, such as `tau`, are of that with the greatest peak, NaN where
        there is none.
        """
        both = "design", "speed"
        variables = [
            variable(name, values, "design", told=(self.units[name], "position"), given=True)
            for name, values in self.held.items()
        ]
        variables.append(variable("speed", self.speed, "speed", given=True))
        numbers = "rigid_peak", "peak", "peak_position", "least", "greatest", "impacts_per_turn"
        variables += [variable(name, self._of(name), *both) for name in (*numbers, "impact_power")]
        for name in ("position", "tau", "turn_through", "flown", "deviation", "impact_speed"):
            worst = [[getattr(item.worst, name, np.nan) for item in row] for row in self.scans]
            variables.append(variable(name, np.array(worst, dtype=float), *both))
        verdicts = np.array([[item.verdict for item in row] for row in self.scans])
        variables.append(variable("verdict", verdicts, *both))
        sizes = {"design": len(self.scans), "speed": len(self.speed)}
        return Table(variables, sizes, attributes={"joint": self.name})

    def __iter__(self) -> Iterator[JointScan]:
        """Iterate over all scans, the speeds of a design in turn."""
        return (item for row in self.scans for item in row)

    def __str__(self) -> str:
        lines = [f"clearance in {self.name}"]
        for index, row in enumerate(self.scans):
            held = {name: f"{values[index]:.4g}" for name, values in self.held.items()}
            design = ", ".join(f"{name} {at} {self.units[name]}" for name, at in held.items())
            for speed, item in zip(self.speed.tolist(), row, strict=True):
                lines.append(f"- {design}, {speed:g} rad/s: {item.summary}")
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
    designs = held_designs(scene.held, held)
    if not designs:
        raise ArgumentError("held gives no positions")
    scans: list[tuple[JointScan, ...]] = []
    rows = list(zip(*designs.values(), strict=True))
    with Task("scans", len(rows)) as task:
        for row in rows:
            design = scene.replace(held=dict(zip(designs, row, strict=True)))
            scanner = Scanner(
                design, name, bearings, clearance, stiffness, radius, damping_ratio, start, rotor
            )
            scans.append(tuple(scanner.scan(value)[name] for value in every))
            task.tell(len(scans))
    kept = {key: read_only(values) for key, values in designs.items()}
    units = {key: scene.mechanism.drivable[key].unit for key in designs}
    return ScanMap(name, read_only(np.array(every)), kept, units, tuple(scans))
