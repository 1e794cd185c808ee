"""Findings: what a report tells of a mechanism in one case, as numbers and text."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from .._version import __version__
from ..errors import ArgumentError
from ..figures.orders import order_amplitudes
from ..frozen import Frozen
from ..mechanism.mechanism import Mechanism
from ..results.result import Result
from ..results.table import Table, Variable
from ..scene.describe import describe
from ..scene.mechanism_report import MechanismReport
from .case import STANDING, Case
from .described import fingerprint
from .extremes import Extreme, extremes
from .grids import number, place
from .page import today

_HIGHEST = 8
"""Greatest order that is listed."""
_LEAST_ORDER = 1e-9
"""Amplitudes up to this part of the greatest of a quantity are what rounding leaves of none."""
_WIDTH = 10
"""Width of a column of numbers in a text."""
_MOST_DIGITS = 15
FEW_DIGITS = 7
"""Right digits of the greatest wrenches from which on six can be shown without a word."""
_WELL = 1e6
"""Condition number up to which nothing has to be said: ten digits are right."""
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
        self.sweep, self.said = case
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
    def extremes(self) -> tuple[Extreme, ...]:
        """Greatest and least values of wrenches and efforts, joint by joint."""
        if self.sweep is None:
            return ()
        return tuple(item for item in extremes(self.sweep) if item.owner != STANDING)

    @property
    def drives(self) -> tuple[str, ...]:
        """Names of the driven coordinates."""
        names = () if self.sweep is None else self.sweep.coordinates
        return tuple(name for name in names if name != STANDING)

    @property
    def acts(self) -> bool:
        """Whether any wrench is different from zero."""
        return any(item.acts for item in self.extremes)

    @cached_property
    def chosen(self) -> tuple[str, ...]:
        """What statics leaves open and a rule chooses: joints with components, and couplings."""
        return () if self.sweep is None else tuple(self.sweep.left_open.rows)

    @cached_property
    def silent(self) -> str:
        """Which couplings do not say how they press on their joints; empty if none."""
        return "" if self.sweep is None else self.sweep.left_open.told

    @cached_property
    def orders(self) -> dict[tuple[str, str, str], np.ndarray]:
        """Amplitudes of orders 0 … 8 `(9,)` by owner, quantity and unit; see `no_orders`.

        Of quantities that act; of sizes (`force`, `shear`, `bending`) as of others.
        """
        if self.sweep is None or self.no_orders:
            return {}
        from .extremes import quantities_of

        angle, found = np.ravel(self.sweep.position), {}
        acting = {(item.owner, item.quantity) for item in self.extremes if item.acts}
        for item in quantities_of(self.sweep):
            if (item.owner, item.name) in acting:
                _, amplitudes = _whole_orders(angle, item.values(self.sweep))
                amplitudes[amplitudes <= _LEAST_ORDER * amplitudes.max(initial=0.0)] = 0.0
                found[item.owner, item.name, item.unit] = amplitudes
        return found

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
        try:
            _whole_orders(np.ravel(sweep.position), np.zeros(len(sweep)))
        except ArgumentError as error:
            return str(error)
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
        return (*rows, ("condition", condition, _digits(condition, self.digits)))

    @cached_property
    def digits(self) -> int:
        """How many digits of the greatest wrenches are right, by the condition where they are."""
        if self.sweep is None or not self.acts:
            return _MOST_DIGITS
        length, each = self.mechanism.characteristic_length, []
        for wrench in self.sweep.values():
            force, moment = (np.linalg.norm(v, axis=-1) for v in (wrench.force, wrench.moment))
            each.append(np.maximum(force * length, moment))
        sizes = np.max(each, axis=0, initial=0.0)
        condition = np.where(np.isfinite(self.sweep.condition), self.sweep.condition, np.inf)
        # Where wrenches vanish, their condition says nothing of the greatest.
        with np.errstate(invalid="ignore"):
            rounding = np.nan_to_num(condition * sizes, nan=0.0, posinf=np.inf).max(initial=0.0)
        greatest = float(sizes.max(initial=0.0))
        if not greatest:
            return _MOST_DIGITS
        part = float(np.finfo(float).eps) * max(1.0, float(rounding) / greatest)
        return int(np.clip(-np.log10(part), 0, _MOST_DIGITS))

    @property
    def doubt(self) -> str:
        """What to think of wrenches of which few digits are right; empty where many are."""
        if self.digits >= FEW_DIGITS:
            return ""
        return (
            f"Only some {self.digits} digits of the greatest wrenches are right: the mechanism is "
            "close to a singular configuration, or loops nearly depend on each other, as where "
            "dimensions are written with few digits. What is greatest follows from small "
            "differences of these."
        )

    def has_axis(self, joint: str) -> bool:
        """Return whether a joint of the sweep has an axis."""
        return self.sweep is not None and self.sweep[joint].has_axis

    def at(self, places: np.ndarray) -> str:
        """Return drive positions `(n, d)` as a text: of several drives, the numbers of samples."""
        if self.sweep is None or not self.drives:
            return ""
        if not len(places):
            return "throughout"
        if len(self.drives) == 1:
            slides = self.sweep.mechanism.drivable[self.drives[0]].slides
            return ", ".join(place(float(value), slides) for value in places[:, 0])
        every = self.sweep.position
        numbers = [int(np.argmax(np.all(every == row, axis=1))) for row in places]
        return f"sample {', '.join(map(str, numbers[:4]))}"

    def table(self) -> Table:
        """Return the extremes as a table, a row each; positions are those of the first of several.

        Columns: `owner`, `quantity`, `unit`, `greatest`, `least`, `determined`, and for every drive
        `greatest_at_NAME` and `least_at_NAME` [rad or m]: NaN where it is constant.
        """
        rows = self.extremes
        told: list[tuple[str, Any, str, str]] = [
            ("owner", [item.owner for item in rows], "", "joint, drive, coupling or element"),
            ("quantity", [item.quantity for item in rows], "", "what it is"),
            ("unit", [item.unit for item in rows], "", "of greatest and least"),
            ("greatest", [item.greatest for item in rows], "", "greatest value"),
            ("least", [item.least for item in rows], "", "least value"),
            ("determined", [item.determined for item in rows], "", "by the laws of motion alone"),
        ]
        for index, name in enumerate(self.drives):
            unit = self.mechanism.drivable[name].unit
            for end in ("greatest", "least"):
                every = [getattr(item, f"{end}_at") for item in rows]
                values = [places[0, index] if len(places) else np.nan for places in every]
                told.append((f"{end}_at_{name}", values, unit, f"position of {name} there"))
        variables = [
            (name, Variable(("row",), np.array(values), unit, text))
            for name, values, unit, text in told
        ]
        return Table(
            variables,
            {"row": len(rows)},
            attributes={
                "mechanism": self.mechanism.name,
                "sha256": self.sha256,
                "cardan_dyn_version": __version__,
            },
        )

    def __repr__(self) -> str:
        count = 0 if self.sweep is None else len(self.sweep)
        return f"<{type(self).__name__} of {self.mechanism.name!r}: {count} samples>"

    def __str__(self) -> str:
        lines = [f"{self.title}: {', '.join(self.case_lines)}", *self.said]
        if self.sweep is None:
            return "\n".join(lines)
        if not self.acts:
            return "\n".join([*lines, "Nothing acts: no load, weight, inertia or element."])
        acting = [item for item in self.extremes if item.acts]
        width = max(len(item.quantity) for item in acting)
        owner = ""
        for item in acting:
            if item.owner != owner:
                owner = item.owner
                lines.append(owner)
            mark = " " if item.determined else "*"
            up, down = number(item.greatest), number(item.least)
            first, last = self.at(item.greatest_at[:2]), self.at(item.least_at[:2])
            between = f"{up:>{_WIDTH}} {item.unit}"
            if len(item.greatest_at):
                between += f" at {first}; {down} at {last}"
            lines.append(f" {mark}{item.quantity.ljust(width)} {between}")
        if self.digits < FEW_DIGITS:
            lines.append(f"! {self.doubt}")
        if self.chosen:
            lines.append(f"* not determined by statics, chosen by {self.sweep.rule}")
        if self.silent:
            lines.append(f"* {self.silent}")
        lines += [f"{name} {value:.1e}: {text}" for name, value, text in self.judgement]
        return "\n".join(lines)

    @property
    def case_lines(self) -> list[str]:
        """What moves, how fast, and what acts, each in a few words."""
        sweep = self.sweep
        if sweep is None:
            return ["not moved"]
        lines = []
        for index, name in enumerate(self.drives):
            slides = sweep.mechanism.drivable[name].slides
            way = np.reshape(sweep.position, (len(sweep), -1))[:, index]
            low, high = place(float(way.min()), slides), place(float(way.max()), slides)
            lines.append(f"{name} at {low}" if low == high else f"{name} {low} … {high}")
        return lines or ["at rest"]


def _whole_orders(angle: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return orders and amplitudes `(9,)` of whole orders up to the highest one."""
    orders, amplitudes = order_amplitudes(angle, values)
    whole = np.arange(_HIGHEST + 1)
    found = np.zeros(len(whole))
    for order, amplitude in zip(orders, amplitudes, strict=True):
        nearest = round(float(order))
        if nearest <= _HIGHEST and abs(float(order) - nearest) < 1e-9:
            found[nearest] = amplitude
    return whole, found


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


def _digits(condition: float, digits: int) -> str:
    """Return what a condition number means."""
    right = f"some {digits} digits of the greatest wrenches are right"
    if digits < FEW_DIGITS:
        return (
            f"close to a singular configuration, or loops that nearly depend on each other: {right}"
        )
    if condition < _WELL:
        return f"well conditioned: {right}"
    return f"wrenches pass through zero, or nearly singular configurations: {right}"
