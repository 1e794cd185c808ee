"""Run-up: a simulation through a range of speed, beside what constant speeds predict."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array
from ..checks import number, positive
from ..errors import ArgumentError
from .characteristic import Characteristic
from .motion_search import MotionSearch
from .result import Result, frame_of, unit_of
from .rotating_scene import rotating_scene
from .simulated_run import Run, SimulatedRun
from .steady_path import steady_path
from .torque_curve import TorqueBarrier, TorqueCurve

if TYPE_CHECKING:
    import pandas

    from ..figures.style import Figure
    from ..scene.scene import Scene

_BESIDE = 1e-3
"""Relative distance beyond the top of a barrier at which a drive still counts as held by it."""
_COLUMNS = TorqueBarrier._fields


@dataclass(frozen=True, eq=False)
class RunUp(Result):
    """A run through a range of speed; N samples, W windows, n free coordinates.

    What is predicted are the periodic motions that a slow run follows, S of them, at speeds that
    lie closer where they change. Where a torque moves the drive they have constant mean speed, and
    the speed varies within a turn as the inertia of the drive allows.

    Attributes:
        scene: with one drive and free coordinates.
        time: `(N,)` [s].
        speed: of the drive `(N,)` [rad/s].
        position: of the free coordinates `(N, n)` [rad or m].
        window: mean speeds of the drive in each revolution `(W,)` [rad/s].
        window_time: times in the middle of them `(W,)` [s].
        envelope: half the way from peak to peak in each of them `(W, n)`.
        predicted_speed: `(S,)` [rad/s].
        predicted: half the way from peak to peak of the periodic motion there `(S, n)`; NaN where
            there is none.
        linear: the same by the linear equation with averaged coefficients, at constant speed.
        predicted_torque: mean torque over the drive's position that the periodic motion absorbs
            `(S,)` [N·m].
        predicted_lack: by how much that exceeds what the drive has `(S,)` [N·m]; all of it where
            the motion is prescribed.
        barriers: resonances in the order in which the run meets them, with the torque that each
            absorbs at most.
        settled_speed: mean speed at which the drive stays in the end, driven by a torque, NaN if
            it does not [rad/s].
        is_captured: whether it stays there for a resonance that absorbs all its torque.
        captured_speed: where, NaN if it does not [rad/s].
    """

    scene: Scene
    time: Array
    speed: Array
    position: Array
    window: Array
    window_time: Array
    envelope: Array
    predicted_speed: Array
    predicted: Array
    linear: Array
    predicted_torque: Array
    predicted_lack: Array
    barriers: tuple[TorqueBarrier, ...]
    settled_speed: float
    is_captured: bool
    captured_speed: float

    @property
    def captured_by(self) -> TorqueBarrier | None:
        """The resonance that holds the drive: the first above its speed that it cannot pass."""
        return _barrier_above(self.barriers, self.captured_speed) if self.is_captured else None

    @property
    def mean_speed(self) -> Array:
        """Speed of the drive without what varies within a revolution `(N,)` [rad/s]."""
        if not self._is_driven:
            return self.speed
        return np.interp(self.time, self.window_time, self.window)

    @property
    def _is_driven(self) -> bool:
        """Whether a torque moves the drive."""
        return not np.array_equal(self.predicted_lack, self.predicted_torque, equal_nan=True)

    def to_dataframe(self) -> pandas.DataFrame:
        """Return a row for each window and coordinate; NaN beyond what is predicted."""
        rows = []
        for column, name in enumerate(self.free):
            order = np.argsort(self.predicted_speed)
            curves = [
                np.interp(
                    self.window, self.predicted_speed[order], values[order, column], np.nan, np.nan
                )
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
        name = self.free[0] if coordinate is None else coordinate
        column = self.free.index(name)
        values = self.position[:, column] - np.mean(self.position[:, column])
        curves = {"periodic motion": self.predicted, "averaged": self.linear}
        return drawn(
            self.mean_speed,
            values,
            unit=unit_of(self.scene, name),
            predicted={
                name: (self.predicted_speed, line[:, column]) for name, line in curves.items()
            },
        )

    def plot_torque(self) -> Figure:
        """Draw the torque that the motions absorb over speed, beside what the drive has.

        A captured drive is marked where it stays in the long run, to which short runs still creep.
        """
        from ..figures.vibration import torque_over_speed

        by, held = self.captured_by, None
        if by is not None:
            held = by.holds if np.isfinite(by.holds) else self.captured_speed
        available = self.predicted_torque - self.predicted_lack
        return torque_over_speed(
            self.predicted_speed,
            self.predicted_torque,
            available=available if self._is_driven else None,
            barriers=[(item.speed, item.torque) for item in self.barriers],
            held=held,
        )

    def stored(self) -> dict[str, Any]:
        """Return what `save` writes, of the barriers a column for each field."""
        columns = zip(*self.barriers, strict=True) if self.barriers else [()] * len(_COLUMNS)
        table = {
            f"barriers.{name}": np.array(of) for name, of in zip(_COLUMNS, columns, strict=True)
        }
        stored = {name: value for name, value in super().stored().items() if name != "barriers"}
        return {**stored, **table}

    def __str__(self) -> str:
        lines = [repr(self)[1:-1], *(f"- {item}" for item in self.barriers)]
        return "\n".join(lines)

    def __repr__(self) -> str:
        by = self.captured_by
        captured = "" if by is None else f", captured at {self.captured_speed:.4g} rad/s by {by}"
        return (
            f"<RunUp of {', '.join(self.free)} from {self.mean_speed[0]:g} to "
            f"{self.mean_speed[-1]:g} rad/s "
            f"in {self.time[-1]:g} s{captured}>"
        )


def run_up(
    scene: Scene,
    start: float,
    end: float,
    duration: float,
    *,
    torque: float | Callable[[float], float] | None = None,
    rtol: float = 1e-8,
    within: float = 1.0,
) -> RunUp:
    """Simulate a run through a range of speed, from the periodic motion at its beginning.

    Args:
        scene: with one drive and free coordinates.
        within: see `periodic_motion`.
        start: speed of the drive at the beginning [rad/s]; with a torque, its mean over a
            revolution.
        end: its speed at the end, of the same sense. A torque need not reach it; where it does,
            the run ends there.
        duration: [s].
        torque: what moves the drive instead of a prescribed motion [N·m], beside the loads of the
            scene: a constant, or a function of the drive's speed [rad/s], such as a motor's line
            `lambda speed: 0.02 * (157.0 - speed)`. Weak ones may be captured at a resonance,
            which then takes all their power.
        rtol: of the simulation.

    Raises:
        ArgumentError: a value is out of range, or the torque returns no finite number.
        VibrationError: a torque cannot turn the drive through with one of the speeds, or lets it
            come to rest.
        SimulationError: see `Scene.simulate`.
        CardanError: see `periodic_motion`.
    """
    duration = positive("duration", duration)
    first, last = number("start", start), number("end", end)
    if first * last <= 0.0 or first == last:
        raise ArgumentError(f"start {start!r} and end {end!r}: give two speeds of one sense")
    search = MotionSearch(rotating_scene(scene), positive("within", within))
    given = None if torque is None else Characteristic(torque)
    run = SimulatedRun(search, first, last, given).over(duration, rtol)
    # A weak torque may let the drive slow down first.
    lowest = (min if last > first else max)(first, np.nan_to_num(run.settled, nan=first))
    curve = TorqueCurve(search, steady_path(search, float(lowest), last), given)
    return _compared(search.rotating.scene, run, curve)


def _compared(scene: Scene, run: Run, curve: TorqueCurve) -> RunUp:
    """Return a run beside what constant speeds predict."""
    found = curve.predicted()
    barriers = curve.barriers(found)
    captured = bool(np.isfinite(run.settled) and _barrier_above(barriers, run.settled))
    return RunUp(
        scene=scene,
        time=run.time,
        speed=run.speed,
        position=run.position,
        window=run.window.speed,
        window_time=run.window.time,
        envelope=run.window.envelope,
        predicted_speed=found.speed,
        predicted=found.swing,
        linear=found.linear,
        predicted_torque=found.torque,
        predicted_lack=found.lack,
        barriers=barriers,
        settled_speed=run.settled,
        is_captured=captured,
        captured_speed=run.settled if captured else np.nan,
    )


def _barrier_above(barriers: tuple[TorqueBarrier, ...], speed: float) -> TorqueBarrier | None:
    """Return the first barrier that holds a drive at a speed, None if there is none."""
    for item in barriers:
        if abs(item.speed) > abs(speed) * (1.0 - _BESIDE) and not item.is_passed:
            return item
    return None
