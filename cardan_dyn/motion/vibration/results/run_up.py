"""Run-up: a simulation through a range of speed, beside what constant speeds predict."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ....core.elements.law import Given, Law
from ....core.results.plot import Plot, own_options
from ....core.results.table import Table
from ....kit.arrays import Array
from ....kit.checks import number, positive
from ....kit.errors import ArgumentError, VibrationError, choices
from ....kit.extremes import turns
from ....kit.periodic import nodes
from ....kit.time_left import Task
from ...simulation.events import Event
from ..model.efforts import with_drive
from ..motions.driven import DrivenMotions, drive_torque
from ..motions.search import MotionSearch
from ..motions.steady_path import steady_path
from .periodic_motion import refuse_missed, search_of
from .result import VibrationResult, table_of, unit_of
from .torque_curve import TorqueBarrier, TorqueCurve

if TYPE_CHECKING:
    from ....figures.style import Figure
    from ....scene.scene import Scene
    from ...simulation.trajectory import Trajectory

_PER_PERIOD = 48
"""Samples of the simulation per period of the mechanism, at least."""
_LATE = 0.8
"""Fraction of the run after which it is looked at whether the drive still speeds up."""
_STALLED = 0.1
"""Rise of speed there, as a fraction of that without resistance, below which it does not."""
_REST = "rest"
"""Name of the event at which the drive comes to rest."""
_BESIDE = 1e-3
"""Relative distance beyond the top of a barrier at which a drive still counts as held by it."""


class Rising(NamedTuple):
    """Motion whose speed rises steadily from the first to the last in a time."""

    first: float
    last: float
    duration: float

    def __call__(self, time: float) -> tuple[float, float, float]:
        """Return position, speed and acceleration."""
        rise = (self.last - self.first) / self.duration
        return self.first * time + 0.5 * rise * time**2, self.first + rise * time, rise


class Run(NamedTuple):
    """What a simulated run gives, N samples, W revolutions; its names are those of `RunUp`."""

    time: Array
    speed: Array
    position: Array
    window: Array
    window_time: Array
    envelope: Array
    settled_speed: float


class SimulatedRun:
    """A run of one scene, from the periodic motion at its first speed."""

    def __init__(self, search: MotionSearch, first: float, last: float, torque: Law | None) -> None:
        """Find the motion with which the run begins.

        Args:
            search: of the scene.
            first: speed at the beginning [rad/s].
            last: at the end.
            torque: of the drive; None where its speed rises steadily.

        Raises:
            VibrationError: there is no motion at the first speed.
            CardanError: see `MotionSearch.primary`.
        """
        self._search, self._first, self._last, self._torque = search, first, last, torque
        rotating = search.rotating
        self._scene, self._drive = rotating.scene, rotating.drive
        found, _ = search.smallest(np.array([first]))
        refuse_missed(search, np.array([first]))
        (motions,) = found
        self._begun = DrivenMotions(search, torque).of(motions)

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
        time, speed = np.array(run.time), np.array(run.speed)
        drive, free = np.split(np.array(run.position), [1], axis=1)
        at, mean, envelope = windows_of(time, drive[:, 0], free, speed[:, 1:])
        settled = self._settled(at, mean, float(time[-1]))
        return Run(time, speed[:, 0].copy(), free.copy(), mean, at, envelope, settled)

    def _simulated(self, duration: float, rtol: float) -> Trajectory:
        """Return the simulation at equidistant times and those of its own steps."""
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
        end = float(run.time[-1])
        turns = max(1.0, fastest * end / self._search.rotating.period)
        # Steps are as short as the fastest swing asks for, which may be faster than the drive.
        return run.at(np.union1d(np.linspace(0.0, end, int(_PER_PERIOD * turns) + 1), run.steps))

    def _load(self, given: Law) -> Any:
        """Return what acts on the drive, its load in the scene included."""
        own, drive = float(np.asarray(self._scene.loads.get(self._drive, 0.0)).item()), self._drive
        if not given.of:
            return given.given + own  # type: ignore[operator]
        return lambda time, position, speed: given.at_one("torque", speed=speed[drive]) + own

    def _ends(self) -> list[Event]:
        """Return what ends the run: the last speed, of which a turn runs ahead, or rest."""
        sense = float(np.sign(self._last - self._first))
        ahead = float(np.max(sense * self._begun.pace)) / self._first
        drive, goal = self._drive, sense * ahead * self._last
        return [
            Event(lambda time, position, speed: speed[drive] - goal, True, int(sense), "end"),
            Event(lambda time, position, speed: speed[drive], True, 0, _REST),
        ]

    def _settled(self, at: Array, mean: Array, end: float) -> float:
        """Return the mean speed at which the drive stays in the end; NaN if it does not."""
        if self._torque is None:
            return np.nan
        late = at >= _LATE * end
        if np.sum(late) < 2:  # A slope takes two.
            return np.nan
        slope = float(np.polyfit(at[late], mean[late], 1)[0])
        free = abs(self._torque.at_one("torque", speed=self._first)) / self._inertia()
        return float(np.mean(mean[late])) if abs(slope) < _STALLED * free else np.nan

    def _inertia(self) -> float:
        """Return the mean moment of inertia that the drive moves [kg m²]."""
        count = len(self._begun.pace[0])
        rest = np.tile(np.mean(self._begun.position[0], axis=0), (count, 1))
        place = with_drive(nodes(count, self._search.rotating.period), rest)
        still = np.zeros_like(place)
        local = self._search.model.efforts.local(place, still, still)
        return float(np.mean(local.by_acceleration[:, 0, 0]))


def windows_of(time: Array, drive: Array, free: Array, rate: Array) -> tuple[Array, Array, Array]:
    """Return middles, mean speeds and half swings of the revolutions of a run.

    The last one ends with it; it is all of the run if that has none.

    Args:
        time: `(N,)` [s].
        drive: position `(N,)` [rad].
        free: coordinates `(N, n)`.
        rate: theirs `(N, n)`.
    """
    way = np.abs(drive - drive[0])
    ends = 2.0 * np.pi * np.arange(1, int(way[-1] / (2.0 * np.pi)) + 1)
    if not ends.size or ends[-1] < way[-1]:
        ends = np.append(ends, way[-1])
    starts = np.maximum(ends - 2.0 * np.pi, 0.0)
    first, last = (np.interp(at, way, time) for at in (starts, ends))
    low, high = np.searchsorted(time, first), np.searchsorted(time, last)
    _, between = turns(time, free, rate)
    found = [
        np.concatenate([free[a : b + 1], between[a:b]])
        for a, b in zip(low.tolist(), high.tolist(), strict=True)
    ]
    return (
        0.5 * (first + last),
        np.sign(drive[-1] - drive[0]) * (ends - starts) / (last - first),
        np.array([0.5 * np.ptp(part, axis=0) for part in found]),
    )


class RunUpPlot(Plot):
    """Draws a run through a range of speeds."""

    def __call__(self, *columns: Any, **options: Any) -> Figure:
        """Draw a free coordinate over speed, beside the prediction.

        Args:
            columns: name of a free coordinate, the first one if there is none; or columns of the
                table, see `Plot`.
            options: `title`, `ax` (one axes) and `figsize`.

        Raises:
            ArgumentError: the coordinate is not free, or as `Plot`.
        """
        found = self._result
        name = columns[0] if columns else found.free[0]
        if len(columns) > 1 or name not in found.free:
            known = found.table().columns()
            if len(columns) == 1 and isinstance(name, str) and name not in known:
                raise ArgumentError(
                    f"{name!r} is not free; free: {', '.join(found.free)}; columns: "
                    f"{choices(known, name)}"
                )
            return super().__call__(*columns, **options)
        from ....figures.vibration import run_up as drawn

        column = found.free.index(name)
        values = found.position[:, column] - np.mean(found.position[:, column])
        curves = {"periodic motion": found.predicted, "averaged": found.linear}
        return drawn(
            found.mean_speed,
            values,
            unit=unit_of(found.scene, name),
            predicted={
                name: (found.predicted_speed, line[:, column]) for name, line in curves.items()
            },
            **own_options(options),
        )

    def torque(self, **options: Any) -> Figure:
        """Draw the torque that the motions absorb over speed, beside what the drive has.

        A captured drive is marked where it stays in the long run, to which short runs still creep.

        Args:
            options: `title`, `ax` (one axes) and `figsize`.
        """
        from ....figures.vibration import torque_over_speed

        found = self._result
        by, held = found.captured_by, None
        if by is not None:
            held = by.holds if np.isfinite(by.holds) else found.captured_speed
        available = found.predicted_torque - found.predicted_lack
        return torque_over_speed(
            found.predicted_speed,
            found.predicted_torque,
            available=available if found._is_driven else None,
            barriers=[(item.speed, item.torque) for item in found.barriers],
            held=held,
            **own_options(options),
        )


@dataclass(frozen=True, eq=False)
class RunUp(VibrationResult):
    """A run through a range of speed; N samples, W windows, n free coordinates.

    What is predicted are the periodic motions that a slow run follows, S of them, at speeds that
    lie closer where they change. Where a torque moves the drive they have constant mean speed, and
    the speed varies within a turn as the inertia of the drive allows.

    Attributes:
        scene: with one drive and free coordinates.
        time: `(N,)` [s].
        speed: of the drive `(N,)` [rad/s].
        position: of the free coordinates `(N, n)` [rad or m].
        window: mean speeds of the drive in each revolution, of which the last ends with the run
            `(W,)` [rad/s].
        window_time: times in the middle of them `(W,)` [s].
        envelope: half the way from peak to peak in each of them, between samples as well `(W, n)`.
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

    @property
    def captured_by(self) -> TorqueBarrier | None:
        """The resonance that holds the drive: the first above its speed that it cannot pass."""
        speed = abs(self.settled_speed) * (1.0 - _BESIDE)
        above = (item for item in self.barriers if abs(item.speed) > speed and not item.is_passed)
        return next(above, None)

    @property
    def captured_speed(self) -> float:
        """Where the drive stays since a resonance absorbs all its torque, NaN if none [rad/s]."""
        return np.nan if self.captured_by is None else self.settled_speed

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

    def table(self) -> Table:
        """Return a row for each window and coordinate; NaN beyond what is predicted."""
        order = np.argsort(self.predicted_speed)
        known, speed = self.predicted_speed[order], self.window
        predicted, linear = (
            [np.interp(speed, known, of, np.nan, np.nan) for of in values[order].T]
            for values in (self.predicted, self.linear)
        )
        return table_of(
            {
                "speed": (speed, "rad/s"),
                "coordinate": (np.array(self.free)[:, None], ""),
                "envelope": (self.envelope.T, "rad or m"),
                "predicted": (predicted, "rad or m"),
                "linear": (linear, "rad or m"),
            }
        )

    @property
    def plot(self) -> RunUpPlot:
        """Figures: `found.plot()`, a free coordinate over speed, and `plot.torque()`."""
        return RunUpPlot(self)

    def _records(self) -> Any:
        """See `VibrationResult._records`."""
        return {"barriers": ("barriers", TorqueBarrier._fields, self.barriers)}

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
    from_speed: float,
    to_speed: float,
    duration: float,
    *,
    torque: Given | None = None,
    rtol: float = 1e-8,
    max_amplitude: float = 1.0,
) -> RunUp:
    """Simulate a run through a range of speed, from the periodic motion at its beginning.

    Args:
        scene: with one drive and free coordinates.
        max_amplitude: see `periodic_motion`.
        from_speed: speed of the drive at the beginning [rad/s]; with a torque, its mean over a
            revolution.
        to_speed: its speed at the end, of the same sense. A torque need not reach it; where it
            does, the run ends there.
        duration: [s].
        torque: what moves the drive instead of a prescribed motion [N·m], beside the loads of the
            scene: a constant, a function of the drive's speed [rad/s], such as a motor's line
            `lambda speed: 0.02 * (157.0 - speed)`, or a table `(n, 2)` of speeds and torques,
            beyond whose ends is an error. Weak ones may be captured at a resonance, which then
            takes all their power.
        rtol: of the simulation.

    Raises:
        ArgumentError: a value is out of range, or the torque returns no finite number.
        VibrationError: a torque cannot turn the drive through with one of the speeds, or lets it
            come to rest.
        SimulationError: see `Scene.simulate`.
        CardanError: see `periodic_motion`.
    """
    duration = positive("duration", duration)
    first, last = number("from_speed", from_speed), number("to_speed", to_speed)
    if first * last <= 0.0 or first == last:
        raise ArgumentError(
            f"from_speed {from_speed!r} and to_speed {to_speed!r}: give two speeds of one sense"
        )
    search = search_of(scene, max_amplitude)
    given = None if torque is None else drive_torque(torque)
    with Task("run-up", 2) as task:
        run = SimulatedRun(search, first, last, given).over(duration, rtol)
        task.tell(1)
        # A weak torque may let the drive slow down first.
        lowest = (min if last > first else max)(first, np.nan_to_num(run.settled_speed, nan=first))
        curve = TorqueCurve(search, steady_path(search, float(lowest), last), given)
        found = curve.predicted()
        barriers = curve.barriers(found)
        scene = search.rotating.scene
        return RunUp(scene=scene, **run._asdict(), **found._asdict(), barriers=barriers)
