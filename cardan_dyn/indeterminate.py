"""Indeterminate: closure forces that the laws of motion leave open, and how they are chosen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from .coordinates import Array


@dataclass(frozen=True)
class Undetermined:
    """Closure forces that change no passive effort.

    Attributes:
        forces: per loop `(N, 6, k)` in world axes about the origin of its group's twin, and per
            coupling, counted on from the loops, `(N, 1, k)`.
        spread: per joint that they load, what they add to its wrench, `(N, 6, k)`.
    """

    forces: dict[int, Array]
    spread: dict[int, Array]


class Choice(Protocol):
    """A rule that chooses undetermined closure forces."""

    def apply(
        self, wrenches: Array, closure: list[Array], undetermined: list[Undetermined]
    ) -> Array:
        """Add the chosen forces to `wrenches (b, N, 6)` and `closure`, in place.

        Returns:
            `(b, 6)` greatest change of each component per unit of undetermined force.
        """
        ...


class Quadratic:
    """The undetermined forces that make a quadratic form of all joint wrenches least.

    Two sets of forces are coupled only where they load the same joint, so the normal equations
    are sparse: a row of loops gives a band, which is eliminated block by block at a cost that is
    linear in the number of loops.
    """

    def weighed(self, joint: int, spread: Array) -> Array:
        """Return the form's matrix for a joint times `spread (N, 6, k)`."""
        raise NotImplementedError

    def measure(self) -> Array:
        """Return `(6,)` factors that make components comparable in a report of influence."""
        raise NotImplementedError

    def apply(
        self, wrenches: Array, closure: list[Array], undetermined: list[Undetermined]
    ) -> Array:
        """See `Choice.apply`."""
        touching: dict[int, list[int]] = {}
        for number, item in enumerate(undetermined):
            for joint in item.spread:
                touching.setdefault(joint, []).append(number)
        blocks: dict[tuple[int, int], Array] = {}
        right: dict[int, Array] = {}
        influence = np.zeros((len(wrenches), 6))
        for joint, numbers in touching.items():
            for first in numbers:
                spread = undetermined[first].spread[joint]
                weighed = self.weighed(joint, spread)
                flipped = weighed.transpose(0, 2, 1)
                part = -(flipped @ wrenches[joint][:, :, None])
                right[first] = right[first] + part if first in right else part
                for second in numbers:
                    if second < first:
                        continue
                    block = flipped @ undetermined[second].spread[joint]
                    key = (first, second)
                    blocks[key] = blocks[key] + block if key in blocks else block
                measured = np.max(np.abs(spread), axis=(0, 2)) * self.measure()
                influence[joint] = np.maximum(influence[joint], measured)
        for number, amount in _solve_sparse(blocks, right).items():
            item = undetermined[number]
            for joint, spread in item.spread.items():
                wrenches[joint] += (spread @ amount)[:, :, 0]
            for loop, forces in item.forces.items():
                closure[loop] += (forces @ amount)[:, :, 0]
        return influence


class LeastNorm(Quadratic):
    """Least sum of squares over all joints: moments, and forces times a length.

    The sum does not depend on where a ring was cut, nor on the order of the joints.
    """

    def __init__(self, length: float) -> None:
        self.length = length
        self._squares = np.repeat([length**2, 1.0], 3)[:, None]

    def weighed(self, joint: int, spread: Array) -> Array:
        """Return `spread` with forces times the length squared."""
        return spread * self._squares

    def measure(self) -> Array:
        """Return the length for forces, 1 for moments."""
        return np.repeat([self.length, 1.0], 3)


def _solve_sparse(
    blocks: dict[tuple[int, int], Array], right: dict[int, Array]
) -> dict[int, Array]:
    """Solve a symmetric positive definite block system, for all samples at once.

    Args:
        blocks: upper triangle: `(i, j)` with i ≤ j to `(N, k_i, k_j)`.
        right: `i` to `(N, k_i, 1)`; used up.
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
