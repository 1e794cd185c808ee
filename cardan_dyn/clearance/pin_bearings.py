"""Pin bearings: a universal joint with clearance between its cross and its forks.

A cross passes a moment on, and hardly a force: not its centre swings round, but the pair of forces
in the two bearings of each pin. Where the moment reverses, the bearings cross their clearance
together. The estimate is that of Dresig and Thümmel along the forces of all open bearings.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from analytic.impact import Start

from ..arrays import Array
from ..errors import AccuracyError, IndeterminateError, ModelError
from ..frozen import read_only
from .arguments import (
    damping_ratio_of,
    drive_of,
    made_of,
    period_of,
    scene_of,
    speed_of,
    start_of,
)
from .force_course import ForceCourse, Swing
from .force_source import ForceSource
from .impact_model import ImpactModel
from .opened_pins import OpenedPins, PinMobility
from .pin_case import PinCase, pin_case
from .pin_scan import PinReversal, PinScan
from .universal_joint import Pins, bearing_forces, pins_of

if TYPE_CHECKING:
    from ..results.sweep import Sweep
    from ..scene.scene import Scene

_SAMPLES, _MOST_SAMPLES = 360, 11_520
"""Positions over a period; doubled until the forces' series ends."""
_TAIL = 1e-6
"""Last harmonics of the forces, as a fraction of the greatest, at which the series ends."""
_NO_FORCE = 1e-9
"""Force, as a fraction of what inertia or other forces would make, that counts as none."""
_STAYS_CLOSED = 1.0
"""Turn-through number from which on a swing is no reversal by any measure."""
_OPEN = 1e-6
"""Part of a pair of forces that motion does not decide, as a fraction, that counts as rounding."""
_PUSHED = 1e-6
"""Part of a force on what has no mass, as a fraction of it, that counts as none."""


def scan_pins(
    scene: Scene,
    speed: float,
    joint: str,
    *,
    radius: float | Mapping[str, float],
    clearance: float | Mapping[str, float],
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
        joint: of type `universal`, with the pins `joint.turn_1` and `joint.turn_2`; or the link
            that is the cross, which two turning joints hold.
        radius: r from the joint's centre to the middle of the bearings [m], of both pins or by
            name.
        clearance: difference 2 s of the diameters of bush and pin [m], likewise.
        stiffness: c of the contact in one bearing [N/m], likewise.
        bearings: names of those that have play, or of pins for both of theirs; all four if None.
        damping_ratio: of the contact, as a fraction of critical damping with the reduced mass.
        start: "release", as a contact that unloads lets go; "rest" is for the paper's example.
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
    speed, source = speed_of(speed), ForceSource(scene_of(scene))
    given = {"radius": radius, "clearance": clearance, "stiffness": stiffness}
    case = pin_case(source.problem, joint, given, bearings)
    impact = {"damping_ratio": damping_ratio_of(damping_ratio), "start": start_of(start)}
    return PinScanner(scene, source, case, rotor).scan(speed, impact)


class PinScanner:
    """Scans of one joint of a scene, at any number of speeds."""

    def __init__(
        self, scene: Scene, source: ForceSource, case: PinCase, rotor: float | None
    ) -> None:
        """Open the joint.

        Raises:
            ArgumentError: a negative inertia, several drives, or no period.
            ModelError: nothing can move, or what would move has no mass.
            CardanError: as `Scene.sweep`.
        """
        self._scene, self._source, self._case = scene, source, case
        self._made_of = made_of(source.problem, rotor)
        self._period = period_of(source.solver)
        placed = pins_of(scene.sweep([0.0]), case.pins)
        places = placed.offsets[:, None] + np.outer(case.radii, [1.0, -1.0])
        self._opened = OpenedPins(
            scene.mechanism, case.pins, case.bearings, places, *drive_of(source.problem, rotor)
        )
        self._at_start = self._opened.mobility(source.closed([0.0])[0])
        self._movable: dict[int, Array] = {}

    def scan(self, speed: float, impact: dict[str, Any]) -> PinScan:
        """Return what play would do at a speed.

        Args:
            speed: of the drive [rad/s].
            impact: damping ratio and start.

        Raises:
            CardanError: as `scan_pins`.
        """
        case = self._case
        turn = self._turn(speed)
        swings = self._swings(turn, speed)
        reversals = self._reversals(swings, speed, impact)
        names = [case.pins[index].name for index in case.opened]
        return PinScan(
            name=case.name,
            position=read_only(np.asarray(turn.sweep.position)),
            force=read_only(_in_world(case, turn)),
            reversals=reversals,
            turning=len(swings) - len(reversals),
            periods=abs(speed) / self._period,
            bearings=tuple(bearing.name for bearing in case.bearings),
            freedoms=self._at_start.freedoms,
            radius=dict(zip(names, case.radii[case.opened].tolist(), strict=True)),
            clearance=dict(zip(names, case.clearances[case.opened].tolist(), strict=True)),
            stiffness=dict(zip(names, case.stiffnesses[case.opened].tolist(), strict=True)),
            speed=speed,
            made_of=self._made_of,
        )

    def _turn(self, speed: float) -> _Turn:
        """Return the forces of the bearings over a period.

        Raises:
            IndeterminateError: a moment is not unique.
            AccuracyError: the forces are too uneven.
        """
        count = _SAMPLES
        while True:
            positions = self._period / count * np.arange(count)
            sweep = self._scene.sweep(positions, speed)
            placed, forces = self._forces(sweep)
            course = ForceCourse(forces.reshape(count, -1), self._period)
            if course.tail <= _TAIL or np.max(np.abs(forces)) <= self._least(speed):
                break
            if count >= _MOST_SAMPLES:
                raise AccuracyError(
                    f"{count} positions do not resolve the forces in the bearings of "
                    f"{self._case.name!r} over a period"
                )
            count *= 2
        if not (self._source.is_inertial or self._source.problem.elements):
            inertial = forces - self._forces(self._scene.sweep(positions, 0.0))[1]
            course = ForceCourse(
                forces.reshape(count, -1), self._period, inertial.reshape(count, -1)
            )
        return _Turn(sweep, placed, forces, course)

    def _forces(self, sweep: Sweep) -> tuple[Pins, Array]:
        """Return where pins are, and what the bearings' motion decides of their forces `(N, B, 2)`.

        Raises:
            IndeterminateError: a moment is not unique.
        """
        case, count = self._case, len(sweep)
        placed = pins_of(sweep, case.pins)
        forces = bearing_forces(sweep, case.pins, placed, case.bearings, case.radii)
        if count not in self._movable:
            # Positions alone decide these, and every speed has the same.
            every = [self._opened.mobility(x).movable for x in sweep.motion._x]
            self._movable[count] = np.array([item @ item.T for item in every])
        stacked = self._movable[count] @ forces.reshape(count, -1, 1)
        decided = stacked.reshape(forces.shape)
        _check_moments(case, forces, decided)
        return placed, decided

    def _least(self, speed: float) -> float:
        """Return the force that counts as none, beside that of inertia at this speed [N]."""
        heaviest = 1.0 / float(np.linalg.eigvalsh(self._at_start.mobility.matrix)[0])
        return _NO_FORCE * heaviest * float(np.nanmax(self._case.radii)) * speed**2

    def _swings(self, turn: _Turn, speed: float) -> list[Swing]:
        """Return where forces are least, but not where there are none or they do not change."""
        greatest = float(np.max(np.linalg.norm(turn.forces, axis=(1, 2))))
        if greatest <= self._least(speed):
            return []
        swings = turn.course.swings(float(np.sign(speed)))
        return [item for item in swings if item.slope * self._period > _NO_FORCE * greatest]

    def _reversals(
        self, swings: list[Swing], speed: float, impact: dict[str, Any]
    ) -> tuple[PinReversal, ...]:
        """Return what happens at swings whose forces come near zero.

        Raises:
            ModelError: a force pushes what has no mass.
        """
        kept, ends = [], []
        states = self._source.closed([item.position for item in swings])
        for swing, x in zip(swings, states, strict=True):
            mobility = self._opened.mobility(x)
            _check_mass(self._case, mobility, swing)
            model = self._model(mobility, swing, speed, impact)
            share = float(np.max(self._case.shares(swing.direction)))
            time = float(model.estimate.contact_time)
            if share * swing.least < _STAYS_CLOSED * model.slope * time:
                kept.append((swing, mobility, model))
                ends.append(swing.position + speed * time)
        reversals = []
        for (swing, mobility, model), x in zip(kept, self._source.closed(ends), strict=True):
            after = self._opened.mobility(x).mobility.reduced_mass(swing.direction)
            reversals.append(self._reversal(swing, mobility, model, speed, after))
        return tuple(reversals)

    def _model(
        self, mobility: PinMobility, swing: Swing, speed: float, impact: dict[str, Any]
    ) -> ImpactModel:
        """Return the two-mass model of a swing, of the bearing that carries most."""
        case, direction = self._case, swing.direction
        return ImpactModel(
            mobility.mobility.reduced_mass(direction),
            case.stiffness(direction),
            case.clearance(direction),
            float(np.max(case.shares(direction))) * swing.slope * abs(speed),
            **impact,
        )

    def _reversal(
        self,
        swing: Swing,
        mobility: PinMobility,
        model: ImpactModel,
        speed: float,
        mass_after: float,
    ) -> PinReversal:
        """Return what is said of a swing."""
        case, direction = self._case, swing.direction
        shares = case.shares(direction)
        most = int(np.argmax(shares))
        along = direction.reshape(-1, 2)[most] @ mobility.frames[most]
        found = {name: float(value) for name, value in model.estimate._asdict().items()}
        time = found["contact_time"]
        return PinReversal(
            position=swing.position,
            force_slope=model.slope,
            direction=read_only(along / shares[most]),
            reduced_mass=model.mass,
            guided_mass=mobility.mobility.reduced_mass(direction, is_guided=True),
            turn_through=float(shares[most]) * swing.least / (model.slope * time),
            flown=abs(speed) * time / swing.way,
            mass_change=mass_after / model.mass - 1.0,
            deviation=mobility.mobility.deviation(direction),
            slope_growth=np.nan if self._source.problem.elements else swing.growth,
            model=model,
            share=tuple((shares / shares[most]).tolist()),
            split=case.split(direction, mobility.movable),
            **found,  # type: ignore[arg-type]
        )


class _Turn(NamedTuple):
    """Forces over a period.

    Attributes:
        sweep: of the scene.
        placed: where the pins are.
        forces: of the bearings `(N, B, 2)` along t and n [N].
        course: the same as functions of the position.
    """

    sweep: Sweep
    placed: Pins
    forces: Array
    course: ForceCourse


def _check_moments(case: PinCase, forces: Array, decided: Array) -> None:
    """Refuse a moment across a pin that loops leave open, as the force of its pair shows.

    Raises:
        IndeterminateError: a pin with both bearings open carries more than motion decides.
    """
    missing = forces - decided
    for index in case.opened:
        pair = [place for place, item in enumerate(case.bearings) if item.pin == index]
        if len(pair) < 2:
            continue
        open_part = np.max(np.abs(missing[:, pair[0]] - missing[:, pair[1]]))
        if open_part > _OPEN * np.max(np.abs(forces)):
            raise IndeterminateError(
                f"joint {case.pins[index].joint!r}: its moment across the pin is statically "
                "indeterminate: other parts hold the joint where its bearings have clearance; free "
                "the mechanism of what holds it twice"
            )


def _check_mass(case: PinCase, mobility: PinMobility, swing: Swing) -> None:
    """Refuse a force on what has no mass.

    Raises:
        ModelError: it has none.
    """
    if np.linalg.norm(mobility.mobility.axes @ swing.direction) < 1.0 - _PUSHED:
        raise ModelError(
            f"{case.name!r}: at {swing.position:g} rad the forces of its bearings push something "
            "without mass; give the links of the joint a mass"
        )


def _in_world(case: PinCase, turn: _Turn) -> Array:
    """Return forces `(N, B, 3)` in the world."""
    of = [bearing.pin for bearing in case.bearings]
    along = np.moveaxis(turn.placed.across[of], 0, 1)
    return turn.forces[..., :1] * along + turn.forces[..., 1:] * turn.placed.normal[:, None]
