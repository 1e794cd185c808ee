"""Variables: the units that stand for all their values."""

from __future__ import annotations

import numpy as np

from cardan_dyn.results.variable import Variable


def test_every_unit_is_named_once() -> None:
    values = np.zeros((2, 3))
    assert Variable(("sample", "joint"), values, "N", "").unit == "N"
    assert Variable(("sample", "joint"), values, ("m", "rad", "m"), "").unit == "m or rad"
    assert not Variable(("sample", "joint"), values, "N", "").is_coordinate
