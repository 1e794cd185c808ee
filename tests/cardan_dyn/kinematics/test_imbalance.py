"""Imbalance: locked, undecided and singular told apart, and what is advised."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from testkit.planar_linkages import five_bar, four_bar, joint, link
from testkit.scenes import text

import cardan_dyn as cd


def error_of(mechanism: cd.Mechanism, drive: object, **options: object) -> cd.CardanError:
    with pytest.raises(cd.CardanError) as caught:
        cd.Scene(mechanism, drive=drive, **options)
    return caught.value


@pytest.mark.parametrize(
    "held",
    [
        {"joint_angle": 0.0, "bearing_out": 0.0},
        {"joint_angle": 0.4, "bearing_out": 0.5},
        {"joint_angle": 0.3, "pin_in": 0.0},
    ],
)
def test_one_held_joint_too_many_locks_a_universal_joint(held: Mapping[str, float]) -> None:
    """With its shafts in line as well, where the pins do not move."""
    error = error_of(cd.load("universal_joint"), "bearing_in", held=held)
    assert isinstance(error, cd.MobilityError)
    assert error.mobility == 0
    assert "it is locked: stop holding " in str(error)
    for name in error.surplus:
        rest = {joint: value for joint, value in held.items() if joint != name}
        cd.Scene(cd.load("universal_joint"), drive="bearing_in", held=rest).sweep([0.0, 0.1])


@pytest.mark.parametrize("drive", ["crank_bearing", "crank_pin", "piston_pin"])
def test_a_position_that_can_only_be_shaken_is_locked(drive: str) -> None:
    """At its dead point the piston does not move at first, whatever drives the crank."""
    error = error_of(cd.load("slider_crank"), drive, held={"piston_guide": 0.0})
    assert isinstance(error, cd.MobilityError)
    assert (error.mobility, error.free, error.surplus) == (0, [], ["piston_guide"])
    assert str(error).endswith("it is locked: stop holding piston_guide")


def test_joints_that_rest_in_the_whole_motion_may_be_held() -> None:
    """With shafts in line the pins rest: holding one of them is redundant, not too much."""
    held = {"joint_angle": 0.0, "pin_in": 0.0}
    turn = cd.Scene(cd.load("universal_joint"), drive="bearing_in", held=held).sweep([0.0, 1.0])
    np.testing.assert_allclose(turn.motion.position("bearing_out"), [0.0, 1.0], atol=1e-12)


def test_dead_points_name_the_joint_that_loses_its_freedom() -> None:
    error = error_of(cd.load("slider_crank"), "piston_guide")
    assert isinstance(error, cd.SingularConfigurationError)
    assert tuple(error.joints) == ("piston_guide",)
    assert set(error.moving) == {"crank_bearing", "crank_pin", "piston_pin"}
    assert "piston_guide cannot move there, and crank_bearing, crank_pin, piston" in str(error)
    assert error.finding in str(error)
    assert error.position == 0.0


def test_a_drive_that_is_locked_is_said_to_be() -> None:
    """A shaft that is held at zero keeps the other one at zero, at any angle between them."""
    error = error_of(cd.load("universal_joint"), "bearing_in", held={"bearing_out": 0.0})
    assert isinstance(error, cd.MobilityError)
    assert "bearing_in cannot move, and cannot be driven; nothing decides" in str(error)
    assert (error.surplus, error.advised) == (["bearing_in"], ["joint_angle"])
    held = {"bearing_out": 0.0}
    cd.Scene(cd.load("universal_joint"), drive="joint_angle", held=held).sweep([0.0, 0.5])


def test_what_is_left_over_is_described() -> None:
    swing = link("swing"), joint("S", "ground", "swing", (0.2, -0.7))
    error = error_of(four_bar(0.3, 0.8, 1.0, *swing), "A")
    expected = "1 freedom is left over: link 'swing' turns about (0, 0, 1) through (0.2, -0.7, 0); "
    assert expected in str(error)
    assert error.details["advised"] == ["S"]


def test_of_many_freedoms_three_are_described() -> None:
    links = [link(f"swing{index}") for index in range(14)]
    hinges = [joint(f"S{index}", "ground", f"swing{index}", (index, 2)) for index in range(14)]
    message = str(error_of(four_bar(0.3, 0.8, 1.0, *links, *hinges), "A"))
    assert "S0, S1, S10, S11, S12, S13, S2, S3, S4, S5 and 4 more; 14 freedoms are" in message
    assert message.count("turns about") == 3
    assert "; and 11 more; drive or hold 14 of them, such as" in message


def test_coordinates_of_balls_are_advised_where_nothing_else_decides_the_motion() -> None:
    ball = '<joint name="S" type="spherical"><parent link="ground"/><child link="swing"/></joint>'
    linkage = four_bar(0.3, 0.8, 1.0, link("swing"), ball)
    error = error_of(linkage, "A")
    assert error.details["advised"] == ["S.x", "S.y", "S.z"]
    cd.Scene(linkage, drive=["A", "S.x", "S.y", "S.z"]).sweep(np.full((2, 4), 0.1))
    several = error_of(cd.load(text("stewart_platform")), "leg_1")
    assert len(several.details["advised"]) == 5  # type: ignore[arg-type]


def test_drives_that_depend_on_each_other_leave_others_free() -> None:
    beside = link("swing"), joint("S", "ground", "swing", (3.0, 0.0))
    error = error_of(four_bar(0.3, 0.8, 1.0, *beside), ["A", "D"])
    assert isinstance(error, cd.MobilityError)
    assert error.mobility == 2
    assert "drop a drive" in str(error)
    assert "link 'swing' turns about" in str(error)
    assert error.advised == ["S"]


def test_a_truss_is_locked_whatever_is_held() -> None:
    error = error_of(five_bar(), "A", held={"D": 0.0, "B": 0.0, "C": 0.0})
    assert isinstance(error, cd.MobilityError)
    assert error.mobility == 0
    assert "it is locked: stop holding more than one joint, or check loops" in str(error)
    assert str(error).endswith("axes, which are x if left out")


def test_what_is_close_to_singular_is_not_locked() -> None:
    """Two rods 1e-7 rad from being in line, with a slider across: refused where it counts."""
    bend = 1e-7
    parts = "".join(
        f'<link name="{name}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" '
        'ixz="0" iyz="0"/></inertial></link>'
        for name in ("base", "near", "far", "slider")
    )
    rods = cd.load(
        f'<robot name="rods">{parts}<joint name="a" type="continuous"><parent link="base"/>'
        f'<child link="near"/><origin rpy="0 0 {bend}"/><axis xyz="0 0 1"/></joint>'
        '<joint name="b" type="continuous"><parent link="near"/><child link="far"/>'
        f'<origin xyz="1 0 0" rpy="0 0 {-2 * bend}"/><axis xyz="0 0 1"/></joint>'
        '<joint name="s" type="prismatic"><parent link="base"/><child link="slider"/>'
        f'<origin xyz="{2 * np.cos(bend)} 0 0"/><axis xyz="0 1 0"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        '<loop name="c" type="continuous"><predecessor link="far"><origin xyz="1 0 0"/>'
        '</predecessor><successor link="slider"><origin xyz="0 0 0"/></successor>'
        '<axis xyz="0 0 1"/></loop></robot>'
    )
    scene = cd.Scene(rods, drive="a")
    assert scene.sweep([0.0]).condition[0] > 1e6
    with pytest.raises(cd.SingularConfigurationError, match=r"rounding decides .* of its speeds"):
        scene.replace(free=scene.drives).simulate(0.1, speed=1.0)


def test_a_cylinder_is_listed_before_what_moves_with_it() -> None:
    """Of 14 joints that would do, ten are named; by their names alone it was none of them."""
    body = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
    others = [f"a{index:02}" for index in range(13)]
    parts = [f'<link name="{name}_link">{body}</link>' for name in ("swing", "way", *others)]
    for name, kind in {"swing": "continuous", "way": "prismatic"}.items():
        limit = '<limit lower="0" upper="1" effort="1" velocity="1"/>' * (kind == "prismatic")
        parts.append(
            f'<joint name="{name}" type="{kind}"><parent link="base"/>'
            f'<child link="{name}_link"/>{limit}</joint>'
        )
    parts += [
        f'<joint name="{name}" type="continuous"><parent link="base"/>'
        f'<child link="{name}_link"/><mimic joint="way" multiplier="1"/></joint>'
        for name in others
    ]
    mechanism = cd.load(f'<robot name="geared"><link name="base"/>{"".join(parts)}</robot>')
    with pytest.raises(cd.MobilityError, match="drive or hold one of: way, a00, a01") as told:
        cd.Scene(mechanism, drive="swing")
    assert str(told.value).endswith("and 4 more")
    with pytest.raises(cd.MobilityError, match=r"has 1 \(swing\); actuate or hold one of: way, a"):
        cd.Scene(mechanism, task=["swing", "way"], actuated="swing")
