"""Axial forces, and what they do to the bearings by the statics of the end shafts."""

import numpy as np
import pytest

from cardan_dyn.analytic import shaft_design as sd
from cardan_dyn.analytic import support_forces as af
from cardan_dyn.analytic import support_forces as sf
from cardan_dyn.analytic.limits import LIMITS

SPANS = sf.Spans(a=0.4, b=0.15, e=0.2, f=0.5)


def test_friction_and_pressure():
    pressure = LIMITS["lubrication_pressure"].value
    friction = sd.slip_force(1000.0, 0.2, 0.04, 0.08)
    force = af.axial_force(-1000.0, 0.2, 0.04, 0.08, pressure, 2e-3)
    # 15 bar on 20 cm^2 are 3 kN.
    assert force == pytest.approx(1000 * 0.08 * np.cos(0.2) / 0.04 + 3000.0, rel=1e-14)
    assert af.axial_force(1000.0, 0.2, 0.04, 0.08) == friction


def test_bearings_carry_the_force_across_the_end_shafts():
    """Force and moment of each end shaft vanish with the bearings' reactions."""
    beta_1, beta_2, F = 0.3, 0.2, 2000.0
    A, B, E, FF = af.axial_support_forces(-F, beta_1, beta_2, SPANS)
    a, b, e, f = SPANS
    for beta, near, far, lever, span in ((beta_1, B, A, b, a), (beta_2, E, FF, e, f)):
        across = F * np.sin(beta)
        # Behind the joint, the near bearing pushes back, the far one with the force.
        assert near - far == pytest.approx(across, rel=1e-14)
        assert near * lever == pytest.approx(far * (lever + span), rel=1e-13)


def test_shapes_nan_and_bad_arguments():
    forces = af.axial_support_forces([[1.0], [np.nan]], 0.1, np.zeros(3), SPANS)
    assert all(force.shape == (2, 3) for force in forces)
    assert np.isnan(forces.A).tolist() == [[False] * 3, [True] * 3]
    assert isinstance(af.axial_force(1, 0, 1), float)
    with pytest.raises(ValueError, match=r"pressure = -1\.0"):
        af.axial_force(1.0, 0.1, 0.1, pressure=-1.0)
    with pytest.raises(ValueError, match=r"e = 0\.0"):
        af.axial_support_forces(1.0, 0.1, 0.1, SPANS._replace(e=0.0))
