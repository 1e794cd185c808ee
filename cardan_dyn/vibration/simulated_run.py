"""Simulated run: a drive that speeds up, steadily or by a torque, and where it stays."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import VibrationError
from ..simulation.events import Event
from .characteristic import Characteristic
from .coexisting import smallest
from .driven_motion import DrivenMotions
from .motion_search import MotionSearch
from .periodic_motion import refuse_missed

if TYPE_CHECKING:
    from ..simulation.trajectory import Trajectory

_PER_PERIOD = 48
"""Samples of the simulation per period of the mechanism, at least."""
_LATE = 0.8
"""Fraction of the run after which it is looked at whether the drive still speeds up."""
_STALLED = 0.1
"""Rise of speed there, as a fraction of that without resistance, below which it does not."""
_FEWEST = 3
"""Revolutions that tell a rise of speed."""
_REST = "rest"
"""Name of the event at which the drive comes to rest."""


class Rising(NamedTuple):
    """Motion whose speed rises steadily from the first to the last in a time."""

    first: float
    last: float
    duration: float

    def __call__(self, time: float) -> tuple[float, float, float]:
        """Return position, speed and acceleration."""
        rise = (self.last - self.first) / self.duration
        return self.first * time + 0.5 * rise * time**2, self.first + rise * time, rise


class Windows(NamedTuple):
    """Whole revolutions of the drive, W of them: middle, mean speed and half swings."""

    time: Array
    speed: Array
    envelope: Array


class Run(NamedTuple):
    """What a simulated run gives, N samples.

    Attributes:
        time: `(N,)` [s].
        speed: of the drive `(N,)` [rad/s].
        position: of the free coordinates `(N, n)` [rad or m].
        window: revolutions of the drive.
        settled: mean speed at which the drive stays in the end; NaN if it does not [rad/s].
    """

    time: Array
    speed: Array
    position: Array
    window: Windows
    settled: float


class SimulatedRun:
    """A run of one scene, from the periodic motion at its first speed."""

    def __init__(
        self, search: MotionSearch, first: float, last: float, torque: Characteristic | None
    ) -> None:
        """Find the motion with which the run begins.

        Args:
            search: of the scene.
            first: speed at the beginning [rad/s].
            last: at the end.
            torque: characteristic of the drive; None where its speed rises steadily.

        Raises:
            VibrationError: there is no motion at the first speed.
            CardanError: see `MotionSearch.primary`.
        """
        self._search, self._first, self._last, self._torque = search, first, last, torque
        rotating = search.rotating
        self._scene, self._drive = rotating.scene, rotating.drive
        found, _ = smallest(search, np.array([first]))
        refuse_missed(search, np.array([first]))
        (motions,) = found
        self._begun = DrivenMotions(
            search.build.efforts, rotating.period, rotating.units, torque
        ).of(motions.course.speed, motions.course.q, motions.model.divisor)

    def over(self, duration: float, rtol: float) -> Run:
        """Return the run.

        Args:
            duration: [s].
            rtol: relative tolerance of the simulation.

        Raises:
            VibrationError: the drive comes to rest under its torque.
            SimulationError: see `Scene.simulate`.
        """
        run = self._simulated(duration, rtol)
        time, speed = np.array(run.time), np.array(run.speed)[:, 0]
        drive, free = np.split(np.array(run.position), [1], axis=1)
        windows = windows_of(time, drive[:, 0], speed, free)
        return Run(time, speed, free.copy(), windows, self._settled(time, windows))

    def _simulated(self, duration: float, rtol: float) -> Trajectory:
        """Return the simulation at equidistant times."""
        begun, names = self._begun, self._search.rotating.free
        position = dict(zip(names, begun.position[0, 0].tolist(), strict=True))
        speed = dict(zip(names, begun.rate[0, 0].tolist(), strict=True))
        drive = self._drive
        moved: dict[str, Any]
        if self._torque is None:
            rising = Rising(self._first, self._last, duration)
            scene, moved = self._scene, {"motion": {drive: rising}}
        else:
            position[drive], speed[drive] = 0.0, float(begun.pace[0, 0])
            scene = self._scene.replace(free=self._scene.coordinates)
            moved = {"loads": {drive: self._load(self._torque)}, "events": self._ends()}
        run = scene.simulate(duration, position=position, speed=speed, **moved, rtol=rtol)
        if any(item.name == _REST for item in run.events):
            raise VibrationError(
                f"{drive} comes to rest after {float(run.time[-1]):g} s: the torque is too weak "
                "for its losses and loads, or acts against the speed at the start",
                speed=self._first,
            )
        fastest = max(abs(self._first), float(np.max(np.abs(np.asarray(run.speed)[:, 0]))))
        turns = max(1.0, fastest * float(run.time[-1]) / self._search.rotating.period)
        return run.evenly(int(_PER_PERIOD * turns) + 1)

    def _load(self, given: Characteristic) -> Any:
        """Return what acts on the drive, its load in the scene included."""
        own, drive = float(np.asarray(self._scene.loads.get(self._drive, 0.0)).item()), self._drive
        if not callable(given.torque):
            return given.torque + own
        return lambda time, position, speed: given(speed[drive]) + own

    def _ends(self) -> list[Event]:
        """Return what ends the run: the last speed, of which a turn runs ahead, or rest."""
        sense = float(np.sign(self._last - self._first))
        ahead = float(np.max(sense * self._begun.pace)) / self._first
        drive, goal = self._drive, sense * ahead * self._last
        return [
            Event(lambda time, position, speed: speed[drive] - goal, True, int(sense), "end"),
            Event(lambda time, position, speed: speed[drive], True, 0, _REST),
        ]

    def _settled(self, time: Array, windows: Windows) -> float:
        """Return the mean speed at which the drive stays in the end; NaN if it does not."""
        if self._torque is None:
            return np.nan
        late = windows.time >= _LATE * time[-1]
        if np.sum(late) < _FEWEST:
            return np.nan
        slope = float(np.polyfit(windows.time[late], windows.speed[late], 1)[0])
        free = abs(self._torque(self._first)) / self._inertia()
        return float(np.mean(windows.speed[late])) if abs(slope) < _STALLED * free else np.nan

    def _inertia(self) -> float:
        """Return the mean moment of inertia that the drive moves [kg m²]."""
        free = len(self._search.rotating.free)
        count = len(self._begun.pace[0])
        place = np.zeros((count, 1 + free))
        place[:, 0] = self._search.rotating.period / count * np.arange(count)
        place[:, 1:] = np.mean(self._begun.position[0], axis=0)
        rest, unit = np.zeros_like(place), np.tile(np.eye(1 + free)[0], (count, 1))
        states = [(rest, unit), (rest, rest)]
        risen, still = self._search.build.efforts.through(place, states)
        return float(np.mean(risen[:, 0] - still[:, 0]))


def windows_of(time: Array, drive: Array, speed: Array, free: Array) -> Windows:
    """Return the revolutions of a run, or all of it if it has none."""
    way = np.abs(drive - drive[0])
    marks = 2.0 * np.pi * np.arange(int(way[-1] / (2.0 * np.pi)) + 1)
    if len(marks) < 2:
        half = 0.5 * np.ptp(free, axis=0)
        return Windows(np.array([np.mean(time)]), np.array([np.mean(speed)]), half[None])
    at = np.interp(marks, way, time)
    places = np.searchsorted(time, at)
    return Windows(
        0.5 * (at[1:] + at[:-1]),
        np.sign(drive[-1] - drive[0]) * 2.0 * np.pi / np.diff(at),
        np.array([0.5 * np.ptp(free[low : high + 1], axis=0) for low, high in pairwise(places)]),
    )
