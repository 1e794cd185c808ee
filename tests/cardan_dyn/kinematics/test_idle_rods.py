"""Idle rods: which bodies may spin, from geometry alone."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.ball_rods import ALONG, WAYS, as_balls, base, hinge, words

import cardan_dyn as cd
from cardan_dyn.command_line.presets import PRESETS
from cardan_dyn.kinematics.idle_rods import idle_rods, rods_by_name


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


def held_by_hinge(axis: np.ndarray, centre: np.ndarray = 0.5 * ALONG) -> cd.Mechanism:
    """The rod with a ball at the crank and a hinge at the rocker."""
    return cd.load(
        f'<robot name="r">{base(centre=centre)}<joint name="b" type="spherical">'
        '<parent link="crank"/><child link="rod"/><origin xyz="0.3 0 0"/></joint>'
        f'<loop name="c" type="continuous"><predecessor link="rod"><origin xyz="{words(ALONG)}"/>'
        '</predecessor><successor link="rocker"><origin xyz="0 0 0.6"/></successor>'
        f'<axis xyz="{words(axis)}"/></loop></robot>'
    )


def test_a_hinge_through_the_ball_lets_the_rod_spin() -> None:
    assert rods(held_by_hinge(ALONG)) == [("b", "c")]
    assert rods(held_by_hinge(np.array([0.0, 1.0, 0.0]))) == []


def test_a_link_between_two_hinges_of_one_axis_spins() -> None:
    light = '<link name="washer"/><link name="arm"/><link name="ground"/>'
    on_axis = hinge("lower", "ground", "washer", "0 0 0.5", "0 0 1")
    above = hinge("upper", "washer", "arm", "0 0 0.1", "0 0 1")
    askew = hinge("upper", "washer", "arm", "0.1 0 0", "0 0 1")
    tip = hinge("tip", "arm", "end", "1 0 0", "0 0 1") + '<link name="end"/>'
    for second, expected in ((above, [("lower", "upper")]), (askew, [])):
        mechanism = cd.load(f'<robot name="r">{light}{on_axis}{second}{tip}</robot>')
        assert rods(mechanism) == expected


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
