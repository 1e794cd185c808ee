"""Every joint type by a mechanism whose answer is known in another way."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.linkages import LINK, POSITIONS, RATES, four_bar, loop, slider_crank
from testkit.scenes import relative, text, universal

import cardan_dyn as cd


def without_cross() -> str:
    """The universal joint with its massless cross left out: one loop of the type `universal`."""
    urdf = text("universal_joint")
    for start, end in (('<link name="cross">', "</link>"), ('<joint name="pin_in"', "</joint>")):
        at = urdf.index(start)
        urdf = urdf[:at] + urdf[urdf.index(end, at) + len(end) :]
    loop_start = urdf.index("<loop")
    return urdf[:loop_start] + (
        '<loop name="joint" type="universal"><predecessor link="shaft_in"/>'
        '<successor link="shaft_out"/><axis xyz="0 1 0"/><axis2 xyz="0 0 1"/></loop></robot>'
    )


def massless_cross() -> str:
    urdf = text("universal_joint")
    start = urdf.index("<inertial>", urdf.index('<link name="cross">'))
    end = urdf.index("</inertial>", start) + len("</inertial>")
    return urdf[:start] + urdf[end:]


@pytest.mark.parametrize("beta_deg", [0.0, 30.0, 80.0])
def test_universal(positions: np.ndarray, beta_deg: float) -> None:
    beta = np.deg2rad(beta_deg)
    found = universal(cd.load(without_cross()), beta, load=-50.0).sweep(positions, speed=20.0)
    reference = universal(cd.load(massless_cross()), beta, load=-50.0).sweep(positions, speed=20.0)
    assert relative(found.drive_effort, reference.drive_effort) < 1e-13
    for name in ("bearing_in", "bearing_out", "joint_angle"):
        moment = reference[name].moment
        scale = np.max(np.abs(reference["pin_out"].moment))
        assert np.max(np.abs(found[name].moment - moment)) < 1e-13 * scale
    pair = found["joint"]
    scale = np.max(np.abs(pair.moment))
    assert np.max(np.abs(pair.moment - reference["pin_out"].moment)) < 1e-13 * scale
    angles = found.motion.position("joint")
    assert angles.shape == (len(positions), 2)
    np.testing.assert_allclose(angles[:, 0], reference.motion.position("pin_in"), atol=1e-13)
    np.testing.assert_allclose(angles[:, 1], reference.motion.position("pin_out"), atol=1e-13)
    # Torsion of the pair: the moment normal to its second pin and to the axis of the fork.
    np.testing.assert_allclose(pair.torsion, pair.moment[:, 0], rtol=0.0, atol=1e-12 * scale)


def test_universal_needs_axes_at_right_angles() -> None:
    with pytest.raises(cd.ModelError, match="<axis> and <axis2> at right angles"):
        cd.load(without_cross().replace('axis2 xyz="0 0 1"', 'axis2 xyz="0 1 1"'))


def test_prismatic_and_cylindrical_guides() -> None:
    sweeps = {}
    for guide in (None, "prismatic", "cylindrical"):
        scene = cd.Scene(
            cd.load(slider_crank(guide)),
            drive="a",
            gravity=(0.0, -9.81, 0.0),
            loads={"slider": cd.Wrench(force=(-40.0, 0.0, 0.0), frame="world")},
        )
        sweeps[guide] = scene.sweep(POSITIONS, **RATES)
    reference = sweeps[None]
    angle = POSITIONS + 0.5 * np.pi
    reach = np.sqrt(1.0 - 0.09)
    slide = 0.3 * np.cos(angle) + np.sqrt(1.0 - (0.3 * np.sin(angle)) ** 2) - reach
    for guide, found in sweeps.items():
        assert relative(found.drive_effort, reference.drive_effort) < 1e-13
        position = found.motion.position("d")
        position = position[:, 0] if guide == "cylindrical" else position
        np.testing.assert_allclose(position, slide, atol=1e-14)
        for name in "abcd":
            force = reference.wrench(name, "world").force[:, :2]
            assert relative(found.wrench(name, "world").force[:, :2], force) < 1e-12
        # A guide carries no force along itself, a cylinder no moment about itself either.
        assert np.max(np.abs(found["d"].axial)) < 1e-12 * np.max(np.abs(found["d"].force))
        assert found["d"].unique[1]
    assert not sweeps["prismatic"]["d"].unique[3]
    assert sweeps["cylindrical"]["d"].unique[3]
    assert np.max(np.abs(sweeps["cylindrical"]["d"].torsion)) < 1e-12


def test_ball_and_cylinder_make_a_four_bar_determinate() -> None:
    """One hinge replaced by a ball, one by a cylinder: everything unique, in the plane the same."""
    urdf = four_bar(loop("spherical"))
    start, end = urdf.index('<joint name="d"'), urdf.index('<loop name="c"')
    # The rocker hangs on the coupler by a ball; its pivot on the ground is the loop.
    ring = urdf[:start].replace(
        'name="rocker"><inertial><origin xyz="0 1.25 0"',
        'name="rocker"><inertial><origin xyz="0 1.25 0"',
    )
    determinate = (
        ring
        + urdf[end:].replace("</robot>", "")
        + '<joint name="carrier" type="floating"><parent link="ground"/><child link="rocker"/>'
        '<origin xyz="2 0 0"/></joint>'
        '<loop name="d" type="cylindrical"><predecessor link="ground"><origin xyz="2 0 0"/>'
        '</predecessor><successor link="rocker"/><axis xyz="0 0 1"/></loop></robot>'
    )
    scene = cd.Scene(cd.load(determinate), drive="a", gravity=(0.0, -9.81, -2.0))
    turn = scene.sweep(POSITIONS, **RATES)
    planar = cd.Scene(
        cd.load(four_bar(loop("continuous"))), drive="a", gravity=(0.0, -9.81, 0.0)
    ).sweep(POSITIONS, **RATES)
    assert np.all([turn[name].unique for name in turn.mechanism.joint_names])
    assert np.max(np.abs(turn["carrier"].force)) < 1e-12
    assert np.max(np.abs(turn["carrier"].moment)) < 1e-12
    for name in "abcd":
        force = planar.wrench(name, "world").force[:, :2]
        assert relative(turn.wrench(name, "world").force[:, :2], force) < 1e-12


def test_planar_loop_is_a_table() -> None:
    """A two-link arm on a table, which it does not feel in the plane."""
    arm = f"""<robot name="arm"><link name="ground"/>
{LINK.format(name="upper", com="0.2 0 0", mass="1")}
{LINK.format(name="fore", com="0.3 0 0", mass="2")}
<joint name="a" type="continuous"><parent link="ground"/><child link="upper"/>
  <axis xyz="0 0 1"/></joint>
<joint name="b" type="continuous"><parent link="upper"/><child link="fore"/>
  <origin xyz="0.5 0 0"/><axis xyz="0 0 1"/></joint>{{loop}}</robot>"""
    table = (
        '<loop name="table" type="planar"><predecessor link="ground"><origin xyz="1 0 0"/>'
        '</predecessor><successor link="fore"><origin xyz="0.5 0 0"/></successor>'
        '<axis xyz="0 0 1"/></loop>'
    )
    positions = np.array([[0.3, 0.8], [0.4, 1.2], [0.6, 1.3]])
    rates = {"speed": np.array([[1.0, -2.0]]), "acceleration": np.array([[3.0, 1.0]])}
    options = {"drive": ["a", "b"], "gravity": (0.0, 0.0, -9.81)}
    free = cd.Scene(cd.load(arm.format(loop="")), **options).sweep(positions, **rates)
    lying = cd.Scene(cd.load(arm.format(loop=table)), **options).sweep(positions, **rates)
    np.testing.assert_allclose(lying.drive_effort, free.drive_effort, rtol=1e-12)
    wrench = lying["table"]
    assert np.max(np.abs(wrench.shear)) < 1e-12
    assert np.max(np.abs(wrench.torsion)) < 1e-12
    np.testing.assert_array_equal(wrench.unique, [True, True, False, False, False, True])
    slides = lying.motion.position("table")[:, :2]
    tip = lying.origin("table")[:, :2] - [1.0, 0.0]
    np.testing.assert_allclose(np.linalg.norm(slides, axis=1), np.linalg.norm(tip, axis=1))


def test_floating_base_is_carried_by_what_holds_it() -> None:
    """A free body with an arm on it, held by a `fixed` loop: the loop carries the weight."""
    urdf = f"""<robot name="carried"><link name="ground"/>
{LINK.format(name="body", com="0.1 0 0", mass="5")}
{LINK.format(name="arm", com="0.4 0 0", mass="2")}
<joint name="base" type="floating"><parent link="ground"/><child link="body"/>
  <origin xyz="0 0 1" rpy="0.2 0.1 -0.3"/></joint>
<joint name="a" type="continuous"><parent link="body"/><child link="arm"/>
  <axis xyz="0 1 0"/></joint>
<loop name="hold" type="fixed"><predecessor link="ground"><origin xyz="0 0 1.05"/></predecessor>
  <successor link="body"/></loop></robot>"""
    turn = cd.Scene(cd.load(urdf), drive="a", gravity=(0.0, 0.0, -10.0)).sweep([0.0, 0.5, 1.0])
    assert np.all(turn["hold"].unique)
    np.testing.assert_allclose(
        turn.wrench("hold", "world").force, [[0.0, 0.0, 70.0]] * 3, atol=1e-11
    )
    assert np.max(np.abs(turn["base"].force)) < 1e-11
    moved = turn.motion.position("base")
    assert moved.shape == (3, 7)
    # The loop is half a decimetre off the description's zero and turned: the base gives way.
    np.testing.assert_allclose(turn.origin("hold"), [[0.0, 0.0, 1.05]] * 3, atol=1e-13)
    np.testing.assert_allclose(turn.rotation("base"), [np.eye(3)] * 3, atol=1e-13)


ROD = (
    '<robot name="rod"><link name="base"/><link name="rod"><inertial><origin xyz="0 0 -1"/>'
    '<mass value="9.5"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    '</link><joint name="ball" type="spherical"><parent link="base"/><child link="rod"/></joint>'
    "</robot>"
)


def test_a_ball_has_no_axis_along_which_it_is_loaded() -> None:
    scene = cd.Scene(cd.load(ROD), drive=["ball.x", "ball.y", "ball.z"], gravity=(0.0, 0.0, -10.0))
    turn = scene.sweep([[0.0, 0.0, 0.0]])
    ball = turn["ball"]
    np.testing.assert_allclose(ball.force, [[0.0, 0.0, 95.0]])
    for name in ("axis", "axial", "torsion", "shear", "bending", "shear_vector", "bending_vector"):
        with pytest.raises(cd.ModelError, match=r"'ball' has no axis.*use \.force and \.moment"):
            getattr(ball, name)
    table = turn.to_dataframe()
    assert np.isnan(table["ball.axial"][0]) and np.isnan(table["ball.torsion"][0])
    assert table["ball.force_z"][0] == pytest.approx(95.0)
    assert "no axis" in turn._repr_html_()
