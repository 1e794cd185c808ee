"""Looking: what a study says, from its Dataset: figures, percentiles' causes, samples by kind."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...figures import designs
from ...figures.wrenches import MARK
from ...kit.arrays import Array
from ...kit.errors import ArgumentError, choices
from .sweeps import OPEN

if TYPE_CHECKING:
    import xarray

    from ...figures.style import Figure

_PARTS = 10
"""Parts of all samples, along each parameter, over which a tornado diagram takes means."""
_RESAMPLES = 400
"""Resamples from which intervals of Sobol indices are taken: their ends hold to a tenth or so."""


def plot_map(
    data: xarray.Dataset,
    name: str,
    *,
    x: str = "",
    y: str = "",
    limit: float | None = None,
    title: str = "",
    ax: Any = None,
    figsize: tuple[float, float] | None = None,
    **at: Any,
) -> Figure:
    """Draw a map of a result over two parameters of a grid; cases without a result are grey.

    Args:
        data: of a study.
        name: of the result.
        x: dimension along the abscissa; the first other than `y` if empty.
        y: dimension along the ordinate; the next one if empty.
        limit: value along which a line is drawn [the unit of the result].
        title: of the figure.
        ax: axes to be drawn into instead of a new figure.
        figsize: width and height of a new figure [inch].
        at: other dimensions to the values at which they are looked at, the nearest ones.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ArgumentError: there is no such result or dimension, or another one is not given.
    """
    drawn = _over_two(data, name, x, y, at, title)
    return designs.value_map(limit=limit, ax=ax, figsize=figsize, **drawn)


def plot_contours(
    data: xarray.Dataset,
    name: str,
    *,
    x: str = "",
    y: str = "",
    limit: float | None = None,
    title: str = "",
    ax: Any = None,
    figsize: tuple[float, float] | None = None,
    **at: Any,
) -> Figure:
    """Draw lines of equal values of a result over two parameters, with that of a limit.

    Args:
        data: see `plot_map`, for all arguments.
        name: of the result.
        x: dimension along the abscissa; the first other than `y` if empty.
        y: dimension along the ordinate; the next one if empty.
        limit: value along which a thick line is drawn; what lies beyond is hatched. The title says
            so where all or nothing does.
        title: of the figure.
        ax: axes to be drawn into instead of a new figure.
        figsize: width and height of a new figure [inch].
        at: other dimensions to values.

    Raises:
        ArgumentError: as `plot_map`, or too few values.
    """
    drawn = _over_two(data, name, x, y, at, title)
    return designs.contour_map(limit=limit, ax=ax, figsize=figsize, **drawn)


def plot_tornado(
    data: xarray.Dataset,
    name: str,
    *,
    title: str = "",
    ax: Any = None,
    figsize: tuple[float, float] | None = None,
) -> Figure:
    """Draw between which values each parameter moves a result.

    Of a grid, the others then are in the middle of their values. Of samples, values are means over
    each tenth of all samples, from the lowest to the highest values of the parameter. Bars go to
    the result at both ends of the parameter, whose values stand below its name; a line spans all
    results between them, by whose length parameters are ranked.

    Args:
        data: of a study.
        name: of the result, a number per case.
        title: of the figure.
        ax: axes to be drawn into instead of a new figure.
        figsize: width and height of a new figure [inch].

    Raises:
        ArgumentError: there is no such result, a case has several, or that in the middle has none.
    """
    values = _numbers(data, name)
    ranges: dict[str, Array] = {}
    parameters = _parameters(data)
    if all(column.dims == (label,) for label, column in parameters.items()):
        centre = {dim: size // 2 for dim, size in values.sizes.items()}
        middle = float(values.isel(centre))
        if not np.isfinite(middle):
            raise ArgumentError(f"{name}: the case in the middle of all has no result")
        for label in parameters:
            along = values.isel({dim: at for dim, at in centre.items() if dim != label})
            ranges[_between(label, data[label][[0, -1]])] = np.asarray(along, dtype=float)
    else:
        plain = independent(data)
        found = _numbers(plain, name)
        for column in _parameters(plain).values():
            edges = np.quantile(column, np.linspace(0.0, 1.0, _PARTS + 1))
            parts = [(column >= low) & (column <= high) for low, high in pairwise(edges)]
            at = [float(column.where(part).mean()) for part in (parts[0], parts[-1])]
            ends = column.copy()[:2].copy(data=at)
            ranges[_between(str(column.name), ends)] = np.array(
                [float(found.where(part).mean()) for part in parts]
            )
        middle = float(found.mean())
    title = _joined(title, _missing(values))
    label = _label(data[name])
    return designs.tornado(ranges, middle=middle, label=label, title=title, ax=ax, figsize=figsize)


def plot_scatter(
    data: xarray.Dataset,
    name: str,
    *,
    limit: float | None = None,
    title: str = "",
    ax: Any = None,
    figsize: tuple[float, float] | None = None,
) -> Figure:
    """Draw a result over each parameter, a point for each case.

    Args:
        data: of a study.
        name: of the result, a number per case.
        limit: value at which a line is drawn.
        title: of the figure.
        ax: axes to be drawn into instead of a new figure, one for each parameter.
        figsize: width and height of a new figure [inch].

    Raises:
        ArgumentError: there is no such result, or a case has several.
    """
    columns, values, missing = _flat(data, [name])
    label = _label(data[name])
    return designs.scatter(
        columns,
        values[label],
        label=label,
        limit=limit,
        title=_joined(title, missing),
        ax=ax,
        figsize=figsize,
    )


def plot_parallel(
    data: xarray.Dataset,
    *names: str,
    limit: float | None = None,
    title: str = "",
    ax: Any = None,
    figsize: tuple[float, float] | None = None,
) -> Figure:
    """Draw each case as a line over all parameters and some results.

    Args:
        data: of a study.
        names: of the results, a number per case each; the last one colours the lines.
        limit: value of that beyond which lines are dashed.
        title: of the figure.
        ax: axes to be drawn into instead of a new figure.
        figsize: width and height of a new figure [inch].

    Raises:
        ArgumentError: there is no such result, none is named, or a case has several.
    """
    if not names:
        raise ArgumentError(f"name results: {choices(map(str, data.data_vars))}")
    columns, values, missing = _flat(data, list(names))
    return designs.parallel_coordinates(
        {**columns, **values},
        limit=limit,
        title=_joined(title, missing),
        ax=ax,
        figsize=figsize,
    )


class StudyPlot:
    """Draws a study: `study.plot("force")`, in the way that fits its parameters.

    Args:
        study: with a dataset.
    """

    def __init__(self, study: Any) -> None:
        self._study = study

    def __call__(self, name: str = "", **options: Any) -> Figure:
        """Draw a result: over samples as points, over a grid as a map, over one axis as a line.

        Args:
            name: of the result, the first one that is a number per case if empty.
            options: of `plot_scatter` or `plot_map`; over one axis, `title`, `ax` and `figsize`.

        Raises:
            ArgumentError: as there.
        """
        data = self._study.dataset
        name = name or self._first(data)
        values = _numbers(data, name)
        parameters = _parameters(data)
        if any(column.dims != (label,) for label, column in parameters.items()):
            return plot_scatter(data, name, **options)
        if len(values.dims) > 1:
            chosen = [options[name] for name in ("x", "y") if name in options]
            rest = [str(dim) for dim in values.dims if dim not in (*chosen, *options)]
            # What is none of both axes is looked at in the middle of its values, unless given.
            for dim in rest[2 - len(chosen) :]:
                options[dim] = data[dim].values[data.sizes[dim] // 2]
            return plot_map(data, name, **options)
        from ...figures.columns import over_column
        from ...figures.style import in_look, over

        column = next(iter(parameters.values()))
        at = over(str(column.name), np.asarray(column), column.attrs.get("units", ""))
        drawn = {name: (np.asarray(values, dtype=float), values.attrs.get("units", "") or "1")}
        options["title"] = _joined(options.get("title", ""), _missing(values))
        return in_look(over_column)(at, drawn, **options)

    def map(self, name: str, **options: Any) -> Figure:
        """Draw a result over two parameters, see `plot_map`."""
        return plot_map(self._study.dataset, name, **options)

    def contours(self, name: str, **options: Any) -> Figure:
        """Draw lines of equal values of a result, see `plot_contours`."""
        return plot_contours(self._study.dataset, name, **options)

    def tornado(self, name: str, **options: Any) -> Figure:
        """Draw what each parameter moves, see `plot_tornado`."""
        return plot_tornado(self._study.dataset, name, **options)

    def scatter(self, name: str, **options: Any) -> Figure:
        """Draw a result over each parameter, see `plot_scatter`."""
        return plot_scatter(self._study.dataset, name, **options)

    def parallel(self, *names: str, **options: Any) -> Figure:
        """Draw each case as a line over all parameters, see `plot_parallel`."""
        return plot_parallel(self._study.dataset, *names, **options)

    def __repr__(self) -> str:
        names = ("map", "contours", "tornado", "scatter", "parallel")
        return f"<Figures of a Study: plot(), {', '.join(f'plot.{name}' for name in names)}>"

    @staticmethod
    def _first(data: xarray.Dataset) -> str:
        """Return the first result that is a number per case."""
        own = {block["dim"] for block in _told(data)}
        for name, values in data.data_vars.items():
            is_number = values.dtype.kind in "biuf" and {str(dim) for dim in values.dims} <= own
            if is_number and name != "state":
                return str(name)
        raise ArgumentError(f"no result is a number per case: {choices(map(str, data.data_vars))}")


class SobolIndices(NamedTuple):
    """What parts of a result's variance parameters cause.

    Attributes:
        first_order: parameter to the part that it causes by itself.
        total: parameter to the part that it causes by itself and together with others.
        first_order_interval: parameter to the ends of the 95 % confidence interval of its first
            index, by resampling the samples as if they were random: those of Sobol's sequence tell
            rather more.
        total_interval: the same of its total index.
    """

    first_order: dict[str, float]
    total: dict[str, float]
    first_order_interval: dict[str, tuple[float, float]]
    total_interval: dict[str, tuple[float, float]]

    def __str__(self) -> str:
        width = max(map(len, ("parameter", *self.first_order)))
        lines = [f"{'parameter':{width}}  {'first order':>22}  {'total':>22}"]
        for name in self.first_order:
            cells = (
                f"{value[name]:6.3f} ({ends[name][0]:.3f} … {ends[name][1]:.3f})"
                for value, ends in (
                    (self.first_order, self.first_order_interval),
                    (self.total, self.total_interval),
                )
            )
            lines.append(f"{name:{width}}  {'  '.join(f'{cell:>22}' for cell in cells)}")
        return "\n".join(lines)


def sobol_indices(data: xarray.Dataset, name: str) -> SobolIndices:
    """Return what each parameter contributes to the variance of a result.

    By `scipy.stats.sobol_indices`, from the results of a study of `sobol_samples`.

    Args:
        data: of the study, of one dimension.
        name: of the result, a number per case.

    Raises:
        ArgumentError: the study is none of `sobol_samples`, a case failed, or the result does not
            vary: then the estimate has no meaning.
    """
    from scipy import stats

    matrices = _matrices(data)
    values = np.asarray(_numbers(data, name))
    if not np.all(np.isfinite(values)):
        count = int(np.count_nonzero(~np.isfinite(values)))
        raise ArgumentError(
            f"{name} is missing in {count} cases: let the function return a number there, or "
            "run(retry=True)"
        )
    if np.ptp(values) == 0.0:
        raise ArgumentError(f"{name} is the same in all cases: no parameter changes it")
    table = values.reshape(-1, matrices).T
    names = list(_parameters(data))

    def indices(rows: Array) -> Array:
        """Return first and total indices `(2, k)`, by some of the samples."""
        of = table[:, rows]
        func = {"f_A": of[None, 0], "f_B": of[None, 1], "f_AB": of[2:, None]}
        found = stats.sobol_indices(func=func, n=len(rows))
        return np.stack([np.ravel(found.first_order), np.ravel(found.total_order)])

    every = np.arange(table.shape[1])
    # Always the same resamples, so that the same data say the same.
    chance = np.random.default_rng(0)
    with np.errstate(divide="ignore", invalid="ignore"):  # A resample of few may not vary.
        again = [indices(chance.choice(every, len(every))) for _ in range(_RESAMPLES)]
    ends = np.nanquantile(again, [0.025, 0.975], axis=0)
    parts = [dict(zip(names, part, strict=True)) for part in indices(every).tolist()]
    intervals = [
        {name: (low, high) for name, low, high in zip(names, *part, strict=True)}
        for part in ends.transpose(1, 0, 2).tolist()
    ]
    return SobolIndices(*parts, *intervals)


def independent(data: xarray.Dataset) -> xarray.Dataset:
    """Return the samples of a study that are independent of each other.

    Of `sobol_samples` those are two for each; of anything else, all.

    Args:
        data: of a study.
    """
    if len(data.sizes) == 0 or "study_parameters" not in data.attrs:
        return data
    told = _told(data)
    for block in told:
        if block.get("matrices", 1) > 1:
            places = np.arange(data.sizes[block["dim"]]) % block["matrices"]
            data = data.isel({block["dim"]: np.flatnonzero(places < 2)})
    return data


def _told(data: xarray.Dataset) -> list[dict[str, Any]]:
    import json

    if "study_parameters" not in data.attrs:
        raise ArgumentError("data is not the dataset of a study, whose attributes say what varies")
    return [item["block"] for item in json.loads(data.attrs["study_parameters"])]


def _matrices(data: xarray.Dataset) -> int:
    told = _told(data)
    if len(told) != 1 or told[0].get("matrices", 1) == 1:
        raise ArgumentError("Sobol indices need a study of studies.sobol_samples(…) alone")
    return int(told[0]["matrices"])


def _parameters(data: xarray.Dataset) -> dict[str, Any]:
    """Return the parameters of a study, in their order."""
    names = [name for block in _told(data) for name in block["units"]]
    return {name: data[name] for name in names if name in data.coords}


def _numbers(data: xarray.Dataset, name: str) -> Any:
    """Return a result that is a number per case."""
    values = _result(data, name)
    own = {block["dim"] for block in _told(data)}
    if more := [str(dim) for dim in values.dims if dim not in own]:
        raise ArgumentError(
            f"{name} has {choices(more)} besides the parameters: take one of its values, as in "
            f"data.assign(peak=data[{name!r}].max({more[0]!r}))"
        )
    return values


def _result(data: xarray.Dataset, name: str) -> Any:
    if name not in data.data_vars:
        listed = [str(label) for label in data.data_vars]
        raise ArgumentError(f"no result {name!r}; results: {choices(listed, name)}")
    return data[name]


def _over_two(
    data: xarray.Dataset, name: str, x: str, y: str, at: Mapping[str, Any], title: str
) -> dict[str, Any]:
    """Return a result over two dimensions, with labels, and where the others are in the title."""
    values = _result(data, name)
    dims = [str(dim) for dim in values.dims]
    others = (dim for dim in dims if dim not in (x, y, *at))
    x, y = x or next(others, ""), y or next(others, "")
    if not (x and y):
        raise ArgumentError(
            f"{name} varies along {choices(dims)}, and a map needs two dimensions: draw it by "
            f"data[{name!r}].plot()"
        )
    for dim in (x, y, *at):
        if dim not in dims:
            raise ArgumentError(
                f"{name} has no dimension {dim!r}; dimensions: {choices(dims, dim)}"
            )
    for dim, place in at.items():
        values = values.sel({dim: place}, method="nearest")
    if rest := [dim for dim in dims if dim not in (x, y, *at)]:
        way = f"{rest[0]}=…" if rest[0].isidentifier() else f'**{{"{rest[0]}": …}}'
        raise ArgumentError(f"say at which value of {choices(rest)}, as the last argument: {way}")
    values = values.transpose(x, y)
    across, labels_x = _axis(data, x)
    up, labels_y = _axis(data, y)
    return {
        "x": across,
        "y": up,
        "values": values,
        "labels": (labels_x, labels_y, _label(data[name])),
        "title": _joined(title, *(f"{dim} = {_valued(values[dim])}" for dim in at)),
    }


def _joined(*parts: str) -> str:
    return ", ".join(part for part in parts if part)


def _axis(data: xarray.Dataset, dim: str) -> tuple[Array, str]:
    """Return values of a dimension as they are drawn, and their label."""
    if dim not in data.coords:
        return np.arange(data.sizes[dim], dtype=float), dim
    shown = _shown(data[dim])
    return np.asarray(shown, dtype=float), _label(shown)


def _shown(parameter: Any) -> Any:
    """Return values of a parameter as they are drawn: angles in degrees."""
    if parameter.attrs.get("units") != "rad":
        return parameter
    return parameter.copy(data=np.rad2deg(np.asarray(parameter))).assign_attrs(units="°")


def _valued(parameter: Any, digits: int = 4) -> str:
    """Return one value of a parameter, or several, with their unit, in words."""
    shown = _shown(parameter)
    unit = shown.attrs.get("units", "")
    numbers = " … ".join(f"{value:.{digits}g}" for value in np.ravel(shown))
    return numbers + {"": "", "1": "", "°": "°"}.get(unit, f" {unit}")


def _missing(values: Any) -> str:
    """Return how many of some results are none, in words; empty if all are there."""
    count = int(np.count_nonzero(~np.isfinite(values)))
    return f"no result: {count} of {values.size}" if count else ""


def _flat(data: xarray.Dataset, names: list[str]) -> tuple[dict[str, Array], dict[str, Array], str]:
    """Return parameters and results `(N,)` of the cases with all of the results, and of the others.

    The latter are counted, in words.
    """
    import xarray

    plain = independent(data)
    parameters = _parameters(plain)
    results = [_numbers(plain, name) for name in names]
    shown = [_shown(parameter) for parameter in parameters.values()]
    every = xarray.broadcast(*shown, *results)
    columns = [np.asarray(item, dtype=float).ravel() for item in every]
    there = np.all(np.isfinite(np.stack(columns)), axis=0)
    missing = _missing(np.where(there, 0.0, np.nan))
    labels = [_label(item) for item in (*shown, *results)]
    found = [column[there] for column in columns]
    count = len(parameters)
    return (
        dict(zip(labels[:count], found[:count], strict=True)),
        dict(zip(labels[count:], found[count:], strict=True)),
        missing,
    )


def _between(name: str, ends: Any) -> str:
    """Return a parameter's name above the values between which it varies."""
    return f"{name}\n{_valued(ends, digits=3)}"


def _label(item: Any) -> str:
    """Return name and unit of a variable, with a star where statics leaves it open."""
    unit = item.attrs.get("units", "")
    name = f"{item.name} [{unit}]" if unit and unit != "1" else str(item.name)
    return name + MARK if OPEN in item.attrs else name
