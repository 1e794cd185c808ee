"""Scan: which joints of a mechanism would hammer if they had play, and how hard.

Dresig and Thümmel's estimate for every turning joint: where the force of the rigid mechanism swings
round, the pin crosses the play and strikes the other side. Reduced masses come from the mechanism.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from analytic.damped_impact import damped_peak
from analytic.impact import Start
from analytic.impact import reversal as estimated

from ..arrays import Array
from ..checks import described, mapping, numbers
from ..errors import AccuracyError, ArgumentError, IndeterminateError, ModelError, choices
from ..frozen import read_only
from .force_course import ForceCourse, Swing
from .joint_scan import JointScan, Reversal
from .opened_joint import Mobility, OpenedJoint

if TYPE_CHECKING:
    import pandas

    from ..results.sweep import Sweep
    from ..scene.scene import Scene

_SAMPLES, _MOST_SAMPLES = 720, 11_520
"""Positions over a period; doubled until the forces' series ends."""
_TAIL = 1e-6
"""Last harmonics of a force, as a fraction of its greatest, at which the series ends."""
_STAYS_CLOSED = 1.0
"""Turn-through number from which on a swing is no reversal by any measure."""


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
        """Names of the joints, the greatest peak first."""
        return sorted(self._joints, key=lambda name: -self._joints[name].peak)

    def to_dataframe(self) -> pandas.DataFrame:
        """Return a row for each reversal, SI units, those of the greatest peaks first."""
        import pandas

        rows = [
            {"joint": name, **item.row()}
            for name in self.ranking
            for item in self._joints[name].reversals
        ]
        return pandas.DataFrame(rows)

    def __str__(self) -> str:
        lines = [f"clearance at {self.speed:g} rad/s"]
        lines += [f"- {name}: {self._joints[name].summary}" for name in self.ranking]
        lines += [f"- {name}: not scanned, {reason}" for name, reason in self.left_out.items()]
        return "\n".join(lines)

    __repr__ = __str__


def scan(
    scene: Scene,
    speed: float,
    *,
    play: float | Mapping[str, float],
    stiffness: float | Mapping[str, float],
    joints: str | Collection[str] | None = None,
    damping_ratio: float = 0.0,
    start: Start = "release",
    rotor: float | None = None,
) -> Scan:
    """Estimate what play would do in the turning joints of a mechanism.

    Args:
        scene: with one drive that turns through; its loads and gravity act.
        speed: constant speed of the drive [rad/s].
        play: difference 2 s of the diameters of bush and pin [m], of all joints or by name.
        stiffness: c of a contact [N/m], likewise: of pin, bush and seat in series. A line contact
            alone is some hundred times stiffer than what holds it.
        joints: names of those to be scanned; all that turn about one axis if None.
        damping_ratio: of the contact, as a fraction of critical damping with the reduced mass.
        start: "release", as a spring lets go; "rest" is for the paper's example.
        rotor: inertia [kg m²] that turns with the drive, which then gives way; None if its motion
            is prescribed, whatever acts.

    Raises:
        ArgumentError: a value is out of range, or the scene has several drives.
        ModelError: a joint that is asked for has no pin, or the mechanism has no mass.
        IndeterminateError: the force of a joint that is asked for is statically indeterminate.
        AccuracyError: the forces are too uneven for a series.
        CardanError: as `Scene.sweep`.

    Source:
        Dresig and Thümmel (14) to (17), (22) to (27), (32) to (34); the reduced mass for any
        mechanism is an own derivation, as is the damped peak.
    """
    speed = _number("speed", speed)
    impact, period = _Impact(speed, damping_ratio, start), _period(scene, speed)
    fixed, rotors = _drive(scene, rotor)
    wanted, left_out = _pins(scene, joints)
    contact = {
        name: (_of("play", play, name), _of("stiffness", stiffness, name)) for name in wanted
    }
    sweep, forces = _forces(scene, speed, period, wanted, left_out, joints is not None)
    pins = [
        _Pin(
            OpenedJoint(scene.mechanism, name, fixed, rotors),
            ForceCourse(force, period).swings(float(np.sign(speed))),
            *contact[name],
        )
        for name, force in forces.items()
    ]
    found = _reversals(scene, pins, impact)
    scanned = {
        name: JointScan(name, sweep.position, read_only(force), *both, abs(speed) / period)
        for (name, force), both in zip(forces.items(), found, strict=True)
    }
    return Scan(scanned, speed, left_out)


def _period(scene: Scene, speed: float) -> float:
    """Return the drive's way after which the motion repeats [rad].

    Raises:
        ArgumentError: there is none, or nothing moves.
        ModelError: nothing has mass.
        CardanError: the drive does not turn through.
    """
    if speed == 0.0:
        raise ArgumentError("speed is 0; joints reverse their forces by inertia: give a speed")
    if len(scene.drives) > 1:
        raise ArgumentError("the scene has several drives; hold all but one of them")
    solver = scene._solver
    if not solver.has_mass:
        raise ModelError(f"{scene.mechanism.name}: no body has mass, so that nothing can strike")
    period = solver.assembly.period()
    if period is None:
        raise ArgumentError(f"{scene.drives[0]} does not come back to itself: there is no period")
    return float(period)


def _number(label: str, value: Any) -> float:
    number = numbers(label, value)
    if number.ndim:
        raise ArgumentError(f"{label} is {described(value)}, expected a number")
    return float(number)


def _of(label: str, given: Any, name: str) -> float:
    """Return the play or stiffness of a joint.

    Raises:
        ArgumentError: it is missing, or not a positive number.
    """
    if isinstance(given, Mapping):
        if name not in mapping(label, given):
            raise ArgumentError(f"{label} has no value for joint {name!r}; it has {choices(given)}")
        given, label = given[name], f"{label}[{name!r}]"
    value = _number(label, given)
    if not value > 0.0:
        raise ArgumentError(f"{label} is {value:g}, expected a positive number")
    return value


def _pins(scene: Scene, asked: str | Collection[str] | None) -> tuple[list[str], dict[str, str]]:
    """Return the joints that turn about one axis, and why others are left out.

    Raises:
        ModelError: one that is asked for is none, or unknown.
    """
    pins, left_out = [], {}
    names = scene.mechanism.joints if asked is None else asked
    names = [names] if isinstance(names, str) else names
    for name in names:
        parts = scene.mechanism.joint(name).parts
        if len(parts) == 1 and parts[0].kind == "revolute" and name in scene.outputs:
            pins.append(name)
            continue
        reason = "it has no pin: it does not turn about one axis"
        if name not in scene.outputs:
            reason = "it is no output of the scene"
        if asked is not None:
            raise ModelError(f"joint {name!r}: {reason}")
        left_out[name] = reason
    return pins, left_out


def _forces(
    scene: Scene,
    speed: float,
    period: float,
    wanted: list[str],
    left_out: dict[str, str],
    is_asked: bool,
) -> tuple[Sweep, dict[str, Array]]:
    """Return a sweep over a period, and forces `(N, 3)` across the pins of joints in the world.

    Raises:
        IndeterminateError: a force is not unique, of a joint that is asked for.
        AccuracyError: the forces are too uneven.
    """
    count = _SAMPLES
    while True:
        sweep = scene.sweep(period / count * np.arange(count), speed)
        forces = {}
        for name in wanted:
            if reason := _open(sweep, name):
                if is_asked:
                    raise IndeterminateError(f"joint {name!r}: {reason}")
                left_out[name] = reason
                continue
            forces[name] = _across(sweep, name)
        scale = max((float(np.max(np.abs(force))) for force in forces.values()), default=0.0)
        rough = [
            name
            for name, force in forces.items()
            if ForceCourse(force, period).tail * np.max(np.abs(force)) > _TAIL * scale
        ]
        if not rough:
            return sweep, forces
        if count >= _MOST_SAMPLES:
            raise AccuracyError(
                f"{count} positions do not resolve the force of joint {rough[0]!r} over a period"
            )
        count *= 2


def _open(sweep: Sweep, name: str) -> str:
    """Return which force across the pin is statically indeterminate, empty if none."""
    axis = sweep.mechanism.joint(name).parts[0].axis
    across = np.abs(axis) < 1.0 - 1e-9
    unique = sweep[name].unique[:3]
    if np.all(unique[across]):
        return ""
    names = "".join(letter for letter, bad in zip("xyz", across & ~unique, strict=True) if bad)
    return (
        f"its force {names} is statically indeterminate; give compliances= to the scene, or free "
        "the mechanism of what holds it twice"
    )


def _across(sweep: Sweep, name: str) -> Array:
    """Return the force across the pin `(N, 3)` in the world."""
    force = np.asarray(sweep.wrench(name, "world").force)
    axis = sweep.rotation(name) @ sweep.mechanism.joint(name).parts[0].axis
    return force - axis * np.sum(force * axis, axis=1, keepdims=True)


def _drive(scene: Scene, rotor: float | None) -> tuple[list[int], dict[int, float]]:
    """Return velocity coordinates that are fixed, and those of rotors with their inertias.

    Raises:
        ArgumentError: a negative inertia.
    """
    coordinates = scene.mechanism.coordinates
    drive, held = coordinates.named[scene.drives[0]].rate, coordinates.rates_of(scene.held)
    if rotor is None:
        return [drive, *held], {}
    inertia = _number("rotor", rotor)
    if inertia < 0.0:
        raise ArgumentError(f"rotor is {inertia:g} kg m², expected no negative number")
    return held, {drive: inertia}


class _Pin(NamedTuple):
    """A joint with its play.

    Attributes:
        opened: the mechanism with this joint open.
        swings: where its force is least.
        play: 2 s [m].
        stiffness: [N/m].
    """

    opened: OpenedJoint
    swings: list[Swing]
    play: float
    stiffness: float


class _Impact:
    """What is assumed of all impacts."""

    def __init__(self, speed: float, damping_ratio: Any, start: Start) -> None:
        self.speed, self.start = speed, start
        self.damping_ratio = _number("damping_ratio", damping_ratio)
        if not 0.0 <= self.damping_ratio < 1.0:
            raise ArgumentError(f"damping_ratio is {damping_ratio:g}; it lies from 0 to below 1")
        if start not in ("release", "rest"):
            raise ArgumentError(f"start is {described(start)}; it is 'release' or 'rest'")

    def of(self, pin: _Pin, swing: Swing, mobility: Mobility) -> Reversal:
        """Return what happens at a swing, the change of mass left open."""
        mass, slope = mobility.reduced_mass(swing.direction), swing.slope * abs(self.speed)
        contact = mass, pin.stiffness, 0.5 * pin.play, slope
        found = estimated(*contact, start=self.start)
        peak = found.peak
        if self.damping_ratio:
            peak = damped_peak(*contact, self.damping_ratio, start=self.start)
        time = float(found.t_1)
        return Reversal(
            position=swing.position,
            force_slope=slope,
            direction=swing.direction,
            reduced_mass=mass,
            guided_mass=mobility.reduced_mass(swing.direction, is_guided=True),
            contact_time=time,
            impact_speed=float(found.v_1),
            tau=float(found.tau),
            peak=float(peak),
            rigid=float(found.rigid),
            added=float(found.added),
            turn_through=swing.least / (slope * time),
            flown=abs(self.speed) * time / swing.way,
            mass_change=0.0,
            deviation=mobility.deviation(swing.direction),
        )


def _reversals(
    scene: Scene, pins: list[_Pin], impact: _Impact
) -> list[tuple[tuple[Reversal, ...], int]]:
    """Return for each pin its reversals, and how many swings are none."""
    every = [(pin, swing) for pin in pins for swing in pin.swings]
    states = _closed(scene, [swing.position for _, swing in every])
    found = [
        impact.of(pin, swing, pin.opened.mobility(x))
        for (pin, swing), x in zip(every, states, strict=True)
    ]
    ends = [item.position + impact.speed * item.contact_time for item in found]
    after = iter(_closed(scene, ends))
    items = iter(found)
    result = []
    for pin in pins:
        kept = []
        for item, x in zip([next(items) for _ in pin.swings], after, strict=False):
            if item.turn_through < _STAYS_CLOSED:
                mass = pin.opened.mobility(x).reduced_mass(item.direction)
                kept.append(replace(item, mass_change=mass / item.reduced_mass - 1.0))
        result.append((tuple(kept), len(pin.swings) - len(kept)))
    return result


def _closed(scene: Scene, positions: list[float]) -> Array:
    """Return closed coordinates `(K, size)` at drive positions."""
    if not positions:
        return np.zeros((0, scene.mechanism.coordinates.size))
    return np.asarray(scene.sweep(positions).motion._x)
