"""Writer of MJCF: a description as a model for MuJoCo 3.2 or later.

Links become nested bodies, the root one that is fixed in the world. Joints with several
coordinates become a hinge, slide or ball each; the last of them has the joint's name. A loop of
type `spherical` without an armature is a `connect`, one of type `fixed` a `weld`, both between
sites, which hold in any configuration. Any other loop becomes what it is in a mechanism's own
model: its joint carries a body on the predecessor, with a share of the successor's inertia, and a
`weld` holds this body to the successor. Read back, the weld is a joint of its own, over which least
norms are then taken as well; whatever the laws of motion decide is the same.

MuJoCo accepts no moving body without mass. A massless link that carries one joint is written as a
body with the joints before and behind it; others are refused.

Bodies nested more than 300 deep are written, but not read back by this package.

Limits of effort are written as what MuJoCo lets motors exert on a joint unless motors are bounded
alike, infinite ones as the greatest number; joints stand in their order as far as bodies do. Of
what MJCF has no word for, `written` returns a list, without limits of speed, which no result
judges, names of fixed joints, visuals and warnings.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from xml.etree.ElementTree import Element, SubElement
from xml.sax.saxutils import quoteattr

import numpy as np
import pinocchio

from ....core.description.bodies import bodies_of
from ....core.description.description import (
    UNBOUNDED,
    ActuatorDescription,
    Description,
    Dynamics,
    JointDescription,
    JointOrLoop,
    Limits,
    LinkDescription,
    LoopDescription,
    elementary,
    summed_efforts,
)
from ....core.description.elements import ROTATION_TOLERANCE, SINGLE_TYPES, unique, words
from ....kit.arrays import Array, inverse, quaternion_product
from ....kit.errors import ModelError, choices
from ..together import together

_DIRECT = {"spherical": "connect", "fixed": "weld"}
"""Types of loops that are an equality, and its kind."""
_WORLD = "world"
"""Name of MuJoCo's outermost body."""
_POWERS = 5
"""Coefficients of MuJoCo's `polycoef`."""
_WORDS = {"revolute": "hinge", "prismatic": "slide", "spherical": "ball"}
"""Elementary part of a joint to the joint that it is in MJCF."""
_MOST_FREEDOMS = 6
"""Freedoms that MuJoCo allows between a body and the one that carries it."""


def to_mjcf(description: Description) -> str:
    """Return a description as MJCF text, which `read` and MuJoCo read.

    Raises:
        ModelError: something has no notation in MJCF: a moving link without mass, a coupling of
            links that several joints move from their common ancestor, a matrix that is no rotation.
    """
    return written(description)[0]


def written(description: Description) -> tuple[str, list[str]]:
    """Return the text of `to_mjcf`, and what of the description is not in it, in words."""
    writer = _MjcfWriter(description)
    return _text(writer.model()), [*dict.fromkeys(writer.left_out)]


class _MjcfWriter:
    def __init__(self, description: Description) -> None:
        self._description = description
        self._bodies = bodies_of(description)
        self._split = Counter(
            self._bodies[loop.successor] for loop in description.loops if not _is_direct(loop)
        )
        # Of links, and of the bodies that carry the joints of loops.
        self._elements: dict[str, Element] = {}
        self._halves: dict[str, Element] = {}
        # Of joints with all freedoms: where their bodies stand at first.
        self._free_at: dict[str, Array] = {}
        self.left_out: list[str] = []
        moving = {joint.name: joint for joint in description.joints if joint.type in SINGLE_TYPES}
        self._actuators = [item for item in description.actuators if item.joint in moving]
        self._world, self._equalities = Element("worldbody"), Element("equality")
        joints = {item.name for item in description.joints_and_loops}
        self._taken = {
            "body": {link.name for link in description.links},
            "joint": joints,
            "equality": joints | {item.name for item in description.couplings},
            "site": {*description.own_frames},
        }
        self._carried: dict[str, list[JointOrLoop]] = {link.name: [] for link in description.links}
        for joint in description.joints:
            self._carried[joint.parent].append(joint)
        for loop in description.loops:
            if not _is_direct(loop):
                self._carried[loop.predecessor].append(loop)

    def model(self) -> Element:
        """Return the whole model."""
        description = self._description
        if _WORLD in {link.name for link in description.links} - {description.root}:
            raise ModelError(f"{description.name}: MJCF keeps the name {_WORLD!r} for the world")
        self._write_tree()
        for loop in description.loops:
            self._write_loop(loop)
        for coupling in description.couplings:
            first, second = coupling.predecessor, coupling.successor
            if not coupling.of_joints:
                first, second = (
                    self._coupled(*links, coupling.name)
                    for links in ((first, second), (second, first))
                )
            powers = [coupling.offset, coupling.ratio, *coupling.higher]
            if len(powers) > _POWERS:
                raise ModelError(
                    f"{description.name}: coupling {coupling.name!r}: MJCF has powers up to the "
                    "fourth; write URDF+"
                )
            polynomial = words(powers + [0.0] * (_POWERS - len(powers)))
            ends = {"joint1": second, "joint2": first, "polycoef": polynomial}
            SubElement(self._equalities, "joint", {"name": coupling.name, **ends})
            if coupling.forces:
                self.left_out.append(f"forces of coupling {coupling.name!r}")
        self._write_sites()
        model = Element("mujoco", model=description.name)
        SubElement(model, "compiler", angle="radian", autolimits="true")
        if description.gravity is not None:
            SubElement(model, "option", gravity=words(description.gravity))
        parts = self._world, self._equalities, self._motors(), self._keyframes()
        model.extend(part for part in parts if len(part) or part is self._world)
        return model

    def _motors(self) -> Element:
        """Return the actuators, and a motor for each driven joint that has none."""
        result, known = Element("actuator"), {item.joint for item in self._actuators}
        driven = [
            ActuatorDescription(
                joint.name, joint.name, force=joint.limits.efforts, control=joint.limits.efforts
            )
            for joint in self._description.joints
            if joint.name in self._description.independent_joints
            and joint.type in SINGLE_TYPES
            and joint.name not in known
        ]
        for item in (*self._actuators, *driven):
            stated = {"name": item.name} if item.name else {}
            stated |= {"joint": item.joint}
            if item.gear != 1.0:
                stated["gear"] = words([item.gear])
            if not item.is_direct:
                self.left_out.append(f"law of actuator {item.name!r}, which is a motor now")
            ranges = {"ctrlrange": item.control, "forcerange": item.force}
            if item in driven or item.force == item.control:
                del ranges["forcerange"]
            stated |= {name: text for name, ends in ranges.items() if (text := _range(ends))}
            SubElement(result, "motor", stated)
        return result

    def _write_sites(self) -> None:
        """Add what is fixed in links beside the ends of loops."""
        for name, (link, placement) in self._description.own_frames.items():
            if link not in self._elements:
                self.left_out.append(f"frame {name!r}")
            else:
                SubElement(self._elements[link], "site", {"name": name, **pose_of(placement, name)})

    def _keyframes(self) -> Element:
        """Return the keyframes, of which each gives all coordinates in MuJoCo's order."""
        result = Element("keyframe")
        joints = [item for item in self._world.iter() if item.tag in ("joint", "freejoint")]
        for key, positions in self._description.keyframes.items():
            if any(item.get("name") not in positions for item in joints):
                self.left_out.append(f"keyframe {key!r}")
                continue
            at = [number for item in joints for number in self._counted(item, positions)]
            SubElement(result, "key", name=key, qpos=words(at))
        return result

    def _counted(self, joint: Element, positions: Mapping[str, float | Array]) -> Array:
        """Return the position of a joint as MuJoCo counts it, with real parts first."""
        name = joint.get("name", "")
        value = np.atleast_1d(positions[name])
        if name in self._free_at:
            start = self._free_at[name]
            turn = pinocchio.Quaternion(start[:3, :3]).normalized().coeffs()
            turned = quaternion_product(turn, value[3:])
            return np.concatenate([start[:3, 3] + start[:3, :3] @ value[:3], np.roll(turned, 1)])
        return np.roll(value, 1) if joint.get("type") == "ball" else value

    def _write_tree(self) -> None:
        """Add the bodies of all links, and those that carry the joints of loops."""
        root, links = self._description.root, {link.name: link for link in self._description.links}
        self._elements[root] = self._world
        if root != _WORLD:
            self._elements[root] = self._add(self._world, root, np.eye(4))
            self._weigh(self._elements[root], links[root])
        # What stands last is taken first, so that bodies stand in the order of joints.
        waiting: list[list[JointOrLoop]] = [[item] for item in reversed(self._carried[root])]
        while waiting:
            chain = waiting.pop()
            item = chain[-1]
            if isinstance(item, LoopDescription):
                name = unique(f"{item.name}_half", self._taken["body"])
                body = self._halves[item.name] = self._body(chain, name, np.eye(4))
                SubElement(body, "inertial", inertial_of(self._half(item)))
                continue
            if not self._is_passed_through(item):
                body = self._body(chain, item.child, item.child_placement)
                self._weigh(body, links[item.child])
                self._elements[item.child] = body
                chain = []
            waiting += [[*chain, behind] for behind in reversed(self._carried[item.child])]

    def _is_passed_through(self, joint: JointDescription) -> bool:
        """Return whether the link of a joint has no mass and no body of its own."""
        link = joint.child
        if joint.type == "fixed" or self._bodies[link].mass > 0.0:
            return False
        carried = self._carried[link]
        is_used = any(
            link == loop.successor or (link == loop.predecessor and _is_direct(loop))
            for loop in self._description.loops
        )
        if len(carried) == 1 and carried[0].type != "fixed" and not is_used:
            return True
        raise ModelError(
            f"{self._description.name}: link {link!r} moves and has no mass, which MuJoCo does not "
            "accept; give it one"
        )

    def _body(self, chain: list[JointOrLoop], name: str, child_placement: Array) -> Element:
        """Return the new body behind one or several joints."""
        # From the body backwards, the placement of each joint's frame in it.
        behind, frames = child_placement, []
        for position, item in enumerate(reversed(chain)):
            if position and isinstance(item, JointDescription):
                behind = item.child_placement @ behind
            frames.append(inverse(behind))
            origin = item.predecessor_origin if isinstance(item, LoopDescription) else item.origin
            behind = origin @ behind
        check_kinds([kind for item in chain for kind, _ in _parts(item)], name)
        first = chain[0]
        parent = first.parent if isinstance(first, JointDescription) else first.predecessor
        if first.type == "floating" and self._bodies[parent].parent is None:
            return self._free(chain, name, self._bodies[parent].at(parent) @ behind)
        body = self._add(self._elements[parent], name, behind)
        for item, frame in zip(chain, reversed(frames), strict=True):
            self._write_joint(body, item, frame)
        return body

    def _free(self, chain: list[JointOrLoop], name: str, placement: Array) -> Element:
        """Return the body of a joint with all freedoms, which MuJoCo knows in the world only."""
        joint, rotors, model = chain[0], {*chain[0].armature}, self._description.name
        if len(chain) > 1:
            raise ModelError(
                f"{model}: link of the floating joint {joint.name!r} has no mass, which MuJoCo "
                "does not accept; give it one"
            )
        if len(rotors) > 1:
            raise ModelError(
                f"{model}: joint {joint.name!r}: MuJoCo knows one armature of all motions of a "
                f"free body, not {words(joint.armature)}"
            )
        body = self._add(self._world, name, placement)
        self._free_at[joint.name] = placement
        self._note_dynamics(joint)
        if rotors:
            SubElement(body, "joint", type="free", name=joint.name, armature=words(rotors))
        else:
            SubElement(body, "freejoint", name=joint.name)
        return body

    def _add(self, carrier: Element, name: str, placement: Array) -> Element:
        return SubElement(carrier, "body", {"name": name, **pose_of(placement, name)})

    def _write_joint(self, body: Element, item: JointOrLoop, frame: Array) -> None:
        """Add the elements of a joint whose `(4, 4)` frame in the body is given."""
        parts = _parts(item)
        # A fixed joint that a scene may drive has no parts here, and a rotor.
        rotors = item.armature if parts and item.armature else (0.0,) * len(parts)
        for count, ((kind, axis), inertia) in enumerate(zip(parts, rotors, strict=True), start=1):
            name = item.name
            if count < len(parts):
                name = unique(f"{item.name}_{count}", self._taken["joint"])
            stated = {"name": name, "type": kind, "pos": words(frame[:3, 3])}
            if kind == "ball":
                self._note_dynamics(item)
            else:
                stated |= {"axis": words(frame[:3, :3] @ axis), **dynamics_of(item.dynamics)}
            if inertia:
                stated["armature"] = words([inertia])
            # The limits of a joint that turns about two axes are those of either.
            if isinstance(item, JointDescription) and all(kind == other for other, _ in parts):
                stated |= self._ranges(item)
            SubElement(body, "joint", stated)

    def _note_dynamics(self, item: JointOrLoop) -> None:
        if item.dynamics.acts:
            self.left_out.append(f"damping and friction of {item.name!r}")

    def _ranges(self, joint: JointDescription) -> dict[str, str]:
        """Return the attributes of a joint's limits that its actuators do not have already."""
        limits, acting = joint.limits, [it for it in self._actuators if it.joint == joint.name]
        exerted = summed_efforts([it.gear for it in acting], [it.force for it in acting])
        ranges = ranges_of(limits)
        stated = {"position": (limits.lower, limits.upper), "effort": limits.efforts}
        if acting and exerted == limits.efforts:
            ranges.pop("actuatorfrcrange", None)
            del stated["effort"]
        self.left_out += [
            f"limits of {what} of {joint.name!r}"
            for what, ends in stated.items()
            if not _range(ends) and ends != UNBOUNDED and any(ends)
        ]
        return ranges

    def _weigh(self, element: Element, link: LinkDescription) -> None:
        """Add the mass of a link, or the share of it that no loop's joint carries."""
        if link.mass:
            SubElement(element, "inertial", inertial_of(self._share(link, link.name)))
        elif np.any(link.inertia):
            raise ModelError(f"link {link.name!r}: an inertia without a mass cannot be written")

    def _share(self, link: LinkDescription, of: str) -> LinkDescription:
        """Return one of the equal parts into which the body of a link is split."""
        body = self._bodies[of]
        count = 1 + self._split[body] if body.parent else 1
        return replace(link, mass=link.mass / count, inertia=link.inertia / count)

    def _half(self, loop: LoopDescription) -> LinkDescription:
        """Return the mass of the body that carries a loop's joint, in the joint's frame.

        It is a share of its successor's. A successor that stands still has none that counts: a
        mass of the size of the others keeps the model regular and is held by the weld alone.
        """
        body, name = self._bodies[loop.successor], loop.name
        if body.parent is None:
            masses = [link.mass for link in self._description.links if link.mass > 0.0]
            mass = float(np.mean(masses)) if masses else 1.0
            return LinkDescription(name, mass, np.zeros(3), mass * np.eye(3))
        if body.mass == 0.0:
            raise ModelError(
                f"loop {name!r}: its successor {loop.successor!r} moves and has no mass, which "
                "MuJoCo does not accept; give it one"
            )
        back = inverse(body.at(loop.successor) @ loop.successor_origin)
        seen = (link.seen_in(back @ placement) for link, placement in body.links)
        whole = together([(link.mass, link.centre, link.inertia) for link in seen])
        return self._share(LinkDescription(name, *whole), loop.successor)

    def _write_loop(self, loop: LoopDescription) -> None:
        """Add the equality of a loop, and the sites between which it holds."""
        if _is_direct(loop):
            name, kind = loop.name, _DIRECT[loop.type]
            start = self._elements[loop.predecessor], loop.predecessor_origin
        else:
            name, kind = unique(f"{loop.name}_weld", self._taken["equality"]), "weld"
            start = self._halves[loop.name], np.eye(4)
        sites = [unique(f"{name}_{side}", self._taken["site"]) for side, _ in loop.ENDS]
        ends = start, (self._elements[loop.successor], loop.successor_origin)
        for site, (element, origin) in zip(sites, ends, strict=True):
            SubElement(element, "site", {"name": site, **pose_of(origin, site)})
        SubElement(self._equalities, kind, name=name, site1=sites[0], site2=sites[1])

    def _coupled(self, link: str, other: str, coupling: str) -> str:
        """Return the one joint that moves a link of a coupling against the common ancestor."""
        common = {*self._bodies[other].path()}
        path = [body for body in self._bodies[link].path() if body not in common]
        joints = [body.joint for body in path if body.joint is not None]
        if len(joints) != 1 or joints[0].type not in SINGLE_TYPES:
            raise ModelError(
                f"{self._description.name}: coupling {coupling!r}: MJCF couples two joints with "
                f"one coordinate; between {link!r} and the common ancestor with {other!r} are "
                f"{choices([f'{joint.name} ({joint.type})' for joint in joints])}"
            )
        return joints[0].name


def _text(model: Element) -> str:
    """Return an element and all in it as text, whose nesting is without a limit."""
    lines = list[str]()
    waiting: list[tuple[str, Element | str]] = [("", model)]
    while waiting:
        indent, item = waiting.pop()
        if isinstance(item, str):
            lines.append(indent + item)
            continue
        stated = "".join(f" {name}={quoteattr(value)}" for name, value in item.items())
        lines.append(f"{indent}<{item.tag}{stated}{'/' * (not len(item))}>")
        waiting += [(indent, f"</{item.tag}>")] * bool(len(item))
        waiting += [(f"{indent}  ", part) for part in reversed(item)]
    return "\n".join([*lines, ""])


def _is_direct(loop: LoopDescription) -> bool:
    """Return whether a loop is an equality by itself, which has no rates."""
    return loop.type in _DIRECT and not loop.armature


def _parts(item: JointOrLoop) -> list[tuple[str, Array]]:
    """Return MJCF's words and axes for the coordinates of a joint, outermost first."""
    return [(_WORDS[kind], axis) for kind, axis in elementary(item.type, item.axis, item.axis_2)]


def check_kinds(kinds: list[str], body: str) -> None:
    """Refuse joints that MuJoCo does not combine in one body."""
    freedoms = sum(3 if kind == "ball" else 1 for kind in kinds)
    balls = [index for index, kind in enumerate(kinds) if kind == "ball"]
    turns_after = balls and any(kind != "slide" for kind in kinds[balls[0] + 1 :])
    if freedoms > _MOST_FREEDOMS or turns_after:
        raise ModelError(
            f"body {body!r}: {', '.join(kinds)} cannot be its joints together in MuJoCo; give the "
            "massless links between them a mass"
        )


def ranges_of(limits: Limits) -> dict[str, str]:
    """Return the attributes of a joint's limits; none where MJCF has no notation for them."""
    bounds = (limits.lower, limits.upper), limits.efforts
    names = ("range", "actuatorfrcrange")
    stated = ((name, _range(ends)) for name, ends in zip(names, bounds, strict=True))
    return {name: text for name, text in stated if text}


def _range(ends: tuple[float, float]) -> str:
    """Return a least and a greatest value in words; none where MJCF has no notation for them."""
    bounds = ends[0] < ends[1] and ends != UNBOUNDED
    return words(np.nan_to_num(ends)) if bounds else ""


def dynamics_of(dynamics: Dynamics) -> dict[str, str]:
    """Return the attributes of what rubs and springs along a hinge or slide of a joint."""
    names = ("damping", "frictionloss", "stiffness", "springref")
    stated = dynamics if dynamics.stiffness else dynamics._replace(rest=0.0)
    return {name: words([value]) for name, value in zip(names, stated, strict=True) if value}


def inertial_of(link: LinkDescription) -> dict[str, str]:
    """Return the attributes of the `<inertial>` of a link with mass."""
    tensor = 0.5 * (link.inertia + link.inertia.T)
    stated = {"pos": words(link.centre), "mass": words([link.mass])}
    products = tensor[[0, 0, 1], [1, 2, 2]]
    if not products.any():
        return {**stated, "diaginertia": words(np.diag(tensor))}
    return {**stated, "fullinertia": words([*np.diag(tensor), *products])}


def pose_of(placement: Array, name: str) -> dict[str, str]:
    """Return the attributes of a `(4, 4)` placement.

    Raises:
        ModelError: it reflects or scales what has the name.
    """
    turn, result = placement[:3, :3], {"pos": words(placement[:3, 3])}
    square = turn @ turn.T
    is_turn = np.allclose(square, np.eye(3), rtol=0.0, atol=ROTATION_TOLERANCE)
    if not is_turn or np.linalg.det(turn) < 0.0:
        raise ModelError(f"{name!r}: {turn.tolist()} is no rotation")
    if not np.array_equal(turn, np.eye(3)):
        x, y, z, w = pinocchio.Quaternion(turn).normalized().coeffs()
        result["quat"] = words([w, x, y, z])
    return result
