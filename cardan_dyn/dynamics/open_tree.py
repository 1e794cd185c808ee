"""Open tree: joint wrenches from inertia, weight and link loads, with all loops cut open."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..forces.link_loads import LinkLoad
from ..kinematics.all_groups import ClosedState, Kinematics
from ..kinematics.batch_model import placement
from ..mechanism.mechanism import Mechanism
from ..mechanism.tree import ancestors


class LoadCase(NamedTuple):
    """What acts on a mechanism at closed positions.

    Attributes:
        dynamics: joint velocities and accelerations, each `(N, nv)`; None where neither inertia nor
            gravity acts, so that inverse dynamics need not be computed.
        loads: `(N, nv)` or `(1, nv)` efforts added at the joints [N·m, N].
        link_loads: wrenches on links.
        gravity: `(3,)` [m/s²].
    """

    dynamics: tuple[Array, Array] | None
    loads: Array
    link_loads: Sequence[LinkLoad]
    gravity: Array


class OpenTree:
    """The bodies of a mechanism, each of them assigned to one group.

    A body may be carried by several groups; its inertia and loads are counted in one of them.

    Attributes:
        bodies: number of bodies.
    """

    def __init__(
        self, mechanism: Mechanism, kinematics: Kinematics, active: Collection[int]
    ) -> None:
        """Find the group of every body.

        Args:
            mechanism: the mechanism.
            kinematics: the groups whose motion is solved.
            active: indices of the groups whose closure forces are solved. If there is none, drive
                efforts follow from virtual work, which needs the inertia of all groups.
        """
        self.bodies = mechanism.model.njoints - 1
        self._model = mechanism.model
        self._massive_groups = [
            index
            for index, solver in enumerate(kinematics.solvers)
            if solver.batch.has_mass and (not active or index in active)
        ]
        self._group_of_body = {
            body: index
            for index, solver in enumerate(kinematics.solvers)
            for body in solver.group.inertial_bodies
        }

    def wrenches(self, state: ClosedState, cases: Sequence[LoadCase], size: int) -> Array:
        """Return the wrench of every body's joint in its frame, `(N, size, 6, c)` for c load cases.

        It is the wrench of the parent on the body that balances inertia, weight and loads.

        Args:
            state: closed positions.
            cases: what acts.
            size: number of wrenches to return; those after the bodies' are zero.
        """
        result = np.zeros((len(state.x), size, 6, len(cases)))
        for index, case in enumerate(cases):
            wrenches = result[..., index]
            for bodies, added in self._contributions(state, case):
                wrenches[:, bodies] += added
        return result

    def _contributions(
        self, state: ClosedState, case: LoadCase
    ) -> Iterator[tuple[slice | Array | int, Array]]:
        """Yield bodies and what the inertia of a group, or a load, adds to their wrenches."""
        if case.dynamics is not None:
            for index in self._massive_groups:
                group_state = state.groups[index]
                batch = group_state.batch
                v, a = (batch.velocity(rates) for rates in case.dynamics)
                wrenches = batch.inverse_dynamics(group_state.q, v, a, case.gravity)
                yield consecutive(batch.bodies), wrenches.reshape(len(v), -1, 6)
        for load in case.link_loads:
            # Where the body's group is not solved, no wanted output depends on the load.
            if load.body not in self._group_of_body:
                continue
            group_state = state.groups[self._group_of_body[load.body]]
            index_of, actions = group_state.batch.index_of, group_state.actions
            wrench = _about_origin(load, actions, index_of[load.body])[:, :, None]
            for body in ancestors(self._model, load.body + 1):
                first = 6 * index_of[body]
                yield body, -np.matmul(actions[:, first : first + 6], wrench)[:, :, 0]


def efforts_along(wrenches: Array, columns: Array, owners: Array, subspace: Array) -> Array:
    """Return components of wrenches `(N, b, 6, c)` along some coordinates, `(N, k, c)`.

    Args:
        wrenches: of all joints, each in its frame.
        columns: `(k,)` velocity coordinates.
        owners: `(nv,)` the body that each of them moves (0-based).
        subspace: `(nv, 6)` their unit twists in their joints' frames.
    """
    chosen = wrenches[:, owners[columns]]
    return np.asarray(np.einsum("nkic,ki->nkc", chosen, subspace[columns]))


def consecutive(indices: Array) -> slice | Array:
    """Return ascending indices, as a slice if there are no gaps, since slices make no copies."""
    span = indices.size and indices[-1] - indices[0] == indices.size - 1
    if span and np.all(np.diff(indices) == 1):
        return slice(int(indices[0]), int(indices[-1]) + 1)
    return indices


def _about_origin(load: LinkLoad, actions: Array, index: int) -> Array:
    """Return a link load `(N, 6)` in world axes about the origin of a batch model.

    Args:
        load: the load.
        actions: of the batch model, see `BatchModel.actions`.
        index: of the load's body in the batch model.
    """
    rotation, position = placement(actions, index)
    force, moment = load.force.T, load.moment.T
    if not load.in_world:
        axes = np.einsum("ikn,kj->ijn", rotation, load.rotation)
        force, moment = (np.einsum("ijn,jn->in", axes, vector) for vector in (force, moment))
    point = position + np.einsum("ikn,k->in", rotation, load.translation)
    force = np.broadcast_to(force, point.shape)
    return np.concatenate([force, moment + np.cross(point, force, axis=0)]).T
