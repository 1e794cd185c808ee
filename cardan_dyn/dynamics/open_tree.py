"""Open tree: joint wrenches from inertia, weight and link loads, with all loops cut open."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from ..arrays import Array, cross
from ..elements.link_loads import LinkLoad
from ..kinematics.closing.all_groups import ClosedState, Kinematics
from ..kinematics.closing.batch_model import BaseMotion, placement
from ..kinematics.closing.group_solver import GroupState
from ..mechanism.mechanism import Mechanism
from ..mechanism.tree import link_inertia


class LoadCase(NamedTuple):
    """What acts on a mechanism at closed positions.

    Attributes:
        dynamics: joint velocities and accelerations, each `(N, nv)`; None where neither inertia nor
            gravity acts, so that inverse dynamics need not be computed.
        loads: `(N, nv)` or `(1, nv)` efforts added at the joints [N·m, N].
        link_loads: wrenches on links.
        gravity: `(N, 3)` or `(1, 3)` [m/s²].
        inertia: link to the factor on its mass and inertia, `(N,)` or `(1,)`.
    """

    dynamics: tuple[Array, Array] | None
    loads: Array
    link_loads: Sequence[LinkLoad]
    gravity: Array
    inertia: Mapping[str, Array] = MappingProxyType({})


class OpenTree:
    """The bodies of a mechanism, each of them assigned to one group.

    A body may be carried by several groups; its inertia and loads are counted in one of them. What
    a group exerts on its base is passed on to the group that the base is assigned to.

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
        self._mechanism = mechanism
        self.bodies = mechanism.model.njoints - 1
        self._massive_groups = {
            index
            for index, solver in enumerate(kinematics.solvers)
            if solver.batch.has_mass and (not active or index in active)
        }
        groups = [solver.group for solver in kinematics.solvers]
        self._group_of_body = {
            body: index for index, group in enumerate(groups) for body in group.inertial_bodies
        }
        self._bases = sorted({group.base for group in groups if group.inertial_bodies} - {-1})
        # A body has a greater index than what it hangs from, so that a group comes after all that
        # hang from its bodies.
        self._inwards = sorted(range(len(groups)), key=lambda index: -groups[index].base)
        self._massive_inwards = [index for index in self._inwards if index in self._massive_groups]

    def wrenches(self, state: ClosedState, cases: Sequence[LoadCase], size: int) -> Array:
        """Return the wrench of every body's joint in its frame, `(N, size, 6, c)` for c load cases.

        It is the wrench of the parent on the body that balances inertia, weight and loads.

        Args:
            state: closed positions.
            cases: what acts.
            size: number of wrenches to return; those after the bodies' are zero.
        """
        result = np.zeros((state.x.shape[0], size, 6, len(cases)))
        for index, case in enumerate(cases):
            wrenches = result[..., index]
            for bodies, added in self._contributions(state, case):
                wrenches[:, bodies] += added
        return result

    def _contributions(
        self, state: ClosedState, case: LoadCase
    ) -> Iterator[tuple[slice | Array | int, Array]]:
        """Yield bodies and what is added to their wrenches."""
        motions = self._base_motions(state, case)
        pushes = self._against_loads(state, case) if case.link_loads else {}
        for group, push in self._of_factors(state, case, motions):
            pushes.setdefault(group, []).append(push)
        for index in self._inwards:
            group_state = state.groups[index]
            batch = group_state.batch
            on_base: list[Array] = []
            if index in self._massive_groups and case.dynamics is not None:
                wrenches, on_base = _inertial(group_state, case.dynamics, case.gravity, motions)
                yield batch.span, wrenches
            for push in pushes.get(index, []):
                for joint in batch.path(batch.index_of[push.body]):
                    actions = group_state.actions[:, 6 * joint : 6 * joint + 6]
                    yield batch.bodies[joint], (actions @ push.wrench[:, :, None])[:, :, 0]
                on_base.append(_moved(push.wrench, batch.origin))
            if batch.base >= 0 and on_base:
                group = self._group_of_body[batch.base]
                push = _push(state.groups[group], batch.base, np.sum(on_base, axis=0))
                pushes.setdefault(group, []).append(push)

    def _base_motions(self, state: ClosedState, case: LoadCase) -> dict[int, BaseMotion]:
        """Return the motions of all bases where inertia or weight acts; of the world if needed."""
        if case.dynamics is None or not (self._bases or case.inertia):
            return {}
        from .base_motion import base_motions  # Many mechanisms stand on the ground alone.

        return base_motions(state, self._group_of_body, self._bases, case.dynamics, case.gravity)

    def _of_factors(
        self, state: ClosedState, case: LoadCase, motions: Mapping[int, BaseMotion]
    ) -> Iterator[tuple[int, _Push]]:
        """Yield what moves links as far as factors add to their inertia, with their groups."""
        if case.dynamics is None or not case.inertia:
            return
        from .base_motion import motion_on  # Few sweeps have factors.

        described = {link.name: link for link in self._mechanism.description.links}
        for link, factor in case.inertia.items():
            index, frame = self._mechanism.link(link)
            body = index - 1
            group = self._group_of_body.get(body)
            if group is None or not (group in self._massive_groups and np.any(factor != 1.0)):
                continue
            group_state = state.groups[group]
            motion = motion_on(group_state, body, motions[group_state.batch.base], case.dynamics)
            wrench = moving_wrench(link_inertia(described[link], frame), motion)
            yield group, _push(group_state, body, (factor - 1.0)[:, None] * wrench)

    def _base_rotations(self, state: ClosedState) -> dict[int, Array]:
        """Return the rotations `(3, 3, N)` or `(3, 3, 1)` of all bases in the world."""
        if not self._bases:
            return {-1: np.eye(3)[:, :, None]}
        from .base_motion import base_rotations

        return base_rotations(state, self._group_of_body, self._bases)

    def _against_loads(self, state: ClosedState, case: LoadCase) -> dict[int, list[_Push]]:
        """Return what holds bodies against the loads on them, by the index of their group."""
        pushes: dict[int, list[_Push]] = {}
        in_world = any(load.in_world for load in case.link_loads)
        rotations = self._base_rotations(state) if in_world else {}
        for load in case.link_loads:
            # Where the body's group is not solved, no wanted output depends on the load.
            group = self._group_of_body.get(load.body)
            if group is not None:
                group_state = state.groups[group]
                rotation = rotations[group_state.batch.base] if load.in_world else None
                wrench = -_load_wrench(load, group_state, rotation)
                pushes.setdefault(group, []).append(_Push(load.body, wrench))
        return pushes


class _Push(NamedTuple):
    """What moves a body of a group, or holds it against loads and the inertia of what hangs on it.

    Attributes:
        body: the body (0-based).
        wrench: `(N, 6)` in the axes of the group's base about the batch model's origin.
    """

    body: int
    wrench: Array


def _inertial(
    group: GroupState,
    dynamics: tuple[Array, Array],
    gravity: Array,
    motions: Mapping[int, BaseMotion],
) -> tuple[Array, list[Array]]:
    """Return wrenches `(N, n, 6)` for inertia and weight, and what they add to the base's joint.

    The latter is `(N, 6)` in the frame of the base; none if the base is the world.

    Args:
        group: the group.
        dynamics: joint velocities and accelerations, each `(N, nv)`.
        gravity: `(N, 3)` or `(1, 3)` [m/s²].
        motions: of all bases but the world.
    """
    batch, (v, a) = group.batch, dynamics
    if batch.base >= 0:
        wrenches, of_base = batch.inverse_dynamics(motions[batch.base], group.x, v, a)
        return wrenches, [of_base]
    return batch.wrenches_on_ground(gravity, group.x, v, a), []


def moving_wrench(inertia: Array, motion: BaseMotion) -> Array:
    """Return the wrenches `(N, 6)` that move a body, in its frame.

    Args:
        inertia: `(6, 6)` of the body in its frame, linear part first.
        motion: of the body.
    """
    momentum = motion.twist @ inertia
    linear, angular = motion.twist[:, :3], motion.twist[:, 3:]
    force, moment = momentum[:, :3], momentum[:, 3:]
    rates = [np.cross(angular, force), np.cross(angular, moment) + np.cross(linear, force)]
    return np.asarray(motion.acceleration @ inertia + np.concatenate(rates, axis=1))


def _push(group: GroupState, body: int, wrench: Array) -> _Push:
    """Return a wrench `(N, 6)` in the frame of a body's joint as what acts in the body's group."""
    rotation, position = placement(group.actions, group.batch.index_of[body])
    force, moment = np.einsum("ijn,nkj->kni", rotation, wrench.reshape(-1, 2, 3))
    return _Push(body, _moved(np.concatenate([force, moment], axis=1), position.T))


def _moved(wrench: Array, point: Array) -> Array:
    """Return wrenches `(N, 6)` that act at a point, `(3,)` or `(N, 3)`, about the origin."""
    force, moment = wrench[:, :3], wrench[:, 3:]
    return np.concatenate([force, moment + np.cross(point, force)], axis=1)


class Along:
    """The velocity coordinates along which wrenches have components: efforts.

    Attributes:
        owners: `(nv,)` the body that each of them moves (0-based).
        subspace: `(nv, 6)` unit twists of the coordinates in their joints' frames.
    """

    def __init__(self, owners: Array, subspace: Array) -> None:
        """Keep the coordinates; arguments as of the class."""
        self.owners, self.subspace = owners, subspace
        # Along an axis of the frame, an effort is one of the components of the wrench: a choice is
        # exact and takes less than a sum. Coordinates that are not solved have no unit twist.
        self._rows: Array | None = None
        if np.all(np.count_nonzero(subspace, axis=1) <= 1):
            self._rows = 6 * owners + np.argmax(np.abs(subspace), axis=1)
            self._signs = subspace.sum(axis=1)[:, None]

    def __len__(self) -> int:
        return len(self.owners)

    def efforts(self, wrenches: Array, columns: Array) -> Array:
        """Return the components `(N, k, c)` of wrenches along some of the coordinates.

        Args:
            wrenches: of all joints, `(N, b, 6, c)`, each in its frame.
            columns: `(k,)` of the coordinates.
        """
        if self._rows is not None:
            count, bodies, _, cases = wrenches.shape
            components = wrenches.reshape(count, 6 * bodies, cases)
            efforts = components.take(self._rows.take(columns), 1)
            efforts *= self._signs.take(columns, 0)
            return efforts
        chosen = wrenches.take(self.owners.take(columns), 1)
        return np.asarray(np.einsum("nkic,ki->nkc", chosen, self.subspace.take(columns, 0)))


def _load_wrench(load: LinkLoad, group: GroupState, rotation: Array | None) -> Array:
    """Return a link load `(N, 6)` in the axes of a group's base about the batch model's origin.

    Args:
        load: the load.
        group: of the load's body.
        rotation: `(3, 3, N)` or `(3, 3, 1)` of the base in the world, for loads in world axes.
    """
    axes, position = placement(group.actions, group.batch.index_of[load.body])
    point = position + np.einsum("ikn,k->in", axes, load.place)
    if rotation is None:
        turn = np.einsum("ikn,kj->ijn", axes, load.rotation)
    else:
        turn = rotation.transpose(1, 0, 2)
    force, moment = (
        np.einsum("ijn,jn->in", turn, vector.T) for vector in (load.force, load.moment)
    )
    force = np.broadcast_to(force, point.shape)
    return np.concatenate([force, moment + cross(point, force)]).T
