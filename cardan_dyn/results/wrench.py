"""Wrench: force and moment in a joint, split along and across its axis."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from ..arrays import Array
from ..frozen import read_only


class Components(Protocol):
    """Where a wrench takes its components from: 0 … 2 of the force, 3 … 5 of the moment."""

    def component(self, index: int) -> Array:
        """Return a component `(N,)`."""
        ...

    def vector(self, first: int) -> Array:
        """Return three components, from the `first` on, `(N, 3)`."""
        ...

    def vanishes(self, index: int) -> bool:
        """Return whether a component is zero throughout."""
        ...


@dataclass(frozen=True, eq=False)
class GivenComponents:
    """Components that are all there, `(N, 6)`."""

    values: Array

    def component(self, index: int) -> Array:
        """Return a component `(N,)`."""
        return self.values[..., index]

    def vector(self, first: int) -> Array:
        """Return three components, from the `first` on, `(N, 3)`."""
        return self.values[..., first : first + 3]

    def vanishes(self, index: int) -> bool:
        """Return whether a component is zero throughout."""
        return not np.any(self.values[..., index])


@dataclass(frozen=True, eq=False)
class JointWrench:
    """The wrench **exerted by the parent link on the child link**, at the joint origin.

    The parent of a loop's joint is its predecessor, the child its successor. Loads and drive
    efforts at the joint are part of it.

    Attributes:
        joint: name of the joint.
        frame: axes of all components: `joint` (fixed in the child), `parent` (fixed in the parent
            and equal to `joint` at coordinate zero) or `world`.
        components: where its components come from.
        axis: unit axis of the joint in these axes, `(3,)`, or `(N, 3)` in `world`.
        unique: `(6,)` whether each component of force and moment, in the joint frame, follows
            from the equations of motion alone at every position. Where it is False, the value is
            the one of least norm, or least elastic energy, among those that satisfy them.
    """

    joint: str
    frame: str
    components: Components
    axis: Array
    unique: Array

    @cached_property
    def force(self) -> Array:
        """Force `(N, 3)` [N]."""
        return read_only(self.components.vector(0))

    @cached_property
    def moment(self) -> Array:
        """Moment `(N, 3)` [N·m]."""
        return read_only(self.components.vector(3))

    @property
    def torsion(self) -> Array:
        """Moment along the joint axis `(N,)` [N·m], positive in the coordinate's sense."""
        return self._along(3)

    @property
    def axial(self) -> Array:
        """Force along the joint axis `(N,)` [N], positive in the axis' sense."""
        return self._along(0)

    @property
    def bending(self) -> Array:
        """Size of the moment across the joint axis `(N,)` [N·m]."""
        return self._size_across(3)

    @property
    def shear(self) -> Array:
        """Size of the force across the joint axis `(N,)` [N]."""
        return self._size_across(0)

    @property
    def bending_vector(self) -> Array:
        """Moment across the joint axis `(N, 3)` [N·m], in the axes of `frame`."""
        return self._across(self.moment)

    @property
    def shear_vector(self) -> Array:
        """Force across the joint axis `(N, 3)` [N], in the axes of `frame`."""
        return self._across(self.force)

    def _along(self, first: int) -> Array:
        if self.axis.ndim == 1:
            return self._sum(first, self.axis)
        vectors = self.moment if first else self.force
        return np.asarray(np.einsum("...i,...i->...", vectors, self.axis))

    def _across(self, vectors: Array) -> Array:
        # a × (v × a) loses no digits where v is almost parallel to the axis a.
        return np.asarray(np.cross(self.axis, np.cross(vectors, self.axis)))

    def _size_across(self, first: int) -> Array:
        if self.axis.ndim > 1:
            return _norm(self._across(self.moment if first else self.force))
        one = np.cross(self.axis, np.eye(3)[np.argmin(np.abs(self.axis))])
        one /= np.linalg.norm(one)
        ways = [one, np.cross(self.axis, one)]
        # In a Cardan joint one of the two is zero throughout.
        ways = [way for way in ways if not self._vanishes(first, way)] or ways[:1]
        parts = [self._sum(first, way) for way in ways]
        return np.asarray(np.hypot(*parts) if len(parts) == 2 else np.abs(parts[0]))

    def _vanishes(self, first: int, direction: Array) -> bool:
        return all(self.components.vanishes(first + int(axis)) for axis in np.nonzero(direction)[0])

    def _sum(self, first: int, direction: Array) -> Array:
        """Return components along a constant direction; most directions are frame axes."""
        (axes,) = np.nonzero(direction)
        parts = [
            part if direction[axis] == 1.0 else part * direction[axis]
            for axis in axes
            for part in [self.components.component(first + int(axis))]
        ]
        return np.asarray(sum(parts[1:], parts[0]))


def _norm(vectors: Array) -> Array:
    scale = np.max(np.abs(vectors), axis=-1, initial=0.0)
    safe = np.where(scale > 0.0, scale, 1.0)
    return np.asarray(
        safe * np.sqrt(np.sum((vectors / safe[..., None]) ** 2, axis=-1)) * (scale > 0.0)
    )
