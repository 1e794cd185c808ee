"""Verdict: rows of all rules, their texts, tables, and that they cannot be changed."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from testkit.line_data import random_line

from cardan_dyn.analytic.rules import RULES
from cardan_dyn.drive_lines import DriveLine, ShaftJoint, Verdict


@pytest.fixture(scope="module")
def line() -> DriveLine:
    joints = [ShaftJoint(rated_torque=2000.0, torque_limit=300.0)] * 3
    return random_line(3, 1, mass=True).replace(
        joints=[dataclasses.replace(j, name=f"<{k}>") for k, j in enumerate(joints)],
        speed=150.0,
        torque=400.0,
    )


@pytest.fixture(scope="module")
def found(line: DriveLine) -> Verdict:
    return line.verdict()


def test_every_rule_that_the_data_allow_has_a_row_in_their_order(found: Verdict) -> None:
    order = [list(RULES).index(row.rule) for row in found]
    assert order == sorted(order)
    absent = set(RULES) - {row.rule for row in found}
    # A maker's factors, duty cycles, precision joints, friction and centrings are not in the data;
    # elastic bearings are part of the bending speed.
    assert absent == {
        "selection_torque",
        "duty_cycle",
        "elastic_bearing",
        "centred_double_joint",
        "precision_joint",
        "efficiency",
    }


def test_passed_and_failed(found: Verdict) -> None:
    assert not found.passed
    margins = [row.margin for row in found.failed]
    assert margins == sorted(margins) and margins[-1] < 0.0
    assert all(row.note for row in found.not_judged)
    counts = [int(part.split()[0]) for part in found.summary.split(", ")]
    assert sum(counts) == len(found) == len(list(found))


def test_every_row_names_a_source_and_a_status(found: Verdict) -> None:
    for row in found:
        assert row.source
        assert row.status in {"pass", "fail", "stated", "not judged"}
        if row.status in {"pass", "fail"}:
            assert row.limit is not None
        elif row.limit is not None:  # What is not known may only make it worse.
            assert row.status == "not judged" and "not judged: give" in row.note


def test_texts(found: Verdict) -> None:
    text = str(found)
    assert found.summary in text and "-- Fork couples" in text
    html = found._repr_html_()
    assert "&lt;0&gt;" in html and "<0>" not in html
    assert html.count("<tr>") == len(found) + 1


def test_table(found: Verdict) -> None:
    pytest.importorskip("pandas", reason="tables need pandas")
    table = found.to_dataframe()
    assert len(table) == len(found)
    assert table["value"].dtype == float
    assert list(table[table.status == "fail"].margin < 0.0) == [True] * len(found.failed)


def test_frozen(found: Verdict) -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        found.rows = ()  # type: ignore[misc]


def test_a_line_without_speed_and_torque_still_has_a_verdict() -> None:
    bare = random_line(2, 1, bend=0.0).verdict()
    assert bare.passed
    assert np.isfinite([row.value for row in bare if row.value is not None]).all()
