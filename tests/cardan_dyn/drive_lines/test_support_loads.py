"""Bearing forces against the closed form of two joints, and against the mechanism of any line."""

import numpy as np
import pytest
from testkit.line_data import double_shaft, random_line

from cardan_dyn import ModelError
from cardan_dyn.analytic import support_forces
from cardan_dyn.drive_lines import Bearing, DriveLine, Shaft
from cardan_dyn.practice.drive_lines.design.support_loads import moments, support_loads


@pytest.mark.parametrize("seed", range(4))
def test_double_shafts(seed: int) -> None:
    rng = np.random.default_rng(seed)
    side, plan = rng.uniform(-0.4, 0.4, (2, 3))
    line = double_shaft(tuple(side), tuple(plan), rng.uniform(-1, 1))
    loads = support_loads(line)
    phi = np.linspace(0, np.pi, 7)
    found = loads.forces(line.fork_phases, phi - line.fork_phases[0], 100.0)
    spans = support_forces.Spans(a=0.12, b=0.06, e=0.07, f=0.15)
    closed = support_forces.support_forces(
        line.geometry.directions, phi, 100.0, 0.9, spans, line.fork_offsets[0]
    )
    # The closed form tells what shafts exert on bearings.
    expected = -np.stack([getattr(closed, name) for name in loads.names], axis=-2)
    assert found == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())
    squares = loads.squares(line.fork_phases, phi - line.fork_phases[0])
    assert 1e4 * squares == pytest.approx(np.sum(expected**2, axis=-1), rel=1e-11)


@pytest.mark.parametrize("count", [2, 3, 4, 5])
def test_mechanisms(count: int) -> None:
    line = random_line(count, seed=count)
    loads = support_loads(line)
    position = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    analysis = line.analyse(speed=0.0, torque=50.0, positions=position)
    found = np.linalg.norm(loads.forces(line.fork_phases, position, 50.0), axis=-1)
    expected = {
        name: analysis.total.bearing_radial[:, k] for k, name in enumerate(analysis.bearings)
    }
    size = max(values.max() for values in expected.values())
    assert sorted(loads.names) == sorted(expected)
    for k, name in enumerate(loads.names):
        assert found[:, k] == pytest.approx(expected[name], abs=1e-9 * size)


def test_moments_pass_on_the_torque() -> None:
    rng = np.random.default_rng(3)
    betas, phases = rng.uniform(0.1, 0.8, 4), rng.uniform(0, 3, 4)
    found = moments(betas, phases, np.linspace(0, 3, 50))
    along_next = np.stack([np.cos(betas), np.sin(betas), 0 * betas], axis=-1)
    assert np.sum(found * along_next, axis=-1)[:, :-1] == pytest.approx(found[:, 1:, 0], rel=1e-13)


def test_lines_that_are_not_held_or_held_too_often() -> None:
    with pytest.raises(ModelError, match="has no bearings whose forces"):
        support_loads(DriveLine(shafts=[Shaft(), Shaft(length=1), Shaft(slope_side=0.1)]))
    line = double_shaft((0.0, 0.1, 0.0))
    many = (*line.shafts[0].bearings, Bearing(distance=0.5))
    first = Shaft(bearings=many)
    with pytest.raises(ModelError, match="statics leaves the force of bearing"):
        support_loads(line.replace(shafts=(first, *line.shafts[1:])))
