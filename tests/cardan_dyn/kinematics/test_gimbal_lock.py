"""When a singularity is said to be gimbal lock."""

from __future__ import annotations

import numpy as np
from testkit.compound_joints import body, joint, robot

import cardan_dyn as cd
from cardan_dyn.core.kinematics.diagnosis.singularities import gimbal_note

PLAIN = cd.load(
    robot(
        body("a", 1.0),
        joint("base", "floating", "ground a"),
        body("b", 1.0),
        joint("ball", "spherical", "a b"),
    )
)
MECHANISM = PLAIN.variant(["ball", "base"])


def note(passives: list[str], **positions: float) -> str:
    coordinates = MECHANISM.coordinates
    x = coordinates.neutral()
    for name, value in positions.items():
        x[coordinates.named[name.replace("__", ".")].column] = value
    return gimbal_note(coordinates, x, coordinates.rates_of(passives))


def test_both_outer_angles_have_to_be_passive() -> None:
    outer = ["ball.x", "ball.z"]
    for angle, shown in ((np.pi / 2, "90°"), (-np.pi / 2, "-90°"), (5 * np.pi / 2, "90°")):
        text = note(outer, ball__y=angle)
        assert text.startswith(f". 'ball.y' is {shown} there; at ±90° the axes of 'ball.x' and")
    assert "turn the origin of 'ball'" in note([*outer, "ball.y"], ball__y=np.pi / 2)
    assert not note(["ball.x", "ball.y"], ball__y=np.pi / 2)
    assert not note(["ball.z"], ball__y=np.pi / 2)
    assert not note(["base.turn_x", "base.turn_z"], ball__y=np.pi / 2)


def test_the_middle_angle_has_to_be_there() -> None:
    outer = ["base.turn_x", "base.turn_z"]
    assert "'base.turn_y' is 90°" in note(outer, base__turn_y=np.pi / 2 - 1e-6)
    for positions in ({"base__turn_y": 1.5}, {"base__turn_x": np.pi / 2}, {"base__y": np.pi / 2}):
        assert not note(outer, **positions)


def test_balls_have_no_gimbal_lock() -> None:
    coordinates = PLAIN.coordinates
    assert not gimbal_note(coordinates, coordinates.neutral(), range(9))
