"""Forces that MJCF states and wrenches leave out: springs, friction, armatures."""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree import ElementTree

import numpy as np

from ...errors import ModelError
from .elements import Attributes, DefaultClasses, several
from .schema import ACTUATORS

_JOINT = ("armature", "damping", "stiffness", "frictionloss", "springdamper")
_TENDON = ("armature", "damping", "stiffness", "frictionloss")
_ACTUATOR = ("armature", "damping")
_FLUID = ("density", "viscosity")
_MOST = 3
"""Most coefficients of a damping or stiffness."""
_SHOWN = 8
"""How many a message lists."""


class Forces:
    """Collects them while a file is read."""

    def __init__(self, classes: DefaultClasses, where: str) -> None:
        self._classes = classes
        self._where = where
        self._found: list[str] = []

    def of_joint(self, attributes: Attributes, name: str) -> None:
        """Note what a joint states, its class included."""
        self._note(attributes, _JOINT, f"joint {name!r}")

    def of_body(self, attributes: Attributes, name: str) -> None:
        """Note whether a body makes up for its weight."""
        self._note(attributes, ("gravcomp",), f"body {name!r}")

    def of_sections(self, root: ElementTree.Element) -> None:
        """Note what tendons, actuators, fluids and deformable bodies state."""
        for option in root.findall("option"):
            self._note(option.attrib, _FLUID, "option")
        for kind, keys, tags in (
            ("tendon", _TENDON, ("spatial", "fixed")),
            ("actuator", _ACTUATOR, ACTUATORS),
        ):
            for element in root.iterfind(f"{kind}/*"):
                if element.tag in tags:
                    name = f"{kind} {element.get('name', element.tag)!r}"
                    default = "tendon" if kind == "tendon" else element.tag
                    at = f"{self._where}: {name}"
                    self._note(self._classes.of(element, "main", at, default), keys, name)
        for element in root.iterfind("deformable/flex"):
            self._found.append(f"flex {element.get('name', '')!r}")

    def left_out(self, strict: bool) -> list[str]:
        """Return what was noted as warnings.

        Raises:
            ModelError: something was, and `strict` refuses it.
        """
        if strict and self._found:
            more = len(self._found) - _SHOWN
            listed = "; ".join(self._found[:_SHOWN]) + (f"; and {more} more" if more > 0 else "")
            raise ModelError(
                f"{self._where}: forces that wrenches leave out: {listed}; load(..., strict=False) "
                "accepts the file and leaves them out"
            )
        return [f"{self._where}: {found} left out of the wrenches" for found in self._found]

    def _note(self, attributes: Attributes, keys: Iterable[str], name: str) -> None:
        at = f"{self._where}: {name}"
        acting = [
            f"{key} {attributes[key]}"
            for key in keys
            if np.any(several(attributes, key, 1, _MOST, at))
        ]
        if acting:
            self._found.append(f"{name}: {', '.join(acting)}")
