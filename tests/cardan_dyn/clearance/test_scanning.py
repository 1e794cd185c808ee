"""Scans of whole mechanisms."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn import AccuracyError, ArgumentError, IndeterminateError, ModelError
from cardan_dyn.analytic import impact
from cardan_dyn.analytic.damped_impact import damped_peak, flight
from cardan_dyn.clearance import Scan, scan, simulate

pytestmark = pytest.mark.usefixtures("loaded_once")

CONTACT: dict[str, Any] = {"clearance": 1e-4, "stiffness": 1e8}


@pytest.fixture(scope="module")
def drive() -> cd.Scene:
    return cd.Scene(cd.load("needle_drive"), drive="main_shaft")


@pytest.fixture(scope="module")
def found(drive: cd.Scene) -> Scan:
    return scan(drive, 300.0, damping_ratio=0.25, **CONTACT)


@pytest.mark.slow
def test_every_pin_is_scanned_and_the_guide_is_not(drive: cd.Scene, found: Scan) -> None:
    assert set(found) | set(found.left_out) == set(drive.mechanism.joints)
    assert list(found.left_out) == ["needle_guide"]
    peaks = [found[name].peak for name in found.ranking]
    assert peaks == sorted(peaks, reverse=True)
    assert "needle_guide: not scanned" in str(found)


def test_forces_are_those_of_the_sweep(drive: cd.Scene, found: Scan) -> None:
    pin = found["coupler_pin"]
    turn = drive.sweep(pin.position, 300.0)
    expected = turn["coupler_pin"].force[:, :2]
    # The force along the pin's axis is no part of it.
    np.testing.assert_allclose(np.linalg.norm(pin.force, axis=1), np.hypot(*expected.T), rtol=1e-12)
    assert pin.rigid_peak == pytest.approx(np.max(np.hypot(*expected.T)))


def test_estimates_are_those_of_the_closed_forms(drive: cd.Scene, found: Scan) -> None:
    """Slope and direction by differences of sweeps."""
    step = 1e-5
    for item in found["rocker_bearing"].reversals:
        near = drive.sweep(item.position + np.array([-step, step]), 300.0)
        forces = near.wrench("rocker_bearing", "world").force
        rate = (forces[1] - forces[0]) / (2.0 * step) * 300.0
        rate[2] = 0.0  # Along the pin, where clearance does nothing.
        np.testing.assert_allclose(item.force_slope * item.direction, rate, rtol=1e-6, atol=1.0)
        contact = item.reduced_mass, 1e8, 0.5e-4, item.force_slope
        undamped = impact.reversal(*contact, start="release")
        # The joint's damper as a fraction of this reversal's critical damping.
        ratio = item.damping / (2.0 * np.sqrt(1e8 * item.reduced_mass))
        assert ratio == pytest.approx(0.25, rel=0.02)
        flown = flight(*contact, ratio)
        assert item.contact_time == pytest.approx(float(flown.t_1))
        assert item.impact_speed == pytest.approx(float(flown.v_1))
        assert item.tau == pytest.approx(float(undamped.tau))
        assert item.two_mass_peak == pytest.approx(float(damped_peak(*contact, ratio)))
        assert item.rigid + item.added == pytest.approx(float(undamped.peak))
        assert item.energy == pytest.approx(0.5 * contact[0] * item.strike_speed**2)
    power = sum(item.energy for item in found["rocker_bearing"].reversals) * 300.0 / (2.0 * np.pi)
    assert found["rocker_bearing"].impact_power == pytest.approx(power)


def test_turning_backwards_mirrors_nothing_but_the_way(drive: cd.Scene, found: Scan) -> None:
    """Inertia forces depend on the square of the speed; flights go the other way."""
    back = scan(drive, -300.0, damping_ratio=0.25, **CONTACT)
    for name in found:
        there = {round(item.position, 6): item for item in found[name].reversals}
        for item in back[name].reversals:
            same = there[round(item.position, 6)]
            assert item.two_mass_peak == pytest.approx(same.two_mass_peak, rel=1e-6)
            np.testing.assert_allclose(item.direction, -same.direction, atol=1e-6)


def test_play_and_stiffness_by_name_and_rotors(drive: cd.Scene, found: Scan) -> None:
    clearance, stiffness = {"coupler_pin": 1e-4}, {"coupler_pin": 1e8}
    options = {"joints": ["coupler_pin"], "damping_ratio": 0.25}
    one = scan(drive, 300.0, clearance=clearance, stiffness=stiffness, **options)
    assert one["coupler_pin"].peak == pytest.approx(found["coupler_pin"].peak, rel=1e-12)
    held = one["coupler_pin"].reversals[0].reduced_mass
    masses = [
        scan(drive, 300.0, clearance=clearance, stiffness=stiffness, rotor=inertia, **options)[
            "coupler_pin"
        ]
        .reversals[0]
        .reduced_mass
        for inertia in (0.0, 1e5)
    ]
    assert masses[0] < held
    assert masses[1] == pytest.approx(held, rel=1e-5)


def test_one_name_is_one_joint_and_forces_cannot_be_changed(drive: cd.Scene) -> None:
    one = scan(drive, 300.0, joints="coupler_pin", **CONTACT)
    assert list(one) == ["coupler_pin"]
    with pytest.raises(ValueError, match="read-only"):
        one["coupler_pin"].force[0] = 0.0


def test_tables(found: Scan) -> None:
    frame = found.to_dataframe()
    assert len(frame) == sum(len(found[name].reversals) for name in found)
    assert frame.joint[0] == found.ranking[0]
    assert {"position", "tau", "peak", "doubts", "direction_x", "verdict"} <= set(frame.columns)
    worst = found[found.ranking[0]].worst
    assert worst is not None
    row = frame[frame.peak == worst.peak].iloc[0]
    for name, exponent in worst.exponents._asdict().items():
        assert row[f"exponent_{name}"] == exponent


@pytest.mark.slow
def test_joints_are_ranked_by_their_peaks_whether_they_strike_or_not() -> None:
    scene = cd.Scene(cd.load("slider_crank"), drive="crank_bearing", loads={"piston_guide": -300.0})
    found = scan(scene, 120.0, damping_ratio=0.25, **CONTACT)
    peaks = [found[name].peak for name in found.ranking]
    assert peaks == sorted(peaks, reverse=True)
    # One that does not strike stands before one that does.
    strikes = [found[name].impacts > 0 for name in found.ranking]
    assert strikes != sorted(strikes, reverse=True)


@pytest.mark.slow
def test_pins_that_never_part_press_by_more_than_without_clearance(
    drive: cd.Scene, found: Scan
) -> None:
    """Their forces turn through with ρ = 0.17 and 0.21; nothing parts in the whole mechanism."""
    for name in ("main_shaft", "eccentric_pin"):
        joint = found[name]
        assert all(0.1 < item.turn_through < 0.3 for item in joint.reversals)
        assert joint.impact_power == 0.0 and joint.impacts == 0
        assert joint.verdict.startswith("no impact: the pin slides round along its wall")
        simulated = simulate(
            drive, 300.0, joints=name, turns=2.2, rtol=1e-6, damping_ratio=0.25, **CONTACT
        )[name]
        assert simulated.struck == ()
        settled = simulated.force[simulated.position > 1.2 * 2.0 * np.pi]
        assert 1.1 * joint.rigid_peak < joint.least < np.max(settled) < joint.greatest
        # A simulation tells of it as well, though nothing began to strike.
        assert np.max(settled) <= simulated.peak
        assert joint.peak == joint.greatest and f"{joint.peak:.4g} N at most" in joint.summary


@pytest.mark.parametrize("speed", [67.36471, 81.798784, 91.389688])
def test_peaks_do_not_jump_where_reversals_come_and_impacts_go(speed: float) -> None:
    """There a third impact ends, a fourth reversal comes (ρ = 1), and the last impact ends."""
    rig = cd.Scene(cd.load("four_bar"), drive="crank_bearing", loads={"rocker_bearing": -10.0})
    response, contact = rig.response(), {"clearance": 1e-4, "stiffness": 1e7, "damping_ratio": 0.2}
    below, above = (
        scan(response, speed * (1.0 + part), joints="rocker_bearing", **contact)["rocker_bearing"]
        for part in (-1e-6, 1e-6)
    )
    assert (len(below.reversals), below.impacts) != (len(above.reversals), above.impacts)
    for name in ("peak", "least", "greatest", "rigid_peak"):
        assert getattr(above, name) == pytest.approx(getattr(below, name), rel=1e-3)


def test_where_a_force_turns_through_the_interval_counts_and_not_the_two_mass_peak() -> None:
    scene = cd.Scene(cd.load("slider_crank"), drive="crank_bearing")
    found = scan(scene, 150.0, joints="piston_pin", damping_ratio=0.25, **CONTACT)
    joint = found["piston_pin"]
    assert all(item.turn_through > 0.1 and item.strikes for item in joint.reversals)
    for item in joint.reversals:
        assert item.peak == item.greatest < item.estimate < item.two_mass_peak
        assert "the pin does not move along a line" in item.doubts[0]


def test_a_force_that_rotates_with_the_drive_never_swings_round() -> None:
    """An unbalanced rotor: the force has one size, but for rounding."""
    rotor = cd.load(
        '<robot name="rotor"><link name="ground"/><link name="disc"><inertial><origin '
        'xyz="0.0123 0.0031 0.2"/><mass value="3.7"/><inertia ixx=".01" iyy=".01" izz=".02" '
        'ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="bearing" type="continuous">'
        '<parent link="ground"/><child link="disc"/><origin rpy="0.3 0.7 0.1"/>'
        '<axis xyz="0.36 0.48 0.8"/></joint></robot>'
    )
    found = scan(cd.Scene(rotor, drive="bearing"), 100.0, **CONTACT)["bearing"]
    assert np.ptp(np.linalg.norm(found.force, axis=1)) < 1e-9 * found.rigid_peak
    assert found.reversals == () and found.turning == 0
    assert found.verdict.startswith("no reversal: the force never swings round")


@pytest.mark.slow
def test_verification_puts_simulations_beside(drive: cd.Scene) -> None:
    contact: dict[str, Any] = {**CONTACT, "damping_ratio": 0.25, "joints": ["needle_pin"]}
    found = scan(drive, 300.0, verify=True, **contact)
    assert found.verified is not None and not found.unverified
    assert [item.joint for item in found.verified] == ["needle_pin"] * 2
    for item, row in zip(found.verified, found.rows(), strict=True):
        assert row["simulated"] == pytest.approx(np.max(item.simulated))
        assert row["least"] <= row["simulated"] <= row["greatest"]
    assert "beside" in str(found) and "needle_pin at" in str(found)
    pin = found["needle_pin"]
    assert pin.simulated == {"needle_pin": max(np.max(item.simulated) for item in found.verified)}
    plain = scan(drive, 300.0, **contact)
    assert plain.verified is None and "simulated" not in plain.rows()[0]
    with pytest.raises(ArgumentError, match="expected a scene"):
        scan(drive.response(), 300.0, verify=True, **contact)


@pytest.mark.parametrize(
    ("change", "said"), [({"rotor": 2.0}, "gives way"), ({"stiffness": 1e14}, "so stiff a contact")]
)
def test_where_no_interval_is_known_an_estimate_is_doubted(
    drive: cd.Scene, change: dict[str, Any], said: str
) -> None:
    """At once: what cannot be followed is not tried."""
    given: dict[str, Any] = {**CONTACT, "damping_ratio": 0.25, "joints": "needle_pin", **change}
    joint = scan(drive, 300.0, **given)["needle_pin"]
    assert said in joint.doubts[0] and joint.doubts[0] in joint.summary
    assert np.isnan([joint.least, joint.greatest]).all()
    for item in joint.reversals:
        assert np.isnan([item.least, item.greatest]).all()
        assert item.peak == item.estimate
    assert joint.peak == max(item.estimate for item in joint.reversals)
    assert joint.summary.startswith(f"{joint.peak:.4g} N estimated; ")


def test_copies_know_what_pins_did(drive: cd.Scene) -> None:
    found = scan(drive, 300.0, joints="needle_pin", damping_ratio=0.25, **CONTACT)
    again = pickle.loads(pickle.dumps(found))
    items, copies = (one["needle_pin"].reversals for one in (found, again))
    for one, other in zip(items, copies, strict=True):
        assert (one.least, one.greatest) == (other.least, other.greatest)
        assert one.least < one.greatest


def test_exponents_are_those_of_other_scans(drive: cd.Scene, found: Scan) -> None:
    """A per mille more of speed, clearance and stiffness in scans of the whole mechanism."""
    step = 1e-3
    options: dict[str, Any] = {"speed": 300.0, "joints": "rocker_pin", "damping_ratio": 0.25}
    for name in ("speed", "clearance", "stiffness"):
        peaks = []
        for factor in np.exp([-step, step]):
            given = {**options, **CONTACT}
            given[name] *= factor
            peaks.append(scan(drive, **given)["rocker_pin"].reversals[0].two_mass_peak)
        expected = np.log(peaks[1] / peaks[0]) / (2.0 * step)
        exponents = found["rocker_pin"].reversals[0].exponents
        assert getattr(exponents, name) == pytest.approx(expected, rel=1e-5)


def test_numbers_that_overflow_are_named(drive: cd.Scene) -> None:
    with pytest.raises(AccuracyError, match="the accelerations of the joints cannot be computed"):
        scan(drive, 1e200, **CONTACT)
    with pytest.raises(ArgumentError, match="speed² is so great that wrenches overflow"):
        scan(drive.response(), 1e200, **CONTACT)


@pytest.mark.parametrize(
    ("change", "error", "match"),
    [
        ({"clearance": 0.0}, ArgumentError, "clearance is 0"),
        ({"clearance": float("nan")}, ArgumentError, "clearance"),
        ({"stiffness": -1.0}, ArgumentError, "stiffness is -1"),
        ({"clearance": {"coupler_pin": 1e-4}}, ArgumentError, "clearance has no value for joint"),
        ({"speed": 0.0}, ArgumentError, "speed is 0"),
        ({"joints": 3}, ArgumentError, "joints is 3"),
        ({"joints": []}, ArgumentError, "joints is empty"),
        ({"joints": ["coupler_pin"] * 2}, ArgumentError, "names a joint twice"),
        ({"clearance": 0.2}, ArgumentError, "no less than the mechanism of 0.15 m"),
        ({"stiffness": 1e3}, ArgumentError, "farther than the mechanism is long"),
        ({"stiffness": 1e300}, ArgumentError, "impacts overflow"),
        ({"start": np.array([1.0, 2.0])}, ArgumentError, "start is"),
        ({"verify": 1}, ArgumentError, "verify is 1"),
        ({"joints": ["needle_guide"]}, ModelError, "has no pin"),
        ({"joints": ["needle"]}, ModelError, "needle"),
        ({"damping_ratio": 1.0}, ArgumentError, "damping_ratio"),
        ({"start": "run"}, ArgumentError, "start is 'run'"),
        ({"rotor": -1.0}, ArgumentError, "rotor"),
    ],
)
def test_bad_input(drive: cd.Scene, change: dict[str, Any], error: Any, match: str) -> None:
    with pytest.raises(error, match=match):
        scan(drive, **{"speed": 300.0, **CONTACT, **change})


def test_scenes_that_cannot_strike(joint: cd.Mechanism, found: Scan) -> None:
    two = cd.Scene(joint, drive=["bearing_in", "joint_angle"], near={"joint_angle": 0.3})
    with pytest.raises(ArgumentError, match="several drives"):
        scan(two, 10.0, **CONTACT)
    one = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.3})
    with pytest.raises(IndeterminateError, match="statically indeterminate"):
        scan(one, 10.0, joints=["pin_in"], **CONTACT)
    assert "statically indeterminate" in scan(one, 10.0, **CONTACT).left_out["pin_in"]
    with pytest.raises(ModelError, match="was not scanned"):
        found["needle_guide"]
    with pytest.raises(ModelError, match="'nothing'"):
        found["nothing"]


@pytest.mark.slow
def test_ctrl_c_ends_all_simulations_and_keeps_the_estimates(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    count = 0

    def press(progress: object, time: float) -> None:
        nonlocal count
        count += 1
        raise KeyboardInterrupt

    monkeypatch.setattr("cardan_dyn.motion.simulation.progress.Progress.step", press)
    scene = cd.Scene(cd.load("needle_drive"), drive="main_shaft")
    found = cd.clearance.scan(scene, 300.0, clearance=1e-4, stiffness=1e8, verify=True)
    assert count == 1
    assert len(found.worst) > 1 and found.verified is not None and not len(found.verified)
    text = " ".join((str(found), *found.notes, *map(str, found.left_out.values())))
    assert "interrupted" in text
