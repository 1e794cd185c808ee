"""Regions of instability against the monodromy matrices of the full equations."""

import numpy as np
import pytest
from shooting import edge, periodic
from vibrating_lines import ElasticMiddleShaft, SpringsOnBothSides

from cardan_dyn.analytic import parametric_regions as pr
from cardan_dyn.analytic import torsional_speed

BETA = np.radians(6.0)
INERTIAS = 0.4, 0.15, 0.7
STIFFNESS = 1.3, 0.9


def motion(speed, damping=(0.0, 0.0), beta=BETA):
    return periodic(SpringsOnBothSides(beta, speed, INERTIAS, STIFFNESS, damping), np.zeros(4))


def measure(number):
    """Of region 1 or 2 a multiplier at -1, of the combined one the discriminant."""
    if number == 1:
        return lambda speed: motion(speed).discriminant
    return lambda speed: np.linalg.det(motion(speed).monodromy + np.eye(4))


@pytest.mark.slow
@pytest.mark.parametrize("number", [0, 1, 2])
def test_ends_of_the_regions(number):
    """To the next order, β² of the width and a tenth of it for the middle."""
    regions = pr.two_spring_regions(BETA, *INERTIAS, *STIFFNESS)
    middle, half = float(regions.middle[number]), float(regions.half_width[number])
    # Over a region as narrow as this the measure is a parabola.
    places = np.array([-1.0, 0.0, 1.0])
    values = [measure(number)(middle + half * place) for place in places]
    ends = np.sort(np.roots(np.polyfit(places, values, 2)))
    assert np.ptp(ends) / 2.0 == pytest.approx(1.0, rel=1e-3)
    assert np.mean(ends) == pytest.approx(0.0, abs=0.02)


def test_modes_are_those_of_the_line():
    """Eigenvalue problem in its own coordinates; orthogonal, with unit modal mass."""
    modes = pr.two_spring_modes(*INERTIAS, *STIFFNESS)
    mass = np.diag([INERTIAS[0] + INERTIAS[1], INERTIAS[2]])
    stiffness = np.array([[sum(STIFFNESS), -STIFFNESS[1]], [-STIFFNESS[1], STIFFNESS[1]]])
    shapes = np.stack([modes.fork, modes.flywheel])
    np.testing.assert_allclose(shapes.T @ mass @ shapes, np.eye(2), atol=1e-14)
    diagonal = np.diag(modes.frequencies**2)
    np.testing.assert_allclose(shapes.T @ stiffness @ shapes, diagonal, atol=1e-13)
    assert modes.frequencies[0] < modes.frequencies[1]


@pytest.mark.slow
@pytest.mark.parametrize("damping", [(1e-4, 2e-4), (2e-5, 6e-4)])
def test_growth_and_ends_with_damping(damping):
    regions = pr.two_spring_regions(BETA, *INERTIAS, *STIFFNESS, *damping)
    growth = [
        float(np.log(np.max(np.abs(motion(float(speed), damping).multipliers))) / np.pi * speed)
        for speed in regions.middle
    ]
    assert growth == pytest.approx(regions.growth.tolist(), rel=2e-3)
    middle, half = float(regions.middle[1]), float(regions.half_width[1])
    for side in (-1.0, 1.0):
        inside, outside = (
            np.max(np.abs(motion(middle + side * factor * half, damping).multipliers))
            for factor in (0.97, 1.03)
        )
        assert inside > 1.0 > outside


def test_uneven_damping_widens_the_combined_region():
    none, even, uneven = (
        pr.two_spring_regions(BETA, *INERTIAS, *STIFFNESS, *damping).half_width[1]
        for damping in ((0.0, 0.0), (1e-5, 1e-5), (0.0, 4e-5))
    )
    assert uneven > even > none
    closed = pr.two_spring_regions(BETA, *INERTIAS, *STIFFNESS, 0.01, 0.01)
    assert np.all(closed.half_width == 0.0) and np.all(closed.growth < 0.0)


def test_a_stiff_shaft_behind_leaves_the_spring_in_front():
    """Its region is that of `torsional_speed`, of all inertia on one spring."""
    regions = pr.two_spring_regions(BETA, 0.4, 0.1, 0.5, 1.0, 1e8)
    zone = torsional_speed.parametric_zone(BETA, 0.6)
    assert regions.middle[0] == pytest.approx(1.0, rel=1e-7)
    # κ for β²/4: the same to β⁴.
    assert regions.half_width[0] == pytest.approx(zone.damping, rel=BETA**2)


@pytest.mark.slow
def test_elastic_middle_shaft():
    """20°: 0.9696 … 1.0318 by the full equation; the error is of the next order in κ."""
    errors = []
    for angle in (20.0, 10.0):
        beta = np.radians(angle)
        low, high = pr.middle_shaft_region(beta)

        def trace(speed, beta=beta):
            return periodic(ElasticMiddleShaft(beta, speed), np.zeros(2)).trace + 2.0

        ends = [
            edge(trace, 0.998 * low, 1.002 * low, 1e-7),
            edge(trace, 0.998 * high, 1.002 * high, 1e-7),
        ]
        errors.append(np.abs(np.subtract(ends, (low, high))))
        if angle == 20.0:
            assert ends == pytest.approx([0.9696, 1.0318], abs=5e-5)
    assert np.all(errors[0] < 3e-4) and np.all(errors[1] < errors[0] / 12.0)


def test_shapes_and_bad_arguments():
    regions = pr.two_spring_regions([[0.1], [np.nan]], 0.4, 0.1, 0.7, [1.0, 2.0, 3.0], 0.9)
    assert all(values.shape == (2, 3, 3) for values in regions)
    assert np.isnan(regions.growth[1]).all() and np.isfinite(regions.growth[0]).all()
    for call, message in (
        (lambda: pr.two_spring_modes(0.0, 0.0, 1.0, 1.0, 1.0), r"front \+ fork = 0\.0"),
        (lambda: pr.two_spring_regions(0.1, 1.0, 0.0, 1.0, 1.0, 0.0), "stiffness_out"),
        (lambda: pr.two_spring_regions(0.1, 1.0, 0.0, 1.0, 1.0, 1.0, -1.0), "damping_in"),
        (lambda: pr.middle_shaft_region(2.0), "beta"),
    ):
        with pytest.raises(ValueError, match=message):
            call()
