"""Joint scan: what play would do in one joint, and how far the estimate can be trusted."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Array

_REVERSAL = 0.03
"""Turn-through number up to which a swing behaves as if the force vanished, within some 7 %."""
_STAYS = 0.3
"""The same from which on the sides usually do not part."""
_FLOWN = 0.4
"""Angle flown, as a fraction of that to the rigid maximum, up to which the ramp is straight enough:
1 to 5 %."""
_LEAST_TAU = 3.0
"""Below, the estimate has not been checked against simulation of whole mechanisms."""
_MASS_CHANGE = 0.1
_DEVIATION = math.radians(20.0)


@dataclass(frozen=True, eq=False)
class Reversal:
    """What happens where the force of a joint swings round.

    Attributes:
        position: of the drive where the force is least [rad].
        force_slope: F₀/t₀, how fast the force grows [N/s].
        direction: `(3,)` unit vector in which it grows, in the world.
        reduced_mass: m that it moves, free to move across it [kg].
        guided_mass: the same if the sides are held from moving across [kg].
        contact_time: t₁ from the reversal to the impact [s].
        impact_speed: v₁ [m/s].
        tau: √(c/m) times the time in the play from rest.
        peak: greatest force after the impact [N]; NaN if there is none.
        rigid: part of an undamped peak that the ramp has reached by then [N].
        added: part of an undamped peak that the play adds [N].
        turn_through: ρ, the least force as a fraction of what the ramp gains over the flight: 0 of
            a true reversal.
        flown: angle that the drive turns during the flight, as a fraction of that to the next
            greatest force of the rigid mechanism.
        mass_change: of the reduced mass over the flight, as a fraction.
        deviation: angle between the force and the motion that it causes [rad].
    """

    position: float
    force_slope: float
    direction: Array
    reduced_mass: float
    guided_mass: float
    contact_time: float
    impact_speed: float
    tau: float
    peak: float
    rigid: float
    added: float
    turn_through: float
    flown: float
    mass_change: float
    deviation: float

    @property
    def energy(self) -> float:
        """Kinetic energy of the impact, m v₁² / 2 [J]."""
        return 0.5 * self.reduced_mass * self.impact_speed**2

    @property
    def strikes(self) -> bool:
        """Whether there is an impact with a peak: the sides part, and the force rises and falls."""
        return self.turn_through < _STAYS and not math.isnan(self.peak)

    @property
    def doubts(self) -> tuple[str, ...]:
        """Why the estimate may be wrong; empty if its assumptions hold."""
        doubts = []
        if self.turn_through > _REVERSAL:
            what = "less than this" if self.turn_through < _STAYS else "usually no impact"
            doubts.append(f"the force turns through (ρ = {self.turn_through:.2f}): {what}")
        if math.isnan(self.peak):
            doubts.append("no peak: the force only follows the ramp (τ below 1.8386)")
        elif self.tau < _LEAST_TAU:
            doubts.append(f"τ = {self.tau:.2f} is small")
        if self.flown > _FLOWN:
            doubts.append(f"the ramp bends over the flight ({self.flown:.2f} of the way): too high")
        if abs(self.mass_change) > _MASS_CHANGE:
            doubts.append(f"the reduced mass changes by {100 * self.mass_change:.0f} %")
        if self.deviation > _DEVIATION:
            doubts.append(
                f"the sides part {math.degrees(self.deviation):.0f}° beside the force's direction"
            )
        return tuple(doubts)

    def row(self) -> dict[str, Any]:
        """Return its numbers by name, and the doubts as text."""
        values = {name: value for name, value in vars(self).items() if name != "direction"}
        directions = {f"direction_{axis}": float(self.direction[k]) for k, axis in enumerate("xyz")}
        return {**values, **directions, "energy": self.energy, "doubts": "; ".join(self.doubts)}


@dataclass(frozen=True, eq=False)
class JointScan:
    """What play would do in a joint.

    Attributes:
        name: of the joint.
        position: of the drive over a period `(N,)` [rad].
        force: across the pin `(N, 3)` in the world, exerted on the child link [N]: its polar
            diagram.
        reversals: where it swings round, in order of position.
        turning: number of positions at which the force is least but far from zero.
        periods: per second [1/s].
    """

    name: str
    position: Array
    force: Array
    reversals: tuple[Reversal, ...]
    turning: int
    periods: float

    @property
    def rigid_peak(self) -> float:
        """Greatest force without play [N]."""
        return float(np.max(np.linalg.norm(self.force, axis=1)))

    @property
    def peak(self) -> float:
        """Greatest force, of an impact or without play [N]."""
        peaks = [item.peak for item in self.reversals if item.strikes]
        return max([self.rigid_peak, *peaks])

    @property
    def impact_power(self) -> float:
        """Kinetic energy of all reversals that strike, per time [W]."""
        return self.periods * sum(item.energy for item in self.reversals if item.strikes)

    @property
    def summary(self) -> str:
        """What there is to say, in one line."""
        if not self.reversals:
            return f"no reversal, {self.rigid_peak:.4g} N at most"
        count = len(self.reversals)
        text = f"{count} reversal{'s' if count > 1 else ''}, {self.peak:.4g} N"
        text += f" instead of {self.rigid_peak:.4g} N, {self.impact_power:.3g} W"
        worst = max(self.reversals, key=lambda item: -1.0 if math.isnan(item.peak) else item.peak)
        return f"{text}; {worst.doubts[0]}" if worst.doubts else text
