"""Rates, accelerations and multipliers of a group at given positions."""

from __future__ import annotations

import numpy as np
from testkit.groups import guesses, only_group, overconstrained, state_of
from testkit.planar_linkages import (
    four_bar,
    geared,
    solver,
    values,
)

from cardan_dyn.core.kinematics.closing.stacked import same_side
from cardan_dyn.core.kinematics.following.branch import Branch

ANGLES = np.linspace(-0.6, 0.6, 7)


def test_rates_follow_from_closed_positions_by_differences() -> None:
    mechanism = four_bar()
    state = state_of(mechanism, "A", ANGLES)
    group = state.group
    step = 1e-5
    closed = []
    item, reduction, _ = only_group(mechanism, "A")
    for sign in (-1.0, 1.0):
        x = guesses(mechanism, "A", ANGLES + sign * step)
        item.newton(x, reduction)
        closed.append(x)
    columns = mechanism.coordinates.column_of(group.passives)
    slope = (closed[1] - closed[0])[:, columns] / (2.0 * step)
    computed = state.rates(np.full((len(ANGLES), 1, 1), 3.0))[:, :, 0]
    np.testing.assert_allclose(computed, 3.0 * slope, rtol=1e-7, atol=1e-8)


def test_accelerations_follow_from_rates_by_differences() -> None:
    mechanism = four_bar()
    item, reduction, _ = only_group(mechanism, "A")
    step, speed, acceleration = 1e-5, 3.0, -2.0
    rates = []
    for time in (-step, 0.0, step):
        x = guesses(mechanism, "A", ANGLES + speed * time + 0.5 * acceleration * time**2)
        state = item.newton(x, reduction)
        drive_rates = np.full((len(ANGLES), 1), speed + acceleration * time)
        rates.append(state.rates(drive_rates[:, :, None])[:, :, 0])
        if time == 0.0:
            v = np.zeros((len(ANGLES), mechanism.model.nv))
            v[:, item.group.known], v[:, item.group.passives] = drive_rates, rates[-1]
            computed = state.accelerations(v, np.full((len(ANGLES), 1), acceleration))
    np.testing.assert_allclose(computed, (rates[2] - rates[0]) / (2.0 * step), rtol=1e-6, atol=1e-6)


def test_equations_are_solved_like_numpy_solves_them() -> None:
    state = state_of(four_bar(), "A", ANGLES)
    generator = np.random.default_rng(5)
    right = generator.normal(size=(len(ANGLES), 3))
    expected = np.array(
        [np.linalg.solve(rows.T, b) for rows, b in zip(state.passive_rows, right, strict=True)]
    )
    np.testing.assert_allclose(state.solve(right[:, :, None])[:, :, 0], expected, rtol=1e-12)


def test_redundant_equations_have_the_least_solution() -> None:
    mechanism = overconstrained()
    state = state_of(mechanism, "A", ANGLES)
    assert np.max(state.residual) < 1e-14
    count, p, r = state.passive_rows.shape
    assert (p, r) == (5, 6)
    pseudoinverses = np.linalg.pinv(state.passive_rows)
    np.testing.assert_allclose(state.inverse, pseudoinverses, atol=1e-12)
    # A parallelogram: all rockers turn alike, the coupler does not.
    velocities = mechanism.coordinates.velocity_columns
    rates = state.rates(np.full((count, 1, 1), 2.0))[:, :, 0]
    of = {name: state.group.passives.tolist().index(velocities[name].start) for name in "BDECF"}
    for name, expected in (("B", -2.0), ("D", 2.0), ("E", 2.0), ("C", 2.0), ("F", 2.0)):
        np.testing.assert_allclose(rates[:, of[name]], expected, rtol=1e-12)
    values_of = np.linalg.svd(state.passive_rows, compute_uv=False)
    np.testing.assert_allclose(state.condition, values_of[:, 0] / values_of[:, -1], rtol=1e-9)


def test_accelerations_of_a_coupling_follow_its_ratio() -> None:
    mechanism = geared(-2.5)
    state = state_of(mechanism, "A", np.array([0.1, 0.2]))
    v = np.random.default_rng(1).normal(size=(2, mechanism.model.nv))
    computed = state.accelerations(v, np.array([[2.0], [-1.0]]))
    np.testing.assert_allclose(computed, [[-5.0], [2.5]], rtol=1e-15)


def test_sides_of_a_dead_point_differ() -> None:
    """Crank and coupler of a driven rocker bend to either side of their line."""
    mechanism = four_bar()
    kinematics, start = solver(mechanism, "A")
    branch = Branch(kinematics, start)
    branch.cover(-np.pi, np.pi)
    positions = np.linspace(-np.pi, np.pi, 721)
    x = kinematics.close(branch.guess(positions)).x
    rocker = values(mechanism, x, "D")
    item, reduction, _ = only_group(mechanism, "D")
    state = item.evaluate(x, reduction)
    same = same_side(state.square, np.repeat(state.inverse[[360]], len(x), axis=0))
    # On the side of position zero, the rocker moves with the crank as it does there.
    slope = np.gradient(rocker, positions)
    is_clear = np.abs(slope) > 0.01
    np.testing.assert_array_equal(same[is_clear], (slope * slope[360] > 0.0)[is_clear])
    assert 100 < np.sum(same) < 621
