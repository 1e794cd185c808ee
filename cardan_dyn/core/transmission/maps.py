"""Maps: what a transmission says of positions, rates and efforts, whoever computes both ways."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from ...kit.arrays import Array
from ...kit.checks import positives
from ...kit.errors import ArgumentError, choices, hinting
from ...kit.frozen import Frozen
from .way import Mapped, Way

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

_ASKED = {
    "acceleration accelerations": "joints accelerate by jacobian times acceleration of the "
    "actuated, and jacobian_rate times their speed",
    "gravity loads load elements": "efforts are those of motors alone, at rest; a sweep of the "
    "scene has all that acts",
    "velocity speeds v qd": "speeds are speed=... [rad/s or m/s]",
    "torque torques force forces efforts tau": "efforts are effort=... [N·m or N]",
}
"""Arguments that people try of both ways, to what is meant."""


class Maps(Frozen):
    """Both ways between actuated coordinates and joints, see `Transmission`.

    With n names, positions, speeds and efforts are `(..., n)`; where one name was given by itself,
    `(...)`. All arguments of a call broadcast.
    """

    _forward: Way
    _backward: Way

    @property
    def actuated(self) -> tuple[str, ...]:
        """Names of the n actuated coordinates."""
        return self._forward.given.names

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the n joints, or coordinates of joints, that they move."""
        return self._forward.found.names

    @hinting(_ASKED)
    def joints_of(
        self,
        actuated: ArrayLike,
        speed: ArrayLike | None = None,
        effort: ArrayLike | None = None,
        held: Mapping[str, ArrayLike] | None = None,
    ) -> Mapped:
        """Return where the actuated coordinates bring the joints.

        Args:
            actuated: positions of the actuated coordinates [rad or m].
            speed: of the actuated coordinates [rad/s or m/s].
            effort: what the motors exert at them [N·m or N], positive in the coordinates' senses.
            held: held joints to positions in place of those of the scene [rad or m], which
                broadcast with the others; not where ranges are fitted.

        Returns:
            `position` and `speed` of the joints, and the `effort` [N·m or N] that motors right at
            the joints would have to exert to do the same: Jᵀ · effort of the joints = effort of
            the actuated, with J = ∂joints/∂actuated (virtual work). The transmission has no mass,
            no weight and no friction in that.

        Raises:
            ArgumentError: a value is not finite, or has another shape.
            AssemblyError: a position is out of reach.
            SingularConfigurationError: the actuated do not decide the motion there; or efforts are
                asked for where they do not move a joint, so that it can take any.
        """
        return self._forward.mapped(actuated, speed, effort, held)

    @hinting(_ASKED)
    def actuated_of(
        self,
        joints: ArrayLike,
        speed: ArrayLike | None = None,
        effort: ArrayLike | None = None,
        held: Mapping[str, ArrayLike] | None = None,
    ) -> Mapped:
        """Return where the actuated coordinates are while the joints are somewhere.

        Args:
            joints: positions of the joints [rad or m].
            speed: of the joints [rad/s or m/s].
            effort: what motors right at the joints would exert [N·m or N].
            held: see `joints_of`.

        Returns:
            `position`, `speed` and `effort` of the actuated coordinates, see `joints_of`, in the
            same assembly mode.

        Raises:
            CardanError: as `joints_of`, with joints and actuated exchanged.
        """
        return self._backward.mapped(joints, speed, effort, held)

    def jacobian(self, actuated: ArrayLike, held: Mapping[str, ArrayLike] | None = None) -> Array:
        """Return J = ∂joints/∂actuated `(..., n, n)`: a row per joint, a column per actuated one.

        Args:
            actuated: their positions [rad or m].
            held: see `joints_of`.

        Raises:
            CardanError: as `joints_of`.
        """
        return self._forward.at(self._actuated(actuated), held)[1]

    def singular_values(self, actuated: ArrayLike) -> Array:
        """Return the singular values of J `(..., n)`, the greatest first.

        Slides are counted in characteristic lengths of the mechanism. Where the last one falls to
        zero, some motion of the actuated does not move the joints, and efforts of the joints by
        motors grow beyond bounds; where the first one grows beyond bounds, the actuated rest while
        joints move, and so do efforts of motors by joints. Errors grow alike, as the greatest or
        the reciprocal of the least. The ratio of both is the condition number.

        Source: Gosselin and Angeles (1990): singularities of the first and of the second kind.

        Args:
            actuated: their positions [rad or m].

        Raises:
            CardanError: as `joints_of`.
        """
        jacobian = self._forward.scaled(self.jacobian(actuated))
        return np.asarray(np.linalg.svd(jacobian, compute_uv=False))

    def speed_limits(self, actuated: ArrayLike, limits: ArrayLike | None = None) -> Array:
        """Return between which speeds the joints can move.

        Args:
            actuated: positions of the actuated coordinates [rad or m].
            limits: greatest speed of each of them, in both senses `(n,)`, or one for all [rad/s or
                m/s]; those of the description if None.

        Returns:
            `(..., 2)` the least and the greatest of one joint. Of two, `(..., 4, 2)` the corners of
            a parallelogram, one after the other; of n, `(..., 2ⁿ, n)` those of a parallelotope, in
            which all speeds lie.

        Raises:
            ArgumentError: the description has no limits, or one is not positive.
            CardanError: as `joints_of`.
        """
        corners = self._corners(limits, "velocity")
        jacobian = self.jacobian(actuated)
        return self._polygon(np.einsum("...jk,ck->...cj", jacobian, corners))

    def effort_limits(self, actuated: ArrayLike, limits: ArrayLike | None = None) -> Array:
        """Return between which efforts motors exert at the joints, at rest and without weight.

        Arguments, results and errors as of `speed_limits`, with efforts [N·m or N]; besides

        Raises:
            SingularConfigurationError: see `joints_of`.
        """
        corners, at = self._corners(limits, "effort"), self._actuated(actuated)
        jacobian = self._forward.at(at)[1]
        self._forward.refuse_singular(at, jacobian)
        transposed = np.swapaxes(jacobian, -1, -2)[..., None, :, :]
        return self._polygon(np.linalg.solve(transposed, corners[..., None])[..., 0])

    def _actuated(self, actuated: object) -> Array:
        return self._forward.given.rows("actuated", actuated)

    def _corners(self, limits: object, kind: str) -> Array:
        """Return the corners `(2ⁿ, n)` of limits in both senses, in a circle if there are four."""
        count = len(self.actuated)
        if limits is None:
            ranges = np.array(
                [
                    item.efforts if kind == "effort" else (-item.velocity, item.velocity)
                    for item in self._forward.given.limits
                ]
            )
            if not np.all((ranges[:, 0] < ranges[:, 1]) & np.isfinite(ranges).all(axis=1)):
                raise ArgumentError(
                    f"the description does not limit {kind} of all of {choices(self.actuated)}; "
                    "give limits"
                )
        else:
            most = positives("limits", limits)
            if len(most) not in (1, count):
                raise ArgumentError(f"limits has shape {most.shape}, expected ({count},)")
            ranges = np.broadcast_to(np.outer(most, (-1.0, 1.0)), (count, 2))
        corners = np.array(list(product(*ranges)))
        return corners[[0, 1, 3, 2]] if count == 2 else corners

    def _polygon(self, corners: Array) -> Array:
        """Return corners `(..., 2ⁿ, n)`; an interval `(..., 2)` of one joint."""
        return corners if len(self.actuated) > 1 else np.sort(corners[..., 0], axis=-1)
