"""Periodic motion: what the free coordinates do while a drive turns at constant speed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ....core.results.plot import Plot, own_figure, own_options
from ....core.results.table import Table
from ....kit.arrays import ROUNDED, Array
from ....kit.checks import positive, several, whole
from ....kit.errors import ArgumentError, VibrationError
from ....kit.periodic import amplitudes, orders_of
from ..model.efforts import with_drive
from ..model.rotating_scene import all_driven, rotating_scene, speeds_of
from ..motions.harmonic_balance import Motions, swings
from ..motions.residuals import residuals
from ..motions.search import MotionSearch
from .result import VibrationResult, table_of, unit_of

if TYPE_CHECKING:
    from ....core.results.sweep import Sweep
    from ....figures.style import Figure
    from ....scene.scene import Scene


class States(NamedTuple):
    """Positions `(R, P, n)` of the free coordinates, and their rates by time."""

    position: Array
    velocity: Array
    acceleration: Array

    def with_drive(self, position: Array, speed: Array) -> States:
        """Return the same, `(R, P, 1 + n)`, behind the drive.

        Args:
            position: of the drive `(P,)` [rad].
            speed: of the drive `(R,)` [rad/s].
        """
        drive = position, speed[:, None], np.zeros(1)
        return States(*map(with_drive, drive, self))


def states(order: Array, amplitude: Array, speed: Array, position: Array) -> States:
    """Return the states that complex amplitudes stand for: q = Re Σ amplitude exp(i order φ).

    Args:
        order: `(K,)` cycles per revolution of the drive.
        amplitude: `(R, K, n)` [rad or m].
        speed: of the drive `(R,)` [rad/s].
        position: φ of the drive `(P,)` [rad].
    """
    waves = np.exp(1j * np.outer(position, order))
    rate = 1j * order[:, None] * speed[:, None, None]
    return States(*((waves @ (rate**power * amplitude)).real for power in range(3)))


class PeriodicMotionPlot(Plot):
    """Draws periodic motions."""

    @own_figure
    def __call__(self, *columns: Any, row: int = 0, **options: Any) -> Figure:
        """Draw the free coordinates of a motion over a revolution.

        Args:
            columns: of the table instead, see `Plot`.
            row: which of the motions.
            options: `title`, `ax` (one axes) and `figsize`.

        Raises:
            ArgumentError: no such row, or as `Plot`.
        """
        from ....figures.vibration import over_revolution

        found = self._result
        position = np.linspace(0.0, 2.0 * np.pi, 721)
        values = found.at(position).position[found._row(row)]
        return over_revolution(position, values, found.free, unit=unit_of(found.scene), **options)

    def orbit(self, first: str = "", second: str = "", *, row: int = 0, **options: Any) -> Figure:
        """Draw the path of two free coordinates of a motion; a dot marks where it begins.

        Args:
            first: coordinate along the abscissa, the first free one if empty.
            second: coordinate along the ordinate, the next one if empty.
            row: which of the motions.
            options: `title`, `ax` (one axes) and `figsize`.

        Raises:
            ArgumentError: no such row, or one is not free.
        """
        from ....figures.vibration import orbits

        found = self._result
        first = first or found.free[0]
        second = second or next((name for name in found.free if name != first), first)
        path = found.orbit(first, second, row)
        across, up = (f"{name} [{unit_of(found.scene, name)}]" for name in (first, second))
        speed = f"{found.speed[row]:.6g} rad/s"
        return orbits({speed: path}, labels=(across, up), **own_options(options))


@dataclass(frozen=True, eq=False)
class PeriodicMotion(VibrationResult):
    """Periodic motions of the free coordinates, a row for each; R rows, n free coordinates.

    A row's motion repeats with `period`. Rows are in the order of the speeds that were asked for;
    where several motions coexist, they follow each other, the smallest first. All have the period
    of the equation: subharmonic ones are not looked for.

    A simulation goes on from a motion if the drive starts where the motion is looked at: with
    `at(0.0)`, `position={drive: 0.0, free: …}`, since loops find a place for drives left out.

    Attributes:
        scene: whose drive turns at constant speed.
        speed: `(R,)` of the drive [rad/s].
        branch: `(R,)` number of the motion at its speed, from 0.
        period: of the motion in the drive's position [rad].
        order: `(K,)` cycles per revolution of the drive.
        amplitude: complex `(R, K, n)`: q = Re Σ amplitude exp(i order φ), φ the drive's position
            [rad or m].
        residual: `(R,)` greatest effort that is left along a free coordinate, at the nodes of the
            motion and between them, by inverse dynamics; as a fraction of the greatest sum of the
            sizes of its terms.
        index: `(R,)` sign of the determinant of the equation's Jacobian. Motions appear and vanish
            in pairs of opposite signs, so that the sum over all of a speed is +1 unless one was
            missed, or lies beyond what was searched.
        missed: speeds without a motion to the reason.
    """

    scene: Scene
    speed: Array
    branch: Array
    period: float
    order: Array
    amplitude: Array
    residual: Array
    index: Array
    missed: Mapping[float, str] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.speed)

    @property
    def incomplete(self) -> Array:
        """Speeds `(K,)` at which further motions exist that were not found [rad/s].

        They are farther than `max_amplitude`, or the search has missed them, as the sum of `index`
        tells.
        """
        speeds = np.unique(self.speed)
        sums = [int(np.sum(self.index[self.speed == speed])) for speed in speeds]
        return np.asarray(speeds[np.array(sums) != 1])

    def at(self, position: Any) -> States:
        """Return the motions at positions `(P,)` of the drive [rad].

        Raises:
            ArgumentError: the positions are no finite numbers, or of another shape.
        """
        return states(self.order, self.amplitude, self.speed, several("position", position))

    def sweep(self, row: int = 0, position: Any = None, *, scene: Scene | None = None) -> Sweep:
        """Return the scene along a motion, with its wrenches and residuals.

        Args:
            row: of the motion.
            position: of the drive `(P,)` [rad]; one revolution in steps that resolve the motion
                if None.
            scene: the same with other outputs, if wanted.

        Raises:
            ArgumentError: no such row, or positions that are no numbers.
            CardanError: as `Scene.sweep`.
        """
        row = self._row(row)
        if position is None:
            count = 2 * int(np.ceil(self.order[-1])) + 32
            position = 2.0 * np.pi / count * np.arange(count)
        places = several("position", position)
        every = [item[row] for item in self.at(places).with_drive(places, self.speed)]
        return all_driven(scene or self.scene).sweep(*every)

    def orbit(self, first: str, second: str, row: int = 0, count: int = 361) -> Array:
        """Return the path `(count, 2)` of two free coordinates over a revolution [rad or m].

        Args:
            first: name of the coordinate in the first column.
            second: of that in the second.
            row: of the motion.
            count: number of points, of which the last is the first.

        `figures.orbits` draws it.

        Raises:
            ArgumentError: one is not free, no such row, or no count.
        """
        row, count = self._row(row), whole("count", count, 2)
        for name in (first, second):
            if name not in self.free:
                raise ArgumentError(f"{name!r} is not free; free: {', '.join(self.free)}")
        q = self.at(np.linspace(0.0, 2.0 * np.pi, count)).position[row]
        return q[:, [self.free.index(first), self.free.index(second)]]

    def _row(self, row: int) -> int:
        """Return the number of a motion."""
        number = whole("row", row, 0)
        if number >= len(self):
            raise ArgumentError(f"row {number} does not exist; motions: 0 to {len(self) - 1}")
        return number

    def table(self) -> Table:
        """Return a row for each motion, coordinate and order, of amplitudes above rounding."""
        waves = np.swapaxes(self.amplitude, 1, 2)
        sizes = np.abs(waves)
        columns = {
            "speed": (self.speed[:, None, None], "rad/s"),
            "branch": (self.branch[:, None, None], "1"),
            "coordinate": (np.array(self.free)[:, None], ""),
            "order": (self.order, "1/rev"),
            "amplitude": (sizes, "rad or m"),
            "phase": (np.angle(waves), "rad"),
            "residual": (self.residual[:, None, None], "1"),
        }
        return table_of(columns, sizes > ROUNDED * np.max(sizes, axis=(1, 2), keepdims=True))

    @property
    def plot(self) -> PeriodicMotionPlot:
        """Figures: `found.plot()`, free coordinates over a revolution, and `plot.orbit()`."""
        return PeriodicMotionPlot(self)

    def __repr__(self) -> str:
        more = self.incomplete
        missing = f"; others exist at {len(more)} of them that were not found" if more.size else ""
        count = len(set(self.speed.tolist())) + len(self.missed)
        return (
            f"<PeriodicMotion of {', '.join(self.free)}: {len(self)} motions at "
            f"{count} speeds{self._without(len(self.missed))}{missing}, residual "
            f"{np.max(self.residual):.1e}>"
        )


def periodic_motion(scene: Scene, speed: Any, *, max_amplitude: float = 1.0) -> PeriodicMotion:
    """Find the periodic motions of a scene whose drive turns at constant speed.

    They are non-linear: Fourier sums whose efforts along the free coordinates vanish, found by the
    exact derivatives of these efforts and held against sweeps.
    Where a motion is not that of the linear equation, as near forced resonances, further ones are
    found along branches of motions through speed, which turn back at folds and cross each other.

    Args:
        scene: with one drive and free coordinates, springs and dampers among the elements.
        speed: of the drive, a number or `(S,)` [rad/s].
        max_amplitude: farthest that motions go from their mean [rad, or characteristic lengths].

    Raises:
        VibrationError: no motion was found at any of the speeds.
        ArgumentError, MobilityError, ModelError: the scene has none, see `rotating_scene`.
        AccuracyError: the efforts are not smooth, or a motion does not hold.
        CardanError: as `Scene.sweep`.
    """
    search = search_of(scene, max_amplitude)
    speeds, _ = speeds_of(speed)
    every = search.every(speeds)
    refuse_missed(search, speeds)
    return _collected(search, speeds, every)


def search_of(scene: Scene, max_amplitude: float) -> MotionSearch:
    """Return the search for motions of a scene, by the arguments of `periodic_motion`.

    Raises:
        CardanError: see `rotating_scene`.
        ArgumentError: `max_amplitude` is no positive number.
    """
    return MotionSearch(rotating_scene(scene), positive("max_amplitude", max_amplitude))


def refuse_missed(search: MotionSearch, speeds: Array) -> None:
    """Refuse if no speed has a motion.

    Raises:
        VibrationError: that is so.
    """
    if len(search.missed) == len(speeds):
        raise VibrationError(
            f"{next(iter(search.missed.values()))}; a greater max_amplitude= looks farther, and "
            "more damping makes motions smaller",
            speed=float(speeds[0]),
        )


def missed_of(search: MotionSearch, speeds: Array) -> dict[float, str]:
    """Return the speeds at which a search found no motion, to the reason."""
    return {float(speeds[item]): reason for item, reason in search.missed.items()}


def _collected(search: MotionSearch, speeds: Array, every: list[Motions]) -> PeriodicMotion:
    """Return all motions as rows."""
    spectra = [amplitudes(motions.course.q, 1) for motions in every]
    count = max(waves.shape[1] for waves in spectra)
    wide = [np.pad(of, ((0, 0), (0, count - of.shape[1]), (0, 0))) for of in spectra]
    amplitude, place, size, residual, sign = (
        np.concatenate(parts)
        for parts in (
            wide,
            [motions.index for motions in every],
            [swings(motions.course.q, motions.model.units) for motions in every],
            [residuals(motions) for motions in every],
            [motions.sign for motions in every],
        )
    )
    rows = np.lexsort((size, place))
    places, period = place[rows], every[0].model.period
    return PeriodicMotion(
        scene=search.rotating.scene,
        speed=speeds[places],
        branch=np.arange(len(rows)) - np.searchsorted(places, places),
        period=period,
        order=orders_of(count, period),
        amplitude=amplitude[rows],
        residual=residual[rows],
        index=sign[rows].astype(int),
        missed=missed_of(search, speeds),
    )
