"""Bushing: an elastic joint of six directions between two links."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..checks import numbers, semidefinite
from ..errors import ArgumentError
from .element import Element
from .rotation_vectors import greatest_angle, left_jacobian_inverse_transposed, rotation_vector

GREATEST_ANGLE = 3.1
"""Rotation [rad] up to which a rotation vector is a smooth function of it; at pi it jumps."""
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
    velocity, in the same axes. Rotations beyond 3.1 rad are refused.

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

    def force(self, rotation: Array, span: Array, rate: Array, label: str) -> BushingForce:
        """Return what it exerts.

        Args:
            rotation: `(N, 3, 3)` of the second frame relative to the first.
            span: `(N, 3)` from the first origin to the second, in the axes of the first [m].
            rate: `(N, 6)` velocity of the second origin as seen from the first frame, then relative
                angular velocity, in the same axes [m/s, rad/s].
            label: how messages call the element.

        Raises:
            ArgumentError: it is turned by more than 3.1 rad.
        """
        turn = rotation_vector(rotation)
        angle = greatest_angle(turn)
        if not angle <= GREATEST_ANGLE:
            raise too_far(label, angle)
        deformation = np.concatenate([span, turn], axis=1)
        gradient = deformation @ self.stiffness
        elastic = gradient.copy()
        elastic[:, 3:] = left_jacobian_inverse_transposed(turn, gradient[:, 3:])
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
        f"{label}: it is turned by {angle:.4g} rad; a bushing turns by {GREATEST_ANGLE:g} rad at "
        "most"
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
