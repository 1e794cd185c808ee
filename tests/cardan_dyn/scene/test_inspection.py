"""What a scene tells of itself, and that a sweep is not needed for it."""

from __future__ import annotations

import numpy as np

import cardan_dyn as cd


def test_a_scene_is_inspected_before_any_sweep() -> None:
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing")
    assert "close rocker_pin" in str(scene.plan())
    assert scene.motion_range() == (-np.inf, np.inf)
    assert scene.configuration().mechanism is scene.mechanism
    assert next(iter(scene.branches())) == "A"
    np.testing.assert_array_equal(scene.reachable([[0.0, 7.0]]), [[True, True]])
