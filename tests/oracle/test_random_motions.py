"""Random chains: rates of Jacobians, mass matrices and linear models against differences."""

from __future__ import annotations

import numpy as np
import pytest
from compare import scene_of
from scenes import draw
from testkit.coordinates import sloped

from cardan_dyn.kit.arrays import Array

POINT = (0.1, 0.2, 0.3)


def agree(found: Array, expected: Array, tolerance: float, least: float = 1.0) -> None:
    """Compare arrays by the greatest of all numbers, at least by what they are rounded like."""
    size = max(float(np.abs(expected).max()), least)
    np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance * size)


@pytest.mark.slow
# Of those that are left out, the drives move nothing, or differences are as long as the way left.
@pytest.mark.parametrize("seed", [*range(1, 6), 8, 9, 10, 11, 12, 14, 16, 33, 40, 43])
def test_equations_of_motion(seed: int) -> None:
    case = draw(seed)
    scene = scene_of(case).replace(loads=None, drive=[*case.drives])
    position, speed, acceleration = (
        np.reshape(values, (-1, len(case.drives)))[:1]
        for values in (case.positions, case.speeds, case.accelerations)
    )
    turn = scene.sweep(position, speed=speed, acceleration=acceleration)
    efforts = np.reshape(turn.drive_effort, (1, -1))
    least = max(np.abs(part).max() for item in turn.values() for part in (item.force, item.moment))
    needed = (scene.mass_matrix(position) @ acceleration[..., None])[..., 0]
    agree(needed + scene.bias(position, speed), efforts, 1e-13, least)
    regressor = scene.regressor(position, speed, acceleration)
    agree(regressor @ regressor.values + regressor.rotors, efforts, 1e-12, least)
    for link in list(scene.mechanism.links)[-2:]:
        found = scene.jacobian(link, POINT, position=position, speed=speed)

        def at(by: float, link: str = link) -> Array:
            there = position + by * speed
            return np.asarray(scene.jacobian(link, POINT, position=there))

        agree(found.rate, sloped(at, 1e-4), 1e-7)

    def advanced(state: Array) -> Array:
        there, moving = np.split(state[None], 2, axis=1)
        mass, bias = scene.mass_matrix(there)[0], scene.bias(there, moving)[0]
        return np.linalg.solve(mass, efforts[0] - bias)

    state = np.concatenate([position[0], speed[0]])
    units = np.eye(len(state))
    expected = [sloped(lambda by, e=e: advanced(state + by * e), 1e-4) for e in units]
    agree(scene.linear(turn)[0].A[len(speed[0]) :], np.stack(expected, axis=-1), 1e-7)
