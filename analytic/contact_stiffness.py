"""Contact stiffness of a pin in its bush, for the joint with clearance.

Line contact of two cylinders of nearly equal radius. With K = (1 - nu^2) / (pi E) of each body,
the pin approaches the bush by

    delta = F (K_1 + K_2) / L * (1 + ln(4 L dR / (F (K_1 + K_2)))),

L being the length of the contact and dR the difference of the radii. SI units, all
arguments broadcast.

References:
    ESDU 78035: Contact phenomena I, stresses, deflections and contact dimensions for normally
    loaded unlubricated elastic components. It stands in for (9), (10) of Dresig and Thuemmel,
    which are lost in the surviving copy.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ._checks import FloatArray, positive, real, refuse, same_shape

__all__ = ["contact_approach", "contact_stiffness", "cylinder_compliance"]


def cylinder_compliance(modulus: ArrayLike, poisson: ArrayLike = 0.3) -> FloatArray:
    """Compliance K = (1 - nu^2) / (pi E) of the material of one cylinder.

    Args:
        modulus: Young's modulus E [Pa], greater than 0.
        poisson: Poisson's ratio nu, -1 < nu <= 0.5.

    Returns:
        K [1/Pa], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        ESDU 78035.
    """
    modulus, poisson = positive("modulus", modulus), real("poisson", poisson)
    refuse("poisson", poisson, (poisson <= -1.0) | (poisson > 0.5), "(-1, 0.5]")
    same_shape(modulus=modulus, poisson=poisson)
    return (1.0 - poisson) * (1.0 + poisson) / (np.pi * modulus)


def contact_approach(
    force: ArrayLike, compliance: ArrayLike, length: ArrayLike, radius_difference: ArrayLike
) -> FloatArray:
    """Approach delta of pin and bush under a force.

    Args:
        force: F [N], greater than 0 and below 4 L dR / compliance.
        compliance: sum K_1 + K_2 of `cylinder_compliance` of pin and bush [1/Pa], greater than 0.
        length: length L of the contact [m], greater than 0.
        radius_difference: dR of bush and pin [m], greater than 0; it is the s of
            `analytic.clearance`.

    Returns:
        delta [m], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        ESDU 78035.
    """
    force, per_length, logarithm = _contact(force, compliance, length, radius_difference)
    return force * per_length * (1.0 + logarithm)


def contact_stiffness(
    force: ArrayLike, compliance: ArrayLike, length: ArrayLike, radius_difference: ArrayLike
) -> FloatArray:
    """Stiffness c = dF / d delta of pin and bush at a force.

    Args:
        force: F [N], greater than 0 and below 4 L dR / compliance, where the stiffness has grown
            without bound and the formula ends.
        compliance: sum K_1 + K_2 of `cylinder_compliance` of pin and bush [1/Pa], greater than 0.
        length: length L of the contact [m], greater than 0.
        radius_difference: dR of bush and pin [m], greater than 0.

    Returns:
        c = L / ((K_1 + K_2) ln(4 L dR / (F (K_1 + K_2)))) [N/m], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Derivative of `contact_approach`.
    """
    _, per_length, logarithm = _contact(force, compliance, length, radius_difference)
    return 1.0 / (per_length * logarithm)


def _contact(
    force: ArrayLike, compliance: ArrayLike, length: ArrayLike, radius_difference: ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Force, compliance per length, and the logarithm of its greatest over the actual force."""
    force, compliance = positive("force", force), positive("compliance", compliance)
    length = positive("length", length)
    difference = positive("radius_difference", radius_difference)
    same_shape(force=force, compliance=compliance, length=length, radius_difference=difference)
    greatest = 4.0 * length * difference / compliance
    full, limit = np.broadcast_arrays(force, greatest)
    refuse("force", full, full >= limit, "(0, 4 length radius_difference / compliance)")
    return force, compliance / length, np.log(greatest / force)
