"""Cases: findings of one load case or of several side by side, and which of them governs."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ..._version import __version__
from ...core.results.result import Result
from ...core.results.table import Table, Variable
from ...figures.wrenches import PARTS, together
from ...kit.errors import ArgumentError
from ...kit.frozen import Frozen
from ...kit.quantities import column
from .extremes import RIGHT, Extreme, counted
from .findings import Findings
from .grids import Grid


class Cases(Result, Frozen):
    """Findings of a mechanism in one load case or in several.

    Attributes:
        reports: findings of each.
        labels: their names; none of a case that stands alone.
    """

    def __init__(self, reports: Sequence[Findings], labels: Sequence[str]) -> None:
        self.reports, self.labels = tuple(reports), tuple(labels)
        self._freeze()

    @cached_property
    def governing(self) -> list[tuple[int, Extreme]]:
        """Of each quantity that statics determines the greatest, behind the index of its case."""
        found: dict[str, tuple[int, Extreme]] = {}
        most: dict[str, float] = {"N": 0.0, "N·m": 0.0}
        for case, report in enumerate(self.reports):
            for item in filter(lambda one: one.determined, report.told):
                best = found.get(item.quantity)
                most[item.unit] = max(most.get(item.unit, 0.0), item.size)
                if best is None or item.size > best[1].size:
                    found[item.quantity] = case, item
        length = self.reports[0].mechanism.characteristic_length
        most |= together(most["N"], most["N·m"], length)
        acting = [item for report in self.reports for item in report.acting.values()]
        for whole, parts in PARTS.items():
            # A force is the greatest if no other one is greater, nor a part of one.
            every = (of.size for of in acting if of.determined and of.quantity in (whole, *parts))
            if whole in found and found[whole][1].size < max(every) * (1.0 - RIGHT):
                del found[whole]
        # What is 0 in the digits of the greatest sizes nothing.
        return [of for of in found.values() if float(column([of[1].size, most[of[1].unit]])[0][0])]

    @property
    def in_words(self) -> str:
        """How many load cases there are, and what they have in common."""
        common, _ = _apart(self.reports)
        shared = f", in all of them {'; '.join(common)}" if common else ""
        return f"{counted(len(self.reports), 'load case')}{shared}"

    @property
    def remarks(self) -> list[str]:
        """Of what joints are sized by, about which point it is where that is not fixed."""
        every = self.reports[0].mechanism.description.joints_and_loops
        sliding = [item.name for item in every if item.type in ("prismatic", "cylindrical")]
        return [
            f"Bending of {item.owner} is that about the joint's origin, which "
            "slides with the child; about other points, as where it is guided, it is another one."
            for _, item in self.governing
            if item.owner in sliding and item.quantity == "bending"
        ]

    @property
    def told_apart(self) -> list[str]:
        """Of each case its label, and what it has beyond the others if that does not say so."""
        every = told_apart(self.reports)
        return [
            label if not text or text == label else f"{label}: {text}"
            for label, text in zip(self.labels, every, strict=True)
        ]

    def sharing(self, case: int, item: Extreme) -> str:
        """Return the labels of the cases in which a quantity is as great as in one of them."""
        found = []
        for index, report in enumerate(self.reports):
            same = report.acting.get((item.owner, item.quantity))
            is_same = same is not None and abs(same.size - item.size) <= RIGHT * item.size
            found += [self.labels[index]] if is_same or index == case else []
        return "all" if 1 < len(self.labels) == len(found) else ", ".join(found)

    @property
    def compared(self) -> list[tuple[str, str, str, list[float]]]:
        """What acts and statics determines: owner, quantity, unit, greatest in size by case."""
        found = {}
        told = ((one.owner, one.quantity) for report in self.reports for one in report.told)
        for key in dict.fromkeys(told):
            row = [report.acting.get(key) for report in self.reports]
            known = [item for item in row if item is not None]
            if all(item.determined for item in known):
                sizes = [item.ends[0][0] if item else 0.0 for item in row]
                found[key] = known[0].unit, sizes
        return [(*key, *of) for key, of in found.items()]

    @property
    def sized(self) -> Grid:
        """How big what joints are sized by is, where, and in which of several cases."""
        rows = []
        for case, item in self.governing:
            (most, at), _ = item.ends
            row = (item.marked, item.unit, most, item.owner, self.reports[case].at(at))
            rows.append((*row, self.sharing(case, item)) if self.labels else row)
        header = ("quantity", "unit", "greatest in size", "in", "at", "load case")
        told = header if self.labels else header[:-1]
        return Grid("headline", "What joints are sized by", told, rows, unit=1)

    def beside(self, first: int = 0, most: int | None = None) -> Grid:
        """Return what joints carry in so many cases beside each other, which have numbers."""
        numbers = [str(index) for index in range(1, len(self.labels) + 1)] or ["greatest in size"]
        part = slice(first, None if most is None else first + most)
        rows = [(*of, *sizes[part]) for *of, sizes in self.compared]
        caption = f"Greatest in size{', by load case' * bool(self.labels)}"
        header = ("of", "quantity", "unit", *numbers[part])
        return Grid(f"load_cases_{first + 1}", caption, header, rows, unit=2)

    def table(self) -> Table:
        """Return the extremes of all cases, a row each; see `Report.table`."""
        cases = [case for case, report in enumerate(self.reports) for _ in report.extremes]
        rows = [item for report in self.reports for item in report.extremes]
        fields = {
            "owner": "joint, drive, coupling or element",
            "quantity": "what it is",
            "unit": "of greatest and least",
            "greatest": "greatest value",
            "least": "least value",
            "determined": "by the laws of motion alone",
            "error": "by how much it may exceed them",
        }
        told: list[tuple[str, list[Any], str, str]] = [
            (name, [getattr(item, name) for item in rows], "", text)
            for name, text in fields.items()
        ]
        if self.labels:
            told.insert(0, ("case", [self.labels[case] for case in cases], "", "load case"))
        units = {
            name: item.unit
            for report in self.reports
            if report.sweep is not None
            for name, item in report.sweep.mechanism.drivable.items()
        }
        for name in dict.fromkeys(name for report in self.reports for name in report.over):
            for end in ("greatest", "least"):
                values = []
                for case, item in zip(cases, rows, strict=True):
                    places, over = getattr(item, f"{end}_at"), self.reports[case].over
                    is_known = len(places) and name in over
                    values.append(places[0, over.index(name)] if is_known else np.nan)
                unit = "s" if name == "time" else units[name]
                told.append((f"{end}_at_{name}", values, unit, f"position of {name} there"))
        return Table(
            [
                (name, Variable(("row",), np.array(values), unit, text))
                for name, values, unit, text in told
            ],
            {"row": len(rows)},
            attributes={
                "mechanism": self.reports[0].mechanism.name,
                "sha256": self.reports[0].sha256,
                "cardan_dyn_version": __version__,
            },
        )

    def __repr__(self) -> str:
        name = self.reports[0].mechanism.name
        count = counted(len(self.reports), "load case")
        return f"<{type(self).__name__} of {name!r}: {count}>"

    def __str__(self) -> str:
        lines = [f"{self.reports[0].title}: {self.in_words}"]
        for index, (text, report) in enumerate(zip(self.told_apart, self.reports, strict=True), 1):
            lines.append(f"{index}: {text}")
            lines += [f"   ! {doubt}" for doubt in report.beware]
        lines += [str(self.sized), *self.remarks, "", str(self.beside())]
        # Beside each other stands only what statics determines.
        told = "; all that is tabled is determined" * bool(self.compared)
        opened = (f"{report.left_open}{told}" for report in self.reports if report.left_open)
        return "\n".join([*lines, *dict.fromkeys(opened)])


def told_apart(reports: Sequence[Findings]) -> list[str]:
    """Return of each case what not all of them have in common; nothing where that is nothing."""
    _, every = _apart(reports)
    of_others = "; ".join(dict.fromkeys(line for own in every for line in own))
    return [", ".join(own) or (f"without {of_others}" if of_others else "") for own in every]


def labels_of(reports: Sequence[Findings], given: Sequence[str]) -> tuple[str, ...]:
    """Return the names of cases: as given, or by what tells them apart, or their numbers.

    Raises:
        ArgumentError: they are not as many as the cases, or the same.
    """
    labels = tuple(given) or tuple(told_apart(reports))
    if not given and ("" in labels or len(set(labels)) < len(labels)):
        labels = tuple(f"case {index}" for index in range(1, len(reports) + 1))
    if len(labels) != len(reports) or len(set(labels)) < len(labels):
        raise ArgumentError(
            f"labels are {list(labels)}, expected one of its own for each of "
            f"{len(reports)} load cases"
        )
    return labels


def _apart(reports: Sequence[Findings]) -> tuple[list[str], list[list[str]]]:
    """Return which lines all cases have in common, and which others each of them has."""
    cases = [report.case_lines for report in reports]
    common = [line for line in cases[0] if all(line in lines for lines in cases)]
    return common, [[line for line in lines if line not in common] for lines in cases]
