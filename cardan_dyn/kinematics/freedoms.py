"""Freedoms: the motions that loops and held joints leave, at closed configurations.

At single configurations, dead points and change points, mechanisms can do other motions than
anywhere else. What a scene lacks shows in generic ones nearby.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..mechanism.mechanism import Mechanism
from .generic_states import states_around
from .group_solver import GroupSolver
from .idle_rods import IdleRod, idle_rods
from .loop_groups import Group, independent_groups
from .stacked import ranks
from .structure import Structure

MOVES = 1e-6
"""Component of a unit vector of free motion above which a joint counts as moving. Joints that the
loops decide have components there as well, by rounding of about 1e-16."""


class Freedoms(NamedTuple):
    """Independent motions of a mechanism at a closed configuration.

    Attributes:
        x: `(size,)` the configuration.
        motions: `(nv, m)` joint rates of each motion, slides counted in lengths of the mechanism.
    """

    x: Array
    motions: Array

    @property
    def number(self) -> int:
        """How many there are."""
        return self.motions.shape[1]

    def rank_of(self, columns: list[int]) -> int:
        """Return how many of some velocity coordinates move independently of each other."""
        return _rank(self.motions[columns])

    def while_resting(self, columns: list[int]) -> Freedoms:
        """Return the motions in which some velocity coordinates rest."""
        rows = self.motions[columns]
        if not rows.size:
            return self
        _, _, right = np.linalg.svd(rows)
        return self._replace(motions=self.motions @ right[_rank(rows) :].T)

    def moving(self, columns: Iterable[int]) -> set[int]:
        """Return those of some velocity coordinates that any of the motions moves."""
        moves = np.max(np.abs(self.motions), axis=1, initial=0.0) > MOVES
        return {column for column in columns if moves[column]}

    def chosen(self, candidates: list[int], known: list[int]) -> list[int]:
        """Return velocity coordinates that move independently of each other and of known ones.

        Args:
            candidates: to choose from; of those that serve well, the first ones are taken.
            known: what is decided already; independent of each other or not.
        """
        rows = self.while_resting(known).motions
        result: list[int] = []
        while rows.shape[1]:
            sizes = np.linalg.norm(rows[candidates], axis=1)
            if not sizes.size or np.max(sizes) <= MOVES:
                break
            best = candidates[int(np.argmax(sizes > _GOOD * np.max(sizes)))]
            result.append(best)
            _, _, right = np.linalg.svd(rows[[best]])
            rows = rows @ right[1:].T
        return result


_GOOD = 0.5
"""Part of the fastest candidate's rate with which another one decides a motion as well."""


def freedoms_near(
    structure: Structure,
    x: Array,
    held: set[int],
    drives: set[int],
    needed: set[int],
    with_spins: bool = False,
) -> list[Freedoms]:
    """Return the freedoms in generic configurations around a closed one.

    Args:
        structure: of the mechanism.
        x: `(size,)` closed coordinates, the first configuration unless it is singular.
        held: velocity coordinates that rest.
        drives: velocity coordinates of the drives; they move as all others do.
        needed: velocity coordinates whose motion matters.
        with_spins: whether spins of idle rods count as freedoms.
    """
    mechanism = structure.mechanism
    free = sorted(set(range(mechanism.model.nv)) - held)
    idle = [] if with_spins else idle_rods(mechanism, set(free) - drives)
    solvers = _solvers(structure, free)
    states = [states_around(solver, x) for solver in solvers]
    result = []
    for index in range(max((len(item.x) for item in states), default=1)):
        at = x.copy()
        null = []
        for solver, item in zip(solvers, states, strict=True):
            # Sets of loops without a common joint may be combined in any way.
            chosen = index % len(item.x)
            changed = item.x[chosen] != x
            at[changed] = item.x[chosen][changed]
            null.append(_null(solver.group, item.group.scaled_rows[chosen], item.rank))
        result.append(_freedoms(mechanism, at, free, idle, needed, null))
    return result


def freedoms_at(
    structure: Structure, x: Array, held: set[int], drives: set[int], needed: set[int]
) -> Freedoms:
    """Return the freedoms at closed coordinates, singular or not; see `freedoms_near`."""
    mechanism = structure.mechanism
    free = sorted(set(range(mechanism.model.nv)) - held)
    null = []
    for solver in _solvers(structure, free):
        state, _ = solver.evaluate(x[None, :], solver.equations.full())
        rank = int(ranks(state.scaled_rows)[0])
        null.append(_null(solver.group, state.scaled_rows[0], rank))
    idle = idle_rods(mechanism, set(free) - drives)
    return _freedoms(mechanism, x, free, idle, needed, null)


def _solvers(structure: Structure, free: list[int]) -> list[GroupSolver]:
    groups = independent_groups(structure, np.array(free, dtype=int))
    return [GroupSolver(structure.mechanism, group) for group in groups if group.passives.size]


def _null(group: Group, rows: Array, rank: int) -> tuple[Array, Array]:
    """Return velocity coordinates and the motions `(p, p - rank)` that rows `(p, R)` leave them."""
    left, _, _ = np.linalg.svd(rows)
    return group.passives, left[:, rank:]


def _freedoms(
    mechanism: Mechanism,
    x: Array,
    free: list[int],
    idle: list[IdleRod],
    needed: set[int],
    null: list[tuple[Array, Array]],
) -> Freedoms:
    """Return the freedoms that loops leave, without spins of idle rods.

    Args:
        mechanism: the mechanism.
        x: `(size,)` the configuration.
        free: velocity coordinates that may move.
        idle: rods whose spins do not count.
        needed: those whose motion matters.
        null: velocity coordinates and their motions, per set of loops.
    """
    on_loops = {int(column) for columns, _ in null for column in columns}
    loose = np.array([column for column in free if column not in on_loops], dtype=int)
    blocks = [*null, (loose, np.eye(len(loose)))]
    motions = np.zeros((mechanism.model.nv, sum(block.shape[1] for _, block in blocks)))
    first = 0
    for columns, block in blocks:
        motions[columns, first : first + block.shape[1]] = block
        first += block.shape[1]
    for rod in idle:
        others = [column for column in free if column not in rod.columns]
        motions = motions @ _row_space(motions[others])
    kept = sorted(needed & set(free))
    return Freedoms(x, motions @ _row_space(motions[kept]))


def _row_space(rows: Array) -> Array:
    """Return an orthonormal basis `(m, rank)` of the combinations of columns that rows feel."""
    if not rows.size:
        return np.zeros((rows.shape[1], 0))
    _, _, right = np.linalg.svd(rows, full_matrices=False)
    return np.asarray(right[: _rank(rows)].T)


def _rank(rows: Array) -> int:
    if not rows.size:
        return 0
    return int(np.sum(np.linalg.svd(rows, compute_uv=False) > MOVES))
