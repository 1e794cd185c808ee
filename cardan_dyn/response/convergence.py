"""Convergence: whether a response has enough samples, needs more, or cannot get any better."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array

PLATEAU = 1e-8
"""Greater errors are never taken for rounding, however slowly they fall: they come from functions
that need more samples."""
GAIN = 0.5
"""A doubling of the samples that leaves more than this part of an error has not lowered it.

Coefficients that fall off geometrically have their ratio squared by a doubling, whereas rounding
stays what it is."""


class Convergence(NamedTuple):
    """Errors of a series after one round of the refinement, and those of earlier rounds.

    Two errors are watched: what the series leaves out (its remainder), which its coefficients
    tell, and how far it deviates from directly solved positions. Measuring deviations costs a
    sum over the series, so it is done only once the remainder lets the refinement end.

    Attributes:
        tolerance: what errors may be, relative to the scale of each function.
        remainder: `(C,)` what the series leaves out, relative to the scale of each function.
        rounding: `(C,)` errors that rounding explains, relative likewise.
        previous_remainder: the greatest remainder of the round before; inf in the first round.
        deviation: `(C,)` deviations from directly solved positions; None if not measured.
        previous_deviation: the greatest deviation that was measured before; inf if none was.
    """

    tolerance: float
    remainder: Array
    rounding: Array
    previous_remainder: float = np.inf
    deviation: Array | None = None
    previous_deviation: float = np.inf

    def next_round(self, remainder: Array, rounding: Array) -> Convergence:
        """Return the convergence after another doubling, deviations not yet measured."""
        return Convergence(
            self.tolerance,
            remainder,
            rounding,
            previous_remainder=self.greatest_remainder,
            previous_deviation=(
                self.previous_deviation if self.deviation is None else self.greatest_deviation
            ),
        )

    def with_deviation(self, deviation: Array) -> Convergence:
        """Return the same round with its measured deviations `(C,)`."""
        return self._replace(deviation=deviation)

    @property
    def greatest_remainder(self) -> float:
        """The greatest remainder of all functions."""
        return float(np.max(self.remainder, initial=0.0))

    @property
    def greatest_deviation(self) -> float:
        """The greatest deviation of all functions; zero if not measured."""
        return 0.0 if self.deviation is None else float(np.max(self.deviation, initial=0.0))

    @property
    def error(self) -> float:
        """The greatest error of all functions."""
        return max(self.greatest_remainder, self.greatest_deviation)

    @property
    def is_below_tolerance(self) -> bool:
        """Whether no function leaves out more than the tolerance."""
        return self.greatest_remainder <= self.tolerance

    @property
    def has_stalled(self) -> bool:
        """Whether the last doubling no longer lowered the remainder, which is small."""
        return GAIN * self.previous_remainder < self.greatest_remainder < PLATEAU

    @property
    def is_rounded(self) -> bool:
        """Whether the remainder has stalled where rounding explains it.

        Coefficients do not fall below the rounding of the samples they are computed from.
        """
        return self.has_stalled and bool(np.all(self.remainder <= self.rounding))

    @property
    def may_end(self) -> bool:
        """Whether the remainder lets the refinement end, if the deviations do not object."""
        return self.is_below_tolerance or self.is_rounded

    @property
    def is_reached(self) -> bool:
        """Whether the series holds: measured deviations stay below tolerance or rounding."""
        return self.deviation is not None and bool(
            np.all(self.deviation <= np.maximum(self.tolerance, self.rounding))
        )

    @property
    def deviation_has_stalled(self) -> bool:
        """Whether the last doubling no longer lowered the measured deviation.

        More samples do not lower a deviation that has another cause than too few of them.
        """
        return (
            self.deviation is not None and self.greatest_deviation > GAIN * self.previous_deviation
        )

    @property
    def is_hopeless(self) -> bool:
        """Whether more samples would not help."""
        return self.has_stalled or self.deviation_has_stalled
