"""What is said of reversals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cardan_dyn.clearance import JointScan, Reversal

GOOD = Reversal(
    position=1.0,
    force_slope=1e6,
    direction=np.array([1.0, 0.0, 0.0]),
    reduced_mass=2.0,
    guided_mass=2.5,
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
)


def joint_scan(*reversals: Reversal) -> JointScan:
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
        ({"mass_change": -0.2}, "changes by -20 %"),
        ({"deviation": 0.5}, "29° beside"),
    ],
)
def test_each_assumption_that_fails_is_named(change: dict[str, float], doubt: str) -> None:
    (said,) = replace(GOOD, **change).doubts
    assert doubt in said


def test_without_doubts_nothing_is_said() -> None:
    assert GOOD.doubts == ()
    assert joint_scan(GOOD).summary == "1 reversal, 4000 N instead of 3000 N, 4.5 W"
    assert joint_scan().summary == "no reversal, 3000 N at most"


def test_a_force_that_turns_through_does_not_count() -> None:
    scanned = joint_scan(GOOD, replace(GOOD, turn_through=0.4, peak=9000.0))
    assert scanned.peak == 4000.0
    assert scanned.impact_power == pytest.approx(4.5)


def test_no_peak_leaves_the_rigid_one() -> None:
    scanned = joint_scan(replace(GOOD, peak=float("nan")))
    assert scanned.peak == scanned.rigid_peak == 3000.0
    assert "no peak" in scanned.summary
