"""How far loops are from closed, by what the joint of each type keeps."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn.core.description.description import LoopDescription
from cardan_dyn.core.description.elements import LOOP_TYPES
from cardan_dyn.core.proof.closed_positions import loop_deviation

START = np.vstack([np.eye(3), [0.3, -0.2, 0.5]])
AXIS, AXIS_2 = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
LENGTH = 2.0


def loop(kind: str) -> LoopDescription:
    return LoopDescription("l", kind, "a", "b", np.eye(4), np.eye(4), AXIS, AXIS_2)


def turned(axis: np.ndarray, angle: float) -> np.ndarray:
    x, y, z = np.sin(angle) * axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    along = np.outer(axis, axis)
    return along + np.cos(angle) * (np.eye(3) - along) + cross


@pytest.mark.parametrize("kind", sorted(LOOP_TYPES))
def test_a_joint_makes_up_for_its_own_motions_alone(kind: str) -> None:
    """Of all turns and slides along the frame, those deviate that no joint of the type has."""
    assert loop_deviation(loop(kind), START, START, LENGTH) == 0.0
    slides = {
        "prismatic": [AXIS],
        "cylindrical": [AXIS],
        "planar": [AXIS_2, np.cross(AXIS, AXIS_2)],
    }.get(kind, [])
    turns = {
        "fixed": [],
        "prismatic": [],
        "universal": [AXIS, AXIS_2],
        "spherical": list(np.eye(3)),
    }.get(kind, [AXIS])
    for axis in np.eye(3):
        moved = START.copy()
        moved[3] += 0.1 * axis
        free = any(np.array_equal(axis, own) for own in slides)
        assert loop_deviation(loop(kind), START, moved, LENGTH) == pytest.approx(
            0.0 if free else 0.05
        )
        moved = START.copy()
        moved[:3] = START[:3] @ turned(axis, 0.1).T
        free = any(np.array_equal(axis, own) for own in turns)
        deviation = loop_deviation(loop(kind), START, moved, LENGTH)
        assert deviation < 1e-15 if free else deviation > 0.05
