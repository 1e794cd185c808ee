"""A needle drive with clearance in its needle pin, scanned and simulated once."""

from __future__ import annotations

from functools import cache

import cardan_dyn as cd
from cardan_dyn.clearance import ContactSimulation, Scan, scan, simulate

JOINT = "needle_pin"
PLAY = 1e-4
SPEED = 300.0


@cache
def scanned() -> Scan:
    """Return the estimate of its impacts."""
    drive = cd.Scene(cd.load("needle_drive"), drive="main_shaft")
    return scan(drive, SPEED, joints=JOINT, clearance=PLAY, stiffness=1e8, damping_ratio=0.25)


@cache
def simulated() -> ContactSimulation:
    """Return a turn and a half of it."""
    drive = cd.Scene(cd.load("needle_drive"), drive="main_shaft")
    contact = {"clearance": PLAY, "stiffness": 1e8, "damping_ratio": 0.25}
    return simulate(drive, SPEED, joints=JOINT, turns=1.5, rtol=1e-7, **contact)
