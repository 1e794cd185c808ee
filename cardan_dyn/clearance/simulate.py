"""Simulate: a whole mechanism with clearance in one or more of its pins, every impact located."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..checks import described, number, positive
from ..elements.contact_laws import ContactLaw, LinearContact
from ..errors import ArgumentError
from .arguments import clearance_of, damping_ratio_of, made_of, of_joint, refuse_unknown
from .contact_simulation import ContactSimulation
from .opened_scene import OpenPin, opened
from .rigid_start import RigidStart

if TYPE_CHECKING:
    from ..scene.scene import Scene


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
    bearings: Mapping[str, float] | None = None,
    rotor: float | None = None,
    turns: float = 2.0,
    position: float | None = None,
    max_touches: int = 100_000,
    rtol: float = 1e-10,
    progress: bool | Callable[[float], object] = False,
) -> ContactSimulation:
    """Simulate a mechanism whose pins have play in their bushes.

    Joints are opened across their axes; pins begin pressed into their walls by the forces of the
    mechanism without play. How that differs from what follows decays with the damping. The bush
    belongs to a joint's parent or a loop's predecessor: friction acts where its wall is touched.

    Args:
        scene: with one drive that turns.
        speed: of the drive, the first one if it is free [rad/s].
        joints: names of the turning joints that have play.
        clearance: difference 2 s of the diameters of bush and pin [m], of all joints or by name.
        law: of the contact, likewise, such as `HuntCrossley`.
        stiffness: instead of a law, that of a `LinearContact`, likewise [N/m].
        damping_ratio: of that, as a scan with the same rotor has it: a fraction of critical damping
            with the joint's mean reduced mass along its force over a period, from 0 to below 1.
        friction: coefficient of Coulomb's friction along the wall, likewise.
        pin_radius: of pins whose surfaces slide as they turn, likewise [m].
        bearings: joints whose pin has two bearings, to their distance from its origin [m].
        rotor: inertia that turns with the drive, which then gives way [kg m²]; None if it does not.
        turns: of the drive at its speed, after which it ends.
        position: of the drive where it begins [rad]; far from reversals of forces if None.
        max_touches: of pins and walls after which it ends with what it has.
        rtol: relative tolerance of each step.
        progress: True for a bar, or a function of the fraction done.

    Raises:
        ArgumentError: a value is out of range, or the scene has several drives.
        ModelError: a joint has no pin, or the others hold it whatever its play.
        CardanError: as `Scene.simulate`.
    """
    begun = RigidStart(scene, speed, joints, position, bearings, rotor)
    values = {"clearance": clearance, "law": law, "stiffness": stiffness, "friction": friction}
    refuse_unknown(scene.mechanism.joints, pin_radius=pin_radius, **values)
    contact = _Contact(
        law, stiffness, damping_ratio_of(damping_ratio), clearance, friction, pin_radius
    )
    pins = contact.pins(begun, scene.mechanism.characteristic_length)
    found = opened(scene, pins, number("rotor", rotor or 0.0, least=0.0))
    duration = 2.0 * np.pi * positive("turns", turns) / abs(begun.speed)
    start = begun.state(found, pins, is_free=rotor is not None)
    limits: dict[str, Any] = {"rtol": rtol, "max_touches": max_touches, "progress": progress}
    if rotor is not None:
        found = found._replace(scene=found.scene.replace(free=found.scene.coordinates))
    trajectory = found.scene.simulate(duration, **start, **limits)
    same = made_of(scene.problem, rotor)
    return ContactSimulation(trajectory, found.contacts, found.drive, begun.speed, same)


class _Contact(NamedTuple):
    """How contacts are described; but for the ratio, of all joints or by name.

    Attributes:
        given: a law, or None.
        stiffness: instead of it.
        ratio: of damping.
        clearance, friction, pin_radius: see `simulate`.
    """

    given: Any
    stiffness: Any
    ratio: float
    clearance: Any
    friction: Any
    pin_radius: Any

    def pins(self, begun: RigidStart, length: float) -> list[OpenPin]:
        """Return what is free in every joint of a mechanism of some length, which has none yet."""
        return [
            OpenPin(
                name,
                clearance_of(self.clearance, name, length),
                self._law(name, begun, has_bearings=name in begun.reach),
                number(*of_joint("friction", self.friction, name), least=0.0),
                number(*of_joint("pin_radius", self.pin_radius, name), least=0.0),
                begun.reach.get(name),
            )
            for name in begun.joints
        ]

    def _law(self, name: str, begun: RigidStart, *, has_bearings: bool) -> ContactLaw:
        """Return the law of a joint.

        Raises:
            ArgumentError: there is none, or both a law and a stiffness.
        """
        if (self.given is None) == (self.stiffness is None):
            raise ArgumentError("give either law= or stiffness=, of the contact")
        if self.given is not None:
            if self.ratio:
                raise ArgumentError("damping_ratio belongs to stiffness=; a law has its own")
            label, law = of_joint("law", self.given, name)
            if not isinstance(law, ContactLaw):
                raise ArgumentError(
                    f"{label} is {described(law)}, expected a contact law such as "
                    "LinearContact(1e8, damping=1e3)"
                )
            return law
        stiffness = positive(*of_joint("stiffness", self.stiffness, name))
        if not self.ratio:
            return LinearContact(stiffness)
        if has_bearings:
            raise ArgumentError(
                f"damping_ratio of joint {name!r}: several bearings move together, and no mass "
                "belongs to one alone; give law=LinearContact.of_ratio(stiffness, ratio, mass)"
            )
        mass = begun.reduced_mass(name)
        return LinearContact(stiffness, 2.0 * self.ratio * float(np.sqrt(stiffness * mass)))
