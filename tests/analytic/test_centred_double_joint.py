"""Centred double joints against points in the plane."""

import mpmath as mp
import numpy as np
import pytest

from cardan_dyn.analytic import centred_double_joint as cd
from cardan_dyn.analytic import drive_line

HALF = 0.060


def placed(half, offset, beta):
    """Joint angles and slip from the points themselves: the swivel axis in the origin."""
    half, offset, beta = (mp.mpf(x) for x in (half, offset, beta))
    front = mp.matrix([-(half + offset), 0])

    def gap(s):
        return mp.norm(mp.matrix([s * mp.cos(beta), s * mp.sin(beta)]) - front) - 2 * half

    distance = mp.findroot(gap, half - offset)
    rear = mp.matrix([distance * mp.cos(beta), distance * mp.sin(beta)])
    link = mp.atan2(rear[1] - front[1], rear[0] - front[0])
    # The fixed shaft lies along x; the sliding one along beta.
    return beta - link, link, distance - (half - offset)


@pytest.mark.parametrize("degrees", [1e-3, 5.0, 20.0, 35.0, 45.0, 70.0])
@pytest.mark.parametrize("offset", [0.0, 2.91e-3, 0.02])
def test_angles_and_slip_are_those_of_the_points(degrees, offset):
    beta = np.radians(degrees)
    value = cd.centred_joint(HALF, offset, beta)
    reference = [float(x) for x in placed(HALF, offset, beta)]
    assert value == pytest.approx(reference, rel=1e-11, abs=1e-17)


def test_equal_angles_at_the_chosen_one():
    for degrees in (30.0, 35.0):
        beta = np.radians(degrees)
        value = cd.centred_joint(HALF, cd.centre_offset(HALF, beta), beta)
        assert value.beta_1 == pytest.approx(beta / 2, rel=1e-14)
        assert value.beta_2 == pytest.approx(beta / 2, rel=1e-14)


def test_numbers_of_the_usual_joint():
    """a = 60 mm, equal at 35 degrees: X = 2.91 mm, residual angle 3.6 and 8.4 degrees."""
    offset = cd.centre_offset(HALF, np.radians(35.0))
    assert 1e3 * offset == pytest.approx(2.91, abs=0.005)
    joint = cd.centred_joint(HALF, offset, np.radians([20.0, 45.0]))
    betas = np.stack([joint.beta_1, joint.beta_2], axis=-1)
    residual = np.degrees(drive_line.residual_angle(betas, [0.0, np.pi / 2]))
    assert residual == pytest.approx([3.6, 8.4], abs=0.05)


def test_shapes_nan_and_bad_arguments():
    values = cd.centred_joint(0.1, [[0.0], [np.nan]], np.zeros(3))
    assert all(value.shape == (2, 3) for value in values)
    assert np.isnan(values.slip).tolist() == [[False] * 3, [True] * 3]
    assert isinstance(cd.centre_offset(0.1, 0.2), float)
    with pytest.raises(ValueError, match=r"offset = 0\.1 .*half_distance"):
        cd.centred_joint(0.1, 0.1, 0.2)
    with pytest.raises(ValueError, match=r"half_distance = 0\.0"):
        cd.centre_offset(0.0, 0.2)
