"""Indeterminate: closure forces that the laws of motion leave open, and how they are chosen."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple, Protocol

import numpy as np

from ..arrays import Array

_STIFF = 1e-10  # Energies this much smaller than the greatest one decide nothing.
_ROUNDING = 1e-18  # The square of what influence counts as none, see `UNIQUE_TOLERANCE`.


class SelfStress(NamedTuple):
    """Closure forces that change no passive effort.

    Attributes:
        forces: per loop `(N, 6, k)` in world axes about the origin of its group's batch, and per
            coupling, counted on from the loops, `(N, 1, k)`.
        joints: `(J,)` the joints that they load.
        spread: what they add to the wrenches of those, `(N, J, 6, k)`.
    """

    forces: dict[int, Array]
    joints: Array
    spread: Array

    def rows(self, places: slice | list[int] = slice(None)) -> Array:
        """Return what they add to some of the joints as one matrix `(N, 6 J, k)`."""
        chosen = self.spread[:, places]
        return chosen.reshape(len(chosen), 6 * chosen.shape[1], chosen.shape[3])

    def wrenches(self, amount: Array) -> Array:
        """Return what an amount `(N, k, c)` of them adds to wrenches, `(N, J, 6, c)`."""
        added = self.rows() @ amount
        return added.reshape(len(added), len(self.joints), 6, amount.shape[2])

    def size(self) -> Array:
        """Return `(J, 6)` the greatest change of each component per unit of them."""
        return np.asarray(np.abs(self.spread).max(axis=0).max(axis=2))


class IndeterminacyRule(Protocol):
    """A rule that chooses self_stresses closure forces.

    Attributes:
        oriented: joints whose orientation it needs.
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
            wrenches: of all joints, `(N, b, 6, c)`.
            self_stresses: what the solution may differ by.
            rotations: for `oriented` joints, `(N, 3, 3)` from the joint's frame to its parent's.

        Returns:
            Per self-stress `(N, k, c)`.
        """
        ...


class LeastNorm:
    """Least sum of squares over all joints: moments, and forces times a length.

    The sum does not depend on where a ring was cut, nor on the order of the joints. Two sets of
    forces are coupled only where they load the same joint, so the normal equations are sparse: a
    row of loops gives a band, which is eliminated at a cost linear in the number of loops.
    """

    oriented: frozenset[int] = frozenset()

    def __init__(self, length: float, counted: frozenset[int]) -> None:
        """Make the rule.

        Args:
            length: that forces count times [m].
            counted: places of the wrenches that the sum is over.
        """
        self._lengths = np.repeat([length, 1.0], 3)
        self._counted = counted

    def amounts(
        self,
        wrenches: Array,
        self_stresses: list[SelfStress],
        rotations: dict[int, Array],
    ) -> list[Array]:
        """See `IndeterminacyRule.amounts`."""
        touching: dict[int, list[int]] = {}
        counting = [
            [place for place, joint in enumerate(item.joints.tolist()) if joint in self._counted]
            for item in self_stresses
        ]
        for number, (item, places) in enumerate(zip(self_stresses, counting, strict=True)):
            for joint in item.joints[places].tolist():
                touching.setdefault(joint, []).append(number)
        pairs = {
            (first, second)
            for numbers in touching.values()
            for first in numbers
            for second in numbers
            if first < second
        }
        blocks: dict[tuple[int, int], Array] = {}
        right: dict[int, Array] = {}
        for number, (item, places) in enumerate(zip(self_stresses, counting, strict=True)):
            rows = item.rows(places)
            flipped = self._weighed(rows)
            loaded = wrenches[:, item.joints[places]]
            right[number] = -(
                flipped @ loaded.reshape(len(loaded), 6 * len(places), loaded.shape[3])
            )
            blocks[number, number] = flipped @ rows
        for first, second in pairs:
            one, other = self_stresses[first], self_stresses[second]
            there_is = {int(other.joints[place]): place for place in counting[second]}
            shared = [
                (place, there_is[int(one.joints[place])])
                for place in counting[first]
                if int(one.joints[place]) in there_is
            ]
            here, there = (list(part) for part in zip(*shared, strict=True))
            blocks[first, second] = self._weighed(one.rows(here)) @ other.rows(there)
        amounts = _solve_sparse(blocks, right)
        return [amounts[number] for number in range(len(self_stresses))]

    def _weighed(self, rows: Array) -> Array:
        """Return transposed rows `(N, k, 6 J)`, squares of lengths applied."""
        squares = np.tile(self._lengths**2, rows.shape[1] // 6)
        return np.asarray((rows * squares[:, None]).transpose(0, 2, 1))


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
            compliances: per joint `(6, 6)` [m/N, rad/(N·m)], in the axes that stay with the parent.
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
        spread: dict[int, list[tuple[int, Array]]] = {}
        sizes = [item.spread.shape[3] for item in self_stresses]
        starts = np.concatenate([[0], np.cumsum(sizes)])
        count, total = len(wrenches), int(starts[-1])
        for number, item in enumerate(self_stresses):
            for place, joint in enumerate(item.joints.tolist()):
                spread.setdefault(joint, []).append((number, item.spread[:, place]))
        elastic, norm = np.zeros((2, count, total, total))
        bound = np.zeros((count, 1))
        right_elastic, right_norm = np.zeros((2, count, total, wrenches.shape[3]))
        for joint, parts in spread.items():
            whole = np.zeros((count, 6, total))
            for number, part in parts:
                whole[:, :, starts[number] : starts[number + 1]] = part
            flipped, wrench = whole.transpose(0, 2, 1), wrenches[:, joint]
            if joint in self._counted:
                norm += flipped @ (whole * self._lengths[:, None] ** 2)
                right_norm -= flipped @ (wrench * self._lengths[:, None] ** 2)
            if joint in self._compliances:
                compliance = self._turned(joint, rotations.get(joint))
                elastic += flipped @ compliance @ whole
                right_elastic -= flipped @ compliance @ wrench
                # What the energy could be if the forces went where the joint yields most.
                softest = self._compliances[joint] / np.multiply.outer(self._lengths, self._lengths)
                sizes = np.sum((whole * self._lengths[:, None]) ** 2, axis=(1, 2))
                bound += np.linalg.norm(softest) * sizes[:, None]
        amounts = _lexicographic(elastic, right_elastic, norm, right_norm, bound)
        return [amounts[:, first:last] for first, last in pairwise(starts.tolist())]

    def _turned(self, joint: int, rotation: Array | None) -> Array:
        """Return a joint's compliance in its own frame, `(N, 6, 6)`."""
        compliance = self._compliances[joint]
        if rotation is None:
            return compliance
        both = np.zeros((len(rotation), 6, 6))
        both[:, :3, :3] = both[:, 3:, 3:] = rotation
        return both.transpose(0, 2, 1) @ compliance @ both


def influence(self_stresses: list[SelfStress], size: int, length: float) -> Array:
    """Return `(b, 6)` greatest change of each component per unit of self-stress.

    Args:
        self_stresses: of a mechanism.
        size: number b of wrenches.
        length: characteristic length, which forces count times [m].
    """
    result = np.zeros((size, 6))
    for item in self_stresses:
        changes = item.size() * np.repeat([length, 1.0], 3)
        result[item.joints] = np.maximum(result[item.joints], changes)
    return result


def _lexicographic(
    first: Array, right_1: Array, second: Array, right_2: Array, bound: Array
) -> Array:
    """Minimise a first quadratic form; among its minima, a second one.

    Args:
        first: `(N, k, k)`.
        right_1: `(N, k, c)`.
        second: `(N, k, k)`.
        right_2: `(N, k, c)`.
        bound: `(N, 1)` greatest value that the first form could have; where all of it is far
            below, it is the rounding of zero and decides nothing.
    """
    values, vectors = np.linalg.eigh(first)
    least = _STIFF * np.max(np.abs(values), axis=1, keepdims=True)
    stiff = values > np.maximum(least, _ROUNDING * bound)
    reciprocal = np.where(stiff, 1.0 / np.where(stiff, values, 1.0), 0.0)
    flipped = vectors.transpose(0, 2, 1)
    amounts = vectors @ (reciprocal[:, :, None] * (flipped @ right_1))
    if np.all(stiff):
        return np.asarray(amounts)
    # Within what the first form leaves open, project the second one's problem.
    loose = vectors * ~stiff[:, None, :]
    left = loose.transpose(0, 2, 1) @ second @ loose
    rest = loose.transpose(0, 2, 1) @ (right_2 - second @ amounts)
    return np.asarray(amounts + loose @ (np.linalg.pinv(left, hermitian=True) @ rest))


def _solve_sparse(
    blocks: dict[tuple[int, int], Array], right: dict[int, Array]
) -> dict[int, Array]:
    """Solve a symmetric positive definite block system, for all samples at once.

    Args:
        blocks: upper triangle: `(i, j)` with i ≤ j to `(N, k_i, k_j)`.
        right: `i` to `(N, k_i, c)`; used up.
    """
    order = sorted(right)
    later = {
        first: [second for second in order if second > first and (first, second) in blocks]
        for first in order
    }
    factors: dict[int, dict[int, Array]] = {}
    for first in order:
        inverse = _inverse(blocks[first, first])
        factors[first] = {second: inverse @ blocks[first, second] for second in later[first]}
        right[first] = inverse @ right[first]
        for second in later[first]:
            flipped = blocks[first, second].transpose(0, 2, 1)
            right[second] = right[second] - flipped @ right[first]
            for third in later[first]:
                if third < second:
                    continue
                part = flipped @ factors[first][third]
                if (second, third) in blocks:
                    blocks[second, third] = blocks[second, third] - part
                else:
                    blocks[second, third] = -part
                    later[second] = sorted({*later[second], third})
    for first in reversed(order):
        for second, factor in factors[first].items():
            right[first] = right[first] - factor @ right[second]
    return right


def _inverse(matrices: Array) -> Array:
    try:
        return np.linalg.inv(matrices)
    except np.linalg.LinAlgError:
        # Tooth moments of a closed gear train load no joint, so nothing chooses between them.
        return np.asarray(np.linalg.pinv(matrices, hermitian=True))
