"""Results of comparisons: the errors, their tolerances, and the table of verdicts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np


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

    @property
    def passed(self) -> bool:
        """Whether every comparison passes, and there are any."""
        return bool(self) and all(comparison.passed for comparison in self)

    def __repr__(self) -> str:
        table = [self._header, *(item.cells for item in self)]
        widths = [max(map(len, column)) for column in zip(*table, strict=True)]
        lines = (
            "  ".join(text.ljust(width) for text, width in zip(line, widths, strict=True)).rstrip()
            for line in table
        )
        return "\n".join([*lines, self._verdict()])

    def _repr_html_(self) -> str:
        from ...kit.markup import element, table  # Imported here: only notebooks show it.

        rows = (item.cells for item in self)
        return f"<div>{table(self._header, rows)}{element('p', self._verdict())}</div>"

    @property
    def _header(self) -> tuple[str, ...]:
        return "scene", "quantity", "formula", "worst error", "tolerance", "verdict"

    def _verdict(self) -> str:
        told = [error <= item.tolerance for item in self for error in item.errors.values()]
        return f"{sum(told)} of {len(told)} comparisons pass."
