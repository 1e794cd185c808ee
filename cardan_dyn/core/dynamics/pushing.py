"""Pushing: how what elements exert changes along a motion and with a number."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...kit.arrays import Array
from ...kit.differences import slope
from ..elements.element import Element
from ..elements.element_forces import Acted, ElementForces
from ..mechanism.mechanism import Mechanism
from .parameters import OfElement, OfOrigin, Parameter


class Pushing(NamedTuple):
    """What elements exert at samples.

    Attributes:
        mechanism: on which.
        elements: all of them.
        x, v: `(n, size)` and `(n, nv)` of the samples; angles count whole turns.
        time: `(n,)` or `(1,)`.
    """

    mechanism: Mechanism
    elements: tuple[Element, ...]
    x: Array
    v: Array
    time: Array

    def acted(self) -> Acted:
        """Return what they exert."""
        return ElementForces(self.mechanism, self.elements).at(self.x, self.v, self.time)

    def rows(self) -> Array:
        """Return it as rows `(k, n)`, in the order of `Prescribed`: efforts, wrenches on links."""
        acted = self.acted()
        every = [acted.efforts]
        every += [part for wrench in acted.wrenches for part in (wrench.force, wrench.moment)]
        count = len(acted.efforts)
        return np.concatenate([np.broadcast_to(part, (count, part.shape[1])).T for part in every])

    def along(self, parameter: Parameter | None, x: Array, v: Array) -> tuple[Array, Array]:
        """Return how far samples go, and how great what moves is, `(n,)` in units of all there is.

        Arguments as of `change`.
        """
        coordinates = self.mechanism.coordinates
        scale, rate_scale = coordinates.scale, 1.0 / coordinates.rate_scale
        fastest = np.maximum(1.0, np.abs(self.v * rate_scale).max(axis=1, initial=0.0))[:, None]
        ways, there = (
            np.abs(np.hstack([x * scale, v * rate_scale / fastest]))
            for x, v in ((x, v), (self.x, self.v))
        )
        far, size = ways.max(axis=1), (there * (ways > 0.0)).max(axis=1)
        if isinstance(parameter, OfOrigin):
            far[:] = np.max(far, initial=1.0 / parameter.unit)
            size += 1.0
        far[far == 0.0] = 1.0
        return far, size

    def change(self, parameter: Parameter | None, x: Array, v: Array) -> Array | float:
        """Return how the rows change with a parameter, or while the samples alone do; 0.0 if not.

        Args:
            parameter: which, if any.
            x: how coordinates change, `(n, size)`.
            v: how velocities do.
        """

        def moved(places: Array) -> Array:
            by = (places[:, None] / far)[..., None]
            many = self._replace(x=self.x + by * x, v=self.v + by * v)
            if isinstance(parameter, OfOrigin):
                ends = (places / far[0]).tolist()
                mechanisms = [parameter.displaced(self.mechanism, by) for by in ends]
                each = zip(mechanisms, many.x, many.v, strict=True)
                return np.stack([self._replace(mechanism=on, x=x, v=v).rows() for on, x, v in each])
            every = many._replace(
                x=many.x.reshape(-1, many.x.shape[-1]),
                v=many.v.reshape(-1, many.v.shape[-1]),
                time=np.tile(self.time, len(places)) if len(self.time) > 1 else self.time,
            ).rows()
            return np.moveaxis(every.reshape(len(every), len(places), -1), 1, 0)

        change: Array | float = 0.0
        if np.any(x) or np.any(v) or isinstance(parameter, OfOrigin):
            far, size = self.along(parameter, x, v)
            change = slope(moved, size) * far
        if isinstance(parameter, OfElement):
            more, less = (
                self._replace(elements=parameter.among(self.elements, end)).rows()
                for end in parameter.ends
            )
            return change + (more - less) / parameter.step
        return change
