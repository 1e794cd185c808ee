"""Verdict: a drive line held against the rules of practice, row by row."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from cardan_dyn.analytic.limits import Limit
from cardan_dyn.analytic.rules import RULES

from ....kit.errors import MissingExtraError
from ....kit.markup import table
from ..line.files import units_of
from .angle_rules import angle_rules
from .case import Case
from .force_rules import force_rules
from .rating_rules import rating_rules
from .rows import FAIL, HEADINGS, OPEN, PASS, STATED, VerdictRow
from .shaft_rules import shaft_rules

if TYPE_CHECKING:
    from collections.abc import Callable

    import pandas

    from ....figures.style import Figure
    from ..line.data import LineData
    from .analysis import Analysis
    from .solving import LineSolver

_NARROW = ("where", "quantity", "value", "by the rule", "limit", "margin", "verdict")
"""Columns of the plain text."""


@dataclass(frozen=True)
class Verdict:
    """What the rules of practice say of a drive line; iterate over its rows.

    Attributes:
        line: its name.
        rows: a row per rule and place, in the order of `analytic.rules.RULES`.
        units: in which it is printed and drawn, `si` or `imperial`: those of most data of the line.
    """

    line: str
    rows: tuple[VerdictRow, ...]
    units: str = "si"

    @property
    def passed(self) -> bool:
        """Whether no row fails and none is open."""
        return not self.failed and not self.open

    @property
    def failed(self) -> tuple[VerdictRow, ...]:
        """Rows that miss their limits, the worst margin first."""
        found = [row for row in self.rows if row.status == FAIL]
        return tuple(sorted(found, key=lambda row: row.margin if row.margin is not None else 0.0))

    @property
    def open(self) -> tuple[VerdictRow, ...]:
        """Rows whose rules apply and cannot be judged; their notes say why, and what to give."""
        return tuple(row for row in self.rows if row.status == OPEN)

    @property
    def summary(self) -> str:
        """Outcome and counts of rows, such as `passed, 3 rows open: 20 pass, 0 fail, …`."""
        counts = self.counts
        told = "failed" if counts[FAIL] else "passed"
        if counts[OPEN]:
            told += f", {counts[OPEN]} row{'s' * (counts[OPEN] > 1)} open"
        return f"{told}: " + ", ".join(f"{count} {status}" for status, count in counts.items())

    @property
    def counts(self) -> dict[str, int]:
        """How many rows pass, fail, are open and are stated, by these words."""
        return {
            status: sum(row.status == status for row in self.rows)
            for status in (PASS, FAIL, OPEN, STATED)
        }

    def plot(
        self, *, title: str = "", ax: Any = None, figsize: tuple[float, float] | None = None
    ) -> Figure:
        """Draw how much room values have to their limits, the least on top.

        Args:
            title: of the figure; the name of the line and the counts of its rows unless given.
            ax: axes to be drawn into instead of a new figure.
            figsize: width and height of a new figure [inch].

        Raises:
            MissingExtraError: matplotlib is not installed.
            ArgumentError: no row has a limit and a value, or more than one axes.
        """
        from ..drawing import margins  # Imported here: few scripts draw.

        return margins(self, title=title, ax=ax, figsize=figsize)

    def __iter__(self) -> Iterator[VerdictRow]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __str__(self) -> str:
        columns = [HEADINGS.index(name) for name in _NARROW]
        every = [row.texts(self.units) for row in self.rows]
        cells = [[texts[i] for i in columns] for texts in every]
        widths = [max(map(len, column)) for column in zip(_NARROW, *cells, strict=True)]
        lines = [f"{self.line}: {self.summary}", _line(_NARROW, widths)]
        title = ""
        for row, (heading, *_), texts in zip(self.rows, every, cells, strict=True):
            if heading != title:
                title = heading
                lines.append(f"-- {title}")
            lines.append(_line(texts, widths))
            lines += [f"     {text}" for text in row.remarks(self.units)]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        title = f"{self.line}: {self.summary}"
        return table(HEADINGS, (row.texts(self.units) for row in self.rows), title)

    def to_dataframe(self) -> pandas.DataFrame:
        """Return all rows as a table in SI units and radians, `unit` beside the numbers.

        Raises:
            MissingExtraError: pandas is not installed.
        """
        try:
            import pandas
        except ImportError as error:
            raise MissingExtraError(
                'this table needs pandas: pip install "cardan-dyn[study]"'
            ) from error
        columns = (
            "rule where quantity value rule_value limit bound unit margin status condition source"
        )
        found = {name: [getattr(row, name, "") for row in self.rows] for name in columns.split()}
        found["limit"] = [row.limit.value if row.limit else None for row in self.rows]
        found["bound"] = [row.limit.bound if row.limit else "" for row in self.rows]
        found["remarks"] = ["; ".join(row.remarks()) for row in self.rows]
        return pandas.DataFrame(found)


def verdict(
    line: LineData,
    limits: Mapping[str, Limit | float | str | None] | None,
    analysis: Analysis | None,
    solver: Callable[[], LineSolver],
) -> Verdict:
    """Return the verdict on a line; see `DriveLine.verdict`.

    Args:
        line: the line.
        limits: see `DriveLine.verdict`.
        analysis: likewise.
        solver: returns what solves the line.
    """
    case = Case(line, limits, analysis, solver)
    rows = [
        row
        for rules in (angle_rules, rating_rules, shaft_rules, force_rules)
        for row in rules(case)
    ]
    order = list(RULES)
    ordered = tuple(sorted(rows, key=lambda row: order.index(row.rule)))
    return Verdict(line.name, ordered, units_of(line))


def _line(texts: tuple[str, ...] | list[str], widths: list[int]) -> str:
    return "  ".join(text.ljust(width) for text, width in zip(texts, widths, strict=True)).rstrip()
