"""Figures: wrenches over angle and time, polar diagrams, orders, lines, vibration, designs.

Results draw themselves by these functions: `sweep.plot()`, see `results.plot`. Needs the extra
`viz` (matplotlib). Every function that draws returns a `matplotlib.figure.Figure`, a new one of
`figsize`, or that of the axes `ax` into which it draws. All have one look: units on every axis,
colours that people with colour blindness tell apart, line styles and markers that differ besides,
so that a black-and-white print can be read. `save` writes SVG and PNG, or PDF. matplotlib is
imported only where a figure is drawn. `figures.style` has what figures of the same look are made
of.

`figures` draws arrays in one look (`style`: a `Sheet` has the axes, legend, title and note of a
figure, an `Abscissa` draws curves on them, `peaks` labels extremes) and knows nothing of results,
which plot themselves through it: `columns` and `wrenches` draw lines over anything, as `panels`
below each other, the other files are figures of one kind.
"""

from .compared import compared
from .orders import order_amplitudes, order_spectrum
from .over_angle import over_angle, ratio_and_angle_error
from .over_time import energy_over_time, over_time
from .polar import force_polar, forces_in_place, moment_polar
from .style import save

__all__ = [
    "compared",
    "energy_over_time",
    "force_polar",
    "forces_in_place",
    "moment_polar",
    "order_amplitudes",
    "order_spectrum",
    "over_angle",
    "over_time",
    "ratio_and_angle_error",
    "save",
]
