"""Simulate: a whole mechanism with clearance in one or more of its pins, every impact located."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio

from ...core.elements.contact_laws import ContactLaw, LinearContact
from ...core.response.identity import forces_identity
from ...kit.arrays import NOTHING, Array
from ...kit.checks import described, number, positive
from ...kit.differences import displacements, slopes
from ...kit.errors import ArgumentError, IndeterminateError
from ...kit.roots import zero
from .arguments import (
    clearance_of,
    damping_ratio_of,
    joint_names,
    of_joint,
    period_of,
    pins_of,
    refuse_unknown,
    scene_of,
    speed_of,
    universal_pins,
)
from .contact_simulation import ContactSimulation
from .opened_joint import OpenedJoint, across_pin, mean_positions, normal_of, what_is_open
from .opened_scene import Opened, OpenPin, opened

if TYPE_CHECKING:
    from ...core.mechanism.mechanism import Mechanism
    from ...scene.scene import Scene


def simulate(
    scene: Scene,
    speed: float,
    *,
    joints: str | Collection[str],
    clearance: float | Mapping[str, float],
    law: ContactLaw | Mapping[str, ContactLaw] | None = None,
    stiffness: float | Mapping[str, float] | None = None,
    damping_ratio: float = 0.0,
    friction: float | Mapping[str, float] = 0.0,
    pin_radius: float | Mapping[str, float] = 0.0,
    radius: float | Mapping[str, float] | None = None,
    rotor: float | None = None,
    turns: float = 2.0,
    position: float | None = None,
    max_touches: int = 100_000,
    rtol: float = 1e-10,
    progress: bool | Callable[[float], object] | None = None,
) -> ContactSimulation:
    """Simulate a mechanism whose pins have clearance in their bushes.

    Joints are opened across their axes; pins begin pressed into their walls by the forces of the
    mechanism without clearance. How that differs from what follows decays with the damping. The
    bush belongs to a joint's parent or a loop's predecessor: friction acts where its wall is
    touched.

    Args:
        scene: with one drive that turns.
        speed: of the drive, the first one if it is free [rad/s].
        joints: names of the turning joints that have clearance; the link that is a cross stands for
            both of its pins, which need a `radius`.
        clearance: difference 2 s of the diameters of bush and pin [m], of all joints or by name.
        law: of the contact, likewise, such as `HuntCrossley`.
        stiffness: instead of a law, that of a `LinearContact`, likewise [N/m].
        damping_ratio: of that, as a scan with the same rotor has it: a fraction of critical damping
            with the joint's mean reduced mass along its force over a period, from 0 to below 1.
        friction: coefficient of Coulomb's friction along the wall, likewise.
        pin_radius: of pins whose surfaces slide as they turn, likewise [m].
        radius: of joints whose pin has two bearings, as those of a cross: their distance from its
            origin [m], of all joints or by name; those without it have one bush.
        rotor: inertia that turns with the drive, which then gives way [kg m²]; None if it does not.
        turns: of the drive at its speed, after which it ends.
        position: of the drive where it begins [rad]; far from reversals of forces if None.
        max_touches: of pins and walls after which it ends with what it has.
        rtol: relative tolerance of each step.
        progress: whether to show how far it is; in terminals and notebooks if None. Or a function
            of the fraction done.

    Raises:
        ArgumentError: a value is out of range, or the scene has several drives.
        ModelError: a joint has no pin, or the others hold it whatever its clearance; a link is no
            cross.
        CardanError: as `Scene.simulate`.
    """
    begun = RigidStart(scene, speed, joints, position, radius, rotor)
    values = {"clearance": clearance, "law": law, "stiffness": stiffness, "friction": friction}
    refuse_unknown(scene.mechanism.joints, pin_radius=pin_radius, **values)
    ratio, length = damping_ratio_of(damping_ratio), scene.mechanism.characteristic_length
    pins = [
        OpenPin(
            name,
            clearance_of(clearance, name, length),
            _law(name, begun, law, stiffness, ratio),
            number(*of_joint("friction", friction, name), least=0.0),
            number(*of_joint("pin_radius", pin_radius, name), least=0.0),
            begun.reach.get(name),
        )
        for name in begun.joints
    ]
    found = opened(scene, pins, number("rotor", rotor or 0.0, least=0.0))
    duration = 2.0 * np.pi * positive("turns", turns) / abs(begun.speed)
    start = begun.state(found, pins, is_free=rotor is not None)
    limits: dict[str, Any] = {"rtol": rtol, "max_touches": max_touches, "progress": progress}
    if rotor is not None:
        found = found._replace(scene=found.scene.replace(free=found.scene.coordinates))
    trajectory = found.scene.simulate(duration, **start, **limits)
    same = forces_identity(scene.problem, rotor=None if rotor is None else float(rotor))
    return ContactSimulation(trajectory, found.contacts, found.drive, begun.speed, same)


def _law(name: str, begun: RigidStart, given: Any, stiffness: Any, ratio: float) -> ContactLaw:
    """Return the law of a joint's contact: one that is given, or a linear one of a stiffness."""
    if (given is None) == (stiffness is None):
        raise ArgumentError("give either law= or stiffness=, of the contact")
    if given is not None:
        if ratio:
            raise ArgumentError("damping_ratio belongs to stiffness=; a law has its own")
        label, law = of_joint("law", given, name)
        if not isinstance(law, ContactLaw):
            raise ArgumentError(
                f"{label} is {described(law)}, expected a contact law such as "
                "LinearContact(1e8, damping=1e3)"
            )
        return law
    checked = positive(*of_joint("stiffness", stiffness, name))
    if not ratio:
        return LinearContact(checked)
    if name in begun.reach:
        raise ArgumentError(
            f"damping_ratio of joint {name!r}: several bearings move together, and no mass "
            "belongs to one alone; give law=LinearContact.of_ratio(stiffness, ratio, mass)"
        )
    return LinearContact(checked, 2.0 * ratio * float(np.sqrt(checked * begun.reduced_mass(name))))


class RigidStart:
    """The mechanism without clearance, as it moves where a simulation begins.

    Attributes:
        joints: names of the joints that have clearance.
        speed: of the drive [rad/s].
        position: of the drive [rad].
        reach: joints whose pin has two bearings to their distance from its origin [m].
    """

    def __init__(
        self,
        scene: Scene,
        speed: Any,
        joints: str | Collection[str],
        position: Any = None,
        radius: Any = None,
        rotor: Any = None,
    ) -> None:
        """Check what is asked for.

        Args:
            scene: with one drive.
            speed: of it [rad/s].
            joints: that have clearance.
            position: of the drive [rad]; where all forces are far from a reversal if None.
            radius: see `reach`.
            rotor: inertia that turns with the drive [kg m²]; None if its motion is prescribed.
        """
        self._scene, self._rotor, self.speed = scene_of(scene), rotor, speed_of(speed)
        self._period = period_of(scene.solver)
        if joints is None:
            raise ArgumentError("joints is None; name those that have clearance")
        mechanism, found, crosses = scene.mechanism, [], {}
        for name in joint_names(joints):
            owner, _, _ = name.rpartition(".")
            if name in mechanism.links and name not in mechanism.joints:
                crosses[name] = universal_pins(mechanism, name)
                found += [pin.name for pin in crosses[name]]
            else:
                found.append(owner if owner in mechanism.joints else name)
        self.joints, _ = pins_of(scene.problem, found)
        joint_names(self.joints)
        self.reach = self._reach(radius)
        for name, pins in crosses.items():
            start = scene.sweep([0.0])
            normal_of(pins, [start.rotation(pin.joint)[0] @ pin.part.axis for pin in pins])
            for pin in pins:
                if pin.name not in self.reach:
                    raise ArgumentError(
                        f"radius has none of {pin.name!r}; give the distance of its bearings from "
                        f"the centre of the cross {name!r}"
                    )
        self.position = self._steady() if position is None else number("position", position)

    def _reach(self, radius: Any) -> dict[str, float]:
        """Return the distances of bearings from the origins of joints."""
        refuse_unknown(self.joints, "has no clearance", radius=radius)
        names = self.joints if radius is not None and not isinstance(radius, Mapping) else radius
        return {name: positive(*of_joint("radius", radius, name)) for name in names or ()}

    def _steady(self) -> float:
        """Position of the drive at which all forces are far from a reversal [rad]."""
        positions = self._period * np.arange(180) / 180
        sweep = self._scene.sweep(positions, self.speed)
        least = np.ones(len(positions))
        for name in self.joints:
            sizes = np.linalg.norm(self._force(sweep, name, self.reach.get(name)), axis=1)
            if np.any(sizes > 0.0):
                least = np.minimum(least, sizes / np.max(sizes))
        return float(positions[np.argmax(least)])

    def reduced_mass(self, name: str) -> float:
        """Return the mass by which a scan means the damping ratio of a joint [kg]."""
        scene = self._scene
        sweep = scene.sweep(mean_positions(self._period), self.speed)
        if reason := what_is_open(scene.solver, sweep, name):
            raise IndeterminateError(
                f"damping_ratio of joint {name!r}: {reason}, or give law=LinearContact(stiffness, "
                "damping) instead"
            )
        opened = OpenedJoint(scene.solver, self._rotor, name)
        force = across_pin(sweep, sweep.motion, name)
        return opened.mean_mass(sweep.motion.rows, force)

    def state(self, opened: Opened, pins: Sequence[OpenPin], *, is_free: bool) -> dict[str, Any]:
        """Return where and how fast a simulation begins, as `Scene.simulate` takes it.

        Args:
            opened: the scene with open joints.
            pins: of the joints.
            is_free: whether nobody moves the drive.
        """
        begun, drive = self._slides(opened.scene.mechanism, pins), opened.drive
        free = [name for name in opened.scene.coordinates if name != drive]
        driven = {drive: self.speed}
        return {
            "position": {drive: self.position, **{name: begun[name][0] for name in free}},
            "speed": {**(driven if is_free else {}), **{name: begun[name][1] for name in free}},
            **({} if is_free else {"motion": driven}),
        }

    def _slides(self, opened: Mechanism, pins: Sequence[OpenPin]) -> dict[str, tuple[float, float]]:
        """Return positions and speeds of the slides and tilts of open joints by name.

        Those whose force is not unique begin in the middle of the clearance, at rest.
        """
        unit = np.ones(1)  # A radian.
        sweep = self._scene.sweep(self.position + np.append(0.0, displacements(unit)), self.speed)
        result: dict[str, tuple[float, float]] = {}
        for item in pins:
            places = self._places(sweep, opened, item)
            rates = self.speed * slopes(places[1:], unit)[:, 0]
            moving = zip(places[0].tolist(), rates.tolist(), strict=True)
            result.update(zip(opened.joint(item.joint).coordinates[:-1], moving, strict=True))
        return result

    def _places(self, sweep: Any, opened: Mechanism, pin: OpenPin) -> Array:
        """Return the places `(N, k)` of a pin along its slides and tilts where walls bear it."""
        force = self._force(sweep, pin.joint, pin.reach)
        sizes = np.linalg.norm(force, axis=1)
        *ways, turn = opened.joint(pin.joint).parts
        result = np.zeros((len(force), len(ways)))
        if not np.all(sizes > 0.0):
            return result
        depths = np.array([self._depth(pin, size) for size in sizes.tolist()])
        # The wall pushes the pin back, into the middle.
        offsets = -force * ((0.5 * pin.clearance + depths) / sizes)[:, None]
        angles = np.asarray(sweep.motion.position(pin.joint)).tolist()
        for k, child in enumerate(sweep.rotation(pin.joint)):
            bush = child @ pinocchio.exp3(-angles[k] * turn.axis)
            along = offsets[k]
            if pin.reach is not None:
                along = np.cross(bush @ turn.axis, along) / pin.reach
            kind = "prismatic" if pin.reach is None else "revolute"
            result[k] = [along @ (bush @ part.axis) * (part.kind == kind) for part in ways]
        return result

    def _force(self, sweep: Any, name: str, reach: float | None) -> Array:
        """Return the force `(N, 3)` on a pin, or on its first bearing, in the world [N].

        Of two bearings at a distance `reach`, it is that of the moment that both exert,
        F = (m × a) / (2 r). Where it is not unique, it is zero.
        """
        none = np.zeros((len(sweep), 3))
        if reach is None:
            is_open = what_is_open(self._scene.solver, sweep, name)
            return none if is_open else across_pin(sweep, sweep.motion, name)
        joint = sweep.mechanism.joint(name)
        beside = np.abs(joint.parts[0].axis) < 1.0 - NOTHING
        if not np.all(sweep[name].unique[3:][beside]):
            return none
        axis = sweep.rotation(name) @ joint.parts[0].axis
        moment = np.asarray(sweep.wrench(name, "world").moment)
        return np.asarray(np.cross(moment, axis) / (2.0 * reach))

    def _depth(self, pin: OpenPin, force: float) -> float:
        """Return how deep a force presses a pin into its wall [m]."""
        length = self._scene.mechanism.characteristic_length

        def missing(depth: float) -> float:
            return force - float(pin.law.force(depth, 0.0, np.inf))

        if missing(length) > 0.0:
            raise ArgumentError(
                f"joint {pin.joint!r}: its force of {force:.3g} N presses the pin into the wall "
                f"farther than the mechanism is long, {length:.3g} m; its contact is too soft"
            )
        return zero(missing, 0.0, length)
