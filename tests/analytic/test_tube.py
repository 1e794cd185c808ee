"""Torsion of tubes against integrals over their section."""

import mpmath as mp
import numpy as np
import pytest
from testkit.cross_geometry import ULP, relative_errors

from cardan_dyn.analytic import shaft_design


@pytest.mark.parametrize(("outer", "inner"), [(0.1, 0.0), (0.09, 0.083), (0.1, 0.0999999)])
def test_stress_and_stiffness_are_those_of_the_section(outer, inner):
    """Stress proportional to the radius, whose moment over the section is the torque."""
    D, d = mp.mpf(outer), mp.mpf(inner)
    polar = mp.quad(lambda r: 2 * mp.pi * r**3, [d / 2, D / 2])
    stress = shaft_design.shear_stress(-850.0, outer, inner)
    assert relative_errors(stress, [850 * (D / 2) / polar])[0] <= 16 * ULP
    stiffness = shaft_design.torsional_stiffness(outer, inner, 1.3, 8e10)
    assert relative_errors(stiffness, [mp.mpf(8e10) * polar / mp.mpf(1.3)])[0] <= 16 * ULP


def test_printed_forms():
    D, d = 0.09, 0.083
    printed = 16 * 850 * D / (np.pi * (D**4 - d**4))
    assert shaft_design.shear_stress(850.0, D, d) == pytest.approx(printed, rel=1e-13)
    psi = 4.4482216152605 / 0.0254**2
    c = 11e6 * psi * np.pi * (D**4 - d**4) / (32 * 1.5)
    assert shaft_design.torsional_stiffness(D, d, 1.5) == pytest.approx(c, rel=1e-6)


def test_shapes_nan_and_bad_arguments():
    assert shaft_design.shear_stress(np.ones((3, 1)), [0.1, 0.2], 0.05).shape == (3, 2)
    assert np.isnan(shaft_design.torsional_stiffness([0.1, np.nan], 0.0, 1.0)).tolist() == [
        False,
        True,
    ]
    assert isinstance(shaft_design.shear_stress(1, 1, 0), float)
    with pytest.raises(ValueError, match=r"inner_diameter\[1\] = 0\.3 .*outer_diameter"):
        shaft_design.shear_stress(1.0, 0.2, [0.1, 0.3])
    with pytest.raises(ValueError, match=r"length = 0\.0"):
        shaft_design.torsional_stiffness(0.2, 0.1, 0.0)
    with pytest.raises(ValueError, match="shear_modulus"):
        shaft_design.torsional_stiffness(0.2, 0.1, 1.0, -1.0)
