"""Scan: which joints of a mechanism would hammer if they had clearance, and how hard.

Dresig and Thümmel's estimate for every turning joint: where the force of the rigid mechanism swings
round, the pin crosses the clearance and strikes the other side. Reduced masses come from the
mechanism.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING

import numpy as np

from analytic.impact import Start

from ..checks import flag
from ..elements.contact_laws import LinearContact
from ..errors import ArgumentError, CardanError
from ..frozen import read_only
from .arguments import (
    clearance_of,
    damping_ratio_of,
    drive_of,
    made_of,
    period_of,
    pins_of,
    refuse_unknown,
    scene_of,
    speed_of,
    start_of,
    stiffness_of,
)
from .compared import Compared, Comparison
from .comparison import compare
from .force_source import ForceSource, PinForces
from .impact_model import Contact
from .impacts import Pin, reversals
from .joint_scan import JointScan
from .opened_joint import OpenedJoint, mean_positions
from .pin_geometry import PinGeometry
from .scanned import Scan
from .simulate import simulate

if TYPE_CHECKING:
    from ..response.response import Response
    from ..scene.scene import Scene

_VERIFIED, _VERIFIED_TO = 2.6, 1e-8
"""Periods of a simulation that verifies, of which the first reversals do not count, and its
relative tolerance."""


def scan(
    scene: Scene | Response,
    speed: float,
    *,
    clearance: float | Mapping[str, float],
    stiffness: float | PinGeometry | Mapping[str, float | PinGeometry],
    joints: str | Collection[str] | None = None,
    damping_ratio: float = 0.0,
    start: Start = "release",
    rotor: float | None = None,
    verify: bool = False,
) -> Scan:
    """Estimate what play would do in the turning joints of a mechanism.

    Args:
        scene: with one drive that turns through; its loads and gravity act. Or its response, from
            which scans at any number of speeds take their forces without a sweep.
        speed: constant speed of the drive [rad/s].
        clearance: difference 2 s of the diameters of bush and pin [m], of all joints or by name.
        stiffness: c of a contact [N/m], likewise: of pin, bush and seat in series; or a
            `PinGeometry`, which decides it at the force of the peak.
        joints: names of those to be scanned; all that turn about one axis if None.
        damping_ratio: of the contact, as a fraction of critical damping with the joint's mean
            reduced mass along its force over a period: a joint has one damper, and a simulation
            means the same.
        start: "release", as a contact that unloads along the ramp lets go, with its damping; "rest"
            is for the paper's example.
        rotor: inertia [kg m²] that turns with the drive, which then gives way; None if its motion
            is prescribed, whatever acts.
        verify: simulate the whole mechanism with play in each joint in which something strikes, one
            at a time, and put the greatest forces beside the estimates: `Scan.verified`. Seconds
            for each.

    Raises:
        ArgumentError: a value is out of range, a contact is too soft, the scene has several drives,
            the response ends somewhere, or a peak is beyond what the geometry of a pin has a
            stiffness for.
        ModelError: a joint that is asked for has no pin, or the mechanism has no mass.
        IndeterminateError: the force of a joint that is asked for is statically indeterminate.
        AccuracyError: the forces are too uneven for a series.
        CardanError: as `Scene.sweep`.

    Source:
        Dresig and Thümmel (14) to (17), (22) to (27), (32) to (34); the reduced mass for any
        mechanism is an own derivation, as is the damped peak.
    """
    speed, source = speed_of(speed), ForceSource(scene)
    verified = scene_of(scene) if flag("verify", verify) else None
    kind = damping_ratio_of(damping_ratio), start_of(start)
    period = period_of(source.solver)
    fixed, rotors = drive_of(source.problem, rotor)
    wanted, left_out = pins_of(source.problem, joints)
    refuse_unknown(source.problem.mechanism.joints, clearance=clearance, stiffness=stiffness)
    length = source.problem.mechanism.characteristic_length
    contacts = {
        name: Contact(stiffness_of(stiffness, name), clearance_of(clearance, name, length), *kind)
        for name in wanted
    }
    found = source.forces(speed, period, wanted, left_out if joints is None else None)
    sense = float(np.sign(speed))
    places, pins = mean_positions(period), []
    states = source.closed(places.tolist())
    for name, course in found.courses.items():
        opened, swings = (
            OpenedJoint(source.problem.mechanism, name, fixed, rotors),
            course.swings(sense),
        )
        # Without damping, no mass is needed for its ratio, and where nothing swings, none at all.
        _check_stiffness(contacts[name], name, course.most, length)
        mass = opened.mean_mass(states, course.at(places)) if swings else np.nan
        pins.append(Pin(name, opened, swings, contacts[name], course, mass, rotor is None))
    same = made_of(source.problem, rotor)
    scanned = Scan(_scanned(source, pins, found, speed, period), speed, left_out, made_of=same)
    if verified is None:
        return scanned
    items, why = _verified(scanned, verified, rotor, period)
    return Scan({name: scanned[name] for name in scanned}, speed, left_out, items, why, same)


def _verified(
    scanned: Scan, scene: Scene, rotor: float | None, period: float
) -> tuple[Comparison, dict[str, str]]:
    """Return reversals beside simulations, and joints of which there is none to why."""
    items: list[Compared] = []
    failed: dict[str, str] = {}
    for name in scanned.ranking:
        worst = scanned[name].worst
        if worst is None:
            continue
        law = LinearContact(worst.stiffness, worst.damping)
        try:
            simulation = simulate(
                scene,
                scanned.speed,
                joints=name,
                clearance=worst.model.clearance,
                law=law,
                rotor=rotor,
                turns=_VERIFIED * period / (2.0 * np.pi),
                rtol=_VERIFIED_TO,
            )
            items += compare(scanned, simulation)
        except CardanError as error:
            failed[name] = str(error)
    return Comparison(items), failed


def _check_stiffness(contact: Contact, name: str, force: float, length: float) -> None:
    """Refuse a contact that gives way by the mechanism's length under the force without play.

    Raises:
        ArgumentError: it does.
    """
    law = contact.stiffness
    if not isinstance(law, PinGeometry) and not force < float(np.asarray(law)) * length:
        raise ArgumentError(
            f"joint {name!r}: its force of {force:.3g} N presses a contact of {law:g} N/m farther "
            f"than the mechanism is long, {length:.3g} m; stiffness is in N/m"
        )


def _scanned(
    source: ForceSource, pins: list[Pin], found: PinForces, speed: float, period: float
) -> dict[str, JointScan]:
    """Return what is said of each pin."""
    position = read_only(found.position)
    return {
        pin.name: JointScan(
            pin.name,
            position,
            read_only(found.forces[pin.name]),
            kept,
            len(pin.swings) - len(kept),
            abs(speed) / period,
        )
        for pin, kept in zip(pins, reversals(source, pins, speed, period), strict=True)
    }
