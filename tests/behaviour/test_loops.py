"""Loops of every type, wherever they are cut, and what stays indeterminate."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from testkit.linkages import LINK, POSITIONS, RATES, four_bar, loop
from testkit.scenes import forward_accelerations, relative, text, universal

import cardan_dyn as cd


def scene_of(urdf: str, **options: object) -> cd.Scene:
    return cd.Scene(cd.load(urdf), drive="a", loads={"d": -3.0}, **options)


def planar_reference(urdf: str, turn: cd.Sweep, gravity: float) -> dict[str, np.ndarray]:
    """In-plane joint forces from the free-body diagrams of the three links.

    Positions come from circle geometry, accelerations from the closure equations of the plane;
    nine equations of Newton and Euler for a_x … c_y, d_y and the drive torque.
    """
    rocker = 2.5
    phi, omega, alpha = POSITIONS, RATES["speed"], RATES["acceleration"]
    angle_1 = phi + 0.5 * np.pi
    tip = 0.5 * np.stack([np.cos(angle_1), np.sin(angle_1)])
    pivot = np.array([[2.0], [0.0]])
    reach = pivot - tip
    distance = np.hypot(*reach)
    coupler = np.hypot(2.0, 2.0)
    along = (coupler**2 + distance**2 - rocker**2) / (2.0 * distance)
    height = np.sqrt(coupler**2 - along**2)
    unit = reach / distance
    # The branch of the description: the joint lies to the left of the line tip - pivot.
    end = tip + along * unit + height * np.stack([-unit[1], unit[0]])
    angle_2 = np.arctan2(end[1] - tip[1], end[0] - tip[0])
    angle_3 = np.arctan2(end[1], end[0] - 2.0)
    lengths = (0.5, coupler, rocker)
    result = {name: np.zeros((len(phi), 2)) for name in "abcd"}
    result["torque"] = np.zeros(len(phi))
    masses, inertias = (1.0, 2.0, 3.0), (0.025, 0.025, 0.025)
    offsets = (0.0, np.deg2rad(45.0), 0.0)
    for k in range(len(phi)):
        e = [np.array([np.cos(t[k]), np.sin(t[k])]) for t in (angle_1, angle_2, angle_3)]
        n = [np.array([-x[1], x[0]]) for x in e]
        matrix = np.stack([lengths[1] * n[1], -lengths[2] * n[2]], axis=1)
        rates = np.linalg.solve(matrix, -lengths[0] * n[0] * omega)
        right = -lengths[0] * (n[0] * alpha - e[0] * omega**2)
        right += lengths[1] * e[1] * rates[0] ** 2 - lengths[2] * e[2] * rates[1] ** 2
        second = np.linalg.solve(matrix, right)
        w, q = (omega, *rates), (alpha, *second)

        def accelerated(vector: np.ndarray, body: int, w=w, q=q) -> np.ndarray:
            return q[body] * np.array([-vector[1], vector[0]]) - w[body] ** 2 * vector

        # Centres of mass in world axes, from each link's inner pivot.
        turn_2 = angle_2[k] - offsets[1]
        rotation = np.array([[np.cos(turn_2), -np.sin(turn_2)], [np.sin(turn_2), np.cos(turn_2)]])
        centres = (0.25 * e[0], rotation @ np.array([1.0, 1.0]), 1.25 * e[2])
        accelerations = (
            accelerated(centres[0], 0),
            accelerated(0.5 * e[0], 0) + accelerated(centres[1], 1),
            accelerated(centres[2], 2),
        )
        # Unknowns: a on crank, b on coupler, c on rocker, d on rocker, drive torque.
        system, known = np.zeros((9, 9)), np.zeros(9)
        arms = {  # body: joint number, sign, arm from its centre of mass
            0: ((0, 1.0, -centres[0]), (1, -1.0, 0.5 * e[0] - centres[0])),
            1: ((1, 1.0, -centres[1]), (2, -1.0, lengths[1] * e[1] - centres[1])),
            2: ((2, 1.0, lengths[2] * e[2] - centres[2]), (3, 1.0, -centres[2])),
        }
        for body, forces in arms.items():
            for number, sign, arm in forces:
                system[3 * body : 3 * body + 2, 2 * number : 2 * number + 2] = sign * np.eye(2)
                system[3 * body + 2, 2 * number : 2 * number + 2] = sign * np.array(
                    [-arm[1], arm[0]]
                )
            known[3 * body : 3 * body + 2] = masses[body] * accelerations[body]
            known[3 * body + 1] += masses[body] * gravity
            known[3 * body + 2] = inertias[body] * q[body]
        system[2, 8] = 1.0
        known[8] -= -3.0
        solution = np.linalg.solve(system, known)
        for number, name in enumerate("abcd"):
            result[name][k] = solution[2 * number : 2 * number + 2]
        result["torque"][k] = solution[8]
    return result


@pytest.mark.parametrize("kind", ["revolute", "continuous", "spherical"])
def test_planar_four_bar_against_free_body_diagrams(kind: str) -> None:
    urdf = four_bar(loop(kind))
    turn = scene_of(urdf, gravity=(0.0, -9.81, 0.0)).sweep(POSITIONS, **RATES)
    expected = planar_reference(urdf, turn, 9.81)
    scale = max(np.max(np.abs(expected[name])) for name in "abcd")
    for name in "abcd":
        found = turn.wrench(name, "world").force[:, :2]
        assert np.max(np.abs(found - expected[name])) < 1e-12 * scale, name
    assert relative(turn.drive_effort, expected["torque"]) < 1e-12


def test_what_is_unique_in_a_planar_four_bar() -> None:
    planar = scene_of(four_bar(loop("continuous"))).sweep(POSITIONS, **RATES)
    ball = scene_of(four_bar(loop("spherical"))).sweep(POSITIONS, **RATES)
    in_plane, across = [0, 1, 5], [2, 3, 4]
    for name in "abcd":
        assert np.all(planar[name].unique[in_plane])
        assert not np.any(planar[name].unique[across])
    # The ball takes no moment, but the force across the plane can still go either way round.
    np.testing.assert_array_equal(ball["c"].unique[3:], [True] * 3)
    across_plane = ball.rotation("c")[:, 2] @ np.where(ball["c"].unique[:3], 0.0, 1.0)
    assert np.all(across_plane > 0.0)
    for name in "abcd":
        difference = ball[name].force[:, :2] - planar[name].force[:, :2]
        if name != "c":
            assert np.max(np.abs(difference)) < 1e-12 * np.max(np.abs(planar[name].force))


def test_swapping_predecessor_and_successor_flips_that_wrench_only() -> None:
    urdf = four_bar(loop("continuous"))
    swapped = four_bar(loop("continuous", "rocker", "coupler"))
    turn = scene_of(urdf, gravity=(0.0, 0.0, -9.81)).sweep(POSITIONS, **RATES)
    other = scene_of(swapped, gravity=(0.0, 0.0, -9.81)).sweep(POSITIONS, **RATES)
    for name, sign in (("a", 1.0), ("b", 1.0), ("c", -1.0), ("d", 1.0)):
        found, reference = other.wrench(name, "world"), turn.wrench(name, "world")
        assert relative(sign * found.force, reference.force) < 1e-12
        assert relative(sign * found.moment, reference.moment) < 1e-12
    np.testing.assert_allclose(
        other.motion.position("c"), -turn.motion.position("c"), rtol=0.0, atol=1e-13
    )


def test_least_norm_does_not_depend_on_the_cut() -> None:
    """The same ring cut at the rocker's pivot, the world being the loop's successor or not."""
    urdf = four_bar(loop("continuous"))
    turn = scene_of(urdf, gravity=(0.0, -9.81, -3.0)).sweep(POSITIONS, **RATES)
    ring = urdf.replace(
        urdf[urdf.index('<joint name="d"') : urdf.index('<loop name="c"')],
        '<joint name="c" type="continuous"><parent link="coupler"/><child link="rocker"/>'
        '<origin xyz="2 2 0" rpy="0 0 0"/><axis xyz="0 0 1"/></joint>',
    )
    ring = ring[: ring.index('<loop name="c"')]
    # The rocker hangs on the coupler now, its frame at the coupler's end.
    ring = ring.replace(
        'name="rocker"><inertial><origin xyz="0 1.25 0"',
        'name="rocker"><inertial><origin xyz="0 -1.25 0"',
    )
    ends = (
        '<{side} link="ground"><origin xyz="2 0 0"/></{side}>',
        '<{side} link="rocker"><origin xyz="0 -2.5 0"/></{side}>',
    )
    for first, second, sign in ((0, 1, 1.0), (1, 0, -1.0)):
        cut = (
            ring
            + '<loop name="d" type="continuous">'
            + ends[first].format(side="predecessor")
            + ends[second].format(side="successor")
            + '<axis xyz="0 0 1"/></loop></robot>'
        )
        load = -3.0 * sign
        scene = cd.Scene(cd.load(cut), drive="a", loads={"d": load}, gravity=(0.0, -9.81, -3.0))
        other = scene.sweep(POSITIONS, **RATES)
        assert other.balance_residual < 1e-13
        for name in "abcd":
            flip = sign if name == "d" else 1.0
            found, reference = other.wrench(name, "world"), turn.wrench(name, "world")
            scale = np.max(np.abs(reference.force))
            assert np.max(np.abs(flip * found.force - reference.force)) < 1e-12 * scale, name
            assert np.max(np.abs(flip * found.moment - reference.moment)) < 1e-12 * scale, name
            np.testing.assert_array_equal(found.unique, reference.unique)


def test_fixed_loop_is_the_wrench_of_a_cut_through_a_link() -> None:
    """Cutting the coupler in two and welding it again shows the wrench in the cut."""
    urdf = four_bar(loop("continuous"))
    turn = scene_of(urdf, gravity=(0.0, -9.81, 0.0)).sweep(POSITIONS, **RATES)
    start = urdf.index('<joint name="d"')
    cut = (
        urdf[:start]
        + urdf[start : urdf.index('<loop name="c"')]
        + '<link name="stub"/>'
        + '<joint name="c" type="continuous"><parent link="rocker"/><child link="stub"/>'
        + '<origin xyz="0 2.5 0"/><axis xyz="0 0 -1"/></joint>'
        + '<loop name="cut" type="fixed"><predecessor link="coupler"><origin xyz="2 2 0"/>'
        + '</predecessor><successor link="stub"><origin xyz="0 0 0"/></successor></loop></robot>'
    )
    scene = scene_of(cut, gravity=(0.0, -9.81, 0.0))
    other = scene.sweep(POSITIONS, **RATES)
    found, reference = other.wrench("cut", "world"), turn.wrench("c", "world")
    assert relative(found.force[:, :2], reference.force[:, :2]) < 1e-12
    assert np.max(np.abs(found.moment[:, 2])) < 1e-12 * np.max(np.abs(found.force))
    np.testing.assert_array_equal(found.unique, [True, True, False, False, False, True])
    np.testing.assert_allclose(other.origin("cut"), turn.origin("c"), atol=1e-13)


def rssr() -> str:
    """A spatial crank-rocker: cranks about skew axes, a coupler with balls at both ends.

    The coupler's spin about its own line is a freedom of its own, which the scene holds... here by
    making one ball a universal joint: two hinges at right angles.
    """
    return f"""<robot name="rssr"><link name="ground"/>
{LINK.format(name="crank", com="0 0.1 0", mass="1")}
<link name="yoke"/>
{LINK.format(name="coupler", com="0.5 0.2 0.3", mass="2")}
{LINK.format(name="rocker", com="0 0 0.4", mass="3")}
<joint name="a" type="continuous"><parent link="ground"/><child link="crank"/>
  <origin xyz="0 0 0"/><axis xyz="0 0 1"/></joint>
<joint name="b1" type="continuous"><parent link="crank"/><child link="yoke"/>
  <origin xyz="0 0.25 0"/><axis xyz="0 0 1"/></joint>
<joint name="b2" type="continuous"><parent link="yoke"/><child link="coupler"/>
  <origin xyz="0 0 0"/><axis xyz="0 1 0"/></joint>
<joint name="d" type="continuous"><parent link="ground"/><child link="rocker"/>
  <origin xyz="1 0.25 0"/><axis xyz="0.1 1 0.2"/></joint>
<loop name="c" type="spherical"><predecessor link="coupler"><origin xyz="1 0 0.8"/></predecessor>
  <successor link="rocker"><origin xyz="0 0 0.8"/></successor></loop></robot>"""


def test_spherical_loop_in_space() -> None:
    """Statically determinate: Pinocchio's forward dynamics gives every wrench."""
    mechanism = cd.load(rssr())
    scene = cd.Scene(mechanism, drive="a", loads={"d": -3.0}, gravity=(1.0, 2.0, -9.0))
    turn = scene.sweep(POSITIONS, speed=8.0, acceleration=5.0)
    assert np.all([turn[name].unique for name in mechanism.joint_names])
    assert turn.balance_residual < 1e-13
    assert np.max(np.abs(turn["c"].moment)) < 1e-12 * np.max(np.abs(turn["c"].force))
    quaternion = turn.motion.position("c")
    np.testing.assert_allclose(np.linalg.norm(quaternion, axis=1), 1.0, rtol=1e-14)
    scale = max(np.max(np.abs(turn[name].force)) for name in mechanism.joint_names)
    model = mechanism.model.copy()
    mechanism.model.gravity.linear = np.array([1.0, 2.0, -9.0])
    for sample in range(0, len(turn), 5):
        efforts = {"d": -3.0, "a": float(turn.drive_effort[sample])}
        a, data, _ = forward_accelerations(mechanism, turn, sample, efforts)
        np.testing.assert_allclose(a, turn.motion.a[sample], atol=1e-9 * np.max(np.abs(a)))
        for name in mechanism.joint_names:
            found = data.f[mechanism.joints[name].id].vector
            ours = np.concatenate([turn[name].force[sample], turn[name].moment[sample]])
            assert np.max(np.abs(found - ours)) < 1e-9 * scale, name
    assert model.nv == mechanism.model.nv


def test_joints_of_a_subtree_follow_each_other(shaft: cd.Mechanism) -> None:
    """Pinocchio's inertia matrix is silently wrong otherwise."""
    model = shaft.model
    q, v = pin.randomConfiguration(model), np.zeros(model.nv)
    data = model.createData()
    weight = pin.rnea(model, data, q, v, v).copy()
    columns = [pin.rnea(model, data, q, v, column) - weight for column in np.eye(model.nv)]
    inertia = np.triu(pin.crba(model, data, q))
    inertia = inertia + np.triu(inertia, 1).T
    np.testing.assert_allclose(inertia, np.array(columns), atol=1e-9)
    assert np.min(np.linalg.eigvalsh(inertia)) > 0.0


def test_every_joint_has_a_wrench_where_pinocchio_says_it_is(joint: cd.Mechanism) -> None:
    turn = universal(joint, 0.4).sweep(np.linspace(0.0, 6.0, 9))
    data = joint.model.createData()
    for sample, q in enumerate(turn.motion.q):
        pin.forwardKinematics(joint.model, data, q)
        for name, record in joint.joints.items():
            frame = data.oMi[record.id]
            np.testing.assert_allclose(turn.rotation(name)[sample], frame.rotation, atol=1e-14)
            np.testing.assert_allclose(turn.origin(name)[sample], frame.translation, atol=1e-14)


def test_gravity_of_helper_bodies_never_shows() -> None:
    """A loop to the world hangs on a helper body, which must not weigh anything."""
    urdf = text("universal_joint")
    massless = four_bar(loop("continuous"))
    assert urdf and massless
    start = massless.index('<joint name="d"')
    ring = (
        massless[:start]
        + '<joint name="c" type="continuous"><parent link="coupler"/><child link="rocker"/>'
        + '<origin xyz="2 2 0"/><axis xyz="0 0 1"/></joint>'
        + '<loop name="d" type="continuous"><predecessor link="rocker">'
        + '<origin xyz="0 -2.5 0"/></predecessor><successor link="ground"><origin xyz="2 0 0"/>'
        + '</successor><axis xyz="0 0 1"/></loop></robot>'
    )
    mechanism = cd.load(ring)
    assert len(mechanism.auxiliary_bodies) == 1
    turn = cd.Scene(mechanism, drive="a", gravity=(0.0, -10.0, 0.0)).sweep([0.0, 0.5])
    carried = turn.wrench("a", "world").force[:, 1] - turn.wrench("d", "world").force[:, 1]
    np.testing.assert_allclose(carried, 10.0 * 6.0, rtol=1e-13)
