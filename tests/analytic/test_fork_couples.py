"""Fork couples against the moments of Grossmann and of Thoma over the turn."""

import numpy as np
import pytest

from cardan_dyn.analytic import grossmann, thoma
from cardan_dyn.analytic import support_forces as fc


@pytest.mark.parametrize("degrees", [0.0, 5.0, 30.0, 44.0, 60.0])
def test_positions_are_those_of_grossmann_and_thoma(degrees):
    beta, torque = np.radians(degrees), 250.0
    couples = fc.fork_couples(beta, -torque)
    in_plane, normal = (grossmann.moments(beta, phi, torque) for phi in (0.0, np.pi / 2))
    assert couples.input_in_plane == in_plane.bending_1 == 0.0
    assert couples.output_in_plane == pytest.approx(in_plane.bending_2, rel=1e-14)
    assert couples.input_normal == pytest.approx(normal.bending_1, rel=1e-14)
    assert couples.output_normal == pytest.approx(normal.bending_2, abs=1e-13)
    # Thoma's Hauptlage A: M_b = M_t tan alpha, with M_t = T cos alpha there.
    M_x, _ = thoma.bending_moments(beta, 0.0, torque * np.cos(beta))
    assert couples.output_in_plane == pytest.approx(M_x, rel=1e-13)


def test_greatest_of_the_turn():
    phi = np.linspace(0, np.pi, 100_001)
    for degrees, exceeded in ((40.0, False), (60.0, True)):
        beta = np.radians(degrees)
        turn, couples = grossmann.moments(beta, phi), fc.fork_couples(beta)
        assert np.max(turn.bending_1) == pytest.approx(couples.input_normal, rel=1e-9)
        assert (np.max(turn.bending_2) > couples.output_in_plane * (1 + 1e-9)) == exceeded


def test_shapes_nan_and_bad_arguments():
    couples = fc.fork_couples([[0.1], [np.nan]], np.ones(3))
    assert all(value.shape == (2, 3) for value in couples)
    assert all(np.isnan(value).tolist() == [[False] * 3, [True] * 3] for value in couples)
    assert all(isinstance(value, float) for value in fc.fork_couples(0.1))
    with pytest.raises(ValueError, match=r"beta = 1\.6"):
        fc.fork_couples(1.6)
