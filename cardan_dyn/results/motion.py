"""Motion: positions, speeds and accelerations of all joints, with all loops closed."""

from __future__ import annotations

import numpy as np

from ..arrays import Array, squeezed
from ..checks import described
from ..errors import ArgumentError, ModelError, choices
from ..frozen import Frozen, read_only
from ..mechanism.mechanism import Mechanism


class Motion(Frozen):
    """The motion of every joint over the samples of a sweep; its arrays cannot be written to.

    Attributes:
        mechanism: the mechanism that moves.
        drives: names of the drives.
        v: joint velocities `(N, nv)` [rad/s, m/s], in Pinocchio's layout.
        a: joint accelerations `(N, nv)` [rad/s², m/s²].
    """

    def __init__(
        self,
        mechanism: Mechanism,
        drives: tuple[str, ...],
        x: Array,
        turns: Array,
        v: Array,
        a: Array,
        velocity_ratios: Array,
    ) -> None:
        """Keep a motion.

        Args:
            mechanism: the mechanism that moves.
            drives: names of the drives.
            x: `(N, size)` coordinates with closed loops; passive angles within one period.
            turns: `(N, size)` whole turns to be added to the angles in `x`.
            v: joint velocities `(N, nv)`.
            a: joint accelerations `(N, nv)`.
            velocity_ratios: `(N, nv, d)` joint velocities per unit speed of each drive.
        """
        self.mechanism = mechanism
        self.drives = drives
        self._coordinates = mechanism.coordinates
        # Views, since the arrays themselves may still be written to where they were computed.
        self._x, self._turns, self.v, self.a, self._velocity_ratios = (
            read_only(np.asarray(array).view()) for array in (x, turns, v, a, velocity_ratios)
        )
        self._freeze()

    def __reduce__(self) -> tuple[object, ...]:
        # Through the constructor, which closes the arrays of a copy to writing as well.
        arrays = (self._x, self._turns, self.v, self.a, self._velocity_ratios)
        return Motion, (self.mechanism, self.drives, *arrays)

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.v)

    def joint_placement(self, joint: str) -> tuple[Array, Array]:
        """Return rotations `(N, 3, 3)` and origins `(N, 3)` [m] of a joint's frame in the world.

        They are NaN where the motion of the joint was not solved.

        Raises:
            ModelError: unknown joint.
        """
        name = self.mechanism.joint(joint).name
        frames = self.mechanism.frames
        return frames.joint(self._x, frames.joints.index(name))

    @property
    def q(self) -> Array:
        """Configurations `(N, nq)` of `Mechanism.model`, as Pinocchio's functions take them."""
        return self._coordinates.configuration(self._x)

    def position(self, joint: str) -> Array:
        """Return a joint's coordinate `(N,)` [rad or m], continuous over any number of turns.

        Joints with several coordinates give them as columns, from the parent outwards:
        `cylindrical` slide and angle; `planar` two slides and angle; `universal` both angles;
        `spherical` a unit quaternion (x, y, z, w); `floating` three slides and a quaternion.

        Raises:
            ModelError: unknown joint, or one without a coordinate.
        """
        columns = self._coordinates.columns[self._moving(joint)]
        values = self._x[:, columns] + 2.0 * np.pi * self._turns[:, columns]
        return squeezed(values)

    def velocity(self, joint: str) -> Array:
        """Return a joint's velocity `(N,)` [rad/s or m/s], a column per coordinate.

        Raises:
            ModelError: unknown joint, or one without a coordinate.
        """
        return squeezed(self.v[:, self._coordinates.velocity_columns[self._moving(joint)]])

    def acceleration(self, joint: str) -> Array:
        """Return a joint's acceleration `(N,)` [rad/s² or m/s²], a column per coordinate.

        Raises:
            ModelError: unknown joint, or one without a coordinate.
        """
        return squeezed(self.a[:, self._coordinates.velocity_columns[self._moving(joint)]])

    def ratio(self, joint: str, drive: int | str = 0) -> Array:
        """Return a joint's velocity ratio `(N,)`: its velocity per unit drive velocity.

        Args:
            joint: name of the joint.
            drive: name of the drive, or its index in `Scene.drives`.

        Raises:
            ModelError: unknown joint, or one without a coordinate.
            ArgumentError: unknown drive.
        """
        columns = self._coordinates.velocity_columns[self._moving(joint)]
        return squeezed(self._velocity_ratios[:, columns, self._drive_index(drive)])

    def _drive_index(self, drive: object) -> int:
        """Return the index of a drive that is given by index or name.

        Raises:
            ArgumentError: unknown drive.
        """
        count = self._velocity_ratios.shape[2]
        if isinstance(drive, str) and drive in self.drives:
            return self.drives.index(drive)
        # NumPy's durations are a subclass of its integers.
        if isinstance(drive, (int, np.integer)) and not isinstance(drive, (bool, np.timedelta64)):
            index = int(drive)
            if 0 <= index < count:
                return index
        listed = [f"{index} ({name})" for index, name in enumerate(self.drives)]
        known = ", ".join(listed or map(str, range(count)))
        # The suggestion alone is wanted of the names, which are listed with their indices.
        _, _, suggestion = choices(self.drives, drive).partition(" (")
        known += f" ({suggestion}" if suggestion else ""
        raise ArgumentError(f"no drive {described(drive)}; drives: {known}")

    def _moving(self, joint: str) -> str:
        """Return the name of a joint that has a coordinate.

        Raises:
            ModelError: unknown joint, or one without a coordinate.
        """
        name = self.mechanism.joint(joint).name
        if name not in self._coordinates.columns:
            raise ModelError(
                f"joint {name!r} is fixed and has no coordinate; joints that have one: "
                f"{choices(self._coordinates.columns)}"
            )
        return name
