"""Responses of a scene: what `Scene` hands on to the response package."""

from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.core.response.response import Response


def test_a_scene_has_responses_of_itself_and_of_designs(joint: cd.Mechanism) -> None:
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.3})
    assert isinstance(scene.response(1e-9), Response)
    family = scene.responses({"joint_angle": [0.1, 0.2]}, 1e-9)
    assert isinstance(family, Response)
    assert np.all(family.error < 1e-9)
    with pytest.raises(cd.ArgumentError, match="tolerance is 2, expected"):
        scene.responses({"joint_angle": [0.1]}, 2.0)
