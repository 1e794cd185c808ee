"""Periodic motions of small systems of equations and the multipliers about them, by shooting.

A system is a function `acceleration(phi, q, rate)` of the rotation of its drive, `()`, and of its
coordinates and their derivatives by that rotation, `(n,)`; it returns the second derivatives `(n,)`
and is analytic in `q` and `rate`, for which it takes complex numbers. Nothing here knows the
package under test.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

Array = np.ndarray
Acceleration = Callable[[float, Array, Array], Array]

HALF_TURN = np.pi
"""Period of a joint's equations in the rotation of its drive."""
_RTOL, _ATOL = 3e-14, 1e-16
_STEP = 1e-100
"""Complex step: derivatives have no error of differences."""


class Periodic(NamedTuple):
    """A motion that repeats itself every half turn of the drive.

    Attributes:
        start: `(2 n,)` coordinates, then their derivatives by the rotation, at rotation zero.
        monodromy: `(2 n, 2 n)` matrix of the variational equation over the half turn.
        residual: by how much the motion misses its start after the half turn.
    """

    start: Array
    monodromy: Array
    residual: float

    @property
    def trace(self) -> float:
        return float(np.trace(self.monodromy))

    @property
    def determinant(self) -> float:
        return float(np.linalg.det(self.monodromy))

    @property
    def multipliers(self) -> Array:
        return np.linalg.eigvals(self.monodromy)

    @property
    def discriminant(self) -> float:
        """Of s² - A s + B - 2 for s = λ + 1/λ, two coordinates without damping.

        It is negative in regions of combined instability alone.
        """
        first = self.trace
        second = (first**2 - float(np.trace(self.monodromy @ self.monodromy))) / 2.0
        return first**2 - 4.0 * (second - 2.0)


def over_half_turn(system: Acceleration, start: Array) -> tuple[Array, Array]:
    """Return where a start leads to after half a turn, and its derivative by the start."""
    size = start.size
    n = size // 2

    def rate(phi: float, extended: Array) -> Array:
        state, matrix = extended[:size], extended[size:].reshape(size, size)
        jacobian = np.zeros((size, size))
        jacobian[:n, n:] = np.eye(n)
        for column in range(size):
            moved = state.astype(complex)
            moved[column] += 1j * _STEP
            jacobian[n:, column] = system(phi, moved[:n], moved[n:]).imag / _STEP
        values = np.concatenate([state[n:], system(phi, state[:n], state[n:])])
        return np.concatenate([values, (jacobian @ matrix).ravel()])

    begin = np.concatenate([start, np.eye(size).ravel()])
    run = solve_ivp(rate, (0.0, HALF_TURN), begin, "DOP853", rtol=_RTOL, atol=_ATOL)
    end = run.y[:, -1]
    return end[:size], end[size:].reshape(size, size)


def periodic(system: Acceleration, start: Array, steps: int = 12) -> Periodic:
    """Return the periodic motion that Newton's method reaches from a start `(2 n,)`."""
    start = np.asarray(start, dtype=float)
    for _ in range(steps):
        end, matrix = over_half_turn(system, start)
        miss = end - start
        if np.max(np.abs(miss)) < 1e-13 * (1.0 + np.max(np.abs(start))):
            break
        start = start - np.linalg.solve(matrix - np.eye(start.size), miss)
    else:
        raise RuntimeError(f"no periodic motion from here, it misses itself by {miss}")
    return Periodic(start, matrix, float(np.max(np.abs(miss))))


def orders(system: Acceleration, start: Array, turns_of: int = 64) -> Array:
    """Return Fourier coefficients `(turns_of, n)` of the coordinates over half a turn.

    Row k belongs to the order 2 k of the rotation, rows from `turns_of / 2` on to negative ones.
    """
    n = start.size // 2
    phi = np.linspace(0.0, HALF_TURN, turns_of, endpoint=False)
    run = solve_ivp(
        lambda at, y: np.concatenate([y[n:], system(at, y[:n], y[n:])]),
        (0.0, HALF_TURN),
        start,
        "DOP853",
        t_eval=phi,
        rtol=_RTOL,
        atol=_ATOL,
    )
    return np.fft.fft(run.y[:n], axis=1).T / turns_of


def edge(
    measure: Callable[[float], float], low: float, high: float, tolerance: float = 1e-12
) -> float:
    """Return where a measure of stability changes its sign between two speeds."""
    return float(brentq(measure, low, high, xtol=tolerance, rtol=1e-14))
