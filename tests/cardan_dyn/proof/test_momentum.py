"""Weights less momentum rates against Pinocchio's inertias, and of a disc by hand."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from testkit.kinematics import frames_of
from testkit.mixed_chain import MIXED, rows

import cardan_dyn as cd
from cardan_dyn.core.proof.momentum import Massive
from cardan_dyn.core.proof.placing import Frame, stacked
from cardan_dyn.core.proof.screws import Screw, Screws

GRAVITY = (1.0, -2.0, -9.81)
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


def massive_bodies(mechanism: cd.Mechanism) -> dict[int, Massive]:
    bodies = enumerate(frames_of(mechanism).bodies)
    return {index: Massive.of(body) for index, body in bodies if body.mass}


def motion(
    mechanism: cd.Mechanism, x: np.ndarray, v: np.ndarray, a: np.ndarray
) -> list[tuple[Frame, tuple[Screw, Screw]]]:
    """Return per body the frame that carries it, its velocity and acceleration."""
    screws = Screws(frames_of(mechanism))
    placed = screws.placing.placed(list(x.T))
    units = screws.units(placed)
    relative = screws.relative(units, list(v.T))
    velocities = screws.absolute(relative)
    changes = screws.absolute(screws.changes(units, list(a.T), relative, velocities))
    lasts = screws.frames.last[: screws.frames.tree]
    return [(placed[last], (velocities[last], changes[last])) for last in lasts]


def at_rest(mechanism: cd.Mechanism, x: np.ndarray) -> list[tuple[Frame, None]]:
    none = np.zeros((len(x), mechanism.model.nv))
    return [(frame, None) for frame, _ in motion(mechanism, x, none, none)]


@pytest.mark.parametrize("name", ["mixed", "stewart_platform", "slider_crank"])
def test_wrenches_are_those_of_pinocchio(name: str) -> None:
    mechanism = cd.load(MIXED if name == "mixed" else name)
    frames, x = frames_of(mechanism), rows(mechanism, COUNT)
    v, a = np.random.default_rng(2).uniform(-2.0, 2.0, (2, COUNT, mechanism.model.nv))
    massive = massive_bodies(mechanism)
    moving, resting = motion(mechanism, x, v, a), at_rest(mechanism, x)
    model, world = mechanism.model, pinocchio.ReferenceFrame.WORLD
    data, gravity = model.createData(), pinocchio.Motion(np.array(GRAVITY), np.zeros(3))
    shift = pinocchio.SE3(np.eye(3), -frames.corner)
    for sample, q in enumerate(mechanism.coordinates.configuration(x)):
        pinocchio.forwardKinematics(model, data, q, v[sample], a[sample])
        for body, own in massive.items():
            joint = mechanism.joints[frames.joints[body]].id
            described = frames.bodies[body]
            inertia = pinocchio.Inertia(described.mass, described.centre, described.inertia)
            inertia = data.oMi[joint].act(inertia)
            velocity = pinocchio.getVelocity(model, data, joint, world)
            acceleration = pinocchio.getAcceleration(model, data, joint, world)
            weight = inertia * gravity
            rate = inertia * acceleration + velocity.cross(inertia * velocity)
            for carried, expected in ((resting, weight), (moving, weight - rate)):
                about_corner = shift.act(expected).vector.reshape(2, 3)
                scale = np.max(np.abs(about_corner))
                frame, moves = carried[body]
                wrench = stacked(own.inertial_wrench(frame, GRAVITY, moves), COUNT)
                np.testing.assert_allclose(wrench[..., sample], about_corner, atol=1e-12 * scale)


def test_a_disc_needs_centripetal_and_tangential_forces() -> None:
    radius, mass, inertia, speed, acceleration = 0.5, 2.0, 0.3, 3.0, 4.0
    mechanism = disc(radius, mass, inertia)
    (massive,) = massive_bodies(mechanism).values()
    rates = np.array([[speed]]), np.array([[acceleration]])
    ((frame, moves),) = motion(mechanism, np.zeros((1, 1)), *rates)
    force, moment = stacked(massive.inertial_wrench(frame, (0.0, 0.0, 0.0), moves), 1)[..., 0]
    # The centre lies on the x axis, is accelerated towards the axle and along y.
    np.testing.assert_allclose(
        force, [mass * radius * speed**2, -mass * radius * acceleration, 0.0], atol=1e-14
    )
    about_axle = (inertia + mass * radius**2) * acceleration
    np.testing.assert_allclose(moment, [0.0, 0.0, -about_axle], atol=1e-14)
    np.testing.assert_allclose(
        massive.turning(moves, LENGTH), mass * LENGTH**2 * (speed**2 + acceleration)
    )


def test_weights_at_rest_act_at_the_centres() -> None:
    mechanism = disc(0.5, 2.0, 0.3)
    (massive,) = massive_bodies(mechanism).values()
    ((frame, _),) = at_rest(mechanism, np.array([[0.5 * np.pi]]))
    force, moment = stacked(massive.inertial_wrench(frame, (0.0, 0.0, -10.0), None), 1)[..., 0]
    np.testing.assert_allclose(force, [0.0, 0.0, -20.0])
    # After a quarter turn the centre lies on the y axis.
    np.testing.assert_allclose(moment, [-10.0, 0.0, 0.0], atol=1e-14)
