"""Comparison: the estimate of a scan beside the simulation of the whole mechanism."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array
from ..checks import described
from ..elements.contact_laws import LinearContact
from ..errors import ArgumentError
from .compared import Compared, Comparison
from .contact_simulation import ContactSimulation
from .joint_scan import JointScan
from .pin_scan import PinScan
from .scanned import Scan

if TYPE_CHECKING:
    from ..elements.pin_contact import PinContact

_SAME = 1e-6
"""Difference of play, stiffness or damping, as a fraction, that is rounding."""
_PER_STEP = 8
"""Times at which the force is looked at between two steps of a simulation."""


def compare(scan: Scan | PinScan, simulation: ContactSimulation) -> Comparison:
    """Compare the estimate of a scan with a simulation.

    What is compared is the greatest force from one reversal to the next: the greater of the
    estimated peak and of the force without play. The first reversal of the simulation is left out,
    before which it had not yet settled.

    Args:
        scan: of the same play and contact as the simulation; of pin bearings, each is compared.
        simulation: of the same mechanism, loads, elements, rotor and speed, over two turns or more.
            It may have friction, of which scans know nothing, and play in further joints; but of
            pin bearings, in the same ones alone.

    Raises:
        ArgumentError: they have no joint in common, their mechanisms, what acts on them, speeds,
            plays or contacts differ, or the simulation is too short.
    """
    if not isinstance(scan, (Scan, PinScan)):
        raise ArgumentError(f"scan is {described(scan)}, expected a scan")
    if not isinstance(simulation, ContactSimulation):
        raise ArgumentError(
            f"simulation is {described(simulation)}, expected one of clearance.simulate"
        )
    scans: Mapping[str, JointScan] = scan.by_bearing() if isinstance(scan, PinScan) else scan
    joints = [name for name in simulation if name in list(scans)]
    if not joints:
        raise ArgumentError("no joint of the simulation was scanned")
    if abs(scan.speed - simulation.speed) > 1e-12 * abs(scan.speed):
        raise ArgumentError(
            f"the scan is of {scan.speed:g} rad/s, the simulation of {simulation.speed:g} rad/s"
        )
    others = [name for name, of in scan.made_of.items() if simulation.made_of.get(name, of) != of]
    if others:
        raise ArgumentError(
            f"the scan and the simulation are of scenes that differ in their {', '.join(others)}; "
            "make both of the same scene and rotor"
        )
    if isinstance(scan, PinScan):
        _check_bearings(scan, simulation)
    for name in joints:
        _check_same(scan, scans[name], simulation.contact(name))
    steps = simulation.steps
    parts = np.linspace(0.0, 1.0, _PER_STEP, endpoint=False)
    times = (steps[:-1, None] + np.diff(steps)[:, None] * parts).ravel()
    fine = simulation.at(np.concatenate([times, steps[-1:]]))
    result = []
    for name in joints:
        course = fine[name]
        result += _of_joint(scans[name], course.position, course.force, float(np.sign(scan.speed)))
    return Comparison(result)


def _check_bearings(scan: PinScan, simulation: ContactSimulation) -> None:
    """Refuse a simulation in which other bearings have play, or bearings at other places.

    Raises:
        ArgumentError: they differ.
    """
    if set(simulation) != set(scan.bearings):
        raise ArgumentError(
            f"the scan has clearance in {', '.join(scan.bearings)}, the simulation in "
            f"{', '.join(simulation)}: bearings move together, and so need the same ones"
        )
    for pin, radius in scan.radius.items():
        places = [simulation.contact(f"{pin}{side}").point_a for side in "+-"]
        reach = 0.5 * float(np.linalg.norm(places[0] - places[1]))
        if abs(reach - radius) > _SAME * radius:
            raise ArgumentError(
                f"joint {pin!r}: the simulation has its bearings {reach:.6g} m from its origin, "
                f"the scan a radius of {radius:.6g} m; give both the same"
            )


def _check_same(scan: Scan | PinScan, joint: JointScan, contact: PinContact) -> None:
    """Refuse a simulation of other play or another contact than a scan's.

    Raises:
        ArgumentError: they differ.
    """
    law = contact.law
    if not isinstance(law, LinearContact):
        raise ArgumentError(
            f"joint {joint.name!r}: the simulation has the law {type(law).__name__}, the scan that "
            "of a linear contact; simulate with stiffness= and damping_ratio=, or a LinearContact"
        )
    if isinstance(scan, PinScan):
        pin = joint.name[:-1]
        stiffness = scan.stiffness[pin]
        # The damper that the two-mass model has for all bearings is shared as their stiffness is.
        dampings = [item.damping * stiffness / item.stiffness for item in scan.reversals]
        pairs = [
            ("clearance", "m", contact.clearance, [scan.clearance[pin]]),
            ("stiffness", "N/m", law.stiffness, [stiffness]),
            ("damping", "N s/m", law.damping, dampings),
        ]
    else:
        items = joint.reversals
        pairs = [
            ("clearance", "m", contact.clearance, [item.model.clearance for item in items]),
            ("stiffness", "N/m", law.stiffness, [item.stiffness for item in items]),
            ("damping", "N s/m", law.damping, [item.damping for item in items]),
        ]
    for label, unit, simulated, scanned in pairs:
        low, high = min(scanned, default=simulated), max(scanned, default=simulated)
        if not (1.0 - _SAME) * low <= simulated <= (1.0 + _SAME) * high:
            raise ArgumentError(
                f"joint {joint.name!r}: the simulation has a {label} of {simulated:.6g} {unit}, "
                f"the scan one of {low:.6g}; give both the same clearance, "
                "stiffness and damping_ratio"
            )


def _of_joint(scan: JointScan, position: Array, force: Array, sense: float) -> list[Compared]:
    """Return the reversals of a joint.

    Args:
        scan: of the joint.
        position: of the drive `(N,)` in the simulation [rad].
        force: `(N,)` in it [N].
        sense: in which the drive turns.
    """
    count = len(scan.position)
    period = float(scan.position[1] - scan.position[0]) * count
    starts = [item.position for item in scan.reversals]
    rigid = np.linalg.norm(scan.force, axis=1)
    found = []
    for index, item in enumerate(scan.reversals):
        after = starts[(index + int(sense)) % len(starts)]
        way = (sense * (after - item.position)) % period or period
        since = (sense * (scan.position - item.position)) % period
        greatest = float(np.max(rigid[since <= way], initial=0.0))
        passed = sense * (position - item.position)
        turns, within = np.floor(passed / period).astype(int), passed % period
        begun, ended = sense * position[0], sense * position[-1]
        whole = [
            turn
            for turn in range(int(np.min(turns)), int(np.max(turns)) + 1)
            if begun < sense * item.position + turn * period - 0.25 * period
            and sense * item.position + turn * period + way <= ended
        ]
        if not whole:
            raise ArgumentError(
                f"the simulation is too short for the reversal of joint {scan.name!r} at "
                f"{item.position:.3g} rad; simulate more turns"
            )
        peaks = [float(np.max(force[(turns == turn) & (within <= way)])) for turn in whole]
        estimate = replace(item, rigid_ahead=greatest).estimate
        found.append(Compared(scan.name, item, greatest, estimate, np.array(peaks)))
    return found
