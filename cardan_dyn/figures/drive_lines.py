"""Drive lines: angle errors, speeds, bending and bearing forces of a line over a turn."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..checks import described
from ..drive_lines.verdict.analysis import Analysis
from ..errors import ArgumentError
from .style import TITLE_SIZE, Figure, angle_axis, axes_grid, curve_style

_SIZE = (7.6, 9.6)
_SMALL = 8


def line_over_angle(analysis: Analysis, *, title: str = "") -> Figure:
    """Draw what an analysis of a drive line found over the rotation of the input shaft.

    From above: the angle error of every shaft behind a joint, its speed ratio, the bending moments
    before and behind each joint, and the bearings' forces across their shafts, with inertia
    and weight.

    Args:
        analysis: without variants.
        title: of the figure; the name of the line unless given.

    Raises:
        ArgumentError: the analysis is of many designs.
    """
    if not isinstance(analysis, Analysis) or len(analysis.shape) != 1:
        what = "of many designs" if isinstance(analysis, Analysis) else described(analysis)
        raise ArgumentError(f"the analysis is {what}, expected one of a single line")
    angle, forces = np.rad2deg(analysis.position), analysis.total
    panels: list[tuple[str, list[tuple[str, Array]]]] = [
        ("angle error [°]", _columns(analysis.shafts, np.rad2deg(analysis.angle_error), first=1)),
        ("speed ratio [–]", _columns(analysis.shafts, analysis.ratio, first=1)),
        (
            "bending [N·m]",
            [
                *_columns([f"before {name}" for name in analysis.joints], forces.bending_in),
                *_columns([f"behind {name}" for name in analysis.joints], forces.bending_out),
            ],
        ),
        ("bearing force [N]", _columns(analysis.bearings, forces.bearing_radial)),
    ]
    figure, axes = axes_grid(len(panels), size=_SIZE, share_x=True)
    for panel, (label, curves) in zip(axes, panels, strict=True):
        for index, (name, values) in enumerate(curves):
            panel.plot(angle, values, **curve_style(index, len(angle)), label=name)
        panel.set_ylabel(label)
        panel.ticklabel_format(axis="y", useOffset=False)
        panel.legend(fontsize=_SMALL, loc="center left", bbox_to_anchor=(1.0, 0.5))
    angle_axis(axes[-1], "rotation of the input shaft [°]", analysis.position)
    figure.suptitle(title or analysis.name, fontsize=TITLE_SIZE)
    return figure


def _columns(
    names: tuple[str, ...] | list[str], values: Array, first: int = 0
) -> list[tuple[str, Array]]:
    return [(name, values[:, index]) for index, name in enumerate(names) if index >= first]
