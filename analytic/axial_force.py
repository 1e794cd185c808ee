"""Axial force of a length compensation and what it does to the support bearings.

SI units and radians, all arguments broadcast.

References:
    Dana industrial drive shafts catalogue, axial forces; E. Klein's catalogue, 7.3.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from analytic._arrays import filled
from analytic._checks import FloatArray, joint_angle, not_negative, real, same_shape
from analytic.shaft_design import slip_force
from analytic.support_forces import Spans, SupportForces, _checked

__all__ = ["axial_force", "axial_support_forces"]


def axial_force(
    torque: ArrayLike,
    beta: ArrayLike,
    radius: ArrayLike,
    friction: ArrayLike = 0.11,
    pressure: ArrayLike = 0.0,
    area: ArrayLike = 0.0,
) -> FloatArray:
    """Axial force of a spline: friction under torque, and grease pressed in.

    Args:
        torque: T [N m], of any sign.
        beta: joint angle [rad], 0 <= beta < pi/2.
        radius: mean radius of the spline [m], greater than 0.
        friction: coefficient of friction, not negative.
        pressure: of the lubricant [Pa], not negative; makers allow up to 15 bar.
        area: of the spline on which the lubricant acts [m^2], not negative.

    Returns:
        The size of the force [N], in the broadcast shape: `shaft_design.slip_force` plus pressure
        times area.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Dana industrial drive shafts catalogue, p. 47.
    """
    slip = slip_force(torque, beta, radius, friction)
    pressure, area = not_negative("pressure", pressure), not_negative("area", area)
    same_shape(slip_force=slip, pressure=pressure, area=area)
    return slip + pressure * area


def axial_support_forces(
    force: ArrayLike, beta_1: ArrayLike, beta_2: ArrayLike, spans: Spans
) -> SupportForces:
    """Forces with which an axial force of the intermediate shaft loads the support bearings.

    Args:
        force: axial force F in the intermediate shaft [N], of any sign.
        beta_1: angle of joint 1 [rad], 0 <= beta_1 < pi/2.
        beta_2: angle of joint 2 [rad], 0 <= beta_2 < pi/2.
        spans: distances of the bearings.

    Returns:
        Sizes at A, B, E and F [N], each in the broadcast shape, in the plane of their joint: F sin
        beta times b/a, (a+b)/a, (e+f)/f and e/f. The thrust bearings carry F cos beta. They add to
        the forces of `support_forces` as vectors.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Klein 7.3; statics of the end shafts.
    """
    force = np.abs(real("force", force))
    beta_1, beta_2 = joint_angle("beta_1", beta_1), joint_angle("beta_2", beta_2)
    distances = _checked(spans)
    shape = same_shape(force=force, beta_1=beta_1, beta_2=beta_2, **distances)
    a, b, e, f = distances.values()
    front, rear = force * np.sin(beta_1), force * np.sin(beta_2)
    values = (front * b / a, front * (a + b) / a, rear * (e + f) / f, rear * e / f)
    return SupportForces(*(filled(value, shape) for value in values))
