"""Compare: the estimate of a scan beside the simulation of the whole mechanism."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...core.elements.contact_laws import LinearContact
from ...kit.arrays import ROUNDED, Array
from ...kit.checks import described
from ...kit.errors import ArgumentError
from .contact_simulation import ContactSimulation, finer
from .planar_motion import SETTLED
from .scan_results import ComparedReversal, JointScan, Scan, ScanComparison

if TYPE_CHECKING:
    from ...core.elements.pin_contact import PinContact


def compare(scan: Scan, simulation: ContactSimulation) -> ScanComparison:
    """Compare the estimate of a scan with a simulation.

    What is compared is the greatest force from one reversal to the next. The first reversal of the
    simulation is left out, before which it had not yet settled.

    Args:
        scan: of the same clearance and contact as the simulation; of a universal joint, each of its
            bearings is compared.
        simulation: of the same mechanism, loads, elements, rotor and speed, over two turns or more.
            It may have friction, of which scans know nothing, and clearance in further joints; but
            of a universal joint, in the same bearings alone.

    Raises:
        ArgumentError: they have no joint in common, their mechanisms, what acts on them, speeds,
            clearances or contacts differ, or the simulation is too short.
    """
    if not isinstance(scan, Scan):
        raise ArgumentError(f"scan is {described(scan)}, expected a scan")
    if not isinstance(simulation, ContactSimulation):
        raise ArgumentError(
            f"simulation is {described(simulation)}, expected one of clearance.simulate"
        )
    opened = set(simulation)
    common = [joint for joint in scan.values() if opened.intersection(joint.by_bearing())]
    if not common:
        raise ArgumentError("no joint of the simulation was scanned")
    simulation.refuse_other_speed(scan.speed)
    others = [name for name, of in scan.made_of.items() if simulation.made_of.get(name, of) != of]
    if others:
        raise ArgumentError(
            f"the scan and the simulation are of scenes that differ in their {', '.join(others)}; "
            "make both of the same scene and rotor"
        )
    for joint in common:
        if joint.radius:
            _check_bearings(joint, simulation)
        for name, item in joint.by_bearing().items():
            _check_same(item, simulation.contact(name))
    fine, scanned = simulation.at(finer(simulation.steps)), scan.by_bearing()
    sense, result = float(np.sign(scan.speed)), []
    for name in simulation:
        if name in scanned:
            course = fine[name]
            result += _of_joint(scanned[name], course.position, course.force, sense)
    return ScanComparison(result)


def _check_bearings(joint: JointScan, simulation: ContactSimulation) -> None:
    """Refuse a simulation in which other bearings have clearance, or bearings at other places."""
    if set(simulation) != set(joint.bearings):
        raise ArgumentError(
            f"the scan has clearance in {', '.join(joint.bearings)}, the simulation in "
            f"{', '.join(simulation)}: bearings move together, and so need the same ones"
        )
    for pin, radius in joint.radius.items():
        places = [simulation.contact(f"{pin}{side}").point_a for side in "+-"]
        reach = 0.5 * float(np.linalg.norm(places[0] - places[1]))
        if not np.isclose(reach, radius, rtol=np.sqrt(ROUNDED), atol=0.0):
            raise ArgumentError(
                f"joint {pin!r}: the simulation has its bearings {reach:.6g} m from its origin, "
                f"the scan a radius of {radius:.6g} m; give both the same"
            )


def _check_same(joint: JointScan, contact: PinContact) -> None:
    """Refuse a simulation of another clearance or another contact than a bearing's in a scan."""
    law = contact.law
    if not isinstance(law, LinearContact):
        raise ArgumentError(
            f"joint {joint.name!r}: the simulation has the law {type(law).__name__}, the scan that "
            "of a linear contact; simulate with stiffness= and damping_ratio=, or a LinearContact"
        )
    same = np.sqrt(ROUNDED)  # Masses, by which damping is meant, are known to fewer digits.
    for label, unit in ("clearance", "m"), ("stiffness", "N/m"), ("damping", "N s/m"):
        is_law = label != "clearance"
        simulated = getattr(law if is_law else contact, label)
        scanned = (
            [getattr(item, label) for item in joint.reversals]
            if is_law
            else [*joint.clearance.values()]
        )
        low, high = min(scanned, default=simulated), max(scanned, default=simulated)
        if not (1.0 - same) * low <= simulated <= (1.0 + same) * high:
            raise ArgumentError(
                f"joint {joint.name!r}: the simulation has a {label} of {simulated:.6g} {unit}, "
                f"the scan one of {low:.6g}; give both the same clearance, stiffness and "
                "damping_ratio"
            )


def _of_joint(
    scan: JointScan, position: Array, force: Array, sense: float
) -> list[ComparedReversal]:
    """Return the reversals of a joint beside the force `(N,)` in it at positions of the drive."""
    period, found = scan.period, []
    begun, ended = sense * position[[0, -1]]
    for item in scan.reversals:
        passed = sense * (position - item.position)
        turns, within = np.floor(passed / period).astype(int), passed % period
        starts = {turn: sense * item.position + turn * period for turn in np.unique(turns).tolist()}
        whole = [
            turn
            for turn, start in starts.items()
            if begun < start - SETTLED * period and start + item.way <= ended
        ]
        if not whole:
            raise ArgumentError(
                f"the simulation is too short for the reversal of joint {scan.name!r} at "
                f"{item.position:.3g} rad; simulate more turns"
            )
        peaks = [float(np.max(force[(turns == turn) & (within <= item.way)])) for turn in whole]
        found.append(ComparedReversal(scan.name, item, np.array(peaks)))
    return found
