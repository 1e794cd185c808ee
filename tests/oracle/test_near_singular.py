"""A sample of simulations that begin close to singular configurations."""

from __future__ import annotations

import near_singular
import numpy as np
import pytest


@pytest.mark.parametrize("seed", range(12))
def test_starts_close_to_singular_configurations(seed: int) -> None:
    """Two rods in line, bars in line that miss it or not, against regular coordinates."""
    what, error, said = near_singular.case(seed)
    assert not near_singular.is_wrong(error, said), (what, error)


@pytest.mark.parametrize("bend", [1e-2, 1e-3, 1e-4, 5e-5, 2e-5])
def test_two_rods_close_to_in_line(bend: float) -> None:
    error, moved = near_singular.rods_error(bend, 0.5, 1.5, np.zeros(3))
    assert moved.energy_residual < 1e-8
    # Rounding of lengths changes the oval on which both angles lie.
    assert error < 1e-8 + 1e-13 / bend**2
    if bend < 1e-3:
        assert "singular" in moved.notes[0]
