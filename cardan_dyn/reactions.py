"""Reactions: the wrench in every joint and the forces that keep the loops closed.

Inverse dynamics of the open tree leaves efforts in the passive joints. The closure forces Λ of
the loops are what turns those efforts into the given loads, and RNEA's wrenches with ±Λ added are
the joint wrenches of the closed chain.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .solver import Closed, Solver
from .twin import Array, placement

UNIQUE_TOLERANCE = 1e-9
"""Greatest influence of an undetermined closure force on a component that counts as unique."""


@dataclass(frozen=True)
class LinkLoad:
    """A wrench that acts on a link.

    Attributes:
        body: number of the joint that moves the link (0-based).
        rotation, translation: placement of the link in that body.
        force, moment: `(N, 3)` or `(1, 3)`.
        in_world: whether they are given in world axes instead of the link's.
    """

    body: int
    rotation: Array
    translation: Array
    force: Array
    moment: Array
    in_world: bool

    def about_origin(self, actions: Array) -> Array:
        """Return the wrench `(N, 6)` in world axes about the twin's origin."""
        rotation, position = placement(actions, self.body)
        force, moment = self.force.T, self.moment.T
        if not self.in_world:
            axes = np.einsum("ikn,kj->ijn", rotation, self.rotation)
            force, moment = (np.einsum("ijn,jn->in", axes, part) for part in (force, moment))
        point = position + np.einsum("ikn,k->in", rotation, self.translation)
        force = np.broadcast_to(force, point.shape)
        return np.concatenate([force, moment + np.cross(point, force, axis=0)]).T


@dataclass(frozen=True)
class Reactions:
    """Wrenches of one block of samples.

    Attributes:
        wrenches: `(N, 6 b)` wrench of every joint in its frame: the twin's joints in order, then
            `fixed` loops in file order.
        closure: `(N, L, 6)` wrench of each loop's predecessor on its successor, in world axes
            about the twin's origin.
        influence: `(6 b,)` greatest change of a component per unit of undetermined closure force.
        link_wrenches: `(N, 6)` for each link load.
    """

    wrenches: Array
    closure: Array
    influence: Array
    link_wrenches: list[Array]


class ReactionSolver:
    """Computes reactions for the closed positions of one scene."""

    def __init__(self, solver: Solver) -> None:
        self.solver = solver
        closure = solver.closure
        mechanism, twin = closure.mechanism, solver.twin
        self.joint_count = twin.joint_count
        self.fixed = [
            number
            for number, loop in enumerate(mechanism.loops)
            if not mechanism.joints[loop.joint].parts
        ]
        own = np.zeros((len(mechanism.loops), len(self.fixed)))
        own[self.fixed, np.arange(len(self.fixed))] = 1.0
        self.signs = np.concatenate([closure.signs, own], axis=1)
        self.parents = np.array(mechanism.model.parents)[1:] - 1

    def solve(
        self,
        here: Closed,
        dynamics: tuple[Array, Array] | None,
        loads: Array,
        link_loads: Sequence[LinkLoad],
    ) -> Reactions:
        """Return the reactions of a block of samples.

        Args:
            here: closed positions.
            dynamics: joint velocities and accelerations `(N, nv)`, or None where neither inertia
                nor gravity acts.
            loads: `(N, nv)` or `(1, nv)` efforts added at the joints [N·m, N].
            link_loads: wrenches on links.
        """
        solver, closure = self.solver, self.solver.closure
        count, bodies = len(here.x), self.signs.shape[1]
        actions = self._actions(here)
        wrenches = np.zeros((count, 6 * bodies))
        if dynamics is not None:
            v, a = (solver.coordinates.twin_velocity(rates) for rates in dynamics)
            wrenches[:, : 6 * self.joint_count] = solver.twin.inverse_dynamics(here.q, v, a)
        link_wrenches = [load.about_origin(here.actions) for load in link_loads]
        for load, wrench in zip(link_loads, link_wrenches, strict=True):
            carried = self._ancestors(load.body, bodies)
            wrenches -= _spread(actions, wrench, carried)

        multipliers = here.solve_transposed((loads - self.efforts(wrenches))[:, solver.passives])
        forces = np.zeros((count, len(closure.sides), 6))
        start = 0
        for number, rows in enumerate(solver.reduction.rows):
            part = multipliers[:, start : start + rows.shape[1]]
            forces[:, number] = (part @ rows.T) * closure.weights
            wrenches += _spread(actions, forces[:, number], self.signs[number])
            start += rows.shape[1]
        influence = np.zeros(6 * bodies)
        undetermined = self._undetermined(here)
        if undetermined is not None:
            influence = self._choose(actions, wrenches, forces, undetermined)
        return Reactions(wrenches, forces, influence, link_wrenches)

    def efforts(self, wrenches: Array) -> Array:
        """Return the components of wrenches along the joints' coordinates, `(N, nv)`."""
        twin = self.solver.twin
        blocks = wrenches.reshape(len(wrenches), -1, 6)
        return np.asarray(np.einsum("nki,ki->nk", blocks[:, twin.owner], twin.subspace))

    def _undetermined(self, here: Closed) -> Array | None:
        """Return closure forces `(N, L, 6, k)` that no passive effort feels, None if k = 0.

        Some rows are redundant at every position alike (`Reduction.null`), others change with it.
        """
        closure, reduction = self.solver.closure, self.solver.reduction
        count = reduction.null_count + here.null.shape[2]
        if not count:
            return None
        result = np.zeros((len(here.x), len(closure.sides), 6, count))
        column, row = here.null.shape[2], 0
        for number, (rows, null) in enumerate(zip(reduction.rows, reduction.null, strict=True)):
            result[:, number, :, : here.null.shape[2]] = (
                rows @ here.null[:, row : row + rows.shape[1]]
            )
            result[:, number, :, column : column + null.shape[1]] = null
            row += rows.shape[1]
            column += null.shape[1]
        return result * closure.weights[:, None]

    def _choose(self, actions: Array, wrenches: Array, forces: Array, undetermined: Array) -> Array:
        """Add the undetermined closure forces of least norm, in place; return their influence.

        The norm is taken over the wrenches of all joints at their origins, forces times the
        mechanism's length, so that it does not depend on where a ring was cut.
        """
        scale = np.tile(1.0 / self.solver.closure.weights, self.signs.shape[1])
        spread = np.zeros((*wrenches.shape, undetermined.shape[3]))
        for number, signs in enumerate(self.signs):
            spread += (actions @ undetermined[:, number]) * (np.repeat(signs, 6) * scale)[:, None]
        transposed = spread.transpose(0, 2, 1)
        right = transposed @ (wrenches * scale)[:, :, None]
        amounts = -np.linalg.solve(transposed @ spread, right)
        wrenches += (spread @ amounts)[:, :, 0] / scale
        forces += (undetermined @ amounts[:, None])[:, :, :, 0]
        return np.asarray(np.max(np.abs(spread), axis=(0, 2)))

    def _actions(self, here: Closed) -> Array:
        """Return the twin's action matrices with those of `fixed` loops appended."""
        if not self.fixed:
            return here.actions
        extra = []
        for number in self.fixed:
            rotation, position = self.solver.closure.sides[number][1].place(here.actions)
            block = np.zeros((len(here.x), 6, 6))
            columns = rotation.transpose(2, 1, 0)
            block[:, :3, :3] = block[:, 3:, 3:] = columns
            block[:, 3:, :3] = np.cross(position.T[:, None, :], columns)
            extra.append(block)
        return np.concatenate([here.actions, *extra], axis=1)

    def _ancestors(self, body: int, bodies: int) -> Array:
        carried = np.zeros(bodies)
        while body >= 0:
            carried[body] = 1.0
            body = self.parents[body]
        return carried


def _spread(actions: Array, wrench: Array, signs: Array) -> Array:
    """Return a wrench about the origin `(N, 6)` in all joints' frames `(N, 6 b)`, with signs."""
    return np.asarray(np.matmul(actions, wrench[:, :, None])[:, :, 0] * np.repeat(signs, 6))
