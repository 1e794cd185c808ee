"""Jacobians, mass matrices and biases, against other ways of finding them."""

from __future__ import annotations

import pickle
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import mpmath as mp
import mujoco
import numpy as np
import pinocchio as pin
import pytest
from scipy.linalg import null_space
from testkit import ball_rods, linkages
from testkit.coordinates import (
    BARS,
    GRAVITY,
    SCENES,
    agree,
    all_driven,
    as_given,
    motion_of,
    ratios_by_pinocchio,
    scene_of,
    sloped,
)

import cardan_dyn as cd
from cardan_dyn.core.results.jacobian import Jacobian
from cardan_dyn.kit.arrays import Array

pytestmark = pytest.mark.usefixtures("loaded_once")

POINT = np.array([0.13, -0.21, 0.34])
GEARED = linkages.gears(linkages.coupling("mesh", "a", "b", -2.5))


def frame_by_pinocchio(mechanism: cd.Mechanism, q: Array, name: str) -> Array:
    """Return the Jacobian `(6, nv)` of `POINT` of a link in the open tree."""
    model = mechanism.model.copy()
    index, placement = mechanism.links[name]
    placed = pin.Frame("p", index, placement * pin.SE3(np.eye(3), POINT), pin.FrameType.OP_FRAME)
    frame, data = model.addFrame(placed, False), None
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    return pin.getFrameJacobian(model, data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)


@pytest.mark.parametrize("name", SCENES)
def test_jacobians_and_masses_are_those_of_the_open_tree_and_its_welds(name: str) -> None:
    scene = scene_of(name)
    position, _, _ = motion_of(scene)
    swept = all_driven(scene).sweep(position)
    mass, model = scene.mass_matrix(as_given(scene, position)), scene.mechanism.model
    ratios = []
    for sample, q in enumerate(swept.motion.q):
        data, ratio = ratios_by_pinocchio(scene, q)
        ratios.append(ratio)
        tree = pin.crba(model, data, q)
        tree = np.triu(tree) + np.triu(tree, 1).T
        agree(mass[sample], ratio.T @ tree @ ratio, 1e-12)
    for link in scene.mechanism.links:
        found = scene.jacobian(link, POINT, position=as_given(scene, position))
        assert found.shape == (len(position), 6, len(scene.coordinates))
        assert found.coordinates == scene.coordinates
        expected = np.array(
            [
                frame_by_pinocchio(scene.mechanism, q, link) @ ratio
                for q, ratio in zip(swept.motion.q, ratios, strict=True)
            ]
        )
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", SCENES)
def test_rates_and_twists(name: str) -> None:
    scene = scene_of(name)
    position, speed, _ = motion_of(scene)
    for link in list(scene.mechanism.links)[1:4]:
        given = {"position": as_given(scene, position), "speed": as_given(scene, speed)}
        found = scene.jacobian(link, POINT, **given)

        def at(by: float, link: str = link) -> Array:
            there = as_given(scene, position + by * speed)
            return np.asarray(scene.jacobian(link, POINT, position=there))

        expected = sloped(at)
        np.testing.assert_allclose(found.rate, expected, rtol=0, atol=2e-9)
        point = all_driven(scene).sweep(position, speed=speed).point(link, POINT)
        twist = np.concatenate([point.velocity, point.angular_velocity], axis=-1)
        np.testing.assert_allclose((found @ speed[..., None])[..., 0], twist, atol=1e-13)
        change = (found.rate @ speed[..., None])[..., 0]
        turned = np.concatenate([point.acceleration, point.angular_acceleration], axis=-1)
        np.testing.assert_allclose(change, turned, atol=1e-12)


def test_rates_of_the_universal_joint_to_fifty_digits() -> None:
    """The output's angular velocity is cos β / (1 − sin²β cos²φ) times that of the input."""
    scene = scene_of("universal")
    phi, beta, omega, swing = 0.7, 0.4, 3.0, -2.0

    def column(time: Any) -> Any:
        angle, bend = mp.mpf(phi) + omega * time, mp.mpf(beta) + swing * time
        ratio = mp.cos(bend) / (1 - mp.sin(bend) ** 2 * mp.cos(angle) ** 2)
        return [ratio * mp.cos(bend), ratio * mp.sin(bend), mp.mpf(0)]

    with mp.workdps(50):
        value = np.array([float(x) for x in column(mp.mpf(0))])
        rate = np.array([float(mp.diff(lambda t, k=k: column(t)[k], 0)) for k in range(3)])
    found = scene.jacobian("shaft_out", position=[phi, beta], speed=[omega, swing])
    axis = found.value[0, 3:, 0]
    flipped = np.diag([1.0, np.sign(axis[1]), 1.0])
    np.testing.assert_allclose(flipped @ axis, value, rtol=0, atol=1e-15)
    np.testing.assert_allclose(flipped @ found.rate[0, 3:, 0], rate, rtol=0, atol=4e-15)


def test_rates_of_a_four_bar_to_fifty_digits() -> None:
    """Crank 0.5, coupler and rocker as in `linkages.four_bar`, closed by two circles."""

    def tip(angle: Any) -> Any:
        end = mp.matrix([-mp.sin(angle) / 2, mp.cos(angle) / 2])
        line = mp.matrix([2, 0]) - end
        apart = mp.norm(line)
        coupler, rocker = mp.sqrt(8), mp.mpf(5) / 2
        along = (coupler**2 - rocker**2 + apart**2) / (2 * apart)
        across = mp.sqrt(coupler**2 - along**2)
        unit = line / apart
        return end + along * unit + across * mp.matrix([-unit[1], unit[0]])

    scene = scene_of("four_bar")
    found = scene.jacobian("rocker", (0.0, 2.5, 0.0), position=0.6, speed=-3.0)
    with mp.workdps(50):
        for k in range(2):
            first, second = (mp.diff(lambda a, k=k: tip(a)[k], mp.mpf(0.6), m) for m in (1, 2))
            assert found[0, k, 0] == pytest.approx(float(first), rel=1e-14)
            assert found.rate[0, k, 0] == pytest.approx(-3.0 * float(second), rel=1e-13)


@pytest.mark.parametrize("name", SCENES)
def test_bias_by_lagrange(name: str) -> None:
    """Efforts follow from the mass matrix and the potential energy of Pinocchio."""
    scene = scene_of(name)
    position, speed, _ = motion_of(scene, 2)
    model, mass = scene.mechanism.model.copy(), scene.mass_matrix
    model.gravity.linear[:] = GRAVITY
    driven = all_driven(scene)

    def lagrangian(there: Array, speed: Array) -> Array:
        kinetic = np.einsum("ni,nij,nj->n", speed, mass(as_given(scene, there)), speed) / 2.0
        data = model.createData()
        weights = [pin.computePotentialEnergy(model, data, q) for q in driven.sweep(there).motion.q]
        return kinetic - np.array(weights)

    def momentum(by: float) -> Array:
        there = as_given(scene, position + by * speed)
        return np.einsum("nij,nj->ni", mass(there), speed)

    units = np.eye(len(scene.coordinates))
    forces = [sloped(lambda by, e=e: lagrangian(position + by * e, speed)) for e in units]
    expected = sloped(momentum) - np.stack(forces, axis=-1)
    found = scene.bias(as_given(scene, position), as_given(scene, speed))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("name", SCENES)
def test_the_equation_of_motion(name: str) -> None:
    """Loads enter by the transpose of a Jacobian, and of velocity ratios."""
    scene = scene_of(name)
    position, speed, acceleration = motion_of(scene)
    link, joint = list(scene.mechanism.links)[2], scene.coordinates[-1]
    force = np.array([3.0, -20.0, 7.0, 1.0, 4.0, -2.0])
    wrench = cd.Wrench(force[:3], force[3:], point=POINT, frame="world")
    loaded = all_driven(scene, loads={joint: 2.0, link: wrench})
    efforts = loaded.sweep(position, speed=speed, acceleration=acceleration).drive_effort
    own = as_given(scene, position)
    needed = scene.bias(own, as_given(scene, speed))
    needed = needed + (scene.mass_matrix(own) @ acceleration[..., None])[..., 0]
    needed[:, -1] -= 2.0
    jacobian = scene.jacobian(link, POINT, position=own)
    needed -= np.einsum("nij,i->nj", jacobian, force)
    agree(efforts.reshape(needed.shape), needed, 1e-12)


def test_masses_as_mujoco_has_them() -> None:
    """A four-bar with rotors, whose loop is a row of MuJoCo's constraints."""
    text = """<mujoco><compiler angle="radian"/><option jacobian="dense"/><worldbody>
<body name="crank"><joint name="a" axis="0 0 1" armature=".3"/>
<inertial pos=".1 .2 0" mass="2" fullinertia=".3 .4 .5 .01 .02 .03"/>
<body name="coupler" pos="0 .5 0"><joint name="b" axis="0 0 1" armature=".02"/>
<inertial pos="1 1 .1" mass="1" diaginertia=".2 .3 .4"/><site name="end" pos="2 2 0"/></body></body>
<body name="rocker" pos="2 0 0"><joint name="d" axis="0 0 1"/>
<inertial pos="0 1.2 0" mass="3" diaginertia=".3 .2 .1"/><site name="pin" pos="0 2.5 0"/></body>
</worldbody><equality><connect site1="end" site2="pin"/></equality></mujoco>"""
    scene = cd.Scene(cd.load(text), drive="a")
    angle = np.linspace(-2.0, 2.0, 5)
    turn, found = scene.sweep(angle), scene.mass_matrix(angle)
    model = mujoco.MjModel.from_xml_string(text)
    for sample in range(len(angle)):
        data, mass = mujoco.MjData(model), np.zeros((3, 3))
        data.qpos[:] = [turn.motion.position(name)[sample] for name in "abd"]
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, mass)
        way = null_space(data.efc_J.reshape(-1, 3), rcond=1e-8)[:, 0]
        way /= way[0]
        assert found[sample, 0, 0] == pytest.approx(way @ mass @ way, rel=1e-10)


def test_gears_carry_inertia_over() -> None:
    scene = cd.Scene(cd.load(GEARED), drive="a")
    masses = {link.name: link for link in scene.mechanism.description.links}
    turn = scene.sweep(0.3)
    ratio = [turn.motion.ratio(name)[0] for name in ("a", "b")]
    own = [
        item.inertia[2, 2] + item.mass * (item.centre[:2] @ item.centre[:2])
        for item in (masses[joint.child] for joint in scene.mechanism.description.joints)
    ]
    expected = sum(r**2 * i for r, i in zip(ratio, own, strict=True))
    assert abs(ratio[1]) != 1.0
    assert scene.mass_matrix(0.3)[0, 0, 0] == pytest.approx(expected, rel=1e-13)


def test_kinetic_energy_of_a_simulation() -> None:
    scene = scene_of("free four-bar").replace(gravity=(0, -9.81, 0))
    course = scene.simulate(1.0, speed=2.0)
    mass = scene.mass_matrix(course.position)[:, 0, 0]
    np.testing.assert_allclose(0.5 * mass * course.speed**2, course.kinetic_energy, rtol=1e-12)


def test_shapes_designs_and_names() -> None:
    joint = cd.load("universal_joint")
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.3}, gravity=GRAVITY)
    phi, beta = np.linspace(0.0, 6.0, 7), np.array([[0.2], [0.5]])
    given = {"position": phi, "held": {"joint_angle": beta}}
    found = scene.jacobian("shaft_out", POINT, **given, speed=2.0)
    assert found.shape == found.rate.shape == (2, 7, 6, 1)
    assert scene.mass_matrix(phi, held=given["held"]).shape == (2, 7, 1, 1)
    assert scene.bias(phi, 2.0, held=given["held"]).shape == (2, 7, 1)
    assert scene.regressor(phi, 2.0, held=given["held"]).shape == (2, 7, 1, 40)
    other = cd.Scene(joint, drive=["bearing_in"], held={"joint_angle": 0.5})
    alone = other.jacobian("shaft_out", POINT, position=phi[3], speed=2.0)
    np.testing.assert_allclose(alone[0], found[1, 3], atol=1e-15)
    np.testing.assert_allclose(alone.rate[0], found.rate[1, 3], atol=1e-14)
    np.testing.assert_allclose(other.jacobian("shaft_out", POINT, position=phi[:, None]), found[1])


def test_what_stands_still_and_what_coordinates_do_not_move() -> None:
    scene = cd.Scene(cd.load("universal_joint"), drive=["bearing_in", "joint_angle"])
    found = scene.jacobian("base", POINT, position=[0.3, 0.2], speed=[1.0, 2.0])
    assert not found.value.any() and not found.rate.any()
    housing = scene.jacobian("housing_out", POINT, position=[0.3, 0.2], speed=[0.0, 0.0])
    assert not housing[..., 0].any() and not housing.rate.any() and housing[..., 1].any()


def test_outputs_strictness_loads_and_elements_do_not_matter() -> None:
    plain = scene_of("four_bar")
    spring = cd.JointSpring("d", 30.0, damping=2.0, rest=0.2)
    other = plain.replace(outputs=["d"], strict=True, loads={"d": [3.0, 4.0]}, elements=[spring])
    for method in ("mass_matrix", "regressor"):
        expected = np.asarray(getattr(plain, method)(0.4))
        np.testing.assert_allclose(getattr(other, method)(0.4), expected, rtol=1e-13, atol=1e-13)
    first, second = (
        scene.jacobian("coupler", POINT, position=0.4, speed=2.0) for scene in (plain, other)
    )
    np.testing.assert_allclose(first, second, atol=1e-15)
    np.testing.assert_allclose(first.rate, second.rate, atol=1e-14)
    turn = plain.sweep(0.4, speed=2.0)
    position, ratio = turn.motion.position("d")[0], turn.motion.ratio("d")[0]
    effort = ratio * (30.0 * (position - 0.2) + 2.0 * ratio * 2.0)
    change = other.bias(0.4, 2.0) - plain.bias(0.4, 2.0)
    assert change[0, 0] == pytest.approx(effort, rel=1e-12)


def test_jacobians_stand_for_arrays_and_survive_pickles_and_threads() -> None:
    scene = scene_of("four_bar")
    found = scene.jacobian("coupler", POINT, position=[0.1, 0.2], speed=1.0)
    assert isinstance(found, Jacobian) and len(found) == 2 and found.ndim == 3
    np.testing.assert_array_equal(found * 2.0, found.value + found)
    np.testing.assert_array_equal(np.linalg.norm(found), np.linalg.norm(found.value))
    with pytest.raises(ValueError, match="read-only"):
        found.value[:] = 0.0
    with pytest.raises(AttributeError, match=r"np\.asarray"):
        found.T  # noqa: B018
    again = pickle.loads(pickle.dumps(found))
    np.testing.assert_array_equal(again, found)
    np.testing.assert_array_equal(again.rate, found.rate)
    with ThreadPoolExecutor(4) as pool:
        every = pool.map(lambda _: np.asarray(scene.mass_matrix(np.linspace(0, 1, 9))), range(8))
        for matrix in every:
            np.testing.assert_allclose(matrix, scene.mass_matrix(np.linspace(0, 1, 9)), rtol=1e-14)


def test_many_samples_are_those_of_single_ones() -> None:
    scene = scene_of("stewart")
    position, speed, _ = motion_of(scene, 3000)
    found = scene.jacobian("platform", POINT, position=position, speed=speed)
    for k in (0, 1711, 2999):
        alone = scene.jacobian("platform", POINT, position=position[k], speed=speed[k])
        np.testing.assert_allclose(alone[0], found[k], atol=1e-13)
        np.testing.assert_allclose(alone.rate[0], found.rate[k], atol=1e-11)


def test_paths_are_followed() -> None:
    """Both ways lead to the same configuration where nothing is in between."""
    scene = scene_of("stewart")
    position, _, _ = motion_of(scene, 4)
    path = np.linspace(position[0], position[1], 9)
    for method in (scene.mass_matrix, scene.bias, scene.regressor):
        expected = np.asarray(method(path))
        agree(method(path, along_path=True), expected, 1e-12)
    given = {"position": path, "speed": np.ones(6)}
    found, straight = (
        scene.jacobian("platform", POINT, along_path=flag, **given) for flag in (True, False)
    )
    agree(found, straight.value, 1e-13)
    agree(found.rate, straight.rate, 1e-11)
    with pytest.raises(cd.ArgumentError, match="along_path"):
        scene.mass_matrix(path, along_path="yes")


def test_rods_that_spin_idly() -> None:
    scene = cd.Scene(cd.load(ball_rods.as_balls()), drive="a")
    plain = scene.jacobian("rocker", position=0.2, speed=1.5)
    twist = scene.sweep(0.2, speed=1.5).point("rod", POINT).velocity
    found = scene.jacobian("rod", POINT, position=0.2)
    np.testing.assert_allclose(found[0, :3, 0] * 1.5, twist[0], atol=1e-15)
    with pytest.raises(cd.ModelError, match="'rod' turns about its line by a rule"):
        scene.jacobian("rod", position=0.2, speed=1.5)

    def at(by: float) -> Array:
        return np.asarray(scene.jacobian("rocker", position=0.2 + by))

    np.testing.assert_allclose(plain.rate, 1.5 * sloped(at), atol=1e-10)
    free = scene.replace(drive=None, free="a", gravity=(1.0, 2.0, -9.81))
    driven = free.replace(drive="a", free=None)
    stiffness = sloped(lambda by: driven.sweep(0.2 + by).drive_effort)
    found = free.linear(driven.sweep(0.2))
    assert found.stiffness[0, 0, 0] == pytest.approx(stiffness[0], rel=1e-8)
    np.testing.assert_allclose(found.mass, free.mass_matrix(0.2), rtol=1e-12)


def test_refusals() -> None:
    scene = scene_of("four_bar")
    for wrong, kind, words in (
        (lambda: scene.jacobian("nothing", position=0.0), cd.ModelError, "links"),
        (lambda: scene.jacobian("a", position=0.0), cd.ModelError, "is a joint"),
        (lambda: scene.jacobian("rocker", (0, 1), position=0.0), cd.ArgumentError, "point"),
        (lambda: scene.jacobian("rocker", position=np.nan), cd.ArgumentError, "position"),
        (lambda: scene.jacobian("rocker", position=0.0, speed=np.inf), cd.ArgumentError, "speed"),
        (lambda: scene.jacobian("rocker", position=0.0).rate, cd.ArgumentError, "speed="),
        (lambda: scene.mass_matrix([]), cd.ArgumentError, "empty"),
        (lambda: scene.mass_matrix(0.0, held={"d": 1.0}), cd.ArgumentError, "does not hold"),
        (lambda: scene.bias([0.0, 1.0], [1.0, 2.0, 3.0]), cd.ArgumentError, "broadcast"),
        (lambda: scene.regressor(0.0, acceleration="x"), cd.ArgumentError, "acceleration"),
    ):
        with pytest.raises(kind, match=words):
            wrong()
    rocking = cd.Scene(cd.load(BARS), drive="d")
    low, high = rocking.motion_range()
    assert np.isfinite([low, high]).all()
    for method in (rocking.mass_matrix, rocking.bias, rocking.regressor):
        with pytest.raises(cd.CardanError) as error:
            method([0.0, high + 0.1])
        assert error.value.sample == 1
    with pytest.raises(cd.CardanError) as error:
        rocking.jacobian("crank", position=[0.0, high + 0.1], speed=1.0)
    assert error.value.sample == 1
    with pytest.raises((cd.SingularConfigurationError, cd.AssemblyError)):
        rocking.jacobian("crank", position=high)
