"""Style: the one look of all figures, and the axes they are drawn on."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Array
from ..checks import file_path, writing
from ..checks import names as checked_names
from ..errors import ArgumentError, MissingExtraError, choices

Figure = Any
"""A `matplotlib.figure.Figure`."""
Axes = Any
"""A `matplotlib.axes.Axes`."""
Swept = Any
"""A sweep or a trajectory: samples in a row."""

# Line styles differ besides colours, so that a black-and-white print can be read.
_LINES: tuple[tuple[str, Any], ...] = (
    ("#1b4f8a", "-"),
    ("#c2571a", "--"),
    ("#3a7d44", ":"),
    ("#7a3b8f", "-."),
    ("#8a6d1b", (0, (6, 1.5, 1, 1.5, 1, 1.5))),
    ("#444444", (0, (1, 0.8))),
    ("#a8324a", (0, (8, 2))),
    ("#2a8a8a", (0, (3, 1, 1, 1))),
)
_MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<")
POINTS = 36
"""About how many points are drawn of a result: every 10° of a revolution, clear of each other."""
SPEED = "speed [1/min]"
"""Label of an abscissa of speeds of rotation."""
PER_MINUTE = 30.0 / np.pi
"""A speed of rotation of 1 rad/s [1/min]."""
TITLE_SIZE = 11
"""Font size of titles [pt]."""
_TICK = 45.0
"""Distance of the ticks of an angle axis [°]."""
_TICK_ROUNDING = 1e-6
"""By how much an end of the range may miss a tick that is still drawn [°]: angles in degrees are
off by rounding, some 1e-13."""
_ROUNDING = 1e-9
"""Part of the greatest moment or force in the joints below which a component of it is rounding: the
axes then show the size of the whole, in which it is zero."""
_HALF_TURN, _WHOLE_TURN = 180.0, 361.0
"""Range of angles for which these ticks are neither too few nor too many [°]; a whole turn may end
one sample later."""
LOOK: Any = {
    "figure.figsize": (7.2, 4.8),
    "figure.constrained_layout.use": True,
    "font.size": 11,
    "axes.titlesize": TITLE_SIZE,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "0.88",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "lines.linewidth": 1.6,
    "svg.fonttype": "none",
    "svg.hashsalt": "cardan-dyn",
}


def require_matplotlib() -> None:
    """Import matplotlib.

    Raises:
        MissingExtraError: it is not installed; the message names the install command.
    """
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise MissingExtraError('figures need matplotlib: pip install "cardan-dyn[viz]"') from error


def line_style(index: int) -> dict[str, Any]:
    """Return colour and line style of the line with this index, for `Axes.plot`."""
    color, style = _LINES[index % len(_LINES)]
    return {"color": color, "linestyle": style}


def curve_style(index: int, count: int) -> dict[str, Any]:
    """Return the style of a line of `count` points; with a marker if it is a single point."""
    marker = {"marker": _MARKERS[index % len(_MARKERS)]} if count == 1 else {}
    return {**line_style(index), **marker}


def point_style(index: int) -> dict[str, Any]:
    """Return marker and colour of the points with this index, for `Axes.plot`."""
    return {
        "linestyle": "none",
        "marker": _MARKERS[index % len(_MARKERS)],
        "markersize": 5,
        # Filled where the same markers occur a second time.
        "markerfacecolor": "white" if index % (2 * len(_MARKERS)) < len(_MARKERS) else None,
        "color": _LINES[index % len(_LINES)][0],
    }


def axes_grid(
    rows: int = 1,
    columns: int = 1,
    *,
    size: tuple[float, float] | None = None,
    share_x: bool = False,
    **projection: str,
) -> tuple[Figure, Any]:
    """Return an empty figure in the look of this package, and its axes.

    Args:
        rows: of axes.
        columns: of axes.
        size: width and height [inch].
        share_x: one abscissa for the axes of a column.
        projection: `projection="polar"` or `"3d"`.

    Returns:
        The figure, and its axes: one, or an array `(rows * columns,)` row by row.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    require_matplotlib()
    import matplotlib
    from matplotlib.figure import Figure as MatplotlibFigure

    with matplotlib.rc_context(LOOK):
        figure = MatplotlibFigure(figsize=size) if size else MatplotlibFigure()
        axes = figure.subplots(
            rows, columns, squeeze=False, sharex="col" if share_x else False, subplot_kw=projection
        ).ravel()
    return figure, axes[0] if len(axes) == 1 else axes


def legend(figure: Figure, columns: int = 2) -> None:
    """Put one legend below all axes of a figure, each label once."""
    handles: dict[str, Any] = {}
    for axes in figure.axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    figure.legend(
        handles.values(), handles.keys(), loc="outside lower center", ncols=columns, frameon=False
    )


def save(figure: Figure, path: str | os.PathLike[str], dpi: int = 150) -> list[Path]:
    """Write a figure as SVG and PNG; the same figure makes the same files.

    Args:
        figure: the figure.
        path: of the files, without a suffix or with any; a missing directory is created.
        dpi: resolution of the PNG [1/inch].

    Returns:
        Paths of the SVG and of the PNG.

    Raises:
        ArgumentError: no path, or they cannot be written.
    """
    import matplotlib

    base = file_path("path", path)
    vector, pixels = base.with_suffix(".svg"), base.with_suffix(".png")
    with writing(base), matplotlib.rc_context(LOOK):
        base.parent.mkdir(parents=True, exist_ok=True)
        # A date in the file would make two files of the same figure differ.
        figure.savefig(vector, metadata={"Date": None})
        figure.savefig(pixels, dpi=dpi, metadata={"Software": None})
    return [vector, pixels]


UNITS = {"torsion": "N·m", "bending": "N·m", "axial": "N", "shear": "N"}
"""Quantities of a `JointWrench` that are drawn as lines, and their units."""


def wrench_panels(
    wrenches: Sequence[Any], abscissa: Array, quantities: Sequence[str]
) -> tuple[Figure, Array]:
    """Return a figure of wrenches over an abscissa: an axes per quantity, a line per joint.

    Args:
        wrenches: of the joints.
        abscissa: `(N,)`.
        quantities: of `UNITS`.

    Raises:
        ArgumentError: unknown quantity.
    """
    for quantity in quantities:
        if quantity not in UNITS:
            raise ArgumentError(
                f"quantity {quantity!r} is unknown; quantities: {choices(UNITS, quantity)}"
            )
    count = len(quantities)
    figure, axes = axes_grid(count, size=(7.2, 1.4 + 2.6 * count), share_x=True)
    panels = np.atleast_1d(axes)
    for quantity, panel in zip(quantities, panels, strict=True):
        values = [getattr(wrench, quantity) for wrench in wrenches]
        for index, (wrench, line) in enumerate(zip(wrenches, values, strict=True)):
            panel.plot(abscissa, line, **curve_style(index, len(abscissa)), label=wrench.joint)
        panel.set_ylabel(f"{quantity} [{UNITS[quantity]}]")
        wholes = [wrench.moment if "m" in UNITS[quantity] else wrench.force for wrench in wrenches]
        whole = max((float(np.max(np.abs(item), initial=0.0)) for item in wholes), default=0.0)
        drawn = max((float(np.max(np.abs(line), initial=0.0)) for line in values), default=0.0)
        if 0.0 < drawn < _ROUNDING * whole:
            panel.set_ylim(-whole, whole)
    legend(figure, min(len(wrenches), 4))
    return figure, panels


def angle_axis(axes: Axes, label: str, position: Array) -> None:
    """Make the abscissa an angle in degrees, with a tick every 45° over one turn."""
    axes.set_xlabel(label)
    low, high = (float(np.rad2deg(end)) for end in (np.min(position), np.max(position)))
    if low == high:
        return  # A single position: matplotlib leaves room on both sides of it.
    axes.set_xlim(low, high)
    if _HALF_TURN <= high - low <= _WHOLE_TURN:
        first = _TICK * np.ceil((low - _TICK_ROUNDING) / _TICK)
        axes.set_xticks(np.arange(first, high + _TICK_ROUNDING, _TICK))


def thinned(count: int, points: int = POINTS) -> slice:
    """Return which of `count` samples are drawn, evenly chosen, for about so many points."""
    return slice(None, None, max(1, (count - 1) // max(points, 1)))


def names(joints: str | Sequence[str], label: str = "joints") -> list[str]:
    """Return one name or several as a list.

    Raises:
        ArgumentError: it is anything else.
    """
    return list(checked_names(label, joints))


def refuse_grid(turn: Swept) -> None:
    """Refuse a sweep over several dimensions, which no line can show.

    Raises:
        ArgumentError: it is one.
    """
    if len(turn.shape) > 1:
        raise ArgumentError(
            f"figures draw sweeps over one dimension, not of shape {turn.shape}; sweep one design "
            "at a time"
        )


def drive_of(turn: Swept, drive: str | None) -> str:
    """Return the joint over whose angle a sweep is drawn: its first drive if none is given.

    Raises:
        ArgumentError: the sweep has several dimensions.
    """
    refuse_grid(turn)
    return turn.coordinates[0] if drive is None else drive


def abscissa(name: str, values: ArrayLike) -> Array:
    """Return an abscissa `(N,)`.

    Raises:
        ArgumentError: it is none, or not finite.
    """
    course = np.asarray(values, dtype=float)
    if course.ndim != 1 or not len(course) or not np.all(np.isfinite(course)):
        raise ArgumentError(f"{name} has shape {course.shape}, expected finite numbers (N,)")
    return course


def ordinates(name: str, values: ArrayLike, at: Array, count: int | None = None) -> Array:
    """Return curves `(N, m)` over an abscissa, a column for each.

    Args:
        name: how messages call them.
        values: of the curves.
        at: the abscissa `(N,)`.
        count: m, if it is known.

    Raises:
        ArgumentError: they have another shape.
    """
    lines = np.asarray(values, dtype=float)
    if lines.ndim != 2 or len(lines) != len(at) or count not in (None, lines.shape[1]):
        expected = f"({len(at)}, {'m' if count is None else count})"
        raise ArgumentError(f"{name!r} has shape {lines.shape}, expected {expected}")
    return lines


def ordinate(name: str, values: ArrayLike, at: Array) -> Array:
    """Return a curve over an abscissa.

    Raises:
        ArgumentError: it has another shape.
    """
    line = np.asarray(values, dtype=float)
    if line.shape != at.shape:
        raise ArgumentError(f"{name!r} has shape {line.shape}, expected {at.shape}")
    return line
