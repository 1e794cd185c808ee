"""Joint angles and fork offset of shafts that bend in two projections.

The catalogue reads the bend of a joint off two drawings, beta_V in the side view and beta_H in
the plan view. Seen along the shaft, the tangents of both are the components of the bend.

The formulas from projections are exact if the common shaft is parallel to both drawing planes;
a single compound angle is exact if either of its two shafts is. In other positions they
hold to first order, and `angle_between` and `offset_between` give the exact values from the
directions of the shafts. Angles are in radians, all arguments broadcast.

Reference:
    Catalogue of cardan shafts, chapter 6.3, Bild 17 to 19.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import dot, length, plane_normal
from ._checks import FloatArray, projected_angle, same_shape, vector

__all__ = ["angle_between", "bending_plane", "compound_angle", "fork_offset", "offset_between"]


def compound_angle(beta_h: ArrayLike, beta_v: ArrayLike) -> FloatArray:
    """Joint angle from its two projections, tan^2 beta = tan^2 beta_H + tan^2 beta_V.

    Args:
        beta_h: projection in the plan view [rad], between -pi/2 and pi/2.
        beta_v: projection in the side view [rad], between -pi/2 and pi/2.

    Returns:
        beta [rad], in the broadcast shape.

    Raises:
        ValueError: a projection out of range or shapes that do not match.

    Source:
        Catalogue 6.3.

    >>> round(float(np.degrees(compound_angle(np.radians(7), np.radians(15)))), 4)
    16.4225
    """
    return np.arctan(np.hypot(*_tangents(beta_h=beta_h, beta_v=beta_v)))


def bending_plane(beta_h: ArrayLike, beta_v: ArrayLike) -> FloatArray:
    """Direction of the bending plane, from the axis of beta_V towards that of beta_H.

    Args:
        beta_h: projection in the plan view [rad], between -pi/2 and pi/2.
        beta_v: projection in the side view [rad], between -pi/2 and pi/2.

    Returns:
        p = atan2(tan beta_H, tan beta_V) [rad] between -pi and pi, in the broadcast shape; 0 for a
        straight joint, which has no bending plane.

    Raises:
        ValueError: a projection out of range or shapes that do not match.

    Source:
        Catalogue 6.3, tan phi = tan beta_H / tan beta_V, with the quadrant it leaves open.
    """
    return np.arctan2(*_tangents(beta_h=beta_h, beta_v=beta_v))


def fork_offset(
    beta_h1: ArrayLike, beta_v1: ArrayLike, beta_h2: ArrayLike, beta_v2: ArrayLike
) -> FloatArray:
    """Angle by which the second fork of the common shaft is turned against the first.

    p_2 - p_1 with its sign, reduced to -90 degrees < gamma <= 90 degrees as a fork looks the same
    after half a turn. With it, both forks pass through their bending planes at the same time.

    Args:
        beta_h1: projection of joint 1 in the plan view [rad], between -pi/2 and pi/2.
        beta_v1: projection of joint 1 in the side view [rad], likewise.
        beta_h2: projection of joint 2 in the plan view [rad], likewise.
        beta_v2: projection of joint 2 in the side view [rad], likewise.

    Returns:
        gamma [rad], in the broadcast shape, counted like `bending_plane`. Exactly 0 if the planes
        coincide, as in Z and W arrangements, and if a joint is straight.

    Raises:
        ValueError: a projection out of range or shapes that do not match.

    Source:
        Catalogue 6.3, phi = phi_1 +- phi_2, whose sign it takes from the drawing. Its example of
        71 degrees against the clock is -70.873 degrees here.

    >>> gamma = fork_offset(*np.radians([7.0, 15.0, 12.0, -11.5]))
    >>> round(float(np.degrees(gamma)), 3)
    -70.873
    """
    h1, v1, h2, v2 = _tangents(beta_h1=beta_h1, beta_v1=beta_v1, beta_h2=beta_h2, beta_v2=beta_v2)
    return _half_turn(h2 * v1 - v2 * h1, v1 * v2 + h1 * h2)


def angle_between(axis_1: ArrayLike, axis_2: ArrayLike) -> FloatArray:
    """Joint angle between two shafts given by their directions.

    Args:
        axis_1: (..., 3) direction of a shaft along the power flow, of any length.
        axis_2: (..., 3) direction of the next shaft along the power flow.

    Returns:
        beta [rad] between 0 and pi, in the broadcast shape without the last axis.

    Raises:
        ValueError: an axis of length zero or shapes that do not match.

    Source:
        Vector algebra; exact where the catalogue's 6.3 is of first order.
    """
    first, second = vector("axis_1", axis_1), vector("axis_2", axis_2)
    same_shape(axis_1=first, axis_2=second)
    return np.arctan2(length(np.cross(first, second)), dot(first, second))


def offset_between(axis_1: ArrayLike, axis_2: ArrayLike, axis_3: ArrayLike) -> FloatArray:
    """Fork offset on the middle one of three shafts given by their directions.

    The angle between the bending planes, about `axis_2` by the right-hand rule.

    Args:
        axis_1: (..., 3) direction of the input shaft along the power flow, of any length.
        axis_2: (..., 3) direction of the common shaft along the power flow.
        axis_3: (..., 3) direction of the output shaft along the power flow.

    Returns:
        gamma [rad], -pi/2 < gamma <= pi/2, in the broadcast shape without the last axis; 0 if a
        joint is straight.

    Raises:
        ValueError: an axis of length zero or shapes that do not match.

    Source:
        Vector algebra; exact where the catalogue's 6.3 is of first order.
    """
    first, common = vector("axis_1", axis_1), vector("axis_2", axis_2)
    last = vector("axis_3", axis_3)
    same_shape(axis_1=first, axis_2=common, axis_3=last)
    normal_1, normal_2 = plane_normal(first, common), plane_normal(common, last)
    sine = dot(np.cross(normal_1, normal_2), common)
    return _half_turn(sine, dot(normal_1, normal_2))


def _tangents(**angles: ArrayLike) -> list[FloatArray]:
    checked = {name: projected_angle(name, value) for name, value in angles.items()}
    same_shape(**checked)
    return [np.tan(angle) for angle in checked.values()]


def _half_turn(sine: FloatArray, cosine: FloatArray) -> FloatArray:
    """Angle of (cosine, sine) reduced to -pi/2 < angle <= pi/2."""
    angle = np.arctan2(np.where(cosine < 0.0, -sine, sine), np.abs(cosine))
    # Adding zero turns -0.0 into 0.0.
    return np.where(angle <= -np.pi / 2, np.pi / 2, angle)[()] + 0.0
