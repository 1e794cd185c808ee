"""Verdict rows: margins of both senses, rounding at a limit, texts in the units of engineers."""

from __future__ import annotations

import math

import pytest

from cardan_dyn.analytic.limits import Limit
from cardan_dyn.drive_lines import DriveLine, Inverse, VerdictRow
from cardan_dyn.practice.drive_lines.verdict.rows import (
    HEADINGS,
    as_text,
    judged,
    opened,
    stated,
    withheld,
)
from cardan_dyn.practice.drive_lines.wording import Wording

MOST, LEAST = Limit(2.0, "m", "someone"), Limit(2.0, "m", "someone", "least")


def row(value: float | None) -> VerdictRow:
    return VerdictRow(rule="lengths", where="tube", quantity="length", value=value, unit="m")


@pytest.mark.parametrize(
    ("value", "limit", "margin", "status"),
    [
        (1.0, MOST, 0.5, "pass"),
        (3.0, MOST, -0.5, "fail"),
        (2.0 * (1 + 1e-12), MOST, 0.0, "pass"),
        (3.0, LEAST, 0.5, "pass"),
        (1.0, LEAST, -0.5, "fail"),
        (math.inf, LEAST, math.inf, "pass"),
        (math.nan, MOST, math.nan, "open"),
    ],
)
def test_judged(value: float, limit: Limit, margin: float, status: str) -> None:
    found = judged(row(value), limit, "")
    assert found.margin == pytest.approx(margin, abs=1e-9, nan_ok=True)
    assert found.status == status
    assert found.source == "someone"


def test_without_limit_or_value() -> None:
    missing = judged(row(1.0), None, "give it")
    assert (missing.status, missing.note) == ("open", "give it")
    assert judged(row(None), MOST, "").status == "open"
    assert opened(row(None), "why").margin is None
    idle = stated(row(1.0), "another rule")
    assert (idle.status, idle.note) == ("stated", "another rule")


def test_what_may_grow_passes_nothing_and_fails_anyway() -> None:
    assert withheld(judged(row(1.0), MOST, ""), "give more").status == "open"
    assert withheld(judged(row(1.0), MOST, ""), "").status == "pass"
    assert withheld(judged(row(3.0), MOST, ""), "give more").status == "fail"


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (math.pi / 60, "rad", "3°"),
        (100 * math.pi, "rad/s", "3000 1/min"),
        (math.radians(27000) * math.pi / 30, "rad^2/s", "27000 °/min"),
        (7.2e6, "s", "2000 h"),
        (0.0254, "m", "25.4 mm"),
        (6e7, "Pa", "60 MPa"),
        (1.0186e-3, "kg m", "1019 g·mm"),
        (0.5, "1", "0.5"),
        (12345.0, "N", "12.35 kN"),
        (0.0, "N", "0 N"),
    ],
)
def test_units_of_engineers(value: float, unit: str, text: str) -> None:
    assert as_text(value, unit) == text


def test_texts_hold_inverses_notes_and_broken_assumptions() -> None:
    full = judged(
        VerdictRow(
            rule="lengths",
            where="tube",
            quantity="length",
            value=1.5,
            unit="m",
            inverses=(Inverse("best", 1.0, "m"),),
            note="a note",
            broken=("straight: it is bent",),
        ),
        MOST,
        "",
    )
    texts = dict(zip(HEADINGS, full.texts(), strict=True))
    assert texts["limit"] == "≤ 2000 mm"
    assert texts["margin"] == "+25 %"
    assert texts["remarks"] == "best 1000 mm; a note; ! straight: it is bent"


@pytest.mark.slow
def test_room_to_a_limit_of_nothing_is_said_in_its_unit() -> None:
    """A part of 0 says nothing: 25 mm of travel are left, not 2 %."""
    verdict = DriveLine.from_toml("truck").verdict()
    (row,) = (row for row in verdict.rows if row.limit is not None and row.limit.value == 0.0)
    assert row.quantity == "travel left when shortest" and row.unit == "m"
    assert row.margin == pytest.approx(0.025)
    assert "+25 mm" in row.texts()
    (axes,) = verdict.plot().axes
    assert "+25 mm" in [text.get_text() for text in axes.texts]


@pytest.mark.parametrize(("units", "told"), [("si", "0 N"), ("imperial", "0 lbf")])
def test_what_is_rounding_is_told_as_zero(units: str, told: str) -> None:
    """What cancels leaves 2e-15 lbf: the command prints what the page says."""
    assert as_text(9.02e-15, "N", units) == as_text(-9.02e-15, "N", units) == told
    page = Wording(units=units).quantity(9.02e-15, "force")
    assert " ".join(page.split()) == told
    assert as_text(1e-6, "N", units) not in (told, "")
