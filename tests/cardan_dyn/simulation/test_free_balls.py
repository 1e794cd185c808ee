"""Free balls: which angles a rotation goes on into, over long parts of a step and short ones."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import cardan_dyn as cd
from cardan_dyn.core.mechanism.mechanism import Mechanism
from cardan_dyn.kit.arrays import Array
from cardan_dyn.motion.simulation.free_balls import WithBalls

BODY = """<robot name="top"><link name="ground"/><link name="top"><inertial><mass value="2"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="base" type="floating"><parent link="ground"/><child link="top"/></joint></robot>"""
PARTS = np.linspace(0.0, 1.0, 129)


@pytest.fixture(scope="module")
def mechanism() -> Mechanism:
    turns = [f"base.{part}" for part in ("x", "y", "z", "turn_x", "turn_y", "turn_z")]
    return cd.Scene(cd.load(BODY), free=turns).mechanism


@pytest.mark.parametrize("rate", [1.0, 3.0, 6.0, 12.0])
@pytest.mark.parametrize("beside", [1.0, 1e-2, 1e-5])
@pytest.mark.parametrize("seed", range(10))
def test_angles_go_on_as_over_short_parts(
    mechanism: Mechanism, rate: float, beside: float, seed: int
) -> None:
    """A turn in the world and one in the body, about fixed axes, near gimbal lock at the start."""
    made, random = WithBalls(mechanism, [4]), np.random.default_rng(seed)
    (ball,) = made.balls
    world, body = random.normal(size=(2, 3)) * rate / np.sqrt(12.0)
    start = random.uniform(-3.0, 3.0, 3)
    start[1] = 0.5 * np.pi + beside * random.normal()
    begun = Rotation.from_quat(ball.quaternion(start))

    def way(time: float) -> tuple[Array, Array]:
        turned = Rotation.from_rotvec(time * world) * begun * Rotation.from_rotvec(time * body)
        row, v = np.zeros(made.coordinates.size), np.zeros(6)
        row[ball.ball : ball.ball + 4] = turned.as_quat()
        v[ball.rates_of] = turned.inv().apply(world) + body
        return row, v

    found = ball.followed(start, (0.0, 1.0), (way(0.0), way(1.0)), way)
    expected = start
    for ends in pairwise(PARTS.tolist()):
        expected = ball.followed(expected, ends, (way(ends[0]), way(ends[1])), way)
    np.testing.assert_allclose(found, expected, atol=1e-6)
