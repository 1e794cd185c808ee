"""Modes drawn larger than life."""

from __future__ import annotations

import numpy as np
import pytest
from testkit import elastic_rigs

import cardan_dyn as cd
from cardan_dyn.practice.viewer.mode_shapes import mode_sweep

RIG = elastic_rigs.scene(elastic_rigs.elastic_rig(), 0.2)


def test_forward_whirl_goes_round() -> None:
    """A shape (1, i) in tilts about z and y: a circle, whose greatest swing is the size."""
    turn = mode_sweep(RIG, [1.0, 1.0j], size=0.05, position=0.3, samples=37)
    assert turn.shape == (37,)
    tilts = np.stack([turn.motion.position(name) for name in RIG.free])
    assert np.hypot(*tilts) == pytest.approx(0.05, rel=1e-12)
    assert tilts[:, 0] == pytest.approx([0.05, 0.0], abs=1e-15)
    assert tilts[:, -1] == pytest.approx(tilts[:, 0], abs=1e-15)
    assert tilts[1, 9] == pytest.approx(-0.05)
    assert turn.motion.position("bearing_in") == pytest.approx(0.3)
    # What the springs exert, and nothing of inertia.
    assert turn.drive_effort[:, 1] == pytest.approx(tilts[0], abs=1e-12)


def test_drive_and_mode_turn_in_proportion() -> None:
    turn = mode_sweep(RIG, [0.0, 2.0], cycles=3, turns=-1, rest=(0.01, 0.02), samples=25)
    assert turn.motion.position("bearing_in")[-1] == pytest.approx(-2.0 * np.pi)
    assert turn.motion.position("tilt_z") == pytest.approx(0.01)
    tilt = turn.motion.position("tilt_y")
    assert tilt[[0, 4, 8]] == pytest.approx([0.12, -0.08, 0.12])
    page = cd.view(turn, moments=False, forces=False, title="mode 2").html
    assert "mode 2" in page


def test_slides_swing_by_parts_of_the_length() -> None:
    rig = cd.load(
        '<robot name="slide"><link name="base"/><link name="rotor"/><link name="mass">'
        '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
        '</inertial></link><joint name="turn" type="continuous"><parent link="base"/>'
        '<child link="rotor"/></joint><joint name="slide" type="prismatic">'
        '<parent link="rotor"/><child link="mass"/><origin xyz="3 0 0"/><axis xyz="0 1 0"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
    )
    turn = mode_sweep(cd.Scene(rig, drive="turn", free="slide"), [-5.0], samples=3)
    expected = -0.1 * rig.characteristic_length
    assert turn.motion.position("slide") == pytest.approx([expected, -expected, expected])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"shape": [1.0]}, r"expected 2 numbers.*tilt_z, tilt_y"),
        ({"shape": [0.0, 0.0]}, "not all zero"),
        ({"shape": [1.0, np.nan]}, "finite"),
        ({"shape": ["a", "b"]}, "expected 2 numbers"),
        ({"size": [1.0, 2.0]}, r"size has shape \(2,\), expected a number"),
        ({"cycles": 0}, "cycles is 0"),
        ({"turns": 0.5}, "turns is 0.5"),
        ({"samples": True}, "samples is True"),
    ],
)
def test_arguments_that_are_refused(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(cd.ArgumentError, match=message):
        mode_sweep(RIG, **{"shape": [1.0, 0.0], **arguments})
