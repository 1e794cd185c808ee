"""Scans of universal joints with clearance, against Thoma's moments and closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from testkit.pin_rigs import THETA, compound, displaced, doubled, rig, scene

import cardan_dyn as cd
from cardan_dyn import ArgumentError, IndeterminateError, ModelError
from cardan_dyn.analytic import impact, single_joint
from cardan_dyn.analytic.damped_impact import damped_peak, flight
from cardan_dyn.clearance import JointScan, PinGeometry, scan

BETA, SPEED, RADIUS = np.radians(20.0), 150.0, 0.05
GIVEN: dict[str, Any] = {"radius": RADIUS, "clearance": 1e-5, "stiffness": 1e8}
GREATEST = float(THETA * SPEED**2 * single_joint.greatest_acceleration(BETA))
"""Torque that the flywheel takes at most [N m]."""


def scan_pins(turn: cd.Scene, speed: float, joint: str, **given: Any) -> JointScan:
    return scan(turn, speed, joints=joint, **given)[joint]


def passed_on(phi: np.ndarray) -> np.ndarray:
    """e₂ · n: what part of the cross's moment is the torque of shaft 2."""
    return np.asarray(np.sqrt(1.0 - (np.sin(BETA) * np.cos(phi)) ** 2))


def slope(phi: float) -> float:
    """Rate of the moment at a reversal of the flywheel alone, M' Ω [N m/s], from Thoma's series."""
    kappa, n = np.tan(0.5 * BETA) ** 2, np.arange(1, 40)
    jerk = -np.sum(8.0 * n**2 * kappa**n * np.cos(2.0 * n * phi))
    return float(THETA * SPEED**3 * jerk / passed_on(np.array(phi)))


@pytest.mark.parametrize(("bearings", "load"), [("pin_in", 2.0), ("pin_out", 0.0), (None, 0.0)])
def test_bearings_carry_the_flywheel_and_the_load(bearings: str | None, load: float) -> None:
    """P = M/(2r) with M = (Θ φ₂'' + T)/(e₂ · n)."""
    found = scan_pins(scene("thoma_rig", BETA, -load), SPEED, "cross", bearings=bearings, **GIVEN)
    phi = found.position
    torque = THETA * SPEED**2 * single_joint.acceleration_ratio(BETA, phi) + load
    expected = np.abs(torque / passed_on(phi)) / (2.0 * RADIUS)
    sizes = np.linalg.norm(found.force, axis=2)
    for column in sizes.T:
        np.testing.assert_allclose(column, expected, rtol=0.0, atol=1e-10 * np.max(expected))
    assert found.bearings[::2] == tuple(
        f"{pin}+" for pin in ("pin_in", "pin_out") if bearings in (None, pin)
    )
    assert found.rigid_peak == pytest.approx(np.max(expected), rel=1e-10)


@pytest.mark.parametrize("name", ["pin_in", "pin_out"])
@pytest.mark.parametrize("start", ["release", "rest"])
def test_one_pin_by_closed_forms(name: str, start: Any) -> None:
    """m = J/(2r²), J = Θ/(e₂·n)², of a bearing with the force P."""
    options: dict[str, Any] = {"bearings": name, "start": start, **GIVEN}
    found = scan_pins(scene("thoma_rig", BETA), SPEED, "cross", **options)
    assert found.freedoms == 2
    assert found.torsional_clearance == pytest.approx(1e-5 / RADIUS)
    quarters = 0.5 * np.pi * np.arange(4)
    positions = [item.position for item in found.reversals]
    np.testing.assert_allclose(positions, quarters, atol=1e-12)
    for item in found.reversals:
        mass = THETA / passed_on(np.array(item.position)) ** 2 / (2.0 * RADIUS**2)
        assert item.reduced_mass == pytest.approx(mass, rel=1e-10)
        assert item.force_slope == pytest.approx(abs(slope(item.position)) / (2 * RADIUS), rel=1e-9)
        expected = impact.reversal(mass, 1e8, 0.5e-5, item.force_slope, start=start)
        assert item.contact_time == pytest.approx(float(expected.t_1), rel=1e-9)
        assert item.impact_speed == pytest.approx(float(expected.v_1), rel=1e-9)
        assert item.tau == pytest.approx(float(expected.tau), rel=1e-9)
        assert item.two_mass_peak == pytest.approx(float(expected.peak), rel=1e-9)
        struck = passed_on(np.array(item.position + SPEED * float(expected.t_1)))
        change = (passed_on(np.array(item.position)) / struck) ** 2 - 1.0
        assert item.mass_change == pytest.approx(change, rel=1e-6) != 0.0
        # Both bearings strike: r ψ' of the inertia J.
        turning = item.impact_speed / RADIUS
        inertia = THETA / passed_on(np.array(item.position)) ** 2
        assert item.energy == pytest.approx(0.5 * inertia * turning**2, rel=1e-9)
        assert item.share == pytest.approx((1.0, 1.0))
        assert item.turn_through < 1e-10
        assert item.split < 1e-10
        assert item.deviation < 1e-7
    power = SPEED / (2.0 * np.pi) * sum(item.energy for item in found.reversals)
    assert found.impact_power == pytest.approx(power)


def test_both_pins_act_in_series() -> None:
    """ψ = s₁/r₁ + s₂/r₂ each way and 1/k = Σ 1/(2 c r²), as one torsional spring with clearance."""
    radius, clearance = {"pin_in": 0.05, "pin_out": 0.04}, {"pin_in": 1e-5, "pin_out": 2e-5}
    stiffness = {"pin_in": 1e8, "pin_out": 6e7}
    found = scan_pins(
        scene("thoma_rig", BETA),
        SPEED,
        "cross",
        radius=radius,
        clearance=clearance,
        stiffness=stiffness,
        damping_ratio=0.2,
    )
    assert found.freedoms == 5
    turn = sum(clearance[pin] / radius[pin] for pin in radius)
    assert found.torsional_clearance == pytest.approx(turn)
    spring = 1.0 / sum(1.0 / (2.0 * stiffness[pin] * radius[pin] ** 2) for pin in radius)
    for item in found.reversals:
        inertia = THETA / passed_on(np.array(item.position)) ** 2
        torsional = inertia, spring, 0.5 * turn, abs(slope(item.position))
        # One damper, whatever the inertia is.
        ratio = item.damping / (2.0 * np.sqrt(item.stiffness * item.reduced_mass))
        moment = float(damped_peak(*torsional, ratio))
        assert item.two_mass_peak == pytest.approx(moment / (2.0 * 0.04), rel=1e-9)
        expected = impact.reversal(*torsional, start="release")
        assert item.tau == pytest.approx(float(expected.tau), rel=1e-9)
        flown = flight(*torsional, ratio)
        assert item.contact_time == pytest.approx(float(flown.t_1), rel=1e-9)
        assert item.energy == pytest.approx(0.5 * inertia * float(flown.v_1) ** 2, rel=1e-9)
        assert item.share == pytest.approx((0.8, 0.8, 1.0, 1.0))
        assert item.split < 1e-10


@pytest.mark.parametrize(("part", "count"), [(0.0, 4), (0.95, 4), (1.05, 0)])
def test_the_torque_reverses_four_times_a_turn_or_never(part: float, count: int) -> None:
    """Below the inertia torque a load is overcome in each quarter, above it never."""
    loaded = scene("thoma_rig", BETA, -part * GREATEST)
    found = scan_pins(loaded, SPEED, "cross", bearings="pin_in", **GIVEN)
    assert len(found.reversals) == count
    assert found.impacts in (0, count)
    if count:
        positions = np.array([item.position for item in found.reversals])
        torque = THETA * SPEED**2 * single_joint.acceleration_ratio(BETA, positions)
        np.testing.assert_allclose(torque, -part * GREATEST, atol=1e-8 * GREATEST)
    else:
        assert "no reversal" in found.verdict
        assert found.peak == found.rigid_peak


def test_a_straight_joint_without_load_carries_nothing() -> None:
    found = scan_pins(scene("thoma_rig", 0.0), SPEED, "cross", **GIVEN)
    assert found.reversals == ()
    assert found.turning == 0
    assert found.rigid_peak < 1e-9


def test_a_constant_torque_never_swings() -> None:
    found = scan_pins(scene("thoma_rig", 0.0, -5.0), SPEED, "cross", bearings="pin_out", **GIVEN)
    assert found.reversals == ()
    assert found.turning == 0
    assert found.rigid_peak == pytest.approx(5.0 / (2.0 * RADIUS))


@pytest.mark.slow
def test_other_descriptions_of_the_same_joint() -> None:
    """As one joint of type universal, and with joints elsewhere on their pins.

    The displaced origins change the force through the cross that statics leaves open and least norm
    chooses; nothing of it is felt where bearings have clearance.
    """
    expected = scan_pins(scene("thoma_rig", BETA), SPEED, "cross", bearings="pin_out", **GIVEN)
    options = {"bearings": "coupling.turn_2", **GIVEN}
    found = [
        scan_pins(scene(compound(), BETA), SPEED, "coupling", **options),
        scan_pins(scene(displaced(), BETA), SPEED, "cross", bearings="pin_out", **GIVEN),
    ]
    for item in found:
        scale = 1e-9 * expected.rigid_peak
        np.testing.assert_allclose(item.force, expected.force, rtol=0.0, atol=scale)
        # Joints beside the centre turn rounding of positions into 1e-11 of accelerations, of which
        # a peak has the slope.
        peaks = [reversal.peak for reversal in item.reversals]
        assert peaks == pytest.approx([reversal.peak for reversal in expected.reversals], rel=1e-8)


@pytest.mark.slow
def test_a_response_gives_the_numbers_of_a_sweep() -> None:
    turn = scene(rig(0.5, (1.5e-4, 1.5e-4, 3e-4)), BETA, -1.0)
    expected = scan_pins(turn, SPEED, "cross", bearings="pin_in", **GIVEN)
    found = scan(turn.response(), SPEED, joints="cross", bearings="pin_in", **GIVEN)["cross"]
    scale = 1e-9 * expected.rigid_peak
    np.testing.assert_allclose(found.force, expected.force, rtol=0.0, atol=scale)
    assert len(found.reversals) == 4
    for one, two in zip(found.reversals, expected.reversals, strict=True):
        assert one.peak == pytest.approx(two.peak, rel=1e-9)
        assert one.slope_growth == pytest.approx(two.slope_growth, rel=1e-6)


@pytest.mark.slow
def test_a_geometry_decides_the_stiffness_of_bearings_at_the_peak() -> None:
    """Of a pin whose bearings carry the same, as of a number that is that stiffness."""
    pin = PinGeometry(0.02, 0.01, seat_stiffness=5e7)
    given: dict[str, Any] = {**GIVEN, "bearings": "pin_in", "damping_ratio": 0.2}
    found = scan_pins(scene("thoma_rig", BETA), SPEED, "cross", **{**given, "stiffness": pin})
    item = found.reversals[0]
    stiffness = float(pin.stiffness(np.array(item.two_mass_peak), GIVEN["clearance"]))
    assert item.stiffness == pytest.approx(stiffness, rel=1e-9)
    same = scan_pins(scene("thoma_rig", BETA), SPEED, "cross", **{**given, "stiffness": stiffness})
    assert same.reversals[0].peak == pytest.approx(item.peak, rel=1e-9)
    for name, one in found.by_bearing().items():
        assert one.bearings == (name,)
        assert one.reversals[0].stiffness == pytest.approx(stiffness, rel=1e-9)


def test_one_damper_for_all_reversals_of_a_joint() -> None:
    """Of the mean mass, which lies between those of the reversals at 0° and 90°."""
    given: dict[str, Any] = {**GIVEN, "bearings": "pin_in", "damping_ratio": 0.2}
    found = scan_pins(scene("thoma_rig", BETA), SPEED, "cross", **given)
    masses = [item.reduced_mass for item in found.reversals]
    assert min(masses) < found.mean_mass < max(masses)
    wanted = 0.4 * np.sqrt(1e8 * found.mean_mass)
    assert [item.damping for item in found.reversals] == pytest.approx([wanted] * 4)


def test_what_is_ahead_of_a_reversal_and_how_far() -> None:
    found = scan_pins(scene("thoma_rig", BETA), SPEED, "cross", bearings="pin_in", **GIVEN)
    for item in found.reversals:
        assert item.way == pytest.approx(0.5 * np.pi, abs=1e-9)
        assert item.rigid_ahead == pytest.approx(found.rigid_peak, rel=1e-3)
        assert item.ahead == pytest.approx((item.rigid_ahead,) * 2)
        assert item.estimate >= item.rigid_ahead


@pytest.mark.slow
def test_backwards_and_with_a_rotor() -> None:
    still = scene("thoma_rig", BETA)
    one = scan_pins(still, SPEED, "cross", bearings="pin_in", **GIVEN)
    back = scan_pins(still, -SPEED, "cross", bearings="pin_in", **GIVEN)
    assert back.peak == pytest.approx(one.peak, rel=1e-9)
    masses = [
        scan_pins(still, SPEED, "cross", bearings="pin_in", rotor=inertia, **GIVEN)
        .reversals[1]
        .reduced_mass
        for inertia in (0.0, 1e9)
    ]
    # A drive that gives way lets the pulley move as well, in series with the flywheel.
    pulley, phi = 0.596500714005, 0.5 * np.pi
    ratio = float(single_joint.speed_ratio(BETA, phi))
    assert masses[1] == pytest.approx(one.reversals[1].reduced_mass, rel=1e-6)
    own = THETA / float(passed_on(np.array(phi))) ** 2
    input_side = pulley / (ratio * float(passed_on(np.array(phi)))) ** 2
    expected = 1.0 / (1.0 / own + 1.0 / input_side) / (2.0 * RADIUS**2)
    assert masses[0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.slow
def test_a_cross_with_mass_moves_where_its_inertia_pulls() -> None:
    """A cross as flat as a disc follows the joint by itself; a compact one has to be tilted."""
    flat, compact = (
        scan_pins(scene(rig(0.5, inertia), BETA), SPEED, "cross", bearings="pin_in", **GIVEN)
        for inertia in ((1.5e-4, 1.5e-4, 3e-4), (1.5e-4, 1.5e-4, 1.5e-4))
    )
    assert all(item.doubts == () for item in flat.reversals)
    # What all pin bearings lack is the only doubt.
    (doubt,) = flat.doubts
    assert "no interval is known: simulate" in doubt
    doubts = ["; ".join(item.doubts) for item in compact.reversals]
    assert any("beside the force's direction" in text for text in doubts)
    assert any("turns through" in text for text in doubts)


def test_bearings_that_cannot_close_together_are_named() -> None:
    """With one bearing open on each pin the cross turns in one way; one bearing closes first."""
    clearance = {"pin_in": 1e-5, "pin_out": 4e-5}
    options = {**GIVEN, "clearance": clearance, "bearings": ("pin_in+", "pin_out+")}
    found = scan_pins(cd_scene("universal_joint"), SPEED, "cross", **options)
    assert found.freedoms == 1
    worst = found.worst
    assert worst is not None
    assert worst.split == pytest.approx((4.0 - 1.0) / np.sqrt(2.0 * (1.0 + 16.0)), rel=1e-6)
    assert any("do not close together (51 %" in text for text in worst.doubts)


def cd_scene(name: str) -> cd.Scene:
    return cd.Scene(cd.load(name), drive="bearing_in", held={"joint_angle": BETA})


def test_gravity_and_hanging_shafts() -> None:
    """Between two joints a shaft hangs in bearings that carry forces as well, which are unique."""
    line = cd.load("double_shaft_z")
    held = {"joint_angle_1": 0.2, "joint_angle_2": 0.2}
    hanging = cd.Scene(line, drive="bearing_in", held=held, gravity=(0.0, 0.0, -9.81))
    found = scan_pins(hanging, 100.0, "cross_1", bearings="pin_1_in", **GIVEN)
    assert found.freedoms == 4
    turn = hanging.sweep(found.position, 100.0)
    wrench = turn.wrench("pin_1_in", "world")
    axis = turn.rotation("pin_1_in") @ np.array(line.joint("pin_1_in").parts[0].axis)
    across = wrench.force - axis * np.sum(wrench.force * axis, axis=1, keepdims=True)
    np.testing.assert_allclose(np.sum(found.force, axis=1), across, atol=1e-8)
    assert np.max(np.abs(across)) > 10.0


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"clearance": 0.0}, ArgumentError, "clearance is 0, expected a positive number"),
        ({"clearance": -1e-5}, ArgumentError, "clearance is -1e-05"),
        ({"stiffness": np.inf}, ArgumentError, "stiffness"),
        ({"radius": np.nan}, ArgumentError, "radius"),
        (
            {"clearance": 0.06},
            ArgumentError,
            "clearance is 0.06 m, no less than the radius of 0.05 m",
        ),
        ({"radius": 1e-9}, ArgumentError, "radius is 1e-09 m; in a mechanism of"),
        ({"radius": None}, ArgumentError, "radius is None; give the distance of the bearings"),
        ({"radius": 1e200}, ArgumentError, r"radius is 1e\+200 m"),
        ({"radius": {"pin_in": 0.05}}, ArgumentError, "radius has no value for joint 'pin_out'"),
        ({"damping_ratio": 1.0}, ArgumentError, "damping_ratio is 1"),
        ({"start": "fast"}, ArgumentError, "start is 'fast'"),
        ({"rotor": -1.0}, ArgumentError, "rotor is -1"),
        ({"bearings": ()}, ArgumentError, "bearings names none of 'cross'"),
        ({"bearings": "pin"}, ModelError, "no bearing 'pin'"),
        ({"bearings": "pin_in+"}, ModelError, "alone nothing can move"),
        ({"joint": "bearing_in"}, ArgumentError, "radius belongs to universal joints; name one"),
        ({"joint": 3}, ArgumentError, "joint"),
        ({"speed": 0.0}, ArgumentError, "speed"),
    ],
)
def test_bad_input(changes: dict[str, Any], error: type[Exception], message: str) -> None:
    given = {"speed": SPEED, "joint": "cross", **GIVEN, **changes}
    with pytest.raises(error, match=message):
        scan_pins(scene("thoma_rig", BETA), given.pop("speed"), given.pop("joint"), **given)


@pytest.mark.slow
def test_what_cannot_be_decided_is_refused() -> None:
    with pytest.raises(IndeterminateError, match="its moment across the pin 'pin_in'"):
        scan_pins(scene(doubled(), BETA), SPEED, "cross", **GIVEN)
    hidden = cd.Scene(
        cd.load("thoma_rig"), drive="bearing_in", held={"joint_angle": BETA}, outputs=["pin_in"]
    )
    with pytest.raises(ModelError, match="joint 'pin_out' is no output"):
        scan_pins(hidden, SPEED, "cross", **GIVEN)
