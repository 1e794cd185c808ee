"""MJCF: a MuJoCo model to a checked description.

Bodies, joints, masses and rigid equalities of a model are read, and damping, friction and springs
of joints, which scenes take as elements. Armatures and forces of other kinds would change wrenches
as well: they are refused, or left out with a warning. An element that cannot be read exactly is
refused, and the message names it.
"""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ...arrays import Array
from ...errors import ModelError
from ..description import Description, JointDescription, LinkDescription
from ..elements import check_size, check_unique, unique
from ..left_out import dynamics_left_out
from ..words import check_words
from .elements import Attributes, Compiler, DefaultClasses, flag, pose
from .equality import Frames, equalities
from .forces import Forces
from .include import with_includes
from .inertia import Shape, frame_of, link, scaled_to
from .joints import DYNAMICS, joint, untaken

_REFUSED = {
    "attach": "write the attached model into the file",
    "replicate": "write the copies into the file",
    "composite": "write its bodies into the file",
    "flexcomp": "deformable bodies have no joints",
    "plugin": "forces that a plugin makes are unknown here",
}
"""Elements in <body> that change the mechanism and are not read, and what to do."""
_Content = list[tuple[ElementTree.Element, Array, str]]
"""Elements of a body, with the frame `(4, 4)` and the default class around each."""


def parse(root: ElementTree.Element, where: str, path: Path | None, strict: bool) -> Description:
    """Read an MJCF model; equalities `connect` and `weld` become loops, `joint` couplings.

    Joints that share a body get massless links between them. All coordinates are zero in the
    initial configuration, also those to which the file gives another value there (`ref`).

    Args:
        root: its outermost element; it stays as it is.
        where: how messages name the source of the text.
        path: the file, from which included ones are found; None for text.
        strict: whether inertias that no body can have are refused, and forces that no wrench
            considers.

    Raises:
        ModelError: what is wrong, where, and the valid choices.
    """
    root = with_includes(root, where, path)
    check_size(1 + sum(1 for _ in root.iter("body")), where)
    passed_over = check_words(root, "mjcf", where)
    reader = _Reader(root, where, strict)
    for world in root.findall("worldbody"):
        reader.read(world)
    links = reader.links
    if reader.compiler.settotalmass > 0.0:
        links[1:] = scaled_to(links[1:], reader.compiler.settotalmass, where)
    loops, couplings, inactive = equalities(root, reader.classes, reader.frames, where)
    reader.forces.of_sections(root)
    left_out = reader.forces.left_out(strict)
    joints = tuple(reader.frames.joints.values())
    left_out = [*dynamics_left_out(joints, where), *left_out]
    return Description(
        name=root.get("model") or "mechanism",
        links=tuple(links),
        joints=joints,
        order=tuple(reader.frames.joints),
        loops=tuple(loops),
        couplings=tuple(couplings),
        independent_joints=_actuated(root, reader.frames.joints),
        notation="MJCF <equality>" if loops or couplings else "no loops",
        warnings=(*passed_over, *reader.warnings, *inactive, *left_out),
    )


def _actuated(root: ElementTree.Element, joints: Collection[str]) -> tuple[str, ...]:
    """Return the joints of the tree that have an actuator, in the order of these."""
    named = (item.get("joint", "") for section in root.findall("actuator") for item in section)
    return tuple(name for name in dict.fromkeys(named) if name in joints)


class _Reader:
    """Reads the bodies of a file.

    Attributes:
        compiler, classes: settings and default classes.
        links: those that were read, that of the world first.
        frames: what equalities refer to.
        forces: forces that no wrench considers.
        warnings: what is wrong and was accepted.
    """

    def __init__(self, root: ElementTree.Element, where: str, strict: bool) -> None:
        self._where = where
        self._strict = strict
        self.compiler = Compiler.of(root, where)
        self.classes = DefaultClasses(root, where)
        self.forces = Forces(self.classes, where)
        self.warnings: list[str] = []
        self._names = {
            "body": _given(root, ("body",), where),
            "joint": _given(root, ("joint", "freejoint"), where),
        }
        self._counts = {"body": 0, "joint": 0}
        world = self._generated("world", "body")
        self.links = [LinkDescription(world)]
        self.frames = Frames(world, {world: np.eye(4)}, {world: world}, {}, {})

    def read(self, world: ElementTree.Element) -> None:
        """Read a `<worldbody>` and all bodies in it, depth first."""
        waiting = [(world, self.frames.root, np.eye(4), "main")]
        while waiting:
            element, parent, frame, childclass = waiting.pop()
            if element is world:
                name, at = parent, f"{self._where}: worldbody"
            else:
                name, at = self._body(element)
            childclass = self.classes.known(element.get("childclass", childclass), at)
            content = self._contents(element, childclass, at)
            if element is not world:
                attributes = element.attrib
                origin = frame @ pose(attributes, self.compiler, at)
                self._joints(content, name, parent, origin, at)
                self._mass(content, name, at)
                self._note_attributes(attributes, name, at)
            elif any(child.tag in ("inertial", "joint", "freejoint") for child, *_ in content):
                raise ModelError(
                    f"{at}: the world has no joints and no mass; write them in a <body>"
                )
            self._sites(content, name, at)
            waiting.extend(
                (child, name, placement, inner_class)
                for child, placement, inner_class in reversed(content)
                if child.tag == "body"
            )

    def _body(self, element: ElementTree.Element) -> tuple[str, str]:
        """Return the name of a body, and how messages name it."""
        self._counts["body"] += 1
        name = element.get("name") or self._generated(f"body_{self._counts['body']}", "body")
        return name, f"{self._where}: body {name!r}"

    def _contents(self, element: ElementTree.Element, childclass: str, at: str) -> _Content:
        """Return the elements of a body; those in a `<frame>` with their placement in the body."""
        self._check_contents(element, at)
        content: _Content = []
        waiting = [(child, np.eye(4), childclass) for child in reversed(element)]
        while waiting:
            child, frame, inner_class = waiting.pop()
            if child.tag != "frame":
                content.append((child, frame, inner_class))
                continue
            inside = f"{at}: frame {child.get('name', '')!r}"
            self._check_contents(child, inside)
            frame = frame @ pose(child.attrib, self.compiler, inside)
            inner_class = self.classes.known(child.get("childclass", inner_class), inside)
            waiting.extend((item, frame, inner_class) for item in reversed(child))
        return content

    @staticmethod
    def _check_contents(element: ElementTree.Element, at: str) -> None:
        for child in element:
            if child.tag in _REFUSED:
                raise ModelError(f"{at}: <{child.tag}> is not supported: {_REFUSED[child.tag]}")

    def _joints(
        self,
        content: _Content,
        body: str,
        parent: str,
        origin: Array,
        at: str,
    ) -> None:
        """Add the joints of a body, and the links between them.

        Args:
            content: of the body.
            body: its name.
            parent: name of the body that it is in.
            origin: `(4, 4)` placement of the body in that one.
            at: how messages name the body.
        """
        elements = [item for item in content if item[0].tag in ("joint", "freejoint")]
        if not elements:
            self._fix(body, parent, origin)
        frames = self.frames
        for count, (element, frame, childclass) in enumerate(elements, start=1):
            is_last = count == len(elements)
            child = body if is_last else self._generated(f"{body}_{count}", "body")
            described = self._joint(element, frame, childclass, (parent, child), origin)
            if described.type == "floating" and (len(elements) > 1 or parent != frames.root):
                raise ModelError(
                    f"{self._where}: joint {described.name!r}: a free joint is the only joint of "
                    "a body in <worldbody>; write a ball and three slides"
                )
            frames.joints[described.name] = described
            frames.links[child] = frames.links[parent] @ origin
            frames.rigid[child] = child
            if not is_last:
                self.links.append(LinkDescription(child))
            # The links between the joints of a body all stand where the body stands.
            parent, origin = child, np.eye(4)

    def _fix(self, body: str, parent: str, origin: Array) -> None:
        """Add the fixed joint of a body that has no joints."""
        name = self._generated(f"{body}_fixed", "joint")
        axis = np.array([1.0, 0.0, 0.0])
        frames = self.frames
        frames.joints[name] = JointDescription(name, "fixed", parent, body, origin, axis, axis)
        frames.links[body] = frames.links[parent] @ origin
        frames.rigid[body] = frames.rigid[parent]

    def _joint(
        self,
        element: ElementTree.Element,
        frame: Array,
        childclass: str,
        ends: tuple[str, str],
        body: Array,
    ) -> JointDescription:
        """Return a joint between two links; `body` is the placement of the second in the first."""
        self._counts["joint"] += 1
        name = element.get("name") or self._generated(f"joint_{self._counts['joint']}", "joint")
        at = f"{self._where}: joint {name!r}"
        attributes: Attributes = {"type": "free"}
        if element.tag == "joint":
            attributes = self.classes.of(element, childclass, at)
        kind = attributes.get("type", "hinge")
        self.forces.of_joint(attributes, name, DYNAMICS - untaken(attributes, kind, at))
        described, warning = joint(attributes, name, ends, body, frame, self.compiler, at)
        if warning:
            self.warnings.append(warning)
        return described

    def _mass(self, content: _Content, name: str, at: str) -> None:
        """Add the link of a body.

        The geoms of a body that cannot move are not read, since its mass has no effect: they may
        be meshes, whose inertia is not computed here. Where a total mass is stated, they count.
        """
        is_immovable = self.frames.rigid[name] == self.frames.root
        inertials: list[Shape] = []
        geoms: list[Shape] = []
        for element, frame, childclass in content:
            if element.tag == "inertial":
                inertials.append(Shape(element.attrib, frame, f"{at}: inertial"))
            elif element.tag == "geom":
                label = f"{at}: geom {element.get('name') or len(geoms) + 1!r}"
                attributes = self.classes.of(element, childclass, label)
                geoms.append(Shape(attributes, frame, label))
        if len(inertials) > 1:
            raise ModelError(f"{at}: there are {len(inertials)} <inertial>; a body has one mass")
        inertial = inertials[0] if inertials else None
        if is_immovable and self.compiler.settotalmass <= 0.0:
            geoms = []
        described, warnings = link(name, inertial, geoms, self.compiler, at, self._strict)
        self.links.append(described)
        self.warnings.extend(warnings)

    def _note_attributes(self, attributes: Attributes, name: str, at: str) -> None:
        """Note a force that compensates the weight of a body, and a `mocap` body."""
        self.forces.of_body(attributes, name)
        if flag(attributes, "mocap", "false", at):
            if self.frames.rigid[name] != self.frames.root:
                raise ModelError(f"{at}: a mocap body stands in the world, without a joint")
            self.warnings.append(f"{at}: mocap: it stands still")

    def _sites(self, content: _Content, body: str, at: str) -> None:
        """Note the sites of a body that have a name."""
        for element, frame, childclass in content:
            name = element.get("name")
            if element.tag != "site" or not name:
                continue
            label = f"{at}: site {name!r}"
            if name in self.frames.sites:
                raise ModelError(f"{label}: another site has this name")
            attributes = self.classes.of(element, childclass, label)
            self.frames.sites[name] = body, frame @ frame_of(attributes, self.compiler, label)

    def _generated(self, name: str, kind: str) -> str:
        """Return a name, like `name`, for an element to which the file gives none."""
        generated = unique(name, self._names[kind])
        self._names[kind].add(generated)
        return generated


def _given(root: ElementTree.Element, tags: tuple[str, ...], where: str) -> set[str]:
    """Return the names that a file gives to bodies or joints, each once."""
    names = [
        name
        for world in root.findall("worldbody")
        for element in world.iter()
        if element.tag in tags and (name := element.get("name"))
    ]
    check_unique(names, tags[0], where)
    return set(names)
