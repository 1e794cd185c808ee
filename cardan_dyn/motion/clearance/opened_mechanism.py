"""Opened mechanism: what a mechanism can do where clearance gives some of its joints more freedom.

Freedoms are added before turning joints, all other joints and loops stay closed, and the ways that
are left carry the inertia of what they move.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import pinocchio

from ...core.mechanism.joints import Part
from ...core.mechanism.mechanism import Mechanism
from ...kit.arrays import NOTHING, Array
from ..simulation.closed_directions import ClosedDirections, CouplingRows

_WEIGHTLESS = 1e-13
"""Inertia of a way, as a fraction of the greatest of any coordinate, that counts as none."""

Freedoms = Sequence[tuple[str, Array]]
"""Kinds, `prismatic` or `revolute`, and unit axes in the joint's frame; the parent's side first."""


def across(axis: Array) -> tuple[Array, Array]:
    """Return two unit vectors across an axis; with it they are right-handed."""
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    return first, np.cross(axis, first)


class Ways(NamedTuple):
    """How an opened mechanism can move at one position.

    Attributes:
        rates: `(nv, f)` velocities of the opened mechanism's coordinates per unit of each way.
        inertia: `(f, f)` of the ways.
        rounding: of the inertias of ways: those up to it may be none at all.
    """

    rates: Array
    inertia: Array
    rounding: float


class OpenedMechanism:
    """A mechanism with freedoms before some of its turning parts.

    Redundant closure equations do no harm: what moves are the ways that they leave.

    Attributes:
        added: body of a part in the mechanism to the velocity coordinates of its freedoms.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        freedoms: Mapping[int, Freedoms],
        fixed: Sequence[int],
        rotors: Mapping[int, float],
        closed: Mapping[int, Array] | None = None,
    ) -> None:
        """Open a mechanism.

        Args:
            mechanism: to be opened.
            freedoms: body of a turning part to what is added before it.
            fixed: velocity coordinates of the mechanism that are driven or held.
            rotors: velocity coordinates that move freely to inertias that turn with them [kg m²].
            closed: body of a part to rows `(k, freedoms)` of combinations that stay zero.
        """
        self._length = mechanism.characteristic_length
        model, self._own = _opened(mechanism, freedoms)
        columns, self.added, moved = _layout(mechanism, freedoms)
        armature = np.zeros(model.nv)
        armature[moved] = mechanism.model.armature
        for index, inertia in rotors.items():
            armature[moved[index]] += inertia
        model.armature = armature
        places = np.insert(np.ones(mechanism.coordinates.size, dtype=bool), columns, False)
        self._columns = np.nonzero(places)[0]
        self._moved = moved
        constraints = [
            loop._replace(
                predecessor=self._own[loop.predecessor], successor=self._own[loop.successor]
            ).constraint(model)
            for loop in mechanism.loops
        ]
        rows = np.zeros((len(mechanism.couplings), model.nv))
        for row, coupling in zip(rows, mechanism.couplings, strict=True):
            row[[moved[index] for index in coupling.predecessor_columns]] += coupling.ratio
            row[[moved[index] for index in coupling.successor_columns]] -= 1.0
        none = np.array([], dtype=int)
        self._closure = ClosedDirections(
            model, constraints, CouplingRows(rows), none, rank=model.nv
        )
        self._free = np.delete(np.arange(model.nv), [moved[index] for index in fixed])
        self._scale = self._scales(mechanism, freedoms, moved)
        self._kept = np.zeros((0, model.nv))
        for body, combinations in (closed or {}).items():
            kept = np.zeros((len(combinations), model.nv))
            kept[:, self.added[body]] = combinations
            self._kept = np.concatenate([self._kept, kept * self._scale / self._length])
        self._upper = np.triu(np.ones((model.nv, model.nv)), 1) + 0.5 * np.eye(model.nv)
        self._model, self._data = model, model.createData()

    def _scales(
        self, mechanism: Mechanism, freedoms: Mapping[int, Freedoms], moved: list[int]
    ) -> Array:
        """Return lengths `(nv,)` that compare slides with angles."""
        scale = np.ones(len(moved) + sum(len(items) for items in freedoms.values()))
        slides = np.nonzero(mechanism.coordinates.rate_scale != 1.0)[0].tolist()
        scale[[moved[index] for index in slides]] = self._length
        for body, items in freedoms.items():
            is_slide = np.array([kind == "prismatic" for kind, _ in items])
            scale[self.added[body][is_slide]] = self._length
        return scale

    def ways(self, x: Array) -> Ways:
        """Return how it can move; `rotation` and `axis` are of the same position afterwards.

        Args:
            x: `(size,)` closed coordinates of the mechanism.
        """
        x = self._with_freedoms(x)
        pinocchio.forwardKinematics(self._model, self._data, x)
        # Of a symmetric matrix, its upper half alone is sure to be there.
        half = self._upper * pinocchio.crba(self._model, self._data, x)
        inertia = half + half.T
        rows = self._closure.jacobian(x) * self._scale
        rows[: len(rows) // 6 * 6].reshape(-1, 6, rows.shape[1])[:, :3] /= self._length
        rows = np.concatenate([rows, self._kept])
        _, values, right = np.linalg.svd(rows[:, self._free])
        rank = int(np.count_nonzero(values > NOTHING * np.max(values, initial=0.0)))
        ways = np.zeros((len(self._scale), len(self._free) - rank))
        ways[self._free] = right[rank:].T
        ways *= self._scale[:, None]
        # What is left of the inertias of all coordinates where a way has none.
        greatest = np.max(np.diag(inertia)[self._free] * self._scale[self._free] ** 2, initial=0.0)
        return Ways(ways, ways.T @ inertia @ ways, _WEIGHTLESS * float(greatest))

    def _with_freedoms(self, x: Array) -> Array:
        """Return coordinates of the opened mechanism, those that were added being zero."""
        found = np.zeros(self._model.nq)
        found[self._columns] = x
        return found

    @property
    def size(self) -> int:
        """Number of velocity coordinates."""
        return int(self._model.nv)

    def velocity(self, v: Array) -> Array:
        """Return velocities `(..., nv)` of the opened mechanism for those of the closed one."""
        found = np.zeros((*v.shape[:-1], self._model.nv))
        found[..., self._moved] = v
        return found

    def coriolis(self, x: Array, along: Array, ways: Array, changes: Array) -> Array:
        """Return forces `(nv, f)` on coordinates per unit of each way's rate and of the drive's.

        Args:
            x: `(size,)` closed coordinates of the mechanism.
            along: `(nv,)` velocities of the motion of the drive alone, per unit of its rate.
            ways: `(nv, f)` velocities per unit of the rate of each way.
            changes: `(nv, f)` derivatives of these by the drive's position.
        """
        x, still = self._with_freedoms(x), np.zeros(self._model.nv)
        found = np.empty_like(ways)

        def force(v: Array, a: Array) -> Array:
            return np.array(pinocchio.rnea(self._model, self._data, x, v, a))

        alone = force(along, still)
        for k, (way, change) in enumerate(zip(ways.T, changes.T, strict=True)):
            # The velocities of the drive alone change with a way as those of the way with the
            # drive, but for turns of balls, which do not commute.
            bend = 2.0 * change
            for start in self._balls:
                part = slice(start, start + 3)
                bend[part] += np.cross(along[part], way[part])
            found[:, k] = force(along + way, bend) - alone - force(way, still)
        return found

    @cached_property
    def _balls(self) -> list[int]:
        """First velocity coordinates of joints that turn about a point."""
        model = self._model
        return [
            model.idx_vs[index]
            for index in range(1, model.njoints)
            if model.nvs[index] == 3 and model.nqs[index] == 4
        ]

    def rotation(self, body: int) -> Array:
        """Return the rotation `(3, 3)` from the frame of what was added before a part to the world.

        It stays with the part's parent.
        """
        return np.asarray(self._data.oMi[self._own[body] - len(self.added[body])].rotation)

    def axis(self, part: Part) -> Array:
        """Return a part's axis `(3,)` in the world."""
        return np.asarray(self._data.oMi[self._own[part.id]].rotation @ part.axis)


def _layout(
    mechanism: Mechanism, freedoms: Mapping[int, Freedoms]
) -> tuple[list[int], dict[int, Array], list[int]]:
    """Return where zeros are inserted into a row, added rates by body, and where others went."""
    columns: list[int] = []
    added: dict[int, Array] = {}
    moved = list(range(mechanism.model.nv))
    coordinates = mechanism.coordinates
    count = 0
    for part, start in zip(coordinates.parts, coordinates.starts, strict=True):
        items = freedoms.get(part.id, ())
        first = mechanism.model.idx_vs[part.id]
        if items:
            added[part.id] = first + count + np.arange(len(items))
            columns += [start] * len(items)
            count += len(items)
        for index in range(first, first + part.nv):
            moved[index] = index + count
    return columns, added, moved


def _opened(mechanism: Mechanism, freedoms: Mapping[int, Freedoms]) -> tuple[Any, dict[int, int]]:
    """Return the model with freedoms before some parts, and where its bodies are in it."""
    source, model, own = mechanism.model, pinocchio.Model(), {0: 0}
    for part in mechanism.coordinates.parts:
        index = part.id
        joint, placement = source.joints[index], source.jointPlacements[index]
        parent = own[source.parents[index]]
        for kind, axis in freedoms.get(index, ()):
            joints = pinocchio.JointModelPrismaticUnaligned, pinocchio.JointModelRevoluteUnaligned
            freedom = joints[kind == "revolute"](axis)
            parent = model.addJoint(parent, freedom, placement, f"play_{model.njoints}")
            placement = pinocchio.SE3.Identity()
        if part.kind == "revolute":
            joint = pinocchio.JointModelRevoluteUnaligned(part.axis)
        own[index] = model.addJoint(parent, joint, placement, source.names[index])
        model.inertias[own[index]] = source.inertias[index]
    model.gravity.linear = np.zeros(3)
    return model, own
