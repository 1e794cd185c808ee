"""Bushing: an elastic joint of six directions between two links."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..checks import numbers, semidefinite
from ..errors import ArgumentError
from .element import Element
from .rotation_vectors import greatest_angle, left_jacobian_inverse_transposed
from .winding import GREATEST_ANGLE

_ALONG = 1e-9
"""Part of a moment across an axis that counts as rounding of one along it."""
_RIGID = 1e-6
"""Deviation of a placement's axes from unit vectors at right angles that counts as rounding of the
numbers given."""


class BushingForce(NamedTuple):
    """What a bushing exerts.

    Attributes:
        wrench: `(N, 6)` on `link_b`, force first, about the bushing's origin in `link_b`, in the
            axes of the bushing's frame in `link_a` [N, N·m]; on `link_a`, the opposite at the same
            point.
        deformation: `(N, 6)` position and rotation vector of the bushing's frame in `link_b`
            relative to that in `link_a`, in the axes of the latter [m, rad].
        energy: `(N,)` that it stores [J].
        dissipation: `(N,)` power that it turns into heat [W].
    """

    wrench: Array
    deformation: Array
    energy: Array
    dissipation: Array


@dataclass(frozen=True, eq=False)
class Bushing(Element):
    """An elastic connection of two links in all six directions, such as a rubber bushing.

    A frame is fixed to each link. The deformation d is the position of the second in the axes of
    the first, then the rotation vector from the first to the second. The energy is ½ dᵀ K d, and
    the elastic wrench is exactly its gradient, at large rotations too. The damper exerts -C times
    the velocity of the second origin as seen from the first frame, then the relative angular
    velocity, in the same axes.

    It remembers how it was wound. Where all joints on a way from one link to the other turn about
    one direction, which both frames then share, their angles add up to the rotation, over any
    number of turns, as a `JointSpring` has it; from 3.1 rad on, the moment has to be along that
    direction. About axes that change, rotations by more than half a turn cannot be told from
    others: beyond 3.1 rad they are refused, as are those that leave half a turn on the straight
    line of joint angles from the description's zero. There it is turned by less than half a turn,
    wherever the angles of joints count from; one that is turned by 3.1 rad there is refused. Balls
    count no turns: where every way between the links leads over one, the rotation is the shortest.

    Attributes:
        link_a, link_b: names of the links, one of which may stand in the world.
        origin: `(3,)` or `(4, 4)` placement of the bushing's frame in `link_a` [m]; kept as
            `(4, 4)`.
        stiffness: `(6, 6)`, symmetric and without a negative direction, or its 6 diagonal values;
            translation first [N/m, N·m/rad]; kept as `(6, 6)`.
        damping: likewise [N·s/m, N·m·s/rad]; none if None.
        origin_b: placement of its frame in `link_b`, like `origin`; if None, the one that is
            without deformation where all joints are at the description's zero.
        name: by which results show it; may be empty.

    Raises:
        ArgumentError: a value is no finite number or of a wrong shape, a matrix is not symmetric or
            negative, a placement is not rigid, or both links are the same.
    """

    link_a: str
    link_b: str
    origin: Array
    stiffness: Array
    damping: Array | None = None
    origin_b: Array | None = None
    name: str = ""

    def __post_init__(self) -> None:
        link_a, link_b = self._two_links()
        expected = "translation first [N/m, N·m/rad]"
        damping = np.zeros(6) if self.damping is None else self.damping
        origin_b = self.origin_b
        self._set(
            link_a=link_a,
            link_b=link_b,
            origin=_placement("Bushing: origin", self.origin),
            stiffness=semidefinite("Bushing: stiffness", self.stiffness, expected),
            damping=semidefinite("Bushing: damping", damping, "translation first"),
            origin_b=None if origin_b is None else _placement("Bushing: origin_b", origin_b),
            name=self._text("name"),
        )
        super().__post_init__()

    @property
    def links(self) -> tuple[str, ...]:
        """Names of both links."""
        return self.link_a, self.link_b

    def force(self, turn: Array, span: Array, rate: Array, label: str) -> BushingForce:
        """Return what it exerts.

        Args:
            turn: `(N, 3)` rotation vectors of the second frame relative to the first [rad], longer
                than 3.1 rad only where it is wound about an axis that does not change.
            span: `(N, 3)` from the first origin to the second, in the axes of the first [m].
            rate: `(N, 6)` velocity of the second origin as seen from the first frame, then relative
                angular velocity, in the same axes [m/s, rad/s].
            label: how messages call the element.

        Raises:
            ArgumentError: it is wound by more than 3.1 rad, and its stiffness is not symmetric
                about the axis.
        """
        deformation = np.concatenate([span, turn], axis=1)
        gradient = deformation @ self.stiffness
        elastic = gradient.copy()
        square = np.einsum("ni,ni->n", turn, turn)
        far = square > GREATEST_ANGLE**2
        if np.any(far):
            across = np.cross(turn[far], gradient[far, 3:])
            sizes = np.linalg.norm(turn[far], axis=1) * np.linalg.norm(gradient[far, 3:], axis=1)
            if np.any(np.linalg.norm(across, axis=1) > _ALONG * sizes):
                raise ArgumentError(
                    f"{label}: it is wound by {greatest_angle(turn):.4g} rad, and its moment then "
                    "is not along the axis about which it turns; beyond "
                    f"{GREATEST_ANGLE:g} rad, this axis has to be one of the principal axes of its "
                    "rotational stiffness, which nothing couples with translation"
                )
        # Along the axis, the rate of the rotation vector is the angular velocity.
        near = ~far
        elastic[near, 3:] = left_jacobian_inverse_transposed(turn[near], gradient[near, 3:])
        drag = rate @ self.damping
        return BushingForce(
            wrench=-elastic - drag,
            deformation=deformation,
            energy=0.5 * np.einsum("ni,ni->n", gradient, deformation),
            dissipation=np.einsum("ni,ni->n", drag, rate),
        )


def too_far(label: str, angle: float) -> ArgumentError:
    """Return the error of a bushing that is turned too far, by an angle [rad]."""
    return ArgumentError(
        f"{label}: it is turned by {angle:.4g} rad, or was on the way there by more than half a "
        "turn, about axes that change, or is turned by half a turn at the description's zero "
        f"already, in one sense or the other; it may be turned by {GREATEST_ANGLE:g} rad, farther "
        "only where all joints between its links turn about one direction and keep it. Put it at "
        "a single joint, or use a JointSpring, which counts whole turns"
    )


def _placement(label: str, given: object) -> Array:
    """Return a placement `(4, 4)`; a point `(3,)` is one with the axes of the link.

    Raises:
        ArgumentError: it is neither, or not rigid.
    """
    array = numbers(label, given)
    if array.shape == (3,):
        placement = np.eye(4)
        placement[:3, 3] = array
        return placement
    if array.shape != (4, 4):
        raise ArgumentError(f"{label} has shape {array.shape}, expected (3,) or (4, 4)")
    rotation = array[:3, :3]
    is_rigid = (
        np.allclose(rotation @ rotation.T, np.eye(3), rtol=0.0, atol=_RIGID)
        and np.linalg.det(rotation) > 0.0
        and np.array_equal(array[3], [0.0, 0.0, 0.0, 1.0])
    )
    if not is_rigid:
        raise ArgumentError(
            f"{label} is no placement: a rotation (3, 3) beside a point, above 0, 0, 0, 1"
        )
    left, _, right = np.linalg.svd(rotation)
    array[:3, :3] = left @ right
    return array
