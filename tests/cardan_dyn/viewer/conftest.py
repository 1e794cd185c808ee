from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd

BETA = 0.6
SAMPLES = np.arange(0, 25, 2)


@pytest.fixture(scope="session")
def loaded_turn() -> cd.Sweep:
    """Universal joint under 10 N·m, 25 positions of one turn."""
    scene = cd.Scene(
        cd.load("universal_joint"),
        drive="bearing_in",
        held={"joint_angle": BETA},
        loads={"bearing_out": -10.0},
    )
    return scene.sweep(np.linspace(0.0, 2.0 * np.pi, 25))
