"""Numbers, words and poses that stand as text between tags."""

from __future__ import annotations

import math
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest

import cardan_dyn as cd
from cardan_dyn.practice.formats.sdf.elements import flag, limit, number, pose, text


def element(content: str) -> ElementTree.Element:
    return ElementTree.fromstring(f"<e>{content}</e>")


def test_text_has_no_blanks_around_it() -> None:
    assert text(element("<a>\n x y\t</a>"), "a", "z", "at") == "x y"
    assert text(element(""), "a", "z", "at") == "z"
    assert text(element("<a/>"), "a", "z", "at") == "z"
    with pytest.raises(cd.ModelError, match="there are 2 <a> in <e>"):
        text(element("<a/><a/>"), "a", "z", "at")


def test_number() -> None:
    assert number(element("<a> -1.5e-3 </a>"), "a", "7", "at") == -1.5e-3
    assert number(element(""), "a", "7", "at") == 7.0
    assert number(element("<a> </a>"), "a", "7", "at") == 7.0
    for word in ("1_0", "nan", "1 2", "0x1"):
        with pytest.raises(cd.ModelError, match="at: a"):
            number(element(f"<a>{word}</a>"), "a", "7", "at")


def test_flag() -> None:
    assert [flag(word, "at") for word in ("true", "1", " True ", "FALSE", "0")] == [
        *(True, True, True, False, False)
    ]
    with pytest.raises(cd.ModelError, match="at is 'yes', expected true or false"):
        flag("yes", "at")


@pytest.mark.parametrize(
    ("tag", "sign", "word", "found"),
    [
        ("upper", 1.0, "0.5", 0.5),
        ("upper", 1.0, "inf", math.inf),
        ("upper", 1.0, "1e16", math.inf),
        ("upper", 1.0, "-1e16", -1e16),
        ("upper", 1.0, "1.79769e+308", math.inf),
        ("lower", -1.0, "-1.79769e+308", -math.inf),
        ("lower", -1.0, "-INF", -math.inf),
        ("lower", -1.0, "-1e+16", -math.inf),
        ("lower", -1.0, "-3", -3.0),
        ("effort", 1.0, "-1", math.inf),
        ("velocity", 1.0, "-1.0", math.inf),
        ("velocity", 1.0, "0", 0.0),
    ],
)
def test_limit(tag: str, sign: float, word: str, found: float) -> None:
    assert limit(element(f"<{tag}>{word}</{tag}>"), tag, sign, "at") == found


def test_limits_that_are_none() -> None:
    assert limit(element(""), "lower", -1.0, "at") == -math.inf
    for word in ("-inf", "nan", "much", "-1.79769e+308"):
        with pytest.raises(cd.ModelError, match="at: limit upper"):
            limit(element(f"<upper>{word}</upper>"), "upper", 1.0, "at")


def test_pose() -> None:
    np.testing.assert_array_equal(pose(element(""), "at"), np.eye(4))
    np.testing.assert_array_equal(pose(element("<pose> </pose>"), "at"), np.eye(4))
    turn = pin.rpy.rpyToMatrix(0.3, -0.4, 0.5)
    found = pose(element("<pose>1 2 3\n0.3 -0.4 0.5</pose>"), "at")
    np.testing.assert_allclose(found, pin.SE3(turn, np.array([1.0, 2, 3])).homogeneous, atol=1e-15)
    degrees = " ".join(repr(math.degrees(angle)) for angle in (0.3, -0.4, 0.5))
    found = pose(element(f'<pose degrees="true">1 2 3 {degrees}</pose>'), "at")
    np.testing.assert_allclose(found[:3, :3], turn, atol=1e-15)
    x, y, z, w = 3.0 * pin.Quaternion(turn).coeffs()
    words = f'<pose rotation_format="quat_xyzw">1 2 3 {x} {y} {z} {w}</pose>'
    np.testing.assert_allclose(pose(element(words), "at")[:3, :3], turn, atol=1e-15)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("<pose>1 2 3</pose>", "pose: '1 2 3' is not 6 finite"),
        ('<pose rotation_format="quat_xyzw">0 0 0 0 0 0</pose>', "is not 7 finite"),
        ('<pose rotation_format="quat_xyzw">0 0 0 0 0 0 0</pose>', "has no direction"),
        ('<pose rotation_format="euler">0 0 0 0 0 0</pose>', "rotation_format 'euler' is unknown"),
        (
            '<pose rotation_format="quat_xyzw" degrees="1">0 0 0 0 0 0 1</pose>',
            "degrees has no meaning",
        ),
        ('<pose degrees="on">0 0 0 0 0 0</pose>', "degrees is 'on'"),
    ],
)
def test_poses_that_are_none(words: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        pose(element(words), "at")
