"""Results of comparisons: when they pass, how they are grouped, and how they are shown."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cardan_dyn.practice.report.verdicts import Comparison, Comparisons

FIRST = Comparison("shaft", "torque <T>", "theory (1)", 10.0, 1e-15, 1e-13)
OTHER_ANGLE = dataclasses.replace(FIRST, beta_deg=20.0, error=5e-14)
FAILED = dataclasses.replace(FIRST, quantity="speed", error=2e-13)
OTHER_SCENE = dataclasses.replace(FIRST, scene="joint", error=0.0)
ALL = Comparisons([FIRST, OTHER_SCENE, FAILED, OTHER_ANGLE])


@pytest.mark.parametrize(
    ("error", "passed"),
    [(0.0, True), (1e-13, True), (1.1e-13, False), (float("inf"), False), (float("nan"), False)],
)
def test_an_error_within_the_tolerance_passes(error: float, passed: bool) -> None:
    assert dataclasses.replace(FIRST, error=error).passed is passed


def test_all_must_pass() -> None:
    assert not ALL.passed
    assert Comparisons([FIRST, OTHER_ANGLE]).passed
    assert not Comparisons([FIRST, dataclasses.replace(FIRST, error=float("nan"))]).passed


def test_no_comparison_passes_nothing() -> None:
    assert not Comparisons([]).passed


@pytest.mark.parametrize("place", [0, 1])
def test_an_error_that_is_not_known_is_the_worst(place: int) -> None:
    items = [FIRST, OTHER_ANGLE]
    items[place] = dataclasses.replace(items[place], error=float("nan"))
    (row,) = Comparisons(items).rows()
    assert np.isnan(row.worst) and not row.passed


def test_they_are_a_sequence() -> None:
    assert list(ALL) == [FIRST, OTHER_SCENE, FAILED, OTHER_ANGLE]
    assert len(ALL) == 4 and ALL[-1] is OTHER_ANGLE and FAILED in ALL
    tail = ALL[2:]
    assert isinstance(tail, Comparisons) and list(tail) == [FAILED, OTHER_ANGLE]
    with pytest.raises(IndexError):
        _ = ALL[4]


def test_rows_group_the_angles_of_a_quantity() -> None:
    rows = ALL.rows()
    # Scenes stand in the order of their first comparison, and what belongs to one stands together.
    assert [(row.scene, row.quantity) for row in rows] == [
        ("shaft", "torque <T>"),
        ("shaft", "speed"),
        ("joint", "torque <T>"),
    ]
    assert [row.errors for row in rows] == [(1e-15, 5e-14), (2e-13,), (0.0,)]
    assert [row.worst for row in rows] == [5e-14, 2e-13, 0.0]
    assert [row.passed for row in rows] == [True, False, True]
    assert {row.tolerance for row in rows} == {1e-13}
    assert {row.source for row in rows} == {"theory (1)"}


@given(st.lists(st.tuples(st.sampled_from("ab"), st.sampled_from("xyz"), st.floats(0.0, 2e-13))))
def test_no_comparison_is_lost_in_the_rows(values: list[tuple[str, str, float]]) -> None:
    made = Comparisons(
        dataclasses.replace(FIRST, scene=scene, quantity=quantity, error=error)
        for scene, quantity, error in values
    )
    rows = made.rows()
    errors = sorted(error for row in rows for error in row.errors)
    assert errors == sorted(error for _, _, error in values)
    assert made.passed == (bool(rows) and all(row.passed for row in rows))
    assert len({(row.scene, row.quantity) for row in rows}) == len(rows)


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
