"""Efforts and their derivatives against sweeps, differences, and equations by hand."""

from __future__ import annotations

import numpy as np
import pytest
from testkit import elastic_rigs
from tilting_shaft import TiltingShaft

import cardan_dyn as cd
from cardan_dyn.kit.differences import displacements, slopes
from cardan_dyn.motion.vibration.model.efforts import FreeEfforts
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene

BETA = np.radians(20.0)


@pytest.fixture(scope="module")
def rig() -> cd.Scene:
    return elastic_rigs.scene(elastic_rigs.elastic_rig(0.3, 1.2, 1.5, 0.02), BETA)


def test_derivatives_are_those_of_sweeps(rig: cd.Scene) -> None:
    """Springs along the drive and elsewhere, loads and weight among what acts."""
    more = [
        cd.JointSpring("bearing_in", 0.2, 0.03, rest=1.0),
        cd.JointSpring("bearing_out", 0.4, 0.05, rest=-0.5),
        cd.Actuator("tilt_z", lambda angle: np.sin(angle), of="position"),
    ]
    loaded = rig.replace(
        loads={"bearing_out": -0.4}, gravity=[0.0, -3.0, -9.81], elements=[*rig.elements, *more]
    )
    random = np.random.default_rng(1)
    positions = np.column_stack([random.uniform(-9.0, 9.0, 6), 0.3 * random.normal(size=(6, 2))])
    speeds, accelerations = random.normal(size=(2, 6, 3))
    found = FreeEfforts(rotating_scene(loaded)).local(positions, speeds, accelerations)
    driven, states = loaded.replace(drive=loaded.coordinates), [positions, speeds, accelerations]
    expected = driven.sweep(*states).drive_effort
    np.testing.assert_allclose(found.efforts, expected, rtol=0, atol=1e-13)
    units = np.ones(3)
    for kind, given in enumerate(found[1:]):
        values = []
        for way in displacements(units):
            moved = list(states)
            moved[kind] = moved[kind] + way
            values.append(driven.sweep(*moved).drive_effort)
        columns = slopes(np.array(values), units)[..., 3 - given.shape[2] :]
        np.testing.assert_allclose(given, columns, rtol=0, atol=1e-9)


def test_accelerations_by_hand_need_no_effort(rig: cd.Scene) -> None:
    speed, phi = 0.8, 1.1
    q, rate = np.array([0.1, -0.2]), np.array([0.3, 0.05])
    bend = TiltingShaft(BETA, speed, 0.3, 1.2, 1.5, 0.02)(phi, q, rate)
    states = [phi, *q], speed * np.r_[1.0, rate], speed**2 * np.r_[0.0, bend]
    found = FreeEfforts(rotating_scene(rig)).local(*(np.array([item]) for item in states))
    assert np.max(np.abs(found.efforts[0, 1:])) < 1e-13
