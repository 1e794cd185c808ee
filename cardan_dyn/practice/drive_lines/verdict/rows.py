"""Verdict rows: what one rule says of one place of a drive line."""

from __future__ import annotations

import math
from dataclasses import KW_ONLY, dataclass, replace
from typing import NamedTuple

from cardan_dyn.analytic.limits import Limit
from cardan_dyn.analytic.rules import RULES

from ....kit.arrays import NOTHING
from ....kit.quantities import amount, cleared
from ..wording import BY_UNIT, Wording

PASS, FAIL, OPEN, STATED = "pass", "fail", "open", "stated"


class Inverse(NamedTuple):
    """What an input of a rule would have to be to meet its limit exactly.

    Attributes:
        what: its name.
        value: in SI units.
        unit: of the value, as in `analytic.limits`.
    """

    what: str
    value: float
    unit: str

    def __str__(self) -> str:
        return self.told()

    def told(self, units: str = "si") -> str:
        """Return it in words, in a system of units of `Wording`."""
        return f"{self.what} {as_text(self.value, self.unit, units)}"


@dataclass(frozen=True)
class VerdictRow:
    """What a rule says of a place of a line.

    Attributes:
        rule: key in `analytic.rules.RULES`.
        where: name of the shaft, joint, bearing or spline; empty for the whole line.
        quantity: what is judged.
        value: exact, by the analysis or composed closed forms; None if it is not known.
        unit: of all values, as in `analytic.limits`: SI and radians.
        rule_value: what the rule of practice gives instead; None if it is the exact value.
        limit: what the value is held against; None if it is stated alone.
        condition: operating point at which the value was found.
        status: `pass`, `fail`, `open` (the rule applies and nobody can tell: the note says why, and
            what to give) or `stated` (there is no limit, or the rule does not apply).
        source: of the limit, or of the rule if there is none.
        broken: assumptions of the rule that do not hold for this line, and what that means.
        inverses: what inputs would meet the limit.
        note: what is missing, or what the value stands for.
    """

    rule: str
    where: str
    quantity: str
    _: KW_ONLY
    value: float | None = None
    unit: str = "1"
    rule_value: float | None = None
    limit: Limit | None = None
    condition: str = ""
    status: str = STATED
    source: str = ""
    broken: tuple[str, ...] = ()
    inverses: tuple[Inverse, ...] = ()
    note: str = ""

    @property
    def margin(self) -> float | None:
        """Room to the limit relative to it, negative if it is missed; None without both.

        From a limit of 0 nothing is relative: then it is the room itself, in SI units.
        """
        if self.value is None or self.limit is None:
            return None
        size = abs(self.limit.value) or 1.0
        room = self.limit.value - self.value
        return (-room if self.limit.bound == "least" else room) / size

    def remarks(self, units: str = "si") -> tuple[str, ...]:
        """Inverses, the note and the broken assumptions, which begin with an exclamation mark."""
        listed = [self.note, *(f"! {text}" for text in self.broken)]
        if units != "si":
            listed = [Wording(units=units).sentence(text) for text in listed]
        return tuple(filter(None, [*(item.told(units) for item in self.inverses), *listed]))

    def texts(self, units: str = "si") -> tuple[str, ...]:
        """What tables show of it, in the units that engineers use, of a system of `Wording`."""

        def shown(value: float | None) -> str:
            return "" if value is None else as_text(value, self.unit, units)

        margin, is_zero = self.margin, self.limit is not None and self.limit.value == 0.0
        room = "" if margin is None else f"{100.0 * margin:+.0f} %"
        # More may act than the values of open rows are of, so that they have no room.
        if self.status == OPEN:
            room = ""
        elif margin is not None and is_zero:
            room = "+" * (margin >= 0.0) + shown(margin)
        bound = "" if self.limit is None else {"least": "≥ "}.get(self.limit.bound, "≤ ")
        return (
            RULES[self.rule].title,
            self.where,
            self.quantity,
            shown(self.value),
            shown(self.rule_value),
            bound + shown(None if self.limit is None else self.limit.value),
            room,
            self.status,
            self.condition,
            self.source,
            "; ".join(self.remarks(units)),
        )


HEADINGS = (
    "rule",
    "where",
    "quantity",
    "value",
    "by the rule",
    "limit",
    "margin",
    "verdict",
    "at",
    "source of the limit",
    "remarks",
)
"""Of `VerdictRow.texts`."""


def judged(row: VerdictRow, limit: Limit | None, missing: str) -> VerdictRow:
    """Return a row held against a limit; an open one without it.

    Args:
        row: with its value.
        limit: None if there is none.
        missing: what would give the limit.
    """
    if limit is None:
        return opened(row, missing)
    held = replace(row, limit=limit, source=limit.source)
    margin = held.margin
    if margin is None or math.isnan(margin):
        return opened(held, "it has no value")
    return replace(held, status=PASS if margin >= -NOTHING else FAIL)


def opened(row: VerdictRow, reason: str) -> VerdictRow:
    """Return a row of which nobody can tell whether it passes; the reason says what to give."""
    return replace(stated(row, reason), status=OPEN)


def withheld(row: VerdictRow, reason: str) -> VerdictRow:
    """Return a row that passes nothing while more may act; what fails does so anyway."""
    return opened(row, reason) if reason and row.status == PASS else row


def stated(row: VerdictRow, reason: str = "") -> VerdictRow:
    """Return a row that counts for nothing, and why the rule does not apply, if that is so."""
    note = "; ".join(filter(None, [row.note, reason]))
    return replace(row, note=note, source=row.source or RULES[row.rule].source)


def as_text(value: float, unit: str, units: str = "si") -> str:
    """Return a value of SI units in the unit that engineers use, of a system of `Wording`.

    As on pages, what is rounding beside one of these units is 0.
    """
    measure = Wording(units=units).measure(BY_UNIT[unit])
    return amount(cleared(value * measure.factor), measure.unit)
