"""Point motion: where points of links are during a motion, and how they move."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ...kit.arrays import Array
from ...kit.checks import described, vector
from ...kit.errors import ArgumentError, ModelError
from ...kit.frozen import Frozen, read_only
from ..mechanism.carried import CarriedFrame, Rates
from .result import Result
from .table import Table, Variable

if TYPE_CHECKING:
    from typing import TypeAlias

    from numpy.typing import ArrayLike

    from .plot import Plot

    Points: TypeAlias = "Iterable[str] | Mapping[str, str | tuple[str, ArrayLike] | PointMotion]"
    """Links, or names to links, `(link, xyz)` or what `point` returned."""


_QUANTITIES = {
    "position": ("m", "position of the point"),
    "velocity": ("m/s", "velocity of the point"),
    "acceleration": ("m/s²", "acceleration of the point"),
    "angular_velocity": ("rad/s", "angular velocity of its link"),
    "angular_acceleration": ("rad/s²", "angular acceleration of its link"),
}
_ORIGIN = (0.0, 0.0, 0.0)


class PointMotion(Frozen, Result):
    """Where a point of a link is and how it moves, in world axes; `Sweep.point` makes it.

    `position, velocity, acceleration = sweep.point("coupler")` takes it apart. Where the drives of
    a sweep are at rest, so is the point; `ratio` tells how far it moves per unit of the drive. As a
    table, its columns are `coupler.position_x` and so on, over drive positions or times. Points of
    a rod that may spin about its line are where `Sweep.idle_rods` says. `(N,)` stands for the shape
    of the samples. Nothing in it can be changed.

    Attributes:
        link: name of the link, or of a frame that is fixed in one.
        xyz: `(3,)` the point, from the origin of that and in its axes [m].
    """

    def __init__(self, moving: Any, link: str, xyz: ArrayLike = _ORIGIN) -> None:
        """Find where the point is.

        Args:
            moving: the sweep or the trajectory, see `MotionResult`.
            link: see the attribute.
            xyz: likewise.

        Raises:
            ModelError: unknown link, or the outputs leave its motion out.
            ArgumentError: `xyz` is no `(3,)` of finite numbers.
        """
        point = read_only(vector("xyz", xyz, 3))
        carrier = CarriedFrame(moving.mechanism, link, point)
        rotation, position = carrier.placed(moving.joint_coordinates)
        if not np.all(np.isfinite(position)):
            raise ModelError(
                f"the outputs of the scene leave out what moves {link!r}; name a joint of it among "
                "the outputs",
                name=link,
            )
        self.link, self.xyz = carrier.name, point
        self._moving, self._carrier = moving, carrier
        self._rotation, self._position = self._shaped(rotation), self._shaped(position)
        self._freeze()

    def __reduce__(self) -> tuple[object, ...]:
        return PointMotion, (self._moving, self.link, self.xyz)

    def __iter__(self) -> Any:
        """Iterate over position, velocity and acceleration."""
        return iter((self.position, self.velocity, self.acceleration))

    def __repr__(self) -> str:
        shape = " × ".join(map(str, self.shape))
        at = f"({', '.join(f'{value:g}' for value in self.xyz)})"
        return f"<PointMotion of {self.link!r} at {at} m: {shape} samples, world axes>"

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the samples."""
        return self._moving.shape

    @property
    def position(self) -> Array:
        """Where the point is `(N, 3)` [m]."""
        return self._position

    @property
    def orientation(self) -> Array:
        """Rotations `(N, 3, 3)` that take components in the link's axes to world axes."""
        return self._rotation

    @cached_property
    def velocity(self) -> Array:
        """Velocity of the point `(N, 3)` [m/s]."""
        return self._shaped(self._twist.velocity.T)

    @cached_property
    def acceleration(self) -> Array:
        """Acceleration of the point `(N, 3)` [m/s²]."""
        return self._shaped(self._rates.acceleration.T)

    @cached_property
    def angular_velocity(self) -> Array:
        """Angular velocity of the link `(N, 3)` [rad/s]."""
        return self._shaped(self._twist.spin.T)

    @cached_property
    def angular_acceleration(self) -> Array:
        """Angular acceleration of the link `(N, 3)` [rad/s²]."""
        return self._shaped(self._rates.spin_rate.T)

    @property
    def plot(self) -> Plot:
        """Figures of its columns: `point.plot("coupler.position_y", x="coupler.position_x")`."""
        from .plot import Plot  # Imported here: few scripts draw.

        plot = Plot(self)
        plot.first = tuple(f"{self.link}.position_{axis}" for axis in "xyz")
        return plot

    def ratio(self, drive: int | str = 0) -> Array:
        """Return the velocity of the point per unit velocity of a drive `(N, 3)` [m/rad, m/m].

        Args:
            drive: name of the drive, or its index in `Scene.drives`; the others rest.

        Raises:
            ArgumentError: unknown drive.
        """
        ratios = self._moving.motion._all_ratios(drive)
        x = self._moving.joint_coordinates
        return self._shaped(self._carrier.rates(x, ratios).velocity.T)

    @cached_property
    def _rates(self) -> Rates:
        of = self._moving
        return self._carrier.rates(
            of.joint_coordinates, of.joint_velocities, of.joint_accelerations
        )

    @cached_property
    def _twist(self) -> Rates:
        # Of simulations, accelerations cost inverse dynamics.
        if "_rates" in self.__dict__:
            return self._rates
        return self._carrier.rates(self._moving.joint_coordinates, self._moving.joint_velocities)

    def _shaped(self, values: Array) -> Array:
        return read_only(np.ascontiguousarray(values).reshape(*self.shape, *values.shape[1:]))

    def table(self) -> Table:
        """Return its motion as a table over drive positions or times."""
        return with_points(self._moving.given(), self._moving, {self.link: self})


def with_points(table: Table, moving: Any, points: Points) -> Table:
    """Return a table with the motions of some points besides.

    Args:
        table: of the same samples.
        moving: what moves them.
        points: see `MotionResult.to_dataframe`.

    Raises:
        ModelError, ArgumentError: see `PointMotion`.
    """
    found = motions_of(moving, points)
    if not found:
        return table
    dims = (*table.samples, "point", "component")
    variables = [
        (
            f"point_{name}",
            Variable(
                dims,
                np.stack([getattr(point, name) for point in found.values()], axis=-2),
                unit,
                f"{label}, in world axes",
            ),
        )
        for name, (unit, label) in _QUANTITIES.items()
    ]
    labels = {**table.labels, "point": tuple(found), "component": ("x", "y", "z")}
    return replace(table, variables=[*table.variables, *variables], labels=labels)


def motions_of(moving: Any, points: Points) -> dict[str, PointMotion]:
    """Return the motions of points by their names; arguments and errors of `with_points`."""
    if isinstance(points, str):
        points = [points]
    named = points if isinstance(points, Mapping) else {name: name for name in points}
    found = {}
    for name, place in named.items():
        if isinstance(place, PointMotion):
            if place.shape != moving.shape:
                raise ArgumentError(
                    f"point {name!r} has the samples {place.shape}, expected {moving.shape}: take "
                    "it of the same result"
                )
            found[name] = place
        elif isinstance(place, str):
            found[name] = PointMotion(moving, place)
        elif isinstance(place, (tuple, list)) and len(place) == 2:
            found[name] = PointMotion(moving, place[0], place[1])
        else:
            raise ArgumentError(
                f"point {name!r} is {described(place)}, expected the name of a link, or "
                "(link, (x, y, z))"
            )
    return found
