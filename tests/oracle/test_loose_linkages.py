"""Random linkages with play in a pin: the stated interval beside the whole mechanism.

`python tests/oracle/run.py loose` runs as many as are wanted, and `run.py peaks` scans all pins.
"""

from __future__ import annotations

import pytest
from loose_linkages import ask_peaks, draw, misprinted, passed

from cardan_dyn import clearance


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 16, 20, 23])
def test_the_interval_holds_what_is_simulated(seed: int) -> None:
    loose = draw(seed)
    assert loose is not None
    found = passed(loose)
    assert found
    for item in found:
        assert item.is_inside and not item.is_unsafe
    # The interval says something: it is no wider than the scatter from turn to turn and a little.
    assert min(item.item.greatest / item.item.least for item in found) < 1.15
    assert any(item.item.strikes for item in found)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [4, 5])
def test_no_peak_is_printed_below_what_is_known(seed: int) -> None:
    loose = draw(seed)
    assert loose is not None
    found = clearance.scan(loose.scene, loose.speed, **loose.contact)  # type: ignore[arg-type]
    assert misprinted(loose, found) == []


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.parametrize("seed", [12, 18])
def test_simulations_do_not_exceed_what_is_printed(seed: int) -> None:
    wrong, counted = ask_peaks(seed)
    assert wrong == [] and counted.count("turn inside") == 2
