"""Random linkages with play in a pin: the stated interval beside the whole mechanism.

`python tests/oracle/run.py loose` runs as many as are wanted.
"""

from __future__ import annotations

import pytest
from loose_linkages import draw, passed


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
