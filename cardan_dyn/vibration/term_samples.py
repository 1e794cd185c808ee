"""Term samples: the terms of the efforts at many places, and their scales."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from .efforts import FreeEfforts, Terms
from .rotating_scene import RotatingScene


class TermSamples:
    """Samples the terms of the efforts of one rotating scene, as columns.

    Attributes:
        rotating: the scene.
        efforts: of its free coordinates.
        free: their number n.
    """

    def __init__(self, rotating: RotatingScene) -> None:
        self.rotating, self.efforts = rotating, FreeEfforts(rotating)
        self.free = len(rotating.free)

    def at(self, drive: Array, q: Array) -> Array:
        """Return terms `(N, F)` at drive positions `(N,)` and free coordinates `(N, n)`."""
        return self.efforts.terms(np.column_stack([drive, q])).flat()

    def about(self, drive: Array, centre: Array, ways: Array) -> Array:
        """Return terms `(K, P, F)` at drive positions `(K,)`, at ways `(P, n)` from `(K, n)`."""
        q = (centre[:, None] + ways).reshape(-1, self.free)
        return self.at(np.repeat(drive, len(ways)), q).reshape(len(drive), len(ways), -1)

    def kinds(self, values: Array) -> Array:
        """Return the greatest of each kind of terms, as columns `(F,)`, of terms `(..., F)`."""
        terms = Terms.of_flat(values.reshape(-1, values.shape[-1]), self.free)
        # Speeds of the drive and of free coordinates differ in size: each has its own scale.
        scales = Terms(
            *(np.maximum(np.max(np.abs(item), axis=0, keepdims=True), 1e-300) for item in terms)
        )
        greatest = Terms(
            np.broadcast_to(np.max(scales.mass, axis=(2,), keepdims=True), scales.mass.shape),
            np.broadcast_to(
                np.max(scales.quadratic, axis=(2, 3), keepdims=True), scales.quadratic.shape
            ),
            np.broadcast_to(np.max(scales.linear, axis=2, keepdims=True), scales.linear.shape),
            scales.static,
        )
        columns = greatest.flat()[0]
        # What the mass matrix measures in is the least that velocity terms are compared with.
        mass = Terms.of_flat(columns, self.free).mass
        least = np.max(mass, axis=1)
        floor = Terms(
            np.broadcast_to(least[:, None], mass.shape)[None],
            np.broadcast_to(least[:, None, None], scales.quadratic.shape[1:])[None],
            np.full((1, *scales.linear.shape[1:]), 1e-300),
            np.full((1, self.free), 1e-300),
        )
        return np.maximum(columns, floor.flat()[0])
