"""Opened mechanism: what a mechanism can do where clearance gives some of its joints more freedom.

Freedoms are added before turning joints, all other joints and loops stay closed, and the ways that
are left carry the inertia of what they move.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pinocchio

from ...core.mechanism.joints import Part
from ...core.mechanism.mechanism import Mechanism
from ...kit.arrays import NOTHING, ROUNDED, Array
from ..simulation.closed_directions import ClosedDirections, CouplingRows

_KINDS = {
    "prismatic": pinocchio.JointModelPrismaticUnaligned,
    "revolute": pinocchio.JointModelRevoluteUnaligned,
}

Freedoms = Sequence[tuple[str, Array]]
"""Kinds, `prismatic` or `revolute`, and unit axes in the joint's frame; the parent's side first."""


def across(axis: Array) -> tuple[Array, Array]:
    """Return two unit vectors across an axis; with it they are right-handed."""
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    return first, np.cross(axis, first)


class OpenedMechanism:
    """A mechanism with freedoms before some of its turning parts.

    Redundant closure equations do no harm: what moves are the ways that they leave.

    Attributes:
        added: body of a part in the mechanism to the velocity coordinates of its freedoms.
        size: number of velocity coordinates.
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
        source, model = mechanism.model, pinocchio.Model()
        self._length = mechanism.characteristic_length
        self._own = own = {0: 0}
        self.added: dict[int, Array] = {}
        columns: list[int] = []
        moved: list[int] = []
        slides: list[int] = []
        for part in mechanism.coordinates.parts:
            index, placement = part.id, source.jointPlacements[part.id]
            parent, begun = own[source.parents[index]], model.nv
            for kind, axis in freedoms.get(index, ()):
                slides += [model.nv] * (kind == "prismatic")
                parent = model.addJoint(parent, _KINDS[kind](axis), placement, f"play_{model.nv}")
                placement = pinocchio.SE3.Identity()
            if model.nv > begun:
                self.added[index] = np.arange(begun, model.nv)
            joint = source.joints[index]
            if part.kind == "revolute":
                joint = _KINDS[part.kind](part.axis)
            columns += range(model.nq, model.nq + joint.nq)
            moved += range(model.nv, model.nv + joint.nv)
            own[index] = model.addJoint(parent, joint, placement, source.names[index])
            model.inertias[own[index]] = source.inertias[index]
        self._columns, self._moved, self.size = columns, moved, int(model.nv)
        model.gravity.linear = np.zeros(3)
        armature = mechanism.model.armature.copy()
        for rate, inertia in rotors.items():
            armature[rate] += inertia
        model.armature = self.velocity(armature)
        constraints = [
            loop._replace(
                predecessor=own[loop.predecessor], successor=own[loop.successor]
            ).constraint(model)
            for loop in mechanism.loops
        ]
        rows = np.zeros((len(mechanism.couplings), mechanism.model.nv))
        for row, coupling in zip(rows, mechanism.couplings, strict=True):
            row[list(coupling.predecessor_columns)] += coupling.ratio
            row[list(coupling.successor_columns)] -= 1.0
        self._closure = ClosedDirections(
            model,
            constraints,
            CouplingRows(self.velocity(rows)),
            np.array(moved, dtype=int)[list(fixed)],
            rank=model.nv,
        )
        # Lengths that compare slides with angles.
        self._scale = self.velocity(mechanism.coordinates.rate_scale)
        self._scale[self._scale == 0.0] = 1.0
        self._scale[slides] = self._length
        self._kept = np.zeros((0, model.nv))
        for body, combinations in (closed or {}).items():
            kept = np.zeros((len(combinations), model.nv))
            kept[:, self.added[body]] = combinations
            self._kept = np.concatenate([self._kept, kept * self._scale / self._length])
        self._model, self._data = model, model.createData()

    def ways(self, x: Array) -> Array:
        """Return the ways in which it can move, as velocities `(nv, f)` of its coordinates.

        `rotation`, `axis` and `centre` are of the same position afterwards.

        Args:
            x: `(size,)` closed coordinates of the mechanism.
        """
        x = self._with_freedoms(x)
        pinocchio.forwardKinematics(self._model, self._data, x)
        free = self._closure.free
        rows = self._closure.jacobian(x) * self._scale
        rows[: self._closure.loop_rows].reshape(-1, 6, self.size)[:, :3] /= self._length
        rows = np.concatenate([rows, self._kept])
        _, values, right = np.linalg.svd(rows[:, free])
        rank = int(np.count_nonzero(values > NOTHING * np.max(values, initial=0.0)))
        ways = np.zeros((self.size, len(free) - rank))
        ways[free] = self._scale[free, None] * right[rank:].T
        return ways

    def inertia(self, x: Array, ways: Array) -> tuple[Array, float]:
        """Return the inertia `(f, f)` of ways, and what of it may be rounding of none at all.

        Args:
            x: `(size,)` closed coordinates of the mechanism.
            ways: `(nv, f)` at the same position.
        """
        free, inertia = self._closure.free, self._closure.metric(self._with_freedoms(x))
        # What is left of the inertias of all coordinates where a way has none.
        greatest = np.max(np.diag(inertia) * self._scale[free] ** 2, initial=0.0)
        return ways[free].T @ inertia @ ways[free], ROUNDED * float(greatest)

    def _with_freedoms(self, x: Array) -> Array:
        """Return coordinates of the opened mechanism, those that were added being zero."""
        found = np.zeros(self._model.nq)
        found[self._columns] = x
        return found

    def velocity(self, v: Array) -> Array:
        """Return velocities `(..., nv)` of the opened mechanism for those of the closed one."""
        found = np.zeros((*v.shape[:-1], self.size))
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
        x, still = self._with_freedoms(x), np.zeros(self.size)

        def force(v: Array, a: Array) -> Array:
            return np.array(pinocchio.rnea(self._model, self._data, x, v, a))

        alone, found = force(along, still), np.empty_like(ways)
        for k, (way, change) in enumerate(zip(ways.T, changes.T, strict=True)):
            # The velocities of the drive alone change with a way as those of the way with the
            # drive, but for turns of balls, which do not commute.
            bend = 2.0 * change
            for start, count in zip(self._model.idx_vs, self._model.nvs, strict=True):
                if count == 3:
                    part = slice(start, start + 3)
                    bend[part] += np.cross(along[part], way[part])
            found[:, k] = force(along + way, bend) - alone - force(way, still)
        return found

    def rotation(self, body: int) -> Array:
        """Return the rotation `(3, 3)` from the frame of what was added before a part to the world.

        It stays with the part's parent.
        """
        return np.asarray(self._data.oMi[self._own[body] - len(self.added[body])].rotation)

    def axis(self, part: Part) -> Array:
        """Return a part's axis `(3,)` in the world."""
        return np.asarray(self._data.oMi[self._own[part.id]].rotation @ part.axis)

    def centre(self, part: Part) -> Array:
        """Return where a part is `(3,)` in the world [m]."""
        return np.array(self._data.oMi[self._own[part.id]].translation)
