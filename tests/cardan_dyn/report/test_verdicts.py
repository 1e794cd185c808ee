"""Results of comparisons: when they pass, and how they are shown."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from cardan_dyn.practice.report.verdicts import Comparison, Comparisons

FIRST = Comparison("shaft", "torque <T>", "theory (1)", 1e-13, {10.0: 1e-15, 20.0: 5e-14})
FAILED = dataclasses.replace(FIRST, quantity="speed", errors={10.0: 2e-13})
OTHER_SCENE = dataclasses.replace(FIRST, scene="joint", errors={10.0: 0.0})
ALL = Comparisons([FIRST, FAILED, OTHER_SCENE])


@pytest.mark.parametrize(
    ("error", "passed"),
    [(0.0, True), (1e-13, True), (1.1e-13, False), (float("inf"), False), (float("nan"), False)],
)
@pytest.mark.parametrize("beta", [5.0, 10.0, 30.0])
def test_errors_within_the_tolerance_pass(error: float, passed: bool, beta: float) -> None:
    """At whatever angle."""
    made = dataclasses.replace(FIRST, errors={**FIRST.errors, beta: error})
    assert made.passed is passed


def test_all_must_pass() -> None:
    assert not ALL.passed
    assert Comparisons([FIRST, OTHER_SCENE]).passed
    unknown = dataclasses.replace(FIRST, errors={10.0: float("nan")})
    assert not Comparisons([FIRST, unknown]).passed


def test_no_comparison_passes_nothing() -> None:
    assert not Comparisons([]).passed


@pytest.mark.parametrize("place", [10.0, 20.0])
def test_an_error_that_is_not_known_is_the_worst(place: float) -> None:
    made = dataclasses.replace(FIRST, errors={**FIRST.errors, place: float("nan")})
    assert np.isnan(made.worst) and not made.passed
    assert FIRST.worst == 5e-14


def test_text_is_an_aligned_table() -> None:
    lines = repr(ALL).splitlines()
    assert lines == [
        "scene  quantity    formula     worst error  tolerance  verdict",
        "shaft  torque <T>  theory (1)  5.0e-14      1e-13      pass",
        "shaft  speed       theory (1)  2.0e-13      1e-13      FAIL",
        "joint  torque <T>  theory (1)  0.0e+00      1e-13      pass",
        "3 of 4 comparisons pass.",
    ]
    assert repr(Comparisons([])).splitlines()[-1] == "0 of 0 comparisons pass."


def test_notebooks_show_the_same_table_escaped() -> None:
    page = ALL._repr_html_()
    assert page.count("<tr") == 4
    assert "torque &lt;T&gt;" in page and "<T>" not in page
    assert page.endswith("<p>3 of 4 comparisons pass.</p></div>")
