"""Twists and spatial accelerations against Pinocchio, and against differences of the frames."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from testkit.kinematics import frames_of
from testkit.mixed_chain import MIXED, moved, rows

import cardan_dyn as cd
from cardan_dyn.proof.twists import State, Twists, cross

COUNT = 3
STEP = 1e-4


@pytest.fixture(scope="module", params=["mixed", "stewart_platform", "thoma_rig", "slider_crank"])
def mechanism(request: pytest.FixtureRequest) -> cd.Mechanism:
    return cd.load(MIXED if request.param == "mixed" else request.param)


def rates(mechanism: cd.Mechanism) -> tuple[np.ndarray, np.ndarray]:
    v, a = np.random.default_rng(5).uniform(-2.0, 2.0, (2, COUNT, mechanism.model.nv))
    return v, a


def about(motion: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Return a twist or spatial acceleration about the origin as `(2, 3)` at a point."""
    linear, angular = motion[:3], motion[3:]
    return np.stack([linear + np.cross(angular, point), angular])


def accelerations(
    twists: Twists, state: State, v: np.ndarray, a: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return velocities and accelerations of all motions' frames, `(M, 2, 3, N)` each."""
    relative = twists.relative(state, v.T)
    velocities = twists.absolute(relative)
    changes = twists.relative_accelerations(state, relative, velocities, a.T)
    return velocities, twists.absolute(changes)


def test_unit_twists_are_columns_of_the_jacobian(mechanism: cd.Mechanism) -> None:
    twists, x = Twists(frames_of(mechanism)), rows(mechanism, COUNT)
    state, data = twists.state(x), mechanism.model.createData()
    assert sorted(twists.rates.tolist()) == list(range(mechanism.model.nv))
    for sample, q in enumerate(mechanism.coordinates.configuration(x)):
        jacobian = pinocchio.computeJointJacobians(mechanism.model, data, q)
        for row, rate in enumerate(twists.rates):
            expected = about(jacobian[:, rate], twists.frames.corner)
            np.testing.assert_allclose(state.unit_twists[row, ..., sample], expected, atol=1e-12)


def test_directions_are_the_linear_or_angular_part_of_unit_twists(
    mechanism: cd.Mechanism,
) -> None:
    twists = Twists(frames_of(mechanism))
    state = twists.state(rows(mechanism, COUNT))
    np.testing.assert_allclose(np.linalg.norm(state.directions, axis=1), 1.0, rtol=1e-14)
    for row, slides in enumerate(twists.sliding):
        linear, angular = state.unit_twists[row]
        np.testing.assert_array_equal(linear if slides else angular, state.directions[row])
        assert np.any(angular) != slides


def test_velocities_and_accelerations_are_those_of_pinocchio(mechanism: cd.Mechanism) -> None:
    twists, x = Twists(frames_of(mechanism)), rows(mechanism, COUNT)
    v, a = rates(mechanism)
    velocities, spatial = accelerations(twists, twists.state(x), v, a)
    model, world = mechanism.model, pinocchio.ReferenceFrame.WORLD
    data, corner = model.createData(), twists.frames.corner
    joints = [
        (twists.frames.last[index], mechanism.joints[name].id)
        for index, name in enumerate(twists.frames.joints)
        if mechanism.joints[name].parts
    ]
    for sample, q in enumerate(mechanism.coordinates.configuration(x)):
        pinocchio.forwardKinematics(model, data, q, v[sample], a[sample])
        for motion, joint in joints:
            velocity = pinocchio.getVelocity(model, data, joint, world).vector
            acceleration = pinocchio.getAcceleration(model, data, joint, world).vector
            for result, reference in ((velocities, velocity), (spatial, acceleration)):
                expected = about(reference, corner)
                scale = np.max(np.abs(expected)) + 1.0
                difference = result[motion, ..., sample] - expected
                assert np.max(np.abs(difference)) < 1e-12 * scale


def test_twists_are_rates_of_the_frames(mechanism: cd.Mechanism) -> None:
    """Origins move with the velocity there, and axes with the angular velocity."""
    twists, x = Twists(frames_of(mechanism)), rows(mechanism, COUNT)
    v, a = rates(mechanism)
    velocities, _ = accelerations(twists, twists.state(x), v, a)
    frames = twists.frames.placed(x)
    later, earlier = (
        twists.frames.placed(moved(mechanism, x, v, a, sign * STEP)) for sign in (1.0, -1.0)
    )
    differences = (later - earlier) / (2.0 * STEP)
    linear, angular = velocities[:, 0], velocities[:, 1]
    expected = np.cross(angular[:, None], frames, axis=2)
    expected[:, 3] += linear
    np.testing.assert_allclose(differences, expected, atol=1e-4)


def test_accelerations_are_rates_of_the_twists(mechanism: cd.Mechanism) -> None:
    twists, x = Twists(frames_of(mechanism)), rows(mechanism, COUNT)
    v, a = rates(mechanism)
    _, spatial = accelerations(twists, twists.state(x), v, a)
    later, earlier = (
        accelerations(twists, twists.state(moved(mechanism, x, v, a, t)), v + t * a, a)[0]
        for t in (STEP, -STEP)
    )
    np.testing.assert_allclose((later - earlier) / (2.0 * STEP), spatial, atol=1e-4)


def test_absolute_twists_add_up_along_a_chain() -> None:
    """Two parallel hinges: angular velocities add up, and the second one is carried along."""
    arm = """<robot name="arm"><link name="base"/><link name="upper"/><link name="lower"/>
      <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/>
        <axis xyz="0 0 1"/></joint>
      <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
        <origin xyz="2 0 0"/><axis xyz="0 0 1"/></joint></robot>"""
    twists = Twists(frames_of(cd.load(arm)))
    state = twists.state(np.zeros((1, 2)))
    v, a = np.array([[3.0, 4.0]]), np.zeros((1, 2))
    velocities, spatial = accelerations(twists, state, v, a)
    np.testing.assert_allclose(velocities[:, 1, 2, 0], [3.0, 7.0])
    # The corner is at the shoulder; the lower arm turns about (2, 0), which moves with 6 along y.
    np.testing.assert_allclose(velocities[1, 0, :, 0], [0.0, 6.0 - 7.0 * 2.0, 0.0])
    # The elbow's twist (0, -8) turns with the shoulder's 3 rad/s.
    np.testing.assert_allclose(spatial[1, 0, :, 0], [24.0, 0.0, 0.0])
    assert not np.any(spatial[0])


def test_a_mechanism_without_joints_has_no_rates() -> None:
    twists = Twists(frames_of(cd.load('<robot name="block"><link name="base"/></robot>')))
    state = twists.state(np.zeros((2, 0)))
    assert twists.rates.shape == (0,)
    assert state.unit_twists.shape == (0, 2, 3, 2)


def test_cross_products_along_the_last_axis_but_one() -> None:
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(2, 1, 3, 4)), rng.normal(size=(2, 5, 3, 4))
    expected = np.cross(a, b, axis=-2)
    np.testing.assert_allclose(cross(a, b), expected, atol=1e-15)
