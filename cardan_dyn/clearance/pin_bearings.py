"""Pin bearings: a universal joint with play between its cross and its forks.

A cross passes a moment on, and hardly a force: not its centre swings round, but the pair of forces
in the two bearings of each pin. Where the moment reverses, the bearings cross their play together.
The estimate is that of Dresig and Thümmel along the forces of all open bearings.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from analytic.impact import Start

from ..arrays import Array
from ..checks import names, text
from ..errors import AccuracyError, ArgumentError, IndeterminateError, ModelError
from ..frozen import read_only
from .force_course import ForceCourse, Swing
from .joint_scan import Reversal
from .opened_pins import OpenedPins, PinMobility
from .pin_scan import PinReversal, PinScan
from .scan import _closed, _drive, _Impact, _number, _of, _period, _Pin
from .universal_joint import (
    Bearing,
    Pins,
    UniversalPin,
    bearing_forces,
    bearings_of,
    pins_of,
    universal_pins,
)

if TYPE_CHECKING:
    from ..results.sweep import Sweep
    from ..scene.scene import Scene

_SAMPLES, _MOST_SAMPLES = 360, 5_760
"""Positions over a period; doubled until the forces' series ends."""
_TAIL = 1e-6
"""Last harmonics of a force, as a fraction of its greatest, at which the series ends."""
_NO_FORCE = 1e-9
"""Part of the moments' forces, as a fraction, that counts as none."""
_STAYS_CLOSED = 1.0
"""Turn-through number from which on a swing is no reversal by any measure."""
_PUSHED = 1e-6
"""Part of a force on what has no mass, as a fraction of it, that counts as none."""


def scan_pins(
    scene: Scene,
    speed: float,
    joint: str,
    *,
    radius: float | Mapping[str, float],
    play: float | Mapping[str, float],
    stiffness: float | Mapping[str, float],
    bearings: str | Collection[str] | None = None,
    damping_ratio: float = 0.0,
    start: Start = "release",
    rotor: float | None = None,
) -> PinScan:
    """Estimate what play in the pin bearings of a universal joint would do: theory alone.

    Each pin has a bearing `pin+` where its axis points to, at the radius from the joint's centre,
    and `pin-` opposite. What loops leave open, such as a force through a cross between two shafts
    in fixed bearings, is no part of the forces: play sets it free.

    Args:
        scene: with one drive that turns through; its loads and gravity act.
        speed: constant speed of the drive [rad/s].
        joint: of type `universal`, with the pins `joint.turn_1` and `joint.turn_2`; or the link that
            is the cross, which two turning joints hold.
        radius: r from the joint's centre to the middle of the bearings [m], of both pins or by name.
        play: difference 2 s of the diameters of bush and pin [m], likewise.
        stiffness: c of the contact in one bearing [N/m], likewise.
        bearings: names of those that have play, or of pins for both of theirs; all four if None.
        damping_ratio: of the contact, as a fraction of critical damping with the reduced mass.
        start: "release", as a spring lets go; "rest" is for the paper's example.
        rotor: inertia [kg m²] that turns with the drive, which then gives way; None if its motion
            is prescribed, whatever acts.

    Raises:
        ArgumentError: a value is out of range, or the scene has several drives.
        ModelError: there is no such universal joint or bearing, its pins are no outputs, what moves
            has no mass, or the tight bearings leave no motion.
        IndeterminateError: the moment of the joint is statically indeterminate.
        AccuracyError: the forces are too uneven for a series.
        CardanError: as `Scene.sweep`.

    Source:
        Dresig and Thümmel (14) to (17), (22) to (27), (32) to (34), along the forces of the open
        bearings; that, and the reduced mass, are own derivations.
    """
    case = _case(scene, joint, radius, play, stiffness, bearings)
    impact = _Impact(_number("speed", speed), damping_ratio, start)
    period = _period(scene, impact.speed)
    fixed, rotors = _drive(scene, rotor)
    sweep, placed, forces = _forces(scene, impact.speed, period, case)
    places = placed.offsets[:, None] + np.outer(case.radii, [1.0, -1.0])
    opened = OpenedPins(scene.mechanism, case.pins, case.bearings, places, fixed, rotors)
    at_start = opened.mobility(sweep.motion._x[0])
    forces = _determined(sweep, opened, forces)
    stacked = forces.reshape(len(forces), -1)
    swings = _swings(stacked, period, impact.speed, _inertial(at_start, case, impact.speed))
    reversals, turning = _reversals(scene, case, opened, swings, impact)
    names = [case.pins[index].name for index in case.opened]
    return PinScan(
        name=joint,
        position=sweep.position,
        force=read_only(_in_world(case, placed, forces)),
        reversals=reversals,
        turning=turning,
        periods=abs(impact.speed) / period,
        bearings=tuple(bearing.name for bearing in case.bearings),
        freedoms=at_start.freedoms,
        radius=dict(zip(names, case.radii[case.opened].tolist(), strict=True)),
        play=dict(zip(names, case.plays[case.opened].tolist(), strict=True)),
        speed=impact.speed,
    )


class _Case(NamedTuple):
    """A universal joint with play.

    Attributes:
        pins: of its cross.
        bearings: that have play.
        opened: indices of the pins that have some of them.
        radii, plays, stiffnesses: `(2,)` of the pins; NaN of one without play.
    """

    pins: tuple[UniversalPin, UniversalPin]
    bearings: tuple[Bearing, ...]
    opened: list[int]
    radii: Array
    plays: Array
    stiffnesses: Array

    def contact(self, direction: Array) -> tuple[float, float, Array]:
        """Return play, stiffness and shares `(B,)` for forces along a stacked direction.

        Where forces are in equilibrium, the bearings' ways add up by virtual work. Everything is
        referred to the bearing that carries most.
        """
        shares = np.linalg.norm(direction.reshape(-1, 2), axis=1)
        greatest = float(np.max(shares))
        of = [bearing.pin for bearing in self.bearings]
        play = greatest * float(shares @ self.plays[of])
        return play, 1.0 / float(np.sum(shares**2 / self.stiffnesses[of])), shares / greatest

    def split(self, direction: Array, mobility: PinMobility) -> float:
        """Return the part of the play that cannot close in all bearings at once."""
        pairs = direction.reshape(-1, 2)
        of = [bearing.pin for bearing in self.bearings]
        sizes = np.linalg.norm(pairs, axis=1, keepdims=True)
        closing = (self.plays[of, None] * pairs / np.where(sizes > 0.0, sizes, 1.0)).ravel()
        missed = closing - mobility.determined(closing)
        return float(np.linalg.norm(missed) / np.linalg.norm(closing))


def _case(
    scene: Scene,
    joint: str,
    radius: float | Mapping[str, float],
    play: float | Mapping[str, float],
    stiffness: float | Mapping[str, float],
    asked: str | Collection[str] | None,
) -> _Case:
    """Check what belongs to the joint.

    Raises:
        ArgumentError: a value is missing or out of range.
        ModelError: there is no such joint or bearing, or it is no output.
    """
    pins = universal_pins(scene.mechanism, text("joint", joint))
    for pin in pins:
        if pin.joint not in scene.outputs:
            raise ModelError(f"joint {pin.joint!r} is no output of the scene; name it there")
    wanted = tuple(pin.name for pin in pins) if asked is None else names("bearings", asked)
    bearings = bearings_of(pins, wanted)
    if not bearings:
        raise ArgumentError("bearings names none; leave it out for all four")
    opened = sorted({bearing.pin for bearing in bearings})
    values = np.full((3, 2), np.nan)
    given = {"radius": radius, "play": play, "stiffness": stiffness}
    for row, (label, value) in zip(values, given.items(), strict=True):
        for index in opened:
            row[index] = _of(label, value, pins[index].name)
    return _Case(pins, bearings, opened, *values)


def _forces(scene: Scene, speed: float, period: float, case: _Case) -> tuple[Sweep, Pins, Array]:
    """Return a sweep over a period, where the pins are, and forces of the bearings `(N, B, 2)`.

    Raises:
        IndeterminateError: a moment is not unique.
        AccuracyError: the forces are too uneven.
    """
    count = _SAMPLES
    while True:
        sweep = scene.sweep(period / count * np.arange(count), speed)
        for index in case.opened:
            _check_moment(sweep, case.pins[index])
        placed = pins_of(sweep, case.pins)
        forces = bearing_forces(sweep, case.pins, placed, case.bearings, case.radii)
        if ForceCourse(forces.reshape(count, -1), period).tail <= _TAIL:
            return sweep, placed, forces
        if not np.max(np.abs(forces)) > _NO_FORCE:
            return sweep, placed, forces
        if count >= _MOST_SAMPLES:
            raise AccuracyError(
                f"{count} positions do not resolve the forces of {case.bearings[0].name!r} over a "
                "period"
            )
        count *= 2


def _check_moment(sweep: Sweep, pin: UniversalPin) -> None:
    """Refuse a moment that is not unique.

    Raises:
        IndeterminateError: it is not.
    """
    across = np.abs(pin.part.axis) < 1.0 - 1e-9
    unique = sweep[pin.joint].unique[3:]
    if not np.all(unique[across]):
        names = "".join(letter for letter, bad in zip("xyz", across & ~unique, strict=True) if bad)
        raise IndeterminateError(
            f"joint {pin.joint!r}: its moment {names} is statically indeterminate; give "
            "compliances= to the scene, or free the mechanism of what holds it twice"
        )


def _determined(sweep: Sweep, opened: OpenedPins, forces: Array) -> Array:
    """Return the part of forces `(N, B, 2)` that laws of motion decide where bearings are open."""
    found = np.empty_like(forces)
    for row, (x, force) in enumerate(zip(sweep.motion._x, forces, strict=True)):
        found[row] = opened.mobility(x).determined(force.ravel()).reshape(-1, 2)
    return found


def _in_world(case: _Case, placed: Pins, forces: Array) -> Array:
    """Return forces `(N, B, 3)` in the world."""
    of = [bearing.pin for bearing in case.bearings]
    along = np.moveaxis(placed.across[of], 0, 1)
    return forces[..., :1] * along + forces[..., 1:] * placed.normal[:, None]


def _inertial(mobility: PinMobility, case: _Case, speed: float) -> float:
    """Return the force that inertia would make of a motion as wide as the joint [N]."""
    heaviest = 1.0 / float(np.linalg.eigvalsh(mobility.mobility.matrix)[0])
    return heaviest * float(np.nanmax(case.radii)) * speed**2


def _swings(forces: Array, period: float, speed: float, inertial: float) -> list[Swing]:
    """Return where stacked forces `(N, 2 B)` are least, but not where they are or stay constant."""
    greatest = float(np.max(np.linalg.norm(forces, axis=1)))
    if greatest <= _NO_FORCE * inertial:
        return []
    swings = ForceCourse(forces, period).swings(float(np.sign(speed)))
    return [item for item in swings if item.slope * period > _NO_FORCE * greatest]


def _reversals(
    scene: Scene, case: _Case, opened: OpenedPins, swings: list[Swing], impact: _Impact
) -> tuple[tuple[Reversal, ...], int]:
    """Return what happens at swings, and how many of them are no reversals.

    Raises:
        ModelError: a force pushes what has no mass.
    """
    found = []
    for swing, x in zip(swings, _closed(scene, [item.position for item in swings]), strict=True):
        mobility = opened.mobility(x)
        direction = mobility.determined(swing.direction)
        if np.linalg.norm(mobility.mobility.axes @ direction) < 1.0 - _PUSHED:
            raise ModelError(
                f"at {swing.position:g} rad, forces of {case.bearings[0].name!r} push something "
                "without mass; give the links of the joint a mass"
            )
        play, stiffness, share = case.contact(direction)
        scale = float(np.max(np.linalg.norm(direction.reshape(-1, 2), axis=1)))
        one = swing._replace(
            least=scale * swing.least, slope=scale * swing.slope, direction=direction
        )
        # TODO
        item = impact.of(_Pin(opened, swings, play, stiffness), one, mobility.mobility)
        most = int(np.argmax(share))
        found.append((item, direction, PinReversal(
            **{**vars(item), "direction": direction.reshape(-1, 2)[most] @ mobility.frames[most] / scale},
            share=tuple(share.tolist()), split=case.split(direction, mobility),
        )))
    ends = [item.position + impact.speed * item.contact_time for _, _, item in found]
    kept = []
    for (_, direction, item), x in zip(found, _closed(scene, ends), strict=True):
        if item.turn_through < _STAYS_CLOSED:
            mass = opened.mobility(x).mobility.reduced_mass(direction)
            kept.append(replace(item, mass_change=mass / item.reduced_mass - 1.0))
    return tuple(kept), len(swings) - len(kept)
