"""Residuals: proofs of a result that use none of the equations it was computed with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .coordinates import Array
from .errors import AccuracyError

BALANCE_TOLERANCE = 1e-8
"""Greatest Newton-Euler or power imbalance of a result, relative."""
CHECK_ROUNDING = 0.1 * float(np.finfo(float).eps)
"""What rounding hides from the balance of bodies, per size of inertial terms.

Their size is estimated with the length of the whole mechanism, some ten times that of its bodies.
"""
_ROUNDING = 1e-13  # Wrenches this much smaller than inertial terms are what rounding left of them.


@dataclass(frozen=True, eq=False, repr=False)
class Residuals:
    """What is left over, and what that is compared with, per sample `(N,)`.

    Attributes:
        unmet: greatest wrench [N·m] that a body or a free coordinate is left with; forces count
            times the length of the mechanism.
        unspent: power [W at unit drive speeds] that is left over.
        wrench: greatest joint wrench [N·m].
        inertia: greatest size [N·m] of the terms that inertial wrenches are the sum of.
        flow: sum of the powers that flow [W at unit drive speeds].
        fastest: greatest joint speed at unit drive speeds, of slides over the length.
        bodies_balanced: whether the outputs tell the balance of any body.
        power_balanced: whether they tell the balance of power.
    """

    unmet: Array
    unspent: Array
    wrench: Array
    inertia: Array
    flow: Array
    fastest: Array
    bodies_balanced: bool = True
    power_balanced: bool = True

    @staticmethod
    def unknown(count: int) -> Residuals:
        """Return the residuals of samples whose outputs leave all bodies out."""
        zero = np.zeros(count)
        return Residuals(
            zero, zero, zero, zero, zero, zero, bodies_balanced=False, power_balanced=False
        )

    @staticmethod
    def joined(parts: list[Residuals]) -> Residuals:
        """Return the residuals of blocks of one sweep as one."""
        return Residuals(
            unmet=np.concatenate([part.unmet for part in parts]),
            unspent=np.concatenate([part.unspent for part in parts]),
            wrench=np.concatenate([part.wrench for part in parts]),
            inertia=np.concatenate([part.inertia for part in parts]),
            flow=np.concatenate([part.flow for part in parts]),
            fastest=np.concatenate([part.fastest for part in parts]),
            bodies_balanced=parts[0].bodies_balanced,
            power_balanced=parts[0].power_balanced,
        )

    @property
    def cancellation(self) -> Array:
        """By how much single terms exceed the greatest wrench that their sum leaves `(N,)`."""
        return 1.0 + _relative(self.inertia, self.wrench)

    @property
    def balance(self) -> float:
        """Greatest imbalance of the bodies relative to the greatest wrench of all samples.

        What the rounding of inertial terms hides from the check counts as imbalance.
        """
        if not self.bodies_balanced:
            return float("nan")
        left = self.unmet + CHECK_ROUNDING * self.inertia
        return float(np.max(_relative(left, self._greatest())))

    @property
    def power(self) -> float:
        """Greatest imbalance of power relative to the power that flows.

        A balanced mechanism passes no power on; then the greatest wrench times the greatest joint
        speed says how exact zero can be.
        """
        if not self.power_balanced:
            return float("nan")
        through = self.flow + self._greatest() * self.fastest
        return float(np.max(_relative(self.unspent, through)))

    def prove(self, positions: Array, condition: Array) -> None:
        """Refuse samples that miss the tolerance, rounding of inertial terms allowed for.

        Args:
            positions: of the drives `(N, d)`.
            condition: `(N,)` condition numbers for the message.

        Raises:
            AccuracyError: a residual misses its tolerance, or is not a number.
        """
        size = self.wrench + self.inertia
        if self.bodies_balanced:
            _prove("balance", self.unmet, size, positions, condition)
        if self.power_balanced:
            _prove("power", self.unspent, self.flow + size * self.fastest, positions, condition)

    def _greatest(self) -> Array:
        greatest = np.max(self.wrench)
        noise = greatest <= _ROUNDING * self.inertia
        return np.where(noise, self.inertia, greatest)


def overflow(what: str) -> AccuracyError:
    """Return the error that numbers are too great, or too different, for doubles."""
    return AccuracyError(
        f"{what} cannot be computed, since numbers overflow; choose units in which lengths, "
        "masses, speeds and loads are not so far from 1",
        residual=float("nan"),
        tolerance=BALANCE_TOLERANCE,
        position=None,
    )


def _prove(name: str, left: Array, scale: Array, positions: Array, condition: Array) -> None:
    found = _relative(left, scale)
    # Not a number is no proof either.
    bad = ~((left <= BALANCE_TOLERANCE * scale) & (scale < np.inf))
    if not np.any(bad):
        return
    worst = int(np.argmax(np.where(bad, np.nan_to_num(found, nan=np.inf), -1.0)))
    if not np.isfinite(found[worst]) or not np.isfinite(scale[worst]):
        raise overflow(f"the {name} residual at drive position {positions[worst].tolist()}")
    raise AccuracyError(
        f"the {name} residual is {found[worst]:.1e} at drive position "
        f"{positions[worst].tolist()}, more than {BALANCE_TOLERANCE:.0e}; the closure "
        f"equations have condition {condition[worst]:.1e} there: stay away "
        "from this position or choose another drive",
        residual=float(found[worst]),
        tolerance=BALANCE_TOLERANCE,
        position=positions[worst],
    )


def _relative(error: Array, scale: Array) -> Array:
    return np.asarray(np.divide(error, scale, out=np.zeros_like(error), where=scale != 0.0))
