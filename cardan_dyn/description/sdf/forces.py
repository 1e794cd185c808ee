"""Forces that an SDF text states and no element is made of: wind, added mass, motors."""

from __future__ import annotations

from xml.etree import ElementTree

from ..elements import only
from ..left_out import forces_left_out
from .elements import flag, number, text

_OF_AXIS = ("damping", "friction", "spring_stiffness")
_AXES = ("axis", "axis2")
_DECAYS = ("linear", "angular")


class Forces:
    """Collects such forces while a text is read."""

    def __init__(self, where: str) -> None:
        self._where = where
        self._noted: list[str] = []

    def of_model(self, model: ElementTree.Element) -> None:
        """Note what a model states for all its links."""
        self._of_flag(model, "enable_wind", "false", "model")

    def of_link(self, link: ElementTree.Element, at: str) -> None:
        """Note what a link states: weight that is switched off, wind, decay, added mass."""
        name = f"link {link.get('name')!r}"
        self._of_flag(link, "gravity", "true", name)
        self._of_flag(link, "enable_wind", "false", name)
        self._of_flag(link, "kinematic", "false", name)
        decay = only(link, "velocity_decay", at)
        if decay is not None:
            self._of_numbers(decay, _DECAYS, f"{name}: velocity_decay")
        inertial = only(link, "inertial", at)
        added = None if inertial is None else only(inertial, "fluid_added_mass", at)
        if added is not None:
            self._of_numbers(added, [child.tag for child in added], f"{name}: fluid_added_mass")

    def of_joint(self, joint: ElementTree.Element, at: str, is_taken: bool = False) -> None:
        """Note what the axes of a joint state, and a motor of the physics engine ODE.

        Args:
            joint: the `<joint>`.
            at: how messages name it.
            is_taken: whether elements can be made of what its axes state.
        """
        name = f"joint {joint.get('name')!r}"
        for tag in () if is_taken else _AXES:
            axis = only(joint, tag, at)
            dynamics = None if axis is None else only(axis, "dynamics", at)
            if dynamics is not None:
                self._of_numbers(dynamics, _OF_AXIS, f"{name}: {tag}")
        for ode in joint.iterfind("physics/ode"):
            self._of_numbers(ode, ("max_force",), f"{name}: physics")

    def left_out(self, strict: bool) -> list[str]:
        """Return a warning for each force that was noted.

        Raises:
            ModelError: there are some, and `strict` refuses them.
        """
        return forces_left_out(self._noted, self._where, strict)

    def _of_flag(self, element: ElementTree.Element, tag: str, default: str, name: str) -> None:
        word = text(element, tag, default, f"{self._where}: {name}")
        if flag(word, f"{self._where}: {name}: {tag}") != (default == "true"):
            self._noted.append(f"{name}: {tag} {word}")

    def _of_numbers(
        self, element: ElementTree.Element, tags: list[str] | tuple[str, ...], name: str
    ) -> None:
        at = f"{self._where}: {name}"
        values = {tag: number(element, tag, "0", at) for tag in tags}
        acting = [f"{tag} {value:g}" for tag, value in values.items() if value]
        if acting:
            self._noted.append(f"{name}: {', '.join(acting)}")
