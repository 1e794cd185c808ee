"""Fork polygons against the composition of joints and against other routes to their limits."""

import numpy as np
import pytest

from cardan_dyn.analytic import drive_line
from cardan_dyn.practice.drive_lines.design import fork_polygon as polygon


def cases() -> list[tuple[np.ndarray, list[int]]]:
    rng = np.random.default_rng(7)
    found = []
    for number in range(60):
        count = int(rng.integers(2, 7))
        corners = (
            [count] if number % 3 else sorted({count, *rng.integers(1, count + 1, 2).tolist()})
        )
        found.append((rng.uniform(0.01, 0.7, count), corners))
    return found


def test_distances_and_angles_are_inverse() -> None:
    betas = np.array([0.0, 1e-9, 0.3, 1.2, 1.57])
    assert polygon.angle(polygon.distance(betas)) == pytest.approx(betas, rel=1e-12)
    assert polygon.distance(betas) == pytest.approx(-np.log(np.cos(betas)), rel=1e-13, abs=1e-17)


def test_corners_are_the_residual_angles() -> None:
    rng = np.random.default_rng(1)
    betas, phases = rng.uniform(0.1, 0.9, 5), rng.uniform(0, np.pi, (20, 5))
    corner = np.zeros(20, dtype=complex)
    for k in range(5):
        corner = polygon.added(corner, np.tan(betas[k] / 2) ** 2 * np.exp(-2j * phases[:, k]))
        residual = drive_line.residual_angle(betas[: k + 1], phases[:, : k + 1])
        assert np.abs(corner) == pytest.approx(np.tan(residual / 2) ** 2, rel=1e-12)


@pytest.mark.slow
def test_polygons_have_the_distances_asked_for() -> None:
    for betas, corners in cases():
        sides = polygon.distance(betas)
        distances = polygon.least_distances(sides, corners)
        links = [polygon.Link(np.array([beta]), np.zeros(1)) for beta in betas]
        least = float(polygon.least_greatest(sides, corners))
        assert distances[corners].max() == pytest.approx(least, abs=1e-14)
        for senses in polygon.turning_senses(sides, distances):
            phases = polygon.polygon_phases(links, distances, senses)
            ends = range(1, len(betas) + 1)
            found = [drive_line.residual_angle(betas[:end], phases[:end]) for end in ends]
            assert polygon.distance(np.array(found)) == pytest.approx(distances[1:], abs=2e-14)


def test_limits_by_intervals_alone() -> None:
    # Bisection on what can be reached, corner by corner, without the sums of the closed form.
    def reached(sides: np.ndarray, corners: list[int], limit: float) -> bool:
        low = high = 0.0
        for k, side in enumerate(sides, 1):
            low, high = max(low - side, side - high, 0.0), high + side
            if k in corners:
                high = min(high, limit)
            if low > high:
                return False
        return True

    for betas, corners in cases():
        sides = polygon.distance(betas)
        low, high = 0.0, float(sides.sum())
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (low, middle) if reached(sides, corners, middle) else (middle, high)
        assert float(polygon.least_greatest(sides, corners)) == pytest.approx(high, abs=1e-14)


def test_what_is_missing_is_a_quotient_of_cosines() -> None:
    betas = np.radians([30.0, 12.0, 10.0])
    missing = polygon.angle(polygon.least_shortfall(polygon.distance(betas)))
    cosines = np.cos(betas)
    assert np.cos(missing) == pytest.approx(cosines[0] / (cosines[1] * cosines[2]), rel=1e-15)
    assert polygon.least_shortfall(polygon.distance(np.array([0.3, 0.3]))) == 0.0


def test_other_corners_stay_as_near_as_they_can() -> None:
    # Four equal joints close as two double shafts, with nothing left in the middle.
    distances = polygon.least_distances(np.full(4, 0.1), [4])
    assert distances == pytest.approx([0.0, 0.1, 0.0, 0.1, 0.0], abs=1e-15)
    assert len(polygon.turning_senses(np.full(4, 0.1), distances)) == 1


def test_triangles_turn_in_both_senses() -> None:
    sides = polygon.distance(np.radians([20.0, 18.0, 15.0]))
    distances = polygon.least_distances(sides, [3])
    assert len(polygon.turning_senses(sides, distances)) == 2


def test_links_move_like_one_joint() -> None:
    link = polygon.Link(np.radians([20.0, 15.0]), np.array([0.0, 0.4]))
    residual = float(drive_line.residual_angle(link.betas, link.phases))
    last = polygon.Link(np.array([residual]), np.zeros(1))
    phases = polygon.polygon_phases([link, last], np.array([0.0, link.side, 0.0]), np.ones(1))
    betas = np.append(link.betas, residual)
    assert drive_line.residual_angle(betas, phases) == pytest.approx(0.0, abs=3e-8)
