"""Visuals: the shapes of a line's links, for scenes and for the drawing of the line.

Sizes that the data do not state go with the others.
"""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element, SubElement

from ....core.description.elements import words
from .data import LineData
from .supports import spline_distance

_ALONG = {"x": f"0 {math.pi / 2!r} 0", "y": f"{math.pi / 2!r} 0 0", "z": "0 0 0"}
_Place = tuple[float, float, float]


def shaft_visuals(line: LineData, index: int) -> list[Element]:
    """Return the shape of a shaft from its joint on along x, with its fork there and its sleeve."""
    length, radius = shaft_length(line, index), shaft_radius(line, index)
    front, rear = (_fork_base(line, index, side) for side in (-1, 0))
    start = -length if index == 0 else 0.0
    low, high = start + front, start + length - rear
    result = [_cylinder(f"tube_{index}", (low + high) / 2.0, "x", radius, high - low)]
    result += _fork(line, 1, -rear) if index == 0 else _fork(line, index, front)
    spline = line.shafts[index].spline
    if spline is not None:
        place, half = spline_distance(line, index), 0.5 * (spline.profile or 3.0 * radius)
        low, high = max(place - half, low), min(place + half, high)
        if high > low:
            middle = (low + high) / 2.0
            result.append(_cylinder(f"sleeve_{index}", middle, "x", 1.2 * radius, high - low))
    return result


def rear_fork_visuals(line: LineData, index: int) -> list[Element]:
    """Return the shape of an intermediate shaft's rear fork, about the centre of its joint."""
    return _fork(line, index + 1, -_fork_base(line, index, 0))


def cross_visuals(line: LineData, number: int) -> list[Element]:
    """Return the shape of a cross: a cylinder for each pin."""
    span = _span(line, number)
    return [
        _cylinder(f"pin_{number}_{end}", 0.0, axis, 0.12 * span, span)
        for end, axis in (("in", "y"), ("out", "z"))
    ]


def shaft_length(line: LineData, index: int) -> float:
    """Return the length of a shaft [m], of an end shaft past its last bearing if none is given."""
    length = float(line.geometry.lengths[index])
    if not math.isnan(length):
        return length
    distances = [1.15 * bearing.distance for bearing in line.shafts[index].bearings]
    return max(distances, default=4.0 * _nominal_diameter(line))


def shaft_radius(line: LineData, index: int) -> float:
    """Return the radius of a shaft [m], of one without a tube that goes with the line."""
    tube = line.shafts[index].tube
    return (tube.outer_diameter if tube else _nominal_diameter(line)) / 2.0


def _nominal_diameter(line: LineData) -> float:
    """Return the diameter of shafts without a tube [m]: the least that sizes of others suggest."""
    tubes = [shaft.tube.outer_diameter for shaft in line.shafts if shaft.tube]
    spans = [joint.cross_span / 1.5 for joint in line.joints if joint.cross_span]
    lengths = line.geometry.lengths[1:-1].tolist()
    slender = min(0.3 * min(lengths), sum(lengths) / 20.0) if lengths else 0.06
    return min(tubes + spans, default=slender)


def _span(line: LineData, number: int) -> float:
    """Return the span of a joint's cross, or one that goes with the shafts beside it [m]."""
    thickest = max(shaft_radius(line, index) for index in (number - 1, number))
    return line.joints[number - 1].cross_span or 3.0 * thickest


def _fork_base(line: LineData, index: int, side: int) -> float:
    """Return how far a fork's base is from its joint, at the front (-1) or rear (0) of a shaft."""
    number = index + side + 1
    if not 1 <= number <= line.count:
        return 0.0
    return min(_span(line, number) / 1.5, 0.2 * shaft_length(line, index))


def _fork(line: LineData, number: int, base: float) -> list[Element]:
    """Return the shape of a fork of a joint, about whose centre it is described.

    Args:
        line: the line.
        number: of the joint.
        base: x of the fork's base [m]; the driving fork, whose pins are along y, is before the
            joint, the driven one, whose pins are along z, behind it.
    """
    if line.even[number - 1]:
        housing = f"housing_{number}"
        return [_visual(housing, "sphere", radius=repr(0.9 * base))] if base > 0.0 else []
    span = _span(line, number)
    eye, thick, end = 0.17 * span, 0.1 * span, math.copysign(0.17 * span, -base)
    middle, length = (base + end) / 2.0, abs(base - end)
    name, ears = f"fork_{number}_{'out' if base > 0.0 else 'in'}", list[Element]()
    for side in (-1.0, 1.0):
        across = side * (0.5 * span - 0.4 * thick)
        sizes = (length, 2.0 * eye, thick) if base > 0.0 else (length, thick, 2.0 * eye)
        place = (middle, 0.0, across) if base > 0.0 else (middle, across, 0.0)
        ear = f"{name}_{'left' if side > 0.0 else 'right'}"
        ears.append(_visual(ear, "box", place, size=words(sizes)))
    return [*ears, _cylinder(f"{name}_base", base, "x", 0.52 * span, thick)]


def _cylinder(name: str, x: float, axis: str, radius: float, length: float) -> Element:
    sizes = {"radius": repr(radius), "length": repr(length)}
    return _visual(name, "cylinder", (x, 0.0, 0.0), _ALONG[axis], **sizes)


def _visual(
    name: str, kind: str, place: _Place = (0.0, 0.0, 0.0), rpy: str = "0 0 0", **sizes: str
) -> Element:
    visual = Element("visual", name=name)
    SubElement(visual, "origin", xyz=words(place), rpy=rpy)
    SubElement(SubElement(visual, "geometry"), kind, sizes)
    return visual
