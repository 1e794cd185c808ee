"""Springs, dampers, bushings, friction and actuators in sweeps, against statics and energy."""

from __future__ import annotations

import copy
import pickle
import threading
from collections.abc import Callable

import numpy as np
import pinocchio
import pytest
from testkit.ball_rods import as_balls
from testkit.drive_lines import two_lines
from testkit.element_work import generalised
from testkit.many_drives import cranks, on_arms
from testkit.scenes import relative

import cardan_dyn as cd
from cardan_dyn.core.elements.element_forces import ElementForces

pytestmark = pytest.mark.usefixtures("loaded_once")

PENDULUM = """<robot name="pendulum"><link name="wall"/><link name="rod"><inertial>
  <origin xyz="0 0 -0.5"/><mass value="2"/><inertia ixx="0.1" iyy="0.1" izz="0.01"/></inertial>
  </link><joint name="pin" type="continuous"><parent link="wall"/><child link="rod"/>
  <origin xyz="0.3 0 2"/><axis xyz="0 1 0"/></joint></robot>"""
K = np.diag([300.0, 400.0, 500.0, 6.0, 7.0, 8.0])
SPRING = cd.PointSpring("crank", (0.05, 0.02, 0), "rocker", (0.1, 0.1, 0), 500.0, 30.0, 0.2)
TORSION = cd.JointSpring("rocker_bearing", 5.0, 3.0, 0.2)
RUBBER = cd.Bushing("coupler", "base", (0.1, 0.0, 0.0), K, 0.05 * K)
RUBBING = cd.JointFriction("rocker_pin", 2.0, 0.5)
ALL = [SPRING, TORSION, RUBBER, RUBBING]
TURN = np.linspace(0.0, 2.0 * np.pi, 30)


def four_bar(*elements: object, **options: object) -> cd.Scene:
    return cd.Scene(cd.load("four_bar"), drive="crank_bearing", elements=list(elements), **options)


def test_a_pendulum_on_a_torsion_spring_and_a_rope() -> None:
    """Statics by hand: what holds a rod against its weight and two springs."""
    anchor, length, stiffness = np.array([1.1, 0.0, 1.7]), 0.3, 40.0
    elements = [
        cd.JointSpring("pin", 6.0, rest=0.4),
        cd.PointSpring("rod", (0.0, 0.0, -0.8), "wall", anchor, stiffness, length=length),
    ]
    scene = cd.Scene(cd.load(PENDULUM), drive="pin", gravity=(0.0, 0.0, -9.81), elements=elements)
    angle = np.linspace(-1.0, 8.0, 50)
    turn = scene.sweep(angle)
    tip = np.stack([0.3 - 0.8 * np.sin(angle), 0 * angle, 2.0 - 0.8 * np.cos(angle)], axis=1)
    distance = np.linalg.norm(anchor - tip, axis=1)
    pull = stiffness * (distance - length)
    force = pull[:, None] * (anchor - tip) / distance[:, None]
    lever = tip - [0.3, 0.0, 2.0]
    moment = lever[:, 2] * force[:, 0] - lever[:, 0] * force[:, 2]
    expected = 2.0 * 9.81 * 0.5 * np.sin(angle) + 6.0 * (angle - 0.4) - moment
    np.testing.assert_allclose(turn.drive_effort, expected, atol=1e-11)
    np.testing.assert_allclose(turn.element_force[1].tension, pull)
    support = turn.wrench("pin", "world").force
    np.testing.assert_allclose(support, [0.0, 0.0, 2.0 * 9.81] - force, atol=1e-11)
    # Like a load, the effort of the torsion spring is part of the wrench at its joint.
    np.testing.assert_allclose(turn["pin"].torsion, expected - 6.0 * (angle - 0.4), atol=1e-11)


def test_a_spring_between_two_links_of_a_four_bar_is_a_pair_of_wrenches() -> None:
    """The spring against loads on both links that are computed by hand from the motion."""
    loose = four_bar()
    turn = loose.sweep(TURN, speed=2.0)
    points = {
        link: turn.origin(joint) + turn.rotation(joint) @ place
        for link, joint, place in (
            ("crank", "crank_bearing", SPRING.point_a),
            ("rocker", "rocker_bearing", SPRING.point_b),
        )
    }
    step = 1e-5
    near = [loose.sweep(TURN + shift) for shift in (-step, step)]
    spans = [
        item.origin("rocker_bearing")
        + item.rotation("rocker_bearing") @ SPRING.point_b
        - item.origin("crank_bearing")
        - item.rotation("crank_bearing") @ SPRING.point_a
        for item in near
    ]
    lengths = [np.linalg.norm(span, axis=1) for span in spans]
    rate = 2.0 * (lengths[1] - lengths[0]) / (2.0 * step)
    span = points["rocker"] - points["crank"]
    distance = np.linalg.norm(span, axis=1)
    tension = 500.0 * (distance - 0.2) + 30.0 * rate
    force = span * (tension / distance)[:, None]
    loads = {
        link: cd.Wrench(
            sign * force,
            np.cross(points[link] - turn.origin(joint), sign * force),
            frame="world",
        )
        for link, joint, sign in (("crank", "crank_bearing", 1.0), ("rocker", "rocker_bearing", -1))
    }
    by_hand = loose.sweep(TURN, speed=2.0, loads=loads)
    sprung = four_bar(SPRING).sweep(TURN, speed=2.0)
    np.testing.assert_allclose(sprung.element_force[0].tension, tension, atol=1e-6)
    for name in sprung:
        # Differences of lengths give the rate to some 1e-10.
        assert relative(sprung[name].force, by_hand[name].force) < 1e-8
    assert relative(sprung.drive_effort, by_hand.drive_effort) < 1e-8
    assert relative(sprung.drive_effort, turn.drive_effort) > 0.1


@pytest.mark.parametrize("element", [SPRING, TORSION, RUBBER], ids=["points", "joint", "bushing"])
def test_quasi_static_effort_is_the_slope_of_the_elastic_energy(element: object) -> None:
    scene, step = four_bar(element), 1e-3
    slopes = [
        (scene.sweep(TURN + k * step).elastic_energy - scene.sweep(TURN - k * step).elastic_energy)
        / (2.0 * k * step)
        for k in (1, 2, 3)
    ]
    slope = 1.5 * slopes[0] - 0.6 * slopes[1] + 0.1 * slopes[2]
    effort = scene.sweep(TURN).drive_effort
    assert np.max(np.abs(effort)) > 0.1
    np.testing.assert_allclose(effort, slope, atol=1e-8 * np.max(np.abs(effort)))


def test_drive_power_is_stored_or_turned_into_heat() -> None:
    """At constant speed of a mechanism whose inertia is subtracted."""
    scene, speed, step = four_bar(*ALL), 3.0, 1e-3
    turn, idle = scene.sweep(TURN, speed=speed), four_bar().sweep(TURN, speed=speed)
    stored = [
        (scene.sweep(TURN + k * step).elastic_energy - scene.sweep(TURN - k * step).elastic_energy)
        / (2.0 * k * step)
        for k in (1, 2, 3)
    ]
    rate = speed * (1.5 * stored[0] - 0.6 * stored[1] + 0.1 * stored[2])
    heat = sum(force.dissipation for force in turn.element_force.values())
    power = speed * (turn.drive_effort - idle.drive_effort)
    assert np.min(heat) >= 0.0
    assert np.max(heat) > 1.0
    np.testing.assert_allclose(power, rate + heat, atol=1e-8 * np.max(np.abs(power)))
    assert turn.power_residual < 1e-13
    assert turn.balance_residual < 1e-13


def test_generalised_forces_agree_with_virtual_work_by_pinocchio() -> None:
    """Pinocchio's inverse dynamics of the tree, less elements, on the motion the loops allow."""
    scene = four_bar(*ALL)
    mechanism = scene.mechanism
    turn = scene.sweep(TURN, speed=3.0, acceleration=2.0)
    motion, model = turn.motion, mechanism.model
    forces = ElementForces(mechanism, ALL).at(motion.rows, motion.v)
    pushed = generalised(mechanism, motion.rows, forces)
    data = model.createData()
    model = model.copy()
    model.gravity.linear = np.zeros(3)
    ratios = np.stack([motion.ratio(name) for name in mechanism], axis=1)
    columns = [mechanism.coordinates.named[name].rate for name in mechanism]
    for sample, q in enumerate(motion.q):
        needed = pinocchio.rnea(model, data, q, motion.v[sample], motion.a[sample])
        work = (needed - pushed[sample])[columns] @ ratios[sample]
        assert turn.drive_effort[sample] == pytest.approx(work, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("outputs", [["rocker_bearing"], ["crank_bearing"], []])
def test_outputs_leave_out_nothing_that_elements_need(outputs: list[str]) -> None:
    whole = four_bar(*ALL).sweep(TURN, speed=3.0)
    part = four_bar(*ALL, outputs=outputs).sweep(TURN, speed=3.0)
    for name in outputs:
        assert relative(part[name].force, whole[name].force) < 1e-13
    if outputs != ["rocker_bearing"]:
        assert relative(part.drive_effort, whole.drive_effort) < 1e-13
    np.testing.assert_allclose(part.elastic_energy, whole.elastic_energy, rtol=1e-13)


def test_bodies_far_from_the_outputs_are_moved_for_elements() -> None:
    """A spring from one of two branches to the other, of which the outputs leave one out."""
    mechanism = cd.load(two_lines(2))
    spring = cd.PointSpring(
        "left_shaft_2", (0.1, 0.3, 0.0), "right_shaft_2", (0.2, -0.1, 0.1), 40.0, 2.0, 0.1
    )
    options = {"drive": "bearing_0", "loads": {"right_2": -4.0}}
    positions = np.linspace(0.0, 3.0, 9)
    whole = cd.Scene(mechanism, **options, elements=[spring]).sweep(positions, speed=2.0)
    without = cd.Scene(mechanism, **options).sweep(positions, speed=2.0)
    plain = cd.Scene(mechanism, **options, outputs=["right_2"])
    for scene in (
        cd.Scene(mechanism, **options, elements=[spring], outputs=["right_2"]),
        plain.replace(elements=[spring]),
    ):
        part = scene.sweep(positions, speed=2.0)
        # What the laws of motion leave open is chosen among the joints that are solved.
        assert np.all(part["right_2"].unique[3:])
        assert relative(part["right_2"].moment, whole["right_2"].moment) < 1e-12
        np.testing.assert_allclose(part.element_force[0].tension, whole.element_force[0].tension)
    assert relative(whole["right_2"].moment, without["right_2"].moment) > 0.1
    again = plain.replace(elements=[spring]).replace(elements=None).sweep(positions, speed=2.0)
    assert relative(again["right_2"].moment, without["right_2"].moment) < 1e-12


def test_angles_count_whole_turns() -> None:
    spring = cd.JointSpring("crank_bearing", 2.0)
    turn = four_bar(spring).sweep(np.array([0.5, 0.5 + 6.0 * np.pi]))
    np.testing.assert_allclose(turn.element_force[0].effort, [-1.0, -1.0 - 12.0 * np.pi])
    np.testing.assert_allclose(np.diff(turn.drive_effort), 12.0 * np.pi)
    joint = cd.load("universal_joint")
    scene = cd.Scene(
        joint,
        drive="bearing_in",
        held={"joint_angle": 0.5},
        elements=[cd.JointSpring("bearing_out", 3.0)],
    )
    out = scene.sweep([0.0, 4.0 * np.pi])
    np.testing.assert_allclose(np.diff(out["bearing_out"].torsion), -12.0 * np.pi)


def test_held_joints_feel_their_springs() -> None:
    joint = cd.load("universal_joint")
    scene = cd.Scene(
        joint,
        drive="bearing_in",
        held={"joint_angle": 0.5},
        loads={"bearing_out": -10.0},
        elements=[cd.JointSpring("joint_angle", 8.0, rest=0.1)],
    )
    angle = np.array([0.2, 0.5, 0.8])[:, None]
    sprung = scene.sweep(TURN, held={"joint_angle": angle})
    plain = scene.replace(elements=None).sweep(TURN, held={"joint_angle": angle})
    added = sprung.holding_effort["joint_angle"] - plain.holding_effort["joint_angle"]
    np.testing.assert_allclose(added, np.broadcast_to(8.0 * (angle - 0.1), (3, 30)), atol=1e-12)


def test_designs_and_grids_are_what_their_samples_are() -> None:
    joint = cd.load("double_shaft_z")
    links = joint.link_names
    elements = [
        cd.PointSpring(links[0], (0.0, 0.3, 0.0), "tube", (0.0, 0.1, 0.0), 50.0, 2.0, 0.1),
        cd.Actuator("bearing_in", np.sin),
        cd.JointFriction("bearing_out", 3.0),
    ]
    held = {"joint_angle_1": 0.2, "joint_angle_2": 0.2, "fork_phase": 0.0}
    scene = cd.Scene(joint, drive="bearing_in", held=held, elements=elements)
    phase, time = np.array([0.0, 0.4])[:, None], np.linspace(0.0, 1.0, 5)
    position = np.linspace(0.0, 4.0, 5)
    gravity = np.zeros((2, 1, 3))
    gravity[1, 0, 2] = -9.81
    grid = scene.sweep(position, 3.0, held={"fork_phase": phase}, time=time, gravity=gravity)
    for design in range(2):
        for sample in range(5):
            one = scene.replace(held={"fork_phase": float(phase[design, 0])}).sweep(
                position[sample], 3.0, time=time[sample], gravity=gravity[design, 0]
            )
            assert one.drive_effort[0] == pytest.approx(grid.drive_effort[design, sample], rel=1e-9)
            tension = one.element_force[0].tension[0]
            assert tension == pytest.approx(grid.element_force[0].tension[design, sample], rel=1e-9)
    np.testing.assert_allclose(grid.element_force[1].effort[1], np.sin(time))
    with pytest.raises(cd.ArgumentError, match=r"shapes do not broadcast: position \(5,\), time"):
        scene.sweep(position, time=[0.0, 1.0])
    with pytest.raises(cd.ArgumentError, match="time is not finite"):
        scene.sweep(position, time=np.nan)


def test_several_drives_and_paths() -> None:
    mechanism = on_arms(2)
    names = [name for name, (body, _) in mechanism.links.items() if body]
    scene = cd.Scene(
        mechanism,
        drive=cranks(mechanism),
        elements=[cd.PointSpring(names[0], (0.1, 0, 0), names[-1], (0, 0.1, 0), 30.0, 1.0, 0.05)],
    )
    ends = np.linspace(0.6, 1.4, len(scene.drives))
    position = np.linspace(0.2, 1.0, 20)[:, None] * ends
    line = scene.sweep(position, speed=2.0)
    path = scene.sweep(position, speed=2.0, along_path=True)
    assert relative(path.drive_effort, line.drive_effort) < 1e-11
    assert np.max(np.abs(line.drive_effort)) > 0.1
    again = scene.sweep(scene.assemble(position), speed=2.0)
    assert relative(again.drive_effort, line.drive_effort) < 1e-12


def test_copies_pickles_and_threads() -> None:
    scene = four_bar(*ALL)
    expected = scene.sweep(TURN, speed=3.0)
    for other in (copy.copy(scene), copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))):
        assert other.elements == scene.elements
        assert relative(other.sweep(TURN, speed=3.0).drive_effort, expected.drive_effort) < 1e-13
    found: list[np.ndarray] = []
    threads = [
        threading.Thread(target=lambda: found.append(scene.sweep(TURN, speed=3.0).drive_effort))
        for _ in range(3)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 3
    assert all(relative(item, expected.drive_effort) < 1e-13 for item in found)


def test_elements_are_replaced_as_a_whole() -> None:
    scene = four_bar(*ALL)
    assert scene.replace(gravity=(0.0, 0.0, -9.81)).elements == scene.elements
    assert scene.replace(elements=[SPRING]).elements == (SPRING,)
    assert scene.replace(elements=None).elements == ()
    assert scene.replace(elements=[SPRING]).solver.assembly is scene.solver.assembly
    assert "4 elements" in repr(scene)


def test_angles_of_balls_make_turns_of_them() -> None:
    text = (
        '<robot name="r"><link name="ground"/><link name="arm"/><joint name="ball" '
        'type="spherical"><parent link="ground"/><child link="arm"/></joint></robot>'
    )
    springs = [cd.JointSpring(f"ball.{axis}", 2.0) for axis in "xyz"]
    scene = cd.Scene(
        cd.load(text), drive=["ball.x", "ball.y"], held={"ball.z": 0.3}, elements=springs
    )
    turn = scene.sweep([[0.1, 0.2]])
    np.testing.assert_allclose(turn.drive_effort, [[0.2, 0.4]], atol=1e-13)
    assert turn.holding_effort["ball.z"][0] == pytest.approx(0.6)


def test_states_without_a_force_are_refused() -> None:
    coincident = cd.PointSpring("crank", (0.0, 0.0, 0.0), "base", (0.0, 0.0, 0.0), 5.0, length=0.1)
    with pytest.raises(cd.ArgumentError, match=r"elements\[1\] \(PointSpring\): its points coin"):
        four_bar(TORSION, coincident).sweep(TURN)
    tilted = np.eye(4)
    tilted[1:3, 1:3] = [[0.8, -0.6], [0.6, 0.8]]
    with pytest.raises(
        cd.ArgumentError, match=r"elements\[0\] \(Bushing\): it is wound by 3.12 rad"
    ):
        four_bar(cd.Bushing("base", "crank", tilted, K)).sweep([0.0, 3.12])


def test_a_damper_between_points_that_meet() -> None:
    """Its direction at the sample where they meet is that of their relative velocity."""
    text = PENDULUM.replace("continuous", "prismatic").replace("0.3 0 2", "0.1 0.7 0.3")
    damper = cd.PointSpring("wall", (0.1, 0.7 + 0.1, 0.3), "rod", (0.0, 0.0, 0.0), 9.0, 5.0)
    scene = cd.Scene(cd.load(text), drive="pin", elements=[damper])
    turn = scene.sweep([0.1 - 1e-3, 0.1, 0.1 + 1e-3], speed=2.0)
    np.testing.assert_allclose(turn.drive_effort, 10.0 + 9.0 * np.array([-1e-3, 0.0, 1e-3]))


@pytest.mark.slow
def test_elements_on_an_idle_rod_turn_it_as_loads_do() -> None:
    mechanism = cd.load(as_balls())
    elements = [
        cd.PointSpring("ground", (0.5, 0.5, 0.3), "rod", (0.2, 0.3, 0.1), 50.0, 3.0, 0.1),
        cd.Bushing("crank", "rod", (0.3, 0.0, 0.0), np.full(6, 5.0), np.ones(6)),
    ]
    scene = cd.Scene(mechanism, drive="a", gravity=(0.0, 0.0, -9.81))
    position = np.linspace(0.0, 1.0, 12)
    sprung = scene.replace(elements=elements).sweep(position, speed=2.0)
    assert sprung.idle_rods
    acted = ElementForces(mechanism, elements).at(sprung.motion.rows, sprung.motion.v)
    wrenches: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    for link, force, moment in acted.wrenches:
        others = wrenches.get(link, (np.zeros(3), np.zeros(3)))
        wrenches[link] = others[0] + force, others[1] + moment
    loads = {link: cd.Wrench(*pair, frame="world") for link, pair in wrenches.items()}
    loaded = scene.sweep(position, speed=2.0, loads=loads)
    for name in sprung:
        assert relative(sprung[name].force, loaded[name].force) < 1e-12
    assert relative(sprung.motion.a, loaded.motion.a) < 1e-12


def test_a_response_refuses_elements() -> None:
    scene = four_bar(SPRING)
    for build in (scene.response, lambda: scene.responses({}), lambda: scene.load_response("none")):
        with pytest.raises(cd.ArgumentError, match="a response takes no elements"):
            build()


def test_an_actuator_of_the_position_does_its_work() -> None:
    """A pump of shaft 2 takes ∫ (1 + cos 2x) dx, whatever the motion; the drive feels it."""

    def pump(turn: np.ndarray) -> np.ndarray:
        return -1.0 - np.cos(2.0 * turn)

    scene = cd.Scene(
        cd.load("universal_joint"),
        drive="bearing_in",
        held={"joint_angle": 0.6},
        elements=[cd.Actuator("bearing_out", pump, of="position", name="pump")],
    )
    turn = scene.sweep(np.linspace(0.0, 9.0, 50))
    x = turn.motion.position("bearing_out")
    ratio = turn.motion.ratio("bearing_out")
    np.testing.assert_allclose(turn.element_force["pump"].effort, pump(x))
    np.testing.assert_allclose(np.ravel(turn.drive_effort), -pump(x) * ratio, atol=1e-13)
    assert turn.balance_residual < 1e-13 and turn.power_residual < 1e-13
    run = scene.replace(free=scene.drives).simulate(1.5, speed=40.0)
    ends = run.at([0.0, 1.5])
    x = ends.motion.position("bearing_out")
    work = -np.diff(x + 0.5 * np.sin(2.0 * x))
    assert np.diff(ends.kinetic_energy) == pytest.approx(work, rel=1e-8)
    assert abs(work[0]) > 1.0 and run.energy_residual < 1e-8


ROTOR = (
    '<robot name="rotor"><link name="base"/><link name="arm"><inertial><mass value="2"/>'
    '<inertia ixx="1" iyy="1" izz="1.5" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    '<joint name="pin" type="continuous"><parent link="base"/><child link="arm"/>'
    '<axis xyz="0 0 1"/></joint></robot>'
)


@pytest.mark.slow
def test_a_bushing_at_a_hinge_counts_whole_turns() -> None:
    """Like a torsion spring: swept, simulated as a harmonic oscillation, and at rest."""
    scene = cd.Scene(
        cd.load(ROTOR), drive="pin", elements=[cd.Bushing("base", "arm", (0, 0, 0), K, name="e")]
    )
    positions = np.array([0.1, 3.2, -3.2, 2.0 * np.pi + 0.1, -7.0, 20.0 * np.pi])
    turn = scene.sweep(positions)
    np.testing.assert_allclose(turn.drive_effort, K[5, 5] * positions, rtol=1e-14)
    np.testing.assert_allclose(turn.elastic_energy, 0.5 * K[5, 5] * positions**2, rtol=1e-14)
    np.testing.assert_allclose(turn.element_force["e"].deformation[:, 5], positions, rtol=1e-14)
    run = scene.replace(free=scene.drives).simulate(3.0, position=20.0, speed=0.0)
    times = np.linspace(0.0, 3.0, 7)
    expected = 20.0 * np.cos(np.sqrt(K[5, 5] / 1.5) * times)
    np.testing.assert_allclose(run.at(times).position, expected, atol=1e-8)
    loaded = scene.replace(loads={"pin": 90.0})
    np.testing.assert_allclose(
        loaded.replace(free=loaded.drives).equilibrium(0.0).position, 90.0 / K[5, 5], rtol=1e-9
    )


def test_a_bushing_on_a_closed_chain_turns_by_the_angles_around_it() -> None:
    """The coupler turns by the sum of two angles that count ten turns each, by less than one."""
    positions = np.linspace(0.0, 20.0 * np.pi, 41)
    bushing = cd.Bushing("base", "crank", (0, 0, 0), [0, 0, 0, 0, 0, 3.0], name="crank")
    scene = cd.Scene(
        cd.load("slider_crank"),
        drive="crank_bearing",
        elements=[bushing, cd.Bushing("crank", "rod", (0, 0, 0), [0, 0, 0, 0, 0, 5.0], name="rod")],
    )
    turn = scene.sweep(positions)
    for name, joint in (("crank", "crank_bearing"), ("rod", "crank_pin")):
        wound = turn.element_force[name].deformation[:, 5]
        np.testing.assert_allclose(wound, turn.motion.position(joint), atol=1e-12)
    expected = 3.0 * positions + 5.0 * wound * turn.motion.ratio("crank_pin")
    np.testing.assert_allclose(turn.drive_effort, expected, rtol=1e-12, atol=1e-10)


def test_a_rotation_that_left_half_a_turn_about_changing_axes_is_refused() -> None:
    """Two turns and 0.1 rad about one axis look like 0.1 rad, and no sum of angles tells them."""
    text = ROTOR.replace(
        "</robot>",
        '<link name="hand"/><joint name="wrist" type="continuous"><parent link="arm"/>'
        '<child link="hand"/><axis xyz="1 0 0"/></joint></robot>',
    )
    scene = cd.Scene(
        cd.load(text), drive=["pin", "wrist"], elements=[cd.Bushing("base", "hand", (0, 0, 0), K)]
    )
    near = scene.sweep([[0.1, 0.0], [0.1, 0.2]])
    np.testing.assert_allclose(near.drive_effort[0], [0.1 * K[5, 5], 0.0], atol=1e-12)
    for position in ([3.2, 0.0], [2.0 * np.pi + 0.1, 0.2], [4.0 * np.pi + 0.1, 0.0]):
        with pytest.raises(cd.ArgumentError, match="on the way there by more than half a turn"):
            scene.sweep([position])


@pytest.mark.parametrize("joint", ["crank_bearing", "crank_pin", "rocker_bearing", "rocker_pin"])
@pytest.mark.parametrize(
    "law",
    [
        lambda joint: cd.JointSpring(joint, 2.0),
        lambda joint: cd.Actuator(joint, [(-10, 20), (0, 0), (10, -20)], of="position"),
        lambda joint: cd.Actuator(joint, lambda angle: -2.0 * angle, of="position"),
    ],
    ids=["spring", "table", "function"],
)
def test_a_force_that_is_mere_rounding_is_none(
    joint: str, law: Callable[[str], cd.JointSpring]
) -> None:
    """Nothing else acts on a linkage without weight, and the element is where it rests."""
    still = cd.Scene(cd.load("four_bar"), drive="crank_bearing", elements=[law(joint)]).sweep(0.0)
    assert abs(still.drive_effort[0]) < 1e-14


@pytest.mark.parametrize("kind", ["function", "table"])
@pytest.mark.parametrize("angle", [0.3, 0.7, 1.9, 3.0])
def test_a_thrust_that_is_mere_rounding_is_none(kind: str, angle: float) -> None:
    """The law passes zero where it is."""

    def still(thrust: object, of: str) -> cd.Sweep:
        law = cd.PointActuator("crank", (0.05, 0.02, 0), "rocker", (0.1, 0.1, 0), thrust, of=of)
        return cd.Scene(cd.load("four_bar"), drive="crank_bearing", elements=[law]).sweep(angle)

    rest = still(1.0, "time").element_force[0].length[0]
    table = [(0.0, 1e4 * rest), (rest, 0.0), (2.0 * rest, -1e4 * rest)]
    thrust = table if kind == "table" else lambda length: 1e4 * (rest - length)
    assert abs(still(thrust, "length").drive_effort[0]) < 1e-12
