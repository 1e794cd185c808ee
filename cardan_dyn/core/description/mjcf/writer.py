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

Limits of position are written where both are finite, no others; nor names of fixed joints, the
joints that the author drives, damping and friction of balls, visuals and warnings.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from xml.sax.saxutils import quoteattr

import numpy as np

from ....kit.arrays import Array, inverse
from ....kit.errors import ModelError, choices
from ..description import (
    Description,
    Dynamics,
    JointDescription,
    JointOrLoop,
    LinkDescription,
    LoopDescription,
    elementary,
)
from ..elements import ROTATION_TOLERANCE, SINGLE_TYPES, unique, words

_DIRECT = {"spherical": "connect", "fixed": "weld"}
"""Types of loops that are an equality, and its kind."""
_WORLD = "world"
_POWERS = 5
"""Coefficients of MuJoCo's `polycoef`."""
"""Name of MuJoCo's outermost body."""
_WORDS = {"revolute": "hinge", "prismatic": "slide", "spherical": "ball"}
"""Elementary part of a joint to the joint that it is in MJCF."""
_MOST_FREEDOMS = 6
"""Freedoms that MuJoCo allows between a body and the one that carries it."""


@dataclass
class _WrittenBody:
    """A body to be written.

    Attributes:
        name: its name; empty for what stands in the world itself.
        placement: `(4, 4)` in the body around it.
        lines: its joints, inertia and sites.
        children: bodies in it.
    """

    name: str
    placement: Array
    lines: list[str] = field(default_factory=list)
    children: list[_WrittenBody] = field(default_factory=list)


def to_mjcf(description: Description) -> str:
    """Return a description as MJCF text, which `read` and MuJoCo read.

    Raises:
        ModelError: something has no notation in MJCF: a moving link without mass, a coupling of
            links that several joints move from their common ancestor, a matrix that is no rotation.
    """
    return _MjcfWriter(description).text()


class _MjcfWriter:
    def __init__(self, description: Description) -> None:
        self._description = description
        self._groups = RigidGroups(description)
        self._bodies: dict[str, _WrittenBody] = {}
        self._world = _WrittenBody("", np.eye(4))
        self._equalities: list[str] = []
        joints = [item.name for item in description.joints]
        joints += [item.name for item in description.loops]
        self._taken = {"body": {link.name for link in description.links}, "joint": set(joints)}
        self._taken["equality"] = self._taken["joint"] | {
            item.name for item in description.couplings
        }
        self._carried: dict[str, list[JointOrLoop]] = {link.name: [] for link in description.links}
        for joint in description.joints:
            self._carried[joint.parent].append(joint)
        for loop in description.loops:
            if not _is_direct(loop):
                self._carried[loop.predecessor].append(loop)

    def text(self) -> str:
        """Return the whole text."""
        description = self._description
        names = [link.name for link in description.links if link.name != description.root]
        if _WORLD in names:
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
            self._equalities.append(
                f"<joint name={quoteattr(coupling.name)} joint1={quoteattr(second)} "
                f"joint2={quoteattr(first)} "
                f'polycoef="{words(powers + [0.0] * (_POWERS - len(powers)))}"/>'
            )
        gravity = "0 0 0" if description.gravity is None else words(description.gravity)
        lines = [
            f"<mujoco model={quoteattr(description.name)}>",
            '  <compiler angle="radian" autolimits="true"/>',
            f'  <option gravity="{gravity}"/>',
            *_of_world(self._world),
        ]
        if self._equalities:
            indented = (f"    {line}" for line in self._equalities)
            lines += ["  <equality>", *indented, "  </equality>"]
        driven = [joint for joint in description.joints if joint.name in self._independent]
        if driven:
            motors = (f"    <motor joint={quoteattr(joint.name)}/>" for joint in driven)
            lines += ["  <actuator>", *motors, "  </actuator>"]
        return "\n".join([*lines, "</mujoco>", ""])

    @property
    def _independent(self) -> set[str]:
        """Joints of the tree with one coordinate that the description's author drives."""
        independent = self._description.independent_joints
        return {
            joint.name
            for joint in self._description.joints
            if joint.name in independent and joint.type in SINGLE_TYPES
        }

    def _write_tree(self) -> None:
        """Add the bodies of all links, and those that carry the joints of loops."""
        root = self._description.root
        body = self._world
        if root != _WORLD:
            body = self._add(self._world, root, np.eye(4))
            body.lines += self._inertial(self._groups.link(root), 1)
        self._bodies[root] = body
        waiting: list[tuple[str, list[JointDescription]]] = [(root, [])]
        while waiting:
            link, before = waiting.pop()
            for item in reversed(self._carried[link]):
                chain: list[JointOrLoop] = [*before, item]
                if isinstance(item, LoopDescription):
                    self._write_helper(chain, item)
                elif self._is_passed_through(item):
                    waiting.append((item.child, [*before, item]))
                else:
                    self._write_link(chain, item)
                    waiting.append((item.child, []))

    def _is_passed_through(self, joint: JointDescription) -> bool:
        """Return whether the link of a joint has no mass and no body of its own."""
        link = joint.child
        if joint.type == "fixed" or self._groups.mass(link) > 0.0:
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

    def _write_link(self, chain: list[JointOrLoop], joint: JointDescription) -> None:
        """Add the body of the link that a joint carries; `chain` ends with that joint."""
        link = self._groups.link(joint.child)
        body = self._body(chain, link.name, joint.child_placement)
        body.lines += self._inertial(link, self._groups.shares(link.name))
        self._bodies[link.name] = body

    def _write_helper(self, chain: list[JointOrLoop], loop: LoopDescription) -> None:
        """Add the body that carries the joint of a loop; `chain` ends with that joint."""
        name = unique(f"{loop.name}_half", self._taken["body"])
        self._taken["body"].add(name)
        body = self._body(chain, name, np.eye(4))
        body.lines.append(inertial_of(self._groups.helper(loop, name)))
        self._bodies[loop.name] = body

    def _body(
        self,
        chain: list[JointOrLoop],
        name: str,
        child_placement: Array,
    ) -> _WrittenBody:
        """Return the new body behind one or several joints."""
        # From the body backwards, the placement of each joint's frame in it.
        behind, frames = child_placement, []
        for position, item in enumerate(reversed(chain)):
            if position and isinstance(item, JointDescription):
                behind = item.child_placement @ behind
            frames.append(inverse(behind))
            behind = _origin(item) @ behind
        check_kinds([kind for item in chain for kind, _ in _parts(item)], name)
        first = chain[0]
        parent = first.parent if isinstance(first, JointDescription) else first.predecessor
        if first.type == "floating" and self._groups.is_fixed(parent):
            return self._free(chain, name, behind)
        body = self._add(self._bodies[parent], name, behind)
        for item, frame in zip(chain, reversed(frames), strict=True):
            body.lines += self._joint_lines(item, frame)
        return body

    def _free(self, chain: list[JointOrLoop], name: str, placement: Array) -> _WrittenBody:
        """Return the body of a joint with all freedoms, which MuJoCo knows in the world only."""
        joint = chain[0]
        if not isinstance(joint, JointDescription) or len(chain) > 1:
            raise ModelError(
                f"{self._description.name}: link of the floating joint {joint.name!r} has no mass, "
                "which MuJoCo does not accept; give it one"
            )
        body = self._add(self._world, name, self._groups.placement(joint.parent) @ placement)
        rotors = {*joint.armature}
        if len(rotors) > 1:
            raise ModelError(
                f"{self._description.name}: joint {joint.name!r}: MuJoCo knows one armature of all "
                f"motions of a free body, not {words(joint.armature)}"
            )
        armature = "".join(f' armature="{words([inertia])}"' for inertia in rotors)
        kind = 'joint type="free"' if armature else "freejoint"
        body.lines.append(f"<{kind} name={quoteattr(joint.name)}{armature}/>")
        return body

    def _add(self, carrier: _WrittenBody, name: str, placement: Array) -> _WrittenBody:
        check_rotation(placement, name)
        body = _WrittenBody(name, placement)
        carrier.children.append(body)
        return body

    def _joint_lines(self, item: JointOrLoop, frame: Array) -> list[str]:
        """Return the elements of a joint whose `(4, 4)` frame in the body is given."""
        parts = _parts(item)
        lines = []
        # A fixed joint that a scene may drive has no parts here, and a rotor.
        rotors = item.armature if parts and item.armature else (0.0,) * len(parts)
        for count, ((kind, axis), inertia) in enumerate(zip(parts, rotors, strict=True), start=1):
            name = item.name
            if count < len(parts):
                name = unique(f"{item.name}_{count}", self._taken["joint"])
                self._taken["joint"].add(name)
            attributes = f'name={quoteattr(name)} type="{kind}" pos="{words(frame[:3, 3])}"'
            if kind != "ball":
                attributes += f' axis="{words(frame[:3, :3] @ axis)}"{dynamics_of(item.dynamics)}'
            if inertia:
                attributes += f' armature="{words([inertia])}"'
            if len(parts) == 1 and isinstance(item, JointDescription):
                attributes += range_of(item)
            lines.append(f"<joint {attributes}/>")
        return lines

    def _inertial(self, link: LinkDescription, shares: int) -> list[str]:
        if link.mass == 0.0:
            if np.any(link.inertia):
                raise ModelError(f"link {link.name!r}: an inertia without a mass cannot be written")
            return []
        share = replace(link, mass=link.mass / shares, inertia=link.inertia / shares)
        return [inertial_of(share)]

    def _write_loop(self, loop: LoopDescription) -> None:
        """Add the equality of a loop, and the sites between which it holds."""
        ends = [
            (loop.predecessor, loop.predecessor_origin),
            (loop.successor, loop.successor_origin),
        ]
        name = loop.name
        if not _is_direct(loop):
            ends[0] = loop.name, np.eye(4)
            name = unique(f"{loop.name}_weld", self._taken["equality"])
            self._taken["equality"].add(name)
        sites = []
        for side, (body, origin) in zip(("predecessor", "successor"), ends, strict=True):
            site = f"{loop.name}_{side}"
            check_rotation(origin, site)
            self._bodies[body].lines.append(f"<site name={quoteattr(site)}{pose_of(origin)}/>")
            sites.append(quoteattr(site))
        kind = _DIRECT[loop.type] if _is_direct(loop) else "weld"
        self._equalities.append(
            f"<{kind} name={quoteattr(name)} site1={sites[0]} site2={sites[1]}/>"
        )

    def _coupled(self, link: str, other: str, coupling: str) -> str:
        """Return the one joint that moves a link of a coupling against the common ancestor."""
        common = {joint.name for joint in self._groups.path(other)}
        joints = [joint for joint in self._groups.path(link) if joint.name not in common]
        if len(joints) != 1 or joints[0].type not in SINGLE_TYPES:
            raise ModelError(
                f"{self._description.name}: coupling {coupling!r}: MJCF couples two joints with "
                f"one coordinate; between {link!r} and the common ancestor with {other!r} are "
                f"{choices([f'{joint.name} ({joint.type})' for joint in joints])}"
            )
        return joints[0].name


def _is_direct(loop: LoopDescription) -> bool:
    """Return whether a loop is an equality by itself, which has no rates."""
    return loop.type in _DIRECT and not loop.armature


def _parts(item: JointOrLoop) -> list[tuple[str, Array]]:
    """Return MJCF's words and axes for the coordinates of a joint, outermost first."""
    return [(_WORDS[kind], axis) for kind, axis in elementary(item.type, item.axis, item.axis_2)]


def _origin(item: JointOrLoop) -> Array:
    return item.origin if isinstance(item, JointDescription) else item.predecessor_origin


def _of_world(world: _WrittenBody) -> list[str]:
    """Return the lines of `<worldbody>` with all bodies in it; nested ones without recursion."""
    lines = ["  <worldbody>", *(f"    {line}" for line in world.lines)]
    waiting: list[tuple[_WrittenBody, int, bool]] = [
        (body, 2, True) for body in reversed(world.children)
    ]
    while waiting:
        body, depth, is_opened = waiting.pop()
        indent = "  " * depth
        if not is_opened:
            lines.append(f"{indent}</body>")
            continue
        lines.append(f"{indent}<body name={quoteattr(body.name)}{pose_of(body.placement)}>")
        lines += [f"{indent}  {line}" for line in body.lines]
        waiting.append((body, depth, False))
        waiting += [(child, depth + 1, True) for child in reversed(body.children)]
    return [*lines, "  </worldbody>"]


class RigidGroups:
    """The groups of links of a description that move as one body."""

    def __init__(self, description: Description) -> None:
        self._links = {link.name: link for link in description.links}
        self._carriers = {joint.child: joint for joint in description.joints}
        self._root = description.root
        self._first: dict[str, str] = {}
        self._placements: dict[str, Array] = {}
        for name in self._links:
            self._place(name)
        self._members: dict[str, list[LinkDescription]] = {}
        for link in description.links:
            self._members.setdefault(self._first[link.name], []).append(link)
        self._shares: dict[str, int] = {}
        for loop in description.loops:
            if not _is_direct(loop):
                first = self._first[loop.successor]
                self._shares[first] = self._shares.get(first, 1) + 1

    def _place(self, name: str) -> None:
        """Find the first link of the group of a link, and the placement of the link there."""
        path = []
        while name not in self._first:
            joint = self._carriers.get(name)
            if joint is None or joint.type != "fixed":
                self._first[name], self._placements[name] = name, np.eye(4)
                break
            path.append(joint)
            name = joint.parent
        for joint in reversed(path):
            self._first[joint.child] = self._first[joint.parent]
            placement = self._placements[joint.parent] @ joint.origin @ joint.child_placement
            self._placements[joint.child] = placement

    def link(self, name: str) -> LinkDescription:
        """Return a link by name."""
        return self._links[name]

    def placement(self, link: str) -> Array:
        """Return the `(4, 4)` placement of a link in the first link of its group."""
        return self._placements[link]

    def is_fixed(self, link: str) -> bool:
        """Return whether a link stands still."""
        return self._first[link] == self._root

    def members(self, link: str) -> list[LinkDescription]:
        """Return all links that move as one with a link."""
        return self._members[self._first[link]]

    def mass(self, link: str) -> float:
        """Return the mass [kg] of all links that move as one with a link."""
        return sum(item.mass for item in self.members(link))

    def shares(self, link: str) -> int:
        """Return among how many bodies the inertia of a link's group is split."""
        return 1 if self.is_fixed(link) else self._shares.get(self._first[link], 1)

    def helper(self, loop: LoopDescription, name: str) -> LinkDescription:
        """Return the mass of the body that carries a loop's joint, in the joint's frame.

        It is a share of its successor's. A successor that stands still has none that counts: a
        mass of the size of the others keeps the model regular and is held by the weld alone.
        """
        if self.is_fixed(loop.successor):
            masses = [link.mass for link in self._links.values() if link.mass > 0.0]
            mass = float(np.mean(masses)) if masses else 1.0
            return LinkDescription(name, mass, np.zeros(3), mass * np.eye(3))
        frame = self._placements[loop.successor] @ loop.successor_origin
        members = self.members(loop.successor)
        mass, count = sum(link.mass for link in members), self.shares(loop.successor)
        if mass == 0.0:
            raise ModelError(
                f"loop {loop.name!r}: its successor {loop.successor!r} moves and has no mass, "
                "which MuJoCo does not accept; give it one"
            )
        seen = [inverse(frame) @ self._placements[link.name] for link in members]
        centres = [
            at[:3, :3] @ link.centre + at[:3, 3] for at, link in zip(seen, members, strict=True)
        ]
        centre = sum(
            (link.mass / mass * own for link, own in zip(members, centres, strict=True)),
            np.zeros(3),
        )
        inertia = np.zeros((3, 3))
        for link, at, own in zip(members, seen, centres, strict=True):
            turn, arm = at[:3, :3], own - centre
            inertia += turn @ link.inertia @ turn.T
            inertia += link.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        return LinkDescription(name, mass / count, centre, inertia / count)

    def path(self, link: str) -> list[JointDescription]:
        """Return the moving joints from a link to the root."""
        joints = []
        while link in self._carriers:
            joint = self._carriers[link]
            if joint.type != "fixed":
                joints.append(joint)
            link = joint.parent
        return joints


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


def range_of(joint: JointDescription) -> str:
    """Return the attribute of a joint's limits; empty where MJCF has no notation for them."""
    lower, upper = joint.limits.lower, joint.limits.upper
    if not (np.isfinite([lower, upper]).all() and lower < upper):
        return ""
    return f' range="{words([lower, upper])}"'


def dynamics_of(dynamics: Dynamics) -> str:
    """Return the attributes of what rubs and springs along a hinge or slide of a joint."""
    stated = {
        "damping": dynamics.damping,
        "frictionloss": dynamics.friction,
        "stiffness": dynamics.stiffness,
        "springref": dynamics.rest if dynamics.stiffness else 0.0,
    }
    return "".join(f' {name}="{words([value])}"' for name, value in stated.items() if value)


def inertial_of(link: LinkDescription) -> str:
    """Return the `<inertial>` of a link with mass."""
    tensor = 0.5 * (link.inertia + link.inertia.T)
    if np.count_nonzero(tensor - np.diag(np.diag(tensor))):
        moments = [tensor[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
        inertia = f'fullinertia="{words(moments)}"'
    else:
        inertia = f'diaginertia="{words(np.diag(tensor))}"'
    return f'<inertial pos="{words(link.centre)}" mass="{words([link.mass])}" {inertia}/>'


def pose_of(placement: Array) -> str:
    """Return the attributes of a `(4, 4)` placement."""
    result = f' pos="{words(placement[:3, 3])}"'
    if not np.array_equal(placement[:3, :3], np.eye(3)):
        result += f' quat="{words(quaternion_of(placement[:3, :3]))}"'
    return result


def check_rotation(placement: Array, name: str) -> None:
    """Refuse a `(4, 4)` matrix that is no placement.

    Raises:
        ModelError: it reflects or scales.
    """
    turn = placement[:3, :3]
    square = turn @ turn.T
    is_turn = np.allclose(square, np.eye(3), rtol=0.0, atol=ROTATION_TOLERANCE)
    if not is_turn or np.linalg.det(turn) < 0.0:
        raise ModelError(f"{name!r}: {turn.tolist()} is no rotation")


def quaternion_of(turn: Array) -> Array:
    """Return the unit quaternion w x y z of a rotation `(3, 3)`, accurate for any angle.

    Source: S. W. Shepperd, Quaternion from rotation matrix, 1978: the greatest component is found
    first, so that none is divided by a small number.
    """
    xx, yy, zz = np.diag(turn)
    squares = np.array([1 + xx + yy + zz, 1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz])
    w = np.array([0.0, turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    rows = np.zeros((4, 4))
    rows[0] = rows[:, 0] = w
    rows[1:, 1:] = turn + turn.T
    rows[np.diag_indices(4)] = squares
    row = rows[int(np.argmax(squares))]
    return np.asarray(row / np.linalg.norm(row))
