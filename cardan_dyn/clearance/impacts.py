"""Impacts: what happens at the swings of pins that have clearance, of all of them at once."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from analytic.clearance import contact_time

from ..arrays import Array
from ..errors import ArgumentError
from .force_course import ForceCourse, Swing
from .force_source import ForceSource
from .impact_model import Contact, Estimates, ImpactModel, estimates
from .joint_scan import MOST_DAMPED, Reversal
from .opened_joint import Mobility, OpenedJoint
from .pin_geometry import PinGeometry
from .pin_motion import PinMotion
from .planar_motion import PinContactNumbers

_BELOW_LIMIT = 0.5
"""Force, as a fraction of the greatest of a contact, up to which its stiffness is asked for."""
_STAYS_CLOSED = 1.0
"""Turn-through number from which on a swing is no reversal by any measure."""


class Pin(NamedTuple):
    """A joint with its play.

    Attributes:
        name: of the joint.
        opened: the mechanism with this joint open.
        swings: where its force is least.
        contact: stiffness, play, damping and start.
        course: of its force.
        mean_mass: by which its damping ratio is meant [kg].
        follows: whether its motion can be followed in the plane of its bush.
    """

    name: str
    opened: OpenedJoint
    swings: list[Swing]
    contact: Contact
    course: ForceCourse
    mean_mass: float
    follows: bool


class _Case(NamedTuple):
    """A swing of a pin."""

    pin: Pin
    swing: Swing
    mobility: Mobility
    mass: float
    slope: float

    @property
    def contact(self) -> Contact:
        """What the sides strike, with its damper as a fraction of this mass's critical one."""
        contact, pin = self.pin.contact, self.pin
        ratio = float(np.asarray(contact.damping_ratio)) * np.sqrt(pin.mean_mass / self.mass)
        return contact._replace(damping_ratio=min(float(ratio), MOST_DAMPED))


def reversals(
    source: ForceSource, pins: list[Pin], speed: float, period: float
) -> list[tuple[Reversal, ...]]:
    """Return for each pin its reversals; swings whose force does not come near zero are none.

    Args:
        source: of the forces.
        pins: with their swings.
        speed: of the drive [rad/s].
        period: after which forces repeat [rad].

    Raises:
        ArgumentError: a peak is beyond what the geometry of a pin has a stiffness for.
        ModelError: what would move has no mass.
    """
    cases = _cases(source, pins, speed)
    found = _estimated(cases)
    through = [
        case.swing.least / (case.slope * float(item.contact_time))
        for case, item in zip(cases, found, strict=True)
    ]
    kept = [index for index, number in enumerate(through) if number < _STAYS_CLOSED]
    ends = [
        cases[index].swing.position + speed * float(found[index].contact_time) for index in kept
    ]
    every: dict[str, list[Reversal]] = {pin.name: [] for pin in pins}
    for index, x in zip(kept, source.closed(ends), strict=True):
        case = cases[index]
        after = case.pin.opened.mobility(x).reduced_mass(case.swing.direction)
        every[case.pin.name].append(
            _reversal(case, found[index], through[index], after / case.mass - 1.0, speed, source)
        )
    return [_together(pin, every[pin.name], source, speed, period) for pin in pins]


def _together(
    pin: Pin, every: list[Reversal], source: ForceSource, speed: float, period: float
) -> tuple[Reversal, ...]:
    """Return the reversals of a pin, each with the way to the next and the motion in its bush."""
    if not every:
        return ()
    sense, motion = float(np.sign(speed)), None
    if pin.follows:
        stiffness = max(every, key=lambda item: float(np.nan_to_num(item.peak))).stiffness
        ratio = float(np.asarray(pin.contact.damping_ratio))
        numbers = PinContactNumbers(
            float(np.asarray(pin.contact.clearance)),
            stiffness,
            2.0 * ratio * float(np.sqrt(stiffness * pin.mean_mass)),
        )
        motion = PinMotion(pin.opened, source, pin.course, numbers, pin.mean_mass, speed, period)
    found = []
    for index, item in enumerate(every):
        after = every[(index + int(sense)) % len(every)]
        way = sense * (after.position - item.position) % period or period
        ahead = pin.course.greatest(item.position, way, sense)
        found.append(replace(item, way=way, rigid_ahead=ahead, motion=motion))
    return tuple(found)


def _cases(source: ForceSource, pins: list[Pin], speed: float) -> list[_Case]:
    """Return the swings that may be reversals, with what moves there."""
    every = [(pin, swing) for pin in pins for swing in pin.swings]
    states = source.closed([swing.position for _, swing in every])
    cases = []
    for (pin, swing), x in zip(every, states, strict=True):
        mobility = pin.opened.mobility(x)
        mass = mobility.reduced_mass(swing.direction)
        slope = swing.slope * abs(speed)
        case = _Case(pin, swing, mobility, mass, slope)
        if swing.least < _STAYS_CLOSED * slope * _longest(case.contact, mass, slope, swing.least):
            cases.append(case)
    return cases


def _longest(contact: Contact, mass: float, slope: float, least: float) -> float:
    """Return what no flight lasts longer than [s]: beyond it, a swing is no reversal in any case.

    That of a release, x³ + 6 x = τ³ + 12 ζ for its time x by ω, exceeds that from rest, τ, only
    where it is shorter than 2 ζ. Then the peak is above the ramp at the impact, and so above the
    least force of a swing that counts: no stiffness is less than that of this force.

    Args:
        contact: stiffness, play, damping and start.
        mass: reduced [kg].
        slope: of the force [N/s].
        least: force of the swing [N].
    """
    clearance, law = float(np.asarray(contact.clearance)), contact.stiffness
    from_rest = float(contact_time(mass, 0.5 * clearance, slope))
    ratio = float(np.asarray(contact.damping_ratio))
    if not ratio or contact.start != "release":
        return from_rest
    if isinstance(law, PinGeometry):
        if least == 0.0:
            return np.inf
        law = law.stiffness(np.asarray(min(least, _BELOW_LIMIT * law.limit(clearance))), clearance)
    stiffness = float(np.asarray(law))
    return max(from_rest, 2.0 * ratio * float(np.sqrt(mass / stiffness)))


def _estimated(cases: list[_Case]) -> list[Estimates]:
    """Return what the impacts are estimated to be, in few calls: each costs more than its arrays.

    Raises:
        ArgumentError: a peak is beyond what the geometry of a pin has a stiffness for.
    """
    found: dict[int, Estimates] = {}
    groups: dict[str, list[int]] = {}
    for index, case in enumerate(cases):
        is_geometry = isinstance(case.pin.contact.stiffness, PinGeometry)
        groups.setdefault(case.pin.name if is_geometry else "", []).append(index)
    for name, group in groups.items():
        some = [cases[index] for index in group]
        contact = some[0].pin.contact
        if not name:
            contact = contact._replace(
                stiffness=np.array([case.pin.contact.stiffness for case in some]),
                clearance=np.array([case.pin.contact.clearance for case in some]),
            )
        contact = contact._replace(
            damping_ratio=np.array([case.contact.damping_ratio for case in some])
        )
        masses = np.array([case.mass for case in some])
        slopes = np.array([case.slope for case in some])
        try:
            with np.errstate(over="raise"):
                values = estimates(masses, slopes, contact)
        except FloatingPointError:
            raise ArgumentError(
                "clearance and stiffness are so great, or so small, that impacts overflow; "
                "clearance is in m, stiffness in N/m"
            ) from None
        except ArgumentError as error:
            raise ArgumentError(f"joint {name!r}: {error}" if name else str(error)) from error
        for place, index in enumerate(group):
            found[index] = Estimates(*(value[place] for value in values))
    return [found[index] for index in range(len(cases))]


def _reversal(
    case: _Case,
    found: Estimates,
    turn_through: float,
    mass_change: float,
    speed: float,
    source: ForceSource,
) -> Reversal:
    """Return what is said of a swing."""
    swing, mobility, contact = case.swing, case.mobility, case.contact
    numbers: dict[str, Array] = found._asdict()
    return Reversal(
        position=swing.position,
        force_slope=case.slope,
        direction=swing.direction,
        reduced_mass=case.mass,
        guided_mass=mobility.reduced_mass(swing.direction, is_guided=True),
        turn_through=turn_through,
        flown=abs(speed) * float(found.contact_time) / swing.way,
        mass_change=mass_change,
        deviation=mobility.deviation(swing.direction),
        slope_growth=np.nan if source.problem.elements else swing.growth,
        model=ImpactModel(case.mass, slope=case.slope, **contact._asdict()),
        **{name: float(value) for name, value in numbers.items()},  # type: ignore[arg-type]
    )
