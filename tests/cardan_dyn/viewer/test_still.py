"""A configuration as the viewer draws it."""

from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.viewer.still import Still


def test_a_still_has_one_sample_without_wrenches() -> None:
    configuration = cd.load("four_bar").assembled(start={"crank_bearing": 0.7})
    still = Still(configuration)
    assert len(still) == 1
    assert still.outputs == tuple(configuration.mechanism)
    for joint in still.outputs:
        np.testing.assert_array_equal(still.origin(joint)[0], configuration.origin(joint))
        np.testing.assert_array_equal(still.rotation(joint)[0], configuration.rotation(joint))
        assert not np.any(still[joint].force)
        assert not np.any(still[joint].moment)
        assert still.motion.position(joint).shape == (1,)
    with pytest.raises(cd.ModelError):
        still["lever"]


def test_a_configuration_can_be_viewed() -> None:
    configuration = cd.load("stewart_platform").assembled()
    page = cd.view(configuration, title="still").html
    assert "still" in page
    with pytest.raises(cd.ArgumentError, match="a sweep or a configuration, not Mechanism"):
        cd.view(configuration.mechanism)  # type: ignore[arg-type]
