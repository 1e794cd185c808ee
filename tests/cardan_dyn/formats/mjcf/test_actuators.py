"""What actuators may exert along joints is what MuJoCo lets them exert."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.core.description.read import read
from cardan_dyn.practice.formats.mjcf.writer import to_mjcf

mujoco = pytest.importorskip("mujoco")

SLIDER = """\
<mujoco><option gravity="0 0 0">{option}</option><worldbody><body name="rod"><joint name="ram"
type="slide" axis="0 0 1"{joint}/><inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/></body>
</worldbody><actuator>{actuators}</actuator></mujoco>"""


def slider(actuators: str, joint: str = "", option: str = "") -> str:
    return SLIDER.format(actuators=actuators, joint=joint, option=option)


def exerted(text: str) -> tuple[float, float]:
    """Return the least and the greatest effort that MuJoCo exerts, wherever it is and moves."""
    model = mujoco.MjModel.from_xml_string(text)
    data, found = mujoco.MjData(model), []
    ends = (-1e9, 0.0, 1e9)
    for control in product(ends, repeat=model.nu):
        for position, speed in product(ends, repeat=2):
            mujoco.mj_resetData(model, data)
            data.ctrl[:], data.qpos[:], data.qvel[:] = control, position, speed
            for _ in range(3):  # Activations follow.
                mujoco.mj_forward(model, data)
                found.append(float(data.qfrc_actuator[0]))
                data.act[:] += 1e6 * data.act_dot * model.opt.timestep
                for limited, ends_of in (
                    (model.actuator_actlimited, model.actuator_actrange),
                    (model.actuator_ctrllimited, model.actuator_ctrlrange),
                ):
                    if model.na and limited[0]:
                        data.act[:] = np.clip(data.act, *ends_of[0])
                        break
    return min(found), max(found)


@pytest.mark.parametrize(
    ("actuators", "joint"),
    [
        ('<motor joint="ram" gear="15000" forcerange="-0.4 0.6"/>', ""),
        ('<motor joint="ram" gear="-15000" forcerange="-0.4 0.6"/>', ""),
        ('<motor joint="ram" forcerange="-9000 9000"/>', ""),
        ('<motor joint="ram" gear="9000" ctrlrange="-1 0.5"/>', ""),
        ('<motor joint="ram" gear="9000" ctrlrange="-1 1" forcerange="-0.4 3"/>', ""),
        ('<motor joint="ram" ctrlrange="2 7"/>', ""),
        ('<motor joint="ram" gear="0" ctrlrange="2 7"/>', ""),
        ('<position joint="ram" kp="1e6" kv="1e4" ctrlrange="0 0.3" forcerange="-60 90"/>', ""),
        ('<velocity joint="ram" kv="1e4" ctrlrange="0 0.3" forcerange="-60 90"/>', ""),
        ('<general joint="ram" gainprm="3" ctrlrange="-2 5"/>', ""),
        ('<general joint="ram" gainprm="-3" biastype="affine" biasprm="4" ctrlrange="-2 5"/>', ""),
        ('<general joint="ram" gaintype="affine" gainprm="3 0 0" ctrlrange="-2 5"/>', ""),
        ('<general joint="ram" dyntype="filter" dynprm="0.1" ctrlrange="2 5"/>', ""),
        ('<general joint="ram" dyntype="integrator" actrange="-2 5" ctrlrange="-1 1"/>', ""),
        ('<cylinder joint="ram" area="0.003" ctrlrange="-2e6 3e6"/>', ""),
        ('<motor jointinparent="ram" forcerange="-6 9"/>', ""),
        ('<motor joint="ram" forcerange="-6 9"/>', ' actuatorfrcrange="-7 8"'),
        ('<motor joint="ram" forcerange="5 9"/>', ' actuatorfrcrange="-7 3"'),
        (
            '<motor joint="ram" ctrlrange="-6 9"/><motor joint="ram" gear="-2" ctrlrange="-1 3"/>',
            "",
        ),
    ],
)
def test_limits_are_what_mujoco_exerts_at_most(actuators: str, joint: str) -> None:
    text = slider(actuators, joint)
    limits = read(text, strict=False).joints[-1].limits
    np.testing.assert_allclose(limits.efforts, exerted(text), rtol=1e-12)
    # And so it is of what is written, if that is a range.
    if limits.efforts[0] < limits.efforts[1]:
        written = to_mjcf(read(text, strict=False))
        assert read(written).joints[-1].limits == limits
        np.testing.assert_allclose(limits.efforts, exerted(written), rtol=1e-12)


def test_limits_on_one_side_stay_so(tmp_path: Path) -> None:
    """As the greatest number on the other side, which no motion of MuJoCo's comes near."""
    text = """<robot name="r"><link name="ground"/><link name="rod"><inertial><mass value="2"/>
    <inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="ram" type="prismatic"
    independent="true"><parent link="ground"/><child link="rod"/><axis xyz="0 0 1"/>
    <limit lower="-inf" upper="0.5" velocity="inf" effort="inf" least_effort="-3"/></joint>
    </robot>"""
    path = cd.write(cd.load(text), tmp_path / "rod.xml")  # And no warning.
    joint = cd.load(path).description.joints[-1]
    assert (joint.limits.lower, joint.limits.upper) == (-np.inf, 0.5)
    assert joint.limits.efforts == (-3.0, np.inf)
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    for position, stopped in ((-1e6, False), (0.4, False), (0.6, True)):
        data.qpos[0] = position
        mujoco.mj_forward(model, data)
        assert (data.nefc > 0) == stopped


def test_controls_are_not_clamped_where_the_file_says_so() -> None:
    text = slider('<motor joint="ram" ctrlrange="-6 9"/>', option='<flag clampctrl="disable"/>')
    assert read(text).joints[-1].limits.efforts == (-np.inf, np.inf)
    assert exerted(text) == (-1e9, 1e9)


def test_each_sense_of_a_cylinder_is_judged_by_its_own_limit() -> None:
    """A cylinder that pulls with 15 N and pushes with 25 N carries 2 kg up, and not 3 kg down."""
    text = slider('<motor name="cylinder" joint="ram" gear="10" forcerange="-1.5 2.5"/>')
    scene = cd.Scene(cd.load(text), gravity=(0, 0, -9.81))
    assert scene.drives == ("ram",)
    at = np.zeros(3)
    assert "exceeds" not in str(scene.sweep(at, acceleration=[0.0, 2.6, -17.3], speed=at))
    up = str(scene.sweep(at, acceleration=[0.0, 2.8, 0.0], speed=at))
    assert "exceeds effort limit of ram (25 N): 25.22 N" in up
    down = str(scene.sweep(at, acceleration=[0.0, -17.4, 0.0], speed=at))
    assert "exceeds effort limit of ram (-15 N): -15.18 N" in down


def test_actuators_that_act_along_no_joint_are_told() -> None:
    text = slider('<motor name="jet" site="s"/>').replace("<inertial", '<site name="s"/><inertial')
    (told,) = (line for line in read(text).warnings if "actuator" in line)
    assert told.endswith("efforts of 1 actuator (jet) left out: they act along no joint alone")


GEAR = """<mujoco model="gear"><option gravity="0 0 -9.81"/><worldbody><site name="eye"
pos="1 0 0"/><body name="b"><joint name="second" axis="0 1 0"/><inertial pos="0 0 1" mass="2"
diaginertia="1 1 1"/><body name="c" pos="0 0 2"><joint name="first"
type="ball"/><inertial pos="0 0 1" mass="1"
diaginertia="1 1 1"/></body></body>
<body name="a"><joint name="ram" type="slide" axis="0 0 1"/><inertial pos="0 0 0" mass="3"
diaginertia="1 1 1"/></body></worldbody>
<equality><joint name="link" joint1="second" joint2="ram" polycoef="0 2 0 0 0"/></equality>
<actuator><motor name="retract" joint="ram" gear="15000" ctrlrange="-1 1" forcerange="-0.4 0.6"/>
</actuator><keyframe><key name="up" qpos="0.5 0.6 0 0.8 0 0.25"/></keyframe></mujoco>"""


def test_actuators_keyframes_and_sites_are_written_in_their_order(tmp_path: Path) -> None:
    mechanism = cd.load(GEAR)
    path = cd.write(mechanism, tmp_path / "gear.xml")
    first, again = (mujoco.MjModel.from_xml_string(text) for text in (GEAR, path.read_text()))
    np.testing.assert_allclose(again.key_qpos, first.key_qpos, rtol=0, atol=1e-15)
    for name in ("gear", "ctrlrange", "forcerange"):
        np.testing.assert_array_equal(
            *(getattr(model, f"actuator_{name}") for model in (first, again))
        )
    assert [again.joint(k).name for k in range(3)] == ["second", "first", "ram"]
    assert (again.actuator(0).name, again.key(0).name) == ("retract", "up")
    np.testing.assert_array_equal(again.site("eye").pos, [1.0, 0.0, 0.0])
    np.testing.assert_array_equal(again.jnt_actfrclimited, 0)
    assert cd.load(path).description == mechanism.description


def test_keyframes_without_a_name_are_numbered() -> None:
    keys = """<key qpos="0.5 0.6 0 0.8 0 0.25"/><key name="keyframe_3" qpos="0 1 0 0 0 0"/>
        <key qpos="1 1 0 0 0 0.5"/>"""
    found = cd.load(GEAR.replace("<key name", f"{keys}<key name")).description.keyframes
    assert list(found) == ["keyframe_1", "keyframe_3", "keyframe_3_2", "up"]
    assert [found[name]["ram"] for name in found] == [0.25, 0.0, 0.5, 0.25]


def test_keyframes_count_from_where_the_zero_is_put(tmp_path: Path) -> None:
    """Bodies stand where they stood in the keyframe, whatever counts as zero."""
    path = cd.write(cd.load(GEAR), tmp_path / "up.xml", at="up")
    first, again = (mujoco.MjModel.from_xml_string(text) for text in (GEAR, path.read_text()))
    np.testing.assert_allclose(again.key_qpos, [[0, 1, 0, 0, 0, 0]], rtol=0, atol=1e-12)
    placed = []
    for model in (first, again):
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, 0)
        mujoco.mj_kinematics(model, data)
        placed.append([data.body(name).xmat for name in "abc"])
    np.testing.assert_allclose(*placed, rtol=0, atol=1e-12)


def test_what_a_notation_has_no_word_for_is_told(tmp_path: Path) -> None:
    mechanism = cd.load(GEAR, forces={"link": "none"})
    with pytest.warns(UserWarning, match="no word for it: forces of coupling 'link'$"):
        cd.write(mechanism, tmp_path / "gear.xml")
    told = "keyframe 'up'; frame 'eye'; actuator 'retract'; gravity$"
    with pytest.warns(UserWarning, match=told):
        path = cd.write(mechanism, tmp_path / "gear.urdf")
    written = {joint.name: joint for joint in cd.load(path).description.joints}
    assert written["ram"].limits.efforts == (-6000.0, 9000.0)


def test_servos_become_motors_which_is_told(tmp_path: Path) -> None:
    text = slider('<position name="p" joint="ram" kp="1e6" forcerange="-60 90"/>')
    with pytest.warns(UserWarning, match="law of actuator 'p', which is a motor now"):
        path = cd.write(cd.load(text), tmp_path / "slider.xml")
    assert exerted(path.read_text()) == (-60.0, 90.0)


def test_a_file_without_words_for_forces_of_couplings_is_given_them() -> None:
    given = {"drive": "ram", "held": {"first": [0, 0, 0, 1]}, "gravity": "description"}
    with pytest.raises(cd.IndeterminateError, match=r"load\(\.\.\., forces="):
        cd.Scene(cd.load(GEAR), strict=True, **given).sweep([0.1])
    silent = cd.load(GEAR, forces={"link": "none"})
    found = cd.Scene(silent, strict=True, **given).sweep([0.1])
    # By virtual work: 3 kg up, and 2 kg and 1 kg at 1 m and 3 m that turn twice as far.
    by_hand = 9.81 * (3.0 - 2.0 * (2.0 * 1.0 + 1.0 * 3.0) * np.sin(0.2))
    np.testing.assert_allclose(found.drive_effort, by_hand, rtol=1e-12)
    with pytest.raises(cd.ArgumentError, match="no coupling 'lnk'; couplings: link"):
        cd.load(GEAR, forces={"lnk": "none"})
    with pytest.raises(cd.ModelError, match="forces 'teeth' is unknown"):
        cd.load(GEAR, forces={"link": "teeth"})


def test_resting_beyond_limits_is_told() -> None:
    """2 kg on a spring of 1 kN/m sink 19.62 mm, where 15 mm are allowed."""
    text = slider("", ' range="-0.015 0.1" stiffness="1000"').replace("<actuator></actuator>", "")
    mechanism = cd.load(text)
    scene = cd.Scene(
        mechanism, free=["ram"], gravity=(0, 0, -9.81), elements=cd.described_elements(mechanism)
    )
    rest = scene.equilibrium()
    np.testing.assert_allclose(rest.position, -0.01962, rtol=1e-9)
    assert "exceeds limit of ram (-15 mm): -19.62 mm" in repr(rest)
