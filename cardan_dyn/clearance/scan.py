"""Scan: which joints of a mechanism would hammer if they had play, and how hard.

Dresig and Thümmel's estimate for every turning joint: where the force of the rigid mechanism swings
round, the pin crosses the play and strikes the other side. Reduced masses come from the mechanism.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from analytic.impact import Start

from ..checks import flag
from ..elements.contact_laws import LinearContact
from ..errors import ArgumentError, CardanError, ModelError, choices
from ..frozen import read_only
from .arguments import (
    damping_ratio_of,
    drive_of,
    period_of,
    pins_of,
    play_of,
    refuse_unknown,
    scene_of,
    speed_of,
    start_of,
    stiffness_of,
)
from .force_source import ForceSource, PinForces
from .impact_model import Contact
from .impacts import Pin, reversals
from .joint_scan import JointScan
from .opened_joint import OpenedJoint, mean_positions
from .pin_geometry import PinGeometry

if TYPE_CHECKING:
    import pandas

    from ..response.response import Response
    from ..scene.scene import Scene
    from .comparison import Compared, Comparison

_VERIFIED, _VERIFIED_TO = 2.6, 1e-7
"""Periods of a simulation that verifies, of which the first reversals do not count, and its
relative tolerance."""


class Scan(Mapping[str, JointScan]):
    """Joints by name, with what play would do in each; `print` shows a table.

    Attributes:
        speed: of the drive [rad/s].
        left_out: joints that were not scanned to why.
        verified: reversals beside simulations of the whole mechanism; None if that was not asked.
        unverified: joints of which a simulation came to nothing, to why.
    """

    def __init__(
        self,
        joints: Mapping[str, JointScan],
        speed: float,
        left_out: Mapping[str, str],
        verified: Comparison | None = None,
        unverified: Mapping[str, str] | None = None,
    ) -> None:
        self._joints = dict(joints)
        self.speed, self.left_out = speed, dict(left_out)
        self.verified, self.unverified = verified, dict(unverified or {})

    def __getitem__(self, joint: str) -> JointScan:
        if joint in self.left_out:
            raise ModelError(f"joint {joint!r} was not scanned: {self.left_out[joint]}")
        if joint not in self._joints:
            raise ModelError(f"no joint {joint!r} was scanned; {choices(self._joints, joint)}")
        return self._joints[joint]

    def __iter__(self) -> Iterator[str]:
        return iter(self._joints)

    def __len__(self) -> int:
        return len(self._joints)

    @property
    def ranking(self) -> list[str]:
        """Names of the joints by severity: the greatest force of an impact first.

        Impacts where a force turns through count by what is left of them. Joints in which nothing
        strikes follow by their greatest force without play.
        """

        def key(name: str) -> tuple[float, float]:
            joint = self._joints[name]
            return -max(joint.severity, joint.partial_severity), -joint.rigid_peak

        return sorted(self._joints, key=key)

    @property
    def notes(self) -> tuple[str, ...]:
        """What concerns whole joints, beside the doubts on single reversals."""
        bare = [
            name
            for name in self.ranking
            for law in {item.model.stiffness for item in self._joints[name].reversals}
            if isinstance(law, PinGeometry) and law.seat_stiffness is None
        ]
        notes = [f"{name}: not verified, {reason}" for name, reason in self.unverified.items()]
        if bare:
            notes.append(
                f"{', '.join(bare)}: the stiffness is that of a line contact alone, which "
                "overstates what pin, bush and seat have in series about a hundredfold; give "
                "seat_stiffness"
            )
        return tuple(notes)

    def rows(self) -> list[dict[str, Any]]:
        """Return a row for each reversal, by column, SI units, in the order of the ranking.

        `simulated` is the mean greatest force until the next reversal, if that was verified.
        """
        beside = {(item.joint, item.reversal.position): item for item in self.verified or ()}
        rows = []
        for name in self.ranking:
            for item in self._joints[name].reversals:
                row = {"joint": name, **item.row()}
                if self.verified is not None:
                    found = beside.get((name, item.position))
                    row["simulated"] = float(np.mean(found.simulated)) if found else np.nan
                rows.append(row)
        return rows

    def to_dataframe(self) -> pandas.DataFrame:
        """Return a row for each reversal, SI units, in the order of the ranking.

        Columns `exponent_...` say by which powers of speed, slope, play, mass and stiffness the
        peak grows; see `Reversal.exponents`.
        """
        import pandas

        return pandas.DataFrame(self.rows())

    def __str__(self) -> str:
        lines = [f"clearance at {self.speed:g} rad/s"]
        lines += [f"- {name}: {self._joints[name].summary}" for name in self.ranking]
        lines += str(self.verified).splitlines()[1:] if self.verified else []
        lines += [f"- {name}: not scanned, {reason}" for name, reason in self.left_out.items()]
        return "\n".join([*lines, *(f"- note: {note}" for note in self.notes)])

    __repr__ = __str__


def scan(
    scene: Scene | Response,
    speed: float,
    *,
    play: float | Mapping[str, float],
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
        play: difference 2 s of the diameters of bush and pin [m], of all joints or by name.
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
    refuse_unknown(source.problem.mechanism.joints, play=play, stiffness=stiffness)
    length = source.problem.mechanism.characteristic_length
    contacts = {
        name: Contact(stiffness_of(stiffness, name), play_of(play, name, length), *kind)
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
    scanned = Scan(_scanned(source, pins, found, speed, period), speed, left_out)
    if verified is None:
        return scanned
    items, why = _verified(scanned, verified, rotor, period)
    return Scan({name: scanned[name] for name in scanned}, speed, left_out, items, why)


def _verified(
    scanned: Scan, scene: Scene, rotor: float | None, period: float
) -> tuple[Comparison, dict[str, str]]:
    """Return reversals beside simulations, and joints of which there is none to why."""
    from .comparison import Comparison, compare
    from .simulate import simulate

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
                play=worst.model.play,
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
