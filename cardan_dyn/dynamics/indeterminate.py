"""Indeterminate: closure forces that the laws of motion leave open, and how they are chosen."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple, Protocol

import numpy as np

from ..arrays import Array, consecutive

_STIFF = 1e-10
"""Eigenvalues of the elastic energy up to this part of the greatest one count as zero.

Eigenvalues are exact to eps = 2e-16 of the greatest one, and more digits are lost with the closure
equations; smaller ones would choose forces by their rounding.
"""
_ENERGY_ROUNDING = 1e-18
"""Eigenvalues of the energy up to this part of their greatest possible value count as zero.

That value is `bound` of `_lexicographic`. The part is the square of the 1e-9 up to which the
influence of a self-stress counts as none, see `reactions.UNIQUE_TOLERANCE`, since energies grow
with the square of forces.
"""


class SelfStress(NamedTuple):
    """Closure forces that change no passive effort.

    Attributes:
        forces: per loop, by its index, `(N, 6, k)` as in `Reactions`; per coupling, by its
            index plus the number of loops, `(N, 1, k)`.
        joints: `(J,)` indices of the joints that they load.
        spread: what they add to the wrenches of those, `(N, J, 6, k)`.
    """

    forces: dict[int, Array]
    joints: Array
    spread: Array

    def rows(self, indices: slice | list[int] | Array = slice(None)) -> Array:
        """Return what they add to the wrenches of some joints, as one matrix `(N, 6 J, k)`.

        Args:
            indices: of these joints in `joints`.
        """
        chosen = self.spread[:, indices]
        return chosen.reshape(len(chosen), 6 * chosen.shape[1], chosen.shape[3])

    def wrenches(self, amount: Array) -> Array:
        """Return what an amount `(N, k, c)` of them adds to wrenches, `(N, J, 6, c)`."""
        added = self.rows() @ amount
        return added.reshape(len(added), len(self.joints), 6, amount.shape[2])

    def size(self) -> Array:
        """Return `(J, 6)` the greatest change of each component per unit of self-stress."""
        # One axis after the other: over both at once it takes ten times as long.
        sizes = np.maximum.reduce(np.abs(self.spread), axis=0)
        return np.asarray(np.maximum.reduce(sizes, axis=2))


class IndeterminacyRule(Protocol):
    """A rule that chooses statically indeterminate closure forces.

    Attributes:
        oriented: indices of the joints whose orientation it needs.
    """

    oriented: frozenset[int]

    def amounts(
        self,
        wrenches: Array,
        self_stresses: list[SelfStress],
        rotations: dict[int, Array],
    ) -> list[Array]:
        """Return how much of each self-stress is to be added to a solution of the load cases.

        Args:
            wrenches: of all joints, `(N, b, 6, c)` for c load cases.
            self_stresses: what the solution may differ by.
            rotations: for `oriented` joints, `(N, 3, 3)` from the joint's frame to its frame at
                coordinate zero, which stays with the parent.

        Returns:
            Per self-stress `(N, k, c)`.
        """
        ...


class _Counted(NamedTuple):
    """The joints loaded by a self-stress whose wrenches a norm counts.

    Attributes:
        indices: in `SelfStress.joints`.
        own: the same, as a slice if there are no gaps.
        joints: these joints, likewise.
    """

    indices: list[int]
    own: slice | Array
    joints: slice | Array


class LeastNorm:
    """Least sum of squares over all joints: of moments, and of forces times a length.

    Moments are those about the joints' origins, as results have them. The sum depends neither on
    where a ring was cut nor on the order of the joints, as long as a joint that slides keeps its
    child, with which its origin moves. Two
    self-stresses are connected only where they load the same joint, so the normal equations are
    sparse: of a line of loops they are a band, which is solved in time linear in their number.

    Attributes:
        counted: indices of the wrenches that the sum is over.
        squared_lengths: `(6,)` factors on the squares of a wrench's components [m² and 1].
    """

    oriented: frozenset[int] = frozenset()

    def __init__(self, length: float, counted: frozenset[int]) -> None:
        """Make the rule.

        Args:
            length: that forces are multiplied with [m].
            counted: indices of the wrenches that the sum is over.
        """
        self.squared_lengths = np.repeat([length, 1.0], 3) ** 2
        self.counted = counted
        # By the joints that self-stresses load, which are those of groups.
        self._known: dict[bytes, _Counted] = {}

    def amounts(
        self,
        wrenches: Array,
        self_stresses: list[SelfStress],
        rotations: dict[int, Array],
    ) -> list[Array]:
        """See `IndeterminacyRule.amounts`."""
        counted = [self._counted_of(item) for item in self_stresses]
        blocks: dict[tuple[int, int], Array] = {}
        right: dict[int, Array] = {}
        for index, (item, chosen) in enumerate(zip(self_stresses, counted, strict=True)):
            rows = item.rows(chosen.own)
            weighted = self._weighted_transpose(rows)
            loaded = wrenches[:, chosen.joints]
            loaded = loaded.reshape(len(loaded), rows.shape[1], loaded.shape[3])
            right[index] = -(weighted @ loaded)
            blocks[index, index] = weighted @ rows
        if len(self_stresses) == 1:
            return [_inverse(blocks[0, 0]) @ right[0]]
        indices = [chosen.indices for chosen in counted]
        for first, second, shared in _connections(self_stresses, indices):
            in_first, in_second = (list(column) for column in zip(*shared, strict=True))
            rows = self_stresses[second].rows(in_second)
            weighted = self._weighted_transpose(self_stresses[first].rows(in_first))
            blocks[first, second] = weighted @ rows
        amounts = _solve_sparse(blocks, right)
        return [amounts[index] for index in range(len(self_stresses))]

    def _counted_of(self, item: SelfStress) -> _Counted:
        """Return which of the joints that a self-stress loads are counted."""
        key = item.joints.tobytes()
        found = self._known.get(key)
        if found is None:
            joints = enumerate(item.joints.tolist())
            indices = np.array([k for k, joint in joints if joint in self.counted], dtype=int)
            own, counted = consecutive(indices), consecutive(item.joints[indices])
            found = self._known[key] = _Counted(indices.tolist(), own, counted)
        return found

    def _weighted_transpose(self, rows: Array) -> Array:
        """Return rows `(N, 6 J, k)` with squared lengths applied, transposed: `(N, k, 6 J)`."""
        count, size, amounts = rows.shape
        weighted = rows.reshape(count, size // 6, 6, amounts) * self.squared_lengths[:, None]
        return np.asarray(weighted.reshape(count, size, amounts).transpose(0, 2, 1))


def _connections(
    self_stresses: list[SelfStress], indices: list[list[int]]
) -> Iterator[tuple[int, int, list[tuple[int, int]]]]:
    """Yield which self-stresses load the same joints.

    Args:
        self_stresses: of a mechanism.
        indices: per self-stress, of the joints in `SelfStress.joints` that are considered.

    Yields:
        Indices of two self-stresses, the lower one first, and of each shared joint the index in the
        first one's `joints` and in the second one's.
    """
    index_of = [
        {int(item.joints[index]): index for index in chosen}
        for item, chosen in zip(self_stresses, indices, strict=True)
    ]
    loading: dict[int, list[int]] = {}
    for index, joints in enumerate(index_of):
        for joint in joints:
            loading.setdefault(joint, []).append(index)
    pairs = {
        (first, second)
        for loaded_by in loading.values()
        for first in loaded_by
        for second in loaded_by
        if first < second
    }
    for first, second in pairs:
        joints_of_second = index_of[second]
        yield (
            first,
            second,
            [
                (index, joints_of_second[joint])
                for joint, index in index_of[first].items()
                if joint in joints_of_second
            ],
        )


class _Form(NamedTuple):
    """A quadratic form ½ yᵀ M y - rᵀ y of amounts y that are to make it least.

    Attributes:
        matrix: M, `(N, k, k)`, symmetric and positive semidefinite.
        right: r, `(N, k, c)` for c load cases.
    """

    matrix: Array
    right: Array


class LeastEnergy:
    """Least elastic energy ½ Σ fᵀ C f of the joints whose compliance C is given.

    What their compliance does not decide is chosen by least norm.
    """

    def __init__(
        self, length: float, counted: frozenset[int], compliances: dict[int, Array]
    ) -> None:
        """Make the rule.

        Args:
            length: for the least norm [m].
            counted: for the least norm, see `LeastNorm`.
            compliances: per joint index `(6, 6)` [m/N, rad/(N·m)], in the axes that stay with the
                parent.
        """
        self.oriented = frozenset(compliances)
        self._compliances = compliances
        self._lengths = np.repeat([length, 1.0], 3)
        self._counted = counted

    def amounts(
        self,
        wrenches: Array,
        self_stresses: list[SelfStress],
        rotations: dict[int, Array],
    ) -> list[Array]:
        """See `IndeterminacyRule.amounts`."""
        sizes = [item.spread.shape[3] for item in self_stresses]
        starts = np.concatenate([[0], np.cumsum(sizes)]).tolist()
        energy, norm, bound = self._forms(wrenches, self_stresses, starts, rotations)
        amounts = _lexicographic(energy, norm, bound)
        return [amounts[:, first:last] for first, last in pairwise(starts)]

    def _forms(
        self,
        wrenches: Array,
        self_stresses: list[SelfStress],
        starts: list[int],
        rotations: dict[int, Array],
    ) -> tuple[_Form, _Form, Array]:
        """Return elastic energy and sum of squares as forms in the amounts of all self-stresses.

        Args:
            wrenches: see `amounts`.
            self_stresses: see `amounts`.
            starts: per self-stress, the index of its first amount among all; then their count.
            rotations: see `amounts`.

        Returns:
            The energy, the sum of squares (see `LeastNorm`), and `(N, 1)` the greatest
            possible eigenvalues of the energy: those of forces along the most compliant directions.
        """
        count, size, cases = len(wrenches), starts[-1], wrenches.shape[3]
        energy, norm = np.zeros((2, count, size, size))
        right_energy, right_norm = np.zeros((2, count, size, cases))
        bound = np.zeros((count, 1))
        lengths = self._lengths[:, None]
        for joint, spread in _spread_by_joint(self_stresses, starts):
            transposed, wrench = spread.transpose(0, 2, 1), wrenches[:, joint]
            if joint in self._counted:
                norm += transposed @ (spread * lengths**2)
                right_norm -= transposed @ (wrench * lengths**2)
            if joint in self._compliances:
                compliance = self._in_joint_frame(joint, rotations.get(joint))
                energy += transposed @ compliance @ spread
                right_energy -= transposed @ compliance @ wrench
                relative = self._compliances[joint] / (lengths * self._lengths)
                squares = np.sum((spread * lengths) ** 2, axis=(1, 2))
                bound += np.linalg.norm(relative) * squares[:, None]
        return _Form(energy, right_energy), _Form(norm, right_norm), bound

    def _in_joint_frame(self, joint: int, rotation: Array | None) -> Array:
        """Return a compliance in its joint's frame, `(N, 6, 6)`, or `(6, 6)` if unrotated."""
        compliance = self._compliances[joint]
        if rotation is None:
            return compliance
        both = np.zeros((len(rotation), 6, 6))
        both[:, :3, :3] = both[:, 3:, 3:] = rotation
        return both.transpose(0, 2, 1) @ compliance @ both


def _spread_by_joint(
    self_stresses: list[SelfStress], starts: list[int]
) -> Iterator[tuple[int, Array]]:
    """Yield every loaded joint with what all self-stresses add to its wrench, `(N, 6, k)`.

    Args:
        self_stresses: of a mechanism.
        starts: per self-stress, the index of its first amount among all; then their count k.
    """
    loading: dict[int, list[tuple[int, Array]]] = {}
    for index, item in enumerate(self_stresses):
        for row, joint in enumerate(item.joints.tolist()):
            loading.setdefault(joint, []).append((index, item.spread[:, row]))
    for joint, spreads in loading.items():
        spread = np.zeros((len(spreads[0][1]), 6, starts[-1]))
        for index, of_self_stress in spreads:
            spread[:, :, starts[index] : starts[index + 1]] = of_self_stress
        yield joint, spread


def influence(self_stresses: list[SelfStress], size: int, length: float) -> Array:
    """Return `(b, 6)` the greatest change of each component per unit of self-stress.

    Args:
        self_stresses: of a mechanism.
        size: number b of wrenches.
        length: characteristic length, that forces are multiplied with [m].
    """
    result = np.zeros((size, 6))
    for index, item in enumerate(self_stresses):
        changes = item.size()
        changes[:, :3] *= length
        if index:
            changes = np.maximum(result[item.joints], changes)
        result[item.joints] = changes
    return result


def _lexicographic(first: _Form, second: _Form, bound: Array) -> Array:
    """Return the amounts `(N, k, c)` that make a form least; of these, those for a second form.

    The first form leaves open the amounts along eigenvectors whose eigenvalue is zero. Within them
    the second form is made least.

    Args:
        first: the form that decides first; its minimum has to exist.
        second: the form that decides what the first one leaves open.
        bound: `(N, 1)` greatest possible eigenvalue of the first form, beside which much smaller
            ones are the rounding of zero.
    """
    values, vectors = np.linalg.eigh(first.matrix)
    least = _STIFF * np.max(np.abs(values), axis=1, keepdims=True)
    decisive = values > np.maximum(least, _ENERGY_ROUNDING * bound)
    inverse = np.where(decisive, 1.0 / np.where(decisive, values, 1.0), 0.0)
    amounts = vectors @ (inverse[:, :, None] * (vectors.transpose(0, 2, 1) @ first.right))
    if np.all(decisive):
        return np.asarray(amounts)
    # Amounts may be changed by any combination of these columns; the others are zero.
    remaining = vectors * ~decisive[:, None, :]
    matrix = remaining.transpose(0, 2, 1) @ second.matrix @ remaining
    right = remaining.transpose(0, 2, 1) @ (second.right - second.matrix @ amounts)
    # The pseudoinverse, since the columns that are zero make the matrix singular.
    return np.asarray(amounts + remaining @ (np.linalg.pinv(matrix, hermitian=True) @ right))


def _solve_sparse(
    blocks: dict[tuple[int, int], Array], right: dict[int, Array]
) -> dict[int, Array]:
    """Solve a symmetric positive definite system of blocks, for all samples at once.

    Unknowns are eliminated in ascending order. Eliminating unknown `i` changes the blocks between
    all later unknowns that it is connected with, and connects those that were not (fill-in). Then
    the unknowns are computed in descending order.

    Args:
        blocks: upper triangle: `(i, j)` with i ≤ j to `(N, k_i, k_j)`; what is missing is zero.
        right: `i` to `(N, k_i, c)`.

    Returns:
        The solution, `i` to `(N, k_i, c)`.
    """
    blocks, solution = dict(blocks), dict(right)
    order = sorted(right)
    later = {
        first: [second for second in order if second > first and (first, second) in blocks]
        for first in order
    }
    # Unknown `first` is its right side less the factors times the later unknowns.
    factors: dict[int, dict[int, Array]] = {}
    for first in order:
        inverse = _inverse(blocks[first, first])
        factors[first] = {second: inverse @ blocks[first, second] for second in later[first]}
        solution[first] = inverse @ solution[first]
        for second in later[first]:
            transposed = blocks[first, second].transpose(0, 2, 1)
            solution[second] = solution[second] - transposed @ solution[first]
            for third in later[first]:
                if third < second:
                    continue  # Of a symmetric pair only the upper block is kept.
                change = transposed @ factors[first][third]
                if (second, third) in blocks:
                    blocks[second, third] = blocks[second, third] - change
                else:
                    blocks[second, third] = -change
                    later[second] = sorted({*later[second], third})
    for first in reversed(order):
        for second, factor in factors[first].items():
            solution[first] = solution[first] - factor @ solution[second]
    return solution


def _inverse(matrices: Array) -> Array:
    try:
        return np.linalg.inv(matrices)
    except np.linalg.LinAlgError:
        # Self-stresses of a closed gear train are moments of couplings, which load no joint: their
        # norm is zero, and the pseudoinverse chooses the amount zero.
        return np.asarray(np.linalg.pinv(matrices, hermitian=True))
