"""Rotors of joints where joints have play: flywheels where carriers turn steadily."""

from __future__ import annotations

import re

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn import clearance

CONTACT = {"clearance": 1e-4, "stiffness": 1e8, "damping_ratio": 0.25}
LAW = {"clearance": 1e-4, "law": clearance.LinearContact(1e8, 10.0)}


def scene(rod: float = 0.0, **rotors: float) -> cd.Scene:
    """Return the slider-crank with rotors of joints, and more inertia of its rod [kg·m²]."""
    text = cd.load("slider_crank").to_urdf()
    for name, inertia in rotors.items():
        dynamics = f'<dynamics armature="{inertia}"/>'
        text = re.sub(rf'(<(joint|loop) name="{name}"[^>]*>)', rf"\1{dynamics}", text)
    if rod:
        before, found, rest = re.split(r'(name="rod">.*?izz=")', text, maxsplit=1, flags=re.DOTALL)
        value, after = rest.split('"', 1)
        text = f'{before}{found}{float(value) + rod!r}"{after}'
    return cd.Scene(cd.load(text, strict=False), drive="crank_bearing")


@pytest.mark.parametrize("joint", ["crank_pin", "piston_pin"])
def test_rotors_at_both_ends_of_the_rod_are_inertia_of_the_rod(joint: str) -> None:
    """Neither the crank, at constant speed, nor the piston turns faster."""
    scenes = scene(crank_pin=0.003, piston_pin=0.002), scene(rod=0.005)
    scans = [clearance.scan(item, 200.0, joints=joint, **CONTACT)[joint] for item in scenes]
    np.testing.assert_allclose(scans[0].force, scans[1].force, rtol=1e-9, atol=1e-8)
    assert scans[0].mean_mass == pytest.approx(scans[1].mean_mass, rel=1e-9)
    runs = [clearance.simulate(item, 200.0, joints=joint, turns=0.02, **LAW) for item in scenes]
    first, second = (run.trajectory for run in runs)
    assert max(first.energy_residual, first.effort_residual) < 1e-7
    np.testing.assert_allclose(first.position[-1], second.position[-1], rtol=1e-7)


def test_a_rotor_of_the_drive_is_the_one_that_is_given() -> None:
    scenes = (scene(crank_bearing=0.7), 0.0), (scene(crank_bearing=0.5), 0.2), (scene(), 0.7)
    masses = [
        clearance.scan(item, 200.0, joints="piston_pin", rotor=rotor, **CONTACT)[
            "piston_pin"
        ].mean_mass
        for item, rotor in scenes
    ]
    np.testing.assert_allclose(masses, masses[0], rtol=1e-12)


def test_so_it_is_in_a_simulation() -> None:
    scenes = (scene(crank_bearing=0.5), 0.2), (scene(), 0.7)
    speeds = [
        clearance.simulate(
            item, 200.0, joints="piston_pin", turns=0.01, rotor=rotor, **LAW
        ).trajectory.speed[-1]
        for item, rotor in scenes
    ]
    np.testing.assert_allclose(speeds[0], speeds[1], rtol=1e-9)
