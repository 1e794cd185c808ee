"""Idle rods: which bodies may spin, from geometry alone."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.ball_rods import ALONG, WAYS, as_balls, base, hinge, words

import cardan_dyn as cd
from cardan_dyn.core.kinematics.loop_system import LoopSystem
from cardan_dyn.core.kinematics.loops.idle_rods import idle_rods, rods_by_name
from cardan_dyn.scene.presets import PRESETS


def rods(mechanism: cd.Mechanism, *prescribed: str) -> list[tuple[str, ...]]:
    columns = mechanism.coordinates.velocity_columns
    taken = {column for name in prescribed for column in range(*columns[name].indices(10**6))}
    return rods_by_name(mechanism, set(range(mechanism.model.nv)) - taken)


@pytest.mark.parametrize("way", WAYS)
def test_a_rod_between_two_balls_is_found_however_it_is_written(way: str) -> None:
    mechanism = cd.load(WAYS[way]())
    (rod,) = idle_rods(mechanism, set(range(mechanism.model.nv)))
    assert len(rod.columns) == (12 if way == "floating" else 6)
    masses = [inertia.mass for inertia in mechanism.model.inertias]
    assert masses[rod.body + 1] > 0.0


def test_a_prescribed_joint_at_an_end_holds_the_rod() -> None:
    mechanism = cd.load(WAYS["hinges"]())
    for name in ("b2", "c3"):
        assert rods(mechanism, name) == []
    assert len(rods(mechanism, "a")) == 1


def test_balls_in_one_point_hold_no_line() -> None:
    mechanism = cd.load(as_balls().replace(f'<origin xyz="{words(ALONG)}"/>', ""))
    assert rods(mechanism) == []


@pytest.mark.parametrize(("offset", "found"), [(0.0, 1), (0.01, 1), (0.1, 0)])
def test_only_bodies_whose_weight_is_on_the_line_are_rods(offset: float, found: int) -> None:
    beside = 0.5 * ALONG + np.array([0.0, offset, 0.0])
    assert len(rods(cd.load(as_balls(centre=beside)))) == found


def held_by_hinge(axis: np.ndarray, mass: str = "1.5") -> cd.Mechanism:
    """The rod with a ball at the crank and a hinge at the rocker."""
    bodies = base().replace('<mass value="1.5"/>', f'<mass value="{mass}"/>')
    return cd.load(
        f'<robot name="r">{bodies}<joint name="b" type="spherical">'
        '<parent link="crank"/><child link="rod"/><origin xyz="0.3 0 0"/></joint>'
        f'<loop name="c" type="continuous"><predecessor link="rod"><origin xyz="{words(ALONG)}"/>'
        '</predecessor><successor link="rocker"><origin xyz="0 0 0.6"/></successor>'
        f'<axis xyz="{words(axis)}"/></loop></robot>'
    )


def test_a_hinge_through_the_ball_lets_a_light_rod_spin() -> None:
    assert rods(held_by_hinge(ALONG, mass="1e-5")) == [("b", "c")]
    assert rods(held_by_hinge(np.array([0.0, 1.0, 0.0]), mass="1e-5")) == []
    # With a mass that matters it is a rotor or a door, which somebody has to drive.
    assert rods(held_by_hinge(ALONG)) == []


def test_a_link_between_two_hinges_of_one_axis_spins() -> None:
    light = '<link name="washer"/><link name="arm"/><link name="ground"/>'
    on_axis = hinge("lower", "ground", "washer", "0 0 0.5", "0 0 1")
    above = hinge("upper", "washer", "arm", "0 0 0.1", "0 0 1")
    askew = hinge("upper", "washer", "arm", "0.1 0 0", "0 0 1")
    tip = hinge("tip", "arm", "end", "1 0 0", "0 0 1") + '<link name="end"/>'
    weld = (
        '<loop name="weld" type="fixed"><predecessor link="end"/><successor link="ground">'
        '<origin xyz="1 0 0.6"/></successor></loop>'
    )
    for second, expected in ((above, [("lower", "upper")]), (askew, [])):
        chain = f'<robot name="r">{light}{on_axis}{second}{tip}'
        assert rods(cd.load(f"{chain}{weld}</robot>")) == expected
        # On no loop, both hinges swing what hangs on them.
        assert rods(cd.load(f"{chain}</robot>")) == []


def test_couplings_hold_the_spins_that_they_count() -> None:
    coupling = (
        '<coupling name="k"><predecessor link="crank"/><successor link="y1"/>'
        '<ratio value="2"/></coupling></robot>'
    )
    mechanism = cd.load(WAYS["hinges"]().replace("</robot>", coupling))
    assert rods(mechanism) == []


def test_slides_end_a_ball() -> None:
    text = WAYS["hinges"]().replace(
        '<joint name="c1" type="continuous">',
        ('<joint name="c1" type="prismatic"><limit lower="-1" upper="1" effort="1" velocity="1"/>'),
    )
    assert rods(cd.load(text)) == []


@pytest.mark.parametrize("name", cd.bundled_names())
def test_bundled_mechanisms_have_no_idle_rods(name: str) -> None:
    mechanism = cd.load(name)
    preset = PRESETS[name]
    assert rods(mechanism, *preset.drive, *preset.held_deg) == []


@pytest.mark.parametrize(("kind", "axis"), [("continuous", "0 0 1"), ("spherical", "0 0 1")])
def test_shafts_in_two_bearings_of_one_body_are_no_rods(kind: str, axis: str) -> None:
    text = (
        '<robot name="rotor"><link name="ground"/><link name="shaft"><inertial><mass value="1"/>'
        '<origin xyz="0 0 0.5"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
        f"</inertial></link>{hinge('lower', 'ground', 'shaft', '0 0 0', axis)}"
        f'<loop name="upper" type="{kind}"><predecessor link="shaft"><origin xyz="0 0 1"/>'
        '</predecessor><successor link="ground"><origin xyz="0 0 1"/></successor>'
        f'<axis xyz="{axis}"/></loop></robot>'
    )
    assert rods(cd.load(text)) == []


def test_rods_between_two_driven_cranks_spin_as_well() -> None:
    mechanism = cd.load(as_balls())
    assert rods(mechanism, "a", "d") == [("b", "c")]


def test_a_rotor_between_a_fixed_and_a_sliding_bearing_is_no_rod() -> None:
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    text = (
        '<robot name="rotor"><link name="ground"/><link name="block"/><link name="rotor"><inertial>'
        '<mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
        f"</link>{hinge('fixed', 'ground', 'rotor', '0 0 0', '1 0 0')}"
        f'<joint name="slide" type="prismatic">{limit}<parent link="ground"/><child link="block"/>'
        '<origin xyz="1 0 0"/><axis xyz="1 0 0"/></joint><loop name="loose" type="continuous">'
        '<predecessor link="rotor"><origin xyz="1 0 0"/></predecessor><successor link="block"/>'
        '<axis xyz="1 0 0"/></loop></robot>'
    )
    assert rods(cd.load(text)) == []
    with pytest.raises((cd.MobilityError, cd.SingularConfigurationError)):
        cd.Scene(cd.load(text), drive="slide")


def test_driven_hinges_within_a_rod_end_it() -> None:
    """How they are turned decides where the line is, and where the weight lies beside it."""
    halves = (
        as_balls()
        .replace('<predecessor link="rod">', '<predecessor link="half">')
        .replace(f'<origin xyz="{words(ALONG)}"/>', f'<origin xyz="{words(0.5 * ALONG)}"/>')
    )
    elbow = hinge("elbow", "rod", "half", words(0.5 * ALONG), "0 0 1") + '<link name="half"/>'
    mechanism = cd.load(halves.replace("</robot>", elbow + "</robot>"))
    assert rods(mechanism, "elbow") == []


def test_slides_belong_to_a_rod_whatever_decides_them() -> None:
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    telescope = (
        as_balls()
        .replace('<predecessor link="rod">', '<predecessor link="inner">')
        .replace(
            "</robot>",
            f'<link name="inner"/><joint name="stroke" type="prismatic">{limit}<parent link="rod"/>'
            f'<child link="inner"/><axis xyz="{words(ALONG)}"/></joint></robot>',
        )
    )
    mechanism = cd.load(telescope)
    assert rods(mechanism, "stroke") == rods(mechanism) == [("b", "c")]


def test_rods_in_a_row_share_their_joints() -> None:
    """A rod of three pieces that swivel on each other: three spins beside the second loop."""
    pieces = (
        as_balls()
        .replace('<predecessor link="rod">', '<predecessor link="p2">')
        .replace('<mass value="1.5"/>', '<mass value="1e-5"/>')
        .replace(f'<origin xyz="{words(ALONG)}"/>', f'<origin xyz="{words(0.4 * ALONG)}"/>')
        .replace(
            "</robot>",
            '<link name="p1"/><link name="p2"/>'
            + hinge("h1", "rod", "p1", words(0.3 * ALONG), words(ALONG))
            + hinge("h2", "p1", "p2", words(0.3 * ALONG), words(ALONG))
            + "</robot>",
        )
    )
    second = (
        '<link name="m"/><link name="n"/>'
        + hinge("e", "ground", "m", "3 0 0", "0 0 1")
        + hinge("f", "m", "n", "1 0 0", "0 0 1")
        + '<loop name="k" type="spherical"><predecessor link="n"><origin xyz="0.5 0 0"/>'
        '</predecessor><successor link="crank"><origin xyz="4.2 0.3 0"/></successor></loop>'
    )
    mechanism = cd.load(pieces.replace("</robot>", second + "</robot>"))
    assert len(rods(mechanism)) == 3
    free = set(range(mechanism.model.nv))
    taken = mechanism.coordinates.velocity_columns["a"].start
    groups = LoopSystem(mechanism, {}).groups(("a",), np.array(sorted(free - {taken})))
    decided = sorted(column for group in groups for column in group.passives.tolist())
    assert decided == sorted(free - {taken})
    assert sum(len(group.idle) for group in groups) == 3
