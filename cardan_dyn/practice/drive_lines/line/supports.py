"""Supports: which bearings carry a line, what is missing, and what statics leaves open.

Across its axis every shaft is held at two places: at its bearings, and at joints that the shaft on
their other side holds. A joint so serves one of its two shafts, and n joints need n + 2 bearings.
The centring of a coupling piece ties the shafts beside it to each other and stands for a bearing.
Along the axis, each stretch of the line between two splines, or a spline and an end, is held by one
locating bearing. More than that is statically indeterminate, less is a mechanism that falls apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ....kit.errors import ModelError
from .data import LineData
from .parts import Bearing, Shaft


class Support(NamedTuple):
    """A bearing of a line.

    Attributes:
        shaft: index of its shaft.
        name: of the bearing.
        distance: see `Bearing` [m].
        locating: whether it carries axial force.
        behind: whether it carries the piece behind the spline of its shaft.
    """

    shaft: int
    name: str
    distance: float
    locating: bool
    behind: bool

    @property
    def joint(self) -> str:
        """Name of its joint in the description."""
        return f"support_{self.name}"

    @property
    def along(self) -> float:
        """Its x in the frame of its shaft [m]; that of the input shaft ends at joint 1."""
        return self.distance if self.shaft else -self.distance


class Supports(NamedTuple):
    """What carries a line.

    Attributes:
        bearings: of all shafts, in the order of the data.
        indeterminate: what statics leaves open, in words; empty if nothing.
    """

    bearings: tuple[Support, ...]
    indeterminate: tuple[str, ...]


def supports(line: LineData) -> Supports:
    """Return what carries a line.

    Raises:
        ModelError: what is missing for the line to be held.
    """
    across = _across(line)
    stretches = _stretches(line)
    locating, along = _along(line, stretches)
    listed = []
    names = iter(_names(line))
    for index, shaft in enumerate(line.shafts):
        for place, bearing in enumerate(shaft.bearings):
            is_locating, behind = (index, place) in locating, _is_behind(line, index, bearing)
            listed.append(Support(index, next(names), bearing.distance, is_locating, behind))
    return Supports(tuple(listed), (*across, *along))


def bearings_of(line: LineData) -> tuple[Support, ...]:
    """Return the bearings that carry a line; none if they do not hold it."""
    try:
        return supports(line).bearings
    except ModelError:
        return ()


def in_order(found: Supports, index: int) -> list[Support]:
    """Return the bearings of a shaft in the order in which the closed chain takes them.

    What hangs from its place best is the piece before the spline, at a locating bearing.
    """
    of_shaft = [item for item in found.bearings if item.shaft == index]
    return sorted(of_shaft, key=lambda item: (item.behind, not item.locating))


def turning_balls(found: Supports) -> list[Support]:
    """Return the bearings that carry a turning shaft themselves, as its sleeve is that of others.

    They are behind the spline of a shaft whose first bearing is before it.
    """
    shafts = sorted({item.shaft for item in found.bearings})
    ordered = [in_order(found, index) for index in shafts]
    return [item for first, *rest in ordered for item in rest if item.behind != first.behind]


def hangs_by_rear(found: Supports, index: int) -> bool:
    """Return whether all bearings of a shaft carry the piece behind its spline."""
    of_shaft = [item.behind for item in found.bearings if item.shaft == index]
    return bool(of_shaft) and all(of_shaft)


def spline_distance(line: LineData, index: int) -> float:
    """Return the distance of a shaft's spline from the joint at its front [m]."""
    spline = line.shafts[index].spline
    if spline is None or spline.distance is None:
        return float(line.geometry.lengths[index]) / 2.0
    return spline.distance


def _is_behind(line: LineData, index: int, bearing: Bearing) -> bool:
    return line.shafts[index].spline is not None and bearing.distance > spline_distance(line, index)


def _names(line: LineData) -> list[str]:
    last, centre, names = len(line.shafts) - 1, 0, []
    taken = {bearing.name for bearing in line.bearings}
    for index, shaft in enumerate(line.shafts):
        # Along the power flow: A is the far bearing of the input shaft, F that of the output shaft.
        order = sorted(range(len(shaft.bearings)), key=lambda i: shaft.bearings[i].distance)
        if index == 0:
            order.reverse()
        of_shaft = [""] * len(order)
        for rank, place in enumerate(order):
            given = shaft.bearings[place].name
            if index in (0, last):
                letters = ("AB", "EF")[index == last]
                plain = letters[rank] if len(order) == 2 else f"{letters[0]}{rank + 1}"
            else:
                centre += 1
                plain = f"C{centre}"
            of_shaft[place] = given or plain
            if not given and plain in taken:
                raise ModelError(
                    f"bearings of a DriveLine: the name {plain!r} is given to one bearing and is "
                    "the plain one of another; name both"
                )
        names += of_shaft
    _check_links(names)
    return names


def _check_links(names: Sequence[str]) -> None:
    """Refuse names that make names of other joints: a bearing is moved by NAME_y and NAME_z."""
    for name in names:
        for taken in (f"{name}_y", f"{name}_z", f"{name}_y_place", f"{name}_z_place"):
            if taken in names:
                raise ModelError(
                    f"bearings of a DriveLine: the name {taken!r} is that of an adjustable joint "
                    f"or link of the bearing {name!r}; give another name"
                )
        if name in ("bearing_in", "bearing_out"):
            raise ModelError(
                f"bearings of a DriveLine: the name {name!r} is that of the bearing of an end "
                "shaft without bearings of its own; give another name"
            )


def _across(line: LineData) -> list[str]:
    """Return which shafts are held at too many places across their axes."""
    found, offered, last = [], 0, len(line.shafts) - 1
    for index, shaft in enumerate(line.shafts):
        # A single bearing at the joint of an end shaft stands for two.
        held = offered + (len(shaft.bearings) or 2 * (index in (0, last)))
        held += shaft.centring is not None
        # A shaft that lacks one place takes the joint behind it, which the next shaft then holds.
        lacking = 2 - held
        if lacking > (0 if index == last else 1):
            raise ModelError(_loose(line, index))
        if lacking < 0:
            found.append(
                f"{line.shaft_names[index]} is held across its axis at {held} places, joints "
                "included, and 2 decide its forces"
            )
        offered = 0 if lacking > 0 else 1
    return found


def _loose(line: LineData, index: int) -> str:
    """Return the message about a shaft that is not held."""
    name = line.shaft_names[index]
    if index == 0 or (index == len(line.shafts) - 1 and len(line.shafts[index].bearings) == 1):
        return (
            f"{name} is not held across its axis: an end shaft has two bearings, or none if one at "
            f"its joint shall stand for them; it has {len(line.shafts[index].bearings)}"
        )
    before = line.shaft_names[index - 1]
    return (
        f"nothing holds joint {index} between {before} and {name} across their axes; give one of "
        "them a (further) bearing, or a centring if it is the piece of a double joint"
    )


def _stretches(line: LineData) -> list[list[tuple[int, int | None]]]:
    """Return the bearings between splines: shaft and place; place None for an end without any."""
    result: list[list[tuple[int, int | None]]] = [[]]
    for index, shaft in enumerate(line.shafts):
        places = sorted(range(len(shaft.bearings)), key=lambda i: shaft.bearings[i].distance)
        for place in places:
            if not _is_behind(line, index, shaft.bearings[place]):
                result[-1].append((index, place))
        if shaft.spline is not None:
            result.append([])
            behind = [i for i in places if _is_behind(line, index, shaft.bearings[i])]
            result[-1] += [(index, place) for place in behind]
        if not places and index in (0, len(line.shafts) - 1):
            result[-1].append((index, None))
    return result


def _along(
    line: LineData, stretches: Sequence[Sequence[tuple[int, int | None]]]
) -> tuple[set[tuple[int, int]], list[str]]:
    """Return which bearings are locating, and which stretches several of them hold."""
    locating: set[tuple[int, int]] = set()
    found = []
    for number, stretch in enumerate(stretches):
        chosen = _locating_in(line.shafts, stretch)
        locating |= {(index, place) for index, place in chosen if place is not None}
        where = _between(line, number, len(stretches))
        if not chosen:
            raise ModelError(
                f"nothing holds {where} along its axis; make one of its bearings locating, or "
                "leave out a spline"
            )
        if len(chosen) > 1:
            remedy = "" if len(stretches) > 1 else "; an intermediate shaft with a spline frees it"
            found.append(f"{where} is held along its axis by {len(chosen)} bearings{remedy}")
    return locating, found


def _locating_in(
    shafts: Sequence[Shaft], stretch: Sequence[tuple[int, int | None]]
) -> list[tuple[int, int | None]]:
    """Return the locating bearings of a stretch: those that are said to be, those of end shafts."""
    stated = {
        (index, place): True if place is None else shafts[index].bearings[place].locating
        for index, place in stretch
    }
    chosen = [key for key, locates in stated.items() if locates]
    for end in (0, len(shafts) - 1):
        of_end = [key for key in stretch if key[0] == end]
        if of_end and not any(stated[key] for key in of_end):
            chosen += [key for key in of_end if stated[key] is None][:1]
    if not chosen:
        chosen = [key for key, locates in stated.items() if locates is None][:1]
    return chosen


def _between(line: LineData, number: int, count: int) -> str:
    """Return how messages call a stretch."""
    if count == 1:
        return "the line"
    with_spline = [
        name for name, shaft in zip(line.shaft_names, line.shafts, strict=True) if shaft.spline
    ]
    if number == 0:
        return f"what lies before the spline of {with_spline[0]}"
    if number == count - 1:
        return f"what lies behind the spline of {with_spline[-1]}"
    return f"what lies between the splines of {with_spline[number - 1]} and {with_spline[number]}"
