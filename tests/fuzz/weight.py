"""Weight: what a description says about masses and places, read a second time.

Nothing here uses the package's readers: what both lose in the same way would not be seen.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np
import yaml

Element = ElementTree.Element

NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
SPACE = " \t\r\n"


class Unclear(Exception):  # noqa: N818
    """The text leaves open what it means, so nothing can be compared."""


class Malformed(Exception):  # noqa: N818
    """What stands in the place of a number is none, and should have been refused."""


@dataclass(frozen=True)
class Body:
    """A link as the text describes it.

    Attributes:
        mass: [kg].
        centre: `(3,)` centre of mass in the link [m].
        joint: name of the joint above it; empty at the root.
        kind: type of that joint.
        parent: name of the link above it.
        xyz: `(3,)` origin of that joint in the parent [m].
        rotation: `(3, 3)` of that joint in the parent.
        axis: `(3,)` axis of that joint.
        moments: sum of its principal moments of inertia [kg·m²].
    """

    mass: float
    centre: np.ndarray
    joint: str
    kind: str
    parent: str
    xyz: np.ndarray
    rotation: np.ndarray
    axis: np.ndarray
    moments: float = 0.0


def numbers(text: str | None, default: str, what: str) -> np.ndarray:
    """Return numbers as XML schemas write them."""
    words = [word for word in re.split(f"[{SPACE}]+", default if text is None else text) if word]
    for word in words:
        if not NUMBER.fullmatch(word):
            raise Malformed(f"{what} {text!r}")
    return np.array([float(word) for word in words])


def _rotation(rpy: np.ndarray) -> np.ndarray:
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return z @ y @ x


def _vector(element: Element | None, key: str, default: str) -> np.ndarray:
    text = None if element is None else element.get(key)
    values = numbers(text, default, key)
    if values.size != len(default.split()):
        raise Malformed(f"{key} {text!r}")
    return values


def urdf(text: str, beside: Mapping[str, str]) -> dict[str, Body]:
    """Return the links of a URDF by name.

    Raises:
        Unclear: the text is no plain URDF.
        Malformed: a number is none.
    """
    try:
        root = ElementTree.fromstring(text.lstrip("\ufeff" + SPACE))
    except ElementTree.ParseError as error:
        raise Unclear(str(error)) from error
    if root.tag != "robot":
        raise Unclear(root.tag)
    changed = _changed_types(beside)
    above: dict[str, Element] = {}
    for joint in root.findall("joint"):
        child = joint.find("child")
        if child is None or child.get("link", "") in above:
            raise Unclear("two parents")
        above[child.get("link", "")] = joint
    bodies = {}
    for link in root.findall("link"):
        name = link.get("name", "")
        inertial = link.find("inertial")
        mass, centre, moments = 0.0, np.zeros(3), 0.0
        if inertial is not None:
            mass = float(_vector(inertial.find("mass"), "value", "0")[0])
            centre = _vector(inertial.find("origin"), "xyz", "0 0 0")
            for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"):
                value = float(_vector(inertial.find("inertia"), key, "0")[0])
                moments += value if key in ("ixx", "iyy", "izz") else 0.0
        joint = above.get(name)
        if joint is None:
            zero = np.zeros(3)
            bodies[name] = Body(mass, centre, "", "", "", zero, np.eye(3), zero, moments)
            continue
        origin, parent = joint.find("origin"), joint.find("parent")
        kind = changed.get(joint.get("name", ""), joint.get("type", ""))
        bodies[name] = Body(
            mass,
            centre,
            joint.get("name", ""),
            kind,
            "" if parent is None else parent.get("link", ""),
            _vector(origin, "xyz", "0 0 0"),
            _rotation(_vector(origin, "rpy", "0 0 0")),
            _vector(joint.find("axis"), "xyz", "1 0 0") if kind != "fixed" else np.zeros(3),
            moments,
        )
    return bodies


def _changed_types(beside: Mapping[str, str]) -> dict[str, str]:
    """Return the joint types that Gepetto's YAML file changes."""
    for name, text in beside.items():
        if name.endswith(("yaml", "yml")):
            try:
                content = yaml.safe_load(text)
            except (yaml.YAMLError, ValueError, RecursionError) as error:
                raise Unclear(str(error)) from error
            if not isinstance(content, dict) or "closed_loop" not in content:
                return {}
            names, kinds = content.get("joint_name", []), content.get("joint_type", [])
            if not (isinstance(names, list) and isinstance(kinds, list)):
                raise Unclear("lists")
            return {str(name): str(kind).lower() for name, kind in zip(names, kinds, strict=False)}
    return {}


def moving(bodies: Mapping[str, Body]) -> dict[str, Body]:
    """Return the links that are not fixed to the root."""
    still = {name for name, body in bodies.items() if not body.joint}
    order = list(bodies.items())
    grown = True
    while grown:
        grown = False
        for name, body in order:
            if name not in still and body.kind == "fixed" and body.parent in still:
                still.add(name)
                grown = True
    return {name: body for name, body in bodies.items() if name not in still}


@dataclass(frozen=True)
class Mjcf:
    """What an MJCF text says.

    Attributes:
        mass: of all bodies that joints can move [kg]; None where shapes or defaults decide it.
        closures: number of equalities that are active.
    """

    mass: float | None
    closures: int


def mjcf(text: str, beside: Mapping[str, str]) -> Mjcf:
    """Read masses and equalities of an MJCF text.

    Raises:
        Unclear: it uses what this reader does not know.
        Malformed: a mass is no number.
    """
    try:
        root = ElementTree.fromstring(text.lstrip("\ufeff" + SPACE))
        for parent in list(root.iter()):
            for index, child in reversed(list(enumerate(parent))):
                if child.tag == "include":
                    parts = ElementTree.fromstring(beside[child.get("file", "")])
                    parent[index : index + 1] = list(parts)
    except (ElementTree.ParseError, KeyError) as error:
        raise Unclear(str(error)) from error
    if root.tag != "mujoco":
        raise Unclear(root.tag)
    closures = sum(
        item.get("active", "true") != "false"
        for equality in root.findall("equality")
        for item in equality
    )
    unknown = {"geom", "frame", "replicate", "composite", "attach", "flexcomp", "default"}
    worlds = root.findall("worldbody")
    if len(worlds) != 1 or any(root.find(f".//{tag}") is not None for tag in unknown):
        return Mjcf(None, closures)
    compiler = root.find("compiler")
    if compiler is not None and set(compiler.attrib) - {"angle"}:
        return Mjcf(None, closures)
    return Mjcf(sum(_mass(body, False) for body in worlds[0].findall("body")), closures)


def _mass(body: Element, moves: bool) -> float:
    """Return the moving mass of a body and all below it; without recursion, for deep ones."""
    total, waiting = 0.0, [(body, moves)]
    while waiting:
        item, moved = waiting.pop()
        moved = moved or any(child.tag in ("joint", "freejoint") for child in item)
        inertials = item.findall("inertial")
        if len(inertials) > 1:
            raise Unclear("several inertials")
        if inertials and moved:
            total += float(_vector(inertials[0], "mass", "0")[0])
        waiting += [(child, moved) for child in item.findall("body")]
    return total
