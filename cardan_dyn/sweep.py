"""Sweep: the result of a scene over given positions, with the residuals that prove it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from .coordinates import Array
from .errors import ArgumentError, ModelError, choices
from .mechanism import Mechanism
from .motion import Motion
from .reactions import ReactionSolver
from .twin import placement
from .wrench import Components, JointWrench, Known

FRAMES = ("joint", "parent", "world")


class Source(Protocol):
    """What a sweep takes its arrays from, as far as they are asked for."""

    def __len__(self) -> int:
        """Return the number of samples."""
        ...

    def wrench(self, number: int) -> Components:
        """Return the wrench of an output in its joint frame."""
        ...

    def drive_effort(self) -> Array | None:
        """Return what the drive exerts, None if the outputs leave it out."""
        ...

    def holding_effort(self) -> dict[str, Array]:
        """Return what holds the held joints."""
        ...

    def motion(self) -> Motion:
        """Return positions, speeds and accelerations."""
        ...


@dataclass(frozen=True, eq=False)
class Solved:
    """A `Source` whose arrays are all there.

    Attributes:
        wrenches: `(N, k, 6)`.
        efforts: `(N,)`, `(N, d)` or None.
        holding: per held joint `(N,)`.
        moved: the motion.
    """

    wrenches: Array
    efforts: Array | None
    holding: dict[str, Array]
    moved: Motion

    def __len__(self) -> int:
        return len(self.wrenches)

    def wrench(self, number: int) -> Components:
        """Return the wrench of an output in its joint frame."""
        return Known(self.wrenches[:, number])

    def drive_effort(self) -> Array | None:
        """Return what the drive exerts, None if the outputs leave it out."""
        return self.efforts

    def holding_effort(self) -> dict[str, Array]:
        """Return what holds the held joints."""
        return self.holding

    def motion(self) -> Motion:
        """Return positions, speeds and accelerations."""
        return self.moved


@dataclass(frozen=True, eq=False)
class Sweep:
    """Joint wrenches, drive efforts and motion of a scene over N samples.

    `sweep["bearing_out"]` is the `JointWrench` of a joint in its own frame; `wrench(name, frame)`
    gives it in other axes. A sweep of a `Response` may have operating points in several
    dimensions: then `(N,)` stands for their shape.

    Attributes:
        mechanism: the mechanism.
        solver: what computed it, for placements.
        outputs: names of the joints whose wrenches are kept.
        source: where the arrays come from.
        unique: `(k, 6)` see `JointWrench.unique`.
        tooth_moment: coupling to the moment `(N,)` [N·m] that it exerts on its successor's joint.
        tooth_unique: coupling to whether its moment follows from the laws of motion alone.
        condition: `(N,)` condition number of the wrenches: that of the closure equations, times
            the greatest transmission ratio if that exceeds 1, times by how much inertial terms
            exceed what is left of them. Errors are some eps times it. One value, the greatest of
            its samples, if it comes from a `Response`.
        loop_residual: worst closure error: angle [rad], or gap as a fraction of
            `Mechanism.length`.
        balance_residual: worst Newton-Euler imbalance over all bodies, relative to the greatest
            wrench of all samples (to inertial terms where wrenches are mere rounding of them);
            nan if only the drive efforts were asked for.
        power_residual: worst imbalance of drive, load, weight and inertia power, relative to the
            power that flows and to the greatest wrench times the greatest joint speed;
            nan where the outputs leave part of that flow out.
    """

    mechanism: Mechanism
    solver: ReactionSolver
    outputs: tuple[str, ...]
    source: Source
    unique: Array
    tooth_moment: dict[str, Array]
    tooth_unique: dict[str, bool]
    condition: Array
    loop_residual: float
    balance_residual: float
    power_residual: float

    @cached_property
    def drive_effort(self) -> Array:
        """What the drive exerts `(N,)` [N·m or N], `(N, d)` for d drives.

        Raises:
            ModelError: the outputs of the scene leave it out.
        """
        effort = self.source.drive_effort()
        if effort is None:
            raise ModelError(
                "the drive effort was not asked for; add the driven joint to the outputs, which "
                f"are: {choices(self.outputs)}"
            )
        return effort

    @cached_property
    def holding_effort(self) -> dict[str, Array]:
        """Held joint to what holds it, `(N,)` [N·m or N]."""
        return self.source.holding_effort()

    @cached_property
    def motion(self) -> Motion:
        """Positions, speeds and accelerations of all joints."""
        return self.source.motion()

    def __len__(self) -> int:
        return len(self.source)

    def __getitem__(self, joint: str) -> JointWrench:
        return self.wrench(joint)

    def __repr__(self) -> str:
        return (
            f"<Sweep of {self.mechanism.name!r}: {len(self)} samples, "
            f"residuals: loop {self.loop_residual:.1e}, balance {self.balance_residual:.1e}, "
            f"power {self.power_residual:.1e}>"
        )

    def wrench(self, joint: str, frame: str = "joint") -> JointWrench:
        """Return the wrench exerted by a joint's parent on its child, at the joint origin.

        Args:
            joint: one of `outputs`.
            frame: axes of the components: `joint` turns with the child; `parent` stays with the
                parent link, which for an end bearing means fixed axes; `world`.

        Raises:
            ModelError: the joint is unknown or was not asked for.
            ArgumentError: unknown frame, or one that needs a sweep over one dimension.
        """
        if joint not in self.outputs:
            self.mechanism.joint(joint)
            raise ModelError(
                f"the wrench of {joint!r} was not asked for; outputs: {choices(self.outputs)}"
            )
        if frame not in FRAMES:
            raise ArgumentError(f"frame {frame!r} is unknown; frames: {choices(FRAMES)}")
        number = self.outputs.index(joint)
        record = self.mechanism.joints[joint]
        components = self.source.wrench(number)
        axis = record.axis
        if frame != "joint":
            force, moment = components.vectors(0), components.vectors(3)
            if force.ndim != 2:
                raise ArgumentError(
                    "only sweeps over one dimension turn wrenches into other axes, not those of "
                    f"shape {force.shape[:-1]}"
                )
            rotation = self._parent_rotation(joint) if frame == "parent" else self.rotation(joint)
            turned = [np.einsum("nij,nj->ni", rotation, part) for part in (force, moment)]
            components = Known(np.concatenate(turned, axis=1))
            if frame == "world" or record.type in ("spherical", "universal", "floating"):
                axis = rotation @ axis
        return JointWrench(joint, frame, components, axis, self.unique[number])

    def rotation(self, joint: str) -> Array:
        """Return rotations `(N, 3, 3)` that take components in a joint's frame to world axes."""
        return self._placement(joint)[0]

    def origin(self, joint: str) -> Array:
        """Return the origin of a joint's frame in the world `(N, 3)` [m]."""
        return self._placement(joint)[1]

    def _placement(self, joint: str) -> tuple[Array, Array]:
        record = self.mechanism.joint(joint)
        if record.parts:
            return self._body_placement(record.index - 1)
        loop = next(loop for loop in self.mechanism.loops if loop.joint == joint)
        frame = loop.successor_placement
        rotation, position = self._body_placement(loop.successor - 1)
        return rotation @ frame.rotation, position + rotation @ frame.translation

    def _body_placement(self, body: int) -> tuple[Array, Array]:
        """Return rotation `(N, 3, 3)` and position `(N, 3)` of a body (-1 for the world)."""
        if body < 0:
            return np.broadcast_to(np.eye(3), (len(self), 3, 3)), np.zeros((len(self), 3))
        group = self.solver.carrier(body)
        twin = self.solver.kinematics.solvers[group].twin
        if group not in self._actions:
            # Computed only here: most scripts never ask where a joint was.
            self._actions[group] = twin.actions(twin.configuration(self.motion.x))
        rotation, position = placement(self._actions[group], twin.local[body])
        return np.ascontiguousarray(rotation.transpose(2, 0, 1)), position.T + twin.origin

    def _parent_rotation(self, joint: str) -> Array:
        """Return rotations from a joint's own frame to its frame at coordinate zero."""
        record = self.mechanism.joints[joint]
        if not record.parts:
            return np.broadcast_to(np.eye(3), (len(self), 3, 3))
        model, first = self.mechanism.model, record.parts[0].index
        at_zero = model.jointPlacements[first].rotation
        at_zero = self._body_placement(model.parents[first] - 1)[0] @ at_zero
        return np.asarray(np.swapaxes(at_zero, -1, -2) @ self.rotation(joint))

    @cached_property
    def _actions(self) -> dict[int, Array]:
        return {}
