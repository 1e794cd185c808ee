"""Prefixes: numbers along an axis in the unit that makes them short, whatever it comes to show."""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.ticker import ScalarFormatter

from ..kit.quantities import prefix, unit_of


class _Label(NamedTuple):
    """A label of an axis: what was written, and of which quantity in which unit of the SI."""

    text: str
    head: str
    unit: str

    @property
    def shown(self) -> str:
        """Unit of the numbers."""
        return self.text[len(self.head) :].strip("[]") if self.unit else ""

    def within(self, unit: str) -> _Label:
        """Return it with a unit of its numbers."""
        return self._replace(text=f"{self.head}[{unit}]") if unit else self


class PrefixFormatter(ScalarFormatter):
    """Writes numbers of a linear axis in kN, mm, ms, and says so in its label.

    The prefix follows what is seen: further lines, other limits, axes that share theirs. Where a
    label has no unit that takes one, numbers are written as they are drawn.
    """

    def __init__(self) -> None:
        super().__init__(useOffset=False)
        self._labels: dict[Any, _Label] = {}
        self._usual = matplotlib.rcParams["axes.formatter.limits"]
        self._exponent = 0

    @classmethod
    def of(cls, panel: Any, axis: Any) -> None:
        """Let it write numbers of an axis, if its scale is linear and nothing else writes them."""
        formatter = axis.get_major_formatter()
        if axis.get_scale() != "linear" or type(formatter) not in (ScalarFormatter, cls):
            return
        if not isinstance(formatter, cls):
            formatter = cls()
            axis.set_major_formatter(formatter)
        if axis not in formatter._labels:
            formatter._labels[axis] = _Label("", "", "")
            # Another scale brings another formatter, and other limits. Of methods axes only hold
            # weak references, and these would end with the formatter.
            panel.callbacks.connect(f"{axis.axis_name}lim_changed", partial(cls.follow, formatter))
        formatter.follow()

    def follow(self, *_: Any) -> None:
        """Write labels as it befits what axes show."""
        known: dict[Any, _Label] = {}
        for axis, former in self._labels.items():
            text = axis.get_label_text()
            unit = unit_of(text)[1]
            if text != former.text:
                if unit and unit == former.shown:
                    return  # Other words for the numbers as they are.
                former = _Label(text, text.removesuffix(f"[{unit}]"), unit)
            known[axis] = former
        # An axis without a label is told by those that share its numbers.
        named = {axis: label for axis, label in known.items() if label.text}
        if any(axis.get_major_formatter() is not self for axis in known):
            self._labels = {}
            for axis, label in named.items():
                axis.set_label_text(label.within(label.unit).text)
        if not self._labels:
            return
        size = max(float(np.max(np.abs(axis.get_view_interval()))) for axis in known)
        scales = {prefix(size, label.unit)[0] for label in named.values()}
        scale = scales.pop() if len(scales) == 1 else 1.0
        self._exponent = round(np.log10(scale))
        self.set_powerlimits((self._exponent,) * 2 if self._exponent else self._usual)
        for axis, label in named.items():
            unit = prefix(size, label.unit)[1] if self._exponent else label.unit
            known[axis] = label.within(unit)
            axis.set_label_text(known[axis].text)
        self._labels = known

    def set_locs(self, locs: Any) -> None:
        """Take the places of ticks, which are known when an axis is drawn."""
        self.follow()
        super().set_locs(locs)

    def get_offset(self) -> str:
        """Return what is written at the end of the axis: nothing where the label tells it."""
        return "" if self._exponent else str(super().get_offset())
