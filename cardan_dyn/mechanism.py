"""Mechanism: the Pinocchio model of the spanning tree plus its loop closures.

A loop becomes an ordinary tree joint plus one weld. Its joint is inserted into the tree on the
predecessor and carries a share of the successor's inertia; a 6D `RigidConstraintModel` welds
that share to the successor. So every joint, loop or not, has a coordinate and a wrench, and
Pinocchio's own `constraintDynamics` applies to `Mechanism.model` as it is. A `fixed` loop needs
no joint: its weld connects the two links directly.
"""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np
import pinocchio

from .description import Description, LoopDescription, read
from .errors import ModelError, choices


@dataclass(frozen=True)
class Joint:
    """One joint of a mechanism, in the tree or closing a loop.

    Attributes:
        name: its name in the description.
        kind: `revolute`, `prismatic`, `spherical` or `fixed`; a `continuous` joint is `revolute`.
        unbounded: whether its angle turns without end.
        axis: `(3,)` unit axis in the joint frame.
        index: index in `Mechanism.model`; 0 for a `fixed` loop, which has no coordinate.
    """

    name: str
    kind: str
    unbounded: bool
    axis: np.ndarray
    index: int

    @property
    def size(self) -> int:
        """Number of velocity coordinates."""
        return {"revolute": 1, "prismatic": 1, "spherical": 3, "fixed": 0}[self.kind]


@dataclass(frozen=True)
class Loop:
    """A weld that closes a loop.

    Attributes:
        joint: name of the joint that the loop is.
        predecessor: index in `Mechanism.model` of the welded body on the predecessor's side (the
            body of the loop's own joint, or the predecessor itself for a `fixed` loop).
        predecessor_placement: `pin.SE3` of the weld in that body.
        successor: index of the successor's body, 0 for the world.
        successor_placement: `pin.SE3` of the weld in the successor's body.
    """

    joint: str
    predecessor: int
    predecessor_placement: pinocchio.SE3
    successor: int
    successor_placement: pinocchio.SE3


class Mechanism:
    """A closed-chain mechanism; `load` makes one.

    Attributes:
        name: name in the description.
        model: `pin.Model` of the spanning tree, the joints of the loops included.
        constraint_models: the welds as `pin.RigidConstraintModel`, for `pin.constraintDynamics`.
        joints: mapping of joint names to `Joint`, tree joints first, then loops.
        links: mapping of link names to `(index in model, pin.SE3 placement in that body)`.
        loops: the welds.
        helpers: indices of bodies that only carry a loop's joint to the world. Their inertia
            keeps `model`'s inertia matrix regular; welded to the world, they never move.
        length: characteristic length [m]. It weighs forces against moments and distances
            against angles wherever both are compared.
    """

    def __init__(self, description: Description) -> None:
        self.name = description.name
        self.description = description
        tree = _tree(description)
        bodies = {
            name: tree.frames[tree.getFrameId(name, pinocchio.FrameType.BODY)]
            for name in description.links
        }
        self.model = _with_loop_joints(tree, description, bodies)
        index = {name: number for number, name in enumerate(self.model.names)}
        self.links: dict[str, tuple[int, pinocchio.SE3]] = {
            name: (index[tree.names[frame.parentJoint]], frame.placement)
            for name, frame in bodies.items()
        }
        self.joints: dict[str, Joint] = {}
        for name, kind in description.joints.items():
            if kind != "fixed":
                self.joints[name] = Joint(
                    name,
                    "prismatic" if kind == "prismatic" else "revolute",
                    kind == "continuous",
                    description.axes[name],
                    index[name],
                )
        self.loops: list[Loop] = []
        for loop in description.loops:
            kind = "revolute" if loop.type == "continuous" else loop.type
            self.joints[loop.name] = Joint(
                loop.name, kind, kind == "revolute", loop.axis, index.get(loop.name, 0)
            )
            self.loops.append(self._weld(loop))
        self.helpers = [loop.predecessor for loop in self.loops if loop.successor == 0]
        self.constraint_models = pinocchio.StdVec_RigidConstraintModel()
        for weld in self.loops:
            self.constraint_models.append(
                pinocchio.RigidConstraintModel(
                    pinocchio.ContactType.CONTACT_6D,
                    self.model,
                    weld.predecessor,
                    weld.predecessor_placement,
                    weld.successor,
                    weld.successor_placement,
                    pinocchio.ReferenceFrame.LOCAL,
                )
            )
        self.length = _characteristic_length(self.model, self.loops)

    @property
    def joint_names(self) -> list[str]:
        """Names of all joints that carry a wrench, loops last."""
        return list(self.joints)

    def joint(self, name: object) -> Joint:
        """Return a joint by name.

        Raises:
            ModelError: unknown name; the message lists the valid ones.
        """
        if not isinstance(name, str) or name not in self.joints:
            raise ModelError(
                f"{self.name}: no joint {name!r}; joints: {choices(self.joints)}", name=name
            )
        return self.joints[name]

    def link(self, name: object) -> tuple[int, pinocchio.SE3]:
        """Return a link's body index and its placement there.

        Raises:
            ModelError: unknown name; the message lists the valid ones.
        """
        if not isinstance(name, str) or name not in self.links:
            raise ModelError(
                f"{self.name}: no link {name!r}; links: {choices(self.links)}", name=name
            )
        return self.links[name]

    def __repr__(self) -> str:
        loops = ", ".join(loop.joint for loop in self.loops) or "none"
        return f"<Mechanism {self.name!r}: {len(self.joints)} joints, loops: {loops}>"

    def _weld(self, loop: LoopDescription) -> Loop:
        predecessor, frame = self.links[loop.predecessor]
        placement = frame * _se3(loop.predecessor_origin)
        own = self.joints[loop.name].index
        if own:
            predecessor, placement = own, pinocchio.SE3.Identity()
        successor, frame = self.links[loop.successor]
        return Loop(
            loop.name, predecessor, placement, successor, frame * _se3(loop.successor_origin)
        )


def load(source: str | os.PathLike[str]) -> Mechanism:
    """Load a mechanism with closed loops.

    Args:
        source: name of a bundled description, path of a URDF file, or URDF text.

    Raises:
        ModelError: the description is missing, malformed or impossible.
    """
    return Mechanism(read(source))


def _tree(description: Description) -> pinocchio.Model:
    try:
        return pinocchio.buildModelFromXML(description.urdf)
    except (ValueError, RuntimeError) as error:
        raise ModelError(f"{description.name}: Pinocchio cannot build the tree: {error}") from error


def _se3(matrix: np.ndarray) -> pinocchio.SE3:
    return pinocchio.SE3(matrix[:3, :3], matrix[:3, 3])


def _loop_joint_model(loop: LoopDescription) -> pinocchio.JointModel:
    if loop.type == "spherical":
        return pinocchio.JointModelSpherical()
    # The bindings build unbounded joints about the positive frame axes only. Any other axis gets
    # a bounded joint, whose limits inverse dynamics never uses.
    unbounded = {
        (1.0, 0.0, 0.0): pinocchio.JointModelRUBX,
        (0.0, 1.0, 0.0): pinocchio.JointModelRUBY,
        (0.0, 0.0, 1.0): pinocchio.JointModelRUBZ,
    }.get(tuple(loop.axis.tolist()))
    return unbounded() if unbounded else pinocchio.JointModelRevoluteUnaligned(loop.axis)


def _with_loop_joints(
    tree: pinocchio.Model, description: Description, bodies: dict[str, pinocchio.Frame]
) -> pinocchio.Model:
    """Rebuild a tree with the joints of its loops inserted.

    They cannot be appended: Pinocchio's inertia matrix and constrained dynamics take it for
    granted that the joints of a subtree follow each other, and are silently wrong otherwise.
    """
    ends = {
        loop.name: (bodies[loop.predecessor], bodies[loop.successor]) for loop in description.loops
    }
    shares: dict[int, int] = {}
    for loop in description.loops:
        predecessor, successor = (frame.parentJoint for frame in ends[loop.name])
        if predecessor == successor:
            raise ModelError(
                f"{description.name}: loop {loop.name!r} connects {loop.predecessor!r} and "
                f"{loop.successor!r}, which fixed joints already make one body"
            )
        if loop.type != "fixed":
            shares[successor] = shares.get(successor, 1) + 1

    model = pinocchio.Model()
    model.name = tree.name
    model.inertias[0] = tree.inertias[0]
    new = {0: 0}

    def visit(joint: int) -> None:
        for child in range(1, tree.njoints):
            if tree.parents[child] != joint:
                continue
            new[child] = model.addJoint(
                new[joint], tree.joints[child], tree.jointPlacements[child], tree.names[child]
            )
            model.inertias[new[child]] = _share(tree.inertias[child], shares.get(child, 1))
            visit(child)
        for loop in description.loops:
            predecessor, successor = ends[loop.name]
            if predecessor.parentJoint != joint or loop.type == "fixed":
                continue
            helper = model.addJoint(
                new[joint],
                _loop_joint_model(loop),
                predecessor.placement * _se3(loop.predecessor_origin),
                loop.name,
            )
            body = successor.parentJoint
            on_successor = successor.placement * _se3(loop.successor_origin)
            model.inertias[helper] = (
                on_successor.actInv(_share(tree.inertias[body], shares[body]))
                if body
                else _helper_inertia(tree)
            )

    visit(0)
    _copy_limits(tree, model, new)
    for frame in list(tree.frames)[1:]:
        model.addFrame(
            pinocchio.Frame(frame.name, new[frame.parentJoint], frame.placement, frame.type), False
        )
    return model


def _copy_limits(tree: pinocchio.Model, model: pinocchio.Model, new: dict[int, int]) -> None:
    for old, index in new.items():
        if old == 0:
            continue
        here, there = tree.joints[old], model.joints[index]
        for names, start, size in (
            (("lowerPositionLimit", "upperPositionLimit"), "idx_q", "nq"),
            (("upperEffortLimit", "lowerEffortLimit"), "idx_v", "nv"),
            (("upperVelocityLimit", "lowerVelocityLimit"), "idx_v", "nv"),
        ):
            first, count = getattr(here, start), getattr(here, size)
            to = getattr(there, start)
            for name in names:
                values = getattr(tree, name)[first : first + count]
                getattr(model, name)[to : to + count] = values


def _share(whole: pinocchio.Inertia, parts: int) -> pinocchio.Inertia:
    return pinocchio.Inertia(whole.mass / parts, whole.lever, whole.inertia / parts)


def _helper_inertia(model: pinocchio.Model) -> pinocchio.Inertia:
    masses = [inertia.mass for inertia in model.inertias if inertia.mass > 0.0]
    mass = float(np.mean(masses)) if masses else 1.0
    return pinocchio.Inertia(mass, np.zeros(3), mass * np.eye(3))


def _characteristic_length(model: pinocchio.Model, loops: list[Loop]) -> float:
    """Return the greatest distance that occurs within a body of the mechanism [m]."""
    on_world: list[np.ndarray] = []
    lengths = [0.0]

    def place(body: int, placement: pinocchio.SE3) -> None:
        if body == 0:
            on_world.append(placement.translation)
        else:
            lengths.append(float(np.linalg.norm(placement.translation)))

    for parent, placement in zip(model.parents[1:], model.jointPlacements[1:], strict=False):
        place(parent, placement)
    for loop in loops:
        place(loop.predecessor, loop.predecessor_placement)
        place(loop.successor, loop.successor_placement)
    if on_world:
        spread = np.asarray(on_world) - np.mean(on_world, axis=0)
        lengths.append(float(np.max(np.linalg.norm(spread, axis=1))))
    for inertia in model.inertias:
        if inertia.mass > 0.0:
            lengths.append(float(np.linalg.norm(inertia.lever)))
            lengths.append(float(np.sqrt(np.trace(inertia.inertia) / (2.0 * inertia.mass))))
    return max(lengths) or 1.0
