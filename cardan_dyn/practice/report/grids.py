"""Grids: tables of a page, whose cells are shown in few digits and copied with all of them."""

from __future__ import annotations

import base64
import csv
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from ...kit.arrays import ROUNDED
from ...kit.markup import aligned
from ...kit.quantities import amount, column, number, span

Row: TypeAlias = tuple[Any, ...]


@dataclass(frozen=True)
class Grid:
    """A table.

    Attributes:
        name: of the file as which it is copied, without suffix.
        caption: what it shows.
        header: of the columns, with units in brackets.
        rows: numbers and texts, numbers in SI units.
        unit: column with the unit of the other numbers of its row, which are shown with a prefix;
            -1 where there is none.
    """

    name: str
    caption: str
    header: tuple[str, ...]
    rows: Sequence[Row]
    unit: int = -1

    @property
    def shown(self) -> list[list[str]]:
        """The cells as texts, numbers of data with six digits, those of a row's unit with four."""
        return [self._shown(row) for row in self.rows]

    def _shown(self, row: Row) -> list[str]:
        if self.unit < 0:
            return [number(cell, 6) if isinstance(cell, float) else str(cell) for cell in row]
        numbers, unit = column((cell for cell in row if isinstance(cell, float)), row[self.unit])
        texts = iter(numbers)
        cells = [next(texts) if isinstance(cell, float) else str(cell) for cell in row]
        cells[self.unit] = unit
        return cells

    def __str__(self) -> str:
        return aligned([self.header, *self.shown], self.numeric)

    @property
    def numeric(self) -> list[bool]:
        """Whether columns hold numbers, which stand to the right."""
        return [
            any(isinstance(row[index], float | int) for row in self.rows)
            for index in range(len(self.header))
        ]

    @property
    def csv(self) -> str:
        """The table as CSV text, numbers with all of their digits."""
        buffer = io.StringIO()
        writer = csv.writer(buffer, lineterminator="\n")
        writer.writerow(self.header)
        writer.writerows(self.rows)
        return buffer.getvalue()

    @property
    def url(self) -> str:
        """Address that contains the CSV text."""
        text = base64.b64encode(self.csv.encode("utf-8")).decode("ascii")
        return f"data:text/csv;charset=utf-8;base64,{text}"


def place(value: float, slides: bool, size: float = 0.0) -> str:
    """Return a position [rad or m] in degrees or with its unit, that of the greatest beside it."""
    return amount(value, "m", size=size) if slides else way(value, value, slides)


def way(low: float, high: float, slides: bool, words: str = " … ") -> str:
    """Return from where to where positions [rad or m] go, in degrees or with their unit."""
    if slides:
        return span(low, high, "m", words)
    low, high = (0.0 if abs(end) < ROUNDED else float(np.degrees(end)) for end in (low, high))
    return span(low, high, "°", words)


def stem_of(name: str) -> str:
    """Return a name as part of the names of files."""
    return re.sub(r"[^\w-]+", "_", name)
