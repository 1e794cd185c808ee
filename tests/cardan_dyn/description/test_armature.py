"""Rotors that files and models state: what is read, read again, written and refused."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import cardan_dyn as cd
from cardan_dyn.core.description.description import Description
from cardan_dyn.core.description.second_reading import reread

URDF = """<robot name="arm" xmlns:drake="http://drake.mit.edu"><link name="a"/><link name="b"/>
<link name="c"/><link name="d"/><joint name="hinge" type="continuous"><parent link="a"/>
<child link="b"/><dynamics damping="1" armature="0.1"/></joint>
<joint name="slide" type="prismatic"><parent link="b"/><child link="c"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="cross" type="universal"><parent link="c"/><child link="d"/><axis2 xyz="0 1 0"/>
<dynamics armature="0.2 0.3"/></joint>
<joint name="stay" type="fixed" adjustable="revolute"><parent link="d"/><child link="e"/>
<dynamics armature="0.7"/></joint><link name="e"/>
<loop name="ball" type="spherical"><predecessor link="e"/><successor link="a"/>
<dynamics armature="0.4"/></loop>{}</robot>"""
DRAKE = """<transmission name="t"><joint name="{}"/>{}<actuator name="m">
<drake:rotor_inertia value="{}"/>{}</actuator></transmission>"""


def rotors(description: Description) -> dict[str, tuple[float, ...]]:
    return {item.name: item.armature for item in description.joints_and_loops if item.armature}


def agreed(mechanism: cd.Mechanism) -> dict[str, tuple[float, ...]]:
    """Return the rotors of a mechanism, which the proof reads alike."""
    found, again = rotors(mechanism.description), rotors(reread(mechanism.description))
    assert found.keys() == again.keys()
    for name, values in found.items():
        np.testing.assert_allclose(again[name], values, rtol=1e-15)
    assert rotors(pickle.loads(pickle.dumps(mechanism)).description) == found
    return found


STATED = {"hinge": (0.1,), "cross": (0.2, 0.3), "stay": (0.7,), "ball": (0.4,)}


def test_a_urdf() -> None:
    mechanism = cd.load(URDF.format(""))
    assert agreed(mechanism) == STATED
    assert "armature 0.2 0.3" in str(mechanism.description)
    rates = mechanism.coordinates.velocity_columns
    assert mechanism.model.armature[rates["cross"]].tolist() == [0.2, 0.3]
    assert mechanism.model.armature[rates["ball"]].tolist() == [0.4] * 3
    assert mechanism.model.armature.sum() == pytest.approx(0.1 + 0.5 + 1.2)


def test_rotors_in_drakes_words() -> None:
    """Beside an armature, and by the squares of ratios, which along slides are in rad/m."""
    ratio = '<drake:gear_ratio value="{}"/>'
    more = DRAKE.format("hinge", "", 0.002, ratio.format(-20))
    more += DRAKE.format("slide", "<type>x</type>", 1e-4, ratio.format(300)) + DRAKE.format(
        "slide", "", 0.5, ""
    )
    mechanism = cd.load(URDF.format(more))
    found = agreed(mechanism)
    assert found["hinge"] == pytest.approx((0.9,))
    assert found["slide"] == pytest.approx((9.5,))
    assert not [line for line in mechanism.warnings if "transmission" in line]


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (DRAKE.format("cross", "", 1, ""), "belongs to one joint with one coordinate, not to cr"),
        (DRAKE.format("hinge", '<joint name="slide"/>', 1, ""), "not to hinge, slide"),
        (DRAKE.format("hinge", "", -1, ""), "-1 is negative"),
        (DRAKE.format("hinge", "", "x", ""), "rotor_inertia"),
        (DRAKE.format("hinge", "", 1, "<drake:gear_ratio/>"), "gear_ratio: None is not"),
        (DRAKE.format("hinge", "", 1, '<drake:rotor_inertia value="1"/>'), "2 <rotor_inertia>"),
        (DRAKE.format("hinge", "", 1, 2 * '<drake:gear_ratio value="2"/>'), "2 <gear_ratio>"),
        (DRAKE.format("hinge", "", 1, '<drake:gear_ratio value="1e30"/>'), "is beyond 1e\\+50"),
    ],
)
def test_transmissions_that_are_refused(more: str, said: str) -> None:
    with pytest.raises(cd.ModelError, match=said):
        cd.load(URDF.format(more))


@pytest.mark.parametrize(
    "inside",
    [
        '<actuator name="m"/>',
        '<joint/><actuator name="m"/>',
        '<joint name="elsewhere"/><actuator name="m"><drake:gear_ratio value="x"/></actuator>',
        '<joint name="hinge"/><joint name="slide"/><actuator name="m"/>',
    ],
)
def test_transmissions_of_other_programs_are_passed_over(inside: str) -> None:
    """Those without a rotor, whatever else they state or leave out."""
    mechanism = cd.load(URDF.format(f"<transmission>{inside}</transmission>"))
    assert agreed(mechanism) == STATED
    told = "<transmission> is for other programs" in " ".join(mechanism.warnings)
    assert told is ("hinge" not in inside)  # A joint of the description is a drive.


@pytest.mark.parametrize(
    ("stated", "said"),
    [
        ("0.1 0.2", "there are 2 numbers; write one for all motions of the continuous joint"),
        ("-1", "-1 is negative, which no inertia is"),
        ("", "is not 1 finite number"),
        ("nan", "is not 1 finite number"),
    ],
)
def test_numbers_that_are_refused(stated: str, said: str) -> None:
    text = URDF.format("").replace('armature="0.1"', f'armature="{stated}"')
    with pytest.raises(cd.ModelError, match=said):
        cd.load(text)


def test_nothing_is_said_of_zeros() -> None:
    text = URDF.format("").replace('armature="0.1"', 'armature="0"')
    assert agreed(cd.load(text)) == {name: STATED[name] for name in ("cross", "stay", "ball")}


MASSES = "".join(
    f'<link name="{name}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" '
    'ixz="0" iyz="0"/></inertial></link>'
    for name in "bcde"
)


@pytest.mark.parametrize("suffix", [".urdf", ".xml"])
def test_they_are_written_and_read_back(suffix: str, tmp_path: Path) -> None:
    """In MJCF, joints of several parts are several joints, and a ball with a rotor is one."""
    text = URDF.format("").replace('<link name="e"/>', "")
    text = text.replace("<link", "<skip", 0)
    for name in "bcd":
        text = text.replace(f'<link name="{name}"/>', "", 1)
    text = text.replace('type="fixed" adjustable="revolute"', 'type="revolute"', 1)
    text = text.replace('<link name="a"/>', '<link name="a"/>' + MASSES, 1)
    text = text.replace('<dynamics armature="0.7"/>', '<limit effort="1" velocity="1"/>')
    mechanism = cd.load(text)
    again = cd.load(cd.write(mechanism, tmp_path / f"again{suffix}"))
    found = agreed(again)
    if suffix == ".urdf":
        assert found == {name: STATED[name] for name in ("hinge", "cross", "ball")}
        assert again.description.agrees(mechanism.description, 1e-14)
    else:
        assert found == {"hinge": (0.1,), "cross_1": (0.2,), "cross": (0.3,), "ball": (0.4,)}


def test_a_fixed_joint_with_a_rotor_is_written_to_mjcf_as_fixed(tmp_path: Path) -> None:
    """What a scene may make of it, MJCF has no word for."""
    text = f"""<robot name="arm"><link name="a"/>{MASSES}
    <joint name="hinge" type="continuous"><parent link="a"/><child link="b"/>
    <dynamics armature="0.1"/></joint><joint name="stay" type="fixed" adjustable="revolute">
    <parent link="b"/><child link="c"/><dynamics armature="0.7"/></joint>
    <joint name="two" type="fixed"><parent link="b"/><child link="d"/></joint>
    <joint name="three" type="fixed"><parent link="b"/><child link="e"/></joint></robot>"""
    again = cd.load(cd.write(cd.load(text), tmp_path / "arm.xml"))
    assert agreed(again) == {"hinge": (0.1,)}


FREE = """<mujoco><worldbody><body name="b"><joint name="f" type="free" armature="0.4"/>
<inertial pos="0 0 .1" mass="1" diaginertia="1 1 1"/></body></worldbody></mujoco>"""


def test_a_free_body(tmp_path: Path) -> None:
    """It may be loaded and written; its ball has no angles along which it resists."""
    mechanism = cd.load(FREE)
    assert agreed(mechanism) == {"f": (0.4,) * 4}
    for suffix in (".xml", ".urdf"):
        again = cd.load(cd.write(mechanism, tmp_path / f"again{suffix}"))
        assert agreed(again) == {"f": (0.4,) * 4}
    names = [f"f.{name}" for name in ("x", "y", "z", "turn_x", "turn_y", "turn_z")]
    with pytest.raises(cd.ModelError, match="its ball has an armature, so that no scene can name"):
        cd.Scene(mechanism, free=names).simulate(0.1)
    text = (tmp_path / "again.urdf").read_text().replace("0.4 0.4 0.4 0.4", "1 1 1 0")
    with pytest.raises(cd.ModelError, match="MuJoCo knows one armature of all motions of a free"):
        cd.write(cd.load(text), tmp_path / "other.xml")
    with pytest.raises(cd.ModelError, match="slides of a floating joint have no directions"):
        cd.load(text.replace("1 1 1 0", "1 0 0 0"))


HINGES = """<mujoco><worldbody><body name="b"><joint name="one" axis="0 0 1" armature="0.4"/>
<inertial pos="0 0 .1" mass="1" diaginertia="1 1 1"/><body name="c"><joint name="two" axis="0 0 1"
armature="0.3"/><inertial pos="0 0 .1" mass="1" diaginertia="1 1 1"/></body></body></worldbody>
{}</mujoco>"""


def test_a_hinge_that_an_equality_holds_has_no_rotor() -> None:
    held = '<equality><joint joint1="two" polycoef="0.1 0 0 0 0"/></equality>'
    assert agreed(cd.load(HINGES.format(held))) == {"one": (0.4,)}


@pytest.mark.parametrize(
    ("of_tendon", "more"), [('armature="2"', ""), ("", '<motor tendon="t" armature="2"/>')]
)
def test_rotors_of_tendons_are_left_out(of_tendon: str, more: str) -> None:
    """In both readings, beside those of joints."""
    text = HINGES.format(
        f'<tendon><fixed name="t" {of_tendon}><joint joint="one" coef="1"/></fixed></tendon>'
        f'<actuator>{more}<motor joint="two" armature="0.1" gear="-2 7"/></actuator>'
    )
    found = agreed(cd.load(text, strict=False))
    assert found == {"one": (0.4,), "two": (pytest.approx(0.7),)}


def of_pinocchio() -> pin.Model:
    """A free body, a ball, two crossed hinges and a screw."""
    model, last = pin.Model(), 0
    for name, joint in (
        ("free", pin.JointModelFreeFlyer()),
        ("ball", pin.JointModelSpherical()),
        ("cross", pin.JointModelUniversal(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))),
        ("screw", pin.JointModelHZ(0.04)),
    ):
        last = model.addJoint(last, joint, pin.exp6(0.1 * np.arange(6.0)), name)
        inertia = pin.Inertia(1.0, np.array([0.1, 0.2, 0.3]), np.eye(3))
        model.appendBodyToJoint(last, inertia, pin.SE3.Identity())
    model.armature = np.array([0, 0, 0, 0.1, 0.1, 0.1, 0.2, 0.2, 0.2, 0.3, 0.4, 0.5])
    return model


def test_a_model_of_pinocchio() -> None:
    model = of_pinocchio()
    model.rotorInertia[9:11], model.rotorGearRatio[9:11] = 0.01, [2.0, -3.0]
    found = agreed(cd.from_pinocchio(model))
    assert found.pop("cross") == pytest.approx((0.34, 0.49))
    assert found == {"free": (0.0, 0.0, 0.0, 0.1), "ball": (0.2,), "screw": (0.5,)}


@pytest.mark.parametrize(
    ("inertia", "said"), [(-1.0, "is negative"), (1e60, "is beyond"), (np.nan, "nan is beyond")]
)
def test_numbers_of_pinocchio_that_are_refused(inertia: float, said: str) -> None:
    model = of_pinocchio()
    model.armature[-1] = inertia
    with pytest.raises(cd.ModelError, match=said):
        cd.from_pinocchio(model)


@pytest.mark.parametrize("rate", [0, 4, 8])
def test_what_pinocchios_rates_cannot_say(rate: int) -> None:
    """Slides along axes that turn with the body, and balls that resist by their axes."""
    model = of_pinocchio()
    model.armature[rate] += 0.25
    with pytest.raises(cd.ModelError, match="only one number for all axes of a ball is read"):
        cd.from_pinocchio(model)


def single(joint: object, armature: list[float]) -> pin.Model:
    model = pin.Model()
    body = model.addJoint(0, joint, pin.SE3.Identity(), "only")
    inertia = pin.Inertia(1.0, np.array([0.1, 0.2, 0.3]), np.eye(3))
    model.appendBodyToJoint(body, inertia, pin.SE3.Identity())
    model.armature = np.array(armature)
    return model


def test_slides_in_a_row_of_pinocchio() -> None:
    mechanism = cd.from_pinocchio(single(pin.JointModelTranslation(), [1.0, 2.0, 3.0]))
    assert sorted(agreed(mechanism).values()) == [(1.0,), (2.0,), (3.0,)]
    assert mechanism.model.armature.tolist() == [1.0, 2.0, 3.0]


def test_angles_of_pinocchio_are_no_ball() -> None:
    """Along angles that are rates, equal armatures are not about the axes of the child."""
    with pytest.raises(cd.ModelError, match="only one number for all axes of a ball is read"):
        cd.from_pinocchio(single(pin.JointModelSphericalZYX(), [0.3] * 3))


def test_a_mimic_of_pinocchio_counts_once() -> None:
    model = pin.buildModelFromXML(
        """<robot name="m"><link name="a"/><link name="b"/><link name="c"/>
        <joint name="one" type="continuous"><parent link="a"/><child link="b"/></joint>
        <joint name="two" type="continuous"><parent link="a"/><child link="c"/>
        <mimic joint="one" multiplier="2"/></joint></robot>""",
        mimic=True,
    )
    assert model.nv == 1
    model.armature[0] = 0.3
    mechanism = cd.from_pinocchio(model, strict=False)
    assert agreed(mechanism) == {"one": (0.3,)}
    turn = cd.Scene(mechanism, drive="one").sweep([0.1], acceleration=2.0)
    assert turn.drive_effort[0] == pytest.approx(0.6)
