"""Sweep: the result of a scene over given positions, with the residuals that prove it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .errors import ArgumentError, ModelError, choices
from .mechanism import Mechanism
from .motion import Motion
from .twin import Array, Twin, placement
from .wrench import JointWrench

FRAMES = ("joint", "parent", "world")


@dataclass(frozen=True)
class Sweep:
    """Joint wrenches, drive efforts and motion of a scene over N samples.

    `sweep["bearing_out"]` is the `JointWrench` of a joint in its own frame; `wrench(name, frame)`
    gives it in other axes.

    Attributes:
        mechanism: the mechanism.
        twin: its free-flyer twin, for placements.
        outputs: names of the joints whose wrenches are kept.
        wrenches: `(N, k, 6)` force [N] and moment [N·m] of the outputs in their joint frames.
        unique: `(k, 6)` see `JointWrench.unique`.
        drive_effort: `(N,)` what the drive exerts [N·m or N], `(N, d)` for d drives.
        holding_effort: held joint to what holds it, `(N,)` [N·m or N].
        motion: positions, speeds and accelerations of all joints.
        condition: `(N,)` condition number of the closure equations.
        loop_residual: worst closure error: angle [rad], or gap as a fraction of
            `Mechanism.length`.
        balance_residual: worst Newton-Euler imbalance over all bodies, relative to the greatest
            wrench of the same sample.
        power_residual: worst imbalance of drive, load, weight and inertia power, relative to the
            power that flows and to the greatest wrench times the greatest joint speed.
    """

    mechanism: Mechanism
    twin: Twin
    outputs: tuple[str, ...]
    wrenches: Array
    unique: Array
    drive_effort: Array
    holding_effort: dict[str, Array]
    motion: Motion
    condition: Array
    loop_residual: float
    balance_residual: float
    power_residual: float

    def __len__(self) -> int:
        return len(self.wrenches)

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
            ArgumentError: unknown frame.
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
        force, moment = self.wrenches[:, number, :3], self.wrenches[:, number, 3:]
        axis = record.axis
        if frame != "joint":
            rotation = self._parent_rotation(joint) if frame == "parent" else self.rotation(joint)
            force, moment = (np.einsum("nij,nj->ni", rotation, part) for part in (force, moment))
            if frame == "world" or record.type in ("spherical", "universal", "floating"):
                axis = rotation @ axis
        return JointWrench(joint, frame, force, moment, axis, self.unique[number])

    def rotation(self, joint: str) -> Array:
        """Return rotations `(N, 3, 3)` that take components in a joint's frame to world axes."""
        record = self.mechanism.joint(joint)
        if record.index:
            rotation, _ = placement(self._actions, record.index - 1)
            return np.ascontiguousarray(rotation.transpose(2, 0, 1))
        loop = next(loop for loop in self.mechanism.loops if loop.joint == joint)
        if loop.successor == 0:
            return np.broadcast_to(loop.successor_placement.rotation, (len(self), 3, 3))
        rotation, _ = placement(self._actions, loop.successor - 1)
        return np.einsum("ikn,kj->nij", rotation, loop.successor_placement.rotation)

    def origin(self, joint: str) -> Array:
        """Return the origin of a joint's frame in the world `(N, 3)` [m]."""
        record = self.mechanism.joint(joint)
        loop = next((loop for loop in self.mechanism.loops if loop.joint == joint), None)
        if record.index:
            return placement(self._actions, record.index - 1)[1].T + self.twin.origin
        assert loop is not None
        if loop.successor == 0:
            return np.broadcast_to(loop.successor_placement.translation, (len(self), 3))
        rotation, position = placement(self._actions, loop.successor - 1)
        point = position.T + np.einsum("ikn,k->ni", rotation, loop.successor_placement.translation)
        return np.asarray(point + self.twin.origin)

    def _parent_rotation(self, joint: str) -> Array:
        """Return rotations from a joint's own frame to its frame at coordinate zero."""
        record = self.mechanism.joints[joint]
        if not record.parts:
            return np.broadcast_to(np.eye(3), (len(self), 3, 3))
        model, first = self.mechanism.model, record.parts[0].index
        at_zero = model.jointPlacements[first].rotation
        if model.parents[first]:
            parent, _ = placement(self._actions, model.parents[first] - 1)
            at_zero = np.einsum("ikn,kj->nij", parent, at_zero)
        return np.asarray(np.swapaxes(at_zero, -1, -2) @ self.rotation(joint))

    @cached_property
    def _actions(self) -> Array:
        # Kept out of the sweep itself: most scripts never ask where a joint was.
        return self.twin.actions(self.motion.coordinates.twin_configuration(self.motion.x))
