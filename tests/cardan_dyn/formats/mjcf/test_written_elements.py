"""Elements of MJCF as text."""

from __future__ import annotations

import math
import sys
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cardan_dyn as cd
from cardan_dyn.core.description.description import Limits, LinkDescription
from cardan_dyn.core.description.elements import rotation_of_quaternion, words
from cardan_dyn.practice.formats.mjcf.writer import (
    check_kinds,
    inertial_of,
    pose_of,
    ranges_of,
)

ANGLES = st.one_of(
    st.sampled_from([0.0, math.pi / 2, -math.pi / 2, math.pi, math.pi - 1e-9, 1e-9]),
    st.floats(-4.0, 4.0),
)
X = np.array([1.0, 0.0, 0.0])


@pytest.mark.slow
@settings(max_examples=300, derandomize=True, deadline=None)
@given(ANGLES, ANGLES, ANGLES)
def test_quaternions_of_any_rotation(roll: float, pitch: float, yaw: float) -> None:
    """Against Pinocchio, up to the sign; also near half turns, where the real part vanishes."""
    turn = pin.rpy.rpyToMatrix(roll, pitch, yaw)
    frame = np.eye(4)
    frame[:3, :3] = turn
    stated = pose_of(frame, "a").get("quat", "1 0 0 0")
    w, x, y, z = found = np.array(stated.split(), dtype=float)
    expected = pin.Quaternion(turn).coeffs()
    sign = 1.0 if expected @ [x, y, z, w] > 0.0 else -1.0
    np.testing.assert_allclose(sign * np.array([x, y, z, w]), expected, atol=1e-12)
    np.testing.assert_allclose(rotation_of_quaternion(found, "at"), turn, atol=1e-15)


def test_what_mujoco_does_not_combine() -> None:
    for kinds in (["slide", "slide", "slide", "ball"], ["hinge"] * 6, ["hinge", "ball", "slide"]):
        check_kinds(kinds, "b")
    for kinds in (["ball", "hinge"], ["hinge"] * 7, ["ball", "ball"]):
        with pytest.raises(cd.ModelError, match=r"body 'b': .* cannot be its joints together"):
            check_kinds(kinds, "b")


@pytest.mark.parametrize(
    ("limits", "found"),
    [
        (Limits(), {}),
        (Limits(-1.0, 2.0), {"range": "-1.0 2.0"}),
        (Limits(-1.0), {"range": f"-1.0 {sys.float_info.max!r}"}),
        (Limits(0.0, 0.0, 1.0, 3.0), {"actuatorfrcrange": "-3.0 3.0"}),
        (Limits(-1.0, 2.0, effort=0.0), {"range": "-1.0 2.0"}),
        (Limits(2.0, 1.0), {}),
    ],
)
def test_ranges(limits: Limits, found: dict[str, str]) -> None:
    assert ranges_of(limits) == found


def test_inertials() -> None:
    link = LinkDescription("a", 2.0, np.array([1.0, 0.0, 0.1 + 0.2]), np.diag([1.0, 2.0, 2.5]))
    assert inertial_of(link) == {
        "pos": "1.0 0.0 0.30000000000000004",
        "mass": "2.0",
        "diaginertia": "1.0 2.0 2.5",
    }
    tensor = np.array([[1.0, 0.1, 0.2], [0.1, 2.0, 0.3], [0.2, 0.3, 2.5]])
    assert inertial_of(replace(link, inertia=tensor))["fullinertia"] == "1.0 2.0 2.5 0.1 0.2 0.3"


def test_poses() -> None:
    frame = np.eye(4)
    frame[:3, 3] = 1.0, -0.0, 1e-20
    assert pose_of(frame, "a") == {"pos": "1.0 0.0 1e-20"}
    frame[:3, :3] = np.diag([1.0, -1.0, -1.0])
    assert pose_of(frame, "a") == {"pos": "1.0 0.0 1e-20", "quat": "0.0 1.0 0.0 0.0"}
    for bad in (np.diag([1.0, 1.0, -1.0, 1.0]), np.diag([2.0, 2.0, 2.0, 1.0])):
        with pytest.raises(cd.ModelError, match=r"'a': .* is no rotation"):
            pose_of(bad, "a")


def test_words_are_read_back_to_the_last_bit() -> None:
    values = [0.1, -1 / 3, 1e-300, 1e22, -0.0]
    assert [float(word) for word in words(values).split()] == values
    assert words([-0.0]) == "0.0"
