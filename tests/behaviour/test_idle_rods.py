"""Rods between two balls: nobody drives their spins, and nothing else feels them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pinocchio
import pytest
from testkit import task_machines as machines
from testkit.ball_rods import ALONG, LINE, WAYS, as_a_floating_rod, as_balls, link

import cardan_dyn as cd
from cardan_dyn.core.kinematics.closing.group_solver import GroupSolver

pytestmark = pytest.mark.usefixtures("loaded_once")

POSITIONS = np.linspace(-1.0, 1.0, 21)
OPTIONS = {"drive": "a", "loads": {"d": -3.0}, "gravity": [0.0, 0.0, -9.81]}
ENDS = {
    "balls": ("b", "c"),
    "floating": ("e", "c", "b"),
    "hinges": ("b3", "b2", "b1", "c1", "c2", "c3"),
}


@pytest.fixture(scope="module")
def mechanisms() -> dict[str, cd.Mechanism]:
    return {way: cd.load(text()) for way, text in WAYS.items()}


@pytest.fixture(scope="module")
def turned(mechanisms: dict[str, cd.Mechanism]) -> Callable[[str], cd.Sweep]:
    """Sweeps each way of writing when it is first asked for: all of them take long to follow."""
    return cache(
        lambda way: cd.Scene(mechanisms[way], **OPTIONS).sweep(
            POSITIONS, speed=5.0, acceleration=2.0
        )
    )


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
def test_rods_need_no_drive(way: str, turned: Callable[[str], cd.Sweep]) -> None:
    turn = turned(way)
    assert turn.balance_residual < 1e-13
    assert turn.loop_residual < 1e-13
    assert turn.rate_residual < 1e-13
    assert turn.power_residual < 1e-13
    (rod,) = turn.idle_rods
    assert sorted(rod) == sorted(ENDS[way])
    assert all(np.all(turn[name].unique) for name in ("a", "d"))


@pytest.mark.slow
@pytest.mark.parametrize("way", ["floating", "hinges"])
def test_all_ways_of_writing_give_the_same_wrenches(
    way: str, turned: Callable[[str], cd.Sweep]
) -> None:
    expected, found = turned("balls"), turned(way)
    np.testing.assert_allclose(found.drive_effort, expected.drive_effort, rtol=1e-11)
    for name in ("a", "d"):
        for quantity in ("force", "moment"):
            np.testing.assert_allclose(
                getattr(found.wrench(name, "world"), quantity),
                getattr(expected.wrench(name, "world"), quantity),
                atol=1e-10,
            )
        np.testing.assert_allclose(
            found.motion.position(name), expected.motion.position(name), atol=1e-12
        )


@pytest.mark.parametrize(
    ("way", "ends"),
    [("balls", ("b", "c")), pytest.param("hinges", ("b3", "c1"), marks=pytest.mark.slow)],
)
def test_no_moment_acts_about_the_line(
    way: str, ends: tuple[str, str], turned: Callable[[str], cd.Sweep]
) -> None:
    """Balls pass no moment; three hinges in a row pass none either."""
    for name in ends:
        assert np.max(np.abs(turned(way)[name].moment)) < 1e-11


def test_rates_of_rods_have_no_part_along_their_lines(turned: Callable[[str], cd.Sweep]) -> None:
    turn = turned("balls")
    rotation, position = turn.rotation("b"), turn.origin("b")
    line = rotation @ ALONG
    ends = turn.motion.velocity("b")
    # The ball's rates are the rod's relative to the crank, in the rod's axes.
    spin = np.einsum("nij,nj->ni", rotation, ends)
    spin[:, 2] += turn.motion.velocity("a")
    assert np.max(np.abs(np.sum(spin * line, axis=1))) < 1e-12
    assert np.max(np.linalg.norm(spin, axis=1)) > 1.0
    np.testing.assert_allclose(np.linalg.norm(position, axis=1), 0.3, rtol=1e-12)


@pytest.mark.parametrize("way", WAYS)
def test_rods_are_turned_by_the_least_rotation_from_zero(
    way: str, mechanisms: dict[str, cd.Mechanism]
) -> None:
    """The axis of a least rotation is normal to the line, before and after it."""
    mechanism = mechanisms[way]
    rod, _ = mechanism.links["rod"]
    data = mechanism.model.createData()
    q_zero = mechanism.coordinates.configuration(mechanism.zero[None])[0]
    pinocchio.forwardKinematics(mechanism.model, data, q_zero)
    at_zero = data.oMi[rod].copy()
    motion = cd.Scene(mechanism, drive="a").sweep(np.linspace(-9.0, 9.0, 40)).motion
    line = at_zero.rotation.T @ LINE
    for q in motion.q:
        pinocchio.forwardKinematics(mechanism.model, data, q)
        turn = data.oMi[rod].rotation @ at_zero.rotation.T
        axis = pinocchio.log3(turn)
        for rotation in (at_zero.rotation, data.oMi[rod].rotation):
            assert abs(axis @ (rotation @ line)) < 1e-12


@pytest.mark.parametrize("way", WAYS)
def test_rods_settle_to_rounding_in_calls_of_one_position(
    way: str, mechanisms: dict[str, cd.Mechanism]
) -> None:
    """The last Newton step of a guess that is good already turns the rod's line, and so the rod."""
    mechanism = mechanisms[way]
    rod, _ = mechanism.links["rod"]
    data = mechanism.model.createData()

    def rotation(q: np.ndarray) -> np.ndarray:
        pinocchio.forwardKinematics(mechanism.model, data, q)
        return np.array(data.oMi[rod].rotation)

    scene = cd.Scene(mechanism, drive="a")
    positions = np.random.default_rng(1).uniform(-9.0, 9.0, 200)
    together = scene.sweep(positions).motion.q
    for position, q in zip(positions, together, strict=True):
        alone = scene.sweep([position]).motion.q[0]
        assert np.max(np.abs(rotation(alone) - rotation(q))) < 5e-13


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
def test_rods_do_not_remember_the_way(way: str) -> None:
    """Other positions before, another order, whole turns: nothing of a result depends on them."""
    mechanism = cd.load(WAYS[way]())
    positions = np.linspace(0.2, 6.0, 15)
    rates = {"speed": 3.0, "acceleration": 1.0}
    expected = cd.Scene(mechanism, **OPTIONS).sweep(positions, **rates)
    scene = cd.Scene(mechanism, **OPTIONS)
    scene.sweep([-30.0, 14.0])
    backwards = scene.sweep(positions[::-1], **rates)
    turned = scene.sweep(positions + 20.0 * np.pi, **rates)
    for joint in mechanism:
        size = 1.0 + np.max(np.abs(expected[joint].force)) + np.max(np.abs(expected[joint].moment))
        for part in ("force", "moment"):
            wanted = getattr(expected[joint], part)
            again, later = getattr(backwards[joint], part)[::-1], getattr(turned[joint], part)
            np.testing.assert_allclose(again, wanted, rtol=0.0, atol=1e-11 * size)
            np.testing.assert_allclose(later, wanted, rtol=0.0, atol=1e-11 * size)


@pytest.mark.slow
def test_weights_beside_the_line_turn_a_rod() -> None:
    """A centre of mass a little beside the line: gravity turns the rod, no moment holds it."""
    beside = 0.5 * ALONG + np.array([0.0, 0.01, 0.0])
    scene = cd.Scene(cd.load(as_balls(centre=beside)), **OPTIONS)
    turn = scene.sweep(POSITIONS, speed=2.0)
    assert turn.balance_residual < 1e-13
    assert np.max(np.abs(turn["b"].moment)) < 1e-11
    still = cd.Scene(cd.load(as_balls()), **OPTIONS).sweep(POSITIONS, speed=2.0)
    spins = turn.motion.acceleration("b") - still.motion.acceleration("b")
    assert np.max(np.abs(spins)) > 0.1


def test_bodies_that_hang_beside_their_line_have_to_be_driven() -> None:
    beside = 0.5 * ALONG + np.array([0.0, 0.3, 0.0])
    with pytest.raises(cd.MobilityError) as caught:
        cd.Scene(cd.load(as_balls(centre=beside)), drive="a")
    assert caught.value.mobility == 2


def test_rods_are_listed_where_a_user_looks() -> None:
    mechanism = cd.load(as_balls())
    report = cd.describe(mechanism)
    assert report.idle_rods == [("b", "c")]
    assert "idle rod at b – c: it may spin about its line and needs no drive" in str(report)
    plan = cd.Scene(mechanism, drive="a").plan()
    assert any("1 idle rod(s), which do not turn about their lines" in step for step in plan.steps)


@pytest.mark.parametrize("way", WAYS)
def test_responses_hold_for_mechanisms_with_rods(
    way: str, mechanisms: dict[str, cd.Mechanism]
) -> None:
    scene = cd.Scene(mechanisms[way], **OPTIONS)
    response = scene.response()
    assert response.error < 1e-12
    positions = np.linspace(-5.0, 9.0, 33)
    exact = scene.sweep(positions, speed=4.0, acceleration=2.0)
    fast = response.sweep(positions, speed=4.0, acceleration=2.0)
    for joint in scene.mechanism:
        size = 1.0 + np.max(np.abs(exact[joint].force)) + np.max(np.abs(exact[joint].moment))
        for part in ("force", "moment"):
            difference = getattr(exact[joint], part) - getattr(fast[joint], part)
            assert np.max(np.abs(difference)) < 1e-11 * size


def hexapod() -> str:
    """Six legs with balls at both ends carry a platform: six idle rods, six drives."""
    # Feet and seats in pairs: on similar hexagons the platform would be singular everywhere.
    thirds = 2.0 * np.pi / 3.0 * np.arange(3)
    feet = np.stack([thirds - 0.15, thirds + 0.15], axis=1).ravel()
    seats = np.stack([thirds - 0.9, thirds + 0.9], axis=1).ravel()
    foot = np.stack([np.cos(feet), np.sin(feet), np.zeros(6)], axis=1)
    seat = 0.5 * np.stack([np.cos(seats), np.sin(seats), np.zeros(6)], axis=1)
    top = np.array([0.05, -0.03, 1.0])
    body = (
        '<inertial><mass value="{mass}"/><inertia ixx="{i}" iyy="{i}" izz="{i}" ixy="0" ixz="0" '
        'iyz="0"/></inertial>'
    )
    text = f'<robot name="hexapod"><link name="ground"/><link name="top">{body.format(mass=5, i=1)}'
    text += (
        '</link><joint name="free" type="floating"><parent link="ground"/><child link="top"/>'
        f'<origin xyz="{top[0]} {top[1]} {top[2]}"/></joint>'
    )
    for leg, (low, high) in enumerate(zip(foot, seat, strict=True)):
        along = top + high - low
        words, end = (" ".join(repr(float(v)) for v in w) for w in (low, along))
        direction = " ".join(repr(float(v)) for v in along / np.linalg.norm(along))
        text += f'<link name="low_{leg}">{body.format(mass=0.5, i=0.01)}</link>'
        text += f'<link name="up_{leg}">{body.format(mass=0.3, i=0.01)}</link>'
        text += (
            f'<joint name="ball_{leg}" type="spherical"><parent link="ground"/>'
            f'<child link="low_{leg}"/><origin xyz="{words}"/></joint>'
            f'<joint name="leg_{leg}" type="prismatic"><parent link="low_{leg}"/>'
            f'<child link="up_{leg}"/><axis xyz="{direction}"/></joint>'
            f'<loop name="seat_{leg}" type="spherical"><predecessor link="up_{leg}">'
            f'<origin xyz="{end}"/></predecessor><successor link="top"><origin xyz="'
            f'{" ".join(repr(float(v)) for v in high)}"/></successor></loop>'
        )
    return text + "</robot>"


def test_rods_in_a_loop_of_several_drives() -> None:
    text = hexapod()
    mechanism = cd.load(text)
    drives = [f"leg_{leg}" for leg in range(6)]
    scene = cd.Scene(mechanism, drive=drives, gravity=[0.0, 0.0, -9.81])
    rng = np.random.default_rng(2)
    turn = scene.sweep(0.05 * rng.uniform(-1, 1, (20, 6)), rng.uniform(-1, 1, (20, 6)))
    assert len(turn.idle_rods) == 6
    # While the legs are driven, as the author says, what is described is what a scene does.
    driven = cd.load(text.replace('"prismatic">', '"prismatic" independent="true">'))
    report = cd.describe(driven)
    assert len(report.idle_rods) == 6
    assert report.mobility - len(report.idle_rods) == len(drives)
    assert turn.balance_residual < 1e-12
    assert turn.loop_residual < 1e-12
    for leg in range(6):
        assert np.max(np.abs(turn[f"ball_{leg}"].moment)) < 1e-10


def test_rods_are_solved_like_other_joints(monkeypatch: pytest.MonkeyPatch) -> None:
    """Their spins are equations: no singular values, and as many evaluations as without rods."""
    evaluations, decompositions = [], []
    evaluate, svd = GroupSolver.evaluate, np.linalg.svd

    def counted(*arguments: object, **options: object) -> object:
        evaluations.append(1)
        return evaluate(*arguments, **options)  # type: ignore[arg-type]

    def decomposed(*arguments: object, **options: object) -> object:
        decompositions.append(1)
        return svd(*arguments, **options)  # type: ignore[call-overload]

    lengths = 0.05 * np.random.default_rng(2).uniform(-1.0, 1.0, (40, 6))
    counts = []
    for mechanism in (cd.load(hexapod()), cd.load("stewart_platform")):
        drives = [name for name in mechanism.joint_names if name.startswith("leg_")]
        scene = cd.Scene(mechanism, drive=drives)
        scene.sweep(lengths)
        with monkeypatch.context() as counting:
            counting.setattr(GroupSolver, "evaluate", counted)
            counting.setattr(np.linalg, "svd", decomposed)
            evaluations.clear()
            scene.sweep(0.9 * lengths)
        counts.append(len(evaluations))
    assert not decompositions
    assert counts[0] <= counts[1] + 2


def on_a_turntable(text: str) -> str:
    """Return a description whose ground turns about an axis askew."""
    turntable = (
        '<link name="world_"/><joint name="table" type="continuous"><parent link="world_"/>'
        '<child link="ground"/><origin xyz="0.2 0.1 0"/><axis xyz="0 1 0.4"/></joint></robot>'
    )
    return text.replace("</robot>", turntable)


@pytest.mark.slow
def test_rods_on_a_moving_base_are_the_same_in_all_ways_of_writing() -> None:
    """Also a floating rod that hangs from the world in the tree, while its ends do not."""
    efforts = []
    floating = on_a_turntable(as_a_floating_rod())
    in_the_world = floating.replace(
        '<parent link="ground"/><child link="rod"/><origin xyz="0.3 0 0"/>',
        '<parent link="world_"/><child link="rod"/><origin xyz="0.5 0.1 0"/>',
    )
    assert in_the_world != floating
    for text in (*(on_a_turntable(WAYS[way]()) for way in WAYS), in_the_world):
        scene = cd.Scene(cd.load(text), drive=["a", "table"], gravity=[0.0, 0.0, -9.81])
        turn = scene.sweep([[0.3, 0.2], [0.7, -0.4]], speed=[4.0, 3.0], acceleration=[1.0, 2.0])
        assert turn.balance_residual < 1e-13
        efforts.append(turn.drive_effort)
    for effort in efforts[1:]:
        np.testing.assert_allclose(effort, efforts[0], rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("way", WAYS)
def test_loads_about_its_line_turn_a_rod(way: str, mechanisms: dict[str, cd.Mechanism]) -> None:
    """Also where nothing else moves: the moment about the line over the inertia about it."""
    moment = 0.7 * LINE
    scene = cd.Scene(mechanisms[way], drive="a", loads={"rod": [0.0, 0.0, 0.0, *moment]})
    turn = scene.sweep([0.0, 0.4])
    assert turn.balance_residual < 1e-12
    assert np.max(np.abs(turn.motion.a)) > 1.0
    loaded = scene.replace(gravity=(0.0, 0.0, -1e-30)).sweep([0.0, 0.4])
    np.testing.assert_allclose(turn.drive_effort, loaded.drive_effort, rtol=0.0, atol=1e-12)


@pytest.mark.slow
def test_loads_about_the_line_of_a_massless_rod_are_refused() -> None:
    text = as_balls()
    first = text.index('<link name="rod"')
    last = text.index("</link>", first)
    mechanism = cd.load(text[:first] + '<link name="rod">' + text[last:])
    scene = cd.Scene(mechanism, drive="a", loads={"rod": [0.0, 0.0, 0.0, 0.0, 1.2, 0.5]})
    with pytest.raises(cd.MobilityError, match=r"idle rod without inertia \(b.x, .*c.z\), which"):
        scene.sweep([0.3])
    through = scene.replace(loads={"rod": [1.0, 2.0, 3.0, 0.0, 0.0, 0.0], "d": 3.0})
    assert through.sweep([0.3]).balance_residual < 1e-13


@pytest.mark.slow
def test_a_rod_in_an_open_chain_swings() -> None:
    """Between two balls, but on no loop: a scene wants its joints driven, and so it is said."""
    hanging = (
        link("upper", 1.0, "0 0 -0.2", np.diag([0.01, 0.01, 0.001]))
        + link("lower", 1.0, "0 0 -0.2", np.diag([0.01, 0.01, 0.001]))
        + '<joint name="top" type="spherical"><parent link="ground"/><child link="upper"/></joint>'
        + '<joint name="middle" type="spherical"><parent link="upper"/><child link="lower"/>'
        + '<origin xyz="0 0 -0.4"/></joint></robot>'
    )
    mechanism = cd.load(as_balls().replace("</robot>", hanging))
    report = cd.describe(mechanism)
    assert report.idle_rods == [("b", "c")]
    # A drive, the spin of the rod, and three coordinates of each ball.
    assert (report.mobility, "mobility 8, 7 without idle rods" in str(report)) == (8, True)
    with pytest.raises(cd.MobilityError, match="mobility 7: nothing decides the motion of"):
        cd.Scene(mechanism, drive="a")
    turns = [f"{name}.{axis}" for name in ("top", "middle") for axis in "xyz"]
    held = dict.fromkeys(turns, 0.0)
    scene = cd.Scene(mechanism, drive="a", held=held, gravity=(0.0, 0.0, -9.81))
    assert scene.sweep([0.0, 0.1]).balance_residual < 1e-13


def test_telescopes_that_follow_spin_as_those_that_drive() -> None:
    """Legs with mass carry loads while six slides and hinges move the platform, and drive it."""
    text, z = machines.stewart(), machines.Z
    for k in range(6):
        for half, mass, at in ("lower", 3.0 + k, 0.2 * z), ("upper", 2.0, -0.15 * z):
            inertia = mass * np.array([0.015, 0.015, 0.0006])
            heavy = machines.link(f"{half}_{k}", mass, at, inertia)
            text = text.replace(machines.link(f"{half}_{k}"), heavy)
    links, names = ["base", *(f"c{k}" for k in range(5))], [f"q{k}" for k in range(6)]
    chain = [machines.link(name) for name in links[1:]]
    for k, (name, axis) in enumerate(zip(names[:5], [*np.eye(3), *np.eye(3)], strict=False)):
        kind, place = "continuous" if k > 2 else "prismatic", machines.RAISED * (k == 0)
        chain.append(machines.joint(name, kind, *links[k : k + 2], place, axis))
    ends = machines.HERE, machines.HERE
    chain.append(machines.loop("q5", "continuous", "c4 platform", ends, z))
    mechanism = cd.load(text.replace("</robot>", "".join(chain) + "</robot>"))
    rng = np.random.default_rng(0)
    position = rng.uniform(-0.1, 0.1, (5, 6))
    loads = dict(zip(machines.LEGS, 100.0 * rng.normal(size=6), strict=True))
    gravity = (0.0, 0.0, -9.81)
    following = cd.Scene(mechanism, drive=names, gravity=gravity, loads=loads).sweep(
        position, *rng.normal(size=(2, 5, 6))
    )
    assert len(following.idle_rods) == 6
    motion = following.motion
    driving = cd.Scene(mechanism, drive=machines.LEGS, gravity=gravity).sweep(
        *(
            np.stack([read(leg) for leg in machines.LEGS], axis=-1)
            for read in (motion.position, motion.velocity, motion.acceleration)
        ),
        loads=dict(zip(names, following.drive_effort.T, strict=True)),
    )
    expected = np.broadcast_to(list(loads.values()), (5, 6))
    np.testing.assert_allclose(driving.drive_effort, expected, rtol=0.0, atol=1e-11)
    for name in mechanism.joints:
        for found, other in zip(driving[name].force, following[name].force, strict=True):
            np.testing.assert_allclose(found, other, rtol=0.0, atol=1e-10)
    spins = [sweep.motion.acceleration("foot_3") for sweep in (driving, following)]
    np.testing.assert_allclose(*spins, rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("mass", [0.0, 1.0])
def test_a_rod_spins_once_however_its_balls_are_written(mass: float) -> None:
    """Two hinges of one ball and that along a massless rod, of the other, meet in a point too."""
    upper = machines.link("upper_0", mass, -0.1 * machines.Z, 0.01 * np.ones(3))
    platform = cd.load(machines.stewart().replace('<link name="upper_0"/>', upper))
    balls = cd.Scene(platform, drive=machines.LEGS, gravity=(1.0, 2.0, -9.81))
    hinges = balls.replace(near={"foot_0.x": 0.0, "head_0.x": 0.0})
    lengths, speeds = [0.03, -0.02, 0.01, 0.02, -0.01, 0.0], [0.1, -0.2, 0.3, 0.1, 0.2, -0.1]
    expected, found = (scene.sweep(lengths, speeds) for scene in (balls, hinges))
    assert found.idle_rods == expected.idle_rods
    assert len(found.idle_rods) == 6
    np.testing.assert_allclose(found.drive_effort, expected.drive_effort, rtol=1e-11)
    np.testing.assert_allclose(found["foot_1"].force, expected["foot_1"].force, atol=1e-10)


def test_spins_without_inertia_are_no_motion_in_time() -> None:
    """Nothing says how they spin: the rod is named, and with inertia it is simulated."""
    text, inertia = machines.stewart(), '<inertia ixx="0.01" iyy="0.01" izz="0.001"/>'
    for k in range(6):
        if k in (3, 5):
            scene = cd.Scene(cd.load(text), free=machines.LEGS, gravity=(0.0, 0.0, -9.81))
            with pytest.raises(cd.ModelError, match=rf"rod between foot_{k}, head_{k} may spin"):
                scene.simulate(0.01)
        massive = f'<link name="lower_{k}"><inertial><mass value="1"/>{inertia}</inertial></link>'
        text = text.replace(f'<link name="lower_{k}"/>', massive)
    scene = cd.Scene(cd.load(text), free=machines.LEGS, gravity=(0.0, 0.0, -9.81))
    assert scene.simulate(0.01).effort_residual < 1e-11
