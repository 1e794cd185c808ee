"""Usual motion: how bundled and unknown mechanisms move when nothing is said about it."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.planar_linkages import five_bar, four_bar, rocker_range
from testkit.scenes import text

import cardan_dyn as cd
from cardan_dyn.scene.presets import PRESETS, preset_of
from cardan_dyn.scene.usual_motion import default_scene, slides, usual_motion

TURN = np.linspace(0.0, 2.0 * np.pi, 9)


def single_joint(kind: str, limit: str = "", words: str = "") -> cd.Mechanism:
    """One body on the ground, 2 m from its first joint to its second."""
    return cd.load(
        f'<robot name="single"><link name="ground"/><link name="arm"/><link name="tip"/>'
        f'<joint name="j" type="{kind}" {words}><parent link="ground"/><child link="arm"/>'
        f'<axis xyz="0 0 1"/>{limit}</joint>'
        '<joint name="end" type="fixed"><parent link="arm"/><child link="tip"/>'
        '<origin xyz="2 0 0"/></joint></robot>'
    )


def swing(low: float, high: float, fraction: float) -> np.ndarray:
    return (low + high) / 2.0 + fraction * (high - low) * np.sin(TURN)


def test_bundled_descriptions_all_have_a_preset() -> None:
    assert set(cd.bundled_names()) <= set(PRESETS)


@pytest.mark.parametrize("name", sorted(PRESETS))
def test_presets_name_joints_of_their_mechanism(name: str) -> None:
    mechanism, preset = cd.load(name), PRESETS[name]
    named = {*preset.drive, *preset.held_deg, *preset.loads}
    assert preset.drive and named <= set(mechanism.joints)
    assert not set(preset.drive) & set(preset.held_deg)
    # What is driven and held leaves nothing free: the sweep would be refused otherwise.
    assert len(usual_motion(mechanism, samples=3).sweep()) == 3


def test_a_shaft_turns_once_as_its_preset_says(joint: cd.Mechanism) -> None:
    turn = usual_motion(joint, samples=9).sweep()
    np.testing.assert_array_equal(turn.motion.position("bearing_in"), TURN)
    assert turn.held == {"joint_angle": np.deg2rad(35.0)}
    np.testing.assert_allclose(turn.motion.v, 0.0)
    # 100 N·m at the output cost this much at the input when both forks are in line.
    assert turn["bearing_in"].torsion[0] == pytest.approx(100.0 / np.cos(np.deg2rad(35.0)))


def test_arguments_replace_the_preset(joint: cd.Mechanism) -> None:
    turn = usual_motion(
        joint,
        held={"joint_angle": 0.2},
        loads={"bearing_out": -7.0},
        gravity=(0.0, 0.0, -9.81),
        samples=9,
    ).sweep(3.0)
    assert turn.held == {"joint_angle": 0.2}
    scene = cd.Scene(
        joint,
        drive="bearing_in",
        held={"joint_angle": 0.2},
        loads={"bearing_out": -7.0},
        gravity=(0.0, 0.0, -9.81),
    )
    expected = scene.sweep(TURN, speed=3.0)
    for name in turn.outputs:
        np.testing.assert_array_equal(turn[name].force, expected[name].force)
        np.testing.assert_array_equal(turn[name].moment, expected[name].moment)


def test_a_driven_joint_is_not_held_by_the_preset(joint: cd.Mechanism) -> None:
    turn = usual_motion(joint, drive=("joint_angle",), held={"bearing_in": 0.1}, samples=5).sweep()
    assert turn.drives == ("joint_angle",) and turn.held == {"bearing_in": 0.1}


def test_a_preset_is_for_its_mechanism_alone() -> None:
    """A mechanism of the same name has other joints."""
    other = text("slider_crank").replace('name="slider_crank"', 'name="universal_joint"', 1)
    mechanism = cd.load(other)
    assert mechanism.name == "universal_joint"
    turn = usual_motion(mechanism, drive=("crank_bearing",), samples=3).sweep()
    assert turn.held == {}


def test_a_rocker_swings_clear_of_its_dead_points() -> None:
    turn = usual_motion(four_bar(), drive=("D",), samples=9).sweep(5.0)
    low, high = rocker_range()
    np.testing.assert_allclose(
        turn.motion.position("D"), swing(low, high, 0.45), atol=1e-6 * (high - low)
    )
    # A swing reverses its direction, which a constant speed does not.
    np.testing.assert_array_equal(turn.motion.v, 0.0)


def test_several_drives_move_together_then_each_by_itself() -> None:
    """Couplers of this five-bar linkage reach whatever its cranks do together or alone."""
    motion = usual_motion(five_bar(), drive=("A", "D"), samples=303)
    turn = motion.sweep()
    a, d = (turn.motion.position(name) for name in "AD")
    np.testing.assert_allclose(a[:101], d[:101], atol=1e-15)
    np.testing.assert_array_equal(d[101:202], 0.0)
    np.testing.assert_array_equal(a[202:], 0.0)
    for way in (a[:101], a[101:202], d[202:]):
        assert (way.max(), way.min()) == pytest.approx((np.pi, -np.pi), rel=1e-3)
    assert "all together over 100% of their ranges" in motion.said
    np.testing.assert_allclose(motion.box, [[-np.pi, np.pi]] * 2)


@pytest.mark.parametrize(
    ("limit", "low", "high"),
    [
        ('<limit lower="-1" upper="3" effort="1" velocity="1"/>', -1.0, 3.0),
        # Such limits stand for none: a twentieth of the length to both sides.
        ('<limit lower="-1e9" upper="1e9" effort="1" velocity="1"/>', None, None),
    ],
)
def test_a_slide_swings_within_its_limits(
    limit: str, low: float | None, high: float | None
) -> None:
    mechanism = single_joint("prismatic", limit)
    reach = 0.05 * mechanism.characteristic_length
    turn = usual_motion(mechanism, drive=("j",), samples=9).sweep()
    expected = swing(-reach if low is None else low, reach if high is None else high, 0.5)
    np.testing.assert_allclose(turn.motion.position("j"), expected, rtol=1e-12, atol=1e-15)


def test_a_joint_without_end_turns_once() -> None:
    turn = usual_motion(single_joint("continuous"), drive=("j",), samples=9).sweep()
    np.testing.assert_array_equal(turn.motion.position("j"), TURN)


def test_joints_that_the_description_drives_move_what_has_no_preset() -> None:
    described = text("four_bar").replace('name="four_bar"', 'name="mine"', 1)
    driven = '<joint name="crank_bearing"'
    mechanism = cd.load(described.replace(driven, f'{driven} independent="true"', 1))
    assert mechanism.independent_joints == ("crank_bearing",)
    assert usual_motion(mechanism, samples=3).sweep().drives == ("crank_bearing",)


def test_coordinates_of_joints_with_several_are_driven() -> None:
    """Turns go once around or swing, slides swing by a part of the length, the rest is held."""
    ball = single_joint("spherical", words='independent="true"')
    turn = usual_motion(ball, samples=9).sweep()
    assert turn.drives == ("j.x", "j.y", "j.z")
    assert len(turn) == 9 and np.ptp(turn.motion.position("j.x")) > 0.3
    guide = single_joint("cylindrical")
    turn = usual_motion(guide, drive=("j.turn",), held={"j.slide": 0.1}, samples=9).sweep()
    np.testing.assert_array_equal(turn.motion.position("j.turn"), TURN)
    turn = usual_motion(guide, drive=("j.slide",), held={"j.turn": 0.1}, samples=9).sweep()
    reach = 0.05 * guide.characteristic_length
    expected = swing(-reach, reach, 0.5)
    np.testing.assert_allclose(turn.motion.position("j.slide"), expected, atol=1e-15)


def test_slides_are_told_from_turns() -> None:
    guide = single_joint("cylindrical")
    assert slides(guide, "j.slide") and not slides(guide, "j.turn")
    assert not slides(guide, "j")
    with pytest.raises(cd.ModelError, match="no joint 'k'"):
        slides(guide, "k")


def test_scenes_by_preset_and_by_arguments() -> None:
    rig = cd.load("thoma_rig")
    assert preset_of(rig) is PRESETS["thoma_rig"]
    scene = default_scene(rig)
    assert scene.drives == ("bearing_in",)
    assert scene.held["joint_angle"] == pytest.approx(np.deg2rad(8.5))
    other = default_scene(rig, held={"joint_angle": 0.3}, gravity=(0.0, 0.0, -9.81))
    assert other.held["joint_angle"] == 0.3
    crank = default_scene(cd.load("slider_crank"), loads={})
    assert crank.drives == ("crank_bearing",) and not crank.loads
    assert preset_of(cd.load("four_bar")).loads == {"rocker_bearing": -60.0}


def test_a_start_beyond_limits_leads_into_them() -> None:
    ram = single_joint("prismatic", '<limit lower="1.2" upper="2" effort="1" velocity="1"/>')
    assert ram.joints["j"] and default_scene(ram).configuration()["j"] == 0.0
    motion = usual_motion(ram, samples=9)
    np.testing.assert_allclose(motion.positions, swing(1.2, 2.0, 0.5), rtol=1e-15)
    assert "j moves between 1.2 and 2 m" in motion.said


def limited_rocker(low: float, high: float) -> cd.Mechanism:
    """The four-bar linkage whose rocker D has limits, and nothing else."""
    limit = f'<limit lower="{low!r}" upper="{high!r}" effort="0" velocity="0"/></joint>'
    before, rocker, after = four_bar().description.source.text.partition('<joint name="D" ')
    after = after.replace("continuous", "revolute", 1).replace("</joint>", limit, 1)
    return cd.load(before + rocker + after)


def test_limits_are_gone_to_and_what_is_cut_at_dead_points_is_said() -> None:
    dead_low, dead_high = rocker_range()
    way = dead_high - dead_low
    # A limit that is nearer to the dead point than a swing without limits would go.
    motion = usual_motion(limited_rocker(dead_low + 0.01 * way, dead_high + 1.0), drive=("D",))
    at = motion.sweep().motion.position("D")
    assert at.min() == pytest.approx(dead_low + 0.01 * way, abs=1e-12)
    assert at.max() == pytest.approx(dead_high - 0.05 * 0.99 * way, abs=1e-6)
    assert f"5% of its way short of where loops end it ({np.degrees(dead_high):.2f}" in motion.said
    within = usual_motion(limited_rocker(dead_low + 0.2 * way, dead_high - 0.2 * way), drive=("D",))
    assert "loops" not in within.said
    # At a limit that is the dead point itself nothing can be computed.
    at_it = usual_motion(limited_rocker(dead_low, dead_high), drive=("D",))
    assert np.ptp(at_it.sweep().motion.position("D")) == pytest.approx(0.9 * way, rel=1e-6)


def test_what_is_not_named_is_held_where_it_is_held_without_any_name() -> None:
    """One crank of a five-bar linkage that is driven leaves the other where it starts."""
    scene = default_scene(five_bar(), drive=("A",))
    assert scene.drives == ("A",) and dict(scene.held) == {"D": 0.0}
    assert dict(default_scene(five_bar(), drive=("A",), held={"D": 0.1}).held) == {"D": 0.1}
    with pytest.raises(cd.MobilityError):
        default_scene(four_bar(), drive=("A",), held={"D": 1.0})
