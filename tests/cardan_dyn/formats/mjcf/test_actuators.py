"""What actuators may exert along joints is what MuJoCo lets them exert."""

from __future__ import annotations

from itertools import product

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
    if limits.efforts[0] < limits.efforts[1] and all(map(np.isfinite, limits.efforts)):
        written = to_mjcf(read(text, strict=False))
        assert read(written).joints[-1].limits == limits
        np.testing.assert_allclose(limits.efforts, exerted(written), rtol=1e-12)


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
