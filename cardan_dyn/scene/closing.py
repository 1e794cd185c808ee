"""Closing: a loop added to a mechanism, for trees whose files state none."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any
from xml.etree.ElementTree import Element, SubElement, fromstring, tostring

import numpy as np

from ..core.description.description import TWO_AXES
from ..core.description.elements import LOOP_TYPES, check_unique, loop, unique, words, xml_root
from ..core.description.write import write_origin
from ..core.mechanics.exact import made
from ..core.mechanism.carried import frame_of
from ..core.mechanism.mechanism import Mechanism
from ..core.mechanism.rezero import link_placements
from ..kit.arrays import Array, inverse
from ..kit.checks import described, placement, text, vector
from ..kit.errors import ArgumentError, AssemblyError
from .assembling import assemble
from .describe import describe

if TYPE_CHECKING:
    import pinocchio
    from numpy.typing import ArrayLike

_SIDES = ("predecessor", "successor")
_WITHOUT_AXIS = ("fixed", "spherical")


def close(
    mechanism: Mechanism,
    link_a: str,
    link_b: str,
    type: str,  # noqa: A002  # It is the word of descriptions.
    *,
    at: ArrayLike | pinocchio.SE3 | None = None,
    at_b: ArrayLike | pinocchio.SE3 | None = None,
    axis: ArrayLike | None = None,
    axis_2: ArrayLike | None = None,
    name: str = "",
    closure_tolerance: float | None = None,
) -> Mechanism:
    """Return a mechanism with one loop more: a joint between two links that it has already.

    It is what a `<loop>` of URDF+ says, for mechanisms from any source; the given one stays as it
    is. A mechanism that nothing moves any more is a structure, and a warning of it says so.

    Args:
        mechanism: from `load`, `from_pinocchio` or `close`.
        link_a: name of a link, the loop's predecessor; or of a site or frame on it, or of a fixed
            joint: places are then counted from there, and without any the joint is there.
        link_b: likewise, the loop's successor.
        type: `revolute` or `continuous` (a hinge), `prismatic` (a slide), `cylindrical`, `planar`,
            `universal`, `spherical` (a ball) or `fixed` (a weld).
        at: place of the joint on `link_a`: a point `(3,)` [m], with axes as those of the link; or a
            placement, `(4, 4)` or `pin.SE3`.
        at_b: likewise on `link_b`; the axes at a point are those of `at` at the description's zero.
            Of `at` and `at_b` one may be left out: both ends are then in the same place at zero.
            If both are given they may be apart there, as those of any loop.
        axis: `(3,)` of the joint in the axes of `at`, of any length; of a plane its normal. Balls
            and welds have none.
        axis_2: `(3,)` second axis of a `universal` joint, at right angles to the first.
        name: of the joint; `loop_1` and so on if empty.
        closure_tolerance: as of `load`, whose own is to be given again. If None, it is what the
            digits of the description say; the numbers given here are exact.

    Raises:
        ModelError: no such link or frame, both are on one link, an unknown type, axes that are
            not at right angles, or a name that another joint has.
        ArgumentError: no mechanism, no place, an axis too few or too many, or no numbers.
        AssemblyError: the loop cannot be closed; the message says by how far it is open at zero,
            and in which direction.
    """
    if not isinstance(mechanism, Mechanism):
        raise ArgumentError(f"close needs a mechanism from load(), not {described(mechanism)}")
    # Frames that rounded numbers had displaced go back to where these put them: the loop has a say
    # in where the exact ones are.
    before = Mechanism(replace(mechanism.base.description.undisplaced(), remedy=""))
    description = before.description
    named = *description.joints_and_loops, *description.couplings
    taken = [item.name for item in named]
    name = text("close: name", name) or unique(f"loop_{len(description.loops) + 1}", {*taken})
    check_unique([*taken, name], "joint or loop", before.name)
    element = Element("loop", name=name, type=text("close: type", type))
    links, ends = _ends(before, (link_a, link_b), (at, at_b))
    for side, link, end in zip(_SIDES, links, ends, strict=True):
        write_origin(SubElement(element, side, link=link), end, f"loop {name!r}")
    for tag, given in _axes(type, axis, axis_2):
        SubElement(element, tag, xyz=words(given))
    added = fromstring(description.added or "<robot/>")
    added.append(element)
    # It is read from its text, as the proof reads it.
    root, stated = xml_root(tostring(added, encoding="unicode"), f"close: {name!r}")
    closed = loop(root[-1], _SIDES, before.links, before.name)
    loops = *description.loops, closed
    result = made(replace(description, loops=loops, added=stated), closure_tolerance)
    _check_closable(result, name)
    equations = 6 * len(result.loops) + len(result.couplings)
    if result.model.nv > equations or describe(result).mobility > 0:
        return result
    warning = (
        f"{result.name}: with the loop {name!r} nothing moves any more: its mobility is 0. If a "
        "mechanism is meant, take a type that leaves more free, such as spherical"
    )
    warnings = *result.description.warnings, warning
    return Mechanism(replace(result.description, warnings=warnings))


def _ends(
    mechanism: Mechanism, names: tuple[str, str], given: tuple[Any, Any]
) -> tuple[list[str], tuple[Array, Array]]:
    """Return the links of a loop, and its `(4, 4)` placements in them.

    Args:
        mechanism: the mechanism, with the numbers of its text.
        names: of the links, or of frames on them.
        given: arguments `at` and `at_b`.
    """
    links: list[str] = []
    ends: list[Array | None] = []
    for label, name, place in zip(("at", "at_b"), names, given, strict=True):
        link, frame = frame_of(mechanism, name)
        links.append(link)
        if place is not None:
            ends.append(frame @ placement(f"close: {label}", place))
        else:
            ends.append(None if link == name else frame)
    at_zero = link_placements(mechanism.description)
    across = inverse(at_zero[links[1]]) @ at_zero[links[0]]
    first, second = ends
    if first is None:
        first = None if second is None else inverse(across) @ second
    elif second is None:
        second = across @ first
    elif np.shape(given[1]) == (3,):
        second[:3, :3] = across[:3, :3] @ first[:3, :3]
    if first is None or second is None:
        raise ArgumentError(
            f"close: where is the joint of {links[0]!r} and {links[1]!r}? Give at=, its place in "
            f"the frame of {links[0]!r}, or at_b=, or both"
        )
    return links, (first, second)


def _axes(kind: str, *given: ArrayLike | None) -> Iterator[tuple[str, Array]]:
    """Yield the elements that state the axes of a type, and these `(3,)`."""
    if kind not in LOOP_TYPES:
        return  # Whoever reads the loop says so.
    count = 0 if kind in _WITHOUT_AXIS else 1 + (kind in TWO_AXES)
    tags = zip(("axis", "axis_2"), ("axis", "axis2"), given, strict=True)
    for number, (label, tag, axis) in enumerate(tags):
        if (axis is None) == (number < count):
            has = ("no axis", "an axis", "axis and axis_2")[count]
            told = "missing" if axis is None else "too much"
            raise ArgumentError(f"close: {label} is {told}: a {kind} joint has {has}")
        if axis is not None:
            yield tag, vector(f"close: {label}", axis, 3)


def _check_closable(mechanism: Mechanism, name: str) -> None:
    """Refuse a loop that cannot be closed."""
    try:
        assemble(mechanism)
    except AssemblyError as error:
        frames = mechanism.frames
        placed, index = frames.placed(mechanism.zero[None, :]), frames.joints.index(name)
        start, end = frames.joint_frames(placed)[index], frames.ended(placed, index - frames.tree)
        gap = end[3, :, 0] - start[3, :, 0]
        raise AssemblyError(
            f"{mechanism.name}: the loop {name!r} cannot be closed: at the description's zero, the "
            f"way from its end on link_a to that on link_b is "
            f"({', '.join(f'{part:.4g}' for part in gap + 0.0)}) m in world axes, "
            f"{np.linalg.norm(gap):.4g} m in all. {error}",
            **error.details,
        ) from error
