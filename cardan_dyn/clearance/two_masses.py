"""Two masses across a play, simulated: the model behind Dresig and Thümmel's estimate.

The masses m₁₁ and m₂₂ are pulled apart by the force F(t) of the rigid mechanism, cross the play 2 s
and strike the other side: m q'' = F(t) - F₁₂, with the gap q and the contact's force F₁₂. Flights
under a ramp, and contacts of a linear law under it, are in closed form; all else is integrated.
Phases end where a contact begins or ends, located to rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ..checks import described, number, numbers, positive, whole
from ..elements.contact_laws import ContactLaw, LinearContact
from ..errors import ArgumentError
from .two_mass_integration import IntegratedPhase, Units
from .two_mass_motion import TwoMassMotion, impacts_of
from .two_mass_phases import Begun, Flight, LinearTouch, Phase, Push

Start = Literal["release", "rest"] | tuple[float, float]

_LEAD = 100.0
"""Natural times before the reversal from which a contact that is not linear unloads: its steady
unloading, of which two terms are known, is then met to 1e-9."""
_STEP = 1e-4
"""Relative step of a central difference, whose error is its square."""
_LEAST_STEPS = 1000
"""Steps over the motion under a force that is a function of time, lest one be stepped over."""
_MOST_PHASES = 8
"""Phases for each impact that is allowed, beyond which contacts begin and end without moving."""


def two_masses(
    law: ContactLaw,
    *,
    play: float,
    mass: float | tuple[float, float],
    end: float,
    ramp: float | None = None,
    force: Callable[[float], float] | None = None,
    start: Start = "release",
    begin: float = 0.0,
    most_impacts: int = 1000,
) -> TwoMassMotion:
    """Simulate two masses across a play, from impact to impact.

    Args:
        law: of the contact on both sides.
        play: 2 s [m].
        mass: reduced mass m, or m₁₁ and m₂₂ [kg].
        end: time at which it ends [s].
        ramp: F₀/t₀ [N/s] of the force F = (F₀/t₀) t, towards a greater gap.
        force: F [N] as a function of time [s], instead of a ramp. What it does within less than a
            thousandth of the motion may be missed.
        start: "release", from the side at the gap 0 as its contact unloads: under a ramp steadily,
            else at rest at the time `begin`, in equilibrium with a force that is negative then.
            "rest", at the gap 0 at rest, without contact: at the time 0 of a ramp, the paper's
            start. Or the gap [m], from 0 to the play, and its rate [m/s] at the time `begin`.
        begin: time at which it begins [s]; under a ramp only where gap and rate are given. Without
            damping a contact that is not linear is followed from before the reversal on.
        most_impacts: that are simulated; when one more begins, the motion ends with what it has.

    Raises:
        ArgumentError: a value is out of range, or does not go with another.
        SimulationError: a contact is too stiff to be integrated.

    Source:
        Dresig and Thümmel (2) to (4), (8), with the start (13) for "rest".
    """
    if not isinstance(law, ContactLaw):
        raise ArgumentError(
            f"law is {described(law)}, expected a contact law such as LinearContact(stiffness)"
        )
    masses = _masses(mass)
    reduced = masses[0] if len(masses) == 1 else masses[0] * (masses[1] / sum(masses))
    model = _Model(law, positive("play", play), reduced, _external(ramp, force))
    begun, is_contact = _Start(model, start, number("begin", begin)).found()
    end = number("end", end)
    if not end > begun.time:
        raise ArgumentError(f"end is {end:g} s; it comes after the begin, {begun.time:g} s")
    phases, ended = model.run(begun, is_contact, end, whole("most_impacts", most_impacts))
    both = (masses[0], masses[1]) if len(masses) == 2 else None
    return TwoMassMotion(
        law, model.play, reduced, both, impacts_of(phases), ended, tuple(phases), model.external
    )


@dataclass(frozen=True)
class _Ramp:
    """The force F = slope · t."""

    slope: float

    def __call__(self, time: float) -> float:
        return self.slope * time


@dataclass(frozen=True)
class _Force:
    """A force that a user gave as a function, checked."""

    function: Callable[[float], Any]

    def __call__(self, time: float) -> float:
        try:
            value = self.function(time)
        except Exception as error:
            raise ArgumentError(
                f"force at {time:g} s fails: {type(error).__name__}: {error}"
            ) from error
        array = numbers(f"force at {time:g} s", value)
        if array.size != 1:
            raise ArgumentError(f"force at {time:g} s has shape {array.shape}, expected a number")
        return float(array.reshape(()))


class _Model:
    """Two masses, their contact and what moves them."""

    def __init__(self, law: ContactLaw, play: float, mass: float, external: _Ramp | _Force) -> None:
        self.law, self.play, self.mass, self.external = law, play, mass, external

    def run(self, begun: Begun, is_contact: bool, end: float, most: int) -> tuple[list[Phase], str]:
        """Return the phases up to an end, and why it is the end."""
        units = self._units(begun, end)
        phases: list[Phase] = []
        met, is_resumed = int(is_contact and begun.touch_speed > 0.0), False
        while True:
            phase = self._phase(begun, is_contact, end, units)
            phase.is_resumed = is_resumed
            phases.append(phase)
            how = phase.outcome
            if not how:
                return phases, "time is up"
            if len(phases) > _MOST_PHASES * (most + 1):
                return phases, f"contacts begin and end without moving at {phase.end:g} s"
            begun = self._next(phase, how)
            is_contact, is_resumed = how in ("returned", "crossed", "resumed"), how == "resumed"
            is_impact = is_contact and not is_resumed and begun.touch_speed > 0.0
            if is_impact and met == most:
                return phases, f"it met {most} impact{'s' if most > 1 else ''}"
            met += is_impact

    def _next(self, phase: Phase, how: str) -> Begun:
        """Return how the phase after one begins."""
        depth, rate = phase.last
        side = phase.begun.side
        if how == "crossed":
            return Begun(phase.end, -side, 0.0, -rate, -rate)
        if how == "returned":
            return Begun(phase.end, side, 0.0, rate, max(rate, 0.0))
        # A spring without damper parts at the depth 0, up to rounding.
        at_zero = depth < 0.0 or (isinstance(self.law, LinearContact) and not self.law.damping)
        if how == "cleared" or (how == "parted" and at_zero):
            return Begun(phase.end, side, 0.0, rate)
        return Begun(phase.end, side, depth, rate, phase.begun.touch_speed)

    def _phase(self, begun: Begun, is_contact: bool, end: float, units: Units) -> Phase:
        """Return the phase that begins in some way, run to its end."""
        law, external = self.law, self.external
        lifted = not is_contact and begun.depth > 0.0
        if isinstance(external, _Ramp):
            push = Push(begun.side * external(begun.time), begun.side * external.slope)
            if not is_contact and not lifted:
                flight = Flight(begun, self.mass, push)
                flight.outcome = flight.fly(self.play, end)
                return flight
            if isinstance(law, LinearContact) and lifted:
                flight = Flight(begun, self.mass, push)
                flight.outcome = flight.rise(law, end)
                return flight
            if isinstance(law, LinearContact):
                touch = LinearTouch(begun, law, self.mass, push)
                touch.outcome = touch.press(end)
                return touch
        phase = IntegratedPhase(begun, is_contact, law, self.mass, external, units)
        phase.outcome = phase.run(self.play, end)
        return phase

    def _units(self, begun: Begun, end: float) -> Units:
        """Return sizes of the motion: what the force does over the play, and what there is."""
        forces = [abs(self.external(time)) for time in np.linspace(begun.time, end, 9).tolist()]
        energy = max(
            0.5 * self.mass * begun.rate**2,
            float(self.law.energy(begun.depth)),
            max(forces) * self.play,
        )
        longest = np.inf if isinstance(self.external, _Ramp) else (end - begun.time) / _LEAST_STEPS
        return Units(self.play, float(np.sqrt(2.0 * energy / self.mass)), energy, longest)


class _Start:
    """How a motion begins."""

    def __init__(self, model: _Model, start: object, begin: float) -> None:
        self._model, self._start, self._begin = model, start, begin

    def found(self) -> tuple[Begun, bool]:
        """Return how the first phase begins, and whether it is a contact.

        Raises:
            ArgumentError: it does not go with the force, or is out of range.
        """
        start, external = self._start, self._model.external
        if isinstance(start, str) and start in ("release", "rest"):
            if not isinstance(external, _Ramp):
                return self._at(0.0, 0.0) if start == "rest" else self._pressed()
            if self._begin != 0.0:
                raise ArgumentError(
                    f"begin is {self._begin:g} s; a ramp's start {start!r} is at its reversal, the "
                    "time 0: give start=(gap, rate) to begin elsewhere"
                )
            if not external.slope > 0.0:
                raise ArgumentError(
                    f"ramp is {external.slope:g} N/s; with start={start!r} it is positive: give "
                    "start=(gap, rate) for others"
                )
            return self._at(0.0, 0.0) if start == "rest" else self._unloading(external.slope)
        if not isinstance(start, (tuple, list)) or len(start) != 2:
            raise ArgumentError(
                f"start is {described(start)}; it is 'release', 'rest' or a gap [m] and its rate "
                "[m/s]"
            )
        gap, rate = number("start: gap", start[0]), number("start: rate", start[1])
        if not 0.0 <= gap <= self._model.play:
            raise ArgumentError(
                f"start: gap is {gap:g} m; it lies from 0 to the play, {self._model.play:g} m"
            )
        return self._at(gap, rate)

    def _at(self, gap: float, rate: float) -> tuple[Begun, bool]:
        """Return a start within the play; at its ends, the way of the rate decides, then of F."""
        play, time = self._model.play, self._begin
        if gap == play:
            return self._on_side(1, rate, time)
        return (
            self._on_side(-1, -rate, time) if gap == 0.0 else (Begun(time, -1, -gap, -rate), False)
        )

    def _on_side(self, side: int, rate: float, time: float) -> tuple[Begun, bool]:
        # A flight without a rate whose force pushes inwards returns at once, without an impact.
        return Begun(time, side, 0.0, rate, max(rate, 0.0)), rate > 0.0

    def _pressed(self) -> tuple[Begun, bool]:
        """Return a contact at rest, in equilibrium with the force.

        Raises:
            ArgumentError: the force does not press on it.
        """
        force = self._model.external(self._begin)
        if not force < 0.0:
            raise ArgumentError(
                f"force at begin, {self._begin:g} s, is {force:g} N; start='release' needs one "
                "that presses at the gap 0 and is negative: choose begin= before its reversal, or "
                "give start='rest' or (gap, rate)"
            )
        return Begun(self._begin, -1, self._depth_of(-force, 0.0), 0.0), True

    def _unloading(self, slope: float) -> tuple[Begun, bool]:
        """Return the steady unloading of the contact under a ramp."""
        law, mass = self._model.law, self._model.mass
        if isinstance(law, LinearContact):
            # q = k t / c - k d / c² solves the equations; the force, k t, vanishes at the time 0.
            rate = slope / law.stiffness
            return Begun(0.0, -1, law.damping * rate / law.stiffness, -rate), False
        n, k = law.order, law.stiffness
        natural = (mass * slope ** (1.0 / n - 1.0) * k ** (-1.0 / n)) ** (1.0 / (3.0 - 1.0 / n))
        lead = _LEAD * natural

        def depth(before: float) -> float:
            still = (slope * before / k) ** (1.0 / n)
            bend = (1.0 / n) * (1.0 / n - 1.0) * still / before**2
            return self._depth_of(slope * before - mass * bend, -still / (n * before))

        step = _STEP * lead
        rate = (depth(lead - step) - depth(lead + step)) / (2.0 * step)
        return Begun(-lead, -1, depth(lead), rate), True

    def _depth_of(self, force: float, rate: float) -> float:
        """Return the depth at which the law has a force [N], positive, at a rate."""
        from scipy.optimize import brentq  # Only simulations need it.

        law = self._model.law
        high = (force / law.stiffness) ** (1.0 / law.order)
        while float(law.force(high, rate)) < force:
            high *= 2.0
        return float(
            brentq(lambda depth: float(law.force(depth, rate)) - force, 0.0, high, xtol=1e-300)
        )


def _external(ramp: object, force: object) -> _Ramp | _Force:
    """Return what moves the masses.

    Raises:
        ArgumentError: not exactly one is given, or it is neither a number nor a function.
    """
    if (ramp is None) == (force is None):
        raise ArgumentError("give one of ramp= [N/s] and force=, a function of time")
    if ramp is not None:
        return _Ramp(number("ramp", ramp))
    if not callable(force):
        raise ArgumentError(f"force is {described(force)}, expected a function of time; give ramp=")
    return _Force(force)


def _masses(given: object) -> tuple[float, ...]:
    """Return the reduced mass, or both masses.

    Raises:
        ArgumentError: they are no positive numbers.
    """
    array = numbers("mass", given)
    if array.shape not in ((), (2,)):
        raise ArgumentError(
            f"mass has shape {array.shape}, expected the reduced mass or m_11 and m_22"
        )
    return tuple(positive("mass", value) for value in np.atleast_1d(array).tolist())
