from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.practice.report.comparisons import POSITIONS, turn_of

BETA = float(np.deg2rad(50.0))


@pytest.fixture(scope="session")
def joint_turn(joint: cd.Mechanism) -> cd.Sweep:
    """One turn of the universal joint at 50°, under 100 N·m."""
    return turn_of(joint, BETA)


@pytest.fixture(scope="session")
def shaft_turn(shaft: cd.Mechanism) -> cd.Sweep:
    """One turn of the double shaft, both joints at 50°, under 100 N·m."""
    return turn_of(shaft, BETA)


@pytest.fixture(scope="session")
def joint_without_load(joint: cd.Mechanism) -> cd.Sweep:
    """Two positions of the universal joint, through which no torque passes."""
    return cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.3}).sweep([0.0, 1.0])


@pytest.fixture(scope="session")
def one_position(joint: cd.Mechanism) -> cd.Sweep:
    """A single position of the universal joint, under 1 N·m."""
    held = {"joint_angle": 0.5}
    scene = cd.Scene(joint, drive="bearing_in", held=held, loads={"bearing_out": 1.0})
    return scene.sweep([2.0])


@pytest.fixture(scope="session")
def needle_turn() -> cd.Sweep:
    """One turn of the needle drive with its inertia at 2000 rpm."""
    return cd.Scene(cd.load("needle_drive"), drive="main_shaft").sweep(POSITIONS, speed=209.4)
