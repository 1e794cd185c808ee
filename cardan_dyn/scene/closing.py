"""Closing: loops and couplings added to a mechanism, for trees whose files state none."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any
from xml.etree.ElementTree import Element, SubElement, fromstring, tostring

import numpy as np
from numpy.typing import ArrayLike

from ..core.description.description import TWO_AXES, CouplingDescription, Mesh
from ..core.description.elements import (
    LOOP_TYPES,
    SINGLE_TYPES,
    check_unique,
    loop,
    unique,
    words,
    xml_root,
)
from ..core.description.mimics import check_mimics, mimics
from ..core.description.urdf import coupling
from ..core.description.write import write_coupling, write_mimic, write_origin
from ..core.mechanics.exact import made
from ..core.mechanism.mechanism import Mechanism
from ..core.mechanism.rezero import link_placements
from ..kit.arrays import ROUNDED, Array, inverse
from ..kit.checks import described, number, numbers, placement, text, vector
from ..kit.errors import ArgumentError, AssemblyError, ModelError, choices
from .assembling import assemble
from .describe import describe

if TYPE_CHECKING:
    import pinocchio
    from numpy.typing import ArrayLike

    from ..core.description.description import Description, LoopDescription

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
    before, taken = _before("close", mechanism)
    description = before.description
    name = text("close: name", name) or unique(f"loop_{len(description.loops) + 1}", {*taken})
    check_unique([*taken, name], "joint or loop", before.name)
    element = Element("loop", name=name, type=text("close: type", type))
    links, ends = _ends(before, (link_a, link_b), (at, at_b))
    for side, link, end in zip(_SIDES, links, ends, strict=True):
        write_origin(SubElement(element, side, link=link), end, f"loop {name!r}")
    for tag, given in _axes(type, axis, axis_2):
        SubElement(element, tag, xyz=words(given))
    element, added = _added(description, element, f"close: {name!r}")
    loops = *description.loops, loop(element, before.links, before.name)
    notation = description.notation
    if "cd.close" not in notation:
        notation = "cd.close" if notation == "no loops" else f"{notation}, cd.close"
    description = replace(description, loops=loops, added=added, notation=notation)
    result = made(description, closure_tolerance)
    _check_closable(result, name)
    return _told_if_locked(result, name, "take a type that leaves more free, such as spherical")


def couple(
    mechanism: Mechanism,
    first: str,
    second: str,
    ratio: float,
    *,
    offset: float = 0.0,
    higher: ArrayLike = (),
    forces: str = "",
    pressure_angle: float | None = None,
    helix_angle: float | None = None,
    along: float | None = None,
    name: str = "",
    closure_tolerance: float | None = None,
) -> Mechanism:
    """Return a mechanism with one coupling more: a pair of gears, a screw, a joint that follows.

    It is what `<coupling>` and `<mimic>` of URDF+ say, for mechanisms from any source; the given
    one stays as it is. If nothing that it couples moves any more, a warning says so.

    Args:
        mechanism: from `load`, `from_pinocchio`, `close` or `couple`.
        first: name of a link, whose motion counts from the nearest common ancestor of both; or of a
            joint of the tree with one coordinate.
        second: likewise, a link or a joint as the first; the one that follows.
        ratio: motion of the second per motion of the first [1, m/rad and so on]; not zero without
            higher coefficients.
        offset: of joints, position of the second while the first is at zero [rad or m].
        higher: coefficients `(n,)` of the square of the first's motion, its cube and so on, where
            the ratio changes: q₂ = offset + ratio q₁ + higher[0] q₁² + higher[1] q₁³ …; the last
            one is not zero.
        forces: what acts between them, `none` or `mesh`; unknown if empty, see
            `CouplingDescription`.
        pressure_angle: of a mesh [rad]; 20° if None.
        helix_angle: of a mesh [rad]; zero if None.
        along: of a mesh, see `Mesh` [m].
        name: of the coupling; `coupling_1` and so on if empty.
        closure_tolerance: as of `close`.

    Raises:
        ModelError: no such link or joint, a joint with several coordinates or one that follows
            another already, a ratio of zero, no such forces, or a name that is taken.
        ArgumentError: no mechanism, no numbers, or an offset of links.
        AssemblyError: it cannot hold near the description's zero.
    """
    before, taken = _before("couple", mechanism)
    description, known = before.description, before.links
    name = text("couple: name", name)
    name = name or unique(f"coupling_{len(description.couplings) + 1}", {*taken})
    check_unique([*taken, name], "joint or loop", before.name)
    first, second = text("couple: first", first), text("couple: second", second)
    of_joints = not (first in known and second in known)
    powers = numbers("couple: higher", higher)
    if powers.ndim != 1:
        raise ArgumentError(
            f"couple: higher has shape {powers.shape}, expected (n,): the coefficients of the "
            "square, the cube and so on"
        )
    given = zip(Mesh._fields, (pressure_angle, helix_angle, along), strict=True)
    teeth = {key: number(f"couple: {key}", value) for key, value in given if value is not None}
    stated = CouplingDescription(
        name=name,
        predecessor=first,
        successor=second,
        ratio=number("couple: ratio", ratio),
        offset=number("couple: offset", offset),
        of_joints=of_joints,
        forces=text("couple: forces", forces),
        mesh=Mesh(**teeth) if teeth or forces == "mesh" else None,
        higher=tuple(powers.tolist()),
    )
    holder = Element("robot")
    if of_joints:
        single = [joint.name for joint in description.joints if joint.type in SINGLE_TYPES]
        if second not in single:
            near = None if second in known else second
            raise ModelError(
                f"{before.name}: coupling {name!r}: {second!r} is no joint of the tree with one "
                f"coordinate, and {first!r} and {second!r} are not both links; joints: "
                f"{choices(single, near)}; links: {choices(known, near)}"
            )
        write_mimic(SubElement(holder, "joint", name=second), stated)
    elif stated.offset:
        raise ArgumentError("couple: a coupling of links has no offset; name the joints instead")
    else:
        write_coupling(holder, stated)
    element, added = _added(description, holder[0], f"couple: {name!r}")
    if of_joints:
        holder[:] = [element]
        (item,), _ = mimics(holder, description.joints, taken, before.name)
        check_mimics([*description.couplings, item], before.name)
    else:
        item = coupling(element, known, before.name)
    description = replace(description, couplings=(*description.couplings, item), added=added)
    result = made(description, closure_tolerance)
    try:
        assemble(result)
    except AssemblyError as error:
        raise AssemblyError(
            f"{before.name}: the coupling {name!r} cannot hold. {error}", **error.details
        ) from error
    return _told_if_locked(result, name, "leave one of its couplings out")


def _before(function: str, mechanism: object) -> tuple[Mechanism, list[str]]:
    """Return a mechanism with the numbers of its text, and the names that are taken.

    Frames that rounded numbers had displaced go back to where these put them: what is added has a
    say in where the exact ones are.
    """
    if not isinstance(mechanism, Mechanism):
        raise ArgumentError(f"{function} needs a mechanism from load(), not {described(mechanism)}")
    description = replace(mechanism.base.description.undisplaced(), remedy="")
    named = *description.joints_and_loops, *description.couplings
    return Mechanism(description), [item.name for item in named]


def _added(description: Description, element: Element, where: str) -> tuple[Element, str]:
    """Return an element as the text says it that states what was added, and this text.

    So it is read as the proof reads it.
    """
    added = fromstring(description.added or "<robot/>")
    added.append(element)
    root, stated = xml_root(tostring(added, encoding="unicode"), where)
    return root[-1], stated


def _told_if_locked(mechanism: Mechanism, name: str, advice: str) -> Mechanism:
    """Return a mechanism, with a warning if what was added locks all that it couples."""
    parts = describe(mechanism).components
    (part,) = (item for item in parts if name in (*item.loops, *item.couplings))
    if part.mobility > 0 or part.is_counted:
        return mechanism
    warning = (
        f"{mechanism.name}: with {name!r} none of the {part.coordinates} coordinates that it "
        f"couples moves any more. If a mechanism is meant, {advice}"
    )
    warnings = *mechanism.description.warnings, warning
    return Mechanism(replace(mechanism.description, warnings=warnings))


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
        mechanism.link_frame(name)  # It refuses what is none.
        link, frame = mechanism.description.fixed_frames.get(name, (name, np.eye(4)))
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
    for index, (label, tag, axis) in enumerate(tags):
        if (axis is None) == (index < count):
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
        axes = _directions(mechanism.description.loops[index - frames.tree])
        apart = np.linalg.norm(axes @ (end[:3, :, 0] - start[:3, :, 0]), axis=1)
        angle = 2.0 * np.arcsin(0.5 * np.max(apart, initial=0.0))
        turned = f"; the axes of its ends are {angle:.4g} rad apart" if angle > ROUNDED else ""
        raise AssemblyError(
            f"{mechanism.name}: the loop {name!r} cannot be closed: at the description's zero, the "
            f"way from its end on link_a to that on link_b is "
            f"({', '.join(f'{part:.4g}' for part in gap + 0.0)}) m in world axes, "
            f"{np.linalg.norm(gap):.4g} m in all{turned}. {error}",
            **error.details,
        ) from error


def _directions(joint: LoopDescription) -> Array:
    """Return the directions `(k, 3)` in the joint's frame that both of its ends share."""
    if joint.type in ("spherical", "universal"):
        return np.zeros((0, 3))
    return np.eye(3) if joint.type == "fixed" else joint.axis[None, :]
