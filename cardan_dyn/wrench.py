"""Wrench: force and moment in a joint, split along and across its axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .coordinates import Array


@dataclass(frozen=True)
class JointWrench:
    """The wrench **exerted by the parent link on the child link**, at the joint origin.

    The parent of a loop's joint is its predecessor, the child its successor. Loads and drive
    efforts at the joint are part of it.

    Attributes:
        joint: name of the joint.
        frame: axes of all components: `joint` (fixed in the child), `parent` (fixed in the parent
            and equal to `joint` at coordinate zero) or `world`.
        force: `(N, 3)` [N].
        moment: `(N, 3)` [N·m].
        axis: unit axis of the joint in these axes, `(3,)`, or `(N, 3)` in `world`.
        unique: `(6,)` whether each component of force and moment, in the joint frame, follows
            from the equations of motion alone at every position. Where it is False, the value is
            the least-norm choice among those that satisfy them.
    """

    joint: str
    frame: str
    force: Array
    moment: Array
    axis: Array
    unique: Array

    @property
    def torsion(self) -> Array:
        """Moment along the joint axis `(N,)` [N·m], positive in the coordinate's sense."""
        return self._along(self.moment)

    @property
    def axial(self) -> Array:
        """Force along the joint axis `(N,)` [N], positive in the axis' sense."""
        return self._along(self.force)

    @property
    def bending(self) -> Array:
        """Size of the moment across the joint axis `(N,)` [N·m]."""
        return _norm(self.bending_vector)

    @property
    def shear(self) -> Array:
        """Size of the force across the joint axis `(N,)` [N]."""
        return _norm(self.shear_vector)

    @property
    def bending_vector(self) -> Array:
        """Moment across the joint axis `(N, 3)` [N·m], in the axes of `frame`."""
        return self._across(self.moment)

    @property
    def shear_vector(self) -> Array:
        """Force across the joint axis `(N, 3)` [N], in the axes of `frame`."""
        return self._across(self.force)

    def _along(self, vectors: Array) -> Array:
        return np.asarray(np.einsum("...i,...i->...", vectors, self.axis))

    def _across(self, vectors: Array) -> Array:
        # a × (v × a) loses no digits where v is almost parallel to the axis a.
        return np.asarray(np.cross(self.axis, np.cross(vectors, self.axis)))


def _norm(vectors: Array) -> Array:
    scale = np.max(np.abs(vectors), axis=-1, initial=0.0)
    safe = np.where(scale > 0.0, scale, 1.0)
    return np.asarray(
        safe * np.sqrt(np.sum((vectors / safe[..., None]) ** 2, axis=-1)) * (scale > 0.0)
    )
