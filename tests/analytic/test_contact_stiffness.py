"""Contact of pin and bush."""

import mpmath as mp
import numpy as np
import pytest
from testkit.cross_geometry import ULP, relative_errors

from cardan_dyn.analytic import contact_stiffness as cs

STEEL = float(cs.cylinder_compliance(2.1e11))


def approach(force, compliance, length, difference):
    k, L, d = (mp.mpf(float(x)) for x in (compliance, length, difference))
    return force * k / L * (1 + mp.log(4 * L * d / (force * k)))


@pytest.mark.parametrize("force", [1.0, 500.0, 2e4])
def test_approach_and_its_derivative(force):
    arguments = (2 * STEEL, 0.03, 5e-5)
    reference = approach(mp.mpf(force), *arguments)
    assert relative_errors(cs.contact_approach(force, *arguments), [reference])[0] <= 8 * ULP
    slope = mp.diff(lambda f: approach(f, *arguments), mp.mpf(force))
    assert relative_errors(cs.contact_stiffness(force, *arguments), [1 / slope])[0] <= 8 * ULP


def test_compliance():
    assert cs.cylinder_compliance(2.1e11, 0.3) == pytest.approx(0.91 / (np.pi * 2.1e11), rel=1e-15)
    assert cs.cylinder_compliance(1.0, 0.0) == pytest.approx(1 / np.pi, rel=1e-15)


def test_stiffness_grows_with_force_and_falls_with_play():
    force = np.geomspace(1, 1e4, 20)
    stiffness = cs.contact_stiffness(force, 2 * STEEL, 0.03, np.array([[5e-5], [1e-4]]))
    assert np.all(np.diff(stiffness, axis=1) > 0)
    assert np.all(stiffness[1] < stiffness[0])


def test_shapes_nan_and_bad_arguments():
    values = cs.contact_stiffness([1.0, np.nan], STEEL, np.full((3, 1), 0.02), 1e-4)
    assert np.isnan(values).tolist() == [[False, True]] * 3
    assert isinstance(cs.contact_approach(1.0, STEEL, 0.02, 1e-4), float)
    limit = 4 * 0.02 * 1e-4 / STEEL
    for call, message in (
        (lambda: cs.contact_stiffness(limit * 1.001, STEEL, 0.02, 1e-4), "force = .*4 length"),
        (lambda: cs.contact_approach(0.0, STEEL, 0.02, 1e-4), r"force = 0\.0"),
        (lambda: cs.contact_approach(1.0, STEEL, 0.02, -1e-4), "radius_difference"),
        (lambda: cs.cylinder_compliance(1.0, 0.6), r"poisson = 0\.6 .*\(-1, 0\.5\]"),
        (lambda: cs.cylinder_compliance(0.0), r"modulus = 0\.0"),
        (lambda: cs.contact_stiffness(np.ones(2), STEEL, np.ones(3), 1e-4), r"length \(3,\)"),
    ):
        with pytest.raises(ValueError, match=message):
            call()
