"""Plot: responses draw the sweeps that they are evaluated to."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ArgumentError
from ..results.plot import MotionPlot

if TYPE_CHECKING:
    from ..figures.style import Figure
    from ..results.sweep import Sweep

_COUNT = 361
"""Positions at which a response is evaluated: every degree of a turn."""
_ASKED = ("position", "speed", "acceleration", "loads", "gravity")
"""Arguments of `Response.sweep`, which figures take as well."""
_MOST_DESIGNS = 8
"""Designs of a family that are drawn: as many as there are styles of lines."""


class ResponsePlot:
    """Draws a response: `response.plot("bearing_out", speed=3.0)`.

    It is evaluated over a period, or over its interval, unless positions are given. All figures are
    those of a sweep (`Sweep.plot`), and take the arguments of `Response.sweep` besides theirs.

    Args:
        response: that is drawn.
        low: first position at which it is evaluated [rad or m].
        high: last one, a period or the interval further.
    """

    def __init__(self, response: Any, low: float, high: float) -> None:
        self._response, self._ends = response, (low, high)

    def __call__(self, *columns: Any, **options: Any) -> Figure:
        """Draw wrenches of joints, or columns, over the drive's position; see `Sweep.plot`.

        Args:
            columns: see `Sweep.plot`.
            options: arguments of `Response.sweep`, and of `Sweep.plot`.

        Raises:
            ArgumentError: as both.
        """
        swept, rest = self._evaluated(options)
        return MotionPlot(swept)(*columns, **rest)

    def polar(
        self,
        joints: str | Sequence[str] = (),
        frames: str | Sequence[str] = "parent",
        **options: Any,
    ) -> Figure:
        """Draw polar diagrams, see `Sweep.plot.polar`; `options` as for `plot`."""
        swept, rest = self._evaluated(options)
        return MotionPlot(swept).polar(joints, frames, **rest)

    def orders(self, *columns: str, **options: Any) -> Figure:
        """Draw amplitudes over orders, see `Sweep.plot.orders`; `options` as for `plot`."""
        swept, rest = self._evaluated(options)
        return MotionPlot(swept).orders(*columns, **rest)

    def ratio(self, output: str, **options: Any) -> Figure:
        """Draw speed ratio and angle error, see `Sweep.plot.ratio`; `options` as for `plot`."""
        swept, rest = self._evaluated(options)
        return MotionPlot(swept).ratio(output, **rest)

    def __repr__(self) -> str:
        return "<Figures of a Response: plot(), plot.polar, plot.orders, plot.ratio>"

    def _evaluated(self, options: Mapping[str, Any]) -> tuple[Sweep, dict[str, Any]]:
        """Return the sweep that is drawn, and the options of the figure."""
        asked = {name: value for name, value in options.items() if name in _ASKED}
        rest = {name: value for name, value in options.items() if name not in _ASKED}
        asked.setdefault("position", np.linspace(*self._ends, _COUNT))
        return self._response.sweep(**asked), rest


class FamilyPlot:
    """Draws the responses of designs: `family.plot("bearing_out.bending", speed=3.0)`.

    Args:
        family: that is drawn.
    """

    def __init__(self, family: Any) -> None:
        self._family = family

    def __call__(self, *columns: Any, title: str = "", **options: Any) -> Figure:
        """Draw wrenches of a joint, or a column, over the drive's position, a line per design.

        Args:
            columns: one joint or column, see `Sweep.plot`.
            title: of the figure.
            options: arguments of `Response.sweep`, and of `Sweep.plot`.

        Raises:
            ArgumentError: other than one name, more designs than lines can show, or as both.
        """
        family = self._family
        designs = list(np.ndindex(*family.shape))
        if len(columns) != 1:
            raise ArgumentError("name one joint or column, of which each design is a line")
        if len(designs) > _MOST_DESIGNS:
            raise ArgumentError(
                f"{len(designs)} designs are more lines than one tells apart: draw some of them, "
                "as in family[0].plot(…)"
            )
        figure: Any = None
        for index in designs:
            label = self._design(index)
            if figure is None:
                figure = family[index].plot(
                    *columns, title=title, label=label, **{"peaks": False, **options}
                )
            else:
                panels = {"ax": options.get("ax", figure.axes)}
                rest = {name: item for name, item in options.items() if name != "figsize"}
                family[index].plot(*columns, label=label, **{"peaks": False, **rest, **panels})
        return figure

    def __repr__(self) -> str:
        return "<Figures of a ResponseFamily: plot(NAME)>"

    def _design(self, index: tuple[int, ...]) -> str:
        """Return the held positions of a design, in words."""
        family = self._family
        told = []
        for name, values in family.held.items():
            if np.ndim(values):
                value = float(np.broadcast_to(values, family.shape)[index])
                slides = family[index].solver.problem.mechanism.drivable[name].slides
                told.append(
                    f"{name} {value:.4g} m" if slides else f"{name} {math.degrees(value):.4g}°"
                )
        return ", ".join(told) or "all designs"
