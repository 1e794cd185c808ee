"""Joints of SDF: edges between links, of which some span a tree and others close loops."""

from __future__ import annotations

import heapq
from collections.abc import Collection
from dataclasses import dataclass, field
from xml.etree import ElementTree

import numpy as np

from ....kit.arrays import Array, inverse
from ....kit.errors import ModelError, choices
from ..description import Dynamics, JointDescription, Limits, LoopDescription
from ..elements import DIRECTION_TOLERANCE, DYNAMICS_WORDS, numbers, only, unit
from .elements import acting, flag, limit, number, text
from .frames import MODEL, WORLD, NamedFrames

TYPES = {
    "revolute": "revolute",
    "continuous": "continuous",
    "prismatic": "prismatic",
    "ball": "spherical",
    "universal": "universal",
    "revolute2": "universal",
    "fixed": "fixed",
}
"""SDF's word for a joint to its type. Of the axes of `universal` and `revolute2`, the first moves
with the parent and the second with the child, as in Gazebo."""
GEARBOX = "gearbox"
"""A joint that couples two angles and connects nothing."""
_REFUSED = {
    "piston": 'write a prismatic and a revolute joint in a row, or <loop type="cylindrical"> in '
    "a URDF",
}
"""Types that are not read, and what to do."""
_AXES_IN_MODEL_UNTIL = (1, 4)
"""Last version whose axes were written in the model's frame."""


@dataclass(frozen=True, eq=False)
class Edge:
    """A joint between two links, before it is known whether it closes a loop.

    Attributes:
        name, type: of the joint.
        parent, child: names of the links, of the first `WORLD` as well.
        placement: `(4, 4)` initial placement of the joint's frame in the world [m].
        axis, axis_2: `(3,)` in that frame.
        limits: of its coordinate.
        is_cut: whether the author wants a loop to be cut here.
        dynamics: what rubs and springs along its coordinates.
        forces: what its axes and a motor of the physics engine ODE exert besides.
        warnings: what else it says and is left out.
    """

    name: str
    type: str
    parent: str
    child: str
    placement: Array
    axis: Array
    axis_2: Array
    limits: Limits
    is_cut: bool
    dynamics: Dynamics = field(default_factory=Dynamics)
    forces: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    def joint(self, links: dict[str, Array], is_reversed: bool) -> JointDescription:
        """Return the edge as a joint of the tree.

        Args:
            links: `(4, 4)` initial placements of the links in the world.
            is_reversed: whether a `fixed` joint carries its parent.
        """
        parent, child = (self.child, self.parent) if is_reversed else (self.parent, self.child)
        return JointDescription(
            name=self.name,
            type=self.type,
            parent=parent,
            child=child,
            origin=inverse(links[parent]) @ self.placement,
            axis=self.axis,
            axis_2=self.axis_2,
            child_placement=inverse(self.placement) @ links[child],
            limits=self.limits,
            dynamics=self.dynamics,
        )

    def loop(self, links: dict[str, Array]) -> LoopDescription:
        """Return the edge as a loop, which the initial placements close."""
        return LoopDescription(
            name=self.name,
            type=self.type,
            predecessor=self.parent,
            successor=self.child,
            predecessor_origin=inverse(links[self.parent]) @ self.placement,
            successor_origin=inverse(links[self.child]) @ self.placement,
            axis=self.axis,
            axis_2=self.axis_2,
            dynamics=self.dynamics,
        )


def edge(
    element: ElementTree.Element, frames: NamedFrames, version: tuple[int, int], where: str
) -> Edge:
    """Return a joint.

    Raises:
        ModelError: it is malformed or of a type that is not supported.
    """
    at = f"{where}: joint {element.get('name')!r}"
    kind = TYPES[kind_of(element, at)]
    parent, child = ends(element, frames, at)
    placement = frames.joint_placement(element.get("name", ""), at)
    axis = axis_2 = np.array([1.0, 0.0, 0.0])
    limits, warnings = Limits(), list[str]()
    if kind not in ("fixed", "spherical"):
        axis = axis_2 = axis_of(element, "axis", placement, frames, version, at)
        limits, warnings = _limits(element, kind, at)
    if kind == "universal":
        axis_2 = axis_of(element, "axis2", placement, frames, version, at)
        _check_right_angle(axis, axis_2, at)
    if kind == "revolute" and not np.isfinite([limits.lower, limits.upper]).any():
        kind = "continuous"
    dynamics = dynamics_of(element, kind, at)
    cut = element.find("physics/simbody/must_be_loop_joint")
    is_cut = cut is not None and flag(cut.text or "", f"{at}: must_be_loop_joint")
    name = element.get("name", "")
    return Edge(
        *(name, kind, parent, child, placement, axis, axis_2, limits, is_cut, dynamics),
        forces=tuple(_forces(element, dynamics.acts, where)),
        warnings=tuple(warnings),
    )


def _forces(joint: ElementTree.Element, is_taken: bool, where: str) -> list[str]:
    """Return the forces of a joint of which no element can be made."""
    name, forces = f"joint {joint.get('name')!r}", list[str]()
    for tag in () if is_taken else ("axis", "axis2"):
        axis = only(joint, tag, f"{where}: {name}")
        dynamics = None if axis is None else only(axis, "dynamics", f"{where}: {name}")
        if dynamics is not None:
            words = ("damping", "friction", "spring_stiffness")
            forces += acting(dynamics, words, f"{name}: {tag}", where)
    for ode in joint.iterfind("physics/ode"):
        forces += acting(ode, ("max_force",), f"{name}: physics", where)
    return forces


def dynamics_of(element: ElementTree.Element, kind: str, at: str) -> Dynamics:
    """Return what rubs and springs along the coordinates of a joint.

    What cannot be taken in is none: along a joint that has no single coordinate, negative values,
    and what both axes of a universal joint do not have alike.

    Args:
        element: the `<joint>`.
        kind: its type here.
        at: how messages name it.

    Raises:
        ModelError: a value is no number.
    """
    if kind in ("fixed", "spherical"):
        return Dynamics()
    first, second = (_dynamics_of_axis(element, tag, at) for tag in ("axis", "axis2"))
    if (kind == "universal" and first != second) or min(first[:3]) < 0.0:
        return Dynamics()
    return first


def _dynamics_of_axis(element: ElementTree.Element, tag: str, at: str) -> Dynamics:
    """Return what an axis states, nothing where there is none."""
    axis = only(element, tag, at)
    dynamics = None if axis is None else only(axis, "dynamics", at)
    if dynamics is None:
        return Dynamics()
    stated = Dynamics(*(number(dynamics, word, "0", f"{at}: {tag}") for word in DYNAMICS_WORDS))
    # Where nothing springs, its rest means nothing.
    return stated if stated.stiffness else stated._replace(rest=0.0)


def kind_of(element: ElementTree.Element, at: str) -> str:
    """Return SDF's word for the type of a joint.

    Raises:
        ModelError: it is unknown, or not supported.
    """
    kind = (element.get("type") or "").lower()
    if kind in _REFUSED:
        raise ModelError(f"{at}: type {kind!r} is not supported: {_REFUSED[kind]}")
    if kind != GEARBOX and kind not in TYPES:
        raise ModelError(
            f"{at}: type {element.get('type')!r} is not supported; types: "
            f"{choices([*TYPES, GEARBOX], kind)}"
        )
    return kind


def ends(element: ElementTree.Element, frames: NamedFrames, at: str) -> tuple[str, str]:
    """Return the links that a joint connects, of its parent `WORLD` as well."""
    links = []
    for tag in ("parent", "child"):
        name = text(element, tag, "", at)
        if not name:
            raise ModelError(f"{at}: <{tag}> is missing or empty")
        links.append(frames.link(name, f"{at}: {tag}"))
    parent, child = links
    if child == WORLD:
        raise ModelError(f"{at}: the world cannot be the child; swap parent and child")
    if parent == child:
        raise ModelError(f"{at}: parent and child are the same link {child!r}")
    return parent, child


def axis_of(
    element: ElementTree.Element,
    tag: str,
    placement: Array,
    frames: NamedFrames,
    version: tuple[int, int],
    at: str,
) -> Array:
    """Return the `(3,)` unit axis of a joint in its frame, whose `(4, 4)` placement is given."""
    axis = only(element, tag, at)
    at = f"{at}: {tag}"
    if axis is None:
        if tag == "axis":
            raise ModelError(f"{at} is missing: <axis><xyz>0 0 1</xyz></axis>")
        axis = ElementTree.Element(tag)  # SDF gives it its default.
    stated = numbers(text(axis, "xyz", "0 0 1", at), 3, "", f"{at}: xyz")
    direction = unit(stated, f"{at}: xyz")
    frame, is_open = _frame_of_axis(axis, frames, version, at)
    if not frame:
        return direction
    turn = frames.placement(frame, f"{at}: expressed_in")[:3, :3]
    found = np.asarray(placement[:3, :3].T @ turn @ direction)
    if is_open and np.linalg.norm(found - direction) > DIRECTION_TOLERANCE:
        raise ModelError(f'{at}: write expressed_in="{MODEL}", not <use_parent_model_frame>')
    return direction if is_open else found


def _frame_of_axis(
    axis: ElementTree.Element, frames: NamedFrames, version: tuple[int, int], at: str
) -> tuple[str, bool]:
    """Return the frame in which an axis is written, and whether it may be the joint's own as well.

    The frame is empty where it is the joint's own.
    """
    xyz = only(axis, "xyz", at)
    named = "" if xyz is None else xyz.get("expressed_in", "")
    in_model = flag(text(axis, "use_parent_model_frame", "false", at), at)
    if frames.has_names:
        return (MODEL, True) if in_model and not named else (named, False)
    if named:
        raise ModelError(f"{at}: expressed_in is known from SDF 1.7 on; this is an older version")
    return MODEL if in_model or version <= _AXES_IN_MODEL_UNTIL else "", False


def _check_right_angle(axis: Array, axis_2: Array, at: str) -> None:
    cosine = float(axis @ axis_2)
    if abs(cosine) > DIRECTION_TOLERANCE:
        raise ModelError(
            f"{at}: its axes are at an angle whose cosine is {cosine:g}, not at right angles; "
            "write two revolute joints with a link of mass 0 between them"
        )


def _limits(element: ElementTree.Element, kind: str, at: str) -> tuple[Limits, list[str]]:
    """Return the limits of a joint, and warnings about what else its axes say.

    A universal joint has limits per axis, which a description has no place for; as all limits they
    play no part in wrenches.
    """
    warnings, limits = [], Limits()
    for tag in ("axis", "axis2"):
        axis = only(element, tag, at)
        if axis is None:
            continue
        initial = number(axis, "initial_position", "0", f"{at}: {tag}")
        if initial:
            warnings.append(
                f"{at}: {tag}: initial_position {initial:g} left out: the coordinate is zero in "
                "the poses of the links"
            )
        stated = only(axis, "limit", at)
        if stated is None or kind == "universal" or tag == "axis2":
            continue
        limits = Limits(
            lower=limit(stated, "lower", -1.0, at),
            upper=limit(stated, "upper", 1.0, at),
            velocity=limit(stated, "velocity", 1.0, at),
            effort=limit(stated, "effort", 1.0, at),
        )
    if kind == "continuous":
        limits = Limits(velocity=limits.velocity, effort=limits.effort)
    return limits, warnings


@dataclass
class SpanningTree:
    """A tree over all links, whose root is the world.

    Attributes:
        joints: its joints in the order in which they were reached, and whether each is a `fixed`
            one that carries its parent.
        floating: links that no joint carries from the world.
        loops: the other joints in file order.
    """

    joints: list[tuple[Edge, bool]] = field(default_factory=list)
    floating: list[str] = field(default_factory=list)
    loops: list[Edge] = field(default_factory=list)


def spanning_tree(links: Collection[str], canonical: str, edges: list[Edge]) -> SpanningTree:
    """Return the tree that a model's joints span.

    It grows from the world: of all joints whose parent is in the tree and whose child is not, the
    one that stands first in the file is taken. So of several joints with the same child, one
    carries it, and the others are loops; parents, children and signs stay those of the file. A
    `fixed` joint, which has no coordinate, may carry its parent as well.

    A link that no chain of joints carries from the world floats. If it is the parent of a joint
    whose child is in the tree, that joint is a loop.

    Args:
        links: names of all links in file order.
        canonical: name of the one that carries the model's frame.
        edges: all joints in file order.
    """
    tree = SpanningTree()
    around: dict[str, list[int]] = {name: [] for name in (WORLD, *links)}
    for index, item in enumerate(edges):
        if not item.is_cut:
            around[item.parent].append(index)
            if item.type == "fixed":
                around[item.child].append(index)
    reached = {WORLD}
    used: set[int] = set()
    _grow(tree, WORLD, edges, around, reached, used)
    while len(reached) <= len(links):
        root = _next_root([name for name in links if name not in reached], canonical, edges)
        tree.floating.append(root)
        reached.add(root)
        _grow(tree, root, edges, around, reached, used)
    tree.loops = [item for index, item in enumerate(edges) if index not in used]
    return tree


def _grow(
    tree: SpanningTree,
    start: str,
    edges: list[Edge],
    around: dict[str, list[int]],
    reached: set[str],
    used: set[int],
) -> None:
    """Add all links that joints carry from one that was just reached."""
    waiting = list(around[start])
    heapq.heapify(waiting)
    while waiting:
        index = heapq.heappop(waiting)
        item = edges[index]
        is_reversed = item.parent not in reached
        child = item.parent if is_reversed else item.child
        if child in reached:
            continue
        reached.add(child)
        used.add(index)
        tree.joints.append((item, is_reversed))
        for other in around[child]:
            heapq.heappush(waiting, other)


def _next_root(left: list[str], canonical: str, edges: list[Edge]) -> str:
    """Return the link that is to float: one that no other link carries, if there is one.

    Of several such links, the canonical one or else the first in the file is taken.
    """
    bodies = _bodies(left, edges)
    carried = {
        bodies[item.child]
        for item in edges
        if not item.is_cut
        and item.type != "fixed"
        and item.parent in bodies
        and item.child in bodies
        and bodies[item.parent] != bodies[item.child]
    }
    free = [name for name in left if bodies[name] not in carried] or left
    return canonical if canonical in free else free[0]


def _bodies(left: list[str], edges: list[Edge]) -> dict[str, str]:
    """Return link to the first of the links that fixed joints make one body with it."""
    around: dict[str, list[str]] = {name: [] for name in left}
    for item in edges:
        if item.type == "fixed" and not item.is_cut and item.parent in around:
            around[item.parent].append(item.child)
            around[item.child].append(item.parent)
    bodies: dict[str, str] = {}
    for first in left:
        waiting = [first]
        while waiting:
            name = waiting.pop()
            if name not in bodies:
                bodies[name] = first
                waiting += around[name]
    return bodies
