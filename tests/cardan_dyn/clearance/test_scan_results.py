"""What is said of reversals."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cardan_dyn.analytic import damped_impact, peak_exponents
from cardan_dyn.clearance import ForceReversal, ImpactModel, JointScan, PinGeometry, Scan
from cardan_dyn.motion.clearance.planar_motion import Passages

MODEL = ImpactModel(2.0, 1e8, 1e-4, 1e6, damping_ratio=0.2)

GOOD = ForceReversal(
    position=1.0,
    force_slope=1e6,
    direction=np.array([1.0, 0.0, 0.0]),
    reduced_mass=2.0,
    stiffness=1e8,
    contact_time=1e-3,
    impact_speed=0.3,
    tau=5.0,
    two_mass_peak=4000.0,
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
        ({"turn_through": 0.1}, "the force turns through (ρ = 0.10)"),
        ({"two_mass_peak": float("nan")}, "no peak"),
        ({"tau": 2.0}, "τ = 2.00 is small"),
        ({"flown": 0.6}, "the ramp bends"),
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
    assert joint_scan(GOOD).verdict == "1 impact in a period"
    assert joint_scan(GOOD).summary == (
        "4000 N estimated; 3000 N without clearance; 1 impact in a period, 4.5 W"
    )


def test_a_force_that_turns_through_counts_by_what_is_left_of_it() -> None:
    """Of what the two-mass model adds to the force without clearance, 1 - ρ²."""
    through = replace(GOOD, turn_through=0.4, two_mass_peak=9000.0, ahead=(3000.0,))
    scanned = joint_scan(GOOD, through)
    assert scanned.peak == through.estimate == pytest.approx(3000.0 + 0.84 * 6000.0)
    assert scanned.worst is through
    assert scanned.impacts == 2
    assert scanned.impact_power == pytest.approx(9.0)
    # Nothing jumps where a swing no longer counts as a reversal.
    last = replace(through, turn_through=1.0 - 1e-9)
    assert joint_scan(last).peak == pytest.approx(joint_scan().peak, rel=1e-7)


def test_no_peak_leaves_the_rigid_one() -> None:
    scanned = joint_scan(replace(GOOD, two_mass_peak=float("nan")))
    assert scanned.peak == scanned.rigid_peak == 3000.0
    assert scanned.peak_position == 0.0
    assert "no peak" in scanned.summary


def test_what_was_simulated_counts() -> None:
    scanned = replace(joint_scan(GOOD), simulated={"pin": 5000.0}, bearings=("pin",))
    assert scanned.peak == 5000.0 and scanned.summary.startswith("5000 N")


def test_verdicts() -> None:
    for scanned, said in (
        (joint_scan(), "no reversal: the force never swings round"),
        (replace(joint_scan(), turning=2), "no reversal: the force turns through 2 times"),
        (replace(joint_scan(), force=np.zeros((2, 3))), "no force"),
    ):
        assert scanned.verdict.startswith(said)
        assert said in scanned.summary
    assert replace(GOOD, flown=0.5).verdict.startswith("impact; the ramp bends")


class Followed:
    """A pin whose greatest forces in three turns are given for each position that it starts at."""

    reason = ""

    def __init__(self, forces: dict[float, list[float]]) -> None:
        self.forces = forces

    def passages(self, position: float, way: float) -> Passages:
        return Passages(np.array(self.forces[position]), np.zeros(3), position + 0.5, 0.05)


def followed(*forces: list[float], **given: Any) -> JointScan:
    """Three reversals whose pin never strikes."""
    motion: Any = Followed({float(k): list(some) for k, some in enumerate(forces)})
    items = [
        replace(GOOD, position=float(k), ahead=(3000.0,), motion=motion, **given)
        for k in range(len(forces))
    ]
    return replace(joint_scan(*items), motion=motion)


@pytest.mark.parametrize("last", [0, 1, 2])
@pytest.mark.parametrize("rho", [0.0, 0.2, 0.9])
def test_the_greatest_interval_of_all_is_the_summary(last: int, rho: float) -> None:
    """Whichever reversal it is, whether the sides strike or not, and wherever ρ is."""
    forces = [[3000.0] * 3, [3100.0, 3400.0, 3000.0], [2900.0] * 3]
    forces[last] = [5000.0, 5100.0, 5050.0]
    joint = followed(*forces, turn_through=rho, two_mass_peak=9000.0)
    assert joint.impacts == 0
    assert joint.greatest == joint.peak == pytest.approx(1.05 * 5100.0)
    assert joint.least == pytest.approx(5000.0 / 1.05)
    assert joint.worst is joint.reversals[last] and joint.peak_position == last + 0.5
    said = "5355 N at most" if last == 1 else "up to 5355 N in 3 turns"  # They differ at number 1.
    assert joint.summary.startswith(f"{said} (4762 to 5355 N); 3000 N without clearance; no")
    table = Scan({"pin": joint}, 1.0, {}).table().columns()
    assert max(table["peak"][0]) == joint.peak


def test_turns_that_differ_are_a_doubt() -> None:
    assert followed([5000.0, 5100.0, 5050.0]).doubts == ()
    joint = followed([5000.0, 5100.0, 7060.0])
    (doubt,) = joint.doubts
    assert "no two turns are alike" in doubt
    # The greatest of some turns is no bound, whichever reversal they differ at.
    assert joint.summary.startswith("up to 7413 N in 3 turns (4762 to 7413 N)")
    for forces in (
        ([5000.0, 5100.0, 7060.0], [9000.0] * 3),
        ([9000.0] * 3, [5000.0, 5100.0, 7060.0]),
    ):
        assert followed(*forces).summary.startswith("up to 9450 N in 3 turns")
    assert "5355 N at most" in followed([5000.0, 5100.0, 5050.0]).summary


def test_the_force_without_clearance_is_never_above_the_peak() -> None:
    joint = followed([2000.0] * 3)
    assert joint.peak == joint.rigid_peak == 3000.0 > joint.greatest
    assert joint.summary.startswith("3000 N at most (1905 to 2100 N)")


def test_the_joint_with_the_greatest_interval_is_ranked_first() -> None:
    """Though the force without clearance is greater in the other."""
    rigid = joint_scan()
    pressed = followed([5000.0, 5100.0, 5050.0])
    pressed = replace(pressed, force=0.5 * pressed.force)
    assert pressed.impacts == 0 and pressed.rigid_peak < rigid.rigid_peak
    assert Scan({"rigid": rigid, "pressed": pressed}, 1.0, {}).ranking == ["pressed", "rigid"]


def test_ties_are_ranked_in_the_order_of_the_mechanism() -> None:
    """By what is printed: rounding of the same force does not change the order."""
    joint = joint_scan()
    every = {
        name: replace(joint, name=name, force=joint.force * (1.0 + part))
        for name, part in (("c", 0.0), ("a", 3e-16), ("b", 1e-15), ("d", 1e-2))
    }
    assert Scan(every, 1.0, {}).ranking == ["d", "c", "a", "b"]


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
    given = {"share": (1.0, 1.0, 0.5, 0.5), "ahead": (0.0, 0.0, 50.0, 0.0)}
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
        unfollowed="no interval is known: simulate",
        clearance={"a": 1e-5, "b": 2e-5},
        stiffness={"a": 1e8, "b": 1e8},
    )


def test_energy_is_that_of_all_bearings() -> None:
    item = bearings()
    assert item.energy == pytest.approx(2.5 * 0.5 * 2.0 * item.impact_speed**2)
    assert cross(item, item).impact_power == pytest.approx(2.0 * 2.0 * item.energy)


def test_bearings_that_do_not_close_together_are_a_doubt() -> None:
    (doubt,) = bearings(tau=5.0, split=0.2).doubts
    assert doubt == "the bearings do not close together (20 % of the clearance)"
    assert bearings(split=0.2).row()["split"] == 0.2


def test_the_interval_that_pin_bearings_lack_is_a_doubt() -> None:
    """Before those on the estimate; single bearings have it as well."""
    scanned = cross(bearings(turn_through=0.1))
    doubt, _ = scanned.doubts
    assert np.isnan([scanned.least, scanned.greatest]).all()
    assert "no interval is known: simulate" in doubt and doubt in scanned.summary
    assert scanned.by_bearing()["a+"].doubts[0] == doubt


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
    assert text.splitlines()[1].startswith("- a+, a-, b+, b- of cross: 4000 N estimated; 50 N")


def test_each_bearing_has_its_share() -> None:
    item = bearings(turn_through=0.5)
    scanned = cross(item)
    found = scanned.by_bearing()
    assert list(found) == ["a+", "a-", "b+", "b-"]
    peaks = [one.reversals[0].peak for one in found.values()]
    # Of b+, 50 N are there without clearance.
    assert peaks == pytest.approx([3000.0, 3000.0, 50.0 + 0.75 * 1950.0, 1500.0])
    assert scanned.peak == max(one.peak for one in found.values())
    assert [found[name].rigid_peak for name in found] == pytest.approx([0.0, 0.0, 50.0, 0.0])
    powers = [one.impact_power for one in found.values()]
    assert sum(powers) == pytest.approx(scanned.impact_power) and powers[0] == 4.0 * powers[2]
