"""Phases of two masses across a play in closed form: flight under a ramp, contact of a linear law.

A phase is told from one side: its depth δ is positive where the masses press into each other there
and minus the way from there elsewhere, m δ'' = f₀ + f₁ τ - F with the contact's force F, positive
inwards. Within a phase τ counts from its start.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain, pairwise
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..elements.contact_laws import LinearContact
from .damped_swing import DampedSwing

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
"""Of the quadrature of powers, exact to rounding over a radian of a swing."""
_BLOCK = 4096
"""Panels of a quadrature that are computed at once."""

Scalar = Callable[[float], float]


class Begun(NamedTuple):
    """How a phase begins.

    Attributes:
        time: [s].
        side: +1 or -1, from which it is told: at the greatest gap, or at the gap 0.
        depth: δ [m].
        rate: δ' [m/s].
        touch_speed: at which the touch began there [m/s]; 0 without one.
    """

    time: float
    side: int
    depth: float
    rate: float
    touch_speed: float = 0.0


class Phase:
    """A phase of the motion.

    Attributes:
        begun: how it begins.
        end: when it ends [s].
        is_contact: whether the sides press on each other, so that the law's force acts.
        is_resumed: whether it is a contact whose force came back before the depth was zero.
        outcome: how it ended, empty where time was up.
        work: that the external force does in it [J].
        loss: that the contact turns into heat in it [J].
        peak: first greatest force of a contact, -inf without one [N].
        peak_time: when it acts [s].
    """

    begun: Begun
    end: float
    is_contact: bool
    is_resumed: bool = False
    outcome: str = ""
    work: float = 0.0
    loss: float = 0.0
    peak: float = -math.inf
    peak_time: float = math.nan

    def states(self, times: Array) -> tuple[Array, Array]:
        """Return depths [m] and rates [m/s] at times within it [s]."""
        raise NotImplementedError

    @property
    def last(self) -> tuple[float, float]:
        """Depth and rate at its end."""
        depth, rate = self.states(np.array([self.end]))
        return float(depth[0]), float(rate[0])


@dataclass(frozen=True)
class Push:
    """The external force over a phase, inwards: f₀ + f₁ τ."""

    value: float
    slope: float


class Flight(Phase):
    """Flight: no force of contact, δ is a cubic polynomial of time."""

    is_contact = False

    def __init__(self, begun: Begun, mass: float, push: Push) -> None:
        """Begin a flight of a mass [kg]; `fly` says where it ends."""
        self.begun, self.end = begun, begun.time
        self._push, self._mass = push, mass
        self._curve = np.array(
            [push.slope / (6.0 * mass), push.value / (2.0 * mass), begun.rate, begun.depth]
        )
        self._slope = self._curve[:3] * np.array([3.0, 2.0, 1.0])

    def states(self, times: Array) -> tuple[Array, Array]:
        """Return depths [m] and rates [m/s] at times within it [s]."""
        tau = times - self.begun.time
        return np.polyval(self._curve, tau), np.polyval(self._slope, tau)

    def fly(self, play: float, until: float) -> str:
        """Let it end; return how: "crossed", "returned" to its side, or "" if time is up.

        Args:
            play: [m].
            until: end of time [s].
        """
        below = self._curve + np.array([0.0, 0.0, 0.0, play])
        return self._fly([(-self._curve, "returned"), (below, "crossed")], until)

    def rise(self, law: LinearContact, until: float) -> str:
        """Let it end where it lifted off a contact that is slow to come back.

        Returns:
            "cleared" when the depth is zero, "resumed" if the contact's force is back before, or ""
            if time is up.
        """
        pull = -law.stiffness * self._curve - law.damping * np.array([0.0, *self._slope])
        how = self._fly([(self._curve, "cleared"), (pull, "resumed")], until)
        first, last = self.states(np.array([self.begun.time, self.end]))[0]
        stored = law.energy([first, last])
        self.loss = float(stored[0] - stored[1])
        return how

    def _fly(self, watched: list[tuple[Array, str]], until: float) -> str:
        length = until - self.begun.time
        tau, how = min((_first_fall(poly, length), how) for poly, how in watched)
        how = "" if tau > length else how
        tau = min(tau, length)
        self.end = self.begun.time + tau if how else until
        nodes = 0.5 * tau * (1.0 + _NODES)
        force = self._push.value + self._push.slope * nodes
        self.work = 0.5 * tau * float(_WEIGHTS @ (force * np.polyval(self._slope, nodes)))
        return how


class LinearTouch(Phase):
    """Contact of a linear law under a ramp: a damped swing about a line."""

    is_contact = True

    def __init__(self, begun: Begun, law: LinearContact, mass: float, push: Push) -> None:
        """Begin a contact of a mass [kg]; `press` says where it ends."""
        self.begun, self.end = begun, begun.time
        self._law, self._mass, self._push = law, mass, push
        c, d = law.stiffness, law.damping
        self._creep = push.slope / c
        self._middle = (push.value - d * self._creep) / c
        self._swing = DampedSwing(
            0.5 * d / mass,
            math.sqrt(c / mass),
            begun.depth - self._middle,
            begun.rate - self._creep,
        )

    def states(self, times: Array) -> tuple[Array, Array]:
        """Return depths [m] and rates [m/s] at times within it [s]."""
        return self._states(times - self.begun.time)

    def _states(self, tau: Any) -> tuple[Any, Any]:
        depth = self._middle + self._creep * tau + self._swing.at(0, tau)
        return depth, self._creep + self._swing.at(1, tau)

    def press(self, until: float) -> str:
        """Let it end; return how: "parted", or "" if time is up."""
        length = until - self.begun.time
        tau = self._parting(length)
        how = "" if tau > length else "parted"
        tau = min(tau, length)
        self.end = self.begun.time + tau if how else until
        self._find_peak(tau)
        bounds = self._swing.panels(tau)
        for first in range(0, len(bounds) - 1, _BLOCK):
            self._account(bounds[first : first + _BLOCK + 1])
        return how

    def _account(self, bounds: Array) -> None:
        """Add the work and the loss between bounds of panels."""
        half = 0.5 * np.diff(bounds)[:, None]
        nodes = bounds[:-1, None] + half * (1.0 + _NODES)
        rate = self._states(nodes)[1]
        force = self._push.value + self._push.slope * nodes
        self.work += float(np.sum(half * _WEIGHTS * force * rate))
        self.loss += self._law.damping * float(np.sum(half * _WEIGHTS * rate * rate))

    def _force(self, tau: float) -> float:
        # At the start without the rounding of the swing, which would part what begins to press.
        state = self._states(tau) if tau > 0.0 else (self.begun.depth, self.begun.rate)
        return float(self._law.force(*state))

    def _force_rate(self, tau: float) -> float:
        if tau == 0.0:
            bend = (self._push.value - self._force(0.0)) / self._mass
            return self._law.stiffness * self.begun.rate + self._law.damping * bend
        return self._push.slope - self._mass * float(self._swing.at(3, tau))

    def _extremes(self, length: float) -> Iterator[tuple[float, bool]]:
        """Yield the times at which the force has a greatest (True) or a least value."""
        # Between zeros of the force's second derivative, the first has one zero at most.
        low = 0.0
        for high in _up_to(self._swing.zeros(4), length):
            before, after = self._force_rate(low), self._force_rate(high)
            if before * after < 0.0:
                yield _root(self._force_rate, low, high), before > 0.0
            if abs(self._push.slope) > self._mass * self._swing.bound(3, high):
                return
            low = high

    def _parting(self, length: float) -> float:
        """Return when the force falls to zero, inf if it does not."""
        push, low = self._push, 0.0
        for high, _ in chain(self._extremes(length), [(length, False)]):
            if self._force(high) <= 0.0:
                return _root(self._force, low, high) if self._force(low) > 0.0 else low
            line = push.value + push.slope * high
            if push.slope >= 0.0 and line > self._mass * self._swing.bound(2, high):
                break
            low = high
        return math.inf

    def _find_peak(self, length: float) -> None:
        """Find the first greatest force; one that a damper has at the touch counts as well."""
        found = []
        first = next(_up_to(self._swing.zeros(4), length))
        begun, later = self._force_rate(0.0), self._force_rate(first)
        if begun < 0.0 or (begun == 0.0 and later < 0.0):
            found.append((self._force(0.0), 0.0))
        for tau, is_greatest in self._extremes(length):
            if is_greatest:
                found.append((self._force(tau), tau))
                break
        if found:
            self.peak, tau = max(found)
            self.peak_time = self.begun.time + tau


def _up_to(times: Iterator[float], length: float) -> Iterator[float]:
    """Yield ascending times below a length, then the length."""
    for time in times:
        if time >= length:
            break
        yield time
    yield length


def _first_fall(poly: Array, length: float) -> float:
    """Return when a cubic falls to zero, inf if not within a length.

    One that starts at zero and does not rise has fallen at once.
    """

    def value(tau: float) -> float:
        return float(np.polyval(poly, tau))

    turns = _quadratic_roots(3.0 * poly[0], 2.0 * poly[1], poly[2])
    for low, high in pairwise([0.0, *(t for t in turns if 0.0 < t < length), length]):
        if value(high) <= 0.0 and high > 0.0:
            return _root(value, low, high) if value(low) > 0.0 else low
    return math.inf


def _quadratic_roots(a: float, b: float, c: float) -> list[float]:
    """Return the real zeros of a x² + b x + c in ascending order."""
    square = b * b - 4.0 * a * c
    if square < 0.0:
        return []
    q = -0.5 * (b + math.copysign(math.sqrt(square), b))
    return sorted([part / whole for part, whole in ((q, a), (c, q)) if whole != 0.0])


def _root(function: Scalar, low: float, high: float) -> float:
    from scipy.optimize import brentq  # Only simulations need it.

    return float(brentq(function, low, high, xtol=1e-300, rtol=4.0 * np.finfo(float).eps))
