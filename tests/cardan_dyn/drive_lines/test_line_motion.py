"""Mean leads against quadrature of the closed forms, and angle errors at any positions."""

import numpy as np
import pytest
from testkit.line_data import double_shaft, random_line

from cardan_dyn.analytic import drive_line
from cardan_dyn.drive_lines import DriveLine, Shaft
from cardan_dyn.practice.drive_lines.line.geometry import zero
from cardan_dyn.practice.drive_lines.verdict.line_motion import mean_leads

TURN = np.linspace(0.0, 2.0 * np.pi, 4096, endpoint=False)


@pytest.mark.slow
@pytest.mark.parametrize(("count", "bend"), [(1, 0.3), (2, 0.5), (4, 0.3), (7, 0.2), (3, 0.8)])
def test_angle_errors_at_any_positions(count: int, bend: float) -> None:
    line = random_line(count, seed=count, bend=bend)
    even = line.analyse(speed=0, torque=0, positions=TURN[::16]).angle_error
    chosen = np.array([3, 4, 5, 90, 200])
    few = line.analyse(speed=0, torque=0, positions=TURN[::16][chosen]).angle_error
    assert few == pytest.approx(even[chosen], abs=1e-14)
    far = TURN[::16][chosen] - 6.0 * np.pi
    turns = line.analyse(speed=0, torque=0, positions=far).angle_error
    assert turns == pytest.approx(few, abs=1e-13)
    # Rotations of the closed form count from elsewhere, so compare without their means.
    single = line.analyse(speed=0, torque=0, positions=0.4).angle_error[0]
    for k in range(1, count + 1):
        output = drive_line.output_angle(
            line.joint_angles[:k], line.fork_phases[:k], np.append(TURN, 0.4)
        ) - np.append(TURN, 0.4)
        assert single[k] == pytest.approx(output[-1] - output[:-1].mean(), abs=1e-13)


@pytest.mark.slow
def test_angle_errors_of_designs() -> None:
    line = double_shaft((0.0, 0.3, -0.1), (0.1, 0.0, 0.2))
    forks = np.linspace(-1, 1, 5)[:, None]
    some = line.analyse(
        speed=0, torque=0, positions=[0.3, 0.9], variants=line.variants(fork_offsets=forks)
    )
    assert some.mean_lead.shape == (5, 3)
    for design, fork in enumerate(forks[:, 0]):
        middle = double_shaft((0.0, 0.3, -0.1), (0.1, 0.0, 0.2), fork_offset=fork)
        alone = middle.analyse(speed=0, torque=0, positions=TURN[::8]).rotation
        lead = alone - alone[:, :1]
        expected = some.rotation[design] - some.rotation[design, :, :1] - lead.mean(axis=0)
        assert some.angle_error[design] == pytest.approx(expected, abs=1e-13)


@pytest.mark.parametrize("degrees", [1e-7, 60.0, 85.0])
def test_the_mean_of_one_joint_is_zero(degrees: float) -> None:
    # The lead is a sine series.
    line = DriveLine(shafts=[Shaft(), Shaft(slope_side=np.radians(degrees))])
    stand = zero(line.geometry, line.fork_offsets)
    mean = mean_leads(stand.driving, stand.driven, stand.rotations)
    assert mean == pytest.approx([0.0, 0.0], abs=1e-14)
