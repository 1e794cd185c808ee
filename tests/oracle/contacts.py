"""Bundled mechanisms with clearance in a pin: the energy is kept to the tolerance asked for.

By all laws of contact, with and without friction, over the first impacts and slides.
"""

from __future__ import annotations

import numpy as np

import cardan_dyn as cd
from cardan_dyn import clearance

PINS = (
    ("slider_crank", "crank_pin"),
    ("slider_crank", "piston_pin"),
    ("four_bar", "crank_pin"),
    ("four_bar", "rocker_pin"),
)


def ask(seed: int) -> tuple[list[str], list[str]]:
    """Return what is wrong with the energy of one simulation, and what it was of."""
    rng = np.random.default_rng(seed)
    mechanism, joint = PINS[rng.integers(len(PINS))]
    stiffness, restitution = 10.0 ** rng.uniform(6.5, 8.5), rng.uniform(0.3, 0.8)
    laws = (
        cd.LinearContact(stiffness, stiffness * 10.0 ** rng.uniform(-5, -4)),
        clearance.HuntCrossley(30.0 * stiffness, restitution=restitution),
        clearance.LankaraniNikravesh(30.0 * stiffness, restitution=restitution),
        clearance.ImpactFunction(stiffness, 1.5, 1e-4 * stiffness, 1e-6),
    )
    law = laws[rng.integers(len(laws))]
    gap, rtol = 10.0 ** rng.uniform(-5, -3), float(10.0 ** rng.uniform(-9, -4))
    speed = 10.0 ** rng.uniform(1, 2.5)
    rotor = None if rng.random() < 0.5 else 10.0 ** rng.uniform(-3, 0)
    what = f"{mechanism} {joint} {type(law).__name__}, rtol {rtol:.1e}"
    scene = cd.Scene(cd.load(mechanism), drive="crank_bearing")
    try:
        found = clearance.simulate(
            scene,
            speed,
            joints=joint,
            clearance=gap,
            law=law,
            turns=0.15,
            rtol=rtol,
            rotor=rotor,
            position=rng.uniform(0.0, 6.0),
            max_touches=12,
            friction=0.1 * (rng.random() < 0.3),
        )
    except cd.CardanError as refused:
        return [f"{what}: {type(refused).__name__}: {refused}"], [mechanism]
    share = found.energy_residual / rtol
    wrong = [f"{what}: energy off by {share:.1f} times its tolerance"] if not share <= 1.0 else []
    return wrong, [mechanism, type(law).__name__, *["impact"] * len(found.impacts)]
