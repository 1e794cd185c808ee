"""Readings: what the page of a scene tells beside the picture: its slider, its state, its numbers.

Angles are told in degrees, as people read them; all else in the units of the results, of which the
page makes others, and shorter numbers.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...core.elements.link_loads import Wrench
from ...core.mechanism.joints import Joint
from ...core.mechanism.mechanism import Mechanism
from ...core.results.left_open import named_components
from ...core.results.limits import efforts
from ...core.results.sweep import Sweep
from ...figures.wrenches import PARTS, QUANTITIES, UNITS, determined, values_of, whole_of
from ...kit.arrays import NOTHING, Array
from ...kit.quantities import amount
from .commands import STEADY, Arrays, node_name
from .scenery import COLORS, MEANINGS
from .still import Still
from .vectors import greatest, slide

_EFFORTS = {
    "drive": ("#1257b3", "effort of the drive"),
    "holding": ("#6d4c41", "effort that holds it"),
}
"""Colours and meanings of efforts."""


class Course(NamedTuple):
    """Along what a scene is shown.

    Attributes:
        name: what it is: the drive, `time`, or `course` where nothing else increases.
        unit: of its values.
        values: `(n,)` increasing or decreasing; None for a single sample.
        seconds: `(n,)` when each sample is passed [s]; None where no speed is known.
    """

    name: str
    unit: str
    values: Array | None
    seconds: Array | None


def readings(
    sweep: Sweep | Still,
    joints: tuple[str, ...],
    samples: Array,
    arrays: Arrays,
    along: Course,
    swings: frozenset[str] = frozenset(),
) -> dict[str, Any]:
    """Return what the page tells, its arrays in `arrays`.

    Args:
        sweep: over one dimension.
        joints: whose wrenches are told.
        samples: `(n,)` indices of the samples that are shown.
        arrays: gets the numbers.
        along: what the slider goes along.
        swings: coordinates that swing as in a mode.
    """
    told = _Teller(sweep, samples, arrays, swings)
    return {
        "sign": "Forces and moments are those that the parent exerts on the child.",
        "mode": told.mode(),
        "course": {
            "name": along.name,
            "unit": along.unit,
            "values": None if along.values is None else arrays.add(along.values, "f8"),
            "seconds": None if along.seconds is None else arrays.add(along.seconds, "f8"),
        },
        "state": told.state(),
        "joints": [told.joint(name) for name in joints],
        "links": told.links(),
    }


def course(sweep: Sweep | Still, samples: Array, *, timed: bool) -> Course:
    """Return along what a scene is shown: time, a drive, or how much of all has been passed.

    Args:
        sweep: over one dimension.
        samples: `(n,)` indices of the samples that are shown.
        timed: whether the samples are moments of a simulation.
    """
    if isinstance(sweep, Still) or len(samples) < 2:
        return Course("", "", None, None)
    time = np.broadcast_to(sweep.time, sweep.shape)[samples]
    positions, speeds = (
        np.reshape(values, (len(sweep), -1))[samples] for values in (sweep.position, sweep.speed)
    )
    for column, name in enumerate(() if timed else sweep.coordinates):
        position = positions[:, column]
        steps = np.diff(position)
        if np.all(steps > 0.0) or np.all(steps < 0.0):
            unit, factor = _scale(sweep.mechanism, name)
            return Course(name, unit, factor * position, _passed(steps, speeds[:, column]))
    if timed or np.all(np.diff(time) > 0.0):
        return Course("time", "s", time, time - time[0])
    share = np.linspace(0.0, 1.0, len(samples))
    if np.max(np.abs(positions[-1] - positions[0])) < STEADY:
        return Course("phase", "°", 360.0 * share, None)
    return Course("course", "%", 100.0 * share, None)


def _passed(steps: Array, speeds: Array) -> Array | None:
    """Return when samples are passed at their speeds `(n,)` [s]; None if these lead nowhere."""
    middle = 0.5 * (speeds[1:] + speeds[:-1])
    with np.errstate(divide="ignore", invalid="ignore"):
        needed = steps / middle
    if not (np.all(np.isfinite(needed)) and np.all(needed > 0.0)):
        return None
    return np.concatenate([[0.0], np.cumsum(needed)])


def _scale(mechanism: Mechanism, coordinate: str) -> tuple[str, float]:
    """Return the unit in which a coordinate is told, and its factor."""
    return ("m", 1.0) if mechanism.drivable[coordinate].slides else ("°", 180.0 / np.pi)


class _Teller:
    """Tells the state of a sweep and the numbers of its joints at some samples."""

    def __init__(
        self, sweep: Sweep | Still, samples: Array, arrays: Arrays, swings: frozenset[str]
    ) -> None:
        self._sweep, self._samples, self._arrays = sweep, samples, arrays
        self._mechanism = sweep.mechanism
        self._swings = swings
        links = reversed(list(self._mechanism.links.items()))
        self._first = {body: name for name, (body, _) in links}
        self._loops = {loop.joint for loop in self._mechanism.loops}
        described = self._mechanism.description
        self._links = {item.name: (item.parent, item.child) for item in described.joints}
        self._links |= {item.name: (item.predecessor, item.successor) for item in described.loops}
        wrenches = [sweep[name] for name in sweep.outputs]
        self._greatest = whole_of(wrenches, self._mechanism.characteristic_length)

    def state(self) -> list[dict[str, Any]]:
        """Return what drives, holds and loads the mechanism: name, and value or values.

        Loads say at which joint they act, empty for one on a link, and the node of their arrow.
        """
        sweep = self._sweep
        if isinstance(sweep, Still):
            return []
        rows = []
        positions = np.reshape(sweep.position, (len(sweep), -1))
        speeds = np.reshape(sweep.speed, (len(sweep), -1))
        for column, name in enumerate(sweep.coordinates):
            kind = "free" if name in sweep.free else "drive"
            kind = "swing" if name in self._swings else kind
            unit, factor = _scale(self._mechanism, name)
            rows.append(self._row(kind, name, factor * positions[:, column], unit))
            if np.any(speeds[:, column]):
                unit = f"{self._mechanism.drivable[name].unit}/s"
                rows.append(self._row("speed", name, speeds[:, column], unit))
        for name, load in sweep.loads.items():
            if isinstance(load, Wrench):
                for what, unit in (("force", "N"), ("moment", "N·m")):
                    size = np.linalg.norm(np.asarray(getattr(load, what)), axis=-1)
                    if np.any(size):
                        more = {"joint": "", "node": f"{node_name(name)} {what}"}
                        rows.append(self._row("load", f"{name}, {what}", size, unit) | more)
            else:
                coordinate = self._mechanism.drivable[name]
                node = f"{node_name(name)} {'force' if coordinate.slides else 'moment'}"
                row = self._row("load", name, load, coordinate.effort_unit)
                rows.append(row | {"joint": coordinate.joint, "node": node})
        for name, position in sweep.held.items():
            unit, factor = _scale(self._mechanism, name)
            rows.append(self._row("held", name, factor * np.asarray(position, float), unit))
        size = np.linalg.norm(sweep.gravity, axis=-1)
        if np.any(size):
            rows.append(self._row("gravity", "", size, "m/s²"))
        return rows

    def mode(self) -> str:
        """Return how large a mode is drawn, in words; empty of what is none."""
        sizes = []
        for name in self._swings:
            way = self._sweep.motion.position(name)[self._samples]
            if np.ptp(way):
                unit, factor = _scale(self._mechanism, name)
                sizes.append((0.5 * factor * float(np.ptp(way)), unit, name))
        if not sizes:
            return ""
        size, unit, name = max(sizes)
        return (
            f"Mode shape, drawn larger than life: {name} swings by {amount(size, unit)} to both "
            "sides. A mode has a shape and a frequency, and no size of its own."
        )

    def _row(self, kind: str, name: str, values: Array, unit: str) -> dict[str, Any]:
        row: dict[str, Any] = {"kind": kind, "name": name, "unit": unit}
        if values.ndim and len(values) > 1 and np.ptp(values) > 0.0:
            return {**row, "values": self._arrays.add(values[self._samples])}
        return {**row, "value": float(np.ravel(values)[0])}

    def joint(self, name: str) -> dict[str, Any]:
        """Return what a joint is and what it carries."""
        joint = self._mechanism.joints[name]
        ends = self._links[name]
        parent, child = (self._first[self._mechanism.links[end][0]] for end in ends)
        told: dict[str, Any] = {
            "name": name,
            "node": node_name(name),
            "type": f"{joint.type}, closes a loop" if name in self._loops else joint.type,
            "parent": parent,
            "child": child,
            "ends": f", from {ends[0]} to {ends[1]}",
            "open": "",
            "stroke": self._stroke(joint),
            "series": [],
        }
        # What joints carry is as much larger than life as a mode is.
        if isinstance(self._sweep, Sweep) and not self._swings:
            wrench = self._sweep[name]
            if not np.all(wrench.unique):
                opened = named_components(~wrench.unique)
                told["open"] = f"Not unique: {opened}, {self._sweep.left_open.why(name)}."
            # First what arrows show: curves that cover each other have the colour of the first.
            names = (*UNITS, "force") if wrench.has_axis else reversed(PARTS)
            parts = [
                (name, QUANTITIES[name], values_of(wrench, name), determined(wrench, name))
                for name in names
            ]
            told["series"] = [
                self._one(*item) for item in (*parts, *self._efforts(self._sweep, joint))
            ]
        return told

    def _stroke(self, joint: Joint) -> list[float]:
        """Return between which positions a joint slides along its axis [m]; none if it does not."""
        way = slide(self._sweep, joint, self._samples)
        return [float(np.min(way)), float(np.max(way))] if np.ptp(way) else []

    def links(self) -> list[dict[str, Any]]:
        """Return names of links, and the nodes under which their shapes are."""
        return [
            {"name": name, "node": node_name(name), "body": node_name(self._first[body])}
            for name, (body, _) in self._mechanism.links.items()
        ]

    def _efforts(self, sweep: Sweep, joint: Joint) -> list[tuple[str, str, Array, bool]]:
        """Return what drives or holds a joint."""
        found, drivable = [], self._mechanism.drivable
        for name, effort in efforts(sweep).items():
            if drivable[name].joint == joint.name and name not in sweep.free:
                kind = "holding" if name in sweep.holding_effort else "drive"
                found.append((kind, drivable[name].effort_unit, effort, True))
        return found

    def _one(self, name: str, unit: str, values: Array, unique: bool) -> dict[str, Any]:
        values = values[self._samples]
        if greatest(values[:, None]) < NOTHING * self._greatest[unit]:
            values = np.zeros_like(values)
        color, means = _EFFORTS.get(name) or (COLORS[name].css, MEANINGS.get(name, "size"))
        told = {"name": name, "unit": unit, "color": color, "means": means, "unique": unique}
        return {**told, "values": self._arrays.add(values)}
