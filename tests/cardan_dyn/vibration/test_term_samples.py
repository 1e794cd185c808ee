"""Samples of terms at many places, and their scales."""

from __future__ import annotations

import numpy as np
import pytest
from testkit import elastic_rigs

from cardan_dyn.motion.vibration.model.build import TermSamples
from cardan_dyn.motion.vibration.model.efforts import Terms
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene


@pytest.fixture(scope="module")
def samples() -> TermSamples:
    return TermSamples(rotating_scene(elastic_rigs.scene(elastic_rigs.elastic_rig(0.3), 0.4)))


def test_ways_are_taken_from_each_place(samples: TermSamples) -> None:
    drive, centre = np.array([0.3, 1.9]), np.array([[0.0, 0.1], [-0.2, 0.05]])
    ways = np.array([[0.01, 0.0], [0.0, -0.02], [0.03, 0.03]])
    found = samples.about(drive, centre, ways)
    assert found.shape == (2, 3, 30)
    for place, way in np.ndindex(2, 3):
        alone = samples.at(drive[place : place + 1], (centre[place] + ways[way])[None])
        np.testing.assert_allclose(found[place, way], alone[0], atol=1e-14)


def test_scales_are_those_of_each_effort_and_kind(samples: TermSamples) -> None:
    terms = Terms(np.zeros((2, 2, 2)), np.zeros((2, 2, 3, 3)), np.zeros((2, 2, 3)), np.ones((2, 2)))
    terms.mass[1, 0, 1] = -3.0
    terms.mass[0, 1, 0] = 2.0
    terms.quadratic[0, 0, 2, 1] = 7.0
    terms.static[1, 1] = -9.0
    found = Terms.of_flat(samples.kinds(terms.flat()), 2)
    assert found.mass.tolist() == [[3.0, 3.0], [2.0, 2.0]]
    # Without velocity terms of its own, an effort has those of its mass matrix.
    assert np.all(found.quadratic[0] == 7.0)
    assert np.all(found.quadratic[1] == 2.0)
    assert found.static.tolist() == [1.0, 9.0]
