"""Free coordinates beside a task: against closed forms, equations by hand, and sweeps."""

from __future__ import annotations

import pickle
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from testkit import task_machines as machines
from testkit.task_machines import HERE, X, Y, Z

import cardan_dyn as cd
from cardan_dyn.kit.arrays import Array

pytestmark = pytest.mark.usefixtures("loaded_once")

G = 9.81
Moves = Callable[[float], tuple[float, float, float]]


def hung(description: str, link: str, axis: Array = Z, down: Array = -Y) -> str:
    """A pendulum of 0.4 kg at the origin of a link: 0.15 m long, and 1e-3 kg·m² about its mass."""
    swing = machines.link("bob", 0.4, 0.15 * down, HERE + 1e-3)
    swing += machines.joint("swing", "continuous", link, "bob", HERE, axis)
    return description.replace("</robot>", f"{swing}</robot>")


def five_bar(**given: object) -> cd.Scene:
    arguments = {
        "task": cd.PointTask("load", axes="xy"),
        "actuated": ["m1", "m2"],
        "free": "swing",
        "near": machines.five_bar_start(),
        "gravity": (0.0, -G, 0.0),
    }
    return cd.Scene(cd.load(hung(machines.five_bar(), "load")), **{**arguments, **given})


def round_trip(centre: float, size: float, rate: float, phase: float) -> Moves:
    def moves(time: float) -> tuple[float, float, float]:
        turn = rate * time + phase
        cosine, sine = size * np.cos(turn), size * np.sin(turn)
        return centre + cosine, -rate * sine, -(rate**2) * cosine

    return moves


CIRCLE = {
    "load.x": round_trip(0.0, 0.05, 2.0 * np.pi, 0.0),
    "load.y": round_trip(0.28, 0.05, 2.0 * np.pi, -0.5 * np.pi),
}


def swept_again(scene: cd.Scene, found: cd.Trajectory) -> cd.Sweep:
    """The sweep in which free coordinates are given the motion that was found."""
    given = []
    for of_task, of_free in (
        (found.task_position, found.motion.position),
        (found.task_speed, found.motion.velocity),
        (found.task_acceleration, found.motion.acceleration),
    ):
        free = np.stack([of_free(name) for name in scene.free], axis=-1)
        given.append(np.concatenate([of_task.reshape(len(found), -1), free], axis=-1))
    return scene.sweep(*given, along_path=True, time=found.time)


def agree(scene: cd.Scene, found: cd.Trajectory) -> None:
    """Efforts and wrenches are those of the sweep; and free coordinates get no effort there."""
    sweep = swept_again(scene, found)
    most = max(float(np.abs(effort).max()) for effort in found.actuated_effort.values())
    for name in scene.actuated:
        off = np.abs(found.actuated_effort[name] - sweep.actuated_effort[name])
        assert np.max(off) < 1e-12 * most
    for name in scene.free:
        assert np.max(np.abs(sweep.drive_effort[:, sweep.coordinates.index(name)])) < 1e-12 * most
    for joint in found:
        size = np.abs(sweep[joint].force).max() or 1.0
        assert found[joint].force == pytest.approx(sweep[joint].force, abs=1e-12 * size)
    assert max(found.task_residual, found.effort_residual, found.loop_residual) < 1e-14
    assert found.energy_residual < 1e-9


def test_pendulum_at_a_tip_on_a_circle_against_its_equation() -> None:
    scene = five_bar()
    assert scene.rows == ("load.x", "load.y", "swing")
    assert scene.drives == ("m1", "m2")
    assert repr(scene).endswith("task load.x, load.y; free swing; actuated m1, m2>")
    found = scene.simulate(1.5, position=0.3, speed=-1.0, motion=CIRCLE)

    def rates(time: float, state: Array) -> list[float]:  # Of the pendulum's angle in the world.
        along, up = (CIRCLE[f"load.{axis}"](time)[2] for axis in "xy")
        pull = along * np.cos(state[0]) + (up + G) * np.sin(state[0])
        return [state[1], -0.4 * 0.15 * pull / (1e-3 + 0.4 * 0.15**2)]

    exact = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14, "t_eval": found.time}
    turned, bob = found.orientation("bob"), found.point("bob")
    angle = np.unwrap(np.arctan2(turned[:, 1, 0], turned[:, 0, 0]))
    rate = bob.angular_velocity[:, 2]
    by_hand = solve_ivp(rates, (0.0, 1.5), [angle[0], rate[0]], **exact).y
    assert angle == pytest.approx(by_hand[0], abs=1e-9)
    assert rate == pytest.approx(by_hand[1], abs=1e-8)
    assert found.point("load").position[:, 1] == pytest.approx(
        [CIRCLE["load.y"](time)[0] for time in found.time], abs=1e-14
    )
    agree(scene, found)


def crane(**given: object) -> cd.Scene:
    """A trolley of 5 kg, and 2 kg at a massless rod of 1 m below it."""
    parts = [machines.link("ground"), machines.link("trolley", 5.0, HERE, HERE + 0.1)]
    parts += [machines.link("rod"), machines.link("hook", 2.0, HERE, HERE)]
    parts.append(machines.joint("travel", "prismatic", "ground", "trolley", HERE, X))
    parts.append(machines.joint("swing", "continuous", "trolley", "rod", HERE, -Y))
    parts.append(machines.joint("end", "fixed", "rod", "hook", -Z, X))
    task = cd.PointTask("hook", axes="x")
    arguments = {"task": task, "actuated": "travel", "free": "swing", "gravity": (0.0, 0.0, -G)}
    return cd.Scene(cd.load(machines.robot("crane", *parts)), **{**arguments, **given})


def test_a_hook_that_must_not_move_sideways_falls_freely() -> None:
    """The task depends on the free angle: the trolley keeps the rod from pulling sideways."""
    scene = crane(near={"swing": 1.0})
    found = scene.simulate(0.25, motion={"hook.x": 0.0})
    swing = found.motion.position("swing")
    assert np.cos(swing) == pytest.approx(np.cos(1.0) + 0.5 * G * found.time**2, abs=1e-13)
    # Nothing acts along the rod, so that the motor moves the trolley alone.
    moved = 5.0 * found.motion.acceleration("travel")
    effort = found.actuated_effort["travel"]
    assert effort == pytest.approx(moved, abs=1e-12 * np.abs(moved).max())
    agree(scene, found)


def test_where_no_effort_makes_the_task_move() -> None:
    with pytest.raises(cd.SingularConfigurationError, match=r"cannot begin .*hook\.x = 0: no effo"):
        crane().simulate(1.0, motion={"hook.x": 0.0})
    with pytest.raises(cd.SimulationError, match=r"no effort of the actuated") as told:
        crane(near={"swing": 1.0}).simulate(1.0, motion={"hook.x": 0.0})
    level = np.sqrt(2.0 * (1.0 - np.cos(1.0)) / G)  # When the rod is upright.
    assert told.value.time == pytest.approx(level, rel=1e-4)
    assert np.all(told.value.trajectory.task_position == pytest.approx(np.sin(1.0)))


def test_tasks_that_depend_on_what_is_free() -> None:
    scene = five_bar(
        task=cd.PointTask("bob", (0.0, -0.06, 0.0), axes="xy"),
        near={**machines.five_bar_start(), "swing": 0.8},
    )
    agree(scene, scene.simulate(0.1, speed=0.4, motion={"bob.x": 0.02, "bob.y": 0.03}))


def test_a_ball_below_an_arm() -> None:
    turns = HERE + 0.01
    parts = [machines.link("ground"), machines.link("upper", 2.0, 0.2 * X, turns)]
    parts += [
        machines.link("lower", 1.0, 0.15 * X, turns),
        machines.link("quill", 0.3, HERE, turns),
    ]
    parts.append(machines.link("load", 0.7, -0.3 * Z, 0.05 * turns))
    parts.append(machines.joint("shoulder", "continuous", "ground", "upper", HERE, Z))
    parts.append(machines.joint("elbow", "continuous", "upper", "lower", 0.4 * X, Z))
    parts.append(machines.joint("lift", "prismatic", "lower", "quill", 0.3 * X, Z))
    parts.append(machines.joint("ball", "spherical", "quill", "load", HERE, Z))
    scene = cd.Scene(
        cd.load(machines.robot("arm", *parts)),
        task=cd.PointTask("quill"),
        actuated=["shoulder", "elbow", "lift"],
        free="ball",
        near={"elbow": 1.0},
        gravity=(0.0, 0.0, -G),
    )
    x, y, _ = scene.configuration().point("quill")
    motion = {
        "quill.x": round_trip(x - 0.05, 0.05, 3.0, 0.0),
        "quill.y": round_trip(y, 0.05, 3.0, -0.5 * np.pi),
        "quill.z": 0.05,
    }
    start = {"ball.x": 0.4, "ball.z": 0.2}
    agree(scene, scene.simulate(0.5, position=start, motion=motion))


def test_an_excavator_turns_its_bucket_below_which_something_swings() -> None:
    mechanism = cd.load(hung(machines.excavator(), "bucket", Y, -Z))
    point = machines.TIP - machines.BUCKET_PIN
    scene = cd.Scene(
        mechanism,
        task=[cd.PointTask("bucket", point, axes="xz"), cd.AngleTask("bucket", "y")],
        actuated=machines.CYLINDERS,
        free="swing",
        gravity=(0.0, 0.0, -G),
        outputs=["boom_cylinder", "swing"],
    )
    motion = dict(zip(scene.rows, (-0.3, 0.1, 0.2), strict=False))
    agree(scene, scene.simulate(0.5, position=0.4, motion=motion))


def bump(begin: float, length: float, height: float) -> Moves:
    """A haversine, whose acceleration jumps at both ends."""
    rate = 2.0 * np.pi / length

    def moves(time: float) -> tuple[float, float, float]:
        if not begin <= time <= begin + length:
            return 0.0, 0.0, 0.0
        turn, half = rate * (time - begin), 0.5 * height
        return half - half * np.cos(turn), half * rate * np.sin(turn), half * rate**2 * np.cos(turn)

    return moves


def over_bump(times: Array, begin: float, length: float, height: float) -> Array:
    """By how much a spring of 10 rad/s on it is longer: Laplace transform by hand."""
    own, rate = 10.0, 2.0 * np.pi / length

    def since(time: Array, start: float) -> Array:
        late = np.maximum(time - start, 0.0)
        return (np.cos(rate * late) - np.cos(own * late)) / (own**2 - rate**2)

    return -0.5 * height * rate**2 * (since(times, begin) - since(times, begin + length))


@pytest.mark.parametrize("begin", [0.25, 0.3141])
@pytest.mark.parametrize("as_task", [False, True])
def test_a_road_with_a_bump(begin: float, as_task: bool) -> None:
    parts = [machines.link("ground"), machines.link("road", 1.0, HERE, HERE + 0.1)]
    parts.append(machines.link("body", 10.0, HERE, HERE + 0.1))
    parts.append(machines.joint("base", "prismatic", "ground", "road", HERE, Z))
    parts.append(machines.joint("strut", "prismatic", "road", "body", 0.5 * Z, Z))
    how = {"task": cd.PointTask("road", axes="z"), "actuated": "base"} if as_task else {}
    scene = cd.Scene(
        cd.load(machines.robot("car", *parts)),
        **(how or {"drive": "base"}),
        free="strut",
        elements=[cd.JointSpring("strut", 1000.0)],
    )
    row = "road.z" if as_task else "base"
    found = scene.simulate(2.0, motion={row: bump(begin, 0.5, 0.05)})
    exact = over_bump(found.time, begin, 0.5, 0.05)
    assert found.motion.position("strut") == pytest.approx(exact, abs=1e-13)
    assert [name for name, _ in found.events] == [f"kink of {row}"] * 2
    assert [time for _, time in found.events] == pytest.approx([begin, begin + 0.5], rel=1e-15)
    assert found.energy_residual < 1e-12
    assert len(found) < 260  # Steps are not refined at the kinks.


def test_a_motion_that_begins_and_ends_with_a_kink() -> None:
    scene = cd.Scene(cd.load("four_bar"), free="crank_bearing")
    assert scene.free
    parts = [machines.link("ground"), machines.link("road"), machines.link("body", 1.0, HERE, HERE)]
    parts.append(machines.joint("base", "prismatic", "ground", "road", HERE, X))
    parts.append(machines.joint("swing", "prismatic", "road", "body", HERE, Y))
    cart = cd.Scene(cd.load(machines.robot("cart", *parts)), drive="base", free="swing")

    def pushed(time: float) -> tuple[float, float, float]:
        acting = float(0.0 < time < 1.0)
        return 0.5 * time**2, time, acting

    found = cart.simulate(1.0, speed=1.0, motion={"base": pushed})
    assert [time for _, time in found.events] == [np.nextafter(0.0, 1.0), 1.0]
    assert found.drive_effort[0, 0] == pytest.approx(1.0)


def test_what_is_out_of_reach() -> None:
    scene = five_bar()
    begin = scene.configuration().point("load")
    still = {"load.x": 0.0}
    with pytest.raises(cd.SimulationError, match=r"end of its reach.*load\.y = 0\.42") as told:
        scene.simulate(2.0, motion={**still, "load.y": 0.2})
    end = np.sqrt(0.45**2 - (0.1 + begin[0]) ** 2)
    assert told.value.time == pytest.approx((end - begin[1]) / 0.2, abs=1e-3)
    far = {**still, "load.y": lambda time: (0.6, 0.0, 0.0)}
    with pytest.raises(cd.AssemblyError, match=r"load\.y, is out of reach at 0\.05, 0\.6, where"):
        scene.simulate(1.0, motion=far)


@pytest.mark.parametrize(
    ("given", "asked", "told"),
    [
        ({"actuated": ["m1", "m2", "e1"]}, {}, "e1, m1, m2 are actuated, more than .*; actuate 2"),
        ({"actuated": None}, {}, r"name the joints whose efforts .*actuated=\[\.\.\.\]"),
        (
            {"task": cd.PointTask("load", axes="x")},
            {},
            r"3 degrees .*, and the task 1 row \(load\.x\) beside what is free \(swing\), 1",
        ),
        ({}, {"motion": {"load.x": 0.0}}, r"nothing says how load\.y of the task"),
        ({}, {"motion": {"load.z": 0.0}}, r"load\.z'\]: it is no row .*rows: load\.x, load\.y"),
        ({}, {"position": {"load.x": 0.1}}, "no joint or coordinate 'load.x'"),
        ({}, {"loads": {"load.x": 0.1}}, "load.x"),
        ({}, {"method": "quadrature"}, "does not suit"),
        ({"free": None, "held": {"swing": 0.0}}, {}, r"needs no simulation: scene\.sweep\(pos"),
    ],
)
def test_refused(given: dict[str, object], asked: dict[str, object], told: str) -> None:
    motion = {"load.x": 0.0, "load.y": 0.0}
    with pytest.raises(cd.CardanError, match=told):
        five_bar(**given).simulate(0.1, **{"motion": motion, **asked})


@pytest.mark.slow
def test_a_pose_beside_what_is_free() -> None:
    mechanism = cd.load(hung(machines.arm(), "hand", X, -Z))
    joints = [name for name in mechanism.drivable if name != "swing"]
    near = dict(zip(joints, (0.3, -0.6, 0.9, 0.4, 0.7, -0.2), strict=True))
    scene = cd.Scene(
        mechanism,
        task=cd.PoseTask("hand"),
        actuated=joints,
        free="swing",
        near=near,
        gravity=(0.0, 0.0, -G),
    )
    hand = scene.configuration()
    place = hand.point("hand")
    turned = Rotation.from_matrix(hand.orientation("hand")).as_rotvec()
    start = dict(zip(scene.rows, [*place, *turned], strict=False))
    rates = dict(zip(scene.rows, (1.0, 2.0, 1.5, 3.0, 2.0, 2.5), strict=False))
    motion = {row: round_trip(at - 0.05, 0.05, rates[row], 0.0) for row, at in start.items()}
    found = scene.simulate(0.2, position=0.3, motion=motion)
    agree(scene, found)
    for k, row in enumerate(start):
        asked = [motion[row](time)[0] for time in found.time]
        assert found.task_position[:, k] == pytest.approx(asked, abs=1e-13)
    # Speeds of a rotation are the angular velocity, here against differences of the rotation.
    close = found.evenly(2001)
    turns = Rotation.from_matrix(close.orientation("hand"))
    step = close.time[1]
    spins = (turns[2:] * turns[:-2].inv()).as_rotvec() / (2.0 * step)
    assert close.task_speed[1:-1, 3:] == pytest.approx(spins, abs=1e-6)
    gains = (close.task_speed[2:] - close.task_speed[:-2]) / (2.0 * step)
    assert close.task_acceleration[1:-1] == pytest.approx(gains, abs=1e-6)


def test_names_of_coordinates_begin_where_the_scene_does() -> None:
    scene = crane(task="travel", near={"travel": 0.7})
    found = scene.simulate(0.1, position=0.2, motion={"travel": 0.5})
    assert found.task_position == pytest.approx(0.7 + 0.5 * found.time, abs=1e-15)
    agree(scene, found)


def test_it_is_a_trajectory() -> None:
    scene = five_bar(elements=[cd.JointSpring("swing", 0.1, damping=0.01)])
    asked = {"position": 0.5, "motion": CIRCLE}

    def damped(time: float, position: dict[str, float], speed: dict[str, float]) -> float:
        return -0.02 * speed["swing"]

    found = scene.simulate(
        0.6, **asked, loads={"swing": damped}, events=lambda time, position, _: position["swing"]
    )
    assert found.events
    agree(scene.replace(loads={"swing": -0.02 * found.motion.velocity("swing")}), found)
    inside = found.at([0.1, 0.2])
    np.testing.assert_array_equal(
        inside.to_dataframe()["load.x.task_position"], inside.task_position[:, 0]
    )
    assert inside.task_position[:, 0] == pytest.approx(
        [CIRCLE["load.x"](time)[0] for time in (0.1, 0.2)], abs=1e-14
    )
    short = scene.simulate(0.1, motion={"load.x": 0.1, "load.y": 0.2})
    again = pickle.loads(pickle.dumps(short))
    np.testing.assert_array_equal(again.actuated_effort["m1"], short.actuated_effort["m1"])
    np.testing.assert_array_equal(again.task_speed, short.task_speed)
    # What follows the task counts from where the scene starts, and is nobody's business.
    with pytest.raises(cd.CardanError, match=r"load\.x"):
        scene.simulate(0.1, **asked, events=lambda time, position, _: position["load.x"])


def test_figures_of_a_task_tell_of_the_task() -> None:
    sweep = five_bar(free=None, held={"swing": 0.0}).sweep([[0.0, 0.26], [0.0, 0.3], [0.0, 0.31]])
    figure = sweep.plot("pin")
    assert figure.axes[0].get_title() == "five_bar: load.y 260 … 310 mm"
    assert figure.axes[-1].get_xlabel() == "load.y [mm]"
    assert sweep.plot("condition").axes[0].get_xlabel() == "load.y [mm]"


def test_functions_that_cannot_be_pickled_stay_behind() -> None:
    """A copy knows what it was asked and what happens at its times, and says what it does not."""

    def pushed(time: float) -> tuple[float, float, float]:
        return 0.5 * time**2, time, 1.0

    motion = {"travel": pushed}
    for scene in crane(task="travel"), crane(task=None, actuated=None, drive="travel"):
        found = scene.simulate(0.3, motion=motion)
        assert found.energy_residual < 1e-9
        again = pickle.loads(pickle.dumps(found))
        assert again.energy_residual == found.energy_residual
        for name in "position", "drive_effort", "time":
            assert np.array_equal(getattr(again, name), getattr(found, name))
        with pytest.raises(cd.ArgumentError, match=r"motion\['travel'\] is a function that cannot"):
            again.at([0.1]).drive_effort  # noqa: B018
        fresh = pickle.loads(pickle.dumps(scene.simulate(0.3, motion=motion)))
        with pytest.raises(cd.ArgumentError, match="ask before it is copied"):
            fresh.energy_residual  # noqa: B018


def test_scene_draws_the_path_that_a_simulated_task_leads() -> None:
    pytest.importorskip("meshcat", reason="the page has a scene")
    found = five_bar().simulate(0.3, position=0.3, speed=-1.0, motion=CIRCLE)
    assert found.led_points.keys() == swept_again(five_bar(), found).led_points.keys()
    assert "path of load" in cd.view(found).html
