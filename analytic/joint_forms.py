"""Two other forms of the universal joint: the ring, and Taylor's joint.

The ring (Weisbach Fig. 74) carries the four bearings in place of the cross. It moves and passes
on moments like the cross, as its two pin axes meet at 90 degrees too, but it has another inertia
and is bent in its plane.

Taylor's joint is a ball with four teeth in a sleeve with four axial slots. Each pair of opposite
teeth is a pin that asks for a sleeve angle of its own, one as pin of the input fork, one as pin of
the output fork, so that the joint locks unless its slots have play. Angles are in radians, all
arguments broadcast.

References:
    J. Weisbach, G. Herrmann: Lehrbuch der Ingenieur- und Maschinen-Mechanik, part 3,
    section 1, paragraph 26; Taylor's joint also in Dingler's Polytechnisches Journal 173 (1864).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from . import _cross
from ._checks import FloatArray, joint_angle, not_negative, positive, real, same_shape
from .single_joint import output_angle

__all__ = [
    "ring_bending",
    "ring_greatest_bending",
    "ring_inertia",
    "ring_pin_force",
    "taylor_driven_angle",
    "taylor_greatest_play",
    "taylor_play",
    "taylor_sleeve_angles",
    "taylor_speed_ratio",
]


def ring_inertia(mass: ArrayLike, radius: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Moments of inertia of a thin ring, m r^2 about its normal and m r^2 / 2 about a diameter.

    Args:
        mass: m [kg], greater than 0.
        radius: r [m], greater than 0.

    Returns:
        Both moments of inertia [kg m^2], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Mechanics of the thin ring of Weisbach Fig. 74.
    """
    mass, radius = positive("mass", mass), positive("radius", radius)
    same_shape(mass=mass, radius=radius)
    polar = mass * radius**2
    return polar, polar / 2.0


def ring_pin_force(moment: ArrayLike, radius: ArrayLike) -> FloatArray:
    """Force on each pin of the ring, M_n / (2 r).

    Args:
        moment: size of the moment M_n that the ring passes on [N m], not negative; it is
            `grossmann.moment_size`.
        radius: radius r of the ring at its pins [m], greater than 0.

    Returns:
        The force [N], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Statics of the ring of Weisbach Fig. 74.
    """
    moment, radius = not_negative("moment", moment), positive("radius", radius)
    same_shape(moment=moment, radius=radius)
    return moment / (2.0 * radius)


def ring_bending(moment: ArrayLike, angle: ArrayLike) -> FloatArray:
    """Size of the bending moment in the plane of the ring.

    The forces of the four pins are tangential and alternate in sense. By symmetry the ring carries
    half a pin force along it on either side of a pin and no bending at the pins, which leaves
    M_n / 4 (sin x + cos x - 1) at the angle x from a pin to the next.

    Args:
        moment: size of the moment M_n that the ring passes on [N m], not negative.
        angle: angle along the ring from any of the pins [rad].

    Returns:
        The bending moment [N m], in the broadcast shape; 0 at the pins, which are 90 degrees apart.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Thin ring of Weisbach Fig. 74; statics and symmetry.
    """
    moment, angle = not_negative("moment", moment), real("angle", angle)
    same_shape(moment=moment, angle=angle)
    sine, cosine = np.abs(np.sin(angle)), np.abs(np.cos(angle))
    # sin x + cos x - 1 = 2 sin x cos x / (sin x + cos x + 1) without its difference
    return moment * sine * cosine / (2.0 * (sine + cosine + 1.0))


def ring_greatest_bending(moment: ArrayLike) -> FloatArray:
    """Greatest bending moment in the plane of the ring, (sqrt 2 - 1) / 4 M_n.

    It stands midway between the pins.

    Args:
        moment: size of the moment M_n that the ring passes on [N m], not negative.

    Returns:
        The bending moment [N m], 0.1036 M_n.

    Raises:
        ValueError: moment negative or infinite.

    Source:
        `ring_bending` at 45 degrees.
    """
    return (np.sqrt(2.0) - 1.0) / 4.0 * not_negative("moment", moment)


def taylor_sleeve_angles(beta: ArrayLike, theta: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Sleeve angles that the two pairs of teeth ask for.

    tan phi_I = cos beta tan theta and tan phi_II = tan theta / cos beta.

    Args:
        beta: angle between ball and sleeve [rad], 0 <= beta < pi/2.
        theta: rotation of the ball [rad]; at 0 one pair of teeth lies in the plane of the shafts.

    Returns:
        phi_I and phi_II [rad], in the broadcast shape, equal only at multiples of 90 degrees.

    Raises:
        ValueError: beta out of range or shapes that do not match.

    Source:
        Weisbach paragraph 26 and his figure of Taylor's joint, with both zeros of rotation.
    """
    return output_angle(beta, theta, zero="normal"), output_angle(beta, theta, zero="in_plane")


def taylor_play(beta: ArrayLike, theta: ArrayLike) -> FloatArray:
    """Play that each slot needs, the difference of the two sleeve angles.

    tan Delta = sin theta cos theta sin beta tan beta, in size.

    Args:
        beta: angle between ball and sleeve [rad], 0 <= beta < pi/2.
        theta: rotation of the ball [rad].

    Returns:
        Delta [rad], not negative, in the broadcast shape.

    Raises:
        ValueError: beta out of range or shapes that do not match.

    Source:
        Difference of the two angles of `taylor_sleeve_angles`.
    """
    beta, theta = joint_angle("beta", beta), real("theta", theta)
    same_shape(beta=beta, theta=theta)
    return np.arctan(np.abs(np.sin(theta) * np.cos(theta)) * np.sin(beta) * np.tan(beta))


def taylor_greatest_play(beta: ArrayLike) -> FloatArray:
    """Greatest play that a slot needs over a turn, atan(sin beta tan beta / 2).

    Args:
        beta: angle between ball and sleeve [rad], 0 <= beta < pi/2.

    Returns:
        Delta [rad], in the shape of `beta`.

    Raises:
        ValueError: beta out of range.

    Source:
        `taylor_play` at 45 degrees.

    >>> np.degrees(taylor_greatest_play(np.radians([5, 10, 20, 30]))).round(3)
    array([0.218, 0.877, 3.562, 8.213])
    """
    beta = joint_angle("beta", beta)
    return np.arctan(np.sin(beta) * np.tan(beta) / 2.0)


def taylor_driven_angle(beta: ArrayLike, theta: ArrayLike) -> FloatArray:
    """Rotation of a sleeve that the ball drives in the positive sense.

    The pair of teeth that asks for more drives: the sleeve leads by 0 to asin tan^2(beta/2), four
    times a turn.

    Args:
        beta: angle between ball and sleeve [rad], 0 <= beta < pi/2.
        theta: rotation of the ball [rad].

    Returns:
        The greater of the two sleeve angles [rad], in the broadcast shape.

    Raises:
        ValueError: beta out of range or shapes that do not match.

    Source:
        Greater angle of `taylor_sleeve_angles`.
    """
    return np.maximum(*taylor_sleeve_angles(beta, theta))


def taylor_speed_ratio(beta: ArrayLike, theta: ArrayLike) -> FloatArray:
    """Ratio of the speeds of a sleeve that the ball drives in the positive sense, and the ball.

    It falls from 1 / cos beta to cos beta over each quarter turn and jumps back by
    sin beta tan beta at the multiples of 90 degrees, where the rounding of theta decides on the
    side (theta = 0 is after the jump).

    Args:
        beta: angle between ball and sleeve [rad], 0 <= beta < pi/2.
        theta: rotation of the ball [rad].

    Returns:
        The ratio, in the broadcast shape.

    Raises:
        ValueError: beta out of range or shapes that do not match.

    Source:
        Derivative of `taylor_driven_angle`.
    """
    beta, theta = joint_angle("beta", beta), real("theta", theta)
    same_shape(beta=beta, theta=theta)
    sine, cosine = np.sin(theta), np.cos(theta)
    second = sine * cosine < 0.0
    return _cross.speed_ratio(
        np.cos(beta), np.where(second, cosine, sine), np.where(second, sine, cosine)
    )
