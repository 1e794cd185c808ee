"""What is said of reversals."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cardan_dyn.analytic import damped_impact, peak_exponents
from cardan_dyn.clearance import ForceReversal, ImpactModel, JointScan, PinGeometry, Scan

MODEL = ImpactModel(2.0, 1e8, 1e-4, 1e6, damping_ratio=0.2)

GOOD = ForceReversal(
    position=1.0,
    force_slope=1e6,
    direction=np.array([1.0, 0.0, 0.0]),
    reduced_mass=2.0,
    guided_mass=2.5,
    stiffness=1e8,
    contact_time=1e-3,
    impact_speed=0.3,
    tau=5.0,
    peak=4000.0,
    rigid=2500.0,
    added=1500.0,
    turn_through=0.01,
    flown=0.2,
    mass_change=0.02,
    deviation=0.1,
    slope_growth=3.0,
    model=MODEL,
)


def joint_scan(*reversals: ForceReversal) -> JointScan:
    force = np.array([[3000.0, 0.0, 0.0], [0.0, 100.0, 0.0]])
    return JointScan("pin", np.array([0.0, 3.0]), force, reversals, 0, 50.0)


@pytest.mark.parametrize(
    ("change", "doubt"),
    [
        ({"turn_through": 0.1}, "less than this"),
        ({"turn_through": 0.5}, "usually no impact"),
        ({"peak": float("nan")}, "no peak"),
        ({"tau": 2.0}, "τ = 2.00 is small"),
        ({"flown": 0.6}, "the ramp bends"),
        ({"flown": 1.6}, "the flight outlasts the force's rise (1.60 of it)"),
        ({"mass_change": -0.2}, "changes by -20 %"),
        ({"deviation": 0.5}, "29° beside"),
    ],
)
def test_each_assumption_that_fails_is_named(change: dict[str, float], doubt: str) -> None:
    (said,) = replace(GOOD, **change).doubts
    assert doubt in said


def test_a_contact_without_a_seat_is_doubted() -> None:
    for law, count in (
        (PinGeometry(0.02, 0.01), 1),
        (PinGeometry(0.02, 0.01, seat_stiffness=1e7), 0),
        (PinGeometry(2e-4, 0.01, seat_stiffness=1e7), 1),
    ):
        said = replace(GOOD, model=replace(MODEL, stiffness=law)).doubts
        assert len(said) == count
    assert "wide to each side" in said[0]


def test_without_doubts_nothing_is_said() -> None:
    assert GOOD.doubts == ()
    assert GOOD.verdict == "impact"
    assert joint_scan(GOOD).verdict == "impact"
    assert joint_scan(GOOD).summary.startswith(
        "1 reversal, 4000 N instead of 3000 N, 4.5 W; 10 % less of: speed -"
    )


def test_a_force_that_turns_through_does_not_count() -> None:
    scanned = joint_scan(GOOD, replace(GOOD, turn_through=0.4, peak=9000.0))
    assert scanned.peak == scanned.severity == 4000.0
    assert scanned.worst is GOOD
    assert scanned.impacts == 1
    assert scanned.impact_power == pytest.approx(4.5)


def test_no_peak_leaves_the_rigid_one() -> None:
    scanned = joint_scan(replace(GOOD, peak=float("nan")))
    assert scanned.peak == scanned.rigid_peak == 3000.0
    assert scanned.severity == 0.0
    assert "no peak" in scanned.summary


def test_verdicts_where_the_theory_does_not_apply() -> None:
    through = replace(GOOD, turn_through=0.45)
    assert through.verdict.startswith("the force turns through (ρ = 0.45): usually no impact")
    for scanned, said in (
        (joint_scan(), "no reversal: the force never swings round; the theory does not apply"),
        (replace(joint_scan(), turning=2), "no reversal: the force turns through 2 times"),
        (joint_scan(replace(GOOD, turn_through=0.9), through), through.verdict),
        (joint_scan(replace(GOOD, peak=float("nan"), tau=1.5)), "no peak: the force only follows"),
        (replace(joint_scan(), force=np.zeros((4, 3))), "no force"),
        (joint_scan(through, replace(GOOD, flown=0.5)), "impact; the ramp bends"),
        (joint_scan(replace(GOOD, flown=1.5)), "impact far below the estimate: the flight"),
    ):
        assert scanned.verdict.startswith(said)
        assert said in scanned.summary or scanned.impacts


def test_exponents_and_what_changes_would_buy() -> None:
    tau = float(MODEL.estimate.tau)
    expected = damped_impact.peak_exponents(tau, 0.2)
    np.testing.assert_allclose(GOOD.exponents, expected, rtol=1e-14)
    # Where loads act the slope grows with another power of the speed.
    loaded = replace(GOOD, slope_growth=5.0).exponents
    assert loaded.speed == pytest.approx(5.0 * expected.slope)
    # Half the clearance makes so much less of a peak of which a small change is known.
    assert GOOD.effects(-1e-6)["clearance"] == pytest.approx(-1e-6 * expected.clearance, rel=1e-5)
    undamped = replace(GOOD, model=replace(MODEL, damping_ratio=0.0, start="rest"))
    found = undamped.exponents.clearance
    assert found == pytest.approx(float(peak_exponents.peak_exponents(tau).clearance), rel=1e-14)


def test_rows_hold_numbers_and_words_alone() -> None:
    assert GOOD.exponents is GOOD.exponents
    row = GOOD.row()
    assert all(isinstance(value, (float, str)) for value in row.values())
    assert row["exponent_clearance"] == GOOD.exponents.clearance
    assert row["verdict"] == "impact"


def bearings(**changes: Any) -> ForceReversal:
    """Of a universal joint, whose bearings are not followed."""
    given = {"share": (1.0, 1.0, 0.5, 0.5), "unfollowed": "no interval is known: simulate"}
    return replace(GOOD, model=replace(MODEL, damping_ratio=0.0), **{**given, **changes})


def cross(*reversals: ForceReversal) -> JointScan:
    force = np.zeros((360, 4, 3))
    force[10, 2] = [0.0, 30.0, 40.0]
    return JointScan(
        name="cross",
        position=np.radians(np.arange(360.0)),
        force=force,
        reversals=reversals,
        turning=0,
        periods=2.0,
        bearings=("a+", "a-", "b+", "b-"),
        freedoms=5,
        radius={"a": 0.05, "b": 0.04},
        clearance={"a": 1e-5, "b": 2e-5},
        stiffness={"a": 1e8, "b": 1e8},
    )


def test_energy_is_that_of_all_bearings() -> None:
    item = bearings()
    assert item.energy == pytest.approx(2.5 * 0.5 * 2.0 * item.impact_speed**2)
    assert cross(item, item).impact_power == pytest.approx(2.0 * 2.0 * item.energy)


def test_bearings_that_do_not_close_together_are_a_doubt() -> None:
    doubt, _ = bearings(tau=5.0, split=0.2).doubts
    assert doubt == "the bearings do not close together (20 % of the clearance)"
    assert bearings(split=0.2).row()["split"] == 0.2


def test_the_interval_that_pin_bearings_lack_is_a_doubt() -> None:
    """The last of them; single bearings have it as well, and what is printed tells of it."""
    item = bearings(tau=5.0)
    (doubt,) = item.doubts
    assert np.isnan(item.least) and np.isnan(item.greatest)
    assert "no interval is known: simulate" in doubt
    assert doubt in item.verdict and doubt in cross(item).summary
    assert cross(item).by_bearing()["a+"].reversals[0].doubts == (doubt,)


def test_the_greatest_force_is_that_of_one_bearing() -> None:
    assert cross().rigid_peak == pytest.approx(50.0)
    assert cross(bearings()).peak == pytest.approx(bearings().peak)


def test_torsional_clearance_is_of_pins_with_both_bearings_open() -> None:
    assert cross().torsional_clearance == pytest.approx(1e-5 / 0.05 + 2e-5 / 0.04)


def test_table_and_text() -> None:
    scanned = cross(bearings(), bearings(position=2.0))
    frame = Scan({"cross": scanned}, 12.0, {}).to_dataframe()
    assert list(frame["position"]) == [1.0, 2.0]
    assert set(frame["joint"]) == {"cross"}
    text = str(Scan({"cross": scanned}, 12.0, {}))
    assert text.splitlines()[1].startswith("- a+, a-, b+, b- of cross: 2 reversals,")


def test_each_bearing_has_its_share() -> None:
    item = bearings()
    found = cross(item).by_bearing()
    assert list(found) == ["a+", "a-", "b+", "b-"]
    assert found["a-"].reversals[0].peak == item.peak
    assert found["b-"].reversals[0].peak == pytest.approx(0.5 * item.peak)
    assert [found[name].rigid_peak for name in found] == pytest.approx([0.0, 0.0, 50.0, 0.0])
