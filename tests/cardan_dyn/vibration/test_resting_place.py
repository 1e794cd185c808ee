"""Where free coordinates stand in the mean."""

from __future__ import annotations

import numpy as np
import pytest
from testkit import elastic_rigs

import cardan_dyn as cd
from cardan_dyn import vibration
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene
from cardan_dyn.motion.vibration.motions.search import MotionSearch

BETA = 0.2
LINE = elastic_rigs.torsional_line(0.5, 0.3, 1.0, 2.0)


def scene(rest: float, load: float = 0.0) -> cd.Scene:
    """A line whose springs are without effort at angles far from zero."""
    springs = [cd.JointSpring("twist_in", 1.0, 0.02, rest), cd.JointSpring("twist_out", 2.0)]
    plain = elastic_rigs.scene(LINE, BETA, loads={"bearing_out": load})
    return plain.replace(elements=springs)


def test_springs_and_mean_torque_say_where() -> None:
    """In the mean over a revolution the ratio is 1; nothing loads the shaft behind."""
    (rest,) = MotionSearch(rotating_scene(scene(2.9, -0.4))).resting(np.array([0.7]))
    found = rest.course.q[0, 0]
    torque = np.mean(_ratio(np.linspace(0.0, np.pi, 48, endpoint=False))) * 0.4
    assert found == pytest.approx([2.9 - torque, 0.0], abs=1e-3)
    assert np.max(np.abs(np.mean(rest.equation.efforts, axis=1))) < 1e-12


def _ratio(turn: np.ndarray) -> np.ndarray:
    """Speed behind the joint by that in front of it."""
    return np.cos(BETA) / (1.0 - (np.sin(BETA) * np.cos(turn)) ** 2)


@pytest.mark.slow
def test_motions_far_from_the_start_are_found() -> None:
    near, far = (vibration.periodic_motion(scene(rest), [0.6, 0.8]) for rest in (0.0, 2.9))
    mean = near.amplitude[:, 0, 0] - far.amplitude[:, 0, 0]
    assert np.abs(mean + 2.9) == pytest.approx(0.0, abs=0.01)
    # Half a turn less 0.24 rad: swings are as large, and stand elsewhere in the turn.
    turn = np.linspace(0.0, np.pi, 200)
    sizes = [np.ptp(item.at(turn).position[:, :, 0]) for item in (near, far)]
    assert sizes[0] == pytest.approx(sizes[1], rel=0.02)
