"""Phases of two masses across a play by integration: any law of contact, any force over time.

They are told as in `two_mass_phases`; work and loss are integrated along with the motion.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..elements.contact_laws import ContactLaw
from ..elements.located import Passage, Rate, Step, Watch, advance, on_step
from .two_mass_phases import Begun, Phase

_RTOL = 1e-13
"""Relative tolerance of a step, near rounding: impacts multiply errors."""
_ATOL = 1e-15
"""Absolute tolerances as a fraction of the units."""
_PLACES = 9
"""Places in a step at which the force is looked at for its greatest value."""
_ZERO = 1e-12
"""Depth at an end, as a fraction of the greatest, that is one of rounding."""
_SHARP = 1e-8
"""Part of the time between two of them to which the greatest is located: its value, to rounding."""


class Units(NamedTuple):
    """Sizes of a motion, for absolute tolerances.

    Attributes:
        length: [m].
        speed: [m/s].
        energy: [J].
        longest: step that resolves the force over time [s].
    """

    length: float
    speed: float
    energy: float
    longest: float = np.inf


class IntegratedPhase(Phase):
    """A phase by integration."""

    def __init__(
        self,
        begun: Begun,
        is_contact: bool,
        law: ContactLaw,
        mass: float,
        force: Callable[[float], float],
        units: Units,
    ) -> None:
        """Begin a phase; `run` says where it ends.

        Args:
            begun: how it begins.
            is_contact: whether the law's force acts.
            law: of the contact.
            mass: reduced mass [kg].
            force: external, of time, towards the greatest gap [N].
            units: sizes of the motion.
        """
        self.begun, self.end, self.is_contact = begun, begun.time, is_contact
        self._law, self._mass, self._units = law, mass, units
        self._steps: list[Step] = []
        self._rate = self._flying(force)
        if is_contact:
            self._rate = self._touching(force)

    def __getstate__(self) -> dict[str, object]:
        # What was integrated can be copied; the equations hold functions.
        return {name: value for name, value in self.__dict__.items() if name != "_rate"}

    def states(self, times: Array) -> tuple[Array, Array]:
        """Return depths [m] and rates [m/s] at times within it [s]."""
        if not self._steps:
            ones = np.ones(len(times))
            return self.begun.depth * ones, self.begun.rate * ones
        ends = np.array([step.end for step in self._steps])
        index = np.minimum(np.searchsorted(ends, times), len(ends) - 1).tolist()
        rows = [self._steps[k].dense(time) for k, time in zip(index, times.tolist(), strict=True)]
        depth, rate = np.array(rows).reshape(-1, 4).T[:2]
        return depth, rate

    @property
    def last(self) -> tuple[float, float]:
        """Depth and rate at its end."""
        return self._last

    def run(self, play: float, until: float) -> str:
        """Let it end; return how, see `Flight` and `LinearTouch`."""
        watches: list[tuple[Watch, str]]
        if self.is_contact:
            watches = [(_depth, "parted"), (self._pressure, "parted")]
        elif self.begun.depth > 0.0:
            watches = [(_depth, "cleared"), (self._lift, "resumed")]
        else:
            watches = [
                (lambda _, y: -float(y[0]), "returned"),
                (lambda _, y: float(y[0]) + play, "crossed"),
            ]
        begun, units = self.begun, self._units
        atol = _ATOL * np.array([units.length, units.speed, units.energy, units.energy])
        found = advance(
            self._rate,
            begun.time,
            np.array([begun.depth, begun.rate, 0.0, 0.0]),
            until,
            [watch for watch, _ in watches],
            rtol=_RTOL,
            atol=atol,
            longest=units.longest,
        )
        return self._take(found, "" if found.event is None else watches[found.event][1])

    def _take(self, found: Passage, how: str) -> str:
        self.end, self._steps = found.time, found.steps
        depth, rate, self.work, self.loss = found.state.tolist()
        # Where both ends of a contact or of a lift coincide, rounding decides which is found.
        greatest = max((abs(float(step.state[0])) for step in found.steps), default=0.0)
        if how in ("parted", "resumed") and abs(depth) <= _ZERO * greatest:
            depth, how = 0.0, "parted" if how == "parted" else "cleared"
        elif how in ("cleared", "returned"):
            depth = 0.0
        self._last = depth, rate
        if self.is_contact:
            self._find_peak()
        return how

    def _pressure(self, _: float, y: Array) -> float:
        return float(self._law.force(y[0], y[1], self.begun.touch_speed))

    def _lift(self, time: float, y: Array) -> float:
        # Not positive at all beyond the depth 0, lest a contact that is back for less than a part
        # of a step be missed.
        return -self._pressure(time, y) if y[0] > 0.0 else -1.0

    def _touching(self, force: Callable[[float], float]) -> Rate:
        law, mass, side, speed = self._law, self._mass, self.begun.side, self.begun.touch_speed

        def rate(time: float, y: Array) -> Array:
            push = side * force(time)
            pressure = float(law.force(y[0], y[1], speed))
            spring = float(law.force(y[0], 0.0, speed))
            rate = y[1]
            return np.array(
                [rate, (push - pressure) / mass, push * rate, (pressure - spring) * rate]
            )

        return rate

    def _flying(self, force: Callable[[float], float]) -> Rate:
        law, mass, side = self._law, self._mass, self.begun.side
        lifted = self.begun.depth > 0.0

        def rate(time: float, y: Array) -> Array:
            push = side * force(time)
            spring = float(law.force(y[0], 0.0, 0.0)) if lifted else 0.0
            return np.array([y[1], push / mass, push * y[1], -spring * y[1]])

        return rate

    def _find_peak(self) -> None:
        """Find the first greatest force; one that a damper has at the touch counts as well."""
        from scipy.optimize import minimize_scalar

        if not self._steps:
            return
        places = [np.linspace(step.start, step.end, _PLACES)[1:] for step in self._steps]
        times = np.concatenate([[self.begun.time], *places])
        force = self._law.force(*self.states(times), self.begun.touch_speed)
        found = [(float(force[0]), float(times[0]))] if force[0] > force[1] else []
        tops = 1 + np.nonzero((force[1:-1] > force[:-2]) & (force[1:-1] >= force[2:]))[0]
        if tops.size:
            low, high = times[tops[0] - 1], times[tops[0] + 1]
            top = minimize_scalar(
                lambda time: -self._force_at(time),
                bounds=(low, high),
                method="bounded",
                options={"xatol": _SHARP * (high - low)},
            )
            found.append((self._force_at(float(top.x)), float(top.x)))
        if found:
            self.peak, self.peak_time = max(found)

    def _force_at(self, time: float) -> float:
        """Return the force at a time, without the interpolant's error."""
        step = next(step for step in self._steps if time <= step.end)
        return self._pressure(time, on_step(self._rate, step, time))


def _depth(_: float, y: Array) -> float:
    return float(y[0])
