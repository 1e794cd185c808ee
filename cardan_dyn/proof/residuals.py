"""Residuals: proofs of a result that use none of the equations it was computed with."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array
from ..errors import AccuracyError, shown, where

if TYPE_CHECKING:
    from ..forces.link_loads import LinkLoad

BALANCE_TOLERANCE = 1e-8
"""Greatest Newton-Euler or power imbalance of a result, relative; of loops and rates likewise."""
CHECK_ROUNDING = 0.1 * float(np.finfo(float).eps)
"""What rounding hides from the balance of bodies, per size of inertial terms.

Their size is estimated with the length of the whole mechanism, some ten times that of its bodies.
"""
_HARMLESS = 1e6  # A condition number that explains no error of the size that is refused.
_ROUNDING = 1e-13  # Wrenches this much smaller than inertial terms are what rounding left of them.


@dataclass(frozen=True, eq=False, repr=False)
class Claim:
    """A result that is to be proven, for a block of N samples.

    Attributes:
        x: `(N, size)` coordinates of all joints.
        turns: `(N, size)` whole turns that their angles lack.
        v, a: joint velocities and accelerations `(N, nv)`.
        positions: of the drives, as they were asked for, `(N, d)`.
        speeds, accelerations: of the drives, as they were asked for, `(N, d)`.
        velocity_ratios: `(N, nv, d)` joint velocities per unit speed of each drive.
        wrenches: `(N, J, 6)` of the joints that are claimed, in the order of `claimed`.
        exerted: `(N, nv)` what drives and held joints exert.
        couplings: `(N, G)` moments of the couplings at their successors' joints.
        loads: `(N, nv)` or `(1, nv)` efforts added at the joints.
        link_loads: links and the wrenches that act on them.
        has_rates: whether `v` or `a` is not zero anywhere.
    """

    x: Array
    turns: Array
    v: Array
    a: Array
    positions: Array
    speeds: Array
    accelerations: Array
    velocity_ratios: Array
    wrenches: Array
    exerted: Array
    couplings: Array
    loads: Array
    link_loads: dict[str, LinkLoad]
    has_rates: bool


@dataclass(frozen=True, eq=False, repr=False)
class Residuals:
    """What is left over, and what that is compared with, per sample `(N,)`.

    Attributes:
        imbalance: greatest wrench [N·m] that a body or a free coordinate is left with; forces count
            times the length of the mechanism.
        power_imbalance: power [W at unit drive speeds] that is left over.
        loop_error: closure error, see `Sweep.loop_residual`.
        rate_error: how far rates violate loops and drives, relative.
        wrench: greatest joint wrench [N·m].
        applied: greatest load or weight [N·m].
        inertia: greatest size [N·m] of the terms that inertial wrenches are the sum of.
        power_scale: sum of the powers that flow [W at unit drive speeds].
        speed_scale: greatest joint speed at unit drive speeds, of slides over the length.
        bodies_balanced: whether the outputs tell the balance of any body.
        power_balanced: whether they tell the balance of power.
    """

    imbalance: Array
    power_imbalance: Array
    loop_error: Array
    rate_error: Array
    wrench: Array
    applied: Array
    inertia: Array
    power_scale: Array
    speed_scale: Array
    bodies_balanced: bool
    power_balanced: bool

    @staticmethod
    def joined(parts: list[Residuals]) -> Residuals:
        """Return the residuals of blocks of one sweep as one."""
        arrays = {
            field.name: np.concatenate([getattr(part, field.name) for part in parts])
            for field in fields(Residuals)
            if not field.name.endswith("balanced")
        }
        return Residuals(
            **arrays,
            bodies_balanced=parts[0].bodies_balanced,
            power_balanced=parts[0].power_balanced,
        )

    @property
    def cancellation(self) -> Array:
        """By how much single terms exceed the greatest wrench that their sum leaves `(N,)`."""
        left = np.maximum(self.wrench, self.applied)
        left = np.where(left > 0.0, left, self.inertia)
        return 1.0 + ratio(self.inertia, left)

    @property
    def balance(self) -> float:
        """Greatest imbalance of the bodies relative to the greatest wrench of all samples.

        What the rounding of inertial terms hides from the check counts as imbalance. Where nothing
        acts there is nothing to compare, and so no residual.
        """
        if not self.bodies_balanced:
            return float("nan")
        left = self.imbalance + CHECK_ROUNDING * self.inertia
        return _worst(left, self._greatest())

    @property
    def rate(self) -> float:
        """Greatest violation of loops, couplings and drives by rates, relative."""
        return float(np.max(self.rate_error))

    @property
    def power(self) -> float:
        """Greatest imbalance of power relative to the power that flows.

        A balanced mechanism passes no power on; then the greatest wrench times the greatest joint
        speed says how exact zero can be.
        """
        if not self.power_balanced:
            return float("nan")
        through = self.power_scale + self._greatest() * self.speed_scale
        return _worst(self.power_imbalance, through)

    def prove(self, positions: Array, condition: Array) -> None:
        """Refuse samples that miss the tolerance, rounding of inertial terms allowed for.

        Args:
            positions: of the drives `(N, d)`.
            condition: `(N,)` condition numbers for the message.

        Raises:
            AccuracyError: a residual misses its tolerance, or is not a number.
        """
        size = self.wrench + self.applied + self.inertia
        _prove("loop", self.loop_error, np.ones_like(self.loop_error), positions, condition)
        _prove("rate", self.rate_error, np.ones_like(self.rate_error), positions, condition)
        if self.bodies_balanced:
            _prove("balance", self.imbalance, size, positions, condition)
        if self.power_balanced:
            _prove(
                "power",
                self.power_imbalance,
                self.power_scale + size * self.speed_scale,
                positions,
                condition,
            )

    def _greatest(self) -> Array:
        greatest = np.max(np.maximum(self.wrench, self.applied))
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
    found = ratio(left, scale)
    # Not a number is no proof either.
    bad = ~((left <= BALANCE_TOLERANCE * scale) & (scale < np.inf))
    if not np.any(bad):
        return
    worst = int(np.argmax(np.where(bad, np.nan_to_num(found, nan=np.inf), -1.0)))
    if not np.isfinite(found[worst]) or not np.isfinite(scale[worst]):
        raise overflow(f"the {name} residual at drive position {shown(positions[worst])}")
    if condition[worst] < _HARMLESS:
        advice = "which explains no such error: please report it with the scene"
    else:
        advice = "stay away from this position or choose another drive"
    raise AccuracyError(
        f"the {name} residual is {found[worst]:.1e} at drive position "
        f"{shown(positions[worst])}, more than {BALANCE_TOLERANCE:.0e}; the closure "
        f"equations have condition {condition[worst]:.1e} there: {advice}",
        residual=float(found[worst]),
        tolerance=BALANCE_TOLERANCE,
        position=where(positions[worst]),
    )


def _worst(error: Array, scale: Array) -> float:
    """Return the greatest relative error, not a number where there is nothing to compare."""
    if not np.any(error) and not np.any(scale):
        return float("nan")
    return float(np.max(ratio(error, scale)))


def ratio(part: Array, whole: Array) -> Array:
    """Return `part / whole`, beyond bounds where something is compared with nothing."""
    # Numbers next to nothing have no digits that could agree.
    with np.errstate(invalid="ignore", over="ignore"):
        return np.where(part == 0.0, 0.0, part / (whole + 1e-300))
