"""Traced: a text of one sample as programs that run for many, once enough samples are proven.

To trace a text takes as long as to compute some thousand samples by it. So the first ones are
computed with floats or arrays, until as many were asked for. When, follows from their number alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np

from ..arrays import Array
from ..mechanism.frames import Frames
from ..tape import WORTH_TRACING, Program, Scalar, Trace, machine_is_at_hand
from .samples import Rows, Sample
from .vectors import greatest

Text: TypeAlias = Callable[[Sample], Sequence[Scalar]]

_FLOATS, _ARRAYS = WORTH_TRACING // 16, WORTH_TRACING // 2
"""What a call is worth, in samples: with floats, and with arrays, which take as long for a few."""
_MOST_KINDS = 8
"""Kinds of claims whose programs are kept, the last ones: of most scenes there are one or two."""


class _Known:
    """What is known of claims of a kind.

    Attributes:
        asked: samples that were computed without a program, and what their calls are worth.
        acting: which rows were not zero at one of these, or of those before.
        program: None if there is none yet. Its last result is zero where it holds: where all rows
            are zero that it leaves out.
    """

    def __init__(self) -> None:
        self.asked = 0
        self.acting: Array | None = None
        self.program: Program | None = None

    def is_worth_tracing(self, rows: Rows, samples: int) -> bool:
        """Take note of claims that no program holds for; return whether there should be one."""
        acting = rows.acting()
        self.acting = acting if self.acting is None else self.acting | acting
        self.asked += max(samples, _FLOATS if rows.count == 1 else _ARRAYS)
        return self.asked >= WORTH_TRACING

    def trace(self, text: Text, rows: Rows, frames: Frames) -> None:
        """Make the program of all rows that were seen to act."""
        assert self.acting is not None
        trace = Trace()
        variables, acting = rows.variables(trace), self.acting.tolist()
        pairs = list(zip(variables, acting, strict=True))
        sample = rows.sample([own if acts else 0.0 for own, acts in pairs], frames)
        left_out = greatest(own for own, acts in pairs if not acts)
        self.program = Program(trace, (*text(sample), left_out), keeps_inputs=True)
        self.asked = 0

    def results(self, rows: Rows) -> Array | None:
        """Return the results of the program; None where it does not hold."""
        if self.program is None:
            return None
        results = self.program.run_rows(rows.parts, rows.count)
        return None if np.count_nonzero(results[-1]) else results[:-1]


class Programs:
    """What a text computes of claims, by a program where these are worth one."""

    def __init__(self) -> None:
        self._of_kinds: dict[tuple[Any, ...], _Known] = {}

    def results(self, text: Text, rows: Rows, samples: int, frames: Frames) -> Array:
        """Return what a text computes of claims, a row for each result.

        Args:
            text: the text.
            rows: of the claims.
            samples: how many the whole sweep has.
            frames: of the description.
        """
        # Without the machine, each operation is a call of NumPy, ten times as slow as floats.
        if rows.count > 1 or machine_is_at_hand():
            known = self._known(rows)
            results = known.results(rows)
            if results is None and known.is_worth_tracing(rows, samples):
                known.trace(text, rows, frames)
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

    def _known(self, rows: Rows) -> _Known:
        known = self._of_kinds.get(rows.kind)
        if known is None:
            if len(self._of_kinds) == _MOST_KINDS:
                self._of_kinds.pop(next(iter(self._of_kinds)))
            known = self._of_kinds[rows.kind] = _Known()
        return known
