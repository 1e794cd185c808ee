"""Bodies that outputs leave out, and loads that change from sample to sample."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.drive_lines import two_lines
from testkit.scenes import relative, universal

import cardan_dyn as cd


def test_loads_on_links_that_the_outputs_leave_out() -> None:
    mechanism = cd.load(two_lines(2))
    wrench = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    options = {"drive": "bearing_0", "loads": {"left_shaft_2": wrench, "right_2": -4.0}}
    positions = np.linspace(0.0, 3.0, 9)
    whole = cd.Scene(mechanism, **options).sweep(positions)
    right = cd.Scene(mechanism, **options, outputs=["right_2"]).sweep(positions)
    assert relative(right["right_2"].moment, whole["right_2"].moment) < 1e-12


def test_frames_and_compliances_of_joints_that_the_outputs_leave_out() -> None:
    mechanism = cd.load(two_lines(2))
    positions = np.linspace(0.0, 3.0, 9)
    options = {"drive": "bearing_0", "loads": {"right_2": -4.0}}
    whole = cd.Scene(mechanism, **options).sweep(positions)
    name = "right_pin_1_in"
    right = cd.Scene(
        mechanism, **options, outputs=[name], compliance={"left_1": np.ones(6) * 1e-6}
    ).sweep(positions)
    wrench, expected = (turn.wrench(name, "parent") for turn in (right, whole))
    unique = expected.unique[3:]
    assert np.any(unique)
    assert relative(wrench.moment[:, unique], expected.moment[:, unique]) < 1e-12
    with pytest.raises(cd.ModelError, match="the outputs of the scene leave out joint 'left_2'"):
        right.origin("left_2")


def test_a_response_refuses_wrenches_that_change(joint: cd.Mechanism) -> None:
    loads = {"shaft_out": np.ones((10, 6))}
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.7}, loads=loads)
    with pytest.raises(cd.ArgumentError, match="'shaft_out' changes from sample to sample"):
        scene.response()


def test_a_response_of_efforts_that_feel_no_weight(joint: cd.Mechanism) -> None:
    scene = universal(joint, 0.7, gravity=(0.0, 0.0, -9.81), outputs=[])
    response = scene.response()
    positions = np.linspace(0.0, 6.0, 50)
    expected = scene.sweep(positions).drive_effort
    assert relative(response.sweep(positions).drive_effort, expected) < 1e-13


def test_undriven_joints_beside_a_loop_are_named(joint: cd.Mechanism) -> None:
    chain = "".join(
        f'<link name="l{k}"/><joint name="j{k}" type="continuous"><parent link="'
        f'{"shaft_in" if k == 0 else f"l{k - 1}"}"/><child link="l{k}"/>'
        '<origin xyz="0 0 0.1"/><axis xyz="0 1 0"/></joint>'
        for k in range(16)
    )
    text = joint.description.source.text.replace("</robot>", chain + "</robot>")
    with pytest.raises(cd.MobilityError, match=r"nothing decides the motion of: j0, j1"):
        universal(cd.load(text), 0.5)


def test_out_of_reach_of_several_drives_without_warnings() -> None:
    legs = [f"leg_{index}" for index in range(1, 7)]
    with pytest.raises(cd.ArgumentError, match="does not say where it is"):
        cd.Scene(cd.load("stewart_platform"), drive=legs).sweep([[1e155] * 6])
