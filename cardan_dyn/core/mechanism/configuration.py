"""Configuration: where all joints of a mechanism are while its loops are closed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ...kit.arrays import Array
from ...kit.checks import vector
from ...kit.errors import ModelError, choices
from ...kit.frozen import Frozen, frozen, read_only

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .mechanism import Mechanism


class Configuration(Frozen, Mapping[str, "float | Array"]):
    """A closed configuration of a mechanism; `cardan_dyn.assemble` and `Scene.configuration`.

    A mapping of its joints to their `positions`: `configuration["crank"]`. What takes positions by
    name takes it: `near`, `position` of simulations, `at` of `cd.write`.
    `cd.view(configuration)` shows it, `cd.describe(configuration)` describes the mechanism there.

    Attributes:
        mechanism: the mechanism.
        branch: name of the assembly mode, see `Scene.branches`; None where nothing is driven, so
            that there are no modes.
        loop_residual: greatest angle [rad], or gap as a fraction of the characteristic length,
            between the two ends of a loop.
        zero_residual: the same at the description's zero.
        x: `(size,)` coordinates, see `mechanism.coordinates`.
        positions: joint to its position [rad or m]; an array for joints of several coordinates, see
            `Motion.position`: a ball has a unit quaternion, or three angles if one of them was
            named.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        x: Array,
        loop_residual: float,
        zero_residual: float,
        branch: str | None = None,
    ) -> None:
        """Keep a configuration.

        Args:
            mechanism: the mechanism.
            x: `(size,)` coordinates of all joints.
            loop_residual: see the attribute.
            zero_residual: likewise.
            branch: likewise.
        """
        self.mechanism = mechanism
        self.loop_residual = loop_residual
        self.zero_residual = zero_residual
        self.branch = branch
        self.x = read_only(np.array(x, dtype=float))
        self.positions = frozen(
            {
                name: read_only(self.x[columns]) if mechanism.joints[name].nv > 1 else float(value)
                for name, columns in mechanism.coordinates.columns.items()
                for value in [self.x[columns.start]]
            }
        )
        self._freeze()

    def __reduce__(self) -> tuple[object, ...]:
        # Through the constructor, which closes the arrays of a copy to writing as well.
        given = (self.mechanism, self.x, self.loop_residual, self.zero_residual, self.branch)
        return Configuration, given

    def __getitem__(self, joint: str) -> float | Array:
        if joint not in self.positions:
            name = self.mechanism.joint(joint).name
            raise ModelError(
                f"joint {name!r} is fixed, it has no position; joints that move: "
                f"{choices(self.positions)}",
                name=name,
            )
        return self.positions[joint]

    def get(self, joint: str, default: Any = None) -> Any:
        """Return the position of a joint, or something else if it has none."""
        return self.positions.get(joint, default)

    def __contains__(self, joint: object) -> bool:
        return joint in self.positions

    def __iter__(self) -> Iterator[str]:
        return iter(self.positions)

    def __len__(self) -> int:
        return len(self.positions)

    # Arrays among the positions cannot be compared as those of a mapping would be.
    __eq__, __hash__ = object.__eq__, object.__hash__

    @cached_property
    def q(self) -> Array:
        """Pinocchio's configuration `(nq,)` of `Mechanism.model`."""
        return read_only(self.mechanism.coordinates.configuration(self.x[None, :])[0])

    def origin(self, joint: str) -> Array:
        """Return the origin of a joint's frame in the world `(3,)` [m].

        Raises:
            ModelError: unknown joint.
        """
        return self._placement(joint)[1][0]

    def rotation(self, joint: str) -> Array:
        """Return the rotation `(3, 3)` that takes components in a joint's frame to world axes.

        Raises:
            ModelError: unknown joint.
        """
        return self._placement(joint)[0][0]

    def point(self, link: str, xyz: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
        """Return where a point of a link is in the world `(3,)` [m].

        Args:
            link: name of a link; or else of a `fixed` joint, of a site of MJCF or a frame of SDF,
                which move with their link.
            xyz: `(3,)` the point, from the origin of that and in its axes [m].

        Raises:
            ModelError: unknown link.
            ArgumentError: `xyz` is no `(3,)` of finite numbers.
        """
        return self._carried(link, vector("xyz", xyz, 3))[1]

    def orientation(self, link: str) -> Array:
        """Return the rotation `(3, 3)` that takes components in a link's axes to world axes.

        Args:
            link: see `point`.

        Raises:
            ModelError: unknown link.
        """
        return self._carried(link, np.zeros(3))[0]

    def _carried(self, link: str, xyz: Array) -> tuple[Array, Array]:
        from .carried import CarriedFrame  # Imported here: few ask configurations for points.

        rotation, point = CarriedFrame(self.mechanism, link, xyz).placed(self.x[None, :])
        return read_only(rotation[0]), read_only(point[0])

    def _placement(self, joint: str) -> tuple[Array, Array]:
        name, frames = self.mechanism.joint(joint).name, self.mechanism.frames
        return frames.joint(self.x[None, :], frames.joints.index(name))

    def __repr__(self) -> str:
        branch = "" if self.branch is None else f" in branch {self.branch}"
        return (
            f"<Configuration of {self.mechanism.name!r}{branch}: closed to "
            f"{self.loop_residual:.1e} (at zero {self.zero_residual:.1e})>"
        )

    def __str__(self) -> str:
        width = max(map(len, self.positions), default=0)
        rows = [f"  {name.ljust(width)}  {_shown(value)}" for name, value in self.positions.items()]
        return "\n".join([repr(self)[1:-1], *rows])


def _shown(value: float | Array) -> str:
    # Adding zero removes the sign of negative zeros.
    return ", ".join(f"{number + 0.0:.6g}" for number in np.atleast_1d(value))
