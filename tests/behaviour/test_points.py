"""Points of links: where they are and how they move, against other ways of finding that."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pinocchio as pin
import pytest
from testkit import claims
from testkit.compound_joints import Z, body, joint, loop, robot
from testkit.drive_lines import two_lines
from testkit.mixed_chain import link, rows

import cardan_dyn as cd
from cardan_dyn.core.mechanism.frames import Frames
from cardan_dyn.core.results.point_motion import PointMotion

pytestmark = pytest.mark.usefixtures("loaded_once")

TURN = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)
POINT = np.array([0.13, -0.21, 0.34])
QUANTITIES = ("position", "velocity", "acceleration", "angular_velocity", "angular_acceleration")


def universal(**options: Any) -> cd.Scene:
    given = {"drive": "bearing_in", "held": {"joint_angle": 0.5}}
    return cd.Scene(cd.load("universal_joint"), **{**given, **options})


def four_bar(**options: Any) -> cd.Scene:
    return cd.Scene(cd.load("four_bar"), **{"drive": "crank_bearing", **options})


def slider_crank() -> cd.Scene:
    return cd.Scene(cd.load("slider_crank"), drive="crank_bearing")


def by_pinocchio(
    mechanism: cd.Mechanism,
    name: str,
    xyz: np.ndarray,
    state: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> list[np.ndarray]:
    """Return rotations and what `QUANTITIES` names of a link's point, by Pinocchio's frames."""
    model = mechanism.model.copy()
    index, placement = mechanism.links[name]
    placement = placement * pin.SE3(np.eye(3), xyz)
    frame = model.addFrame(pin.Frame("point", index, placement, pin.FrameType.OP_FRAME), False)
    data, aligned = model.createData(), pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    found = []
    for q, v, a in zip(*state, strict=True):
        pin.forwardKinematics(model, data, q, v, a)
        placed = pin.updateFramePlacement(model, data, frame)
        velocity = pin.getFrameVelocity(model, data, frame, aligned)
        acceleration = pin.getFrameClassicalAcceleration(model, data, frame, aligned)
        found.append(
            [
                placed.rotation.copy(),
                placed.translation.copy(),
                velocity.linear,
                acceleration.linear,
                velocity.angular,
                acceleration.angular,
            ]
        )
    return [np.array(values) for values in zip(*found, strict=True)]


def check_all_links(turn: cd.Sweep | cd.Trajectory) -> None:
    motion = turn.motion
    state = motion.q, motion.v, motion.a
    for name in turn.mechanism.links:
        rotation, *expected = by_pinocchio(turn.mechanism, name, POINT, state)
        found = turn.point(name, POINT)
        np.testing.assert_allclose(turn.orientation(name), rotation, atol=3e-15)
        for quantity, values in zip(QUANTITIES, expected, strict=True):
            scale = 1.0 + np.max(np.abs(values))
            np.testing.assert_allclose(getattr(found, quantity), values, atol=3e-14 * scale)


class RandomChain:
    """A tree with a joint of each type about oblique axes, at random coordinates and rates."""

    TYPES = (
        "continuous",
        "prismatic",
        "planar",
        "cylindrical",
        "spherical",
        "universal",
        "floating",
    )

    def __init__(self, order: tuple[int, ...]) -> None:
        text, parent = '<robot name="chain"><link name="base"/>', "base"
        for kind in (self.TYPES[index] for index in order):
            axis = "0 0.6 0.8" if kind == "universal" else "0.36 0.48 0.8"
            element = (
                f'<joint name="{kind}" type="{kind}"><parent link="{parent}"/>'
                f'<child link="{kind}_link"/><origin xyz="0.3 -0.2 0.5" rpy="0.3 -0.2 0.5"/>'
                f'<axis xyz="{axis}"/>'
            )
            second = '<axis2 xyz="1 0 0"/>' if kind == "universal" else ""
            text += link(f"{kind}_link", 1.0) + element + second + "</joint>"
            parent = f"{kind}_link"
        self.mechanism = cd.load(text + "</robot>")
        self.joint_coordinates = rows(self.mechanism, 4, seed=sum(order))
        rng, nv = np.random.default_rng(order[0]), self.mechanism.model.nv
        self.joint_velocities = rng.normal(size=(4, nv))
        self.joint_accelerations = rng.normal(size=(4, nv))
        self.shape = (2, 2)


@pytest.mark.parametrize("order", [(0, 1, 2, 3, 4, 5, 6), (6, 5, 4, 3, 2, 1, 0), (4, 2, 6, 0, 1)])
def test_trees_of_every_joint_type_move_as_pinocchio_says(order: tuple[int, ...]) -> None:
    chain = RandomChain(order)
    q = chain.mechanism.coordinates.configuration(chain.joint_coordinates)
    state = q, chain.joint_velocities, chain.joint_accelerations
    for name in chain.mechanism.links:
        rotation, *expected = by_pinocchio(chain.mechanism, name, POINT, state)
        found = PointMotion(chain, name, POINT)  # type: ignore[arg-type]
        np.testing.assert_allclose(found.orientation.reshape(4, 3, 3), rotation, atol=3e-15)
        for quantity, values in zip(QUANTITIES, expected, strict=True):
            scale = 1.0 + np.max(np.abs(values))
            assert getattr(found, quantity).shape == (2, 2, 3)
            np.testing.assert_allclose(
                getattr(found, quantity).reshape(4, 3), values, atol=1e-14 * scale
            )


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("slider_crank", {"drive": "crank_bearing"}),
        ("needle_drive", {"drive": "main_shaft"}),
        ("universal_joint", {"drive": "bearing_in", "held": {"joint_angle": 0.5}}),
        ("ring_joint", {"drive": "bearing_in", "held": {"joint_angle": 0.3}}),
    ],
)
def test_every_link_of_a_closed_chain_moves_as_pinocchio_says_of_its_tree(
    name: str, options: dict[str, Any]
) -> None:
    scene = cd.Scene(cd.load(name), **options)
    check_all_links(scene.sweep(TURN[::8], speed=3.0, acceleration=-7.0))


@pytest.mark.parametrize("scene", [claims.coupled_wheels, claims.linkages_on_arms, claims.spatial])
def test_couplings_arms_and_balls(scene: Callable[[], cd.Scene]) -> None:
    made = scene()
    where = claims.positions(made)[:5]
    rates = np.arange(1.0, 1.0 + len(made.drives))
    if len(made.drives) == 1:
        where, rates = where[:, 0], rates[0]
    check_all_links(made.sweep(where, speed=rates, acceleration=-rates))


def derivative(values: np.ndarray) -> np.ndarray:
    """Return the derivative over the angle of values over a whole turn in even steps."""
    count = len(values)
    waves = np.fft.fftfreq(count, 1.0 / count)
    waves[count // 2] = 0.0
    factors = (1j * waves).reshape(-1, *[1] * (values.ndim - 1))
    return np.fft.ifft(factors * np.fft.fft(values, axis=0), axis=0).real


@pytest.mark.parametrize(
    ("made", "name"),
    [
        (four_bar, "coupler"),
        (slider_crank, "rod"),
        (universal, "cross"),
        (universal, "shaft_out"),
    ],
)
def test_rates_are_derivatives_of_positions(made: Callable[[], cd.Scene], name: str) -> None:
    """Fourier series of the positions alone, differentiated."""
    scene = made()
    speed, acceleration = 3.0, -5.0
    turn = scene.sweep(TURN, speed=speed, acceleration=acceleration)
    point = turn.point(name, POINT)
    first = derivative(point.position)
    second = derivative(first)
    np.testing.assert_allclose(point.ratio(), first, atol=1e-11)
    np.testing.assert_allclose(point.velocity, first * speed, atol=3e-11)
    expected = second * speed**2 + first * acceleration
    np.testing.assert_allclose(point.acceleration, expected, atol=1e-8)
    turning = derivative(point.orientation)
    spin = speed * turning @ point.orientation.transpose(0, 2, 1)
    vectors = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1)
    np.testing.assert_allclose(point.angular_velocity, vectors, atol=1e-10)
    spin_rate = derivative(vectors) * speed + vectors / speed * acceleration
    np.testing.assert_allclose(point.angular_acceleration, spin_rate, atol=1e-8)


def test_the_coupler_curve_of_a_four_bar_is_that_of_its_closed_form() -> None:
    """Half angles of the loop equation, differentiated with fifty digits."""
    crank, coupler, rocker, frame = (mpmath.mpf(text) for text in ("0.08", "0.4", "0.25", "0.47"))
    tip = mpmath.mpc("0.13", "-0.21")
    omega, alpha = 3, -5

    def curve(phi: Any) -> Any:
        pin_at = crank * mpmath.expj(phi)
        across = frame - pin_at
        length = abs(across)
        inner = (coupler**2 + length**2 - rocker**2) / (2 * coupler * length)
        return pin_at + tip * across / length * mpmath.expj(mpmath.acos(inner))

    angles = [0.0, 0.7, 2.5, 4.0]
    turn = four_bar().sweep(angles, speed=float(omega), acceleration=float(alpha))
    position, velocity, acceleration = turn.point("coupler", (0.13, -0.21, 0.0))
    with mpmath.workdps(50):
        for index, angle in enumerate(angles):
            values = [mpmath.diff(curve, mpmath.mpf(angle), order) for order in range(3)]
            rates = values[1] * omega, values[2] * omega**2 + values[1] * alpha
            for found, expected in zip(
                (position, velocity, acceleration), (values[0], *rates), strict=True
            ):
                exact = [float(expected.real), float(expected.imag), found[index, 2]]
                scale = max(1e-2, float(abs(expected)))
                np.testing.assert_allclose(found[index], exact, atol=2e-14 * scale)
                assert abs(found[index, 2]) < 1e-15


FIVE_BAR = f"""<robot name="five_bar"><link name="base"/>{
    "".join(f'<link name="{name}"/>' for name in ("left", "right", "left_rod", "right_rod"))
}
  <joint name="q1" type="continuous"><parent link="base"/><child link="left"/>
    <origin xyz="-0.1 0 0"/><axis xyz="0 0 1"/></joint>
  <joint name="q2" type="continuous"><parent link="base"/><child link="right"/>
    <origin xyz="0.1 0 0"/><axis xyz="0 0 1"/></joint>
  <joint name="elbow_1" type="continuous"><parent link="left"/><child link="left_rod"/>
    <origin xyz="0.2 0 0"/><axis xyz="0 0 1"/></joint>
  <joint name="elbow_2" type="continuous"><parent link="right"/><child link="right_rod"/>
    <origin xyz="0.2 0 0"/><axis xyz="0 0 1"/></joint>
  <loop name="tip" type="revolute"><predecessor link="left_rod"><origin xyz="0.25 0 0"/>
    </predecessor><successor link="right_rod"><origin xyz="0.25 0 0"/></successor>
    <axis xyz="0 0 1"/></loop></robot>"""


@pytest.mark.slow
def test_the_tip_of_a_five_bar_moves_on_the_circle_that_its_drives_were_made_for() -> None:
    """Drives of the inverse problem, differentiated with fifty digits; the tip is on a circle."""

    def drives(t: Any) -> tuple[Any, Any]:
        x = mpmath.mpf("0.05") * mpmath.cos(2 * mpmath.pi * t)
        y = mpmath.mpf("0.28") + mpmath.mpf("0.05") * mpmath.sin(2 * mpmath.pi * t)
        found = []
        for side in (1, -1):
            across = x + side * mpmath.mpf("0.1")
            far = mpmath.sqrt(across**2 + y**2)
            inner = (mpmath.mpf("0.2") ** 2 + far**2 - mpmath.mpf("0.25") ** 2) / (2 * far) * 5
            found.append(mpmath.atan2(y, across) + side * mpmath.acos(inner))
        return found[0], found[1]

    times = (0.0, 0.25, 0.625, 0.875)
    with mpmath.workdps(50):
        position, speed, acceleration = (
            np.array(
                [
                    [
                        float(mpmath.diff(lambda t, k=k: drives(t)[k], mpmath.mpf(time), order))
                        for k in range(2)
                    ]
                    for time in times
                ]
            )
            for order in range(3)
        )
    np.testing.assert_allclose(position[0], [1.9848129005862, 0.715744556202147], rtol=1e-13)
    scene = cd.Scene(
        cd.load(FIVE_BAR), drive=["q1", "q2"], near={"q1": position[0, 0], "q2": position[0, 1]}
    )
    turn = scene.sweep(position, speed, acceleration)
    angle = 2.0 * np.pi * np.array(times)
    out = 0.05 * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    along = 0.05 * np.stack([-np.sin(angle), np.cos(angle), 0.0 * angle], axis=1)
    for name in ("left_rod", "right_rod"):
        tip = turn.point(name, (0.25, 0.0, 0.0))
        np.testing.assert_allclose(tip.position - np.array([0.0, 0.28, 0.0]), out, atol=1e-15)
        np.testing.assert_allclose(tip.velocity, 2.0 * np.pi * along, atol=1e-14)
        np.testing.assert_allclose(tip.acceleration, -((2.0 * np.pi) ** 2) * out, atol=1e-13)


def test_designs_and_grids_keep_their_shape() -> None:
    scene = universal()
    designs = scene.sweep(TURN[:7], speed=2.0, held={"joint_angle": [[0.1], [0.2], [0.3]]})
    point = designs.point("shaft_out", POINT)
    assert point.position.shape == point.velocity.shape == point.acceleration.shape == (3, 7, 3)
    assert point.orientation.shape == (3, 7, 3, 3)
    one = scene.sweep(TURN[:7], speed=2.0, held={"joint_angle": 0.2}).point("shaft_out", POINT)
    for quantity in QUANTITIES:
        np.testing.assert_allclose(
            getattr(point, quantity)[1], getattr(one, quantity), atol=1e-13, rtol=1e-13
        )
    grid = scene.response().sweep(TURN[:7], speed=[[1.0], [2.0]])
    found = grid.point("shaft_out", POINT)
    assert found.velocity.shape == (2, 7, 3)
    np.testing.assert_allclose(2.0 * found.velocity[0], found.velocity[1], atol=1e-12)
    single = scene.sweep(0.3).point("shaft_out")
    assert single.position.shape == (1, 3)


def test_points_move_with_a_base_whose_motion_is_prescribed() -> None:
    names = ["base.x", "base.y", "base.z", "base.turn_x", "base.turn_y", "base.turn_z"]
    mechanism = cd.load(
        robot(
            body("platform", 3.0, "0.05 -0.1 0.2"),
            joint("base", "floating", "ground platform", 'xyz="1 -0.5 0.3" rpy="0.2 0.4 -0.3"'),
            body("crank", 0.5, "0 0.15 0"),
            joint("a", "continuous", "platform crank", "", (Z,)),
            body("coupler", 0.8, "0.4 0.1 0.05"),
            joint("b", "continuous", "crank coupler", 'xyz="0 0.3 0"', (Z,)),
            body("rocker", 0.6, "0 0.4 0"),
            joint("d", "continuous", "platform rocker", 'xyz="1 0 0"', (Z,)),
            loop("c", "continuous", "coupler rocker", ('xyz="1 0.5 0"', 'xyz="0 0.8 0"'), (Z,)),
        )
    )
    scene = cd.Scene(mechanism, drive=[*names, "a"])
    rng = np.random.default_rng(5)
    where, speed, acceleration = rng.uniform(-0.5, 0.5, (3, 4, 7))
    check_all_links(scene.sweep(where, speed, acceleration))


def test_at_rest_points_rest_and_ratios_tell_how_they_would_move() -> None:
    turn, moving = (four_bar().sweep(TURN[:5], speed=speed) for speed in (0.0, 4.0))
    point = turn.point("coupler", POINT)
    for quantity in QUANTITIES[1:]:
        assert not np.any(getattr(point, quantity))
    expected = moving.point("coupler", POINT).velocity
    np.testing.assert_allclose(4.0 * point.ratio("crank_bearing"), expected, atol=1e-14)
    with pytest.raises(cd.ArgumentError, match=r"no drive 'crank'; drives: 0 .crank_bearing."):
        point.ratio("crank")


def test_digits_are_not_lost_far_from_the_origin() -> None:
    """A four-bar a kilometre away: rates do not know, positions have the digits of a kilometre."""
    text = cd.load("four_bar").to_urdf()
    far = text.replace('<robot name="four_bar">', '<robot name="far"><link name="ground"/>', 1)
    far = far.replace(
        "</robot>",
        '<joint name="foot" type="fixed"><parent link="ground"/><child link="base"/>'
        '<origin xyz="1024 -2048 512"/></joint></robot>',
    )
    near = four_bar().sweep(TURN[:5], speed=4.0, acceleration=2.0).point("coupler", POINT)
    away = cd.Scene(cd.load(far), drive="crank_bearing").sweep(TURN[:5], 4.0, 2.0)
    point = away.point("coupler", POINT)
    for quantity in QUANTITIES[1:]:
        np.testing.assert_allclose(
            getattr(point, quantity), getattr(near, quantity), atol=1e-12, rtol=1e-12
        )
    np.testing.assert_allclose(point.position - near.position, [[1024.0, -2048.0, 512.0]] * 5)


FIXED = """<robot name="arm"><link name="base"/><link name="arm"/><link name="hand"/>
  <link name="tool"/>
  <joint name="swing" type="continuous"><parent link="base"/><child link="arm"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="flange" type="fixed"><parent link="arm"/><child link="hand"/>
    <origin xyz="2 0 0" rpy="0 0 1.5707963267948966"/></joint>
  <joint name="tcp" type="fixed"><parent link="hand"/><child link="tool"/>
    <origin xyz="1 0 0"/></joint></robot>"""
SITES = """<mujoco><worldbody><body name="arm"><joint name="swing" axis="0 0 1"/>
  <geom type="sphere" size="0.1"/><site name="tip" pos="2 1 0" euler="0 0 90"/></body>
  </worldbody></mujoco>"""
FRAMES = """<sdf version="1.9"><model name="arm"><link name="arm"><pose>1 0 0 0 0 0</pose></link>
  <joint name="swing" type="continuous"><parent>world</parent><child>arm</child>
  <axis><xyz>0 0 1</xyz></axis></joint>
  <frame name="elbow" attached_to="arm"><pose>2 0 0 0 0 0</pose></frame>
  <frame name="tip" attached_to="elbow"><pose>0 1 0 0 0 1.5707963267948966</pose></frame>
  </model></sdf>"""
QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize("name", ["tool", "tcp"])
def test_what_fixed_joints_join_goes_by_its_own_name(name: str) -> None:
    turn = cd.Scene(cd.load(FIXED), drive="swing").sweep([0.0, np.pi / 2.0], speed=2.0)
    point = turn.point(name, (0.5, 0.0, 0.0))
    np.testing.assert_allclose(point.position, [[2.0, 1.5, 0.0], [-1.5, 2.0, 0.0]], atol=1e-15)
    expected = [[-3.0, 4.0, 0.0], [-4.0, -3.0, 0.0]]
    np.testing.assert_allclose(point.velocity, expected, atol=2e-15)
    np.testing.assert_allclose(point.acceleration, -4.0 * point.position, atol=4e-15)
    np.testing.assert_allclose(turn.orientation(name)[0], QUARTER, atol=1e-15)
    assert not np.any(turn.point("base", (1.0, 2.0, 3.0)).velocity)
    np.testing.assert_array_equal(turn.point("base", (1.0, 2.0, 3.0)).position, [[1, 2, 3]] * 2)


@pytest.mark.parametrize(("text", "base"), [(SITES, 0.0), (FRAMES, 1.0)])
def test_sites_and_frames_of_other_notations_go_by_name(text: str, base: float) -> None:
    turn = cd.Scene(cd.load(text, strict=False), drive="swing").sweep([0.0, np.pi], speed=2.0)
    point = turn.point("tip", (0.0, -1.0, 0.0))
    expected = [[base + 3.0, 1.0, 0.0], [base - 3.0, -1.0, 0.0]]
    np.testing.assert_allclose(point.position, expected, atol=1e-14)
    np.testing.assert_allclose(point.velocity, [[-2.0, 6.0, 0.0], [2.0, -6.0, 0.0]], atol=1e-14)
    np.testing.assert_allclose(turn.orientation("tip")[0], QUARTER, atol=1e-15)


def test_other_names_and_points_are_refused_with_advice() -> None:
    turn = four_bar().sweep(TURN[:3])
    with pytest.raises(cd.ModelError, match=r"no link or frame 'copler'.*did you mean 'coupler'"):
        turn.point("copler")
    with pytest.raises(cd.ModelError, match="'crank_pin' is a joint, between the links 'crank'"):
        turn.point("crank_pin")
    with pytest.raises(cd.ModelError, match="'rocker_pin' is a joint"):
        turn.orientation("rocker_pin")
    with pytest.raises(cd.ModelError, match=r"no link or frame None"):
        turn.point(None)  # type: ignore[arg-type]
    for wrong in ((0.0, 1.0), "coupler", (np.nan, 0.0, 0.0), [[0.0] * 3]):
        with pytest.raises(cd.ArgumentError, match="xyz"):
            turn.point("coupler", wrong)
    with pytest.raises(cd.ImmutableError):
        turn.point("coupler").link = "crank"  # type: ignore[misc]
    with pytest.raises(ValueError, match="read-only"):
        turn.point("coupler").position[0, 0] = 1.0


def test_what_the_outputs_leave_out_is_refused() -> None:
    mechanism = cd.load(two_lines(2))
    scene = cd.Scene(mechanism, drive="bearing_0", outputs=["right_2"])
    turn, whole = (
        item.sweep(TURN[:3], 2.0) for item in (scene, cd.Scene(mechanism, drive="bearing_0"))
    )
    left_out = set()
    for name in mechanism.links:
        expected = whole.point(name, POINT)
        try:
            found = turn.point(name, POINT)
            np.testing.assert_allclose(found.position, expected.position, atol=1e-13)
            np.testing.assert_allclose(found.velocity, expected.velocity, atol=1e-13)
        except cd.ModelError as error:
            assert "leave out what moves" in str(error)
            left_out.add(name.split("_")[0])
    assert left_out == {"left"}


def test_configurations_and_equilibria_tell_where_points_are() -> None:
    scene = four_bar()
    configuration = scene.configuration()
    turn = scene.sweep(0.0)
    point = configuration.point("coupler", POINT)
    assert point.shape == (3,)
    np.testing.assert_allclose(point, turn.point("coupler", POINT).position[0], atol=1e-14)
    expected = turn.orientation("coupler")[0]
    np.testing.assert_allclose(configuration.orientation("coupler"), expected, atol=1e-14)
    with pytest.raises(cd.ModelError, match="did you mean 'coupler'"):
        configuration.point("couplr")
    hanging = cd.Scene(
        cd.load(FIXED.replace('<link name="tool"/>', TOOL)), free="swing", gravity=[9.81, 0, 0]
    )
    rest = hanging.equilibrium(0.3)
    np.testing.assert_allclose(rest.point("tool"), [np.sqrt(5.0), 0.0, 0.0], atol=1e-9)
    # From the swing, the tool is at (1, -2) in its own axes, which are a quarter turn ahead.
    np.testing.assert_allclose(rest.orientation("tool") @ [1, -2, 0], rest.point("tool"), atol=1e-9)


TOOL = """<link name="tool"><inertial><mass value="1"/>
  <inertia ixx="1" iyy="1" izz="1"/></inertial></link>"""


def test_points_of_a_simulation_need_no_wrenches_until_they_accelerate() -> None:
    text = FIXED.replace('<link name="tool"/>', TOOL)
    scene = cd.Scene(cd.load(text), free="swing", gravity=[0.0, -9.81, 0.0])
    path = scene.simulate(1.0, position=0.2, speed=1.0).evenly(9)
    point = path.point("tool", (0.0, -1.0, 0.0))
    angle, rate = path.position, path.speed
    out = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    along = np.stack([-np.sin(angle), np.cos(angle), 0.0 * angle], axis=1)
    expected = 3.0 * out + along
    np.testing.assert_allclose(point.position, expected, atol=1e-14)
    swept = rate[:, None] * (3.0 * along - out)
    np.testing.assert_allclose(point.velocity, swept, atol=1e-13)
    assert "_solved" not in path.__dict__
    turning = path.acceleration[:, None] * (3.0 * along - out) - rate[:, None] ** 2 * expected
    np.testing.assert_allclose(point.acceleration, turning, atol=1e-12)
    check_all_links(path)
    # A pendulum of inertia 1 + 5 kg·m² whose centre is at (2, 1).
    moment = -9.81 * (2.0 * np.cos(angle) - np.sin(angle))
    np.testing.assert_allclose(point.angular_acceleration[:, 2], moment / 6.0, atol=1e-9)


def test_only_the_joints_on_the_way_are_placed_some_samples_at_a_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    turn = four_bar().sweep(np.linspace(0.0, 6.0, 10_000), speed=3.0)
    placed: list[tuple[int, int]] = []
    place = Frames.placed

    def counted(frames: Frames, x: np.ndarray, path: list[int]) -> np.ndarray:
        placed.extend((index, len(x)) for index in path)
        return place(frames, x, path)

    monkeypatch.setattr(Frames, "placed", counted)
    crank = turn.point("crank", POINT)
    assert {index for index, _ in placed} == {0}
    assert sum(count for _, count in placed) == 10_000
    assert max(count for _, count in placed) < 5000
    placed.clear()
    _ = crank.velocity, crank.angular_velocity
    assert sum(count for _, count in placed) == 10_000
    placed.clear()
    _ = crank.acceleration, crank.angular_acceleration, crank.position
    assert sum(count for _, count in placed) == 10_000
    one = four_bar().sweep(turn.position[-3:], speed=3.0).point("crank", POINT)
    np.testing.assert_allclose(crank.acceleration[-3:], one.acceleration, atol=1e-13)


def test_points_stand_in_tables_by_name(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    turn = four_bar().sweep(TURN[:5], speed=3.0)
    tip = turn.point("coupler", POINT)
    frame = turn.to_dataframe(points={"tip": ("coupler", POINT), "pin": tip, "crank": "crank"})
    for name in QUANTITIES:
        np.testing.assert_array_equal(frame[f"tip.{name}_y"], getattr(tip, name)[:, 1])
        np.testing.assert_array_equal(frame[f"pin.{name}_z"], getattr(tip, name)[:, 2])
    assert frame.attrs["units"]["tip.acceleration_x"] == "m/s²"
    assert "crank.position_x" in frame
    dataset = turn.to_xarray(motion=False, points=["coupler"])
    found = dataset["point_velocity"].sel(point="coupler", component="x")
    np.testing.assert_array_equal(found, turn.point("coupler").velocity[:, 0])
    assert "point" not in turn.to_xarray().dims
    alone = tip.to_dataframe()
    np.testing.assert_array_equal(alone["coupler.position_x"], tip.position[:, 0])
    np.testing.assert_array_equal(alone["position"], turn.position)
    # As texts: readers of numbers of older pandas round once more.
    read = pandas.read_csv(tip.save(tmp_path / "tip.csv"), dtype=str)
    np.testing.assert_array_equal(
        read["coupler.velocity_x [m/s]"].astype(float), tip.velocity[:, 0]
    )
    with pytest.raises(cd.ArgumentError, match="point 'tip' is 3, expected the name of a link"):
        turn.to_dataframe(points={"tip": 3})
    other = four_bar().sweep(TURN[:4]).point("coupler")
    with pytest.raises(cd.ArgumentError, match="take it of the same result"):
        turn.to_dataframe(points={"tip": other})
    path = cd.Scene(cd.load("four_bar"), free="crank_bearing").simulate(
        0.1, position=0.0, speed=9.0
    )
    moved = path.to_dataframe(points=["coupler"])
    np.testing.assert_array_equal(moved["coupler.position_x"], path.point("coupler").position[:, 0])
    assert path.point("coupler").table().abscissa == "time"


def test_points_draw_themselves_over_each_other() -> None:
    pytest.importorskip("matplotlib")
    point = four_bar().sweep(TURN, speed=3.0).point("coupler", POINT)
    figure = point.plot("coupler.position_y", x="coupler.position_x")
    (line,) = figure.axes[0].lines
    np.testing.assert_array_equal(line.get_xdata(), point.position[:, 0])
    np.testing.assert_array_equal(line.get_ydata(), point.position[:, 1])
    assert len(point.plot().axes[0].lines) == 3


@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda item: pickle.loads(pickle.dumps(item))]
)
def test_copies_are_the_same_motion(copied: Callable[[PointMotion], PointMotion]) -> None:
    point = four_bar().sweep(TURN[:5], speed=3.0).point("coupler", POINT)
    again = copied(point)
    assert again.link == "coupler"
    for quantity in QUANTITIES:
        np.testing.assert_array_equal(getattr(again, quantity), getattr(point, quantity))
        assert not getattr(again, quantity).flags.writeable
    assert (
        repr(again) == "<PointMotion of 'coupler' at (0.13, -0.21, 0.34) m: 5 samples, world axes>"
    )
