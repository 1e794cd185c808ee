"""The command `view`: its words and units become the arguments of a sweep and of a scene."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("meshcat", reason="the viewer needs meshcat")
pytest.importorskip("jinja2", reason="the page needs Jinja")

import cardan_dyn as cd
from cardan_dyn.command_line import view_command
from cardan_dyn.command_line.view_command import MotionOptions, scene_of

QUICK = MotionOptions(samples=3)
KINDS = ("visuals", "moments", "forces", "axes", "traces", "labels")


def sweep(motion: MotionOptions, mechanism: cd.Mechanism) -> cd.Sweep:
    return motion.motion(mechanism).sweep(motion.speed)


def test_degrees_are_converted(joint: cd.Mechanism) -> None:
    motion = MotionOptions((), ("joint_angle=20",), ("bearing_out=-5",), np.pi, samples=9)
    turn = sweep(motion, joint)
    assert turn.held == {"joint_angle": pytest.approx(np.pi / 9.0)}
    speed = turn.motion.v[:, joint.coordinates.velocity_columns["bearing_in"].start]
    np.testing.assert_allclose(speed, np.pi, rtol=1e-15)
    assert len(turn) == 9


def test_slides_are_held_in_metres() -> None:
    mechanism = cd.load(
        '<robot name="r"><link name="a"/><link name="b"/><link name="c"/>'
        '<joint name="turn" type="continuous"><parent link="a"/><child link="b"/></joint>'
        '<joint name="slide" type="prismatic"><parent link="b"/><child link="c"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
    )
    turn = sweep(MotionOptions(("turn",), ("slide=0.25",), samples=3), mechanism)
    assert turn.held == {"slide": 0.25}


def test_coordinates_are_held_in_degrees_or_metres() -> None:
    mechanism = cd.load(
        '<robot name="r"><link name="a"/><link name="b"/><link name="c"/>'
        '<joint name="ball" type="spherical"><parent link="a"/><child link="b"/></joint>'
        '<joint name="guide" type="cylindrical"><parent link="b"/><child link="c"/></joint></robot>'
    )
    held = ("ball.x=30", "ball.z=-60°", "guide.slide=250 mm", f"guide.turn={np.pi / 2}rad")
    turn = sweep(MotionOptions(("ball.y",), held, samples=3), mechanism)
    radians = {"ball.x": np.pi / 6, "ball.z": -np.pi / 3, "guide.turn": np.pi / 2}
    assert turn.held == pytest.approx({**radians, "guide.slide": 0.25})


def test_what_is_not_given_is_the_presets(joint: cd.Mechanism) -> None:
    turn = sweep(MotionOptions(samples=5), joint)
    assert turn.drives == ("bearing_in",)
    assert turn.held == {"joint_angle": np.deg2rad(35.0)}
    np.testing.assert_array_equal(turn.motion.v, 0.0)
    without_load = sweep(MotionOptions(loads=("bearing_out=0",), samples=5), joint)
    np.testing.assert_array_equal(without_load["bearing_in"].torsion, 0.0)
    assert np.all(turn["bearing_in"].torsion != 0.0)


def test_gravity_acts_on_the_sweep() -> None:
    mechanism = cd.load("four_bar")
    forces = [
        sweep(MotionOptions(loads=("rocker_bearing=0",), gravity=gravity, samples=3), mechanism)[
            "crank_bearing"
        ].force
        for gravity in (None, (0.0, -9.81, 0.0))
    ]
    np.testing.assert_array_equal(forces[0], 0.0)
    assert np.all(np.linalg.norm(forces[1], axis=1) > 0.1)


def test_unknown_joints_are_refused(joint: cd.Mechanism) -> None:
    for motion in (
        MotionOptions(held=("elbow=3",), samples=3),
        MotionOptions(("elbow",), samples=3),
        MotionOptions(loads=("elbow=3",), samples=3),
    ):
        with pytest.raises(cd.ModelError, match="'elbow'"):
            sweep(motion, joint)


@pytest.mark.parametrize("hidden", [(), *((kind,) for kind in KINDS), KINDS])
def test_hidden_kinds_are_switched_off(
    hidden: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    given_options: dict[str, object] = {}
    monkeypatch.setattr(view_command, "draw", lambda sweep, **more: given_options.update(more))
    scene_of("four_bar", QUICK, ("crank_bearing",), hidden, 2.5, True)
    assert {kind: given_options.pop(kind) for kind in KINDS} == {
        kind: kind not in hidden for kind in KINDS
    }
    assert given_options == {"joints": ("crank_bearing",), "duration": 2.5, "frames": 3}
    scene_of("four_bar", QUICK, (), (), 2.5, True)
    assert given_options["joints"] is None


def test_scene_is_that_of_its_sweep() -> None:
    shown = scene_of("four_bar", QUICK, (), (), 8.0, True)
    page = cd.view(QUICK.motion(cd.load("four_bar")).sweep(QUICK.speed), frames=3).html
    # Each drawing gives its objects new identifiers, all of the same length.
    assert len(shown.html) == len(page)
    with pytest.raises(cd.CardanError, match="no_such_file"):
        scene_of("no_such_file.urdf", QUICK, (), (), 8.0, True)
