"""With what precision the numbers of a text are written."""

from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.core.description.digits import precision_of


def precision(xyz: str = "0 0 0", rpy: str = "0 0 0", axis: str = "0 0 1") -> tuple[float, float]:
    """Of a URDF with one hinge placed so, whose masses have many digits."""
    text = (
        '<robot name="r"><link name="g"/><link name="a"><inertial>'
        '<origin xyz="0.123456 0 0" rpy="0.1234 0 0"/><mass value="1.23456789"/>'
        '<inertia ixx="0.012345" iyy="0.012345" izz="0.012345"/></inertial></link>'
        '<joint name="A" type="continuous"><parent link="g"/><child link="a"/>'
        f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/></joint></robot>'
    )
    return precision_of(cd.load(text).description)


@pytest.mark.parametrize(
    ("number", "expected"),
    [
        ("0", 0.0),
        ("0.15", 0.0),
        ("1000", 0.0),
        ("0.1500", 5e-5),
        ("0.123457", 5e-7),
        ("-1.234e-3", 5e-7),
        ("12.34", 5e-3),
        ("0.12345678901234567", 5e-18),
    ],
)
def test_lengths_are_off_by_half_of_the_last_of_four_digits_or_more(
    number: str, expected: float
) -> None:
    length, angle = precision(xyz=f"0.3 {number} 0")
    assert length == pytest.approx(expected)
    assert angle == 0.0


@pytest.mark.parametrize(
    ("number", "expected"),
    [
        ("0.5", 0.0),
        ("1.5", 0.0),
        ("1.57", 0.5 * np.pi - 1.57),
        ("-3.14", np.pi - 3.14),
        ("1.05", 0.0028024488034021),
        ("0.524", 0.524 - np.pi / 6.0),
        ("1.23", 0.0),
        ("1.5708", 5e-5),
        ("0.1234", 5e-5),
    ],
)
def test_angles_of_three_digits_are_off_if_they_stand_for_parts_of_a_right_one(
    number: str, expected: float
) -> None:
    assert precision(rpy=f"{number} 0 0") == (0.0, pytest.approx(expected))


def test_directions_count_as_angles() -> None:
    assert precision(axis="0.7071 0 0.7071") == (0.0, pytest.approx(5e-5))


def test_other_notations_name_their_numbers_otherwise() -> None:
    mjcf = (
        '<mujoco><compiler angle="{}"/><worldbody><body name="a" pos="0 0.1234 0" '
        'euler="10.25 0 0"><joint name="A" axis="0 0 1"/><inertial pos="0 0 0" mass="1.2345" '
        'diaginertia="1 1 1"/></body></worldbody></mujoco>'
    )
    degrees, radians = (
        precision_of(cd.load(mjcf.format(unit)).description) for unit in ("degree", "radian")
    )
    assert degrees == (pytest.approx(5e-5), pytest.approx(np.deg2rad(5e-3)))
    assert radians == (pytest.approx(5e-5), pytest.approx(5e-3))
    sdf = (
        '<sdf version="1.9"><model name="m"><link name="g"/><link name="a">'
        "<pose>0 0.1234 0 0 0 1.571</pose><inertial><mass>1.2345</mass></inertial></link>"
        '<joint name="w" type="fixed"><parent>world</parent><child>g</child></joint>'
        '<joint name="A" type="revolute"><parent>g</parent><child>a</child><axis>'
        "<xyz>0 0 1</xyz></axis></joint></model></sdf>"
    )
    assert precision_of(cd.load(sdf).description) == (pytest.approx(5e-5), pytest.approx(5e-4))
