"""Motion: positions, speeds and accelerations of all joints, with all loops closed."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TypeAlias

import numpy as np

from ...kit.arrays import Array, squeezed
from ...kit.checks import described
from ...kit.errors import ArgumentError, ModelError, choices
from ...kit.frozen import Frozen, read_only
from ..dynamics.velocity_ratios import VelocityRatios
from ..mechanism.coordinates import Coordinates
from ..mechanism.mechanism import Mechanism

Rates: TypeAlias = tuple[Array, Array, VelocityRatios]
"""Velocities and accelerations `(N, nv)` of all joints, and their velocity ratios."""


class Motion(Frozen):
    """The motion of every joint over the samples of a sweep; its arrays cannot be written to.

    Where the samples have several dimensions, `(N,)` stands for their shape.

    Attributes:
        mechanism: the mechanism that moves.
        drives: names of the drives.
        shape: of the samples.
    """

    mechanism: Mechanism
    drives: tuple[str, ...]
    shape: tuple[int, ...]
    _x: Array
    _turns: Array
    _coordinates: Coordinates
    _given: Rates | Callable[[], Rates]

    def __init__(
        self,
        mechanism: Mechanism,
        drives: tuple[str, ...],
        x: Array,
        turns: Array,
        rates: Rates | Callable[[], Rates],
        shape: tuple[int, ...] | None = None,
    ) -> None:
        """Keep a motion.

        Args:
            mechanism: the mechanism that moves.
            drives: names of the drives.
            x: `(N, size)` coordinates with closed loops.
            turns: `(N, size)` whole turns to be added to the angles in `x`.
            rates: of all samples; or what returns them, called once they are asked for.
            shape: of the samples, N in all; `(N,)` if None.
        """
        shape = (len(x),) if shape is None else shape
        self._freeze(
            mechanism=mechanism,
            drives=drives,
            _coordinates=mechanism.coordinates,
            _given=rates,
            shape=shape,
            # Views, since the arrays themselves may still be written to where they were computed.
            _x=read_only(x.view()),
            _turns=read_only(turns.view()),
        )

    def __reduce__(self) -> tuple[object, ...]:
        # Through the constructor, which closes the arrays of a copy to writing as well.
        arrays = self._x, self._turns, self._rates
        return Motion, (self.mechanism, self.drives, *arrays, self.shape)

    def __len__(self) -> int:
        """Return the number of samples, along the first of several dimensions."""
        return self.shape[0]

    @property
    def x(self) -> Array:
        """Coordinates `(N, size)` with closed loops, of all samples in one dimension.

        Angles that are not driven lie between -π and π, see `turns`. Columns as in `Coordinates`.
        """
        return self._without_turns[0]

    @property
    def turns(self) -> Array:
        """Whole turns `(N, size)` that the angles in `x` lack."""
        return self._without_turns[1]

    @cached_property
    def _without_turns(self) -> tuple[Array, Array]:
        # Over how many turns a motion was followed before it repeated, nobody asked.
        angles, named = self._coordinates.angle_columns, self._coordinates.named
        driven = {named[name].column for name in self.drives}
        own = [column for column in angles.tolist() if column not in driven]
        taken = np.rint(self._x[:, own] / (2.0 * np.pi))
        if not np.count_nonzero(taken):
            return self._x, self._turns
        x, turns = self._x.copy(), self._turns.copy()
        x[:, own] -= 2.0 * np.pi * taken
        turns[:, own] += taken
        return read_only(x), read_only(turns)

    @cached_property
    def _rates(self) -> Rates:
        return self._given() if callable(self._given) else self._given

    @cached_property
    def v(self) -> Array:
        """Joint velocities `(N, nv)` [rad/s, m/s], in Pinocchio's layout."""
        return read_only(self._shaped(self._rates[0]))

    @cached_property
    def a(self) -> Array:
        """Joint accelerations `(N, nv)` [rad/s², m/s²], in Pinocchio's layout."""
        return read_only(self._shaped(self._rates[1]))

    @property
    def velocity_ratios(self) -> VelocityRatios:
        """Velocities of all joints per unit speed of each drive, see `ratio`."""
        return self._rates[2]

    def _shaped(self, values: Array) -> Array:
        """Return values `(N, ...)` in the shape of the samples."""
        return np.asarray(values).reshape(*self.shape, *values.shape[1:])

    def joint_placement(self, joint: str) -> tuple[Array, Array]:
        """Return rotations `(N, 3, 3)` and origins `(N, 3)` [m] of a joint's frame in the world.

        They are NaN where the motion of the joint was not solved.

        Raises:
            ModelError: unknown joint.
        """
        name = self.mechanism.joint(joint).name
        frames = self.mechanism.frames
        rotation, origin = frames.joint(self._x, frames.joints.index(name))
        return self._shaped(rotation), self._shaped(origin)

    def joint_turn(self, joint: str) -> Array:
        """Return rotations `(N, 3, 3)` from a joint's frame to its frame at coordinate zero.

        The latter stays with the parent. They are NaN where its motion was not solved.

        Raises:
            ModelError: unknown joint.
        """
        name = self.mechanism.joint(joint).name
        frames = self.mechanism.frames
        return self._shaped(frames.turned(self._x, frames.joints.index(name)))

    @property
    def rows(self) -> Array:
        """Coordinates of all samples `(N, size)`, whole turns counted; see `Coordinates`."""
        return np.asarray(self._x + 2.0 * np.pi * self._turns)

    @property
    def q(self) -> Array:
        """Configurations `(N, nq)` of `Mechanism.model`, as Pinocchio's functions take them.

        Of angles that are not driven, any whole turns may be missing: `position` counts them.
        """
        return self._shaped(self._coordinates.configuration(self._x))

    def position(self, joint: str) -> Array:
        """Return a joint's coordinate `(N,)` [rad or m], continuous over any number of turns.

        Joints with several coordinates give them as columns, from the parent outwards:
        `cylindrical` slide and angle; `planar` two slides and angle; `universal` both angles;
        `spherical` a unit quaternion (x, y, z, w); `floating` three slides and a quaternion.
        Instead of a quaternion there are three Cardan angles if the scene names one of them.

        Args:
            joint: name of a joint, or of a coordinate as in `Mechanism.drivable`.

        Raises:
            ModelError: unknown joint, one without a coordinate, or a Cardan angle of a ball that
                was solved without such angles.
        """
        columns, _ = self.spans(joint)
        values = self._x[:, columns] + 2.0 * np.pi * self._turns[:, columns]
        return self._shaped(squeezed(values))

    @property
    def of_named(self) -> tuple[Array, Array, Array]:
        """Positions, velocities and accelerations `(N, n)` of all coordinates that have names."""
        named = self._coordinates.named.values()
        columns, rates = [item.column for item in named], [item.rate for item in named]
        values = self._x[:, columns] + 2.0 * np.pi * self._turns[:, columns]
        return self._shaped(values), self.v[..., rates], self.a[..., rates]

    def velocity(self, joint: str) -> Array:
        """Return a joint's velocity `(N,)` [rad/s or m/s], a column per coordinate.

        Args:
            joint: see `position`.

        Raises:
            ModelError: see `position`.
        """
        return self._of_columns(self.v, joint)

    def acceleration(self, joint: str) -> Array:
        """Return a joint's acceleration `(N,)` [rad/s² or m/s²], a column per coordinate.

        Args:
            joint: see `position`.

        Raises:
            ModelError: see `position`.
        """
        return self._of_columns(self.a, joint)

    def ratio(self, joint: str, drive: int | str = 0) -> Array:
        """Return a joint's velocity ratio `(N,)`: its velocity per unit drive velocity.

        Args:
            joint: see `position`.
            drive: name of the drive, or its index in `Scene.drives`.

        Raises:
            ModelError: see `position`.
            ArgumentError: unknown drive.
        """
        _, columns = self.spans(joint)
        ratios = self.velocity_ratios.of_coordinates(columns, self._drive_index(drive))
        return self._shaped(squeezed(ratios))

    def _all_ratios(self, drive: int | str = 0) -> Array:
        """Return the velocity ratios `(N, nv)` of all velocity coordinates, see `ratio`.

        Raises:
            ArgumentError: unknown drive.
        """
        columns = slice(0, len(self._coordinates.rate_scale))
        return self.velocity_ratios.of_coordinates(columns, self._drive_index(drive))

    def _of_columns(self, rates: Array, joint: str) -> Array:
        """Return the columns of rates that belong to a joint, without an axis for one column."""
        columns = rates[..., self.spans(joint)[1]]
        return columns[..., 0] if columns.shape[-1] == 1 else columns

    def _drive_index(self, drive: object) -> int:
        """Return the index of a drive that is given by index or name."""
        count = self.velocity_ratios.drives
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

    def spans(self, name: str) -> tuple[slice, slice]:
        """Return the columns of a joint or coordinate, in coordinates and in velocities."""
        coordinates, drivable = self._coordinates, self.mechanism.drivable
        if isinstance(name, str) and name in drivable and name not in self.mechanism:
            if name not in coordinates.named:
                raise ModelError(
                    f"{name!r} is a Cardan angle, but {drivable[name].joint!r} was solved as a "
                    "ball; a scene that drives, holds, starts or loads one of its coordinates by "
                    "name has them all",
                    name=name,
                )
            scalar = coordinates.named[name]
            return slice(scalar.column, scalar.column + 1), slice(scalar.rate, scalar.rate + 1)
        joint = self._moving(name)
        return coordinates.columns[joint], coordinates.velocity_columns[joint]

    def _moving(self, joint: str) -> str:
        """Return the name of a joint that has a coordinate."""
        name = self.mechanism.joint(joint).name
        if name not in self._coordinates.columns:
            raise ModelError(
                f"joint {name!r} is fixed and has no coordinate; joints that have one: "
                f"{choices(self._coordinates.columns)}"
            )
        return name
