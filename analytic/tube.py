"""Torsion of the tube of a drive shaft.

SI units, all arguments broadcast.

References:
    S. Timoshenko: Strength of Materials; PSS.DriveshaftCalculations, Tube.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from analytic._checks import FloatArray, not_negative, positive, real, refuse, same_shape

__all__ = ["shear_stress", "torsional_stiffness"]


def shear_stress(
    torque: ArrayLike, outer_diameter: ArrayLike, inner_diameter: ArrayLike
) -> FloatArray:
    """Greatest shear stress of a tube under torque, tau = 16 T D / (pi (D^4 - d^4)).

    Args:
        torque: T [N m], of any sign.
        outer_diameter: D [m], greater than 0.
        inner_diameter: d [m], 0 <= d < D.

    Returns:
        The size of tau [Pa] at the outer surface, in the broadcast shape. Notches, welds and
        buckling of thin walls are not part of it.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        PSS, Tube; Saint-Venant's torsion.
    """
    torque = np.abs(real("torque", torque))
    polar, outer, _ = _polar_moment(outer_diameter, inner_diameter, torque=torque)
    return torque / polar * (outer / 2.0)


def torsional_stiffness(
    outer_diameter: ArrayLike,
    inner_diameter: ArrayLike,
    length: ArrayLike,
    shear_modulus: ArrayLike = 7.58423e10,
) -> FloatArray:
    """Torsional stiffness of a tube, c = pi G (D^4 - d^4) / (32 L).

    Args:
        outer_diameter: D [m], greater than 0.
        inner_diameter: d [m], 0 <= d < D.
        length: L [m], greater than 0.
        shear_modulus: G [Pa], greater than 0; by default 11e6 psi.

    Returns:
        c [N m/rad], in the broadcast shape; forks, splines and flanges soften a shaft further.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        PSS, Tube, with its G of steel; Saint-Venant's torsion.
    """
    length, modulus = positive("length", length), positive("shear_modulus", shear_modulus)
    polar, _, _ = _polar_moment(
        outer_diameter, inner_diameter, length=length, shear_modulus=modulus
    )
    return modulus * polar / length


def _polar_moment(
    outer_diameter: ArrayLike, inner_diameter: ArrayLike, **others: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Polar moment of area and both diameters, checked."""
    outer = positive("outer_diameter", outer_diameter)
    inner = not_negative("inner_diameter", inner_diameter)
    same_shape(outer_diameter=outer, inner_diameter=inner, **others)
    full, wide = np.broadcast_arrays(inner, outer)
    refuse("inner_diameter", full, full >= wide, "[0, outer_diameter)")
    # D^4 - d^4 of thin walls without its difference.
    polar = np.pi / 32.0 * (outer - inner) * (outer + inner) * (outer**2 + inner**2)
    return polar, outer, inner
