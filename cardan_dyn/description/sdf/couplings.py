"""Couplings of SDF: gearboxes, and axes that mimic others, where they are ratios of two joints.

A gearbox couples links, whose motions a description adds up from their nearest common ancestor. So
it says the same only of two hinges of the tree that turn on the same body.
"""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np

from ...arrays import Array
from ...errors import ModelError, choices
from ..description import CouplingDescription, JointDescription
from ..elements import SINGLE_TYPES, unique
from ..mimics import check_mimics, default_name
from .elements import number, text
from .frames import WORLD, Frames
from .joints import axis_of, ends

_TURNS = frozenset({"revolute", "continuous"})
_PARALLEL_TOLERANCE = 1e-9
"""Greatest sine between a gearbox's axis and the hinge's: what axes with ten digits have."""


class Couplings:
    """Turns gearboxes and mimicked axes into couplings.

    Attributes:
        couplings: those that were read so far.
    """

    def __init__(
        self,
        joints: list[JointDescription],
        frames: Frames,
        version: tuple[int, int],
        taken: set[str],
        where: str,
    ) -> None:
        """Take the joints of the tree.

        Args:
            joints: all of them.
            frames: of the model.
            version: of the format.
            taken: names of all joints.
            where: how messages name the source of the text.
        """
        self.couplings: list[CouplingDescription] = []
        self._frames, self._version, self._where = frames, version, where
        self._taken = taken
        self._joints = {joint.name: joint for joint in joints}
        self._carriers = {joint.child: joint for joint in joints}

    def add_gearbox(self, element: ElementTree.Element) -> None:
        """Add a gearbox: two angles, from a third body to the parent and to the child.

        Raises:
            ModelError: hinges on that body, about the gearbox's axes, do not make these angles.
        """
        name = element.get("name", "")
        at = f"{self._where}: joint {name!r}"
        reference = text(element, "gearbox_reference_body", "", at)
        if not reference:
            raise ModelError(f"{at}: <gearbox_reference_body> is missing")
        base = self._frames.link(reference, f"{at}: gearbox_reference_body")
        placement = self._frames.joint_placement(name, at)
        ratio = -number(element, "gearbox_ratio", "1", at)
        hinges = []
        for tag, link in zip(("axis", "axis2"), ends(element, self._frames, at), strict=True):
            stated = axis_of(element, tag, placement, self._frames, self._version, at)
            hinge, sign = self._hinge(link, base, placement[:3, :3] @ stated, f"{at}: {tag}")
            hinges.append(hinge)
            ratio *= sign
        self._add(name, hinges[0], hinges[1], ratio, at)

    def add_mimic(self, joint: ElementTree.Element, tag: str, mimic: ElementTree.Element) -> None:
        """Add the coupling of an axis that follows another one.

        Raises:
            ModelError: one of the joints has several axes or closes a loop, or the axes are not in
                the stated relation initially.
        """
        name = joint.get("name", "")
        at = f"{self._where}: joint {name!r}: {tag}: mimic"
        leader = mimic.get("joint") or ""
        if mimic.get("axis", "axis") != "axis" or tag != "axis":
            raise ModelError(f"{at}: only joints with one axis can be coupled")
        followed, follower = (self._simple(item, at) for item in (leader, name))
        ratio = number(mimic, "multiplier", "1", at)
        offset = number(mimic, "offset", "0", at) - ratio * number(mimic, "reference", "0", at)
        if followed is follower:
            raise ModelError(f"{at}: a joint cannot mimic itself")
        coupling = CouplingDescription(
            unique(default_name(name), self._taken),
            followed.name,
            follower.name,
            _ratio(ratio, at),
            offset,
            of_joints=True,
        )
        check_mimics([*self.couplings, coupling], self._where)
        self._taken.add(coupling.name)
        self.couplings.append(coupling)

    def _add(
        self,
        name: str,
        first: JointDescription,
        second: JointDescription,
        ratio: float,
        at: str,
    ) -> None:
        if first is second or self._body(first.parent) != self._body(second.parent):
            raise ModelError(
                f"{at}: only two joints on the same body can be coupled, not {first.name!r} on "
                f"{first.parent!r} and {second.name!r} on {second.parent!r}"
            )
        self._taken.add(name)
        self.couplings.append(
            CouplingDescription(name, first.child, second.child, _ratio(ratio, at))
        )

    def _simple(self, name: str, at: str) -> JointDescription:
        """Return a joint of the tree with one coordinate."""
        joint = self._joints.get(name)
        if joint is None or joint.type not in SINGLE_TYPES:
            known = [item.name for item in self._joints.values() if item.type in SINGLE_TYPES]
            raise ModelError(
                f"{at}: {name!r} is no joint of the tree with one axis; joints that can be "
                f"coupled: {choices(known, name)}"
            )
        return joint

    def _hinge(self, link: str, base: str, axis: Array, at: str) -> tuple[JointDescription, float]:
        """Return the hinge that turns a link on a base, and its sense relative to an axis."""
        hinge = self._carriers.get(self._body(link))
        if (
            hinge is None
            or hinge.type not in _TURNS
            or self._body(hinge.parent) != self._body(base)
        ):
            raise ModelError(
                f"{at}: no hinge of the tree turns {link!r} on the reference body {base!r}; write "
                "one, whose parent is that body"
            )
        own = self._frames.joint_placement(hinge.name, at)[:3, :3] @ hinge.axis
        if np.linalg.norm(np.cross(own, axis)) > _PARALLEL_TOLERANCE:
            raise ModelError(f"{at}: it is not parallel to the axis of the hinge {hinge.name!r}")
        return hinge, 1.0 if own @ axis > 0.0 else -1.0

    def _body(self, link: str) -> str:
        """Return the first of the links that fixed joints make one body with a link."""
        while link != WORLD and self._carriers[link].type == "fixed":
            link = self._carriers[link].parent
        return link


def _ratio(ratio: float, at: str) -> float:
    """Return the ratio of a coupling, which is not zero."""
    if ratio == 0.0:
        raise ModelError(f"{at}: a ratio of zero would hold a joint, not couple it")
    return ratio
