"""Courses: quantities over what moves, a line for each case; the page and `plot` draw the same."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Unpack

import numpy as np

from ...core.results.sweep import Sweep
from ...figures.style import Abscissa, Figure, Onto, in_look, over, plain, sheet
from ...figures.wrenches import MARK, along
from ...kit.arrays import Array
from ...kit.errors import ArgumentError, choices
from .cases import Cases
from .extremes import Extreme, quantities_of
from .findings import Findings, ways
from .page import BESIDE


@in_look
def courses(
    cases: Cases,
    told: Sequence[Extreme],
    *,
    x: str = "",
    **onto: Unpack[Onto],
) -> Figure:
    """Draw quantities, axes for each and a line for each case.

    They are drawn over what all cases have in common: time, the only drive, or else the row of
    their task that turns back least, or else the number of the sample.

    Args:
        cases: in which something is driven.
        told: which quantities, of which the first six are drawn.
        x: a coordinate, or a row of the task of all cases, to be drawn over instead.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`.

    Raises:
        ArgumentError: other axes than are needed, or `x` is nothing to be drawn over.
    """
    shown = told[:BESIDE]
    size = (7.2, 1.0 + 1.8 * len(shown))
    drawn = sheet(len(shown), size=size, share_x=True, **onto)
    sweeps = [sweep for report in cases.reports if (sweep := report.drawn[0]) is not None]
    every, labels = _over(cases.reports, sweeps, x), cases.labels or ("",)
    for index, (sweep, label, at) in enumerate(zip(sweeps, labels, every, strict=True)):
        values = {(one.owner, one.name): one.values for one in quantities_of(sweep)}
        for panel, item in zip(drawn.panels, shown, strict=True):
            # What a case leaves out has no line there.
            if (item.owner, item.quantity) in values:
                course = values[item.owner, item.quantity](sweep)
                panel.plot(at.values, course, **at.style(index), label=plain(label))
    for panel, item in zip(drawn.panels, shown, strict=True):
        mark = "" if item.determined else MARK
        panel.set_ylabel(f"{plain(item.owner)}\n{item.quantity}{mark} [{item.unit}]")
    at = every[0]
    ends = np.concatenate([one.values for one in every])
    drawn.over(at._replace(values=ends[[ends.argmin(), ends.argmax()]]))
    return drawn.finish()


def _over(reports: Sequence[Findings], sweeps: Sequence[Sweep], x: str) -> list[Abscissa]:
    """Return what each sweep is drawn over; all of them have the same label."""
    rows = [{way.name: way for way in ways(sweep) if way.kind == "task"} for sweep in sweeps]
    coordinates = sweeps[0].mechanism.drivable
    common = [name for name in rows[0] if all(name in of for of in rows)]
    drives = {report.drives for report in reports}
    if not x and all(report.is_over_time for report in reports):
        return [over("time", sweep.time, "s") for sweep in sweeps]
    if x and x not in common and x not in coordinates:
        raise ArgumentError(
            f"x is {x!r}; it is a coordinate or a row of the task of all cases: "
            f"{choices([*common, *coordinates], x)}"
        )
    if not x and len(drives) == 1 and len(reports[0].drives) == 1:
        (x,) = reports[0].drives
    if x in coordinates:
        return _together([along(sweep, x) for sweep in sweeps])
    one_way = {name: min(_one_way(of[name].position) for of in rows) for name in common}
    best = x or max(one_way, key=one_way.__getitem__, default="")
    if best and (x or one_way[best]):
        return [over(best, of[best].position, of[best].unit) for of in rows]
    return [over("sample", np.arange(1, len(sweep) + 1), "") for sweep in sweeps]


def _together(every: list[Abscissa]) -> list[Abscissa]:
    """Return angles, of sets clear of each other without the whole turns between them."""
    ends = np.array([(at.values.min(), at.values.max()) for at in every])
    whole = 360.0 * np.round((ends - ends[0]).mean(axis=1) / 360.0)
    if every[0].kind != "angle" or not whole.any() or ends[:, 0].max() <= ends[:, 1].min():
        return every
    label = f"{every[0].label} less whole turns"
    pairs = zip(every, whole, strict=True)
    return [at._replace(values=at.values - turns, label=label) for at, turns in pairs]


def _one_way(values: Array) -> float:
    """Return how far values get in the end as a part of the way they go: 1 if they never turn."""
    way = float(np.abs(np.diff(values)).sum())
    return float(np.ptp(values)) / way if way else 0.0
