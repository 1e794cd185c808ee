"""Second reading of SDF: the numbers of a model, read once more for the proof.

It shares nothing with the first reader but the `plain` model and the decisions which joints are a
tree and which way round they stand; what the first reader checked is not checked again. Turns and
inertias of shapes are Pinocchio's.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any
from xml.etree.ElementTree import Element, fromstring

import numpy as np
import pinocchio

from ....core.description.description import (
    CouplingDescription,
    Description,
    LinkDescription,
    LoopDescription,
    SourceText,
)
from ....kit.arrays import Array
from ..renumbered import link_in, link_of, placed_at
from .plain import of_urdf, plain

_MODEL = "__model__"


def reread(description: Description, source: SourceText) -> Description:
    """Return a description with the numbers of its text: masses, placements, axes, ratios."""
    model, _ = plain(fromstring(source.text), "SDF", strict=False, model=source.model)
    return _Numbers(model).of(description)


def loops_in_urdf(robot: Element, loops: Iterable[LoopDescription]) -> dict[str, LoopDescription]:
    """Return loops, by name, with the numbers of joints that a URDF's `<gazebo>` elements state."""
    model, _ = of_urdf(robot, "URDF")
    added = {item.get("name") for item in model.findall("joint")}
    numbers = _Numbers(model)
    return {loop.name: numbers.placed(loop) for loop in loops if loop.name in added}


class _Numbers:
    """The numbers of a model.

    Attributes:
        places: `(4, 4)` placements in the world; of joints under a name that begins with a blank.
    """

    def __init__(self, model: Element) -> None:
        self._links = {item.attrib["name"]: item for item in model.findall("link")}
        self._joints = {item.attrib["name"]: item for item in model.findall("joint")}
        stated = {name: _placed(item, _MODEL) for name, item in self._links.items()}
        for item in model.findall("frame"):
            stated[item.attrib["name"]] = _placed(item, item.get("attached_to") or _MODEL)
        for name, item in self._joints.items():
            stated[f" {name}"] = _placed(item, _word(item, "child"))
            # In older versions, whose frames have no names, a link may be called the same.
            stated.setdefault(name, (f" {name}", np.eye(4)))
        _, place = _placed(model, "")
        if anchor := model.get("placement_frame"):
            place = place @ np.linalg.inv(_settled(stated, np.eye(4))[anchor])
        self.places = _settled(stated, place)

    def of(self, description: Description) -> Description:
        """Return a description with these numbers."""
        hinges = {joint.child: joint.name for joint in description.joints}
        return description.with_each(
            self.placed,
            links=tuple(
                _link(link.name, self._links[link.name])
                if link.name in self._links
                else LinkDescription(link.name)
                for link in description.links
            ),
            couplings=tuple(self._coupling(item, hinges) for item in description.couplings),
        )

    def placed(self, item: Any) -> Any:
        """Return a joint or loop with its placements and axes."""
        if item.name in self._joints:
            frame, axes = self.places[f" {item.name}"], self._axes(item.name, item.type)
        else:  # It joins the link with the world, and stands where the link does.
            frame, axes = self.places[item.child], []
        return placed_at(item, [frame] * len(item.ENDS), self.places, *axes)

    def _axes(self, joint: str, kind: str) -> list[Array]:
        """Return the axes of a joint in its frame."""
        if kind in ("fixed", "spherical"):
            return [np.array([1.0, 0.0, 0.0])]
        turn = self.places[f" {joint}"][:3, :3]
        tags = ("axis", "axis2")[: 1 + (kind == "universal")]
        return [np.linalg.solve(turn, self._in_world(joint, tag)) for tag in tags]

    def _in_world(self, joint: str, tag: str) -> Array:
        """Return a `(3,)` unit axis of a joint in the world."""
        xyz = self._joints[joint].find(f"{tag}/xyz")
        direction = np.array([0.0, 0.0, 1.0])
        if xyz is not None and xyz.text:
            direction = np.array(xyz.text.split(), dtype=float)
        named = None if xyz is None else xyz.get("expressed_in")
        turn = self.places[named or f" {joint}"][:3, :3]
        return np.asarray(turn @ direction / np.sqrt(direction @ direction))

    def _coupling(
        self, coupling: CouplingDescription, hinges: dict[str, str]
    ) -> CouplingDescription:
        """Return a coupling with the ratio of its gearbox, or of the axis that mimics another."""
        if coupling.of_joints:
            axis = self._joints[coupling.successor]
            ratio, offset, reference = (
                float(_word(axis, f"axis/mimic/{tag}") or default)
                for tag, default in (("multiplier", 1.0), ("offset", 0.0), ("reference", 0.0))
            )
            return replace(coupling, ratio=ratio, offset=offset - ratio * reference)
        gear = coupling.name
        senses = [
            self._in_world(hinges[link], "axis") @ self._in_world(gear, tag)
            for tag, link in (("axis", coupling.predecessor), ("axis2", coupling.successor))
        ]
        ratio = -float(_word(self._joints[gear], "gearbox_ratio") or 1.0)
        return replace(coupling, ratio=ratio * float(np.sign(np.prod(senses))), offset=0.0)


def _settled(stated: dict[str, tuple[str, Array]], model: Array) -> dict[str, Array]:
    """Return all placements in the world, each after that to which it is relative."""
    known = {_MODEL: model, "world": np.eye(4)}
    for name in stated:
        chain = []
        while name not in known:
            chain.append(name)
            name = stated[name][0]
        for each in reversed(chain):
            base, local = stated[each]
            known[each] = known[base] @ local
    return known


def _link(name: str, element: Element) -> LinkDescription:
    """Return a link with the mass and inertia of its element, or those that count without it."""
    inertial = element.find("inertial")
    if inertial is None:
        return LinkDescription(name, 1.0, np.zeros(3), np.eye(3))
    if inertial.get("auto", "").strip().lower() in ("true", "1"):
        density = float(_word(inertial, "density") or 1000.0)
        solids = [_solid(item, density) for item in element.findall("collision")]
        return link_of(name, np.sum(solids, axis=0), np.eye(4))
    mass = float(_word(inertial, "mass") or 1.0)
    inertia = inertial.find("inertia")
    tensor = np.eye(3)
    if inertia is not None:
        rows = (("ixx", "ixy", "ixz"), ("ixy", "iyy", "iyz"), ("ixz", "iyz", "izz"))
        tensor = np.array([[float(_word(inertia, key) or 0.0) for key in row] for row in rows])
    return link_in(name, mass, _placed(inertial, "")[1], tensor)


def _solid(collision: Element, density: float) -> Array:
    """Return the dynamic parameters `(10,)` of a collision shape in its link."""
    shape = collision[[part.tag for part in collision].index("geometry")][0]
    words = {part.tag: [float(word) for word in (part.text or "").split()] for part in shape}
    solid = pinocchio.Inertia
    if shape.tag == "box":
        make, sizes, volume = solid.FromBox, words["size"], float(np.prod(words["size"]))
    elif shape.tag == "ellipsoid":
        make, sizes = solid.FromEllipsoid, words["radii"]
        volume = float(np.prod(sizes)) * 4.0 * np.pi / 3.0
    else:
        sizes = [*words["radius"], *words.get("length", [])]
        make = getattr(solid, f"From{shape.tag.capitalize()}")
        pole = 0.0 if shape.tag == "cylinder" else 4.0 / 3.0 * sizes[0]
        volume = np.pi * sizes[0] ** 2 * (sum(sizes[1:]) + pole)
    mass = volume * float(_word(collision, "density") or density)
    placed = pinocchio.SE3(_placed(collision, "")[1]).act(make(mass, *sizes))
    return np.array(placed.toDynamicParameters())


def _placed(item: Element, default: str) -> tuple[str, Array]:
    """Return what an element's `<pose>` is relative to, and its `(4, 4)` placement there."""
    pose = item.find("pose")
    values = [] if pose is None else [float(word) for word in (pose.text or "").split()]
    base = default if pose is None else pose.get("relative_to") or default
    if pose is None or not values:
        return base, np.eye(4)
    turn = np.array(values[3:])
    if pose.get("rotation_format") == "quat_xyzw":
        turn = pinocchio.Quaternion(turn / np.sqrt(turn @ turn)).matrix()
    else:
        is_degrees = pose.get("degrees", "").strip().lower() in ("true", "1")
        turn = pinocchio.rpy.rpyToMatrix(np.deg2rad(turn) if is_degrees else turn)
    return base, np.array(pinocchio.SE3(turn, np.array(values[:3])).homogeneous)


def _word(element: Element, tag: str) -> str:
    """Return the text of a child element; empty without it."""
    return (element.findtext(tag) or "").strip()
