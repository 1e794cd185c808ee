"""Contact following: when pins strike the walls of their bushes and leave them, step by step.

Within a phase all forces are smooth, but for kinks of some laws, where steps end as well. A phase
ends where a pin reaches the wall, where the wall no
longer presses, or where it presses again before the pin is back in the clearance: that is located
on the interpolated step, and the integration starts anew from there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import pinocchio

from ...core.elements.pin_motion import PinPlace
from ...core.elements.stepping import first_fall
from ...core.mechanism.mechanism import Mechanism
from ...kit.arrays import EPS, NOTHING, Array
from ...kit.extremes import peak
from .integration import Integration
from .recorded_contact import FREE, PARTED, PRESSED, Phase, RecordedContact
from .system import System

_INNER = 8
"""Parts of a step between which contacts are looked at."""
_LEFT = np.concatenate([np.linspace(1.0, 0.0, _INNER, endpoint=False), np.logspace(-1.0, -6.0, 16)])
"""Parts of the way out of a wall, on which it may press once more, that are left where it is
looked at."""
_STRICT = 1e-2
"""Part of the tolerances that steps may use while a wall presses: pins enter it by so little that
forces and energies would miss what was asked for a hundred times over."""


class Touch(NamedTuple):
    """A time during which a wall presses a pin.

    Attributes:
        contact: index of the element among those of the scene.
        start, end: times [s]; the end is that of the simulation if it still pressed then.
        speed: at which the pin struck the wall [m/s]; NaN where the simulation began pressed.
        peak: greatest force [N].
        peak_time: when [s].
        direction: `(3,)` unit vector in which the pin pressed the wall then, in world axes.
    """

    contact: int
    start: float
    end: float
    speed: float
    peak: float
    peak_time: float
    direction: Array


class _Peak(NamedTuple):
    """Greatest force of a touch so far: [N], when [s], and in which direction `(3,)`."""

    force: float
    time: float
    direction: Array


class ContactFollowing:
    """The contacts of a simulation.

    Attributes:
        touches: those that ended.
    """

    def __init__(
        self, system: System, contacts: Sequence[tuple[int, RecordedContact]], most: int
    ) -> None:
        """Make it.

        Args:
            system: the equations of motion.
            contacts: that it moves, without phases yet, each with its index among all elements.
            most: number of touches after which the simulation ends.
        """
        self._system, self._most = system, most
        self._pins = [_Pin(index, contact, system.mechanism) for index, contact in contacts]
        self._data = system.physical.createData()
        self.touches: list[Touch] = []

    def begin(self, y: Array) -> None:
        """Begin the first phases.

        Args:
            y: first row. A wall that presses there does not know how the touch began: laws that
                depend on it act without damping.
        """
        for pin, place in zip(self._pins, self._places(y), strict=True):
            is_pressed = place.depth > 0.0 and pin.pressure(place, np.inf) > 0.0
            pin.begin(0.0, is_pressed)
            if place.depth > NOTHING * pin.clearance and not is_pressed:
                pin.part(0.0)

    @property
    def strictness(self) -> float:
        """Part of the tolerances that steps may use: less where a wall presses."""
        return _STRICT if any(pin.is_pressed for pin in self._pins) else 1.0

    def follow(self, integration: Integration) -> str:
        """Look at the last step, and end it where a phase ends.

        Args:
            integration: that took it.

        Returns:
            Why the simulation is to end; empty if it is not.
        """
        step = integration.steps[-1]
        known: dict[float, list[PinPlace]] = {}

        def places(time: float) -> list[PinPlace]:
            if time not in known:
                known[time] = self._places(step.dense(time))
            return known[time]

        def of(index: int) -> Callable[[float], PinPlace]:
            return lambda time: places(time)[index]

        times = np.linspace(step.start, step.end, _INNER + 1).tolist()
        ends = [pin.end(times, of(index)) for index, pin in enumerate(self._pins)]
        # Rounding has begun a phase on the wrong side: it ends as soon as places differ.
        soon = step.start + np.sqrt(EPS) * (times[1] - times[0])
        ends = [soon if end <= step.start else end for end in ends]
        first = min(ends)
        end = min(first, step.end)
        seen = [*(time for time in times if time < end), end]
        for index, pin in enumerate(self._pins):
            pin.note_peak(seen, of(index))
        if first == np.inf:
            return ""
        point = integration.on(step, end)
        for pin, when, at in zip(self._pins, ends, self._places(point.y), strict=True):
            if when == first:
                self.touches += pin.switch(end, at)
        integration.strictness = self.strictness
        integration.restart(point)
        return f"{self._most} touches of pins" if len(self.touches) >= self._most else ""

    def closed(self, time: float) -> tuple[Touch, ...]:
        """Return all touches of a simulation, those as well that last at its end."""
        return *self.touches, *(touch for pin in self._pins for touch in pin.touch(time))

    def _places(self, y: Array) -> list[PinPlace]:
        """Return where all pins are at a row."""
        system = self._system
        state = system.placed(system.unit(y[: system.size]), y[system.size :])
        pinocchio.forwardKinematics(system.physical, self._data, *state)
        return [pin.motion.place(self._data) for pin in self._pins]


class _Pin:
    """One contact as it is followed.

    Attributes:
        motion: of the pin.
    """

    def __init__(self, index: int, contact: RecordedContact, mechanism: Mechanism) -> None:
        self._index, self._contact = index, contact
        self.motion = contact.motion(mechanism)
        self._begun, self._left, self._speed = 0.0, np.inf, np.nan
        self._peak: _Peak | None = None

    @property
    def _phase(self) -> Phase:
        return self._contact.phases.last

    @property
    def clearance(self) -> float:
        """Clearance of the contact [m]."""
        return self._contact.clearance

    @property
    def is_pressed(self) -> bool:
        """Whether the wall presses."""
        return self._phase.state == PRESSED

    def part(self, time: float) -> None:
        """Leave a wall in which the pin still is, and which does not press it."""
        self._contact.phases.begin(Phase(time, PARTED, self._phase.touch_speed))

    def pressure(self, place: PinPlace, touch_speed: float) -> float:
        """Return what the law says, whether or not it acts [N]."""
        return float(self._contact.law.force(place.depth, place.growth, touch_speed))

    def begin(self, time: float, is_pressed: bool, speed: float = np.nan) -> None:
        """Begin to touch, or to be free; `speed` is that towards the wall, if known."""
        law_speed = np.inf if np.isnan(speed) else speed
        self._contact.phases.begin(Phase(time, PRESSED if is_pressed else FREE, law_speed))
        self._begun, self._left, self._speed, self._peak = time, np.inf, speed, None

    def end(self, times: list[float], place: Callable[[float], PinPlace]) -> float:
        """Return when the phase ends within a step [s]; inf if it does not.

        Args:
            times: within the step, its start and end included.
            place: of the pin at a time.
        """
        phase = self._phase
        if phase.state == FREE:
            return first_fall(lambda time: -place(time).depth, times)

        def pressure(time: float) -> float:
            return self.pressure(place(time), phase.touch_speed)

        if phase.state == PRESSED:
            kinks = (self._crossing(kink, times, place) for kink in self._contact.law.kinks)
            return min(first_fall(pressure, times), *kinks, np.inf)
        back = first_fall(lambda time: place(time).depth, times)
        # Some laws press once more just before the pin is back, whose flight the step may be.
        way = min(back, times[-1]) - times[0]
        inside = [times[0] + way * (1.0 - left) for left in _LEFT.tolist()]
        return min(back, first_fall(lambda time: -pressure(time), inside))

    @staticmethod
    def _crossing(kink: float, times: list[float], place: Callable[[float], PinPlace]) -> float:
        """Return when the depth passes that of a kink within a step; inf if it does not."""
        start = place(times[0]).depth - kink
        side = start if abs(start) > NOTHING * kink else place(times[1]).depth - kink
        sign = 1.0 if side > 0.0 else -1.0
        return first_fall(lambda time: sign * (place(time).depth - kink), times)

    def switch(self, time: float, place: PinPlace) -> list[Touch]:
        """Begin the phase that follows, if it is no kink; return the touch that ended, if any."""
        phase, contact = self._phase, self._contact
        if phase.state == FREE:
            self.begin(time, True, place.growth)
            return []
        if phase.state == PRESSED and any(
            abs(place.depth - kink) <= NOTHING * kink for kink in contact.law.kinks
        ):
            return []
        if place.depth <= NOTHING * contact.clearance:
            ended = self.touch(time)
            self.begin(time, False)
            return ended
        # Where the wall presses once more before the pin is back, it is the same touch.
        self._left = time if phase.state == PRESSED else np.inf
        state = PARTED if phase.state == PRESSED else PRESSED
        contact.phases.begin(Phase(time, state, phase.touch_speed))
        return []

    def note_peak(self, times: list[float], place: Callable[[float], PinPlace]) -> None:
        """Keep the greatest force of a step if it is that of the touch so far.

        Args:
            times: within the step.
            place: of the pin at a time.
        """
        phase = self._phase
        if phase.state != PRESSED:
            return
        forces = [self.pressure(place(time), phase.touch_speed) for time in times]
        best = int(np.argmax(forces))
        so_far = self._peak.force if self._peak else 0.0
        if forces[best] < so_far and best in (0, len(times) - 1):
            return
        time, force = times[best], forces[best]
        low, high = times[max(best - 1, 0)], times[min(best + 1, len(times) - 1)]
        if high > low:
            time, force = peak(
                lambda at: self.pressure(place(at), phase.touch_speed), low, high, (time, force)
            )
        if force > so_far:
            self._peak = _Peak(force, time, np.array(place(time).away))

    def touch(self, time: float) -> list[Touch]:
        """Return the touch that ends at a time at the latest, if the wall is touched."""
        if self._phase.state == FREE or self._peak is None:
            return []
        end = min(self._left, time)
        return [Touch(self._index, self._begun, end, self._speed, *self._peak)]
