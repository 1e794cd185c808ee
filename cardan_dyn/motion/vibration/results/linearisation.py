"""Linearisation: the equation of small disturbances of a periodic motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ....core.results.plot import Plot, own_figure
from ....core.results.table import Table
from ....kit.arrays import Array
from ....kit.differences import displacements, slopes
from ....kit.errors import ArgumentError
from ....kit.periodic import amplitudes, orders_of
from ..model.efforts import with_drive
from ..model.modes import Modes, averaged, modes
from ..model.motion_equation import LocalEquation
from ..model.rotating_scene import speeds_of
from ..motions.harmonic_balance import Motions
from ..motions.linear import at_mean
from ..motions.residuals import residuals
from ..motions.stability import first_order, monodromy, ranked_multipliers
from .periodic_motion import refuse_missed, search_of
from .result import VibrationResult, unit_of

if TYPE_CHECKING:
    from ....figures.style import Figure
    from ....scene.scene import Scene

_UNITS = {
    "rad": ("kg·m²", "N·m·s/rad", "N·m/rad"),
    "m": ("kg", "N·s/m", "N/m"),
    "rad or m": ("SI", "SI", "SI"),
}
"""Units of mass, damping and stiffness, by that of the free coordinates."""


class LinearisationPlot(Plot):
    """Draws the coefficients of a linear equation."""

    @own_figure
    def __call__(self, *columns: Any, **options: Any) -> Figure:
        """Draw mass, damping and stiffness over the drive's position, a whole period.

        Args:
            columns: of the table instead, see `Plot`.
            options: `title`, `ax` (three axes) and `figsize`.

        Raises:
            ArgumentError: as `Plot`.
        """
        from ....figures.vibration import coefficients

        found = self._result
        names, units = ("mass", "damping", "stiffness"), _UNITS[unit_of(found.scene)]
        closed = {
            f"{name} [{unit}]": np.concatenate([getattr(found, name), getattr(found, name)[:1]])
            for name, unit in zip(names, units, strict=True)
        }
        at = np.append(found.position, found.period)
        return coefficients(at, closed, found.free, **options)


@dataclass(frozen=True, eq=False)
class Linearisation(VibrationResult):
    """M δq̈ + D δq̇ + K δq = 0 about a periodic motion, with coefficients of its period.

    Arrays are at N equidistant positions of the drive over one period; n free coordinates.

    Attributes:
        scene: whose drive turns at constant speed.
        speed: of the drive [rad/s].
        period: of the coefficients in the drive's position [rad].
        position: of the drive `(N,)` [rad].
        motion: the periodic motion `(N, n)` [rad or m].
        mass, damping, stiffness: `(N, n, n)`; the damping has the gyroscopic terms, the stiffness
            what inertia and loads add to the springs.
        forcing: `(N, n)` what acts along the free coordinates while they rest at the mean of the
            motion: inertia of what the drive moves, loads, springs [N·m, N].
        derivative_error: greatest difference of the stiffness from differences of
            efforts that sweeps find, as a fraction of the greatest stiffness.
    """

    scene: Scene
    speed: float
    period: float
    position: Array
    motion: Array
    mass: Array
    damping: Array
    stiffness: Array
    forcing: Array
    derivative_error: float

    @property
    def order(self) -> Array:
        """Orders of the Fourier coefficients `(K,)` [cycles per revolution of the drive]."""
        return orders_of((len(self.position) + 1) // 2, self.period)

    def fourier(self, name: str) -> Array:
        """Return Fourier coefficients `(K, …)`: Re Σ c exp(i order φ).

        Args:
            name: `mass`, `damping`, `stiffness`, `forcing` or `motion`.

        Raises:
            ArgumentError: another name.
        """
        names = ("mass", "damping", "stiffness", "forcing", "motion")
        if name not in names:
            raise ArgumentError(f"{name!r} has no coefficients; names: {', '.join(names)}")
        return amplitudes(getattr(self, name))

    @property
    def _equation(self) -> LocalEquation:
        """The coefficients as those of one motion, whose efforts vanish."""
        none, coefficients = np.zeros((1, 0)), (self.mass, self.damping, self.stiffness)
        mass, damping, stiffness = (item[None] for item in coefficients)
        return LocalEquation(none, none, mass, damping, stiffness, none)

    def modes(self) -> Modes:
        """Return the modes of the averaged equation, arrays with one row."""
        return modes(*averaged(self._equation))

    def monodromy(self) -> Array:
        """Return what a period makes of (δq, dδq/ds) `(2n, 2n)`, s = |φ| the way of the drive."""
        matrix = first_order(self._equation, np.array([self.speed]))
        return monodromy(matrix, self.period)[0][0]

    def multipliers(self) -> Array:
        """Return the complex Floquet multipliers `(2n,)` of a period, the greatest first."""
        return np.asarray(ranked_multipliers(self.monodromy()[None])[0])

    def table(self) -> Table:
        """Return a row for each order, with columns for the parts of each coefficient.

        `mass[a, b].real` and `mass[a, b].imag`, since no file format takes complex numbers.
        """
        columns: dict[str, Array] = {}
        for name in ("mass", "damping", "stiffness"):
            found = self.fourier(name)
            columns |= {
                f"{name}[{first}, {second}]": found[:, i, j]
                for i, first in enumerate(self.free)
                for j, second in enumerate(self.free)
            }
        found = self.fourier("forcing")
        columns |= {f"forcing[{name}]": found[:, i] for i, name in enumerate(self.free)}
        parts = {
            f"{name}.{part}": getattr(values, part)
            for name, values in columns.items()
            for part in ("real", "imag")
        }
        rows = [
            {"order": float(order), **{name: values[k] for name, values in parts.items()}}
            for k, order in enumerate(self.order)
        ]
        return Table.of_rows(rows, {"order": "1/rev", **dict.fromkeys(parts, "SI")})

    @property
    def plot(self) -> LinearisationPlot:
        """Figures: `linear.plot()`, mass, damping and stiffness over the drive's position."""
        return LinearisationPlot(self)

    def __repr__(self) -> str:
        return (
            f"<Linearisation of {', '.join(self.free)} at {self.speed:g} rad/s, derivative error "
            f"{self.derivative_error:.1e}>"
        )


def linearise(scene: Scene, speed: float, *, max_amplitude: float = 1.0) -> Linearisation:
    """Linearise the equation of motion about the periodic motion at a speed.

    Never about the drive's own uniform motion: near forced resonances that invents instabilities.
    Where several motions coexist, about the smallest.

    Args:
        scene: with one drive and free coordinates.
        speed: of the drive, a number [rad/s].
        max_amplitude: see `periodic_motion`.

    Raises:
        CardanError: see `periodic_motion`.
    """
    speeds, is_single = speeds_of(speed)
    if not is_single:
        raise ArgumentError("linearise takes one speed; vibration.campbell and floquet take many")
    search = search_of(scene, max_amplitude)
    found, _ = search.smallest(speeds)
    refuse_missed(search, speeds)
    (motions,) = found
    residuals(motions)
    model, course, equation = motions.model, motions.course, motions.equation
    return Linearisation(
        scene=search.rotating.scene,
        speed=float(speeds[0]),
        period=model.period,
        position=model.positions,
        motion=course.q[0].copy(),
        mass=equation.mass[0].copy(),
        damping=equation.damping[0].copy(),
        stiffness=equation.stiffness[0].copy(),
        forcing=-model.along(at_mean(course)).efforts[0],
        derivative_error=_derivative_error(motions, equation.stiffness[0]),
    )


def _derivative_error(motions: Motions, stiffness: Array) -> float:
    """Return how far a stiffness `(N, n, n)` is from differences of efforts by sweeps."""
    model, course = motions.model, motions.course
    place = with_drive(model.positions, course.q[0])
    moves = course.velocities[0], course.accelerations[0]
    beside = with_drive(np.zeros(1), displacements(model.units))
    efforts = np.array([model.efforts(place + way, *moves)[:, 1:] for way in beside])
    scale = float(np.max(np.abs(stiffness)))
    gap = slopes(efforts, model.units) - stiffness
    return float(np.max(np.abs(gap)) / scale) if scale else 0.0
