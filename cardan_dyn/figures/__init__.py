"""Figures: wrenches over angle and time, polar diagrams, orders, lines, impacts, vibration.

Needs the extra `viz` (matplotlib). Every function that draws returns a `matplotlib.figure.Figure`,
all in one look: units on every axis, line styles and markers that differ besides the colours, so
that a black-and-white print can be read. `save` writes SVG and PNG. matplotlib is imported only
where a figure is drawn. `figures.style` has what figures of the same look are made of, and
`figures.work_precision` draws the results of benchmarks.
"""

from .compared import compared
from .contact_course import contact_course
from .critical_speeds import campbell, critical_speed_map, orders_over_speed, stability_chart
from .force_reversals import force_reversals
from .impact_ranking import impact_ranking
from .orders import order_amplitudes, order_spectrum
from .over_angle import over_angle, ratio_and_angle_error
from .over_time import energy_over_time, over_time
from .peak_factor import peak_factor
from .peak_influence import peak_influence
from .pin_bearings import pin_forces, pin_peaks
from .pin_orbit import pin_orbit
from .polar import force_polar, forces_in_place, moment_polar
from .positions import universal_joint_positions
from .style import save
from .vibration import orbits, over_revolution, run_up

__all__ = [
    "campbell",
    "compared",
    "contact_course",
    "critical_speed_map",
    "energy_over_time",
    "force_polar",
    "force_reversals",
    "forces_in_place",
    "impact_ranking",
    "moment_polar",
    "orbits",
    "order_amplitudes",
    "order_spectrum",
    "orders_over_speed",
    "over_angle",
    "over_revolution",
    "over_time",
    "peak_factor",
    "peak_influence",
    "pin_forces",
    "pin_orbit",
    "pin_peaks",
    "ratio_and_angle_error",
    "run_up",
    "save",
    "stability_chart",
    "universal_joint_positions",
]
