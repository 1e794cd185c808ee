"""Style: the one look of all figures, and the axes they are drawn on."""

from __future__ import annotations

import os
import re
import textwrap
from collections.abc import Callable, Iterable, Mapping
from functools import wraps
from inspect import signature
from pathlib import Path
from typing import Any, NamedTuple, TypedDict, TypeVar
from weakref import WeakSet

import numpy as np
from numpy.typing import ArrayLike

from ..kit.arrays import NOTHING, Array
from ..kit.checks import described, file_path, positive, writing
from ..kit.errors import ArgumentError, MissingExtraError, choices
from ..kit.quantities import unit_of

Figure = Any
"""A `matplotlib.figure.Figure`."""
Axes = Any
"""A `matplotlib.axes.Axes`."""
Swept = Any
"""A sweep or a trajectory: samples in a row."""
Into = Any
"""Axes to be drawn into: one, or several in an array or a list; None for a new figure."""
Size = tuple[float, float]
"""Width and height of a figure [inch]."""
_Draw = TypeVar("_Draw", bound=Callable[..., Any])


class Onto(TypedDict, total=False):
    """What every figure takes of where it is drawn.

    Attributes:
        title: of the figure; of its axes if there is one or they are somebody else's.
        ax: axes to be drawn into instead of a new figure, see `Into`.
        figsize: width and height of a new figure [inch].
    """

    title: str
    ax: Into
    figsize: Size | None


# Line styles differ besides colours, so that a black-and-white print can be read. The colours are
# those of Okabe and Ito, which people with any kind of colour blindness tell apart, without their
# yellow, which is too light for lines.
_LINES: tuple[tuple[str, Any], ...] = (
    ("#0072b2", "-"),
    ("#d55e00", "--"),
    ("#009e73", ":"),
    ("#cc79a7", "-."),
    ("#e69f00", (0, (6, 1.5, 1, 1.5, 1, 1.5))),
    ("#000000", (0, (1, 0.8))),
    ("#56b4e9", (0, (8, 2))),
    ("#5a5a5a", (0, (3, 1, 1, 1))),
)
_MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<")
POINTS = 36
"""About how many points are drawn of a result: every 10° of a revolution, clear of each other."""
PER_MINUTE = 30.0 / np.pi
"""A speed of rotation of 1 rad/s [1/min]."""
TITLE_SIZE = 11
"""Font size of titles [pt]."""
GUIDE = {"color": "0.55", "linewidth": 0.9}
"""Style of lines that help to read others."""
NAME = {"color": "0.35", "fontsize": 9}
"""Style of what is written at them."""
SMALL = 9
"""Font size of what is written within axes, and of notes [pt]."""
LETTER = 0.6
"""Mean width of a letter as a fraction of the font size."""
SIGN = "what the parent link exerts on the child link"
"""Whose wrench is drawn: the sense of all forces and moments in joints."""
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
    "pdf.fonttype": 42,
    "ps.fonttype": 42,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-3, 5),
    "axes.formatter.use_mathtext": True,
    "axes.unicode_minus": True,
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
    """Return colour and line style of the line with this index, for `Axes.plot`.

    Where colours come again, they have other line styles.
    """
    count = len(_LINES)
    color, style = _LINES[index % count][0], _LINES[(index + index // count) % count][1]
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


def in_look(draw: _Draw) -> _Draw:
    """Let a function draw in the look of this package, unless it draws into given axes, `ax=`.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ArgumentError: neither the function nor `Onto` has such an option.
    """
    own = {*signature(draw).parameters}
    known = own - {"onto"} | {*Onto.__annotations__}

    @wraps(draw)
    def drawn(*arguments: Any, **options: Any) -> Any:
        for name in options if "onto" in own else ():
            if name not in known:
                said = f"no option {name!r} of {draw.__name__}"
                raise ArgumentError(f"{said}; options: {choices(sorted(known), name)}")
        require_matplotlib()
        import matplotlib

        if options.get("ax") is not None:
            return draw(*arguments, **options)
        with matplotlib.rc_context(LOOK):
            return draw(*arguments, **options)

    return drawn  # type: ignore[return-value]


class Sheet(NamedTuple):
    """What a figure is drawn on: axes of its own, or those of somebody else.

    Attributes:
        figure: that has the axes.
        panels: the axes `(rows * columns,)`, row by row.
        is_new: whether the figure is new, and so has room for a title and a legend of its own.
        may_grow: whether its size may follow what is drawn.
        title: of the figure; empty for none.
    """

    figure: Figure
    panels: Array
    is_new: bool
    may_grow: bool
    title: str = ""

    def finish(self, title: str = "", columns: int = 2, note: str = "") -> Figure:
        """Write title, legend and note, and return the figure.

        Args:
            title: if `sheet` was given none.
            columns: of the legend, at most; 0 where axes have their own.
            note: on what is drawn, below it in small letters.
        """
        title = self.title or title
        for panel in self.panels:
            if panel.get_autoscaley_on():
                settle(panel)
            shorten(panel)
        panel = self.panels[0]
        if title and (not self.is_new or (len(self.panels) == 1 and not panel.get_title())):
            panel.set_title(wrapped(title, self.figure.get_figwidth()), fontsize=TITLE_SIZE)
        elif title:
            heading(self.figure, title)
        if self.is_new:
            legend(self.figure, columns, note=note, grows=self.may_grow)
            return self.figure
        if columns and self.figure.legends:
            # Of a figure that has one for all axes, that tells of the new lines as well.
            for former in list(self.figure.legends):
                former.remove()
            legend(self.figure, columns, note=note)
        elif columns:
            _legend_within(self.panels, note)
        return self.figure

    def over(self, at: Abscissa) -> None:
        """Make an abscissa that of all axes, and write its label below the last."""
        for panel in self.panels if not self.is_new else self.panels[-1:]:
            at.name(panel)
        for panel in self.panels[:-1]:
            panel.set_xlabel("")

    def drawn(self, panel: int = 0) -> int:
        """Return how many named lines axes have, so that further ones are drawn otherwise."""
        lines = self.panels[panel].get_lines()
        return sum(not str(line.get_label()).startswith("_") for line in lines)


def sheet(
    rows: int = 1,
    columns: int = 1,
    *,
    count: int | None = None,
    size: Size | None = None,
    share_x: bool = False,
    title: str = "",
    ax: Into = None,
    figsize: Size | None = None,
) -> Sheet:
    """Return axes to draw on: given ones, or those of a new figure in the look of this package.

    Args:
        rows: of axes.
        columns: of axes.
        count: of axes that are needed; as many as fit into rows and columns if None.
        size: of a new figure unless `figsize` is given [inch].
        share_x: one abscissa for the axes of a column.
        title: of the figure.
        ax: axes to be drawn into instead of a new figure, see `Into`.
        figsize: of a new figure [inch].

    Raises:
        MissingExtraError: matplotlib is not installed.
        ArgumentError: `ax` are no axes, of another projection, or not as many as are needed;
            `figsize` is no size, or is given besides `ax`.
    """
    needed = rows * columns if count is None else count
    if ax is None:
        wanted = size if figsize is None else _size(figsize)
        figure, grid = axes_grid(rows, columns, size=wanted, share_x=share_x)
        panels = np.atleast_1d(grid)
        for panel in panels[needed:]:
            panel.remove()
        return Sheet(figure, panels[:needed], True, figsize is None, title)
    if figsize is not None:
        raise ArgumentError("figsize is that of a new figure: give either it or ax")
    panels = _given(ax, needed)
    return Sheet(panels[0].figure, panels, False, False, title)


def _size(figsize: Size) -> Size:
    """Return a size of a figure that is one."""
    try:
        width, height = (positive("figsize", length) for length in figsize)
    except (TypeError, ValueError) as error:
        raise ArgumentError(
            f"figsize is {described(figsize)}, expected width and height in inches, as in "
            "figsize=(7.2, 4.8)"
        ) from error
    return width, height


def _given(ax: Into, needed: int) -> Array:
    """Return given axes in a row."""
    from matplotlib.axes import Axes as MatplotlibAxes

    items = [ax] if isinstance(ax, MatplotlibAxes) else list(np.ravel(np.array(ax, dtype=object)))
    for item in items:
        if not isinstance(item, MatplotlibAxes):
            raise ArgumentError(
                f"ax is {described(item)}, expected axes of matplotlib, such as those of "
                "plt.subplots()"
            )
        if item.name != "rectilinear":
            raise ArgumentError(
                f"ax has the projection {item.name!r}, expected 'rectilinear': give axes of "
                "plt.subplots()"
            )
    if len(items) != needed:
        raise ArgumentError(
            f"ax has {len(items)} axes, and {needed} are drawn: give ax=axes of "
            f"figure, axes = plt.subplots({needed}), or leave ax out"
        )
    panels = np.empty(needed, dtype=object)
    panels[:] = items
    return panels


def axes_grid(
    rows: int = 1,
    columns: int = 1,
    *,
    size: Size | None = None,
    share_x: bool = False,
    **projection: str,
) -> tuple[Figure, Any]:
    """Return an empty figure in the look of this package, and its axes.

    Args:
        rows: of axes.
        columns: of axes.
        size: width and height [inch].
        share_x: one abscissa for the axes of a column.
        projection: `projection="polar"`.

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


def heading(figure: Figure, title: str) -> None:
    """Write the title of a figure, in several lines where it is longer than that is wide."""
    figure.suptitle(wrapped(title, figure.get_figwidth(), TITLE_SIZE), fontsize=TITLE_SIZE)
    layout = figure.get_layout_engine()
    if layout is not None:
        # Titles of axes that have two lines would touch it.
        layout.set(h_pad=0.08)


def plain(name: str) -> str:
    """Return a name as Matplotlib is to write it: with its `$`, which begin no formula.

    Matplotlib leaves out of legends what begins with an underscore; behind a space without width
    it does not.
    """
    return ("\u200b" if name.startswith("_") else "") + name.replace("$", r"\$")


def width_of(text: str, size: float = SMALL) -> float:
    """Return how wide a text is [inch]."""
    from matplotlib.textpath import TextPath

    return float(TextPath((0.0, 0.0), text, size=size).get_extents().width) / 72.0


def rows_of(spans: Iterable[tuple[float, float]]) -> list[int]:
    """Return in which row each span from low to high stands, so that none covers another."""
    ends: list[float] = []
    rows = []
    for low, high in spans:
        rows.append(next((row for row, end in enumerate(ends) if end <= low), len(ends)))
        ends[rows[-1] : rows[-1] + 1] = [high]
    return rows


def wrapped(text: str, width: float, size: float = TITLE_SIZE) -> str:
    """Return a text in lines that fit into a width [inch]; a number stays with its unit."""
    letters = max(8, int(width * 72.0 / (LETTER * size)))
    kept = re.sub(r"(?<=\d) ", "\N{NO-BREAK SPACE}", text).split("\n")
    lines = (part for line in kept for part in textwrap.wrap(line, letters) or [""])
    return "\n".join(lines).replace("\N{NO-BREAK SPACE}", " ")


def legend(figure: Figure, columns: int = 2, *, note: str = "", grows: bool = False) -> None:
    """Put one legend below all axes of a figure, each label once.

    Args:
        figure: the figure.
        columns: of the legend; fewer where labels are too long for them, none if 0.
        note: on what is drawn, in small letters above the labels.
        grows: whether the figure becomes higher for a legend of many rows.
    """
    handles = _handles(figure.axes) if columns else {}
    if not handles:
        if note:
            text = wrapped(note, figure.get_figwidth(), SMALL)
            figure.supxlabel(text, fontsize=SMALL, color="0.35")
        return
    width, size = figure.get_figwidth(), LOOK["font.size"]
    # Beside its label, a column of a legend has a handle and gaps as wide as this [inch].
    beside = 4.8 * size / 72.0
    labels = [wrapped(label, width - beside, size) for label in handles]
    wide = [max(width_of(line, size) for line in label.split("\n")) + beside for label in labels]
    # Matplotlib fills columns from the left, those to the left with one more where it is uneven.
    fitting = (
        count
        for count in range(min(columns, len(handles)), 1, -1)
        if sum(map(max, np.array_split(wide, count))) <= width
    )
    columns = next(fitting, 1)
    drawn = figure.legend(
        handles.values(),
        labels,
        loc="outside lower center",
        ncols=columns,
        frameon=False,
        title=wrapped(note, width, SMALL) if note else None,
        title_fontsize=SMALL,
    )
    drawn.get_title().set_color("0.35")
    rows = -(-len(handles) // columns)
    if grows and rows > 2:  # For two there is room.
        figure.set_figheight(figure.get_figheight() + 0.24 * (rows - 2))


def _handles(panels: Iterable[Axes]) -> dict[str, Any]:
    """Return what legends show of axes, by its labels."""
    handles: dict[str, Any] = {}
    for panel in panels:
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    return handles


def _legend_within(panels: Any, note: str) -> None:
    """Put a legend into the first of given axes, where there is most room."""
    handles = _handles(panels)
    if handles:
        labels = [wrapped(label, 4.0, SMALL) for label in handles]
        drawn = panels[0].legend(handles.values(), labels, loc="best", fontsize=SMALL)
        if note:
            drawn.set_title(wrapped(note, 4.0, SMALL), prop={"size": SMALL - 1})


_SETTLED: WeakSet[Any] = WeakSet()
"""Axes whose ordinate `settle` has limited."""


def settle(panel: Axes, scale: float = 0.0) -> None:
    """Show constants and rounding as what they are, without offsets at the axes.

    Where all values of axes are constant but for rounding, the ordinate begins at zero, and where
    they are all but zero beside a scale, it shows the scale.

    Args:
        panel: axes with lines.
        scale: size of what the values are a part of.
    """
    shorten(panel)
    if panel.name != "rectilinear" or panel.get_yscale() != "linear" or panel.patches:
        return
    if not panel.get_autoscaley_on() and panel not in _SETTLED:
        return
    drawn = [
        np.asarray(line.get_ydata(), dtype=float)
        for line in panel.get_lines()
        if line.get_transform().contains_branch_seperately(panel.transData)[1]
    ]
    values = np.concatenate([np.ravel(line) for line in drawn]) if drawn else np.zeros(0)
    values = values[np.isfinite(values)]
    if not values.size:
        return
    size, span = float(np.max(np.abs(values))), float(np.ptp(values))
    if span > NOTHING * size and size > NOTHING * scale:
        if panel in _SETTLED and not panel.get_autoscaley_on():
            panel.autoscale(axis="y")
        return
    _SETTLED.add(panel)
    if size <= NOTHING * scale or size == 0.0:
        panel.set_ylim(-(scale or 1.0), scale or 1.0)
    else:
        value = 1.15 * float(values[np.argmax(np.abs(values))])
        panel.set_ylim(min(0.0, value), max(0.0, value))


def shorten(panel: Axes) -> None:
    """Let axes write numbers with the prefixes that make them short, and without offsets."""
    from .prefixes import PrefixFormatter

    for axis in (panel.xaxis, panel.yaxis):
        PrefixFormatter.of(panel, axis)


def save(figure: Figure, path: str | os.PathLike[str], dpi: int = 150) -> list[Path]:
    """Write a figure, as SVG and PNG or in one format.

    Figures that are drawn alike make the same SVG, PNG and PDF.

    Args:
        figure: the figure.
        path: of the file, whose suffix is its format, such as `.pdf`; of both files without one.
            A missing directory is created.
        dpi: resolution of what consists of pixels [1/inch].

    Returns:
        Paths of the SVG and of the PNG, or of the only file.

    Raises:
        ArgumentError: no path, or they cannot be written.
    """
    import matplotlib

    base = file_path("path", path)
    # Anything else behind a point belongs to the name.
    is_one = base.suffix.lower().removeprefix(".") in figure.canvas.get_supported_filetypes()
    files = [base] if is_one else [base.with_name(base.name + end) for end in (".svg", ".png")]
    for file in files:
        with writing(file) as part, matplotlib.rc_context(LOOK):
            file.parent.mkdir(parents=True, exist_ok=True)
            figure.savefig(part, dpi=dpi, metadata=_UNDATED.get(file.suffix.lower()))
    return files


_UNDATED = {
    ".svg": {"Date": None},
    ".png": {"Software": None},
    ".pdf": {"CreationDate": None},
}
"""What is written about files: no dates or versions, which would make two files of one figure
differ."""


class Abscissa(NamedTuple):
    """What a figure is drawn over.

    Attributes:
        values: as they are drawn `(N,)`: angles in degrees.
        label: of the axis, with its unit.
        kind: `angle`, with a tick every 45° over one turn, or `range`, which both end where the
            values do; or empty.
    """

    values: Array
    label: str
    kind: str = ""

    @property
    def unit(self) -> str:
        """Its unit, as it follows a number."""
        return unit_of(self.label)[1]

    def style(self, index: int) -> dict[str, Any]:
        """Return how the values with this index are drawn: as points if in no order.

        Samples that turn back at every other one are no path, and lines between them say nothing.
        """
        steps = np.sign(np.diff(self.values))
        turns = np.count_nonzero(steps[1:] * steps[:-1] < 0.0)
        if 2 * turns > len(steps):
            return point_style(index)
        return curve_style(index, len(self.values))

    def draw(
        self, panel: Axes, curves: Mapping[str, ArrayLike], first: int = 0, **line: Any
    ) -> list[Any]:
        """Draw curves `(N,)` by their names, and return the lines.

        Args:
            panel: axes.
            curves: names, as the legend has them, to values.
            first: index of the first one's style.
            line: properties of all of them, for `Axes.plot`.

        Raises:
            ArgumentError: a curve has another shape.
        """
        drawn = []
        for index, (name, values) in enumerate(curves.items(), first):
            style = {**self.style(index), "label": plain(name), **line}
            drawn += panel.plot(self.values, shaped(name, values, len(self.values)), **style)
        return drawn

    def name(self, panel: Axes) -> None:
        """Write the label at axes, and limit them."""
        panel.set_xlabel(self.label)
        low, high = float(np.min(self.values)), float(np.max(self.values))
        if not self.kind or low == high:
            return  # Of a single position matplotlib leaves room on both sides.
        panel.set_xlim(low, high)
        ticks = 45.0 * np.arange(np.ceil(low / 45.0 - NOTHING), high / 45.0 + NOTHING)
        if self.kind == "angle" and 4 <= len(ticks) <= 9:
            panel.set_xticks(ticks)


def over(name: str, values: ArrayLike, unit: str) -> Abscissa:
    """Return a quantity to be drawn over, angles in degrees and limited to its values."""
    at = np.asarray(values, dtype=float)
    if unit == "rad":
        return Abscissa(np.rad2deg(at), f"{plain(name)} [°]", "angle")
    label = f"{plain(name)} [{unit}]" if unit not in ("", "1") else plain(name)
    return Abscissa(at, label, "range")


def speeds(speed: ArrayLike, kind: str = "range") -> Abscissa:
    """Return speeds of rotation `(N,)` [rad/s], to be drawn over in 1/min.

    Raises:
        ArgumentError: they are none, or not finite.
    """
    return Abscissa(PER_MINUTE * abscissa("speed", speed), "speed [1/min]", kind)


def thinned(count: int, points: int = POINTS) -> slice:
    """Return which of `count` samples are drawn, evenly chosen, for about so many points."""
    return slice(None, None, max(1, (count - 1) // max(points, 1)))


def refuse_grid(turn: Swept) -> None:
    """Refuse a sweep over several dimensions, which no line can show.

    Raises:
        ArgumentError: it is one.
    """
    if len(turn.shape) > 1:
        raise ArgumentError(
            f"figures and scenes show sweeps over one dimension, not of shape {turn.shape}; sweep "
            "one design at a time"
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


def shaped(name: str, values: ArrayLike, *shape: int | str) -> Array:
    """Return values as numbers of a shape, in which a letter is any length.

    Raises:
        ArgumentError: they have another shape.
    """
    found = np.asarray(values, dtype=float)
    lengths = [
        given if isinstance(n, str) else n for n, given in zip(shape, found.shape, strict=False)
    ]
    if found.shape != (*lengths,) or len(lengths) != len(shape):
        expected = ", ".join(map(str, shape)) + "," * (len(shape) == 1)
        raise ArgumentError(f"{name!r} has shape {found.shape}, expected ({expected})")
    return found
