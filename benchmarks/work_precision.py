"""Work and precision: error against time per value of several methods."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from cardan_dyn import ArgumentError
from cardan_dyn.figures.style import (
    Axes,
    Figure,
    Into,
    Size,
    in_look,
    line_style,
    point_style,
    sheet,
)

FIELDS = ("method", "task", "error", "microseconds")
"""Fields that every record needs; `beta_deg` [deg] is read as well."""
_FLOOR = 1e-17
"""Where an error of exactly zero is drawn: below every relative error of doubles, some 1e-16."""
_LEAST_DECADES = 2.2
"""Least range of a scale in decades, so that two whole decades have numbers."""


def read_records(directory: str | os.PathLike[str]) -> list[dict[str, Any]]:
    """Read the results of benchmarks.

    Args:
        directory: with JSON files, each a list of records or a mapping that holds such lists. A
            record is a mapping with `method`, `task`, `error` [–] and `microseconds` per value.
            Records that lack one of them are left out, and those without a finite error or a
            positive time, which were not measured.

    Returns:
        The records of all files in the order of their names; none if there is no file.

    Raises:
        ArgumentError: a file is not JSON.
    """
    records: list[dict[str, Any]] = []
    for path in sorted(Path(directory).glob("*.json")):
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
        except ValueError as error:
            raise ArgumentError(f"{path} is not JSON: {error}") from error
        lists = [content] if isinstance(content, list) else _lists(content)
        records += [record for entries in lists for record in entries if _complete(record)]
    return records


@in_look
def work_precision(
    records: Iterable[Mapping[str, Any]],
    title: str = "",
    *,
    ax: Into = None,
    figsize: Size | None = None,
) -> Figure:
    """Draw error against time per value, one line per method and one axes per task.

    Args:
        records: mappings with `method`, `task`, `error` (relative), `microseconds` (time per
            value). An error of exactly zero is drawn at 1e-17.
        title: of the figure.
        ax: axes to be drawn into instead of a new figure, one for each task.
        figsize: width and height of a new figure [inch].

    Raises:
        ArgumentError: there is no record, one lacks a field, or another number of axes.
    """
    table = [dict(record) for record in records]
    if not table or not all(_complete(record) for record in table):
        raise ArgumentError(f"work-precision needs records with the fields {', '.join(FIELDS)}")
    tasks = list(dict.fromkeys(record["task"] for record in table))
    methods = list(dict.fromkeys(record["method"] for record in table))
    columns = min(len(tasks), 2)
    rows = -(-len(tasks) // columns)
    drawn = sheet(
        rows,
        columns,
        count=len(tasks),
        size=(4.6 * columns + 2.0 * (columns == 1), 4.2 * rows),
        ax=ax,
        figsize=figsize,
    )
    for panel, task in zip(drawn.panels, tasks, strict=True):
        for index, method in enumerate(methods):
            points = sorted(
                (float(record["microseconds"]), max(float(record["error"]), _FLOOR))
                for record in table
                if record["task"] == task and record["method"] == method
            )
            if points:
                style = {**point_style(index), **line_style(index), "label": method}
                panel.plot(*zip(*points, strict=True), **style)
        panel.set_xscale("log")
        panel.set_yscale("log")
        _whole_decades(panel)
        panel.set_xlabel("time per value [µs]")
        panel.set_ylabel("relative error [–]")
        panel.set_title(task)
    return drawn.finish(title, 3 if columns == 2 else 2)


def _whole_decades(axes: Axes) -> None:
    """Let both scales cover at least two decades, with numbers at whole decades only."""
    from matplotlib.ticker import LogLocator, NullFormatter

    limits = (
        (axes.get_xlim, axes.set_xlim, axes.xaxis),
        (axes.get_ylim, axes.set_ylim, axes.yaxis),
    )
    for get_limits, set_limits, axis in limits:
        low, high = np.log10(get_limits())
        margin = max(0.0, _LEAST_DECADES - (high - low)) / 2.0
        set_limits(10.0 ** (low - margin), 10.0 ** (high + margin))
        axis.set_major_locator(LogLocator(numticks=8))
        axis.set_minor_formatter(NullFormatter())


def _lists(content: Any) -> list[list[Any]]:
    """Return the lists that a mapping holds."""
    return [value for value in content.values() if isinstance(value, list)] if content else []


def _complete(record: Any) -> bool:
    """Return whether a record has all fields, a finite error and a positive time."""
    if not isinstance(record, Mapping) or any(record.get(field) is None for field in FIELDS):
        return False
    error, time = (record[field] for field in FIELDS[2:])
    return bool(np.isfinite(error) and np.isfinite(time) and time > 0.0)
