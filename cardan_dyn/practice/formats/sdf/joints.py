"""Joints of SDF: edges between links, of which some span a tree and others close loops."""

from __future__ import annotations

import heapq
from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import NamedTuple
from xml.etree.ElementTree import Element

import numpy as np

from ....core.description.description import (
    X_AXIS,
    Dynamics,
    JointDescription,
    Limits,
    LoopDescription,
)
from ....core.description.elements import (
    DIRECTION_TOLERANCE,
    DYNAMICS_WORDS,
    numbers,
    one_of,
    only,
    unit,
)
from ....kit.arrays import Array, inverse
from ....kit.errors import ModelError
from .elements import acting, flag, inside, limit, number, text
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
_AXES = ("axis", "axis2")
GEARBOX = "gearbox"
"""A joint that couples two angles and connects nothing."""
_REFUSED = {
    "piston": 'write a prismatic and a revolute joint in a row, or <loop type="cylindrical"> in '
    "a URDF",
}
"""Types that are not read, and what to do."""


@dataclass(frozen=True, eq=False, repr=False)
class Edge(JointDescription):
    """A joint between two links, before it is known whether it closes a loop.

    Its origin is that in the world, where the model stands initially; its parent may be `WORLD`.

    Attributes:
        is_cut: whether the author wants a loop to be cut here.
        forces: what its axes and a motor of the physics engine ODE exert besides its dynamics.
        warnings: what else it says and is left out.
    """

    is_cut: bool = False
    forces: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    def joint(self, links: dict[str, Array], is_reversed: bool) -> JointDescription:
        """Return the edge as a joint of the tree.

        Args:
            links: `(4, 4)` initial placements of the links in the world.
            is_reversed: whether a `fixed` joint carries its parent.
        """
        parent, child = (self.child, self.parent) if is_reversed else (self.parent, self.child)
        origin, placement = (
            inverse(links[parent]) @ self.origin,
            inverse(self.origin) @ links[child],
        )
        placed = (parent, child, origin, self.axis, self.axis_2, placement)
        return JointDescription(
            self.name, self.type, *placed, limits=self.limits, dynamics=self.dynamics
        )

    def loop(self, links: dict[str, Array]) -> LoopDescription:
        """Return the edge as a loop, which the initial placements close."""
        first, second = (inverse(links[name]) @ self.origin for name in (self.parent, self.child))
        named = (self.name, self.type, self.parent, self.child)
        return LoopDescription(*named, first, second, self.axis, self.axis_2, self.dynamics)


def edge(element: Element, frames: NamedFrames, where: str) -> Edge:
    """Return a joint.

    What rubs and springs along it is an element's where all its coordinates have the same, and
    nothing is negative; else those are forces of which none is made.

    Raises:
        ModelError: it is malformed or of a type that is not supported.
    """
    name = element.get("name", "")
    at = f"{where}: joint {name!r}"
    kind = TYPES[kind_of(element, at)]
    parent, child = ends(element, frames, at)
    origin = frames.joint_placement(name, at)
    count = {"fixed": 0, "spherical": 0, "universal": 2}.get(kind, 1)
    axes = [axis_of(element, tag, origin, frames, at) for tag in _AXES[:count]] or [X_AXIS]
    cosine, limits = float(axes[0] @ axes[-1]), Limits()
    if count == 2 and abs(cosine) > DIRECTION_TOLERANCE:
        raise ModelError(
            f"{at}: its axes are at an angle whose cosine is {cosine:g}, not at right angles; "
            "write two revolute joints with a link of mass 0 between them"
        )
    if count == 1:
        # A universal joint has limits per axis, which a description has no place for.
        bounds = inside(inside(element, "axis", at), "limit", at)
        limits = Limits(
            limit(bounds, "lower", -1.0, at),
            *(limit(bounds, tag, 1.0, at) for tag in ("upper", "velocity", "effort")),
        )
    if kind == "continuous":
        limits = replace(limits, lower=-np.inf, upper=np.inf)
    if kind == "revolute" and np.isinf([limits.lower, limits.upper]).all():
        kind = "continuous"
    warnings, forces, along = list[str](), list[str](), list[Dynamics]()
    for tag in _AXES:
        part, own = inside(element, tag, at), f"{at}: {tag}"
        initial = number(part, "initial_position", "0", own)
        if initial and count:
            warnings.append(
                f"{own}: initial_position {initial:g} left out: the coordinate is zero in the "
                "poses of the links"
            )
        rubbing = inside(part, "dynamics", own)
        forces += acting(rubbing, DYNAMICS_WORDS[:3], f"joint {name!r}: {tag}", where)
        stated = Dynamics(*(number(rubbing, word, "0", own) for word in DYNAMICS_WORDS))
        # Where nothing springs, its rest means nothing.
        along.append(stated if stated.stiffness else stated._replace(rest=0.0))
    dynamics = along[0]
    if not count or min(dynamics[:3]) < 0.0 or along[0] != along[count - 1]:
        dynamics = Dynamics()
    if dynamics.acts:
        forces = []
    for ode in element.iterfind("physics/ode"):
        forces += acting(ode, ("max_force",), f"joint {name!r}: physics", where)
    return Edge(
        *(name, kind, parent, child, origin, axes[0], axes[-1]),
        limits=limits,
        dynamics=dynamics,
        is_cut=flag(
            element.findtext("physics/simbody/must_be_loop_joint") or "false",
            f"{at}: must_be_loop_joint",
        ),
        forces=tuple(forces),
        warnings=tuple(warnings),
    )


def kind_of(element: Element, at: str) -> str:
    """Return SDF's word for the type of a joint.

    Raises:
        ModelError: it is unknown, or not supported.
    """
    kind = (element.get("type") or "").lower()
    if kind in _REFUSED:
        raise ModelError(f"{at}: type {kind!r} is not supported: {_REFUSED[kind]}")
    return one_of(kind, [*TYPES, GEARBOX], "type", at, "is not supported")


def ends(element: Element, frames: NamedFrames, at: str) -> tuple[str, str]:
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
    return parent, child


def axis_of(element: Element, tag: str, placement: Array, frames: NamedFrames, at: str) -> Array:
    """Return the `(3,)` unit axis of a joint in its frame, whose `(4, 4)` placement is given."""
    axis = only(element, tag, at)
    at = f"{at}: {tag}"
    if axis is None:
        raise ModelError(f"{at} is missing: <axis><xyz>0 0 1</xyz></axis>")
    stated = numbers(text(axis, "xyz", "0 0 1", at), 3, "", f"{at}: xyz")
    direction = unit(stated, f"{at}: xyz")
    frame = inside(axis, "xyz", at).get("expressed_in")
    if not frame:
        return direction
    turn = frames.placement(frame, f"{at}: expressed_in")[:3, :3]
    found = np.asarray(placement[:3, :3].T @ turn @ direction)
    if not flag(text(axis, "use_parent_model_frame", "false", at), at):
        return found
    # Newer versions do not know it: it is to be the same in both frames.
    if np.linalg.norm(found - direction) > DIRECTION_TOLERANCE:
        raise ModelError(f'{at}: write expressed_in="{MODEL}", not <use_parent_model_frame>')
    return direction


class SpanningTree(NamedTuple):
    """A tree over all links, whose root is the world.

    Attributes:
        joints: its joints in the order in which they were reached, and whether each is a `fixed`
            one that carries its parent.
        floating: links that no joint carries from the world.
        loops: the other joints in file order.
    """

    joints: list[tuple[Edge, bool]]
    floating: list[str]
    loops: list[Edge]


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
    tree = SpanningTree([], [], [])
    around: dict[str, list[int]] = {name: [] for name in (WORLD, *links)}
    for index, item in enumerate(edges):
        if not item.is_cut:
            around[item.parent].append(index)
            if item.type == "fixed":
                around[item.child].append(index)
    reached: set[str] = set()
    used: set[int] = set()
    for root in (WORLD, *_roots(links, canonical, edges)):
        if root in reached:
            continue
        tree.floating.extend([root] * (root != WORLD))
        reached.add(root)
        waiting = list(around[root])
        while waiting:
            index = heapq.heappop(waiting)
            item = edges[index]
            is_reversed = item.parent not in reached
            child = item.parent if is_reversed else item.child
            if child not in reached:
                reached.add(child)
                used.add(index)
                tree.joints.append((item, is_reversed))
                for other in around[child]:
                    heapq.heappush(waiting, other)
    tree.loops.extend(item for index, item in enumerate(edges) if index not in used)
    return tree


def _roots(links: Collection[str], canonical: str, edges: list[Edge]) -> list[str]:
    """Return the links in the order in which they are to float, if they do.

    Those that no other body carries come first, of these the canonical one.
    """
    first = {name: name for name in (WORLD, *links)}
    for item in edges:
        if item.type == "fixed" and not item.is_cut:
            kept, merged = first[item.parent], first[item.child]
            first.update((name, kept) for name, body in first.items() if body == merged)
    carried = {
        first[item.child]
        for item in edges
        if not item.is_cut and first[item.parent] != first[item.child]
    }
    return sorted((canonical, *links), key=lambda name: first[name] in carried)
