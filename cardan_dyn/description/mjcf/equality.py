"""Equalities of MJCF: `connect` and `weld` as loops, `joint` as couplings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TypeVar
from xml.etree import ElementTree

import numpy as np

from ...arrays import Array, inverse
from ...errors import ModelError, choices
from ..description import CouplingDescription, JointDescription, LoopDescription
from ..elements import SINGLE_TYPES, numbers, unique
from .elements import (
    Attributes,
    DefaultClasses,
    flag,
    keyword,
    number,
    rotation_of_quaternion,
)

Named = TypeVar("Named")
LOOPS = ("connect", "weld")
"""Kinds of <equality> that close loops."""


@dataclass(frozen=True, eq=False)
class Frames:
    """Where the bodies of a file are, and its sites and joints: what equalities refer to.

    Attributes:
        root: name of the link that stands in the world.
        links: link to its `(4, 4)` placement in the world, initially.
        rigid: link to the first of those links that fixed joints make one body with it.
        sites: site to its link and `(4, 4)` placement there.
        joints: tree joints by name.
    """

    root: str
    links: dict[str, Array]
    rigid: dict[str, str]
    sites: dict[str, tuple[str, Array]]
    joints: dict[str, JointDescription]


def equalities(
    root: ElementTree.Element, classes: DefaultClasses, frames: Frames, where: str
) -> tuple[list[LoopDescription], list[CouplingDescription], list[str]]:
    """Return the loops, the couplings, and warnings about equalities that are switched off.

    Args:
        root: outermost element of the file.
        classes: its default classes.
        frames: what the equalities refer to.
        where: how messages name the source of the text.

    Raises:
        ModelError: an equality is malformed, or of a kind that is not supported.
    """
    loops, couplings, warnings = [], [], []
    taken = set(frames.joints)
    named = {name for item in _items(root) if (name := item.get("name"))}
    disabled = _are_disabled(root, where)
    for count, element in enumerate(_items(root), start=1):
        name = element.get("name")
        at = f"{where}: <equality> <{element.tag}> {name or count!r}"
        attributes = classes.of(element, "main", at, "equality")
        if disabled or not flag(attributes, "active", "true", at):
            warnings.append(f"{at}: left out, as it is not active")
            continue
        if element.tag not in (*LOOPS, "joint"):
            raise ModelError(
                f"{where}: <equality> <{element.tag}> is not supported; kinds: "
                f"{choices((*LOOPS, 'joint'), element.tag)}; joint is a coupling"
            )
        name = unique(name or f"equality_{count}", taken if name else taken | named)
        taken.add(name)
        if element.tag == "joint":
            couplings.append(_coupling(attributes, name, frames, where, at))
        else:
            loops.append(_loop(element.tag, attributes, name, frames, at))
    # In the order of the joints, as a URDF lists them.
    order = {name: index for index, name in enumerate(frames.joints)}
    couplings.sort(key=lambda coupling: order[coupling.successor])
    return loops, couplings, warnings


def _are_disabled(root: ElementTree.Element, where: str) -> bool:
    """Return whether an option switches all equalities off."""
    words, at = ("enable", "disable"), f"{where}: flag equality"
    return any(
        keyword(item.get("equality", "enable"), words, at) == "disable"
        for item in root.iterfind("option/flag")
    )


def _items(root: ElementTree.Element) -> Iterator[ElementTree.Element]:
    return root.iterfind("equality/*")


def _loop(kind: str, attributes: Attributes, name: str, frames: Frames, at: str) -> LoopDescription:
    """Return the loop that a `connect` or a `weld` is.

    Its coordinates are zero in the initial configuration, save for a `weld` that states another
    relative pose.
    """
    by_sites = [key for key in ("site1", "site2") if key in attributes]
    by_bodies = [key for key in ("body1", "body2", "anchor", "relpose") if key in attributes]
    if by_sites and by_bodies:
        raise ModelError(f"{at}: {by_sites[0]} and {by_bodies[0]} exclude each other")
    if kind == "weld" and number(attributes, "torquescale", "1", at) == 0.0:
        raise ModelError(f"{at}: a weld with torquescale 0 is a ball; write <connect>")
    if by_sites:
        links, origins = _of_sites(kind, attributes, frames, at)
    else:
        links, origins = _of_bodies(kind, attributes, frames, at)
    axis = np.array([1.0, 0.0, 0.0])
    joint = "spherical" if kind == "connect" else "fixed"
    return LoopDescription(name, joint, *links, *origins, axis, axis)


def _of_sites(
    kind: str, attributes: Attributes, frames: Frames, at: str
) -> tuple[tuple[str, str], tuple[Array, Array]]:
    """Return the links that an equality of two sites connects, and `(4, 4)` placements there."""
    (first, origin_1), (second, origin_2) = (
        _named(attributes, key, frames.sites, at) for key in ("site1", "site2")
    )
    _check_apart(first, second, at)
    if kind == "connect":
        # The sites of a ball joint may have any orientation: that of the second is replaced, so
        # that the coordinate is zero in the initial configuration.
        origin_2 = origin_2.copy()
        origin_2[:3, :3] = _across(first, second, frames)[:3, :3].T @ origin_1[:3, :3]
    return (first, second), (origin_1, origin_2)


def _of_bodies(
    kind: str, attributes: Attributes, frames: Frames, at: str
) -> tuple[tuple[str, str], tuple[Array, Array]]:
    """Return the links that an equality of bodies connects, and `(4, 4)` placements there."""
    bodies = {link: link for link in frames.links}
    bodies.setdefault("world", frames.root)
    first = _named(attributes, "body1", bodies, at)
    second = _named(attributes, "body2", bodies, at) if "body2" in attributes else frames.root
    _check_apart(first, second, at)
    across = _across(first, second, frames)
    if kind == "connect":
        if "anchor" not in attributes:
            raise ModelError(f'{at}: anchor="..." is missing')
        origin_1 = _at_point(numbers(attributes["anchor"], 3, "", f"{at}: anchor"))
        return (first, second), (origin_1, inverse(across) @ origin_1)
    origin_2 = _at_point(numbers(attributes.get("anchor"), 3, "0 0 0", f"{at}: anchor"))
    origin_1 = across @ origin_2
    relative_pose = numbers(attributes.get("relpose"), 7, "0 1 0 0 0 0 0", f"{at}: relpose")
    # A quaternion of zeros stands for the pose in the initial configuration.
    if np.any(relative_pose[3:]):
        # MuJoCo holds the anchor, a point of the second body, at this point of the first.
        origin_1 = _at_point(relative_pose[:3])
        origin_1[:3, :3] = rotation_of_quaternion(relative_pose[3:], f"{at}: relpose")
    return (first, second), (origin_1, origin_2)


def _check_apart(first: str, second: str, at: str) -> None:
    if first == second:
        raise ModelError(f"{at}: both ends are on the body {first!r}")


def _across(first: str, second: str, frames: Frames) -> Array:
    """Return the initial `(4, 4)` placement of the second link in the first."""
    return inverse(frames.links[first]) @ frames.links[second]


def _coupling(
    attributes: Attributes, name: str, frames: Frames, where: str, at: str
) -> CouplingDescription:
    """Return the coupling that an equality of two joints is, where its polynomial is linear.

    The polynomial counts both coordinates from the initial configuration, where those of a
    description are zero.
    """
    driven = _named(attributes, "joint1", frames.joints, at)
    driving = None
    if "joint2" in attributes:
        driving = _named(attributes, "joint2", frames.joints, at)
    factors = numbers(attributes.get("polycoef"), 5, "0 1 0 0 0", f"{at}: polycoef")
    if (
        driving is None
        or driven is driving
        or not {driven.type, driving.type} <= SINGLE_TYPES
        or factors[1] == 0.0
        or np.any(factors[2:])
    ):
        raise ModelError(
            f"{where}: <equality> <joint> is not supported except as a coupling: {name!r} needs "
            'two hinges or slides and polycoef="offset ratio 0 0 0", the ratio not zero'
        )
    offset, ratio = factors[:2].tolist()
    return CouplingDescription(name, driving.name, driven.name, ratio, offset, of_joints=True)


def _named(attributes: Attributes, key: str, known: Mapping[str, Named], at: str) -> Named:
    """Return the known item that an attribute names."""
    name = attributes.get(key)
    if name is None:
        raise ModelError(f'{at}: {key}="..." is missing')
    if name not in known:
        raise ModelError(f"{at}: {key} {name!r} does not exist; names: {choices(known, name)}")
    return known[name]


def _at_point(point: Array) -> Array:
    """Return the `(4, 4)` placement at a point, axes parallel."""
    result = np.eye(4)
    result[:3, 3] = point
    return result
