"""Bending moments of the output shaft of a universal joint, after D. Thoma (1920).

The cross carries no mass and no friction, so the moment it passes on is normal to both
pins. On shaft 2 it appears as the torque M_t and the bending moments M_x and M_z.

Directions. Let e_1 and e_2 be the unit vectors of the shafts in the sense of rotation. The
moment that the cross exerts on shaft 2 is M_t e_2 + M_x e_x + M_z e_z with

    e_x = (e_1 - e_2 cos beta) / sin beta, in the plane of the shafts,
    e_z = (e_2 x e_1) / sin beta, normal to that plane.

Thoma's own axes x, y, z are the opposite of e_x, e_2, e_z: his shafts turn about -y, and
(6) and (7) are ratios, which reversing all three axes leaves as they are.

Rotations are counted from his Hauptlage A, the pin axis of the input fork in the plane of the
shafts. Angles are in radians, all arguments broadcast, scalars give NumPy floats, and an
infinite rotation gives NaN.

Reference:
    D. Thoma: Das Kraeftespiel im Kreuzgelenk. Schweizerische Bauzeitung 75 (1920),
    no. 17, p. 187. https://doi.org/10.5169/seals-36448
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from . import _cross
from ._checks import FloatArray, joint_angle, not_negative, real, refuse, same_shape

__all__ = [
    "RigHarmonics",
    "bending_moments",
    "moment_cosines",
    "pin_cosines",
    "rig_harmonics",
    "rig_moments",
    "rig_moments_small_angle",
]


class RigHarmonics(NamedTuple):
    """Amplitudes of one order: M_t and M_x of the sine, M_z of the cosine [N m]."""

    torsion: FloatArray
    bending_x: FloatArray
    bending_z: FloatArray


def pin_cosines(beta: ArrayLike, phi_1: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Direction cosines of the pins of fork 1 and fork 2 in Thoma's axes x, y, z.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        phi_1: rotation of the input shaft [rad].

    Returns:
        Two arrays of unit vectors, each in the broadcast shape with a last axis of 3.

    Raises:
        ValueError: beta out of range or shapes that do not match.

    Source:
        Thoma 1920 (1) and (2), the output rotation eliminated by (4).
    """
    sin_b, cos_b, sine, cosine, root = _position(beta, phi_1)
    pin_1 = (cosine * cos_b, -cosine * sin_b, sine)
    pin_2 = (-sine / root, 0.0, cos_b * cosine / root)
    return _vectors(*pin_1), _vectors(*pin_2)


def moment_cosines(beta: ArrayLike, phi_1: ArrayLike) -> FloatArray:
    """Direction cosines (cos lambda, cos mu, cos nu) of the moment in Thoma's axes x, y, z.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        phi_1: rotation of the input shaft [rad].

    Returns:
        Unit vectors, in the broadcast shape with a last axis of 3. The normal to both pins
        taken is the one that makes an acute angle with the sense of rotation, -y.

    Raises:
        ValueError: beta out of range or shapes that do not match.

    Source:
        Thoma 1920, unnumbered equations before (6), the output rotation eliminated by (4).
    """
    sin_b, cos_b, sine, cosine, root = _position(beta, phi_1)
    factor = -sin_b * cosine / root
    return _vectors(factor * cos_b * cosine, -root, factor * sine)


def bending_moments(
    beta: ArrayLike, phi_1: ArrayLike, torque: ArrayLike = 1.0
) -> tuple[FloatArray, FloatArray]:
    """Bending moments M_x and M_z on shaft 2 that belong to its torque.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        phi_1: rotation of the input shaft [rad].
        torque: torque M_t that the cross exerts on shaft 2 [N m]; with the default 1 the
            results are the ratios to it.

    Returns:
        M_x and M_z [N m], each in the broadcast shape. M_x runs between 0 and
        torque * tan beta, M_z between -torque * tan(beta) / 2 and +torque * tan(beta) / 2.

    Raises:
        ValueError: beta out of range or shapes that do not match.

    Source:
        Thoma 1920 (6) and (7), multiplied by cos^2 phi: finite at every position.

    >>> M_x, M_z = bending_moments(np.radians(45), 0.0, torque=100.0)
    >>> round(float(M_x), 9), float(M_z)
    (100.0, 0.0)
    """
    beta, phi_1 = joint_angle("beta", beta), real("phi_1", phi_1)
    torque = real("torque", torque)
    shape = same_shape(beta=beta, phi_1=phi_1, torque=torque)
    M_x, M_z = _writable(np.cos(phi_1), shape), _writable(np.sin(phi_1), shape)
    # Blocks that stay in the cache, written over sine and cosine: fresh memory for every step
    # would take longer than the steps.
    blocks = np.nditer(
        [M_x, M_z, np.cos(beta), torque * np.sin(beta)],
        flags=["external_loop", "buffered", "zerosize_ok"],
        op_flags=[["readwrite"], ["readwrite"], ["readonly"], ["readonly"]],
        buffersize=16384,
    )
    with blocks:
        for cosine, sine, cos_b, scale in blocks:
            in_plane = cos_b * cosine
            factor = scale * cosine / (in_plane * in_plane + sine * sine)
            np.multiply(factor, in_plane, out=cosine)
            np.multiply(factor, sine, out=sine)
    return M_x[()], M_z[()]


def rig_moments(
    beta: ArrayLike, phi_1: ArrayLike, inertia: ArrayLike, speed: ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Torque and bending moments on shaft 2 of Thoma's rig, exactly.

    The input shaft turns at constant speed, held by a pulley of very great inertia; shaft 2
    carries nothing but a flywheel.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        phi_1: rotation of the input shaft [rad].
        inertia: moment of inertia of the flywheel [kg m^2], not negative.
        speed: angular speed of the input shaft [rad/s].

    Returns:
        M_t, M_x and M_z [N m], each in the broadcast shape.

    Raises:
        ValueError: beta or inertia out of range or shapes that do not match.

    Source:
        Thoma 1920 (8), printed as a second (3), with (6) and (7).
    """
    beta, phi_1, scale = _rig_arguments(beta, phi_1, inertia, speed)
    sine, cosine = np.sin(phi_1), np.cos(phi_1)
    cos_b, sin_b = np.cos(beta), np.sin(beta)
    torque = scale * _cross.acceleration_ratio(cos_b, sin_b**2, sine, cosine)
    denominator, error = _cross.denominator_and_error(cos_b, sine, cosine)
    factor = torque * sin_b * cosine / denominator * (1.0 - error)
    return torque, factor * cos_b * cosine, factor * sine


def rig_moments_small_angle(
    beta: ArrayLike, phi_1: ArrayLike, inertia: ArrayLike, speed: ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Torque and bending moments on shaft 2 of Thoma's rig in his form for small angles.

    He neglects (1 - cos beta)^2. The error is 1.5, 2.7 and 2.5 % of the peak of M_t, M_x and
    M_z at 8.5 degrees and 8.6, 14.5 and 13.7 % at 20 degrees.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        phi_1: rotation of the input shaft [rad].
        inertia: moment of inertia of the flywheel [kg m^2], not negative.
        speed: angular speed of the input shaft [rad/s].

    Returns:
        M_t, M_x and M_z [N m], each in the broadcast shape.

    Raises:
        ValueError: beta or inertia out of range or shapes that do not match.

    Source:
        Thoma 1920, the three unnumbered equations that end the example.
    """
    beta, phi_1, scale = _rig_arguments(beta, phi_1, inertia, speed)
    sine, cosine = np.sin(phi_1), np.cos(phi_1)
    # sin 2a + sin(4a)/2 = 4 sin a cos^3 a and 1 - cos 4a = 8 sin^2 a cos^2 a
    torque = -4.0 * scale * _cross.versine(beta) * sine * cosine
    factor = torque * np.sin(beta) * cosine
    return torque, factor * cosine, factor * sine


def rig_harmonics(
    beta: ArrayLike,
    order: ArrayLike,
    inertia: ArrayLike = 1.0,
    speed: ArrayLike = 1.0,
) -> RigHarmonics:
    """Harmonic content of the exact moments of Thoma's rig.

    M_t and M_x are sums of amplitude * sin(order * phi_1), M_z of amplitude * cos(order * phi_1)
    over the even orders, and order 0 is the mean of M_z. Small angles leave orders 2 and 4:
    Thoma's small-angle form. A bending frequency omega_n of shaft 2 is thus excited at the
    speeds omega_n / 2 and omega_n / 4.

    With kappa = tan^2(beta/2), n = order / 2 and g_n = n kappa^(n-1) (1 + (n-1)(1 - kappa^2)/2),
    per inertia * speed^2:

        M_t: -4 n kappa^n
        M_x: -sin^3 beta / (4 cos beta) * (g_(n-1) + 2 g_n + g_(n+1))
        M_z: -sin^3 beta / (4 cos^2 beta) * (g_(n+1) - g_(n-1))

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        order: order of the rotation, even and not negative: 0, 2, 4, ...
        inertia: moment of inertia of the flywheel [kg m^2], not negative.
        speed: angular speed of the input shaft [rad/s].

    Returns:
        torsion, bending_x and bending_z [N m], each in the broadcast shape. The amplitudes of
        M_z change sign (order 4 at 66.4 degrees): near there their accuracy is relative to
        the two terms of the difference.

    Raises:
        ValueError: beta, order or inertia out of range or shapes that do not match.

    Source:
        Fourier series of Thoma 1920 (8), (6) and (7).

    >>> amplitudes = rig_harmonics(np.radians(8.5), [2, 4])
    >>> (amplitudes.bending_x * 1e3).round(4)
    array([-1.6461, -0.8435])
    """
    order = real("order", order)
    # NaN, which is unequal to itself, passes as everywhere.
    uneven = (order != 2.0 * np.rint(order / 2.0)) & ~np.isnan(order)
    wrong = (order < 0.0) | np.isinf(order) | uneven
    refuse("order", order, wrong, "0, 2, 4, ...")
    beta, order, scale = _rig_arguments(beta, order, inertia, speed, "order")
    sine, cosine = np.sin(beta), np.cos(beta)
    kappa = np.tan(beta / 2) ** 2
    defect = cosine / np.cos(beta / 2) ** 4  # 1 - kappa^2
    n = order / 2.0

    def g(k: FloatArray) -> FloatArray:
        power = np.power(kappa, np.maximum(k - 1.0, 0.0))
        return power * np.maximum(k, 0.0) * (1.0 + (k - 1.0) * defect / 2.0)

    bend = -scale * sine**3 / (4.0 * cosine)
    return RigHarmonics(
        torsion=-4.0 * scale * n * kappa**n,
        bending_x=bend * np.sign(n) * (g(n - 1.0) + 2.0 * g(n) + g(n + 1.0)),
        bending_z=bend / cosine * (g(n + 1.0) - g(n - 1.0)),
    )


def _position(beta: ArrayLike, phi_1: ArrayLike) -> tuple[FloatArray, ...]:
    """Sines and cosines of both angles, and the root of the denominator they share."""
    beta, phi_1 = joint_angle("beta", beta), real("phi_1", phi_1)
    same_shape(beta=beta, phi_1=phi_1)
    sine, cosine, cos_b = np.sin(phi_1), np.cos(phi_1), np.cos(beta)
    return np.sin(beta), cos_b, sine, cosine, np.sqrt(_cross.denominator(cos_b, sine, cosine))


def _writable(values: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """`values` itself if it is an array of this shape, else a copy that is."""
    return values if values.shape == shape != () else np.array(np.broadcast_to(values, shape))


def _vectors(*components: FloatArray | float) -> FloatArray:
    return np.stack(np.broadcast_arrays(*components), axis=-1)


def _rig_arguments(
    beta: ArrayLike,
    second: ArrayLike,
    inertia: ArrayLike,
    speed: ArrayLike,
    name: str = "phi_1",
) -> tuple[FloatArray, FloatArray, FloatArray]:
    beta, second = joint_angle("beta", beta), real(name, second)
    inertia, speed = not_negative("inertia", inertia), real("speed", speed)
    same_shape(**{"beta": beta, name: second, "inertia": inertia, "speed": speed})
    return beta, second, inertia * speed**2
