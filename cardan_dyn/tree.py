"""Tree: Pinocchio's model of a description, with a joint for every loop.

Every joint is a chain of elementary parts (turn about an axis, slide along an axis, ball) through
massless bodies. So all joint types, and loops as well as tree joints, go through the same few
lines everywhere else.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio

from .errors import ModelError

if TYPE_CHECKING:
    from .description import Description, LoopDescription

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Part:
    """An elementary part of a joint.

    Attributes:
        kind: `revolute`, `prismatic` or `spherical`.
        axis: `(3,)` unit axis in the joint frame.
        index: index in the model.
    """

    kind: str
    axis: Array
    index: int

    @property
    def size(self) -> int:
        """Number of velocity coordinates."""
        return 3 if self.kind == "spherical" else 1


def elementary(kind: str, axis: Array, axis_2: Array) -> list[tuple[str, Array]]:
    """Return kinds and axes of a joint type's parts, from the parent outwards.

    Args:
        kind: a joint type of URDF, or `spherical`, `universal`, `cylindrical`.
        axis: unit axis; the normal of a `planar` joint, the first axis of a `universal` one.
        axis_2: second axis of a `universal` joint.
    """
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    across /= np.linalg.norm(across)
    x, y, z = np.eye(3)
    return {
        "fixed": [],
        "revolute": [("revolute", axis)],
        "continuous": [("revolute", axis)],
        "prismatic": [("prismatic", axis)],
        "cylindrical": [("prismatic", axis), ("revolute", axis)],
        "planar": [
            ("prismatic", across),
            ("prismatic", np.cross(axis, across)),
            ("revolute", axis),
        ],
        "universal": [("revolute", axis), ("revolute", axis_2)],
        "spherical": [("spherical", axis)],
        "floating": [
            ("prismatic", x),
            ("prismatic", y),
            ("prismatic", z),
            ("spherical", x),
        ],
    }[kind]


class TreeBuilder:
    """Builds the model of a description.

    Attributes:
        model: the tree with the joints of its loops.
        parts: joint name to its parts in the model; none for `fixed` loops.
        links: link name to `(body in the model, pin.SE3 placement there)`.
    """

    def __init__(self, description: Description) -> None:
        self._description = description
        source = description.tree()
        self._source = source
        self._frames = {
            name: source.frames[source.getFrameId(name, pinocchio.FrameType.BODY)]
            for name in description.links
        }
        self._shares = self._count_shares()
        self.model = pinocchio.Model()
        self.model.name = source.name
        self.model.inertias[0] = source.inertias[0]
        self.parts: dict[str, list[Part]] = {
            loop.name: [] for loop in description.loops if loop.type == "fixed"
        }
        self._new = {0: 0}
        self._visit(0)
        self.links = {
            name: (self._new[frame.parentJoint], frame.placement)
            for name, frame in self._frames.items()
        }
        for frame in list(source.frames)[1:]:
            body = self._new[frame.parentJoint]
            self.model.addFrame(
                pinocchio.Frame(frame.name, body, frame.placement, frame.type), False
            )

    def _visit(self, joint: int) -> None:
        """Add the joints on a body of the source, depth first.

        Loops cannot be appended at the end: Pinocchio's inertia matrix and constrained dynamics
        take it for granted that the joints of a subtree follow each other, and are silently wrong
        otherwise.
        """
        source, description = self._source, self._description
        for child in range(1, source.njoints):
            if source.parents[child] != joint:
                continue
            name = source.names[child]
            chain = elementary(
                description.joints[name], description.axes[name], description.axes[name]
            )
            # Pinocchio's own joint knows whether it turns without end.
            ready = source.joints[child] if _same(source.joints[child], chain) else None
            body = self._add(name, chain, self._new[joint], source.jointPlacements[child], ready)
            self._new[child] = body
            self.model.inertias[body] = _share(source.inertias[child], self._shares.get(child, 1))
            if ready is not None:
                self._copy_limits(child, body)
            self._visit(child)
        for loop in description.loops:
            predecessor = self._frames[loop.predecessor]
            if predecessor.parentJoint != joint or loop.type == "fixed":
                continue
            body = self._add(
                loop.name,
                elementary(loop.type, loop.axis, loop.axis_2),
                self._new[joint],
                predecessor.placement * se3(loop.predecessor_origin),
                None,
            )
            self.model.inertias[body] = self._loop_inertia(loop)

    def _add(
        self,
        name: str,
        chain: list[tuple[str, Array]],
        parent: int,
        placement: pinocchio.SE3,
        ready: pinocchio.JointModel | None,
    ) -> int:
        """Add the parts of a joint; the last one has the joint's name. Return the child body."""
        parts = []
        for number, (kind, axis) in enumerate(chain, start=1):
            last = number == len(chain)
            parent = self.model.addJoint(
                parent,
                ready or _joint_model(kind, axis),
                placement,
                name if last else f"{name}:{number}",
            )
            parts.append(Part(kind, axis, parent))
            placement = pinocchio.SE3.Identity()
        self.parts[name] = parts
        return parent

    def _count_shares(self) -> dict[int, int]:
        """Return for each successor body of the source among how many bodies it is split."""
        shares: dict[int, int] = {}
        for loop in self._description.loops:
            successor = self._frames[loop.successor].parentJoint
            if self._frames[loop.predecessor].parentJoint == successor:
                raise ModelError(
                    f"{self._description.name}: loop {loop.name!r} connects {loop.predecessor!r} "
                    f"and {loop.successor!r}, which fixed joints already make one body"
                )
            if loop.type != "fixed":
                shares[successor] = shares.get(successor, 1) + 1
        return shares

    def _loop_inertia(self, loop: LoopDescription) -> pinocchio.Inertia:
        """Return the inertia of the body that carries a loop's joint."""
        successor = self._frames[loop.successor]
        body = successor.parentJoint
        if body == 0:
            masses = [inertia.mass for inertia in self._source.inertias if inertia.mass > 0.0]
            mass = float(np.mean(masses)) if masses else 1.0
            return pinocchio.Inertia(mass, np.zeros(3), mass * np.eye(3))
        placement = successor.placement * se3(loop.successor_origin)
        return placement.actInv(_share(self._source.inertias[body], self._shares[body]))

    def _copy_limits(self, old: int, new: int) -> None:
        here, there = self._source.joints[old], self.model.joints[new]
        for names, start, size in (
            (("lowerPositionLimit", "upperPositionLimit"), "idx_q", "nq"),
            (("upperEffortLimit", "lowerEffortLimit"), "idx_v", "nv"),
            (("upperVelocityLimit", "lowerVelocityLimit"), "idx_v", "nv"),
        ):
            first, count = getattr(here, start), getattr(here, size)
            to = getattr(there, start)
            for name in names:
                values = getattr(self._source, name)[first : first + count]
                getattr(self.model, name)[to : to + count] = values


def se3(matrix: Array) -> pinocchio.SE3:
    """Return a `(4, 4)` placement as Pinocchio's type."""
    return pinocchio.SE3(matrix[:3, :3], matrix[:3, 3])


def _joint_model(kind: str, axis: Array) -> pinocchio.JointModel:
    if kind == "spherical":
        return pinocchio.JointModelSpherical()
    if kind == "prismatic":
        return pinocchio.JointModelPrismaticUnaligned(axis)
    # The bindings build unbounded joints about the positive frame axes only. Any other axis gets
    # a bounded joint, whose limits inverse dynamics never uses.
    unbounded = {
        (1.0, 0.0, 0.0): pinocchio.JointModelRUBX,
        (0.0, 1.0, 0.0): pinocchio.JointModelRUBY,
        (0.0, 0.0, 1.0): pinocchio.JointModelRUBZ,
    }.get(tuple(axis.tolist()))
    return unbounded() if unbounded else pinocchio.JointModelRevoluteUnaligned(axis)


def _same(joint: pinocchio.JointModel, chain: list[tuple[str, Array]]) -> bool:
    sizes = [3 if kind == "spherical" else 1 for kind, _ in chain]
    return len(chain) == 1 and joint.nv == sizes[0]


def _share(whole: pinocchio.Inertia, parts: int) -> pinocchio.Inertia:
    if parts == 1:
        return whole.copy()  # Made anew, an inertia that no body can have would be refused.
    try:
        return pinocchio.Inertia(whole.mass / parts, whole.lever, whole.inertia / parts)
    except (RuntimeError, ValueError) as error:
        raise ModelError(
            f"the inertia of a loop's successor is one that no body can have ({error}); mend it, "
            "or swap predecessor and successor"
        ) from error


def ancestors(model: pinocchio.Model, index: int) -> list[int]:
    """Return the bodies (0-based) from the root to the body of a joint index, its own last."""
    path = []
    while index > 0:
        path.append(index - 1)
        index = model.parents[index]
    return path[::-1]
