"""Joint scan: what clearance would do in one joint, and how far the estimate can be trusted."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from analytic.peak_exponents import PeakExponents

from ..arrays import Array
from .impact_model import ImpactModel
from .pin_geometry import PinGeometry

if TYPE_CHECKING:
    from .pin_motion import Passages, PinMotion

_REVERSAL = 0.03
"""Turn-through number up to which a swing behaves as if the force vanished, within some 7 %."""
_STAYS = 0.3
"""The same from which on the sides usually do not part."""
_FLOWN = 0.4
"""Angle flown, as a fraction of that to the rigid maximum, up to which the ramp is straight enough:
1 to 5 %."""
_LEAST_TAU = 3.0
"""Below, the estimate has not been checked against simulation of whole mechanisms."""
MOST_DAMPED = 0.99
"""Damping ratio up to which the two-mass model goes; a damper that is stronger counts as this."""
_APART = 0.1
"""Speed of a strike, as a fraction of that of the two-mass model, below which a pin only brushes
its wall: a hundredth of the energy."""
_MODEL, _PER_OFFSET = 0.03, 20.0
"""By which forces of whole mechanisms lie around those of the pin in its plane, as a fraction, and
how much more per offset of the pin as a fraction of the mechanism's length: found by 483 reversals
of random linkages, three of which lay outside."""
_NEAR = 0.1
"""Difference of the two-mass model and the pin in its plane that is remarked."""
_LOOSE = 0.1
"""Uncertainty of the plane, as a fraction, that is remarked."""
_LIVELY = 0.03
"""Damping ratio below which small differences grow from impact to impact."""
_MASS_CHANGE = 0.1
_DEVIATION = math.radians(20.0)
_LESS = -0.1
"""Change of a parameter of which summaries tell what it would buy."""
_NOT_MODEL = {"direction", "model", "motion"}


@dataclass(frozen=True, eq=False)
class Reversal:
    """What happens where the force of a joint swings round.

    Attributes:
        position: of the drive where the force is least [rad].
        force_slope: F₀/t₀, how fast the force grows [N/s].
        direction: `(3,)` unit vector in which it grows, in the world.
        reduced_mass: m that it moves, free to move across it [kg].
        guided_mass: the same if the sides are held from moving across [kg].
        stiffness: c of the contact, at the peak if it depends on the force [N/m].
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
        slope_growth: by which power of the drive's speed the slope grows, 3 where inertia alone
            acts; NaN where elements act.
        model: the numbers of the two-mass model.
        way: that the drive turns until the next reversal [rad].
        rigid_ahead: greatest force without play until then [N].
        motion: of the pin in the plane of its bush, followed when it is first asked for; None where
            the drive gives way, and of pin bearings.

    Where there is such a motion, `greatest`, `least`, `expected`, `strike_speed` and `gap` tell of
    it, and it decides whether the sides strike and how hard.
    """

    position: float
    force_slope: float
    direction: Array
    reduced_mass: float
    guided_mass: float
    stiffness: float
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
    slope_growth: float
    model: ImpactModel
    way: float = math.nan
    rigid_ahead: float = math.nan
    motion: PinMotion | None = field(default=None, repr=False)

    @cached_property
    def passages(self) -> Passages | None:
        """What the pin did in the plane of its bush, in every turn; None if that is not known."""
        motion = self.motion
        if motion is None or not motion.is_followed:
            return None
        found = motion.passages(self.position, self.way, self.contact_time)
        return found if len(found.greatest) > 1 else None

    @property
    def expected(self) -> float:
        """Greatest force until the next reversal, mean of all turns [N]; NaN if not known."""
        return math.nan if self.passages is None else float(np.mean(self.passages.greatest))

    @property
    def least(self) -> float:
        """Lower end of the interval in which that force lies, turn by turn [N]; NaN if not known.

        What the pin does in its plane in some turns, without friction, with what whole mechanisms
        differ from it.
        """
        if self.passages is None:
            return math.nan
        return float(np.min(self.passages.greatest)) / (1.0 + self._margin)

    @property
    def greatest(self) -> float:
        """Upper end of this interval [N]."""
        if self.passages is None:
            return math.nan
        return (1.0 + self._margin) * float(np.max(self.passages.greatest))

    @property
    def _margin(self) -> float:
        """By which the force of a whole mechanism may lie beside that of the pin in its plane."""
        if self.motion is None:
            return math.nan
        contact = self.motion.contact
        offset = 0.5 * contact.clearance + self.expected / contact.stiffness
        return _MODEL + _PER_OFFSET * offset / self.motion.length

    @property
    def strike_speed(self) -> float:
        """Speed of the hardest strike, normal to the wall, median of all turns [m/s].

        That of the two-mass model where the motion in the plane is not known.
        """
        if self.passages is None:
            return self.impact_speed
        return float(np.median(self.passages.speed))

    @property
    def gap(self) -> float:
        """Greatest distance from the wall, as a fraction of half the play, median of all turns."""
        return math.nan if self.passages is None else float(np.median(self.passages.gap))

    @property
    def energy(self) -> float:
        """Kinetic energy of the impact, m v² / 2 [J]."""
        return 0.5 * self.reduced_mass * self.strike_speed**2

    @property
    def damping(self) -> float:
        """Damper of the contact, d [N s/m]."""
        if self.motion is not None:
            # One that is stronger than the two-mass model goes is whole here.
            contact = self.motion.contact
            return contact.damping * math.sqrt(self.stiffness / contact.stiffness)
        critical = 2.0 * math.sqrt(self.stiffness * self.reduced_mass)
        return self.model.damping_ratio * critical

    @property
    def strikes(self) -> bool:
        """Whether the sides part and strike, not only brush.

        In the plane, if that motion is known; else where the force comes near zero and the two-mass
        model has a peak, at which the force rises and falls.
        """
        if self.passages is None:
            return self.turn_through < _STAYS and not math.isnan(self.peak)
        return self.strike_speed >= _APART * self.impact_speed

    @property
    def is_partial(self) -> bool:
        """Whether the force turns through rather than vanishes."""
        return self.turn_through > _REVERSAL

    @property
    def severity(self) -> float:
        """Greatest force of the impact [N], 0 if nothing strikes.

        In the plane, until a swing of the contact after it; if that is not known, the peak.
        """
        if not self.strikes:
            return 0.0
        return self.peak if self.passages is None else float(np.mean(self.passages.struck))

    @property
    def estimate(self) -> float:
        """The greater of the peak and of the force without play until the next reversal [N]."""
        peak = self.peak if self.turn_through < _STAYS and not math.isnan(self.peak) else 0.0
        return max(peak, 0.0 if math.isnan(self.rigid_ahead) else self.rigid_ahead)

    @cached_property
    def exponents(self) -> PeakExponents:
        """By which powers of its parameters the peak grows, d ln peak / d ln parameter.

        Of speed, slope, play, mass and stiffness; each with the others as they are, but for the
        slope, which follows the speed. The mass stays, though the reversal moves with the speed
        where more than inertia acts. NaN where there is no peak.
        """
        found = self.model.exponents
        return found._replace(speed=self.slope_growth * found.slope)

    def effects(self, change: float = _LESS) -> dict[str, float]:
        """Return what a change of each parameter would buy: the change of the peak, as a fraction.

        Args:
            change: of the parameter, as a fraction above -1; by the exponents, and so exact for
                small ones.
        """
        grown = math.log1p(change)
        return {name: math.expm1(grown * e) for name, e in self.exponents._asdict().items()}

    @property
    def verdict(self) -> str:
        """In plain words, whether the theory applies."""
        number = f"ρ = {self.turn_through:.2f}"
        if self.passages is not None and not self.strikes:
            far = f", and presses by up to {self.greatest:.4g} N" if self._is_above else ""
            through = f": the force turns through ({number})" if self.is_partial else ""
            return f"no impact: the pin stays on its wall as it slides round{far}{through}"
        if self.passages is not None and self.is_partial:
            return f"partial impact; {self.doubts[0]}"
        if self.turn_through >= _STAYS:
            return f"the force turns through ({number}): usually no impact, no estimate"
        if math.isnan(self.peak) and self.passages is None:
            return f"no peak: the force only follows the ramp (τ = {self.tau:.2f})"
        if self.flown > 1.0:
            number = f"{self.flown:.2f} of it"
            return f"impact far below the estimate: the flight outlasts the force's rise ({number})"
        return f"impact; {self.doubts[0]}" if self.doubts else "impact"

    @property
    def doubts(self) -> tuple[str, ...]:
        """Why the estimate may be wrong; empty if its assumptions hold."""
        doubts = []
        if self.passages is not None:
            interval = f"{self.least:.4g} to {self.greatest:.4g} N in the plane"
            if self._is_above:
                doubts.append(
                    f"the pin grazes and slides: {interval}, beside {self.estimate:.4g} N"
                )
            elif self.estimate > (1.0 + _NEAR) * self.least:
                doubts.append(f"less than this: {interval}, beside {self.estimate:.4g} N")
        elif self.motion is not None:
            doubts.append(
                "so stiff a contact swings too often in a turn for its pin to be followed in the "
                "plane: verify"
            )
        elif not math.isnan(self.way):
            doubts.append("the drive gives way, and the pin is not followed in its plane: verify")
        if self.motion is not None and self._margin > _LOOSE:
            doubts.append("clearance and deflection are no longer small beside the mechanism")
        if self.model.damping_ratio >= MOST_DAMPED:
            doubts.append("the contact is damped more than critically")
        elif self.motion is not None and self.model.damping_ratio < _LIVELY:
            doubts.append("hardly damped: no two impacts are alike")
        if self.turn_through > _REVERSAL:
            what = "less than this" if self.turn_through < _STAYS else "usually no impact"
            doubts.append(f"the force turns through (ρ = {self.turn_through:.2f}): {what}")
        if math.isnan(self.peak):
            doubts.append("no peak: the force only follows the ramp (undamped, τ below 1.8386)")
        elif self.tau < _LEAST_TAU:
            doubts.append(f"τ = {self.tau:.2f} is small")
        if self.flown > 1.0:
            doubts.append(
                f"the flight outlasts the force's rise ({self.flown:.2f} of it): far too high"
            )
        elif self.flown > _FLOWN:
            doubts.append(f"the ramp bends over the flight ({self.flown:.2f} of the way): too high")
        if abs(self.mass_change) > _MASS_CHANGE:
            doubts.append(f"the reduced mass changes by {100 * self.mass_change:.0f} %")
        if self.deviation > _DEVIATION:
            doubts.append(
                f"the sides part {math.degrees(self.deviation):.0f}° beside the force's direction"
            )
        law = self.model.stiffness
        if isinstance(law, PinGeometry) and not math.isnan(self.peak):
            doubts.extend(law.doubts(self.peak, self.model.clearance))
        return tuple(doubts)

    @property
    def _is_above(self) -> bool:
        """Whether the force in the plane is greater than the estimate by more than a little."""
        return self.greatest > (1.0 + _NEAR) * self.estimate

    def row(self) -> dict[str, Any]:
        """Return its numbers by name, exponents, verdict, and the doubts as text.

        `severity` is that of a reversal, `partial_severity` that of a force that turns through.
        """
        partial = self.severity if self.is_partial else 0.0
        values = {name: value for name, value in vars(self).items() if name in _NUMBERS}
        directions = {f"direction_{axis}": float(self.direction[k]) for k, axis in enumerate("xyz")}
        exponents = {f"exponent_{name}": e for name, e in self.exponents._asdict().items()}
        return {
            **values,
            **directions,
            "expected": self.expected,
            "least": self.least,
            "greatest": self.greatest,
            "severity": self.severity - partial,
            "partial_severity": partial,
            "strike_speed": self.strike_speed,
            "gap": self.gap,
            "energy": self.energy,
            **exponents,
            "verdict": self.verdict,
            "doubts": "; ".join(self.doubts),
        }


_NUMBERS = [name for name in Reversal.__dataclass_fields__ if name not in _NOT_MODEL]
"""Fields that are numbers: what is cached beside them is none of a table's columns."""


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

    @cached_property
    def rigid_peak(self) -> float:
        """Greatest force without play [N]."""
        return float(np.max(np.linalg.norm(self.force, axis=-1)))

    @property
    def peak(self) -> float:
        """Greatest force, of an impact or without play [N]."""
        return max(self.rigid_peak, self.severity, self.partial_severity)

    @property
    def severity(self) -> float:
        """Greatest force of the impacts where the force vanishes [N]; 0 if nothing strikes."""
        return max((item.severity for item in self.reversals if not item.is_partial), default=0.0)

    @property
    def partial_severity(self) -> float:
        """Greatest force of the impacts where the force turns through [N]; 0 if nothing strikes."""
        return max((item.severity for item in self.reversals if item.is_partial), default=0.0)

    @property
    def worst(self) -> Reversal | None:
        """The most severe reversal of those that strike; None if none does."""
        striking = [item for item in self.reversals if item.strikes]
        return max(striking, key=lambda item: item.severity, default=None)

    @property
    def impacts(self) -> int:
        """Impacts in a period: reversals that strike."""
        return sum(item.strikes for item in self.reversals)

    @property
    def impacts_per_turn(self) -> float:
        """Impacts in a turn of the drive; a period may have several turns."""
        period = len(self.position) * float(self.position[1] - self.position[0])
        return 2.0 * math.pi * self.impacts / period

    @property
    def impact_power(self) -> float:
        """Kinetic energy of all reversals that strike, per time [W]."""
        return self.periods * sum(item.energy for item in self.reversals if item.strikes)

    @property
    def verdict(self) -> str:
        """In plain words, whether the theory applies, and what speaks against it."""
        if self.rigid_peak == 0.0:
            return "no force, and so no impact"
        if not self.reversals:
            if not self.turning:
                return "no reversal: the force never swings round; the theory does not apply"
            times = f"{self.turning} time{'s' if self.turning > 1 else ''}"
            return f"no reversal: the force turns through {times}, far from zero; no estimate"
        least = min(self.reversals, key=lambda item: (not item.strikes, item.turn_through))
        return (self.worst or least).verdict

    @property
    def summary(self) -> str:
        """What there is to say, in one line."""
        if self.worst is None:
            return f"{self.rigid_peak:.4g} N at most; {self.verdict}"
        count = len(self.reversals)
        text = f"{count} reversal{'s' if count > 1 else ''}, {self.peak:.4g} N"
        text += f" instead of {self.rigid_peak:.4g} N, {self.impact_power:.3g} W"
        if self.worst.passages is not None:
            text += f"; {self.worst.least:.4g} to {self.worst.greatest:.4g} N in the plane"
        bought = [
            f"{name} {100.0 * effect:+.1f} %"
            for name, effect in self.worst.effects().items()
            if not math.isnan(effect)
        ]
        text += f"; 10 % less of: {', '.join(bought)}"
        return f"{text}; {self.worst.doubts[0]}" if self.worst.doubts else text
