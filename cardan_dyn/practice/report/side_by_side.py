"""Side by side: reports on a mechanism in several load cases, and which of them governs."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from functools import cached_property
from pathlib import Path

from ...core.mechanism.mechanism import Mechanism
from ...core.results.plot import draws
from ...core.results.result import Result
from ...core.results.sweep import Sweep
from ...core.results.table import Table
from ...kit.checks import described, file_path, flag
from ...kit.errors import ArgumentError
from ...kit.frozen import Frozen
from ...kit.quantities import amount, column
from .extremes import Extreme
from .findings import (
    apart,
    cases_apart,
    cases_in_words,
    cases_with,
    compared,
    governing,
    table_of,
)
from .plots import ReportPlot
from .reporting import Report


class Reports(Result, Frozen):
    """Reports on a mechanism in several load cases, side by side: `print` and `save` as `Report`.

    They begin with the greatest of each quantity that statics determines, with its joint, its place
    and the load case, go on with every joint in all load cases, and end with each case by itself.
    As a table (`to_dataframe`) they have the rows of all reports, with the column `case`.

    Args:
        cases: sweeps of one mechanism, each over one dimension, or reports on it.
        labels: how the load cases are called; by what tells them apart if there are none.
        title, project, author, date, revision: as of `Report`, for sweeps.

    Attributes:
        reports: a `Report` on each load case.
        labels: their names.

    Raises:
        ArgumentError: no case at all, cases of several mechanisms, or labels that are not as many
            or the same.
        CardanError: as `Report`.
    """

    def __init__(
        self,
        cases: Iterable[Sweep | Report],
        labels: Iterable[str] = (),
        *,
        title: str = "",
        project: str = "",
        author: str = "",
        date: str = "",
        revision: str = "",
    ) -> None:
        head = {"title": title, "project": project, "author": author}
        head |= {"date": date, "revision": revision}
        if isinstance(cases, Sweep | Report | Mechanism):
            raise ArgumentError("several load cases are a list of sweeps; one is that of a Report")
        self.reports = tuple(
            case if isinstance(case, Report) else Report(case, **head) for case in cases
        )
        if not self.reports:
            raise ArgumentError("there is no load case to report on")
        if len({report.sha256 for report in self.reports}) > 1:
            raise ArgumentError("load cases are those of one mechanism, and there are several")
        self.labels = tuple(labels) or _told_apart([report.case_lines for report in self.reports])
        if len(self.labels) != len(self.reports) or len(set(self.labels)) < len(self.labels):
            raise ArgumentError(
                f"labels are {described(list(self.labels))}, expected one of its own for each of "
                f"{len(self.reports)} load cases"
            )
        self._freeze()

    @cached_property
    def headline(self) -> tuple[tuple[int, Extreme], ...]:
        """Of each quantity that statics determines the greatest, behind the index of its case."""
        return tuple(governing(self.reports))

    def table(self) -> Table:
        """Return the extremes of all reports, see `Report.table`, with the column `case`."""
        return table_of(self.reports, self.labels)

    def save(self, path: str | os.PathLike[str], *, scene: bool = True) -> Path:
        """Write the page, or the extremes alone; see `Report.save`.

        The scene is that of the load case in which the first quantity of the headline is greatest.
        """
        with_scene = flag("scene", scene)
        target = file_path("path", path)
        if target.suffix != ".html":
            return super().save(target)
        from .mechanism_page import write  # Imported here: it draws.

        return write(self.reports, self.labels, target, with_scene)

    def __repr__(self) -> str:
        name = self.reports[0].mechanism.name
        return f"<{type(self).__name__} of {name!r}: {len(self.reports)} load cases>"

    def __str__(self) -> str:
        lines = [f"{self.reports[0].title}: {cases_in_words(self.reports)}"]
        told = cases_apart(self.reports, self.labels)
        for index, (text, report) in enumerate(zip(told, self.reports, strict=True), 1):
            lines.append(f"{index}: {text}")
            lines += [f"   ! {doubt}" for doubt in report.doubts]
        width = max((len(item.quantity) for _, item in self.headline), default=0)
        for case, item in self.headline:
            (most, first), _ = item.ends
            place = f" at {self.reports[case].at(first[:2])}" if len(first) else ""
            shown = f"{amount(most, item.unit)} in {item.owner}{place}"
            labels = cases_with(self.reports, self.labels, (case, item))
            lines.append(f"{item.quantity.ljust(width)}  {shown}: {labels}")
        owner = ""
        counts = "".join(f"{index:>10}" for index in range(1, len(self.labels) + 1))
        lines.append(f"  {'greatest in size'.ljust(16)}{counts}")
        for row in compared(self.reports):
            one = next(item for item in row if item is not None)
            if one.owner != owner:
                owner = one.owner
                lines.append(owner)
            numbers, unit = column([item.ends[0][0] if item else 0.0 for item in row], one.unit)
            shown = "".join(f"{text:>10}" for text in numbers)
            lines.append(f"  {one.quantity.ljust(16)}{shown} {unit}")
        opened = (report.left_open for report in self.reports)
        return "\n".join([*lines, *dict.fromkeys(filter(None, opened))])


draws(Reports)(ReportPlot)


def _told_apart(cases: Sequence[Sequence[str]]) -> tuple[str, ...]:
    """Return of each case what not all of them have in common, or its number."""
    labels = tuple(
        ", ".join(own) or f"case {number}" for number, own in enumerate(apart(cases)[1], 1)
    )
    if len(set(labels)) == len(labels):
        return labels
    return tuple(f"case {index}" for index in range(1, len(cases) + 1))
