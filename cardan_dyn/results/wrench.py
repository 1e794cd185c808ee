"""Wrench: force and moment in a joint, split along and across its axis."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple, Protocol

import numpy as np

from ..arrays import Array
from ..errors import ModelError
from ..frozen import read_only

WITHOUT_AXIS = frozenset({"spherical", "floating", "fixed"})
"""Types of joints that have no axis: what a description says of one means nothing."""
_Direction = tuple[tuple[int, float], ...]
"""A constant vector: the axes along which it has a component, with the components."""


def named_components(flags: Array) -> str:
    """Return flagged components `(6,)` as text, for example `force z, moment xy`."""
    vectors = [
        f"{name} {''.join(axis for axis, flag in zip('xyz', flagged, strict=True) if flag)}"
        for name, flagged in (("force", flags[:3]), ("moment", flags[3:]))
        if np.any(flagged)
    ]
    return ", ".join(vectors)


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


class StoredComponents(NamedTuple):
    """Components that were computed before.

    Attributes:
        values: `(N, 6)`.
    """

    values: Array

    def component(self, index: int) -> Array:
        """Return a component `(N,)`."""
        return self.values[..., index]

    def vector(self, first: int) -> Array:
        """Return three components, from the `first` on, `(N, 3)`."""
        return self.values[..., first : first + 3]

    def vanishes(self, index: int) -> bool:
        """Return whether a component is zero throughout."""
        return not self.values[..., index].any()


@dataclass(frozen=True, eq=False, repr=False)
class JointWrench:
    """The wrench **exerted by the parent link on the child link**, at the joint origin.

    The parent of a loop's joint is its predecessor, the child its successor. Loads and drive
    efforts at the joint are part of it.

    Attributes:
        joint: name of the joint.
        frame: axes of all components: `joint` (fixed in the child), `parent` (fixed in the parent
            and equal to `joint` at coordinate zero) or `world`.
    """

    joint: str
    frame: str
    _components: Components
    _axis: Array | None
    _flags: Callable[[], Array]

    @property
    def has_axis(self) -> bool:
        """Whether the joint has an axis: balls, floating and fixed joints have none."""
        return self._axis is not None

    @property
    def axis(self) -> Array:
        """Unit axis of the joint in these axes, `(3,)`.

        It is `(N, 3)` where it turns: in `world`, and in `parent` for `universal` joints.

        Raises:
            ModelError: the joint has no axis: it is a ball, floats or is fixed.
        """
        if self._axis is None:
            raise ModelError(
                f"joint {self.joint!r} has no axis, so that nothing is along or across it; use "
                ".force and .moment, or name the axes that are meant: "
                f"sweep.wrench({self.joint!r}, 'parent')",
                name=self.joint,
            )
        return self._axis

    @cached_property
    def unique(self) -> Array:
        """Whether each component follows from the equations of motion alone, `(6,)`.

        Force, then moment, in the axes of `frame`, at every position. Where it is False, the value
        is the one of least norm, or least elastic energy, among those that satisfy them.
        """
        return self._flags()

    def __repr__(self) -> str:
        shape = " × ".join(str(size) for size in self.moment.shape[:-1])
        greatest = float(np.max(_norm(self.moment), initial=0.0))
        chosen = "" if np.all(self.unique) else f", not unique: {named_components(~self.unique)}"
        return (
            f"<JointWrench of {self.joint!r} in {self.frame} axes: {shape} samples, "
            f"moment up to {greatest:.4g} N·m{chosen}>"
        )

    @cached_property
    def force(self) -> Array:
        """Force `(N, 3)` [N]."""
        return read_only(self._components.vector(0))

    @cached_property
    def moment(self) -> Array:
        """Moment `(N, 3)` [N·m]."""
        return read_only(self._components.vector(3))

    @property
    def torsion(self) -> Array:
        """Moment along the joint axis `(N,)` [N·m], positive in the coordinate's sense."""
        return self._along(3)

    @property
    def axial(self) -> Array:
        """Force along the joint axis `(N,)` [N], positive in the sense of the axis.

        It is the axial load of a bearing.
        """
        return self._along(0)

    @property
    def bending(self) -> Array:
        """Size of the moment across the joint axis `(N,)` [N·m]."""
        return self._size_across(3)

    @property
    def shear(self) -> Array:
        """Size of the force across the joint axis `(N,)` [N]: the radial load of a bearing."""
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
        """Return the component along the axis, of the force (`first` 0) or the moment (3)."""
        if self.axis.ndim == 1:
            return self._sum(first, _components_of(self.axis))
        vectors = self.moment if first else self.force
        return np.asarray(np.einsum("...i,...i->...", vectors, self.axis))

    def _across(self, vectors: Array) -> Array:
        """Return the part of vectors across the axis."""
        # a × (v × a) loses no digits where v is almost parallel to the axis a.
        return np.asarray(np.cross(self.axis, np.cross(vectors, self.axis)))

    def _size_across(self, first: int) -> Array:
        """Return the size across the axis, of the force (`first` 0) or the moment (3)."""
        if self.axis.ndim > 1:
            return _norm(self._across(self.moment if first else self.force))
        directions = _directions_across(*self.axis.tolist())
        # In a Cardan joint one of the two components is zero throughout, which spares its
        # evaluation and the square root.
        vanishes = self._components.vanishes
        acting = [
            item for item in directions if not all(vanishes(first + axis) for axis, _ in item)
        ]
        components = [self._sum(first, item) for item in acting or directions[:1]]
        return np.asarray(np.hypot(*components) if len(acting) == 2 else np.abs(components[0]))

    def _sum(self, first: int, direction: _Direction) -> Array:
        """Return the component along a constant direction; most directions are frame axes."""
        terms = [self._term(first + axis, factor) for axis, factor in direction]
        return np.asarray(sum(terms[1:], terms[0]))

    def _term(self, index: int, factor: float) -> Array:
        """Return a component times a factor; frame axes need no product."""
        values = self._components.component(index)
        return values if factor == 1.0 else values * factor


def _components_of(vector: Array) -> _Direction:
    """Return the axes along which a vector `(3,)` has a component, with the components."""
    return tuple((axis, value) for axis, value in enumerate(vector.tolist()) if value)


@lru_cache(maxsize=1024)
def _directions_across(x: float, y: float, z: float) -> tuple[_Direction, _Direction]:
    """Return two unit vectors across an axis and each other."""
    axis = np.array([x, y, z])
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    across /= np.linalg.norm(across)
    return _components_of(across), _components_of(np.cross(axis, across))


def _norm(vectors: Array) -> Array:
    """Return lengths `(...)` of vectors `(..., 3)`, whose squares may overflow or vanish."""
    scale = np.max(np.abs(vectors), axis=-1, initial=0.0)
    safe = np.where(scale > 0.0, scale, 1.0)
    return np.asarray(
        safe * np.sqrt(np.sum((vectors / safe[..., None]) ** 2, axis=-1)) * (scale > 0.0)
    )
