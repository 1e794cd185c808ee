"""Freedoms: the motions that loops and held joints leave, at closed configurations.

At single configurations, dead points and change points, mechanisms can do other motions than
anywhere else. What a scene lacks shows in generic ones nearby.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from .generic_states import states_around
from .group_solver import GroupSolver
from .idle_rods import idle_rods
from .loop_groups import independent_groups
from .stacked import ranks
from .structure import Structure
from .tolerances import MOVES

_GOOD = 0.5
"""Part of the fastest candidate's rate with which another one decides a motion as well."""


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


class Surroundings:
    """Generic configurations around a closed one, with any joints held.

    What was found for some held joints is kept: their ranks take longer than all that follows.
    """

    def __init__(self, structure: Structure, x: Array) -> None:
        """Begin with nothing.

        Args:
            structure: of the mechanism.
            x: `(size,)` closed coordinates.
        """
        self._structure = structure
        self._x = x
        self._near: dict[frozenset[int], list[_SetOfLoops]] = {}

    def freedoms(
        self, held: set[int], drives: set[int], needed: set[int], with_spins: bool = False
    ) -> list[Freedoms]:
        """Return the freedoms in the configurations, in the closed one first unless it is singular.

        Args:
            held: velocity coordinates that rest.
            drives: velocity coordinates of the drives; they move as all others do.
            needed: velocity coordinates whose motion matters.
            with_spins: whether spins of idle rods count as freedoms.
        """
        key = frozenset(held)
        if key not in self._near:
            self._near[key] = [_SetOfLoops.near(solver, self._x) for solver in self._solvers(held)]
        sets = self._near[key]
        count = max((len(item.x) for item in sets), default=1)
        return [
            self._joined(sets, index, held, drives, needed, with_spins) for index in range(count)
        ]

    def freedoms_here(self, held: set[int], drives: set[int], needed: set[int]) -> Freedoms:
        """Return the freedoms in the closed configuration, singular or not; see `freedoms`."""
        sets = [_SetOfLoops.at(solver, self._x) for solver in self._solvers(held)]
        return self._joined(sets, 0, held, drives, needed, False)

    def _solvers(self, held: set[int]) -> Iterator[GroupSolver]:
        """Make what solves each set of loops that has no joint in common with others."""
        free = np.array(self._free(held), dtype=int)
        for group in independent_groups(self._structure, free):
            if group.passives.size:
                yield GroupSolver(self._structure.mechanism, group)

    def _free(self, held: set[int]) -> list[int]:
        return sorted(set(range(self._structure.mechanism.model.nv)) - held)

    def _joined(
        self,
        sets: list[_SetOfLoops],
        index: int,
        held: set[int],
        drives: set[int],
        needed: set[int],
        with_spins: bool,
    ) -> Freedoms:
        """Return the freedoms of all sets of loops and of what is on none; see `freedoms`.

        Args:
            sets: of loops; their configurations may be combined in any way.
            index: which of their configurations.
            held: see `freedoms`.
            drives: see `freedoms`.
            needed: see `freedoms`.
            with_spins: see `freedoms`.
        """
        mechanism, free = self._structure.mechanism, self._free(held)
        x = self._x.copy()
        for item in sets:
            chosen = item.x[index % len(item.x)]
            x[chosen != self._x] = chosen[chosen != self._x]
        null = [(item.columns, item.null[index % len(item.x)]) for item in sets]
        motions = _block_diagonal(null, free, mechanism.model.nv)
        for rod in () if with_spins else idle_rods(mechanism, set(free) - drives):
            others = [column for column in free if column not in rod.columns]
            motions = motions @ _row_space(motions[others])
        return Freedoms(x, motions @ _row_space(motions[sorted(needed & set(free))]))


class _SetOfLoops(NamedTuple):
    """Loops and couplings that have no joint in common with others, in K configurations.

    Attributes:
        columns: `(p,)` velocity coordinates on them.
        x: `(K, size)` closed configurations.
        null: `(K, p, n)` motions that they leave.
    """

    columns: Array
    x: Array
    null: Array

    @staticmethod
    def near(solver: GroupSolver, x: Array) -> _SetOfLoops:
        """Return generic configurations around closed coordinates `(size,)`."""
        states = states_around(solver, x)
        left, _, _ = np.linalg.svd(states.group.scaled_rows)
        return _SetOfLoops(solver.group.passives, states.x, left[:, :, states.rank :])

    @staticmethod
    def at(solver: GroupSolver, x: Array) -> _SetOfLoops:
        """Return closed coordinates `(size,)` alone, with their own rank."""
        state, _ = solver.evaluate(x[None, :], solver.equations.full())
        left, _, _ = np.linalg.svd(state.scaled_rows)
        rank = int(ranks(state.scaled_rows)[0])
        return _SetOfLoops(solver.group.passives, x[None, :], left[:, :, rank:])


def _block_diagonal(null: list[tuple[Array, Array]], free: list[int], nv: int) -> Array:
    """Return motions `(nv, m)`: those of sets of loops, and each free coordinate on none of them.

    Args:
        null: velocity coordinates `(p,)` and their motions `(p, n)`, per set of loops.
        free: velocity coordinates that may move.
        nv: how many there are.
    """
    on_loops = {int(column) for columns, _ in null for column in columns}
    loose = np.array([column for column in free if column not in on_loops], dtype=int)
    blocks = [*null, (loose, np.eye(len(loose)))]
    motions = np.zeros((nv, sum(block.shape[1] for _, block in blocks)))
    first = 0
    for columns, block in blocks:
        motions[columns, first : first + block.shape[1]] = block
        first += block.shape[1]
    return motions


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
