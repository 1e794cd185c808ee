"""Mechanism: the Pinocchio model of the spanning tree plus its loop closures.

A loop becomes an ordinary tree joint plus one weld. Its joint is inserted into the tree on the
predecessor and carries a share of the successor's inertia; a 6D `RigidConstraintModel` welds
that share to the successor. So every joint, loop or not, has a coordinate and a wrench, and
Pinocchio's own `constraintDynamics` applies to `Mechanism.model` as it is. A `fixed` loop needs
no joint: its weld connects the two links directly.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pinocchio

from ..description.read import read
from ..errors import ModelError, choices
from ..frozen import Frozen, FrozenDict
from .coordinates import Coordinates
from .joints import Joint, Part
from .tree import TreeBuilder, ancestors, se3

if TYPE_CHECKING:
    from ..description.description import (
        CouplingDescription,
        Description,
        JointDescription,
        LoopDescription,
    )
    from .frames import Frames


_SHORTEST = 1e-30
"""Characteristic length [m] below which a mechanism is refused: powers of it and their reciprocals
have to stay within the range of doubles, which ends at 1e-308."""


class Loop(NamedTuple):
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


class Coupling(NamedTuple):
    """A velocity ratio between two links: ratio times the predecessor's motion is the successor's.

    Motions are angles or slides, summed up over the joints from the nearest common ancestor of both
    links.

    Attributes:
        name: its name in the description.
        ratio: motion of the successor per motion of the predecessor.
        predecessor, successor: indices of the links' bodies in `Mechanism.model`.
        predecessor_columns, successor_columns: velocity coordinates between them and their
            nearest common ancestor.
    """

    name: str
    ratio: float
    predecessor: int
    successor: int
    predecessor_columns: tuple[int, ...]
    successor_columns: tuple[int, ...]


class Mechanism(Frozen):
    """A closed-chain mechanism; `load` makes one.

    It cannot be changed; copies and pickles are made anew from its description.

    Attributes:
        name: name in the description.
        description: the description that it was made of.
        notation: how the description writes its loops, and what else it says about them.
        warnings: what is wrong with the description and was accepted.
        model: `pin.Model` of the spanning tree, the joints of the loops included. Its `gravity` is
            Pinocchio's 9.81 m/s² along -z, which plays no part in scenes: they have the gravity
            that they are given, none unless they are given some. It keeps the limits of the
            description, of which scenes know nothing either.
        constraint_models: the welds as `pin.RigidConstraintModel`, for `pin.constraintDynamics`.
        joints: mapping of joint names to `Joint`, tree joints first, then loops.
        links: mapping of link names to `(index in model, pin.SE3 placement in that body)`.
        loops: the welds.
        couplings: the velocity ratios between links.
        independent_joints: names of the joints that the description's author drives.
        auxiliary_bodies: indices of the bodies in `model` that only carry a loop's joint to the
            world. Their artificial inertia keeps the inertia matrix of `model` regular; it has no
            effect, since they are welded to the world.
        characteristic_length: greatest distance within a body [m]. It weighs forces against
            moments and distances against angles wherever both are compared.
        coordinates: layout of joint coordinates and velocities.
    """

    def __init__(self, description: Description) -> None:
        self.description = description
        self.name = description.name
        self.notation = description.notation
        self.warnings = description.warnings
        tree = TreeBuilder(description)
        self.model = tree.model
        self.links = FrozenDict(tree.links)
        self.joints = FrozenDict(_joints(description, tree.parts))
        self.loops = tuple(self._weld(loop) for loop in description.loops)
        self.couplings = tuple(self._coupling(item) for item in description.couplings)
        self.independent_joints = description.independent_joints
        self.auxiliary_bodies = tuple(
            loop.predecessor
            for loop in self.loops
            if loop.successor == 0 and self.joints[loop.joint].parts
        )
        self.constraint_models = _constraint_models(self.model, self.loops)
        self.characteristic_length = _characteristic_length(self.model, self.loops)
        if self.characteristic_length < _SHORTEST:
            raise ModelError(
                f"{self.name}: the greatest length is {self.characteristic_length:g} m; "
                "give lengths in metres"
            )
        self.coordinates = Coordinates(self.model, self.joints.values(), self.characteristic_length)
        self._freeze()

    def __reduce__(self) -> tuple[object, ...]:
        return Mechanism, (self.description,)

    @cached_property
    def fixed_loops(self) -> tuple[str, ...]:
        """Names of the `fixed` loops, which have a wrench but neither coordinate nor body."""
        return tuple(loop.joint for loop in self.loops if not self.joints[loop.joint].parts)

    def __getitem__(self, joint: str) -> Joint:
        return self.joint(joint)

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names of all joints, those of the tree first, then the loops."""
        return iter(self.joints)

    def __contains__(self, joint: object) -> bool:
        return isinstance(joint, str) and joint in self.joints

    def __len__(self) -> int:
        """Return the number of joints, loops included."""
        return len(self.joints)

    def __bool__(self) -> bool:
        return True

    @property
    def link_names(self) -> list[str]:
        """Names of all links."""
        return list(self.links)

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
                f"{self.name}: no joint {name!r}; joints: {choices(self.joints, name)}", name=name
            )
        return self.joints[name]

    def link(self, name: object) -> tuple[int, pinocchio.SE3]:
        """Return a link's body index and its placement there.

        Raises:
            ModelError: unknown name; the message lists the valid ones.
        """
        if not isinstance(name, str) or name not in self.links:
            raise ModelError(
                f"{self.name}: no link {name!r}; links: {choices(self.links, name)}", name=name
            )
        return self.links[name]

    @cached_property
    def frames(self) -> Frames:
        """Where every joint is, by plain forward kinematics."""
        from .frames import Frames

        return Frames(self.description, self.coordinates)

    @cached_property
    def reread(self) -> Description:
        """The description with the numbers of its text read once more, for the proof."""
        from ..description.second_reading import reread

        return reread(self.description)

    @cached_property
    def placements_at_zero(self) -> dict[int, pinocchio.SE3]:
        """Placements of all bodies (0-based; -1 is the world) with every joint at zero."""
        placements = {-1: pinocchio.SE3.Identity()}
        for index in range(1, self.model.njoints):
            parent = placements[self.model.parents[index] - 1]
            placements[index - 1] = parent * self.model.jointPlacements[index]
        return placements

    def to_urdf(self) -> str:
        """Return the description as URDF+ text, which `load` reads back; without visuals."""
        from ..description.write import to_urdf

        return to_urdf(self.description)

    def write(
        self, path: str | os.PathLike[str], *, at: Mapping[str, object] | None = None
    ) -> Path:
        """Write the description to a file, which `load` reads back; without visuals.

        A file that exists is replaced.

        Args:
            path: file whose suffix says in which notation: `.urdf` for URDF+, as `to_urdf` returns
                it; `.xml` or `.mjcf` for MJCF, see `description.mjcf.writer` for what it becomes
                there.
            at: closed configuration that becomes the zero of the written coordinates: name of every
                moving joint, loops included, to its position as `Motion.position` gives it for a
                sample. Limits are counted from there as well. Without it the zero stays.

        Returns:
            The path.

        Raises:
            ArgumentError: unknown suffix, no such directory, or `at` is incomplete, malformed or
                not closed.
            ModelError: the notation cannot say something of the description.
        """
        from ..description.files import write

        description = self.description
        if at is not None:
            from .rezero import rezeroed

            description = rezeroed(description, at)
        return write(description, path)

    def __repr__(self) -> str:
        loops = ", ".join(loop.joint for loop in self.loops) or "none"
        return f"<Mechanism {self.name!r}: {len(self.joints)} joints, loops: {loops}>"

    def _repr_html_(self) -> str:
        from ..markup import table  # Imported here: only notebooks show it.

        rows = [
            ("notation", self.notation),
            ("characteristic length", f"{self.characteristic_length:.4g} m"),
            ("joints", "\n".join(f"{joint.name}: {joint.type}" for joint in self.joints.values())),
            ("loops", ", ".join(loop.joint for loop in self.loops) or "none"),
            ("couplings", "\n".join(map(_shown, self.couplings)) or "none"),
            ("warnings", "\n".join(self.warnings) or "none"),
        ]
        return table(("property", "value"), rows, caption=self.name)

    def _weld(self, loop: LoopDescription) -> Loop:
        predecessor, frame = self.links[loop.predecessor]
        placement = frame * se3(loop.predecessor_origin)
        joint_body = self.joints[loop.name].id
        if joint_body:
            predecessor, placement = joint_body, pinocchio.SE3.Identity()
        successor, frame = self.links[loop.successor]
        return Loop(
            loop.name, predecessor, placement, successor, frame * se3(loop.successor_origin)
        )

    def _coupling(self, coupling: CouplingDescription) -> Coupling:
        bodies = [self.links[name][0] for name in (coupling.predecessor, coupling.successor)]
        chains = [set(ancestors(self.model, body)) for body in bodies]
        first, second = (
            tuple(self._coupled_columns(coupling.name, side - opposite))
            for side, opposite in (chains, chains[::-1])
        )
        if not (first or second):
            raise ModelError(
                f"{self.name}: coupling {coupling.name!r}: no joint moves {coupling.predecessor!r} "
                f"relative to {coupling.successor!r}"
            )
        return Coupling(coupling.name, coupling.ratio, bodies[0], bodies[1], first, second)

    def _coupled_columns(self, coupling: str, bodies: set[int]) -> list[int]:
        """Return the velocity coordinates of the joints that move some bodies (0-based).

        Raises:
            ModelError: one of them has several coordinates, which the coupling cannot count.
        """
        columns = []
        for joint in self.joints.values():
            for part in joint.parts:
                if part.id - 1 not in bodies:
                    continue
                if joint.nv != 1:
                    raise ModelError(
                        f"{self.name}: coupling {coupling!r}: joint {joint.name!r} between its "
                        f"links is {joint.type}; only joints with one coordinate can be coupled"
                    )
                columns.append(self.model.idx_vs[part.id])
        return columns


def load(source: str | os.PathLike[str], *, strict: bool = True) -> Mechanism:
    """Load a mechanism with closed loops.

    Args:
        source: name of a bundled description, path of a URDF, MJCF or SDF file, or their text.
            Loops may be written in URDF+, as Isaac's `<loop_joint>`, in Gepetto's YAML file beside
            the URDF, as `<equality>` in MJCF, or as joints of SDF that do not belong to its tree.
        strict: refuse what is probably wrong: inertias that no body can have, misspelled words of a
            URDF or SDF file, forces in an MJCF or SDF file that no wrench considers. Many published
            robots have some: with False they are accepted (a mass of zero as no mass) and listed in
            `Mechanism.warnings`. A negative mass is refused in any case.

    Raises:
        ModelError: the description is missing, malformed or impossible.
    """
    return Mechanism(read(source, strict))


def _joints(description: Description, parts: dict[str, list[Part]]) -> dict[str, Joint]:
    """Return the joints that carry a wrench by name, those of the tree first, then the loops."""
    described: list[JointDescription | LoopDescription] = [*description.joints, *description.loops]
    joints = {}
    for item in described:
        if item.name in parts:
            axis = np.cross(item.axis, item.axis_2) if item.type == "universal" else item.axis
            joints[item.name] = Joint(item.name, item.type, axis, tuple(parts[item.name]))
    return joints


def _shown(coupling: Coupling) -> str:
    return f"{coupling.name}: ratio {coupling.ratio:g}"


def _constraint_models(
    model: pinocchio.Model, loops: tuple[Loop, ...]
) -> pinocchio.StdVec_RigidConstraintModel:
    """Return welds as Pinocchio's constraints."""
    result = pinocchio.StdVec_RigidConstraintModel()
    for weld in loops:
        result.append(
            pinocchio.RigidConstraintModel(
                pinocchio.ContactType.CONTACT_6D,
                model,
                weld.predecessor,
                weld.predecessor_placement,
                weld.successor,
                weld.successor_placement,
                pinocchio.ReferenceFrame.LOCAL,
            )
        )
    return result


def _characteristic_length(model: pinocchio.Model, loops: tuple[Loop, ...]) -> float:
    """Return the greatest distance that occurs within a body of the mechanism [m]."""
    placed = list(zip(list(model.parents)[1:], list(model.jointPlacements)[1:], strict=True))
    for loop in loops:
        placed.append((loop.predecessor, loop.predecessor_placement))
        placed.append((loop.successor, loop.successor_placement))
    lengths = [0.0]
    lengths += [float(np.linalg.norm(frame.translation)) for body, frame in placed if body]
    # The world's origin may be anywhere, so frames in the world are measured from their middle.
    on_world = [frame.translation for body, frame in placed if not body]
    if on_world:
        spread = np.asarray(on_world) - np.mean(on_world, axis=0)
        lengths.append(float(np.max(np.linalg.norm(spread, axis=1))))
    for inertia in list(model.inertias)[1:]:
        if inertia.mass > 0.0:
            lengths.append(float(np.linalg.norm(inertia.lever)))
            spread_of_mass = max(float(np.trace(inertia.inertia)), 0.0) / (2.0 * inertia.mass)
            lengths.append(float(np.sqrt(spread_of_mass)))
    return max(lengths) or 1.0
