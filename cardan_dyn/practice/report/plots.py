"""Plots: what reports draw of themselves."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ...core.results.plot import Plot
from ...kit.errors import ArgumentError, choices

if TYPE_CHECKING:
    from ...figures.style import Figure
    from .extremes import Extreme


class ReportPlot(Plot):
    """Draws what joints carry in each case: `reports.plot()`, or `reports.plot("boom_pin")`."""

    def __call__(self, *columns: Any, **options: Any) -> Figure:
        """Draw quantities, axes for each, and a line for each load case.

        What they are drawn over is what the cases have in common: the only drive, or else the row
        of their task that turns back least, or else the number of the sample. A star marks what
        statics leaves open.

        Args:
            columns: joints, drives, couplings or elements, or quantities of them such as
                `boom_pin.shear` and `lift.drive_effort`; what joints are sized by, as on the page,
                if there is none. Six quantities are drawn at most.
            options: `x` (a coordinate, or a row of the task, to be drawn over instead), `title`,
                `ax` (one for each quantity) and `figsize`.

        Raises:
            MissingExtraError: matplotlib is not installed.
            ArgumentError: nothing of this name acts, nothing is driven, or other axes than are
                needed.
        """
        cases = self._result.cases
        if not all(report.drives for report in cases.reports):
            raise ArgumentError("no figure over what moves: a case drives nothing")
        known: dict[str, Extreme] = {}
        for report in cases.reports:
            for item in report.told:
                known.setdefault(f"{item.owner}.{item.quantity.replace(' ', '_')}", item)
        told = [item for _, item in cases.governing]
        if columns:
            told = []
            for name in columns:
                found = [item for key, item in known.items() if name in (key, item.owner)]
                if not found:
                    owners = dict.fromkeys(item.owner for item in known.values())
                    raise ArgumentError(
                        f"nothing acts in {name!r}; joints, drives, couplings and elements: "
                        f"{choices(owners, name)}; quantities: {choices(known, name)}"
                    )
                told += [item for item in found if item not in told]
        if not told:
            raise ArgumentError(
                "nothing acts that statics determines: name what is drawn"
                if known
                else "nothing acts: there is nothing to be drawn"
            )
        from .courses import courses  # Imported here: it needs matplotlib.

        return courses(cases, told, **options)
