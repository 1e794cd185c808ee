"""Start search: where a scene starts, from closed, open and singular zeros."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from testkit.design_line import design_line, nominal
from testkit.planar_linkages import (
    BASE,
    COUPLER,
    CRANK,
    ROCKER,
    described,
    four_bar,
    joint,
    link,
    loop,
    pin_distance,
    rocker_range,
    values,
)

import cardan_dyn as cd
from cardan_dyn.core.kinematics.diagnosis.reach import unclosed
from cardan_dyn.core.kinematics.division import Division
from cardan_dyn.core.kinematics.loop_system import LoopSystem
from cardan_dyn.core.kinematics.start import states_to_start
from cardan_dyn.core.problem.arguments import checked

AT_ZERO = np.arctan2(BASE, ROCKER - CRANK)
"""Angle from the coupler's line of pins to the crank with B at zero."""


def begun(mechanism: cd.Mechanism, drive: str = "A", **options: object) -> np.ndarray:
    """Closed coordinates from which the held joints of a scene are moved."""
    problem = checked(mechanism, drive=drive, **options)
    system = LoopSystem(mechanism, problem.held)
    return states_to_start(Division.of_open_loops(problem, system))[0]


def open_at_zero() -> cd.Mechanism:
    """A four-bar whose rocker's pivot is 0.3 farther away than where its zero would close."""
    return described(
        *(link(name) for name in "abc"),
        joint("A", "ground", "a"),
        joint("B", "a", "b", (0.0, 0.3)),
        joint("D", "ground", "c", (1.3, 0.0)),
        loop("b", "c", (1.0, 0.5), (0.0, 0.8)),
    )


def test_a_closed_zero_is_the_start() -> None:
    mechanism = four_bar()
    start = begun(mechanism)
    np.testing.assert_array_equal(start, mechanism.coordinates.neutral())


def test_the_drive_stays_at_zero_if_the_loops_close_there() -> None:
    mechanism = open_at_zero()
    start = begun(mechanism)[None, :]
    assert values(mechanism, start, "A")[0] == 0.0
    rocker = float(values(mechanism, start, "D")[0])
    pins = np.array([1.3 - 0.8 * np.sin(rocker), 0.8 * np.cos(rocker) - 0.3])
    assert np.linalg.norm(pins) == pytest.approx(np.hypot(1.0, 0.5), abs=1e-13)


@pytest.mark.parametrize("position", [0.3, 0.6])
def test_joints_of_the_start_are_followed_to_their_positions(position: float) -> None:
    mechanism = four_bar()
    start = begun(mechanism, near={"D": position})[None, :]
    assert values(mechanism, start, "D")[0] == position
    assert pin_distance(mechanism, start)[0] == pytest.approx(COUPLER, abs=1e-13)
    # No dead point of D was passed: crank and coupler are nowhere in line, as at zero.
    assert np.sign(np.sin(values(mechanism, start, "B")[0] - AT_ZERO)) == -np.sign(np.sin(AT_ZERO))


def test_starts_that_no_motion_leads_to_are_assembled_there() -> None:
    """The rocker on the other side of its pivot: mirrored, its range is disconnected."""
    low, high = rocker_range()
    mechanism = four_bar()
    for position in (np.pi - high + 0.01, np.pi - low - 0.01):
        start = begun(mechanism, near={"D": position})[None, :]
        assert values(mechanism, start, "D")[0] == pytest.approx(position, abs=1e-12)
        assert pin_distance(mechanism, start)[0] == pytest.approx(COUPLER, abs=1e-12)


def test_starts_that_nothing_closes_say_how_far_the_joint_came() -> None:
    _, high = rocker_range()
    with pytest.raises(cd.AssemblyError, match=r"joint 'D' cannot be brought to 1\.5") as caught:
        begun(four_bar(), near={"D": 1.5})
    assert caught.value.nearest == pytest.approx(high, abs=1e-6)


def test_large_angles_bring_the_question_of_degrees() -> None:
    with pytest.raises(cd.AssemblyError, match=r"if 30 degrees were meant, give 0\.523599"):
        begun(four_bar(), near={"D": 30.0})


def test_all_joints_of_the_start_are_where_they_are_wanted(joint: cd.Mechanism) -> None:
    """While the second joint moves, and then the held one, the first is carried along."""
    start = {"pin_in": 0.3}
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.5}, near=start)
    positions = scene.branches()["A"]
    assert positions["pin_in"] == pytest.approx(0.3, abs=1e-12)
    assert positions["joint_angle"] == pytest.approx(0.5, abs=1e-12)


@pytest.mark.parametrize(
    "start",
    [{"pin_in": 0.9}, {"bearing_in": 1.0, "bearing_out": 3.0}, {"pin_in": 0.1, "pin_out": 0.4}],
)
def test_starts_that_contradict_each_other_are_refused(
    joint: cd.Mechanism, start: dict[str, float]
) -> None:
    with pytest.raises(cd.AssemblyError, match="with all joints of start and held at") as caught:
        cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.5}, near=start)
    assert caught.value.residual > 1e-3


def test_a_held_joint_starts_where_it_is_held(joint: cd.Mechanism) -> None:
    with pytest.raises(cd.ArgumentError, match=r"is held at 0\.5 and cannot start at 0\.9"):
        cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.5}, near={"joint_angle": 0.9})
    cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.5}, near={"joint_angle": 0.5})


def test_complete_starts_that_do_not_close_are_refused() -> None:
    with pytest.raises(cd.AssemblyError, match="near joint 'C' cannot be brought to"):
        cd.Scene(four_bar(), drive="A", near={"A": 0.5, "B": -0.9, "C": -1.5, "D": 2.4})


def test_two_joints_choose_the_assembly_mode() -> None:
    """Crank and coupler say where the pin is, so they decide between the two modes."""
    scene = cd.Scene(four_bar(), drive="A", near={"A": 0.5})
    modes = cd.Scene(four_bar(), drive="A", near={"A": 0.5}).branches()
    for mode in modes.values():
        start = {name: mode[name] for name in "AB"}
        chosen = cd.Scene(four_bar(), drive="A", near=start)
        assert chosen.sweep([0.5]).motion.position("D")[0] == pytest.approx(mode["D"], abs=1e-9)
    assert abs(modes["A"]["D"] - modes["B"]["D"]) > 1.0
    assert scene.sweep([0.5]).motion.position("D")[0] == pytest.approx(modes["A"]["D"])


def test_starts_after_whole_turns_are_followed() -> None:
    """At 2π the loop looks closed with all else at zero, but the coupler has made a turn too."""
    mechanism = four_bar()
    for turns in (1.0, -2.0):
        start = begun(mechanism, near={"A": 2.0 * np.pi * turns})[None, :]
        assert values(mechanism, start, "B")[0] == pytest.approx(-2.0 * np.pi * turns, abs=1e-9)


def test_far_zeros_lead_to_the_same_mode_for_every_drive() -> None:
    """Displaced by up to a radian, the zero is nearest to one mode, whichever joint drives."""
    description = four_bar().description
    offsets = {"A": -0.314, "B": -0.996, "D": -0.736}
    joints = []
    for item in description.joints:
        turn = np.eye(4)
        turn[:3, :3] = Rotation.from_rotvec(offsets[item.name] * item.axis).as_matrix()
        joints.append(replace(item, origin=item.origin @ turn))
    mechanism = cd.load(cd.Mechanism(replace(description, joints=tuple(joints))).to_urdf())
    starts = [begun(mechanism, drive)[None, :] for drive in "AD"]
    np.testing.assert_allclose(starts[0], starts[1], atol=1e-9)
    for name, offset in offsets.items():
        assert abs(values(mechanism, starts[0], name)[0]) < 1.5, offset


def test_contradictions_are_told_in_names_of_coordinates() -> None:
    """Degrees are asked for of an angle, not of a slide."""
    mechanism = cd.load(
        '<robot name="r"><link name="g"/><link name="a"/><joint name="free" type="floating">'
        '<parent link="g"/><child link="a"/></joint></robot>'
    )
    error = str(unclosed(mechanism, 0.1, {"free.turn_x": 45.0}))
    assert "(free.turn_x: 45)" in error
    assert "if 45 degrees were meant, give 0.785398" in error
    assert "degrees" not in str(unclosed(mechanism, 0.1, {"free.z": 45.0}))


def test_held_joints_are_brought_to_their_positions_one_by_one() -> None:
    """Joints of a line with slips share what solves them; one at its position stays there."""
    mechanism, held = cd.load(design_line(3)), nominal(3) | {"length_1": 0.0, "phase_1": 0.0}
    problem = checked(mechanism, drive="bearing_0", held=held)
    system = LoopSystem(mechanism, problem.held)
    division = Division.of_open_loops(problem, system)
    kinematics, states = division.kinematics, states_to_start(division)
    assert len(states) == 1 + len(held)
    reached = dict.fromkeys(held, 0.0)
    for (name, value), state in zip(problem.held.items(), states[1:], strict=True):
        reached[name] = value
        for joint_name, position in reached.items():
            column = mechanism.coordinates.named[joint_name].column
            np.testing.assert_allclose(state[column], position, rtol=0.0, atol=1e-15)
        assert kinematics.evaluate(state[None]).residual[0] < 1e-12
