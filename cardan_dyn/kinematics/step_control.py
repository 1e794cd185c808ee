"""Step control: how far the end of a branch may move in one step."""

from __future__ import annotations

import numpy as np

from ..arrays import Array

REJECTED_EXCESS = 4.0
"""Ratio of an extrapolation's error to the allowed correction from which on its step is rejected.
The error grows with the third power of the step, so such a step is 1.6 times too long."""
_FIRST_STEP = 2.0 * np.pi / 16.0
"""Step [units of the drive] that is tried first; step control corrects it after one trial."""
_LONGEST_STEP = 2.0 * np.pi / 8.0
"""Longest step [units of the drive], so that even a motion without any error has eight nodes per
turn."""
_SHORTEST_STEP = 1e-9
"""Step [units of the drive] below which the end cannot be followed any farther. It is far above
the rounding of drive positions, so that a step always moves."""
_SINGULAR_DISTANCE = 3.0
"""Distance to a singular configuration times the condition number there, as a lower bound: at a
distance δ from where assembly modes meet, the condition number is about 3/δ or more."""
_APPROACH = 0.7
"""Share of the estimated way to a singular configuration that one step may go. Below one, the
margin stays positive and the singular configuration is never stepped over."""
_GREATEST_GROWTH = 2.5
"""Factor by which a step may grow at once: the error of the last step says little about the error
of a much longer one."""
_LEAST_EXCESS = 1e-3
"""Lower bound of the error ratio in the formula for the next step, where zero has no negative
power. It changes nothing else: `_GREATEST_GROWTH` limits the step at any ratio below 0.064."""
_SHRINKAGE = 0.35
"""Factor by which a rejected step shrinks: the error of an extrapolation falls to a 23rd, which is
accepted if it was up to 90 times the allowed correction."""
_EXTRAPOLATION_ORDER = 3.0
"""Power of the step with which the error of an extrapolation by two derivatives grows."""
_ALLOWED_CORRECTION = 0.03
"""Allowed error [rad] of an extrapolation where the closure equations are well conditioned: small
against the distance between assembly modes, so that Newton's method cannot change the mode."""
_WELL_CONDITIONED = 100.0
"""Condition number up to which `_ALLOWED_CORRECTION` holds undiminished."""


class StepControl:
    """Chooses the steps of one end of a branch on the way to a target.

    Attributes:
        sign: direction of motion, 1 or -1.
        target: drive position to reach [rad or m].
        unit: drive displacement that counts as one radian [rad or m].
        margin: reciprocal condition number at the end of the branch; zero if singular.
        step: length of the step to try next, positive [rad or m].
    """

    def __init__(self, sign: float, target: float, unit: float, margin: float) -> None:
        self.sign = sign
        self.target = target
        self.unit = unit
        self.margin = margin
        self.step = min(_FIRST_STEP, _SINGULAR_DISTANCE * margin) * unit

    @property
    def is_stopped(self) -> bool:
        """Whether steps have become too short to go on."""
        return self.step < _SHORTEST_STEP * self.unit

    def remaining(self, position: float) -> float:
        """Return the distance from a drive position to the target, negative beyond it."""
        return self.sign * (self.target - position)

    def next_position(self, position: float) -> float:
        """Return the position to try next: at last the target itself, not a sum of steps."""
        if self.remaining(position) <= self.step:
            return self.target
        return position + self.sign * self.step

    def accept(self, step: float, excess: float, margin: float) -> None:
        """Choose the next step after a successful one.

        Beyond a singular configuration the branch may go on in several ways. It is therefore
        approached in ever shorter steps, so that it is found, and never stepped over.

        Args:
            step: length of the successful step [rad or m].
            excess: ratio of the extrapolation's error to the allowed correction.
            margin: reciprocal condition number at the position that was reached.
        """
        growth = max(excess, _LEAST_EXCESS) ** (-1.0 / _EXTRAPOLATION_ORDER)
        self.step = min(step * min(_GREATEST_GROWTH, growth), _LONGEST_STEP * self.unit)
        if margin < self.margin:
            # The margin is taken to fall in proportion to the distance from where it vanishes.
            self.step = min(self.step, _APPROACH * step * margin / (self.margin - margin))
        self.margin = margin

    def reject(self) -> None:
        """Choose a shorter step after one that failed."""
        self.step *= _SHRINKAGE


def allowed_correction(condition: Array) -> Array:
    """Return how far extrapolations may be off [rad], from the condition numbers they lead to.

    Other assembly modes come nearer in proportion to the condition number.
    """
    return _ALLOWED_CORRECTION * np.minimum(1.0, _WELL_CONDITIONED / condition)
