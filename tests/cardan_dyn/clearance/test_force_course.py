"""Force courses of known forces."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from cardan_dyn.clearance.force_course import ForceCourse

PHI = 2.0 * np.pi / 720 * np.arange(720)


def course(x: np.ndarray, y: np.ndarray) -> ForceCourse:
    return ForceCourse(np.stack([x, y, 0.0 * x], axis=1), 2.0 * np.pi)


def test_a_force_along_a_line_vanishes_twice() -> None:
    shift = 0.1234
    swings = course(3.0 * np.sin(PHI - shift), 4.0 * np.sin(PHI - shift)).swings(1.0)
    assert [item.position for item in swings] == pytest.approx([shift, np.pi + shift], abs=1e-12)
    assert [item.least for item in swings] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert [item.slope for item in swings] == pytest.approx([5.0, 5.0], rel=1e-12)
    np.testing.assert_allclose(swings[0].direction, [0.6, 0.8, 0.0], atol=1e-12)
    np.testing.assert_allclose(swings[1].direction, [-0.6, -0.8, 0.0], atol=1e-12)
    assert swings[0].way == pytest.approx(np.pi / 2, abs=0.01)


def test_the_sense_turns_directions_and_ways() -> None:
    x = np.sin(PHI) + 0.3 * np.sin(2.0 * PHI)
    forward, backward = (course(x, 0.0 * x).swings(sense)[0] for sense in (1.0, -1.0))
    np.testing.assert_allclose(forward.direction, -backward.direction, atol=1e-12)
    assert forward.position == pytest.approx(backward.position, abs=1e-12)
    # sin φ + 0.3 sin 2φ is greatest at 0.3333 π to either side of its zero at 0, least there at π.
    greatest = np.arccos((np.sqrt(1.0 + 8.0 * 0.36) - 1.0) / (4.0 * 0.6))
    assert (forward.way, backward.way) == pytest.approx((greatest, greatest), abs=0.01)
    shifted = course(np.sin(PHI) + 0.3 * np.sin(2.0 * PHI + 1.0), 0.0 * PHI)
    for sense in (1.0, -1.0):
        item = shifted.swings(sense)[0]
        sizes = np.abs(np.sin(turned := item.position + sense * PHI) + 0.3 * np.sin(2 * turned + 1))
        peak = PHI[1:-1][(sizes[1:-1] > sizes[:-2]) & (sizes[1:-1] > sizes[2:])][0]
        assert item.way == pytest.approx(peak, abs=0.02)


def test_an_ellipse_has_its_least_force_on_the_short_axis() -> None:
    swings = course(5.0 * np.cos(PHI), 0.2 * np.sin(PHI)).swings(1.0)
    assert [item.position for item in swings] == pytest.approx([np.pi / 2, 1.5 * np.pi], abs=1e-9)
    assert [item.least for item in swings] == pytest.approx([0.2, 0.2], rel=1e-12)
    assert swings[0].slope == pytest.approx(5.0, rel=1e-12)


def test_a_force_that_stays_has_none() -> None:
    assert course(2.0 + np.cos(PHI), 0.0 * PHI + 5.0).swings(1.0)[0].least > 5.0
    assert course(0.0 * PHI + 2.0, 0.0 * PHI).swings(1.0) == []


def test_the_tail_tells_of_corners() -> None:
    assert course(np.sin(PHI), np.cos(PHI)).tail < 1e-14
    assert course(np.abs(np.sin(PHI)), 0.0 * PHI).tail > 1e-6
    # A component that is mere rounding beside the others is no corner.
    noise = 1e-13 * np.random.default_rng(1).standard_normal(len(PHI))
    assert course(np.sin(PHI), noise).tail < 1e-12


def test_the_slope_grows_with_the_cube_of_the_speed_where_inertia_acts() -> None:
    assert course(np.sin(PHI), 0.1 * np.cos(PHI)).swings(1.0)[0].growth == 3.0


def test_the_growth_of_a_slope_beside_a_constant_force() -> None:
    """F = Ω² sin φ - C: zero at sin φ = C / Ω², of slope Ω³ cos φ."""
    still, zero = 0.4, 0.0 * PHI
    forces, inertial = (
        np.stack([x, zero, zero], axis=1) for x in (np.sin(PHI) - still, np.sin(PHI))
    )
    found = ForceCourse(forces, 2.0 * np.pi, inertial).swings(1.0)
    # d ln(Ω √(Ω⁴ - C²)) / d ln Ω at Ω = 1.
    expected = 1.0 + 2.0 / (1.0 - still**2)
    assert [item.growth for item in found] == pytest.approx([expected, expected], rel=1e-10)
    assert found[0].position == pytest.approx(np.arcsin(still), abs=1e-10)


def test_the_growth_of_an_ellipse_beside_a_constant_force() -> None:
    """Against differences of the least of |Ω² (cos φ, b sin φ) + C| found on a fine grid."""
    constant = np.array([0.05, 0.02])

    def slope(speed: float) -> float:
        def force(phi: float) -> np.ndarray:
            return speed**2 * np.array([np.cos(phi), 0.2 * np.sin(phi)]) + constant

        best = minimize_scalar(
            lambda phi: float(force(phi) @ force(phi)), bounds=(1.0, 2.2), options={"xatol": 1e-12}
        ).x
        return float(speed**3 * np.hypot(np.sin(best), 0.2 * np.cos(best)))

    inertial = np.stack([np.cos(PHI), 0.2 * np.sin(PHI), 0.0 * PHI], axis=1)
    whole = inertial + np.append(constant, 0.0)
    item = ForceCourse(whole, 2.0 * np.pi, inertial).swings(1.0)[0]
    step = 1e-3
    expected = np.log(slope(np.exp(step)) / slope(np.exp(-step))) / (2.0 * step)
    assert item.growth == pytest.approx(expected, rel=1e-5)


def test_dips_of_rounding_in_a_force_of_constant_size_are_no_swings() -> None:
    noise = 1e-13 * np.random.default_rng(2).standard_normal((2, len(PHI)))
    assert course(np.cos(PHI) + noise[0], np.sin(PHI) + noise[1]).swings(1.0) == []
    # Beside dips that are none of it.
    found = course(np.cos(PHI) + noise[0], 0.5 * np.sin(PHI) + noise[1]).swings(1.0)
    assert [item.position for item in found] == pytest.approx([0.5 * np.pi, 1.5 * np.pi], abs=1e-6)


def test_a_force_that_touches_zero_and_comes_back_has_no_swing() -> None:
    assert course(1.0 - np.cos(PHI - 0.2), 0.0 * PHI).swings(1.0) == []
    assert len(course(0.999 - np.cos(PHI - 0.2), 0.0 * PHI).swings(1.0)) == 2
