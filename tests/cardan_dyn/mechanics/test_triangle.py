"""Rows turned among each other until they are a triangle."""

import numpy as np

from cardan_dyn.core.mechanics.constrained import triangle


def test_what_rotations_leave_of_zeros_is_turned_again() -> None:
    """Two rows change places, which leaves the negative of what zeros are turned by."""
    zero, one = np.zeros(1), np.ones(1)
    rows = [{0: zero, 1: zero, 2: one}, {0: one, 1: -one, 2: zero}, {1: zero, 2: zero, 3: one}]
    (first, upper), (second, lower) = triangle(rows, [0, 1])
    assert (first, second) == (0, 1)
    np.testing.assert_allclose(np.abs([upper[0], upper[1]]), 1.0, rtol=1e-15)
    assert 0.0 < abs(lower[1].item()) < 1e-150
    np.testing.assert_allclose(np.hypot(lower[2], lower.get(3, 0.0)), 1.0, rtol=1e-15)
