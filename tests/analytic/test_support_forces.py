"""Support forces of double shafts against the equations of equilibrium, solved at 50 digits."""

import mpmath as mp
import numpy as np
import pytest
from testkit.cross_geometry import cross, norm, turned

from cardan_dyn.analytic import compound_angle
from cardan_dyn.analytic import support_forces as sf

SPANS = sf.Spans(a=0.4, b=0.15, e=0.2, f=0.5)
TORQUE, LENGTH = 900.0, 1.3


def unit(a):
    return [x / norm(a) for x in a]


def row(vector, place, size):
    """One equation: a component of the unknown vector that starts at `place`."""
    line = [mp.mpf(0)] * size
    line[place : place + 3] = vector
    return line


def arm(vector, place, size):
    """Three equations: the moment of the unknown force at `place` with this lever arm."""
    lines = []
    for i in range(3):
        axis = [mp.mpf(i == j) for j in range(3)]
        lines.append(row(cross(axis, vector), place, size))
    return lines


def equilibrium(axes, phi, offset):
    """M_1, M_2, P and the four bearing forces from the statics of all three shafts."""
    e_1, e_2, e_3 = (unit([mp.mpf(x) for x in axis]) for axis in axes)
    T, L = mp.mpf(TORQUE), mp.mpf(LENGTH)
    across = unit(cross(cross(e_1, e_2), e_1))
    pin = turned(across, e_1, mp.mpf(phi))
    driven = unit(cross(e_2, pin))
    second = turned(driven, e_2, mp.mpf(offset))
    last = unit(cross(e_3, second))
    basis = [[mp.mpf(i == j) for j in range(3)] for i in range(3)]
    size = 9
    A, y = [], []
    for vector, place, value in (
        (pin, 0, 0), (driven, 0, 0), (e_1, 0, T), (second, 3, 0), (last, 3, 0), (e_2, 6, 0),
    ):  # fmt: skip
        A.append(row(vector, place, size))
        y.append(mp.mpf(value))
    levers = arm([-L * x for x in e_2], 6, size)
    for axis, lever in zip(basis, levers, strict=True):
        moments = [a - b for a, b in zip(row(axis, 0, size), row(axis, 3, size), strict=True)]
        A.append([a + b for a, b in zip(moments, lever, strict=True)])
        y.append(mp.mpf(0))
    solution = list(mp.lu_solve(mp.matrix(A), mp.matrix(y)))
    M_1, M_2, P = solution[:3], solution[3:6], solution[6:]

    def bearings(force, moment, axis, away, near, span):
        """Unknown: reactions near and far, thrust and torque along the axis."""
        rows, right = [], []
        levers = [
            [a + b for a, b in zip(n, f, strict=True)]
            for n, f in zip(
                arm([near * x for x in away], 0, 8),
                arm([(near + span) * x for x in away], 3, 8),
                strict=True,
            )
        ]
        for i, axis_i in enumerate(basis):
            both = [a + b for a, b in zip(row(axis_i, 0, 8), row(axis_i, 3, 8), strict=True)]
            both[6] = axis[i]
            rows.append(both)
            right.append(-force[i])
            levers[i][7] = axis[i]
            rows.append(levers[i])
            right.append(-moment[i])
        rows += [row(axis, 0, 8), row(axis, 3, 8)]
        right += [mp.mpf(0), mp.mpf(0)]
        reaction = list(mp.lu_solve(mp.matrix(rows), mp.matrix(right)))
        # On the bearings, not on the shaft.
        return [-x for x in reaction[3:6]], [-x for x in reaction[:3]]

    a, b, e, f = (mp.mpf(x) for x in SPANS)
    minus = lambda v: [-x for x in v]  # noqa: E731
    A_, B_ = bearings(minus(P), minus(M_1), e_1, minus(e_1), b, a)
    F_, E_ = bearings(P, M_2, e_3, e_3, e, f)
    return M_1, M_2, P, A_, B_, E_, F_


def floats(vector):
    return np.array([float(x) for x in vector])


ARRANGEMENTS = [
    sf.shaft_axes(np.radians(20.0), np.radians(20.0)),
    sf.shaft_axes(np.radians(25.0), np.radians(10.0)),
    sf.shaft_axes(np.radians(12.0), np.radians(30.0), np.pi),
    sf.shaft_axes(np.radians(15.0), np.radians(18.0), 1.2),
    np.array([[1.0, 0.2, -0.5], [2.0, 0.1, 0.3], [0.5, -0.2, 0.3]]),
]


@pytest.mark.parametrize("axes", ARRANGEMENTS)
@pytest.mark.parametrize("offset", [None, 0.4])
def test_forces_are_those_of_equilibrium(axes, offset):
    rotations = np.array([0.0, 0.4, np.pi / 2, 2.5, -1.1])
    values = sf.double_shaft_wrenches(axes, rotations, TORQUE, LENGTH, offset)
    forces = sf.support_forces(axes, rotations, TORQUE, LENGTH, SPANS, offset)
    used = compound_angle.offset_between(*axes) if offset is None else offset
    for i, phi in enumerate(rotations):
        M_1, M_2, P, *bearings = (floats(v) for v in equilibrium(axes, phi, used))
        np.testing.assert_allclose(values.moment_1[i], M_1, atol=2e-14 * TORQUE)
        np.testing.assert_allclose(values.moment_2[i], M_2, atol=2e-14 * TORQUE)
        np.testing.assert_allclose(values.force[i], P, atol=2e-14 * TORQUE / LENGTH)
        for force, reference in zip(forces, bearings, strict=True):
            np.testing.assert_allclose(force[i], reference, atol=1e-13 * TORQUE)


@pytest.mark.parametrize(("arrangement", "plane_offset"), [("Z", 0.0), ("W", np.pi)])
@pytest.mark.parametrize("degrees", [(20.0, 20.0), (25.0, 10.0), (8.0, 30.0)])
def test_extreme_positions(arrangement, plane_offset, degrees):
    axes = sf.shaft_axes(*np.radians(degrees), plane_offset)
    swept = sf.support_forces(axes, [0.0, np.pi / 2], TORQUE, LENGTH, SPANS)
    sizes = np.array([np.linalg.norm(force, axis=-1) for force in swept])
    tables = sf.planar_support_forces(*np.radians(degrees), TORQUE, LENGTH, SPANS, arrangement)
    np.testing.assert_allclose(sizes.T, tables, atol=1e-12 * TORQUE)


def test_catalogue_formulas():
    beta_1, beta_2 = np.radians([25.0, 10.0])
    a, b, e, f = SPANS
    for arrangement, sign in (("Z", -1), ("W", 1)):
        P = TORQUE * np.cos(beta_1) * (np.tan(beta_1) + sign * np.tan(beta_2)) / LENGTH
        in_plane, normal = sf.planar_support_forces(
            beta_1, beta_2, TORQUE, LENGTH, SPANS, arrangement
        )
        expected = (P * b / a, P * (a + b) / a, P * (e + f) / f, P * e / f)
        assert in_plane == pytest.approx(expected, rel=1e-13)
        input_ = TORQUE * np.tan(beta_1) / a
        output = TORQUE * np.sin(beta_2) / (f * np.cos(beta_1))
        assert normal == pytest.approx((input_, input_, output, output), rel=1e-13)


def test_equal_angles_in_z():
    beta = np.radians(20.0)
    in_plane, _ = sf.planar_support_forces(beta, beta, TORQUE, LENGTH, SPANS)
    assert in_plane == (0.0, 0.0, 0.0, 0.0)
    wrenches = sf.double_shaft_wrenches(sf.shaft_axes(beta, beta), 0.0, TORQUE, LENGTH)
    assert np.linalg.norm(wrenches.force) < 1e-15 * TORQUE / LENGTH


def test_greatest_force_need_not_be_extreme():
    axes = sf.shaft_axes(*np.radians([40.0, 10.0]), np.pi)
    spans = sf.Spans(a=0.26, b=0.18, e=0.146, f=0.127)
    phi = np.linspace(0, np.pi, 721)
    length = 0.94
    swept = np.linalg.norm(sf.support_forces(axes, phi, TORQUE, length, spans).E, axis=-1)
    assert np.max(swept) > 1.01 * max(swept[0], swept[360])


def test_correct_forks_pass_on_the_torque():
    axes = sf.shaft_axes(0.3, 0.3, 0.8)
    wrenches = sf.double_shaft_wrenches(axes, np.linspace(0, 6, 13), TORQUE, LENGTH)
    np.testing.assert_allclose(wrenches.moment_2 @ axes[2], TORQUE, rtol=1e-14)


def test_straight_joints():
    for axes in (
        sf.shaft_axes(0.0, 0.0),
        sf.shaft_axes(0.0, 0.2),
        np.array([[0.6, 0.3, -0.2]] * 3),
    ):
        wrenches = sf.double_shaft_wrenches(axes, [0.0, 1.0], TORQUE, LENGTH)
        direction = axes[0] / np.linalg.norm(axes[0])
        np.testing.assert_allclose(wrenches.moment_1, [TORQUE * direction] * 2, atol=1e-12)


def test_spans_broadcast():
    axes = sf.shaft_axes(0.3, np.array([0.2, 0.4]))
    near = np.array([[0.1], [0.2], [0.3]])
    forces = sf.support_forces(axes, 0.7, TORQUE, LENGTH, SPANS._replace(b=near))
    assert all(force.shape == (3, 2, 3) for force in forces)
    for i in range(3):
        alone = sf.support_forces(axes, 0.7, TORQUE, LENGTH, SPANS._replace(b=near[i, 0]))
        for force, single in zip(forces, alone, strict=True):
            np.testing.assert_array_equal(force[i], single)
    swept = sf.support_forces(axes[0], 0.7, TORQUE, LENGTH, SPANS._replace(f=np.ones(4)))
    assert all(force.shape == (4, 3) for force in swept)


def test_shapes_nan_and_bad_arguments():
    axes = sf.shaft_axes(np.array([[0.1], [0.2], [np.nan]]), np.array([0.1, 0.3]))
    assert axes.shape == (3, 2, 3, 3)
    forces = sf.support_forces(axes, 0.3, TORQUE, LENGTH, SPANS)
    assert all(force.shape == (3, 2, 3) for force in forces)
    missing = np.isnan(forces.A).any(axis=-1)
    assert missing.tolist() == [[False, False], [False, False], [True, True]]
    table, _ = sf.planar_support_forces(np.zeros((2, 1)), 0.1, 1.0, np.ones(3), SPANS)
    assert all(force.shape == (2, 3) for force in table)
    with pytest.raises(ValueError, match=r"length = 0\.0"):
        sf.double_shaft_wrenches(sf.shaft_axes(0.1, 0.1), 0.0, 1.0, 0.0)
    with pytest.raises(ValueError, match=r"axes of shape \(2, 3\)"):
        sf.double_shaft_wrenches(np.ones((2, 3)), 0.0, 1.0, 1.0)
    with pytest.raises(ValueError, match=r"angle of joint 2 in axes = 2\.9"):
        sf.double_shaft_wrenches([[1, 0, 0], [1, 0.1, 0], [-1, 0, 0.2]], 0.0, 1.0, 1.0)
    with pytest.raises(ValueError, match=r"b = -1\.0"):
        sf.planar_support_forces(0.1, 0.1, 1.0, 1.0, SPANS._replace(b=-1.0))
    with pytest.raises(ValueError, match="'X' is not one of 'Z', 'W'"):
        sf.planar_support_forces(0.1, 0.1, 1.0, 1.0, SPANS, "X")
    with pytest.raises(ValueError, match=r"phi_1 \(2,\), .*length \(3,\)"):
        sf.double_shaft_wrenches(sf.shaft_axes(0.1, 0.1), np.zeros(2), 1.0, np.ones(3))
