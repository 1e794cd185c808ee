"""Campbell: natural frequencies and modes over the speed of the drive."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from ....core.results.plot import Plot, own_figure
from ....core.results.table import Table
from ....kit.arrays import Array
from ....kit.checks import positives
from ..model.modes import Modes, averaged, clear_senses, modes, sense_name
from ..model.rotating_scene import speeds_of
from ..motions.harmonic_balance import Motions
from ..motions.residuals import refuse_unheld
from ..motions.search import MotionSearch
from .periodic_motion import refuse_missed, search_of
from .result import VibrationResult, table_of

if TYPE_CHECKING:
    from ....figures.style import Figure
    from ....scene.scene import Scene


class CampbellPlot(Plot):
    """Draws natural frequencies over speed."""

    @own_figure
    def __call__(
        self, *columns: Any, orders: Any = (1, 2, 4), critical: Any = None, **options: Any
    ) -> Figure:
        """Draw natural frequencies over speed, with the lines of orders, or columns of the table.

        Args:
            columns: see `Plot`, for all options of columns.
            orders: cycles per revolution of the drive, one or several.
            critical: speeds and frequencies `(C, 2)` that are marked [rad/s].
            options: `title`, `ax` (one axes) and `figsize`.

        Raises:
            ArgumentError: orders are no numbers, or as `Plot`.
        """
        from ....figures.critical_speeds import campbell

        found = self._result
        return campbell(
            found.speed,
            found.frequency,
            orders=orders,
            whirl=clear_senses(found.whirl),
            critical=critical,
            **options,
        )


@dataclass(frozen=True, eq=False)
class Campbell(VibrationResult):
    """Modes of the averaged equation about the periodic motion, S speeds, n modes.

    A mode keeps its column from speed to speed. Speeds without a periodic motion have NaN.

    Attributes:
        scene: whose drive turns at constant speed.
        speed: of the drive `(S,)` [rad/s].
        frequency: damped natural angular frequencies `(S, n)` [rad/s]; 0 where a mode creeps.
        decay: real parts of the eigenvalues `(S, n)` [1/s], negative where modes decay.
        log_decrement: `(S, n)`; NaN where a mode creeps.
        amplification: amplification factor 1/(2ζ) `(S, n)`, infinite without damping; NaN where a
            mode creeps.
        shape: complex mode shapes `(S, n, n)`: of coordinates, by modes.
        whirl: `(S, n)` from -1, backward, to +1, forward; about 0 where a mode swings in a plane.
    """

    scene: Scene
    speed: Array
    frequency: Array
    decay: Array
    log_decrement: Array
    amplification: Array
    shape: Array
    whirl: Array

    def separation_margin(self, orders: Any = (1, 2, 4)) -> Array:
        """Return the distance `(S, n)` of each mode from the nearest order, as a fraction of it.

        Args:
            orders: cycles per revolution of the drive that excite, a number or `(K,)`.

        Raises:
            ArgumentError: an order is no positive number.
        """
        lines = np.abs(self.speed)[:, None] * positives("orders", orders)
        gaps = np.abs(self.frequency[:, :, None] - lines[:, None, :]) / lines[:, None, :]
        return np.asarray(np.min(gaps, axis=2))

    @property
    def there(self) -> Array:
        """Places among the speeds at which there is a motion."""
        return np.nonzero(np.isfinite(self.decay[:, 0]))[0]

    def at(self, row: int) -> tuple[Array, Array]:
        """Return eigenvalues `(n,)` [1/s] and mode shapes `(n, n)` at one of the speeds."""
        return self.decay[row] + 1j * self.frequency[row], self.shape[row]

    def table(self) -> Table:
        """Return a row for each speed and mode, which are counted from 1 as in figures."""
        names = [sense_name(sense) for sense in self.whirl.ravel().tolist()]
        return table_of(
            {
                "speed": (self.speed[:, None], "rad/s"),
                "mode": (1 + np.arange(self.whirl.shape[1]), ""),
                "frequency": (self.frequency, "rad/s"),
                "decay": (self.decay, "1/s"),
                "log_decrement": (self.log_decrement, "1"),
                "amplification": (self.amplification, "1"),
                "whirl": (np.reshape(names, self.whirl.shape), ""),
            }
        )

    def renumbered(self, order: Array) -> Campbell:
        """Return the same with its modes in another order `(n,)`."""
        columns = ("frequency", "decay", "log_decrement", "amplification", "shape", "whirl")
        return replace(self, **{name: getattr(self, name)[..., order] for name in columns})

    @property
    def plot(self) -> CampbellPlot:
        """Figures: `campbell.plot()`, natural frequencies over speed with the lines of orders."""
        return CampbellPlot(self)

    def __repr__(self) -> str:
        missed = self._without(len(self.speed) - len(self.there))
        return f"<Campbell of {', '.join(self.free)} at {len(self.speed)} speeds{missed}>"


def campbell(scene: Scene, speed: Any, *, max_amplitude: float = 1.0) -> Campbell:
    """Return natural frequencies and modes over speed.

    Args:
        scene: with one drive and free coordinates.
        speed: of the drive, a number or `(S,)` [rad/s].
        max_amplitude: see `periodic_motion`.

    Raises:
        CardanError: see `periodic_motion`.
    """
    speeds, _ = speeds_of(speed)
    return campbell_of(search_of(scene, max_amplitude), speeds)


def campbell_of(search: MotionSearch, speeds: Array) -> Campbell:
    """Return the modes about the motions that a search finds at speeds `(S,)`; see `campbell`."""
    every_motion, _ = search.smallest(speeds)
    refuse_missed(search, speeds)
    refuse_unheld(every_motion)
    return modes_about(search, speeds, every_motion)


def resting_campbell(search: MotionSearch, speeds: Array) -> Campbell:
    """Return the modes about coordinates at rest, as `resting_motions`, at speeds `(S,)`."""
    return modes_about(search, speeds, search.resting(speeds))


def modes_about(search: MotionSearch, speeds: Array, every_motion: list[Motions]) -> Campbell:
    """Return the modes about motions at speeds `(S,)`."""
    free = len(search.rotating.free)
    shape = (len(speeds), free)
    missing = complex(np.nan, np.nan)
    value, shapes = np.full(shape, missing), np.full((*shape, free), missing)
    whirl = np.full(shape, np.nan)
    for motions in every_motion:
        equation, index = motions.equation, motions.index
        found = modes(*averaged(equation))
        value[index], shapes[index] = found.value, found.shape
        middle = np.mean(motions.course.q[0], axis=0)
        for turns in np.unique(np.sign(speeds[index])).tolist():
            sense, rows = search.whirl(middle, turns), index[np.sign(speeds[index]) == turns]
            for row in rows.tolist():
                shapes[row] = sense.parted(value[row], shapes[row])
            whirl[rows] = sense.of(shapes[rows])
    # Speeds without a motion stand between those that continue each other.
    for before, row in pairwise(np.nonzero(np.isfinite(value[:, 0]))[0].tolist()):
        order = followed(value[before], shapes[before], value[row], shapes[row])
        value[row], shapes[row], whirl[row] = (
            value[row, order],
            shapes[row][:, order],
            whirl[row, order],
        )
    every = Modes(value, shapes)
    return Campbell(
        scene=search.rotating.scene,
        speed=speeds,
        frequency=every.frequency.copy(),
        decay=value.real.copy(),
        log_decrement=every.log_decrement,
        amplification=every.amplification,
        shape=shapes,
        whirl=whirl,
    )


def followed(value_before: Array, before: Array, value: Array, shapes: Array) -> Array:
    """Return the order `(n,)` in which modes continue those of the speed before."""
    from scipy.optimize import linear_sum_assignment  # Few scripts need it.

    sizes = np.linalg.norm(before, axis=0)[:, None] * np.linalg.norm(shapes, axis=0)
    likeness = np.abs(before.conj().T @ shapes) / sizes
    spread = float(np.max(np.abs(value))) or 1.0
    likeness -= np.abs(value_before[:, None] - value) / spread
    return np.asarray(linear_sum_assignment(-likeness)[1])
