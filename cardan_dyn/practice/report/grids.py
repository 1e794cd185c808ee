"""Grids: tables of a page, whose cells are shown in few digits and copied with all of them."""

from __future__ import annotations

import base64
import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...kit.arrays import ROUNDED


@dataclass(frozen=True)
class Grid:
    """A table.

    Attributes:
        name: of the file as which it is copied, without suffix.
        caption: what it shows.
        header: of the columns, with units in brackets.
        rows: numbers and texts.
    """

    name: str
    caption: str
    header: tuple[str, ...]
    rows: Sequence[tuple[Any, ...]]

    @property
    def shown(self) -> list[list[str]]:
        """The cells as texts, numbers with six digits."""
        return [[text_of(cell) for cell in row] for row in self.rows]

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


def text_of(cell: object) -> str:
    """Return a cell as text, numbers with six digits."""
    if isinstance(cell, float):
        return number(cell)
    return str(cell)


def number(value: float, digits: int = 6) -> str:
    """Return a number with some digits; zero has no sign."""
    return f"{value + 0.0:.{digits}g}" if np.isfinite(value) else "–"


def place(value: float, slides: bool) -> str:
    """Return a position [rad or m] in degrees or millimetres, with its unit."""
    if slides:
        return f"{round(1e3 * value, 4) + 0.0:.7g} mm"
    degrees = 0.0 if abs(value) < ROUNDED else float(np.degrees(value))
    return f"{round(degrees, 3) + 0.0:.7g}°"


def stem_of(name: str) -> str:
    """Return a name as part of the names of files."""
    return "".join(letter if letter.isalnum() or letter in "-_" else "_" for letter in name)
