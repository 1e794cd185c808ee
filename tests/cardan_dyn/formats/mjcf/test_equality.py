"""Equalities of MJCF become loops and couplings, placed as MuJoCo places them."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from testkit.mjcf import CONNECTS, HALVES, ROCKER, placed

import cardan_dyn as cd
from cardan_dyn.core.description.description import LoopDescription
from cardan_dyn.core.description.read import read


def test_inactive_equalities_are_left_out() -> None:
    off = '<default><equality active="false"/></default>'
    both = f"<equality>{CONNECTS['sites']}<connect body1='crank' anchor='0 0 0' /></equality>"
    text = HALVES.format(rocker=ROCKER, more=off + both)
    assert read(text).loops == ()
    assert read(text).notation == "no loops"
    assert [remark.split(": ", 1)[1] for remark in read(text).warnings] == [
        "<equality> <connect> 'c': left out, as it is not active",
        "<equality> <connect> 2: left out, as it is not active",
    ]
    (found,) = read(text.replace("anchor='0 0 0'", "anchor='0 0 0' active='true'")).loops
    assert (found.name, found.predecessor, found.successor) == ("equality_2", "crank", "world")
    flagged = text.replace(off, '<option><flag equality="disable"/></option>')
    assert read(flagged).loops == ()


TWO = """<mujoco><worldbody>
<body name="b1" pos="0 0 1" euler="0 0 30"><joint name="e"/>
  <site name="s1" pos=".1 .2 .3" euler="10 20 30"/></body>
<body name="b2" pos="1 0 0" euler="40 0 0"><joint/>
  <site name="s2" pos=".4 .2 .3" euler="10 20 70"/></body>
</worldbody><equality>{}</equality></mujoco>"""


def ends(equality: str) -> tuple[LoopDescription, np.ndarray, np.ndarray]:
    """Return a loop, and both placements of its frame in the world, initially."""
    (found,) = read(TWO.format(equality)).loops
    placements = placed(cd.load(TWO.format("")), {})
    return (
        found,
        placements[found.predecessor].homogeneous @ found.predecessor_origin,
        placements[found.successor].homogeneous @ found.successor_origin,
    )


@pytest.mark.parametrize(
    ("equality", "first", "second"),
    [
        # eq_data of MuJoCo 4.0: points in the bodies that coincide.
        ('<connect body1="b1" body2="b2" anchor="1 2 3"/>', (1, 2, 3), (-1.13397, 4.281, 1.62944)),
        ('<connect body1="b1" anchor="1 2 3"/>', (1, 2, 3), (-0.13397, 2.23205, 4)),
        ('<connect body1="world" body2="b1" anchor="1 2 3"/>', (1, 2, 3), (1.86603, 1.23205, 2)),
        ('<connect site1="s1" site2="s2"/>', (0.1, 0.2, 0.3), (0.4, 0.2, 0.3)),
        ('<weld body1="b1" body2="b2"/>', (0.86603, -0.5, -1), (0, 0, 0)),
        (
            '<weld body1="b1" body2="b2" anchor=".1 .2 .3" relpose="5 6 7 0 0 0 0"/>',
            (0.93281, -0.58432, -0.64163),
            (0.1, 0.2, 0.3),
        ),
        ('<weld body1="b1" body2="b2" relpose=".5 .6 .7 1 .1 0 0"/>', (0.5, 0.6, 0.7), (0, 0, 0)),
        (
            '<weld body1="b1" body2="b2" anchor=".1 .2 .3" relpose=".5 .6 .7 1 .1 0 0"/>',
            (0.5, 0.6, 0.7),
            (0.1, 0.2, 0.3),
        ),
        ('<weld body1="b1"/>', (0, 0, -1), (0, 0, 0)),
        ('<weld site1="s1" site2="s2"/>', (0.1, 0.2, 0.3), (0.4, 0.2, 0.3)),
    ],
)
def test_where_equalities_hold(
    equality: str, first: tuple[float, ...], second: tuple[float, ...]
) -> None:
    found, predecessor, successor = ends(equality)
    assert found.type == ("spherical" if "connect" in equality else "fixed")
    np.testing.assert_allclose(found.predecessor_origin[:3, 3], first, atol=1e-5)
    np.testing.assert_allclose(found.successor_origin[:3, 3], second, atol=1e-5)
    if "connect" in equality or not ("relpose" in equality or "site" in equality):
        np.testing.assert_allclose(predecessor[:3, :3], successor[:3, :3], atol=1e-14)
    if "relpose" in equality and "0 0 0 0" not in equality:
        turn = pin.Quaternion(np.array([0.1, 0.0, 0.0, 1.0])).normalized().matrix()
        np.testing.assert_allclose(found.predecessor_origin[:3, :3], turn, atol=1e-14)
        np.testing.assert_array_equal(found.successor_origin[:3, :3], np.eye(3))


def test_equalities_are_named_apart_from_joints() -> None:
    connect = '<connect {} body1="b1" body2="b2" anchor="0 0 0"/>'
    named = [connect.format(f'name="{name}"') if name else connect.format("") for name in "ef"]
    text = TWO.format("".join([*named, connect.format(""), connect.format('name="equality_4"')]))
    assert [found.name for found in read(text).loops] == [
        *("e_2", "f", "equality_3", "equality_4"),
    ]


def test_couplings_of_two_joints() -> None:
    gear = '<joint name="g" joint1="e" joint2="f" polycoef="0 -2.5 0 0 0"/>'
    wheels = TWO.replace("<joint/>", '<joint name="f"/>').replace('euler="40 0 0"', "")
    mass = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
    mechanism = cd.load(wheels.format(gear).replace("<site", mass + "<site"))
    turn = cd.Scene(mechanism, drive="f").sweep([0.1, 0.2], acceleration=1.0)
    np.testing.assert_allclose(turn.motion.position("e"), [-0.25, -0.5], rtol=1e-13)
    np.testing.assert_allclose(turn.drive_effort, 1.0 + 2.5**2, rtol=1e-13)
    with pytest.raises(cd.ModelError, match="is not supported except as a coupling"):
        read(wheels.format(gear.replace("-2.5", "0")))
    ball = wheels.replace('name="f"', 'name="f" type="ball"')
    with pytest.raises(cd.ModelError, match="only HINGE and SLIDE joint allowed"):
        read(ball.format(gear))


def test_couplings_count_from_the_initial_configuration() -> None:
    """As MuJoCo does: `ref` shifts the joints' coordinates and not what the polynomial says."""
    gear = '<joint name="g" joint1="e" joint2="f" polycoef="0.4 -2.5 0 0 0"/>'
    slide = '<joint name="f" type="slide" ref="0.3"/>'
    rack = TWO.replace('<joint name="e"/>', '<joint name="e" ref="40"/>').replace("<joint/>", slide)
    (found,) = read(rack.format(gear)).couplings
    assert (found.name, found.predecessor, found.successor) == ("g", "f", "e")
    assert (found.ratio, found.offset, found.of_joints) == (-2.5, 0.4, True)
    turn = cd.Scene(cd.load(rack.format(gear)), drive="f").sweep([0.0, 0.1])
    np.testing.assert_allclose(turn.motion.position("e"), [0.4, 0.15], rtol=1e-13)


CHAIN = """<mujoco><worldbody>
<body name="A" pos="0 0 1"><joint name="e" axis="0 1 0" ref="40"/>
  <inertial pos=".1 0 0" mass="1" diaginertia="1 1 1"/>
  <body name="B" pos=".5 0 0"><joint name="f" type="slide" axis="1 0 0" ref=".3"/>
    <inertial pos="0 .1 0" mass="2" diaginertia="1 1 1"/></body></body>
<body name="C" pos="1 0 0"><joint name="g" axis="0 1 0"/>
  <inertial pos="0 0 .2" mass="1" diaginertia="1 1 1"/></body></worldbody>
<equality><joint joint1="f" joint2="e" polycoef=".4 -.5 0 0 0"/>
<joint joint1="g" joint2="f" polycoef="-.2 3 0 0 0"/></equality></mujoco>"""


def test_a_chain_of_couplings_against_mujoco() -> None:
    """Place of B and effort of e at 0.7 rad, where MuJoCo 4.0.0 finds both equalities met."""
    scene = cd.Scene(cd.load(CHAIN), drive="e", gravity=(0.0, 0.0, -9.81))
    turn = scene.sweep([0.7])
    at = {name: float(turn.motion.position(name)[0]) for name in "efg"}
    place = placed(scene.mechanism, at)["B"].translation
    np.testing.assert_allclose(place, [0.420663203006, 0.0, 0.645680272019], atol=1e-12)
    np.testing.assert_allclose(turn.drive_effort, -2.831035412074858, rtol=1e-13)


TENDONS = """<mujoco><worldbody><body name="b"><inertial pos=".1 0 0" mass="1"
  diaginertia=".01 .01 .01"/><joint name="j" axis="0 1 0" ref="12"/><body name="c" pos=".2 0 0">
  <inertial pos=".1 0 0" mass="1" diaginertia=".01 .01 .01"/><joint name="k" axis="0 1 0"/></body>
  </body></worldbody><tendon><fixed name="s"><joint joint="j" coef="2"/><joint joint="k"
  coef="-4"/></fixed><fixed name="t"><joint joint="j" coef="2"/></fixed><fixed name="u">
  <joint joint="k" coef="5"/></fixed></tendon><equality>{}</equality></mujoco>"""


def test_limited_tendons_are_said_to_couple_nothing() -> None:
    """Limits of nothing but a thousandth are a gear to MuJoCo, whose limits are soft."""
    text = TENDONS.format("")
    assert not any("tendon" in warning for warning in cd.load(text).warnings)
    limited = text.replace('<fixed name="s">', '<fixed name="s" limited="true" range="-.001 .001">')
    (said,) = (warning for warning in cd.load(limited).warnings if "tendon" in warning)
    assert said.endswith("limits of 1 tendon (s) left out: they couple nothing")


@pytest.mark.parametrize(
    ("equality", "ratio", "offset"),
    [
        ('<tendon name="e" tendon1="s" polycoef="0.6 9 9 9 9"/>', 0.5, -0.15),
        ('<tendon name="e" tendon1="t" tendon2="u" polycoef="0.2 0.8 0 0 0"/>', 0.5, -0.05),
        ('<tendon name="e" tendon1="u" tendon2="s" polycoef="0.3 0.5 0 0 0"/>', 1 / 7, 0.3 / 7),
    ],
)
def test_fixed_tendons_couple_two_joints(equality: str, ratio: float, offset: float) -> None:
    """2 j - 4 k = 0.6; 2 j = 0.2 + 0.8 · 5 k; 5 k = 0.3 + 0.5 (2 j - 4 k), from the start."""
    mechanism = cd.load(TENDONS.format(equality))
    (found,) = mechanism.description.couplings
    assert (found.name, found.predecessor, found.successor) == ("e", "j", "k")
    assert (found.ratio, found.offset) == (pytest.approx(ratio), pytest.approx(offset))
    turn = cd.Scene(mechanism, drive="j", gravity=(0, 0, -9.81)).sweep([0.1, 0.7], speed=2.0)
    np.testing.assert_allclose(turn.motion.position("k"), ratio * np.array([0.1, 0.7]) + offset)
    (again,) = mechanism.second_reading.couplings
    assert again.ratio == pytest.approx(found.ratio, rel=1e-13)
    assert again.offset == pytest.approx(found.offset, rel=1e-13)


@pytest.mark.parametrize("ratio", [-1.0, 0.0, 0.7])
@pytest.mark.parametrize("driven", ["j", "k"])
def test_tendons_of_single_joints_follow_a_polynomial(ratio: float, driven: str) -> None:
    """2 j of a tendon, 5 k of the other; as MuJoCo's own residual says."""
    mujoco = pytest.importorskip("mujoco")
    driving = "jk".replace(driven, "")
    first, second = ("t", "u") if driven == "j" else ("u", "t")
    equality = f'<tendon tendon1="{first}" tendon2="{second}" polycoef="0.2 {ratio} 0.3 0 -0.04"/>'
    text = TENDONS.format(equality)
    mechanism = cd.load(text)
    (found,) = mechanism.description.couplings
    (again,) = mechanism.second_reading.couplings
    assert (found.predecessor, found.successor) == (driving, driven)
    for name in ("ratio", "offset", "higher"):
        np.testing.assert_allclose(getattr(found, name), getattr(again, name), rtol=1e-14)
    at = np.array([-0.3, 0.1, 0.25])
    scene = cd.Scene(mechanism, drive=driving, gravity=(0, 0, -9.81))
    turn = scene.sweep(at, speed=2.0)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    for k in range(len(at)):
        for name in "jk":
            place = model.joint(name).qposadr[0]
            data.qpos[place] = model.qpos0[place] + turn.motion.position(name)[k]
        mujoco.mj_forward(model, data)
        assert data.efc_type[0] == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        assert abs(data.efc_pos[0]) < 1e-13


@pytest.mark.parametrize(
    "equality",
    [
        '<tendon tendon1="t"/>',
        '<tendon tendon1="t" tendon2="s" polycoef="0 1 0.1 0 0"/>',
        '<tendon tendon1="t" tendon2="s" polycoef="0 -1 0.1 0 0"/>',
        '<tendon tendon1="t" tendon2="u" polycoef="0.1 0 0 0 0"/>',
        '<tendon tendon1="s"/><joint joint1="k"/>',
    ],
)
def test_tendons_that_couple_no_two_joints_are_refused(equality: str) -> None:
    with pytest.raises(cd.ModelError, match=r"<tendon> 1: it is not supported; .* tendon where"):
        read(TENDONS.format(equality))


def test_couplings_stand_in_the_order_of_their_joints() -> None:
    gears = '<joint name="{0}" joint1="{0}" joint2="{1}"/>'
    text = FREE.format(gears.format("g", "e") + gears.format("f", "e"))
    assert [coupling.name for coupling in read(text).couplings] == ["f_2", "g_2"]


def test_a_slide_may_be_coupled_to_a_hinge() -> None:
    gear = '<joint name="g" joint1="e" joint2="f" polycoef="0 -2.5 0 0 0"/>'
    rack = TWO.replace("<joint/>", '<joint name="f" type="slide"/>').replace('euler="40 0 0"', "")
    mass = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
    mechanism = cd.load(rack.format(gear).replace("<site", mass + "<site"))
    turn = cd.Scene(mechanism, drive="f").sweep([0.1, 0.2], acceleration=1.0)
    np.testing.assert_allclose(turn.motion.position("e"), [-0.25, -0.5], rtol=1e-13)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (TWO.format('<connect body1="b1"/>'), "must be specified"),
        (TWO.format('<connect site1="s1" body1="b1"/>'), "can be specified"),
        (TWO.format('<connect body1="x" anchor="0 0 0"/>'), "unknown element 'x'"),
        (TWO.format('<weld site1="s1" site2="s3"/>'), "unknown element 's3'"),
        (TWO.format('<weld body1="b1" body2="b1"/>'), "element 'b1' is repeated"),
        (TWO.format('<weld body1="b1" torquescale="0"/>'), "is a ball; write <connect>"),
        (TWO.format('<weld body1="b1" active="yes"/>'), "invalid keyword: 'yes'"),
        (TWO.format('<joint joint1="x"/>'), "unknown element 'x'"),
        (
            TWO.format('<tendon tendon1="t"/>').replace(
                "<equality>",
                '<tendon><fixed name="t"><joint joint="e" coef="1"/></fixed></tendon><equality>',
            ),
            "<equality> <tendon> 1: it is not supported; kinds: connect, joint, weld",
        ),
    ],
)
def test_refused(text: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        read(text)


FREE = """<mujoco><worldbody><body name="b1"><joint name="e"/>
<body name="fixed"><body name="b2"><joint name="f"/></body></body>
<body name="b3"><joint name="g"/></body></body></worldbody><equality>{}</equality></mujoco>"""


def test_couplings_of_any_two_joints() -> None:
    gear = '<joint name="c" joint1="g" joint2="{}" polycoef="0 3 0 0 0"/>'
    for driving in "ef":
        (found,) = read(FREE.format(gear.format(driving))).couplings
        assert (found.name, found.predecessor, found.successor) == ("c", driving, "g")
        assert (found.ratio, found.offset) == (3.0, 0.0)


def test_a_coupling_without_coefficients_has_the_ratio_1() -> None:
    (found,) = read(FREE.format('<joint joint1="g" joint2="f"/>')).couplings
    assert (found.name, found.ratio) == ("equality_1", 1.0)


def test_equalities_keep_the_order_of_the_file() -> None:
    description = read(
        FREE.format(
            '<weld body1="b2"/><joint joint1="g" joint2="f"/><connect body1="b3" anchor="0 0 0"/>'
        )
    )
    assert [(item.name, item.type) for item in description.loops] == [
        ("equality_1", "fixed"),
        ("equality_3", "spherical"),
    ]
    assert description.notation == "MJCF <equality>"


def test_flags_of_the_equalities() -> None:
    text = FREE.format('<weld body1="b2"/>')
    for flag, count in (("enable", 1), ("disable", 0)):
        option = f'<option><flag equality="{flag}"/></option><worldbody>'
        assert len(read(text.replace("<worldbody>", option)).loops) == count
    with pytest.raises(cd.ModelError, match="invalid keyword: 'off'"):
        read(text.replace("<worldbody>", '<option><flag equality="off"/></option><worldbody>'))
