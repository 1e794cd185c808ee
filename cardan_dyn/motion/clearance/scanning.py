"""Scan: which joints of a mechanism would hammer if they had clearance, and how hard.

Dresig and Thümmel's estimate for every turning joint, and for the bearings of universal joints:
where the force of the rigid mechanism swings round, the pin crosses the clearance and strikes the
other side. Reduced masses come from the mechanism.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from cardan_dyn.analytic.clearance import contact_time
from cardan_dyn.analytic.impact import Start

from ...core.elements.contact_laws import LinearContact
from ...core.response.identity import forces_identity
from ...kit.arrays import NOTHING, Array
from ...kit.checks import flag
from ...kit.errors import ArgumentError, CardanError, ModelError
from ...kit.frozen import read_only
from ...kit.time_left import Task
from .arguments import (
    Lengths,
    Stiffnesses,
    damping_ratio_of,
    opened_joints,
    scene_of,
    speed_of,
    start_of,
)
from .comparing import compare
from .forces import ForceCourse, ForceSource, Swing
from .impact_model import Estimates, ImpactModel, estimates
from .opened_joint import Mobility, OpenedJoint, mean_positions
from .pin_geometry import PinGeometry, StiffnessLaw
from .planar_motion import FollowedPin
from .scan_results import (
    MOST_DAMPED,
    ComparedReversal,
    ForceReversal,
    JointScan,
    Scan,
    ScanComparison,
)
from .simulating import simulate

if TYPE_CHECKING:
    from ...core.response.response import Response
    from ...scene.scene import Scene
from ..simulation.progress import INTERRUPTED

_VERIFIED, _VERIFIED_TO = 2.6, 1e-8
"""Periods of a simulation that verifies, of which the first reversals do not count, and its
relative tolerance."""
_BELOW_LIMIT = 0.5
"""Force, as a fraction of the greatest of a contact, up to which its stiffness is asked for."""
_STAYS_CLOSED = 1.0
"""Turn-through number from which on a swing is no reversal by any measure."""
_DRIVE_GIVES_WAY = "the drive gives way, and the pin is not followed in its plane: verify"
_SEVERAL_BEARINGS = (
    "pins are not followed in the planes of their bearings, and so no interval is known: simulate"
)


def scan(
    scene: Scene | Response,
    speed: float,
    *,
    clearance: Lengths,
    stiffness: Stiffnesses,
    joints: str | Collection[str] | None = None,
    radius: Lengths | None = None,
    bearings: str | Collection[str] | None = None,
    damping_ratio: float = 0.0,
    start: Start = "release",
    rotor: float | None = None,
    verify: bool = False,
) -> Scan:
    """Estimate what clearance would do in the joints of a mechanism.

    A joint that turns about one axis has one bush, in which its pin stays parallel. A universal
    joint hammers in the bearings of its pins, not at its centre: each pin has a bearing `pin+`
    where its axis points to, at the radius from the joint's centre, and `pin-` opposite. What loops
    leave open of their forces, such as a force through a cross between two shafts in fixed
    bearings, is no part of them: clearance sets it free.

    Args:
        scene: with one drive that turns through; its loads and gravity act. Or its response, from
            which scans at any number of speeds take their forces without a sweep.
        speed: constant speed of the drive [rad/s].
        clearance: difference 2 s of the diameters of bush and pin [m], of all joints or by name; of
            a universal joint by the names of its pins, as `stiffness` and `radius`.
        stiffness: c of a contact [N/m], likewise: of pin, bush and seat in series; or a
            `PinGeometry`, which decides it at the force of the peak.
        joints: names of those to be scanned; all that turn about one axis if None. Universal ones
            by a joint of type `universal`, with the pins `joint.turn_1` and `joint.turn_2`, or by
            the link that is the cross, which two turning joints hold.
        radius: of universal joints, from the centre to the middle of the bearings [m], likewise.
        bearings: of universal joints that have clearance, or pins for both of theirs; all four of
            each if None.
        damping_ratio: of the contact, as a fraction of critical damping with the joint's mean
            reduced mass along its force over a period: a joint has one damper, and a simulation
            means the same.
        start: "release", as a contact that unloads along the ramp lets go, with its damping; "rest"
            is for the paper's example.
        rotor: inertia [kg m²] that turns with the drive, which then gives way; None if its motion
            is prescribed, whatever acts.
        verify: simulate the whole mechanism with clearance in each joint whose force swings round,
            one at a time, and put the greatest forces beside what was scanned: `Scan.verified`.
            They count for the peaks. Seconds for each.

    Raises:
        ArgumentError: a value is out of range, a contact is too soft, the scene has several drives,
            the response ends somewhere, or a peak is beyond what the geometry of a pin has a
            stiffness for.
        ModelError: a joint that is asked for has no pin, there is no such universal joint or
            bearing, the mechanism or what moves has no mass, or tight bearings leave no motion.
        IndeterminateError: the force of a joint that is asked for, or the moment of a universal
            one, is statically indeterminate.
        AccuracyError: the forces are too uneven for a series.
        CardanError: as `Scene.sweep`.

    Source:
        Dresig and Thümmel (14) to (17), (22) to (27), (32) to (34), of bearings along the forces of
        the open ones; that, the reduced mass for any mechanism and the damped peak are own
        derivations.
    """
    speed = speed_of(speed)
    verified = scene_of(scene) if flag("verify", verify) else None
    scanner = Scanner(
        scene, joints, bearings, clearance, stiffness, radius, damping_ratio, start, rotor
    )
    scanned = scanner.scan(speed)
    if verified is None:
        return scanned
    items, why = _verified(scanned, verified, rotor, scanner.period)
    joints = {
        name: replace(joint, simulated=_greatest(joint, items)) for name, joint in scanned.items()
    }
    return Scan(joints, speed, scanned.left_out, items, why, scanned.made_of)


class Scanner:
    """Scans of joints of one scene, at any number of speeds.

    Attributes:
        period: of the drive [rad].
    """

    def __init__(
        self,
        given: Scene | Response,
        joints: str | Collection[str] | None,
        bearings: str | Collection[str] | None,
        clearance: Lengths,
        stiffness: Stiffnesses,
        radius: Lengths | None,
        damping_ratio: float,
        start: Start,
        rotor: float | None,
    ) -> None:
        """Check what is asked for; see `scan`."""
        self._source = source = ForceSource(given)
        self._ratio, self._start = damping_ratio_of(damping_ratio), start_of(start)
        self._joints, self._left_out = opened_joints(
            source.solver, rotor, joints, bearings, clearance, stiffness, radius
        )
        self._are_named, self._rotor = joints is not None, rotor
        self._made_of, self.period = (
            forces_identity(source.problem, rotor=None if rotor is None else float(rotor)),
            source.period,
        )

    @cached_property
    def _states(self) -> Array:
        """Closed coordinates of which mean masses are taken."""
        return self._source.closed(mean_positions(self.period).tolist())

    def scan(self, speed: float) -> Scan:
        """Return what clearance would do at a speed of the drive [rad/s]."""
        source, sense = self._source, float(np.sign(speed))
        found = source.forces(speed, self._joints, refuse=self._are_named)
        moving = []
        for name, course in found.courses.items():
            joint, swings = self._joints[name], course.swings(sense)
            self._check_stiffness(joint, course.most)
            mass, massless = self._mean_mass(joint, course, bool(swings))
            force = found.bearings[name].world
            moving.append(_Moving(joint, force, course, swings, mass, massless))
        position = read_only(found.position)
        joints = {
            item.joint.name: self._joint_scan(item, position, kept, speed)
            for item, kept in zip(moving, self._reversals(moving, speed), strict=True)
        }
        left_out = {**self._left_out, **found.left_out}
        return Scan(joints, speed, left_out, made_of=self._made_of)

    def _mean_mass(
        self, joint: OpenedJoint, course: ForceCourse, is_needed: bool
    ) -> tuple[float, str]:
        """Return the mean mass of a joint, or why it has none; refuse that where it is needed."""
        if course.most == 0.0:
            return np.nan, ""
        try:
            mass = joint.mean_mass(self._states, course.at(mean_positions(self.period)))
        except ModelError as error:
            if is_needed:
                raise
            return np.nan, str(error)
        return mass, ""

    def _check_stiffness(self, joint: OpenedJoint, force: float) -> None:
        """Refuse a contact that gives way by the mechanism's length under the rigid force."""
        length = self._source.problem.mechanism.characteristic_length
        for law in joint.laws:
            if not isinstance(law, PinGeometry) and not force < law * length:
                raise ArgumentError(
                    f"joint {joint.name!r}: its force of {force:.3g} N presses a contact of "
                    f"{law:g} N/m farther than the mechanism is long, {length:.3g} m; stiffness is "
                    "in N/m"
                )

    def _joint_scan(
        self, item: _Moving, position: Array, kept: list[ForceReversal], speed: float
    ) -> JointScan:
        """Return what is said of a joint."""
        joint = item.joint
        motion, unfollowed = self._followed(item, kept, speed)
        names = [bearing.of for bearing in joint.bearings]
        radii = {} if joint.radii is None else {
            pin.name: float(radius)
            for pin, radius in zip(joint.pins, joint.radii, strict=True)
            if pin.name in names
        }  # fmt: skip
        return JointScan(
            name=joint.name,
            position=position,
            force=read_only(item.force if joint.is_cross else item.force[:, 0]),
            reversals=tuple(replace(one, motion=motion) for one in kept),
            turning=len(item.swings) - len(kept),
            periods=abs(speed) / self.period,
            bearings=tuple(bearing.name for bearing in joint.bearings),
            freedoms=joint.at_start.movable.shape[1] if joint.is_cross else 2,
            mean_mass=item.mean_mass,
            clearance=dict(zip(names, joint.clearances.tolist(), strict=True)),
            stiffness=dict(zip(names, joint.laws, strict=True)),
            radius=radii,
            motion=motion,
            unfollowed=unfollowed,
        )

    def _followed(
        self, item: _Moving, kept: list[ForceReversal], speed: float
    ) -> tuple[FollowedPin | None, str]:
        """Return the motion of a joint's pin in its bush, or why it is not followed."""
        joint, course = item.joint, item.course
        unfollowed = item.massless
        if joint.is_cross:
            unfollowed = _SEVERAL_BEARINGS
        elif self._rotor is not None:
            unfollowed = _DRIVE_GIVES_WAY
        if unfollowed or course.most == 0.0:
            return None, unfollowed
        (law,), clearance = joint.laws, float(joint.clearances[0])
        if isinstance(law, PinGeometry):
            force = max([course.most, *(one.estimate for one in kept)])
            try:
                law = float(law.stiffness(np.asarray(force), clearance))
            except ArgumentError as error:
                return None, f"its pin is not followed, and no interval is known: {error}"
        damping = 2.0 * self._ratio * float(np.sqrt(law * item.mean_mass))
        contact = LinearContact(law, damping)
        return FollowedPin(joint, self._source, course, contact, item.mean_mass, speed), ""

    def _reversals(self, moving: list[_Moving], speed: float) -> list[list[ForceReversal]]:
        """Return of each joint its reversals: swings whose force comes near zero."""
        cases = self._cases(moving, speed)
        found = _estimated(cases)
        through = [
            case.least / (case.model.slope * float(item.contact_time))
            for case, item in zip(cases, found, strict=True)
        ]
        kept = [index for index, number in enumerate(through) if number < _STAYS_CLOSED]
        ends = [
            cases[index].swing.position + speed * float(found[index].contact_time) for index in kept
        ]
        every: dict[str, list[ForceReversal]] = {item.joint.name: [] for item in moving}
        for index, x in zip(kept, self._source.closed(ends), strict=True):
            case = cases[index]
            after = case.of.joint.mobility(x).reduced_mass(case.swing.direction)
            every[case.of.joint.name].append(
                self._reversal(
                    case, found[index], through[index], after / case.model.mass - 1.0, speed
                )
            )
        return [self._joined(item, every[item.joint.name], speed) for item in moving]

    def _cases(self, moving: list[_Moving], speed: float) -> list[_Case]:
        """Return the swings that may be reversals, with what moves there."""
        every = [(item, swing) for item in moving for swing in item.swings]
        states = self._source.closed([swing.position for _, swing in every])
        cases = []
        for (item, swing), x in zip(every, states, strict=True):
            joint, direction = item.joint, swing.direction
            if swing.slope * self.period <= NOTHING * swing.least:
                continue
            mobility = joint.mobility(x)
            joint.check_mass(mobility, direction, swing.position)
            mass, most = mobility.reduced_mass(direction), float(np.max(joint.shares(direction)))
            ratio = self._ratio * float(np.sqrt(item.mean_mass / mass))
            slope, least = most * swing.slope * abs(speed), most * swing.least
            model = ImpactModel(
                mass,
                joint.stiffness(direction),
                joint.clearance(direction),
                slope,
                min(ratio, MOST_DAMPED),
                self._start,
            )
            if least < _STAYS_CLOSED * slope * _longest(model, least):
                cases.append(_Case(item, swing, mobility, least, model))
        return cases

    def _reversal(
        self, case: _Case, found: Estimates, turn_through: float, change: float, speed: float
    ) -> ForceReversal:
        """Return what is said of a swing."""
        swing, mobility, joint = case.swing, case.mobility, case.of.joint
        shares = joint.shares(swing.direction)
        local = swing.direction.reshape(len(shares), -1)
        world = np.einsum("bd,bdi->bi", local, mobility.frames)
        directions = world / np.where(shares > 0.0, shares, 1.0)[:, None]
        most = int(np.argmax(shares))
        numbers = {name: float(value) for name, value in found._asdict().items()}
        numbers["two_mass_peak"] = numbers.pop("peak")
        critical = 2.0 * float(np.sqrt(numbers["stiffness"] * case.of.mean_mass))
        return ForceReversal(
            position=swing.position,
            force_slope=case.model.slope,
            direction=read_only(directions[most]),
            reduced_mass=case.model.mass,
            turn_through=turn_through,
            flown=abs(speed) * numbers["contact_time"] / swing.way,
            mass_change=change,
            deviation=mobility.deviation(swing.direction),
            slope_growth=np.nan if self._source.problem.elements else swing.growth,
            model=case.model,
            damping=self._ratio * critical,
            share=tuple((shares / shares[most]).tolist()),
            directions=read_only(directions) if joint.is_cross else None,
            split=joint.split(swing.direction, mobility.movable) if joint.is_cross else 0.0,
            **numbers,  # type: ignore[arg-type]
        )

    def _joined(
        self, item: _Moving, every: list[ForceReversal], speed: float
    ) -> list[ForceReversal]:
        """Return reversals, each with the way to the next and the forces on it."""
        sense, found = float(np.sign(speed)), []
        for index, one in enumerate(every):
            after = every[(index + int(sense)) % len(every)]
            way = sense * (after.position - one.position) % self.period or self.period
            ahead = item.course.greatest(one.position, way, sense)
            found.append(replace(one, way=way, ahead=tuple(ahead.tolist())))
        return found


class _Moving(NamedTuple):
    """A joint with its force, where that is least, and the mass by which its damping is meant."""

    joint: OpenedJoint
    force: Array
    course: ForceCourse
    swings: list[Swing]
    mean_mass: float
    massless: str


class _Case(NamedTuple):
    """A swing of a joint's forces, with what moves there and what it strikes.

    The model and the least force are those of the bearing that carries most.
    """

    of: _Moving
    swing: Swing
    mobility: Mobility
    least: float
    model: ImpactModel


def _longest(model: ImpactModel, least: float) -> float:
    """Return what no flight lasts longer than [s]: beyond it, a swing is no reversal in any case.

    That of a release, x³ + 6 x = τ³ + 12 ζ for its time x by ω, exceeds that from rest, τ, only
    where it is shorter than 2 ζ. Then the peak is above the ramp at the impact, and so above the
    least force of a swing that counts: no stiffness is less than that of this force.
    """
    mass, law, clearance, ratio = model.mass, model.stiffness, model.clearance, model.damping_ratio
    from_rest = float(contact_time(mass, 0.5 * clearance, model.slope))
    if not ratio or model.start != "release":
        return from_rest
    if isinstance(law, StiffnessLaw):
        if least == 0.0:
            return np.inf
        force = np.asarray(min(least, _BELOW_LIMIT * law.limit(clearance)))
        law = float(law.stiffness(force, clearance))
    return max(from_rest, 2.0 * ratio * float(np.sqrt(mass / law)))


def _estimated(cases: list[_Case]) -> list[Estimates]:
    """Return what impacts are estimated to be, in few calls: each costs more than its arrays."""
    found: dict[int, Estimates] = {}
    groups: dict[tuple[str, StiffnessLaw] | None, list[int]] = {}
    for index, case in enumerate(cases):
        # A law takes one clearance at a time.
        law = case.model.stiffness
        key = (case.of.joint.name, law) if isinstance(law, StiffnessLaw) else None
        groups.setdefault(key, []).append(index)
    for key, group in groups.items():
        some = [cases[index].model for index in group]
        given: dict[str, Any] = {
            name: np.array([getattr(model, name) for model in some])
            for name in ("mass", "stiffness", "clearance", "slope", "damping_ratio")
        }
        if key:
            given |= {"stiffness": key[1], "clearance": some[0].clearance}
        try:
            with np.errstate(over="raise"):
                values = estimates(**given, start=some[0].start)
        except FloatingPointError:
            raise ArgumentError(
                "clearance and stiffness are so great, or so small, that impacts overflow; "
                "clearance is in m, stiffness in N/m"
            ) from None
        except ArgumentError as error:
            raise ArgumentError(f"joint {key[0]!r}: {error}" if key else str(error)) from error
        for place, index in enumerate(group):
            found[index] = Estimates(*(value[place] for value in values))
    return [found[index] for index in range(len(cases))]


def _verified(
    scanned: Scan, scene: Scene, rotor: float | None, period: float
) -> tuple[ScanComparison, dict[str, str]]:
    """Return reversals beside simulations, and joints of which there is none to why."""
    items: list[ComparedReversal] = []
    failed: dict[str, str] = {}
    with Task("simulating joints", len(scanned.ranking)) as task:
        for done, name in enumerate(scanned.ranking):
            task.tell(done)
            joint = scanned[name]
            if not joint.reversals:
                continue
            pins = list(joint.clearance)
            if joint.radius and len(joint.bearings) < 2 * len(pins):
                failed[name] = "a simulation opens both bearings of a pin"
                continue
            try:
                simulation = simulate(
                    scene,
                    scanned.speed,
                    joints=pins,
                    clearance=joint.clearance,
                    law={pin: _law(joint, pin) for pin in pins},
                    radius=joint.radius or None,
                    rotor=rotor,
                    turns=_VERIFIED * period / (2.0 * np.pi),
                    rtol=_VERIFIED_TO,
                )
                if simulation.trajectory.reason == INTERRUPTED:
                    # By Ctrl-C, which is meant for those that follow as well.
                    rest = (item for item in scanned.ranking[done:] if scanned[item].reversals)
                    failed |= dict.fromkeys(rest, INTERRUPTED)
                    break
                items += compare(scanned, simulation)
            except CardanError as error:
                failed[name] = str(error)
    return ScanComparison(items), failed


def _greatest(joint: JointScan, items: ScanComparison) -> dict[str, float]:
    """Return the greatest simulated force of each bearing of a joint."""
    found: dict[str, float] = {}
    for item in items:
        if item.joint in joint.bearings:
            most = float(np.max(item.simulated))
            found[item.joint] = max(most, found.get(item.joint, 0.0))
    return found


def _law(joint: JointScan, pin: str) -> LinearContact:
    """Return the contact of a pin's bearings at the worst reversal of a joint."""
    bearings = joint.by_bearing()
    own = bearings[pin if pin in bearings else f"{pin}+"]
    index = joint.reversals.index(joint.worst)
    worst = own.reversals[index]
    return LinearContact(worst.stiffness, worst.damping)
