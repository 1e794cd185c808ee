"""Recorded contact: a pin contact that knows when a simulation found it pressed, and since when."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ...core.elements.pin_contact import PinContact
from ...kit.arrays import Array

FREE, PRESSED, PARTED = "free", "pressed", "parted"
"""States of a contact: the pin is in the clearance; its law acts; the wall follows too slowly to
press, so that the pin has left it before it is back in the clearance."""


class Phase(NamedTuple):
    """What a contact does from a time on.

    Attributes:
        start: [s].
        state: `free`, `pressed` or `parted`.
        touch_speed: at which the pin struck the wall [m/s]; infinite if that is not known.
    """

    start: float
    state: str
    touch_speed: float


class Phases:
    """The phases of a contact, one after the other."""

    def __init__(self) -> None:
        self._starts: list[float] = []
        self._phases: list[Phase] = []

    def __len__(self) -> int:
        return len(self._phases)

    def begin(self, phase: Phase) -> None:
        """Begin a phase, later than all others."""
        self._starts.append(phase.start)
        self._phases.append(phase)

    @property
    def last(self) -> Phase:
        """The phase that began last."""
        return self._phases[-1]

    def at(self, time: float) -> Phase:
        """Return the phase at a time; where one begins, that one."""
        return self._phases[max(bisect_right(self._starts, time) - 1, 0)]

    def sampled(self, times: Array) -> tuple[Array, Array]:
        """Return at times `(N,)` whether the law acts, and the speeds of touch."""
        indices = np.maximum(np.searchsorted(self._starts, times, side="right") - 1, 0)
        pressed = np.array([phase.state == PRESSED for phase in self._phases])
        speeds = np.array([phase.touch_speed for phase in self._phases])
        return pressed[indices], speeds[indices]


@dataclass(frozen=True, eq=False)
class RecordedContact(PinContact):
    """A pin contact whose phases a simulation has located.

    Attributes:
        phases: of the simulation.
    """

    phases: Phases = field(default_factory=Phases, compare=False)

    def pressure(self, depth: Array, rate: Array, time: Array) -> Array:
        """See `PinContact.pressure`."""
        is_pressed, speeds = self.phases.sampled(time)
        force = self.law.force(depth, rate, speeds)
        return np.where(is_pressed, np.maximum(force, 0.0), 0.0)

    def acts_at(self, time: float) -> bool:
        """See `PinContact.acts_at`."""
        return self.phases.at(time).state == PRESSED

    def pressure_at(self, depth: float, rate: float, time: float) -> float:
        """See `PinContact.pressure_at`; smooth within a phase and a little beyond its end."""
        phase = self.phases.at(time)
        if phase.state != PRESSED:
            return 0.0
        return float(self.law.force(depth, rate, phase.touch_speed))

    @classmethod
    def of(cls, contact: PinContact) -> RecordedContact:
        """Return a contact with no phases yet."""
        return cls(**{name: value for name, value in vars(contact).items() if name != "phases"})
