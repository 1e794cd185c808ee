"""Scales: what errors of a response's functions are relative to, and what is mere rounding."""

from __future__ import annotations

import numpy as np

from ...kit.arrays import EPS, Array
from ..mechanism.mechanism import Mechanism
from ..proof.residuals import Residuals
from .columns import ACCELERATION, GRAVITY, SPEED_SQUARED, Layout

FEW_ROUNDINGS = 10.0 * EPS
"""Rounding of samples, of functions or changes that vanish by their scale, and of inertial terms by
condition number and cancellation. Measured: up to 3 eps of inertial terms, at bend angles from 1°
to 85° and in a line of three joints; 9 eps of samples in a Cardan joint."""
_LEAST_SCALE = 0.1
"""Least scale of a function, as a part of the greatest wrench of its column. Joints that carry
next to nothing would otherwise need digits that the samples do not have."""


class Scales:
    """Magnitudes of the functions of a response.

    Values are `(C, M)` samples of all functions, in the order of the layout. Forces are compared
    with moments after multiplication by the characteristic length.
    """

    def __init__(self, mechanism: Mechanism, layout: Layout) -> None:
        self._layout = layout
        self._lengths = np.repeat([mechanism.characteristic_length, 1.0], 3)
        mass = sum(float(inertia.mass) for inertia in mechanism.model.inertias)
        length = mechanism.characteristic_length
        rotors = mechanism.model.armature * mechanism.coordinates.rate_scale**2
        inertia = mass * length**2 + float(np.sum(rotors))
        terms = dict.fromkeys((SPEED_SQUARED, ACCELERATION), inertia)
        terms |= dict.fromkeys(GRAVITY, mass * length)
        # Weight or inertia at unit gravity, speed or acceleration.
        self._body_terms = np.array([terms.get(column, 0.0) for column in layout.columns])

    def of(self, values: Array) -> Array:
        """Return `(C,)` what errors of each function are relative to."""
        sizes, greatest = self._sizes(values), self._greatest(values)
        least = _LEAST_SCALE * np.where(greatest > 0.0, greatest, 1.0)[:, None]
        scales = np.maximum(sizes, least)
        wrenches, _ = self._layout.split(scales)
        wrenches /= self._lengths
        return scales.ravel()

    def empty(self, values: Array) -> Array:
        """Return `(C,)` which functions are nothing but the rounding of weight or inertia."""
        return (self._sizes(values) <= EPS * self._body_terms[:, None]).ravel()

    def cancellation(self, values: Array, proven: Residuals) -> float:
        """Return by how much inertial terms exceed what is left of them at constant speed.

        Args:
            values: at some of the positions of `proven`.
            proven: residuals of the scene at unit rates, with its inertial terms.
        """
        greatest = dict(zip(self._layout.columns, self._greatest(values).tolist(), strict=True))
        remaining = greatest.get(SPEED_SQUARED, 0.0)
        return 1.0 + (float(np.max(proven.inertia)) / remaining if remaining else 0.0)

    def rounding(self, cancellation: float, condition: float) -> Array:
        """Return `(C,)` what the rounding of inertial terms adds to each function, by its scale.

        Only the column `speed²` has any: it is a small difference of inertial terms where these
        nearly cancel, and keeps their rounding.
        """
        size = FEW_ROUNDINGS * condition * cancellation
        is_inertial = [column == SPEED_SQUARED for column in self._layout.columns]
        return np.repeat(size * np.array(is_inertial, dtype=float), self._layout.size)

    def _greatest(self, values: Array) -> Array:
        """Return the greatest wrench or effort of each column, forces times the length."""
        return np.asarray(np.max(self._sizes(values), axis=1, initial=0.0))

    def _sizes(self, values: Array) -> Array:
        """Return `(columns, functions)` greatest sizes, of wrenches that of all their components.

        Forces are multiplied by the length.
        """
        shape = len(self._layout.columns), self._layout.size
        sizes = np.max(np.abs(values), axis=1).reshape(shape)
        wrenches, _ = self._layout.split(sizes)
        wrenches[:] = np.max(wrenches * self._lengths, axis=2, keepdims=True, initial=0.0)
        return sizes
