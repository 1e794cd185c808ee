"""Plot: results draw themselves, by the figures that know nothing of them.

Every result has `plot`. Called without arguments it draws what is asked of such a result first,
called with names of columns these, and its methods are the other figures. All return a
`matplotlib.figure.Figure`, and take what figures take:

- `x`: what is drawn over: the name of a column or of a joint, or an array with an entry per sample,
- `ax`: axes to be drawn into instead of a new figure, one or as many as the figure has,
- `figsize`: width and height of a new figure [inch],
- `title`, `label` of the lines, `xlabel` and `ylabel`, with their units,
- `peaks`: label the greatest and the least value of each line; nothing if False; the greater one by
  size, of few lines, if None,
- properties of lines, such as `color`, `linestyle`, `linewidth` or `marker`.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import wraps
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np

from ...kit.arrays import Array
from ...kit.checks import described, names
from ...kit.errors import ArgumentError, choices
from .case_line import case_line
from .limits import effort_limits, efforts
from .table import Table

if TYPE_CHECKING:
    from ...figures.panels import Panel
    from ...figures.style import Abscissa, Figure

_MOST_JOINTS = 4
"""Joints that are drawn if none is named: those on which most acts."""
_ROUNDING = 1e-9
"""Part of the greatest moment in joints below which one is rounding."""
_FORCES = ("N", "N·m")
"""Units of what rounding leaves of a balance: it is seen beside the greatest of them."""
_SIZES = {
    "bending": "moment",
    "moment_magnitude": "moment",
    "shear": "force",
    "force_magnitude": "force",
}
"""Columns that are sizes of vectors, and of which."""
_INSTEAD = {
    "over": "the abscissa is x=…",
    "y": "name what is drawn first: result.plot(…, x=…)",
    "column": "name columns first: result.plot(…)",
    "columns": "name columns first: result.plot(…)",
    "joint": "name joints first: result.plot(…)",
    "joints": "name joints first: result.plot(…)",
    "of": "name the column first, as result.plot('joint.shear')",
    "axes": "axes are ax=…",
    "axis": "axes are ax=…",
    "size": "the size is figsize=(width, height)",
    "kind": "other figures are methods: result.plot.NAME(…)",
    "grid": "set it afterwards: figure.axes[0].grid(…)",
    "legend": "change it afterwards: figure.legends",
}
"""What else one may call an option, and what it is called."""
_OWN = ("title", "peaks", "ax", "figsize")
"""Options that all figures of lines have."""
_Kind = TypeVar("_Kind", bound="type[Plot]")
_Draw = TypeVar("_Draw", bound="Callable[..., Figure]")
_PLOTS: dict[type, type[Plot]] = {}


def draws(kind: type) -> Callable[[_Kind], _Kind]:
    """Let a class of plots draw a kind of results that cannot know it."""

    def register(plot: _Kind) -> _Kind:
        _PLOTS[kind] = plot
        return plot

    return register


def own_figure(draw: _Draw) -> _Draw:
    """Let a method of a plot draw without columns; those that are named are of the table.

    It is given those of its options alone that it names, and `title`, `ax` and `figsize`.
    """

    @wraps(draw)
    def drawn(self: Plot, *columns: Any, **options: Any) -> Figure:
        if columns:
            return Plot.__call__(self, *columns, **options)
        return draw(self, **own_options(options, *(draw.__kwdefaults__ or ())))

    return cast("_Draw", drawn)


def plot_of(result: Any) -> Plot:
    """Return what draws a result."""
    kinds = (_PLOTS[kind] for kind in type(result).__mro__ if kind in _PLOTS)
    return next(kinds, Plot)(result)


class Plot:
    """Draws a result: `result.plot()`, or `result.plot("name of a column")`.

    Args:
        result: anything with a `table`.
    """

    first: tuple[str, ...] = ()
    """Columns that are drawn if none is named."""

    def __init__(self, result: Any) -> None:
        self._result = result

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        raise AttributeError(
            f"no figure {name!r}; figures of a {type(self._result).__name__}: "
            f"{choices(self._figures(), name)}; columns are drawn by their names: "
            f'result.plot("…")'
        )

    def __repr__(self) -> str:
        return f"<Figures of a {type(self._result).__name__}: plot(), {', '.join(self._figures())}>"

    def _figures(self) -> list[str]:
        """Return the names of the methods that draw."""
        own = (name for name in dir(type(self)) if not name.startswith("_") and name != "first")
        return [f"plot.{name}" for name in own]

    def __call__(
        self,
        *columns: Any,
        x: Any = "",
        label: str | Sequence[str] = "",
        xlabel: str = "",
        **options: Any,
    ) -> Figure:
        """Draw columns of the table over one of them; those of one unit share their axes.

        Args:
            columns: names of columns, as in `to_dataframe`, or arrays `(N,)` with an entry per
                sample; what is asked first if there is none.
            x: name of the column that is the abscissa, or an array; what was given first, such as
                the position of the first drive, a speed or a time, if empty.
            label: of the lines, one or as many as there are columns; their names if empty.
            xlabel: of the abscissa, with its unit; its name if empty.
            options: `title`, `ylabel` (with its unit, where all lines have the same), `peaks`, `ax`
                (one for each unit) and `figsize`, see `results.plot`; properties of the lines.

        Raises:
            MissingExtraError: matplotlib is not installed.
            ArgumentError: there is no such column, an array of another length, the result has
                several dimensions, or other axes than are needed.
        """
        table = self._table()
        known = table.columns()
        chosen = columns or tuple(name for name in self.first if name in known) or _first(table)
        if not chosen:
            raise ArgumentError(f"name what is drawn; columns: {choices(known)}")
        at = self._abscissa(x, xlabel, table, known)
        drawn = self._ordinates(chosen, label, known, len(at.values))
        return self._draw(at, drawn, known, **options)

    def _draw(
        self,
        at: Abscissa,
        drawn: Mapping[str, tuple[Array, str]],
        known: Mapping[str, tuple[Array, str]],
        *,
        marked: Collection[str] = (),
        note: str = "",
        **options: Any,
    ) -> Figure:
        """Draw labelled columns over an abscissa."""
        from ...figures.columns import over_column  # Imported here: it needs matplotlib.
        from ...figures.style import in_look

        own, line = _divided(options, *_OWN, "ylabel")
        scales = self._scales(known)
        return in_look(over_column)(
            at, drawn, scales=scales, marked=marked, note=note, line=line, **own
        )

    def _scales(self, known: Mapping[str, tuple[Array, str]]) -> dict[str, float]:
        """Return units to sizes beside which values are rounding."""
        return {unit: _greatest(known, unit) for unit in _FORCES}

    def _table(self) -> Table:
        """Return the table of a result over one dimension."""
        table: Table = self._result.table()
        if len(table.samples) > 1:
            raise ArgumentError(
                f"figures draw results over one dimension, not over {choices(table.samples)}; "
                "take one design at a time"
            )
        return table

    def _abscissa(
        self, x: Any, label: str, table: Table, known: Mapping[str, tuple[Array, str]]
    ) -> Abscissa:
        """Return what is drawn over."""
        from ...figures.style import Abscissa, over

        if not isinstance(x, str):
            name, values, unit = _labelled(x, "x", _size(table))
            at = over(name, values, unit)
        else:
            name = x or table.abscissa
            if not name and not known:
                raise ArgumentError("the result is empty: there is nothing to be drawn")
            if name:
                at = over(name, *self._column(name, known))
            else:
                count = _size(table)
                at = over(next(iter(table.samples), "sample"), np.arange(count), "")
        if not np.all(np.isfinite(at.values)):
            raise ArgumentError("x has values that are no numbers, over which nothing is drawn")
        rises = bool(np.all(np.diff(at.values) >= 0.0) or np.all(np.diff(at.values) <= 0.0))
        return Abscissa(at.values, label or at.label, at.kind if rises else "")

    def _ordinates(
        self,
        columns: Sequence[Any],
        label: str | Sequence[str],
        known: Mapping[str, tuple[Array, str]],
        count: int,
    ) -> dict[str, tuple[Array, str]]:
        """Return labels to values and units of what is drawn."""
        labels = [label] if isinstance(label, str) else list(label)
        if len(labels) not in (0, len(columns)) and labels != [""]:
            raise ArgumentError(
                f"label has {len(labels)} names for {len(columns)} lines: give one for each"
            )
        drawn: dict[str, tuple[Array, str]] = {}
        for index, column in enumerate(columns):
            if isinstance(column, str):
                name, (values, unit) = column, self._column(column, known)
            else:
                name, values, unit = _labelled(column, f"array {index + 1}", count)
            given = labels[index] if labels not in ([], [""]) else name
            drawn[given] = values, unit
        return drawn

    def _column(self, name: str, known: Mapping[str, tuple[Array, str]]) -> tuple[Array, str]:
        """Return values and unit of a column."""
        if name not in known:
            raise ArgumentError(f"no column {name!r}; columns: {choices(known, name)}")
        values, unit = known[name]
        if values.dtype.kind not in "biuf":
            raise ArgumentError(f"column {name!r} holds words, which cannot be drawn")
        return np.asarray(values, dtype=float), unit


class MotionPlot(Plot):
    """Draws a sweep or a trajectory: `sweep.plot("bearing_out")`.

    What is drawn of joints is exerted by the parent link on the child link; a star marks what
    statics leaves open.
    """

    def __call__(
        self,
        *columns: Any,
        x: Any = "",
        quantities: str | Sequence[str] = (),
        label: str | Sequence[str] = "",
        xlabel: str = "",
        **options: Any,
    ) -> Figure:
        """Draw wrenches of joints over the drive's position or time, or columns of the table.

        Args:
            columns: names of joints, or names of columns of the table or arrays (see `Plot`), not
                of both; if there is none, the efforts of drives and actuated joints with their
                limits, and joints that are driven, loaded or hang on the ground: four at most, on
                which most acts.
            x: name of a joint, whose position is the abscissa, or of a column, or an array `(N,)`;
                the position of the first drive, or the time of a trajectory, if empty.
            quantities: of joints: `torsion`, `bending`, `axial`, `shear`, and the sizes `force` and
                `moment`; each has its own axes. The first four, without those that are all but zero
                beside the whole force or moment, if empty; the sizes of joints without an axis.
            label: of the lines, see `Plot`; of joints, one if there is one.
            xlabel: of the abscissa, with its unit; its name if empty.
            options: see `Plot`; axes are one for each quantity or unit.

        Raises:
            MissingExtraError: matplotlib is not installed.
            ArgumentError: there is no such joint or column, an array of another length, the result
                has several dimensions, or other axes than are needed.
        """
        turn = self._result
        asked = [name for name in columns if isinstance(name, str) and name in turn.outputs]
        if 0 < len(asked) < len(columns):
            raise ArgumentError(
                f"joints and columns are not drawn together: name columns of {asked[0]!r}, such "
                f'as "{asked[0]}.bending" or "{asked[0]}.shear"'
            )
        joints = asked if columns else list(self._bearings())
        if not joints:
            # Where no wrench was asked for, efforts that act are drawn: what is free has none.
            known = {} if columns else self._table().columns()
            driven = [key for key in known if key.endswith("drive_effort") and known[key][0].any()]
            shown = columns or driven
            return super().__call__(*shown, x=x, label=label, xlabel=xlabel, **options)
        from ...figures.style import in_look, refuse_grid
        from ...figures.wrenches import wrench_panels

        refuse_grid(turn)
        # Quantities have their own ordinates.
        own, line = _divided({k: v for k, v in options.items() if k != "ylabel"}, *_OWN)
        if label:
            if len(joints) > 1:
                raise ArgumentError("label is that of one joint: name one, or leave label out")
            line["label"] = label if isinstance(label, str) else label[0]
        drawn = names("quantities", quantities) if quantities else ()
        others = [name for name in turn.outputs if name not in joints and not columns]
        return in_look(wrench_panels)(
            turn,
            joints,
            self._over(x, xlabel),
            drawn,
            others=others,
            above=[] if columns or drawn or "ax" in options else self._of_drives(),
            line=line,
            **self._titled(own),
        )

    def _of_drives(self) -> list[Panel]:
        """Return panels of the efforts of drives and actuated joints that act, one for a unit."""
        from ...figures.panels import Panel

        turn, limits = self._result, effort_limits(self._result.mechanism)
        held = getattr(turn, "sweep", turn).holding_effort
        found: dict[str, Panel] = {}
        for name, values in efforts(turn).items():
            if name in held or not np.any(values):
                continue
            unit = turn.mechanism.drivable[name].effort_unit
            panel = found.setdefault(unit, Panel(f"effort of drives [{unit}]", unit, 0.0, {}, {}))
            panel.curves[name] = values
            if name in limits:
                panel.limits[name] = limits[name]
        return list(found.values())

    def _titled(self, options: Mapping[str, Any]) -> dict[str, Any]:
        """Return options with the case as the title of a new figure that was given none."""
        case = case_line(self._result) if options.get("ax") is None else ""
        return {"title": case, **options}

    def over_time(
        self, joints: str | Sequence[str] = (), *arguments: Any, **options: Any
    ) -> Figure:
        """Draw torsion and bending of joints over time, see `figures.over_time`."""
        from ...figures.over_time import over_time

        drawn = joints or self._bearings()
        return over_time(self._result, drawn, *arguments, **self._titled(options))

    def energy(self, **options: Any) -> Figure:
        """Draw the energies of a trajectory and what is wrong with them.

        Arguments and errors are those of `figures.energy_over_time`.
        """
        from ...figures.over_time import energy_over_time

        return energy_over_time(self._result, **self._titled(options))

    def ratio(self, output: str, *, label: str = "", **options: Any) -> Figure:
        """Draw speed ratio and angle error of a joint, see `figures.ratio_and_angle_error`.

        Args:
            output: joint whose motion is shown.
            label: of the lines; the name of the mechanism if empty.
            options: of `figures.ratio_and_angle_error`.
        """
        from ...figures.over_angle import ratio_and_angle_error

        turns = {label or self._result.mechanism.name: self._result}
        return ratio_and_angle_error(turns, output=output, **self._titled(options))

    def polar(
        self,
        joints: str | Sequence[str] = (),
        frames: str | Sequence[str] = "parent",
        *,
        of: str = "",
        **options: Any,
    ) -> Figure:
        """Draw the curve of a joint's moment or force, see `figures.moment_polar`.

        Args:
            joints: one joint or several; each is a diagram; see `__call__` if there is none.
            frames: `parent`, `joint` or `world`, or several of them.
            of: `moment` or `force`; if empty, the moment, unless there is none across the axes.
            options: of `figures.moment_polar`.

        Raises:
            ArgumentError: `of` is neither.
        """
        from ...figures.polar import force_polar, moment_polar

        kinds = {"moment": moment_polar, "force": force_polar}
        drawn = names("joints", joints) if joints else list(self._bearings())
        if of and of not in kinds:
            raise ArgumentError(f"of is {described(of)}; it is {choices(kinds)}")
        kind = kinds[of or self._most_asked(drawn)]
        return kind(self._result, drawn, frames, **self._titled(options))

    def orders(self, *columns: str, **options: Any) -> Figure:
        """Draw the amplitudes of columns over the orders of revolution.

        Sizes (`.bending`, `.shear`, `.force_magnitude`, `.moment_magnitude`) have orders that no
        component has: in their place components of the vector are drawn, across the joint's axis
        if it has one, in axes that stand still (`bearing_out moment y`: the parent's, or the
        world's where the parent turns). Orders from half as many on as there are samples in a turn
        appear as lower ones.

        Args:
            columns: names of columns of one unit, see `Plot`; if there is none, of the joints that
                are drawn without being named: bending, or shear where there is no bending.
            options: of `figures.order_spectrum`, which draws them over the first drive.

        Raises:
            ArgumentError: there is no such column, they have several units, or the drive's
                positions are not whole turns in even steps.
        """
        from ...figures.orders import order_spectrum
        from ...figures.style import drive_of
        from .axes import in_fixed_axes

        position = self._result.motion.position(drive_of(self._result, None))
        known = self._table().columns()
        if not columns:
            joints = self._bearings()
            quantity = "bending" if self._most_asked(joints) == "moment" else "shear"
            columns = tuple(f"{name}.{quantity}" for name in joints)
        values = {name: self._column(name, known) for name in columns}
        units = {unit for _, unit in values.values()}
        if len(units) != 1:
            raise ArgumentError(f"name columns of one unit, not of: {choices(sorted(units))}")
        unit, shown = units.pop(), {}
        marked, opened = self._marked(columns), set()
        for name, (column, _) in values.items():
            joint, _, quantity = name.rpartition(".")
            if quantity not in _SIZES or joint not in self._result.outputs:
                shown[f"{name} *" if name in marked else name] = column
                opened |= {joint} if name in marked else set()
                continue
            turn = getattr(self._result, "sweep", self._result)
            size = float(np.max(np.abs(column), initial=0.0))
            for part, (component, unique) in in_fixed_axes(turn, joint, _SIZES[quantity]).items():
                acts = bool(np.max(np.abs(component), initial=0.0) > _ROUNDING * size)
                if acts or not size:
                    shown[f"{joint} {part}{'' if unique else ' *'}"] = component
                    opened |= set() if unique else {joint}
        note = self._note(columns, opened)
        return order_spectrum(position, shown, unit=unit, note=note, **self._titled(options))

    def _draw(
        self,
        at: Abscissa,
        drawn: Mapping[str, tuple[Array, str]],
        known: Mapping[str, tuple[Array, str]],
        **options: Any,
    ) -> Figure:
        # A label of its own hides the name of a column, by its values it is found again.
        names = {
            label: label
            if label in known
            else next((k for k, item in known.items() if np.array_equal(item[0], values)), label)
            for label, (values, _) in drawn.items()
        }
        found = self._marked(list(names.values()))
        marked = [label for label, name in names.items() if name in found]
        note = self._note(list(names.values()), {name.rpartition(".")[0] for name in found})
        titled = self._titled(options)
        return super()._draw(at, drawn, known, marked=marked, note=note, **titled)

    def _abscissa(
        self, x: Any, label: str, table: Table, known: Mapping[str, tuple[Array, str]]
    ) -> Abscissa:
        turn = self._result
        if isinstance(x, str) and not x and (self._has_task or np.ndim(turn.time) == 1):
            return self._over(x, label)
        if isinstance(x, str) and f"{x}.task_position" in known:
            label = label or super()._abscissa(f"{x}.task_position", "", table, known).label
            return super()._abscissa(
                f"{x}.task_position", label.replace(".task_position", ""), table, known
            )
        if isinstance(x, str) and x not in known:
            first = turn.coordinates[0] if turn.coordinates else ""
            if x in turn.mechanism.drivable:
                from ...figures.wrenches import along

                at = along(turn, x)
                return at._replace(label=label or at.label)
            if x and x in turn.mechanism.joints:
                raise ArgumentError(
                    f"joint {x!r} has no position to be drawn over; x is one of: "
                    f"{choices(turn.mechanism.drivable, first)}"
                )
        if (
            isinstance(x, str)
            and (x or table.abscissa) == "position"
            and len(turn.coordinates) == 1
        ):
            # The position of the only drive is told by the name of the drive.
            from ...figures.style import plain

            label = label or super()._abscissa(x, "", table, known).label.replace(
                "position", plain(turn.coordinates[0]), 1
            )
        return super()._abscissa(x, label, table, known)

    def _column(self, name: str, known: Mapping[str, tuple[Array, str]]) -> tuple[Array, str]:
        if name not in known:
            turn = self._result
            if name in turn.mechanism.joints:
                turn.wrench(name)  # Says that it was not asked for.
            raise ArgumentError(
                f"no column {name!r}; columns: {choices(known, name)}; joints: "
                f"{choices(turn.outputs, name)}"
            )
        return super()._column(name, known)

    def _scales(self, known: Mapping[str, tuple[Array, str]]) -> dict[str, float]:
        from ...figures.wrenches import together

        force, moment = (_greatest(known, unit) for unit in _FORCES)
        return together(force, moment, self._result.mechanism.characteristic_length)

    def _over(self, x: Any, label: str) -> Abscissa:
        """Return what wrenches are drawn over, without all columns where they are not needed."""
        from ...figures.over_time import times_of

        turn = self._result
        if isinstance(x, str) and not x:
            is_timed = np.ndim(turn.time) == 1 or not turn.coordinates
            at = times_of(turn) if is_timed else self._led()
            return at._replace(label=label or at.label)
        table = self._table()
        return self._abscissa(x, label, table, table.columns())

    def _led(self) -> Abscissa:
        """Return the first of what moves as given that goes one way only, or else the samples."""
        from ...figures.style import over

        leads = self._result.leads
        varied = [lead for lead in leads if np.ptp(lead.position)]
        one_way = [
            lead
            for lead in varied
            if abs(np.sum(np.sign(np.diff(lead.position)))) == len(lead.position) - 1
        ]
        if len(varied) > 1 and not one_way:
            return over("sample", np.arange(len(leads[0].position)), "")
        name, slides, position, _ = (one_way or varied or leads)[0]
        return over(name, position, "m" if slides else "rad")

    @property
    def _has_task(self) -> bool:
        """Whether it is a sweep over rows of a task."""
        return hasattr(self._result, "rows") and not hasattr(self._result, "kinetic_energy")

    def _bearings(self) -> tuple[str, ...]:
        """Return the joints that are asked for first: bearings on the ground, drives and loads."""
        turn = self._result
        acted_on = {*turn.coordinates, *turn.loads}
        found = [
            name
            for name in turn.outputs
            if name not in turn.held and (name in acted_on or name in turn.mechanism.grounded)
        ] or list(turn.outputs)
        if len(found) <= _MOST_JOINTS:
            return tuple(found)
        length = turn.mechanism.characteristic_length
        sizes = {
            name: _size_of(turn[name].force) + _size_of(turn[name].moment) / length
            for name in found
        }
        greatest = sorted(found, key=lambda name: -sizes[name])[:_MOST_JOINTS]
        return tuple(name for name in found if name in greatest)

    def _most_asked(self, joints: Sequence[str]) -> str:
        """Return `moment` where there is one across the axes of joints, else `force`."""
        turn = self._result
        wrenches = [turn[name] for name in joints]
        length = turn.mechanism.characteristic_length
        whole = [_size_of(w.moment) for w in wrenches] + [
            length * _size_of(w.force) for w in wrenches
        ]
        across = [_size_of(w.bending_vector if w.has_axis else w.moment) for w in wrenches]
        acts = max(across, default=0.0) > _ROUNDING * max(whole, default=0.0)
        # In a plane mechanism statics knows the forces alone.
        known = any(np.all(w.unique[3:]) for w in wrenches) or not any(
            np.any(w.unique[:3]) for w in wrenches
        )
        return "moment" if known and (acts or not any(whole)) else "force"

    def _marked(self, columns: Sequence[str]) -> set[str]:
        """Return which columns statics leaves open."""
        from ...figures.wrenches import UNITS, determined

        turn, marked = self._result, set()
        for column in columns:
            owner, _, quantity = column.rpartition(".")
            whole, _, component = quantity.partition("_")
            known = quantity != "coupling_moment" or turn.coupling_unique.get(owner, True)
            if owner in turn.outputs:
                wrench, is_vector = turn[owner], whole in ("force", "moment")
                if quantity in UNITS and wrench.has_axis:
                    known = determined(wrench, quantity)
                elif is_vector and component == "magnitude":
                    known = determined(wrench, whole)
                elif is_vector and component in ("x", "y", "z"):
                    known = determined(wrench, whole, ["xyz".index(component)])
            if not known:
                marked.add(column)
        return marked

    def _note(self, columns: Sequence[str], opened: Collection[str]) -> str:
        """Return whose wrenches are drawn, if any is, and what a star means at what is `opened`."""
        from ...figures.wrenches import sign_note

        parts = ("force", "moment", "torsion", "bending", "axial", "shear")
        named = (column.rpartition(".") for column in columns)
        of_wrenches = (n in self._result.outputs and q.startswith(parts) for n, _, q in named)
        return sign_note(self._result, opened) if opened or any(of_wrenches) else ""


def _first(table: Table) -> tuple[str, ...]:
    """Return the first numbers of a table that were not given, with others of their variable."""
    for name, variable in table.variables:
        if not variable.is_coordinate and variable.values.dtype.kind in "biuf":
            return tuple(replace(table, variables=[(name, variable)]).columns())[:_MOST_JOINTS]
    return ()


def _divided(given: Mapping[str, Any], *names: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the options of a figure that are named, and the others, properties of lines.

    Raises:
        ArgumentError: matplotlib knows no such property of a line.
    """
    own = {name: value for name, value in given.items() if name in names}
    line = {name: value for name, value in given.items() if name not in own}
    for name in line:
        if name in _INSTEAD:
            raise ArgumentError(f"no option {name!r} of a plot: {_INSTEAD[name]}")
    if line:
        from ...figures.style import require_matplotlib

        require_matplotlib()
        from matplotlib.lines import Line2D
    for name in line:
        if not hasattr(Line2D, f"set_{name}"):
            known = ["x", "ax", "figsize", "title", "label", "xlabel", "ylabel", "peaks", "color"]
            known += ["linestyle", "linewidth", "marker", "alpha"]
            raise ArgumentError(f"no option {name!r} of a plot; options: {choices(known, name)}")
    return own, line


def own_options(given: Mapping[str, Any], *names: str) -> dict[str, Any]:
    """Return the options of a figure that has no lines of columns.

    Args:
        given: options by name.
        names: of those that the figure has besides `title`, `ax` and `figsize`.

    Raises:
        ArgumentError: it has no such option.
    """
    known = (*names, "title", "ax", "figsize")
    for name in given:
        if name not in known:
            raise ArgumentError(
                f"no option {name!r} of this figure; options: {choices(known, name)}; figures of "
                "columns that are named have more, see results.plot"
            )
    return dict(given)


def _labelled(values: Any, name: str, count: int) -> tuple[str, Array, str]:
    """Return name, values `(N,)` and unit of an array, of which those of xarray know all.

    Args:
        values: the array.
        name: how messages and figures call it unless it has a name.
        count: N.

    Raises:
        ArgumentError: it is no array of numbers, or has another shape.
    """
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise ArgumentError(
            f"{name} is {described(values)}, expected a name or an array of numbers"
        ) from error
    if array.shape != (count,):
        more = ": take one of its columns, as in values[:, 2]" if array.ndim > 1 else ""
        raise ArgumentError(f"{name} has shape {array.shape}, expected {(count,)}{more}")
    told = getattr(values, "attrs", {})
    own = told.get("long_name") or getattr(values, "name", None)
    return str(own or name), array, str(told.get("units", ""))


def _size(table: Table) -> int:
    return next(iter(table.samples.values()), 1)


def _size_of(vectors: Array) -> float:
    return float(np.max(np.abs(vectors), initial=0.0))


def _greatest(known: Mapping[str, tuple[Array, str]], unit: str) -> float:
    """Return the greatest value of all columns of a unit."""
    sizes = (
        np.max(np.abs(values), where=np.isfinite(values), initial=0.0)
        for values, its in known.values()
        if its == unit
    )
    return float(max(sizes, default=0.0))
