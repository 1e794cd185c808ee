"""Bodies that outputs leave out, loads that change, and ways that meet: refused or right."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import relative, universal
from lines import two_lines

import cardan_dyn as cd
from cardan_dyn.assembly import Assembly

LINK = (
    '<link name="{0}"><inertial><origin xyz="0.1 0 0"/><mass value="1"/><inertia ixx=".01" '
    'iyy=".02" izz=".02" ixy="0" ixz="0" iyz="0"/></inertial></link>'
)


def parallelogram(crank: float, base: float, lean: float) -> str:
    """A linkage whose ways meet where all links are in line: crank at ±π/2 from upright."""
    tip = f"{-crank * np.sin(lean)!r} {crank * np.cos(lean)!r} 0".replace("np.float64", "")
    tip = tip.replace("(", "").replace(")", "")
    links = "".join(LINK.format(name) for name in "abc")
    return f"""<robot name="parallelogram"><link name="ground"/>{links}
<joint name="A" type="continuous"><parent link="ground"/><child link="a"/>
  <axis xyz="0 0 1"/></joint>
<joint name="B" type="continuous"><parent link="a"/><child link="b"/>
  <origin xyz="{tip}"/><axis xyz="0 0 1"/></joint>
<joint name="D" type="continuous"><parent link="ground"/><child link="c"/>
  <origin xyz="{base} 0 0"/><axis xyz="0 0 1"/></joint>
<loop name="C" type="continuous"><predecessor link="b"><origin xyz="{base} 0 0"/></predecessor>
  <successor link="c"><origin xyz="{tip}"/></successor><axis xyz="0 0 1"/></loop></robot>"""


@pytest.mark.parametrize(
    ("crank", "base", "lean"),
    [
        (1.0, 2.0, 0.0),
        (0.5, 2.0, 0.0),
        (0.6884100539236251, 1.8549032498426308, -0.38007837606199213),
        (0.9627273973468053, 1.2553406364634119, -0.7546186796478531),
        (0.3, 0.31, 0.6),
    ],
)
def test_no_way_leads_past_where_ways_meet(crank: float, base: float, lean: float) -> None:
    """Beyond it a parallelogram and an antiparallelogram go on, and neither is the right one."""
    mechanism = cd.load(parallelogram(crank, base, lean))
    low, high = -np.pi / 2.0 - lean, np.pi / 2.0 - lean
    found = cd.Scene(mechanism, drive="A").range()
    assert found == pytest.approx((low, high), abs=2e-5)
    scene = cd.Scene(mechanism, drive="A", loads={"D": -3.0})
    for _ in range(3):
        for beyond in (low - 0.4, high + 0.3, 6.4, -20.0):
            with pytest.raises(cd.SingularConfigurationError, match="the way on is not unique"):
                scene.sweep([0.0, beyond])
        near = np.array([low + 1e-3, 0.0, high - 1e-3])
        turn = scene.sweep(near)
        np.testing.assert_allclose(turn.motion.position("D"), near, atol=1e-11)
        # The rounding of the description itself is magnified by the distance squared.
        np.testing.assert_allclose(turn.drive_effort, 3.0, rtol=1e-8)


def test_loads_on_links_that_the_outputs_leave_out() -> None:
    mechanism = cd.load(two_lines(2))
    wrench = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    options = {"drive": "bearing_0", "loads": {"left_shaft_2": wrench, "right_2": -4.0}}
    positions = np.linspace(0.0, 3.0, 9)
    whole = cd.Scene(mechanism, **options).sweep(positions)
    part = cd.Scene(mechanism, **options, outputs=["right_2"]).sweep(positions)
    assert relative(part["right_2"].moment, whole["right_2"].moment) < 1e-12


def test_frames_and_compliances_of_joints_that_the_outputs_leave_out() -> None:
    mechanism = cd.load(two_lines(2))
    positions = np.linspace(0.0, 3.0, 9)
    options = {"drive": "bearing_0", "loads": {"right_2": -4.0}}
    whole = cd.Scene(mechanism, **options).sweep(positions)
    name = "right_pin_1_in"
    part = cd.Scene(
        mechanism, **options, outputs=[name], compliance={"left_1": np.ones(6) * 1e-6}
    ).sweep(positions)
    found, expected = (turn.wrench(name, "parent") for turn in (part, whole))
    sure = expected.unique[3:]
    assert np.any(sure)
    assert relative(found.moment[:, sure], expected.moment[:, sure]) < 1e-12
    with pytest.raises(cd.ModelError, match="the outputs of the scene leave out joint 'left_2'"):
        part.origin("left_2")


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
    text = joint.source.text.replace("</robot>", chain + "</robot>")
    with pytest.raises(cd.MobilityError, match=r"nothing decides the motion of: j0, j1"):
        universal(cd.load(text), 0.5)


def test_out_of_reach_of_several_drives_without_warnings() -> None:
    legs = [f"leg_{number}" for number in range(1, 7)]
    with pytest.raises(cd.AssemblyError):
        cd.Scene(cd.load("stewart_platform"), drive=legs).sweep([[1e155] * 6])


def test_known_periods_are_used_for_any_positions(joint: cd.Mechanism) -> None:
    scene = universal(joint, 0.7)
    scene.response()
    assembly: Assembly = scene.assembly
    known = assembly._branch.span
    scene.sweep([6.2, -6.2])
    assert assembly._branch.span == known
