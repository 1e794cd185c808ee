"""Scan: which joints of a mechanism would hammer if they had play, and how hard.

Dresig and Thümmel's estimate for every turning joint: where the force of the rigid mechanism swings
round, the pin crosses the play and strikes the other side. Reduced masses come from the mechanism.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from analytic.impact import Start

from ..errors import ModelError, choices
from ..frozen import read_only
from .arguments import (
    damping_ratio_of,
    drive_of,
    period_of,
    pins_of,
    play_of,
    refuse_unknown,
    speed_of,
    start_of,
    stiffness_of,
)
from .force_source import ForceSource, PinForces
from .impact_model import Contact
from .impacts import Pin, reversals
from .joint_scan import JointScan
from .opened_joint import OpenedJoint
from .pin_geometry import PinGeometry

if TYPE_CHECKING:
    import pandas

    from ..response.response import Response
    from ..scene.scene import Scene


class Scan(Mapping[str, JointScan]):
    """Joints by name, with what play would do in each; `print` shows a table.

    Attributes:
        speed: of the drive [rad/s].
        left_out: joints that were not scanned to why.
    """

    def __init__(
        self, joints: Mapping[str, JointScan], speed: float, left_out: Mapping[str, str]
    ) -> None:
        self._joints = dict(joints)
        self.speed, self.left_out = speed, dict(left_out)

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
        """Names of the joints by severity: the greatest peak of an impact first.

        Those in which nothing strikes follow by their greatest force without play.
        """

        def key(name: str) -> tuple[float, float]:
            joint = self._joints[name]
            return -joint.severity, -joint.rigid_peak

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
        if not bare:
            return ()
        return (
            f"{', '.join(bare)}: the stiffness is that of a line contact alone, which overstates "
            "what pin, bush and seat have in series about a hundredfold; give seat_stiffness",
        )

    def rows(self) -> list[dict[str, Any]]:
        """Return a row for each reversal, by column, SI units, in the order of the ranking."""
        return [
            {"joint": name, **item.row()}
            for name in self.ranking
            for item in self._joints[name].reversals
        ]

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
        damping_ratio: of the contact, as a fraction of critical damping with the reduced mass.
        start: "release", as a contact that unloads along the ramp lets go, with its damping; "rest"
            is for the paper's example.
        rotor: inertia [kg m²] that turns with the drive, which then gives way; None if its motion
            is prescribed, whatever acts.

    Raises:
        ArgumentError: a value is out of range, the scene has several drives, the response ends
            somewhere, or a peak is beyond what the geometry of a pin has a stiffness for.
        ModelError: a joint that is asked for has no pin, or the mechanism has no mass.
        IndeterminateError: the force of a joint that is asked for is statically indeterminate.
        AccuracyError: the forces are too uneven for a series.
        CardanError: as `Scene.sweep`.

    Source:
        Dresig and Thümmel (14) to (17), (22) to (27), (32) to (34); the reduced mass for any
        mechanism is an own derivation, as is the damped peak.
    """
    speed, source = speed_of(speed), ForceSource(scene)
    kind = damping_ratio_of(damping_ratio), start_of(start)
    period = period_of(source.solver)
    fixed, rotors = drive_of(source.problem, rotor)
    wanted, left_out = pins_of(source.problem, joints)
    refuse_unknown(source.problem.mechanism.joints, play=play, stiffness=stiffness)
    contacts = {
        name: Contact(stiffness_of(stiffness, name), play_of(play, name), *kind) for name in wanted
    }
    found = source.forces(speed, period, wanted, left_out if joints is None else None)
    sense = float(np.sign(speed))
    pins = [
        Pin(
            name,
            OpenedJoint(source.problem.mechanism, name, fixed, rotors),
            course.swings(sense),
            contacts[name],
        )
        for name, course in found.courses.items()
    ]
    return Scan(_scanned(source, pins, found, speed, period), speed, left_out)


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
        for pin, kept in zip(pins, reversals(source, pins, speed), strict=True)
    }
