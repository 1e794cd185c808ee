"""MJCF: a MuJoCo model to a checked description.

Bodies, joints, masses and rigid equalities of a model are read, and damping, friction and springs
of joints, which scenes take as elements. Armatures and forces of other kinds would change wrenches
as well: they are refused, or left out with a warning. An element that cannot be read exactly is
refused, and the message names it.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import TypeVar
from xml.etree import ElementTree

import numpy as np

from ...arrays import Array, inverse
from ...errors import ModelError, choices
from ...frozen import frozen
from ..description import (
    CouplingDescription,
    Description,
    Dynamics,
    JointDescription,
    Limits,
    LinkDescription,
    LoopDescription,
)
from ..elements import (
    SINGLE_TYPES,
    at_point,
    check_size,
    check_unique,
    file_text,
    numbers,
    unique,
    xml_root,
)
from ..left_out import dynamics_left_out, forces_left_out
from ..words import check_words
from .elements import (
    MOST_TERMS,
    Attributes,
    Compiler,
    DefaultClasses,
    flag,
    keyword,
    number,
    pose,
    rotation_of_quaternion,
    several,
    unit,
)
from .inertia import MassElement, frame_of, link, scaled_to

DEPTH = 300
"""Greatest depth of elements within each other; the root counts as 1. Deeper models were never
tested."""
_TYPES = {"hinge": "revolute", "slide": "prismatic", "ball": "spherical", "free": "floating"}
"""MJCF's word for a joint to its type."""
_DYNAMICS = {"damping", "stiffness", "frictionloss"}
"""Attributes of a joint of which elements can be made."""
_FORCES = {
    "joint": ("armature", "damping", "stiffness", "frictionloss", "springdamper"),
    "body": ("gravcomp",),
    "option": ("density", "viscosity"),
    "tendon": ("armature", "damping", "stiffness", "frictionloss"),
    "actuator": ("armature", "damping"),
}
"""Attributes that state a force, by what has them."""
_LOOPS = ("connect", "weld")
"""Kinds of <equality> that close loops."""
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
Named = TypeVar("Named")


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
    reader = MjcfReader(root, where, strict)
    for world in root.findall("worldbody"):
        reader.read(world)
    links = reader.links
    if reader.compiler.settotalmass > 0.0:
        links[1:] = scaled_to(links[1:], reader.compiler.settotalmass, where)
    loops, couplings = reader.equalities(root)
    reader.note_forces(root)
    joints = tuple(reader.joints.values())
    left_out = dynamics_left_out(joints, where)
    left_out += forces_left_out(reader.forces, where, strict)
    return Description(
        name=root.get("model") or "mechanism",
        links=tuple(links),
        joints=joints,
        order=tuple(reader.joints),
        loops=tuple(loops),
        couplings=tuple(couplings),
        independent_joints=_actuated(root, reader.joints),
        notation="MJCF <equality>" if loops or couplings else "no loops",
        warnings=(*passed_over, *reader.warnings, *left_out),
        frames=frozen(reader.sites),
    )


def _actuated(root: ElementTree.Element, joints: Collection[str]) -> tuple[str, ...]:
    """Return the joints of the tree that have an actuator, in the order of these."""
    named = (item.get("joint", "") for section in root.findall("actuator") for item in section)
    return tuple(name for name in dict.fromkeys(named) if name in joints)


def with_includes(root: ElementTree.Element, where: str, path: Path | None) -> ElementTree.Element:
    """Return a model in which included files' elements, and theirs in turn, replace `<include>`.

    As in MuJoCo, a path is taken from beside the main file, or else from beside the including
    one, and a file is included once.

    Args:
        root: outermost element of the main file; it stays as it is.
        where: how messages name the main file.
        path: the main file; None for text.

    Raises:
        ModelError: a file is missing, malformed or included twice, or elements are nested deeper
            than `DEPTH`.
    """
    seen = set() if path is None else {path.resolve()}
    main = None if path is None else path.parent
    result = ElementTree.Element(root.tag, root.attrib)
    waiting = [(root, result, main, 1)]
    while waiting:
        parent, resolved, beside, depth = waiting.pop()
        if depth > DEPTH:
            raise ModelError(
                f"{where}: <{parent.tag}> is nested {depth} elements deep; the limit is {DEPTH}"
            )
        content = deque((child, beside) for child in parent)
        while content:
            child, folder = content.popleft()
            if child.tag != "include":
                copied = ElementTree.SubElement(resolved, child.tag, child.attrib)
                waiting.append((child, copied, folder, depth + 1))
                continue
            included, file = _included(child, where, main, folder)
            if file.resolve() in seen:
                raise ModelError(
                    f"{where}: <include file={child.get('file')!r}>: the file is included twice, "
                    "or includes itself; include it once"
                )
            seen.add(file.resolve())
            content.extendleft((item, file.parent) for item in reversed(included))
    return result


def _included(
    element: ElementTree.Element, where: str, main: Path | None, beside: Path | None
) -> tuple[ElementTree.Element, Path]:
    name = element.get("file")
    at = f"{where}: <include file={name!r}>"
    check_words(element, "mjcf", where)
    if not name:
        raise ModelError(f'{where}: an <include> needs file="..."')
    if len(element):
        raise ModelError(f"{at}: it has elements of its own; an <include> has none")
    if main is None or beside is None:
        raise ModelError(f"{at}: text has no directory to find it in; load the file by its path")
    try:
        existing = [file for file in (main / name, beside / name) if file.is_file()]
        if not existing:
            raise ModelError(f"{at}: there is no file {str(main / name)!r}")
    except (OSError, ValueError) as error:  # A name that is too long, or has a null character.
        raise ModelError(f"{at}: cannot be read ({error})") from error
    return xml_root(file_text(existing[0], at).strip(), at)[0], existing[0]


class MjcfReader:
    """Reads the bodies of a file.

    Attributes:
        compiler: settings.
        links: those that were read, that of the world first.
        joints: those of the tree by name.
        classes: default attributes.
        contents: elements of each body with its name, those of the world first.
        forces: forces that no wrench considers.
        warnings: what is wrong and was accepted.
        sites: name to the link that carries it, and its placement there.
    """

    def __init__(self, root: ElementTree.Element, where: str, strict: bool) -> None:
        self._where = where
        self._strict = strict
        self.compiler = Compiler.of(root, where)
        self.classes = DefaultClasses(root, where)
        self.contents: list[tuple[str, _Content]] = []
        self.forces: list[str] = []
        self.warnings: list[str] = []
        self._names = {
            "body": _given(root, ("body",), where),
            "joint": _given(root, ("joint", "freejoint"), where),
        }
        self._counts = {"body": 0, "joint": 0}
        self._root = world = self._generated("world", "body")
        self.links = [LinkDescription(world)]
        self.joints: dict[str, JointDescription] = {}
        # Of links: their initial placement in the world, and the first link of their rigid body.
        self._placements = {world: np.eye(4)}
        self._rigid = {world: world}
        self.sites: dict[str, tuple[str, Array]] = {}

    def read(self, world: ElementTree.Element) -> None:
        """Read a `<worldbody>` and all bodies in it, depth first."""
        waiting = [(world, self._root, np.eye(4), "main")]
        while waiting:
            element, parent, frame, childclass = waiting.pop()
            if element is world:
                name, at = parent, f"{self._where}: worldbody"
            else:
                name, at = self._body(element)
            childclass = self.classes.known(element.get("childclass", childclass), at)
            content = self._contents(element, childclass, at)
            self.contents.append((name, content))
            if element is not world:
                attributes = element.attrib
                origin = frame @ pose(attributes, self.compiler, at)
                self._read_joints(content, name, parent, origin)
                self._mass(content, name, at)
                self._note_attributes(attributes, name, at)
            elif any(child.tag in ("inertial", "joint", "freejoint") for child, *_ in content):
                raise ModelError(
                    f"{at}: the world has no joints and no mass; write them in a <body>"
                )
            self._read_sites(content, name, at)
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

    def _read_joints(self, content: _Content, body: str, parent: str, origin: Array) -> None:
        """Add the joints of a body, and the links between them."""
        elements = [item for item in content if item[0].tag in ("joint", "freejoint")]
        if not elements:
            self._fix(body, parent, origin)
        for count, (element, frame, childclass) in enumerate(elements, start=1):
            is_last = count == len(elements)
            child = body if is_last else self._generated(f"{body}_{count}", "body")
            described = self._joint(element, frame, childclass, (parent, child), origin)
            if described.type == "floating" and (len(elements) > 1 or parent != self._root):
                raise ModelError(
                    f"{self._where}: joint {described.name!r}: a free joint is the only joint of "
                    "a body in <worldbody>; write a ball and three slides"
                )
            self.joints[described.name] = described
            self._placements[child] = self._placements[parent] @ origin
            self._rigid[child] = child
            if not is_last:
                self.links.append(LinkDescription(child))
            # The links between the joints of a body all stand where the body stands.
            parent, origin = child, np.eye(4)

    def _fix(self, body: str, parent: str, origin: Array) -> None:
        name = self._generated(f"{body}_fixed", "joint")
        axis = np.array([1.0, 0.0, 0.0])
        self.joints[name] = JointDescription(name, "fixed", parent, body, origin, axis, axis)
        self._placements[body] = self._placements[parent] @ origin
        self._rigid[body] = self._rigid[parent]

    def _joint(
        self,
        element: ElementTree.Element,
        frame: Array,
        childclass: str,
        ends: tuple[str, str],
        body: Array,
    ) -> JointDescription:
        self._counts["joint"] += 1
        name = element.get("name") or self._generated(f"joint_{self._counts['joint']}", "joint")
        at = f"{self._where}: joint {name!r}"
        attributes: Attributes = {"type": "free"}
        if element.tag == "joint":
            attributes = self.classes.of(element, childclass, at)
        kind = attributes.get("type", "hinge")
        taken = _DYNAMICS - _untaken(attributes, kind, at)
        self._note("joint", attributes, name, taken)
        described, warning = joint(attributes, name, ends, body, frame, self.compiler, at)
        if warning:
            self.warnings.append(warning)
        return described

    def _mass(self, content: _Content, name: str, at: str) -> None:
        """Add the link of a body.

        The geoms of a body that cannot move are not read, since its mass has no effect: they may
        be meshes, whose inertia is not computed here. Where a total mass is stated, they count.
        """
        is_immovable = self._rigid[name] == self._root
        inertials: list[MassElement] = []
        geoms: list[MassElement] = []
        for element, frame, childclass in content:
            if element.tag == "inertial":
                inertials.append(MassElement(element.attrib, frame, f"{at}: inertial"))
            elif element.tag == "geom":
                label = f"{at}: geom {element.get('name') or len(geoms) + 1!r}"
                attributes = self.classes.of(element, childclass, label)
                geoms.append(MassElement(attributes, frame, label))
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
        self._note("body", attributes, name)
        if flag(attributes, "mocap", "false", at):
            if self._rigid[name] != self._root:
                raise ModelError(f"{at}: a mocap body stands in the world, without a joint")
            self.warnings.append(f"{at}: mocap: it stands still")

    def _read_sites(self, content: _Content, body: str, at: str) -> None:
        for element, frame, childclass in content:
            name = element.get("name")
            if element.tag != "site" or not name:
                continue
            label = f"{at}: site {name!r}"
            if name in self.sites:
                raise ModelError(f"{label}: another site has this name")
            attributes = self.classes.of(element, childclass, label)
            self.sites[name] = body, frame @ frame_of(attributes, self.compiler, label)

    def _generated(self, name: str, kind: str) -> str:
        """Return a name, like `name`, for an element to which the file gives none."""
        generated = unique(name, self._names[kind])
        self._names[kind].add(generated)
        return generated

    def note_forces(self, root: ElementTree.Element) -> None:
        """Note what tendons, actuators, fluids and deformable bodies exert."""
        for option in root.findall("option"):
            self._note("option", option.attrib)
        for kind in ("tendon", "actuator"):
            for element in root.iterfind(f"{kind}/*"):
                name = element.get("name", element.tag)
                default = "tendon" if kind == "tendon" else element.tag
                at = f"{self._where}: {kind} {name!r}"
                self._note(kind, self.classes.of(element, "main", at, default), name)
        for element in root.iterfind("deformable/flex"):
            self.forces.append(f"flex {element.get('name', '')!r}")

    def _note(
        self, kind: str, attributes: Attributes, name: str = "", taken: Iterable[str] = ()
    ) -> None:
        """Note attributes that state a force, but for those that are taken."""
        owner = f"{kind} {name!r}" if name else kind
        acting = [
            f"{key} {attributes[key]}"
            for key in _FORCES[kind]
            if key not in taken
            and np.any(several(attributes, key, 1, MOST_TERMS, f"{self._where}: {owner}"))
        ]
        if acting:
            self.forces.append(f"{owner}: {', '.join(acting)}")

    def equalities(
        self, root: ElementTree.Element
    ) -> tuple[list[LoopDescription], list[CouplingDescription]]:
        """Return the loops and couplings; `connect` and `weld` are loops, `joint` a coupling."""
        loops, couplings = [], []
        taken = set(self.joints)
        named = {name for item in root.iterfind("equality/*") if (name := item.get("name"))}
        words, at = ("enable", "disable"), f"{self._where}: flag equality"
        disabled = any(
            keyword(item.get("equality", "enable"), words, at) == "disable"
            for item in root.iterfind("option/flag")
        )
        for count, element in enumerate(root.iterfind("equality/*"), start=1):
            name = element.get("name")
            at = f"{self._where}: <equality> <{element.tag}> {name or count!r}"
            attributes = self.classes.of(element, "main", at, "equality")
            if disabled or not flag(attributes, "active", "true", at):
                self.warnings.append(f"{at}: left out, as it is not active")
                continue
            if element.tag not in (*_LOOPS, "joint"):
                raise ModelError(
                    f"{self._where}: <equality> <{element.tag}> is not supported; kinds: "
                    f"{choices((*_LOOPS, 'joint'), element.tag)}; joint is a coupling"
                )
            name = unique(name or f"equality_{count}", taken if name else taken | named)
            taken.add(name)
            if element.tag == "joint":
                couplings.append(self._coupling(attributes, name, at))
            else:
                loops.append(self._loop(element.tag, attributes, name, at))
        # In the order of the joints, as a URDF lists them.
        order = {name: index for index, name in enumerate(self.joints)}
        couplings.sort(key=lambda coupling: order[coupling.successor])
        return loops, couplings

    def _loop(self, kind: str, attributes: Attributes, name: str, at: str) -> LoopDescription:
        """Return the loop that a `connect` or a `weld` is.

        Its coordinates are zero in the initial configuration, save for a `weld` that states another
        relative pose.
        """
        by_sites = [key for key in ("site1", "site2") if key in attributes]
        by_bodies = [key for key in ("body1", "body2", "anchor", "relpose") if key in attributes]
        if by_sites and by_bodies:
            raise ModelError(f"{at}: {by_sites[0]} and {by_bodies[0]} exclude each other")
        if kind == "weld" and number(attributes, "torquescale", "1", at) == 0.0:
            raise ModelError(f"{at}: a weld with torquescale 0 is a ball; write <connect>")
        if by_sites:
            links, origins = self._of_sites(kind, attributes, at)
        else:
            links, origins = self._of_bodies(kind, attributes, at)
        axis = np.array([1.0, 0.0, 0.0])
        joint = "spherical" if kind == "connect" else "fixed"
        return LoopDescription(name, joint, *links, *origins, axis, axis)

    def _of_sites(
        self, kind: str, attributes: Attributes, at: str
    ) -> tuple[tuple[str, str], tuple[Array, Array]]:
        """Return the links of the two sites of an equality, and `(4, 4)` placements there."""
        (first, origin_1), (second, origin_2) = (
            _named(attributes, key, self.sites, at) for key in ("site1", "site2")
        )
        _check_apart(first, second, at)
        if kind == "connect":
            # The sites of a ball joint may have any orientation: that of the second is replaced, so
            # that the coordinate is zero in the initial configuration.
            origin_2 = origin_2.copy()
            origin_2[:3, :3] = self._across(first, second)[:3, :3].T @ origin_1[:3, :3]
        return (first, second), (origin_1, origin_2)

    def _of_bodies(
        self, kind: str, attributes: Attributes, at: str
    ) -> tuple[tuple[str, str], tuple[Array, Array]]:
        """Return the links that an equality of bodies connects, and `(4, 4)` placements there."""
        bodies = {link: link for link in self._placements}
        bodies.setdefault("world", self._root)
        first = _named(attributes, "body1", bodies, at)
        second = _named(attributes, "body2", bodies, at) if "body2" in attributes else self._root
        _check_apart(first, second, at)
        across = self._across(first, second)
        if kind == "connect":
            if "anchor" not in attributes:
                raise ModelError(f'{at}: anchor="..." is missing')
            origin_1 = at_point(numbers(attributes["anchor"], 3, "", f"{at}: anchor"))
            return (first, second), (origin_1, inverse(across) @ origin_1)
        origin_2 = at_point(numbers(attributes.get("anchor"), 3, "0 0 0", f"{at}: anchor"))
        origin_1 = across @ origin_2
        relative_pose = numbers(attributes.get("relpose"), 7, "0 1 0 0 0 0 0", f"{at}: relpose")
        # A quaternion of zeros stands for the pose in the initial configuration.
        if np.any(relative_pose[3:]):
            # MuJoCo holds the anchor, a point of the second body, at this point of the first.
            origin_1 = at_point(relative_pose[:3])
            origin_1[:3, :3] = rotation_of_quaternion(relative_pose[3:], f"{at}: relpose")
        return (first, second), (origin_1, origin_2)

    def _across(self, first: str, second: str) -> Array:
        """Return the initial `(4, 4)` placement of the second link in the first."""
        return inverse(self._placements[first]) @ self._placements[second]

    def _coupling(self, attributes: Attributes, name: str, at: str) -> CouplingDescription:
        """Return the coupling that an equality of two joints is, where its polynomial is linear.

        The polynomial counts both coordinates from the initial configuration, where those of a
        description are zero.
        """
        driven = _named(attributes, "joint1", self.joints, at)
        driving = None
        if "joint2" in attributes:
            driving = _named(attributes, "joint2", self.joints, at)
        factors = numbers(attributes.get("polycoef"), 5, "0 1 0 0 0", f"{at}: polycoef")
        if (
            driving is None
            or driven is driving
            or not {driven.type, driving.type} <= SINGLE_TYPES
            or factors[1] == 0.0
            or np.any(factors[2:])
        ):
            raise ModelError(
                f"{self._where}: <equality> <joint> is not supported except as a coupling: "
                f'{name!r} needs two hinges or slides and polycoef="offset ratio 0 0 0", '
                "the ratio not zero"
            )
        offset, ratio = factors[:2].tolist()
        return CouplingDescription(name, driving.name, driven.name, ratio, offset, of_joints=True)


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


def joint(
    attributes: Attributes,
    name: str,
    ends: tuple[str, str],
    body: Array,
    frame: Array,
    compiler: Compiler,
    at: str,
) -> tuple[JointDescription, str]:
    """Return a joint of a body, and a warning where its zero is elsewhere than in the file.

    Args:
        attributes: those of its class included.
        name: of the joint.
        ends: names of its two links.
        body: `(4, 4)` initial placement of the second link in the first.
        frame: `(4, 4)` placement of the frame around the joint in the second link.
        compiler: settings of the file.
        at: how messages name the joint.

    Raises:
        ModelError: an attribute is malformed.
    """
    kind = keyword(attributes.get("type", "hinge"), _TYPES, f"{at}: type")
    axis = np.array([1.0, 0.0, 0.0])
    if kind == "free":
        return JointDescription(name, _TYPES[kind], *ends, body, axis, axis), ""
    # The joint's frame has the axes of the child link, and its origin at the joint's pos there.
    joint_in_child, child_in_joint = np.eye(4), np.eye(4)
    point = numbers(attributes.get("pos"), 3, "0 0 0", f"{at}: pos")
    joint_in_child[:3, 3] = frame[:3, :3] @ point + frame[:3, 3]
    child_in_joint[:3, 3] = -joint_in_child[:3, 3]
    origin = body @ joint_in_child
    if kind == "ball":
        return JointDescription(name, _TYPES[kind], *ends, origin, axis, axis, child_in_joint), ""
    stated = numbers(attributes.get("axis"), 3, "0 0 1", f"{at}: axis")
    axis = frame[:3, :3] @ unit(stated, f"{at}: axis")
    initial = number(attributes, "ref", "0", at)
    limits = _limits(attributes, initial, compiler, at)
    scale = compiler.angle if kind == "hinge" else 1.0
    limits = Limits(limits.lower * scale, limits.upper * scale)
    joint_type = "continuous" if kind == "hinge" and limits == Limits() else _TYPES[kind]
    warning = f"{at}: its coordinate is zero where the file counts {initial:g} (ref)"
    taken = _dynamics_of(attributes, kind, compiler, at)
    described = JointDescription(
        name, joint_type, *ends, origin, axis, axis, child_in_joint, limits, "", taken
    )
    return described, warning if initial else ""


def _dynamics_of(attributes: Attributes, kind: str, compiler: Compiler, at: str) -> Dynamics:
    """Return the damping, friction and spring that a joint states along its coordinate.

    The spring is at rest at `springref`, which counts as the file counts the joint; here the
    initial configuration is zero. What cannot be taken in is zero: see `_untaken`.
    """
    left = _untaken(attributes, kind, at)
    damping, stiffness, friction = (
        0.0 if key in left else float(several(attributes, key, 1, MOST_TERMS, at)[:1].sum())
        for key in ("damping", "stiffness", "frictionloss")
    )
    if not stiffness:
        return Dynamics(damping, friction)
    initial = number(attributes, "ref", "0", at)
    rest = number(attributes, "springref", "0", at) - initial
    scale = compiler.angle if kind == "hinge" else 1.0
    return Dynamics(damping, friction, stiffness, rest * scale)


def _untaken(attributes: Attributes, kind: str, at: str) -> set[str]:
    """Return which of the damping, stiffness and friction of a joint no element is made of.

    Those are all of a joint with a ball, higher terms of a polynomial, negative values, and what
    `springdamper` replaces.
    """
    if kind not in ("hinge", "slide"):
        return set(_DYNAMICS)
    left = set()
    for key in _DYNAMICS:
        terms = several(attributes, key, 1, MOST_TERMS, at)
        if np.any(terms[1:]) or np.any(terms < 0.0):
            left.add(key)
    if np.any(several(attributes, "springdamper", 1, MOST_TERMS, at)):
        left |= {"damping", "stiffness"}
    return left


def _limits(attributes: Attributes, initial: float, compiler: Compiler, at: str) -> Limits:
    """Return the limits of a joint in the file's unit, counted from the initial configuration."""
    lower, upper = numbers(attributes.get("range"), 2, "0 0", f"{at}: range").tolist()
    words = ("false", "true", "auto")
    limited = keyword(attributes.get("limited", "auto"), words, f"{at}: limited")
    if limited == "auto" and lower < upper and not compiler.autolimits:
        raise ModelError(f'{at}: without autolimits, a range needs limited="true" or "false"')
    if limited == "false" or (limited == "auto" and lower >= upper):
        return Limits()
    if lower >= upper:
        raise ModelError(f"{at}: range {lower:g} {upper:g} does not ascend")
    return Limits(lower - initial, upper - initial)


def _check_apart(first: str, second: str, at: str) -> None:
    if first == second:
        raise ModelError(f"{at}: both ends are on the body {first!r}")


def _named(attributes: Attributes, key: str, known: Mapping[str, Named], at: str) -> Named:
    name = attributes.get(key)
    if name is None:
        raise ModelError(f'{at}: {key}="..." is missing')
    if name not in known:
        raise ModelError(f"{at}: {key} {name!r} does not exist; names: {choices(known, name)}")
    return known[name]
