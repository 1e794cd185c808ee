"""Findings: what a report tells of a mechanism in one case, as numbers and text."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ..._version import __version__
from ...core.elements.joint_elements import Actuator
from ...core.elements.link_loads import Wrench
from ...core.mechanism.mechanism import Mechanism
from ...core.results.axes import in_fixed_axes
from ...core.results.lost_digits import WELL, digits, near_singular, right
from ...core.results.result import Result
from ...core.results.sweep import Sweep
from ...core.results.table import Table, Variable
from ...figures.orders import order_amplitudes
from ...figures.wrenches import PARTS
from ...kit.arrays import NOTHING
from ...kit.frozen import Frozen
from ...kit.quantities import column, span
from ...scene.describe import describe
from ...scene.mechanism_report import MechanismReport
from ...scene.task_sweep import TaskSweep, unit_of_row
from .case import STANDING, Case
from .described import fingerprint
from .extremes import RIGHT, SIZES, Extreme, Extremes, counted, extremes, quantities_of
from .grids import place, way
from .page import today

_HIGHEST = 8
"""Greatest order that is listed."""
_DRAWN = 361
"""Positions at least at which figures show a range."""
_DOUBLINGS = 7
"""How often positions at which orders are told are doubled, at most: to 8192 in a turn."""
GOOD, POOR = 1e-12, 1e-9
"""Residuals: below the first, nothing but rounding; above the second, close to what is refused."""


class Findings(Result, Frozen):
    """What was found of a mechanism in one case; see `Report`.

    Attributes:
        mechanism: as it was loaded.
        sweep: of the case; None if the mechanism cannot be moved.
        said: how the case was chosen.
        title, project, author, date, revision: head of the page.
    """

    def _take(self, mechanism: Mechanism, case: Case, *head: str) -> None:
        self.mechanism = mechanism.base
        self.sweep, self.said, self._box = case
        title, self.project, self.author, date, self.revision = head
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
        return extremes(self.sweep, self._box)

    @property
    def extremes(self) -> tuple[Extreme, ...]:
        """Greatest and least values of wrenches and efforts, joint by joint."""
        return tuple(item for item in self._found.rows if item.owner != STANDING)

    @property
    def drives(self) -> tuple[str, ...]:
        """Names of the driven coordinates."""
        names = () if self.sweep is None else self.sweep.coordinates
        return tuple(name for name in names if name != STANDING)

    @property
    def acts(self) -> bool:
        """Whether any wrench is different from zero."""
        return any(item.acts for item in self.extremes)

    @property
    def left_open(self) -> str:
        """What is not unique and why, of joints and couplings by name; empty if all is."""
        return "" if self.sweep is None else self.sweep.left_open.text

    @cached_property
    def orders(self) -> dict[tuple[str, str, str], np.ndarray]:
        """Amplitudes of orders 0 … 8 `(9,)` by owner, quantity and unit; see `no_orders`.

        Of what acts: efforts, what is along the axis of a joint, and components across it in axes
        that stand still (`moment y`, see `in_fixed_axes`). The size of a vector has other orders.
        """
        if self.sweep is None or self.no_orders:
            return {}
        return self._orders[0]

    @property
    def orders_error(self) -> float:
        """By how much orders changed at last, of the greatest, when positions were doubled."""
        return self._orders[1]

    @cached_property
    def _orders(self) -> tuple[dict[tuple[str, str, str], np.ndarray], float]:
        found = self._orders_at(8 * _HIGHEST)
        # Orders that positions are too few for appear as lower ones, until they are enough.
        for doubled in range(1, _DOUBLINGS + 1):
            coarse, found = found, self._orders_at(8 * _HIGHEST * 2**doubled)
            changes = [
                np.abs(value - coarse.get(key, 0.0)).max() / value.max()
                for key, value in found.items()
            ]
            error = max(changes, default=0.0)
            if error <= NOTHING:
                break
        for amplitudes in found.values():
            amplitudes[amplitudes <= NOTHING * amplitudes.max(initial=0.0)] = 0.0
        return found, float(error)

    def _orders_at(self, count: int) -> dict[tuple[str, str, str], np.ndarray]:
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
            elif item.name != "force" or not turn[item.owner].has_axis:
                vector = "force" if item.unit == "N" else "moment"
                for name, (values, _) in in_fixed_axes(turn, item.owner, vector).items():
                    if np.abs(values).max() > NOTHING * size[item.owner, item.name]:
                        found[item.owner, name, item.unit] = values
        angle = 2.0 * np.pi / count * np.arange(len(turn))
        return {
            key: order_amplitudes(angle, values)[1][::turns][: _HIGHEST + 1]
            for key, values in found.items()
        }

    @property
    def drawn(self) -> tuple[Sweep | None, str]:
        """What figures show, and what is to be said of it: the range, however few its samples."""
        sweep = self.sweep
        search = self._found.search
        if sweep is None or search is None:
            told = "" if sweep is None else f" Of the {counted(len(sweep))} alone."
            return sweep, told
        return (sweep if len(sweep) >= _DRAWN else search.evenly(_DRAWN, endpoint=True)), ""

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
        if self._found.search is None:
            return f"orders are not known between samples: {self._found.unknown}"
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
        return (*rows, ("condition", condition, self._judged_condition(condition)))

    def _judged_condition(self, condition: float) -> str:
        if self._near_singular:
            return self._near_singular
        zero = "wrenches pass through zero, or nearly singular configurations"
        well = "well conditioned" if condition < WELL else zero
        return f"{well}: {right(self._found.rounding)}"

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
        found = [self._found.doubt] if self.acts and self._found.unknown else []
        if told := self._near_singular:
            found.append(f"{told[0].upper()}{told[1:]}.")
        if self.sweep is not None and (told := self.sweep.near_reach):
            found.append(f"{told[0].upper()}{told[1:]}.")
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

    @property
    def covered(self) -> str:
        """What the extremes are the extremes of."""
        if self._found.search is None:
            return self._found.covered
        slides = self.mechanism.drivable[self.drives[0]].slides
        return f"the whole range from {way(*self._found.search.ends, slides, ' to ')}"

    @cached_property
    def places(self) -> np.ndarray:
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

    def at(self, places: np.ndarray, word: str = "place ") -> str:
        """Return drive positions `(n, d)` as a text: of several drives, which of the `places`."""
        if self.sweep is None or not self.drives:
            return ""
        if not len(places):
            return "throughout"
        if len(self.drives) == 1:
            slides = self.sweep.mechanism.drivable[self.drives[0]].slides
            size = float(np.abs(self.sweep.position).max())
            # Places that lie closer to each other than digits tell are named once.
            every = (place(float(value), slides, size) for value in places[:, 0])
            return ", ".join(dict.fromkeys(every))
        if told := self.task_at(places[:1]):
            return ", ".join(told)
        return f"{word}{int(np.argmax(np.all(self.places == places[0], axis=1))) + 1}"

    def task_at(self, places: np.ndarray) -> list[str]:
        """Return the rows of the task that change, at the samples that are one of drive positions.

        Args:
            places: `(1, d)`, a position of all drives.

        Returns:
            Texts such as `tip.z 1.2 m`; none without a task.
        """
        if self.sweep is None:
            return []
        positions = np.reshape(self.sweep.position, (len(self.sweep), -1))
        (found,) = np.nonzero(np.all(positions == places, axis=1))
        told = []
        for name, (values, unit) in task_rows(self.sweep).items():
            size = float(np.abs(values).max())
            if len(found) and np.ptp(values) > NOTHING * size:
                told.append(f"{name} {place(float(values[found[0]]), unit == 'm', size)}")
        return told

    def table(self) -> Table:
        """Return the extremes as a table, a row each; positions are those of the first of several.

        Columns: `owner`, `quantity`, `unit`, `greatest`, `least`, `determined`, `error` (by how
        much the quantity may exceed them; NaN where that is not known), and for every drive
        `greatest_at_NAME` and `least_at_NAME` [rad or m]: NaN where it is constant.
        """
        return table_of([self])

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
        if self.drives and not self._found.unknown:
            lines.append(f"Extremes of {self.covered}.")
        lines += [f"! {doubt}" for doubt in self.doubts]
        acting = self.told
        width = max(len(item.quantity) for item in acting)
        owner = ""
        for item in acting:
            if item.owner != owner:
                owner = item.owner
                lines.append(owner)
            mark = f"{' ' if item.settled else '?'}{' ' if item.determined else '*'}"
            (most, first), (other, last) = item.ends
            (shown, opposite), unit = column([most, other], item.unit)
            between = f"{shown:>10} {unit}"
            if len(first):
                between += f" at {self.at(first[:2])}; {opposite} at {self.at(last[:2])}"
            lines.append(f"{mark}{item.quantity.ljust(width)} {between}")
        if len(self.drives) > 1:
            lines.append("The page, and `places`, tell the positions of all drives at each place.")
        if not all(item.settled for item in acting):
            lines.append("? may be exceeded, see above")
        if self.left_open:
            lines.append(f"* {self.left_open}")
        lines += [f"{name} {value:.1e}: {text}" for name, value, text in self.judgement]
        return "\n".join(lines)

    @cached_property
    def _once(self) -> list[Extreme]:
        """The extremes of what acts, without forces and moments that a part of them tells."""
        found = []
        for item in self._acting.values():
            parts = [
                self._acting[item.owner, part]
                for part in PARTS.get(item.quantity, ())
                if (item.owner, part) in self._acting
            ]
            # What statics leaves open is told by its parts, of which it may determine some.
            is_told = any(
                part.determined > item.determined or abs(part.size - item.size) <= RIGHT * item.size
                for part in parts
            )
            if not is_told:
                found.append(item)
        return found

    @cached_property
    def _acting(self) -> dict[tuple[str, str], Extreme]:
        return {(item.owner, item.quantity): item for item in self.extremes if item.acts}

    def _is_effort(self, item: Extreme) -> bool:
        """Return whether what is along the axis of a joint is what drives or holds it."""
        if item.quantity not in ("torsion", "axial"):
            return False
        efforts = (self._acting.get((item.owner, name)) for name in EFFORTS)
        slack = RIGHT * item.size
        return any(
            effort is not None
            and abs(effort.greatest - item.greatest) <= slack
            and abs(effort.least - item.least) <= slack
            for effort in efforts
        )

    @property
    def told(self) -> list[Extreme]:
        """The extremes of what acts, each force and moment once, efforts as such."""
        return [item for item in self._once if not self._is_effort(item)]

    @property
    def headline(self) -> list[Extreme]:
        """What a joint is sized by: of each quantity that statics determines the greatest.

        A torsion, or an axial force, that is the effort of a drive is told as that.
        """
        return [item for _, item in governing([self])]

    @property
    def case_lines(self) -> list[str]:
        """What moves, how fast, and what acts, each in a few words."""
        sweep = self.sweep
        if sweep is None:
            return ["not moved"]
        lines = []
        for index, name in enumerate(self.drives):
            slides = sweep.mechanism.drivable[name].slides
            positions = np.reshape(sweep.position, (len(sweep), -1))[:, index]
            low, high = float(positions.min()), float(positions.max())
            lines.append(f"{name}{' at' * (low == high)} {way(low, high, slides)}")
            speeds = np.reshape(sweep.speed, (len(sweep), -1))[:, index]
            if np.any(speeds):
                lines.append(speed_text(speeds, slides))
        if isinstance(sweep, TaskSweep):
            # The task is what was asked for, and drives follow it.
            lines = []
            speeds = np.reshape(sweep.task_speed, (len(sweep), -1)).T
            for (name, (values, unit)), speed in zip(task_rows(sweep).items(), speeds, strict=True):
                low, high = float(values.min()), float(values.max())
                lines.append(f"{name}{' at' * (low == high)} {way(low, high, unit == 'm')}")
                lines += [speed_text(speed, unit == "m")] if np.any(speed) else []
        if len(self.drives) > 1:
            # Extremes are sought far beyond them.
            lines.append(f"at {counted(len(sweep))}")
        lines = lines or ["at rest"]
        for name, load in sweep.loads.items():
            if isinstance(load, Wrench):
                sizes = (
                    between(np.linalg.norm(np.atleast_2d(vector), axis=-1), unit)
                    for vector, unit in ((load.force, "N"), (load.moment, "N·m"))
                    if np.any(vector)
                )
                lines.append(f"{' and '.join(sizes) or 'nothing'} on {name}")
            else:
                unit = sweep.mechanism.drivable[name].effort_unit
                lines.append(f"{between(np.ravel(np.asarray(load, dtype=float)), unit)} at {name}")
        if np.any(sweep.gravity):
            lines.append("gravity")
        if sweep.elements:
            lines.append(f"{len(sweep.elements)} element{'s' * (len(sweep.elements) > 1)}")
        return lines


def task_rows(sweep: Sweep) -> dict[str, tuple[np.ndarray, str]]:
    """Return the rows of the task that a sweep follows, with positions `(N,)` and units, if any."""
    if not isinstance(sweep, TaskSweep):
        return {}
    every = np.reshape(sweep.task_position, (len(sweep), -1)).T
    units = [unit_of_row(sweep.mechanism, row) for row in sweep.rows]
    return dict(zip(sweep.rows, zip(every, units, strict=True), strict=True))


def apart(cases: Sequence[Sequence[str]]) -> tuple[list[str], list[list[str]]]:
    """Return which lines all cases have in common, and which others each of them has."""
    common = [line for line in cases[0] if all(line in lines for lines in cases)]
    return common, [[line for line in lines if line not in common] for lines in cases]


def governing(reports: Sequence[Findings]) -> list[tuple[int, Extreme]]:
    """Return of each quantity that statics determines the greatest, and in which case it is."""
    found: dict[str, tuple[int, Extreme]] = {}
    for case, report in enumerate(reports):
        for item in report._once:
            best = found.get(item.quantity)
            if item.determined and (best is None or item.size > best[1].size):
                found[item.quantity] = case, item
    efforts = {(found[name][0], found[name][1].owner) for name in EFFORTS if name in found}
    return [
        (case, item)
        for case, item in found.values()
        if (case, item.owner) not in efforts or not reports[case]._is_effort(item)
    ]


def cases_in_words(reports: Sequence[Findings]) -> str:
    """Return how many load cases there are, and what they have in common."""
    common, _ = apart([report.case_lines for report in reports])
    count = f"{len(reports)} load case{'s' * (len(reports) > 1)}"
    return f"{count}, in all of them {'; '.join(common)}" if common else count


def cases_apart(reports: Sequence[Findings], labels: Sequence[str]) -> list[str]:
    """Return of each case its label, and what it has beyond the others if that does not say so."""
    _, every = apart([report.case_lines for report in reports])
    told = [", ".join(own) or "nothing besides" for own in every]
    return [
        label if text == label or not any(every) else f"{label}: {text}"
        for label, text in zip(labels, told, strict=True)
    ]


def cases_with(
    reports: Sequence[Findings], labels: Sequence[str], governing: tuple[int, Extreme]
) -> str:
    """Return the labels of the cases in which a quantity is as great as in the one that governs."""
    case, item = governing
    found = []
    for index, (report, label) in enumerate(zip(reports, labels, strict=True)):
        same = report._acting.get((item.owner, item.quantity))
        is_same = same is not None and abs(same.size - item.size) <= RIGHT * item.size
        found += [label] if is_same or index == case else []
    return "all" if 1 < len(labels) == len(found) else ", ".join(found)


def compared(reports: Sequence[Findings]) -> list[list[Extreme | None]]:
    """Return what acts and statics determines, a row each with its extreme in every case.

    None stands where it does not act.
    """
    told = dict.fromkeys((item.owner, item.quantity) for report in reports for item in report.told)
    rows = [[report._acting.get(key) for report in reports] for key in told]
    return [row for row in rows if all(item is None or item.determined for item in row)]


def table_of(reports: Sequence[Findings], labels: Sequence[str] = ()) -> Table:
    """Return the extremes of one case, or of several with the column `case`; see `table`."""
    cases = [case for case, report in enumerate(reports) for _ in report.extremes]
    rows = [item for report in reports for item in report.extremes]
    told: list[tuple[str, list[Any], str, str]] = [
        ("owner", [item.owner for item in rows], "", "joint, drive, coupling or element"),
        ("quantity", [item.quantity for item in rows], "", "what it is"),
        ("unit", [item.unit for item in rows], "", "of greatest and least"),
        ("greatest", [item.greatest for item in rows], "", "greatest value"),
        ("least", [item.least for item in rows], "", "least value"),
        ("determined", [item.determined for item in rows], "", "by the laws of motion alone"),
        ("error", [item.error for item in rows], "", "by how much it may exceed them"),
    ]
    if labels:
        told.insert(0, ("case", [labels[case] for case in cases], "", "load case"))
    mechanism = reports[0].mechanism
    for name in dict.fromkeys(name for report in reports for name in report.drives):
        for end in ("greatest", "least"):
            values = []
            for case, item in zip(cases, rows, strict=True):
                places, drives = getattr(item, f"{end}_at"), reports[case].drives
                is_known = len(places) and name in drives
                values.append(places[0, drives.index(name)] if is_known else np.nan)
            unit = mechanism.drivable[name].unit
            told.append((f"{end}_at_{name}", values, unit, f"position of {name} there"))
    return Table(
        [
            (name, Variable(("row",), np.array(values), unit, text))
            for name, values, unit, text in told
        ],
        {"row": len(rows)},
        attributes={
            "mechanism": mechanism.name,
            "sha256": reports[0].sha256,
            "cardan_dyn_version": __version__,
        },
    )


def speed_text(values: np.ndarray, slides: bool) -> str:
    """Return speeds of a drive [rad/s or m/s] as a text, of what turns in 1/min."""
    return between(values if slides else values * 30.0 / np.pi, "m/s" if slides else "1/min")


def between(values: np.ndarray, unit: str = "") -> str:
    """Return a number that all values have, or their range, with its unit."""
    return span(float(values.min()), float(values.max()), unit)


EFFORTS = ("drive effort", "holding effort")
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
    if value <= GOOD:
        return f"{what} to rounding"
    if value <= POOR:
        return f"{what}; good, with some digits lost"
    return f"{what}; near the limit of 1e-8: look at the condition"
