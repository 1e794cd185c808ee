"""Idle spins: the accelerations of idle rods about their lines.

Their joints pass no moment about the line, so that gravity and inertia alone turn such a rod. Its
acceleration follows from that, whatever rates it has. Closure forces do no work on a spin, so the
wrenches of the open tree suffice.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..arrays import Array
from ..errors import MobilityError, choices
from ..kinematics.closing.all_groups import ClosedState
from ..kinematics.closing.group_solver import GroupState
from .open_tree import Along, LoadCase, OpenTree

_MASSLESS = 1e-14
"""Inertia against a spin, relative to all masses at the characteristic length, up to which it is
the rounding of other inertias: such a rod is balanced at any acceleration, and does not spin."""

_BALANCED = 1e-9
"""Moment about the line of a rod without inertia, as a fraction of the greatest wrench, up to which
it is the rounding of forces that pass through the line."""


class IdleSpins:
    """Accelerations of all idle rods."""

    def __init__(self, tree: OpenTree, along: Along, greatest: float) -> None:
        """Prepare the computation.

        Args:
            tree: of all bodies.
            along: all velocity coordinates.
            greatest: all masses at the characteristic length [kg·m²].
        """
        self._least = _MASSLESS * greatest
        self._tree = tree
        self._along = along

    def added(self, state: ClosedState, cases: Sequence[LoadCase], wrenches: Array) -> Array:
        """Add the inertia of all spins to wrenches, and return the accelerations.

        Args:
            state: closed positions.
            cases: c load cases.
            wrenches: `(N, b, 6, c)` of the open tree at rates without spins; changed.

        Returns:
            `(N, nv, c)`.

        Raises:
            MobilityError: a moment acts about the line of a rod that has no inertia about it.
        """
        result = np.zeros((len(state.x), len(self._along), len(cases)))
        if not any(case.dynamics or case.link_loads or np.any(case.loads) for case in cases):
            return result
        loads = np.stack([np.broadcast_to(case.loads, result.shape[:2]) for case in cases], axis=2)
        for group_state in state.groups:
            if group_state.group.idle:
                self._add(state, group_state, loads, wrenches, result, cases[0].inertia)
        return result

    def _add(
        self,
        state: ClosedState,
        group_state: GroupState,
        loads: Array,
        wrenches: Array,
        accelerations: Array,
        factors: Mapping[str, Array],
    ) -> None:
        """Add the spins of one group to wrenches and accelerations of all.

        Args:
            state: closed positions.
            group_state: of the group.
            loads: efforts at the joints `(N, nv, c)`.
            wrenches: see `added`; changed.
            accelerations: likewise.
            factors: on the inertia of links, the same in all cases.
        """
        passives = group_state.group.passives
        idle = group_state.idle * np.isin(passives, list(_columns(group_state)))[:, None]
        left = np.swapaxes(idle, -1, -2)
        moments = left @ (loads[:, passives] - self._along.efforts(wrenches, passives))
        if not np.any(moments):
            return
        unit_wrenches = self._inertia_of(state, passives, idle, wrenches.shape[1], factors)
        inertia = left @ self._along.efforts(unit_wrenches, passives)
        values, vectors = np.linalg.eigh(0.5 * (inertia + np.swapaxes(inertia, -1, -2)))
        counts = values > self._least
        along = np.swapaxes(vectors, -1, -2) @ moments
        unbalanced = np.abs(along) * ~counts[:, :, None]
        if np.max(unbalanced) > _BALANCED * np.max(np.abs(wrenches)):
            names = group_state.solver.coordinates.names_of(_columns(group_state))
            raise MobilityError(
                f"a load acts about the line of an idle rod without inertia ({choices(names)}), "
                "which nothing can hold; give the rod mass, take the load off, or drive or hold "
                "its spin",
                free=names,
            )
        reciprocal = np.divide(1.0, values, out=np.zeros_like(values), where=counts)
        spins = vectors @ (reciprocal[:, :, None] * along)
        wrenches += np.einsum("nbik,nkc->nbic", unit_wrenches, spins)
        accelerations[:, passives] += idle @ spins

    def _inertia_of(
        self,
        state: ClosedState,
        passives: Array,
        idle: Array,
        size: int,
        factors: Mapping[str, Array],
    ) -> Array:
        """Return wrenches `(N, b, 6, k)` that unit accelerations along k spins need."""
        none = np.zeros((1, len(self._along)))
        rest = np.zeros((len(state.x), len(self._along)))
        cases = []
        for column in range(idle.shape[2]):
            unit = np.zeros_like(rest)
            unit[:, passives] = idle[:, :, column]
            cases.append(LoadCase((rest, unit), none, [], np.zeros((1, 3)), factors))
        return self._tree.wrenches(state, cases, size)


def _columns(group_state: GroupState) -> set[int]:
    """Return the velocity coordinates of the joints at the ends of the rods of a group."""
    return {column for rod in group_state.group.idle for column in rod.columns}
