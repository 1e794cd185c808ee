"""Extremes: the greatest values of periodic quantities, between the samples as well as at them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from ....kit.arrays import Array
from ....kit.extremes import greatest
from ....kit.periodic import resampled
from .analysis import LineForces


def _torques(forces: LineForces) -> Array:
    """Return the torques at the front ends of all shafts, then those at their rear ends."""
    front = [forces.drive_torque[:, None], forces.torsion_out]
    rear = [forces.torsion_in, -forces.load_torque[:, None]]
    return np.concatenate([*front, *rear], axis=1)[..., None]


COMPONENTS: Mapping[str, Callable[[LineForces], Array]] = MappingProxyType(
    {
        "torque": _torques,
        "torque_back": lambda forces: -_torques(forces),
        "bending_in": lambda forces: forces.moment_in[..., 1:],
        "bending_out": lambda forces: forces.moment_out[..., 1:],
        "bearing_radial": lambda forces: forces.bearing_force[..., 1:],
        "bearing_axial": lambda forces: forces.bearing_force[..., :1],
        "spline_friction": lambda forces: forces.spline_force[..., :1],
        "centring": lambda forces: forces.centring_force,
    }
)
"""Quantities to their components `(P, k, c)` in the forces of a turn."""
SIGNED = frozenset({"torque", "torque_back"})
"""Quantities of one component whose greatest value counts, those of all others their size."""
_CLOSE = 0.7
"""Part of the greatest size at the samples that a case has to reach there to be looked at in
between."""
_MOST_NUMBERS = 250_000
"""Numbers that are looked at together."""


def greatest_of(total: Array, *, signed: bool = False) -> Array:
    """Return the greatest sizes of vectors `(P, k, c)` at the samples; of signed ones, values."""
    sizes = total[..., 0] if signed else np.linalg.norm(total, axis=-1)
    return np.asarray(sizes.max(axis=0))


def greatest_over(factors: Array, components: Array, *, signed: bool = False) -> Array:
    """Return the greatest sizes over a period of sums of periodic vectors, `(cases, k)`.

    Of cases that are far from the greatest one of all, those at the samples.

    Args:
        factors: `(cases, causes)` of the vectors.
        components: `(causes, P, k, c)` of the vectors at equal steps, which determine them.
        signed: whether greatest values are meant, of vectors of one component.
    """
    result = np.empty((len(factors), components.shape[2]))
    for sizes, row in zip(result, factors, strict=True):
        sizes[:] = greatest_of(np.tensordot(row, components, 1), signed=signed)
    most = result.max(axis=0, initial=0.0)
    # Of what is no longer finite nothing can be said.
    is_near = (result >= _CLOSE * most) & (most > 0.0) & np.isfinite(most)
    cases, places = np.nonzero(is_near)
    # Squares have twice as many harmonics.
    fine = resampled(components, 2 * components.shape[1], 1)
    together = max(1, _MOST_NUMBERS // fine.shape[1])
    for start in range(0, len(cases), together):
        case, place = cases[start : start + together], places[start : start + together]
        total = np.einsum("ij,jpic->pic", factors[case], fine[:, :, place], optimize=True)
        total /= most[place, None]
        found, _ = greatest(total[..., 0] if signed else (total**2).sum(axis=-1))
        result[case, place] = (found if signed else np.sqrt(found)) * most[place]
    return result
