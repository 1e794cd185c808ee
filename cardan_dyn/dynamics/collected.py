"""Collected: what a sweep keeps of its blocks, written at once where it is returned."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from ..arrays import Array
from ..proof.residuals import Residuals
from ..time_left import Task
from .inverse_dynamics import Solution, refuse_overflow
from .velocity_ratios import VelocityRatios

_MOST_SAMPLES = 16_384
"""Samples whose residuals wait until those that decide are chosen, so that this takes no time."""


def collected(
    spans: Sequence[slice],
    solve: Callable[[int], Solution],
    positions_of: Callable[[int], Array],
    guesses: Callable[[Callable[[Array], Array] | None], Array] | None,
    workers: int,
    keeps_rates: bool = True,
) -> Solution:
    """Return what is kept of the blocks of a sweep.

    Args:
        spans: samples of each block.
        solve: returns what is kept of a block, by its index.
        positions_of: returns its drive positions `(n, d)`.
        guesses: returns coordinates `(N, size)` that may be overwritten with those of blocks that
            are solved; in an array that it is handed the maker of, if there is one.
        workers: greatest number of processes that divide the blocks among them.
        keeps_rates: whether velocities, accelerations and velocity ratios are kept.

    Raises:
        AccuracyError: a residual exceeds its tolerance, or numbers overflow.
    """
    shares = [range(1, len(spans))]
    if workers > 1:
        from .workers import in_order, shares_of  # Most sweeps are done by one.

        shares = [range(max(1, item.start), item.stop) for item in shares_of(len(spans), workers)]
    rows = Rows(spans[-1].stop, is_shared=len(shares) > 1)
    if guesses is not None:
        rows.arrays["x"] = guesses(rows.empty if len(shares) > 1 else None)

    def solved(blocks: range) -> Evidence:
        evidence = Evidence()
        with Task("sweep", len(blocks)) as task:
            for index in blocks:
                block = solve(index)
                rows.put(spans[index], kept(block, keeps_rates))
                evidence.add(block, positions_of(index))
                if block.velocity_ratios is not None:
                    evidence.moved = block.velocity_ratios.moved
                task.tell(index - blocks.start + 1)
        return evidence

    if len(shares) == 1:
        return solved(range(len(spans))).concluded(rows)
    # The first one before others are forked, who need to know the arrays.
    first = solved(range(1))
    return first.concluded(rows, in_order(lambda blocks: solved(blocks).condensed(), shares))


class Rows:
    """Arrays `(N, ...)` that are filled block by block.

    Attributes:
        arrays: those that are known, by name.
    """

    def __init__(self, count: int, is_shared: bool = False) -> None:
        """Begin with none.

        Args:
            count: number of samples.
            is_shared: whether other processes, forked later, fill them too.
        """
        self.arrays: dict[str, Array] = {}
        self._count, self._is_shared = count, is_shared

    def put(self, span: slice, values: Mapping[str, Array]) -> None:
        """Keep the values of some samples."""
        for name, value in values.items():
            if name not in self.arrays:
                if len(value) == self._count:  # The only block needs no copy.
                    self.arrays[name] = value
                    continue
                self.arrays[name] = self.empty(value)
            self.arrays[name][span] = value

    def empty(self, like: Array) -> Array:
        """Return an array for all samples, of the kind of one `(n, ...)` of some of them."""
        shape = (self._count, *like.shape[1:])
        if not self._is_shared:
            return np.empty(shape, dtype=like.dtype)
        count = math.prod(shape)
        import mmap  # Most sweeps are done by one process.

        memory = mmap.mmap(-1, max(1, count * like.dtype.itemsize))
        return np.frombuffer(memory, dtype=like.dtype, count=count).reshape(shape)


class Evidence:
    """What proves samples, and what is kept of that: a few samples decide what is said of all.

    Attributes:
        moved: see `VelocityRatios`.
    """

    moved: Array

    def __init__(self) -> None:
        self._loop_error, self._closure_condition = 0.0, 1.0
        self._influence: Array | None = None
        self._couplings: set[int] = set()
        self._overflown: set[str] = set()
        self._waiting: list[tuple[Residuals, Array, Array]] = []
        self._refused: list[tuple[Residuals, Array, Array]] = []
        self._kept: list[Residuals] = []
        self._count = 0

    def add(self, block: Solution, positions: Array) -> None:
        """Take the evidence of a block at drive positions `(n, d)`."""
        self._overflown |= block.overflown
        self._loop_error = float(np.max(block.loop_error, initial=self._loop_error))
        self._closure_condition = float(
            np.max(block.closure_condition, initial=self._closure_condition)
        )
        known = self._influence
        self._influence = block.influence if known is None else np.maximum(known, block.influence)
        self._couplings |= block.indeterminate_couplings
        self._waiting.append((block.residuals, positions, block.closure_condition))
        self._count += len(positions)
        if self._count >= _MOST_SAMPLES:
            self.condensed()

    def condensed(self) -> Evidence:
        """Judge the samples that wait, keep those that decide, and return this."""
        if not self._waiting:
            return self
        residuals, positions, condition = _joined(self._waiting)
        if residuals.is_proven():
            from ..proof.condensed import condensed  # Few sweeps have so many samples.

            self._kept = [condensed(Residuals.joined([*self._kept, residuals]))]
        else:
            self._refused.append((residuals, positions, condition))
        self._waiting, self._count = [], 0
        return self

    def concluded(self, rows: Rows, others: Sequence[Evidence] = ()) -> Solution:
        """Return all that is kept of a sweep.

        Args:
            rows: its arrays.
            others: of the samples behind those of this one, in their order.

        Raises:
            AccuracyError: a residual exceeds its tolerance, or numbers overflow.
        """
        every = [self, *others]
        influences = [item._influence for item in every if item._influence is not None]
        overflown = set().union(*(item._overflown for item in every))
        refuse_overflow(overflown)
        refused = [part for item in every for part in (*item._refused, *item._waiting)]
        if refused:
            residuals, positions, condition = _joined(refused)
            residuals.prove(positions, condition)
        kept = [part for item in every for part in (*item._kept, *(w[0] for w in item._waiting))]
        arrays = dict(rows.arrays)
        names = ("v", "a", "ratios", "magnification")
        v, a, ratios, magnification = (arrays.pop(name, None) for name in names)
        return Solution(
            **arrays,
            magnification=magnification,
            v=v,
            a=a,
            velocity_ratios=None if ratios is None else VelocityRatios(ratios, self.moved),
            loop_error=np.max([[item._loop_error] for item in every], axis=0),
            closure_condition=np.max([[item._closure_condition] for item in every], axis=0),
            residuals=kept[0] if len(kept) == 1 else Residuals.joined(kept),
            influence=np.max(influences, axis=0),
            indeterminate_couplings=set().union(*(item._couplings for item in every)),
        )


def kept(block: Solution, keeps_rates: bool = True) -> dict[str, Array]:
    """Return the arrays of a block by their names, those of the velocity ratios as `ratios`."""
    names = ("x", "wrenches", "efforts", "coupling_moments", "magnification", "cancellation")
    arrays = {name: getattr(block, name) for name in names if getattr(block, name) is not None}
    if keeps_rates and block.velocity_ratios is not None:
        arrays |= {"v": block.v, "a": block.a, "ratios": block.velocity_ratios.values}
    return arrays


def _joined(parts: list[tuple[Residuals, Array, Array]]) -> tuple[Residuals, Array, Array]:
    if len(parts) == 1:
        return parts[0]
    residuals, positions, conditions = zip(*parts, strict=True)
    return Residuals.joined(list(residuals)), np.concatenate(positions), np.concatenate(conditions)
