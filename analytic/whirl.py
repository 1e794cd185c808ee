"""Whirl of shaft 2 behind a universal joint, on bearings with springs: Thoma's critical speeds.

Shaft 2 turns with the speed Omega and tilts about the joint's centre on springs of the stiffness c
and dampers d, alike in all directions; Theta is its moment of inertia about its axis, A that across
it about the joint's centre, omega_n^2 = c / A. The tilt is the complex number s = s_x + i s_z: how
far the shaft's direction moves along e_x, in the plane of the shafts, and e_z of `thoma`, normal to
it. It grows counterclockwise in the sense of rotation: parts exp(+i n Omega t) whirl forwards,
exp(-i n Omega t) backwards. The moments M_x and M_z of the cross tilt it by

    A s'' - i Theta Omega s' + d s' + c s = M_z - i M_x .

All angles are in radians, rotations count from Thoma's Hauptlage A, all arguments broadcast.

References:
    D. Thoma: Das Kraeftespiel im Kreuzgelenk. Schweizerische Bauzeitung 75 (1920), no. 17, p. 187,
    whose critical speeds omega_n / 2 and omega_n / 4 are those of Theta / A = 0. The rotor with its
    gyroscopic term is that of the textbooks; what follows here of both is derived in this package.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arrays import filled
from ._checks import FloatArray, joint_angle, not_negative, positive, real, refuse
from ._checks import same_shape as broadcast
from .thoma import rig_harmonics

__all__ = [
    "Whirl",
    "critical_speed",
    "flutter_torque",
    "moments_of_flywheel",
    "moments_of_input_torque",
    "moments_of_output_torque",
    "peak",
    "tilts",
    "whirl_frequencies",
]

ComplexArray = NDArray[np.complex128]
Values = NDArray[Any]


class Whirl(NamedTuple):
    """Complex amplitudes of an order: of exp(+i n phi) and of exp(-i n phi).

    An order 0 is a constant; it stands under `forward`.
    """

    forward: ComplexArray
    backward: ComplexArray


def critical_speed(
    frequency: ArrayLike, order: ArrayLike, ratio: ArrayLike = 0.0, *, forward: bool = True
) -> FloatArray:
    """Speed of rotation at which an order of the joint meets the whirl of shaft 2.

    Args:
        frequency: omega_n = sqrt(c / A) [rad/s], greater than 0.
        order: n, times per revolution, greater than 0.
        ratio: Theta / A, from 0 to 2, the most that a body can have.
        forward: whether the order whirls forwards.

    Returns:
        omega_n / sqrt(n^2 -+ n Theta / A) [rad/s], the upper sign forwards, in the broadcast
        shape; inf where the gyroscopic moment stiffens the shaft so much that there is none, from
        Theta / A = n forwards.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Own derivation from Thoma 1920 and the rotor with gyroscopic term.

    >>> np.round(critical_speed(1.0, [2, 4], 0.1), 6)
    array([0.512989, 0.253185])
    """
    frequency, order = positive("frequency", frequency), positive("order", order)
    ratio = _inertia_ratio(ratio)
    shape = broadcast(frequency=frequency, order=order, ratio=ratio)
    square = order * (order - ratio if forward else order + ratio)
    with np.errstate(divide="ignore"):
        return filled(frequency / np.sqrt(np.maximum(square, 0.0)), shape)


def whirl_frequencies(
    speed: ArrayLike, frequency: ArrayLike, ratio: ArrayLike = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Natural frequencies of forward and backward whirl at a speed of rotation.

    Args:
        speed: Omega [rad/s], not negative.
        frequency: omega_n = sqrt(c / A) [rad/s], greater than 0.
        ratio: Theta / A, from 0 to 2.

    Returns:
        Both roots p of p^2 -+ (Theta / A) Omega p - omega_n^2 = 0 [rad/s], forward first, each
        positive and in the broadcast shape. Their product is omega_n^2.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Rotor with gyroscopic term (textbooks), without damping.
    """
    speed, frequency = not_negative("speed", speed), positive("frequency", frequency)
    ratio = _inertia_ratio(ratio)
    shape = broadcast(speed=speed, frequency=frequency, ratio=ratio)
    half = ratio * speed / 2.0
    forward = half + np.hypot(half, frequency)
    # The other root by the product of both: their difference would cancel.
    return filled(forward, shape), filled(frequency * (frequency / forward), shape)


def moments_of_flywheel(
    beta: ArrayLike, order: ArrayLike, inertia: ArrayLike = 1.0, speed: ArrayLike = 1.0
) -> Whirl:
    """Bending of shaft 2 by its own inertia, at constant speed of the input shaft.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        order: 0, 2, 4, ...
        inertia: Theta of shaft 2 about its axis [kg m^2], not negative.
        speed: Omega [rad/s].

    Returns:
        Amplitudes of M_z - i M_x [N m], real, in the broadcast shape. For small angles order 2
        whirls both ways with Theta Omega^2 beta^3 / 4, order 4 forwards alone with as much, all
        others as beta^5 or less. With t = tan(beta/2) and kappa = t^2 they are 2 Theta Omega^2 t^3
        times 1 - kappa - ..., -(1 + 2 kappa + ...) and 1 + 3 kappa - ..., that is beta^3 / 4 times
        1, -(1 + 3 beta^2 / 4) and 1 + beta^2 to the next order: order 2 forwards alone stays close
        to the cube of the angle, since its own series and that of tan(beta/2) cancel.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Thoma 1920 (6) and (7) with (8), their Fourier series from `thoma.rig_harmonics`.
    """
    _, bend_x, bend_z = rig_harmonics(beta, order, inertia, speed)
    rotates = np.asarray(order, dtype=float) > 0.0
    forward = np.where(rotates, (bend_z - bend_x) / 2.0, bend_z)
    backward = np.where(rotates, (bend_z + bend_x) / 2.0, 0.0)
    return _whirl(forward, backward, np.shape(forward))


def moments_of_input_torque(beta: ArrayLike, order: ArrayLike, torque: ArrayLike = 1.0) -> Whirl:
    """Bending of shaft 2 where the torque of the input shaft is constant.

    M_x = T sin beta (1 + cos 2 phi) / 2 and M_z = T tan beta sin(2 phi) / 2: there is no fourth
    order at any angle, and order 2 whirls forwards almost alone.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        order: 0, 2, 4, ...
        torque: T of shaft 1 [N m].

    Returns:
        Amplitudes of M_z - i M_x [N m], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Own derivation: Thoma 1920 (6) and (7) with the torque T / eta behind a massless joint.
    """
    beta, order, torque = joint_angle("beta", beta), _even(order), real("torque", torque)
    shape = broadcast(beta=beta, order=order, torque=torque)
    sine, tangent = np.sin(beta), np.tan(beta)
    second = np.where(order == 2.0, torque / 4.0, 0.0)
    constant = np.where(order == 0.0, torque * sine / 2.0, 0.0)
    # tan b - sin b = 2 tan b sin^2(b/2)
    behind = 2.0 * tangent * np.sin(beta / 2.0) ** 2
    return _whirl(-1j * (constant + second * (tangent + sine)), 1j * second * behind, shape)


def moments_of_output_torque(beta: ArrayLike, order: ArrayLike, torque: ArrayLike = 1.0) -> Whirl:
    """Bending of shaft 2 where its own torque is constant.

    M_z - i M_x = -i T sin beta cos phi / (cos beta cos phi - i sin phi) is a geometric series in
    exp(2 i phi): all orders whirl forwards, each tan^2(beta/2) times the one before.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        order: 0, 2, 4, ...
        torque: T that the cross exerts on shaft 2 [N m].

    Returns:
        Amplitudes of M_z - i M_x [N m], in the broadcast shape: with kappa = tan^2(beta/2)
        -i T tan(beta/2) (1 + kappa) kappa^(n/2 - 1), and -i T tan(beta/2) for order 0.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Own derivation from Thoma 1920 (6) and (7).

    >>> moments = moments_of_output_torque(np.radians(5), [2, 4]).forward
    >>> round(float(abs(moments[1] / moments[0])), 4)
    0.0019
    """
    beta, order, torque = joint_angle("beta", beta), _even(order), real("torque", torque)
    shape = broadcast(beta=beta, order=order, torque=torque)
    half = np.tan(beta / 2.0)
    kappa = half**2
    power = (1.0 + kappa) * kappa ** np.maximum(order / 2.0 - 1.0, 0.0)
    factor = np.where(order > 0.0, power, 1.0)
    return _whirl(-1j * torque * half * factor, np.zeros(()), shape)


def tilts(
    moments: Whirl,
    order: ArrayLike,
    speed: ArrayLike,
    polar: ArrayLike,
    diametral: ArrayLike,
    stiffness: ArrayLike,
    damping: ArrayLike = 0.0,
) -> Whirl:
    """Tilt of shaft 2 by the moments of an order, as long as it is small.

    Args:
        moments: amplitudes [N m], as the functions above return them.
        order: n of these moments, not negative.
        speed: Omega [rad/s].
        polar: Theta [kg m^2], not negative.
        diametral: A [kg m^2], greater than 0, about the joint's centre.
        stiffness: c [N m/rad], greater than 0.
        damping: d [N m s/rad], not negative; 2 zeta sqrt(c A) of a damping ratio.

    Returns:
        Complex amplitudes [rad], M / (c - A n^2 Omega^2 +- n Theta Omega^2 +- i d n Omega), the
        upper signs forwards, in the broadcast shape; inf or nan at an undamped critical speed.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        The rotor of the module's head. Its own motion changes the moments by the square of the
        tilt, and its amplitudes are right to 0.5 % at 5 degrees.
    """
    order, speed = not_negative("order", order), real("speed", speed)
    polar, diametral = not_negative("polar", polar), positive("diametral", diametral)
    stiffness, damping = positive("stiffness", stiffness), not_negative("damping", damping)
    ahead, behind = (np.asarray(part, dtype=complex) for part in moments)
    shape = np.broadcast_shapes(
        broadcast(
            order=order,
            speed=speed,
            polar=polar,
            diametral=diametral,
            stiffness=stiffness,
            damping=damping,
        ),
        ahead.shape,
        behind.shape,
    )
    turning = order * speed
    rigid, gyroscopic = stiffness - diametral * turning**2, polar * turning * speed
    with np.errstate(divide="ignore", invalid="ignore"):
        return _whirl(
            ahead / (rigid + gyroscopic + 1j * damping * turning),
            behind / (rigid - gyroscopic - 1j * damping * turning),
            shape,
        )


def peak(
    beta: ArrayLike,
    order: ArrayLike,
    polar: ArrayLike,
    diametral: ArrayLike,
    stiffness: ArrayLike,
    damping_ratio: ArrayLike,
    *,
    forward: bool = True,
) -> tuple[FloatArray, FloatArray]:
    """Greatest tilt of shaft 2 by its own inertia, over all speeds, and the speed it occurs at.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        order: 2, 4, ...
        polar: Theta [kg m^2], greater than 0.
        diametral: A [kg m^2], greater than 0, about the joint's centre.
        stiffness: c [N m/rad], greater than 0.
        damping_ratio: zeta = d / (2 sqrt(c A)), greater than 0.
        forward: whether the forward or the backward part of the order is meant.

    Returns:
        Speed [rad/s] and amplitude [rad], each in the broadcast shape. With g = n^2 -+ n Theta / A
        and D = zeta n / sqrt(g) they are the critical speed over sqrt(1 - 2 D^2), and the moment
        per speed squared over 2 A g D sqrt(1 - D^2); inf and nan where there is no peak.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Greatest value of `tilts` under `moments_of_flywheel`, which grow with the square of the
        speed.

    >>> speed, tilt = peak(np.radians(5), [2, 4], 0.1, 1.0, 1.0, 0.01)
    >>> speed.round(5), (tilt * 1e4).round(4)
    (array([0.51304, 0.25321]), array([2.1308, 0.5299]))
    """
    polar, diametral = positive("polar", polar), positive("diametral", diametral)
    stiffness, ratio = positive("stiffness", stiffness), positive("damping_ratio", damping_ratio)
    order = _even(order)
    moments = moments_of_flywheel(beta, order, polar)
    amount = np.abs(moments.forward if forward else moments.backward)
    critical = critical_speed(
        np.sqrt(stiffness / diametral), order, polar / diametral, forward=forward
    )
    excess = order * (order - polar / diametral if forward else order + polar / diametral)
    with np.errstate(divide="ignore", invalid="ignore"):
        own = ratio * order / np.sqrt(np.maximum(excess, 0.0))
        inner = 1.0 - 2.0 * own**2
        speed = np.where(inner > 0.0, critical / np.sqrt(np.maximum(inner, 0.0)), np.inf)
        tilt = amount / (2.0 * diametral * excess * own * np.sqrt(1.0 - own**2))
        tilt = np.where(np.isfinite(speed), tilt, np.nan)
    shape = np.broadcast_shapes(speed.shape, tilt.shape)
    return filled(speed, shape), filled(tilt, shape)


def flutter_torque(
    stiffness: ArrayLike,
    damping: ArrayLike,
    diametral: ArrayLike = 1.0,
    polar: ArrayLike = 0.0,
    speed: ArrayLike = 0.0,
) -> FloatArray:
    """Torque along shaft 2 from which on its forward whirl grows by itself.

    On average over a revolution a load torque T about the shaft, carried by no bearing that tilts,
    turns the tilt by i s T / 2, which grows once T / 2 exceeds d p_f, the damping at the frequency
    of forward whirl. Without gyroscopic effect that is T = 4 zeta c.

    Args:
        stiffness: c [N m/rad], greater than 0.
        damping: d [N m s/rad], not negative; 2 zeta sqrt(c A) of a damping ratio.
        diametral: A [kg m^2], greater than 0, about the joint's centre.
        polar: Theta [kg m^2], at most 2 A.
        speed: Omega [rad/s], not negative.

    Returns:
        T = 2 d p_f [N m], in the broadcast shape: a torque that resists the rotation.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Own derivation, averaged over a revolution at beta = 0; parametric resonances near
        Omega = p_f and at greater angles can grow below it.
    """
    stiffness, damping = positive("stiffness", stiffness), not_negative("damping", damping)
    diametral, polar = positive("diametral", diametral), not_negative("polar", polar)
    speed = not_negative("speed", speed)
    broadcast(stiffness=stiffness, damping=damping, diametral=diametral, polar=polar, speed=speed)
    ahead, _ = whirl_frequencies(speed, np.sqrt(stiffness / diametral), polar / diametral)
    return 2.0 * damping * ahead


def _inertia_ratio(value: ArrayLike) -> FloatArray:
    ratio = real("ratio", value)
    refuse("ratio", ratio, (ratio < 0.0) | (ratio > 2.0), "[0, 2]")
    return ratio


def _even(value: ArrayLike) -> FloatArray:
    order = real("order", value)
    uneven = (order != 2.0 * np.rint(order / 2.0)) & ~np.isnan(order)
    refuse("order", order, (order < 0.0) | np.isinf(order) | uneven, "0, 2, 4, ...")
    return order


def _whirl(forward: Values, backward: Values, shape: tuple[int, ...]) -> Whirl:
    return Whirl(
        *(np.array(np.broadcast_to(part, shape), dtype=complex)[()] for part in (forward, backward))
    )
