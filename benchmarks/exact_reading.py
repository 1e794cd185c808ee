"""Reading of a description for the exact evaluation: its doubles as exact numbers."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass

from mpmath import mp, mpf

from .vectors import Matrix, Vector, about, dot, flip, identity, product


@dataclass(frozen=True)
class Joint:
    """A joint of the tree (`loop` False) or a loop's joint, with exact numbers."""

    name: str
    kind: str
    parent: str
    child: str
    rotation: Matrix
    translation: Vector
    axis: Vector
    loop: bool
    successor_rotation: Matrix
    successor_translation: Vector


@dataclass(frozen=True)
class Body:
    """Mass properties of a link, the inertia about its centre of mass in the link's axes."""

    mass: mpf
    centre: Vector
    inertia: Matrix


def read_body(link: ElementTree.Element) -> Body:
    """Return the mass properties of a `<link>`; none if it has no `<inertial>`."""
    inertial = link.find("inertial")
    if inertial is None:
        return Body(mpf(0), [mpf(0)] * 3, [[mpf(0)] * 3 for _ in range(3)])
    rotation, centre = _origin(inertial)
    mass, tensor = inertial.find("mass"), inertial.find("inertia")
    assert mass is not None and tensor is not None
    entry = {key: mpf(float(value)) for key, value in tensor.attrib.items()}
    inertia = [
        [entry["ixx"], entry["ixy"], entry["ixz"]],
        [entry["ixy"], entry["iyy"], entry["iyz"]],
        [entry["ixz"], entry["iyz"], entry["izz"]],
    ]
    inertia = product(product(rotation, inertia), flip(rotation))
    return Body(mpf(float(mass.get("value", "0"))), centre, inertia)


def read_joint(item: ElementTree.Element) -> Joint:
    """Return the joint of a `<joint>`."""
    rotation, translation = _origin(item)
    return Joint(
        name=item.get("name", ""),
        kind=item.get("type", ""),
        parent=_attribute(item, "parent", "link"),
        child=_attribute(item, "child", "link"),
        rotation=rotation,
        translation=translation,
        axis=_axis(item),
        loop=False,
        successor_rotation=identity(),
        successor_translation=[mpf(0)] * 3,
    )


def read_loop(item: ElementTree.Element) -> Joint:
    """Return the joint of a `<loop>`, its predecessor as parent."""
    sides = [item.find(side) for side in ("predecessor", "successor")]
    (rotation, translation), (turn, shift) = (_origin(side) for side in sides if side is not None)
    return Joint(
        name=item.get("name", ""),
        kind=item.get("type", ""),
        parent=_attribute(item, "predecessor", "link"),
        child=_attribute(item, "successor", "link"),
        rotation=rotation,
        translation=translation,
        axis=_axis(item),
        loop=True,
        successor_rotation=turn,
        successor_translation=shift,
    )


def _attribute(item: ElementTree.Element, tag: str, key: str) -> str:
    element = item.find(tag)
    return "" if element is None else element.get(key, "")


def _axis(item: ElementTree.Element) -> Vector:
    text = _attribute(item, "axis", "xyz") or "1 0 0"
    axis = [mpf(float(value)) for value in text.split()]
    norm = mp.sqrt(dot(axis, axis))
    return [value / norm for value in axis]


def _origin(item: ElementTree.Element) -> tuple[Matrix, Vector]:
    origin = item.find("origin")
    attributes = {} if origin is None else origin.attrib
    shift = [mpf(float(value)) for value in attributes.get("xyz", "0 0 0").split()]
    roll, pitch, yaw = (mpf(float(x)) for x in attributes.get("rpy", "0 0 0").split())
    units = [[mpf(i == k) for i in range(3)] for k in range(3)]
    turn = product(about(units[1], pitch), about(units[0], roll))
    turn = product(about(units[2], yaw), turn)
    return turn, shift
