"""Work and precision: which records are read, and how they are drawn."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cardan_dyn as cd

pytest.importorskip("matplotlib", reason="figures need matplotlib")

from testkit.drawings import check_units_and_files

from benchmarks.work_precision import read_records, work_precision

RECORDS: list[dict[str, Any]] = [
    {
        "method": method,
        "task": task,
        "beta_deg": 50.0,
        "error": 0.0 if steps == 4 else 10.0 ** (-order * steps),
        "microseconds": cost * 2.0**steps,
    }
    for task in ("motion", "wrenches")
    for method, order, cost in (("first", 1, 0.1), ("second", 2, 1.0), ("third", 3, 4.0))
    for steps in range(1, 5)
]


def test_records(tmp_path: Path) -> None:
    assert read_records(tmp_path) == []
    (tmp_path / "a.json").write_text(json.dumps(RECORDS[:2]), encoding="utf-8")
    unmeasured = {**RECORDS[0], "error": None}
    content = {"machine": "x", "records": [*RECORDS[2:4], {"method": "no error"}, unmeasured]}
    (tmp_path / "b.json").write_text(json.dumps(content), encoding="utf-8")
    assert read_records(tmp_path) == RECORDS[:4]
    (tmp_path / "c.json").write_text("{", encoding="utf-8")
    with pytest.raises(cd.ArgumentError, match=r"c\.json is not JSON"):
        read_records(tmp_path)


@pytest.mark.parametrize(
    "flaw",
    [
        {"microseconds": 0.0},
        {"microseconds": -1.0},
        {"microseconds": float("inf")},
        {"error": float("nan")},
        {"task": None},
    ],
)
def test_records_that_were_not_measured_are_left_out(flaw: dict[str, Any], tmp_path: Path) -> None:
    content = [RECORDS[0], {**RECORDS[1], **flaw}, "not a record", RECORDS[2]]
    (tmp_path / "a.json").write_text(json.dumps(content), encoding="utf-8")
    (tmp_path / "empty.json").write_text("null", encoding="utf-8")
    assert read_records(tmp_path) == [RECORDS[0], RECORDS[2]]
    with pytest.raises(cd.ArgumentError, match="needs records with the fields"):
        work_precision([{**RECORDS[1], **flaw}])


def test_work_precision() -> None:
    figure = work_precision(RECORDS)
    assert [axes.get_title() for axes in figure.axes] == ["motion", "wrenches"]
    for axes in figure.axes:
        assert axes.get_xscale() == axes.get_yscale() == "log"
        lines = {line.get_label(): line for line in axes.get_lines()}
        assert list(lines) == ["first", "second", "third"]
        # From quick to slow; an error of zero stays on the paper.
        assert np.all(np.diff(lines["second"].get_xdata()) > 0.0)
        assert lines["second"].get_ydata()[-1] == 1e-17
    for wrong in ([], [{"method": "a"}]):
        with pytest.raises(cd.ArgumentError, match="method, task, error, microseconds"):
            work_precision(wrong)


@pytest.mark.slow
def test_figure_has_units(tmp_path: Path) -> None:
    figure = work_precision(RECORDS, title="methods")
    check_units_and_files(figure, tmp_path)
    assert figure.get_suptitle() == "methods"


def test_a_method_without_records_of_a_task_is_left_out_there() -> None:
    records = [*RECORDS[:4], {**RECORDS[4], "task": "wrenches"}, {**RECORDS[8], "task": "rates"}]
    axes = work_precision(records).axes
    assert [panel.get_title() for panel in axes] == ["motion", "wrenches", "rates"]
    drawn = [[line.get_label() for line in panel.get_lines()] for panel in axes]
    assert drawn == [["first"], ["second"], ["third"]]


def test_both_scales_have_numbers_at_two_decades_at_least() -> None:
    """Records that hardly differ would else have no whole decade between them."""
    records = [{**RECORDS[0], "error": error} for error in (3e-9, 4e-9)]
    (axes,) = work_precision(records).axes
    for low, high in (axes.get_xlim(), axes.get_ylim()):
        assert np.log10(high / low) >= 2.2 - 1e-9
        assert np.floor(np.log10(high)) - np.ceil(np.log10(low)) >= 1
    low, high = axes.get_ylim()
    assert low < 3e-9 and high > 4e-9
