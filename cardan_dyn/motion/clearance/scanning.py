"""Scan: which joints of a mechanism would hammer if they had clearance, and how hard.

Dresig and Thümmel's estimate for every turning joint, and for the bearings of universal joints:
where the force of the rigid mechanism swings round, the pin crosses the clearance and strikes the
other side. Reduced masses come from the mechanism.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

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
from .impact_model import ImpactModel, estimate
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
        name: replace(joint, simulated=_simulated(joint, items)) for name, joint in scanned.items()
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
        self._are_named, self._rotor, self.period = joints is not None, rotor, source.period
        inertia = None if rotor is None else float(rotor)
        self._made_of = forces_identity(source.problem, rotor=inertia)

    @cached_property
    def _states(self) -> Array:
        """Closed coordinates of which mean masses are taken."""
        return self._source.closed(mean_positions(self.period).tolist())

    def scan(self, speed: float) -> Scan:
        """Return what clearance would do at a speed of the drive [rad/s]."""
        sense = float(np.sign(speed))
        positions, forces, courses, left_out = self._source.forces(
            speed, self._joints, refuse=self._are_named
        )
        swings = {name: course.swings(sense) for name, course in courses.items()}
        means = {name: self._mean(name, courses[name], bool(swings[name])) for name in courses}
        masses = {name: mass for name, (mass, _) in means.items()}
        reversals = self._reversals(swings, masses, speed)
        scans, position = {}, read_only(positions)
        for name, course in courses.items():
            joint, found = self._joints[name], reversals[name]
            items = []
            for index, item in enumerate(found):
                after = found[(index + int(sense)) % len(found)]
                way = sense * (after.position - item.position) % self.period or self.period
                ahead = tuple(course.greatest(item.position, way, sense).tolist())
                items.append(replace(item, way=way, ahead=ahead))
            motion, why = self._followed(joint, course, means[name], items, speed)
            force, pins = forces[name].world, [item.of for item in joint.bearings]
            radius: dict[str, float] = {}
            if joint.radii is not None:
                radius = {item.of: float(joint.radii[item.pin]) for item in joint.bearings}
            scans[name] = JointScan(
                name=name,
                position=position,
                force=read_only(force if joint.is_cross else force[:, 0]),
                reversals=tuple(replace(item, motion=motion) for item in items),
                turning=len(swings[name]) - len(items),
                periods=abs(speed) / self.period,
                bearings=tuple(item.name for item in joint.bearings),
                freedoms=joint.at_start.movable.shape[1] if joint.is_cross else 2,
                mean_mass=masses[name],
                clearance=dict(zip(pins, joint.clearances.tolist(), strict=True)),
                stiffness=dict(zip(pins, joint.laws, strict=True)),
                radius=radius,
                motion=motion,
                unfollowed=why,
            )
        return Scan(scans, speed, {**self._left_out, **left_out}, made_of=self._made_of)

    def _mean(self, name: str, course: ForceCourse, is_needed: bool) -> tuple[float, str]:
        """Return the mean mass of a joint, or why it has none; refuse that where it is needed.

        A contact that gives way by the mechanism's length under the rigid force is refused as well.
        """
        joint, length = self._joints[name], self._source.problem.mechanism.characteristic_length
        for law in joint.laws:
            if not isinstance(law, PinGeometry) and not course.most < law * length:
                raise ArgumentError(
                    f"joint {name!r}: its force of {course.most:.3g} N presses a contact of "
                    f"{law:g} N/m farther than the mechanism is long, {length:.3g} m; stiffness is "
                    "in N/m"
                )
        if course.most == 0.0:
            return np.nan, ""
        try:
            return joint.mean_mass(self._states, course.at(mean_positions(self.period))), ""
        except ModelError as error:
            if is_needed:
                raise
            return np.nan, str(error)

    def _followed(
        self,
        joint: OpenedJoint,
        course: ForceCourse,
        mean: tuple[float, str],
        found: list[ForceReversal],
        speed: float,
    ) -> tuple[FollowedPin | None, str]:
        """Return the motion of a joint's pin in its bush, or why it is not followed."""
        mass, unfollowed = mean
        if joint.is_cross:
            unfollowed = _SEVERAL_BEARINGS
        elif self._rotor is not None:
            unfollowed = _DRIVE_GIVES_WAY
        if unfollowed or course.most == 0.0:
            return None, unfollowed
        (law,), clearance = joint.laws, float(joint.clearances[0])
        if isinstance(law, PinGeometry):
            force = max([course.most, *(item.estimate for item in found)])
            try:
                law = float(law.stiffness(np.asarray(force), clearance))
            except ArgumentError as error:
                return None, f"its pin is not followed, and no interval is known: {error}"
        contact = LinearContact(law, 2.0 * self._ratio * float(np.sqrt(law * mass)))
        return FollowedPin(joint, self._source, course, contact, mass, speed), ""

    def _reversals(
        self, swings: dict[str, list[Swing]], masses: dict[str, float], speed: float
    ) -> dict[str, list[ForceReversal]]:
        """Return of each joint its reversals: swings whose force comes near zero."""
        every = [(name, swing) for name, some in swings.items() for swing in some]
        states = self._source.closed([swing.position for _, swing in every])
        cases = []
        for (name, swing), x in zip(every, states, strict=True):
            joint, direction = self._joints[name], swing.direction
            if swing.slope * self.period <= NOTHING * swing.least:
                continue
            mobility = joint.mobility(x)
            joint.check_mass(mobility, direction, swing.position)
            # The model and the least force are those of the bearing that carries most.
            mass, most = mobility.reduced_mass(direction), float(np.max(joint.shares(direction)))
            model = ImpactModel(
                mass,
                joint.stiffness(direction),
                joint.clearance(direction),
                most * swing.slope * abs(speed),
                min(self._ratio * float(np.sqrt(masses[name] / mass)), MOST_DAMPED),
                self._start,
            )
            if most * swing.least < model.slope * _longest(model, most * swing.least):
                cases.append((name, swing, mobility, model, most))
        estimate([(name, model) for name, _, _, model, _ in cases])
        kept, ends = [], []
        for name, swing, mobility, model, most in cases:
            time = float(model.estimate.contact_time)
            through = most * swing.least / (model.slope * time)
            if through < 1.0:
                kept.append((name, swing, mobility, model, through))
                ends.append(swing.position + speed * time)
        found: dict[str, list[ForceReversal]] = {name: [] for name in swings}
        for (name, swing, mobility, model, through), x in zip(
            kept, self._source.closed(ends), strict=True
        ):
            case = self._joints[name], swing, mobility, model, through, x, masses[name], speed
            found[name].append(self._reversal(*case))
        return found

    def _reversal(
        self,
        joint: OpenedJoint,
        swing: Swing,
        mobility: Mobility,
        model: ImpactModel,
        turn_through: float,
        after: Array,
        mean_mass: float,
        speed: float,
    ) -> ForceReversal:
        """Return what is said of a swing; `after` are coordinates at the impact."""
        shares = joint.shares(swing.direction)
        local = swing.direction.reshape(len(shares), -1)
        world = np.einsum("bd,bdi->bi", local, mobility.frames)
        directions = world / np.where(shares > 0.0, shares, 1.0)[:, None]
        # The first of those that carry as much but for rounding.
        most = int(np.argmax(shares >= (1.0 - NOTHING) * np.max(shares)))
        numbers = {name: float(value) for name, value in model.estimate._asdict().items()}
        numbers["two_mass_peak"] = numbers.pop("peak")
        end_mass = joint.mobility(after).reduced_mass(swing.direction)
        return ForceReversal(
            position=swing.position,
            force_slope=model.slope,
            direction=read_only(directions[most]),
            reduced_mass=model.mass,
            turn_through=turn_through,
            flown=abs(speed) * numbers["contact_time"] / swing.way,
            mass_change=end_mass / model.mass - 1.0,
            deviation=mobility.deviation(swing.direction),
            slope_growth=np.nan if self._source.problem.elements else swing.growth,
            model=model,
            damping=2.0 * self._ratio * float(np.sqrt(numbers["stiffness"] * mean_mass)),
            share=tuple((shares / np.max(shares)).tolist()),
            directions=read_only(directions) if joint.is_cross else None,
            split=joint.split(swing.direction, mobility.movable) if joint.is_cross else 0.0,
            **numbers,  # type: ignore[arg-type]
        )


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
        # Half the greatest force is one of which a contact has a stiffness.
        force = np.asarray(min(least, 0.5 * law.limit(clearance)))
        law = float(law.stiffness(force, clearance))
    return max(from_rest, 2.0 * ratio * float(np.sqrt(mass / law)))


def _verified(
    scanned: Scan, scene: Scene, rotor: float | None, period: float
) -> tuple[ScanComparison, dict[str, str]]:
    """Return reversals beside simulations, and joints of which there is none to why."""
    items: list[ComparedReversal] = []
    failed: dict[str, str] = {}
    names = [name for name in scanned.ranking if scanned[name].reversals]
    with Task("simulating joints", len(names)) as task:
        for done, name in enumerate(names):
            task.tell(done)
            joint = scanned[name]
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
                    failed |= dict.fromkeys(names[done:], INTERRUPTED)
                    break
                items += compare(scanned, simulation)
            except CardanError as error:
                failed[name] = str(error)
    return ScanComparison(items), failed


def _simulated(joint: JointScan, items: ScanComparison) -> dict[str, float]:
    """Return the greatest simulated force of each bearing of a joint."""
    return {
        name: max(float(np.max(item.simulated)) for item in items if item.joint == name)
        for name in joint.bearings
        if any(item.joint == name for item in items)
    }


def _law(joint: JointScan, pin: str) -> LinearContact:
    """Return the contact of a pin's bearings at the worst reversal of a joint."""
    bearings = joint.by_bearing()
    own = bearings[pin if pin in bearings else f"{pin}+"]
    worst = own.reversals[joint.reversals.index(joint.worst)]
    return LinearContact(worst.stiffness, worst.damping)
