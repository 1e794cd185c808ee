from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.practice.report import comparisons

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


@pytest.fixture(scope="session")
def joint_turn(joint: cd.Mechanism) -> cd.Sweep:
    """One turn of the universal joint at 50°, under 100 N·m."""
    return comparisons.turn_of(joint, float(np.deg2rad(50.0)))


@pytest.fixture(scope="session")
def shaft_turn(shaft: cd.Mechanism) -> cd.Sweep:
    """One turn of the double shaft, both joints at 30°, under 100 N·m."""
    return comparisons.turn_of(shaft, float(np.deg2rad(30.0)))
