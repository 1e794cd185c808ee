"""Whole mechanisms with clearance, against equations written by hand."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from testkit import pin_rigs
from testkit.loose_slider_crank import LooseSliderCrank

import cardan_dyn as cd
from cardan_dyn import clearance

SPEED, PLAY, STIFFNESS, DAMPING = 300.0, 2e-4, 1e8, 5e3


def scene() -> cd.Scene:
    return cd.Scene(cd.load("slider_crank"), drive="crank_bearing")


@pytest.fixture(scope="module")
def loose() -> clearance.ContactSimulation:
    law = cd.LinearContact(STIFFNESS, DAMPING)
    return clearance.simulate(
        scene(), SPEED, joints="crank_pin", clearance=PLAY, law=law, turns=1.2
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("speed", "gap", "stiffness", "damping", "position"),
    [(300.0, 2e-4, 1e8, 5e3, None), (40.0, 1e-3, 1e7, 0.0, 1.1)],
)
def test_slider_crank_moves_as_by_equations_written_by_hand(
    speed: float, gap: float, stiffness: float, damping: float, position: float | None
) -> None:
    law = cd.LinearContact(stiffness, damping)
    found = clearance.simulate(
        scene(), speed, joints="crank_pin", clearance=gap, law=law, turns=0.7, position=position,
        rtol=1e-11,
    )  # fmt: skip
    # Bounces without damping are chaotic: the first three impacts are compared.
    struck = found["crank_pin"].struck
    times = np.linspace(0.0, found.time[-1] if damping else struck[3].start, 400)
    begun = found.trajectory.at([0.0])
    angle = begun.motion.position("crank_bearing")[0]
    motion = begun.motion
    turn, rate = (of("crank_pin")[0, 2] for of in (motion.position, motion.velocity))
    guide = motion.position("piston_guide")[0], motion.velocity("piston_guide")[0]
    hand = LooseSliderCrank.bundled(speed, gap, stiffness, damping)
    start = np.array([0.195 + guide[0], angle + turn, guide[1], speed + rate])
    expected = hand.forces(angle, start, times)
    force = found.at(times)["crank_pin"].force
    np.testing.assert_allclose(force, expected, atol=1e-6 * np.max(expected))
    if not damping:
        # It bounces: forces of zero are among those that agree.
        assert np.count_nonzero(expected == 0.0) > 20


@pytest.mark.slow
def test_what_presses_is_the_force_of_the_other_joints(loose: clearance.ContactSimulation) -> None:
    """The wall's force on the rod and that of the piston pin accelerate the rod."""
    at = loose.evenly(50)
    sweep = at.trajectory.sweep
    assert np.max(sweep.balance_residual) < 1e-9
    assert at.trajectory.effort_residual < 1e-9
    np.testing.assert_allclose(
        np.linalg.norm(at["crank_pin"].vector, axis=1), at["crank_pin"].force, rtol=1e-12
    )


@pytest.mark.slow
def test_energy_is_accounted_for(loose: clearance.ContactSimulation) -> None:
    assert 0.0 < loose.energy_residual < 1e-6


@pytest.mark.campaign
@pytest.mark.slow
def test_impacts_hold_the_greatest_force() -> None:
    law = cd.LinearContact(1e7, 20.0)
    found = clearance.simulate(
        scene(), 40.0, joints="crank_pin", clearance=1e-3, law=law, position=1.1
    )
    course = found.evenly(20_001)["crank_pin"]
    assert course.peak == pytest.approx(np.max(course.force), rel=1e-3)
    assert course.peak >= np.max(course.force[course.time > course.struck[0].start])
    for impact in course.struck:
        inside = (course.time > impact.start) & (course.time < impact.end)
        assert np.all(course.force[inside] >= 0.0)
        assert np.max(course.force[inside], initial=0.0) <= impact.peak * (1.0 + 1e-9)
        assert np.linalg.norm(impact.direction) == pytest.approx(1.0)
    free = course.force == 0.0
    # Where the pin leaves faster than the wall follows, it is still a little in it.
    fastest = max(impact.speed for impact in course.struck)
    assert np.any(free) and np.all(course.depth[free] < 20.0 * fastest / 1e7)
    frame = found.to_dataframe()
    assert list(frame["start"]) == sorted(frame["start"])
    assert f"{len([i for i in course.struck if i.speed > 0])} impacts" in str(found)


@pytest.mark.campaign
@pytest.mark.slow
def test_no_contact_is_missed() -> None:
    """The same impacts with steps a hundred times smaller, from the first flight on."""
    law = cd.LinearContact(1e7, 20.0)
    arguments = {
        "joints": "crank_pin",
        "clearance": 1e-3,
        "law": law,
        "position": 1.1,
        "turns": 0.18,
    }
    found = clearance.simulate(scene(), 40.0, **arguments)
    few = found.trajectory

    contact = few.problem.elements[0]
    tight = cd.PinContact(
        **{name: getattr(contact, name) for name in cd.PinContact.__dataclass_fields__}
    )
    opened = cd.Scene(few.mechanism, drive=few.drives, free=few.free, elements=[tight])
    struck = [item for item in few.touches if item.start > 0.0][:2]
    start = struck[0].start - 2e-4
    begun = few.at([start])
    fine = opened.simulate(
        struck[1].end + 2e-4 - start,
        position=dict(zip(few.coordinates, begun.position[0], strict=True)),
        speed=dict(zip(few.free, begun.speed[0, 1:], strict=True)),
        motion={"crank_bearing": 40.0},
        step=float(np.median(np.diff(few.time))) / 100.0,
    )
    during = (few.time > start) & (few.time < struck[1].end)
    assert len(fine.time) > 50 * np.count_nonzero(during)
    assert len(fine.touches) == 2
    for item, other in zip(fine.touches, struck, strict=True):
        assert item.start + start == pytest.approx(other.start, abs=1e-10)
        assert item.peak == pytest.approx(other.peak, rel=1e-6)


@pytest.mark.campaign
@pytest.mark.slow
def test_damped_peaks_converge_over_a_turn_and_undamped_ones_for_three_impacts() -> None:
    needles = cd.Scene(cd.load("needle_drive"), drive="main_shaft")
    for damping, count in ((3e3, None), (0.0, 3)):
        law, peaks = cd.LinearContact(1e8, damping), []
        for rtol in (1e-10, 1e-12):
            found = clearance.simulate(
                needles, 300.0, joints="coupler_pin", clearance=1e-4, law=law, turns=1.0, rtol=rtol,
                max_touches=100_000 if count is None else count + 1,
            )  # fmt: skip
            peaks.append([item.peak for item in found["coupler_pin"].struck[:count]])
        assert len(peaks[0]) == len(peaks[1]) >= (count or 2)
        # Touches of a hundredth of the greatest force are brushes on the way.
        coarse, fine = np.array(peaks)
        np.testing.assert_allclose(coarse, fine, rtol=1e-5, atol=1e-7 * np.max(fine))
        assert any("only their distribution" in note for note in found.notes) == (damping == 0.0)


@pytest.mark.slow
def test_free_drive_gives_way_and_a_heavy_rotor_does_not() -> None:
    law = cd.LinearContact(1e8, 5e3)
    arguments = {
        "joints": "crank_pin",
        "clearance": 1e-4,
        "law": law,
        "turns": 0.5,
        "position": 0.3,
    }
    held = clearance.simulate(scene(), 100.0, **arguments)
    heavy = clearance.simulate(scene(), 100.0, rotor=1e6, **arguments)
    light = clearance.simulate(scene(), 100.0, rotor=0.0, **arguments)
    times = np.linspace(0.0, held.time[-1], 50)
    speeds = [item.at(times).trajectory.speed[:, 0] for item in (held, heavy, light)]
    np.testing.assert_allclose(speeds[0], 100.0, rtol=1e-12)
    np.testing.assert_allclose(speeds[1], 100.0, rtol=1e-6)
    assert np.ptp(speeds[2]) > 1.0
    assert light.energy_residual < 1e-6
    np.testing.assert_allclose(
        heavy.at(times)["crank_pin"].force, held.at(times)["crank_pin"].force, rtol=1e-3, atol=1.0
    )


@pytest.mark.slow
@pytest.mark.parametrize("joint", ["crank_bearing", "piston_pin"])
def test_driven_joints_and_loops_can_have_play(joint: str) -> None:
    found = clearance.simulate(
        scene(), 200.0, joints=joint, clearance=1e-4, stiffness=1e8, damping_ratio=0.3, turns=0.6
    )
    rigid = clearance.scan(
        scene(), 200.0, clearance=1e-4, stiffness=1e8, damping_ratio=0.3, joints=[joint]
    )
    course = found.evenly(300)[joint]
    tight = np.interp(
        course.position, rigid[joint].position, np.linalg.norm(rigid[joint].force, axis=1)
    )
    # It begins pressed, near the force without clearance.
    np.testing.assert_allclose(course.force[:10], tight[:10], rtol=0.02)
    assert found.energy_residual < 1e-6


@pytest.mark.slow
def test_two_joints_at_once_and_copies() -> None:
    found = clearance.simulate(
        scene(), 200.0, joints=["crank_pin", "piston_pin"], clearance={"crank_pin": 1e-4,
        "piston_pin": 5e-5}, stiffness=1e8, damping_ratio=0.3, turns=0.3,
    )  # fmt: skip
    assert list(found) == ["crank_pin", "piston_pin"]
    again = pickle.loads(pickle.dumps(found))
    for name in found:
        np.testing.assert_array_equal(again[name].force, found[name].force)
    assert found.energy_residual < 1e-6


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.parametrize("pins", [["pin_in"], ["pin_in", "pin_out"]])
def test_bearings_of_a_universal_joint_strike_in_pairs(pins: list[str]) -> None:
    """The cross hangs between both bearings of a pin: their forces are opposite and equal."""
    joint = cd.Scene(
        cd.load("universal_joint"), drive="bearing_in", held={"joint_angle": np.radians(20.0)}
    )
    reach = dict.fromkeys(pins, 0.03)
    law = cd.LinearContact(1e7, 1000.0)
    found = clearance.simulate(
        joint, 150.0, joints=pins, radius=reach, clearance=1e-4, law=law, turns=0.8
    )
    assert list(found) == [f"{pin}{side}" for pin in pins for side in "+-"]
    assert found.trajectory.energy_residual < 1e-8 and found.energy_residual < 1e-5
    at = found.evenly(200)
    for pin in pins:
        first, second = at[f"{pin}+"], at[f"{pin}-"]
        assert len(first.struck) >= 2
        scale = np.max(first.force)
        np.testing.assert_allclose(first.vector, -second.vector, atol=1e-6 * scale)
    # Their couple is what turns shaft 2, which nothing else does.
    if len(pins) == 1:
        shaft = at.trajectory.motion.acceleration("bearing_out")
        links = joint.mechanism.description.links
        inertia, light = (
            next(link for link in links if link.name == name).inertia[0, 0]
            for name in ("shaft_out", "cross")
        )
        axis = at.trajectory.sweep.rotation("bearing_out") @ np.array([1.0, 0.0, 0.0])
        arms = at.trajectory.sweep.rotation("pin_in") @ np.array([0.0, 0.03, 0.0])
        couple = 2.0 * np.cross(arms, at["pin_in+"].vector)
        # The cross is accelerated as well, about as fast.
        np.testing.assert_allclose(
            np.sum(couple * axis, axis=1),
            inertia * shaft,
            atol=2.0 * light * np.max(np.abs(shaft)),
        )
        assert light < 0.1 * inertia


@pytest.mark.slow
def test_it_ends_after_as_many_impacts_as_it_may() -> None:
    law = cd.LinearContact(1e7)
    found = clearance.simulate(
        scene(), 40.0, joints="crank_pin", clearance=1e-3, law=law, position=1.1, max_touches=3
    )
    assert found.reason == "3 touches of pins" and len(found.impacts) == 3
    assert "ended by: 3 touches" in str(found)


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"joints": "piston_guide"}, cd.ModelError, "it has no pin"),
        ({"joints": "nothing"}, cd.ModelError, "no joint 'nothing'"),
        ({"joints": 3}, cd.ArgumentError, "joints is 3"),
        ({"joints": []}, cd.ArgumentError, "joints is empty"),
        ({"joints": ["crank_pin", "crank_pin"]}, cd.ArgumentError, "twice"),
        ({"clearance": 0.0}, cd.ArgumentError, "clearance is 0, expected a positive number"),
        ({"clearance": np.nan}, cd.ArgumentError, "clearance"),
        ({"clearance": 0.2}, cd.ArgumentError, "no less than the mechanism of 0.15 m"),
        ({"joints": None}, cd.ArgumentError, "joints is None"),
        ({"clearance": {"piston_pin": 1e-4}}, cd.ArgumentError, "clearance has no value for joint"),
        (
            {"clearance": {"crank_pin": 1e-4, "pin": 1e-4}},
            cd.ArgumentError,
            "'pin', which is no joint",
        ),
        ({"stiffness": -1.0}, cd.ArgumentError, "stiffness is -1"),
        ({"stiffness": None}, cd.ArgumentError, "either law= or stiffness="),
        ({"law": cd.LinearContact(1e8)}, cd.ArgumentError, "either law= or stiffness="),
        ({"law": 3.0, "stiffness": None}, cd.ArgumentError, "expected a contact law"),
        ({"damping_ratio": 1.0}, cd.ArgumentError, "damping_ratio is 1"),
        ({"friction": -0.1}, cd.ArgumentError, "friction is -0.1"),
        ({"pin_radius": np.inf}, cd.ArgumentError, "pin_radius"),
        ({"radius": {"piston_pin": 0.1}}, cd.ArgumentError, "has no clearance"),
        ({"radius": {"crank_pin": 0.1}, "damping_ratio": 0.2}, cd.ArgumentError, "of_ratio"),
        ({"radius": {"crank_pin": 0.0}}, cd.ArgumentError, "expected a positive number"),
        ({"rotor": -1.0}, cd.ArgumentError, "rotor is -1"),
        ({"turns": 0.0}, cd.ArgumentError, "turns is 0"),
        ({"max_touches": 0}, cd.ArgumentError, "max_touches"),
        ({"stiffness": 1.0}, cd.ArgumentError, "too soft"),
    ],
)
def test_bad_input_is_refused(
    changes: dict[str, object], error: type[cd.CardanError], message: str
) -> None:
    arguments: dict[str, object] = {"joints": "crank_pin", "clearance": 1e-4, "stiffness": 1e8}
    with pytest.raises(error, match=message):
        clearance.simulate(scene(), 100.0, **{**arguments, **changes})  # type: ignore[arg-type]


def test_a_contact_gives_way_by_less_than_the_mechanism_is_long() -> None:
    """By the force without clearance; a scan draws the same line, by the greatest of a turn."""
    force = scene().sweep([0.8], 100.0)["crank_pin"].force[0]
    length = scene().mechanism.characteristic_length
    limit = float(np.linalg.norm(force)) / length
    given = {"joints": "crank_pin", "clearance": 1e-5, "position": 0.8, "turns": 1e-6}
    soft = clearance.simulate(scene(), 100.0, stiffness=1.01 * limit, **given)
    assert soft["crank_pin"].depth[0] == pytest.approx(length / 1.01)
    with pytest.raises(cd.ArgumentError, match=f"farther than the mechanism is long, {length:.3g}"):
        clearance.simulate(scene(), 100.0, stiffness=0.99 * limit, **given)


def test_a_response_is_no_scene() -> None:
    with pytest.raises(cd.ArgumentError, match="of type Response, expected a scene"):
        clearance.simulate(
            scene().response(),
            100.0,
            joints="crank_pin",
            clearance=1e-4,
            stiffness=1e8,  # type: ignore[arg-type]
        )


def test_a_scene_without_speed_is_refused() -> None:
    with pytest.raises(cd.ArgumentError, match="speed is 0"):
        clearance.simulate(scene(), 0.0, joints="crank_pin", clearance=1e-4, stiffness=1e8)


BEARINGS: dict[str, Any] = {"clearance": 1e-5, "radius": 0.05, "turns": 0.02, "rtol": 1e-7}


def test_a_cross_stands_for_both_of_its_pins() -> None:
    turning = pin_rigs.scene(pin_rigs.rig(0.5, (2e-4, 3e-4, 4e-4)), 0.3)
    law = cd.LinearContact(1e8, 1e3)
    found, pins = (
        clearance.simulate(turning, 150.0, joints=joints, law=law, **BEARINGS)
        for joints in ("cross", ["pin_in", "pin_out"])
    )
    assert list(found) == ["pin_in+", "pin_in-", "pin_out+", "pin_out-"]
    for name in found:
        np.testing.assert_array_equal(found[name].force, pins[name].force)
        assert found[name].peak > 100.0


@pytest.mark.parametrize(
    ("joints", "radius", "error", "match"),
    [
        ("cross", None, cd.ArgumentError, "radius has none of 'pin_in'; give the distance"),
        ("cross", {"pin_in": 0.05}, cd.ArgumentError, "radius has none of 'pin_out'"),
        (["cross", "pin_in"], 0.05, cd.ArgumentError, "joints names a joint twice"),
    ],
)
def test_a_cross_that_cannot_open_says_why(
    joints: Any, radius: Any, error: type[cd.CardanError], match: str
) -> None:
    turning = pin_rigs.scene(pin_rigs.rig(0.5, (2e-4, 3e-4, 4e-4)), 0.3)
    with pytest.raises(error, match=match):
        clearance.simulate(
            turning, 150.0, joints=joints, radius=radius, clearance=1e-5, stiffness=1e8
        )


def test_a_link_between_parallel_pins_is_no_cross() -> None:
    with pytest.raises(cd.ModelError, match="'crank_pin' and 'piston_pin' are parallel"):
        clearance.simulate(scene(), 100.0, joints="rod", radius=0.01, clearance=1e-4, stiffness=1e8)


@pytest.mark.parametrize("joints", ["coupling", "coupling.turn_1"])
def test_a_universal_joint_without_a_cross_says_what_to_do(joints: str) -> None:
    turning = pin_rigs.scene(pin_rigs.compound(), 0.3)
    with pytest.raises(cd.ModelError, match="describe the cross as a link with mass between two"):
        clearance.simulate(turning, 150.0, joints=joints, stiffness=1e8, **BEARINGS)
    scanned = clearance.scan(turning, 150.0, clearance=1e-5, stiffness=1e8)
    assert "A scan takes it with radius=" in scanned.left_out["coupling"]
