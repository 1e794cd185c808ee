"""Traced: a text of one sample as programs that run for any number of samples.

A claim of a kind that was not seen before is traced, which takes as long as some dozen samples take
by the text itself. The program is kept with the mechanism. Where there is no machine, the text is
computed with floats or arrays.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np

from ...kit.arrays import Array
from ...kit.threads import in_turn
from ..mechanism.frames import Frames
from ..mechanism.kept import MOST
from ..tape import Program, Scalar, Trace, machine_is_at_hand
from .samples import Rows, Sample
from .vectors import greatest

Text: TypeAlias = Callable[[Sample], Sequence[Scalar]]

_MOST_TRACED = 256
"""Velocity ratios up to which a claim is traced: each drive by itself moves all bodies in the text,
so that tracing takes as long as their number is large. More take arrays."""


class _Known:
    """A program for claims of a kind.

    Attributes:
        acting: which rows were not zero when it was traced. Its last result is zero where it holds:
            where all others are.
        program: the program.
    """

    def __init__(self, text: Text, rows: Rows, frames: Frames, acting: Array) -> None:
        """Trace a text; arguments as of `Programs.results`, and the attribute."""
        in_turn()
        self.acting = acting
        with Trace() as trace:
            pairs = list(zip(rows.variables(trace), acting.tolist(), strict=True))
            sample = rows.sample([own if acts else 0.0 for own, acts in pairs], frames)
            left_out = greatest(own for own, acts in pairs if not acts)
            self.program = Program(trace, (*text(sample), left_out), keeps_inputs=True)

    def results(self, rows: Rows) -> Array | None:
        """Return the results of the program; None where it does not hold."""
        results = self.program.run_rows(rows.parts, rows.count)
        return None if np.count_nonzero(results[-1]) else results[:-1]


class Programs:
    """What a text computes of claims, by programs where there is a machine to run them."""

    def __init__(self) -> None:
        self._of_kinds: dict[tuple[Any, ...], _Known] = {}

    def results(self, text: Text, rows: Rows, frames: Frames) -> Array:
        """Return what a text computes of claims, a row for each result.

        They are alike to the last bit for any number of claims beside each other.

        Args:
            text: the text.
            rows: of the claims.
            frames: of the description.
        """
        if machine_is_at_hand() and rows.ratios <= _MOST_TRACED:
            known = self._known(text, rows, frames)
            results = known.results(rows)
            if results is None:
                known = _Known(text, rows, frames, known.acting | rows.acting())
                self._of_kinds[rows.kind] = known
                results = known.results(rows)
            if results is not None:
                return results
        # What overflows is refused by those who judge results.
        with np.errstate(over="ignore", invalid="ignore"):
            computed = text(rows.sample(rows.scalars, frames))
        results = np.empty((len(computed), rows.count))
        for row, values in zip(results, computed, strict=True):
            row[:] = values
        return results

    def _known(self, text: Text, rows: Rows, frames: Frames) -> _Known:
        known = self._of_kinds.get(rows.kind)
        if known is None:
            if len(self._of_kinds) == MOST:
                self._of_kinds.pop(next(iter(self._of_kinds)))
            known = self._of_kinds[rows.kind] = _Known(text, rows, frames, rows.acting())
        return known
