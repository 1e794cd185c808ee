"""SDF: a model of SDFormat, versions 1.4 to 1.12, to a checked description.

Links, joints, masses and gears of one model are read. A joint is an edge of a graph here: a link
may be the child of several joints, and joints may form rings. `spanning_tree` says which of them
become loops. All coordinates are zero in the poses of the links, which close all loops.

The world is the root. A link that no joint carries from the world is free in SDF: it gets a
`floating` joint, and a warning says how to hold it. A static model stands still as a whole.

Damping, friction and springs of joints are read, which scenes take as elements. Wind and other
forces would change wrenches as well: they are refused, or left out with a warning. An element that
cannot be read exactly is refused, and the message names it.
"""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any
from xml.etree import ElementTree

import numpy as np

from ....kit.arrays import Array, inverse
from ....kit.errors import ModelError, choices
from ....kit.frozen import frozen
from ..description import CouplingDescription, Description, JointDescription, LinkDescription
from ..elements import (
    DIRECTION_TOLERANCE,
    LEAST_MASS,
    SINGLE_TYPES,
    check_size,
    numbers,
    only,
    unique,
)
from ..left_out import dynamics_left_out, forces_left_out
from ..mimics import check_mimics, default_name
from ..urdf import MOMENTS, check_inertia, tensor_of
from ..words import check_words
from .elements import acting, flag, number, pose, text
from .frames import WORLD, NamedFrames
from .joints import GEARBOX, Edge, SpanningTree, axis_of, edge, ends, kind_of, spanning_tree
from .plain import is_static, plain
from .solids import solid

_VERSIONS = ((1, 4), (1, 12))
"""First and last version that is read."""
_GRAVITY = "0 0 -9.8"
"""That of a world which says nothing of it [m/s²]. Source: SDFormat 1.12, `<world>`."""
_IGNORED = ("plugin", "gripper")
"""Elements of a model that may make forces of their own."""


def parse(
    root: ElementTree.Element, where: str, strict: bool, name: str | None = None
) -> Description:
    """Read a model of an SDF text.

    Args:
        root: its outermost element.
        where: how messages name the source of the text.
        strict: whether inertias that no body can have are refused, unknown words, and forces that
            no wrench considers.
        name: of the model; None where there is only one.

    Raises:
        ModelError: what is wrong, where, and the valid choices.
    """
    version = version_of(root, where)
    warnings = check_words(root, "sdf", where, strict)
    model, besides = plain(root, version, where, strict, name)
    check_size(1 + len(model.findall("link")), where)
    _check_contents(model, where)
    reader = _Reader(model, version, where, strict)
    description = reader.description([*warnings, *besides])
    return replace(description, **_gravity(root, model, where))


def _gravity(root: ElementTree.Element, model: ElementTree.Element, where: str) -> dict[str, Any]:
    """Return what the world of a model says of gravity; nothing where it stands in no world."""
    for world in root.findall("world"):
        if any(item.get("name") == model.get("name") for item in world.findall("model")):
            # Versions before 1.6 have it among what is about the solver.
            owners = world, *world.findall("physics")
            stated = [item for owner in owners for item in owner.findall("gravity")]
            at = f"{where}: world {world.get('name')!r}: gravity"
            given = (stated[0].text or "").strip() if stated else _GRAVITY
            return {"gravity": numbers(given, 3, "", at), "states_gravity": bool(stated)}
    return {}


def version_of(root: ElementTree.Element, where: str) -> tuple[int, int]:
    """Return the version of the format that a text states."""
    stated = root.get("version") or ""
    if not re.fullmatch(r"[0-9]+\.[0-9]+", stated):
        raise ModelError(f"{where}: <sdf> needs its version, such as 1.9, not {stated!r}")
    major, minor = (int(word) for word in stated.split("."))
    first, last = _VERSIONS
    if not first <= (major, minor) <= last:
        raise ModelError(
            f"{where}: SDF {stated} is not read, only versions {first[0]}.{first[1]} to "
            f"{last[0]}.{last[1]}; `gz sdf -p FILE` converts older ones"
        )
    return major, minor


def _check_contents(model: ElementTree.Element, where: str) -> None:
    """Refuse what would add links to the model, or places that older versions left open."""
    for tag, advice in (
        ("include", "write the included model's links and joints into the file"),
        ("link/frame", "write it in the <model>"),
        ("joint/frame", "write it in the <model>"),
        ("link/inertial/frame", "write a <pose>"),
    ):
        if model.find(tag) is not None:
            parent = tag.rpartition("/")[0].rpartition("/")[2] or "model"
            raise ModelError(
                f"{where}: <{tag.rpartition('/')[2]}> in <{parent}> is not read: {advice}"
            )


class _Reader:
    def __init__(
        self, model: ElementTree.Element, version: tuple[int, int], where: str, strict: bool
    ) -> None:
        self._model, self._version = model, version
        self._where, self._strict = where, strict
        self._frames = NamedFrames(model, version, where)
        self._frames.check()
        self._forces: list[str] = []
        self._warnings: list[str] = []
        self._placements = {WORLD: np.eye(4)}
        self._joint_names = {item.get("name", "") for item in model.findall("joint")}

    def description(self, warnings: list[str]) -> Description:
        """Return the model's description; `warnings` are those that were found before."""
        links = [LinkDescription(WORLD), *(self._link(item) for item in self._of("link"))]
        edges = [self._edge(item) for item in self._of("joint") if not self._is_gearbox(item)]
        if is_static(self._model, self._where):
            tree, joints, couplings = SpanningTree(), self._held(edges), []
        else:
            tree = spanning_tree(self._frames.links, self._frames.canonical, edges)
            joints = self._joints(tree, edges)
            couplings = self._couplings(joints)
        self._note_flag(self._model, "enable_wind", "false", "model")
        for tag in _IGNORED:
            for item in self._of(tag):
                self._warnings.append(
                    f"{self._where}: <{tag}> {item.get('name', '')!r} passed over: forces that it "
                    "makes are unknown here"
                )
        loops = tuple(item.loop(self._placements) for item in tree.loops)
        left_out = dynamics_left_out([*joints, *loops], self._where)
        left_out += forces_left_out(self._forces, self._where, self._strict)
        return Description(
            name=self._model.get("name") or "mechanism",
            links=tuple(links),
            joints=tuple(joints),
            order=tuple(joint.name for joint in joints),
            loops=loops,
            couplings=tuple(couplings),
            notation="SDF joints beyond a tree" if tree.loops else "no loops",
            warnings=(*warnings, *self._warnings, *left_out),
            frames=frozen({name: self._carried(name) for name in self._frames.further}),
        )

    def _carried(self, name: str) -> tuple[str, Array]:
        """Return the link that a frame moves with, and its `(4, 4)` placement there."""
        at = f"{self._where}: {name!r}"
        link, placement = self._frames.link(name, at), self._frames.placement(name, at)
        return link, inverse(self._frames.placement(link, at)) @ placement

    def _of(self, tag: str) -> list[ElementTree.Element]:
        return self._model.findall(tag)

    def _is_gearbox(self, joint: ElementTree.Element) -> bool:
        return kind_of(joint, f"{self._where}: joint {joint.get('name')!r}") == GEARBOX

    def _edge(self, element: ElementTree.Element) -> Edge:
        found = edge(element, self._frames, self._version, self._where)
        self._warnings += found.warnings
        self._forces += found.forces
        return found

    def _link(self, element: ElementTree.Element) -> LinkDescription:
        name = element.get("name", "")
        at = f"{self._where}: link {name!r}"
        self._placements[name] = self._frames.placement(name, at)
        self._note_forces(element, at)
        inertial = only(element, "inertial", at)
        if inertial is None:
            self._warnings.append(f"{at}: without <inertial>, SDF gives it 1 kg and 1 kg·m²")
            return LinkDescription(name, 1.0, np.zeros(3), np.eye(3))
        if flag(inertial.get("auto", "false"), f"{at}: inertial auto"):
            return self._solid(name, element, inertial, at)
        stated = only(inertial, "pose", at)
        if stated is not None and (stated.get("relative_to") or stated.get("frame")):
            raise ModelError(f"{at}: the pose of <inertial> is in the link; it names no frame")
        return self._massive(name, inertial, pose(inertial, f"{at}: inertial"), at)

    def _solid(
        self, name: str, link: ElementTree.Element, inertial: ElementTree.Element, at: str
    ) -> LinkDescription:
        """Return a link with the mass of its collision shapes, by their density."""
        for tag in ("mass", "pose", "inertia"):
            if inertial.find(tag) is not None:
                raise ModelError(f'{at}: <{tag}> and auto="true" exclude each other; keep one')
        mass, centre, tensor = solid(link, number(inertial, "density", "1000", at), at)
        return LinkDescription(name, mass, centre, tensor)

    def _note_forces(self, link: ElementTree.Element, at: str) -> None:
        """Note weight that is switched off, wind, decay and added mass of a link."""
        name = f"link {link.get('name')!r}"
        for tag, default in (("gravity", "true"), ("enable_wind", "false"), ("kinematic", "false")):
            self._note_flag(link, tag, default, name)
        decay = only(link, "velocity_decay", at)
        if decay is not None:
            words = ("linear", "angular")
            self._forces += acting(decay, words, f"{name}: velocity_decay", self._where)
        inertial = only(link, "inertial", at)
        added = None if inertial is None else only(inertial, "fluid_added_mass", at)
        if added is not None:
            tags = [child.tag for child in added]
            self._forces += acting(added, tags, f"{name}: fluid_added_mass", self._where)

    def _note_flag(self, element: ElementTree.Element, tag: str, default: str, name: str) -> None:
        word = text(element, tag, default, f"{self._where}: {name}")
        if flag(word, f"{self._where}: {name}: {tag}") != (default == "true"):
            self._forces.append(f"{name}: {tag} {word}")

    def _massive(
        self, name: str, inertial: ElementTree.Element, frame: Array, at: str
    ) -> LinkDescription:
        """Return a link with the mass and inertia of an `<inertial>` whose frame is given."""
        mass = number(inertial, "mass", "1", at)
        tensor = self._tensor(inertial, at)
        if mass == 0.0 and not np.any(tensor):
            return LinkDescription(name)
        if mass < LEAST_MASS and (self._strict or mass):
            raise ModelError(
                f"{at}: mass {mass:g} kg is not positive; a massless link has moments of zero, too"
                + ("; load(..., strict=False) accepts it" if mass == 0.0 else "")
            )
        if mass == 0.0:
            self._warnings.append(f"{at}: mass 0 kg: an inertia without mass")
        warning = check_inertia(tensor, at, self._strict)
        if warning:
            self._warnings.append(warning)
        turn = frame[:3, :3]
        return LinkDescription(name, mass, frame[:3, 3], turn @ tensor @ turn.T)

    def _tensor(self, inertial: ElementTree.Element, at: str) -> Array:
        """Return the inertia `(3, 3)` about the centre of mass, in the axes of `<inertial>`."""
        inertia = only(inertial, "inertia", at)
        if inertia is None:
            self._warnings.append(f"{at}: without <inertia>, SDF gives it 1 kg·m²")
            return np.eye(3)
        moments = []
        for tag in MOMENTS:
            default = "" if tag in ("ixx", "iyy", "izz") else "0"
            value = text(inertia, tag, default, at)
            moments.append(float(numbers(value, 1, "", f"{at}: inertia {tag}")[0]))
        return tensor_of(*moments)

    def _joints(self, tree: SpanningTree, edges: list[Edge]) -> list[JointDescription]:
        """Return the joints of the tree in file order, after those of links that float."""
        joints = []
        for link in tree.floating:
            joint = self._to_world(link, "floating")
            joints.append(joint)
            self._warnings.append(
                f"{self._where}: link {link!r} floats (joint {joint.name!r}), as no joint carries "
                f'it from the world; <joint type="fixed"> with parent world holds it'
            )
        reversed_of = {item.name: is_reversed for item, is_reversed in tree.joints}
        joints += [
            item.joint(self._placements, reversed_of[item.name])
            for item in edges
            if item.name in reversed_of
        ]
        return joints

    def _held(self, edges: list[Edge]) -> list[JointDescription]:
        """Return the joints that hold each link of a static model, whose own do not move."""
        self._warnings += [
            f"{self._where}: joint {item.name!r} left out: the model is static" for item in edges
        ]
        return [self._to_world(link, "fixed") for link in self._frames.links]

    def _to_world(self, link: str, kind: str) -> JointDescription:
        """Return a joint of a type between the world and a link, which the file does not have."""
        name = unique(f"{link}_{kind}", self._joint_names)
        self._joint_names.add(name)
        axis = np.array([1.0, 0.0, 0.0])
        return JointDescription(name, kind, WORLD, link, self._placements[link], axis, axis)

    def _couplings(self, joints: list[JointDescription]) -> list[CouplingDescription]:
        """Return the gearboxes, and the axes that mimic others, of the joints of the tree."""
        self._tree = {joint.name: joint for joint in joints}
        self._carriers = {joint.child: joint for joint in joints}
        found: list[CouplingDescription] = []
        for element in self._of("joint"):
            if self._is_gearbox(element):
                found.append(self._gearbox(element))
            for tag in ("axis", "axis2"):
                mimic = element.find(f"{tag}/mimic")
                if mimic is not None:
                    found.append(self._mimic(element, tag, mimic))
                    check_mimics(found, self._where)
        return found

    def _gearbox(self, element: ElementTree.Element) -> CouplingDescription:
        """Return a gearbox, which makes two angles, of parent and child on a third body, a ratio.

        It couples links, whose motions a description adds up from their nearest common ancestor. So
        it says the same only of two hinges of the tree that turn on the same body.
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
        first, second = hinges
        if first is second or self._body(first.parent) != self._body(second.parent):
            raise ModelError(
                f"{at}: only two joints on the same body can be coupled, not {first.name!r} on "
                f"{first.parent!r} and {second.name!r} on {second.parent!r}"
            )
        return CouplingDescription(name, first.child, second.child, _ratio(ratio, at))

    def _mimic(
        self, joint: ElementTree.Element, tag: str, mimic: ElementTree.Element
    ) -> CouplingDescription:
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
        coupling = unique(default_name(name), self._joint_names)
        self._joint_names.add(coupling)
        return CouplingDescription(
            coupling, followed.name, follower.name, _ratio(ratio, at), offset, of_joints=True
        )

    def _simple(self, name: str, at: str) -> JointDescription:
        joint = self._tree.get(name)
        if joint is None or joint.type not in SINGLE_TYPES:
            known = [item.name for item in self._tree.values() if item.type in SINGLE_TYPES]
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
            or hinge.type not in ("revolute", "continuous")
            or self._body(hinge.parent) != self._body(base)
        ):
            raise ModelError(
                f"{at}: no hinge of the tree turns {link!r} on the reference body {base!r}; write "
                "one, whose parent is that body"
            )
        own = self._frames.joint_placement(hinge.name, at)[:3, :3] @ hinge.axis
        if np.linalg.norm(np.cross(own, axis)) > DIRECTION_TOLERANCE:
            raise ModelError(f"{at}: it is not parallel to the axis of the hinge {hinge.name!r}")
        return hinge, 1.0 if own @ axis > 0.0 else -1.0

    def _body(self, link: str) -> str:
        """Return the first of the links that fixed joints make one body with a link."""
        while link != WORLD and self._carriers[link].type == "fixed":
            link = self._carriers[link].parent
        return link


def _ratio(ratio: float, at: str) -> float:
    if ratio == 0.0:
        raise ModelError(f"{at}: a ratio of zero would hold a joint, not couple it")
    return ratio
