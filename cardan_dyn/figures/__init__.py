"""Figures: wrenches over angle and time, polar diagrams, orders, lines, vibration, designs.

Needs the extra `viz` (matplotlib). Every function that draws returns a `matplotlib.figure.Figure`,
all in one look: units on every axis, line styles and markers that differ besides the colours, so
that a black-and-white print can be read. `save` writes SVG and PNG. matplotlib is imported only
where a figure is drawn. `figures.style` has what figures of the same look are made of, and
`figures.work_precision` draws the results of benchmarks.
"""

from .compared import compared
from .designs import contour_map, parallel_coordinates, scatter, tornado, value_map
from .orders import order_amplitudes, order_spectrum
from .over_angle import over_angle, ratio_and_angle_error
from .over_time import energy_over_time, over_time
from .polar import force_polar, forces_in_place, moment_polar
from .positions import universal_joint_positions
from .style import save

__all__ = [
    "compared",
    "contour_map",
    "energy_over_time",
    "force_polar",
    "forces_in_place",
    "moment_polar",
    "order_amplitudes",
    "order_spectrum",
    "over_angle",
    "over_time",
    "parallel_coordinates",
    "ratio_and_angle_error",
    "save",
    "scatter",
    "tornado",
    "universal_joint_positions",
    "value_map",
]
