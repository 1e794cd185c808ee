"""Verdict: rows of all rules, their texts, tables, and that they cannot be changed."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest
from testkit.line_data import FAN, random_line

from cardan_dyn.analytic.rules import RULES
from cardan_dyn.drive_lines import DriveLine, ShaftJoint, Verdict, VerdictRow


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


@pytest.mark.slow
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
    assert found.open and all(row.note for row in found.open)
    assert sum(found.counts.values()) == len(found) == len(list(found))
    told, _, counts = found.summary.partition(": ")
    assert told == f"failed, {len(found.open)} rows open"
    assert counts == ", ".join(f"{count} {status}" for status, count in found.counts.items())


def test_a_verdict_has_three_outcomes(found: Verdict) -> None:
    def outcome(*statuses: str) -> tuple[bool, str]:
        rows = tuple(dataclasses.replace(found.rows[0], status=status) for status in statuses)
        made = Verdict("line", rows)
        return made.passed, made.summary.partition(":")[0]

    assert outcome("pass", "stated") == (True, "passed")
    assert outcome("pass", "open", "stated") == (False, "passed, 1 row open")
    assert outcome("open", "fail", "open") == (False, "failed, 2 rows open")
    assert outcome("pass", "fail") == (False, "failed")


def test_every_row_names_a_source_and_a_status(found: Verdict) -> None:
    for row in found:
        assert row.source
        assert row.status in {"pass", "fail", "open", "stated"}
        if row.status in {"pass", "fail"}:
            assert row.limit is not None
        elif row.limit is not None:  # What is not known may only make it worse.
            assert row.status == "open" and "give" in row.note


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
    assert bare.open and not bare.failed and not bare.passed
    assert np.isfinite([row.value for row in bare if row.value is not None]).all()


def test_a_line_of_which_everything_is_known_passes() -> None:
    found = DriveLine.from_toml(FAN).verdict()
    assert found.passed and found.summary.startswith("passed: ")


@pytest.mark.parametrize(
    "lost",
    [
        "speed_rpm = 980\n", "torque_nm = 800\n", "life_h = 8000\n", "radial_limit_kn = 8, ",
        ", axial_limit_kn = 9", ", shear_limit_mpa = 60", "friction = 0.1, radius_mm = 25, ",
        ", compressed_mm = 1150", ", travel_mm = 110", 'size = "2040"\n',
        "largest_angle_deg = 20\n", "rated_torque_nm = 2500\n", "torque_limit_nm = 5000\n",
        "inertia_kgm2 = 25\n",
        "tube = { outer_diameter_mm = 90, wall_mm = 3, shear_limit_mpa = 60 }\n",
    ],
)  # fmt: skip
def test_what_is_not_given_is_open_and_named(lost: str) -> None:
    assert lost in FAN
    found = DriveLine.from_toml(FAN.replace(lost, "", 1)).verdict()
    assert not found.passed and not found.failed
    field = re.findall(r"[a-z]+(?:_[a-z]+)*", lost)[0]
    short = re.sub(r"_(rpm|nm|h|kn|mpa|mm|deg|kgm)$", "", field)
    assert any(short in row.note for row in found.open)


@pytest.mark.slow
def test_without_its_rating_of_reversals_the_whole_swing_counts() -> None:
    """25 kg·m² at ±10 rad/s² and from 0 to 800 N·m: a swing of 1300 N·m, over cos 3°."""

    def row(pulsating: int) -> VerdictRow:
        text = FAN.replace("reversing_limit_nm = 1800\n", "")
        text = text.replace("pulsating_limit_nm = 2500", f"pulsating_limit_nm = {pulsating}")
        rows = DriveLine.from_toml(text).verdict()
        return next(row for row in rows if row.quantity == "shock torque, reversing")

    assert row(2500).value == pytest.approx(1300.0 / np.cos(np.radians(3.0)), rel=1e-3)
    assert [row(limit).status for limit in (1310, 1290, 1060, 1040)] == [
        "pass", "open", "open", "fail",
    ]  # fmt: skip
    assert "give reversing_limit" in row(1290).note
