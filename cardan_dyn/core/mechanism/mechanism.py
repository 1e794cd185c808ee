"""Mechanism: the Pinocchio model of the spanning tree plus its loop closures.

A loop becomes an ordinary tree joint plus one weld. Its joint is inserted into the tree on the
predecessor and carries a share of the successor's inertia; a 6D `RigidConstraintModel` welds
that share to the successor. So every joint, loop or not, has a coordinate and a wrench, and
Pinocchio's own `constraintDynamics` applies to `Mechanism.model` as it is. A `fixed` loop needs
no joint: its weld connects the two links directly.

Where a loop's two frames stand to each other while the tree is at zero is the author's choice: pins
may be turned about their axes, and balls in any way. That is a position of the loop's own joint,
not a loop that is open.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from functools import cached_property
from itertools import count
from typing import TYPE_CHECKING, ClassVar

import numpy as np
import pinocchio

from ...kit.arrays import Array, cardan_angles
from ...kit.checks import mapping, number
from ...kit.errors import ModelError, choices
from ...kit.frozen import Frozen, FrozenDict, read_only
from .coordinates import Coordinates
from .joints import Joint, NamedCoordinate, Part, described_joints
from .kept import Kept
from .tree import TreeBuilder, artificial_inertia, se3
from .welds import (
    LEAST_LENGTH,
    coupling_of,
    greatest_length,
    shown,
    weld,
)

if TYPE_CHECKING:
    from ..description.description import (
        Description,
        JointOrLoop,
    )
    from .frames import Frames
    from .teeth import Teeth
    from .undescribed import Undescribed


_MOST_LISTED = 4
"""Open loops that a warning names, so that it stays readable."""
_OPEN = 1e-3
"""Angle [rad] and part of the characteristic length by which loops may be open at zero without a
word: what is written with four digits."""
_ROUNDING = 1e-12
"""Distance of a coordinate from the one that fits [rad, or lengths of the mechanism] up to which it
stays: rotations written as angles leave some 1e-16 times the number of frames between them."""
_UNDECIDED = 1e-9
"""Length of the vector whose direction an angle is, at most 1, below which it has none."""


class Mechanism(Frozen):
    """A closed-chain mechanism; `load` makes one.

    It cannot be changed; copies and pickles are made anew from its description.

    A ball (of a `spherical` or `floating` joint) has a unit quaternion as its coordinates. A scene
    that names one of its Cardan angles has a mechanism in which this ball is three turns, see
    `variant`: about x of the parent's side, then the carried y, then the child's z.

    Attributes:
        name: name in the description.
        description: the description that it was made of.
        notation: how the description writes its loops, and what else it says about them.
        model: `pin.Model` of the spanning tree, the joints of the loops included. Its `gravity` is
            Pinocchio's 9.81 m/s² along -z, which plays no part in scenes, as the limits that it
            keeps play none.
        constraint_models: the welds as `pin.RigidConstraintModel`, for `pin.constraintDynamics`.
        joints: mapping of joint names to `Joint`, tree joints first, then loops.
        links: mapping of link names to `(index in model, pin.SE3 placement in that body)`.
        loops: the welds.
        couplings: the ratios between the motions of links or joints.
        teeth: those of gears among them.
        independent_joints: names of the joints that the description's author drives.
        auxiliary_bodies: indices of the bodies in `model` that only carry a loop's joint to the
            world. Their artificial inertia, without effect, keeps the inertia matrix regular.
        characteristic_length: greatest distance within a body [m]: between its joints and its
            centre of mass; for joints on the world, from their middle. Without loops, or where
            there are no such distances, the radius of gyration about the centre counts as well. It
            weighs forces against moments and distances against angles wherever both are compared,
            and does not depend on which joint of a ring is the loop.
        coordinates: layout of joint coordinates and velocities.
        kept: what scenes of it found out, for other scenes.
    """

    _meant: ClassVar[Mapping[str, str]] = {
        "run solve sweep simulate inverse_dynamics statics forces wrenches": "make a scene of it: "
        "cd.Scene(mechanism, drive=...), then .sweep(positions) or .simulate(duration)",
        "dof dofs ndof mobility freedoms degrees_of_freedom rank": "cd.describe(mechanism) tells "
        "its mobility; joint velocities number mechanism.model.nv",
        "nq nv njoints": "Pinocchio's model has it: mechanism.model",
        "plot show view draw display render visualize": "cd.view(cd.assemble(mechanism)) draws it",
        "describe info summary report": "cd.describe(mechanism)",
        "bodies parts link_list": "mechanism.links, mechanism.link_names",
        "axes joint_list": "mechanism.joints",
        "mass masses inertias": "mechanism.description.links have masses and inertias",
        "save write export to_xml": "cd.write(mechanism, path); mechanism.to_urdf() is its text",
        "q positions configuration assemble": "cd.assemble(mechanism) closes its loops",
        "gravity loads drive held": "these belong to a scene: cd.Scene(mechanism, drive=..., "
        "loads=..., gravity=...)",
    }

    def __init__(
        self, description: Description, base: Mechanism | None = None, cardan: Collection[str] = ()
    ) -> None:
        """Make a mechanism.

        Args:
            description: what it is made of.
            base: the mechanism of which it is a variant.
            cardan: names of the joints whose balls are written as three turns.
        """
        self.description = description
        self._base = base
        self._remarks: tuple[str, ...] = () if base is None else base._remarks
        self._variants: dict[tuple[frozenset[str], frozenset[str]], Mechanism] = {}
        self.kept = Kept()
        self.name = description.name
        self.notation = description.notation
        tree = TreeBuilder(description, cardan)
        self.model = tree.model
        self.links = FrozenDict(tree.links)
        self.joints = FrozenDict(described_joints(description, tree.parts))
        self.loops = tuple(
            weld(loop, self.links, self.joints[loop.name].id) for loop in description.loops
        )
        # What a length or an angle adds to the motion between links is no motion that is coupled.
        described = {
            name: self.joints[name] for name in self.joints if name not in description.origins
        }
        self.couplings = tuple(
            coupling_of(item, self.model, described, self.links) for item in description.couplings
        )
        self.teeth: tuple[Teeth, ...] = ()
        if any(item.mesh for item in description.couplings):
            from .teeth import teeth_of  # Few mechanisms have gears.

            self.teeth = tuple(
                teeth_of(index, item.mesh, coupling, self.model, self.joints)
                for index, (item, coupling) in enumerate(
                    zip(description.couplings, self.couplings, strict=True)
                )
                if item.mesh is not None
            )
        self.independent_joints = description.independent_joints
        self.auxiliary_bodies = tuple(
            loop.predecessor
            for loop in self.loops
            if loop.successor == 0 and self.joints[loop.joint].parts
        )
        self.constraint_models = pinocchio.StdVec_RigidConstraintModel()
        self.constraint_models.extend([loop.constraint(self.model) for loop in self.loops])
        # Variants are compared by the same length, however their bodies are divided.
        self.characteristic_length: float = (
            self._length() if base is None else base.characteristic_length
        )
        for body in self.auxiliary_bodies:
            self.model.inertias[body] = artificial_inertia(description, self.characteristic_length)
        self.coordinates = Coordinates(
            self.model, self.joints.values(), self.characteristic_length, cardan
        )
        self._freeze()

    def _length(self) -> float:
        """Return the characteristic length; 1 m where there is none, as in a spherical linkage.

        What rounding leaves of zero is accepted where nothing but turns makes up the mechanism.
        """
        length = greatest_length(self.model, self.loops)
        if length >= LEAST_LENGTH:
            return length
        if length == 0.0:
            return 1.0
        what = f"{self.name}: the greatest length is {length:g} m"
        parts = (part for joint in self.joints.values() for part in joint.parts)
        if any(part.kind == "prismatic" for part in parts):
            raise ModelError(f"{what}; give lengths in metres, or zeros")
        self._remarks = (f"{what}, which counts as none; give lengths in metres",)
        return 1.0

    def __reduce__(self) -> tuple[object, ...]:
        if self._base is not None:
            moving = self._base.adjustable.keys() & self.joints.keys() | {*self.description.origins}
            return _variant, (self._base, sorted(self.coordinates.cardan), sorted(moving))
        return Mechanism, (self.description,)

    @cached_property
    def curving_columns(self) -> Array:
        """Columns of which others are polynomials, so that no turn of them is like another."""
        rates = {
            rate for item in self.couplings if item.higher for rate in item.predecessor_columns
        }
        return self.coordinates.column_of(np.array(sorted(rates), dtype=int))

    @cached_property
    def undescribed(self) -> tuple[Undescribed, ...]:
        """What couplings leave open whose description does not say which forces they exert."""
        if all(item.forces for item in self.couplings):
            return ()
        from .undescribed import undescribed  # Few mechanisms have couplings.

        return undescribed(self.couplings, self.model, self.joints, self.loops)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """What is wrong with the description and was accepted, and how far its zero is open."""
        description, described = self.description, (*self.description.warnings, *self._remarks)
        if description.displacements:
            changes = "; ".join(map(str, description.displacements))
            described += (
                f"{self.name}: rounded numbers made exact, so that loops close: {changes}",
            )
        if description.remedy:
            described += (f"{self.name}: {description.remedy}",)
        listed = []
        for name, between in self.gaps(self.zero).items():
            gap = float(np.linalg.norm(between.translation))
            angle = float(np.linalg.norm(pinocchio.log3(between.rotation)))
            if max(angle, gap / self.characteristic_length) > _OPEN:
                listed.append(f"{name} by {gap:.3g} m, {angle:.3g} rad")
        if not listed:
            return described
        more = f" and {len(listed) - _MOST_LISTED} more" * (len(listed) > _MOST_LISTED)
        return (
            *described,
            f"{self.name}: loops are open at the description's zero: "
            f"{'; '.join(listed[:_MOST_LISTED])}{more}; scenes start where they can be closed near "
            "it, unless near= says where",
        )

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
            raise ModelError(f"{self.name}: {_why_no_joint(self, name)}", name=name)
        return self.joints[name]

    @cached_property
    def grounded(self) -> frozenset[str]:
        """Names of the joints, loops among them, that connect a link to the world."""
        parents = self.model.parents
        in_tree = {
            name
            for name, joint in self.joints.items()
            if joint.parts and parents[joint.parts[0].id] == 0
        }
        return frozenset(in_tree).union(
            loop.joint for loop in self.loops if 0 in (loop.predecessor, loop.successor)
        )

    @cached_property
    def drivable(self) -> FrozenDict[str, NamedCoordinate]:
        """What scenes can drive, hold, start and load, by name.

        A joint with one coordinate by its own name; one of several by `joint.coordinate`:
        `universal` `turn_1`, `turn_2`; `cylindrical` `slide`, `turn`; `planar` `slide_1`,
        `slide_2`, `turn`; `spherical` `x`, `y`, `z`, the Cardan angles; `floating` `x`, `y`, `z`,
        `turn_x`, `turn_y`, `turn_z`. The effort along a coordinate is the component of the joint's
        wrench along its axis where that then is: for the first turn of a universal joint the
        parent's axis, for the slides of a floating one the parent's axes.
        """
        return FrozenDict(self.coordinates.drivable)

    @cached_property
    def coordinates_together(self) -> FrozenDict[str, tuple[str, ...]]:
        """Joints with several coordinates to all of these; their name stands for them in scenes.

        Where another joint is called like one of them, that joint is meant, and this one left out.
        """
        every = self.joints
        return FrozenDict(
            {
                name: joint.coordinates
                for name, joint in every.items()
                if joint.nv > 1 and not every.keys() & set(joint.coordinates)
            }
        )

    @property
    def independent_coordinates(self) -> tuple[str, ...]:
        """Names of all coordinates of the joints that the description's author drives."""
        joints = (self.joint(name) for name in self.independent_joints)
        # A fixed joint has no coordinate; its own name says which one it is in errors.
        return tuple(name for joint in joints for name in joint.coordinates or (joint.name,))

    @cached_property
    def adjustable(self) -> FrozenDict[str, str]:
        """Fixed joints that become movable in scenes that hold or drive them, and what they become.

        At zero they are where they are fixed; `<joint type="fixed" adjustable="revolute">` in URDF.
        Beside these, every length and angle of a description can be held or driven, by the names
        that `Sweep.derivative` has for them: `origin:JOINT.x` and so on.
        """
        joints = self.base.description.joints
        return FrozenDict({item.name: item.adjustable for item in joints if item.adjustable})

    def is_adjustable(self, name: object) -> bool:
        """Return whether a name is that of an adjustable joint, or says a length or an angle."""
        if not isinstance(name, str) or name in self.base.joints:
            return False
        return name in self.adjustable or name.startswith("origin:")

    def variant(self, cardan: Collection[str] = (), adjusted: Collection[str] = ()) -> Mechanism:
        """Return the mechanism in which balls are three turns and adjustable joints can move.

        Args:
            cardan: names of joints whose balls are turns; those without make no difference.
            adjusted: names of the adjustable joints that can move, and of lengths and angles, see
                `adjustable`.

        Raises:
            ModelError: no such joint.
            ArgumentError: no such component of a placement.
        """
        base, moving = self.base, frozenset(adjusted)
        key = frozenset(name for name in cardan if base.joint(name).has_ball), moving
        if not any(key):
            return base
        if key not in base._variants:
            description = base.description
            if moving:
                from ..description.origins import with_origins  # Few scenes change any.

                description = with_origins(description, moving)
            # Of those that threads make at the same time, all of them get the first.
            base._variants.setdefault(key, Mechanism(description, base, key[0]))
        return base._variants[key]

    @property
    def base(self) -> Mechanism:
        """The mechanism that was loaded, with its balls as balls."""
        return self if self._base is None else self._base

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
    def link_frames(self) -> FrozenDict[str, tuple[int, pinocchio.SE3]]:
        """Links, and frames that are fixed in them: to the body, and the placement there.

        Frames are `fixed` joints, sites of MJCF, frames of SDF and of Pinocchio. Of one name, a
        link comes before a joint, and that before other frames.
        """
        placed = {
            name: (self.links[link][0], self.links[link][1] * se3(place))
            for name, (link, place) in self.description.fixed_frames.items()
        }
        return FrozenDict({**placed, **self.links})

    def link_frame(self, name: object) -> tuple[int, pinocchio.SE3]:
        """Return the body index and the placement there of a link, or of a frame fixed in one.

        Raises:
            ModelError: unknown name; the message lists the valid ones.
        """
        if not isinstance(name, str) or name not in self.link_frames:
            raise ModelError(
                f"{self.name}: no link or frame {name!r}; links and frames: "
                f"{choices(self.link_frames, name)}",
                name=name,
            )
        return self.link_frames[name]

    # What the package computes with, made when it is first needed and kept.

    @cached_property
    def frames(self) -> Frames:
        """Where every joint is, by plain forward kinematics and without Pinocchio."""
        from .frames import Frames

        return Frames(self.description, self.coordinates)

    @cached_property
    def second_reading(self) -> Description:
        """The description with the numbers of its text read once more, for the proof."""
        from ..description.second_reading import reread

        return reread(self.description)

    @cached_property
    def wrench_indices(self) -> FrozenDict[str, int]:
        """Joint to the index of its wrench: bodies in order, then `fixed` loops.

        Of a joint of several parts it is that of the last one: the inner bodies are massless, and
        transmit the same wrench.
        """
        result = {joint.name: joint.id - 1 for joint in self.joints.values() if joint.parts}
        fixed = (loop.joint for loop in self.loops if loop.is_fixed)
        return FrozenDict(result | dict(zip(fixed, count(self.model.njoints - 1), strict=False)))

    @property
    def wrench_count(self) -> int:
        """Number of wrenches, those of inner bodies of joints included."""
        return self.model.njoints - 1 + sum(loop.is_fixed for loop in self.loops)

    @cached_property
    def placements_at_zero(self) -> dict[int, pinocchio.SE3]:
        """Placements of all bodies (0-based; -1 is the world) with every joint at zero."""
        placements = {-1: pinocchio.SE3.Identity()}
        for index in range(1, self.model.njoints):
            parent = placements[self.model.parents[index] - 1]
            placements[index - 1] = parent * self.model.jointPlacements[index]
        return placements

    @cached_property
    def zero(self) -> Array:
        """Coordinates `(size,)` of the description's zero, which need not close its loops.

        All joints are at zero, except that those which mimic others are where their offsets say,
        and those of loops where the two ends of their loop are nearest to each other.
        """
        return read_only(self.fitted(_zero_of(self.description, self.coordinates)))

    def fitted(self, x: Array, fixed: Collection[int] = ()) -> Array:
        """Return coordinates `(size,)` with the joints of loops where they fit the tree.

        Each is where the two ends of its loop are nearest to each other, with angles within half a
        turn of where they were. All other joints stay.

        Args:
            x: `(size,)` coordinates; kept as they are.
            fixed: velocity coordinates that stay; a loop whose joint has one of them stays
                altogether.
        """
        coordinates = self.coordinates
        chosen = {
            name: coordinates.columns[name]
            for name in (loop.joint for loop in self.loops if not loop.is_fixed)
            if not _has_any(coordinates.velocity_columns[name], fixed)
        }
        if not chosen:
            return x
        result, at_zero, neutral = x.copy(), x.copy(), coordinates.neutral()
        for columns in chosen.values():
            at_zero[columns] = neutral[columns]
        gaps = self.gaps(at_zero)
        for name, columns in chosen.items():
            values = _values(self.joints[name].parts, gaps[name], x[columns])
            away = (values - x[columns]) * coordinates.scale[columns]
            if np.max(np.abs(away)) > _ROUNDING:
                result[columns] = values
        return result

    def gaps(self, x: Array) -> dict[str, pinocchio.SE3]:
        """Return loops to the placements of their successor's end in their own, at `x (size,)`."""
        if not self.loops:
            return {}
        model, data = self.model, self.model.createData()
        pinocchio.forwardKinematics(model, data, self.coordinates.configuration(x[None])[0])
        # Not those in the world, from whose origin the mechanism may be so far that digits fail.
        base = next(
            model.jointPlacements[k] for k in range(1, model.njoints) if not model.parents[k]
        )
        placed: list[pinocchio.SE3] = []

        def at(body: int, placement: pinocchio.SE3) -> pinocchio.SE3:
            return placed[body] * placement if body else base.actInv(placement)

        for body, parent in enumerate(model.parents):
            placed.append(at(parent, data.liMi[body]))
        return {
            loop.joint: at(loop.predecessor, loop.predecessor_placement).actInv(
                at(loop.successor, loop.successor_placement)
            )
            for loop in self.loops
        }

    @cached_property
    def joint_dynamics(self) -> FrozenDict[str, tuple[float, float]]:
        """Coordinates to the damping [N·m·s/rad, N·s/m] and friction [N·m, N] described for them.

        `<dynamics>` in URDF and SDF, `damping` and `frictionloss` in MJCF; of a joint with several
        coordinates, those of each. Joints with a ball are left out. No wrench considers them unless
        a scene is given `described_elements`.
        """
        return FrozenDict(
            {
                name: (item.dynamics.damping, item.dynamics.friction)
                for name, item in self._described_coordinates()
                if item.dynamics.damping or item.dynamics.friction
            }
        )

    @cached_property
    def joint_springs(self) -> FrozenDict[str, tuple[float, float]]:
        """Coordinates to stiffness [N·m/rad, N/m] and rest of the springs described for them.

        The rest is the position [rad or m] without effort. `spring_stiffness` and
        `spring_reference` of `<dynamics>` in SDF and URDF+, `stiffness` and `springref` in MJCF;
        otherwise as `joint_dynamics`.
        """
        return FrozenDict(
            {
                name: (item.dynamics.stiffness, item.dynamics.rest)
                for name, item in self._described_coordinates()
                if item.dynamics.stiffness
            }
        )

    def _described_coordinates(self) -> Iterator[tuple[str, JointOrLoop]]:
        """Iterate over coordinates of joints without a ball, and what describes their joints."""
        for item in self.description.joints_and_loops:
            if item.name in self.joints and not self.joints[item.name].has_ball:
                for name in self.joints[item.name].coordinates:
                    # What is called like a coordinate of another joint is that joint.
                    if name == item.name or name not in self.joints:
                        yield name, item

    def to_urdf(self, adjusted: Mapping[str, float] | None = None) -> str:
        """Return the description as URDF+ text, which `load` reads back; without visuals.

        Args:
            adjusted: what scenes hold adjustable joints, lengths and angles at [m or rad], such as
                the end of an optimisation; see `adjustable`. They are fixed there in the text, and
                count from there. Masses, centres and inertias of links stay as they are.

        Raises:
            ArgumentError: a value is no number, or there is no such component of a placement.
            ModelError: a name says no length or angle; or the description has no notation in URDF+.
        """
        from ..description.origins import adjusted as with_values
        from ..description.write import to_urdf

        base = self.base
        values = {
            name: number(f"adjusted[{name!r}]", value)
            for name, value in mapping("adjusted", adjusted).items()
        }
        for name in values:
            if not base.is_adjustable(name):
                raise ModelError(
                    f"adjusted: {name!r} says no length or angle; name adjustable joints, or "
                    "origin:JOINT.x, y, z, roll, pitch, yaw",
                    name=name,
                )
        return to_urdf(with_values(base.description, values) if values else self.description)

    def __repr__(self) -> str:
        loops = ", ".join(loop.joint for loop in self.loops) or "none"
        return f"<Mechanism {self.name!r}: {len(self.joints)} joints, loops: {loops}>"

    def _repr_html_(self) -> str:
        from ...kit.markup import table  # Only notebooks show it.

        rows = [
            ("notation", self.notation),
            ("characteristic length", f"{self.characteristic_length:.4g} m"),
            ("joints", "\n".join(f"{joint.name}: {joint.type}" for joint in self.joints.values())),
            ("loops", ", ".join(loop.joint for loop in self.loops) or "none"),
            ("couplings", "\n".join(map(shown, self.couplings)) or "none"),
            ("warnings", "\n".join(self.warnings) or "none"),
        ]
        return table(("property", "value"), rows, caption=self.name)


def _variant(base: Mechanism, cardan: Collection[str], moving: Collection[str]) -> Mechanism:
    return base.variant(cardan, moving)


def _why_no_joint(mechanism: Mechanism, name: object) -> str:
    """Return why a name is that of no joint, for messages."""
    if isinstance(name, str) and name in mechanism.drivable:
        return f"{name!r} is a coordinate; name its joint, {mechanism.drivable[name].joint!r}"
    if mechanism.is_adjustable(name):
        return (
            f"joint {name!r} is adjustable, and rigid unless a scene holds or drives it; to have "
            f"its wrench or motion, hold it: held={{{name!r}: 0.0}}"
        )
    return f"no joint {name!r}; joints: {choices(mechanism.joints, name)}"


def _zero_of(description: Description, coordinates: Coordinates) -> Array:
    """Return coordinates `(size,)` at which all joints are at zero, those of loops as well.

    Joints that mimic others are where their offsets say.
    """
    x = coordinates.neutral()
    mimics = [item for item in description.couplings if item.of_joints]
    for _ in mimics:  # A joint may mimic one that mimics another itself, further below.
        for item in mimics:
            mimicked = x[coordinates.columns[item.predecessor].start]
            x[coordinates.columns[item.successor].start] = item.polynomial(mimicked)
    return x


def _has_any(columns: slice, fixed: Collection[int]) -> bool:
    return any(columns.start <= column < columns.stop for column in fixed)


def _values(parts: tuple[Part, ...], to: pinocchio.SE3, near: Array) -> Array:
    """Return the coordinates of a joint that come nearest to a displacement.

    Slides come before turns in every joint, and are at right angles to each other, so that they
    alone shift the joint's origin.
    """
    rotation = to.rotation
    slides = [part.axis @ to.translation for part in parts if part.kind == "prismatic"]
    turning = [part for part in parts if part.kind != "prismatic"]
    before = near[len(slides) :]
    if not turning:
        return np.array(slides)
    if turning[0].kind == "spherical":
        quaternion = np.array(pinocchio.Quaternion(rotation).coeffs())
        return np.array([*slides, *(-quaternion if quaternion @ before < 0.0 else quaternion)])
    angles = _angles([part.axis for part in turning], rotation, before)
    away = np.remainder(angles - before, 2.0 * np.pi)
    away[away > np.pi + _UNDECIDED] -= (
        2.0 * np.pi
    )  # Rounding does not decide the way of half turns.
    return np.array([*slides, *(before + away)])


def _angles(axes: list[Array], rotation: Array, near: Array) -> Array:
    """Return the angles of turns about one, two or three axes that come nearest to a rotation.

    Several axes are at right angles to each other, three of them right-handed.
    """
    if len(axes) == 1:
        (axis,) = axes
        along = axis @ rotation @ axis
        vector = pinocchio.unSkew(0.5 * (rotation - rotation.T))
        pairs = [(axis @ vector, 0.5 * (np.trace(rotation) - along))]
    elif len(axes) == 2:
        # The first turn alone moves the second axis, the second turn alone brings the first back.
        first, second = axes
        third = np.cross(first, second)
        moved, back = rotation @ second, rotation.T @ first
        pairs = [(third @ moved, second @ moved), (third @ back, first @ back)]
    else:
        basis = np.stack(axes, axis=1)
        return cardan_angles(pinocchio.Quaternion(basis.T @ rotation @ basis).coeffs())
    return np.array(
        [
            np.arctan2(sine, cosine) if np.hypot(sine, cosine) > _UNDECIDED else before
            for (sine, cosine), before in zip(pairs, near, strict=True)
        ]
    )
