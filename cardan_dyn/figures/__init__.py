"""Figures: wrenches over the turn, polar diagrams, orders, positions, run time against error.

Needs the extra `viz` (matplotlib). Every function returns a `matplotlib.figure.Figure`, all in
one look: units on every axis, line styles and markers that differ besides the colours, so that a
black-and-white print can be read. `save` writes SVG and PNG. matplotlib is imported only where a
figure is drawn.
"""

from .closed_forms import bending_polar, compared, speed_ratio, thoma_bending, torque_ratio
from .orders import order_amplitudes, order_spectrum
from .over_angle import over_angle, ratio_and_angle_error
from .polar import force_polar, forces_in_place, moment_polar
from .positions import universal_joint_positions
from .style import Figure, axes_grid, legend, line_style, point_style, require_matplotlib, save
from .work_precision import read_records, work_precision

__all__ = [
    "Figure",
    "axes_grid",
    "bending_polar",
    "compared",
    "force_polar",
    "forces_in_place",
    "legend",
    "line_style",
    "moment_polar",
    "order_amplitudes",
    "order_spectrum",
    "over_angle",
    "point_style",
    "ratio_and_angle_error",
    "read_records",
    "require_matplotlib",
    "save",
    "speed_ratio",
    "thoma_bending",
    "torque_ratio",
    "universal_joint_positions",
    "work_precision",
]
