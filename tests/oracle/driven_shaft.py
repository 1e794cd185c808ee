"""Shaft 2 tilting on springs, driven by a torque: Newton and Euler, with the moment of the cross.

Shaft 1 with the moment of inertia J turns about e_x by φ; its pin is p = (0, cos φ, sin φ). Shaft 2
points along x = R_z(β + a) R_y(b) e_x, its bearing turns with a about e_z and with b about
y = R_z(β + a) e_y. The pins are at right angles, so that pin 2 is x × p but for its length, and a
massless cross passes on a moment m along the normal n of both pins alone. Vectors are in the world:

    shaft 1, about e_x:    J φ'' = T - m n·e_x
    shaft 2, H = A x × x' + Θ σ x:
        about x:           Θ σ' = m n·x
        about y:           A y·(x × x'') + Θ σ y·x' = m n·y - c b - d b'
        about e_z:         A e_z·(x × x'') + Θ (σ x)'·e_z = m n·e_z - c a - d a'
    both turn alike about the normal: (φ' e_x - a' e_z - b' y - g' x)·n = 0, and its derivative,

where σ = g' - a' sin b is the spin of shaft 2. Nothing here knows the package under test.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, sin, sqrt

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import OptimizeResult

Array = np.ndarray
Vector = tuple[float, float, float]

_X, _Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def _cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _sum(*parts: tuple[float, Vector]) -> Vector:
    return (
        sum(f * v[0] for f, v in parts),
        sum(f * v[1] for f, v in parts),
        sum(f * v[2] for f, v in parts),
    )


@dataclass(frozen=True)
class DrivenShaft:
    """The system for (φ, a, b).

    Attributes:
        beta: joint angle with unloaded springs [rad].
        torque: T of the drive as a function of its speed [N m].
        inertia: J of shaft 1 [kg m²].
        polar: Θ of shaft 2 about its axis [kg m²].
        diametral: A across it, about the joint's centre [kg m²].
        stiffness: c of both tilts [N m/rad].
        damping_ratio: ζ, d = 2 ζ √(c A).
    """

    beta: float
    torque: Callable[[float], float]
    inertia: float = 1.0
    polar: float = 0.1
    diametral: float = 1.0
    stiffness: float = 1.0
    damping_ratio: float = 0.01

    def accelerations(self, position: Array, speed: Array) -> Array:
        """Return the second derivatives of (φ, a, b) by time."""
        (phi, a, b), (turning, va, vb) = map(float, position), map(float, speed)
        x = (cos(self.beta + a) * cos(b), sin(self.beta + a) * cos(b), -sin(b))
        y = (-sin(self.beta + a), cos(self.beta + a), 0.0)
        moved_y = _sum((va, _cross(_Z, y)))
        housing = _sum((va, _Z), (vb, y))
        moved_x = _cross(housing, x)
        pin = (0.0, cos(phi), sin(phi))
        raw = _cross(x, pin)
        length = sqrt(_dot(raw, raw))
        other = _sum((1.0 / length, raw))
        normal = _cross(pin, other)
        own = _dot(_sum((turning, _X), (-1.0, housing)), normal) / _dot(x, normal)
        spin = own - va * sin(b)
        whole = _sum((1.0, housing), (own, x))
        moved_pin = _sum((turning, _cross(_X, pin)))
        moved_normal = _sum(
            (1.0, _cross(moved_pin, other)), (1.0, _cross(pin, _cross(whole, other)))
        )
        # What is left of x'', and of the second derivative of the rotation, without a'', b'', g''.
        left_x = _sum((1.0, _cross(housing, moved_x)), (vb, _cross(moved_y, x)))
        left_turn = _sum((vb, moved_y), (own, moved_x))
        by_a, by_b = _cross(x, _cross(_Z, x)), _cross(x, _cross(y, x))
        left = _cross(x, left_x)
        gap = _sum((turning, _X), (-1.0, whole))
        damping = 2.0 * self.damping_ratio * sqrt(self.stiffness * self.diametral)
        inertia, polar, c = self.diametral, self.polar, self.stiffness
        # Unknown: φ'', a'', b'', g'', m; σ' = g'' - a'' sin b - a' b' cos b.
        along = (0.0, -sin(b), 0.0, 1.0)
        drift = -va * vb * cos(b)
        rows = np.zeros((5, 5))
        right = np.zeros(5)
        rows[0] = self.inertia, 0.0, 0.0, 0.0, normal[0]
        right[0] = self.torque(turning)
        rows[1] = *(polar * item for item in along), -_dot(normal, x)
        right[1] = -polar * drift
        for row, axis, effort in (
            (2, y, -c * b - damping * vb),
            (3, _Z, -c * a - damping * va),
        ):
            share = polar * _dot(axis, x)
            rows[row, :4] = [share * item for item in along]
            rows[row, 1] += inertia * _dot(axis, by_a)
            rows[row, 2] += inertia * _dot(axis, by_b)
            rows[row, 4] = -_dot(normal, axis)
            right[row] = effort - inertia * _dot(axis, left) - share * drift
            right[row] -= polar * spin * _dot(axis, moved_x)
        rows[4] = normal[0], -normal[2], -_dot(y, normal), -_dot(x, normal), 0.0
        right[4] = _dot(left_turn, normal) - _dot(gap, moved_normal)
        return np.linalg.solve(rows, right)[:3]

    def run(
        self, start: Array, duration: float, until: float | None = None, rtol: float = 1e-9
    ) -> OptimizeResult:
        """Return scipy's solution from `(φ, a, b, φ', a', b')`, up to a speed if one is given."""

        def rate(_: float, state: Array) -> Array:
            return np.concatenate([state[3:], self.accelerations(state[:3], state[3:])])

        def reached(_: float, state: Array) -> float:
            return float(state[3]) - until if until is not None else 1.0

        reached.terminal = True  # type: ignore[attr-defined]
        return solve_ivp(
            rate,
            (0.0, duration),
            start,
            "DOP853",
            rtol=rtol,
            atol=1e-3 * rtol,
            events=reached,
            dense_output=True,
        )
