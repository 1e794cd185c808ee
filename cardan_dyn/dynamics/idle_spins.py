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
        # A spin moves its rod alone, so that none adds to the moment along another.
        of_units = self._of_accelerations(
            state, passives, idle.sum(axis=2, keepdims=True), wrenches.shape[1], factors
        )
        inertia = left @ self._along.efforts(of_units, passives)
        counts = inertia > self._least
        unbalanced = np.abs(moments) * ~counts
        if np.max(unbalanced) > _BALANCED * np.max(np.abs(wrenches)):
            names = group_state.solver.coordinates.names_of(_columns(group_state))
            raise MobilityError(
                f"a load acts about the line of an idle rod without inertia ({choices(names)}), "
                "which nothing can hold; give the rod mass, take the load off, or drive or hold "
                "its spin",
                free=names,
            )
        spins = np.divide(moments, inertia, out=np.zeros_like(moments), where=counts)
        added = idle @ spins
        wrenches += self._of_accelerations(state, passives, added, wrenches.shape[1], factors)
        accelerations[:, passives] += added

    def _of_accelerations(
        self,
        state: ClosedState,
        passives: Array,
        accelerations: Array,
        size: int,
        factors: Mapping[str, Array],
    ) -> Array:
        """Return wrenches `(N, b, 6, c)` that accelerations `(N, p, c)` of passives need."""
        none = np.zeros((1, len(self._along)))
        rest = np.zeros((len(state.x), len(self._along)))
        cases = []
        for column in range(accelerations.shape[2]):
            along = np.zeros_like(rest)
            along[:, passives] = accelerations[:, :, column]
            cases.append(LoadCase((rest, along), none, [], np.zeros((1, 3)), factors))
        return self._tree.wrenches(state, cases, size)


def _columns(group_state: GroupState) -> set[int]:
    """Return the velocity coordinates of the joints at the ends of the rods of a group."""
    return {column for rod in group_state.group.idle for column in rod.columns}
