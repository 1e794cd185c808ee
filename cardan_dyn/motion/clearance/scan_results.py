"""Scan results: what clearance would do in joints, and how far to trust it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from cardan_dyn.analytic.peak_exponents import PeakExponents

from ...core.results.result import Result
from ...core.results.table import Table
from ...kit.arrays import Array
from ...kit.errors import ModelError, choices
from .impact_model import ImpactModel
from .pin_geometry import PinGeometry, StiffnessLaw
from .planar_motion import FollowedPin, Passages
from .row_tables import COMPONENTS, row_table, variable

TURNED = 0.03
"""Turn-through number up to which a swing behaves as if the force vanished, within some 7 %."""
FLOWN = 0.4
"""Angle flown, as a fraction of that to the rigid maximum, up to which the ramp is straight enough:
1 to 5 %."""
LEAST_TAU = 3.0
"""Below, the estimate has not been checked against simulation of whole mechanisms."""
MOST_DAMPED = 0.99
"""Damping ratio up to which the two-mass model goes; a damper that is stronger counts as this."""
_APART = 0.1
"""Speed of a strike, as a fraction of that of the two-mass model, below which a pin only brushes
its wall: a hundredth of the energy."""
_NO_NUMBERS = {"direction", "directions", "model", "motion", "share", "ahead"}


def _of(item: Any, *names: str) -> dict[str, Any]:
    """Return attributes by name."""
    return {name: getattr(item, name) for name in names}


@dataclass(frozen=True, eq=False)
class ForceReversal:
    """What happens where the forces of a joint's open bearings swing round together.

    Forces, speeds and masses are those of the bearing that carries most: its force moves the
    reduced mass across the mean clearance, and the direction is that of its force.

    Attributes:
        position: of the drive where the force is least [rad].
        force_slope: F₀/t₀, how fast the force grows [N/s].
        direction: `(3,)` unit vector in which it grows, in the world.
        reduced_mass: m that it moves, free to move across it [kg].
        stiffness: c of the contact, at the peak if it depends on the force [N/m].
        contact_time: t₁ from the reversal to the impact [s].
        impact_speed: v₁ [m/s].
        tau: √(c/m) times the time in the clearance from rest.
        two_mass_peak: greatest force after the impact in the two-mass model, as if the force
            vanished before [N]; NaN if there is none.
        rigid: part of an undamped peak that the ramp has reached by then [N].
        added: part of an undamped peak that the clearance adds [N].
        turn_through: ρ, the least force as a fraction of what the ramp gains over the flight: 0 of
            a true reversal.
        flown: angle that the drive turns during the flight, as a fraction of that to the next
            greatest force of the rigid mechanism.
        mass_change: of the reduced mass over the flight, as a fraction.
        deviation: angle between the force and the motion that it causes [rad].
        slope_growth: by which power of the drive's speed the slope grows, 3 where inertia alone
            acts; NaN where elements act.
        model: the numbers of the two-mass model.
        way: that the drive turns until the next reversal [rad].
        damping: damper d that the contact has then [N s/m].
        share: force of each open bearing as a fraction of the greatest.
        directions: `(B, 3)` of each as `direction`; None if there is one.
        ahead: greatest force of each without clearance until the next reversal [N].
        split: part of the clearance, as a fraction, that cannot close at once in all open bearings,
            since the mechanism ties their motions together.
        motion: of the pin in the plane of its bush, followed when it is first asked for; None if it
            cannot be.
    """

    position: float
    force_slope: float
    direction: Array
    reduced_mass: float
    stiffness: float
    contact_time: float
    impact_speed: float
    tau: float
    two_mass_peak: float
    rigid: float
    added: float
    turn_through: float
    flown: float
    mass_change: float
    deviation: float
    slope_growth: float
    model: ImpactModel
    way: float = math.nan
    damping: float = 0.0
    share: tuple[float, ...] = (1.0,)
    directions: Array | None = None
    ahead: tuple[float, ...] = (0.0,)
    split: float = 0.0
    motion: FollowedPin | None = field(default=None, repr=False)

    @cached_property
    def passages(self) -> Passages | None:
        """What the pin did in the plane of its bush, in every turn; None if that is not known."""
        return None if self.motion is None else self.motion.passages(self.position, self.way)

    @property
    def rigid_ahead(self) -> float:
        """Greatest force without clearance until the next reversal [N]."""
        return max(self.ahead)

    @property
    def estimate(self) -> float:
        """Greatest force until the next reversal as far as a line tells [N].

        Of the force without clearance and, beyond it, of 1 - ρ² of what the two-mass model adds:
        of 210 pins of random linkages that were followed in their planes, one in twenty added more.
        """
        left = max(0.0, 1.0 - self.turn_through**2)
        struck = 0.0 if math.isnan(self.two_mass_peak) else self.two_mass_peak
        most = max(self.share) or 1.0
        pairs = zip(self.share, self.ahead, strict=True)
        return max(force + left * max(0.0, struck * part / most - force) for part, force in pairs)

    @property
    def least(self) -> float:
        """Lower end of the interval of the greatest force until the next reversal [N].

        What the pin does in its plane in some turns, without friction, with what whole mechanisms
        differ from it. NaN if that is not known.
        """
        return math.nan if self.passages is None else self.passages.least

    @property
    def greatest(self) -> float:
        """Upper end of this interval [N]."""
        return math.nan if self.passages is None else self.passages.greatest

    @property
    def peak(self) -> float:
        """Greatest force until the next reversal of all that is known [N].

        The upper end of the interval, where there is one: it takes the place of the estimate, which
        knows less. Never less than the force without clearance.
        """
        if self.passages is None:
            return self.estimate
        return max(self.passages.greatest, self.rigid_ahead)

    @property
    def strike_speed(self) -> float:
        """Speed of the hardest strike, normal to the wall, median of all turns [m/s].

        That of the two-mass model where the motion in the plane is not known.
        """
        if self.passages is None:
            return self.impact_speed
        return float(np.median(self.passages.speed))

    @property
    def energy(self) -> float:
        """Kinetic energy of the impact in all open bearings, m v² / 2 each [J]."""
        parts = sum(share**2 for share in self.share)
        return parts * 0.5 * self.reduced_mass * self.strike_speed**2

    @property
    def strikes(self) -> bool:
        """Whether the sides part and strike, not only brush: no force depends on that."""
        return self.strike_speed >= _APART * self.impact_speed

    @cached_property
    def exponents(self) -> PeakExponents:
        """By which powers of its parameters the two-mass peak grows, d ln peak / d ln parameter.

        Of speed, slope, clearance, mass and stiffness; each with the others as they are, but for
        the slope, which follows the speed. The mass stays, though the reversal moves with the speed
        where more than inertia acts. NaN where there is no peak.
        """
        found = self.model.exponents
        return found._replace(speed=self.slope_growth * found.slope)

    def effects(self, change: float) -> dict[str, float]:
        """Return by which fraction the two-mass peak would change with each parameter.

        Args:
            change: of the parameter, as a fraction above -1; by the exponents, and so exact for
                small ones.
        """
        grown = math.log1p(change)
        return {name: math.expm1(grown * e) for name, e in self.exponents._asdict().items()}

    @property
    def verdict(self) -> str:
        """In plain words, what happens, and what speaks first against the number for it."""
        if not self.strikes:
            return "no impact: the pin slides round along its wall"
        doubts = self.doubts if self.passages is None else self.passages.doubts
        return f"impact; {doubts[0]}" if doubts else "impact"

    @property
    def doubts(self) -> tuple[str, ...]:
        """Why the estimate may be wrong; empty if its assumptions hold."""
        law, mass, apart = (
            self.model.stiffness,
            100 * self.mass_change,
            math.degrees(self.deviation),
        )
        has_peak = not math.isnan(self.two_mass_peak)
        is_beside = self.passages is not None and not self.least <= self.estimate <= self.greatest
        doubts = {
            f"the pin does not move along a line: {self.least:.4g} to {self.greatest:.4g} N in "
            f"the plane, beside {self.estimate:.4g} N": is_beside,
            "no peak: the force only follows the ramp (undamped, τ below 1.8386)": not has_peak,
            f"τ = {self.tau:.2f} is small": has_peak and self.tau < LEAST_TAU,
            f"the force turns through (ρ = {self.turn_through:.2f})": self.turn_through > TURNED,
            "the contact is damped more than critically": self.model.damping_ratio >= MOST_DAMPED,
            f"the ramp bends over the flight ({self.flown:.2f} of the way): too high": (
                self.flown > FLOWN
            ),
            f"the reduced mass changes by {mass:.0f} %": abs(mass) > 10.0,
            f"the sides part {apart:.0f}° beside the force's direction": apart > 20.0,
            "the bearings do not close together "
            f"({100 * self.split:.0f} % of the clearance)": self.split > 0.05,
        }
        found = [doubt for doubt, holds in doubts.items() if holds]
        if isinstance(law, StiffnessLaw) and has_peak:
            found += law.doubts(self.two_mass_peak, self.model.clearance)
        return tuple(found)

    def row(self) -> dict[str, Any]:
        """Return its numbers by name, exponents, verdict, and the doubts as text."""
        directions = {
            f"direction_{axis}": float(at) for axis, at in zip("xyz", self.direction, strict=True)
        }
        exponents = {f"exponent_{name}": e for name, e in self.exponents._asdict().items()}
        said = {"verdict": self.verdict, "doubts": "; ".join(self.doubts)}
        return {**_of(self, *_NUMBERS), **directions, **_of(self, *_FOUND), **exponents, **said}


_FOUND = ("peak", "least", "greatest", "estimate", "rigid_ahead", "strike_speed", "energy")
_NUMBERS = [name for name in ForceReversal.__dataclass_fields__ if name not in _NO_NUMBERS]
"""Fields that are numbers: what is cached beside them is none of a table's columns."""


@dataclass(frozen=True, eq=False)
class JointScan(Result):
    """What clearance would do in the `B` open bearings of a joint.

    Attributes:
        name: of the joint, or of the link that is a cross.
        position: of the drive over a period `(N,)` [rad].
        force: across the pin `(N, 3)` in the world, exerted on the child link [N]: its polar
            diagram; of the bearings of a universal joint `(N, B, 3)`.
        reversals: where it swings round, in order of position.
        turning: number of positions at which the force is least but far from zero.
        periods: per second [1/s].
        bearings: names of the open bearings; the joint's own if its pin has one bush.
        freedoms: in how many ways they can move, the drive prescribed.
        mean_mass: by which the damping ratio is meant [kg]: the geometric mean of the reduced
            masses along the force over a period. NaN where no force acts.
        clearance: 2 s of each pin's bearings [m].
        stiffness: of the contact in one of these [N/m], or the geometry that decides it.
        radius: of each open pin of a universal joint: from its centre to the bearings [m].
        motion: of the pin in the plane of its bush, followed when it is first asked for; None if it
            cannot be.
        unfollowed: why not.
        simulated: bearings to the greatest force in a simulation that verified them [N].
    """

    name: str
    position: Array
    force: Array
    reversals: tuple[ForceReversal, ...]
    turning: int
    periods: float
    bearings: tuple[str, ...] = ()
    freedoms: int = 2
    mean_mass: float = math.nan
    clearance: Mapping[str, float] = field(default_factory=dict)
    stiffness: Mapping[str, float | PinGeometry] = field(default_factory=dict)
    radius: Mapping[str, float] = field(default_factory=dict)
    motion: FollowedPin | None = field(default=None, repr=False)
    unfollowed: str = ""
    simulated: Mapping[str, float] = field(default_factory=dict)

    @cached_property
    def rigid_peak(self) -> float:
        """Greatest force without clearance [N]."""
        return float(np.max(np.linalg.norm(self.force, axis=-1)))

    @property
    def period(self) -> float:
        """Of the drive [rad]."""
        return len(self.position) * float(self.position[1] - self.position[0])

    @cached_property
    def _passages(self) -> tuple[Passages, ...]:
        """What the pin did from each reversal to the next, or in whole turns; empty if unknown."""
        if self.motion is None:
            return ()
        every = [item.passages for item in self.reversals]
        every = every or [self.motion.passages(0.0, self.period)]
        return tuple(item for item in every if item is not None)

    @property
    def least(self) -> float:
        """Lower end of the interval in which the greatest force of a turn lies [N].

        NaN if it is not known.
        """
        return max((item.least for item in self._passages), default=math.nan)

    @property
    def greatest(self) -> float:
        """Upper end of this interval [N]."""
        return max((item.greatest for item in self._passages), default=math.nan)

    @cached_property
    def _known(self) -> list[tuple[float, float]]:
        """Every force that is known [N], and at which position of the drive [rad]."""
        sizes = np.linalg.norm(self.force.reshape(len(self.position), -1, 3), axis=-1)
        found = [(self.rigid_peak, float(self.position[np.argmax(np.max(sizes, axis=1))]))]
        found += [(item.greatest, item.position) for item in self._passages]
        if not self._passages:
            found += [(item.peak, item.position) for item in self.reversals]
        return found + [(force, math.nan) for force in self.simulated.values()]

    @property
    def peak(self) -> float:
        """Greatest force of all that is known, with clearance and without [N].

        The upper end of the interval, where the pin is followed; else the greatest estimate; and
        never less than the force without clearance, or than what was simulated.
        """
        return max(force for force, _ in self._known)

    @property
    def peak_position(self) -> float:
        """Position of the drive at which that force acts [rad].

        Of an estimate that of the reversal before it; NaN if it was simulated.
        """
        return max(self._known, key=lambda item: item[0])[1]

    @property
    def worst(self) -> ForceReversal | None:
        """The reversal with the greatest peak, whether the sides strike or not; None of none."""
        return max(self.reversals, key=lambda item: item.peak, default=None)

    @property
    def impacts(self) -> int:
        """Impacts in a period: reversals that strike."""
        return sum(item.strikes for item in self.reversals)

    @property
    def impacts_per_turn(self) -> float:
        """Impacts in a turn of the drive; a period may have several turns."""
        return 2.0 * math.pi * self.impacts / self.period

    @property
    def impact_power(self) -> float:
        """Kinetic energy by which sides come together at all reversals, per time [W]."""
        return self.periods * sum(item.energy for item in self.reversals)

    @property
    def verdict(self) -> str:
        """In plain words, what happens."""
        if self.rigid_peak == 0.0:
            return "no force, and so no impact"
        if self.impacts:
            return f"{self.impacts} impact{'s' if self.impacts > 1 else ''} in a period"
        if self.reversals:
            return self.reversals[0].verdict
        if not self.turning:
            return "no reversal: the force never swings round"
        times = f"{self.turning} time{'s' if self.turning > 1 else ''}"
        return f"no reversal: the force turns through {times}, far from zero"

    @property
    def doubts(self) -> tuple[str, ...]:
        """What speaks against the peak: against its interval, or why there is none."""
        if self._passages:
            return max(self._passages, key=lambda item: item.greatest).doubts
        reason = self.unfollowed if self.motion is None else self.motion.reason
        return tuple(filter(None, (reason, *(self.worst.doubts if self.worst else ()))))

    @property
    def summary(self) -> str:
        """What there is to say, in one line."""
        text = f"{self.peak:.4g} N estimated"
        if self._passages:
            text = f"{self.peak:.4g} N at most"
            if not all(item.are_alike for item in self._passages):
                # Others may be greater: that of some turns is no bound.
                turns = min(len(item.forces) for item in self._passages)
                text = f"up to {self.peak:.4g} N in {turns} turns"
            text += f" ({self.least:.4g} to {self.greatest:.4g} N)"
        text += f"; {self.rigid_peak:.4g} N without clearance; {self.verdict}"
        if self.impacts:
            text += f", {self.impact_power:.3g} W"
        return f"{text}; {self.doubts[0]}" if self.doubts else text

    def row(self) -> dict[str, Any]:
        """Return the numbers of a whole turn by name, verdict, and the doubts as text."""
        return {
            "position": self.peak_position,
            **_of(self, "peak", "least", "greatest"),
            "rigid_ahead": self.rigid_peak,
            "verdict": self.verdict,
            "doubts": "; ".join(self.doubts),
        }

    @property
    def label(self) -> str:
        """Its name, and of a universal joint which bearings are open."""
        return f"{', '.join(self.bearings)} of {self.name}" if self.radius else self.name

    def table(self) -> Table:
        """Return the force of each open bearing over a period, in the world, SI units."""
        names = self.bearings or (self.name,)
        force = np.reshape(self.force, (len(self.position), len(names), 3))
        dims = "position", "bearing", "component"
        told = "N", "across the pin without clearance, on the child link, in the world"
        return Table(
            [
                variable("position", self.position, "position", given=True),
                variable("force", force, *dims, told=told),
            ],
            {"position": len(self.position)},
            labels={"bearing": names, **COMPONENTS},
            attributes={"joint": self.name, "verdict": self.verdict},
        )

    @property
    def torsional_clearance(self) -> float:
        """Angle between both ends, by which one side of a universal joint turns against the other.

        2 s / r [rad] of each pin with both bearings open.
        """
        return sum(
            self.clearance[pin] / radius
            for pin, radius in self.radius.items()
            if {f"{pin}+", f"{pin}-"} <= set(self.bearings)
        )

    def by_bearing(self) -> dict[str, JointScan]:
        """Return what is said of each open bearing: its force, and its share of the peaks."""
        if not self.radius:
            return {self.name: self}
        return {
            name: replace(
                self,
                name=name,
                force=self.force[:, index],
                reversals=tuple(self._shared(item, index, name[:-1]) for item in self.reversals),
                bearings=(name,),
                clearance={name: self.clearance[name[:-1]]},
                stiffness={name: self.stiffness[name[:-1]]},
                radius={},
                simulated={key: force for key, force in self.simulated.items() if key == name},
            )
            for index, name in enumerate(self.bearings)
        }

    def _shared(self, item: ForceReversal, index: int, pin: str) -> ForceReversal:
        """Return a reversal with the forces and the contact of one bearing."""
        share, law = item.share[index], self.stiffness[pin]
        forces = {name: share * getattr(item, name) for name in ("two_mass_peak", "rigid", "added")}
        direction = item.direction if item.directions is None else item.directions[index]
        alone = replace(
            item,
            direction=direction,
            directions=None,
            share=(share,),
            ahead=(item.ahead[index],),
            **forces,
        )
        if isinstance(law, PinGeometry):
            law = float(law.stiffness(np.asarray(alone.estimate), self.clearance[pin]))
        # The damper that the two-mass model has for all bearings is shared as their stiffness is.
        return replace(alone, stiffness=law, damping=item.damping * law / item.stiffness)


@dataclass(frozen=True, eq=False)
class ComparedReversal:
    """A reversal as it was scanned, and as it was simulated.

    Attributes:
        joint: its name.
        reversal: as it was scanned.
        simulated: greatest forces of the simulation until the next reversal, of every whole turn
            after the first reversal `(K,)` [N].
    """

    joint: str
    reversal: ForceReversal
    simulated: Array

    @property
    def error(self) -> float:
        """Estimate of the reversal over the mean of the simulated peaks, less 1."""
        return float(self.reversal.estimate / np.mean(self.simulated) - 1.0)

    def row(self) -> dict[str, Any]:
        """Return its numbers by name, and the doubts of the estimate as text."""
        item = self.reversal
        return {
            "joint": self.joint,
            "position": item.position,
            "rigid": item.rigid_ahead,
            **_of(item, "estimate", "peak"),
            "simulated": float(np.mean(self.simulated)),
            "simulated_least": float(np.min(self.simulated)),
            "simulated_greatest": float(np.max(self.simulated)),
            "error": self.error,
            **_of(item, "least", "greatest", "turn_through", "flown", "tau"),
            "doubts": "; ".join(item.doubts),
        }


class ScanComparison(Result, tuple[ComparedReversal, ...]):
    """Reversals as they were estimated and simulated, joint by joint; `print` shows a table."""

    def table(self) -> Table:
        """Return a row for each reversal, SI units."""
        told = {"rigid": ("N", "greatest force without clearance until the next reversal")}
        return row_table([item.row() for item in self], "reversal", told)

    def __str__(self) -> str:
        lines = ["scan beside simulation [N]"]
        for item in self:
            found, doubts = item.reversal, "; ".join(item.reversal.doubts)
            interval = f"{found.least:.4g} to {found.greatest:.4g} in the plane and "
            lines.append(
                f"- {item.joint} at {found.position:.3f} rad: simulated "
                f"{np.min(item.simulated):.4g} to {np.max(item.simulated):.4g}, beside "
                f"{interval if found.passages else ''}an estimate of {found.estimate:.4g} "
                f"({100.0 * item.error:+.1f} %); rigid {found.rigid_ahead:.4g}"
                f"{'; ' + doubts if doubts else ''}"
            )
        return "\n".join(lines)

    __repr__ = __str__


class Scan(Result, Mapping[str, JointScan]):
    """Joints by name, with what clearance would do in each; `print` shows a table.

    Attributes:
        speed: of the drive [rad/s].
        left_out: joints that were not scanned to why.
        verified: reversals beside simulations of the whole mechanism; None if that was not asked.
        unverified: joints of which a simulation came to nothing, to why.
        made_of: what the forces depend on, each with its hash: `compare` asks for the same.
    """

    def __init__(
        self,
        joints: Mapping[str, JointScan],
        speed: float,
        left_out: Mapping[str, str],
        verified: ScanComparison | None = None,
        unverified: Mapping[str, str] | None = None,
        made_of: Mapping[str, str] | None = None,
    ) -> None:
        self._joints = dict(joints)
        self.speed, self.left_out = speed, dict(left_out)
        self.verified, self.unverified = verified, dict(unverified or {})
        self.made_of = dict(made_of or {})

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
        """Names of the joints by their peaks as they are printed, the greatest first.

        Those whose peaks do not differ in what is printed stand in the order of the mechanism.
        """
        return sorted(self._joints, key=lambda name: -float(f"{self._joints[name].peak:.4g}"))

    @property
    def worst(self) -> dict[str, ForceReversal]:
        """The reversal with the greatest peak of each joint that has any, as they are ranked."""
        every = {name: self._joints[name].worst for name in self.ranking}
        return {name: item for name, item in every.items() if item is not None}

    def by_bearing(self) -> dict[str, JointScan]:
        """Return what is said of each open bearing of each joint; see `JointScan.by_bearing`."""
        return {
            name: item
            for joint in self._joints.values()
            for name, item in joint.by_bearing().items()
        }

    @property
    def notes(self) -> tuple[str, ...]:
        """What concerns whole joints, beside the doubts on single reversals."""
        bare = [
            name
            for name in self.ranking
            if self._joints[name].reversals
            and any(
                isinstance(law, PinGeometry) and law.seat_stiffness is None
                for law in self._joints[name].stiffness.values()
            )
        ]
        notes = [f"{name}: not verified, {reason}" for name, reason in self.unverified.items()]
        if bare:
            notes.append(
                f"{', '.join(bare)}: the stiffness is that of a line contact alone, which "
                "overstates what pin, bush and seat have in series about a hundredfold; give "
                "seat_stiffness"
            )
        return tuple(notes)

    def rows(self) -> list[dict[str, Any]]:
        """Return a row for each reversal, by column, SI units, in the order of the ranking.

        A joint whose force never swings round has one for the whole turn. `simulated` is the
        greatest force until the next reversal, if that was verified; of the bearing that carries
        most.
        """
        rows = []
        for name in self.ranking:
            joint = self._joints[name]
            for item in joint.reversals:
                row = {"joint": name, **item.row()}
                if self.verified is not None:
                    forces = [
                        float(np.max(other.simulated))
                        for other in self.verified
                        if other.reversal.position == item.position
                        and other.joint in joint.bearings
                    ]
                    row["simulated"] = max(forces, default=np.nan)
                rows.append(row)
            if not joint.reversals:
                rows.append({"joint": name, **joint.row()})
        names = dict.fromkeys(name for row in rows for name in row)
        empty = {name: "" if name in ("verdict", "doubts") else math.nan for name in names}
        return [{**empty, **row} for row in rows]

    def table(self) -> Table:
        """Return a row for each reversal, SI units, in the order of the ranking.

        The greatest `peak` of a joint is that of its summary. Columns `exponent_...` say by which
        powers of speed, slope, clearance, mass and stiffness the two-mass peak grows; see
        `ForceReversal.exponents`. The forces over a period are those of each joint:
        `scan[name].to_xarray()`.
        """
        told = {"rigid": ("N", "part of an undamped peak that the ramp has reached by then")}
        return row_table(self.rows(), "reversal", told, speed=self.speed)

    def __str__(self) -> str:
        lines = [f"clearance at {self.speed:g} rad/s"]
        lines += [
            f"- {self._joints[name].label}: {self._joints[name].summary}" for name in self.ranking
        ]
        lines += str(self.verified).splitlines()[1:] if self.verified else []
        lines += [f"- {name}: not scanned, {reason}" for name, reason in self.left_out.items()]
        return "\n".join([*lines, *(f"- note: {note}" for note in self.notes)])

    __repr__ = __str__
