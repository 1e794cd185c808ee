"""Results of comparisons: the errors, their tolerances, and the table of verdicts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...kit.markup import aligned, element, table


@dataclass(frozen=True)
class Comparison:
    """One quantity of one scene against its closed form.

    Attributes:
        scene: what was computed.
        quantity: what is compared, with its symbol.
        source: author and formula.
        tolerance: greatest error that passes [–].
        errors: joint angle [deg] to the greatest deviation over the revolution, relative to the
            greatest value [–].
    """

    scene: str
    quantity: str
    source: str
    tolerance: float
    errors: Mapping[float, float]

    @property
    def worst(self) -> float:
        """The greatest of the errors; NaN if one of them is."""
        return float(np.max(list(self.errors.values())))

    @property
    def passed(self) -> bool:
        """Whether the errors are within the tolerance; NaN is not."""
        return self.worst <= self.tolerance

    @property
    def cells(self) -> tuple[str, ...]:
        """Its row of the table."""
        verdict = "pass" if self.passed else "FAIL"
        numbers = f"{self.worst:.1e}", f"{self.tolerance:.0e}"
        return self.scene, self.quantity, self.source, *numbers, verdict


class Comparisons(tuple[Comparison, ...]):
    """Comparisons in the order in which they were made; a notebook shows them as a table."""

    __slots__ = ()
    header = "scene", "quantity", "formula", "worst error", "tolerance", "verdict"

    @property
    def passed(self) -> bool:
        """Whether every comparison passes, and there are any."""
        return bool(self) and all(comparison.passed for comparison in self)

    def __repr__(self) -> str:
        return "\n".join([aligned([self.header, *(item.cells for item in self)]), self._verdict()])

    def _repr_html_(self) -> str:
        rows = (item.cells for item in self)
        return f"<div>{table(self.header, rows)}{element('p', self._verdict())}</div>"

    def _verdict(self) -> str:
        told = [error <= item.tolerance for item in self for error in item.errors.values()]
        return f"{sum(told)} of {len(told)} comparisons pass."
