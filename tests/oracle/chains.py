"""Random closed chains: the text of a description, and the same numbers as plain data.

The geometry is drawn in the world with every joint at zero, so that all loops are closed there:
a point and an axis in the world are expressed in the frames of the two links that they connect.
Nothing of the package under test is used.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

Array = np.ndarray

LIMITS = '<limit lower="-1e9" upper="1e9" effort="1e9" velocity="1e9"/>'
TURNS = ("revolute", "continuous")


@dataclass(frozen=True, eq=False)
class Link:
    """A link: mass [kg], centre `(3,)` [m] and inertia about it `(3, 3)` [kg·m²] in its axes."""

    name: str
    mass: float = 0.0
    centre: Array = field(default_factory=lambda: np.zeros(3))
    inertia: Array = field(default_factory=lambda: np.zeros((3, 3)))
    text: str = ""


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint of the tree or of a loop.

    Attributes:
        parent, child: its links; predecessor and successor of a loop.
        parent_side, child_side: `(4, 4)` placements of its frame in them [m].
        axis, axis_2: `(3,)` unit vectors in its frame.
        closes: whether it closes a loop.
        zero: its coordinates while all joints of the tree are at zero, where not zero themselves.
    """

    name: str
    type: str
    parent: str
    child: str
    parent_side: Array
    child_side: Array
    axis: Array
    axis_2: Array
    closes: bool
    text: str
    zero: Array | None = None


@dataclass(frozen=True, eq=False)
class Coupling:
    """Ratio × coordinates from the world to the predecessor = those to the successor."""

    name: str
    predecessor: str
    successor: str
    ratio: float


@dataclass(frozen=True, eq=False)
class Chain:
    """A mechanism with loops as plain data; tree joints stand before what they carry.

    Attributes:
        size: length of its order of magnitude [m].
        features: what it has, for grouping failures.
    """

    links: dict[str, Link]
    joints: dict[str, Joint]
    couplings: tuple[Coupling, ...]
    size: float
    features: frozenset[str]

    def scaled(self, length: float, mass: float) -> Chain:
        """Return the chain with all lengths and masses multiplied.

        Only texts and the size follow: no oracle is asked about it.
        """

        def multiplied(text: str) -> str:
            text = re.sub(
                r'(<origin xyz=")([^"]*)',
                lambda found: found[1] + words([length * float(x) for x in found[2].split()]),
                text,
            )
            for name, factor in ((r"mass value", mass), (r"i[xyz]{2}", mass * length**2)):
                text = re.sub(
                    rf'([ <]{name}=)"([^"]*)"',
                    lambda found, factor=factor: f'{found[1]}"{factor * float(found[2])!r}"',
                    text,
                )
            return text

        return replace(
            self,
            links={
                name: replace(item, text=multiplied(item.text)) for name, item in self.links.items()
            },
            joints={
                name: replace(item, text=multiplied(item.text))
                for name, item in self.joints.items()
            },
            couplings=tuple(
                replace(item, ratio=item.ratio * length ** self._slides_more(item))
                for item in self.couplings
            ),
            size=self.size * length,
        )

    def _slides_more(self, coupling: Coupling) -> int:
        """Return 1 where only the successor of a coupling slides, -1 where only the other does."""
        by_child = {joint.child: joint for joint in self.joints.values() if not joint.closes}

        def slides(link: str) -> int:
            while link in by_child and by_child[link].type == "fixed":
                link = by_child[link].parent
            return int(link in by_child and by_child[link].type == "prismatic")

        return slides(coupling.successor) - slides(coupling.predecessor)

    @property
    def text(self) -> str:
        """The description in URDF+ notation."""
        couplings = [
            f'<coupling name="{item.name}" forces="none"><predecessor link="{item.predecessor}"/>'
            f'<successor link="{item.successor}"/><ratio value="{item.ratio!r}"/></coupling>'
            for item in self.couplings
        ]
        parts = [link.text for link in self.links.values()]
        parts += [joint.text for joint in self.joints.values()]
        return "\n".join(['<robot name="chain">', *parts, *couplings, "</robot>"])


def rotation(rpy: Sequence[float] | Array) -> Array:
    """Return the rotation of fixed-axis roll, pitch, yaw: R_z(yaw) R_y(pitch) R_x(roll)."""
    turns = [turn(axis, angle) for axis, angle in zip(np.eye(3), rpy, strict=True)]
    return turns[2] @ turns[1] @ turns[0]


def turn(axis: Array, angle: float) -> Array:
    """Return the rotation about a unit axis (Rodrigues)."""
    cross = skew(axis)
    return np.eye(3) + np.sin(angle) * cross + 2.0 * np.sin(0.5 * angle) ** 2 * cross @ cross


def skew(vector: Array) -> Array:
    """Return the matrix of the cross product with a vector."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def placed(rotated: Array, position: Sequence[float] | Array) -> Array:
    """Return a `(4, 4)` placement."""
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = rotated, position
    return result


def inverse(placement: Array) -> Array:
    """Return the inverse of a `(4, 4)` placement."""
    turned = placement[:3, :3].T
    return placed(turned, -turned @ placement[:3, 3])


def angles(rotated: Array) -> Array:
    """Return roll, pitch, yaw of a rotation."""
    roll = np.arctan2(rotated[2, 1], rotated[2, 2])
    # Yaw of what roll leaves: upright, where both turn about one axis, roll is rounding.
    left = rotated @ turn(np.array([1.0, 0.0, 0.0]), roll).T
    pitch = np.arctan2(-rotated[2, 0], np.hypot(rotated[0, 0], rotated[1, 0]))
    return np.array([roll, pitch, np.arctan2(-left[0, 1], left[1, 1])])


def words(values: Sequence[float] | Array) -> str:
    """Write numbers so that they are read back as they are."""
    return " ".join(repr(float(value)) for value in values)


def unit(vector: Array) -> Array:
    """Return a vector of length one."""
    return vector / np.linalg.norm(vector)


def written(placement: Array) -> tuple[Array, str]:
    """Return a `(4, 4)` placement, exactly as its text says it, and that text."""
    rpy, xyz = angles(placement[:3, :3]), placement[:3, 3]
    return (
        placed(rotation(rpy), xyz),
        f'<origin xyz="{words(xyz)}" rpy="{words(rpy)}"/>',
    )


def loop_joint(
    name: str,
    kind: str,
    links: tuple[str, str],
    ends: Iterable[Array],
    axes: tuple[Array, Array | None],
    zero: Array | None = None,
) -> Joint:
    """Return a loop between two links, whose frames `(4, 4)` in them are its ends."""
    (first, one), (second, two) = map(written, ends)
    axis, axis_2 = axes
    extra = "" if axis_2 is None else f'<axis2 xyz="{words(axis_2)}"/>'
    text = (
        f'<loop name="{name}" type="{kind}"><predecessor link="{links[0]}">{one}'
        f'</predecessor><successor link="{links[1]}">{two}</successor>'
        f'<axis xyz="{words(axis)}"/>{extra}</loop>'
    )
    axis = unit(np.asarray(axis, float))
    axis_2 = axis if axis_2 is None else unit(np.asarray(axis_2, float))
    return Joint(name, kind, *links, first, second, axis, axis_2, True, text, zero)


def turned(joint: Joint, rng: np.random.Generator, size: float) -> Joint:
    """Return a loop whose frames are turned and shifted along its own freedoms.

    The same bodies meet in the same axes and points; what differs is where its coordinates count
    from: those in `Joint.zero` close it while the tree is at zero.
    """
    axis, axis_2 = joint.axis, joint.axis_2
    angle_1, angle_2 = (
        float(
            rng.choice([0.0, 0.5 * np.pi, np.pi, rng.uniform(-np.pi, np.pi)], p=[0.1] * 3 + [0.7])
        )
        for _ in range(2)
    )
    shift_1, shift_2 = size * rng.uniform(-1.0, 1.0, size=2) * (rng.random(2) < 0.8)
    between = np.arctan2(np.sin(angle_2 - angle_1), np.cos(angle_2 - angle_1))
    if between < 1e-9 - np.pi:
        between += 2.0 * np.pi
    turns = turn(axis, angle_1), turn(axis, angle_2)
    if joint.type in ("revolute", "continuous"):
        moves = [placed(rotated, np.zeros(3)) for rotated in turns]
        zero = np.array([between])
    elif joint.type == "prismatic":
        moves = [placed(np.eye(3), shift * axis) for shift in (shift_1, shift_2)]
        zero = np.array([shift_2 - shift_1])
    elif joint.type == "cylindrical":
        moves = [
            placed(*item) for item in zip(turns, (shift_1 * axis, shift_2 * axis), strict=True)
        ]
        zero = np.array([shift_2 - shift_1, between])
    elif joint.type == "planar":
        smallest = min(range(3), key=lambda k: (abs(axis[k]), k))
        first = unit(np.cross(axis, np.eye(3)[smallest]))
        second = np.cross(axis, first)
        moves = [placed(turns[0], shift_1 * first), placed(turns[1], shift_2 * second)]
        seen = turns[0].T @ (shift_2 * second - shift_1 * first)
        zero = np.array([first @ seen, second @ seen, between])
    elif joint.type == "universal":
        # Of its two axes, each link keeps its own.
        moves = [placed(turns[0], np.zeros(3)), placed(turn(axis_2, angle_2), np.zeros(3))]
        zero = np.array([-angle_1, angle_2])
        zero = np.arctan2(np.sin(zero), np.cos(zero))
        zero[zero < 1e-9 - np.pi] += 2.0 * np.pi
    elif joint.type == "spherical":
        quaternions = [unit(rng.normal(size=4)) for _ in range(2)]
        moves = [placed(of_quaternion(item), np.zeros(3)) for item in quaternions]
        (u, a), (v, b) = ((item[:3], item[3]) for item in quaternions)
        zero = np.append(a * v - b * u - np.cross(u, v), a * b + u @ v)
        zero *= 1.0 if zero[3] > 0.0 else -1.0
    else:
        return joint
    ends = (joint.parent_side @ moves[0], joint.child_side @ moves[1])
    axes = axis, axis_2 if joint.type == "universal" else None
    return loop_joint(joint.name, joint.type, (joint.parent, joint.child), ends, axes, zero)


def of_quaternion(quaternion: Array) -> Array:
    """Return the rotation of a unit quaternion (x, y, z, w)."""
    vector, scalar = skew(quaternion[:3]), quaternion[3]
    return np.eye(3) + 2.0 * scalar * vector + 2.0 * vector @ vector


class Builder:
    """Puts a chain together from joints given in the world, all of them at zero.

    Attributes:
        links, joints, couplings, features: of the chain.
        at: `(4, 4)` placements of the links in the world.
    """

    def __init__(self, size: float = 1.0) -> None:
        self.size = size
        self.links: dict[str, Link] = {}
        self.joints: dict[str, Joint] = {}
        self.couplings: list[Coupling] = []
        self.features: set[str] = set()
        self.at: dict[str, Array] = {}
        self.link("world")
        self.at["world"] = np.eye(4)

    def link(
        self,
        name: str,
        mass: float = 0.0,
        centre: Sequence[float] | Array = (0.0, 0.0, 0.0),
        rpy: Sequence[float] | Array = (0.0, 0.0, 0.0),
        inertia: Array | None = None,
    ) -> None:
        """Add a link; `inertia` has the axes of `rpy`."""
        if mass == 0.0:
            self.links[name] = Link(name, text=f'<link name="{name}"/>')
            return
        tensor = np.eye(3) * 0.01 * mass * self.size**2 if inertia is None else inertia
        entries = " ".join(
            f'i{"xyz"[i]}{"xyz"[k]}="{float(tensor[i, k])!r}"'
            for i, k in zip(*np.triu_indices(3), strict=True)
        )
        text = (
            f'<link name="{name}"><inertial><origin xyz="{words(centre)}" rpy="{words(rpy)}"/>'
            f'<mass value="{float(mass)!r}"/><inertia {entries}/></inertial></link>'
        )
        axes = rotation(rpy)
        self.links[name] = Link(name, mass, np.array(centre, float), axes @ tensor @ axes.T, text)

    def joint(
        self,
        name: str,
        kind: str,
        parent: str,
        child: str,
        frame: Array,
        axis: Array | None = None,
    ) -> None:
        """Add a tree joint whose frame in the world is `frame`, `axis` in that frame."""
        seen, origin = self._seen_from(parent, frame)
        axis = np.array([0.0, 0.0, 1.0]) if axis is None else axis
        self.at[child] = self.at[parent] @ seen
        text = (
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'{origin}<axis xyz="{words(axis)}"/>'
            f"{LIMITS if kind in ('revolute', 'prismatic') else ''}</joint>"
        )
        axis = unit(np.asarray(axis, float))
        self.joints[name] = Joint(
            name, kind, parent, child, seen, np.eye(4), axis, axis, False, text
        )

    def loop(
        self,
        name: str,
        kind: str,
        predecessor: str,
        successor: str,
        frame: Array,
        axis: Array | None = None,
        axis_2: Array | None = None,
    ) -> None:
        """Add a loop whose frame in the world is `frame`, axes in that frame."""
        axis = np.array([0.0, 0.0, 1.0]) if axis is None else axis
        ends = (inverse(self.at[link]) @ frame for link in (predecessor, successor))
        self.joints[name] = loop_joint(name, kind, (predecessor, successor), ends, (axis, axis_2))

    def coupling(self, name: str, predecessor: str, successor: str, ratio: float) -> None:
        """Add a coupling."""
        self.couplings.append(Coupling(name, predecessor, successor, ratio))
        self.features.add("coupling")

    def chain(self) -> Chain:
        """Return what was put together; loops stand after the tree."""
        ordered = sorted(self.joints.values(), key=lambda joint: joint.closes)
        return Chain(
            dict(self.links),
            {joint.name: joint for joint in ordered},
            tuple(self.couplings),
            self.size,
            frozenset(self.features),
        )

    def _seen_from(self, link: str, frame: Array) -> tuple[Array, str]:
        """Return a frame in a link, exactly as its text says it."""
        return written(inverse(self.at[link]) @ frame)


def cut_elsewhere(
    chain: Chain, rng: np.random.Generator
) -> tuple[Chain, set[str], dict[str, Array]]:
    """Return a chain in which other joints close its rings; it has neither couplings nor floats.

    Joints that slide keep parent and child: their origin moves with the latter.

    Returns:
        The chain, the joints whose parent and child have changed places, and per link the
        `(4, 4)` placement of its frame in the new one.
    """
    at, edges = {"world": np.eye(4)}, list(chain.joints.values())
    for joint in edges:
        if not joint.closes:
            at[joint.child] = at[joint.parent] @ joint.parent_side
    # What is fixed stays in the tree, some loops stay loops, and what slides keeps its child.
    order = [edges[index] for index in rng.permutation(len(edges))]
    order.sort(key=lambda joint: joint.type != "fixed" or joint.closes)
    waiting = [
        joint for joint in order if not (joint.type in ("fixed", "universal") and joint.closes)
    ]
    slides = ("prismatic", "planar", "cylindrical")
    builder, reverse, tree = Builder(chain.size), set(), []
    while len(builder.at) < len(chain.links):
        joint = next(
            item
            for item in waiting
            if (item.parent in builder.at) != (item.child in builder.at)
            and (item.parent in builder.at or item.type not in slides)
        )
        tree.append(joint)
        frame, axis = at[joint.parent] @ joint.parent_side, joint.axis
        ends = joint.parent, joint.child
        if joint.child in builder.at:
            reverse.add(joint.name)
            ends, axis = ends[::-1], -axis
        builder.joint(joint.name, joint.type, *ends, frame, axis)
    for joint in edges:
        if joint not in tree:
            frame = at[joint.parent] @ joint.parent_side
            second = joint.axis_2 if joint.type == "universal" else None
            builder.loop(
                joint.name, joint.type, joint.parent, joint.child, frame, joint.axis, second
            )
    moved = {name: inverse(builder.at[name]) @ at[name] for name in chain.links}
    for name, link in chain.links.items():
        axes = moved[name][:3, :3]
        tensor = axes @ link.inertia @ axes.T
        centre = axes @ link.centre + moved[name][:3, 3]
        builder.link(name, link.mass, centre, inertia=0.5 * (tensor + tensor.T))
    return builder.chain(), reverse, moved


class RandomBuilder(Builder):
    """Draws links, frames and rings of joints."""

    MOST_BODIES = 6

    def __init__(self, rng: np.random.Generator) -> None:
        size = float(10.0 ** rng.uniform(-3.0, 3.0)) if rng.random() < 0.25 else 1.0
        super().__init__(size)
        self.rng = rng
        self.bodies = 0
        if size != 1.0:
            self.features.add("scaled")
        self.pole: dict[str, str] = {"world": "world"}
        self._fixed_count = 0

    def chance(self, probability: float) -> bool:
        return bool(self.rng.random() < probability)

    def pick(self, *options: str, weights: Sequence[float] | None = None) -> str:
        return str(self.rng.choice(options, p=weights))

    def direction(self) -> Array:
        """Return a unit vector, along a world axis now and then."""
        if self.chance(0.2):
            return np.eye(3)[self.rng.integers(3)] * self.rng.choice([-1.0, 1.0])
        return unit(self.rng.normal(size=3))

    def across(self, axis: Array) -> Array:
        return unit(np.cross(axis, self.rng.normal(size=3)))

    def point(self) -> Array:
        return self.size * self.rng.uniform(-1.0, 1.0, size=3)

    def frame(self, axis: Array, point: Array) -> tuple[Array, Array]:
        """Return a random frame at a point, and the axis in it, aligned now and then."""
        if self.chance(0.4):
            column = int(self.rng.integers(3))
            first = self.across(axis)
            columns = [axis, first, np.cross(axis, first)]
            axes = np.stack([columns[(k - column) % 3] for k in range(3)], axis=1)
            return placed(axes, point), np.eye(3)[column]
        axes = rotation(self.rng.uniform(-1.5, 1.5, size=3))
        return placed(axes, point), axes.T @ axis

    def add_link(self, name: str, massive: float = 0.75) -> None:
        """Add a link, with a body of any shape or without mass."""
        if not self.chance(massive):
            self.link(name)
            return
        mass = float(10.0 ** self.rng.uniform(-1.0, 1.0))
        sides = self.size * self.rng.uniform(0.1, 0.6, size=3) ** 2
        axes = rotation(self.rng.uniform(-1.5, 1.5, size=3))
        tensor = mass * self.size * axes @ np.diag(np.sum(sides) - sides) @ axes.T
        tensor = 0.5 * (tensor + tensor.T)
        self.link(
            name,
            mass,
            self.size * self.rng.uniform(-0.5, 0.5, size=3),
            self.rng.uniform(-1.5, 1.5, size=3),
            tensor,
        )

    def body(self, parent: str, kind: str, axis: Array, point: Array) -> str:
        """Add a moving body; return its name."""
        name = f"b{self.bodies}"
        frame, seen = self.frame(axis, point)
        self.add_link(name)
        self.joint(f"j{self.bodies}", kind, parent, name, frame, seen)
        self.pole[name] = name
        self.features.add(f"tree {kind}")
        self.bodies += 1
        return name

    def fixed(self, parent: str) -> str:
        """Fix another link to a link; return its name."""
        name = f"f{self._fixed_count}"
        self.add_link(name)
        self.joint(f"x{self._fixed_count}", "fixed", parent, name, self.frame(*self._any())[0])
        self.pole[name] = self.pole[parent]
        self._fixed_count += 1
        return name

    def _any(self) -> tuple[Array, Array]:
        return self.direction(), self.point()

    def maybe_fixed(self, link: str, probability: float = 0.15) -> str:
        """Return the link or one that is fixed to it."""
        return self.fixed(link) if self.chance(probability) else link

    def close(
        self,
        kind: str,
        one: str,
        other: str,
        axis: Array,
        point: Array,
        axis_2: Array | None = None,
    ) -> None:
        """Close a loop, either link being its predecessor."""
        ends = (one, other) if self.chance(0.5) else (other, one)
        if kind == "universal":
            axis_2 = self.across(axis) if axis_2 is None else axis_2
            frame = placed(rotation(self.rng.uniform(-1.5, 1.5, size=3)), point)
            if self.chance(0.3):
                frame[:3, :3] = np.stack([axis, axis_2, np.cross(axis, axis_2)], axis=1)
            seen, seen_2 = (frame[:3, :3].T @ vector for vector in (axis, axis_2))
        else:
            (frame, seen), seen_2 = self.frame(axis, point), None
        count = sum(joint.closes for joint in self.joints.values())
        shared = set(self.tree_path(one)) & set(self.tree_path(other))
        if any(self.joints[name].type != "fixed" for name in shared):
            self.features.add("moving base")
        self.loop(f"l{count}", kind, *ends, frame, seen, seen_2)
        self.features.add(f"loop {kind}")
        if self.pole[ends[1]] == "world":
            self.features.add("successor world")
            if kind == "fixed":
                self.features.add("fixed loop to world")

    def planar(self, base: str, end: str, normal: Array | None = None) -> None:
        """A ring whose links move in one plane."""
        normal = self.direction() if normal is None else normal
        centre = self.point()
        room = self.MOST_BODIES - self.bodies
        count = int(self.rng.integers(1, max(2, min(4, room + 1))))
        inside = {"planar": 3, "fixed": 0}
        freedom = 3 if self.chance(0.1) else 4 if self.chance(0.75) else 5
        for _ in range(200):
            kinds = [
                self.pick(*TURNS, "prismatic", "planar", weights=[0.4, 0.25, 0.22, 0.13])
                for _ in range(count)
            ]
            closing = self.pick(
                *(*TURNS, "prismatic", "planar", "cylindrical", "spherical", "universal", "fixed")
            )
            if sum(inside.get(kind, 1) for kind in (*kinds, closing)) == freedom:
                break
        else:
            raise Redraw("no planar ring of these bodies")

        def spot() -> Array:
            flat = self.point()
            flat -= normal * (normal @ flat)
            return centre + flat + 0.3 * self.size * self.rng.normal() * normal

        carrier = base
        for kind in kinds:
            axis = self.across(normal) if kind == "prismatic" else normal
            carrier = self.body(self.maybe_fixed(carrier), kind, axis, spot())
        axis = self.across(normal) if closing == "prismatic" else normal
        self.close(closing, self.maybe_fixed(carrier), self.maybe_fixed(end), axis, spot())

    def spherical(self, base: str, end: str) -> None:
        """A ring whose axes meet in a point."""
        centre = self.point()
        room = self.MOST_BODIES - self.bodies
        closing = self.pick(*TURNS, "universal", "spherical", "fixed", weights=[0.2] * 5)
        rows = {"universal": 2, "spherical": 3, "fixed": 0}.get(closing, 1)
        count = (3 if self.chance(0.1) else 4 if self.chance(0.75) else 5) - rows
        if not 1 <= count <= room:
            raise Redraw("no spherical ring of these bodies")
        carrier = base
        for _ in range(count):
            axis = self.direction()
            # Only turns may have their origin anywhere on their axis.
            spot = centre + self.size * self.rng.uniform(-0.5, 0.5) * axis
            carrier = self.body(self.maybe_fixed(carrier), self.pick(*TURNS), axis, spot)
        axis = self.direction()
        spot = centre + (0.4 * self.size * axis if closing in TURNS else 0.0)
        self.close(closing, self.maybe_fixed(carrier), self.maybe_fixed(end), axis, spot)

    def coaxial(self, base: str, end: str) -> None:
        """Supports along one line."""
        axis, centre = self.direction(), self.point()
        carrier = base
        for _ in range(int(self.rng.integers(1, 3))):
            kind = self.pick(*TURNS, "prismatic", "planar", weights=[0.4, 0.25, 0.25, 0.1])
            spot = centre + self.size * self.rng.uniform(-1.0, 1.0) * axis
            carrier = self.body(self.maybe_fixed(carrier), kind, axis, spot)
        closing = self.pick(*TURNS, "prismatic", "planar", "cylindrical", "spherical")
        spot = centre + self.size * self.rng.uniform(-1.0, 1.0) * axis
        self.close(closing, self.maybe_fixed(carrier), self.maybe_fixed(end), axis, spot)

    def support(self) -> None:
        """A second joint on the axis of a tree joint that turns."""
        turning = [j for j in self.joints.values() if j.type in TURNS and not j.closes]
        if not turning:
            raise Redraw("nothing turns")
        joint = turning[int(self.rng.integers(len(turning)))]
        frame = self.at[joint.child]
        axis = frame[:3, :3] @ joint.axis
        spot = frame[:3, 3] + self.size * self.rng.uniform(0.2, 1.0) * axis
        kind = self.pick(*TURNS, "cylindrical", "spherical", "planar")
        self.close(kind, joint.child, joint.parent, axis, spot)

    def spatial(self, base: str, end: str) -> None:
        """A ring without any common plane or point."""
        room = self.MOST_BODIES - self.bodies
        freedoms = {"planar": 3, "cylindrical": 2, "universal": 2, "spherical": 3, "fixed": 0}
        freedom = 6 if self.chance(0.12) else 7 if self.chance(0.7) else 8
        for _ in range(300):
            count = int(self.rng.integers(1, max(2, room + 1)))
            kinds = [
                self.pick(*TURNS, "prismatic", "planar", weights=[0.3, 0.2, 0.25, 0.25])
                for _ in range(count)
            ]
            closing = self.pick(
                *(*TURNS, "prismatic", "planar", "cylindrical", "spherical", "universal", "fixed")
            )
            if sum(freedoms.get(kind, 1) for kind in (*kinds, closing)) == freedom:
                break
        else:
            raise Redraw("no spatial ring of these bodies")
        carrier = base
        for kind in kinds:
            carrier = self.body(self.maybe_fixed(carrier), kind, self.direction(), self.point())
        self.close(
            closing,
            self.maybe_fixed(carrier),
            self.maybe_fixed(end),
            self.direction(),
            self.point(),
        )

    def shafts(self, base: str, end: str) -> None:
        """Two shafts whose forks a cross connects, the second one's bearing in a housing."""
        centre, first = self.point(), self.direction()
        angle = self.rng.uniform(0.2, 0.9)
        hinge = self.across(first)
        second = turn(hinge, angle) @ first
        entry = self.body(base, self.pick(*TURNS), first, centre)
        bearer = end
        if self.chance(0.4):
            bearer = self.body(end, self.pick(*TURNS), hinge, centre)
        out = self.body(self.maybe_fixed(bearer), self.pick(*TURNS), second, centre)
        pin = self.across(first)
        other = unit(np.cross(pin, second))
        if self.chance(0.6):
            self.close("universal", entry, out, pin, centre, other)
            # The pins belong to their shafts: the first axis turns with the predecessor.
            self._order_universal(entry, pin, other)
        else:
            cross = self.body(entry, self.pick(*TURNS), pin, centre)
            self.close(self.pick(*TURNS), cross, out, other, centre)

    def _order_universal(self, entry: str, pin: Array, other: Array) -> None:
        last = list(self.joints.values())[-1]
        if last.parent != entry:
            frame = self.at[last.parent] @ last.parent_side
            seen, seen_2 = (frame[:3, :3].T @ vector for vector in (other, pin))
            self.loop(last.name, "universal", last.parent, last.child, frame, seen, seen_2)

    def double_shaft(self, base: str, end: str) -> None:
        """Two shafts in space with a telescope between two crosses."""
        if self.MOST_BODIES - self.bodies < 5:
            raise Redraw("no room for a double shaft")
        near, far = self.point(), self.point()
        middle = unit(far - near)
        first, second = (unit(middle + 0.6 * self.rng.normal(size=3)) for _ in range(2))
        entry = self.body(base, self.pick(*TURNS), first, near)
        out = self.body(end, self.pick(*TURNS), second, far)
        pin = self.across(first)
        cross = self.body(entry, self.pick(*TURNS), pin, near)
        tube = self.body(cross, self.pick(*TURNS), unit(np.cross(pin, middle)), near)
        slip = self.body(tube, "prismatic", middle, 0.5 * (near + far))
        pin = self.across(middle)
        self.close("universal", slip, out, pin, far, unit(np.cross(pin, second)))

    def floating(self, base: str, end: str) -> None:
        """A free body that loops alone hold: welded, or the rod between crank and rocker."""
        if self.chance(0.5):
            free = self.body(base, "floating", *self._any())
            self.close("fixed", free, self.maybe_fixed(end), *self._any())
            return
        crank = self.body(base, self.pick(*TURNS), *self._any())
        rocker = self.body(end, self.pick(*TURNS), *self._any())
        rod = self.body(self.pick(base, crank), "floating", *self._any())
        self.close("spherical", crank, rod, *self._any())
        self.close("universal", rod, rocker, *self._any())

    def couple(self) -> None:
        """Couple two links, one of them sometimes a wheel that is added for it."""
        if self.chance(0.6):
            self.body(self.pick(*self.links), self.pick(*TURNS, "prismatic"), *self._any())
        names = [name for name in self.links if self.pole[name] != "world"]
        for _ in range(30):
            one, other = self.rng.choice(["world", *names], size=2, replace=False)
            apart = set(self.tree_path(str(one))) ^ set(self.tree_path(str(other)))
            counted = [
                self.joints[name] for name in sorted(apart) if self.joints[name].type != "fixed"
            ]
            single = (*TURNS, "prismatic")
            if not counted or any(joint.type not in single for joint in counted):
                continue
            sides = [
                {
                    joint.type == "prismatic"
                    for joint in counted
                    if joint.name in self.tree_path(str(link))
                }
                for link in (one, other)
            ]
            if any(len(side) > 1 for side in sides):
                continue
            # Coupled to nothing, a joint is locked: legal, but all such cases are alike.
            if not all(sides) and self.chance(0.95):
                continue
            ratio = float(self.rng.choice([-1.0, 1.0]) * self.rng.uniform(0.4, 2.5))
            # Between a turn and a slide it has a unit, and goes with the size.
            ratio *= self.size ** float(sides[1] == {True}) / self.size ** float(sides[0] == {True})
            self.coupling(f"c{len(self.couplings)}", str(one), str(other), ratio)
            if not all(sides):
                self.features.add("coupling to nothing")
            return

    def tree_path(self, link: str) -> list[str]:
        """Return the tree joints between the world and a link."""
        above = {joint.child: joint for joint in self.joints.values() if not joint.closes}
        names = []
        while link in above:
            names.append(above[link].name)
            link = above[link].parent
        return names


class Redraw(Exception):  # noqa: N818, no error but a wish
    """What was drawn is not a case to test."""


def random_chain(rng: np.random.Generator) -> Chain:
    """Draw a chain.

    Raises:
        Redraw: it came out too large.
    """
    draw = RandomBuilder(rng)
    base = draw.fixed("world") if draw.chance(0.3) else "world"
    if draw.chance(0.55):
        kind = draw.pick(*TURNS, "prismatic", weights=[0.4, 0.3, 0.3])
        base = draw.body(base, kind, draw.direction(), draw.point())
        base = draw.maybe_fixed(base, 0.3)
    rings = {
        "planar": 0.3,
        "spherical": 0.17,
        "spatial": 0.2,
        "shafts": 0.12,
        "coaxial": 0.09,
        "floating": 0.08,
        "double_shaft": 0.04,
    }
    total = sum(rings.values())
    weights = [value / total for value in rings.values()]

    def ring(base: str) -> None:
        kind = draw.pick(*rings, weights=weights)
        free = kind in ("spatial", "floating", "double_shaft")
        end = base
        if free and draw.chance(0.35):
            end = draw.pick(*draw.links)
        elif draw.chance(0.15):
            end = draw.fixed(base)
        getattr(draw, kind)(base, end)
        draw.features.add(f"ring {kind}")

    ring(base)
    if draw.chance(0.45) and draw.bodies < draw.MOST_BODIES:
        if draw.chance(0.25):
            draw.support()
            draw.features.add("ring support")
        else:
            ring(draw.pick(*draw.links) if draw.chance(0.6) else base)
    if draw.chance(0.3):
        draw.couple()
    if draw.chance(0.15) and draw.bodies <= draw.MOST_BODIES:
        draw.body(draw.pick(*draw.links), draw.pick(*TURNS, "prismatic"), *draw._any())
    if not 2 <= draw.bodies <= draw.MOST_BODIES + 1:
        raise Redraw(f"{draw.bodies} bodies")
    if sum(joint.closes for joint in draw.joints.values()) > 3:
        raise Redraw("too many loops")
    return draw.chain()
