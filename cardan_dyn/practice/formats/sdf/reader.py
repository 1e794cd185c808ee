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

from dataclasses import replace
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from ....core.description.description import (
    CouplingDescription,
    Description,
    JointDescription,
    LinkDescription,
    SourceText,
)
from ....core.description.elements import (
    DIRECTION_TOLERANCE,
    SINGLE_TYPES,
    check_size,
    numbers,
    only,
    unique,
)
from ....core.description.left_out import forces_left_out
from ....core.description.mimics import check_mimics, default_name
from ....core.description.urdf import MOMENTS, check_inertia, tensor_of
from ....core.description.words import check_words
from ....kit.arrays import Array, inverse
from ....kit.errors import ModelError, choices
from ....kit.frozen import frozen
from .elements import acting, base_of, flag, inside, number, pose, text
from .frames import WORLD, NamedFrames
from .joints import GEARBOX, SpanningTree, axis_of, edge, ends, kind_of, spanning_tree
from .plain import FIRST_WITH_FRAMES, is_static, plain, version_of
from .solids import solid

_GRAVITY = "0 0 -9.8"
"""That of a world which says nothing of it [m/s²]. Source: SDFormat 1.12, `<world>`."""
_IGNORED = ("plugin", "gripper")
"""Elements of a model that may make forces of their own."""


def parse(root: Element, given: SourceText, where: str, strict: bool) -> Description:
    """Read a model of an SDF text.

    Args:
        root: its outermost element.
        given: the text, and which model is asked for.
        where: how messages name the source of the text.
        strict: whether inertias that no body can have are refused, unknown words, and forces that
            no wrench considers.

    Raises:
        ModelError: what is wrong, where, and the valid choices.
    """
    has_names = version_of(root, where) >= FIRST_WITH_FRAMES
    warnings = check_words(root, "sdf", where, strict)
    model, besides = plain(root, where, strict, given.model)
    check_size(1 + len(model.findall("link")), where)
    _check_contents(model, where)
    reader = _Reader(model, NamedFrames(model, where, has_names), where, strict)
    description = reader.description([*warnings, *besides])
    return replace(description, source=given, **_gravity(root, model, where))


def _gravity(root: Element, model: Element, where: str) -> dict[str, Any]:
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


def _check_contents(model: Element, where: str) -> None:
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
    def __init__(self, model: Element, frames: NamedFrames, where: str, strict: bool) -> None:
        frames.check()
        self._model, self._frames, self._where, self._strict = model, frames, where, strict
        self._forces: list[str] = []
        self._warnings: list[str] = []
        self._placements = {WORLD: np.eye(4)} | {
            name: frames.placement(name, where) for name in frames.links
        }
        self._of_joint = {item.get("name", ""): item for item in model.findall("joint")}
        self._taken = {*self._of_joint}

    def description(self, warnings: list[str]) -> Description:
        """Return the model's description; `warnings` are those that were found before."""
        model, frames, where = self._model, self._frames, self._where
        links = [LinkDescription(WORLD), *map(self._link, model.findall("link"))]
        edges = [
            edge(item, frames, where)
            for name, item in self._of_joint.items()
            if kind_of(item, f"{where}: joint {name!r}") != GEARBOX
        ]
        for item in edges:
            self._warnings += item.warnings
            self._forces += item.forces
        tree, couplings = SpanningTree([], [], []), list[CouplingDescription]()
        if is_static(model, where):
            self._warnings += [
                f"{where}: joint {item.name!r} left out: the model is static" for item in edges
            ]
            joints = [self._to_world(link, "fixed") for link in frames.links]
        else:
            tree = spanning_tree(frames.links, frames.canonical, edges)
            joints = [self._floating(link) for link in tree.floating]
            ways = {item.name: is_reversed for item, is_reversed in tree.joints}
            joints += [
                item.joint(self._placements, ways[item.name]) for item in edges if item.name in ways
            ]
            couplings = self._couplings(joints)
        self._note_flag(model, "enable_wind", "false", "model")
        self._warnings += [
            f"{where}: <{tag}> {item.get('name', '')!r} passed over: forces that it makes are "
            "unknown here"
            for tag in _IGNORED
            for item in model.findall(tag)
        ]
        loops = tuple(item.loop(self._placements) for item in tree.loops)
        left_out = forces_left_out(self._forces, where, self._strict)
        further = {}
        for name in frames.further:
            link, place = frames.link(name, where), frames.placement(name, where)
            further[name] = link, inverse(self._placements[link]) @ place
        return Description(
            name=model.get("name") or "mechanism",
            links=tuple(links),
            joints=tuple(joints),
            order=tuple(joint.name for joint in joints),
            loops=loops,
            couplings=tuple(couplings),
            notation="SDF joints beyond a tree" if tree.loops else "no loops",
            warnings=(*warnings, *self._warnings, *left_out),
            frames=frozen(further),
        )

    def _link(self, element: Element) -> LinkDescription:
        name = element.get("name", "")
        at = f"{self._where}: link {name!r}"
        self._note_forces(element, name, at)
        inertial = only(element, "inertial", at)
        if inertial is None:
            self._warnings.append(f"{at}: without <inertial>, SDF gives it 1 kg and 1 kg·m²")
            return LinkDescription(name, 1.0, np.zeros(3), np.eye(3))
        if flag(inertial.get("auto", "false"), f"{at}: inertial auto"):
            return LinkDescription(name, *solid(element, inertial, at))
        if base_of(inertial):
            raise ModelError(f"{at}: the pose of <inertial> is in the link; it names no frame")
        frame, mass = pose(inertial, f"{at}: inertial"), number(inertial, "mass", "1", at)
        inertia, tensor = only(inertial, "inertia", at), np.eye(3)
        if inertia is None:
            self._warnings.append(f"{at}: without <inertia>, SDF gives it 1 kg·m²")
        else:
            needed = dict.fromkeys(("ixx", "iyy", "izz"), "")
            moments = (
                numbers(text(inertia, tag, needed.get(tag, "0"), at), 1, "", f"{at}: inertia {tag}")
                for tag in MOMENTS
            )
            tensor = tensor_of(*(float(moment[0]) for moment in moments))
        if mass == 0.0 and not np.any(tensor):
            return LinkDescription(name)
        warning = check_inertia(mass, tensor, at, self._strict, "moments of zero, too")
        self._warnings += [warning] * bool(warning)
        turn = frame[:3, :3]
        return LinkDescription(name, mass, frame[:3, 3], turn @ tensor @ turn.T)

    def _note_forces(self, link: Element, name: str, at: str) -> None:
        """Note weight that is switched off, wind, decay and added mass of a link."""
        owner = f"link {name!r}"
        for tag, default in (("gravity", "true"), ("enable_wind", "false"), ("kinematic", "false")):
            self._note_flag(link, tag, default, owner)
        decay, added = (
            inside(link, "velocity_decay", at),
            inside(inside(link, "inertial", at), "fluid_added_mass", at),
        )
        for item, tags in ((decay, ("linear", "angular")), (added, [part.tag for part in added])):
            self._forces += acting(item, tags, f"{owner}: {item.tag}", self._where)

    def _note_flag(self, element: Element, tag: str, default: str, name: str) -> None:
        word = text(element, tag, default, f"{self._where}: {name}")
        if flag(word, f"{self._where}: {name}: {tag}") != (default == "true"):
            self._forces.append(f"{name}: {tag} {word}")

    def _floating(self, link: str) -> JointDescription:
        """Return the joint of a link that no joint carries from the world."""
        joint = self._to_world(link, "floating")
        self._warnings.append(
            f"{self._where}: link {link!r} floats (joint {joint.name!r}), as no joint carries it "
            'from the world; <joint type="fixed"> with parent world holds it'
        )
        return joint

    def _to_world(self, link: str, kind: str) -> JointDescription:
        """Return a joint of a type between the world and a link, which the file does not have."""
        name = unique(f"{link}_{kind}", self._taken)
        return JointDescription(name, kind, WORLD, link, self._placements[link])

    def _couplings(self, joints: list[JointDescription]) -> list[CouplingDescription]:
        """Return the gearboxes, and the axes that mimic others, of the joints of the tree."""
        self._tree = {joint.name: joint for joint in joints}
        self._carriers = {joint.child: joint for joint in joints}
        found: list[CouplingDescription] = []
        for name, element in self._of_joint.items():
            at = f"{self._where}: joint {name!r}"
            if kind_of(element, at) == GEARBOX:
                found.append(self._gearbox(element, name, at))
            for tag in ("axis", "axis2"):
                mimic = element.find(f"{tag}/mimic")
                if mimic is not None:
                    found.append(self._mimic(name, tag, mimic, f"{at}: {tag}: mimic"))
                    check_mimics(found, self._where)
        return found

    def _gearbox(self, element: Element, name: str, at: str) -> CouplingDescription:
        """Return a gearbox, which makes two angles, of parent and child on a third body, a ratio.

        It couples links, whose motions a description adds up from their nearest common ancestor. So
        it says the same only of two hinges of the tree that turn on the same body.
        """
        reference = text(element, "gearbox_reference_body", "", at)
        if not reference:
            raise ModelError(f"{at}: <gearbox_reference_body> is missing")
        base = self._frames.link(reference, f"{at}: gearbox_reference_body")
        placement = self._frames.joint_placement(name, at)
        ratio, hinges = -number(element, "gearbox_ratio", "1", at), []
        for tag, link in zip(("axis", "axis2"), ends(element, self._frames, at), strict=True):
            stated = axis_of(element, tag, placement, self._frames, at)
            hinge, sense = self._hinge(link, base, placement[:3, :3] @ stated, f"{at}: {tag}")
            hinges.append(hinge)
            ratio *= sense
        first, second = hinges
        if first is second or self._body(first.parent) != self._body(second.parent):
            raise ModelError(
                f"{at}: only two joints on the same body can be coupled, not {first.name!r} on "
                f"{first.parent!r} and {second.name!r} on {second.parent!r}"
            )
        return CouplingDescription(name, first.child, second.child, _ratio(ratio, at))

    def _mimic(self, name: str, tag: str, mimic: Element, at: str) -> CouplingDescription:
        if mimic.get("axis", "axis") != "axis" or tag != "axis":
            raise ModelError(f"{at}: only joints with one axis can be coupled")
        leader = mimic.get("joint") or ""
        for joint in (leader, name):
            known = [key for key, item in self._tree.items() if item.type in SINGLE_TYPES]
            if joint not in known:
                raise ModelError(
                    f"{at}: {joint!r} is no joint of the tree with one axis; joints that can be "
                    f"coupled: {choices(known, joint)}"
                )
        ratio = number(mimic, "multiplier", "1", at)
        offset = number(mimic, "offset", "0", at) - ratio * number(mimic, "reference", "0", at)
        if leader == name:
            raise ModelError(f"{at}: a joint cannot mimic itself")
        coupling = unique(default_name(name), self._taken)
        ratio = _ratio(ratio, at)
        return CouplingDescription(coupling, leader, name, ratio, offset, of_joints=True)

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
