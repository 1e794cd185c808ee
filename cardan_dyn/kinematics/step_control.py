"""Step control: how far the end of a branch may go in one step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array

WORST = 4.0
"""How many times as far as it should an extrapolation may be off."""
_FIRST_STEP = 2.0 * np.pi / 16.0
_LONGEST_STEP = 2.0 * np.pi / 8.0
_SHORTEST_STEP = 1e-9
_APPROACH = 0.7  # How much of the way to a singular position a step may go.
_STEP_CORRECTION = 0.03  # How far an extrapolation should be off,
_GENTLE = 100.0  # Condition up to which it may be off as far as that.


@dataclass
class StepControl:
    """An end of a branch on its way.

    Attributes:
        end: 0 or -1, its place among the nodes.
        sign: where it goes.
        target: drive position to reach.
        unit: what counts as one radian's worth of the drive.
        margin: reciprocal condition number where it is.
        step: what to try next.
    """

    end: int
    sign: float
    target: float
    unit: float
    margin: float
    step: float = 0.0

    def __post_init__(self) -> None:
        # At a distance δ from where ways meet the condition is some 3/δ or more.
        self.step = min(_FIRST_STEP, 3.0 * self.margin) * self.unit

    @property
    def stopped(self) -> bool:
        """Whether steps have become too short to go on."""
        return self.step < _SHORTEST_STEP * self.unit

    def left(self, position: float) -> float:
        """Return how far the target still is."""
        return self.sign * (self.target - position)

    def ahead(self, position: float) -> float:
        """Return the next position: at the end the target itself, not a sum of steps."""
        if self.left(position) <= self.step:
            return self.target
        return position + self.sign * self.step

    def arrive(self, moved: float, bad: float, margin: float) -> None:
        """Choose the next step after one by `moved`.

        Beyond a point where the margin vanishes several ways may go on: it is approached, so that
        it is found, and never stepped over.

        Args:
            moved: how far it went.
            bad: how far extrapolations were off, relative to how far they should be.
            margin: where it is now.
        """
        # The error of an extrapolation grows with the third power of the step.
        step = moved * min(2.5, max(bad, 1e-3) ** (-1.0 / 3.0))
        self.step = min(step, _LONGEST_STEP * self.unit)
        if margin < self.margin:
            self.step = min(self.step, _APPROACH * moved * margin / (self.margin - margin))
        self.margin = margin

    def fall_back(self) -> None:
        """Choose a shorter step after one that was refused."""
        self.step *= 0.35


def room(condition: Array) -> Array:
    """Return how far extrapolations should be off, by the condition of where they lead."""
    # Other ways of assembling the mechanism come as near as its condition is bad.
    return _STEP_CORRECTION * np.minimum(1.0, _GENTLE / condition)
