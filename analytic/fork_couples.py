"""Couples with which a joint bends its shafts, at the two positions that catalogues print.

The sizes of the bending moments of Grossmann and Thoma at 0 and 90 degrees. For the same formulas
Dana speaks of a flange fork at right angles to the drawing plane and Elbe of a fork in the plane of
deflection, so that here the pin of the driving fork tells the positions: in the plane of the
shafts, or normal to it. SI units, all arguments broadcast.

References:
    E. Klein's catalogue of cardan shafts, chapter 7; Elbe, technical annex 2; `grossmann`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from analytic._arrays import filled
from analytic._checks import FloatArray, joint_angle, real, same_shape

__all__ = ["ForkCouples", "fork_couples"]


class ForkCouples(NamedTuple):
    """Bending couples of both shafts [N m], by the plane in which the driving pin lies."""

    input_in_plane: FloatArray
    output_in_plane: FloatArray
    input_normal: FloatArray
    output_normal: FloatArray


def fork_couples(beta: ArrayLike, torque: ArrayLike = 1.0) -> ForkCouples:
    """Bending couples of a joint at its two extreme positions.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        torque: torque T of the driving shaft [N m], of any sign.

    Returns:
        Driving pin in the plane of the shafts: 0 on the driving shaft, T sin beta on the driven;
        normal to it: T tan beta on the driving shaft, 0 on the driven. Sizes, each in the
        broadcast shape. T tan beta is the greatest couple of the driving shaft over a turn;
        T sin beta is exceeded in between above 45 degrees, `grossmann.greatest_bending_2`.

    Raises:
        ValueError: beta out of range or shapes that do not match.

    Source:
        Klein chapter 7; Elbe, technical annex 2; Grossmann 1939 (6) and (8) at 0 and 90 degrees.

    >>> couples = fork_couples(np.radians(45.0), 100.0)
    >>> round(float(couples.output_in_plane), 4), round(float(couples.input_normal), 4)
    (70.7107, 100.0)
    """
    beta, torque = joint_angle("beta", beta), np.abs(real("torque", torque))
    shape = same_shape(beta=beta, torque=torque)
    # Zero times the torque, so that NaN stays NaN.
    none = 0.0 * torque * beta
    values = (none, torque * np.sin(beta), torque * np.tan(beta), none)
    return ForkCouples(*(filled(value, shape) for value in values))
