"""Elements of MJCF: settings, default classes and frames."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from ...arrays import Array
from ...errors import ModelError, choices
from ..elements import numbers

Attributes = Mapping[str, str]
ORIENTATIONS = ("quat", "axisangle", "xyaxes", "zaxis", "euler")
"""Attributes that turn a frame; an element has one of them at most."""
MOST_TERMS = 3
"""Greatest count of coefficients of a damping or stiffness: MuJoCo's are polynomials."""
_LEAST_SINE = 1e-10
"""Sine of an angle below which two directions count as parallel. Entries of unit vectors are
rounded by about 1e-16: the normal of closer directions would have fewer than six correct digits."""


def keyword(value: str, words: Collection[str], at: str) -> str:
    """Return an attribute's value, which must be one of several words."""
    if value not in words:
        raise ModelError(f"{at} is {value!r}, expected one of {', '.join(words)}")
    return value


def number(attributes: Attributes, name: str, default: str, at: str) -> float:
    """Return the number that an attribute states."""
    return float(numbers(attributes.get(name), 1, default, f"{at}: {name}")[0])


def several(attributes: Attributes, name: str, least: int, most: int, at: str) -> Array:
    """Return the numbers of an attribute that may list `least` to `most` of them; none without it.

    Raises:
        ModelError: it lists fewer or more, or anything but finite numbers.
    """
    value = attributes.get(name)
    if value is None:
        return np.zeros(0)
    count = len(value.split())
    if not least <= count <= most:
        raise ModelError(f"{at}: {name} {value!r} is not {least} to {most} finite numbers")
    return numbers(value, count, "", f"{at}: {name}")


def flag(attributes: Attributes, name: str, default: str, at: str) -> bool:
    """Return whether an attribute is true."""
    return keyword(attributes.get(name, default), ("true", "false"), f"{at}: {name}") == "true"


@dataclass(frozen=True)
class Compiler:
    """What `<compiler>` says.

    Attributes:
        angle: radians per unit in which the file gives angles.
        eulerseq: axes about which Euler angles turn; small letters turn with the frame.
        autolimits: whether a range makes a joint limited.
        inertiafromgeom: `false`, `true` or `auto`: whether geoms give bodies their inertia.
        groups: first and last group of geoms that do.
        boundmass, boundinertia: least mass [kg] and principal moment [kg·m²] of a body.
        balanceinertia: whether moments that no body can have are replaced by their mean.
        settotalmass: mass of all bodies together [kg], where positive.
    """

    angle: float = math.pi / 180.0
    eulerseq: str = "xyz"
    autolimits: bool = True
    inertiafromgeom: str = "auto"
    groups: tuple[float, float] = (0.0, 5.0)
    boundmass: float = 0.0
    boundinertia: float = 0.0
    balanceinertia: bool = False
    settotalmass: float = -1.0

    @classmethod
    def of(cls, root: ElementTree.Element, where: str) -> Compiler:
        """Return the settings of all `<compiler>` elements; of a repeated one the last counts.

        Raises:
            ModelError: a setting is malformed or not supported.
        """
        at = f"{where}: compiler"
        stated: dict[str, str] = {}
        for element in root.findall("compiler"):
            stated.update(element.attrib)
        if stated.get("coordinate", "local") != "local":
            raise ModelError(
                f"{at}: coordinate {stated['coordinate']!r} is not supported; load and save the "
                "model in MuJoCo 2.3.3 or older, which makes coordinates local"
            )
        unit_of_angle = keyword(stated.get("angle", "degree"), ("degree", "radian"), f"{at}: angle")
        sequence = stated.get("eulerseq", "xyz")
        if len(sequence) != 3 or set(sequence) - set("xyzXYZ"):
            raise ModelError(f"{at}: eulerseq {sequence!r} is not three letters of xyzXYZ")
        groups = numbers(stated.get("inertiagrouprange"), 2, "0 5", f"{at}: inertiagrouprange")
        return cls(
            angle=math.pi / 180.0 if unit_of_angle == "degree" else 1.0,
            eulerseq=sequence,
            autolimits=flag(stated, "autolimits", "true", at),
            inertiafromgeom=keyword(
                stated.get("inertiafromgeom", "auto"),
                ("false", "true", "auto"),
                f"{at}: inertiafromgeom",
            ),
            groups=(float(groups[0]), float(groups[1])),
            boundmass=number(stated, "boundmass", "0", at),
            boundinertia=number(stated, "boundinertia", "0", at),
            balanceinertia=flag(stated, "balanceinertia", "false", at),
            settotalmass=number(stated, "settotalmass", "-1", at),
        )


class DefaultClasses:
    """The classes of `<default>`: attributes that hold for elements which do not state them."""

    def __init__(self, root: ElementTree.Element, where: str) -> None:
        self._where = where
        self._classes: dict[str, dict[str, dict[str, str]]] = {"main": {}}
        for section in root.findall("default"):
            if section.get("class", "main") != "main":
                raise ModelError(
                    f"{where}: the outermost <default> is class 'main', not "
                    f"{section.get('class')!r}; put it into another <default>"
                )
            self._add(section, "main")
            waiting = [(item, "main") for item in section.findall("default")]
            while waiting:
                element, parent = waiting.pop()
                name = element.get("class")
                if not name or name in self._classes:
                    raise ModelError(
                        f"{where}: <default> in <default> needs a class name of its own, "
                        f"not {name!r}"
                    )
                self._classes[name] = dict(self._classes[parent])
                self._add(element, name)
                waiting.extend((item, name) for item in element.findall("default"))

    def _add(self, section: ElementTree.Element, name: str) -> None:
        content = self._classes[name]
        for element in section:
            if element.tag != "default":
                content[element.tag] = merged(content.get(element.tag, {}), element.attrib)

    def known(self, name: str, at: str) -> str:
        """Return the name of a class.

        Raises:
            ModelError: there is no such class.
        """
        if name not in self._classes:
            raise ModelError(
                f"{at}: default class {name!r} does not exist; classes: "
                f"{choices(self._classes, name)}"
            )
        return name

    def of(
        self, element: ElementTree.Element, childclass: str, at: str, kind: str | None = None
    ) -> dict[str, str]:
        """Return an element's attributes, completed by those of its class.

        Args:
            element: the element, which may name a class.
            childclass: the class that counts otherwise, that of the body or frame around it.
            at: how messages name the element.
            kind: tag under which the class lists its defaults, if not the element's tag.
        """
        name = self.known(element.get("class") or childclass, at)
        return merged(self._classes[name].get(kind or element.tag, {}), element.attrib)


def merged(base: Attributes, over: Attributes) -> dict[str, str]:
    """Return attributes over those of a class, as MuJoCo combines them.

    An orientation replaces that of the class, also where another attribute describes it. A size
    that lists fewer numbers than that of the class keeps the rest of them.
    """
    kept = dict(base)
    if any(name in over for name in ORIENTATIONS):
        for name in ORIENTATIONS:
            kept.pop(name, None)
    kept.update(over)
    if "size" in over:
        sizes = over["size"].split()
        kept["size"] = " ".join(sizes + base.get("size", "").split()[len(sizes) :])
    return kept


def pose(attributes: Attributes, compiler: Compiler, at: str) -> Array:
    """Return the `(4, 4)` placement that pos and an orientation describe."""
    result = np.eye(4)
    result[:3, 3] = numbers(attributes.get("pos"), 3, "0 0 0", f"{at}: pos")
    result[:3, :3] = _orientation(attributes, compiler, at)
    return result


def segment(attributes: Attributes, at: str) -> tuple[Array, float]:
    """Return the `(4, 4)` placement and half the length [m] of a shape between two points.

    Its frame is in the middle; its z axis points to the first point, as in MuJoCo.
    """
    ends = numbers(attributes.get("fromto"), 6, "", f"{at}: fromto")
    along = ends[:3] - ends[3:]
    result = np.eye(4)
    result[:3, 3] = 0.5 * (ends[:3] + ends[3:])
    result[:3, :3] = _from_z(unit(along, f"{at}: fromto"))
    return result, 0.5 * float(np.linalg.norm(along))


def unit(vector: Array, at: str) -> Array:
    """Return a vector scaled to the length 1.

    Raises:
        ModelError: it has no direction.
    """
    # The squares of very small components would vanish.
    greatest = float(np.max(np.abs(vector)))
    if greatest == 0.0:
        raise ModelError(f"{at}: a vector of zeros has no direction")
    scaled = vector / greatest
    return scaled / np.linalg.norm(scaled)


def rotation_of_quaternion(quaternion: Array, at: str) -> Array:
    """Return the `(3, 3)` rotation of a quaternion w x y z of any length."""
    w, x, y, z = unit(quaternion, at)
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def _orientation(attributes: Attributes, compiler: Compiler, at: str) -> Array:
    """Return the `(3, 3)` rotation that one of `ORIENTATIONS` describes."""
    stated = [name for name in ORIENTATIONS if name in attributes]
    if len(stated) > 1:
        raise ModelError(f"{at}: {' and '.join(stated)} both turn it; keep one of them")
    if not stated:
        return np.eye(3)
    name = stated[0]
    at = f"{at}: {name}"
    count = {"quat": 4, "axisangle": 4, "xyaxes": 6, "zaxis": 3, "euler": 3}[name]
    values = numbers(attributes[name], count, "", at)
    if name == "quat":
        return rotation_of_quaternion(values, at)
    if name == "axisangle":
        return _turn(unit(values[:3], at), compiler.angle * values[3])
    if name == "zaxis":
        return _from_z(unit(values, at))
    if name == "xyaxes":
        return _from_axes(values[:3], values[3:], at)
    return _from_euler_angles(compiler.angle * values, compiler.eulerseq)


def _from_axes(x: Array, y: Array, at: str) -> Array:
    """Return the `(3, 3)` rotation to an x axis and a y axis, made normal to each other."""
    x, y = unit(x, at), unit(y, at)
    y = y - x * (x @ y)
    if np.linalg.norm(y) < _LEAST_SINE:
        raise ModelError(f"{at}: both axes have the same direction")
    y = y / np.linalg.norm(y)
    return np.stack([x, y, np.cross(x, y)], axis=1)


def _from_euler_angles(angles: Array, sequence: str) -> Array:
    """Return the `(3, 3)` rotation of angles [rad] about axes in a sequence.

    Small letters are axes that turn with the frame, capital letters axes that stand still.
    """
    result = np.eye(3)
    for letter, angle in zip(sequence, angles, strict=True):
        turn = _turn(np.eye(3)["xyz".index(letter.lower())], angle)
        result = result @ turn if letter.islower() else turn @ result
    return result


def _turn(axis: Array, angle: float) -> Array:
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross)


def _from_z(direction: Array) -> Array:
    """Return the shortest `(3, 3)` rotation from the z axis to a unit vector.

    To the vector -z, half a turn about any axis normal to z is as short; x is taken, as in MuJoCo.
    """
    across = np.array([-direction[1], direction[0], 0.0])
    sine = float(np.linalg.norm(across))
    axis = across / sine if sine > _LEAST_SINE else np.array([1.0, 0.0, 0.0])
    return _turn(axis, math.atan2(sine, direction[2]))
