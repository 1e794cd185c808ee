"""Visuals: plain shapes of shafts and crosses, for the viewer."""

from __future__ import annotations

import math
from xml.etree import ElementTree

from .line_data import LineData

_SLENDERNESS = 12.0
"""Length of a shaft over its diameter where no tube says its diameter."""
_ALONG_X = f"0 {math.pi / 2!r} 0"
_ALONG_Y = f"{math.pi / 2!r} 0 0"


def shaft_visuals(line: LineData, index: int) -> list[ElementTree.Element]:
    """Return the shape of a shaft: a cylinder along x from its joint."""
    length = _length(line, index)
    gap = min(_diameter(line), 0.2 * length)
    front = gap if index else -length
    rear = -gap if index == 0 else length - (gap if index < line.count else 0.0)
    middle = (front + rear) / 2.0
    return [_cylinder(f"tube_{index}", middle, _ALONG_X, _radius(line, index), rear - front)]


def cross_visuals(line: LineData, number: int) -> list[ElementTree.Element]:
    """Return the shape of a cross: a cylinder for each pin."""
    span = line.joints[number - 1].cross_span or 1.5 * _diameter(line)
    return [
        _cylinder(f"pin_{number}_{end}", 0.0, turn, 0.12 * span, span)
        for end, turn in (("in", _ALONG_Y), ("out", "0 0 0"))
    ]


def _length(line: LineData, index: int) -> float:
    """Return the length of a shaft, of an end shaft up to its last bearing if nothing else says."""
    length = float(line.geometry.lengths[index])
    if not math.isnan(length):
        return length
    distances = [bearing.distance for bearing in line.shafts[index].bearings]
    return max(distances, default=4.0 * _diameter(line))


def _diameter(line: LineData) -> float:
    """Return the greatest diameter of the tubes, or one that goes with the lengths."""
    diameters = [shaft.tube.outer_diameter for shaft in line.shafts if shaft.tube]
    lengths = [float(length) for length in line.geometry.lengths if not math.isnan(length)]
    return max(diameters, default=min(lengths, default=1.0) / _SLENDERNESS)


def _radius(line: LineData, index: int) -> float:
    tube = line.shafts[index].tube
    return (tube.outer_diameter if tube else _diameter(line)) / 2.0


def _cylinder(name: str, x: float, turn: str, radius: float, length: float) -> ElementTree.Element:
    visual = ElementTree.Element("visual", name=name)
    ElementTree.SubElement(visual, "origin", xyz=f"{x!r} 0 0", rpy=turn)
    geometry = ElementTree.SubElement(visual, "geometry")
    ElementTree.SubElement(
        geometry, "cylinder", radius=repr(float(radius)), length=repr(float(length))
    )
    return visual
