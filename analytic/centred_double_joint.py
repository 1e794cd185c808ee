"""Double joint whose halves are centred on each other, as in steered axles.

Two joints stand the distance 2 a apart. The fixed shaft ends in the front joint, the other shaft
slides. The swivel axis of the axle stands the distance a + X behind the front joint. With X = 0 it
is in the middle between the joints of a straight axle, and both joint angles are equal at no other
angle; with X > 0 they are equal at one angle beta_x of the axle. SI units and radians, all
arguments broadcast.

References:
    Elbe, technical annex 7; SOREM; formulas by own derivation from the triangle of both joints and
    the swivel axis.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import filled
from ._checks import FloatArray, joint_angle, not_negative, positive, refuse, same_shape

__all__ = ["CentredJoint", "centre_offset", "centred_joint"]


class CentredJoint(NamedTuple):
    """Both joint angles [rad], of the sliding and of the fixed shaft, and the slip [m]."""

    beta_1: FloatArray
    beta_2: FloatArray
    slip: FloatArray


def centre_offset(half_distance: ArrayLike, beta: ArrayLike) -> FloatArray:
    """Offset of the swivel axis with which both joint angles are equal at an angle of the axle.

    Args:
        half_distance: a, half the distance of the joints [m], greater than 0.
        beta: angle beta_x of the axle [rad], 0 <= beta < pi/2; 30 to 35 degrees are usual.

    Returns:
        X = a (1 / cos(beta / 2) - 1) [m], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Own derivation; Elbe, technical annex 7, tabulates X.

    >>> round(float(centre_offset(0.060, np.radians(35.0))) * 1e3, 2)
    2.91
    """
    half, beta = positive("half_distance", half_distance), joint_angle("beta", beta)
    same_shape(half_distance=half, beta=beta)
    # 1 / cos x - 1 = 2 sin^2(x/2) / cos x
    return half * 2.0 * np.sin(beta / 4.0) ** 2 / np.cos(beta / 2.0)


def centred_joint(half_distance: ArrayLike, offset: ArrayLike, beta: ArrayLike) -> CentredJoint:
    """Joint angles and slip of a centred double joint.

    sin beta_1 = (a + X) sin beta / (2 a), beta_2 = beta - beta_1,
    e = sqrt(4 a^2 - (a + X)^2 sin^2 beta) - (a + X) cos beta - (a - X).

    Args:
        half_distance: a, half the distance of the joints [m], greater than 0.
        offset: X of the swivel axis [m], 0 <= X < a.
        beta: angle of the axle [rad], 0 <= beta < pi/2.

    Returns:
        beta_1, beta_2 and the slip e, positive where the sliding joint moves away from the swivel
        axis, each in the broadcast shape. `drive_line.residual_angle` of both angles with phases
        90 degrees apart is the residual angle.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Own derivation: law of sines in the triangle of both joints and the swivel axis.
    """
    half, offset = positive("half_distance", half_distance), not_negative("offset", offset)
    beta = joint_angle("beta", beta)
    shape = same_shape(half_distance=half, offset=offset, beta=beta)
    full, wide = np.broadcast_arrays(offset, half)
    refuse("offset", full, full >= wide, "[0, half_distance)")
    arm = half + offset
    beta_1 = np.arcsin(arm * np.sin(beta) / (2.0 * half))
    beta_2 = beta - beta_1
    # 2 a cos beta_1 - 2 a + arm (1 - cos beta), without its differences
    slip = 2.0 * arm * np.sin(beta / 2.0) ** 2 - 4.0 * half * np.sin(beta_1 / 2.0) ** 2
    return CentredJoint(*(filled(value, shape) for value in (beta_1, beta_2, slip)))
