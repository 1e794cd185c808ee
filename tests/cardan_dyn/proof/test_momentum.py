"""Weights less momentum rates against Pinocchio's inertias, and of a disc by hand."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from testkit.kinematics import frames_of
from testkit.mixed_chain import MIXED, rows

import cardan_dyn as cd
from cardan_dyn.proof.momentum import MassiveBodies
from cardan_dyn.proof.twists import Twists

GRAVITY = np.array([[1.0, -2.0, -9.81]])
COUNT = 3
LENGTH = 0.7


def disc(radius: float, mass: float, inertia: float) -> cd.Mechanism:
    """Return a disc whose centre is at a distance from the vertical axis that it turns about."""
    return cd.load(
        f"""<robot name="disc"><link name="base"/><link name="disc"><inertial>
      <origin xyz="{radius} 0 0"/><mass value="{mass}"/>
      <inertia ixx="0.2" iyy="0.2" izz="{inertia}"/></inertial></link>
      <joint name="axle" type="continuous"><parent link="base"/><child link="disc"/>
        <axis xyz="0 0 1"/></joint></robot>"""
    )


def massive_bodies(mechanism: cd.Mechanism, length: float = LENGTH) -> MassiveBodies:
    frames = frames_of(mechanism)
    return MassiveBodies(frames, dict(enumerate(frames.bodies)), length)


def of_frames(mechanism: cd.Mechanism, chosen: slice | np.ndarray) -> list[int]:
    """Return indices of bodies or motions, each body with one motion at least."""
    return np.arange(len(frames_of(mechanism).motions))[chosen].tolist()


def motion(
    mechanism: cd.Mechanism, x: np.ndarray, v: np.ndarray, a: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return frames, velocities and accelerations of all motions."""
    twists = Twists(frames_of(mechanism))
    state = twists.state(x)
    relative = twists.relative(state, v.T)
    velocities = twists.absolute(relative)
    changes = twists.relative_accelerations(state, relative, velocities, a.T)
    return state.motion_frames, velocities, twists.absolute(changes)


@pytest.mark.parametrize("name", ["mixed", "stewart_platform", "slider_crank"])
def test_wrenches_are_those_of_pinocchio(name: str) -> None:
    mechanism = cd.load(MIXED if name == "mixed" else name)
    frames, x = frames_of(mechanism), rows(mechanism, COUNT)
    v, a = np.random.default_rng(2).uniform(-2.0, 2.0, (2, COUNT, mechanism.model.nv))
    massive = massive_bodies(mechanism)
    moving = massive.weights_less_momentum_rates(*motion(mechanism, x, v, a), GRAVITY)
    resting = massive.weights(frames.placed(x), GRAVITY)
    model, world = mechanism.model, pinocchio.ReferenceFrame.WORLD
    data, gravity = model.createData(), pinocchio.Motion(GRAVITY[0], np.zeros(3))
    shift = pinocchio.SE3(np.eye(3), -frames.corner)
    for sample, q in enumerate(mechanism.coordinates.configuration(x)):
        pinocchio.forwardKinematics(model, data, q, v[sample], a[sample])
        for index, body in enumerate(of_frames(mechanism, massive.indices)):
            joint = mechanism.joints[frames.joints[body]].id
            described = frames.bodies[body]
            inertia = pinocchio.Inertia(described.mass, described.centre, described.inertia)
            inertia = data.oMi[joint].act(inertia)
            velocity = pinocchio.getVelocity(model, data, joint, world)
            acceleration = pinocchio.getAcceleration(model, data, joint, world)
            weight = inertia * gravity
            rate = inertia * acceleration + velocity.cross(inertia * velocity)
            for inertial, expected in ((resting, weight), (moving, weight - rate)):
                about_corner = shift.act(expected).vector.reshape(2, 3)
                scale = np.max(np.abs(about_corner))
                wrench = inertial.wrenches[index, ..., sample]
                np.testing.assert_allclose(wrench, about_corner, atol=1e-12 * scale)


def test_a_disc_needs_centripetal_and_tangential_forces() -> None:
    radius, mass, inertia, speed, acceleration = 0.5, 2.0, 0.3, 3.0, 4.0
    mechanism = disc(radius, mass, inertia)
    massive = massive_bodies(mechanism)
    rates = np.array([[speed]]), np.array([[acceleration]])
    moving = motion(mechanism, np.zeros((1, 1)), *rates)
    inertial = massive.weights_less_momentum_rates(*moving, np.zeros((1, 3)))
    force, moment = inertial.wrenches[0, ..., 0]
    # The centre lies on the x axis, is accelerated towards the axle and along y.
    np.testing.assert_allclose(
        force, [mass * radius * speed**2, -mass * radius * acceleration, 0.0], atol=1e-14
    )
    about_axle = (inertia + mass * radius**2) * acceleration
    np.testing.assert_allclose(moment, [0.0, 0.0, -about_axle], atol=1e-14)
    np.testing.assert_allclose(inertial.size, mass * LENGTH**2 * (speed**2 + acceleration))


def test_weights_at_rest_act_at_the_centres() -> None:
    mechanism = disc(0.5, 2.0, 0.3)
    massive, gravity = massive_bodies(mechanism), np.array([[0.0, 0.0, -10.0]])
    inertial = massive.weights(frames_of(mechanism).placed(np.array([[0.5 * np.pi]])), gravity)
    np.testing.assert_allclose(inertial.wrenches[0, 0, :, 0], [0.0, 0.0, -20.0])
    # After a quarter turn the centre lies on the y axis.
    np.testing.assert_allclose(inertial.wrenches[0, 1, :, 0], [-10.0, 0.0, 0.0], atol=1e-14)
    np.testing.assert_array_equal(inertial.size, [0.0])


def test_massive_bodies_and_the_greatest_of_them() -> None:
    mechanism = cd.load(MIXED)
    massive = massive_bodies(mechanism)
    masses = [
        frames_of(mechanism).bodies[index].mass for index in of_frames(mechanism, massive.indices)
    ]
    assert len(massive) == len(masses) == 4
    assert sorted(masses) == [1.0, 2.0, 3.0, 4.0]
    assert massive.greatest_mass == 4.0
    weight = 4.0 * np.sqrt(1.0 + 4.0 + 9.81**2) * LENGTH
    assert massive.greatest_weight(GRAVITY) == pytest.approx([weight], rel=1e-15)
    for index, carrier in zip(
        of_frames(mechanism, massive.indices), of_frames(mechanism, massive.motions), strict=True
    ):
        assert frames_of(mechanism).motions[carrier].joint == index


def test_bodies_without_mass_are_left_out() -> None:
    text = '<robot name="arm"><link name="base"/><link name="arm"/><joint name="hinge" '
    text += 'type="continuous"><parent link="base"/><child link="arm"/></joint></robot>'
    massive = massive_bodies(cd.load(text))
    assert not massive
    assert massive.greatest_mass == 0.0
    assert massive.greatest_weight(GRAVITY) == [0.0]


def test_weights_that_overflow_are_infinite_without_warnings() -> None:
    massive = massive_bodies(disc(0.5, 2.0, 0.3), 2.0)
    assert massive.greatest_weight(np.array([[0.0, 0.0, -1.7e308]])) == [np.inf]


def test_gravity_may_differ_from_sample_to_sample() -> None:
    mechanism = cd.load(MIXED)
    massive, x = massive_bodies(mechanism), rows(mechanism, COUNT)
    v, a = np.random.default_rng(2).uniform(-2.0, 2.0, (2, COUNT, mechanism.model.nv))
    gravity = np.random.default_rng(3).uniform(-9.0, 9.0, (COUNT, 3))
    frames = frames_of(mechanism).placed(x)
    moving = massive.weights_less_momentum_rates(*motion(mechanism, x, v, a), gravity)
    resting = massive.weights(frames, gravity)
    for sample in range(COUNT):
        part, own = slice(sample, sample + 1), gravity[[sample]]
        alone = massive.weights_less_momentum_rates(
            *motion(mechanism, x[part], v[part], a[part]), own
        )
        at_rest = massive.weights(frames[..., part], own)
        for together, single in ((moving, alone), (resting, at_rest)):
            wrenches = together.wrenches[..., part]
            np.testing.assert_allclose(wrenches, single.wrenches, rtol=1e-13, atol=1e-12)
            np.testing.assert_allclose(together.size[part], single.size, rtol=1e-13)
    greatest = 4.0 * LENGTH * np.linalg.norm(gravity, axis=1)
    np.testing.assert_allclose(massive.greatest_weight(gravity), greatest, rtol=1e-15)


def test_some_of_the_bodies_are_collected_by_their_indices() -> None:
    frames = frames_of(cd.load(MIXED))
    heaviest = max(range(len(frames.bodies)), key=lambda index: frames.bodies[index].mass)
    massive = MassiveBodies(frames, {heaviest: frames.bodies[heaviest]}, LENGTH)
    assert massive.indices == slice(heaviest, heaviest + 1)
    assert [motion.joint for motion in frames.motions[massive.motions]] == [heaviest]
    assert massive.greatest_mass == 4.0
