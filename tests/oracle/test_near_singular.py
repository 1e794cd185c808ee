"""A sample of simulations that begin close to singular configurations."""

from __future__ import annotations

import near_singular
import numpy as np
import pytest


@pytest.mark.campaign
# Then platforms, and dead points of sliders that are driven, so close that rounding decides.
@pytest.mark.slow
@pytest.mark.parametrize("seed", [*range(12), 20, 48, 59, 94])
def test_starts_close_to_singular_configurations(seed: int) -> None:
    """Linkages in line that miss it or not, dead points and platforms, by regular coordinates."""
    what, error, said = near_singular.case(seed)
    assert not near_singular.is_wrong(error, said), (what, error)


@pytest.mark.slow
@pytest.mark.parametrize("bend", [1e-2, 1e-3, 1e-4, 5e-5, 2e-5])
def test_two_rods_close_to_in_line(bend: float) -> None:
    error, moved = near_singular.rods_error(bend, 0.5, 1.5, np.zeros(3))
    assert moved.energy_residual < 1e-8
    # Rounding of lengths changes the oval on which both angles lie.
    assert error < 1e-8 + 1e-13 / bend**2
    if bend < 1e-3:
        assert "singular" in moved.notes[0]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [27, 62])
def test_platforms_close_to_singular_are_not_taken_for_locked(seed: int) -> None:
    what, error, said = near_singular.case(seed)
    assert error < 1e-6, (what, error)
    assert "close to a singular configuration" in said and "Error" not in said
