"""The equation of motions: how often it repeats, by hand along large motions, where it ends."""

from __future__ import annotations

import numpy as np
import pytest
from testkit import elastic_rigs
from tilting_shaft import TiltingShaft

from cardan_dyn.motion.vibration.model.motion_equation import MotionEquation, motion_equation
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene
from cardan_dyn.motion.vibration.motions.harmonic_balance import course_of

RIG = elastic_rigs.elastic_rig()


def equation_of(urdf: str, beta: float) -> MotionEquation:
    return motion_equation(rotating_scene(elastic_rigs.scene(urdf, beta)), 1.0)


def test_unbalance_takes_the_whole_revolution() -> None:
    heavy = '<link name="shaft_out"><inertial>'
    unbalanced = RIG.replace(heavy, f'{heavy}<origin xyz="0.1 0.01 0"/>')
    assert unbalanced != RIG
    for urdf, divisor in ((RIG, 2), (unbalanced, 1)):
        model = equation_of(urdf, 0.1)
        assert (model.divisor, model.period) == (divisor, pytest.approx(2.0 * np.pi / divisor))


def test_large_motions_by_hand() -> None:
    beta, speed = 0.8, 0.9
    model = equation_of(RIG, beta).on(31)
    x = 2.0 * model.positions
    q = np.stack([0.4 * np.cos(x) - 0.2, 0.5 * np.sin(x)], axis=-1)
    course = course_of(q[None], np.array([speed]), model.period)
    equation, system = model.along(course), TiltingShaft(beta, speed)
    missing = [
        course.bend[0, k] - system(phi, course.q[0, k], course.rate[0, k])
        for k, phi in enumerate(model.positions)
    ]
    expected = speed**2 * np.einsum("nij,nj->ni", equation.mass[0], np.array(missing))
    np.testing.assert_allclose(equation.efforts[0], expected, atol=1e-11)
    # By the speed, along the same course.
    ends = [
        model.along(course._replace(speed=np.array([speed + step]))).efforts[0]
        for step in (1e-4, -1e-4)
    ]
    np.testing.assert_allclose(equation.slope[0], (ends[0] - ends[1]) / 2e-4, atol=1e-11)


def test_a_motion_where_the_mechanism_cannot_go_spoils_no_other() -> None:
    model = equation_of(RIG, 0.3)
    q = np.zeros((2, model.count, 2))
    q[1] += 0.5 * np.pi - 0.3  # The joint locks at a right angle, somewhere in the turn.
    q[1, 0] = [0.0, 0.5 * np.pi - 0.3]
    course = course_of(q, np.array([0.8, 0.8]), model.period)
    alone = model.along(type(course)(*(item[:1] for item in course)))
    found = model.along(course)
    np.testing.assert_allclose(found.efforts[0], alone.efforts[0], rtol=0, atol=1e-14)
