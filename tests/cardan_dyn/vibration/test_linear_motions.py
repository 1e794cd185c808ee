"""Linear motions against closed forms and the Newton step of differences."""

from __future__ import annotations

import numpy as np
import pytest
from testkit import elastic_rigs

from cardan_dyn.kit.periodic import amplitudes
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene
from cardan_dyn.motion.vibration.motions.harmonic_balance import Motions
from cardan_dyn.motion.vibration.motions.linear import at_mean, averaged_motions, linear_motions
from cardan_dyn.motion.vibration.motions.search import MotionSearch


def found(urdf: str, beta: float, speed: float) -> Motions:
    search = MotionSearch(rotating_scene(elastic_rigs.scene(urdf, beta)))
    return search.primary(np.array([speed]))[0]


def test_a_linear_equation_with_constant_coefficients_is_solved_exactly() -> None:
    # A spring behind the joint, whose drive decides the motion in front.
    line = elastic_rigs.torsional_line(stiffness_in=None, stiffness_out=0.5, damping_out=0.1)
    motions = found(line, 0.4, 0.7)
    for linear in (linear_motions(motions), averaged_motions(motions)):
        np.testing.assert_allclose(linear, motions.course.q, atol=1e-12)


def test_the_second_order_of_a_spring_in_front() -> None:
    """Small angles: θ'' of order 2 is forced by a β²/2 sin 2φ; see the oracle of lines."""
    beta, speed = 1e-3, 0.8
    motions = found(elastic_rigs.torsional_line(), beta, speed)
    # J₂ η η_θ Ω² = -½ β² Ω² sin 2φ to first order in β², a = ½, on 1 - 4 Ω².
    expected = 0.5 * beta**2 * speed**2 / (1.0 - 4.0 * speed**2)
    for linear in (linear_motions(motions), averaged_motions(motions)):
        size = amplitudes(linear, 1)[0, 1, 0]
        assert abs(size) == pytest.approx(abs(expected), rel=1e-4)


def test_resting_motions_keep_their_means() -> None:
    motions = found(elastic_rigs.torsional_line(), 0.4, 0.7)
    rest = at_mean(motions.course)
    np.testing.assert_allclose(rest.q[0], np.mean(motions.course.q), atol=1e-16)
    assert not np.any(rest.rate)
