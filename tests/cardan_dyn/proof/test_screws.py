"""Frames, twists and their rates against Pinocchio, and against differences of the frames."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio
import pytest
from testkit.kinematics import frames_of
from testkit.mixed_chain import MIXED, moved, rows

import cardan_dyn as cd
from cardan_dyn.core.proof.placing import Frame, stacked
from cardan_dyn.core.proof.screws import Screw, Screws, about, in_world, power, velocity_at

COUNT = 3
STEP = 1e-4


@pytest.fixture(scope="module", params=["mixed", "stewart_platform", "thoma_rig", "slider_crank"])
def mechanism(request: pytest.FixtureRequest) -> cd.Mechanism:
    return cd.load(MIXED if request.param == "mixed" else request.param)


def rates(mechanism: cd.Mechanism) -> tuple[np.ndarray, np.ndarray]:
    v, a = np.random.default_rng(5).uniform(-2.0, 2.0, (2, COUNT, mechanism.model.nv))
    return v, a


def at_corner(motion: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Return a twist or spatial acceleration about the origin as `(2, 3)` at a point."""
    linear, angular = motion[:3], motion[3:]
    return np.stack([linear + np.cross(angular, point), angular])


def placed(screws: Screws, x: np.ndarray) -> list[Frame]:
    return screws.placing.placed(list(x.T))


def as_arrays(found: Sequence[Screw], count: int = COUNT) -> np.ndarray:
    """Return screws as `(k, 2, 3, N)`."""
    vectors = [vector for screw in found for vector in screw]
    return stacked(vectors, count).reshape(-1, 2, 3, count)


def frame_arrays(frames: Sequence[Frame], count: int = COUNT) -> np.ndarray:
    """Return frames as `(k, 4, 3, N)`."""
    vectors = [vector for axes, origin in frames for vector in (*axes, origin)]
    return stacked(vectors, count).reshape(-1, 4, 3, count)


def accelerations(
    screws: Screws, x: np.ndarray, v: np.ndarray, a: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return velocities and accelerations of all motions' frames, `(M, 2, 3, N)` each."""
    units = screws.units(placed(screws, x))
    relative = screws.relative(units, list(v.T))
    velocities = screws.absolute(relative)
    changes = screws.changes(units, list(a.T), relative, velocities)
    return as_arrays(velocities), as_arrays(screws.absolute(changes))


def test_joints_are_where_pinocchio_places_them(mechanism: cd.Mechanism) -> None:
    screws, x = Screws(frames_of(mechanism)), rows(mechanism, COUNT)
    frames, data = screws.frames, mechanism.model.createData()
    found = frame_arrays(screws.placing.joint_frames(placed(screws, x)))
    for sample, q in enumerate(mechanism.coordinates.configuration(x)):
        pinocchio.forwardKinematics(mechanism.model, data, q)
        for index, name in enumerate(frames.joints):
            if mechanism.joints[name].parts:
                expected = data.oMi[mechanism.joints[name].id]
                axes, origin = found[index, :3, :, sample], found[index, 3, :, sample]
                np.testing.assert_allclose(axes, expected.rotation.T, atol=1e-14)
                np.testing.assert_allclose(origin + frames.corner, expected.translation, atol=1e-14)


def test_unit_twists_are_columns_of_the_jacobian(mechanism: cd.Mechanism) -> None:
    screws, x = Screws(frames_of(mechanism)), rows(mechanism, COUNT)
    units, data = as_arrays(screws.units(placed(screws, x))), mechanism.model.createData()
    assert sorted(screws.rates) == list(range(mechanism.model.nv))
    for sample, q in enumerate(mechanism.coordinates.configuration(x)):
        jacobian = pinocchio.computeJointJacobians(mechanism.model, data, q)
        for row, rate in enumerate(screws.rates):
            expected = at_corner(jacobian[:, rate], screws.frames.corner)
            np.testing.assert_allclose(units[row, ..., sample], expected, atol=1e-12)


def test_velocities_and_accelerations_are_those_of_pinocchio(mechanism: cd.Mechanism) -> None:
    screws, x = Screws(frames_of(mechanism)), rows(mechanism, COUNT)
    v, a = rates(mechanism)
    velocities, spatial = accelerations(screws, x, v, a)
    model, world = mechanism.model, pinocchio.ReferenceFrame.WORLD
    data, frames = model.createData(), screws.frames
    joints = [
        (frames.last[index], mechanism.joints[name].id)
        for index, name in enumerate(frames.joints)
        if mechanism.joints[name].parts
    ]
    for sample, q in enumerate(mechanism.coordinates.configuration(x)):
        pinocchio.forwardKinematics(model, data, q, v[sample], a[sample])
        for motion, joint in joints:
            velocity = pinocchio.getVelocity(model, data, joint, world).vector
            acceleration = pinocchio.getAcceleration(model, data, joint, world).vector
            for result, reference in ((velocities, velocity), (spatial, acceleration)):
                expected = at_corner(reference, frames.corner)
                scale = np.max(np.abs(expected)) + 1.0
                difference = result[motion, ..., sample] - expected
                assert np.max(np.abs(difference)) < 1e-12 * scale


def test_twists_are_rates_of_the_frames(mechanism: cd.Mechanism) -> None:
    """Origins move with the velocity there, and axes with the angular velocity."""
    screws, x = Screws(frames_of(mechanism)), rows(mechanism, COUNT)
    v, a = rates(mechanism)
    velocities, _ = accelerations(screws, x, v, a)
    frames, later, earlier = (
        frame_arrays(placed(screws, moved(mechanism, x, v, a, time))) for time in (0.0, STEP, -STEP)
    )
    differences = (later - earlier) / (2.0 * STEP)
    linear, angular = velocities[:, 0], velocities[:, 1]
    expected = np.cross(angular[:, None], frames, axis=2)
    expected[:, 3] += linear
    np.testing.assert_allclose(differences, expected, atol=1e-4)


def test_accelerations_are_rates_of_the_twists(mechanism: cd.Mechanism) -> None:
    screws, x = Screws(frames_of(mechanism)), rows(mechanism, COUNT)
    v, a = rates(mechanism)
    _, spatial = accelerations(screws, x, v, a)
    later, earlier = (
        accelerations(screws, moved(mechanism, x, v, a, t), v + t * a, a)[0] for t in (STEP, -STEP)
    )
    np.testing.assert_allclose((later - earlier) / (2.0 * STEP), spatial, atol=1e-4)


def test_absolute_twists_add_up_along_a_chain() -> None:
    """Two parallel hinges: angular velocities add up, and the second one is carried along."""
    arm = """<robot name="arm"><link name="base"/><link name="upper"/><link name="lower"/>
      <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/>
        <axis xyz="0 0 1"/></joint>
      <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
        <origin xyz="2 0 0"/><axis xyz="0 0 1"/></joint></robot>"""
    screws = Screws(frames_of(cd.load(arm)))
    units = screws.units(screws.placing.placed([0.0, 0.0]))
    relative = screws.relative(units, [3.0, 4.0])
    velocities = screws.absolute(relative)
    spatial = screws.absolute(screws.changes(units, [0.0, 0.0], relative, velocities))
    assert [spin for _, spin in velocities] == [(0.0, 0.0, 3.0), (0.0, 0.0, 7.0)]
    # The corner is at the shoulder; the lower arm turns about (2, 0), which moves with 6 along y.
    assert velocities[1][0] == (0.0, 6.0 - 7.0 * 2.0, 0.0)
    # The elbow's twist (0, -8) turns with the shoulder's 3 rad/s.
    assert spatial[1] == ((24.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    assert spatial[0] == ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def test_a_mechanism_without_joints_has_no_rates() -> None:
    screws = Screws(frames_of(cd.load('<robot name="block"><link name="base"/></robot>')))
    assert screws.rates == screws.units(screws.placing.placed([])) == []


def test_wrenches_are_placed_as_by_pinocchio() -> None:
    """And their power does not depend on the point about which both are taken."""
    pinocchio.seed(1)
    rng = np.random.default_rng(1)
    for _ in range(20):
        wrench, twist = (tuple(map(tuple, pair)) for pair in rng.normal(size=(2, 2, 3)).tolist())
        placement, point = pinocchio.SE3.Random(), tuple(rng.normal(size=3).tolist())
        frame = Frame(
            tuple(map(tuple, placement.rotation.T.tolist())), tuple(placement.translation.tolist())
        )
        placed_wrench = in_world(wrench, frame)
        expected = placement.act(pinocchio.Force(np.ravel(wrench)))
        np.testing.assert_allclose(np.ravel(placed_wrench), expected.vector, atol=1e-14)
        there = velocity_at(point, twist), twist[1]
        np.testing.assert_allclose(
            power(about(point, wrench), there), power(wrench, twist), rtol=1e-12
        )
        np.testing.assert_allclose(power(wrench, twist), np.sum(np.multiply(wrench, twist)))
