"""Figures of a drive line's page: what moves and acts over a turn, and its orders."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...drive_lines import Analysis
from ...figures.orders import draw_bars
from ...figures.style import Abscissa, Axes, Figure, Sheet, in_look, sheet
from ...kit.arrays import NOTHING, Array
from ...kit.periodic import amplitudes
from ..drive_lines.drawing import LINE_PITCH, SMALL, WIDTH
from ..drive_lines.wording import Wording
from .page import HIGHEST


@in_look
def motion(analysis: Analysis, wording: Wording) -> Figure:
    """Draw angle errors and speed ratios of the shafts behind the joints."""
    names = analysis.shafts[1:]
    degrees = wording.measure("angle").factor
    return _over_turn(
        analysis,
        wording,
        [
            (wording("angle error") + " [°]", names, analysis.angle_error[:, 1:] * degrees),
            (wording("speed ratio"), names, analysis.ratio[:, 1:]),
        ],
    )


@in_look
def forces(analysis: Analysis, wording: Wording) -> Figure:
    """Draw bending moments on both sides of the joints, and forces across the shafts."""
    total = analysis.total
    torque, force = (wording.measure(name).factor for name in ("torque", "force"))
    sides = ("{joint}, before", "{joint}, behind")
    names = [wording(side, joint=name) for side in sides for name in analysis.joints]
    bending = np.concatenate([total.bending_in, total.bending_out], axis=1) * torque
    radial = total.bearing_radial * force
    return _over_turn(
        analysis,
        wording,
        [
            (wording("bending moment") + wording.unit("torque"), names, bending),
            (wording("bearing force across") + wording.unit("force"), analysis.bearings, radial),
        ],
    )


def has_orders(analysis: Analysis) -> bool:
    """Return whether the positions are even steps of one turn, whose orders are known."""
    count = len(analysis.position)
    steps = np.diff(analysis.position, append=analysis.position[0] + 2.0 * np.pi)
    return count > 2 * HIGHEST and bool(np.abs(steps - 2.0 * np.pi / count).max() < NOTHING)


@in_look
def orders(analysis: Analysis, wording: Wording) -> Figure:
    """Draw amplitudes of the orders of the angle errors and of the bearing forces.

    Those of a force are the greatest length of its vector across the shaft, which runs round an
    ellipse once in every period of an order; order 0 is the mean.
    """
    shown = range(HIGHEST + 1)
    errors = np.abs(amplitudes(analysis.angle_error[:, 1:])[shown])
    errors *= wording.measure("angle").factor
    across = amplitudes(analysis.total.bearing_force[..., 1:])[shown]
    # Both half axes of the ellipse have the sum and the difference of these as their squares.
    sums = (np.abs(across) ** 2).sum(axis=-1) + np.abs((across**2).sum(axis=-1))
    sizes = np.sqrt(sums / 2.0) * wording.measure("force").factor
    panels = [
        (wording("angle error") + " [°]", analysis.shafts[1:], errors),
        (wording("bearing force across") + wording.unit("force"), analysis.bearings, sizes),
    ]
    drawn = _sheet(panels)
    for panel, (label, names, values) in zip(drawn.panels, panels, strict=True):
        draw_bars(panel, shown, dict(zip(map(_wrapped, names), values.T, strict=True)))
        _finish(panel, label, values, wording)
    drawn.panels[-1].set_xticks(shown)
    drawn.panels[-1].set_xlabel(wording("order of the input shaft's rotation"))
    return drawn.finish("", 0)


def _over_turn(
    analysis: Analysis, wording: Wording, panels: Sequence[tuple[str, Sequence[str], Array]]
) -> Figure:
    drawn, label = _sheet(panels), wording("rotation of the input shaft") + " [°]"
    at = Abscissa(np.rad2deg(analysis.position), label, "angle")
    for panel, (label, names, values) in zip(drawn.panels, panels, strict=True):
        at.draw(panel, dict(zip(map(_wrapped, names), values.T, strict=True)))
        _finish(panel, label, values, wording)
    drawn.over(at)
    return drawn.finish("", 0)


def _wrapped(name: str) -> str:
    # Beside the axes is room for so many letters.
    return "\n".join(textwrap.wrap(name, 20) or [name])


def _sheet(panels: Sequence[tuple[str, Sequence[str], Array]]) -> Sheet:
    """Return axes so high that the legend beside each has room."""
    # Half a line is between two names.
    lines = max(sum(_wrapped(name).count("\n") + 1.5 for name in of) for _, of, _ in panels)
    height = max(2.35, LINE_PITCH * lines * SMALL / 72.0 + 0.2)
    return sheet(len(panels), size=(WIDTH, len(panels) * height), share_x=True)


def _finish(panel: Axes, label: str, values: Array, wording: Wording) -> None:
    """Label axes, and leave no scale of rounding where nothing is."""
    panel.set_ylabel(label)
    panel.yaxis.set_major_formatter(_formatter(wording))
    most = float(np.abs(values).max(initial=0.0))
    if values.size and (np.ptp(values) <= NOTHING * most or most < NOTHING):
        middle = float(values.mean())
        room = max(0.05 * abs(middle), 0.05)
        panel.set_ylim(middle - room, middle + room)
    panel.legend(
        fontsize=SMALL,
        loc="center left",
        bbox_to_anchor=(1.0, 0.5),
        handlelength=2.4,
        frameon=False,
    )


def _formatter(wording: Wording) -> Any:
    """Return what writes ticks with the decimal sign of the language."""
    from matplotlib.ticker import ScalarFormatter

    class Ticks(ScalarFormatter):
        def __call__(self, value: float, position: int | None = None) -> str:
            text = str(super().__call__(value, position))
            # Mathematical text sets a comma as one between numbers, unless it stands in braces.
            comma = "{,}" if "$" in text else ","
            return text.replace(".", comma) if wording.language == "de" else text

    return Ticks(useOffset=False)
