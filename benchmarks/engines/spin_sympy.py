"""SymPy spins: Lagrange's equation in the input's rotation alone, integrated by DOP853.

The user gives the rotations of cross and output in closed form; deriving is not counted.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
import sympy as sp
from scipy.integrate import solve_ivp
from sympy.physics import mechanics as me

from ..spin import CROSS, SHAFT, SPEED, Spin
from .spinning import Spinner

LEVELS = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)


@lru_cache(maxsize=1)
def _derived() -> Callable[[float, float, float], float]:
    """Return the acceleration of the input as a function of β, position and speed."""
    phi = me.dynamicsymbols("phi")
    beta, position, speed = sp.symbols("beta position speed")
    time = me.dynamicsymbols._t
    rate = phi.diff(time)
    square = sp.cos(beta) ** 2 + (sp.sin(beta) * sp.sin(phi)) ** 2
    out = sp.cos(beta) / square * rate
    pin = sp.sin(beta) * sp.cos(beta) * sp.cos(phi) / square * rate
    energy = (SHAFT * (rate**2 + out**2) + CROSS * (rate**2 + pin**2)) / 2
    system = me.LagrangesMethod(energy, [phi])
    system.form_lagranges_equations()
    acceleration = system.rhs()[1].subs({rate: speed}).subs({phi: position})
    # Python's floats are faster than NumPy's for one value at a time.
    arguments = beta, position, speed
    return sp.lambdify(arguments, sp.simplify(acceleration), "math", cse=True)


def _prepare(spin: Spin, tolerance: float) -> Callable[[], float]:
    function, beta = _derived(), spin.beta
    start = np.array([0.0, SPEED])

    def derivative(_: float, state: np.ndarray) -> list[float]:
        position, speed = state.tolist()
        return [speed, function(beta, position, speed)]

    def run() -> float:
        options = {"method": "DOP853", "rtol": tolerance, "atol": tolerance}
        return float(solve_ivp(derivative, (0.0, spin.duration), start, **options).y[0, -1])

    return run


def methods() -> list[Spinner]:
    """Return the method."""
    settings = "LagrangesMethod in one coordinate, lambdify(cse), solve_ivp DOP853"
    return [Spinner("SymPy", sp.__version__, settings, LEVELS, _prepare)]
