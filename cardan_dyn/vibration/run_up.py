"""Run-up: a simulation through a range of speed, beside what constant speeds predict."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..checks import numbers
from ..errors import ArgumentError
from .forced_response import forced_response
from .periodic_motion import limit
from .result import Result, frame_of
from .rotating_scene import rotating_scene

if TYPE_CHECKING:
    import pandas

    from ..figures.style import Figure
    from ..results.sweep import Sweep
    from ..scene.scene import Scene
    from ..simulation.trajectory import Trajectory

_PREDICTED = 120
"""Constant speeds that are predicted."""
_PER_PERIOD = 24
"""Samples of the simulation per period of the mechanism, at least."""
_STALLED = 0.1
"""Rise of speed over the last fifth, as a fraction of that without resistance, below which the
drive has been captured."""


class _Rising(NamedTuple):
    """Motion whose speed rises steadily from the first to the last in a time."""

    first: float
    last: float
    duration: float

    def __call__(self, time: float) -> tuple[float, float, float]:
        """Return position, speed and acceleration."""
        rise = (self.last - self.first) / self.duration
        return self.first * time + 0.5 * rise * time**2, self.first + rise * time, rise


@dataclass(frozen=True, eq=False)
class RunUp(Result):
    """A run through a range of speed; N samples, W windows, n free coordinates.

    Attributes:
        scene: its drive first.
        time: `(N,)` [s].
        speed: of the drive `(N,)` [rad/s].
        position: of the free coordinates `(N, n)` [rad or m].
        window: speeds `(W,)` in the middle of windows of some revolutions [rad/s].
        envelope: half the way from peak to peak in each window `(W, n)`.
        predicted_speed: `(S,)` [rad/s].
        predicted: half the way from peak to peak of the periodic motion there `(S, n)`; NaN where
            there is none.
        linear: the same by the linear equation with averaged coefficients.
        is_captured: whether the drive stays at a speed that it does not pass, driven by a torque.
        captured_speed: where, NaN if it does not [rad/s].
    """

    scene: Scene
    time: Array
    speed: Array
    position: Array
    window: Array
    envelope: Array
    predicted_speed: Array
    predicted: Array
    linear: Array
    is_captured: bool
    captured_speed: float

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the free coordinates."""
        return self.scene.drives[1:]

    def to_dataframe(self) -> pandas.DataFrame:
        """Return a row for each window and coordinate."""
        rows = []
        for column, name in enumerate(self.free):
            order = np.argsort(self.predicted_speed)
            curves = [
                np.interp(self.window, self.predicted_speed[order], values[order, column])
                for values in (self.predicted, self.linear)
            ]
            rows += [
                {
                    "speed": speed,
                    "coordinate": name,
                    "envelope": self.envelope[row, column],
                    "predicted": curves[0][row],
                    "linear": curves[1][row],
                }
                for row, speed in enumerate(self.window.tolist())
            ]
        units = ("rad/s", "", "rad or m", "rad or m", "rad or m")
        names = ("speed", "coordinate", "envelope", "predicted", "linear")
        return frame_of(rows, dict(zip(names, units, strict=True)))

    def plot(self, coordinate: str | None = None) -> Figure:
        """Draw a free coordinate over speed, the first one if None, beside the prediction.

        Raises:
            ArgumentError: it is not free.
        """
        from ..figures.vibration import run_up as drawn

        if coordinate is not None and coordinate not in self.free:
            raise ArgumentError(f"{coordinate!r} is not free; free: {', '.join(self.free)}")
        column = 0 if coordinate is None else self.free.index(coordinate)
        values = self.position[:, column] - np.mean(self.position[:, column])
        curves = {"periodic motion": self.predicted, "averaged": self.linear}
        return drawn(
            self.speed,
            values,
            unit="rad or m",
            predicted={
                name: (self.predicted_speed, line[:, column]) for name, line in curves.items()
            },
        )

    def __repr__(self) -> str:
        captured = f", captured at {self.captured_speed:.4g} rad/s" if self.is_captured else ""
        return (
            f"<RunUp of {', '.join(self.free)} from {self.speed[0]:g} to {self.speed[-1]:g} rad/s "
            f"in {self.time[-1]:g} s{captured}>"
        )


def run_up(
    scene: Scene,
    start: float,
    end: float,
    duration: float,
    *,
    torque: float | None = None,
    drive: str | None = None,
    rtol: float = 1e-8,
    within: float = 1.0,
) -> RunUp:
    """Simulate a run through a range of speed, from the periodic motion at its beginning.

    Args:
        scene: its other drives are free.
        drive: see `periodic_motion`.
        within: see `periodic_motion`.
        start: speed of the drive at the beginning [rad/s].
        end: its speed at the end, of the same sense; with a torque, it need not be reached.
        duration: [s].
        torque: a constant one that moves the drive instead of a prescribed motion [N·m]; weak ones
            may be captured at a resonance, which then takes all their power.
        rtol: of the simulation.

    Raises:
        ArgumentError: a value is out of range.
        SimulationError: see `Scene.simulate`.
        CardanError: see `periodic_motion`.
    """
    duration = limit("duration", duration)
    ends = [numbers(label, value) for label, value in (("start", start), ("end", end))]
    if any(value.ndim for value in ends) or ends[0] * ends[1] <= 0.0 or ends[0] == ends[1]:
        raise ArgumentError(f"start {start!r} and end {end!r}: give two speeds of one sense")
    first, last = (float(value) for value in ends)
    rotating = rotating_scene(scene, drive)
    within = limit("within", within)
    if torque is not None and numbers("torque", torque).ndim:
        raise ArgumentError(f"torque is {torque!r}, expected a number")
    begun = forced_response(rotating.scene, first, joints=[], within=within)
    order, wave = begun.order, begun.amplitude[0]
    begins: dict[str, Any] = {
        "position": dict(zip(rotating.free, np.sum(wave, axis=0).real.tolist(), strict=True)),
        "speed": dict(zip(rotating.free, (1j * first * order @ wave).real.tolist(), strict=True)),
    }
    if torque is None:
        moved: dict[str, Any] = {"motion": {rotating.drive: _Rising(first, last, duration)}}
    else:
        begins["position"][rotating.drive], begins["speed"][rotating.drive] = 0.0, first
        moved = {"loads": {rotating.drive: float(numbers("torque", torque))}}
    run = rotating.scene.simulate(duration, **begins, **moved, rtol=rtol)
    fastest = max(abs(first), abs(last), float(np.max(np.abs(np.asarray(run.speed)[:, 0]))))
    count = int(_PER_PERIOD * max(1.0, fastest * duration / rotating.period)) + 1
    return _compared(rotating.scene, run.evenly(count), (first, last), torque, within)


def _compared(
    scene: Scene,
    run: Trajectory | Sweep,
    ends: tuple[float, float],
    torque: float | None,
    within: float,
) -> RunUp:
    """Return a run beside what constant speeds predict."""
    time = np.asarray(run.t)  # type: ignore[union-attr]
    position, rate = np.asarray(run.position), np.asarray(run.speed)
    drive, free = position[:, 0], position[:, 1:]
    window, envelope = _envelope(drive, rate[:, 0], free)
    low, high = min(ends), max(ends)
    speeds = np.linspace(low, high, _PREDICTED)
    response = forced_response(scene, speeds, joints=[], within=within)
    captured, where = False, np.nan
    if torque is not None:
        fifth = time >= 0.8 * time[-1]
        slope = float(np.polyfit(time[fifth], rate[fifth, 0], 1)[0])
        early = time <= 0.1 * time[-1]
        free_slope = float(np.polyfit(time[early], rate[early, 0], 1)[0])
        mean = float(np.mean(rate[fifth, 0]))
        captured = abs(slope) < _STALLED * abs(free_slope) and low < mean < high
        where = mean if captured else np.nan
    return RunUp(
        scene=scene,
        time=time.copy(),
        speed=rate[:, 0].copy(),
        position=free.copy(),
        window=window,
        envelope=envelope,
        predicted_speed=speeds,
        predicted=_half_swings(response.order, response.amplitude),
        linear=_half_swings(response.order, response.averaged),
        is_captured=captured,
        captured_speed=where,
    )


def _envelope(drive: Array, speed: Array, free: Array) -> tuple[Array, Array]:
    """Return speeds `(W,)` and half swings `(W, n)` in windows of one revolution."""
    turn = np.floor(np.abs(drive - drive[0]) / (2.0 * np.pi)).astype(int)
    starts = np.nonzero(np.diff(turn, prepend=-1))[0].tolist()
    parts = [slice(*pair) for pair in pairwise(starts)]
    parts = parts or [slice(0, len(drive))]
    middle = np.array([float(np.mean(speed[part])) for part in parts])
    return middle, np.array([0.5 * np.ptp(free[part], axis=0) for part in parts])


def _half_swings(order: Array, amplitude: Array) -> Array:
    """Return half the way from peak to peak `(S, n)` of amplitudes `(S, K, n)`."""
    count = 8 * len(order)
    waves = np.exp(1j * np.outer(2.0 * np.pi / count * np.arange(count), order))
    return 0.5 * np.ptp((waves @ amplitude).real, axis=1)
