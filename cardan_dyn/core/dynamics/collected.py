"""Collected: what a sweep keeps of its blocks, written at once where it is returned."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...kit.arrays import Array
from ...kit.threads import in_threads
from ...kit.time_left import Task
from ..proof.condensed import condensed
from ..proof.residuals import Residuals
from .inverse_dynamics import Solution, refuse_overflow
from .velocity_ratios import VelocityRatios


def collected(
    spans: Sequence[slice],
    solve: Callable[[int], Solution],
    positions_of: Callable[[int], Array],
    guesses: Array | None,
    keeps_rates: bool = True,
) -> Solution:
    """Return what is kept of the blocks of a sweep, which are solved beside each other.

    Args:
        spans: samples of each block.
        solve: returns what is kept of a block, by its index.
        positions_of: returns its drive positions `(n, d)`.
        guesses: coordinates `(N, size)` that are overwritten with those of blocks that are solved.
        keeps_rates: whether velocities, accelerations and velocity ratios are kept.

    Raises:
        AccuracyError: a residual exceeds its tolerance, or numbers overflow.
    """
    rows = Rows(spans[-1].stop)
    if guesses is not None:
        rows.arrays["x"] = guesses

    def solved(index: int) -> Evidence:
        block = solve(index)
        rows.put(spans[index], kept(block, keeps_rates))
        return Evidence.of(block, positions_of(index))

    with Task("sweep", len(spans)) as task:
        return Evidence.concluded(in_threads(solved, range(len(spans)), task.tell), rows)


class Rows:
    """Arrays `(N, ...)` that are filled block by block, of which several may be put at once.

    Attributes:
        arrays: those that are known, by name.
    """

    def __init__(self, count: int) -> None:
        """Begin with none, for so many samples."""
        self.arrays: dict[str, Array] = {}
        self._count = count

    def put(self, span: slice, values: Mapping[str, Array]) -> None:
        """Keep the values of some samples."""
        for name, value in values.items():
            if name not in self.arrays:
                if len(value) == self._count:  # The only block needs no copy.
                    self.arrays[name] = value
                    continue
                # Of those that threads make at the same time, all of them fill the first.
                whole = np.empty((self._count, *value.shape[1:]), dtype=value.dtype)
                self.arrays.setdefault(name, whole)
            self.arrays[name][span] = value


class Evidence(NamedTuple):
    """What proves a block: of its samples, the few that decide what is said of the whole sweep.

    Attributes:
        loop_error, closure_condition: greatest ones.
        influence, couplings: see `Solution`.
        overflown: see `Solution`.
        moved: see `VelocityRatios`.
        residuals: of the samples that decide.
        refused: residuals, drive positions and closure conditions of all samples if any is refused.
    """

    loop_error: float
    closure_condition: float
    influence: Array
    couplings: set[int]
    overflown: set[str]
    moved: Array
    residuals: Residuals
    refused: tuple[Residuals, Array, Array] | None

    @staticmethod
    def of(block: Solution, positions: Array) -> Evidence:
        """Return the evidence of a block at drive positions `(n, d)`."""
        residuals, condition = block.residuals, block.closure_condition
        is_proven = residuals.is_proven()
        assert block.velocity_ratios is not None
        return Evidence(
            loop_error=float(np.max(block.loop_error)),
            closure_condition=float(np.max(condition)),
            influence=block.influence,
            couplings=block.indeterminate_couplings,
            overflown=block.overflown,
            moved=block.velocity_ratios.moved,
            residuals=condensed(residuals) if is_proven else residuals,
            refused=None if is_proven else (residuals, positions, condition),
        )

    @staticmethod
    def concluded(every: Sequence[Evidence], rows: Rows) -> Solution:
        """Return all that is kept of a sweep.

        Args:
            every: of its blocks, in their order.
            rows: its arrays.

        Raises:
            AccuracyError: a residual exceeds its tolerance, or numbers overflow.
        """
        refuse_overflow(set().union(*(item.overflown for item in every)))
        if refused := [item.refused for item in every if item.refused]:
            residuals, *of = zip(*refused, strict=True)
            Residuals.joined(list(residuals)).prove(*map(np.concatenate, of))
        arrays = dict(rows.arrays)
        v, a, ratios = (arrays.pop(name, None) for name in ("v", "a", "ratios"))
        return Solution(
            **arrays,
            v=v,
            a=a,
            velocity_ratios=None if ratios is None else VelocityRatios(ratios, every[0].moved),
            loop_error=np.max([[item.loop_error] for item in every], axis=0),
            closure_condition=np.max([[item.closure_condition] for item in every], axis=0),
            residuals=condensed(Residuals.joined([item.residuals for item in every])),
            influence=np.max([item.influence for item in every], axis=0),
            indeterminate_couplings=set().union(*(item.couplings for item in every)),
        )


def kept(block: Solution, keeps_rates: bool = True) -> dict[str, Array]:
    """Return the arrays of a block by their names, those of the velocity ratios as `ratios`."""
    arrays = {
        name: getattr(block, name) for name in ("x", "wrenches", "efforts", "coupling_moments")
    }
    arrays["cancellation"] = block.residuals.cancellation
    if keeps_rates and block.velocity_ratios is not None:
        arrays |= {"v": block.v, "a": block.a, "ratios": block.velocity_ratios.values}
    return arrays
