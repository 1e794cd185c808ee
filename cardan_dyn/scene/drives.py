"""Drives: which coordinates can drive a mechanism, over which range, and which to take first."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..core.kinematics.closing.far import GenericStates, generic_states
from ..core.kinematics.loops.idle_rods import rods_by_name
from ..core.kinematics.loops.structure import Structure
from ..core.kinematics.tolerances import MOVES
from ..core.mechanism.configuration import Configuration
from ..core.mechanism.mechanism import Mechanism
from ..core.results.limits import UNLIMITED, described_limits, exceeded
from ..kit.arrays import Array, cardan_angles
from ..kit.errors import (
    ArgumentError,
    CardanError,
    MobilityError,
    SingularConfigurationError,
    choices,
)
from ..kit.frozen import Frozen, frozen
from ..kit.markup import aligned
from ..kit.quantities import amount
from .assembling import assemble, closure_error
from .presets import preset_of
from .scene import Scene

MOST_COORDINATES = 400
"""Joint coordinates of a component above which its ranks are counted: singular values of six
matrices of this size take a few seconds, and grow with the third power."""
_MOST_FOLLOWED = 30
"""Coordinates on loops up to which all of them are followed to the ends of their ranges; of larger
mechanisms those that are chosen as drives are. A range takes 0.01 to 0.3 s."""
_NONE = (0.0, 0.0, 0.0)
"""Gravity of scenes that are only moved [m/s²]."""


@dataclass(frozen=True)
class Drive:
    """A coordinate of a mechanism, as a drive.

    Attributes:
        name: of the coordinate, see `Mechanism.drivable`.
        slides: whether it is a slide [m]; else it is an angle [rad].
        is_grounded: whether its joint connects a link to the world.
        start: where it is at the start [rad or m].
        limits: of the description; ±inf where there are none.
        instead_of: drives in whose place it can determine the motion; itself if it is one of them.
        reach: between which positions the loops let it move from the start, the other drives
            staying where they are: dead points, or where assembly modes meet; ±inf where nothing
            ends the way. None if it was not followed, or cannot drive.
        beyond: where limits of other joints are exceeded within `range`, in words; empty where they
            are not, or were not looked at.
        problem: why it does not determine the motion from the start; empty if it does.
    """

    name: str
    slides: bool
    is_grounded: bool
    start: float
    limits: tuple[float, float] = UNLIMITED
    instead_of: tuple[str, ...] = ()
    reach: tuple[float, float] | None = None
    problem: str = ""
    beyond: str = ""

    @property
    def determines(self) -> bool:
        """Whether it determines the motion, together with the other drives."""
        return not self.problem

    @property
    def range(self) -> tuple[float, float] | None:
        """Between which positions it can move [rad or m]: its reach, within its limits.

        None as `reach` is. Limits that leave nothing of the reach are not regarded.
        """
        if self.reach is None:
            return None
        low, high = max(self.limits[0], self.reach[0]), min(self.limits[1], self.reach[1])
        return (low, high) if low < high else self.reach

    @property
    def turns(self) -> bool:
        """Whether it is an angle that turns without end."""
        return not self.slides and self.range == UNLIMITED

    @property
    def ends(self) -> str:
        """What ends its range, in words; or why it has none."""
        if self.problem or self.range is None or self.reach is None:
            return self.problem or "not followed"
        if self.range == UNLIMITED:
            text = "no end" if self.slides else "turns through"
        else:
            by_loops = [a == b for a, b in zip(self.range, self.reach, strict=True)]
            ends = zip(self.range, by_loops, strict=True)
            words = ["loops" if loops else "limit" for end, loops in ends if np.isfinite(end)]
            text = " and ".join(dict.fromkeys(words))
        is_inside = self.limits[0] <= self.start <= self.limits[1]
        more = "" if is_inside else "starts beyond its limits"
        return "; ".join(filter(None, [text, more, self.beyond]))

    def __str__(self) -> str:
        if self.problem or self.range is None or self.range == UNLIMITED:
            return self.ends
        low, high = (0.0 if abs(end) < 1e-12 else end for end in self.range)
        return f"{low:.4g} to {high:.4g} {'m' if self.slides else 'rad'} ({self.ends})"


class Drives(Frozen, Mapping[str, Drive]):
    """How a mechanism can be driven; `print` shows it. Coordinates by name, as `Drive`.

    `cd.Scene(mechanism, **drives.arguments)` is driven as `default` says.

    Attributes:
        name: of the mechanism.
        mobility: number of coordinates that decide the motion; idle rods do not count.
        needed: that many coordinates that together determine the motion, the best ones first; None
            where the mechanism is too large to be examined and says no drives itself.
        default: those of them that should be driven: what the preset of a bundled mechanism says,
            else the motors of the description, else a joint at the ground, if possible one that
            turns through. Empty if nothing can be driven from the start.
        held: the rest of them, where they are held [rad or m].
        start: the configuration in which all this holds.
        is_moved: whether `start` is not where the description's own zero leads to, but beside it,
            since that is a singular configuration.
        reason: why these are the default, in words; or why nothing is.
    """

    def __init__(
        self,
        name: str,
        found: Mapping[str, Drive],
        needed: tuple[str, ...],
        default: tuple[str, ...],
        held: Mapping[str, float],
        reason: str,
        start: Configuration,
        is_moved: bool,
    ) -> None:
        self.name, self.mobility, self.needed, self.default = name, len(needed), needed, default
        self.held, self.reason, self.start, self.is_moved = frozen(held), reason, start, is_moved
        self._found = frozen(found)
        self._freeze()

    def __getitem__(self, name: str) -> Drive:
        if name not in self._found:
            raise ArgumentError(
                f"{name!r} is no coordinate that was examined as a drive: "
                f"{choices(self._found, name)}"
            )
        return self._found[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._found)

    def __len__(self) -> int:
        return len(self._found)

    @property
    def arguments(self) -> dict[str, object]:
        """Arguments of a `Scene` that is driven as `default` says: `drive`, `held`, `near`."""
        drive = self.default[0] if len(self.default) == 1 else list(self.default)
        return {
            "drive": drive,
            "held": dict(self.held),
            "near": self.start if self.is_moved else None,
        }

    @property
    def ranked(self) -> list[Drive]:
        """All of them: those of the default, what else is needed, others, and what cannot drive."""
        first = dict.fromkeys((*self.default, *self.needed))
        order = {name: place for place, name in enumerate(first)}
        return sorted(
            self.values(), key=lambda item: (bool(item.problem), order.get(item.name, len(order)))
        )

    def role(self, item: Drive) -> str:
        """Return whether a coordinate is a default, where it is held, or whose place it takes."""
        if item.name in self.default:
            return "default"
        if item.name in self.held:
            at = self.held[item.name]
            told = amount(at, "m") if item.slides else amount(float(np.degrees(at)), "°")
            return f"held at {told}"
        if not (item.determines and item.instead_of):
            return ""
        if len(self.default) == 1:
            return "instead"
        first, *others = item.instead_of
        return f"instead of {first}{f' or {len(others)} more' * bool(others)}"

    def __str__(self) -> str:
        rows = [
            ("", item.name, "; ".join(filter(None, [str(item), self.role(item)])))
            for item in self.ranked
        ]
        return "\n".join(filter(None, [repr(self)[1:-1], aligned(rows)]))

    def __repr__(self) -> str:
        return f"<Drives of {self.name!r}: mobility {self.mobility}, {self.reason}>"


class _Freedom(NamedTuple):
    """What moves together: loops and couplings with joints in common, or one free coordinate.

    Attributes:
        names: of its coordinates.
        basis: `(K, c, m)` motions of the c coordinates that the closure equations allow, in K
            closed configurations, the start the first; m is the mobility with its idle rods.
        idle: number of idle rods in it.
    """

    names: list[str]
    basis: Array
    idle: int

    def picked(self, wanted: list[str]) -> list[str]:
        """Return coordinates that determine the motion, the first ones of a list that do."""
        found: list[str] = []
        for name in sorted(self.names, key=wanted.index):
            if len(found) == self.basis.shape[2] - self.idle:
                break
            rows = self.basis[:, [self.names.index(item) for item in (*found, name)]]
            if np.max(np.linalg.svd(rows, compute_uv=False)[:, -1]) > MOVES:
                found.append(name)
        return found

    def replaceable(self, name: str, picked: list[str]) -> list[str]:
        """Return which picked coordinates another one can replace, the most affected first."""
        rows = self.basis[:, [self.names.index(item) for item in picked]]
        own = self.basis[:, self.names.index(name)]
        rates = np.max(np.abs(own[:, None] @ np.linalg.pinv(rows))[:, 0], axis=0)
        order = np.argsort(-rates, kind="stable")
        return [picked[index] for index in order if rates[index] > MOVES]


def drives_of(mechanism: Mechanism, start: Configuration | None = None) -> Drives:
    """Find out how a mechanism can be driven.

    Args:
        mechanism: from `load`.
        start: configuration from which it moves; where the preset of a bundled mechanism starts,
            or where its loops can be closed near the description's zero, unless given.

    Raises:
        AssemblyError: the loops cannot be closed.
    """
    return _Search(mechanism, start).result()


class _Search:
    """Finds the drives of a mechanism."""

    def __init__(self, mechanism: Mechanism, start: Configuration | None) -> None:
        preset = preset_of(mechanism)
        self._preset = preset if start is None else None
        if self._preset is not None:
            held = {name: np.deg2rad(value) for name, value in self._preset.held_deg.items()}
            scene = Scene(mechanism, drive=list(self._preset.drive), held=held, gravity=_NONE)
            start = scene.configuration()
        given = assemble(mechanism) if start is None else start
        self._mechanism = given.mechanism
        self._structure = Structure(self._mechanism)
        self._rods = rods_by_name(self._mechanism, set(range(self._mechanism.model.nv)))
        self._given, self._start, self._freedoms = given, given, list[_Freedom]()
        self._find()
        self._on_loops = {name for of in self._freedoms if len(of.names) > 1 for name in of.names}
        self._positions = self._placed()

    def result(self) -> Drives:
        """Return what was found."""
        order = sorted(self._mechanism.drivable, key=self._key)
        picked = [item.picked(order) for item in self._freedoms]
        needed = [name for names in picked for name in names]
        found = {name: self._drive(name, [name], needed) for name in needed}
        if len(self._on_loops) <= _MOST_FOLLOWED:
            for freedom, names in zip(self._freedoms, picked, strict=True):
                for name in freedom.names:
                    if name not in found and name in self._mechanism.coordinates.named:
                        places = freedom.replaceable(name, names) if names else []
                        found[name] = self._drive(name, places, needed)
        listed = {name: found[name] for name in self._mechanism.drivable if name in found}
        default, reason, needed = self._chosen(listed, needed)
        # The best of its component may have taken the place of the one that came first.
        for freedom in self._freedoms:
            own = [name for name in needed if name in freedom.names]
            for name in freedom.names:
                if name in listed and listed[name].instead_of:
                    places = [name] if name in own else freedom.replaceable(name, own)
                    listed[name] = replace(listed[name], instead_of=tuple(places))
        held = {name: self._positions[name] for name in needed if default and name not in default}
        needed.sort(key=lambda item: (item not in default, list(listed).index(item)))
        start = self._start, self._start is not self._given
        return Drives(self._mechanism.name, listed, tuple(needed), default, held, reason, *start)

    def _find(self) -> None:
        """Find what moves together, and where it starts: not where that is singular."""
        mechanism, given, x = self._mechanism, self._given, self._given.x.copy()
        names = {}
        for name, named in mechanism.drivable.items():
            names[mechanism.coordinates.velocity_columns[named.joint].start + named.offset] = name
        left, freedoms, is_moved = set(names), self._freedoms, False
        for item in generic_states(self._structure, MOST_COORDINATES, given.x):
            group = item.group.group if isinstance(item, GenericStates) else item.group
            columns = group.passives.tolist()
            left -= set(columns)
            own = [names[column] for column in columns if column in names]
            if not isinstance(item, GenericStates):
                # Too large to be examined: what its author drives is taken as what is needed.
                motors = set(mechanism.independent_coordinates)
                freedoms += [
                    _Freedom([name], np.ones((1, 1, 1)), 0) for name in own if name in motors
                ]
                continue
            joints = {mechanism.drivable[name].joint for name in own}
            idle = sum(not joints.isdisjoint(rod) for rod in self._rods)
            # Motions that no closure equation opposes.
            _, _, right = np.linalg.svd(item.group.scaled_rows.transpose(0, 2, 1))
            basis = right[:, item.rank :].transpose(0, 2, 1)
            kept = [index for index, column in enumerate(columns) if column in names]
            freedoms.append(_Freedom(own, basis[:, kept], idle))
            if item.rank_at_start < item.rank:
                moving = [
                    index
                    for joint in joints
                    for index in range(*mechanism.coordinates.columns[joint].indices(len(x)))
                ]
                x[moving] = item.x[0][moving]
                is_moved = True
        freedoms += [_Freedom([names[column]], np.ones((1, 1, 1)), 0) for column in sorted(left)]
        if is_moved:
            error = closure_error(self._structure, x)
            self._start = Configuration(mechanism, x, error, given.zero_residual, given.branch)

    def _placed(self) -> dict[str, float]:
        """Return where all coordinates start; of balls their Cardan angles."""
        x, coordinates = self._start.x, self._mechanism.coordinates
        placed = {}
        for joint in self._mechanism.joints.values():
            if not joint.parts:
                continue
            values = x[coordinates.columns[joint.name]]
            if len(values) > joint.nv:
                values = np.concatenate([values[:-4], cardan_angles(values[-4:])])
            for name, value in zip(joint.coordinates, values, strict=True):
                placed[name] = float(value)
        return placed

    def _key(self, name: str) -> tuple[object, ...]:
        """Return by what coordinates are sorted that may be needed as drives."""
        mechanism = self._mechanism
        item = mechanism.drivable[name]
        following = {coupling.successor for coupling in mechanism.description.couplings}
        preset = () if self._preset is None else (*self._preset.drive, *self._preset.held_deg)
        return (
            name not in preset,
            name not in mechanism.independent_coordinates,
            any(item.joint in rod for rod in self._rods) or item.joint in following,
            mechanism.joints[item.joint].nv > 1,
            item.joint not in mechanism.grounded,
            any(item.joint == loop.joint for loop in mechanism.loops),
        )

    def _drive(self, name: str, places: list[str], needed: list[str]) -> Drive:
        """Return what is known of a coordinate that may take the place of others."""
        item = self._mechanism.drivable[name]
        drive = Drive(
            name, item.slides, item.joint in self._mechanism.grounded, self._positions[name],
            described_limits(self._mechanism, name), tuple(places),
        )  # fmt: skip
        if not places:
            return replace(drive, problem="it does not move")
        if self._mechanism.joints[item.joint].nv == 1 and name not in self._on_loops:
            return replace(drive, reach=UNLIMITED)
        held = {other: self._positions[other] for other in needed if other not in (name, places[0])}
        try:
            scene = Scene(self._mechanism, drive=name, held=held, near=self._start, gravity=_NONE)
            drive = replace(drive, reach=scene.motion_range())
        except CardanError as error:
            return replace(drive, problem=_shortened(error))
        return replace(drive, beyond=self._beyond(scene, drive))

    def _beyond(self, scene: Scene, drive: Drive) -> str:
        """Return where a drive takes other joints beyond their limits, see `Drive.beyond`."""
        limited = (
            described_limits(self._mechanism, name) for name in self._on_loops - {drive.name}
        )
        low, high = drive.range or UNLIMITED
        if drive.turns:
            low, high = drive.start, drive.start + 2.0 * np.pi
        if set(limited) <= {UNLIMITED} or not np.isfinite(high - low):
            return ""
        try:
            # At every hundredth; the ends themselves may be dead points.
            found = exceeded(scene.sweep(np.linspace(low, high, 101)[1:-1]))
        except CardanError:
            return ""
        others = f", and {len(found) - 1} more" * (len(found) > 1)
        return f"{found[0]}{others}" if found else ""

    def _chosen(
        self, found: Mapping[str, Drive], needed: list[str]
    ) -> tuple[tuple[str, ...], str, list[str]]:
        """Return the default and why it is, and what is needed with it."""
        if not needed:
            return (), "nothing can move", needed
        motors = tuple(
            name for name in self._mechanism.independent_coordinates
            if name in needed and found[name].determines
        )  # fmt: skip
        if self._preset is not None:
            names, reason = self._preset.drive, "driven as its preset says"
        elif motors:
            names, reason = motors, "driven where the description says"
        elif not self._mechanism.loops and len(needed) > 1:
            names, reason = self._unlike_bases(needed), "its joints move one by one"
        else:
            best = self._best(found)
            if best is None:
                return (), "nothing can be driven from the start", needed
            turns = self._turns_through(best, found)
            names, reason = (best.name,), _why(best, turns)
            if not (turns or self._is_cylinder(best) or len(needed) == 1):
                names, reason = self._unlike_bases(needed), "these determine the motion together"
            if best.name not in needed and names == (best.name,):
                place = best.instead_of[0]
                needed = [best.name if name == place else name for name in needed]
        listed = ", ".join(names) if len(names) < 4 else f"{len(names)} joints"
        return tuple(names), f"{reason}: {listed}", needed

    def _unlike_bases(self, needed: list[str]) -> tuple[str, ...]:
        """Return coordinates in order, without those by which whole mechanisms move in space."""
        needed = [name for name in self._mechanism.drivable if name in needed]
        joints = self._mechanism.joints
        types = {name: joints[self._mechanism.drivable[name].joint].type for name in needed}
        return tuple(name for name in needed if types[name] != "floating") or tuple(needed)

    def _best(self, found: Mapping[str, Drive]) -> Drive | None:
        """Return the coordinate that is driven alone: at the ground, and turning through.

        Else a cylinder: a slide in a loop that has limits. Whole mechanisms do not tumble in space.
        """
        able = [item for item in found.values() if item.determines and item.range is not None]
        in_place = set(self._unlike_bases([item.name for item in able]))

        def rank(item: Drive) -> tuple[bool, ...]:
            turns = self._turns_through(item, found)
            at_ground = turns and item.is_grounded
            rest = turns, self._is_cylinder(item), item.is_grounded
            return item.name in in_place, at_ground, *rest

        return max(able, key=rank, default=None)

    def _turns_through(self, best: Drive, found: Mapping[str, Drive]) -> bool:
        """Return whether an angle turns without end, and nothing that it moves meets its limits."""
        joint = self._mechanism.drivable[best.name].joint
        if not best.turns or self._mechanism.joints[joint].nv > 1:
            return False  # A ball's angle is no crank.
        along = [item for item in self._freedoms if best.name in item.names]
        moved = [found[name] for item in along for name in item.names if name in found]
        return all(item.range == item.reach for item in moved)

    def _is_cylinder(self, item: Drive) -> bool:
        return item.slides and item.limits != UNLIMITED and item.name in self._on_loops


def _why(best: Drive, turns: bool) -> str:
    where = "at the ground" if best.is_grounded else "not at the ground"
    if best.slides and not best.is_grounded:
        return f"driven by a slide{' between its limits' * (best.limits != UNLIMITED)}"
    how = "turns through" if turns else "slides" if best.slides else "swings"
    return f"driven at a joint {where} that {how}"


def _shortened(error: CardanError) -> str:
    """Return what an error says of a drive in a few words."""
    if isinstance(error, SingularConfigurationError):
        return "starts in a dead point"
    if isinstance(error, MobilityError):
        return "does not determine the motion"
    return str(error).partition(";")[0]
