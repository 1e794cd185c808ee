"""Lengths, slopes, balance and losses of an installed drive shaft.

SI units and radians, all arguments broadcast.

References:
    Dana drive shafts catalogues, length dimensions; Befco, driveline length; Spicer driveline
    installation manual and torsional analysis calculator; ISO 21940-11.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import filled
from ._checks import (
    FloatArray,
    joint_angle,
    not_negative,
    positive,
    projected_angle,
    real,
    same_shape,
)
from .compound_angle import angle_between
from .limits import SPEED_ANGLES

__all__ = [
    "OperatingLengths",
    "TelescopeMargins",
    "greatest_joint_angle",
    "joint_angles_from_slopes",
    "joint_efficiency",
    "operating_lengths",
    "residual_unbalance",
    "shaft_directions",
    "telescope_margins",
]


class OperatingLengths(NamedTuple):
    """Least, recommended and greatest length of a shaft in operation [m]."""

    least: FloatArray
    recommended: FloatArray
    greatest: FloatArray


class TelescopeMargins(NamedTuple):
    """Travel left where a telescope is shortest, and overlap where it is longest [m]."""

    travel_left: FloatArray
    overlap: FloatArray


def operating_lengths(compressed: ArrayLike, compensation: ArrayLike) -> OperatingLengths:
    """Lengths at which a shaft with length compensation may run.

    Args:
        compressed: L_z, shortest length [m], greater than 0.
        compensation: L_a, by which it can be extended [m], not negative.

    Returns:
        L_z, L_z + L_a / 3 and L_z + L_a [m], each in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Dana commercial and industrial drive shafts catalogues, length dimensions.
    """
    short, travel = positive("compressed", compressed), not_negative("compensation", compensation)
    shape = same_shape(compressed=short, compensation=travel)
    values = (short, short + travel / 3.0, short + travel)
    return OperatingLengths(*(filled(value, shape) for value in values))


def telescope_margins(
    compressed: ArrayLike, separated: ArrayLike, shortest: ArrayLike, longest: ArrayLike
) -> TelescopeMargins:
    """Margins of the telescope of a shaft over the travel of what it connects.

    Args:
        compressed: length at which the telescope strikes [m], greater than 0.
        separated: length at which its profiles part [m], greater than 0.
        shortest: least length in operation [m], greater than 0.
        longest: greatest length in operation [m], greater than 0.

    Returns:
        shortest - compressed and separated - longest [m], each in the broadcast shape; negative
        where the shaft strikes or parts.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Geometry; what should be left is in `limits.LIMITS` (Befco; agricultural PTO practice).
    """
    compressed, separated = positive("compressed", compressed), positive("separated", separated)
    shortest, longest = positive("shortest", shortest), positive("longest", longest)
    shape = same_shape(
        compressed=compressed, separated=separated, shortest=shortest, longest=longest
    )
    return TelescopeMargins(
        filled(shortest - compressed, shape), filled(separated - longest, shape)
    )


def shaft_directions(slopes: ArrayLike, headings: ArrayLike = 0.0) -> FloatArray:
    """Directions of shafts from what is measured on them, slope and heading.

    Args:
        slopes: angle of each shaft against the horizontal, positive where it falls along the
            power flow [rad], between -pi/2 and pi/2.
        headings: angle of each shaft against the vehicle in the plan view, positive to the left
            [rad], between -pi/2 and pi/2; the arc tangent of lateral offset over horizontal length.

    Returns:
        Unit vectors in the broadcast shape with a last axis of 3: forward, left, up.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Geometry of Spicer's torsional analysis calculator, which asks for slopes and offsets.
    """
    slopes, headings = projected_angle("slopes", slopes), projected_angle("headings", headings)
    same_shape(slopes=slopes, headings=headings)
    level = np.cos(slopes)
    parts = (level * np.cos(headings), level * np.sin(headings), -np.sin(slopes))
    return np.stack(np.broadcast_arrays(*parts), axis=-1)


def joint_angles_from_slopes(slopes: ArrayLike, headings: ArrayLike = 0.0) -> FloatArray:
    """Joint angles of a line from slopes and headings of its shafts, exactly.

    Args:
        slopes: (..., n + 1) slopes of the shafts [rad], as in `shaft_directions`.
        headings: (..., n + 1) headings of the shafts [rad], likewise.

    Returns:
        (..., n) joint angles [rad]; in one vertical plane the differences of the slopes. Makers
        take sqrt(vertical^2 + horizontal^2) of the differences, which is of second order.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Angles between `shaft_directions`; Spicer driveline installation manual p. 10.
    """
    directions = shaft_directions(np.atleast_1d(real("slopes", slopes)), headings)
    return np.atleast_1d(angle_between(directions[..., :-1, :], directions[..., 1:, :]))


def greatest_joint_angle(speed: ArrayLike) -> FloatArray:
    """Greatest angle at which a joint should run at a speed, by a maker's table.

    Args:
        speed: of rotation [rad/s], not negative.

    Returns:
        beta [rad], in the shape of `speed`. Between the rows of the table speed times angle is
        interpolated, above it that of the last row holds, below it the angle of the first.

    Raises:
        ValueError: an argument out of range.

    Source:
        Spicer driveline installation manual, `limits.SPEED_ANGLES`.

    >>> rpm = np.array([1000.0, 3500.0, 5000.0, 10000.0])
    >>> np.degrees(greatest_joint_angle(rpm * np.pi / 30)).round(2)
    array([11.5,  5. ,  3.2,  1.6])
    """
    speed = not_negative("speed", speed)
    speeds, angles = np.array(list(SPEED_ANGLES)), np.array(list(SPEED_ANGLES.values()))
    reached = np.maximum(speed, speeds[0])
    return np.asarray(np.interp(reached, speeds, speeds * angles) / reached)[()]


def residual_unbalance(grade: ArrayLike, mass: ArrayLike, speed: ArrayLike) -> FloatArray:
    """Residual unbalance that a balance quality grade allows, U = G m / omega.

    Args:
        grade: G [m/s], greater than 0; G16 is 0.016.
        mass: m of the shaft [kg], greater than 0.
        speed: greatest speed of rotation [rad/s], greater than 0.

    Returns:
        U [kg m] of the whole shaft, in the broadcast shape; half of it for each of two planes.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        ISO 21940-11; U = 9549 G m / n in g mm, mm/s, kg and 1/min (Erbessd).
    """
    grade, mass, speed = positive("grade", grade), positive("mass", mass), positive("speed", speed)
    same_shape(grade=grade, mass=mass, speed=speed)
    return grade * mass / speed


def joint_efficiency(
    beta: ArrayLike, friction: ArrayLike, pin_radius: ArrayLike, arm: ArrayLike
) -> FloatArray:
    """Efficiency of a joint whose pins rub, eta = 1 - (4 / pi) mu (r / R) beta.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        friction: coefficient mu of the pin bearings, not negative.
        pin_radius: r of the pins [m], greater than 0.
        arm: R from the centre to the middle of a pin bearing [m], greater than 0.

    Returns:
        eta, in the broadcast shape. For small losses and angles: at 15 degrees the loss is
        2 % too small, at 30 degrees 8 %.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Own derivation: each pin rocks by 4 beta a turn under the force T / (2 R).
    """
    beta, friction = joint_angle("beta", beta), not_negative("friction", friction)
    radius, arm = positive("pin_radius", pin_radius), positive("arm", arm)
    same_shape(beta=beta, friction=friction, pin_radius=radius, arm=arm)
    return 1.0 - 4.0 / np.pi * friction * radius / arm * beta
