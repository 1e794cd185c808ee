"""Plot: responses draw the sweeps that they are evaluated to."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...kit.errors import ArgumentError
from ..results.plot import MotionPlot

if TYPE_CHECKING:
    from ...figures.style import Figure

_ASKED = ("position", "speed", "acceleration", "loads", "gravity")
"""Arguments of `Response.sweep`, which figures take as well."""
_MOST_DESIGNS = 8
"""Designs that are drawn: as many as there are styles of lines."""


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

        Of designs, one joint or column, a line per design.

        Args:
            columns: see `Sweep.plot`.
            options: arguments of `Response.sweep`, and of `Sweep.plot`.

        Raises:
            ArgumentError: as both; or of designs, other than one name, or more of them than lines
                can show.
        """
        response, figure = self._response, None
        if not response.shape:
            return self._drawn("__call__", columns, options)
        designs = list(np.ndindex(*response.shape))
        if len(columns) != 1:
            raise ArgumentError("name one joint or column, of which each design is a line")
        if len(designs) > _MOST_DESIGNS:
            raise ArgumentError(
                f"{len(designs)} designs are more lines than one tells apart: draw some of them, "
                "as in response[0].plot(…)"
            )
        options = {"peaks": False, **options}
        for index in designs:
            figure = response[index].plot(*columns, label=self._design(index), **options)
            options = {
                name: item for name, item in options.items() if name not in ("title", "figsize")
            }
            options.setdefault("ax", figure.axes)
        return figure

    def polar(
        self,
        joints: str | Sequence[str] = (),
        frames: str | Sequence[str] = "parent",
        **options: Any,
    ) -> Figure:
        """Draw polar diagrams, see `Sweep.plot.polar`; `options` as for `plot`."""
        return self._drawn("polar", (joints, frames), options)

    def orders(self, *columns: str, **options: Any) -> Figure:
        """Draw amplitudes over orders, see `Sweep.plot.orders`; `options` as for `plot`."""
        return self._drawn("orders", columns, options)

    def ratio(self, output: str, **options: Any) -> Figure:
        """Draw speed ratio and angle error, see `Sweep.plot.ratio`; `options` as for `plot`."""
        return self._drawn("ratio", (output,), options)

    def __repr__(self) -> str:
        return "<Figures of a Response: plot(), plot.polar, plot.orders, plot.ratio>"

    def _drawn(self, figure: str, given: Sequence[Any], options: Mapping[str, Any]) -> Figure:
        """Return a figure of the sweep; options are those of both."""
        asked = {name: value for name, value in options.items() if name in _ASKED}
        rest = {name: value for name, value in options.items() if name not in _ASKED}
        asked.setdefault("position", np.linspace(*self._ends, 361))
        drawn: Figure = getattr(MotionPlot(self._response.sweep(**asked)), figure)(*given, **rest)
        return drawn

    def _design(self, index: tuple[int, ...]) -> str:
        """Return the held positions of a design, in words."""
        response, told = self._response, []
        drivable = response.solver.problem.mechanism.drivable
        for name, values in response.held.items():
            if np.ndim(values):
                value = float(np.broadcast_to(values, response.shape)[index])
                size = f"{value:.4g} m" if drivable[name].slides else f"{math.degrees(value):.4g}°"
                told.append(f"{name} {size}")
        return ", ".join(told) or "all designs"
