"""Equalities of MJCF: `connect` and `weld` as loops, gears as couplings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TypeVar
from xml.etree import ElementTree

import numpy as np

from ...arrays import Array
from ...errors import ModelError, choices
from ..description import CouplingDescription, JointDescription, LoopDescription
from ..elements import numbers
from .elements import Attributes, DefaultClasses, flag, number, rotation_of_quaternion
from .schema import check_attributes, keyword

Found = TypeVar("Found")
LOOPS = ("connect", "weld")
"""Kinds of <equality> that close loops."""


@dataclass(frozen=True, eq=False)
class Places:
    """Where the bodies of a file are.

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
    root: ElementTree.Element, classes: DefaultClasses, places: Places, where: str
) -> tuple[list[LoopDescription], list[CouplingDescription], list[str]]:
    """Return the loops, the gears and warnings on what is switched off."""
    loops, couplings, warnings = [], [], []
    taken = set(places.joints)
    named = {name for item in _items(root) if (name := item.get("name"))}
    disabled = any(
        keyword(item.get("equality", "enable"), ("enable", "disable"), f"{where}: flag equality")
        == "disable"
        for item in root.iterfind("option/flag")
    )
    for count, element in enumerate(_items(root), start=1):
        name = element.get("name")
        at = f"{where}: <equality> <{element.tag}> {name or count!r}"
        attributes = classes.of(element, "main", at, "equality")
        if disabled or not flag(attributes, "active", "true", at):
            warnings.append(f"{at}: left out, as it is not active")
            continue
        if element.tag not in (*LOOPS, "joint"):
            raise ModelError(
                f"{where}: <equality> <{element.tag}> is not supported; kinds: {choices(LOOPS)}, "
                "and joint for gears"
            )
        gear = element.tag == "joint"
        check_attributes(element, at, "equality joint" if gear else None)
        name = unique(name or f"equality_{count}", taken if name else taken | named)
        taken.add(name)
        if gear:
            couplings.append(_gear(attributes, name, places, where, at))
        else:
            loops.append(_loop(element.tag, attributes, name, places, at))
    return loops, couplings, warnings


def unique(name: str, taken: set[str]) -> str:
    """Return a name that is not taken: itself, or with a number."""
    found, count = name, 1
    while found in taken:
        count += 1
        found = f"{name}_{count}"
    return found


def _items(root: ElementTree.Element) -> Iterator[ElementTree.Element]:
    return root.iterfind("equality/*")


def _loop(kind: str, attributes: Attributes, name: str, places: Places, at: str) -> LoopDescription:
    by_sites = [key for key in ("site1", "site2") if key in attributes]
    by_bodies = [key for key in ("body1", "body2", "anchor", "relpose") if key in attributes]
    if by_sites and by_bodies:
        raise ModelError(f"{at}: {by_sites[0]} and {by_bodies[0]} exclude each other")
    if kind == "weld" and number(attributes, "torquescale", "1", at) == 0.0:
        raise ModelError(f"{at}: a weld with torquescale 0 is a ball; write <connect>")
    if by_sites:
        (first, origin_1), (second, origin_2) = (
            _named(attributes, key, places.sites, at) for key in ("site1", "site2")
        )
    else:
        bodies = {link: (link, np.eye(4)) for link in places.links}
        bodies.setdefault("world", bodies[places.root])
        first, origin_1 = _named(attributes, "body1", bodies, at)
        second, origin_2 = bodies[places.root]
        if "body2" in attributes:
            second, origin_2 = _named(attributes, "body2", bodies, at)
    if first == second:
        raise ModelError(f"{at}: both ends are on the body {first!r}")
    # Placement of the second body in the first, as the file describes it.
    across = _inverse(places.links[first]) @ places.links[second]
    if kind == "connect" and not by_sites:
        if "anchor" not in attributes:
            raise ModelError(f'{at}: anchor="..." is missing')
        origin_1 = _moved(numbers(attributes["anchor"], 3, "", f"{at}: anchor"))
        origin_2 = _inverse(across) @ origin_1
    elif kind == "connect":
        # A ball stands at zero as the file describes it, however its sites are turned.
        origin_2 = origin_2.copy()
        origin_2[:3, :3] = across[:3, :3].T @ origin_1[:3, :3]
    elif not by_sites:
        origin_2 = _moved(numbers(attributes.get("anchor"), 3, "0 0 0", f"{at}: anchor"))
        origin_1 = across @ origin_2
        pose = numbers(attributes.get("relpose"), 7, "0 1 0 0 0 0 0", f"{at}: relpose")
        if np.any(pose[3:]):
            # MuJoCo holds the anchor, a point of the second body, at this point of the first.
            origin_1 = _moved(pose[:3])
            origin_1[:3, :3] = rotation_of_quaternion(pose[3:], f"{at}: relpose")
    axis = np.array([1.0, 0.0, 0.0])
    joint = "spherical" if kind == "connect" else "fixed"
    return LoopDescription(name, joint, first, second, origin_1, origin_2, axis, axis)


def _gear(
    attributes: Attributes, name: str, places: Places, where: str, at: str
) -> CouplingDescription:
    """Return the coupling that a polynomial between two joints is, where it is a ratio.

    A coupling sums up rotations from the nearest common ancestor of its links. So it says the
    same only of hinges that stand on one body.
    """
    driven = _named(attributes, "joint1", places.joints, at)
    driving = None
    if "joint2" in attributes:
        driving = _named(attributes, "joint2", places.joints, at)
    factors = numbers(attributes.get("polycoef"), 5, "0 1 0 0 0", f"{at}: polycoef")
    if (
        driving is None
        or driven is driving
        or not {driven.type, driving.type} <= {"revolute", "continuous"}
        or places.rigid[driven.parent] != places.rigid[driving.parent]
        or factors[1] == 0.0
        or np.any(factors[[0, 2, 3, 4]])
    ):
        raise ModelError(
            f"{where}: <equality> <joint> is not supported but for gears: {name!r} needs two "
            'hinges on the same body and polycoef="0 ratio 0 0 0"'
        )
    return CouplingDescription(name, driving.child, driven.child, float(factors[1]))


def _named(attributes: Attributes, key: str, found: Mapping[str, Found], at: str) -> Found:
    """Return what an attribute names."""
    name = attributes.get(key)
    if name is None:
        raise ModelError(f'{at}: {key}="..." is missing')
    if name not in found:
        raise ModelError(f"{at}: {key} {name!r} does not exist; names: {choices(found)}")
    return found[name]


def _moved(point: Array) -> Array:
    result = np.eye(4)
    result[:3, 3] = point
    return result


def _inverse(placement: Array) -> Array:
    result = np.eye(4)
    result[:3, :3] = placement[:3, :3].T
    result[:3, 3] = -placement[:3, :3].T @ placement[:3, 3]
    return result
