"""Compound angles and fork offsets against directions in space."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from testkit.cross_geometry import ULP, cross, dot, norm, relative_errors

from cardan_dyn.analytic import compound_angle as ca
from cardan_dyn.analytic import drive_line

modest = settings(max_examples=80, deadline=None, derandomize=True)
SLOPES = st.floats(-1.4, 1.4)


def direction(vertical, horizontal):
    """A shaft whose projections make these angles with x."""
    return mp.mpf(1), mp.tan(mp.mpf(vertical)), mp.tan(mp.mpf(horizontal))


X = (mp.mpf(1), mp.mpf(0), mp.mpf(0))


def between(a, b):
    return mp.atan2(norm(cross(a, b)), dot(a, b))


@modest
@given(SLOPES, SLOPES)
def test_compound_angle_is_exact(beta_h, beta_v):
    value = ca.compound_angle(beta_h, beta_v)
    reference = between(X, direction(beta_v, beta_h))
    assert relative_errors(value, [reference])[0] <= 8 * ULP


@pytest.mark.parametrize("pair", [(1e-9, 2e-9), (0.0, np.radians(89.999)), (1e-300, 0.0), (0, 0)])
def test_compound_angle_at_the_edges(pair):
    value = ca.compound_angle(*pair)
    h, v = (mp.tan(mp.mpf(x)) for x in pair)
    reference = mp.atan(mp.sqrt(h * h + v * v))
    assert abs(value - float(reference)) <= 2 * ULP * abs(float(reference))


@modest
@given(SLOPES, SLOPES, SLOPES, SLOPES)
def test_fork_offset_is_the_angle_of_the_planes_about_the_common_shaft(h1, v1, h2, v2):
    # The common shaft lies along x; the input shaft comes from the other side.
    axes = np.array(
        [
            [float(c) for c in direction(-v1, -h1)],
            [1.0, 0.0, 0.0],
            [float(c) for c in direction(v2, h2)],
        ]
    )
    formula, exact = ca.fork_offset(h1, v1, h2, v2), ca.offset_between(*axes)
    assert -np.pi / 2 < formula <= np.pi / 2
    assert -np.pi / 2 < exact <= np.pi / 2
    bends = ca.compound_angle([h1, h2], [v1, v2])
    if np.min(bends) > 1e-6:
        difference = (formula - exact) / np.pi
        assert abs(difference - round(difference)) < 1e-9


def test_worked_example():
    gamma = ca.fork_offset(*np.radians([7.0, 15.0, 12.0, -11.5]))
    assert np.degrees(gamma) == pytest.approx(-70.873, abs=5e-4)
    planes = ca.bending_plane(np.radians([7.0, 12.0]), np.radians([15.0, -11.5]))
    reduced = (planes[1] - planes[0] - gamma) / np.pi
    assert reduced == pytest.approx(round(reduced), abs=1e-14)


@pytest.mark.parametrize("bend", [1e-9, 0.3, 1.3])
def test_one_plane_needs_no_offset(bend):
    for sign in (1.0, -1.0):  # W and Z
        assert ca.fork_offset(0.0, bend, 0.0, sign * bend) == 0.0
        assert ca.fork_offset(bend, bend, sign * bend, sign * bend) == 0.0
    assert ca.fork_offset(0.0, bend, bend, 0.0) == np.pi / 2
    assert ca.fork_offset(0.0, bend, -bend, 0.0) == np.pi / 2
    assert ca.fork_offset(0.0, bend, 0.0, 0.0) == 0.0
    assert np.copysign(1.0, ca.fork_offset(0.0, bend, -0.0, bend)) == 1.0


def test_offset_makes_the_output_uniform():
    """The sign of the offset, by the pins of a spatial double shaft with equal angles."""
    axes = np.array([[1.0, -0.3, 0.4], [1.0, 0.0, 0.0], [1.0, 0.5, 0.0]])
    bends = ca.angle_between(axes[:2], axes[1:])
    assert bends[0] == pytest.approx(bends[1], rel=4 * ULP)
    gamma = ca.offset_between(*axes)
    assert abs(gamma) > 0.1
    unit = axes / np.linalg.norm(axes, axis=1)[:, None]
    outputs = []
    for phi in np.linspace(0.0, 3.0, 7):
        start = np.cross(np.cross(unit[0], unit[1]), unit[0])
        start /= np.linalg.norm(start)
        pin = np.cos(phi) * start + np.sin(phi) * np.cross(unit[0], start)
        driven = np.cross(unit[1], pin)
        driven /= np.linalg.norm(driven)
        pin = np.cos(gamma) * driven + np.sin(gamma) * np.cross(unit[1], driven)
        last = np.cross(unit[2], pin)
        normal = np.cross(unit[1], unit[2])
        normal /= np.linalg.norm(normal)
        angle = np.arctan2(last @ np.cross(unit[2], normal), last @ normal)
        outputs.append(angle - phi)
    spread = (np.array(outputs) - outputs[0]) / np.pi
    np.testing.assert_allclose(spread, np.round(spread), atol=1e-12)
    phases = drive_line.fork_phases([gamma], [gamma])
    assert drive_line.residual_angle([bends[0]] * 2, phases) == 0.0


@modest
@given(st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6))
def test_angle_between_is_exact(numbers):
    a, b = np.array(numbers[:3]), np.array(numbers[3:])
    if min(np.linalg.norm(a), np.linalg.norm(b)) < 1e-3:
        return
    reference = between([mp.mpf(x) for x in a], [mp.mpf(x) for x in b])
    assert abs(ca.angle_between(a, b) - float(reference)) <= 8 * ULP


def test_parallel_shafts_have_no_plane():
    line = np.array([0.6, 0.3, -0.2])
    assert ca.angle_between(line, 7 * line) <= 2 * ULP
    assert ca.offset_between(line, 3 * line, [1.0, 0.0, 0.0]) == 0.0
    assert ca.angle_between(line, -line) == pytest.approx(np.pi, abs=2 * ULP)


def test_shapes_nan_and_bad_arguments():
    assert ca.fork_offset(np.zeros((4, 1)), 0.1, 0.2, np.zeros(3)).shape == (4, 3)
    assert np.isnan(ca.compound_angle([0.1, np.nan], 0.2)).tolist() == [False, True]
    assert np.isnan(ca.fork_offset([0.1, np.nan], 0.2, 0.3, 0.1)).tolist() == [False, True]
    axes = np.ones((2, 3))
    axes[1, 0] = np.nan
    assert np.isnan(ca.angle_between(axes, [1.0, 0.0, 0.0])).tolist() == [False, True]
    assert isinstance(ca.compound_angle(0.1, 0.2), float)
    assert isinstance(ca.fork_offset(0.1, 0.2, 0.3, 0.4), float)
    with pytest.raises(ValueError, match=r"beta_v = -1\.6 .*\(-pi/2, pi/2\) rad"):
        ca.compound_angle(0.1, -1.6)
    with pytest.raises(ValueError, match=r"beta_h \(2,\), beta_v \(3,\)"):
        ca.bending_plane(np.zeros(2), np.zeros(3))
    with pytest.raises(ValueError, match="length of axis_2"):
        ca.angle_between([1.0, 0.0, 0.0], [0.0, 0.0, 0.0])
    with pytest.raises(ValueError, match=r"length of axis_1 = inf"):
        ca.angle_between([1.0, np.inf, 0.0], [1.0, 0.0, 0.0])
    with pytest.raises(ValueError, match=r"axis_1 of shape \(2,\)"):
        ca.angle_between([1.0, 0.0], [1.0, 0.0, 0.0])


@pytest.mark.parametrize("size", [1e-320, 1e-200, 1e-100, 1.0, 1e150, 1e200, 1e308])
@pytest.mark.parametrize("other", [1e-200, 1.0, 1e200])
def test_length_of_the_axes_does_not_matter(size, other):
    first, second = np.array([1.0, 0.5, 0.0]), np.array([0.25, 1.0, -0.5])
    cosine = (0.25 + 0.5) / np.sqrt(1.25 * 1.3125)
    value = ca.angle_between(size * first, other * second)
    # Below 1e-308, floats themselves have fewer digits.
    assert value == pytest.approx(np.arccos(cosine), rel=1e-14 if size > 1e-300 else 1e-3)


def test_axes_that_mark_no_direction():
    for axis in ([0.0, 0.0, 0.0], [1.0, np.inf, 0.0]):
        with pytest.raises(ValueError, match=r"length of axis_1"):
            ca.angle_between(axis, [1.0, 0.0, 0.0])
