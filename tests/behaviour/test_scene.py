"""Scenes: bad arguments, mobility, and positions that cannot be reached."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from testkit.linkages import LINK, four_bar, loop
from testkit.scenes import relative, text, universal

import cardan_dyn as cd
from cardan_dyn.analytic import single_joint

pytestmark = pytest.mark.usefixtures("loaded_once")

HELD = {"joint_angle": 0.5}
WRONG = [float("nan"), float("inf"), -float("inf"), "x", None, 1j, [[1.0]], {}]


@pytest.mark.parametrize("value", WRONG)
def test_bad_values_are_refused_everywhere(joint: cd.Mechanism, value: object) -> None:
    good = {"drive": "bearing_in", "held": HELD}
    acting = (
        {"loads": {"bearing_out": value}},
        {"loads": {"shaft_out": value}},
        {"loads": {"shaft_out": cd.Wrench(force=[0.0, value, 0.0])}},
        {"loads": {"shaft_out": cd.Wrench(moment=[0.0, value, 0.0])}},
        {"gravity": [0.0, value, 0.0]},
    )
    scene = cd.Scene(joint, **good)
    is_number = value == [[1.0]]  # One sample, written out.
    for options in ({"held": {"joint_angle": value}}, *acting):
        if is_number and options == acting[0]:
            assert cd.Scene(joint, **good, **options).loads["bearing_out"].shape == (1, 1)
            continue
        with pytest.raises(cd.CardanError):
            cd.Scene(joint, **{**good, **options})
    for options in (
        {"speed": value},
        {"acceleration": [value]},
        {"held": {"joint_angle": value}},
        {"inertia": {"cross": value}},
        *acting,
    ):
        if is_number and options not in acting[1:]:
            assert np.size(scene.sweep([0.0], **options).drive_effort) == 1
            continue
        with pytest.raises(cd.ArgumentError):
            scene.sweep([0.0], **options)
    with pytest.raises(cd.ArgumentError):
        scene.sweep([0.0, value])
    for options in ({"loads": value}, {"held": value}, {"inertia": value}, {"gravity": value}):
        if not value and value != {}:
            continue  # Nothing is given.
        if value == {} and "gravity" not in options:
            continue
        with pytest.raises(cd.ArgumentError):
            scene.sweep([0.0], **options)


def test_messages_name_argument_and_choices(joint: cd.Mechanism) -> None:
    good = {"drive": "bearing_in", "held": HELD}
    cases = [
        ({**good, "drive": "bearing"}, "no joint 'bearing'; joints: bearing_in, bearing_out, j"),
        ({**good, "drive": 3}, "drive is 3, expected a name or a sequence of names"),
        (
            {**good, "drive": []},
            "at least one coordinate that is driven or free; joints: bearing_in",
        ),
        ({**good, "held": {"angle": 0.1}}, "no joint 'angle'; joints: bearing_in"),
        ({**good, "held": {"joint_angle": [0.1, 0.2]}}, "to move this joint, make it a drive"),
        ({**good, "drive": "joint_angle"}, "driven, free or held, and named once"),
        ({**good, "drive": ["bearing_in", "bearing_in"]}, "driven, free or held"),
        (
            {**good, "loads": {"shaft": 1.0}},
            "no joint or link has this name; joints: .*links: base",
        ),
        ({**good, "loads": {"base": [0.0] * 6}}, "'base' is fixed to the world"),
        ({**good, "loads": {"shaft_out": 1.0}}, "a link takes force and moment"),
        ({**good, "loads": {"shaft_out": cd.Wrench(frame="joint")}}, "frames: link, world"),
        ({**good, "gravity": 9.81}, r"gravity has shape \(\), expected \(3,\)"),
        ({**good, "outputs": ["pin"]}, "no joint 'pin'; joints"),
    ]
    for options, message in cases:
        with pytest.raises(cd.CardanError, match=message):
            cd.Scene(joint, **options)
    with pytest.raises(cd.ArgumentError, match="needs a mechanism from load"):
        cd.Scene("universal_joint", **good)


def test_drives_must_match_the_mobility(joint: cd.Mechanism) -> None:
    with pytest.raises(cd.MobilityError, match=r"leave mobility 2.*joint_angle") as caught:
        cd.Scene(joint, drive="bearing_in")
    assert caught.value.mobility == 2
    assert "joint_angle" in caught.value.free
    with pytest.raises(cd.MobilityError, match="drop a drive"):
        cd.Scene(joint, drive=["bearing_in", "bearing_out"], held=HELD)
    with pytest.raises(cd.MobilityError, match=r"it is locked: stop holding pin_in$"):
        cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.1, "pin_in": 0.0})
    open_chain = text("universal_joint")
    start, end = open_chain.index("<loop"), open_chain.index("</loop>") + len("</loop>")
    opened = cd.load(open_chain[:start] + open_chain[end:])
    with pytest.raises(cd.MobilityError, match="it has no loop: nothing decides") as caught:
        cd.Scene(opened, drive="bearing_in", held=HELD)
    assert caught.value.free == ["pin_in", "bearing_out"]


def test_open_chains_need_no_loop() -> None:
    pendulum = cd.load(
        f'<robot name="p"><link name="base"/>{LINK.format(name="rod", com="0.4 0 0", mass="2")}'
        '<joint name="hinge" type="continuous"><parent link="base"/><child link="rod"/>'
        '<axis xyz="0 0 1"/></joint></robot>'
    )
    scene = cd.Scene(pendulum, drive="hinge", gravity=(0.0, -9.81, 0.0))
    angle = np.linspace(-7.0, 7.0, 29)
    swing = scene.sweep(angle, speed=3.0, acceleration=2.0)
    inertia = 0.025 + 2.0 * 0.4**2
    expected = inertia * 2.0 + 2.0 * 9.81 * 0.4 * np.cos(angle)
    assert relative(swing.drive_effort, expected) < 1e-14
    # Along the rod the hinge pulls inwards: centripetal force and weight.
    pull = swing["hinge"].force[:, 0]
    assert relative(pull, -2.0 * 0.4 * 9.0 + 2.0 * 9.81 * np.sin(angle)) < 1e-14


def test_two_drives_move_an_open_or_a_closed_chain(joint: cd.Mechanism) -> None:
    """The joint angle as a second drive: the same wrenches as when it is held there."""
    scene = cd.Scene(joint, drive=["bearing_in", "joint_angle"], loads={"bearing_out": -2.0})
    positions = np.array([[0.0, 0.5], [0.3, 0.5], [1.0, 0.2], [-0.4, 0.8]])
    turn = scene.sweep(positions)
    assert turn.drive_effort.shape == (4, 2)
    for sample, (phi, beta) in enumerate(positions):
        single = universal(joint, beta, load=-2.0).sweep(phi)
        assert turn.drive_effort[sample, 0] == pytest.approx(single.drive_effort[0], rel=1e-13)
        holding = single.holding_effort["joint_angle"][0]
        assert turn.drive_effort[sample, 1] == pytest.approx(holding, abs=1e-13)
    rates = turn.motion.ratio("bearing_out", drive=0)
    np.testing.assert_allclose(
        rates, single_joint.speed_ratio(positions[:, 1], positions[:, 0]), rtol=1e-13
    )


def test_positions_in_any_order_and_far_away(joint: cd.Mechanism) -> None:
    beta = np.deg2rad(60.0)
    rng = np.random.default_rng(7)
    positions = rng.uniform(-40.0, 40.0, 300)
    turn = universal(joint, beta).sweep(positions)
    expected = single_joint.output_angle(beta, positions)
    np.testing.assert_allclose(turn.motion.position("bearing_out"), expected, rtol=0, atol=2e-14)
    # A million turns: the wrench is that of the angle as it was given, to rounding.
    far = 2.0 * np.pi * 1e6 + np.linspace(0.0, 6.0, 50)
    turn = universal(joint, beta).sweep(far)
    ratio = single_joint.speed_ratio(beta, far)
    assert relative(turn.drive_effort, ratio) < 1e-14
    expected = single_joint.output_angle(beta, far)
    np.testing.assert_allclose(turn.motion.position("bearing_out"), expected, rtol=1e-15)


def test_sweeps_do_not_depend_on_earlier_ones(joint: cd.Mechanism) -> None:
    scene = universal(joint, 1.3)
    scene.sweep([-0.2])
    scene.sweep(np.linspace(0.0, 30.0, 1000))
    again = scene.sweep([0.1, 0.2])
    fresh = universal(joint, 1.3).sweep([0.1, 0.2])
    np.testing.assert_allclose(again.drive_effort, fresh.drive_effort, rtol=1e-14)
    np.testing.assert_allclose(
        again.motion.position("bearing_out"), fresh.motion.position("bearing_out"), rtol=1e-13
    )


def test_locked_at_a_right_angle(joint: cd.Mechanism) -> None:
    with pytest.raises(cd.SingularConfigurationError):
        universal(joint, 0.5 * np.pi).sweep(np.linspace(0.0, 1.0, 5))


def test_a_rocker_cannot_be_driven_through() -> None:
    """The four-bar's rocker as drive: its range ends where crank and coupler are in line."""
    mechanism = cd.load(four_bar(loop("continuous")))
    scene = cd.Scene(mechanism, drive="d")
    swing = scene.sweep(np.linspace(-0.08, 0.1, 5))
    assert swing.loop_residual < 1e-13
    # Crank 0.5 and coupler √8 in line: the rocker's end is 0.5 + √8 from the crank's pivot.
    cosine = (2.0**2 + 2.5**2 - (0.5 + np.sqrt(8.0)) ** 2) / (2.0 * 2.0 * 2.5)
    limit = 0.5 * np.pi - np.arccos(cosine)
    with pytest.raises(cd.CardanError, match=r"drive 'd' cannot be brought to -0\.09") as caught:
        scene.sweep(np.linspace(0.0, -1.5, 50))
    assert caught.value.nearest == pytest.approx(limit, abs=1e-8)
    assert caught.value.sample == 3
    assert caught.value.position == np.linspace(0.0, -1.5, 50)[3]
    assert caught.value.reach == pytest.approx(scene.motion_range(), abs=1e-8)
    assert "d cannot move there, and a, b, c can move while d rests" in str(caught.value)


def test_a_loop_that_cannot_close() -> None:
    urdf = four_bar(loop("continuous"), rocker="9.0")
    with pytest.raises(cd.AssemblyError, match="the least closure error found"):
        cd.Scene(cd.load(urdf), drive="a")


def test_a_zero_position_that_is_only_nearly_closed() -> None:
    """Rounded dimensions in a file are closed up, not refused."""
    scene = cd.Scene(cd.load(four_bar(loop("continuous"), rocker="2.52")), drive="a")
    assert scene.sweep(np.linspace(0.0, 6.0, 20)).loop_residual < 1e-13


def test_errors_carry_their_numbers(joint: cd.Mechanism) -> None:
    with pytest.raises(cd.MobilityError) as caught:
        cd.Scene(joint, drive="bearing_in")
    for error in (caught.value, copy.copy(caught.value), pickle.loads(pickle.dumps(caught.value))):
        assert str(error) == str(caught.value)
        assert error.mobility == 2
    with pytest.raises(AttributeError, match="has no attribute 'weight'"):
        _ = caught.value.weight


def test_closed_positions_stay_right_when_more_of_the_motion_becomes_known() -> None:
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", loads={"rocker_bearing": -5.0})
    closed = scene.assemble(np.linspace(0.0, 0.1, 5))
    before = scene.sweep(closed)["crank_bearing"].moment
    # What was closed for three rows of the planar loop is closed again for all six.
    kinematics = scene.solver.assembly.kinematics
    assert kinematics.reductions[0].rows[0].shape[1] == 3
    kinematics.reductions[0] = kinematics.solvers[0].equations.full
    after = scene.sweep(closed)["crank_bearing"].moment
    assert relative(after, before) < 1e-13
