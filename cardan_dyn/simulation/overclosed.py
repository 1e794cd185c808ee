"""Overclosed: accelerations of chains whose loops have redundant rows only while they are closed.

Bennett's linkage moves although its four hinges leave no freedom by count: three closure equations
follow from the others on closed positions, and nowhere else. Within a step of an integration states
are a little open, where all six equations are independent and leave the chain no motion: taken as
they are, accelerations jump with the size of the gap. Here the equations keep the rank that they
have where loops are closed, their weakest combinations left out, so that accelerations are smooth.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio

from ..arrays import Array

_ZERO = 1e-10
"""Singular value of the closure equations, as a fraction of their greatest, that counts as zero."""
_OPEN = 1e-3
"""Displacement [rad, or a fraction of the length] by which loops are opened to see their rank."""
_MOVED = (0.02, 0.05)
"""Displacements after which they are closed again to see it."""


class Overclosed:
    """Accelerations of a chain by the directions that its closed loops leave."""

    def __init__(
        self, model: Any, constraints: Any, couplings: Array, prescribed: Array, rank: int
    ) -> None:
        """Make it.

        Args:
            model: `pin.Model` of the chain, without armature.
            constraints: Pinocchio's constraints that close its loops.
            couplings: rows `(k, nv)` of its couplings.
            prescribed: velocity coordinates `(p,)` that are driven or held.
            rank: of the closure equations where loops are closed, along free coordinates.
        """
        self._model, self._data = model, model.createData()
        self._constraints, self._couplings = list(constraints), couplings
        self._prescribed, self._rank = prescribed, rank
        self._free = np.delete(np.arange(model.nv), prescribed)

    def accelerations(self, x: Array, v: Array, efforts: Array, prescribed: Array) -> Array:
        """Return the accelerations `(nv,)` that efforts cause.

        Args:
            x: configuration, closed up to a small drift.
            v: velocities `(nv,)`.
            efforts: along all coordinates `(nv,)`.
            prescribed: accelerations of the prescribed coordinates `(p,)`.
        """
        model, data, free = self._model, self._data, self._free
        inertia = np.triu(pinocchio.crba(model, data, x))
        inertia += np.triu(inertia, 1).T
        resisting = pinocchio.nonLinearEffects(model, data, x, v)
        a = np.zeros(model.nv)
        a[self._prescribed] = prescribed
        rows = self.jacobian(x)
        gains = -self._drift(x, v) - rows @ a
        left, values, right = np.linalg.svd(rows[:, free])
        rank = min(self._rank, int(np.count_nonzero(values > _ZERO * values[0])))
        a[free] = right[:rank].T @ ((left[:, :rank].T @ gains) / values[:rank])
        ways = right[rank:].T
        missing = (efforts - resisting - inertia @ a)[free]
        own = ways.T @ inertia[np.ix_(free, free)] @ ways
        a[free] += ways @ np.linalg.solve(own, ways.T @ missing)
        return a

    def rank(self, x: Array) -> int:
        """Return the rank of the closure equations along free coordinates at a configuration."""
        values = np.linalg.svd(self.jacobian(x)[:, self._free], compute_uv=False)
        return int(np.count_nonzero(values > _ZERO * np.max(values, initial=0.0)))

    def jacobian(self, x: Array) -> Array:
        """Return the rows `(6 L + k, nv)` of loops and couplings at a configuration."""
        model, data = self._model, self._data
        pinocchio.computeJointJacobians(model, data, x)
        rows = np.empty((6 * len(self._constraints) + len(self._couplings), model.nv))
        rows[6 * len(self._constraints) :] = self._couplings
        for index, item in enumerate(self._constraints):
            between = self._world_rows(item.joint1_id) - self._world_rows(item.joint2_id)
            frame = data.oMi[item.joint1_id] * item.joint1_placement
            rows[6 * index : 6 * index + 6] = frame.toActionMatrixInverse() @ between
        return rows

    def _world_rows(self, joint: int) -> Array:
        """Return the twist `(6, nv)` of a body per unit rate, in the world."""
        model, data = self._model, self._data
        if not joint:
            return np.zeros((6, model.nv))
        frame = pinocchio.ReferenceFrame.WORLD
        return np.asarray(pinocchio.getJointJacobian(model, data, joint, frame))

    def _drift(self, x: Array, v: Array) -> Array:
        """Return how fast the rows' products with constant rates change, `(6 L + k,)`."""
        model, data = self._model, self._data
        pinocchio.forwardKinematics(model, data, x, v, np.zeros(model.nv))
        result = np.zeros(6 * len(self._constraints) + len(self._couplings))
        for index, item in enumerate(self._constraints):
            first = _moving(data, item.joint1_id, item.joint1_placement)
            second = _moving(data, item.joint2_id, item.joint2_placement)
            between = first[0].actInv(second[0])
            rate = between.act(second[1])
            # The second body's rate is seen in axes that move with the first.
            change = first[2] - between.act(second[2]) + first[1].cross(rate)
            result[6 * index : 6 * index + 6] = change.vector
        return result


def _moving(data: Any, joint: int, placement: pinocchio.SE3) -> tuple[Any, Any, Any]:
    """Return placement, velocity and acceleration of a frame on a body, the latter in its axes."""
    return (
        data.oMi[joint] * placement,
        placement.actInv(data.v[joint]),
        placement.actInv(data.a[joint]),
    )


def overclosed_or_none(
    model: Any,
    constraints: Any,
    couplings: Array,
    prescribed: Array,
    state: Array,
    closed: Callable[[Array], Array],
) -> Overclosed | None:
    """Return how a chain moves if closure equations are redundant only where its loops are closed.

    Args:
        model: of the chain; its armature is left out.
        constraints: see `Overclosed`.
        couplings: see `Overclosed`.
        prescribed: see `Overclosed`.
        state: a closed configuration.
        closed: closes a configuration that is a little open.
    """
    if not len(constraints):
        return None
    model = model.copy()
    model.armature = np.zeros(model.nv)
    made_of = model, constraints, couplings, prescribed
    every = Overclosed(*made_of, rank=model.nv)
    free = np.delete(np.arange(model.nv), prescribed)
    ways = np.zeros((len(_MOVED) + 1, model.nv))
    ways[:, free] = np.random.default_rng(0).normal(size=(len(ways), free.size))

    def displaced(size: float, way: Array) -> Array:
        return np.asarray(pinocchio.integrate(model, state, size * way))

    opened = every.rank(displaced(_OPEN, ways[-1]))
    here = every.rank(state)
    if here == opened:
        return None
    # The state itself may be singular.
    moved = [closed(displaced(size, way)) for size, way in zip(_MOVED, ways, strict=False)]
    rank = max(here, *map(every.rank, moved))
    return None if rank == opened else Overclosed(*made_of, rank=rank)
