"""Pin contact: a pin in a bush with clearance, which strikes its wall and slides along it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...kit.arrays import Array
from ...kit.checks import described, vector
from ...kit.errors import ArgumentError
from .contact_laws import ContactLaw
from .element import Exerted, LinkElement, LinkWrench, Quantity
from .pin_motion import PinMotion, cross

if TYPE_CHECKING:
    from ..mechanism.mechanism import Mechanism
    from .link_motions import LinkMotion
    from .one_state import OneState


class ContactMotion(NamedTuple):
    """How a pin moves in its bush at N samples, in world axes.

    Attributes:
        axis: `(N, 3)` unit vector of the bush.
        offset: `(N, 3)` of the pin's point from the bush's axis, across it [m].
        rate: `(N, 3)` its velocity as the bush sees it, across the axis [m/s].
        spin: `(N,)` angular velocity of the pin relative to the bush, about the axis [rad/s].
    """

    axis: Array
    offset: Array
    rate: Array
    spin: Array


class ContactForce(NamedTuple):
    """What a pin contact exerts.

    Attributes:
        pressure: `(N,)` force that presses pin and wall apart, not negative [N].
        friction: `(N,)` force along the wall on the pin, in the sense of a turn about the axis [N].
        depth: `(N,)` by which the pin has entered the wall; negative in the clearance [m].
        offset: `(N, 3)` of the pin's point from the bush's axis, in world axes [m].
        force: `(N, 3)` on `link_b`, in world axes [N]; on `link_a`, the opposite.
        energy: `(N,)` that the wall stores [J].
        dissipation: `(N,)` power that the wall and friction turn into heat [W].
    """

    pressure: Array
    friction: Array
    depth: Array
    offset: Array
    force: Array
    energy: Array
    dissipation: Array


@dataclass(frozen=True, eq=False)
class PinContact(LinkElement):
    """A pin on one link in a bush on another one, with clearance: contact across its axis.

    The point of the pin moves freely within the clearance; farther out, the wall presses it back by
    its law, never pulls, and Coulomb's friction acts along the wall, where the pin's surface
    slides: -friction times the pressure times v / sqrt(v² + transition²), as of `JointFriction`.
    Along the axis and against tilting nothing acts: joints do that.

    Attributes:
        link_a: of the bush.
        point_a: `(3,)` on its axis, in the link's frame [m].
        axis_a: `(3,)` of the bush, in the link's frame; of any length.
        link_b: of the pin.
        point_b: `(3,)` of the pin that strikes, in the link's frame [m].
        clearance: difference 2 s of the diameters of bush and pin, positive [m].
        law: of the force that presses them apart.
        friction: coefficient, not negative.
        radius: of the pin, not negative: its surface slides as it turns [m].
        transition: speed at which friction sets in, positive [m/s].
        name: by which results show it; may be empty.

    Raises:
        ArgumentError: a value is no finite number, out of its range or of a wrong shape, or both
            links are the same.
    """

    group = "pin_contact"
    quantities = (
        Quantity("pressure", "contact_pressure", "force that presses pin and wall apart", "N"),
        Quantity("friction", "contact_friction", "force along the wall on the pin", "N"),
        Quantity(
            *("depth", "contact_depth"),
            *("depth by which the pin has entered the wall, negative in the clearance", "m"),
        ),
        Quantity(
            *("offset", "contact_offset"),
            *("place of the pin beside the axis of its bush, in world axes", "m", "component"),
        ),
    )
    link_a: str
    point_a: Array
    axis_a: Array
    link_b: str
    point_b: Array
    clearance: float
    law: ContactLaw
    friction: float = 0.0
    radius: float = 0.0
    transition: float = 1e-3
    name: str = ""

    def __post_init__(self) -> None:
        link_a, link_b = self._two_links()
        kind = type(self).__name__
        axis = vector(f"{kind}: axis_a", self.axis_a, 3)
        size = float(np.linalg.norm(axis))
        if not size > 0.0:
            raise ArgumentError(f"{kind}: axis_a is zero; give the direction of the bush's axis")
        self._set(
            link_a=link_a,
            point_a=vector(f"{kind}: point_a", self.point_a, 3),
            axis_a=axis / size,
            link_b=link_b,
            point_b=vector(f"{kind}: point_b", self.point_b, 3),
            clearance=self._positive("clearance"),
            friction=self._number("friction", least=0.0),
            radius=self._number("radius", least=0.0),
            transition=self._positive("transition"),
            name=self._text("name"),
        )
        if not isinstance(self.law, ContactLaw):
            raise ArgumentError(f"{kind}: law is {described(self.law)}, expected a contact law")
        super().__post_init__()

    @property
    def jump(self) -> str:
        """See `Element.jump`."""
        return (
            f"the pin of {self.link_b!r} has clearance in its bush: it strikes, which no linear "
            "vibration knows; use Scene.simulate"
        )

    def on(self, mechanism: Mechanism, label: str) -> _PinInBush:
        """See `Element.on`."""
        return _PinInBush(self, self.motion(mechanism))

    def motion(self, mechanism: Mechanism) -> PinMotion:
        """Return what tells where the pin is in its bush, one state at a time."""
        bush = self.link_a, self.point_a, self.axis_a
        pin = self.link_b, self.point_b
        return PinMotion(mechanism, bush, pin, self.radius, self.clearance)

    def pressure(self, depth: Array, rate: Array, time: Array) -> Array:
        """Return the force `(N,)` that presses pin and wall apart [N].

        Args:
            depth: `(N,)` by which the pin has entered the wall [m].
            rate: `(N,)` of its growth [m/s].
            time: `(N,)` [s].

        Raises:
            ArgumentError: the law depends on how fast a touch began, which simulations alone know.
        """
        if self.law.needs_touch_speed and np.any(depth > 0.0):
            raise ArgumentError(
                f"{type(self).__name__} {self.name!r}: the law {type(self.law).__name__} depends "
                "on how fast each touch began, which only simulations know; elsewhere, take a law "
                "with constant factors"
            )
        inside = np.maximum(depth, 0.0)
        force = self.law.force(inside, rate, np.zeros_like(depth))
        return np.where(depth > 0.0, np.maximum(force, 0.0), 0.0)

    def acts_at(self, time: float) -> bool:
        """Return whether there may be a pressure at a time [s]."""
        return True

    def pressure_at(self, depth: float, rate: float, time: float) -> float:
        """Return the force of `pressure` at one state."""
        if depth <= 0.0:
            return 0.0
        return max(float(self.law.force(depth, rate, 0.0)), 0.0)

    def force(self, motion: ContactMotion, time: Array) -> ContactForce:
        """Return what it exerts.

        Args:
            motion: of the pin in its bush.
            time: `(N,)` [s].

        Raises:
            ArgumentError: see `pressure`.
        """
        distance = np.sqrt(np.einsum("ni,ni->n", motion.offset, motion.offset))
        # In the middle of the clearance, no direction is needed.
        away = motion.offset / np.where(distance > 0.0, distance, 1.0)[:, None]
        along = np.cross(motion.axis, away)
        depth = distance - 0.5 * self.clearance
        growth = np.einsum("ni,ni->n", away, motion.rate)
        slide = np.einsum("ni,ni->n", along, motion.rate) + self.radius * motion.spin
        pressure = self.pressure(depth, growth, time)
        friction = -self.friction * pressure * slide / np.hypot(slide, self.transition)
        inside = np.maximum(depth, 0.0)
        # What neither pushes back nor is stored is lost, also where the wall follows too slowly.
        still, any_speed = np.zeros_like(depth), np.ones_like(depth)
        spring = np.where(depth > 0.0, self.law.force(inside, still, any_speed), 0.0)
        return ContactForce(
            pressure=pressure,
            friction=friction,
            depth=depth,
            offset=motion.offset,
            force=friction[:, None] * along - pressure[:, None] * away,
            energy=np.where(depth > 0.0, self.law.energy(inside), 0.0),
            dissipation=(pressure - spring) * growth - friction * slide,
        )

    def arm(self, motion: ContactMotion) -> Array:
        """Return the vectors `(N, 3)` from the pin's point to where it touches the wall [m]."""
        distance = np.sqrt(np.einsum("ni,ni->n", motion.offset, motion.offset))
        return self.radius * motion.offset / np.where(distance > 0.0, distance, 1.0)[:, None]


class _PinInBush(NamedTuple):
    """A pin contact on a mechanism."""

    element: PinContact
    motion: PinMotion

    def at(self, x: Array, v: Array, time: Array, links: Mapping[str, LinkMotion]) -> Exerted:
        """See `Acting.at`."""
        element, shape = self.element, (len(x), 3)
        bush, pin = links[element.link_a], links[element.link_b]
        axis = np.broadcast_to(bush.rotation @ element.axis_a, shape)
        arm = np.broadcast_to(pin.rotation @ element.point_b, shape)
        beside = pin.position + arm - bush.position
        span = np.broadcast_to(beside - bush.rotation @ element.point_a, shape)
        # The velocity of the pin's point as the bush sees it, which turns.
        seen = np.broadcast_to(pin.velocity + np.cross(pin.spin, arm) - bush.velocity, shape)
        seen = seen - np.cross(bush.spin, beside)
        motion = ContactMotion(
            axis,
            span - axis * np.einsum("ni,ni->n", axis, span)[:, None],
            seen - axis * np.einsum("ni,ni->n", axis, seen)[:, None],
            np.einsum("ni,ni->n", axis, np.broadcast_to(pin.spin - bush.spin, shape)),
        )
        done = element.force(motion, time)
        lever = element.arm(motion)
        wrenches = (
            LinkWrench(element.link_a, -done.force, -np.cross(beside + lever, done.force)),
            LinkWrench(element.link_b, done.force, np.cross(arm + lever, done.force)),
        )
        moved = seen + np.cross(motion.axis * motion.spin[:, None], lever)
        return Exerted(done, np.einsum("ni,ni->n", done.force, moved), wrenches=wrenches)

    def add(self, efforts: Array, state: OneState) -> None:
        """See `Acting`."""
        element = self.element
        if not element.acts_at(state.time):
            return
        place = self.motion.place(state.data)
        pressure = element.pressure_at(place.depth, place.growth, state.time)
        (x, y, z), (u, v, w), rub = place.away, place.along, 0.0
        if element.friction:
            slip = place.slide / math.hypot(place.slide, element.transition)
            rub = element.friction * pressure * slip
        force = (
            -pressure * x - rub * u,
            -pressure * y - rub * v,
            -pressure * z - rub * w,
        )
        wrench = np.array([*force, *cross(place.touch, force)])
        state.push_about_origin(efforts, self.motion.bush, -wrench)
        state.push_about_origin(efforts, self.motion.pin, wrench)
