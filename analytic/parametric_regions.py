"""Speeds at which elastic shafts at a universal joint are unstable, for small joint angles.

A joint whose ratio eta = 1 + 2 kappa cos 2 phi + ..., kappa = tan^2(beta/2), varies with twice the
speed of rotation Omega varies the stiffness and inertia behind it likewise. Torsional vibration of
two natural frequencies then grows in a region about Omega = (omega_i + omega_j) / 2, unless damping
closes it: a single frequency (i = j) by turning over after each half turn, two of them together.
`torsional_speed.parametric_zone` is the case of a single spring in front of the joint.

SI units, angles in radians, all arguments broadcast.

References:
    Own derivations: averaging over the rotation, of first order in kappa, of the equations of
    motion linearised about their periodic motion. The textbooks have it for any system with
    periodic coefficients: A. H. Nayfeh, D. T. Mook: Nonlinear Oscillations, Wiley 1979, ch. 5.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import filled
from ._checks import FloatArray, joint_angle, not_negative, positive, same_shape

__all__ = ["Modes", "Regions", "middle_shaft_region", "two_spring_modes", "two_spring_regions"]

_PAIRS = np.array([0, 0, 1]), np.array([0, 1, 1])
"""Modes of the three regions: the first alone, both together, the second alone."""


class Modes(NamedTuple):
    """Torsional modes of a line, the lower first along the last axis of 2.

    `frequencies` [rad/s]; `fork` and `flywheel` are the rotations of the joint's forks and of the
    flywheel behind it, scaled so that the modal mass is one.
    """

    frequencies: FloatArray
    fork: FloatArray
    flywheel: FloatArray


class Regions(NamedTuple):
    """Regions of instability, along a last axis of 3: mode 1, modes 1 and 2 together, mode 2.

    `middle` and `half_width` are of the speed of rotation [rad/s]; the half width is 0 where
    damping closes the region. `growth` is the greatest exponent with which vibration grows [1/s],
    negative where it decays.
    """

    middle: FloatArray
    half_width: FloatArray
    growth: FloatArray


def two_spring_modes(
    front: ArrayLike,
    fork: ArrayLike,
    flywheel: ArrayLike,
    stiffness_in: ArrayLike,
    stiffness_out: ArrayLike,
) -> Modes:
    """Torsional modes of a joint between two elastic shafts, at the joint angle zero.

    The drive turns one end of the shaft in front of the joint, a flywheel sits at the end of the
    shaft behind it.

    Args:
        front: J_1 of the input fork [kg m^2], not negative.
        fork: J_f of the output fork [kg m^2], not negative, greater than 0 if `front` is not.
        flywheel: J_2 [kg m^2], greater than 0.
        stiffness_in: k_1 of the shaft in front [N m/rad], greater than 0.
        stiffness_out: k_2 of the shaft behind [N m/rad], greater than 0.

    Returns:
        Modes in the broadcast shape, with a last axis of 2.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Two inertias on two springs (textbooks).
    """
    front, fork = not_negative("front", front), not_negative("fork", fork)
    near = positive("front + fork", front + fork)
    flywheel = positive("flywheel", flywheel)
    k_1, k_2 = positive("stiffness_in", stiffness_in), positive("stiffness_out", stiffness_out)
    shape = same_shape(near=near, flywheel=flywheel, stiffness_in=k_1, stiffness_out=k_2)
    # Symmetric in coordinates scaled by the roots of the inertias.
    matrix = np.empty((*shape, 2, 2))
    matrix[..., 0, 0] = (k_1 + k_2) / near
    matrix[..., 1, 1] = k_2 / flywheel
    matrix[..., 0, 1] = matrix[..., 1, 0] = -k_2 / np.sqrt(near * flywheel)
    squares, vectors = np.linalg.eigh(matrix)
    scale = np.sqrt(near)[..., None], np.sqrt(flywheel)[..., None]
    return Modes(np.sqrt(squares), vectors[..., 0, :] / scale[0], vectors[..., 1, :] / scale[1])


def two_spring_regions(
    beta: ArrayLike,
    front: ArrayLike,
    fork: ArrayLike,
    flywheel: ArrayLike,
    stiffness_in: ArrayLike,
    stiffness_out: ArrayLike,
    damping_in: ArrayLike = 0.0,
    damping_out: ArrayLike = 0.0,
) -> Regions:
    """Regions of instability of a joint between two elastic shafts.

    With modes u (fork) and w (flywheel) of unit modal mass, the joint couples modes i and j by
    p = 2 kappa [k_2 (2 u_i u_j - u_i w_j - w_i u_j) - J_f (omega_i^2 + omega_j^2) u_i u_j], which
    makes them grow with p / (4 sqrt(omega_i omega_j)) = c in the middle, against their damping
    delta = (d_1 u^2 + d_2 (w - u)^2) / 2.

    Args:
        beta: joint angle [rad], 0 <= beta < pi/2.
        front: J_1 of the input fork [kg m^2], see `two_spring_modes`.
        fork: J_f of the output fork [kg m^2].
        flywheel: J_2 [kg m^2].
        stiffness_in: k_1 of the shaft in front [N m/rad].
        stiffness_out: k_2 of the shaft behind [N m/rad].
        damping_in: d_1 of the shaft in front [N m s/rad], not negative.
        damping_out: d_2 of the shaft behind [N m s/rad], not negative.

    Returns:
        Regions in the broadcast shape, with a last axis of 3. With damping the half width is
        (delta_i + delta_j) / 2 sqrt(c^2 / (delta_i delta_j) - 1), which without damping stands for
        c: damping that is spread unevenly widens the region of both modes, without bound in this
        order where one of them has none.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Own derivation, see the module's head. The motions have to be small, so that the periodic
        one is not itself near a resonance.
    """
    beta = joint_angle("beta", beta)
    modes = two_spring_modes(front, fork, flywheel, stiffness_in, stiffness_out)
    k_2, inertia = np.asarray(stiffness_out, float), np.asarray(fork, float)
    d_1, d_2 = not_negative("damping_in", damping_in), not_negative("damping_out", damping_out)
    parts = {"beta": beta, "modes": modes.frequencies[..., 0], "damping_in": d_1}
    shape = same_shape(**parts, damping_out=d_2)
    (w_i, w_j), (u_i, u_j), (f_i, f_j) = (
        (values[..., _PAIRS[0]], values[..., _PAIRS[1]]) for values in modes
    )
    springs = k_2[..., None] * (2.0 * u_i * u_j - u_i * f_j - f_i * u_j)
    masses = inertia[..., None] * (w_i**2 + w_j**2) * u_i * u_j
    kappa = np.tan(beta / 2.0)[..., None] ** 2
    coupling = np.abs(2.0 * kappa * (springs - masses)) / (4.0 * np.sqrt(w_i * w_j))
    each = d_1[..., None] * modes.fork**2 + d_2[..., None] * (modes.flywheel - modes.fork) ** 2
    delta_i, delta_j = each[..., _PAIRS[0]] / 2.0, each[..., _PAIRS[1]] / 2.0
    product, mean = delta_i * delta_j, (delta_i + delta_j) / 2.0
    # Half the sum over the root of the product tends to 1 as both dampings vanish together.
    with np.errstate(divide="ignore", invalid="ignore"):
        spread = np.where(mean > 0.0, mean / np.sqrt(product), 1.0)
    inside = np.sqrt(np.maximum(coupling**2 - product, 0.0))
    width = np.where(inside > 0.0, spread, 1.0) * inside
    growth = np.hypot(coupling, (delta_i - delta_j) / 2.0) - mean
    whole = (*shape, 3)
    return Regions(filled((w_i + w_j) / 2.0, whole), filled(width, whole), filled(growth, whole))


def middle_shaft_region(beta: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """First region of instability of the elastic middle shaft of a phased double joint.

    The middle shaft has no mass of its own, and the output, an inertia J_3, turns uniformly; its
    small vibration x obeys J_3 x'' + k eta^2(Omega t) x = 0 all the same.

    Args:
        beta: angle of both joints [rad], 0 <= beta < pi/2.

    Returns:
        Ends of the region over omega_n = sqrt(k / J_3): sqrt(cos beta) and its reciprocal, each in
        the shape of `beta`. At 20 degrees 0.9694 ... 1.0316, the full equation has 0.9696 ...
        1.0318.

    Raises:
        ValueError: an argument out of range.

    Source:
        Own derivation: harmonic balance of first order with the exact mean and order 2 of eta^2,
        (1 + kappa^2) / (1 - kappa^2) and 4 kappa / (1 - kappa^2).
    """
    root = np.sqrt(np.cos(joint_angle("beta", beta)))
    return root, 1.0 / root
