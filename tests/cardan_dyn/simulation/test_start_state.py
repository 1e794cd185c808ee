"""Start states: what is given decides the drives, or contradicts itself."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.linkages import four_bar, loop

import cardan_dyn as cd
from cardan_dyn.motion.simulation.start_state import closed_start, drive_positions


@pytest.fixture(scope="module")
def bars() -> cd.Scene:
    return cd.Scene(cd.load(four_bar(loop("continuous"))), drive="a")


@pytest.fixture(scope="module")
def two(joint: cd.Mechanism) -> cd.Scene:
    return cd.Scene(joint, drive="joint_angle", free="bearing_in", near={"joint_angle": 0.3})


def test_positions_of_drives(bars: cd.Scene, two: cd.Scene) -> None:
    np.testing.assert_array_equal(drive_positions(bars.solver, 0.4), [0.4])
    np.testing.assert_array_equal(drive_positions(bars.solver, None), [0.0])
    np.testing.assert_array_equal(drive_positions(two.solver, None), [0.3, 0.0])
    np.testing.assert_array_equal(drive_positions(two.solver, {"bearing_in": 2.0}), [0.3, 2.0])
    np.testing.assert_array_equal(drive_positions(two.solver, [0.1, 2.0]), [0.1, 2.0])
    np.testing.assert_array_equal(drive_positions(two.solver, 2.0), [0.3, 2.0])


def test_a_passive_joint_decides_the_drive(bars: cd.Scene) -> None:
    turn = bars.sweep([0.2])
    rocker = float(turn.motion.position("d")[0])
    assert drive_positions(bars.solver, {"d": rocker})[0] == pytest.approx(0.2, abs=1e-13)


def test_a_passive_joint_moves_the_drive_that_is_not_prescribed(two: cd.Scene) -> None:
    there = two.replace(drive=two.coordinates).sweep([[0.5, 0.7]]).motion
    given = {"bearing_out": float(there.position("bearing_out")[0])}
    found = drive_positions(two.solver, given, {"joint_angle": 0.5})
    np.testing.assert_allclose(found, [0.5, 0.7], atol=1e-12)


def test_messages_say_by_how_much_and_what_is_right(bars: cd.Scene) -> None:
    right = float(bars.sweep([0.2]).motion.position("d")[0])
    message = (
        rf"position\['d'\] is {right + 0.01:g}, .* by 0.01: with a at 0.2 it is at {right:.9g}"
    )
    with pytest.raises(cd.ArgumentError, match=message):
        drive_positions(bars.solver, {"a": 0.2, "d": right + 0.01})
    drive_positions(bars.solver, {"a": 0.2, "d": right + 2.0 * np.pi})
    ratio = float(bars.sweep([0.2], 1.0).motion.velocity("d")[0])
    start = np.array([0.2])
    with pytest.raises(cd.ArgumentError, match=r"speed\['.'\] is .* violates the loops by"):
        closed_start(bars.solver, start, {"a": 2.0, "d": 2.0 * ratio + 0.1}, {})
    agreeing = closed_start(bars.solver, start, {"a": 2.0, "d": 2.0 * ratio}, {})
    assert agreeing.velocity("a")[0] == 2.0


def test_speeds(bars: cd.Scene, two: cd.Scene) -> None:
    start = np.array([0.2])
    ratio = float(bars.sweep([0.2], 1.0).motion.velocity("d")[0])
    motion = closed_start(bars.solver, start, {"d": 1.5}, {})
    assert motion.velocity("a")[0] == pytest.approx(1.5 / ratio, rel=1e-13)
    assert closed_start(bars.solver, start, None, {}).velocity("d")[0] == 0.0
    both = np.array([0.3, 0.2])
    moved = closed_start(two.solver, both, 4.0, {"joint_angle": 0.5})
    assert (moved.velocity("bearing_in")[0], moved.velocity("joint_angle")[0]) == (4.0, 0.5)
    named = closed_start(two.solver, both, {"bearing_out": 2.0}, {"joint_angle": 0.5})
    assert named.velocity("bearing_out")[0] == pytest.approx(2.0, rel=1e-13)
    assert named.velocity("joint_angle")[0] == pytest.approx(0.5, rel=1e-13)


@pytest.mark.parametrize("given", [{"joint_angle": 0.9}, [0.9, 4.0]])
def test_prescribed_motion_is_not_contradicted(two: cd.Scene, given: object) -> None:
    prescribed = {"joint_angle": 0.5}
    with pytest.raises(
        cd.ArgumentError, match=r"is 0\.9, 0\.4 from 0\.5, with which its prescribed"
    ):
        drive_positions(two.solver, given, prescribed)
    with pytest.raises(
        cd.ArgumentError, match=r"is 0\.9, 0\.4 from 0\.5, with which its prescribed"
    ):
        closed_start(two.solver, np.array([0.5, 0.2]), given, prescribed)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (np.nan, "not finite"),
        ("x", "not an array of real numbers"),
        ([[1.0], [1.0, 2.0]], "not an array of real numbers"),
        ([1.0, 2.0], r"has shape \(2,\), expected 1 \(a\)"),
        ({"a": np.inf}, r"\['a'\] is not finite"),
        ({"a": [1.0, 2.0]}, "expected a number"),
    ],
)
def test_what_is_no_start_is_refused(bars: cd.Scene, given: object, message: str) -> None:
    with pytest.raises(cd.ArgumentError, match=message):
        drive_positions(bars.solver, given)
    with pytest.raises(cd.ArgumentError, match=message):
        closed_start(bars.solver, np.zeros(1), given, {})


def test_names_are_those_of_joints_that_move(bars: cd.Scene, joint: cd.Mechanism) -> None:
    with pytest.raises(cd.ModelError, match="no joint 'x'; joints: a, b, c, d"):
        drive_positions(bars.solver, {"x": 1.0})
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.4})
    with pytest.raises(cd.ArgumentError, match="the scene holds this joint"):
        drive_positions(scene.solver, {"joint_angle": 0.4})
