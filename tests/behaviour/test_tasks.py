"""Motion given where it is wanted: against closed forms, virtual work, and sweeps of the drives."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from testkit import task_machines as machines
from testkit import transmissions

import cardan_dyn as cd
from cardan_dyn import studies
from cardan_dyn.kit.arrays import Array
from cardan_dyn.practice.studies.fingerprint import differences, fingerprint
from cardan_dyn.scene.tasks import missed

pytestmark = pytest.mark.usefixtures("loaded_once")

STEP = 1e-30
"""Of complex differences, which lose nothing."""
TIMES = np.array([0.0, 0.25, 0.625, 0.875])


def circle(times: Array) -> tuple[Array, Array, Array]:
    """Position, velocity and acceleration of the five-bar's tip."""
    turn = 2.0 * np.pi * times
    way = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    across = np.stack([-np.sin(turn), np.cos(turn)], axis=-1)
    rate = 2.0 * np.pi
    return [0.0, 0.28] + 0.05 * way, 0.05 * rate * across, -0.05 * rate**2 * way


def five_bar(*masses: float, **given: object) -> cd.Scene:
    mechanism = cd.load(machines.five_bar(*masses))
    arguments = {
        "task": cd.PointTask("load", axes="xy"),
        "actuated": ["m1", "m2"],
        "near": machines.five_bar_start(),
        "gravity": (0.0, -9.81, 0.0),
    }
    return cd.Scene(mechanism, **{**arguments, **given})


PULL = {"load": cd.Wrench(force=(3.0, -4.0, 0.0), frame="world")}


def test_five_bar_against_its_free_bodies() -> None:
    sweep = five_bar(loads=PULL).sweep(*circle(TIMES))
    expected = {  # At 0.625 s and so on: 12 free-body equations, equal to Lagrange's to 1e-18.
        "m1": (
            [1.9848129005862, 2.07347482012341, 2.46046655630439, 2.11518393195383],
            [-0.608903036817037, 1.25066773332571, -0.48761931299259, -1.43135957223839],
            [-2.77713621940785, -2.38126678821425, -5.6261886768245, -4.44116557884531],
        ),
        "m2": (
            [0.715744556202147, 1.06811783346638, 1.02640872163596, 0.681126097285406],
            [0.957311379269204, 1.25066773332571, -1.43135957223839, -0.48761931299259],
            [5.0085082309672, 3.13484647286059, 5.21658992642412, 6.0834179395983],
        ),
    }
    for name, (angle, rate, effort) in expected.items():
        assert sweep.motion.position(name) == pytest.approx(angle, rel=1e-13)
        assert sweep.motion.velocity(name) == pytest.approx(rate, rel=1e-13)
        assert sweep.actuated_effort[name] == pytest.approx(effort, abs=1e-12 * 6.0)
    assert sweep.rows == ("load.x", "load.y")
    for found, given in zip(sweep.point("load"), circle(TIMES), strict=True):
        assert found[..., :2] == pytest.approx(given, abs=1e-13)
    assert max(sweep.loop_residual, sweep.balance_residual, sweep.power_residual) < 1e-14
    assert sweep.task_residual < 1e-14
    # The task carries nothing: wrenches are those of the machine that its motors drive.
    machine = five_bar(loads=PULL).machine
    driven = machine.sweep(sweep.position, sweep.speed, sweep.acceleration)
    assert driven["pin"].force == pytest.approx(sweep["pin"].force, abs=1e-12)
    # By virtual work, what would act along x and y if these were driven.
    along = machine.jacobian("load", position=sweep.position)[:, :2]
    assert 1.0 / np.linalg.det(along) == pytest.approx(
        [-22.023706, -24.979151, -19.902683, -19.902683], abs=1e-6
    )
    acting = np.linalg.solve(np.swapaxes(along, 1, 2), sweep.drive_effort[..., None])[..., 0]
    np.testing.assert_allclose(
        acting,
        [
            [-7.81098681626807, 20.6446516638922],
            [-3.0, 17.3056846313723],
            [1.12075406638813, 22.3834239769646],
            [-7.12075406638813, 22.3834239769646],
        ],
        rtol=0.0,
        atol=1e-12 * 23.0,
    )


def test_second_kind_of_singular_configuration() -> None:
    scene = five_bar(0.0, 0.0)
    level = np.sqrt(0.2**2 - 0.15**2)  # Where the distal links are in line.
    above = np.array([1e-2, 1e-4, 1e-6])
    sweep = scene.sweep(np.stack([0.0 * above, level + above], axis=-1))
    expected = np.array([17.3305405535768, 1623.27996234831, 162218.730885297])
    tolerance = 1e-15 * sweep.condition * expected
    assert np.all(np.abs(sweep.drive_effort[:, 0] + expected) < tolerance)
    assert np.all(np.abs(sweep.drive_effort[:, 1] - expected) < tolerance)
    assert np.all(sweep.task_condition < 30.0)
    assert sweep.condition[1] > 1e3 * sweep.condition[0]
    with pytest.raises(cd.SingularConfigurationError, match=r"sample 1.*second kind") as told:
        scene.sweep([[0.0, 0.2], [0.0, level]])
    assert told.value.sample == 1
    assert told.value.position == pytest.approx([0.0, level])


def test_first_kind_of_singular_configuration() -> None:
    scene, end = five_bar(), 0.438748219369606
    near, far = (scene.sweep([[0.0, end - below]]) for below in (1e-6, 1e-2))
    # Equations and rates of the motors go with the square root of the distance, which both count.
    assert near.task_condition / far.task_condition == pytest.approx(1e4, rel=0.1)
    assert near.condition < 50.0
    with pytest.raises(cd.AssemblyError, match="out of reach") as told:
        scene.sweep([[0.0, 0.3], [0.0, 0.5]])
    assert told.value.sample == 1
    assert told.value.position == pytest.approx([0.0, 0.5])
    assert 0.4 < told.value.nearest[1] < end
    points = [[0.0, 0.3], [0.0, 0.5]]
    np.testing.assert_array_equal(scene.reachable(points), [True, False])


def test_where_a_path_touches_the_end_of_reach_is_told() -> None:
    scene, end = five_bar(), 0.438748219369606
    close = scene.sweep([[0.0, 0.3], [0.0, end - 1e-9], [0.0, 0.3]])
    assert "end of its reach at sample 1" in close.near_reach
    assert close.near_reach in repr(close)
    assert any("end of its reach" in doubt for doubt in cd.Report(close).doubts)
    assert not scene.sweep([[0.0, 0.3], [0.0, end - 1e-4]]).near_reach


def test_a_path_through_a_singular_configuration_between_samples_is_told() -> None:
    """The efforts change their sign where the distal links are in line, and no sample is there."""
    scene, level = five_bar(0.0, 0.0), np.sqrt(0.2**2 - 0.15**2)
    heights = level + np.array([0.05, 0.02, 0.01, -0.01, -0.02])
    through = scene.sweep([[0.0, height] for height in heights])
    assert list(np.sign(through.drive_effort[:, 1])) == [1, 1, 1, -1, -1]
    assert through.near_reach.startswith(
        f"between sample 2 (load.x = 0 m, load.y = {heights[2]:.4g}"
    )
    assert "passes a singular configuration of the second kind" in through.near_reach
    assert through.near_reach in repr(through)
    assert any("second kind" in doubt for doubt in cd.Report(through).doubts)
    for side in (slice(0, 3), slice(3, None)):
        assert not scene.sweep([[0.0, height] for height in heights[side]]).near_reach
    copied = pickle.loads(pickle.dumps(through))
    assert copied.near_reach == through.near_reach


def test_working_modes() -> None:
    ways = []
    for first, second in (1.0, 1.0), (-1.0, 1.0), (1.0, -1.0):
        start = machines.five_bar_start()
        tip = np.array([0.05, 0.28])
        for number, side in (1, -1.0), (2, 1.0):
            if (first, second)[number - 1] < 0.0:  # The other elbow: mirrored at base and tip.
                line = np.arctan2(tip[1], tip[0] - 0.1 * side)
                start[f"m{number}"] = 2.0 * line - start[f"m{number}"]
                start[f"e{number}"] = -start[f"e{number}"]
        sweep = five_bar(near=start).sweep(*circle(TIMES))
        assert sweep.point("load").position[:, :2] == pytest.approx(circle(TIMES)[0], abs=1e-13)
        ways.append(sweep.position)
    assert np.all(np.abs(ways[0][:, 0] - ways[1][:, 0]) > 0.1)
    assert ways[0][:, 1] == pytest.approx(ways[1][:, 1], abs=1e-13)
    assert ways[0][:, 0] == pytest.approx(ways[2][:, 0], abs=1e-13)


def pose(times: Array) -> tuple[Array, Array, Array]:
    """Rows of the Stewart platform: position and rotation vector, and their rates."""
    t = times[:, None]
    place = np.hstack([0.05 * np.sin(t), 0.04 * np.cos(t), 0.6 + 0.03 * np.sin(2 * t)])
    speed = np.hstack([0.05 * np.cos(t), -0.04 * np.sin(t), 0.06 * np.cos(2 * t)])
    more = np.hstack([-0.05 * np.sin(t), -0.04 * np.cos(t), -0.12 * np.sin(2 * t)])
    turns = np.hstack([0.15 * np.sin(t / 2), 0.08 * np.cos(t), 0.1 * np.sin(t)])
    first = np.hstack([0.075 * np.cos(t / 2), -0.08 * np.sin(t), 0.1 * np.cos(t)])
    second = np.hstack([-0.0375 * np.sin(t / 2), -0.08 * np.cos(t), -0.1 * np.sin(t)])
    # Angular velocity of turns about z, the carried y, the carried x.
    about_z, about_y = Rotation.from_rotvec(turns[:, :1] * [0, 0, 1]), [0.0, 1.0, 0.0]
    y = about_z.apply(about_y)
    x = (about_z * Rotation.from_rotvec(turns[:, 1:2] * about_y)).apply([1.0, 0.0, 0.0])
    z = np.tile([0.0, 0.0, 1.0], (len(t), 1))
    spin_z, spin_zy = first[:, :1] * z, first[:, :1] * z + first[:, 1:2] * y
    spin = spin_zy + first[:, 2:] * x
    rate = second[:, :1] * z + second[:, 1:2] * y + second[:, 2:] * x
    rate += first[:, 1:2] * np.cross(spin_z, y) + first[:, 2:] * np.cross(spin_zy, x)
    turned = Rotation.from_euler("ZYX", turns).as_rotvec()
    return np.hstack([place, turned]), np.hstack([speed, spin]), np.hstack([more, rate])


def stewart(**given: object) -> cd.Scene:
    push = cd.Wrench(force=(50.0, -30.0, -200.0), moment=(5.0, 3.0, -8.0), frame="world")
    arguments = {"loads": {"platform": push}, "gravity": (0.0, 0.0, -9.81)}
    mechanism = cd.load(machines.stewart())
    task = cd.PoseTask("platform")
    return cd.Scene(mechanism, task=task, actuated=machines.LEGS, **{**arguments, **given})


def test_stewart_platform_against_its_free_body() -> None:
    rows = pose(np.array([0.0, 2.0]))
    sweep = stewart().sweep(*rows)
    lengths = [
        *(0.665178443569155, 0.682158809109316, 0.66843075162175),
        *(0.688659598473852, 0.726085728748109, 0.69055762509639),
        *(0.620931170760079, 0.684615916785135, 0.69658143788232),
        *(0.693145129909101, 0.63270716374871, 0.68483276091718),
    ]
    thrusts = [
        *(96.8091132204575, 115.916156741967, 37.2920745780882),
        *(77.1331568966176, 66.483200768655, 60.4821638550347),
        *(102.785237448003, 136.130329018382, 12.7032379163118),
        *(56.6751549563334, 109.610770199353, 36.0940863586543),
    ]
    found = (sweep.position + machines.LEG_LENGTHS).ravel()
    assert found == pytest.approx(lengths, abs=1e-13)
    assert sweep.drive_effort.ravel() == pytest.approx(thrusts, abs=1e-12 * 136.0)
    point = sweep.point("platform")
    assert point.velocity == pytest.approx(rows[1][:, :3], abs=1e-14)
    assert point.acceleration == pytest.approx(rows[2][:, :3], abs=1e-14)
    assert point.angular_velocity == pytest.approx(rows[1][:, 3:], abs=1e-14)
    assert point.angular_acceleration == pytest.approx(rows[2][:, 3:], abs=1e-14)
    assert sweep.task_residual < 1e-14
    np.testing.assert_array_equal(sweep.task_position, rows[0])
    np.testing.assert_array_equal(sweep.task_speed, rows[1])
    np.testing.assert_array_equal(sweep.task_acceleration, rows[2])


def test_legs_near_the_singular_surface_of_a_stewart_platform() -> None:
    # Turned by about 90° about z its legs do not hold it: thrusts grow as the angle is missed.
    scene = stewart(loads={"platform": cd.Wrench(moment=(0.0, 0.0, 10.0), frame="world")})

    def spun(angle: float) -> list[float]:
        return [0.0, 0.0, 0.6, 0.0, 0.0, angle]

    angles = np.radians([0.0, 40.0, 60.0, 70.0])
    sweep = scene.sweep([spun(angle) for angle in angles], along_path=True)
    assert np.all(np.diff(sweep.condition) > 0.0)
    # One free body: six thrusts along the legs balance weight and moment.
    for angle, thrusts, lengths in zip(angles, sweep.drive_effort, sweep.position, strict=True):
        turn = Rotation.from_rotvec([0.0, 0.0, angle])
        heads = turn.apply(machines.HEADS) + machines.RAISED
        ways = heads - machines.FEET
        sizes = np.linalg.norm(ways, axis=1)
        assert lengths + machines.LEG_LENGTHS == pytest.approx(sizes, abs=1e-13)
        ways /= sizes[:, None]
        screws = np.hstack([ways, np.cross(heads - machines.RAISED, ways)]).T
        weight = 20.0 * 9.81 * np.array([0.0, 0.0, -1.0])
        centre = turn.apply([0.01, 0.02, 0.03])
        moment = np.cross(centre, weight) + 10.0 * machines.Z
        acting = np.concatenate([weight, moment])
        expected = np.linalg.solve(screws, -acting)
        tolerance = 1e-14 * np.linalg.cond(screws) * np.abs(expected).max()
        assert thrusts == pytest.approx(expected, abs=tolerance)
    with pytest.raises(
        cd.SingularConfigurationError, match=r"sample 1\) in .* second kind"
    ) as told:
        scene.sweep([spun(0.0), spun(np.pi / 2.0)])
    assert told.value.sample == 1
    assert told.value.position == pytest.approx(spun(np.pi / 2.0))
    assert told.value.condition > 1e12


def excavator(**given: object) -> cd.Scene:
    mechanism = cd.load(machines.excavator())
    point = machines.TIP - machines.BUCKET_PIN
    task = [cd.PointTask("bucket", point, axes="xz"), cd.AngleTask("bucket", "y")]
    arguments = {"task": task, "actuated": machines.CYLINDERS, "gravity": (0.0, 0.0, -9.81)}
    return cd.Scene(mechanism, **{**arguments, **given})


def grading(count: int) -> Array:
    """Tip along the ground towards the machine, with a bucket that rolls in."""
    share = np.linspace(0.0, 1.0, count)
    return np.stack([5.2 - 0.9 * share, -0.6 - 0.3 * share**2, 0.4 * share], axis=-1)


def test_excavator_against_its_geometry_and_virtual_work() -> None:
    rows, speed = grading(9), np.array([-0.5, 0.2, 0.3])
    scene = excavator()
    still, moving = scene.sweep(rows), scene.sweep(rows, speed, [0.1, 0.4, -0.2])
    for k, row in enumerate(rows):
        lengths, _ = machines.excavator_at(row)
        jets = [machines.excavator_at(row + 1j * STEP * axis) for axis in np.eye(3)]
        by = np.stack([jet[0].imag for jet in jets], axis=1) / STEP  # Of lengths by rows.
        forces = np.linalg.solve(by.T, [float(jet[1].imag) / STEP for jet in jets])
        assert still.position[k] == pytest.approx(lengths.real, abs=1e-13 * 5.0)
        assert still.drive_effort[k] == pytest.approx(forces, abs=1e-12 * np.abs(forces).max())
        assert moving.speed[k] == pytest.approx(by @ speed, abs=1e-12)
        assert moving.position[k] == pytest.approx(still.position[k], abs=1e-15)
    assert moving.task_residual < 1e-14
    driven = scene.machine.sweep(moving.position, moving.speed, moving.acceleration)
    size = np.abs(moving.drive_effort).max()
    assert driven.drive_effort == pytest.approx(moving.drive_effort, abs=1e-12 * size)
    tip = driven.point("bucket", machines.TIP - machines.BUCKET_PIN)
    assert tip.position[:, [0, 2]] == pytest.approx(rows[:, :2], abs=1e-13)
    assert tip.velocity[:, [0, 2]] - speed[:2] == pytest.approx(0.0, abs=1e-13)
    assert tip.acceleration[:, [0, 2]] - [0.1, 0.4] == pytest.approx(0.0, abs=1e-12)
    assert tip.angular_velocity[:, 1] == pytest.approx(0.3, abs=1e-13)
    assert tip.angular_acceleration[:, 1] == pytest.approx(-0.2, abs=1e-12)


@pytest.mark.slow
def test_what_an_excavator_cannot_reach() -> None:
    scene = excavator()
    with pytest.raises(
        cd.AssemblyError, match=r"bucket.x, bucket.z, bucket.turn_y, is .* 9,"
    ) as far:
        scene.sweep([[5.2, -0.6, 0.0], [9.0, -0.6, 0.0]])
    # Boom and stick in line: the tip as far from the boom's foot as these let the bucket be.
    pin = machines.BUCKET_PIN - machines.TIP
    lengths = [
        np.linalg.norm(machines.STICK_PIN - end) for end in (machines.FOOT, machines.BUCKET_PIN)
    ]
    reach = np.sqrt(sum(lengths) ** 2 - (pin[2] - 0.6) ** 2) - pin[0]
    assert far.value.nearest == pytest.approx([reach, -0.6, 0.0], abs=1e-3)
    # A bucket turns as far as its linkage; nothing is singular there but the follower.
    with pytest.raises(cd.AssemblyError) as turned:
        scene.sweep([[5.2, -0.6, 6.0]])
    assert 1.0 < turned.value.nearest[2] < 2.0


def test_parallel_ankle_against_the_lengths_of_its_rods() -> None:
    scene = cd.Scene(
        cd.load(machines.ankle()),
        drive=["pitch", "roll"],
        actuated=["motor_l", "motor_r"],
        gravity=(0.0, 0.0, -9.81),
    )
    rng = np.random.default_rng(4)
    rows, rates = rng.uniform(-0.3, 0.3, (2, 12, 2))
    sweep = scene.sweep(rows, rates)
    still = scene.sweep(rows)
    assert still.task_residual < 1e-14
    for k, (row, rate) in enumerate(zip(rows, rates, strict=True)):
        by = np.zeros((2, 2))
        for side, motor in enumerate(sweep.position[k]):
            assert abs(machines.rod_gap(side, motor, *row)) < 1e-15
            turn = 1j * STEP * np.eye(2)
            own = machines.rod_gap(side, motor + 1j * STEP, *row).imag
            by[side] = [-machines.rod_gap(side, motor, *(row + way)).imag / own for way in turn]
        assert sweep.speed[k] == pytest.approx(by @ rate, abs=1e-13)
        height = [
            machines.tilted(*(row + way), machines.SOLE)[2].imag / STEP
            for way in 1j * STEP * np.eye(2)
        ]
        weight = 9.81 * machines.FOOT_MASS * np.array(height)
        assert still.drive_effort[k] == pytest.approx(np.linalg.solve(by.T, weight), abs=1e-12)
    # The way back: the motors as drives bring the foot to where it was given.
    back = scene.machine.sweep(sweep.position, sweep.speed)
    assert back.motion.position("roll") == pytest.approx(rows[:, 1], abs=1e-13)
    assert back.motion.velocity("pitch") == pytest.approx(rates[:, 0], abs=1e-13)


def arm(**given: object) -> cd.Scene:
    arguments = {"near": machines.ARM_START, "gravity": (0.0, 0.0, -9.81)}
    return cd.Scene(cd.load(machines.arm()), **{**arguments, **given})


def test_inverse_kinematics_of_an_arm_is_the_inverse() -> None:
    joints = list(machines.ARM)
    rng = np.random.default_rng(1)
    q = np.array(list(machines.ARM_START.values())) + rng.uniform(-0.5, 0.5, (40, 6))
    v, a = rng.normal(size=(2, 40, 6))
    forward = arm(drive=joints).sweep(q, v, a)
    hand = forward.point("hand")
    turned = Rotation.from_matrix(hand.orientation).as_rotvec()
    rows = np.hstack([hand.position, turned])
    rates = np.hstack([hand.velocity, hand.angular_velocity])
    more = np.hstack([hand.acceleration, hand.angular_acceleration])
    scene = arm(task=cd.PoseTask("hand"), actuated=joints)
    sweep = scene.sweep(rows, rates, more)
    lost = 1e-14 * sweep.task_condition.max()
    assert sweep.position == pytest.approx(q, abs=lost)
    assert sweep.speed == pytest.approx(v, abs=10.0 * lost)
    assert sweep.acceleration == pytest.approx(a, abs=100.0 * lost)
    size = np.abs(forward.drive_effort).max()
    assert sweep.drive_effort == pytest.approx(forward.drive_effort, abs=100.0 * lost * size)


def test_paths_turn_a_link_as_far_as_they_lead() -> None:
    joints, share = list(machines.ARM), np.linspace(0.0, 1.0, 200)
    ways = [1.5 * np.sin(5 * share), 0.3 * np.sin(3 * share), 0.4 * share]
    ways += [2.2 * share, 0.5 * np.sin(4 * share), 7.0 * share]
    q = np.array(list(machines.ARM_START.values())) + np.stack(ways, axis=-1)
    hand = arm(drive=joints).sweep(q).point("hand")
    turned = Rotation.from_matrix(hand.orientation).as_rotvec()
    scene = arm(task=cd.PoseTask("hand"), actuated=joints)
    sweep = scene.sweep(np.hstack([hand.position, turned]), along_path=True)
    assert sweep.position == pytest.approx(q, abs=1e-14 * sweep.task_condition.max())


def gantry(*hinges: int) -> tuple[cd.Mechanism, list[str]]:
    """Return a hand on three slides and hinges about x (0), y (1) or z (2), and its joints."""
    parts = [machines.link("ground"), machines.link("hand", 2.0, 0.1 * machines.X, np.ones(3))]
    links = ["ground", *(f"m{k}" for k in range(5)), "hand"]
    names, kinds = [f"q{k}" for k in range(6)], ["prismatic"] * 3 + ["continuous"] * 3
    axes = np.eye(3)[[0, 1, 2, *hinges]]
    for name, kind, axis, *ends in zip(names, kinds, axes, links, links[1:], strict=False):
        parts.append(machines.joint(name, kind, *ends, 0.0 * axis, axis))
    parts += [machines.link(name) for name in links[1:-1]]
    return cd.load(machines.robot("gantry", *parts)), names


@pytest.mark.parametrize("along_path", [False, True])
def test_turns_that_no_middle_angle_limits(along_path: bool) -> None:
    """A turn about y alone goes beyond the right angle at which other angles change as well."""
    mechanism, names = gantry(0, 2, 1)
    turned = np.linspace(0.0, 3.0, 13)
    rows = turned[:, None] * np.eye(6)[4]
    sweep = cd.Scene(mechanism, task=cd.PoseTask("hand"), actuated=names).sweep(
        rows, along_path=along_path
    )
    assert sweep.position == pytest.approx(turned[:, None] * np.eye(6)[5], abs=1e-14)


LOCKED = [(0.0, np.pi / 2, 0.0), (0.4, -np.pi / 2, 0.3), (0.2, np.pi / 2 - 1e-9, 0.5)]


@pytest.mark.parametrize("turn", [*LOCKED, (np.pi, 0.0, 0.0), (0.0, 2.8, 0.3)])
def test_rates_are_right_where_cardan_angles_lock(turn: tuple[float, float, float]) -> None:
    """A link on three slides and three hinges, whose axes are those of no angles of ours."""
    mechanism, names = gantry(2, 0, 2)
    near = {"q3": 0.3, "q4": 0.9, "q5": -0.4}
    scene = cd.Scene(mechanism, task=cd.PoseTask("hand"), actuated=names, near=near)
    start = Rotation.from_matrix(scene.configuration().orientation("hand"))
    row = np.concatenate([[0.1, -0.2, 0.3], (Rotation.from_euler("XYZ", turn) * start).as_rotvec()])
    rate = np.array([1.0, 2.0, -1.0, 0.7, -0.3, 0.9])
    more = np.array([0.5, 0.0, 1.0, -2.0, 1.0, 0.4])
    sweep = scene.sweep(row[None], rate, more)
    hand, scale = sweep.point("hand"), sweep.task_condition[0]
    assert sweep.task_residual < 1e-14 * scale
    turned = Rotation.from_matrix(hand.orientation[0]) * Rotation.from_rotvec(row[3:]).inv()
    assert turned.magnitude() < 1e-14 * scale
    assert hand.angular_velocity[0] == pytest.approx(rate[3:], abs=1e-14 * scale)
    assert hand.angular_acceleration[0] == pytest.approx(more[3:], abs=1e-13 * scale)


@pytest.mark.slow
def test_rows_of_any_kind_meet() -> None:
    start = machines.five_bar_start()
    tasks = {
        "load.x d2.y": [cd.PointTask("load", axes="x"), cd.PointTask("d2", (0.25, 0, 0), axes="y")],
        "load.y load.x": cd.PointTask("load", axes="yx"),
        "tip.x tip.y": cd.PointTask("tip", axes="xy"),  # The joint that fixes it.
        "m1 load.x": ["m1", cd.PointTask("load", axes="x")],
        "d1.turn_z load.y": [cd.AngleTask("d1"), cd.PointTask("load", axes="y")],
        "load.x load.x_2": [cd.PointTask("load", axes="x"), cd.PointTask("load", (0, 0.1, 0), "x")],
    }
    reference = five_bar().sweep(*circle(TIMES))
    elbow = reference.motion.position("m1") + reference.motion.position("e1")
    zero = five_bar().machine.mechanism  # Where d1 points along x.
    assert zero.placements_at_zero[0].rotation[0, 0] == 1.0
    x, y = circle(TIMES)[0].T
    higher = reference.point("load", (0, 0.1, 0)).position[:, 0]
    values = {"load.x": x, "tip.x": x, "load.y": y, "tip.y": y, "d2.y": y, "load.x_2": higher}
    values |= {"m1": reference.position[:, 0], "d1.turn_z": elbow}
    for rows, task in tasks.items():
        scene = five_bar(task=task, near=start)
        assert scene.rows == tuple(rows.split())
        sweep = scene.sweep(np.stack([values[row] for row in scene.rows], axis=-1))
        lost = 1e-14 * sweep.task_condition.max()
        assert sweep.position == pytest.approx(reference.position, abs=lost)


def universal(rows: Array, first: int) -> Array:
    """Return directions `(N, 3)` by angles `(N, 2)` of turns about two axes in order."""
    axes = [("xyz" * 2)[first + k].upper() for k in range(2)]
    along = np.eye(3)[(first + 2) % 3]
    return Rotation.from_euler("".join(axes), rows).apply(along)


@pytest.mark.parametrize(
    ("along", "first", "other"), [("x", 1, ""), ("z", 0, ""), ("y", 2, "upper")]
)
def test_directions_against_rotations_of_scipy(along: str, first: int, other: str) -> None:
    own = np.array([0.2, 1.0, 0.1])
    tasks = [cd.PointTask("hand"), cd.DirectionTask("hand", own, along, other), "wrist_3"]
    robot = cd.load(machines.arm())
    scene = cd.Scene(robot, task=tasks, actuated=[*machines.ARM], near=machines.ARM_START)
    begun = scene.configuration()
    carried = begun.orientation(other) if other else np.eye(3)
    x, y, z = np.roll(own @ begun.orientation("hand").T @ carried, -first) / np.linalg.norm(own)
    turns = np.array([np.arctan2(-y, z), np.arcsin(x)])
    start = np.concatenate([begun.point("hand"), turns, [machines.ARM_START["wrist_3"]]])
    rates, more = 0.1 * np.array([1.0, -2.0, 1.0, 3.0, 2.0, 1.0]), np.linspace(-0.5, 0.5, 6)
    t = np.linspace(0.0, 0.5, 4)[:, None]
    sweep = scene.sweep(start + t * rates, rates, more)
    lost = 1e-15 * sweep.task_condition.max()
    hand = sweep.point("hand")
    base = sweep.point(other) if other else None
    held = np.tile(np.eye(3), (4, 1, 1)) if base is None else base.orientation
    got = (hand.orientation @ own / np.linalg.norm(own))[:, None, :] @ held
    asked = universal(sweep.task_position[:, 3:5], first)
    assert got[:, 0] == pytest.approx(asked, abs=lost)
    # How fast it turns, by differences of the same angles along the parabola.
    step = 1e-5
    ends = [universal((start + t * rates + s * step * rates)[:, 3:5], first) for s in (1, -1)]
    spin = hand.angular_velocity - (0.0 if base is None else base.angular_velocity)
    seen = (np.cross(spin, hand.orientation @ own) / np.linalg.norm(own))[:, None, :] @ held
    assert seen[:, 0] == pytest.approx((ends[0] - ends[1]) / (2 * step), abs=1e-9)
    assert sweep.task_residual < lost
    assert missed(scene.task, sweep.task_position + 0.02 * np.eye(6)[4], sweep) > 0.01


def test_distances() -> None:
    """Those from feet to heads of a Stewart platform are the lengths of its legs."""
    ends = zip(machines.HEADS, machines.FEET, strict=True)
    tasks = [cd.DistanceTask("platform", "base", head, foot) for head, foot in ends]
    platform = cd.load(machines.stewart())
    scene = cd.Scene(platform, task=tasks, actuated=machines.LEGS, gravity=(0, 0, -9.81))
    assert scene.rows[:2] == ("platform.distance", "platform.distance_2")
    longer = np.linspace(0.0, 0.05, 3)[:, None] * np.arange(6)
    rate, more = np.linspace(0.1, 0.3, 6), np.linspace(0.2, -0.2, 6)
    sweep = scene.sweep(machines.LEG_LENGTHS + longer, rate, more)
    driven = scene.machine.sweep(longer, rate, more)
    assert sweep.position == pytest.approx(longer, abs=1e-14)
    assert sweep.acceleration == pytest.approx(np.tile(more, (3, 1)), abs=1e-13)
    assert sweep.drive_effort == pytest.approx(driven.drive_effort, abs=1e-10)
    assert sweep.task_residual < 1e-14
    length = platform.characteristic_length
    off = missed(scene.task, sweep.task_position + 1e-3, sweep)
    assert off == pytest.approx(1e-3 / length)
    # Between links of a plane, one of them moving; and where it has no direction.
    pair = [cd.DistanceTask("load", "p2"), cd.DistanceTask("load", "p1")]
    sweep = five_bar(task=pair, near=machines.five_bar_start()).sweep([[0.31, 0.3]], [0.1, 0.2])
    way = sweep.point("load").position - sweep.point("p2").position
    assert np.linalg.norm(way) == pytest.approx(0.31, abs=1e-15)
    assert (way @ sweep.point("load").velocity[0])[0] == pytest.approx(0.031, abs=1e-14)
    with pytest.raises(cd.ModelError, match="zero where the scene starts"):
        five_bar(task=[cd.DistanceTask("load", "d2", other_point=(0.25, 0, 0)), "m1"])


def test_poses_that_the_nearest_angles_do_not_lead_to() -> None:
    parts = [machines.link("ground"), machines.link("torso", 10.0, machines.HERE, np.ones(3))]
    parts.append(machines.joint("base", "floating", "ground", "torso", machines.HERE, machines.X))
    axes = [f"base.{name}" for name in ("x", "y", "z", "turn_x", "turn_y", "turn_z")]
    free = cd.load(machines.robot("free", *parts))
    scene = cd.Scene(free, task=cd.PoseTask("torso"), actuated=axes)
    rows = np.zeros((60, 6))
    rows[:, 3:] = Rotation.random(60, random_state=3).as_rotvec()
    assert scene.reachable(rows).all()
    sweep = scene.sweep(rows)
    assert sweep.task_residual < 1e-15 * sweep.task_condition.max()


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("origin:e1.x", marks=pytest.mark.slow),
        "origin:pin.successor.x",
        "mass:d2",
    ],
)
def test_derivatives_hold_the_task(name: str) -> None:
    """Against differences of sweeps of mechanisms that are held otherwise."""
    five, given = five_bar(gravity=(0.0, -9.81, 0.0)), circle(TIMES)
    sweep = five.sweep(*given)
    found = sweep.derivative(name)
    of_machine = sweep.of_machine.derivative(name).drive_effort
    efforts = np.stack([found.actuated_effort[joint] for joint in sweep.actuated_effort], -1)
    np.testing.assert_array_equal(efforts, found.drive_effort)
    if name.startswith("mass"):  # It moves nothing.
        np.testing.assert_allclose(found.drive_effort, of_machine, rtol=1e-15)
        return
    step, held = 1e-5, five_bar(gravity=(0.0, -9.81, 0.0), held={name: 0.0})
    ends = [held.sweep(*given, held={name: s * step}) for s in (1, -1)]
    for read in (lambda of: of.drive_effort, lambda of: of["e1"].force[:, :2]):
        slope = (read(ends[0]) - read(ends[1])) / (2.0 * step)
        assert read(found) == pytest.approx(slope, abs=1e-7 * np.abs(slope).max())
    where_held = held.sweep(*given).derivative(name)
    assert where_held.drive_effort == pytest.approx(found.drive_effort, abs=1e-12)
    assert np.abs(where_held.point("load")).max() < 1e-14
    assert np.abs(of_machine - found.drive_effort).max() > 1.0
    assert found.loop_residual < 1e-13 and found.balance_residual < 1e-13
    again = pickle.loads(pickle.dumps(sweep)).derivative(name)
    assert again.drive_effort == pytest.approx(found.drive_effort, abs=1e-12)


def test_derivatives_by_rows_of_a_task() -> None:
    scene, given = five_bar(gravity=(0.0, -9.81, 0.0)), circle(TIMES)
    sweep, step = scene.sweep(*given), 1e-5
    for order, kind in enumerate(("", "speed:", "acceleration:")):
        ends = []
        for sign in (1.0, -1.0):
            moved = [values.copy() for values in given]
            moved[order][:, 0] += sign * step
            ends.append(scene.sweep(*moved).drive_effort)
        slope = (ends[0] - ends[1]) / (2.0 * step)
        found = sweep.derivative(f"{kind}load.x").drive_effort
        assert found == pytest.approx(slope, abs=1e-7 * np.abs(slope).max())
    by = sweep.derivative("load.x", "origin:e1.*", "gravity.y")
    assert [*by] == ["origin:e1.x", "origin:e1.y", "origin:e1.yaw", "gravity.y", "load.x"]
    weights = {"drive_effort": 1.0, "e1.force_x": 2.0}
    for name, slope in sweep.gradient(weights, *by).items():
        summed = by[name].drive_effort.sum() + 2.0 * by[name]["e1"].force[:, 0].sum()
        assert slope == pytest.approx(summed, rel=1e-12)


def test_derivatives_where_more_acts_than_moves() -> None:
    """Loads have an axis more than the positions of the task."""
    scene, given = five_bar(), circle(TIMES)
    pulls = np.array([1.0, -2.0])
    sweep = scene.sweep(*given, loads={"m1": pulls[:, None]})
    for name in "origin:e1.x", "load.x", "mass:d2":
        found, weights = sweep.derivative(name), {"drive_effort": 1.0}
        assert found.drive_effort.shape == (2, len(TIMES), 2)
        for pull, of_pull in zip(pulls, found.drive_effort, strict=True):
            alone = scene.sweep(*given, loads={"m1": pull}).derivative(name)
            assert of_pull == pytest.approx(alone.drive_effort, abs=1e-11)
        summed = sweep.gradient(weights, name)[name]
        assert summed == pytest.approx(found.drive_effort.sum(), rel=1e-12)


def test_numbers_that_have_to_be_held_for_a_derivative() -> None:
    """Distances are followed by rods, points of plane arms in their plane: held numbers go on."""
    task, rows, step = [cd.DistanceTask("load", "p2"), "m1"], [[0.31, 1.9]], 1e-5
    name = "origin:pin.successor.x"
    with pytest.raises(cd.ModelError, match=f"held={{'{name}': 0.0}}"):
        five_bar(task=task).sweep(rows).derivative(name)
    scene = five_bar(task=task, held={name: 0.0})
    ends = [scene.sweep(rows, held={name: s * step}).drive_effort for s in (1, -1)]
    found = scene.sweep(rows).derivative(name).drive_effort
    slope = (ends[0] - ends[1]) / (2.0 * step)
    assert found == pytest.approx(slope, abs=1e-7 * np.abs(slope).max())
    upper = machines.link("upper", 1.0, np.array([0.2, 0.1, 0.0]), np.ones(3))
    parts = [machines.link("ground"), upper]
    parts.append(machines.link("lower", 1.0, np.array([0.2, 0.0, 0.1]), np.ones(3)))
    parts.append(machines.joint("a", "continuous", "ground", "upper", machines.HERE, machines.Z))
    elbow = np.array([0.4, 0.0, 0.1])
    parts.append(machines.joint("b", "continuous", "upper", "lower", elbow, machines.Z))
    arm = {
        "task": cd.PointTask("lower", (0.3, 0.0, 0.1), axes="xy"),
        "actuated": ["a", "b"],
        "near": {"a": 0.3, "b": 0.9},
        "gravity": (1.0, -9.81, 2.0),
    }
    mechanism, rows = cd.load(machines.robot("arm", *parts)), [[0.5, 0.4], [0.52, 0.3]]
    for name in "origin:b.z", "origin:b.roll":
        with pytest.raises(cd.ModelError, match="hold it there"):
            cd.Scene(mechanism, **arm).sweep(rows).derivative(name)
        scene = cd.Scene(mechanism, held={name: 0.0}, **arm)
        ends = [scene.sweep(rows, held={name: s * step}) for s in (1, -1)]
        found = scene.sweep(rows).derivative(name)
        slope = (ends[0]["a"].moment - ends[1]["a"].moment) / (2.0 * step)
        assert found["a"].moment == pytest.approx(slope, abs=1e-7 * np.abs(slope).max())
        assert np.abs(slope).max() > 0.1


@pytest.mark.slow
def test_what_misses_a_task_shows() -> None:
    length = cd.load(machines.excavator()).characteristic_length
    sweep, rows = excavator().sweep(grading(3)), grading(3)
    point, angle = excavator().task
    assert missed((point, angle), rows, sweep) < 1e-14
    assert missed((point, angle), rows + 1e-3 * machines.Y, sweep) == pytest.approx(1e-3 / length)
    assert missed((point, angle), rows - 0.02 * machines.Z, sweep) == pytest.approx(0.02)
    pushed = stewart().sweep(given := pose(np.array([0.3, 0.7]))[0])
    task = (cd.PoseTask("platform"),)
    assert missed(task, given, pushed) < 1e-14
    turned = given + 0.01 * np.eye(6)[3]
    assert missed(task, turned, pushed) == pytest.approx(0.01, rel=0.02)
    legs = pushed.position + 0.1 * np.eye(6)[4]
    size = pushed.mechanism.characteristic_length
    assert missed(tuple(machines.LEGS), legs, pushed) == pytest.approx(0.1 / size)


def test_a_single_row() -> None:
    """The ram of a press: its crank, and what happens at its dead points."""
    scene = cd.Scene(
        cd.load("slider_crank"),
        task=cd.PointTask("piston", axes="x"),
        actuated="crank_bearing",
        near={"crank_bearing": 0.5},
        loads={"piston_guide": -100.0},
    )
    low, high = scene.motion_range()
    ram = np.linspace(low, high, 11)[1:-1]
    sweep = scene.sweep(ram, speed=0.2)
    assert sweep.task_position.shape == sweep.position.shape == (9,)
    assert sweep.point("piston").position[:, 0] == pytest.approx(ram, abs=1e-15)
    assert scene.sweep(ram).drive_effort * sweep.speed == pytest.approx(100.0 * 0.2, rel=1e-11)
    assert scene.sweep(ram[:, None]).shape == (9,)
    assert scene.sweep(ram[3]).shape == (1,)
    with pytest.raises(cd.SingularConfigurationError, match="first kind") as ended:
        scene.sweep([ram[2], high], speed=1.0)
    assert ended.value.sample == 1
    with pytest.raises(cd.AssemblyError, match="out of reach") as beyond:
        scene.sweep(high + 0.01)
    assert beyond.value.nearest == pytest.approx(high, abs=1e-6)


def test_designs_loads_and_speeds_broadcast() -> None:
    scene = cd.Scene(
        cd.load("universal_joint"),
        drive="bearing_out",
        actuated="bearing_in",
        held={"joint_angle": 0.5},
    )
    turn, bends = np.linspace(0.0, 12.0, 7), np.array([0.2, 0.5])[:, None]
    torque = np.array([-100.0, 50.0])[:, None, None]
    sweep = scene.sweep(turn, 3.0, held={"joint_angle": bends}, loads={"bearing_out": torque})
    assert sweep.shape == sweep.task_position.shape == sweep.task_condition.shape == (2, 2, 7)
    assert sweep.task_speed[1, 0, 3] == 3.0
    # Backwards through a joint the roles of its shafts are exchanged, a quarter of a turn on.
    square = np.cos(bends) / (1.0 - np.sin(bends) ** 2 * np.sin(turn) ** 2)
    assert sweep.speed == pytest.approx(np.broadcast_to(3.0 * square, (2, 2, 7)), rel=1e-13)
    still = scene.sweep(turn, held={"joint_angle": bends}, loads={"bearing_out": torque})
    assert still.drive_effort * sweep.speed == pytest.approx(-3.0 * torque + 0.0 * sweep.speed)
    frame = sweep.to_xarray()
    assert frame.task_position.dims == ("sample_0", "sample_1", "sample_2", "task")
    assert frame.task_position.attrs["units"] == "rad"


@pytest.mark.slow
def test_more_actuated_joints_than_decide_the_motion() -> None:
    joints = ["m1", "m2", "e1"]
    scene = five_bar(actuated=joints)
    shared, alone = scene.sweep(*circle(TIMES)), five_bar().sweep(*circle(TIMES))
    assert not any(shared.actuated_unique.values())
    assert alone.actuated_unique == {"m1": True, "m2": True}
    # Virtual work leaves a line of efforts, of which the nearest to zero is taken.
    rates = np.stack([[shared.motion.ratio(n, k) for n in joints] for k in shared.drives], -1)
    rates = np.moveaxis(rates, 1, 0)
    efforts = np.stack([shared.actuated_effort[name] for name in joints], -1)
    null = np.linalg.svd(np.moveaxis(rates, -1, -2))[2][:, -1]
    assert np.einsum("na,na->n", null, efforts) == pytest.approx(0.0, abs=1e-12)
    speeds = np.stack([shared.motion.velocity(name) for name in joints], -1)
    power = np.sum(alone.drive_effort * alone.speed, axis=-1)
    assert np.sum(efforts * speeds, axis=-1) == pytest.approx(power, abs=1e-12)
    # Wrenches are those of these efforts, and what depends on the sharing is not unique.
    loads = {name: shared.actuated_effort[name] for name in joints if name not in shared.drives}
    other = scene.machine.sweep(shared.position, shared.speed, shared.acceleration, loads=loads)
    assert other["pin"].force == pytest.approx(shared["pin"].force, abs=1e-12)
    assert alone["pin"].unique[0]
    assert not shared["pin"].unique[0]
    # How they are shared changes as well, of which derivatives of the machine say nothing.
    by = shared.derivative("load.x", "gravity.x")
    assert all(np.isnan(of.drive_effort).all() for of in by.values())
    assert all(list(of.actuated_effort) == joints for of in by.values())
    assert all(np.isnan(list(of.actuated_effort.values())).all() for of in by.values())
    with pytest.raises(cd.ModelError, match="laws of motion"):
        shared.gradient({"m1.drive_effort": 1.0}, "load.x")
    # As loads they stay as they are, and are those of any sweep in linear models.
    models = [scene.machine.linear(item).A for item in (shared, other)]
    np.testing.assert_allclose(*models, rtol=1e-9, atol=1e-9)
    # A weight that forbids a joint to take part, and other drives where some do not decide.
    heavy = scene.replace(effort_weights={"e1": 1e14}).sweep(*circle(TIMES))
    assert heavy.actuated_effort["m2"] == pytest.approx(alone.actuated_effort["m2"], abs=1e-9)
    level = [[0.0, np.sqrt(0.2**2 - 0.15**2)]]
    assert scene.sweep(level).condition < 100.0
    with pytest.raises(cd.IndeterminateError, match="leave open"):
        five_bar(actuated=joints, strict=True, outputs=[]).sweep(level)


def test_a_floating_base_and_a_foot() -> None:
    parts = [machines.link("ground"), machines.link("torso", 10.0, machines.HERE, np.ones(3))]
    parts += [machines.link(n, 2.0, -0.2 * machines.Z, 0.1 * np.ones(3)) for n in ("thigh", "calf")]
    parts.append(machines.joint("base", "floating", "ground", "torso", machines.HERE, machines.X))
    parts.append(machines.joint("hip", "continuous", "torso", "thigh", machines.HERE, machines.Y))
    knee = -0.4 * machines.Z
    parts.append(machines.joint("knee", "continuous", "thigh", "calf", knee, machines.Y))
    walker = cd.load(machines.robot("walker", *parts))
    base = [f"base.{name}" for name in ("x", "y", "z", "turn_x", "turn_y", "turn_z")]
    near = {"hip": 0.3, "knee": -0.6}
    task = [*base, cd.PointTask("calf", knee, axes="xz")]
    scene = cd.Scene(walker, task=task, actuated=[*base, "hip", "knee"], near=near)
    sweep = scene.sweep([[0.1, 0.0, 0.05, 0.2, -0.1, 0.3, 0.1, -0.7]])
    foot = sweep.point("calf", knee).position[0]
    assert foot[[0, 2]] == pytest.approx([0.1, -0.7], abs=1e-14)
    # With a foot that is held on the ground, the leg and the ground's hinge move the torso.
    standing = cd.close(
        walker, "ground", "calf", "revolute", at_b=knee, axis=machines.Y, name="toe"
    )
    task = [cd.PointTask("torso", axes="xz"), cd.AngleTask("torso", "y")]
    scene = cd.Scene(standing, task=task, actuated=["hip", "knee", "toe"], near=near)
    sweep = scene.sweep([[0.05, -0.02, 0.1]], gravity=(0.0, 0.0, -9.81))
    torso = sweep.point("torso")
    assert torso.position[0] == pytest.approx([0.05, 0.0, -0.02], abs=1e-14)
    assert torso.orientation[0, 0, 2] == pytest.approx(np.sin(0.1), abs=1e-14)
    assert sweep.balance_residual < 1e-13


@pytest.mark.slow
def test_scenes_and_sweeps_are_kept() -> None:
    scene = five_bar(elements=[cd.JointSpring("e1", 10.0, 0.1)])
    sweep = scene.sweep(*circle(TIMES))
    for other in copy.deepcopy(scene), pickle.loads(pickle.dumps(scene)):
        assert (other.rows, other.actuated) == (scene.rows, scene.actuated)
        again = other.sweep(*circle(TIMES))
        assert again.drive_effort == pytest.approx(sweep.drive_effort, abs=1e-13)
    for other in copy.deepcopy(sweep), pickle.loads(pickle.dumps(sweep)):
        np.testing.assert_array_equal(other.task_condition, sweep.task_condition)
        np.testing.assert_array_equal(other.task_position, sweep.task_position)
        np.testing.assert_array_equal(other.actuated_effort["m2"], sweep.actuated_effort["m2"])
    loaded = scene.replace(loads={"m1": 1.0})
    found = loaded.sweep(*circle(TIMES)).drive_effort - sweep.drive_effort
    assert found == pytest.approx(np.array([[-1.0, 0.0]] * 4), abs=1e-13)
    assert "task load.x, load.y; actuated m1, m2" in repr(loaded)
    elbows = scene.replace(actuated=["e1", "e2"]).sweep(*circle(TIMES))
    power = [np.sum(each.drive_effort * each.speed, -1) for each in (elbows, sweep)]
    assert power[0] == pytest.approx(power[1], abs=1e-12)
    assert type(scene.replace(task=None)) is type(scene.replace(drive=["m1", "m2"])) is cd.Scene
    assert scene.replace(task=["m1", "m2"]).rows == ("m1", "m2")
    assert five_bar(outputs=["m1", "m2"]).sweep(*circle(TIMES)).outputs == ("m1", "m2")
    frame = sweep.to_dataframe()
    np.testing.assert_array_equal(frame["load.x.task_speed"], circle(TIMES)[1][:, 0])
    assert frame.attrs["units"]["load.x.task_speed"] == "m/s"


def test_studies_tell_tasks_apart() -> None:
    tasks = point("xy"), point("yx"), cd.PointTask("load", (0.0, 0.1, 0.0), axes="xy")
    parts = [fingerprint(studies.Sweeps(five_bar(task=task), "condition")) for task in tasks]
    again = fingerprint(studies.Sweeps(five_bar(task=point("xy")), "condition"))
    assert differences(parts[0], again) == []
    assert differences(parts[0], parts[1]) and differences(parts[0], parts[2])


def point(axes: str = "xy", link: str = "load") -> cd.PointTask:
    return cd.PointTask(link, axes=axes)


@pytest.mark.parametrize(
    ("given", "error", "told"),
    [
        ({"task": point("x")}, cd.MobilityError, "2 degrees of freedom, .*1 row .*1 too few"),
        ({"task": point("xyz")}, cd.MobilityError, "3 rows .*1 too many"),
        ({"task": ["m1", cd.AngleTask("p1")]}, cd.MobilityError, "depend on each other.* m2"),
        ({"task": ["m1", "m1"]}, cd.ArgumentError, "m1 more than once"),
        ({"task": point(link="lod")}, cd.ModelError, "no link or frame 'lod'.*'load'"),
        ({"task": point(link="base")}, cd.ModelError, "fixed to the world"),
        ({"task": ["m1", "m9"]}, cd.ModelError, "no joint 'm9'"),
        ({"task": []}, cd.ArgumentError, "the task is empty"),
        ({"task": [3]}, cd.ArgumentError, "task has 3; expected cd.PointTask"),
        ({"task": None}, cd.ArgumentError, "actuated says which joints .*elsewhere"),
        ({"drive": "m1"}, cd.ArgumentError, "drive and task both"),
        ({"free": "m1"}, cd.ArgumentError, "either driven, free or held"),
        ({"actuated": None}, cd.MobilityError, r"actuated=\[...\]; joints: e1"),
        (
            {"actuated": ["m1"]},
            cd.MobilityError,
            r"2 deg.* 1 \(m1\); actuate or hold one of: e1, e2",
        ),
        ({"actuated": ["m1", "m7"]}, cd.ModelError, "no joint 'm7'"),
        ({"effort_weights": {"m1": 0.0}}, cd.ArgumentError, "weights are positive"),
        ({"effort_weights": {"e1": 1.0}}, cd.ArgumentError, "'e1' is not actuated"),
    ],
)
def test_refused_scenes(given: dict[str, object], error: type, told: str) -> None:
    with pytest.raises(error, match=told):
        five_bar(**given)


def test_many_actuated_joints_are_not_tried_in_all_combinations() -> None:
    platform = cd.load(machines.stewart())
    balls = [f"{end}_{k}" for end in ("foot", "head") for k in range(6)]
    with pytest.raises(cd.MobilityError, match="7 degrees of freedom, and the task 6 rows"):
        cd.Scene(platform, task=cd.PoseTask("platform"), actuated=balls)


def test_a_platform_that_floats_beside_its_legs_is_moved_by_a_pose_task() -> None:
    """What the message advises is done, against lengths of legs by points and a rotation."""
    platform, legs = cd.load(transmissions.hexapod()), [f"leg_{k}" for k in range(6)]
    with pytest.raises(cd.ArgumentError, match=r"'pose' turns by several.*task=cd.PoseTask"):
        cd.Scene(platform, drive="pose", actuated=legs).sweep(np.zeros(6))
    place, turn = np.array([0.05, -0.04, 0.63]), np.array([0.1, -0.08, 0.15])
    scene = cd.Scene(platform, task=cd.PoseTask("platform"), actuated=legs)
    found = scene.sweep(np.concatenate([place, turn])[None])
    base, top = transmissions.hexapod_points()
    lengths = np.linalg.norm(Rotation.from_rotvec(turn).apply(top) + place - base, axis=1)
    first = np.linalg.norm(np.array([0.0, 0.0, 0.6]) + top - base, axis=1)
    assert found.position[0] == pytest.approx(lengths - first, abs=1e-13)


def test_refused_tasks() -> None:
    with pytest.raises(cd.ArgumentError, match="'xw'"):
        cd.PointTask("load", axes="xw")
    with pytest.raises(cd.ArgumentError, match="expected up to three"):
        cd.PointTask("load", axes="xx")
    with pytest.raises(cd.ArgumentError, match="not finite"):
        cd.PointTask("load", (0.0, np.nan, 0.0))
    with pytest.raises(cd.ArgumentError, match="expected x, y or z"):
        cd.AngleTask("load", "xy")
    with pytest.raises(cd.ArgumentError, match="PoseTask: link"):
        cd.PoseTask(3)
    with pytest.raises(cd.ArgumentError, match="points nowhere"):
        cd.DirectionTask("load", (0.0, 0.0, 0.0))
    with pytest.raises(cd.ArgumentError, match="expected x, y or z"):
        cd.DirectionTask("load", (1.0, 0.0, 0.0), along="xy")
    with pytest.raises(cd.ArgumentError, match="DistanceTask: other_point"):
        cd.DistanceTask("load", "base", other_point=(0.0, 1.0))


def test_refused_calls() -> None:
    scene = five_bar()
    with pytest.raises(cd.ArgumentError, match=r"each row of the task: load.x, load.y"):
        scene.sweep(np.zeros(3))
    with pytest.raises(cd.ArgumentError, match="not finite"):
        scene.sweep([[np.nan, 0.3]])
    with pytest.raises(cd.ArgumentError, match="empty"):
        scene.sweep([])
    with pytest.raises(cd.ArgumentError, match=r"scene.machine.assemble"):
        scene.assemble([[0.05, 0.28]])
    with pytest.raises(cd.ArgumentError, match=r"scene.machine.assemble"):
        scene.sweep(scene.machine.assemble(scene.sweep([[0.05, 0.28]]).position))
    for refused in scene.equilibrium, scene.response:
        with pytest.raises(cd.MobilityError, match=r"scene.machine is the same"):
            refused()
    with pytest.raises(cd.MobilityError, match="range of one row"):
        scene.motion_range()
    sweep = scene.sweep([[0.05, 0.28]])
    with pytest.raises(cd.ModelError, match=r"rows, load.x, load.y, .*of_machine"):
        sweep.derivative("speed:m1")
    with pytest.raises(cd.ModelError, match="nothing that the scene drives"):
        sweep.derivative("e1")
    named = five_bar(task=cd.PointTask("tip", axes="xy")).sweep([[0.05, 0.28]])
    with pytest.raises(cd.ModelError, match="PointTask of 'tip' mean depends on it"):
        named.derivative("origin:tip.x")
    with pytest.raises(cd.ModelError, match="rows of a AngleTask"):
        excavator().sweep(grading(1)).derivative("origin:stick_pin.pitch")
    with pytest.raises(cd.ModelError, match="or it is no coordinate"):
        stewart().sweep(pose(np.array([0.3]))[0]).derivative("platform.turn_x")
    with pytest.raises(TypeError, match="no argument 'tip'"):
        five_bar(tip=point())
