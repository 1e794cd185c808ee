"""Rotors of drives: inertia along a joint's rates, against MuJoCo, Pinocchio and closed forms."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation
from testkit.linkages import RATES, four_bar, loop

import cardan_dyn as cd

pytestmark = pytest.mark.usefixtures("loaded_once")

MOMENTS = {"x": 0.02, "y": 0.05, "z": 0.04}
"""Principal moments of inertia of a pendulum [kg·m²]."""

Array = np.ndarray
TREE = """<mujoco><compiler angle="radian"/><option gravity="0.4 -0.3 -9.81"/><worldbody>
<body name="a" pos=".1 0 .2"><joint name="a" axis="0 .6 .8" armature=".3"/>
<inertial pos=".1 .2 0" mass="2" fullinertia=".3 .4 .5 .01 .02 .03"/>
<body name="b" pos=".3 .1 0"><joint name="b" type="slide" axis="1 0 0" armature="4"/>
<inertial pos="0 .1 .1" mass="1" diaginertia=".02 .03 .04"/>
<body name="c" pos="0 0 .4"><joint name="c" axis="0 1 0"/><joint name="d" axis="1 0 0"
 armature=".02"/><inertial pos=".1 0 .1" mass=".5" diaginertia=".01 .02 .02"/></body></body></body>
</worldbody><actuator><motor joint="c" armature=".001" gear="30"/>
<motor jointinparent="d" armature=".002" gear="-5"/><position joint="d" kp="3"/></actuator></mujoco>
"""
RODS = """<mujoco><compiler angle="radian"/><option gravity="0.5 0.2 -9.81"/><worldbody>
<body name="cross" pos="0 0 .3"><joint name="pitch" axis="0 1 0" armature=".003"/>
<inertial pos="0 0 0" mass=".05" diaginertia="1e-5 1e-5 1e-5"/>
<body name="foot"><joint name="roll" axis="1 0 0"/>
<inertial pos=".03 0 -.03" mass=".8" diaginertia=".002 .004 .004"/>
<site name="fl" pos="-.05 .04 .01"/><site name="fr" pos="-.05 -.04 .01"/></body></body>
<body name="ml" pos="0 .05 .52"><joint name="ml" axis="0 1 0" armature=".012"/>
<inertial pos="-.02 0 0" mass=".06" diaginertia="1e-5 2e-5 2e-5"/>
<body name="rl" pos="-.05 .01 0"><joint name="bl" type="ball" {ball}/>
<inertial pos="0 -.01 -.105" mass=".07" diaginertia="2e-4 2e-4 1e-5"/>
<site name="rl" pos="0 -.02 -.21"/></body></body>
<body name="mr" pos="0 -.05 .48"><joint name="mr" axis="0 1 0"/>
<inertial pos="-.02 0 0" mass=".06" diaginertia="1e-5 2e-5 2e-5"/>
<body name="rr" pos="-.05 -.01 0"><joint name="br" type="ball"/>
<inertial pos="0 .01 -.085" mass=".07" diaginertia="2e-4 2e-4 1e-5"/>
<site name="rr" pos="0 .02 -.17"/></body></body></worldbody>
<equality><connect site1="fl" site2="rl"/><connect site1="fr" site2="rr"/></equality>
<actuator><motor joint="mr" armature="2e-6" gear="60"/></actuator></mujoco>"""


def by_mujoco(text: str, turn: cd.Sweep, sample: int, told: dict[str, float]) -> Array:
    """Return efforts of drives, once the accelerations of all joints are as MuJoCo has them.

    Both follow from one linear system.

    Args:
        text: MJCF.
        turn: whose positions and velocities are taken.
        sample: index.
        told: drives and their accelerations.
    """
    model = mujoco.MjModel.from_xml_string(text)
    data, mechanism = mujoco.MjData(model), turn.mechanism
    coordinates, rates = mechanism.coordinates, []
    for index in range(model.njnt):
        name, at = model.joint(index).name, model.jnt_qposadr[index]
        own = turn.motion.x[sample][coordinates.columns[name]]
        if model.jnt_type[index] == int(mujoco.mjtJoint.mjJNT_BALL):
            own = own[[3, 0, 1, 2]]
        data.qpos[at : at + len(own)] = own
        rates += range(mechanism.model.nv)[coordinates.velocity_columns[name]]
    data.qvel[:] = turn.joint_velocities[sample][rates]
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    rows, drifts = [], []
    for index in range(model.neq):
        ends = np.zeros((2, 2, 2, 3, model.nv))
        for end, site in zip(ends, (model.eq_obj1id[index], model.eq_obj2id[index]), strict=True):
            mujoco.mj_jacSite(model, data, *end[0], site)
            body, point = model.site_bodyid[site], data.site_xpos[site]
            mujoco.mj_jacDot(model, data, *end[1], point, body)
        kept = 2 if model.eq_type[index] == int(mujoco.mjtEq.mjEQ_WELD) else 1
        between, change = (ends[0] - ends[1])[:, :kept].reshape(2, -1, model.nv)
        rows.append(between)
        drifts.append(change @ data.qvel)
    closing = np.concatenate([*rows, np.zeros((0, model.nv))])
    chosen = np.eye(model.nv)[[model.joint(name).dofadr[0] for name in told]]
    below = np.concatenate([closing, chosen])
    whole = np.block([[mass, -below.T], [below, np.zeros((len(below), len(below)))]])
    right = [-data.qfrc_bias, *[-drift for drift in drifts], np.array(list(told.values()))]
    found = np.linalg.lstsq(whole, np.concatenate(right), rcond=1e-13)[0]
    of_tree = turn.joint_accelerations[sample][rates]
    np.testing.assert_allclose(of_tree, found[: model.nv], rtol=1e-8, atol=1e-9)
    return found[len(found) - len(told) :]


def test_a_driven_tree_as_mujoco_has_it() -> None:
    """Armatures of joints, and of actuators by the square of their gears."""
    mechanism = cd.load(TREE)
    names = ["a", "b", "c", "d"]
    assert [joint.armature for joint in mechanism.description.joints] == [
        (0.3,), (4.0,), (0.001 * 30.0**2,), (0.02 + 0.002 * 5.0**2,),
    ]  # fmt: skip
    scene = cd.Scene(mechanism, drive=names, gravity=(0.4, -0.3, -9.81))
    a = [3.0, -2.0, 5.0, 4.0]
    turn = scene.sweep([[0.3, 0.1, -0.4, 0.7]], speed=[1.0, -0.5, 2.0, 3.0], acceleration=a)
    efforts = by_mujoco(TREE, turn, 0, dict(zip(names, a, strict=True)))
    np.testing.assert_allclose(turn.drive_effort[0], efforts, rtol=1e-12)
    assert max(turn.balance_residual, turn.power_residual) < 1e-14


@pytest.mark.parametrize("drives", [["ml", "mr"], ["pitch", "roll"]])
@pytest.mark.parametrize("ball", ["", 'armature="2e-4"'])
def test_loops_with_rods_that_spin(ball: str, drives: list[str]) -> None:
    """Rods between balls spin as forces have it; rotors about all axes resist that like inertia."""
    text, a = RODS.format(ball=ball), {drives[0]: 30.0, drives[1]: -20.0}
    scene = cd.Scene(cd.load(text), drive=drives, gravity=(0.5, 0.2, -9.81))
    turn = scene.sweep(
        [[0.1, -0.05], [-0.1, 0.05]], speed=[[1.0, 2.0], [-3.0, 1.0]], acceleration=list(a.values())
    )
    assert len(turn.idle_rods) == 2
    assert max(turn.balance_residual, turn.power_residual) < 1e-14
    needed = scene.mass_matrix(turn.position) @ list(a.values())
    needed += scene.bias(turn.position, turn.speed)
    for sample in range(2):
        efforts = by_mujoco(text, turn, sample, a)
        np.testing.assert_allclose(turn.drive_effort[sample], efforts, rtol=1e-9)
        np.testing.assert_allclose(needed[sample], efforts, rtol=1e-9)


def test_free_coordinates_accelerate_as_in_mujoco() -> None:
    text = RODS.format(ball="")
    scene = cd.Scene(cd.load(text), free=["pitch", "roll"], gravity=(0.5, 0.2, -9.81))
    run = scene.simulate(0.2, position=[0.1, 0.05], speed=[1.0, -2.0], rtol=1e-11)
    assert run.energy_residual < 1e-9
    # Sweeps know nothing of how fast rods spin.
    assert run.effort_residual < 1e-7
    by_mujoco(text, run.sweep, 0, {})


CRANK, ROD, MASS, SPINNING = 0.1, 0.3, 1.2, 0.02
SLIDER_CRANK = f"""<mujoco><option gravity="0 0 0"/><worldbody>
<body><joint name="main" axis="0 0 1" armature="{SPINNING}"/><geom size=".01" mass="1e-9"/>
<body pos="{CRANK} 0 0"><joint name="big_end" axis="0 0 1"/><geom size=".01" mass="1e-9"/>
<site name="s" pos="{ROD} 0 0"/></body></body><body pos="{CRANK + ROD} 0 0">
<inertial pos="0 0 0" mass="{MASS}" diaginertia="1e-3 1e-3 1e-3"/>
<joint name="bore" type="slide" axis="1 0 0" armature="{{}}"/><site name="p"/></body></worldbody>
<equality><connect site1="s" site2="p"/></equality></mujoco>"""


def test_slider_crank_by_hand() -> None:
    """m x'' x' + I φ'' with x = r cos φ + √(l² - r² sin² φ); a rotor on the slide is mass there."""
    sliding, w, b = 0.7, 3.0, 20.0
    angles = np.linspace(0.2, 6.0, 9)
    turn, light = (
        cd.Scene(cd.load(SLIDER_CRANK.format(armature)), drive="main").sweep(
            angles, speed=w, acceleration=b
        )
        for armature in (sliding, 0.0)
    )
    sine, cosine = np.sin(angles), np.cos(angles)
    root = np.sqrt(ROD**2 - (CRANK * sine) ** 2)
    slope = -CRANK * sine - CRANK**2 * sine * cosine / root
    bend = (
        -CRANK * cosine
        - CRANK**2 * (cosine**2 - sine**2) / root
        - CRANK**4 * (sine * cosine) ** 2 / root**3
    )
    acceleration = slope * b + bend * w**2
    for found, mass in ((turn, MASS + sliding), (light, MASS)):
        np.testing.assert_allclose(
            found.drive_effort, mass * acceleration * slope + SPINNING * b, rtol=1e-7
        )
    # The joint passes on what accelerates its rotor; the pin gives what both need.
    force = turn.wrench("bore", "world").force
    np.testing.assert_allclose(force[:, 0], -sliding * acceleration, rtol=1e-9)
    np.testing.assert_allclose(force[:, 1], -(MASS + sliding) / MASS * -light["bore"].force[:, 1])
    # Along its axis, the main bearing passes on what the crank needs, without the rotor.
    np.testing.assert_allclose(
        turn["main"].moment[:, 2], turn.drive_effort - SPINNING * b, rtol=1e-9
    )


def bar(dynamics: str = "", inertia: float = 0.4) -> str:
    return f"""<robot name="bar"><link name="ground"/><link name="bar"><inertial>
<origin xyz="0 0 -0.5"/><mass value="2"/><inertia ixx="0.5" iyy="{inertia}" izz="0.5" ixy="0"
ixz="0" iyz="0"/></inertial></link><joint name="pin" type="continuous"><parent link="ground"/>
<child link="bar"/><axis xyz="0 1 0"/>{dynamics}</joint></robot>"""


def test_a_rotor_on_the_ground_is_a_flywheel_on_the_link() -> None:
    """Equal but for the moment about the axis, which does not pass the joint."""
    rotor, wheel = cd.load(bar('<dynamics armature="0.3"/>')), cd.load(bar(inertia=0.7))
    angles, rates = np.linspace(0.0, 6.0, 7), {"speed": 4.0, "acceleration": 5.0}
    turns = [
        cd.Scene(item, drive="pin", gravity=(0, 0, -9.81)).sweep(angles, **rates)
        for item in (rotor, wheel)
    ]
    np.testing.assert_allclose(turns[0].drive_effort, turns[1].drive_effort, rtol=1e-13)
    np.testing.assert_allclose(turns[0]["pin"].force, turns[1]["pin"].force, atol=1e-13)
    apart = turns[1]["pin"].moment - turns[0]["pin"].moment
    np.testing.assert_allclose(apart, np.tile([0.0, 0.3 * 5.0, 0.0], (7, 1)), atol=1e-12)
    responses = [cd.Scene(item, drive="pin").response() for item in (rotor, wheel)]
    np.testing.assert_allclose(responses[0].inertia(angles), responses[1].inertia(angles))


@pytest.mark.parametrize("method", ["quadrature", "response", "DOP853", "Radau"])
def test_a_pendulum_swings_as_one_with_a_flywheel(method: str) -> None:
    runs = [
        cd.Scene(cd.load(text), free="pin", gravity=(0, 0, -9.81)).simulate(
            1.0, position=1.0, speed=8.0, method=method, rtol=1e-10
        )
        for text in (bar('<dynamics armature="0.3"/>'), bar(inertia=0.7))
    ]
    assert runs[0].method == method
    np.testing.assert_allclose(runs[0].position[-1], runs[1].position[-1], rtol=1e-8)
    np.testing.assert_allclose(runs[0].kinetic_energy, runs[1].kinetic_energy, rtol=1e-7)
    assert runs[0].energy_residual < 1e-8
    assert runs[0].effort_residual < 1e-8


def test_equilibria_stay_and_swing_more_slowly() -> None:
    still = cd.Scene(cd.load(bar('<dynamics armature="0.3"/>')), free="pin", gravity=(0, 0, -9.81))
    found = still.equilibrium(0.4)
    assert found.position[0] == pytest.approx(0.0, abs=1e-12)
    expected = np.sqrt(2.0 * 9.81 * 0.5 / (0.4 + 2.0 * 0.5**2 + 0.3))
    np.testing.assert_allclose(found.frequencies, expected, rtol=1e-8)


def test_hinges_that_meet_are_no_ball() -> None:
    """What resists along a turn by itself does not along the rotation of all three."""
    gimbal = """<mujoco><option gravity="0.5 0.2 -9.81"/><worldbody><body>
    <joint name="one" axis="1 0 0" armature=".2"/><joint name="two" axis="0 1 0"/>
    <joint name="three" axis="0 0 1" armature=".1"/>
    <inertial pos=".1 .2 .3" mass="1" diaginertia=".1 .2 .25"/></body></worldbody></mujoco>"""
    scene = cd.Scene(cd.load(gimbal), free=["one", "two", "three"], gravity=(0.5, 0.2, -9.81))
    run = scene.simulate(1.0, position=[0.3, 0.4, 0.5], speed=[1.0, 2.0, -3.0], rtol=1e-10)
    for time in (0, -1):
        by_mujoco(gimbal, run.sweep, time, {})
    assert run.energy_residual < 1e-8


def test_hinges_that_become_a_ball_hang_from_one_with_a_rotor() -> None:
    gimbal = """<mujoco><option gravity="0.5 0.2 -9.81"/><worldbody><body>
    <joint name="base" axis="0 .6 .8" armature=".4"/>
    <inertial pos=".1 .2 .3" mass="1" diaginertia=".1 .2 .25"/><body pos=".3 0 0">
    <joint name="one" axis="1 0 0"/><joint name="two" axis="0 1 0"/>
    <joint name="three" axis="0 0 1"/><inertial pos=".1 .2 .3" mass="1" diaginertia=".1 .2 .25"/>
    </body></body></worldbody></mujoco>"""
    names = ["base", "one", "two", "three"]
    scene = cd.Scene(cd.load(gimbal), free=names, gravity=(0.5, 0.2, -9.81))
    run = scene.simulate(0.5, position=[0.3] * 4, speed=[1.0, 2.0, 3.0, -1.0], rtol=1e-10)
    for time in (0, -1):
        by_mujoco(gimbal, run.sweep, time, {})
    assert run.energy_residual < 1e-8


def test_a_torsional_spring_before_a_rotor_without_a_link() -> None:
    line = cd.load("""<robot name="line"><link name="ground"/><link name="in"/><link name="out"/>
    <joint name="drive" type="continuous"><parent link="ground"/><child link="in"/></joint>
    <joint name="twist" type="continuous"><parent link="in"/><child link="out"/>
    <dynamics spring_stiffness="100" damping="0.1" armature="0.25"/></joint></robot>""")
    scene = cd.Scene(line, drive="drive", free=["twist"], elements=cd.described_elements(line))
    found = cd.vibration.campbell(scene, [10.0])
    np.testing.assert_allclose(found.decay, -0.5 * 0.1 / 0.25, rtol=1e-9)
    np.testing.assert_allclose(found.frequency, np.sqrt(100.0 / 0.25 - 0.2**2), rtol=1e-9)


def without(text: str) -> str:
    return re.sub(r' armature="[^"]*"', "", text)


FOUR_BAR = four_bar(loop("continuous").replace("</loop>", '<dynamics armature="0.5"/></loop>'))
FOUR_BAR = FOUR_BAR.replace(
    '<origin xyz="2 0 0"/><axis', '<origin xyz="2 0 0"/><dynamics armature="0.9"/><axis'
)


def test_a_rotor_on_the_joint_of_a_loop(tmp_path: Path) -> None:
    """As if what accelerates rotors were taken off by loads, and as virtual work has it."""
    scene, bare = (cd.Scene(cd.load(text), drive="a") for text in (FOUR_BAR, without(FOUR_BAR)))
    angles = np.linspace(0.0, 6.0, 9)
    turn = scene.sweep(angles, **RATES)
    named = scene.mechanism.coordinates
    rotors = {name: named.rates_of([name])[0] for name in ("c", "d")}
    taken = {
        name: inertia * turn.joint_accelerations[:, rotors[name]]
        for name, inertia in (("c", 0.5), ("d", 0.9))
    }
    loaded = bare.sweep(angles, loads={name: -effort for name, effort in taken.items()}, **RATES)
    np.testing.assert_allclose(turn.drive_effort, loaded.drive_effort, rtol=1e-13)
    for name in turn:
        np.testing.assert_allclose(turn[name].force, loaded[name].force, atol=1e-11)
    v = turn.joint_velocities / RATES["speed"]
    more = sum(taken[name] * v[:, rate] for name, rate in rotors.items())
    light = bare.sweep(angles, **RATES).drive_effort
    np.testing.assert_allclose(turn.drive_effort - light, more, rtol=1e-11)
    run = cd.Scene(scene.mechanism, free="a", gravity=(0, -9.81, 0)).simulate(
        0.5, position=0.3, speed=4.0, method="DOP853"
    )
    assert run.energy_residual < 1e-8
    path = cd.write(scene.mechanism, tmp_path / "four_bar.xml")
    again = cd.Scene(cd.load(path), drive="a").sweep(angles, **RATES)
    np.testing.assert_allclose(again.drive_effort, turn.drive_effort, rtol=1e-11)
    for sample in range(len(angles)):
        efforts = by_mujoco(path.read_text(), again, sample, {"a": RATES["acceleration"]})
        np.testing.assert_allclose(efforts, turn.drive_effort[sample], rtol=1e-8)


@pytest.mark.parametrize(
    ("kind", "stated"),
    [("cylindrical", "3 0.5"), ("universal", "0.2 0.3"), ("spherical", "0.4")],
)
def test_rotors_of_all_coordinates_of_a_loop(kind: str, stated: str) -> None:
    """As virtual work has it, from accelerations along all of them."""
    own = f'<dynamics armature="{stated}"/></loop>'
    text, angles = four_bar(loop(kind).replace("</loop>", own)), np.linspace(0.0, 6.0, 9)
    turn, light = (
        cd.Scene(cd.load(item), drive="a").sweep(angles, **RATES) for item in (text, without(text))
    )
    efforts = turn.mechanism.model.armature * turn.joint_accelerations
    more = np.sum(efforts * turn.joint_velocities, axis=1) / RATES["speed"]
    np.testing.assert_allclose(turn.drive_effort - light.drive_effort, more, atol=1e-12)
    assert np.max(np.abs(more)) > 0.1
    assert max(turn.balance_residual, turn.power_residual) < 1e-14


def test_a_fixed_joint_has_a_rotor_where_it_is_driven() -> None:
    arm = cd.load("""<robot name="arm"><link name="a"/><link name="b"/><link name="c"/>
    <joint name="hinge" type="continuous"><parent link="a"/><child link="b"/>
    <dynamics armature="0.1"/></joint><joint name="stay" type="fixed" adjustable="revolute">
    <parent link="b"/><child link="c"/><axis xyz="0 1 0"/><dynamics armature="0.7"/></joint>
    </robot>""")
    for options, positions, efforts in (
        ({"drive": "hinge"}, [0.1], [0.2]),
        ({"drive": "hinge", "held": {"stay": 0.2}}, [0.1], [0.2]),
        ({"drive": ["hinge", "stay"]}, [[0.1, 0.2]], [[0.2, 1.4]]),
    ):
        turn = cd.Scene(arm, **options).sweep(positions, acceleration=2.0)
        np.testing.assert_allclose(turn.drive_effort, efforts, rtol=1e-14)


def test_wheels_that_mesh() -> None:
    """I₁ + i² I₂, as of rotors that really turn."""
    wheels = """<robot name="wheels"><link name="ground"/><link name="one"/><link name="two"/>
<joint name="a" type="continuous"><parent link="ground"/><child link="one"/><axis xyz="0 0 1"/>
<dynamics armature="0.2"/></joint><joint name="b" type="continuous"><parent link="ground"/>
<child link="two"/><axis xyz="0 0 1"/><dynamics armature="0.03"/><mimic joint="a" multiplier="-4"/>
</joint></robot>"""
    turn = cd.Scene(cd.load(wheels), drive="a").sweep([0.0, 1.0], acceleration=5.0)
    np.testing.assert_allclose(turn.drive_effort, (0.2 + 16.0 * 0.03) * 5.0, rtol=1e-14)
    run = cd.Scene(cd.load(wheels), free="a", loads={"a": 0.68}).simulate(1.0)
    np.testing.assert_allclose(run.speed[-1], 1.0, rtol=1e-9)


def test_teeth_accelerate_the_rotor_of_a_wheel() -> None:
    """Pitch radii 0.04 m and 0.1 m: the force at the teeth is I₂ α₂ / r₂, and presses apart."""
    pair = """<robot name="pair"><link name="box"/><link name="pinion"/><link name="wheel"/>
<joint name="in" type="continuous"><parent link="box"/><child link="pinion"/><axis xyz="0 0 1"/>
<dynamics armature="0.02"/></joint><joint name="out" type="continuous"><parent link="box"/>
<child link="wheel"/><origin xyz="0.14 0 0"/><axis xyz="0 0 1"/><dynamics armature="0.3"/></joint>
<coupling name="teeth" forces="mesh" pressure_angle="0.4"><predecessor link="pinion"/>
<successor link="wheel"/><ratio value="-0.4"/></coupling></robot>"""
    turn = cd.Scene(cd.load(pair), drive="in").sweep([0.0, 1.0], acceleration=5.0)
    force = 0.3 * 0.4 * 5.0 / 0.1
    np.testing.assert_allclose(turn.drive_effort, (0.02 + 0.4**2 * 0.3) * 5.0, rtol=1e-13)
    on_wheel = [[force * np.tan(0.4), force, 0.0]] * 2
    for name, sign in (("out", -1.0), ("in", 1.0)):
        wrench = turn.wrench(name, "world")
        np.testing.assert_allclose(wrench.force, sign * np.array(on_wheel), atol=1e-12)
    np.testing.assert_allclose(turn["out"].torsion, 0.3 * 0.4 * 5.0, rtol=1e-12)
    np.testing.assert_allclose(turn["in"].torsion, 0.4**2 * 0.3 * 5.0, rtol=1e-12)


def test_slides_of_a_free_body_whose_angles_are_named() -> None:
    """Their rotors are masses that do not turn; its ball has none."""
    free = bar().replace('type="continuous"', 'type="floating"')
    heavy = free.replace("<axis", '<dynamics armature="3 3 3 0"/><axis')
    names = [f"pin.{name}" for name in ("x", "y", "z", "turn_x", "turn_y", "turn_z")]
    a = np.array([1.0, -2.0, 3.0, 4.0, 5.0, -6.0])
    turns = [
        cd.Scene(cd.load(text), drive=names).sweep(
            [[0.1, 0.2, 0.3, 0.4, 0.5, 0.6]], speed=2.0, acceleration=a
        )
        for text in (heavy, free)
    ]
    more = turns[0].drive_effort - turns[1].drive_effort
    np.testing.assert_allclose(more, [[3.0, -6.0, 9.0, 0.0, 0.0, 0.0]], atol=1e-13)


def test_held_joints_need_nothing_for_their_rotors() -> None:
    scenes = [
        cd.Scene(cd.load(text), drive=["a", "b", "c"], held={"d": 0.3}, gravity=(0.0, 0.0, 0.0))
        for text in (TREE, TREE.replace(' armature=".02"', ""))
    ]
    turns = [scene.sweep([[0.1, 0.2, 0.3]], speed=1.0, acceleration=2.0) for scene in scenes]
    np.testing.assert_array_equal(turns[0].holding_effort["d"], turns[1].holding_effort["d"])
    np.testing.assert_array_equal(turns[0].drive_effort, turns[1].drive_effort)


def test_a_model_of_pinocchio() -> None:
    """`model.armature` as `pin.rnea` counts it, and rotors by the square of their ratios."""
    model = pin.buildSampleModelManipulator()
    random = np.random.default_rng(3)
    own, rotors, ratios = random.uniform(0.1, 0.5, (3, model.nv))
    model.armature, model.rotorInertia, model.rotorGearRatio = own, rotors, 10.0 * ratios
    mechanism = cd.from_pinocchio(model)
    q, v, a = random.normal(size=(3, model.nv))
    turn = cd.Scene(
        mechanism, drive=[joint.name for joint in mechanism.description.joints],
        gravity=model.gravity.linear,
    ).sweep(q[None], speed=v, acceleration=a)  # fmt: skip
    model.armature = own + rotors * (10.0 * ratios) ** 2
    expected = pin.rnea(model, model.createData(), q, v, a)
    np.testing.assert_allclose(turn.drive_effort[0], expected, rtol=1e-11)


def test_the_armature_of_a_ball_is_an_inertia_where_its_parent_stands_still() -> None:
    """What is advised where a scene would name angles moves as MuJoCo's ball with an armature."""

    def pendulum(more: float, dynamics: str = "") -> cd.Mechanism:
        moments = "".join(f'i{2 * axis}="{value + more}" ' for axis, value in MOMENTS.items())
        return cd.load(
            '<robot name="p"><link name="ground"/><link name="bob"><inertial>'
            f'<origin xyz="0.1 0 -0.3"/><mass value="2"/><inertia {moments}/></inertial></link>'
            '<joint name="ball" type="spherical"><parent link="ground"/><child link="bob"/>'
            f"{dynamics}</joint></robot>"
        )

    start = dict(zip(("ball.x", "ball.y", "ball.z"), (0.3, 0.4, 0.2), strict=True))
    with pytest.raises(cd.ModelError, match=r"with 0\.3 kg·m² more in each of ixx, iyy and izz"):
        cd.Scene(pendulum(0.0, '<dynamics armature="0.3"/>'), free=["ball"])
    scene = cd.Scene(pendulum(0.3), free=["ball"], gravity=(0.0, 0.0, -9.81))
    found = scene.simulate(1.0, speed=start).motion.position("ball")[-1]
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><option timestep="2e-3" integrator="RK4"/><worldbody><body>'
        '<joint type="ball" armature="0.3"/><inertial pos="0.1 0 -0.3" mass="2" '
        f'diaginertia="{" ".join(map(str, MOMENTS.values()))}"/></body></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    data.qvel[:] = list(start.values())
    for _ in range(500):
        mujoco.mj_step(model, data)
    w, x, y, z = data.qpos
    expected = Rotation.from_quat([x, y, z, w]).as_euler("XYZ")
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-8)


def test_the_armature_of_a_ball_on_a_parent_that_moves_is_a_link_on_hinges_that_mimic_its_own() -> (
    None
):
    """What is advised there moves as MuJoCo's ball with an armature."""

    def link(name: str, mass: float, centre: str, moments: Iterable[float]) -> str:
        stated = " ".join(f'i{2 * axis}="{of}"' for axis, of in zip("xyz", moments, strict=True))
        return (
            f'<link name="{name}"><inertial><origin xyz="{centre}"/><mass value="{mass}"/>'
            f"<inertia {stated}/></inertial></link>"
        )

    def hinges(name: str, parent: str, place: str, mimic: str = "") -> str:
        text, before = "", parent
        for axis, xyz in (("x", "1 0 0"), ("y", "0 1 0"), ("z", "0 0 1")):
            child = name if axis == "z" else f"{name}_{axis}"
            text += f'<link name="{child}"/>' * (axis != "z")
            text += (
                f'<joint name="{name}.{axis}" type="continuous"><parent link="{before}"/>'
                f'<child link="{child}"/><origin xyz="{place}"/><axis xyz="{xyz}"/>'
                f"{mimic.format(axis)}</joint>"
            )
            before, place = child, "0 0 0"
        return text

    arm = (0.2, 0.3, 0.1)
    head = (
        f'<robot name="p"><link name="ground"/>{link("arm", 3.0, "0.2 0.1 0", arm)}'
        f'{link("bob", 2.0, "0.1 0 -0.3", MOMENTS.values())}<joint name="a" type="continuous">'
        '<parent link="ground"/><child link="arm"/><axis xyz="0 0.6 0.8"/></joint>'
    )
    ball = (
        '<joint name="bob" type="spherical"><parent link="arm"/><child link="bob"/>'
        '<origin xyz="0.4 0 0.1"/><dynamics armature="0.3"/></joint>'
    )
    with pytest.raises(cd.ModelError, match=r"whose ixx, iyy and izz are 0\.3 kg·m² each"):
        cd.Scene(cd.load(f"{head}{ball}</robot>"), free=["a", "bob"])
    mechanism = cd.load(
        f"{head}{hinges('bob', 'arm', '0.4 0 0.1')}{link('rotor', 1.0, '0 0 0', (0.3,) * 3)}"
        + hinges("rotor", "ground", "0 0 0", '<mimic joint="bob.{}" forces="none"/>')
        + "</robot>"
    )
    assert cd.describe(mechanism).mobility == 4
    start = {"a": 1.5, "bob.x": 0.3, "bob.y": 0.4, "bob.z": -0.9}
    scene = cd.Scene(mechanism, free=list(start), gravity=(0.0, 0.0, -9.81))
    motion = scene.simulate(1.0, speed=start).motion
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><option timestep="2e-3" integrator="RK4"/><worldbody><body>'
        '<joint axis="0 0.6 0.8"/><inertial pos="0.2 0.1 0" mass="3" diaginertia="0.2 0.3 0.1"/>'
        '<body pos="0.4 0 0.1"><joint type="ball" armature="0.3"/><inertial pos="0.1 0 -0.3" '
        f'mass="2" diaginertia="{" ".join(map(str, MOMENTS.values()))}"/></body></body>'
        "</worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    data.qvel[:] = list(start.values())
    for _ in range(500):
        mujoco.mj_step(model, data)
    w, x, y, z = data.qpos[1:]
    found = [motion.position(name)[-1] for name in start]
    expected = [data.qpos[0], *Rotation.from_quat([x, y, z, w]).as_euler("XYZ")]
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-7)
