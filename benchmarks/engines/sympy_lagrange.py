"""SymPy: Lagrange's equations with multipliers, turned into a NumPy function."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
import sympy as sp
from sympy.physics import mechanics as me

from .common import Method, pin_angles


@lru_cache(maxsize=1)
def _derived() -> Callable[..., list[np.ndarray]]:
    """Return multipliers of the five constraints as a function of beta and all angles.

    Two tilts of the input shaft are coordinates held at zero; their multipliers are its bending.
    """
    phi, tilt_y, tilt_z, theta, psi = coordinates = me.dynamicsymbols("phi tilt_y tilt_z theta psi")
    prescribed, beta = sp.symbols("prescribed beta")
    world = me.ReferenceFrame("N")
    tilted_z = world.orientnew("Z", "Axis", (tilt_z, world.z))
    tilted = tilted_z.orientnew("Y", "Axis", (tilt_y, tilted_z.y))
    shaft_in = tilted.orientnew("A", "Axis", (phi, tilted.x))
    cross = shaft_in.orientnew("C", "Axis", (theta, shaft_in.y))
    shaft_out = cross.orientnew("B", "Axis", (psi, cross.z))
    axis = sp.cos(beta) * world.x + sp.sin(beta) * world.y
    constraints = [
        phi - prescribed,
        tilt_y,
        tilt_z,
        shaft_out.x.dot(-sp.sin(beta) * world.x + sp.cos(beta) * world.y),
        shaft_out.x.dot(world.z),
    ]
    # Quasi-static: any inertia will do.
    energy = sum(q.diff(me.dynamicsymbols._t) ** 2 for q in coordinates) / 2
    system = me.LagrangesMethod(
        energy,
        coordinates,
        hol_coneqs=constraints,
        forcelist=[(shaft_out, -axis)],
        frame=world,
    )
    system.form_lagranges_equations()
    time = me.dynamicsymbols._t
    at_rest = {q.diff(time, 2): 0 for q in coordinates} | {q.diff(time): 0 for q in coordinates}
    held = {tilt_y: 0, tilt_z: 0}
    equations = system.eom.subs(at_rest).subs(held)
    multipliers = sp.symbols("lam1:6")
    names = dict(zip(system.lam_vec, multipliers, strict=True))
    solved = sp.solve(list(equations.subs(names)), multipliers, dict=True)[0]
    expressions = [sp.trigsimp(solved[name]) for name in multipliers]
    return sp.lambdify((beta, phi, theta, psi), expressions, "numpy", cse=True)


def _prepare(beta: float, phi: np.ndarray) -> Callable[[], np.ndarray]:
    function = _derived()

    def run() -> np.ndarray:
        torsion, bend_y, bend_z, out_1, out_2 = function(beta, phi, *pin_angles(beta, phi))
        return np.stack(
            [torsion, np.hypot(bend_y, bend_z), np.full_like(phi, -1.0), np.hypot(out_1, out_2)],
            axis=1,
        )

    return run


def methods() -> list[Method]:
    """Return the method."""
    settings = "LagrangesMethod, lambdify(cse); loop closed by the user, derivation not counted"
    return [Method("SymPy", sp.__version__, settings, _prepare, samples=10_000, once=True)]
