"""Plots: what results with clearance draw of themselves.

The figures know the results, so these do not know their figures: `results.plot.draws` joins them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ...core.results.plot import Plot, draws, own_figure, own_options
from ...kit.errors import ArgumentError
from . import drawing
from .contact_simulation import ContactSimulation, JointContact
from .influences import PARAMETERS, Influence
from .scan_maps import ScanMap
from .scan_results import JointScan, Scan, ScanComparison

if TYPE_CHECKING:
    from ...figures.style import Figure


@draws(Scan)
class ScanPlot(Plot):
    """Draws a scan: `scan.plot()`, its ranking."""

    @own_figure
    def __call__(self, *columns: Any, **options: Any) -> Figure:
        """Draw joints by their peaks, and what would make these milder.

        Args:
            columns: of the table of reversals instead, see `Plot`.
            options: of `drawing.impact_ranking`.

        Raises:
            ArgumentError: no joint was scanned, or as `Plot`.
        """
        return drawing.impact_ranking(self._result, **options)

    def reversals(self, joints: str | Sequence[str] | None = None, **options: Any) -> Figure:
        """Draw where forces swing round, see `drawing.force_reversals`."""
        return drawing.force_reversals(self._result, joints, **options)

    def peak_factor(self, **options: Any) -> Figure:
        """Draw where the worst reversals are on f(τ), see `drawing.peak_factor`."""
        return drawing.peak_factor(self._result, **options)

    def influence(self, parameters: str | Sequence[str] = (), **options: Any) -> Figure:
        """Draw two-mass peaks of the worst reversals, see `drawing.peak_influence`.

        Args:
            parameters: all if there is none; the speed only where inertia alone acts.
            options: of `drawing.peak_influence`.

        Raises:
            ArgumentError: no force swings round, or as there.
        """
        worst = self._result.worst
        if not worst:
            raise ArgumentError("no force swings round, so that there is no peak to be drawn")
        inertial = all(item.slope_growth == 3.0 for item in worst.values())
        return drawing.peak_influence(worst, parameters or PARAMETERS[not inertial :], **options)


@draws(JointScan)
@draws(ScanMap)
class ScannedPlot(Plot):
    """Draws a scanned joint, its forces and peaks; and one over speeds and designs, its peaks."""

    @own_figure
    def __call__(self, *columns: Any, **options: Any) -> Figure:
        """Draw `drawing.pin_forces` of a joint, `drawing.pin_peaks` of a map.

        Args:
            columns: of the table instead, see `Plot`.
            options: of the figure.

        Raises:
            ArgumentError: a map has one speed only, or as `Plot`.
        """
        is_map = isinstance(self._result, ScanMap)
        return (drawing.pin_peaks if is_map else drawing.pin_forces)(self._result, **options)


@draws(ContactSimulation)
class ContactPlot(Plot):
    """Draws a simulation with clearance: `simulation.plot("pin")`, the force in a joint."""

    def __call__(
        self, *columns: Any, scanned: Scan | None = None, turns: float = 1.0, **options: Any
    ) -> Figure:
        """Draw the force by which the wall presses a pin over the drive's position.

        Args:
            columns: name of a joint with clearance or of one of its bearings, the one with the
                greatest peak if there is none; or columns of the table of impacts, see `Plot`.
            scanned: see `drawing.contact_course`.
            turns: likewise.
            options: of `drawing.contact_course`.

        Raises:
            ArgumentError: as there, or as `Plot`.
        """
        simulation = self._result
        if columns and (len(columns) > 1 or columns[0] not in simulation):
            return super().__call__(*columns, **options)
        joint = columns[0] if columns else self._hardest()
        return drawing.contact_course(
            simulation,
            joint,
            scanned=scanned,
            turns=turns,
            **own_options(options, "scanned", "turns"),
        )

    def orbit(self, joint: str = "", **options: Any) -> Figure:
        """Draw the orbit of a pin in its bush, see `drawing.pin_orbit`.

        Args:
            joint: with clearance, or one of its bearings; that with the greatest peak if empty.
            options: of `drawing.pin_orbit`.
        """
        return drawing.pin_orbit(self._result, joint or self._hardest(), **options)

    def _hardest(self) -> str:
        """Return the bearing with the greatest peak, the first one without any impact."""
        peaks = dict.fromkeys(self._result, 0.0)
        for item in self._result.impacts:
            peaks[item.bearing] = max(peaks[item.bearing], item.peak)
        return max(peaks, key=lambda name: peaks[name])


@draws(JointContact)
@draws(Influence)
class CoursePlot(Plot):
    """Draws what a pin did, over time, or the peak of an impact over the factor on a parameter."""

    @property
    def first(self) -> tuple[str, ...]:  # type: ignore[override]
        """The force of the wall; the peak."""
        return ("peak",) if isinstance(self._result, Influence) else ("force",)


@draws(ScanComparison)
class ScanComparisonPlot(Plot):
    """Draws estimates beside simulations: both over the position of the reversals."""

    first = ("estimate", "simulated", "rigid")

    def __call__(self, *columns: Any, **options: Any) -> Figure:
        """Draw estimated and simulated forces, and those without clearance, as points.

        Args:
            columns: of the table instead, see `Plot`, for all options.
            options: likewise.

        Raises:
            ArgumentError: as `Plot`.
        """
        return super().__call__(
            *columns, **{"x": "position", "linestyle": "none", "marker": "o", **options}
        )
