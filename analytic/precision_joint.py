"""Torque for which precision joints of DIN 808 are chosen.

SI units and radians, all arguments broadcast.

References:
    DIN 808; JW Winco, determining the size of universal joints.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from analytic._checks import FloatArray, joint_angle, positive, real, refuse, same_shape

__all__ = ["angle_factor", "required_torque"]


def angle_factor(beta: ArrayLike, factors: Mapping[float, float]) -> FloatArray:
    """Factor k by which the torque of a precision joint is raised for its angle.

    Args:
        beta: joint angle [rad], from 0 to the last angle of the table.
        factors: k by the angle in degrees, such as `limits.DIN_808_FACTORS["plain"]`.

    Returns:
        k, linear between the angles of the table and that of the first below it, in the shape of
        `beta`.

    Raises:
        ValueError: beta out of range, or a table without angles.

    Source:
        DIN 808 by `limits.DIN_808_FACTORS`. Makers' charts differ by up to 20 % between the
        angles of the table.

    >>> from analytic.limits import DIN_808_FACTORS
    >>> round(float(angle_factor(np.radians(30.0), DIN_808_FACTORS["plain"])), 9)
    2.2
    """
    beta = joint_angle("beta", beta)
    if not factors:
        raise ValueError(f"factors = {factors!r} is empty: one angle at least is valid")
    angles = np.array(sorted(factors))
    # A rounding of radians beyond the last angle still is this angle.
    refuse("beta", beta, np.degrees(beta) > angles[-1] * (1.0 + 1e-12), f"[0, {angles[-1]:g}] deg")
    return np.interp(np.degrees(beta), angles, [factors[angle] for angle in angles])


def required_torque(
    torque: ArrayLike,
    beta: ArrayLike,
    factors: Mapping[float, float],
    share: ArrayLike = 1.0,
) -> FloatArray:
    """Torque that a precision joint must bear by its data sheet, T k / share.

    Args:
        torque: T [N m], of any sign.
        beta: joint angle [rad], from 0 to the last angle of the table.
        factors: k by the angle in degrees, as in `angle_factor`.
        share: of the torque of a single joint that the joint bears, greater than 0; 0.9 for a
            double joint.

    Returns:
        The size of the torque [N m], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        DIN 808; JW Winco.
    """
    torque, share = np.abs(real("torque", torque)), positive("share", share)
    factor = angle_factor(beta, factors)
    same_shape(torque=torque, beta=factor, share=share)
    return torque * factor / share
