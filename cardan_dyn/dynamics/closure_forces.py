"""Closure forces: multipliers of the closure equations as forces, and the wrenches they change."""

from __future__ import annotations

import numpy as np

from ..arrays import Array, consecutive
from ..kinematics.closing.batch_model import placement
from ..kinematics.closing.equations import LoopAxes
from ..kinematics.closing.group_solver import GroupState
from ..mechanism.mechanism import Mechanism
from .indeterminate import SelfStress


class ClosureForces:
    """Closure forces of the loops and couplings of a mechanism.

    Attributes:
        size: number b of wrenches: of the bodies, then of the `fixed` loops.
        fixed_loops: index of each `fixed` loop, to the index of its wrench.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        bodies = mechanism.model.njoints - 1
        fixed = [index for index, loop in enumerate(mechanism.loops) if loop.is_fixed]
        self._loop_count = len(mechanism.loops)
        self.size = bodies + len(fixed)
        self._indices = np.arange(self.size)
        self.fixed_loops = {loop: bodies + count for count, loop in enumerate(fixed)}

    def self_stresses(self, state: GroupState) -> list[SelfStress]:
        """Return the closure forces of a group that change no passive effort.

        Args:
            state: of the group, at closed positions.
        """
        forces = []
        if state.null.shape[2]:
            forces.append(self.of_multipliers(state, state.null))
        for local, loop in enumerate(state.group.loops):
            null, axes = state.reduction.null[local], state.reduction.axes[local]
            if null.shape[1]:
                forces.append({loop: _wrench(state, axes, null)})
        return [SelfStress(item, *self._effect(state, item)) for item in forces]

    def of_multipliers(self, state: GroupState, multipliers: Array) -> dict[int, Array]:
        """Return closure forces `(N, 6, k)` and coupling moments `(N, 1, k)`.

        Args:
            state: of a group.
            multipliers: `(N, R, k)` of its reduced closure equations.

        Returns:
            By the index of the loop, or of the coupling plus the number of loops.
        """
        result, start = {}, 0
        for local, loop in enumerate(state.group.loops):
            rows, axes = state.reduction.rows[local], state.reduction.axes[local]
            of_loop = multipliers[:, start : start + rows.shape[1]]
            combined = of_loop if rows.shape[1] == 6 else rows @ of_loop
            result[loop] = _wrench(state, axes, combined)
            start += rows.shape[1]
        for coupling, unit in zip(state.group.couplings, state.equations.slip_units, strict=True):
            # The successor's coefficient in a coupling's row is -1 over the unit of its slip.
            index = self._loop_count + coupling
            result[index] = multipliers[:, start : start + 1] / unit
            start += 1
        return result

    def on_path(
        self, state: GroupState, local: int, loop: int, forces: Array
    ) -> tuple[slice | Array, Array]:
        """Return the joints on a loop and what closure forces `(N, 6, k)` add to their wrenches.

        Args:
            state: of the loop's group.
            local: index of the loop in the group.
            loop: index of the loop in the mechanism.
            forces: in the axes of the batch model's base about its origin.

        Returns:
            Indices of the joints among all wrenches, and `(N, J, 6, k)`.
        """
        tree, bodies = state.equations.tree, state.batch.bodies
        ends = tree.loops[local].predecessor, tree.loops[local].successor
        first, second = ({*tree.path(end.body)} for end in ends)
        path = np.array(sorted(first ^ second), dtype=int)
        rows = consecutive((6 * path[:, None] + np.arange(6)).ravel())
        signs = np.where(np.isin(path, list(first)), 1.0, -1.0)
        added = (state.actions[:, rows] @ forces).reshape(len(forces), len(path), 6, -1)
        added *= signs[:, None, None]
        joints = consecutive(bodies[path])
        if loop in self.fixed_loops:
            end = ends[1]
            lever = tree.length * np.array(end.translation)
            turn, point = _placed(state, end.body, np.array(end.rotation).T, lever)
            columns, action = np.swapaxes(turn, 1, 2), np.zeros((len(forces), 6, 6))
            action[:, :3, :3] = action[:, 3:, 3:] = columns
            action[:, 3:, :3] = np.cross(point[:, None, :], columns)
            joints = consecutive(np.append(self._indices[joints], self.fixed_loops[loop]))
            added = np.concatenate([added, (action @ forces)[:, None]], axis=1)
        return joints, added

    def _effect(self, state: GroupState, forces: dict[int, Array]) -> tuple[Array, Array]:
        """Return the joints that closure forces load, and what they add, `(N, J, 6, k)`."""
        indices = self._indices
        paths = [
            self.on_path(state, local, loop, forces[loop])
            for local, loop in enumerate(state.group.loops)
            if loop in forces
        ]
        if len(paths) == 1:
            ((joints, spread),) = paths
            return indices[joints], spread
        loaded = np.array(sorted({k for path, _ in paths for k in indices[path].tolist()}), int)
        size = next(iter(forces.values())).shape[2]
        total = np.zeros((len(state.x), len(loaded), 6, size))
        for joints, spread in paths:
            total[:, np.searchsorted(loaded, indices[joints])] += spread
        return loaded, total


def _wrench(state: GroupState, axes: LoopAxes, combinations: Array) -> Array:
    """Return wrenches of a loop in the base's axes about the batch model's origin.

    Args:
        state: of its group.
        axes: of the loop, see `Reduction`.
        combinations: of its weighted rows, `(N, 6, k)` or `(6, k)`.

    Returns:
        `(N, 6, k)`, force first.
    """
    equations = state.equations
    weighted = combinations * np.repeat([[1.0 / equations.length], [1.0]], 3, axis=0)
    point = equations.tree.length * np.array(axes.point)
    turn, position = _placed(state, axes.body, np.eye(3), point)
    matrices = np.zeros((len(turn), 6, 6))
    matrices[:, :3, :3] = matrices[:, 3:, 3:] = turn
    matrices[:, 3:, :3] = np.cross(position[:, :, None], turn, axis=1)
    return np.asarray(matrices @ weighted)


def _placed(state: GroupState, body: int, rotation: Array, point: Array) -> tuple[Array, Array]:
    """Return axes `(N, 3, 3)` and a point `(N, 3)` about the batch model's origin [m].

    Args:
        state: of a group.
        body: index in its tree of what carries them, -1 for the base.
        rotation: `(3, 3)` in the body; of the base, in the axes of the tree.
        point: `(3,)` likewise [m].
    """
    if body < 0:
        axes, place = np.array([state.equations.tree.axes]), np.zeros((1, 3))
        axes, place = axes.repeat(len(state.x), 0), place.repeat(len(state.x), 0)
    else:
        turn, position = placement(state.actions, body)
        axes, place = turn.transpose(2, 0, 1), position.T
    return axes @ rotation, place + axes @ point
