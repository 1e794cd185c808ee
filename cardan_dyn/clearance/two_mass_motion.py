"""Two-mass motion: how two masses moved across a play, their impacts and energies."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..checks import numbers
from ..elements.contact_laws import ContactLaw
from ..errors import ArgumentError
from .two_mass_phases import Phase

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

_SAMPLES = 33
"""Of a phase, for figures."""


@dataclass(frozen=True)
class Impact:
    """A touch of the two sides, from where the depth begins until their force vanishes.

    Attributes:
        time: of the touch [s].
        side: +1 where the play is used up, -1 where the gap is zero.
        speed: at which it begins [m/s].
        peak: first greatest force after it, one that a damper has at once included; NaN if the
            force only rises, or rises until time is up [N].
        peak_time: when it acts [s].
        duration: until the force vanishes for the last time; NaN if time is up before [s].
        restitution: speed then, over that before; NaN likewise. The external force acts meanwhile:
            that of a free impact is `ContactLaw.restitution`.
    """

    time: float
    side: int
    speed: float
    peak: float
    peak_time: float
    duration: float
    restitution: float


class TwoMassState(NamedTuple):
    """The two masses at times `(N,)`.

    Attributes:
        gap: of the side where the motion begins [m]: from 0 to the play without contact, below 0
            where they press on each other there, beyond the play on the other side.
        speed: its rate [m/s].
        force: of the contact [N]: positive where the play is used up, negative at the gap 0, F₁₂.
        external: the force F that moves them [N], positive towards a greater gap.
    """

    gap: Array
    speed: Array
    force: Array
    external: Array


class Energies(NamedTuple):
    """Energies at the bounds of the phases `(P,)`, of the relative motion [J].

    Attributes:
        time: [s].
        kinetic: m v² / 2.
        stored: in the contacts.
        work: that the external force has done since the start.
        lost: that contacts have turned into heat since the start.
    """

    time: Array
    kinetic: Array
    stored: Array
    work: Array
    lost: Array


@dataclass(frozen=True, eq=False)
class TwoMassMotion:
    """How two masses moved across a play.

    Attributes:
        law: of the contact on both sides.
        play: 2 s [m].
        mass: reduced mass m [kg].
        masses: m₁₁ and m₂₂ [kg], or None if the reduced mass alone was given.
        impacts: in order of time.
        ended: why it ended: "time is up", or that it met as many impacts as it might.
    """

    law: ContactLaw
    play: float
    mass: float
    masses: tuple[float, float] | None
    impacts: tuple[Impact, ...]
    ended: str
    _phases: tuple[Phase, ...] = field(repr=False)
    _external: Callable[[Any], Any] = field(repr=False)

    @property
    def peak(self) -> float:
        """Greatest of the impacts' peaks; NaN without one [N]."""
        peaks = [item.peak for item in self.impacts if not np.isnan(item.peak)]
        return max(peaks, default=float("nan"))

    @cached_property
    def times(self) -> Array:
        """Times of the samples `(N,)` [s]: bounds of phases, and places within them."""
        bounds = [(phase.begun.time, phase.end) for phase in self._phases]
        places = [np.linspace(*pair, _SAMPLES)[:-1] for pair in bounds if pair[1] > pair[0]]
        return np.concatenate([*places, [bounds[-1][1]]])

    @cached_property
    def _sampled(self) -> TwoMassState:
        return self.at(self.times)

    @property
    def gap(self) -> Array:
        """Gap at `times` `(N,)`, see `TwoMassState` [m]."""
        return self._sampled.gap

    @property
    def speed(self) -> Array:
        """Its rate at `times` `(N,)` [m/s]."""
        return self._sampled.speed

    @property
    def force(self) -> Array:
        """Contact's force at `times` `(N,)`, see `TwoMassState` [N]."""
        return self._sampled.force

    def at(self, times: ArrayLike) -> TwoMassState:
        """Return the state at times `(N,)`, in any order, within the motion [s].

        At the time of a touch it is that after it.

        Raises:
            ArgumentError: a time is no finite number, or outside of the motion.
        """
        asked = np.atleast_1d(numbers("times", times))
        if asked.ndim > 1:
            raise ArgumentError(f"times has shape {asked.shape}, expected (N,)")
        first, last = self._phases[0].begun.time, self._phases[-1].end
        if np.any((asked < first) | (asked > last)):
            raise ArgumentError(f"times lie from {first:g} to {last:g} s; some are outside")
        starts = np.array([phase.begun.time for phase in self._phases])
        owner = np.searchsorted(starts, asked, side="right") - 1
        gap, speed, force = np.zeros((3, len(asked)))
        for index in np.unique(owner).tolist():
            phase, mine = self._phases[index], owner == index
            depth, rate = phase.states(asked[mine])
            side = phase.begun.side
            gap[mine] = side * depth + (self.play if side > 0 else 0.0)
            speed[mine] = side * rate
            if phase.is_contact:
                pressed = self.law.force(depth, rate, phase.begun.touch_speed)
                force[mine] = side * np.maximum(pressed, 0.0)
        external = np.array([float(self._external(time)) for time in asked.tolist()])
        return TwoMassState(gap, speed, force, external)

    def displacements(self, times: ArrayLike) -> tuple[Array, Array]:
        """Return how far the masses m₁₁ and m₂₂ have moved, each `(N,)` [m].

        The forces on both are opposite, so that their centre stays where it is. The first moves
        towards a greater gap, the second against it; both count from where the gap is zero.

        Raises:
            ArgumentError: the reduced mass alone is known, or as `at`.
        """
        if self.masses is None:
            raise ArgumentError(
                "the reduced mass does not say how far each side moves; give mass=(m_11, m_22)"
            )
        gap = self.at(times).gap
        total = sum(self.masses)
        return gap * (self.masses[1] / total), -gap * (self.masses[0] / total)

    @cached_property
    def energies(self) -> Energies:
        """Energies at the bounds of the phases."""
        first = self._phases[0].begun
        rows = [(first.time, first.depth, first.rate, 0.0, 0.0)]
        for phase in self._phases:
            work, lost = rows[-1][3] + phase.work, rows[-1][4] + phase.loss
            rows.append((phase.end, *phase.last, work, lost))
        time, depth, rate, done, heat = np.array(rows).T
        return Energies(time, 0.5 * self.mass * rate**2, self.law.energy(depth), done, heat)

    @property
    def energy_residual(self) -> float:
        """Greatest imbalance of work, kinetic, stored and lost energy, over what was exchanged."""
        _, kinetic, stored, work, lost = self.energies
        total = kinetic + stored - work + lost
        exchanged = max(float(np.max(np.abs(part))) for part in self.energies[1:])
        return float(np.max(np.abs(total - total[0]))) / exchanged if exchanged else 0.0


def impacts_of(phases: Sequence[Phase]) -> tuple[Impact, ...]:
    """Return the impacts of phases; a touch whose force comes back before it ends is one."""
    found: list[Impact] = []
    contacts = [phase for phase in phases if phase.is_contact and phase.begun.touch_speed > 0.0]
    for index, phase in enumerate(contacts):
        begun = phase.begun
        if phase.is_resumed:
            continue
        whole = [phase]
        for later in contacts[index + 1 :]:
            if not later.is_resumed:
                break
            whole.append(later)
        top = max(whole, key=lambda part: part.peak)
        ends = whole[-1].outcome == "parted"
        found.append(
            Impact(
                time=begun.time,
                side=begun.side,
                speed=begun.touch_speed,
                peak=top.peak if np.isfinite(top.peak) else float("nan"),
                peak_time=top.peak_time,
                duration=whole[-1].end - begun.time if ends else float("nan"),
                restitution=-whole[-1].last[1] / begun.touch_speed if ends else float("nan"),
            )
        )
    return tuple(found)
