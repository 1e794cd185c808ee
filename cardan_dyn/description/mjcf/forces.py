"""Forces that an MJCF file states and no element is made of: armatures, tendons, fluids."""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree import ElementTree

import numpy as np

from ..left_out import forces_left_out
from .elements import MOST_TERMS, Attributes, DefaultClasses, several

_JOINT = ("armature", "damping", "stiffness", "frictionloss", "springdamper")
_TENDON = ("armature", "damping", "stiffness", "frictionloss")
_ACTUATOR = ("armature", "damping")
_FLUID = ("density", "viscosity")


class Forces:
    """Collects such forces while a file is read."""

    def __init__(self, classes: DefaultClasses, where: str) -> None:
        self._classes = classes
        self._where = where
        self._noted: list[str] = []

    def of_joint(self, attributes: Attributes, name: str, taken: Iterable[str] = ()) -> None:
        """Note what a joint states, its class included, but for attributes that are taken."""
        left = [key for key in _JOINT if key not in taken]
        self._note(attributes, left, f"joint {name!r}")

    def of_body(self, attributes: Attributes, name: str) -> None:
        """Note whether a force compensates the weight of a body."""
        self._note(attributes, ("gravcomp",), f"body {name!r}")

    def of_sections(self, root: ElementTree.Element) -> None:
        """Note what tendons, actuators, fluids and deformable bodies state."""
        for option in root.findall("option"):
            self._note(option.attrib, _FLUID, "option")
        for kind, keys in (("tendon", _TENDON), ("actuator", _ACTUATOR)):
            for element in root.iterfind(f"{kind}/*"):
                name = f"{kind} {element.get('name', element.tag)!r}"
                default = "tendon" if kind == "tendon" else element.tag
                at = f"{self._where}: {name}"
                self._note(self._classes.of(element, "main", at, default), keys, name)
        for element in root.iterfind("deformable/flex"):
            self._noted.append(f"flex {element.get('name', '')!r}")

    def left_out(self, strict: bool) -> list[str]:
        """Return a warning for each force that was noted.

        Raises:
            ModelError: there are some, and `strict` refuses them.
        """
        return forces_left_out(self._noted, self._where, strict)

    def _note(self, attributes: Attributes, keys: Iterable[str], name: str) -> None:
        """Note the attributes among `keys` that are not zero."""
        at = f"{self._where}: {name}"
        acting = [
            f"{key} {attributes[key]}"
            for key in keys
            if np.any(several(attributes, key, 1, MOST_TERMS, at))
        ]
        if acting:
            self._noted.append(f"{name}: {', '.join(acting)}")
