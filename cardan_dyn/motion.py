"""Motion: positions, speeds and accelerations of all joints. It exists only with loops closed."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from .checks import described
from .coordinates import Array, Coordinates
from .errors import ArgumentError, ModelError, choices
from .frozen import read_only
from .mechanism import Mechanism


@dataclass(frozen=True, eq=False)
class Motion:
    """The motion of every joint over the samples of a sweep; its arrays cannot be written to.

    Attributes:
        mechanism: the mechanism that moves.
        coordinates: layout of `x`.
        x: `(N, size)` coordinates with closed loops; passive angles within one period.
        turns: `(N, size)` whole turns to be added to the angles in `x`.
        v: joint velocities `(N, nv)` [rad/s, m/s], in Pinocchio's layout.
        a: joint accelerations `(N, nv)` [rad/s², m/s²].
        transmission: `(N, nv, d)` joint velocities per unit speed of each drive.
        drives: names of the drives, where they are known.
    """

    mechanism: Mechanism
    coordinates: Coordinates
    x: Array
    turns: Array
    v: Array
    a: Array
    transmission: Array
    drives: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in ("x", "turns", "v", "a", "transmission"):
            # A view, since what has computed the array may have use for it yet.
            object.__setattr__(self, name, read_only(np.asarray(getattr(self, name)).view()))

    def __reduce__(self) -> tuple[object, ...]:
        # Through the constructor, which closes the arrays of a copy as well.
        return Motion, tuple(getattr(self, field.name) for field in fields(self))

    @property
    def q(self) -> Array:
        """Configurations `(N, nq)` of `Mechanism.model`, as Pinocchio's functions take them."""
        return self.coordinates.configuration(self.x)

    def position(self, joint: str) -> Array:
        """Return a joint's coordinate `(N,)` [rad or m], continuous over any number of turns.

        Joints with several coordinates give them as columns, from the parent outwards:
        `cylindrical` slide and angle; `planar` two slides and angle; `universal` both angles;
        `spherical` a unit quaternion (x, y, z, w); `floating` three slides and a quaternion.

        Raises:
            ModelError: unknown joint.
        """
        columns = self.coordinates.columns[self._moving(joint)]
        values = self.x[:, columns] + 2.0 * np.pi * self.turns[:, columns]
        return values[:, 0] if values.shape[1] == 1 else values

    def velocity(self, joint: str) -> Array:
        """Return a joint's velocity `(N,)` [rad/s or m/s], a column per coordinate."""
        return _squeezed(self.v[:, self.coordinates.velocities[self._moving(joint)]])

    def acceleration(self, joint: str) -> Array:
        """Return a joint's acceleration `(N,)` [rad/s² or m/s²], a column per coordinate."""
        return _squeezed(self.a[:, self.coordinates.velocities[self._moving(joint)]])

    def ratio(self, joint: str, drive: int | str = 0) -> Array:
        """Return a joint's transmission ratio `(N,)`: its velocity per unit drive velocity.

        Args:
            joint: name of the joint.
            drive: name of the drive, or its number in `Scene.drives`.

        Raises:
            ModelError: unknown joint.
            ArgumentError: unknown drive.
        """
        columns = self.coordinates.velocities[self._moving(joint)]
        return _squeezed(self.transmission[:, columns, self._number(drive)])

    def _number(self, drive: object) -> int:
        """Return the number of a drive that is given by number or name."""
        count = self.transmission.shape[2]
        if isinstance(drive, str) and drive in self.drives:
            return self.drives.index(drive)
        if isinstance(drive, (int, np.integer)) and not isinstance(drive, (bool, np.timedelta64)):
            number = int(drive)
            if 0 <= number < count:
                return number
        listed = [f"{number} ({name})" for number, name in enumerate(self.drives)]
        known = ", ".join(listed or map(str, range(count)))
        raise ArgumentError(f"no drive {described(drive)}; drives: {known}")

    def _moving(self, joint: str) -> str:
        name = self.mechanism.joint(joint).name
        if name not in self.coordinates.columns:
            raise ModelError(
                f"joint {name!r} is fixed and has no coordinate; joints that have one: "
                f"{choices(self.coordinates.columns)}"
            )
        return name


def _squeezed(values: Array) -> Array:
    return values[:, 0] if values.shape[1] == 1 else values
