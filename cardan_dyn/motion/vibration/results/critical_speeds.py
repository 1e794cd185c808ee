"""Critical speeds: where an order meets a natural frequency, or a motion is unstable."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement, product
from typing import TYPE_CHECKING, Any

import numpy as np

from ....core.results.plot import Plot
from ....core.results.table import Table
from ....kit.arrays import NOTHING, Array
from ....kit.checks import flag, positives
from ....kit.errors import ArgumentError
from ....kit.periodic import MOST_NODES, amplitudes, orders_of, resampled
from ....kit.time_left import Task
from ..model.rotating_scene import speeds_of
from ..motions.continuation import Point
from ..motions.regions import Region, StabilityOverSpeed, regions
from ..motions.search import MotionSearch
from ..motions.stability import NONE, stability
from .campbell import Campbell
from .periodic_motion import search_of
from .resonance import (
    KNOWN,
    OPEN,
    CriticalSpeed,
    Resonance,
    crossings,
    lattice,
    met,
    numbered_campbell,
    resonance,
)
from .result import VibrationResult

if TYPE_CHECKING:
    from ....figures.style import Figure
    from ....scene.scene import Scene

_SPEEDS = 61
"""Speeds between the ends of a range at which the diagram's modes are found."""
_ASIDE = 0.1
"""Distance from an end of the range, as a fraction of it, from which resonances lean into it."""
_MULTIPLES = 12
"""Multiples of the coefficients' frequency up to which narrow instabilities are looked for."""
_SURVIVED = 0.35
"""Swing of a rotation [rad], some 20°, from which on hardly any shaft or support survives."""
_HIGHEST = 8
"""Highest order that is looked at unless others are asked for."""


class CriticalSpeedsPlot(Plot):
    """Draws critical speeds in the diagram of Campbell."""

    def __call__(self, *columns: Any, **options: Any) -> Figure:
        """Draw natural frequencies over speed with the orders, and the critical speeds.

        Args:
            columns: of the table instead, see `Plot`.
            options: of `Campbell.plot`; the orders are those that were looked at.

        Raises:
            ArgumentError: as `Campbell.plot`.
        """
        if columns:
            return super().__call__(*columns, **options)
        found = self._result
        points = [(row.speed, row.frequency) for row in found.rows if row.kind == "resonance"]
        drawn: Figure = found.campbell.plot(
            **{"orders": found.orders, "critical": points or None, **options}
        )
        return drawn


@dataclass(frozen=True, eq=False)
class CriticalSpeeds(VibrationResult):
    """Critical speeds in a range, ascending; iterate over them, or print their table.

    Attributes:
        scene: whose drive turns at constant speed.
        low, high: ends of the range [rad/s].
        orders: that were looked at.
        rows: the critical speeds.
        campbell: modes over the range.
        remarks: what to know besides: motions beyond the limits of joints, or of a size that hardly
            any shaft survives, instabilities that go on beyond the range, and what cannot have been
            seen.
    """

    scene: Scene
    low: float
    high: float
    orders: tuple[float, ...]
    rows: tuple[CriticalSpeed, ...]
    campbell: Campbell
    remarks: tuple[str, ...] = ()

    def __iter__(self) -> Any:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def peaks(self, orders: Sequence[float] | None = None) -> dict[str, Array]:
        """Return `(C, 2)` speeds and finite severities of resonances, and of their jumps, by name.

        Args:
            orders: whose resonances are wanted; of all if None.
        """
        names = {KNOWN: "mode alone", OPEN: "mode alone, at least"}
        found: dict[str, list[tuple[float, float]]]
        found = {name: [] for name in (*names.values(), "jump")}
        for row in self.rows:
            if row.kind == "resonance" and (orders is None or row.order in orders):
                if row.outcome in names:
                    found[names[row.outcome]].append((row.speed, row.severity))
                jumps = (row.rising, row.rising_severity), (row.falling, row.falling_severity)
                found["jump"] += jumps
        return {
            name: np.reshape([point for point in points if 0.0 < point[1] < np.inf], (-1, 2))
            for name, points in found.items()
        }

    def _records(self) -> Any:
        """See `VibrationResult._records`."""
        return {"rows": ("table", CriticalSpeed._fields, self.rows)}

    def table(self) -> Table:
        """Return a row for each critical speed."""
        units = (
            *("rad/s", "", "1/rev", "", "rad/s", "", "rad, m, or 1/s", "", "1", "rad/s", "rad/s"),
            *("rad/s", "rad or m", "rad/s", "rad or m"),
        )
        rows = [row._asdict() for row in self.rows]
        return Table.of_rows(rows, dict(zip(CriticalSpeed._fields, units, strict=True)))

    @property
    def plot(self) -> CriticalSpeedsPlot:
        """Figures: `found.plot()`, natural frequencies with the orders, and the critical speeds."""
        return CriticalSpeedsPlot(self)

    def __str__(self) -> str:
        lines = [f"critical speeds from {self.low:g} to {self.high:g} rad/s"]
        for row in self.rows:
            if row.kind == "resonance":
                lines.append(
                    f"- {row.speed:.6g} rad/s: order {row.order:g} meets mode {row.mode} "
                    f"({row.whirl}, {row.frequency:.6g} rad/s), amplitude of the mode "
                    f"alone {row.severity_text}, Q {row.amplification:.3g}"
                )
                if jumps := row.jumps("rad/s"):
                    lines[-1] += f"; {jumps}"
            else:
                lines.append(
                    f"- {row.lower:.6g} to {row.upper:.6g} rad/s: {row.kind}, "
                    f"growth {row.severity_text}/s"
                )
        if not self.rows:
            lines.append("none")
        return "\n".join([*lines, *(f"({remark})" for remark in self.remarks)])

    __repr__ = __str__


def critical_speeds(
    scene: Scene,
    speed: Any,
    *,
    orders: Any = None,
    instabilities: bool = True,
    max_amplitude: float = 1.0,
) -> CriticalSpeeds:
    """Find the critical speeds of a scene in a range of speed.

    Args:
        scene: see `periodic_motion`.
        speed: the two ends of the range, or speeds at which modes are found `(S,)` [rad/s].
            Resonances that reach into it are listed, if order and mode meet no farther beyond an
            end than a tenth of it.
        orders: cycles per revolution of the drive that are looked at, one or several; all up to 8
            that force the free coordinates if None. Orders that the motion does not have, such as
            2.5, have no severity.
        instabilities: whether unstable intervals are looked for.
        max_amplitude: see `periodic_motion`.

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
    search = search_of(scene, max_amplitude)
    low, high = float(speeds[0]), float(speeds[-1])
    unstable: list[Region] = []
    unseen, missed = 0.0, np.zeros(0)
    with Task("critical speeds", 4) as task:
        found, modes = numbered_campbell(search, speeds, _ASIDE)
        task.tell(1)
        wanted = _exciting(search, modes) if given is None else given
        resonances = _resonances(search, modes, wanted, low, high)
        if instabilities:
            task.tell(2)
            places, unseen = _places(modes, speeds, search.model.period)
            over = StabilityOverSpeed(search, speeds, stability(search, speeds))
            known = over.at(places)
            missed = places[known.kind == NONE]
            task.tell(3)
            unstable = regions(over, places, known)
    rows = [item.row for item in resonances] + [_unstable(item) for item in unstable]
    return CriticalSpeeds(
        scene=search.rotating.scene,
        low=low,
        high=high,
        orders=tuple(wanted),
        rows=tuple(sorted(rows)),
        campbell=found,
        remarks=(
            *_remarks(search.rotating.scene, resonances, unstable, unseen, (low, high)),
            *_missed(missed),
        ),
    )


def _exciting(search: MotionSearch, modes: Campbell) -> list[float]:
    """Return the orders up to the highest that force the free coordinates.

    Args:
        search: of the scene.
        modes: about rest: what forces at a speed is weighed where it may meet one of them.
    """
    swings = modes.frequency[modes.frequency > 0.0]
    places = np.abs(modes.speed)
    if swings.size:
        places = np.array([np.min(swings) / _HIGHEST, np.min(swings), np.max(swings)])
    found = search.resting(np.unique(np.sign(modes.speed[-1]) * places))
    if not found:
        return []
    sizes = np.max(np.abs(amplitudes(found[0].equation.efforts, 1)), axis=(0, 2))
    orders = orders_of(len(sizes), found[0].model.period)
    forces = sizes > NOTHING * np.max(sizes[1:])
    return list(orders[forces & (orders > 0.0) & (orders <= _HIGHEST)].tolist())


def _resonances(
    search: MotionSearch, modes: Campbell, orders: list[float], low: float, high: float
) -> list[Resonance]:
    """Return the resonances that lie between two speeds."""
    found = []
    waves = list(product(orders, range(modes.frequency.shape[1])))
    with Task("resonances", len(waves)) as task:
        for done, (order, mode) in enumerate(waves):
            task.tell(done)
            for crossing in crossings(search, modes, order, mode):
                # One beyond an end may lean into the range.
                if not (low - _ASIDE * abs(low) <= crossing.speed <= high + _ASIDE * abs(high)):
                    continue
                item = resonance(search, order, mode, crossing)
                row = item.row
                places = np.array([item.crossing.speed, row.speed, row.lower, row.upper])
                if np.nanmin(places) <= high and np.nanmax(places) >= low:
                    found.append(item)
    return found


def _places(modes: Campbell, speeds: Array, period: float) -> tuple[Array, float]:
    """Return speeds at which stability is looked at, and below which size it is not.

    Disturbances may grow where two natural frequencies, or twice the same, add up to a multiple of
    the frequency of the coefficients, or differ by it.

    Args:
        modes: about rest.
        speeds: asked for.
        period: of the coefficients [rad].
    """
    low, high = float(speeds[0]), float(speeds[-1])
    size, frequency = np.abs(modes.speed), modes.frequency
    wave = 2.0 * np.pi / period
    every = [speeds]
    count = frequency.shape[1]
    for first, second in combinations_with_replacement(range(count), 2):
        for sense in (1.0, -1.0) if first != second else (1.0,):
            sums = np.abs(frequency[:, first] + sense * frequency[:, second])
            for multiple in range(1, _MULTIPLES + 1):
                found = met(modes.speed, multiple * wave * size - sums)
                every.append(np.array([at for at, _ in found]))
    swings = frequency[frequency > 0.0]
    least = 2.0 * float(np.max(swings)) / (wave * _MULTIPLES) if swings.size else 0.0
    rough = lattice(low, high)
    every.append(rough[np.abs(rough) >= least])
    places = np.unique(np.concatenate(every))
    places = places[(places >= low) & (places <= high)]
    keep = np.append(True, np.diff(places) > NOTHING * np.abs(places[1:]))
    return places[keep], least


def _remarks(
    scene: Scene,
    found: list[Resonance],
    regions_found: list[Region],
    unseen: float,
    ends: tuple[float, float],
) -> tuple[str, ...]:
    """Return what a reader of the table should know besides."""
    remarks = []
    for item in found:
        name = f"order {item.row.order:g} at mode {item.row.mode}"
        if item.peak is not None:
            remarks += [f"{name}: {text}" for text in _beyond(scene, item.peak)]
        remarks += [f"{name}: {note}" for note in item.notes]
    for region in regions_found:
        if not region.is_closed:
            beside = zip(("below", "above"), (region.lower, region.upper), ends, strict=True)
            sides = [side for side, edge, end in beside if edge == end]
            where = f"{' and '.join(sides)}, beyond the range" if sides else "to where no motion is"
            remarks.append(
                f"the {region.kind} from {region.lower:.6g} to {region.upper:.6g} rad/s goes on "
                f"{where}"
            )
    slowest = min(abs(end) for end in ends)
    if slowest < unseen * (1.0 - NOTHING):
        remarks.append(
            f"below {unseen:.4g} rad/s ({unseen * 30.0 / np.pi:.4g} 1/min), narrow instabilities "
            f"are not looked for: there modes swing more than {_MULTIPLES / 2:g} times in a period"
        )
    return tuple(dict.fromkeys(remarks))


def _missed(speeds: Array) -> list[str]:
    """Return a remark on speeds at which nothing is known of stability."""
    if not speeds.size:
        return []
    least, most = float(np.min(speeds)), float(np.max(speeds))
    where = f"at {least:.6g}" if least == most else f"at {len(speeds)} speeds from {least:.6g}"
    until = "" if least == most else f" to {most:.6g}"
    return [
        f"no motion was found {where}{until} rad/s, so that whether it is stable is not known: a "
        "greater `max_amplitude` looks farther"
    ]


def _beyond(scene: Scene, peak: Point) -> list[str]:
    """Return by which joints a motion leaves what they allow, or what shafts survive."""
    coordinates = scene.mechanism.drivable
    texts = []
    # Between the nodes of a motion is more than at them.
    course = resampled(peak.q, MOST_NODES)
    for name, q in zip(scene.free, course.T, strict=True):
        swing = float(np.max(np.abs(q - np.mean(q))))
        if not coordinates[name].slides and swing > _SURVIVED:
            texts.append(
                f"{name} swings by {swing:.3g} rad ({np.rad2deg(swing):.3g}°), which hardly any "
                "elastic shaft or support survives"
            )
    for joint in scene.mechanism.description.joints:
        lower, upper = joint.limits.lower, joint.limits.upper
        if joint.name not in scene.free:
            continue
        q = course[:, scene.free.index(joint.name)]
        if np.max(q) > upper or np.min(q) < lower:
            unit = coordinates[joint.name].unit
            texts.append(
                f"{joint.name} moves from {np.min(q):.3g} to {np.max(q):.3g} {unit}, beyond its "
                f"limits {lower:g} to {upper:g}"
            )
    return texts


def _unstable(region: Region) -> CriticalSpeed:
    return CriticalSpeed(
        speed=region.speed,
        kind=region.kind,
        order=np.nan,
        mode=0,
        frequency=np.nan,
        whirl="",
        severity=region.growth,
        outcome=KNOWN if region.is_closed else OPEN,
        amplification=np.nan,
        lower=region.lower,
        upper=region.upper,
    )
