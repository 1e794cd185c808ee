"""Rows of coordinates: their layout, how they move and what they are for Pinocchio."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from testkit.mixed_chain import MIXED, moved, rows

import cardan_dyn as cd

STEP = 1e-4
CROSS = ["cross.turn_1", "cross.turn_2"]


@pytest.fixture(scope="module")
def mechanism() -> cd.Mechanism:
    return cd.load(MIXED)


@pytest.fixture(scope="module")
def motion(mechanism: cd.Mechanism) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(1)
    v, a = rng.uniform(-1.0, 1.0, (2, 5, mechanism.model.nv))
    return rows(mechanism, 5), v, a


def test_rows_have_four_columns_per_ball_and_one_per_other_part(mechanism: cd.Mechanism) -> None:
    coordinates = mechanism.coordinates
    widths = {name: span.stop - span.start for name, span in coordinates.columns.items()}
    assert widths == {"turn": 1, "slide": 1, "swing": 1, "ball": 4, "hinge": 1, "cross": 2}
    assert coordinates.size == 10
    rates = {name: span.stop - span.start for name, span in coordinates.velocity_columns.items()}
    assert rates == {"turn": 1, "slide": 1, "swing": 1, "ball": 3, "hinge": 1, "cross": 2}
    slide = coordinates.columns["slide"].start
    expected = np.ones(10)
    expected[slide] = 1.0 / mechanism.characteristic_length
    np.testing.assert_array_equal(coordinates.scale, expected)
    assert slide not in coordinates.angle_columns
    assert len(coordinates.angle_columns) == 5


def test_neutral_is_zero_but_for_the_scalars_of_quaternions(mechanism: cd.Mechanism) -> None:
    coordinates = mechanism.coordinates
    expected = np.zeros(coordinates.size)
    expected[coordinates.columns["ball"].stop - 1] = 1.0
    np.testing.assert_array_equal(coordinates.neutral(), expected)


def test_column_of_finds_the_columns_of_velocities(mechanism: cd.Mechanism) -> None:
    coordinates = mechanism.coordinates
    names = ["hinge", "turn", "slide"]
    velocities = np.array([coordinates.velocity_columns[name].start for name in names])
    expected = [coordinates.columns[name].start for name in names]
    assert coordinates.column_of(velocities).tolist() == expected


def test_turns_and_slides_are_found_by_name(mechanism: cd.Mechanism) -> None:
    coordinates = mechanism.coordinates
    assert set(coordinates.named) == {*("turn", "slide", "swing", "hinge"), *CROSS}
    assert coordinates.named["slide"].slides and not coordinates.named["cross.turn_2"].slides
    first = coordinates.columns["cross"].start
    assert coordinates.columns_of(CROSS) == [first, first + 1]
    rate = coordinates.velocity_columns["cross"].start
    assert coordinates.rates_of(CROSS[::-1]) == [rate + 1, rate]
    ball = coordinates.velocity_columns["ball"].start
    angles = ["ball.x", "ball.y", "ball.z"]
    assert coordinates.names_of({ball + 1, rate + 1}) == [*angles, "cross.turn_2"]
    variant = mechanism.variant(["ball"]).coordinates
    assert variant.names_of({ball + 1}) == ["ball.y"]
    assert variant.columns["ball"].stop - variant.columns["ball"].start == 3
    assert variant.neutral().tolist() == [0.0] * 9


def test_configurations_are_those_of_pinocchio(mechanism: cd.Mechanism) -> None:
    """A step in Pinocchio's own configuration space leads to the same configuration."""
    coordinates, model = mechanism.coordinates, mechanism.model
    x = rows(mechanism, 4)
    step = np.random.default_rng(2).uniform(-3.0, 3.0, (4, model.nv))
    after = x.copy()
    coordinates.moves(np.arange(model.nv)).apply(after, step)
    for row, displacement, result in zip(x, step, after, strict=True):
        q = coordinates.configuration(row[None])[0]
        expected = pinocchio.integrate(model, q, displacement)
        found = coordinates.configuration(result[None])[0]
        # The two quaternions of a rotation are the same configuration.
        assert pinocchio.isSameConfiguration(model, found, expected, 1e-12)


def test_moves_change_nothing_but_the_chosen_joints(mechanism: cd.Mechanism) -> None:
    coordinates = mechanism.coordinates
    slide, ball = (coordinates.velocity_columns[name] for name in ("slide", "ball"))
    velocities = np.array([*range(ball.start, ball.stop), slide.start])
    moves = coordinates.moves(velocities)
    assert moves.slides.tolist() == [3]
    ball_column = coordinates.columns["ball"].start
    assert moves.quaternions.tolist() == [list(range(ball_column, ball_column + 4))]
    assert moves.rotations.tolist() == [[0, 1, 2]]
    x = rows(mechanism, 3)
    after = x.copy()
    moves.apply(after, np.array([[0.0, 0.0, np.pi, 0.25]] * 3))
    changed = np.any(after != x, axis=0)
    expected = np.zeros(coordinates.size, dtype=bool)
    expected[coordinates.columns["ball"]] = expected[coordinates.columns["slide"]] = True
    assert changed.tolist() == expected.tolist()
    # A half turn about z of the ball's own frame: q (0, 0, 1, 0).
    a, b, c, d = x[:, coordinates.columns["ball"]].T
    np.testing.assert_allclose(
        after[:, coordinates.columns["ball"]], np.stack([b, -a, d, -c], axis=1), atol=1e-15
    )
    np.testing.assert_allclose(
        after[:, coordinates.columns["slide"]], x[:, coordinates.columns["slide"]] + 0.25
    )


def test_derivative_is_that_of_moving_rows(
    mechanism: cd.Mechanism, motion: tuple[np.ndarray, np.ndarray, np.ndarray]
) -> None:
    x, v, a = motion
    ahead, behind = (moved(mechanism, x, v, a, t) for t in (STEP, -STEP))
    expected = (ahead - behind) / (2.0 * STEP)
    np.testing.assert_allclose(mechanism.coordinates.derivative(x, v), expected, atol=1e-7)


def test_curvature_is_the_second_derivative_of_moving_rows(
    mechanism: cd.Mechanism, motion: tuple[np.ndarray, np.ndarray, np.ndarray]
) -> None:
    x, v, a = motion
    ahead, behind = (moved(mechanism, x, v, a, t) for t in (STEP, -STEP))
    expected = (ahead - 2.0 * x + behind) / STEP**2
    np.testing.assert_allclose(mechanism.coordinates.curvature(x, v, a), expected, atol=1e-6)


def test_normalised_rows_have_unit_quaternions(mechanism: cd.Mechanism) -> None:
    coordinates = mechanism.coordinates
    x = rows(mechanism, 3)
    longer = x.copy()
    longer[:, coordinates.columns["ball"]] *= [[2.0], [0.1], [1.0]]
    np.testing.assert_allclose(coordinates.normalised(longer), x, rtol=1e-14)


def test_what_is_apart_ignores_whole_turns_and_signs_of_quaternions_alone(
    mechanism: cd.Mechanism,
) -> None:
    coordinates = mechanism.coordinates
    x = rows(mechanism, 3)
    same = x.copy()
    same[:, coordinates.angle_columns] += 2.0 * np.pi * np.arange(5)
    same[:, coordinates.columns["ball"]] *= -1.0
    apart = coordinates.apart(x, x[0])
    np.testing.assert_allclose(apart[0], 0.0, atol=1e-15)
    np.testing.assert_allclose(coordinates.apart(same, x[0]), apart, atol=1e-14)
    for column in range(coordinates.size):
        other = x.copy()
        other[:, column] += 0.1
        off = np.max(np.abs(coordinates.apart(other, x[0]) - apart), axis=1)
        assert np.all(off > 0.01)


@pytest.mark.parametrize("angle", [0.3, -2.0, np.pi])
def test_how_far_apart_a_turned_ball_is(mechanism: cd.Mechanism, angle: float) -> None:
    """As far as a turn by the same angle, about whichever axis and from wherever it stands."""
    coordinates = mechanism.coordinates
    first = rows(mechanism, 1)[0]
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    turned = first.copy()
    own = coordinates.columns["ball"]
    by = pinocchio.Quaternion(*np.append(np.cos(0.5 * angle), np.sin(0.5 * angle) * axis))
    turned[own] = (pinocchio.Quaternion(first[own]) * by).coeffs()
    apart = np.linalg.norm(coordinates.apart(turned[None, :], first))
    np.testing.assert_allclose(apart, 2.0 * np.abs(np.sin(0.5 * angle)), rtol=1e-12)
