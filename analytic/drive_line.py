"""Drive lines of any number of universal joints, as one equivalent joint, exactly.

A drive line is given by the joint angles `betas` and the fork phases `phases`, both with the
joints along the last axis. The phase gamma_k of joint k is the angle of its input pin from the
bending plane of joint k when the line's rotation is zero: 0 in the plane, 90 degrees normal to
it. `fork_phases` finds the phases from bending planes and forks. In a double shaft with the
correct fork position they differ by 90 degrees, in Z, W and spatial arrangement alike.

A joint turns the direction of its pin like the Moebius map W -> (W - z) / (1 - conj(z) W) with
W = exp(2 i phi) and z = kappa exp(-2 i gamma), kappa = tan^2(beta/2). Such maps form a group: a
line of joints is one such map and a rotation, so it moves exactly like one joint. This
joint's angle is the residual angle of the line, and its motion costs the same for any number
of joints.

A phase, or a difference of phases, within a few units in the last place of a multiple of 90
degrees is taken to be that multiple, as no float is equal to 90 degrees; the unit is that of the
phases as they are given, before whole turns are taken off. Joints are combined two by two, in an
order that loses no digits when neighbours have nearly equal angles; equal ones compensate to
exactly zero. In lines of three and more joints that compensate in another way, errors are a few
units in the last place of the greatest beta_k^2. Angles are in radians.

References:
    Catalogue of cardan shafts, chapter 6 (6.1 to 6.5); VDI 2722; SAE Universal Joint and
    Driveshaft Design Manual AE-7; H. Ch. Seherr-Thoss, F. Schmelz, E. Aucktor: Universal
    Joints and Driveshafts.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _cross
from ._checks import FloatArray, finite, joint_angle, real, same_shape

__all__ = [
    "EquivalentJoint",
    "acceleration_ratio",
    "equivalent_joint",
    "fork_phases",
    "output_angle",
    "residual_angle",
    "residual_angle_approximate",
    "speed_ratio",
]

ComplexArray = NDArray[np.complex128]

_ROUNDING = 4.0 * float(np.finfo(float).eps)
"""Relative error of a phase that is meant as a multiple of 90 degrees: what rounding pi, and a sum
or two of such multiples, make of it."""


class EquivalentJoint(NamedTuple):
    """The single joint that moves like a drive line [rad].

    The line's output rotation is phi + shift + lead of a joint of angle `beta` at phi + `phase`.
    `shift` is the mean advance of the output; it is zero if all phases differ by multiples of 90
    degrees.
    """

    beta: FloatArray
    phase: FloatArray
    shift: FloatArray


class _Line(NamedTuple):
    """The equivalent joint: cos beta, 1 - cos beta, sine and cosine of the phase, and the shift."""

    cosine: FloatArray
    versine: FloatArray
    sin_phase: FloatArray
    cos_phase: FloatArray
    shift: FloatArray


def fork_phases(
    plane_offsets: ArrayLike, fork_offsets: ArrayLike, first: ArrayLike = 0.0
) -> FloatArray:
    """Phases of the joints from the angles between bending planes and between forks.

    gamma_(k+1) = gamma_k + 90 degrees + fork offset - plane offset.

    Args:
        plane_offsets: (..., n - 1), angle from the bending plane of each joint to that of the
            next, about their common shaft in the sense of rotation [rad]; 0 in Z, pi in W.
        fork_offsets: (..., n - 1), angle from the output fork of each joint to the input fork of
            the next on their common shaft, in the sense of rotation [rad]; 0 in line.
        first: (...) phase of the first joint [rad].

    Returns:
        (..., n) phases [rad], whole turns not taken off. Multiples of 90 degrees stay multiples
        along lines of any length.

    Raises:
        ValueError: an infinite argument or shapes that do not match.

    Source:
        Catalogue chapter 6, second condition: forks of the common shaft in their bending planes
        at the same time, that is fork offset equal to plane offset, make the phases differ by
        90 degrees.

    >>> np.degrees(fork_phases([0.0], [0.0]))
    array([ 0., 90.])
    """
    planes = np.atleast_1d(finite("plane_offsets", plane_offsets))
    forks = np.atleast_1d(finite("fork_offsets", fork_offsets))
    start = finite("first", first)
    shape = same_shape(plane_offsets=planes, fork_offsets=forks)
    same_shape(first=start, offsets=np.empty(shape[:-1]))
    lines = np.broadcast_shapes(start.shape, shape[:-1])
    terms = np.zeros((*lines, shape[-1] + 1, 2))
    terms[..., 0, 0] = start
    terms[..., 1:, 0], terms[..., 1:, 1] = forks, -planes
    # Quarter turns are counted, so that only what is left of each offset is rounded.
    quarters = np.rint(terms / (np.pi / 2))
    rests = terms - quarters * (np.pi / 2)
    count = np.cumsum(np.sum(quarters, axis=-1), axis=-1) + np.arange(shape[-1] + 1.0)
    rest = np.cumsum(np.sum(rests, axis=-1), axis=-1)
    size = np.cumsum(np.sum(np.abs(terms), axis=-1), axis=-1)
    rest = np.where(np.abs(rest) <= _ROUNDING * size, 0.0, rest)
    return count * (np.pi / 2) + rest


def equivalent_joint(betas: ArrayLike, phases: ArrayLike) -> EquivalentJoint:
    """The single joint that moves exactly like the drive line.

    Args:
        betas: (..., n) joint angles [rad], each 0 <= beta < pi/2.
        phases: (..., n) fork phases [rad].

    Returns:
        beta, phase and shift [rad], each of shape (...). The phase is between -pi/2 and pi/2, and
        0 if beta is 0.

    Raises:
        ValueError: betas out of range or shapes that do not match.

    Source:
        Exact form of the catalogue's 6.4 and 6.5, from the composition of the joints' maps.
    """
    line = _line(betas, phases)
    beta = 2.0 * np.arctan(np.sqrt(line.versine / (1.0 + line.cosine)))
    return EquivalentJoint(beta, np.arctan2(line.sin_phase, line.cos_phase), line.shift)


def residual_angle(betas: ArrayLike, phases: ArrayLike) -> FloatArray:
    """Residual angle beta_E: the angle of a single joint as non-uniform as the line, exactly.

    With phases of 0 and 90 degrees, cos beta_E is the product of cos beta_k over the former
    divided by that over the latter, inverted if above 1.

    Args:
        betas: (..., n) joint angles [rad], each 0 <= beta < pi/2.
        phases: (..., n) fork phases [rad].

    Returns:
        beta_E [rad] of shape (...), between 0 and pi/2. Exactly 0 for two joints of equal angle
        with phases 90 degrees apart.

    Raises:
        ValueError: betas out of range or shapes that do not match.

    Source:
        Exact form of the catalogue's 6.4 and 6.5, where beta_E shall be at most 3 degrees.

    >>> round(float(np.degrees(residual_angle(np.radians([12.0, 10.0]), [0.0, np.pi / 2]))), 4)
    6.6673
    """
    return equivalent_joint(betas, phases).beta


def residual_angle_approximate(betas: ArrayLike, phases: ArrayLike) -> FloatArray:
    """Residual angle beta_E to first order, beta_E^2 = |sum beta_k^2 exp(2 i gamma_k)|.

    Args:
        betas: (..., n) joint angles [rad], each 0 <= beta < pi/2.
        phases: (..., n) fork phases [rad]; with 0 and 90 degrees the signs are + and -.

    Returns:
        beta_E [rad] of shape (...). Differences of squares are formed as products.

    Raises:
        ValueError: betas out of range or shapes that do not match.

    Source:
        Catalogue 6.4 and 6.5, beta_E = sqrt(+-beta_1^2 +-beta_2^2 ...).

    >>> beta_E = residual_angle_approximate(np.radians([12.0, 10.0]), [0.0, np.pi / 2])
    >>> round(float(np.degrees(beta_E)), 4)
    6.6332
    """
    betas, phases = _joints(betas, phases)
    total = np.zeros(betas.shape[:-1], dtype=complex)
    for k in range(0, betas.shape[-1] - 1, 2):
        first, second = betas[..., k], betas[..., k + 1]
        (sine, cosine), _, both = _apart(phases[..., k : k + 2])
        in_line, opposed = first**2 + second**2, (first - second) * (first + second)
        pair = in_line * cosine - 1j * opposed * sine
        total = total + pair * both
    if betas.shape[-1] % 2:
        total = total + betas[..., -1] ** 2 * _turn(phases[..., -1])
    return np.sqrt(np.abs(total))


def output_angle(betas: ArrayLike, phases: ArrayLike, phi_1: ArrayLike) -> FloatArray:
    """Rotation of the output shaft of the line.

    It is counted so that it starts where phi_1 does: without joint angles both are equal. It is
    continuous over any number of turns.

    Args:
        betas: (..., n) joint angles [rad], each 0 <= beta < pi/2.
        phases: (..., n) fork phases [rad].
        phi_1: rotation of the input shaft [rad], broadcast against (...).

    Returns:
        The rotation [rad] in the shape to which phi_1 and (...) broadcast.

    Raises:
        ValueError: betas out of range or shapes that do not match.

    Source:
        Composition of Thoma 1920 (4) joint by joint.
    """
    line, sine, cosine, phi_1 = _at(betas, phases, phi_1)
    total = phi_1 + (line.shift + _cross.lead(line.cosine, line.versine, sine, cosine))
    # Where the line lags, a small rotation nearly cancels; its direction does not.
    along, across = line.cosine * cosine, sine
    direction = np.arctan2(
        across * line.cos_phase - along * line.sin_phase,
        along * line.cos_phase + across * line.sin_phase,
    )
    return np.where(np.abs(phi_1) < np.pi / 2, line.shift + direction, total)[()]


def speed_ratio(betas: ArrayLike, phases: ArrayLike, phi_1: ArrayLike) -> FloatArray:
    """Ratio of output to input speed of the line, the product of its joints' ratios.

    Args:
        betas: (..., n) joint angles [rad], each 0 <= beta < pi/2.
        phases: (..., n) fork phases [rad].
        phi_1: rotation of the input shaft [rad], broadcast against (...).

    Returns:
        The ratio, in the shape to which phi_1 and (...) broadcast.

    Raises:
        ValueError: betas out of range or shapes that do not match.

    Source:
        Weisbach paragraph 26, composed joint by joint.
    """
    line, sine, cosine, _ = _at(betas, phases, phi_1)
    return _cross.speed_ratio(line.cosine, sine, cosine)


def acceleration_ratio(betas: ArrayLike, phases: ArrayLike, phi_1: ArrayLike) -> FloatArray:
    """Second derivative of the line's output rotation by its input rotation.

    Args:
        betas: (..., n) joint angles [rad], each 0 <= beta < pi/2.
        phases: (..., n) fork phases [rad].
        phi_1: rotation of the input shaft [rad], broadcast against (...).

    Returns:
        The derivative [1/rad], in the shape to which phi_1 and (...) broadcast.

    Raises:
        ValueError: betas out of range or shapes that do not match.

    Source:
        Derivative of `speed_ratio`.
    """
    line, sine, cosine, _ = _at(betas, phases, phi_1)
    sine_squared = line.versine * (1.0 + line.cosine)
    return _cross.acceleration_ratio(line.cosine, sine_squared, sine, cosine)


def _joints(betas: ArrayLike, phases: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Both arrays in their common shape, with at least one joint on the last axis."""
    angles = np.atleast_1d(joint_angle("betas", betas))
    gammas = np.atleast_1d(real("phases", phases))
    shape = same_shape(betas=angles, phases=gammas)
    if shape[-1] == 0:
        raise ValueError(f"betas of shape {angles.shape} holds no joint: at least 1 is valid")
    return np.broadcast_to(angles, shape), np.broadcast_to(gammas, shape)


def _quarter(angle: FloatArray, size: FloatArray | None = None) -> tuple[FloatArray, FloatArray]:
    """Sine and cosine, exact where `angle` is a multiple of 90 degrees to rounding.

    `size` is that of the angles it was made from, if they are greater.
    """
    sine, cosine = np.sin(angle), np.cos(angle)
    rounding = _ROUNDING * np.abs(angle if size is None else size)
    at_0, at_90 = np.abs(sine) <= rounding, np.abs(cosine) <= rounding
    return (
        np.where(at_0, 0.0, np.where(at_90, np.sign(sine), sine)),
        np.where(at_90, 0.0, np.where(at_0, np.sign(cosine), cosine)),
    )


def _reduced(angle: FloatArray) -> FloatArray:
    """The angle without whole turns; multiples of 90 degrees to rounding become exact ones."""
    sine, cosine = _quarter(angle)
    return np.where(np.abs(angle) <= np.pi, angle, np.arctan2(sine, cosine))


def _direction(angle: FloatArray, size: FloatArray | None = None) -> ComplexArray:
    sine, cosine = _quarter(angle, size)
    return np.asarray(cosine + 1j * sine)


def _turn(gamma: FloatArray) -> ComplexArray:
    """exp(2 i gamma)."""
    return _direction(gamma) ** 2


def _line(betas: ArrayLike, phases: ArrayLike) -> _Line:
    """Compose the maps W -> (p W - q) / (conj(p) - conj(q) W) of all joints."""
    betas, phases = _joints(betas, phases)
    kappas, complements = np.tan(betas / 2) ** 2, np.cos(betas) / np.cos(betas / 2) ** 2
    p = np.ones(betas.shape[:-1], dtype=complex)
    q, shift = np.zeros_like(p), np.zeros(p.shape)
    for k in range(0, betas.shape[-1], 2):
        if k + 1 < betas.shape[-1]:
            next_p, next_q = _pair(betas[..., k : k + 2], phases[..., k : k + 2])
        else:
            next_p, next_q = np.ones_like(p), kappas[..., k] * np.conj(_turn(phases[..., k]))
        parallel = next_p * p
        both = parallel + next_q * np.conj(q)
        shift = shift + np.angle(next_p) + np.angle(both * np.conj(parallel))
        p, q = both, next_p * q + next_q * np.conj(p)
    size = np.abs(p) + np.abs(q)
    versine = 2.0 * np.abs(q) / size
    # The determinant |p|^2 - |q|^2 as the product of all 1 - kappa^2.
    cosine = np.prod(complements * (1.0 + kappas), axis=-1) / size**2
    sin_phase, cos_phase = _quarter(np.where(q == 0.0, 0.0, np.angle(np.conj(q) * p) / 2))
    return _Line(
        np.where(versine < 0.5, 1.0 - versine, cosine), versine, sin_phase, cos_phase, shift
    )


def _pair(betas: FloatArray, phases: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """1 + z_2 conj(z_1) and z_1 + z_2, as joints in line plus joints opposed to each other."""
    first, second = betas[..., 0], betas[..., 1]
    kappas, halves = np.tan(betas / 2) ** 2, np.cos(betas / 2) ** 2
    complements = np.cos(betas) / halves
    total, product = kappas[..., 0] + kappas[..., 1], kappas[..., 0] * kappas[..., 1]
    # kappa_1 - kappa_2, and 1 - kappa_1 kappa_2 the same from either end of the line.
    difference = np.sin((first - second) / 2) * np.sin((first + second) / 2)
    difference = difference / (halves[..., 0] * halves[..., 1])
    opposed = np.sum(complements, axis=-1) - np.prod(complements, axis=-1)
    (sine, cosine), apart, both = _apart(phases)
    p = ((1.0 + product) * cosine + 1j * opposed * sine) * np.conj(apart)
    q = total * cosine + 1j * difference * sine
    return p, q * np.conj(both)


def _apart(
    phases: FloatArray,
) -> tuple[tuple[FloatArray, FloatArray], ComplexArray, ComplexArray]:
    """Sine and cosine of the difference of two phases, and the directions of it and of the sum."""
    # Whole turns go before the difference is taken: its rounding would be that of the turns.
    reduced, size = _reduced(phases), np.max(np.abs(phases), axis=-1)
    delta, both = reduced[..., 1] - reduced[..., 0], reduced[..., 0] + reduced[..., 1]
    size = np.maximum(size, np.maximum(np.abs(delta), np.abs(both)))
    sine, cosine = _quarter(delta, size)
    return (sine, cosine), np.asarray(cosine + 1j * sine), _direction(both, size)


def _at(
    betas: ArrayLike, phases: ArrayLike, phi_1: ArrayLike
) -> tuple[_Line, FloatArray, FloatArray, FloatArray]:
    """The line, sine and cosine of its equivalent joint's rotation, and phi_1."""
    line, phi_1 = _line(betas, phases), real("phi_1", phi_1)
    try:
        np.broadcast_shapes(line.shift.shape, phi_1.shape)
    except ValueError:
        raise ValueError(
            f"phi_1 of shape {phi_1.shape} does not match the lines' {line.shift.shape}: valid "
            "are shapes that broadcast against betas and phases without their last axis"
        ) from None
    sine, cosine = np.sin(phi_1), np.cos(phi_1)
    return (
        line,
        sine * line.cos_phase + cosine * line.sin_phase,
        cosine * line.cos_phase - sine * line.sin_phase,
        phi_1,
    )
