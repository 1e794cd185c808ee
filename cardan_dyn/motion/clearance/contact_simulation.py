"""Contact simulation: what was found of pins with clearance while a mechanism moved."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ...core.elements.link_motions import LinkMotions
from ...core.results.result import Result
from ...core.results.table import Table
from ...kit.arrays import ROUNDED, Array
from ...kit.errors import ArgumentError, ModelError, choices
from ...kit.frozen import read_only
from ..simulation.trajectory import Trajectory
from .opened_mechanism import across
from .row_tables import COMPONENTS, row_table, variable

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ...core.elements.pin_contact import PinContact


@dataclass(frozen=True, eq=False)
class PinImpact:
    """A time during which a pin presses the wall of its bush.

    Attributes:
        bearing: name of the joint, or of one of its two bearings, `joint+` or `joint-`.
        start, end: [s]; the end is that of the simulation if it still pressed then.
        position: of the drive at the start, all turns counted [rad].
        speed: at which the pin struck the wall [m/s]; NaN where the simulation began pressed.
        peak: greatest force [N].
        peak_time: when [s].
        direction: `(3,)` unit vector in which the pin pressed the wall then, in the world.
    """

    bearing: str
    start: float
    end: float
    position: float
    speed: float
    peak: float
    peak_time: float
    direction: Array


@dataclass(frozen=True, eq=False)
class JointContact(Result):
    """What a pin did in its bush, at N times.

    Attributes:
        name: of the joint, or of one of its two bearings, `joint+` or `joint-`.
        time: times `(N,)` [s].
        position: of the drive `(N,)`, all turns counted [rad].
        force: `(N,)` by which the wall presses the pin [N].
        friction: `(N,)` along the wall on the pin, in the sense of a turn about the axis [N].
        depth: `(N,)` of the pin in the wall, negative in the clearance [m].
        offset: `(N, 3)` of the pin from the axis of its bush, in world axes [m].
        orbit: `(N, 2)` the same as the bush sees it, along two of its directions that are normal to
            its axis and to each other [m].
        vector: `(N, 3)` force on the pin, in world axes [N].
        impacts: all of the simulation, in order of time.
    """

    name: str
    time: Array
    position: Array
    force: Array
    friction: Array
    depth: Array
    offset: Array
    orbit: Array
    vector: Array
    impacts: tuple[PinImpact, ...]

    def table(self) -> Table:
        """Return what the pin did over time, SI units."""
        return Table(
            [
                variable("time", self.time, "time", given=True),
                variable("position", self.position, "time"),
                *(
                    variable(name, getattr(self, name), "time")
                    for name in ("force", "friction", "depth")
                ),
                variable("offset", self.offset, "time", "component"),
                variable("orbit", self.orbit, "time", "orbit_component"),
                variable("vector", self.vector, "time", "component"),
            ],
            {"time": len(self.time)},
            labels=COMPONENTS,
            attributes={"bearing": self.name},
        )

    @property
    def peak(self) -> float:
        """Greatest force in the simulation [N], whether the pin struck or never left its wall."""
        return max([float(np.max(self.force)), *(item.peak for item in self.impacts)])

    @property
    def struck(self) -> tuple[PinImpact, ...]:
        """Impacts that began in the simulation."""
        return tuple(item for item in self.impacts if not np.isnan(item.speed))


def finer(times: Array) -> Array:
    """Return times `(N,)` with others between, each step cut into eight parts."""
    between = times[:-1, None] + np.diff(times)[:, None] * np.arange(8) / 8
    return np.append(between, times[-1])


def finely(simulation: ContactSimulation, bearing: str, first: int = 0) -> JointContact:
    """Return what a pin did at finer times from one on, and where its impacts have corners."""
    times = simulation.time[first:]
    impacts = simulation[bearing].impacts
    corners = np.ravel([(item.start, item.peak_time, item.end) for item in impacts])
    corners = corners[(corners > times[0]) & (corners < times[-1])]
    return simulation.at(np.union1d(finer(times), corners))[bearing]


class ContactSimulation(Result, Mapping[str, JointContact]):
    """A simulation of clearance: pins by names of joints or bearings; `print` shows a table.

    Attributes:
        trajectory: of the mechanism with its joints open; all that a trajectory tells.
        drive: name of the drive in it.
        speed: of the drive, or its first one [rad/s].
        made_of: of the mechanism without clearance, see `Scan`.
    """

    def __init__(
        self,
        trajectory: Trajectory,
        contacts: Mapping[str, tuple[int, ...]],
        drive: str,
        speed: float,
        made_of: Mapping[str, str] | None = None,
    ) -> None:
        self.trajectory, self.drive, self.speed = trajectory, drive, speed
        self.made_of = dict(made_of or {})
        self._contacts = dict(contacts)
        elements = trajectory.elements
        self._indices = {
            elements[index].name: index for every in contacts.values() for index in every
        }

    def __reduce__(self) -> tuple[object, ...]:
        return ContactSimulation, self._with(self.trajectory)

    @property
    def time(self) -> Array:
        """Times `(N,)` [s]: the steps of the simulation, or those that `at` was given."""
        return self.trajectory.time

    def refuse_other_speed(self, speed: float) -> None:
        """Refuse the speed of a scan if it is another one.

        Raises:
            ArgumentError: it is.
        """
        if abs(speed - self.speed) > ROUNDED * abs(speed):
            raise ArgumentError(
                f"the scan is of {speed:g} rad/s, the simulation of {self.speed:g} rad/s"
            )

    @property
    def steps(self) -> Array:
        """Times `(S,)` of the steps of the simulation [s], also if `at` was given others."""
        return self.trajectory.steps

    @property
    def reason(self) -> str:
        """Why it ended before its time; empty if it did not."""
        return self.trajectory.reason

    @property
    def notes(self) -> tuple[str, ...]:
        """What one should know of it."""
        notes = list(self.trajectory.notes)
        elements = self.trajectory.elements
        laws = [elements[index].law for index in self._indices.values()]  # type: ignore[attr-defined]
        # By a touch of 1 kg at 0.1 m/s: from 0.9 on, small differences grow from impact to impact.
        if any(law.restitution(0.1, 1.0) > 0.9 for law in laws):
            notes.append(
                "hardly damped: after a few impacts no digit of a single one is left, and only "
                "their distribution tells something"
            )
        missing, stored = self._energies
        # Forces go by the root of what is stored.
        if missing > 0.1 * stored > 0.0:
            notes.append(
                f"inaccurate: {missing:.2g} J are missing in the balance of energy, where walls "
                f"store {stored:.2g} J at most; forces of impacts may be off: compare with a "
                "simulation of smaller rtol"
            )
        return tuple(notes)

    @cached_property
    def _energies(self) -> tuple[float, float]:
        """Greatest energy that is missing in the balance, and greatest that walls store [J]."""
        whole = self.trajectory.at(self.steps)
        energy = whole.kinetic_energy + whole.potential_energy - whole.work
        forces = (whole.element_force[index] for index in self._indices.values())
        stored = max(float(np.max(force.energy)) for force in forces)
        return float(np.max(np.abs(energy - energy[0]))), stored

    def at(self, times: ArrayLike) -> ContactSimulation:
        """Return the same simulation at other times, see `Trajectory.at`."""
        return ContactSimulation(*self._with(self.trajectory.at(times)))

    def evenly(self, count: int) -> ContactSimulation:
        """Return the same simulation at equidistant times."""
        return ContactSimulation(*self._with(self.trajectory.evenly(count)))

    def _with(self, trajectory: Trajectory) -> tuple[Any, ...]:
        """Return what the same simulation at other times is made of."""
        return trajectory, self._contacts, self.drive, self.speed, self.made_of

    def __getitem__(self, bearing: str) -> JointContact:
        force: Any = self.trajectory.element_force[self._index(bearing)]
        return JointContact(
            bearing,
            self.time,
            self._drive_position,
            force.pressure,
            force.friction,
            force.depth,
            force.offset,
            read_only(self._orbit(self.contact(bearing), force.offset)),
            force.force,
            tuple(item for item in self.impacts if item.bearing == bearing),
        )

    def _index(self, bearing: str) -> int:
        if bearing not in self._indices:
            raise ModelError(
                f"no joint {bearing!r} has clearance; {choices(self._indices, bearing)}"
            )
        return self._indices[bearing]

    def contact(self, bearing: str) -> PinContact:
        """Return what a pin strikes: its clearance and its law.

        Raises:
            ModelError: no such joint has clearance.
        """
        return cast("PinContact", self.trajectory.elements[self._index(bearing)])

    def _orbit(self, contact: PinContact, offset: Array) -> Array:
        """Return offsets `(N, 3)` in the world as the bush of a contact sees them, `(N, 2)`."""
        trajectory = self.trajectory
        bush = LinkMotions(trajectory.mechanism, [contact.link_a]).at(*trajectory.states)
        turned = bush[contact.link_a].rotation @ np.stack(across(contact.axis_a), axis=1)
        return np.asarray((offset[:, None] @ turned)[:, 0])

    def __iter__(self) -> Iterator[str]:
        return iter(self._indices)

    def __len__(self) -> int:
        return len(self._indices)

    @property
    def _drive_position(self) -> Array:
        positions = self.trajectory.position.reshape(len(self.time), -1)
        return read_only(positions[:, list(self.trajectory.coordinates).index(self.drive)])

    @cached_property
    def impacts(self) -> tuple[PinImpact, ...]:
        """Of all pins, in order of the times at which they began."""
        names = {index: name for name, index in self._indices.items()}
        touches = sorted(self.trajectory.touches, key=lambda item: item.start)
        if not touches:
            return ()
        there = self.at([item.start for item in touches])
        return tuple(
            PinImpact(
                names[item.contact],
                item.start,
                item.end,
                float(position),
                item.speed,
                item.peak,
                item.peak_time,
                read_only(item.direction),
            )
            for item, position in zip(touches, there._drive_position, strict=True)
        )

    @cached_property
    def energy_residual(self) -> float:
        """What is missing in the balance of energy over all steps, see `Trajectory`.

        It is relative to the energy that moves, of which walls store a small part: by that part,
        forces of impacts may be less exact.
        """
        return self.trajectory.at(self.steps).energy_residual

    def table(self) -> Table:
        """Return a row for each impact, SI units, in order of time.

        What pins did over time is theirs: `simulation[name].to_xarray()`.
        """
        told = {
            "position": ("rad", "position of the drive at the start, all turns counted"),
            "speed": ("m/s", "speed at which the pin struck the wall"),
            "peak": ("N", "greatest force"),
        }
        rows = [vars(item) for item in self.impacts]
        return row_table(rows, "impact", told, drive_speed=self.speed)

    def __str__(self) -> str:
        ended = f", ended by: {self.reason}" if self.reason else ""
        lines = [f"clearance at {self.speed:g} rad/s, {self.trajectory.time[-1]:g} s{ended}"]
        for name in self:
            struck = [item for item in self.impacts if item.bearing == name and item.speed > 0.0]
            lines.append(f"- {name}: {len(struck)} impacts, {self[name].peak:.4g} N at most")
        lines += [f"- {note}" for note in self.notes]
        return "\n".join(lines)

    __repr__ = __str__
