"""Lines of joints against the equations of equilibrium of all shafts, solved together.

The reference knows forces and moments at every joint and bearing as unknowns of one linear system:
six equations for every shaft. What the elimination of `analytic.line_forces` assumes (moments
normal to both pins, no axial force in the spline, floating centre bearings) are rows of it.
"""

import numpy as np
import pytest

from cardan_dyn.analytic import support_forces as lf
from cardan_dyn.analytic import support_forces as sf

SPANS = sf.Spans(a=0.4, b=0.15, e=0.2, f=0.5)
TORQUE = 700.0


def skew(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def pins_of(axes, phi, offsets):
    """Driving and driven pin of every joint, turned in space."""

    def turn(v, axis, angle):
        return v * np.cos(angle) + np.cross(axis, v) * np.sin(angle)

    normal = np.cross(axes[0], axes[1])
    pin = turn(np.cross(normal, axes[0]) / np.linalg.norm(normal), axes[0], phi)
    pins = []
    for k in range(1, len(axes)):
        driven = np.cross(axes[k], pin)
        driven /= np.linalg.norm(driven)
        pins.append((pin, driven))
        if k < len(axes) - 1:
            pin = turn(driven, axes[k], offsets[k - 1])
    return pins


def equilibrium(axes, phi, lengths, centres, offsets):
    """Joint moments, and forces on the bearings, as the solution of one system."""
    n = len(axes) - 1
    points = [np.zeros(3)]
    for k in range(1, n):
        points.append(points[-1] + lengths[k - 1] * axes[k])
    unknowns, rows, values = {}, [], []

    def unknown(name):
        return unknowns.setdefault(name, 3 * len(unknowns))

    names = [f"F{k}" for k in range(1, n + 1)] + [f"M{k}" for k in range(1, n + 1)]
    names += [f"C{k}" for k in range(1, n - 1)] + ["A", "B", "E", "F", "drive", "load"]
    for name in names:
        unknown(name)
    size = 3 * len(unknowns)

    def equation(blocks, value):
        """Sum of matrix times unknown is the value; each matrix (m, 3)."""
        lines = np.zeros((len(np.atleast_1d(value)), size))
        for name, matrix in blocks:
            place = unknown(name)
            lines[:, place : place + 3] += matrix
        rows.append(lines)
        values.append(np.atleast_1d(value))

    one, zero = np.eye(3), np.zeros(3)
    # F_k, M_k act on shaft k at joint k, their opposites on shaft k - 1; moments about joint k.
    first, last = points[0], points[-1]
    near, far = first - SPANS.b * axes[0], first - (SPANS.a + SPANS.b) * axes[0]
    equation([("F1", -one), ("A", one), ("B", one)], zero)
    equation(
        [("M1", -one), ("A", skew(far - first)), ("B", skew(near - first)), ("drive", one)], zero
    )
    for k in range(1, n):
        force = [(f"F{k}", one), (f"F{k + 1}", -one)]
        arm = points[k] - points[k - 1]
        moment = [(f"M{k}", one), (f"M{k + 1}", -one), (f"F{k + 1}", -skew(arm))]
        if k < n - 1:
            force.append((f"C{k}", one))
            moment.append((f"C{k}", skew(centres[k - 1] * axes[k])))
        equation(force, zero)
        equation(moment, zero)
    near, far = last + SPANS.e * axes[n], last + (SPANS.e + SPANS.f) * axes[n]
    equation([(f"F{n}", one), ("E", one), ("F", one)], zero)
    equation(
        [(f"M{n}", one), ("E", skew(near - last)), ("F", skew(far - last)), ("load", one)], zero
    )
    for k, (driving, driven) in enumerate(pins_of(axes, phi, offsets), start=1):
        # The cross is free about both pins.
        equation([(f"M{k}", np.array([driving, driven]))], np.zeros(2))
    for name, axis in (("drive", axes[0]), ("load", axes[n])):
        equation([(name, one - np.outer(axis, axis))], zero)
    equation([("drive", axes[0][None])], [TORQUE])
    # Axial: the spline, the centre bearings, and one of both bearings of each end shaft.
    equation([(f"F{n}", axes[n - 1][None])], [0.0])
    for k in range(1, n - 1):
        equation([(f"C{k}", axes[k][None])], [0.0])
    equation([("A", axes[0][None])], [0.0])
    equation([("F", axes[n][None])], [0.0])
    matrix, right = np.concatenate(rows), np.concatenate(values)
    solution, _, rank, _ = np.linalg.lstsq(matrix, right, rcond=None)
    assert rank == size
    np.testing.assert_allclose(matrix @ solution, right, atol=1e-9)
    return {name: solution[place : place + 3] for name, place in unknowns.items()}


def random_line(joints, seed):
    generator = np.random.default_rng(seed)
    axes = [np.array([1.0, 0.0, 0.0])]
    while len(axes) < joints + 1:
        axis = axes[-1] + 0.35 * generator.normal(size=3)
        axes.append(axis / np.linalg.norm(axis))
    lengths = generator.uniform(0.5, 1.6, joints - 1)
    centres = lengths[:-1] * generator.uniform(0.5, 1.2, joints - 2)
    return np.array(axes), lengths, centres, generator.uniform(-2, 2, joints - 1)


@pytest.mark.parametrize("joints", [2, 3, 4, 6])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_random_lines_are_in_equilibrium(joints, seed):
    axes, lengths, centres, offsets = random_line(joints, seed)
    scale = np.array([[2.0], [0.5]] * 4)[: joints + 1]
    for phi in (0.0, 0.7, -2.1):
        reference = equilibrium(axes, phi, lengths, centres, offsets)
        moments = lf.line_moments(scale * axes, phi, TORQUE, offsets)
        forces = lf.line_support_forces(axes, phi, TORQUE, lengths, centres, SPANS, offsets)
        for k in range(joints):
            np.testing.assert_allclose(moments[k], reference[f"M{k + 1}"], atol=1e-10 * TORQUE)
        for k in range(joints - 2):
            np.testing.assert_allclose(
                forces.centres[k], -reference[f"C{k + 1}"], atol=1e-10 * TORQUE
            )
        for name, axis in (("A", axes[0]), ("B", axes[0]), ("E", axes[-1]), ("F", axes[-1])):
            across = -reference[name] + (reference[name] @ axis) * axis
            np.testing.assert_allclose(getattr(forces, name), across, atol=1e-10 * TORQUE)


def test_three_joints_by_the_printed_formula():
    """C = [l_1 Q - (M_1 - M_2) x e_2] / c across e_2, Q = (M_2 - M_3) x e_3 / l_2."""
    axes, lengths, centres, offsets = random_line(3, 8)
    M_1, M_2, M_3 = lf.line_moments(axes, 0.4, TORQUE, offsets)
    Q = np.cross(M_2 - M_3, axes[2]) / lengths[1]
    C = (lengths[0] * Q - np.cross(M_1 - M_2, axes[1])) / centres[0]
    C -= (C @ axes[1]) * axes[1]
    forces = lf.line_support_forces(axes, 0.4, TORQUE, lengths, centres, SPANS, offsets)
    np.testing.assert_allclose(forces.centres[0], -C, atol=1e-11 * TORQUE)


def test_two_joints_are_the_double_shaft():
    axes = sf.shaft_axes(np.radians([25.0, 12.0]), np.radians(10.0), 0.8)
    phi = np.linspace(0, 6, 7)[:, None]
    expected = sf.support_forces(axes, phi, TORQUE, 1.3, SPANS)
    forces = lf.line_support_forces(axes, phi, TORQUE, [1.3], np.zeros(0), SPANS)
    assert forces.centres.shape == (7, 2, 0, 3)
    for name in "ABEF":
        np.testing.assert_allclose(
            getattr(forces, name), getattr(expected, name), atol=1e-12 * TORQUE
        )


def test_straight_line_loads_no_bearing():
    axes = np.tile([1.0, 0.0, 0.0], (4, 1))
    forces = lf.line_support_forces(axes, [0.0, 1.0], TORQUE, [1.0, 1.2], [0.9], SPANS)
    assert all(np.max(np.abs(force)) < 1e-11 for force in forces)


def test_shapes_and_nan():
    axes, lengths, centres, offsets = random_line(3, 5)
    torque = np.array([[1.0], [np.nan]])
    spans = SPANS._replace(f=np.ones((4, 1, 1)))
    forces = lf.line_support_forces(axes, np.zeros(3), torque, lengths, centres, spans, offsets)
    assert forces.A.shape == forces.E.shape == (4, 2, 3, 3)
    assert forces.centres.shape == (4, 2, 3, 1, 3)
    assert np.isnan(forces.B[:, 1]).all()
    assert not np.isnan(forces.centres[:, 0]).any()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"axes": np.ones((1, 3))}, r"axes of shape \(1, 3\)"),
        ({"axes": np.eye(3)[[0, 1]]}, r"angles of the joints in axes\[0\] = 1\.57"),
        ({"axes": np.array([[1, 0, 0], [1, 0.1, 0]])}, "at least 2 are valid"),
        ({"lengths": [1.0, 2.0, 3.0]}, r"lengths of shape \(3,\) does not match \(\.\.\., 2\)"),
        ({"centres": []}, r"centres of shape \(0,\)"),
        ({"centres": [0.0]}, r"centres\[0\] = 0\.0"),
        ({"fork_offsets": [0.1]}, r"fork_offsets of shape \(1,\)"),
    ],
)
def test_bad_arguments(change, message):
    axes, lengths, centres, _ = random_line(3, 5)
    arguments = {"axes": axes, "lengths": lengths, "centres": centres} | change
    with pytest.raises(ValueError, match=message):
        lf.line_support_forces(phi_1=0.1, torque=1.0, spans=SPANS, **arguments)
