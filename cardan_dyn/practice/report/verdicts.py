"""Results of comparisons: the errors, their tolerances, and the table of verdicts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np


@dataclass(frozen=True)
class Comparison:
    """One quantity of one scene against its closed form.

    Attributes:
        scene: what was computed.
        quantity: what is compared, with its symbol.
        source: author and formula.
        beta_deg: joint angle [deg].
        error: greatest deviation over the revolution, relative to the greatest value [–].
        tolerance: greatest error that passes [–].
    """

    scene: str
    quantity: str
    source: str
    beta_deg: float
    error: float
    tolerance: float

    @property
    def passed(self) -> bool:
        """Whether the error is within the tolerance; NaN is not."""
        return bool(self.error <= self.tolerance)


class Row(NamedTuple):
    """One quantity of one scene at all joint angles.

    Attributes:
        scene, quantity, source, tolerance: see `Comparison`.
        errors: at each joint angle, in the order of the comparisons.
        worst: the greatest of them; NaN if one of them is.
        passed: whether all of them are within the tolerance.
    """

    scene: str
    quantity: str
    source: str
    errors: tuple[float, ...]
    worst: float
    tolerance: float
    passed: bool


class Comparisons(tuple[Comparison, ...]):
    """Comparisons in the order in which they were made; a notebook shows them as a table."""

    __slots__ = ()

    def __getitem__(self, index: Any) -> Any:
        found = super().__getitem__(index)
        return Comparisons(found) if isinstance(index, slice) else found

    @property
    def passed(self) -> bool:
        """Whether every comparison passes, and there are any."""
        return bool(self) and all(comparison.passed for comparison in self)

    def rows(self) -> list[Row]:
        """Return one row per quantity of each scene, scenes in the order of their first one."""
        grouped: dict[str, dict[tuple[str, str], list[Comparison]]] = {}
        for item in self:
            quantities = grouped.setdefault(item.scene, {})
            quantities.setdefault((item.quantity, item.source), []).append(item)
        return [
            Row(
                scene=scene,
                quantity=quantity,
                source=source,
                errors=tuple(item.error for item in items),
                worst=float(np.max([item.error for item in items])),
                tolerance=items[0].tolerance,
                passed=all(item.passed for item in items),
            )
            for scene, quantities in grouped.items()
            for (quantity, source), items in quantities.items()
        ]

    def __repr__(self) -> str:
        table = [self._header, *map(_texts, self.rows())]
        widths = [max(map(len, column)) for column in zip(*table, strict=True)]
        lines = (
            "  ".join(text.ljust(width) for text, width in zip(line, widths, strict=True)).rstrip()
            for line in table
        )
        return "\n".join([*lines, self._verdict()])

    def _repr_html_(self) -> str:
        from ...kit.markup import element, table  # Imported here: only notebooks show it.

        rows = (_texts(row) for row in self.rows())
        return f"<div>{table(self._header, rows)}{element('p', self._verdict())}</div>"

    @property
    def _header(self) -> tuple[str, ...]:
        return "scene", "quantity", "formula", "worst error", "tolerance", "verdict"

    def _verdict(self) -> str:
        failed = sum(not comparison.passed for comparison in self)
        return f"{len(self) - failed} of {len(self)} comparisons pass."


def _texts(row: Row) -> tuple[str, ...]:
    """Return the cells of a row of the table."""
    verdict = "pass" if row.passed else "FAIL"
    return (
        *(row.scene, row.quantity, row.source),
        *(f"{row.worst:.1e}", f"{row.tolerance:.0e}", verdict),
    )
