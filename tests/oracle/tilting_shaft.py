"""Shaft 2 of a universal joint tilting about the joint's centre on springs, by Lagrange, by hand.

Its bearing stands at the angle β + a in the plane of the shafts, then tilted by b across it: the
directions across its axis are R e_y and R e_z with R = R_z(β + a) R_y(b). The shaft turns by γ in
it. Pin 1 is p = (0, cos φ, sin φ), pin 2 is R (0, -sin γ, cos γ), and both are at right angles:

    tan γ = n / m,  n = p·R e_z = cos φ sin(β + a) sin b + sin φ cos b,
                    m = p·R e_y = cos φ cos(β + a).

With the spin σ = γ' - a' sin b about its axis, T = (Θ σ² + A (b'² + a'² cos² b)) / 2. As γ is a
function of φ, a and b, its part of Lagrange's operator on σ vanishes and what is left is -b' cos b
for a, a' cos b for b:

    Θ [σ' (γ_a - sin b) - σ b' cos b] + A (a'' cos² b - 2 a' b' sin b cos b) + c a + d a' = 0
    Θ [σ' γ_b + σ a' cos b] + A (b'' + a'² sin b cos b) + c b + d b' = 0

Nothing here knows the package under test.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

Array = np.ndarray


def _tangent(beta: float, phi: float, a: Array, b: Array) -> tuple[list[Array], list[list[Array]]]:
    """First and second derivatives of γ = atan2(n, m) by φ, a and b."""
    cp, sp, ca, sa, cb, sb = (
        function(x) for x in (phi, beta + a, b) for function in (np.cos, np.sin)
    )
    zero = 0.0 * a
    n, m = cp * sa * sb + sp * cb, cp * ca
    n_1 = [-sp * sa * sb + cp * cb, cp * ca * sb, cp * sa * cb - sp * sb]
    m_1 = [-sp * ca, -cp * sa, zero]
    n_2 = [
        [-n, -sp * ca * sb, -sp * sa * cb - cp * sb],
        [-sp * ca * sb, -cp * sa * sb, cp * ca * cb],
        [-sp * sa * cb - cp * sb, cp * ca * cb, -n],
    ]
    m_2 = [[-m, sp * sa, zero], [sp * sa, -m, zero], [zero, zero, zero]]
    square = n * n + m * m
    first = [(m * n_1[i] - n * m_1[i]) / square for i in range(3)]
    second = [
        [
            (m * n_2[i][j] - n * m_2[i][j] + m_1[j] * n_1[i] - n_1[j] * m_1[i]) / square
            - 2.0 * first[i] * (m * m_1[j] + n * n_1[j]) / square
            for j in range(3)
        ]
        for i in range(3)
    ]
    return first, second


@dataclass(frozen=True)
class TiltingShaft:
    """The system for q = (a, b), derivatives by φ.

    Attributes:
        beta: joint angle with unloaded springs [rad].
        speed: Ω [rad/s].
        polar: Θ about the shaft's axis [kg m²].
        diametral: A across it, about the joint's centre [kg m²].
        stiffness: c of both tilts [N m/rad].
        damping_ratio: ζ, d = 2 ζ √(c A).
        load: constant torque on the shaft along its axis, against its rotation, from outside: the
            bearing that tilts does not carry it [N m].
    """

    beta: float
    speed: float
    polar: float = 0.1
    diametral: float = 1.0
    stiffness: float = 1.0
    damping_ratio: float = 0.01
    load: float = 0.0

    def __call__(self, phi: float, q: Array, rate: Array) -> Array:
        (a, b), (va, vb) = q, rate
        first, second = _tangent(self.beta, phi, a, b)
        sb, cb = np.sin(b), np.cos(b)
        step = (1.0, va, vb)
        spin = first[0] + first[1] * va + first[2] * vb - va * sb
        # The change of the spin, without what a'' and b'' add to it.
        drift = sum(second[i][j] * step[i] * step[j] for i in range(3) for j in range(3))
        drift = drift - va * vb * cb
        along = (first[1] - sb, first[2])
        theta, inertia = self.polar, self.diametral
        k = self.stiffness / self.speed**2
        d = 2.0 * self.damping_ratio * np.sqrt(self.stiffness * self.diametral) / self.speed
        # The load does work on the rotation about the axis, as the flywheel does.
        torque = theta * drift + self.load / self.speed**2
        right = np.stack(
            [
                -torque * along[0] + theta * spin * vb * cb + 2.0 * inertia * va * vb * sb * cb,
                -torque * along[1] - theta * spin * va * cb - inertia * va**2 * sb * cb,
            ]
        ) - np.stack([k * a + d * va, k * b + d * vb])
        m_aa = theta * along[0] ** 2 + inertia * cb**2
        m_ab = theta * along[0] * along[1]
        m_bb = theta * along[1] ** 2 + inertia
        determinant = m_aa * m_bb - m_ab * m_ab
        return np.stack(
            [
                (m_bb * right[0] - m_ab * right[1]) / determinant,
                (m_aa * right[1] - m_ab * right[0]) / determinant,
            ]
        )
