"""Keyframes of MJCF: scenes begin in them by name, where MuJoCo places the bodies."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

import cardan_dyn as cd

INERTIAL = '<inertial pos="0.1 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>'
CHAIN = f"""<mujoco><compiler angle="radian"/><worldbody>
  <body name="base" pos="0.1 0.2 0.3" quat="0.5 0.5 0.5 0.5"><freejoint name="root"/>{INERTIAL}
    <body name="arm" pos="0.2 0 0.1" euler="0.3 0.2 0.1"><joint name="h" axis="0 1 1" ref="0.4"/>
      {INERTIAL}
      <body name="hand" pos="0.3 0 0"><joint name="b" type="ball" pos="0.05 0 0.02"/>{INERTIAL}
        <body name="tip" pos="0.1 0 0"><joint name="s" type="slide" axis="1 0 0"/>{INERTIAL}
  </body></body></body></body></worldbody>
  <keyframe>
    <key qpos="0 0 0 1 0 0 0 0 1 0 0 0 0"/>
    <key name="home" qpos="-0.2 0.5 1 0.3 -0.4 0.8 0.2 0.9 0.6 0.1 -0.5 0.4 0.07"/>
  </keyframe></mujoco>"""
FOUR_BAR = f"""<mujoco><compiler angle="radian"/><worldbody>
  <body name="crank"><joint name="a" axis="0 0 1"/>{INERTIAL}
    <body name="coupler" pos="0.1 0 0"><joint name="b" axis="0 0 1"/>{INERTIAL}</body></body>
  <body name="rocker" pos="0.4 0 0"><joint name="d" axis="0 0 1"/>{INERTIAL}</body>
  </worldbody>
  <equality><connect name="c" body1="coupler" body2="rocker" anchor="0.3 0.2 0"/></equality>
  <keyframe><key name="up" qpos="{{}}"/><key name="off" qpos="1 2 3"/></keyframe></mujoco>"""


def test_bodies_are_where_mujoco_places_them() -> None:
    mechanism = cd.load(CHAIN)
    assert list(mechanism.description.keyframes) == ["keyframe_1", "home"]
    model = mujoco.MjModel.from_xml_string(CHAIN)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 1)
    mujoco.mj_forward(model, data)
    drives = ["root", "h", "b", "s"]
    for found in (
        cd.assemble(mechanism, near="home"),
        cd.Scene(
            mechanism, drive="h", held={}, near="home", free=["root", "b", "s"]
        ).configuration(),
        cd.Scene(mechanism, drive=drives, near="home").configuration(),
    ):
        for name in ("base", "arm", "hand", "tip"):
            expected = data.body(name)
            np.testing.assert_allclose(found.point(name), expected.xpos, atol=1e-12)
            np.testing.assert_allclose(
                found.orientation(name), expected.xmat.reshape(3, 3), atol=1e-12
            )


def test_rounded_keyframes_of_loops_mean_the_nearest_assembly() -> None:
    bar = cd.load(FOUR_BAR.format("0 0 0"))
    exact = cd.Scene(bar, drive="a", near={"a": 0.4}).configuration()
    rounded = " ".join(f"{exact[name]:.3f}" for name in "abd")
    bar = cd.load(FOUR_BAR.format(rounded))
    start = cd.Scene(bar, drive="a", near="up").configuration()
    for name in "abd":
        assert start[name] == pytest.approx(exact[name], abs=2e-3)
    assert start.loop_residual < 1e-12
    with pytest.raises(cd.AssemblyError, match="nearest closed configuration"):
        cd.Scene(bar, drive="a", near="off")


def test_held_joints_are_where_they_are_held() -> None:
    mechanism = cd.load(CHAIN)
    scene = cd.Scene(mechanism, drive=["root", "b"], held={"h": 0.1, "s": 0.2}, near="home")
    assert scene.configuration()["h"] == 0.1


def test_unknown_names_are_refused() -> None:
    mechanism = cd.load(CHAIN)
    for make in (
        lambda: cd.Scene(mechanism, drive="h", near="hom"),
        lambda: cd.assemble(mechanism, "hom"),
    ):
        with pytest.raises(cd.ArgumentError, match=r"no keyframe 'hom'.*mean 'home'"):
            make()
    with pytest.raises(
        cd.ArgumentError, match=r"no keyframe 'home'; keyframes of MJCF and .*: none"
    ):
        cd.assemble(cd.load("four_bar"), near="home")
