"""Description: what a file says about a mechanism, checked, as plain data.

The model is built from these numbers alone. Records that say the same about a mechanism are equal,
whatever notation they were read from: `==` compares contents, arrays included, to the last bit.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, TypeAlias

import numpy as np

from ...kit.arrays import Array
from ...kit.frozen import FrozenDict, Value, read_only

IDENTITY = read_only(np.eye(4))
"""Placement `(4, 4)` in the same place."""
X_AXIS = read_only(np.array([1.0, 0.0, 0.0]))
"""Axis `(3,)` of a joint that states none."""
ROUNDING = 1e-12
"""Displacement [rad, m] and closure error that is rounding."""
PRESSURE_ANGLE = np.pi / 9.0
"""Pressure angle of the usual basic rack [rad]. Source: ISO 53:1998."""
GUESTS = {
    "mujoco": "cardan_dyn.practice.formats.mjcf",
    "sdf": "cardan_dyn.practice.formats.sdf",
}
"""Outermost elements of texts to the packages that read them, imported when one is needed.

Each has `parse` in its module `reader`, `reread` in `second_reading`, and `visuals` in `visuals`.
"""


@dataclass(frozen=True, eq=False)
class Source:
    """Where a description comes from, for what is read only when it is shown or proven.

    Attributes:
        guest: name of the package that reads it, see `GUESTS`; empty for a URDF, which the
            core reads itself.
    """

    guest: str = field(default="", kw_only=True)


@dataclass(frozen=True, eq=False)
class SourceText(Source):
    """A text that a description was read from.

    Attributes:
        text: the whole text.
        path: the file, beside which meshes are found; None for text.
        beside: the YAML file that lists loops of a URDF, as it was read; empty without one.
        model: name of the one of several models that was asked for; None where there is only one.
    """

    text: str
    path: Path | None
    beside: str | bytes = ""
    model: str | None = None

    @property
    def folder(self) -> Path | None:
        """Where the file is; None for text."""
        return None if self.path is None else self.path.parent


@dataclass(frozen=True, eq=False, repr=False)
class LinkDescription(Value):
    """A link and its mass.

    Attributes:
        name: its name.
        mass: [kg]; 0 for a massless link, and for a rotor that is given by its inertia alone.
        centre: `(3,)` centre of mass in the link's frame [m].
        inertia: `(3, 3)` about the centre, in the link's axes [kg·m²].
    """

    name: str
    mass: float = 0.0
    centre: Array = field(default_factory=lambda: np.zeros(3))
    inertia: Array = field(default_factory=lambda: np.zeros((3, 3)))

    @property
    def is_massless(self) -> bool:
        """Whether it has neither mass nor inertia."""
        return self.mass == 0.0 and not np.any(self.inertia)

    def seen_in(self, placement: Array) -> LinkDescription:
        """Return the link as seen in the frame in which it has a `(4, 4)` placement."""
        turn = placement[:3, :3]
        centre = turn @ self.centre + placement[:3, 3] if self.mass else self.centre
        return replace(self, centre=centre, inertia=turn @ self.inertia @ turn.T)

    def __repr__(self) -> str:
        return f"<LinkDescription {self.name!r}: {self.mass:g} kg>"


class Dynamics(NamedTuple):
    """What rubs and springs along each coordinate of a joint.

    No wrench considers it, unless a scene takes it for an element.

    Attributes:
        damping: viscous [N·m·s/rad or N·s/m].
        friction: dry [N·m or N].
        stiffness: of a spring [N·m/rad or N/m].
        rest: position at which the spring is without effort [rad or m].
    """

    damping: float = 0.0
    friction: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0

    @property
    def acts(self) -> bool:
        """Whether any effort comes of it."""
        return bool(self.damping or self.friction or self.stiffness)


@dataclass(frozen=True, eq=False)
class Limits(Value):
    """Limits of a joint's coordinate: results tell what lies beyond them, and nothing is cut off.

    Attributes:
        lower, upper: position [rad or m].
        velocity: [rad/s or m/s].
        effort: the greatest one [N·m or N].
        least_effort: as a cylinder pulls less than it pushes [N·m or N]; None where it is the
            greatest one in the other sense.
    """

    lower: float = -np.inf
    upper: float = np.inf
    velocity: float = np.inf
    effort: float = np.inf
    least_effort: float | None = None

    def __post_init__(self) -> None:
        if self.least_effort == -self.effort:
            object.__setattr__(self, "least_effort", None)
        super().__post_init__()

    @property
    def efforts(self) -> tuple[float, float]:
        """The least and the greatest effort [N·m or N]."""
        least = self.least_effort
        return (-self.effort if least is None else least), self.effort


UNBOUNDED = (-np.inf, np.inf)
"""The least and the greatest of what nothing bounds."""


class ActuatorDescription(NamedTuple):
    """A motor or cylinder along a joint, as its author has it.

    Attributes:
        name: its name; may be empty.
        joint: name of the joint along which it acts.
        gear: effort of the joint per force of the actuator.
        force: least and greatest force, before the gear [N·m or N].
        control: least and greatest force that is asked of it, where a control asks for forces.
        is_direct: whether its force is what its control asks for, not what a law makes of that.
    """

    name: str
    joint: str
    gear: float = 1.0
    force: tuple[float, float] = UNBOUNDED
    control: tuple[float, float] = UNBOUNDED
    is_direct: bool = True


def summed_efforts(
    factors: Iterable[float], efforts: Iterable[tuple[float, float]]
) -> tuple[float, float]:
    """Return the least and the greatest sum of efforts, each between two values, times factors."""
    least = greatest = 0.0
    for factor, ends in zip(factors, efforts, strict=True):
        if factor:
            low, high = sorted(float(factor) * end for end in ends)
            least, greatest = least + low, greatest + high
    return least, greatest


class _TwoAxes(Value):
    """What has two axes, which are one but for types of `TWO_AXES`."""

    type: str
    axis: Array

    def __post_init__(self) -> None:
        if self.type not in TWO_AXES:
            object.__setattr__(self, "axis_2", self.axis)
        super().__post_init__()


@dataclass(frozen=True, eq=False, repr=False)
class JointDescription(_TwoAxes):
    """A joint of the spanning tree.

    Attributes:
        name: its name.
        type: one of `elements.TREE_TYPES`.
        parent, child: names of the two links.
        origin: `(4, 4)` placement of the joint's frame in the parent [m].
        axis: `(3,)` unit axis in the joint frame.
        axis_2: `(3,)` second axis of a joint of `TWO_AXES`; else the first.
        child_placement: `(4, 4)` placement of the child link in the joint's frame [m]. In a URDF
            both frames coincide; MJCF places them independently.
        limits: of its coordinate.
        adjustable: what a `fixed` joint becomes in a scene that holds or drives it: `revolute` or
            `prismatic` along `axis`, where its place is zero; empty if it stays fixed.
        dynamics: what rubs and springs along its coordinates.
        armature: of each of its parts, see `elementary`, the inertia that rotors have along its
            rates [kg·m²; of a slide kg]: a rotor's own times the square of how much faster it
            turns; about all axes of a ball alike. None where nothing states any. What acts along
            the rates accelerates it; bodies feel nothing else of it.
    """

    name: str
    type: str
    parent: str
    child: str
    origin: Array
    axis: Array = field(default_factory=lambda: X_AXIS)
    axis_2: Array = field(default_factory=lambda: X_AXIS)
    child_placement: Array = field(default_factory=lambda: IDENTITY)
    limits: Limits = field(default_factory=Limits)
    adjustable: str = ""
    dynamics: Dynamics = field(default_factory=Dynamics)
    armature: tuple[float, ...] = ()

    ENDS: ClassVar = (("parent", "origin"),)
    """Names of its fields: a link, and the placement of the joint's frame in that."""

    def __repr__(self) -> str:
        return f"<JointDescription {self.name!r}: {self.type}, {self.parent!r} -> {self.child!r}>"


@dataclass(frozen=True, eq=False, repr=False)
class LoopDescription(_TwoAxes):
    """A closure between two links, in URDF+ notation.

    Attributes:
        name: name of the joint that the loop is.
        type: one of `elements.LOOP_TYPES`.
        predecessor, successor: names of the two links.
        predecessor_origin, successor_origin: `(4, 4)` placements of the joint frame in the links
            [m]. The coordinate is zero where both coincide.
        axis: `(3,)` unit vector in the joint frame.
        axis_2: `(3,)` second axis of a joint of `TWO_AXES`; else the first.
        dynamics: what rubs and springs along its coordinates.
        armature: see `JointDescription`.
    """

    name: str
    type: str
    predecessor: str
    successor: str
    predecessor_origin: Array
    successor_origin: Array
    axis: Array = field(default_factory=lambda: X_AXIS)
    axis_2: Array = field(default_factory=lambda: X_AXIS)
    dynamics: Dynamics = field(default_factory=Dynamics)
    armature: tuple[float, ...] = ()

    ENDS: ClassVar = (
        ("predecessor", "predecessor_origin"),
        ("successor", "successor_origin"),
    )
    """See `JointDescription.ENDS`."""

    def __repr__(self) -> str:
        ends = f"{self.predecessor!r} -> {self.successor!r}"
        return f"<LoopDescription {self.name!r}: {self.type}, {ends}>"


JointOrLoop: TypeAlias = JointDescription | LoopDescription

TWO_AXES = frozenset({"universal"})
"""Types of joints that have two axes, at right angles."""


class Mesh(NamedTuple):
    """The teeth of two gears on parallel axes.

    Attributes:
        pressure_angle: between their line of action and the tangent of the pitch circles, across
            the axes [rad].
        helix_angle: of the predecessor's teeth to its axis at the pitch circle, positive for a
            right-hand helix [rad].
        along: way along the predecessor's axis from its joint's origin to the middle of the teeth
            [m]; None where both joints have their origins in this plane.
    """

    pressure_angle: float = PRESSURE_ANGLE
    helix_angle: float = 0.0
    along: float | None = None


@dataclass(frozen=True, eq=False)
class CouplingDescription(Value):
    """A coupling of two motions, either of links, as URDF+ has it, or of joints.

    The motion of the successor is `offset` plus `ratio` times that of the predecessor, plus
    `higher` times its square, its cube and so on. The motion of a link is its angle or slide,
    summed up over the joints from the nearest common ancestor of both links; that of a joint is its
    coordinate.

    Attributes:
        name: its name.
        predecessor, successor: names of the two links, or of the two joints of the tree.
        ratio: motion of the successor per motion of the predecessor.
        offset: motion of the successor while the predecessor is at zero [rad or m].
        of_joints: whether it couples joints, as `<mimic>` does.
        higher: coefficients of the predecessor's square, cube and so on, the last one not zero; the
            ratio may be zero where there are any.
        forces: what it exerts on the links: `none` but moments about turning axes and forces along
            slides, between the two links of each joint; those of a `mesh` of teeth; or empty where
            nothing says so.
        mesh: the teeth; None without.
    """

    name: str
    predecessor: str
    successor: str
    ratio: float
    offset: float = 0.0
    of_joints: bool = False
    forces: str = ""
    mesh: Mesh | None = None
    higher: tuple[float, ...] = ()

    @property
    def polynomial(self) -> np.polynomial.Polynomial:
        """Motion of the successor as a function of that of the predecessor."""
        return np.polynomial.Polynomial((self.offset, self.ratio, *self.higher))


class Displacement(NamedTuple):
    """How the frame of a joint, or the successor's end of a loop, was displaced.

    Attributes:
        joint: name of the joint or loop.
        is_end: whether it is the successor's end of a loop.
        matrix: `(4, 4)` displacement in the frame's own axes [m].
        before: `(4, 4)` placement of the frame in its link before.
    """

    joint: str
    is_end: bool
    matrix: Array
    before: Array

    def __str__(self) -> str:
        """Return it in words, without what is rounding."""
        turn = self.matrix[:3, :3]
        # An axial vector's length is the sine: rounding does not decide small angles.
        sine = 0.5 * float(np.linalg.norm(np.cross(np.eye(3), turn, axisb=0).sum(axis=0)))
        angle = float(np.arctan2(sine, 0.5 * (np.trace(turn) - 1.0)))
        distance = float(np.linalg.norm(self.matrix[:3, 3]))
        parts = [f"turned by {angle:.2g} rad"] * (angle > ROUNDING)
        parts += [f"shifted by {distance:.2g} m"] * (distance > ROUNDING)
        return f"{self.joint}{' on its successor' * self.is_end} {' and '.join(parts)}"


@dataclass(frozen=True, eq=False, repr=False)
class Description(Value):
    """A checked description.

    Two descriptions are equal (`==`) where they say the same about the mechanism, limits, drives
    and the order of joints included. How it was written does not count: source text, notation and
    warnings may differ. `print` shows a summary.

    Attributes:
        name: name of the mechanism.
        links: in file order; one of them, the root, is the child of no joint.
        joints: those of the spanning tree, in file order.
        order: names of the tree joints in the order in which Pinocchio's own reader of the
            format would take them, so that its users find the indices that they know.
        loops: the closures in file order.
        couplings: the couplings in file order.
        independent_joints: names of the joints that its author drives.
        notation: how the loops were written, and what else was found.
        warnings: what is wrong with it and was accepted.
        source: what it was read from; None where its numbers are not those of anything.
        frames: further frames by name, such as the sites of MJCF: the link that carries each, and
            its `(4, 4)` placement there [m].
        displacements: what was changed about the numbers of its text, see `displaced`.
        remedy: what would let loops close all along their motion, where its numbers miss that;
            empty where nothing is known.
        added: URDF+ text of the loops and couplings that were added to those of the source; empty
            without any.
        keyframes: name to positions of the joints of its tree by name [rad or m], those of a ball
            as a unit quaternion (x, y, z, w), of a floating joint `(7,)` with that last.
        gravity: `(3,)` acceleration of free fall in world axes [m/s²], which scenes take where they
            ask for that of the description; None where its notation has none.
        states_gravity: whether the author wrote it; else it is the format's default.
        origins: names of joints that are lengths and angles of it, see `origins`; its source knows
            nothing of them.
        actuators: what acts along its joints, whose limits of effort consider it.
    """

    name: str
    links: tuple[LinkDescription, ...]
    joints: tuple[JointDescription, ...]
    order: tuple[str, ...]
    loops: tuple[LoopDescription, ...]
    couplings: tuple[CouplingDescription, ...] = ()
    independent_joints: tuple[str, ...] = ()
    notation: str = field(default="URDF+", compare=False)
    warnings: tuple[str, ...] = field(default=(), compare=False)
    source: Source | None = field(default=None, compare=False)
    frames: Mapping[str, tuple[str, Array]] = field(
        default_factory=lambda: FrozenDict({}), compare=False
    )
    displacements: tuple[Displacement, ...] = field(default=(), compare=False)
    remedy: str = field(default="", compare=False)
    added: str = field(default="", compare=False)
    keyframes: Mapping[str, Mapping[str, float | Array]] = field(
        default_factory=lambda: FrozenDict({}), compare=False
    )
    gravity: Array | None = field(default=None, compare=False)
    states_gravity: bool = field(default=False, compare=False)
    origins: tuple[str, ...] = field(default=(), compare=False)
    actuators: tuple[ActuatorDescription, ...] = field(default=(), compare=False)

    def displaced(self, by: Mapping[tuple[str, bool], Array]) -> Description:
        """Return the description with frames of joints and ends of loops elsewhere.

        Args:
            by: name of a joint or loop, and whether its successor's end is meant, to the `(4, 4)`
                displacement in the frame's own axes [m].
        """
        frames = {
            (item.name, bool(end)): getattr(item, field)
            for item in self.joints_and_loops
            for end, (_, field) in enumerate(item.ENDS)
        }
        changed = tuple(Displacement(*key, matrix, frames[key]) for key, matrix in by.items())
        frames.update({(*item[:2],): item.before @ item.matrix for item in changed})
        return self._with_frames(frames, changed)

    def undisplaced(self) -> Description:
        """Return the description with the numbers of its text."""
        return self._with_frames({item[:2]: item.before for item in self.displacements}, ())

    def _with_frames(
        self, frames: Mapping[tuple[str, bool], Array], changed: tuple[Displacement, ...]
    ) -> Description:
        """Return the description with some frames elsewhere, and what was changed about them."""

        def moved(item: Any) -> Any:
            ends = (((item.name, bool(end)), field) for end, (_, field) in enumerate(item.ENDS))
            return replace(item, **{field: frames[end] for end, field in ends if end in frames})

        return self.with_each(moved, displacements=changed)

    def with_each(self, change: Callable[[Any], Any], **more: Any) -> Description:
        """Return the description with every joint and loop as changed, and other fields."""
        joints, loops = (tuple(map(change, items)) for items in (self.joints, self.loops))
        return replace(self, joints=joints, loops=loops, **more)

    def with_types(self, types: Mapping[str, str]) -> Description:
        """Return the description in which some joints and loops are of other types.

        Springs and friction of theirs, limits and the motion that an author gives them are left
        out: they were those of the type that it was. A rotor stays with the last part.
        """

        def changed(item: Any) -> Any:
            if item.name not in types:
                return item
            kind = types[item.name]
            rotors = at_last_parts(item.armature, kind)
            found = replace(item, type=kind, dynamics=Dynamics(), armature=rotors)
            return found if isinstance(item, LoopDescription) else replace(found, limits=Limits())

        kept = tuple(name for name in self.independent_joints if name not in types)
        return self.with_each(changed, independent_joints=kept)

    @property
    def joints_and_loops(self) -> tuple[JointOrLoop, ...]:
        """The joints of the tree, then the loops, in file order."""
        return (*self.joints, *self.loops)

    @property
    def fixed_frames(self) -> dict[str, tuple[str, Array]]:
        """What is fixed in links and named unlike any: to the link, `(4, 4)` placement there [m].

        They are `fixed` joints of the tree and `frames`; of one name, a joint comes first.
        """
        links = {link.name for link in self.links}
        joints = {
            item.name: (item.parent, item.origin) for item in self.joints if item.type == "fixed"
        }
        return {
            name: place for name, place in {**self.frames, **joints}.items() if name not in links
        }

    @property
    def own_frames(self) -> dict[str, tuple[str, Array]]:
        """Those of `frames` that are no ends of loops, for which MJCF has sites of their names."""
        ends = [
            (f"{loop.name}_{side}", getattr(loop, side), getattr(loop, origin)[:3, 3])
            for loop in self.loops
            for side, origin in loop.ENDS
        ]
        return {
            name: (link, place)
            for name, (link, place) in self.frames.items()
            if not any(
                re.fullmatch(rf"{re.escape(end)}(_\d+)?", name)
                and link == at
                and np.array_equal(place[:3, 3], point)
                for end, at, point in ends
            )
        }

    @property
    def text(self) -> SourceText | None:
        """Its text and file, where it was read from one."""
        return self.source if isinstance(self.source, SourceText) else None

    @cached_property
    def root(self) -> str:
        """Name of the link that stands in the world."""
        children = {joint.child for joint in self.joints}
        return next(link.name for link in self.links if link.name not in children)

    def __repr__(self) -> str:
        counts = (
            f"{len(items)} {name}{'s' * (len(items) != 1)}"
            for name in ("link", "joint", "loop", "coupling")
            if (items := getattr(self, f"{name}s"))
        )
        return f"<Description {self.name!r}: {', '.join(counts)}>"

    def __str__(self) -> str:
        """Return a summary: links with masses, joints with axes, loops, couplings and drives."""
        from ...kit.markup import aligned  # Only what is printed needs it.

        sections: dict[str, list[tuple[str, ...]]] = {
            "links": [_of_link(link) for link in self.links],
            "joints": [
                _of_joint(joint, joint.parent, joint.child, joint.name in self.independent_joints)
                for joint in self.joints
            ],
            "loops": [_of_joint(loop, loop.predecessor, loop.successor) for loop in self.loops],
            "couplings": [
                (
                    item.name,
                    shown_ratio(item.ratio, item.offset, item.higher),
                    f"{item.predecessor} -> {item.successor}",
                )
                for item in self.couplings
            ],
        }
        lines = [self.name]
        for title, rows in sections.items():
            if rows:
                lines += [f"{title}:", aligned([("", *row) for row in rows])]
        return "\n".join(lines)


def placed_links(
    links: Iterable[str], joints: Iterable[tuple[str, str, Array]]
) -> dict[str, Array]:
    """Return the `(4, 4)` placements of links in the root, with every joint at zero.

    Links that no chain of joints connects to a root are at the root.

    Args:
        links: names of all of them.
        joints: of each, the names of parent and child, and the child's `(4, 4)` placement there.
    """
    placed = dict.fromkeys(links, IDENTITY)
    children: dict[str, list[tuple[str, Array]]] = {link: [] for link in placed}
    carried = set()
    for parent, child, placement in joints:
        children.setdefault(parent, []).append((child, placement))
        carried.add(child)
    waiting = [link for link in placed if link not in carried]
    while waiting:
        parent = waiting.pop()
        for child, placement in children.pop(parent, []):
            placed[child] = placed[parent] @ placement
            waiting.append(child)
    return placed


def elementary(
    kind: str, axis: Array, axis_2: Array, cardan: bool = False
) -> list[tuple[str, Array]]:
    """Return kinds and axes of a joint type's parts, from the parent outwards.

    Args:
        kind: a joint type of URDF, or `spherical`, `universal`, `cylindrical`.
        axis: unit axis; the normal of a `planar` joint, the first axis of a `universal` one.
        axis_2: second axis of a `universal` joint.
        cardan: write a ball as three turns, whose angles are then coordinates.
    """
    alone = {
        "fixed": [],
        "revolute": [("revolute", axis)],
        "continuous": [("revolute", axis)],
        "prismatic": [("prismatic", axis)],
        "cylindrical": [("prismatic", axis), ("revolute", axis)],
        "universal": [("revolute", axis), ("revolute", axis_2)],
    }
    if kind in alone:
        return alone[kind]
    if kind in ("spherical", "floating"):
        x, y, z = np.eye(3)
        slides = [("prismatic", x), ("prismatic", y), ("prismatic", z)]
        ball = [("spherical", axis if kind == "spherical" else x)]
        if cardan:
            ball = [("revolute", x), ("revolute", y), ("revolute", z)]
        return ball if kind == "spherical" else [*slides, *ball]
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    across /= np.linalg.norm(across)
    further = np.cross(axis, across)
    slides = [("prismatic", across), ("prismatic", further)]
    turns = [("revolute", across), ("revolute", further), ("revolute", axis)]
    return {"planar": [*slides, turns[-1]], "loose": [*slides, *turns]}[kind]


def kinds_of(kind: str) -> list[str]:
    """Return the kinds of a joint type's parts, see `elementary`."""
    x, y, _ = np.eye(3)
    return [part for part, _ in elementary(kind, x, y)]


def at_last_parts(armature: Sequence[float], kind: str) -> tuple[float, ...]:
    """Return the armature of a joint type that is known of its last parts alone, or of none."""
    if not any(armature):
        return ()
    return (0.0,) * (len(kinds_of(kind)) - len(armature)) + tuple(armature)


def shown_ratio(ratio: float, offset: float, higher: Sequence[float]) -> str:
    """Return the ratio of a coupling, and what else it has of a polynomial, as a text."""
    powers = f", higher {' '.join(f'{value:g}' for value in higher)}" if higher else ""
    return f"ratio {ratio:g}" + (f", offset {offset:g}" if offset else "") + powers


def _of_link(link: LinkDescription) -> tuple[str, ...]:
    """Return the columns that a summary shows of a link."""
    if link.is_massless:
        return link.name, "massless", ""
    return link.name, f"{link.mass:g} kg", f"centre {_vector(link.centre)} m"


def _of_joint(joint: JointOrLoop, parent: str, child: str, driven: bool = False) -> tuple[str, ...]:
    """Return the columns that a summary shows of a joint or loop between two links."""
    axes = ""
    if joint.type in TWO_AXES:
        axes = f"axes {_vector(joint.axis)} and {_vector(joint.axis_2)}"
    elif joint.type not in ("fixed", "spherical", "floating"):
        axes = f"axis {_vector(joint.axis)}"
    rotors = f"armature {' '.join(f'{x:g}' for x in joint.armature)}" if joint.armature else ""
    drive = "independent" if driven else ""
    return joint.name, joint.type, f"{parent} -> {child}", axes, drive, rotors


def _vector(values: Array) -> str:
    # Adding zero removes the sign of negative zeros.
    return f"({', '.join(f'{value:.6g}' for value in values + 0.0)})"
