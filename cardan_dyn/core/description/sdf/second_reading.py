"""Second reading of SDF: the numbers of a model, read once more for the proof.

It shares nothing with the first reader but the `plain` model and the decisions which joints are a
tree and which way round they stand; what the first reader checked is not checked again.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ....kit.arrays import Array
from ..description import LinkDescription
from .plain import plain

if TYPE_CHECKING:
    from ..description import (
        CouplingDescription,
        Description,
        JointDescription,
        LoopDescription,
    )

_STANDS = "world"
_FIRST_NAMED = 1.07
"""Version, its minor part in hundredths, from which on frames can be named."""
_LAST_IN_MODEL = 1.04
"""Last version in which axes are those of the model."""


def reread(description: Description, root: Element, name: str | None = None) -> Description:
    """Return a description with the numbers of its text: masses, placements, axes, ratios.

    Args:
        description: what the first reader found.
        root: outermost element of the text.
        name: of the model; None where there is only one.
    """
    version = root.attrib["version"]
    major, minor = version.split(".")
    model, _ = plain(root, (int(major), int(minor)), "SDF", strict=False, model=name)
    return _Numbers(model, version).of(description)


def loops_in_urdf(robot: Element, loops: Iterable[LoopDescription]) -> dict[str, LoopDescription]:
    """Return loops, by name, with the numbers of joints that a URDF's `<gazebo>` elements state.

    The URDF is taken for a model whose links are placed relative to each other, as its joints say.
    """
    model = Element("model")
    names = {link.attrib["name"] for link in robot.findall("link")}
    added = {item.attrib["name"]: item for item in robot.findall("gazebo/joint")}
    joints = robot.findall("joint")
    carried = {child.attrib["link"]: item for item in joints for child in item.findall("child")}
    for name in names:
        body = SubElement(model, "link", name=name)
        if name not in carried:
            continue
        parent, origin = carried[name].find("parent"), carried[name].find("origin")
        pose = SubElement(body, "pose", relative_to="" if parent is None else parent.attrib["link"])
        stated = {} if origin is None else origin.attrib
        pose.text = f"{stated.get('xyz', '0 0 0')} {stated.get('rpy', '0 0 0')}"
    for link, item in carried.items():
        if item.attrib["name"] not in {*names, *added}:
            SubElement(model, "frame", name=item.attrib["name"], attached_to=link)
    model.extend([*robot.findall("gazebo/frame"), *added.values()])
    numbers = _Numbers(model, "1.7")
    return {loop.name: numbers.loop(loop) for loop in loops if loop.name in added}


class _Numbers:
    """The numbers of a model.

    Attributes:
        places: `(4, 4)` placements in the world; of joints under a name that begins with a blank.
    """

    def __init__(self, model: Element, version: str) -> None:
        self._model = model
        major, minor = version.split(".")
        self._version = int(major) + int(minor) / 100.0
        self._links = {item.attrib["name"]: item for item in self._model.findall("link")}
        self._joints = {item.attrib["name"]: item for item in self._model.findall("joint")}
        self.places = self._placed()

    def _placed(self) -> dict[str, Array]:
        """Return all placements, each as soon as that is known to which it is relative."""
        waiting: dict[str, tuple[str, Array]] = {}
        for name, item in self._links.items():
            waiting[name] = self._relative(item, "__model__")
        for item in self._model.findall("frame"):
            base = item.get("attached_to") or "__model__"
            waiting[item.attrib["name"]] = self._relative(item, base)
        for name, item in self._joints.items():
            waiting[f" {name}"] = self._relative(item, _word(item, "child"))
        if self._version >= _FIRST_NAMED:
            waiting |= {name: (f" {name}", np.eye(4)) for name in self._joints}
        placed = self._settled(waiting, {"__model__": np.eye(4), _STANDS: np.eye(4)})
        model = _matrix(self._model.find("pose"))
        anchor = self._model.get("placement_frame")
        if anchor:
            model = model @ np.linalg.inv(placed[anchor])
        return self._settled(waiting, {"__model__": model, _STANDS: np.eye(4)})

    @staticmethod
    def _settled(
        waiting: dict[str, tuple[str, Array]], known: dict[str, Array]
    ) -> dict[str, Array]:
        left = dict(waiting)
        while left:
            ready = [name for name, (base, _) in left.items() if base in known]
            if not ready:
                raise ValueError(f"{sorted(left)} stand nowhere, which the first reader places")
            for name in ready:
                base, local = left.pop(name)
                known[name] = known[base] @ local
        return known

    @staticmethod
    def _relative(item: Element, default: str) -> tuple[str, Array]:
        pose = item.find("pose")
        if pose is None:
            return default, np.eye(4)
        return pose.get("relative_to") or pose.get("frame") or default, _matrix(pose)

    def of(self, description: Description) -> Description:
        """Return a description with these numbers."""
        hinges = {joint.child: joint for joint in description.joints}
        return replace(
            description,
            links=tuple(
                _link(link.name, self._links[link.name])
                if link.name in self._links
                else LinkDescription(link.name)
                for link in description.links
            ),
            joints=tuple(map(self._joint, description.joints)),
            loops=tuple(map(self.loop, description.loops)),
            couplings=tuple(self._coupling(item, hinges) for item in description.couplings),
        )

    def _joint(self, joint: JointDescription) -> JointDescription:
        element = self._joints.get(joint.name)
        parent, child = self.places[joint.parent], self.places[joint.child]
        if element is None:
            # It joins the link with the world, and stands where the link does.
            return replace(joint, origin=child, child_placement=np.eye(4))
        frame = self.places[f" {joint.name}"]
        axis, axis_2 = self._axes(joint.type, element)
        return replace(
            joint,
            origin=np.linalg.solve(parent, frame),
            child_placement=np.linalg.solve(frame, child),
            axis=axis,
            axis_2=axis_2,
        )

    def loop(self, loop: LoopDescription) -> LoopDescription:
        """Return a loop with its placements and axes."""
        frame = self.places[f" {loop.name}"]
        axis, axis_2 = self._axes(loop.type, self._joints[loop.name])
        return replace(
            loop,
            predecessor_origin=np.linalg.solve(self.places[loop.predecessor], frame),
            successor_origin=np.linalg.solve(self.places[loop.successor], frame),
            axis=axis,
            axis_2=axis_2,
        )

    def _axes(self, kind: str, element: Element) -> tuple[Array, Array]:
        if kind in ("fixed", "spherical"):
            return np.array([1.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0])
        axis = self._axis(element, "axis")
        return axis, self._axis(element, "axis2") if kind == "universal" else axis

    def _axis(self, element: Element, tag: str) -> Array:
        """Return a `(3,)` unit axis in the joint's frame."""
        axis = element.find(tag)
        xyz = None if axis is None else axis.find("xyz")
        words = "0 0 1" if xyz is None or not xyz.text else xyz.text
        direction = np.array(words.split(), dtype=float)
        direction = direction / np.sqrt(direction @ direction)
        named = None if xyz is None else xyz.get("expressed_in")
        flag = "" if axis is None else _word(axis, "use_parent_model_frame").lower()
        if self._version <= _LAST_IN_MODEL or flag in ("true", "1"):
            named = "__model__"
        if not named:
            return direction
        own = self.places[f" {element.attrib['name']}"]
        return np.linalg.solve(own[:3, :3], self.places[named][:3, :3] @ direction)

    def _coupling(
        self, coupling: CouplingDescription, hinges: dict[str, JointDescription]
    ) -> CouplingDescription:
        """Return a coupling with the ratio of its gearbox, or of the axis that mimics another."""
        if coupling.of_joints:
            mimic = self._joints[coupling.successor].find("axis/mimic")
            ratio, offset, reference = (
                float((mimic is not None and _word(mimic, tag)) or default)
                for tag, default in (("multiplier", 1.0), ("offset", 0.0), ("reference", 0.0))
            )
            return replace(coupling, ratio=ratio, offset=offset - ratio * reference)
        gear = self._joints[coupling.name]
        ratio = -float(_word(gear, "gearbox_ratio") or 1.0)
        for tag, link in (("axis", coupling.predecessor), ("axis2", coupling.successor)):
            hinge = hinges[link].name
            own = self.places[f" {hinge}"][:3, :3] @ self._axis(self._joints[hinge], "axis")
            stated = self.places[f" {coupling.name}"][:3, :3] @ self._axis(gear, tag)
            ratio *= np.sign(own @ stated)
        return replace(coupling, ratio=float(ratio), offset=0.0)


def _link(name: str, element: Element) -> LinkDescription:
    """Return a link with the mass and inertia of its element, or those that count without it."""
    inertial = element.find("inertial")
    if inertial is None:
        return LinkDescription(name, 1.0, np.zeros(3), np.eye(3))
    if inertial.get("auto", "").strip().lower() in ("true", "1"):
        return _solid(name, element, float(_word(inertial, "density") or 1000.0))
    mass = float(_word(inertial, "mass") or 1.0)
    frame = _matrix(inertial.find("pose"))
    inertia = inertial.find("inertia")
    tensor = np.eye(3)
    if inertia is not None:
        rows = (("ixx", "ixy", "ixz"), ("ixy", "iyy", "iyz"), ("ixz", "iyz", "izz"))
        tensor = np.array([[float(_word(inertia, key) or 0.0) for key in row] for row in rows])
    turn = frame[:3, :3]
    return LinkDescription(name, mass, frame[:3, 3], np.einsum("ij,jk,lk->il", turn, tensor, turn))


def _solid(name: str, link: Element, density: float) -> LinkDescription:
    """Return a link made of its collision shapes, by their second moments about its origin."""
    mass, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for item in link.findall("collision"):
        own, squares = _second_moments(item[[part.tag for part in item].index("geometry")][0])
        own *= float(_word(item, "density") or density)
        frame = _matrix(item.find("pose"))
        turn, place = frame[:3, :3], frame[:3, 3]
        mass += own
        first += own * place
        second += own * ((turn * squares) @ turn.T + np.outer(place, place))
    centre = first / mass
    second -= mass * np.outer(centre, centre)
    return LinkDescription(name, mass, centre, np.trace(second) * np.eye(3) - second)


def _second_moments(shape: Element) -> tuple[float, Array]:
    """Return the volume of a shape, and the mean squares `(3,)` of coordinates in it."""
    words = {part.tag: [float(word) for word in (part.text or "").split()] for part in shape}
    if shape.tag == "box":
        edges = np.array(words["size"])
        return float(np.prod(edges)), edges**2 / 12.0
    if shape.tag == "ellipsoid":
        radii = np.array(words["radii"])
        return float(np.prod(radii)) * 4.0 * np.pi / 3.0, radii**2 / 5.0
    (radius,) = words["radius"]
    (length,) = words.get("length", [0.0])
    # Slices across the axis at z: discs of radius r(z), whose mean square of x is r²/4.
    pole = radius if shape.tag in ("sphere", "capsule") else 0.0
    volume = np.pi * radius**2 * (length + 4.0 / 3.0 * pole)
    across = np.pi / 4.0 * radius**4 * (length + 16.0 / 15.0 * pole)
    half = length / 2.0
    # ∫z²(R² - (z - h)²) dz over a cap, by powers of the distance from its plane.
    cap = half**2 * 2.0 / 3.0 + half * pole / 2.0 + pole**2 * 2.0 / 15.0
    along = np.pi * radius**2 * (2.0 * half**3 / 3.0 + 2.0 * pole * cap)
    return volume, np.array([across, across, along]) / volume


def _matrix(pose: Element | None) -> Array:
    """Return the `(4, 4)` placement that a `<pose>` states; identity without one."""
    frame = np.eye(4)
    values = [] if pose is None else [float(word) for word in (pose.text or "").split()]
    if pose is None or not values:
        return frame
    if pose.get("rotation_format") == "quat_xyzw":
        quaternion = np.array(values[3:])
        frame[:3, :3] = _turned(quaternion / np.sqrt(quaternion @ quaternion))
    else:
        is_degrees = pose.get("degrees", "").strip().lower() in ("true", "1")
        for axis, angle in enumerate(np.deg2rad(values[3:]) if is_degrees else values[3:]):
            half = np.zeros(4)
            half[axis], half[3] = np.sin(0.5 * angle), np.cos(0.5 * angle)
            frame[:3, :3] = _turned(half) @ frame[:3, :3]
    frame[:3, 3] = values[:3]
    return frame


def _turned(quaternion: Array) -> Array:
    """Return the `(3, 3)` rotation of a unit quaternion x y z w, from its half turns."""
    x, y, z, w = quaternion
    left = np.array([[w, -z, y, x], [z, w, -x, y], [-y, x, w, z], [-x, -y, -z, w]])
    right = np.array([[w, -z, y, -x], [z, w, -x, -y], [-y, x, w, -z], [x, y, z, w]])
    return np.asarray((left @ right)[:3, :3])


def _word(element: Element, tag: str) -> str:
    """Return the text of a child element; empty without it."""
    return (element.findtext(tag) or "").strip()
