"""Findings: what a report tells of a mechanism in one case, as numbers and text."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...core.description.origins import PREFIX
from ...core.elements.joint_elements import Actuator
from ...core.elements.link_loads import Wrench
from ...core.results.axes import in_fixed_axes
from ...core.results.left_open import LeftOpen
from ...core.results.limits import briefly, exceeded
from ...core.results.lost_digits import WELL, digits, near_singular, right
from ...core.results.result import Result
from ...core.results.sweep import Sweep
from ...figures.orders import order_amplitudes
from ...figures.wrenches import PARTS, QUANTITIES
from ...kit.arrays import NOTHING, ROUNDED, Array
from ...kit.frozen import Frozen
from ...kit.periodic import MOST_NODES
from ...kit.quantities import amount, span
from ...motion.simulation.trajectory import Trajectory
from ...scene.describe import describe
from ...scene.mechanism_report import MechanismReport
from ...scene.task_simulation import TaskTrajectory
from ...scene.task_sweep import TaskSweep, unit_of_row
from .case import STANDING, Case
from .described import fingerprint
from .extremes import (
    RIGHT,
    SIZES,
    Extreme,
    Extremes,
    counted,
    extremes,
    is_over_time,
    quantities_of,
)
from .grids import Grid, Row, place, way
from .page import FRAMES, HIGHEST, today


class Way(NamedTuple):
    """How a drive, a free coordinate or a row of a task moves.

    Attributes:
        kind: `drive`, `free` or `task`.
        name: of it.
        unit: of positions, `rad` or `m`.
        position, speed, acceleration: `(N,)`.
    """

    kind: str
    name: str
    unit: str
    position: Array
    speed: Array
    acceleration: Array

    @property
    def slides(self) -> bool:
        """Whether it is a length."""
        return self.unit == "m"

    @property
    def size(self) -> float:
        """The greatest position in size."""
        return float(np.abs(self.position).max())

    @property
    def span(self) -> str:
        """From where to where it goes."""
        return way_of(self.position, self.slides)

    @property
    def pace(self) -> list[str]:
        """Its speed, and how that changes; nothing where it rests."""
        told = [speed_text(self.speed, self.slides)] if np.any(self.speed) else []
        if np.any(self.acceleration):
            told.append(f"acceleration {between(self.acceleration, f'{self.unit}/s²')}")
        return told


class Findings(Result, Frozen):
    """What was found of a mechanism in one case; see `Report`.

    Attributes:
        mechanism: as it was loaded.
        sweep: of the case; None if the mechanism cannot be moved.
        said: how the case was chosen.
        title, project, author, date, revision: head of the page.
    """

    def __init__(
        self, case: Case, title: str, project: str, author: str, date: str, revision: str
    ) -> None:
        mechanism, self.sweep, self.said, self._box, self._trajectory, self._ways = case
        self.mechanism = mechanism.base
        self.project, self.author, self.revision = project, author, revision
        self.title = title or mechanism.name
        self.date = date or today().isoformat()
        self._freeze()

    @cached_property
    def description(self) -> MechanismReport:
        """Mobility, ranks and drives."""
        return describe(self.mechanism)

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of the description's text."""
        return fingerprint(self.mechanism)

    @cached_property
    def _found(self) -> Extremes:
        """Extremes and what could not be known of them."""
        if self.sweep is None:
            return Extremes((), None, "", "", 0.0)
        return extremes(self.sweep, self._box, self._trajectory)

    @property
    def extremes(self) -> tuple[Extreme, ...]:
        """Greatest and least values of wrenches and efforts, joint by joint."""
        return tuple(item for item in self._found.rows if item.owner != STANDING)

    @property
    def drives(self) -> tuple[str, ...]:
        """Names of the driven coordinates."""
        names = () if self.sweep is None else self.sweep.coordinates
        return tuple(name for name in names if name != STANDING)

    @cached_property
    def ways(self) -> list[Way]:
        """How drives and free coordinates move, and behind them the rows of a task, if any."""
        return [] if self.sweep is None else ways(self._trajectory or self.sweep)

    @property
    def task(self) -> list[Way]:
        """How the rows of a task move, none without a task."""
        return [one for one in self.ways if one.kind == "task"]

    @property
    def told_rows(self) -> list[Way]:
        """The rows of the task that places are told by: those that vary, all where none does."""
        moved = [row for row in self.task if np.ptp(row.position) > NOTHING * row.size]
        return moved or self.task

    @property
    def acts(self) -> bool:
        """Whether any wrench is different from zero."""
        return any(item.acts for item in self.extremes)

    @property
    def left_open(self) -> str:
        """What is not unique and why, of joints and couplings by name; empty if all is."""
        return "" if self.opened is None else self.opened.text

    @cached_property
    def opened(self) -> LeftOpen | None:
        """What is not unique of the joints and couplings of the machine; None if nothing moves."""
        if self.sweep is None:
            return None
        found = self.sweep.left_open
        chosen, silent = (
            {name: parts for name, parts in of.items() if not name.startswith(PREFIX)}
            for of in (found.chosen, found.silent)
        )
        return found._replace(chosen=chosen, silent=silent)

    @cached_property
    def orders(self) -> dict[tuple[str, str, str], Array]:
        """Amplitudes of orders 0 … 8 `(9,)` by owner, quantity and unit; see `no_orders`.

        Of what acts: efforts, what is along the axis of a joint, and components across it in axes
        that stand still (`moment y`, see `in_fixed_axes`). The size of a vector has other orders.
        """
        return {} if self.no_orders else self._orders[0]

    @property
    def orders_error(self) -> float:
        """By how much orders changed at last, of the greatest, when positions were doubled."""
        return self._orders[1]

    @cached_property
    def _orders(self) -> tuple[dict[tuple[str, str, str], Array], float]:
        count = 8 * HIGHEST
        found, error = self._orders_at(count), 1.0
        # Orders that positions are too few for appear as lower ones, until they are enough.
        while error > NOTHING and count < MOST_NODES:
            count *= 2
            coarse, found = found, self._orders_at(count)
            changes = [
                np.abs(value - coarse.get(key, 0.0)).max() / value.max()
                for key, value in found.items()
            ]
            error = float(max(changes, default=0.0))
        for amplitudes in found.values():
            amplitudes[amplitudes <= NOTHING * amplitudes.max(initial=0.0)] = 0.0
        return found, error

    def _orders_at(self, count: int) -> dict[tuple[str, str, str], Array]:
        """Return orders by a number of positions in each turn."""
        if self._found.search is None:
            return {}
        turns, found = round(self._turns), {}
        turn = self._found.search.evenly(count * turns)
        size = {(item.owner, item.quantity): item.size for item in self.extremes if item.acts}
        for item in quantities_of(turn):
            if (item.owner, item.name) not in size:
                continue
            if item.name not in SIZES:
                found[item.owner, item.name, item.unit] = item.values(turn)
            elif item.name != "force" or (item.owner, "shear") not in size:
                vector = "force" if item.unit == "N" else "moment"
                for name, (values, _) in in_fixed_axes(turn, item.owner, vector).items():
                    if np.abs(values).max() > NOTHING * size[item.owner, item.name]:
                        found[item.owner, name, item.unit] = values
        angle = 2.0 * np.pi / count * np.arange(len(turn))
        return {
            key: order_amplitudes(angle, values)[1][::turns][: HIGHEST + 1]
            for key, values in found.items()
        }

    @cached_property
    def drawn(self) -> tuple[Sweep | None, str]:
        """What figures show, and what is to be said of it: the range, however few its samples.

        Curves pass through the extremes of the tables, which mostly lie between samples.
        """
        sweep = self.sweep
        search = self._found.search
        if sweep is None or search is None:
            told = "" if sweep is None else f" Of the {counted(len(sweep))} alone."
            return sweep, told
        few = np.linspace(*search.ends, FRAMES) if len(sweep) < FRAMES else search.known
        places = [end.ravel() for of in self.told for end in (of.greatest_at, of.least_at)]
        return search.solved(np.unique(np.concatenate([few, *places]))), ""

    @property
    def _turns(self) -> float:
        """How many turns the drive makes."""
        low, high = self._found.search.ends if self._found.search else (0.0, 0.0)
        return (high - low) / (2.0 * np.pi)

    @cached_property
    def no_orders(self) -> str:
        """Why there are no orders; empty if there are some."""
        sweep = self.sweep
        if sweep is None or not self.drives:
            return "nothing moves"
        if len(self.drives) > 1:
            return "orders are those of one drive that turns, and several move"
        if sweep.mechanism.drivable[self.drives[0]].slides:
            return f"orders are those of a drive that turns, and {self.drives[0]} slides"
        if self._found.search is None or self.is_over_time:
            return f"orders are those of a range, and these are {self.covered}"
        if abs(self._turns - round(self._turns)) > 1e-9 or not round(self._turns):
            return f"orders need whole turns, the angles cover {self._turns:.6g}"
        return "" if self.acts else "nothing acts"

    @property
    def judgement(self) -> tuple[tuple[str, float, str], ...]:
        """Residuals and condition: names, values, and what they mean in words."""
        if self.sweep is None:
            return ()
        rows = [
            (name.removesuffix("_residual"), float(value), _judged(float(value), _PROVES[name]))
            for name, value in self.sweep.proven.residuals.items()
        ]
        condition = float(np.max(self.sweep.condition))
        zero = "wrenches pass through zero, or nearly singular configurations"
        well = "well conditioned" if condition < WELL else zero
        told = self._near_singular or f"{well}: {right(self._found.rounding)}"
        return (*rows, ("condition", condition, told))

    @property
    def digits(self) -> int:
        """How many digits of the greatest wrenches are right, by the condition where they are."""
        return digits(self._found.rounding)

    @property
    def _near_singular(self) -> str:
        return near_singular(self._found.rounding)

    @cached_property
    def doubts(self) -> tuple[str, ...]:
        """What has to be known before any number is used; empty if all of them are right."""
        unknown = self._found.unknown if self.acts else ""
        if not all(item.settled for item in self.told):
            unknown += "; a ? marks what may be exceeded"
        reach = "" if self.sweep is None else self.sweep.near_reach
        found = [sentence(text) for text in (unknown, self._near_singular, reach) if text]
        if self.sweep is not None and self.acts and self.drives:
            # Whatever is looked at, such a function may be something else in between.
            given = [
                f"{item.joint!r}"
                for item in self.sweep.elements
                if isinstance(item, Actuator) and callable(item.effort)
            ]
            if given:
                found.append(
                    f"The effort of an actuator at {', '.join(given)} is a function of yours: what "
                    "it does over a way much shorter than a hundredth of the range may be missed."
                )
        return tuple(found)

    @cached_property
    def exceeded(self) -> tuple[str, ...]:
        """Where the case goes beyond limits of the description, in words."""
        # The steps of a simulation may be far from each other.
        sweep = self.drawn[0] if self.is_over_time else self.sweep
        return () if sweep is None else exceeded(sweep)

    @property
    def beware(self) -> list[str]:
        """The doubts, and in brief limits that are exceeded, as sentences."""
        return [*self.doubts, *map(sentence, briefly(self.exceeded))]

    @property
    def covered(self) -> str:
        """What the extremes are the extremes of."""
        if self._found.search is None:
            return self._found.covered
        if self.is_over_time:
            return f"the whole time from {span(*self._found.search.ends, 's', ' to ')}"
        assert self.sweep is not None  # There is a search.
        slides = self.sweep.mechanism.drivable[self.drives[0]].slides
        whole = "the whole range" + f" of {self.drives[0]}" * bool(self.task)
        return f"{whole} from {way(*self._found.search.ends, slides, ' to ')}"

    @cached_property
    def places(self) -> Array:
        """Positions `(n, d)` of several drives at which extremes occur, as `place 1` names them."""
        every = [
            end[:1]
            for item in self.extremes
            if item.acts
            for end in (item.greatest_at, item.least_at)
        ]
        if not every:
            return np.zeros((0, len(self.drives)))
        rows, first = np.unique(np.concatenate(every), axis=0, return_index=True)
        return np.asarray(rows[np.argsort(first)])

    def at(self, places: Array, word: str = "place ") -> str:
        """Return drive positions `(n, d)` as a text: of several drives, which of the `places`.

        Of a task its rows instead, unless there is no word for a place, and they are many.
        """
        if self.sweep is None or not self.drives:
            return ""
        if not len(places):
            return "throughout"
        if self.is_over_time:
            size = float(np.abs(self.sweep.time).max())
            return ", ".join(f"t = {amount(float(time), 's', size=size)}" for time in places[:, 0])
        positions = np.reshape(self.sweep.position, (len(self.sweep), -1))
        samples = np.flatnonzero(np.all(positions == places[0], axis=1))[:1]
        told = []
        for row in self.told_rows if len(samples) else ():
            at = place(float(row.position[samples[0]]), row.slides, row.size)
            told.append(f"{row.name} {at}")
        # Beside a table of places two rows of a task are told as such.
        if told and (word or len(told) < 3):
            return ", ".join(told)
        if len(self.drives) == 1:
            slides = self.sweep.mechanism.drivable[self.drives[0]].slides
            size = float(np.abs(self.sweep.position).max())
            # Places that lie closer to each other than digits tell are named once.
            every = (place(float(value), slides, size) for value in places[:, 0])
            # Beside rows of a task a number alone would be taken for one of them.
            return f"{self.drives[0]} " * bool(self.task) + ", ".join(dict.fromkeys(every))
        return f"{word}{int(np.argmax(np.all(self.places == places[0], axis=1))) + 1}"

    def __repr__(self) -> str:
        count = 0 if self.sweep is None else len(self.sweep)
        loose = sum(item.acts and not item.settled for item in self.extremes)
        doubt = f", {loose} extremes in doubt" if loose else ""
        doubt += f", {self._near_singular}" if self._near_singular else ""
        return f"<{type(self).__name__} of {self.mechanism.name!r}: {counted(count)}{doubt}>"

    def __str__(self) -> str:
        lines = [f"{self.title}: {', '.join(self.case_lines)}", *self.said]
        if self.sweep is None:
            return "\n".join(lines)
        if not self.acts:
            return "\n".join([*lines, "Nothing acts: no load, weight, inertia or element."])
        if self.drives:
            lines.append(f"Extremes of {self.covered}.")
        lines += [f"! {text}" for text in self.beware]
        lines += [f"{grid}\n" for grid in self.grids(2)]
        if self.has_places:
            lines.append(
                "The page tells each place; `places` are the positions of all drives there."
            )
        if self.left_open:
            lines.append(f"{'* ' * self.is_marked}{self.left_open}{self.what_is_determined}")
        lines += [f"{name} {value:.1e}: {text}" for name, value, text in self.judgement]
        return "\n".join(lines)

    def grids(self, most: int | None = None) -> list[Grid]:
        """Return the extremes of wrenches, and of efforts; each at so many places at most."""
        at = "place" if self.has_places else "at"
        header = ("quantity", "unit", "greatest in size", at, "other end", f"{at} ")
        found = []
        for name, of, caption in (
            (
                "extremes",
                "joint",
                "Greatest in size and the other end of the range, with the drive's position",
            ),
            ("efforts", "of", "Efforts of drives, of what is held, of couplings and elements"),
        ):
            rows: list[Row] = []
            # What joints can be sized by comes first.
            for item in sorted(self.told, key=lambda item: not item.determined):
                if (item.quantity in QUANTITIES) != (name == "extremes"):
                    continue
                (size, first), (other, last) = item.ends
                ends = (other, self.at(last[:most], "")) if len(last) else ("", "")
                what = item.owner, item.marked, item.unit
                rows.append((*what, size, self.at(first[:most], ""), *ends))
            if rows:
                found.append(Grid(name, caption, (of, *header), rows, unit=2))
        return found

    @property
    def is_marked(self) -> bool:
        """Whether anything that is told has a star."""
        return not all(item.determined for item in self.told)

    @property
    def what_is_determined(self) -> str:
        """Behind what is left open: which of what is told is not; empty if nothing is told."""
        rows = "rows without a star are" if self.is_marked else "all that is tabled is"
        return f"; {rows} determined" if any(item.determined for item in self.told) else ""

    @property
    def is_over_time(self) -> bool:
        """Whether places are times."""
        return self.sweep is not None and is_over_time(self.sweep)

    @property
    def over(self) -> tuple[str, ...]:
        """What places are positions of: `time`, or the drives."""
        return ("time",) if self.is_over_time else self.drives

    @property
    def is_exact(self) -> bool:
        """Whether extremes are those of a range, and nothing of them is in doubt."""
        return self._found.search is not None and not self.doubts

    @property
    def has_places(self) -> bool:
        """Whether places are positions of several drives, which have numbers."""
        return len(self.drives) > 1 and not self.is_over_time

    @cached_property
    def told(self) -> list[Extreme]:
        """The extremes of what acts: each force and moment once, and along axes what joints carry.

        What is along a free direction of a joint is what was put there: loads, efforts of drives
        and of elements, which are told as such. A rotor takes up a part of that.
        """
        free = {
            (joint.name, quantity)
            for joint in self.mechanism.description.joints_and_loops
            for quantity, types in _FREE.items()
            if joint.type in types and not joint.armature
        }
        found = []
        for key, item in self.acting.items():
            parts = [(item.owner, part) for part in PARTS.get(item.quantity, ())]
            acting = [self.acting[part] for part in parts if part in self.acting]
            # What statics leaves open is told by its parts, of which it may determine some.
            is_told = not free.isdisjoint([key, *parts]) or any(
                part.determined > item.determined or abs(part.size - item.size) <= RIGHT * item.size
                for part in acting
            )
            if not is_told:
                found.append(item)
        return found

    @cached_property
    def acting(self) -> dict[tuple[str, str], Extreme]:
        """The extremes of what acts, by owner and quantity."""
        return {(item.owner, item.quantity): item for item in self.extremes if item.acts}

    @property
    def case_lines(self) -> list[str]:
        """What moves, how fast, and what acts, each in a few words."""
        sweep = self.sweep
        if sweep is None:
            return ["not moved"]
        lines = []
        for one in self.ways:
            # The task is what was asked for, and drives follow it.
            if (one.kind != "drive" or not self.task) and one.name != STANDING:
                lines.append(f"{one.name}{' at' * (not np.ptp(one.position))} {one.span}")
                lines += [speed_text(one.speed, one.slides)] if np.any(one.speed) else []
        if self.is_over_time:
            lines = [between(sweep.time, "s"), *lines]
        elif len(self.drives) > 1:
            # Extremes are sought far beyond them.
            lines.append(f"at {counted(len(sweep))}")
        return [*(lines or ["at rest"]), *acting(sweep, self._ways)]


def acting(sweep: Sweep, ways: Mapping[str, tuple[float, int]]) -> list[str]:
    """Return what is held and what acts, each in a few words; `ways` as of a `Case`."""
    known = sweep.mechanism.drivable
    lines = [f"{name} held at {way_of(at, known[name].slides)}" for name, at in sweep.held.items()]
    for name, load in sweep.loads.items():
        if isinstance(load, Wrench):
            sizes = (
                between(np.linalg.norm(np.atleast_2d(vector), axis=-1), unit)
                for vector, unit in ((load.force, "N"), (load.moment, "N·m"))
                if np.any(vector)
            )
            lines.append(f"{' and '.join(sizes) or 'nothing'} on {name}")
            continue
        moving = ""
        if name in ways:
            effort, sense = ways[name]
            load, moving = np.array(effort), f" moving {_SENSES[sense]}"
        lines.append(f"{between(load, known[name].effort_unit)} at {name}{moving}")
    if weight := gravity_of(sweep):
        lines.append(f"gravity {weight}")
    if sweep.elements:
        lines.append(counted(len(sweep.elements), "element"))
    return lines


def gravity_of(sweep: Sweep) -> str:
    """Return gravity in world axes; nothing where there is none."""
    vectors = np.reshape(sweep.gravity, (-1, 3))
    told = ", ".join(between(along) for along in vectors.T)
    return f"({told}) m/s²" if np.any(vectors) else ""


def ways(result: Sweep | Trajectory) -> list[Way]:
    """Return how drives and free coordinates move, and behind them the rows of a task, if any."""
    sweep = result.sweep if isinstance(result, Trajectory) else result
    kinds = ["free" if name in sweep.free else "drive" for name in sweep.coordinates]
    moved: list[tuple[Any, ...]] = [
        (kinds, sweep.coordinates, sweep.position, sweep.speed, sweep.acceleration)
    ]
    if isinstance(result, TaskSweep | TaskTrajectory):
        task = result.task_position, result.task_speed, result.task_acceleration
        moved.append((["task"] * len(result.rows), result.rows, *task))
    found, length = [], sweep.mechanism.characteristic_length
    for kinds, names, *courses in moved:
        units = [unit_of_row(sweep.mechanism, name) for name in names]
        sizes, every = np.array([length if unit == "m" else 1.0 for unit in units]), []
        for values, least in zip(courses, (1.0, 0.0, 0.0), strict=True):
            own = np.reshape(values, (len(sweep), -1))
            # Beside the mechanism, or beside the fastest, the rounding of nothing is nothing.
            floor = NOTHING * sizes * max(np.abs(own / sizes).max(initial=0.0), least)
            every.append(np.where(np.abs(own) <= floor, 0.0, own).T)
        found += [Way(*of) for of in zip(kinds, names, units, *every, strict=True)]
    return found


def sentence(text: str) -> str:
    """Return a text as a sentence; nothing stays nothing."""
    return text and f"{text[0].upper()}{text[1:]}."


def speed_text(values: Array, slides: bool) -> str:
    """Return speeds of a drive [rad/s or m/s] as a text, of what turns in 1/min."""
    return between(values if slides else values * 30.0 / np.pi, "m/s" if slides else "1/min")


def way_of(positions: ArrayLike, slides: bool) -> str:
    """Return where all positions [rad or m] are, or from where to where they go."""
    return way(float(np.min(positions)), float(np.max(positions)), slides)


def between(values: ArrayLike, unit: str = "") -> str:
    """Return a number that all values have, or their range, with its unit."""
    return span(float(np.min(values)), float(np.max(values)), unit)


_FREE = {
    "torsion": ("revolute", "continuous", "cylindrical"),
    "axial": ("prismatic", "cylindrical"),
}
"""Quantities to the types of joints that carry none of them."""
_SENSES = {1: "forward", -1: "backward"}
"""In which a joint moves, by the sign of its speed."""
_PROVES = {
    "loop_residual": "loops, couplings, drives and held joints are closed",
    "balance_residual": "every body is in balance",
    "power_residual": "power is in balance",
    "rate_residual": "speeds and accelerations fit the loops",
}
"""What each residual proves."""


def _judged(value: float, what: str) -> str:
    if np.isnan(value):
        return "nothing to compare: nothing acts, or not all that acts was asked for"
    if value <= ROUNDED:
        return f"{what} to rounding"
    if value <= NOTHING:
        return f"{what}; good, with some digits lost"
    return f"{what}; near the limit of 1e-8: look at the condition"
