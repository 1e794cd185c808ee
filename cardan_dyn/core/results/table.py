"""Table: values with names for dimensions and units, as Dataset, DataFrame or file.

A Dataset has the dimensions of the variables. A DataFrame has a row per sample (of a grid: in C
order, with an index per dimension), and a flat column per value: `name.quantity` for what belongs
to something with a name, `name.quantity_x` for components.
"""

from __future__ import annotations

import csv
import json
import math
import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import cycle
from operator import add
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...kit.arrays import Array
from ...kit.checks import described, file_path, writing
from ...kit.errors import ArgumentError, MissingExtraError, ModelError, choices
from ...kit.frozen import frozen

if TYPE_CHECKING:
    import pandas
    import xarray

SUFFIXES = (".csv", ".json", ".nc", ".parquet")
_IN_FRONT = {"moving_joint": "joint_", "point": "point_"}
"""Dimensions to what the names of variables along them begin with, and names of columns do not."""


class Variable(NamedTuple):
    """Values with names for their dimensions.

    Attributes:
        dims: names of the dimensions.
        values: an array of these.
        units: one for all values, or one per entry of the last dimension.
        long_name: what they are.
        is_coordinate: whether they were given, as drive positions and loads are, and not solved.
    """

    dims: tuple[str, ...]
    values: Array
    units: str | tuple[str, ...]
    long_name: str
    is_coordinate: bool = False

    @property
    def unit(self) -> str:
        """All units that occur, in one text."""
        units = (self.units,) if isinstance(self.units, str) else self.units
        return " or ".join(dict.fromkeys(units))


@dataclass(frozen=True, eq=False)
class Table:
    """What a result holds, before it is a Dataset or a DataFrame.

    Attributes:
        variables: names and values, in the order of columns.
        samples: dimensions that become rows of a DataFrame, and their sizes.
        labels: dimension to the names along it; dimensions of a Dataset that have none are counted.
        units: coordinate to the dimension along which it tells units, and these.
        attributes: of the whole table: numbers and texts, so that any file format takes them.
        flags: variables of a Dataset over no samples: name to dimensions, values and attributes.
        frame_attributes: what a DataFrame has in their place.
    """

    variables: Sequence[tuple[str, Variable]]
    samples: Mapping[str, int]
    labels: Mapping[str, Sequence[str]] = field(default_factory=dict)
    units: Mapping[str, tuple[str, Sequence[str]]] = field(default_factory=dict)
    attributes: Mapping[str, Any] = field(default_factory=dict)
    flags: Mapping[str, tuple[tuple[str, ...], Array, Mapping[str, str]]] = field(
        default_factory=dict
    )
    frame_attributes: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of_rows(
        cls,
        rows: Sequence[Mapping[str, Any]],
        units: Mapping[str, str],
        given: Collection[str] = (),
    ) -> Table:
        """Return rows of numbers and texts as a table along one dimension, `row`.

        Args:
            rows: values by column.
            units: of all columns, in their order.
            given: columns that are coordinates.
        """
        variables = [
            (
                name,
                Variable(
                    ("row",),
                    np.array([row[name] for row in rows]),
                    unit,
                    name.replace("_", " "),
                    is_coordinate=name in given,
                ),
            )
            for name, unit in units.items()
        ]
        return cls(variables, {"row": len(rows)})

    def to_xarray(self) -> xarray.Dataset:
        """Return a Dataset; see `Result.to_xarray`."""
        try:
            import xarray
        except ImportError as error:
            raise _missing("xarray") from error
        names = [name for name, _ in self.variables]
        repeated = {name for name in names if names.count(name) > 1}
        if repeated:
            # A link `a` and a joint `a_force` both have loads that vary.
            raise ModelError(
                f"a table cannot hold two variables of the name {choices(repeated)}: rename the "
                "joint or the link in the description"
            )
        data: dict[str, Any] = {}
        coordinates: dict[str, Any] = {}
        for name, variable in self.variables:
            told = {"units": variable.unit, "long_name": variable.long_name}
            where = coordinates if variable.is_coordinate else data
            where[name] = (variable.dims, np.array(variable.values), told)
        used = {dim for _, variable in self.variables for dim in variable.dims}
        used |= {dim for dims, *_ in self.flags.values() for dim in dims}
        coordinates |= {
            dim: (dim, list(names)) for dim, names in self.labels.items() if dim in used
        }
        coordinates |= {
            name: (dim, list(units), {"long_name": f"unit along {dim}"})
            for name, (dim, units) in self.units.items()
            if dim in used
        }
        return xarray.Dataset(data | dict(self.flags), coordinates, dict(self.attributes))

    def columns(self) -> dict[str, tuple[Array, str]]:
        """Return values `(N,)` over all samples, and their units, by names of columns."""
        found: dict[str, tuple[Array, str]] = {}
        count = math.prod(self.samples.values())
        for name, variable in self.variables:
            names, units = self._entries(name, variable), variable.units
            values = self._over_samples(variable).reshape(count, len(names)).T
            along = cycle((units,) if isinstance(units, str) else units)
            found |= zip(names, zip(values, along, strict=False), strict=True)
        return found

    @property
    def abscissa(self) -> str:
        """Name of the first column that was given, such as the first drive's position, or empty."""
        given = (item for item in self.variables if item[1].is_coordinate)
        return next((column for item in given for column in self._entries(*item)), "")

    def _places(self, columns: Collection[str]) -> list[str]:
        """Return the names of the columns that count samples."""
        if len(self.samples) > 1:
            return list(self.samples)
        # A dimension with values, such as times, is a column.
        return ["sample" if name in columns else name for name in self.samples]

    def to_dataframe(self) -> pandas.DataFrame:
        """Return a DataFrame; see `Result.to_dataframe`."""
        try:
            import pandas
        except ImportError as error:
            raise _missing("pandas") from error
        columns = self.columns()
        units = {name: unit for name, (_, unit) in columns.items()}
        sizes, names = list(self.samples.values()), self._places(columns)
        index = pandas.RangeIndex(int(np.prod(sizes)), name=names[0])
        if len(sizes) > 1:
            index = pandas.MultiIndex.from_product(map(range, sizes), names=names)
        values: Any = _together(columns)
        if values.dtype == object:
            values = {name: values for name, (values, _) in columns.items()}
        frame = pandas.DataFrame(values, index, [*columns])
        told = {"units": units, **self.frame_attributes, **self.attributes}
        # pandas copies them deeply whenever a column is read: what cannot be changed stays itself.
        frame.attrs = {
            name: frozen(item) if isinstance(item, dict) else item for name, item in told.items()
        }
        return frame

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write a file; see `Result.save`."""
        target = file_path("path", path)
        if target.suffix not in SUFFIXES:
            raise ArgumentError(
                f"path is {described(str(path))}; its suffix says what is written: "
                f"{choices(SUFFIXES)}"
            )
        if target.suffix == ".nc":
            table = self.to_xarray()
            # Its format has no dimension without entries beside the samples.
            empty = [dim for dim, size in table.sizes.items() if not size]
            table = table.drop_dims([dim for dim in empty if dim not in self.samples])
            with writing(target) as part:
                table.to_netcdf(part, engine="scipy")
            return target
        if target.suffix == ".csv":
            return self.to_csv(target, header=False)
        frame = self.to_dataframe()
        if target.suffix == ".parquet":
            with writing(target) as part:
                try:
                    frame.to_parquet(part)
                except ImportError as error:
                    raise MissingExtraError(
                        "Parquet files need pyarrow: pip install pyarrow"
                    ) from error
            return target
        told = _as_json({"columns": {name: frame[name].tolist() for name in frame}})
        told |= _as_json(frame.attrs)
        text = json.dumps(told, ensure_ascii=False, indent=1, allow_nan=False)
        with writing(target) as part:
            part.write_text(text, encoding="utf-8")
        return target

    def to_csv(self, path: str | os.PathLike[str], *, header: bool = True) -> Path:
        """Write a text file; see `Result.to_csv`."""
        target, columns = file_path("path", path), self.columns()
        shown = [f"{name} [{unit}]" if unit else name for name, (_, unit) in columns.items()]
        places = np.indices(tuple(self.samples.values())).reshape(len(self.samples), -1).T.tolist()
        values = _together(columns)
        # Where there is no number, a text file has nothing.
        rows = np.where(values != values, "", values.astype(object)).tolist()
        lines = []
        if header:
            told = {name: value for name, value in self.attributes.items() if value != ""}
            lines = [f"# {name}: {' '.join(str(value).split())}\n" for name, value in told.items()]
        with writing(target) as part, part.open("w", encoding="utf-8", newline="") as file:
            file.writelines(lines)
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow([*self._places(columns), *shown])
            writer.writerows(map(add, places, rows))
        return target

    def _over_samples(self, variable: Variable) -> Array:
        """Return values over all samples of a variable that may vary along some of them only."""
        shape, dims = tuple(self.samples.values()), tuple(self.samples)
        if variable.dims[: len(dims)] == dims and variable.values.shape[: len(dims)] == shape:
            return variable.values
        varying = [dim for dim in variable.dims if dim in self.samples]
        rest = variable.values.shape[len(varying) :]
        sizes = dict(zip(varying, variable.values.shape, strict=False))
        padded = np.reshape(variable.values, (*(sizes.get(dim, 1) for dim in self.samples), *rest))
        return np.broadcast_to(padded, (*shape, *rest))

    def _entries(self, name: str, variable: Variable) -> list[str]:
        """Return the columns of all entries of a variable beyond the samples, in C order.

        These have one dimension of names at most, and one of components behind it.
        """
        quantity, owners, parts = name, [""], [""]
        for dim in variable.dims:
            if dim in self.samples:
                continue
            if dim.endswith("component"):
                parts = [f"_{part.replace(' ', '_')}" for part in self.labels[dim]]
                continue
            owners = [f"{owner}." for owner in self.labels[dim]]
            if dim == "drive" and not quantity.startswith("drive_"):
                quantity = f"drive_{quantity}"
            elif dim in _IN_FRONT:
                quantity = quantity.removeprefix(_IN_FRONT[dim])
        return [f"{owner}{quantity}{part}" for owner in owners for part in parts]


def _together(columns: Mapping[str, tuple[Array, str]]) -> Array:
    """Return the values of columns as one array `(N, k)`: pandas examines each of several."""
    values = [column for column, _ in columns.values()]
    numbers = all(column.dtype == float for column in values)
    count = len(values[0]) if values else 0
    return np.array(values, float if numbers else object).reshape(len(values), count).T


def _as_json(value: Any) -> Any:
    """Return a value as JSON can say it, which has no numbers that are not finite."""
    if isinstance(value, Mapping):
        return {name: _as_json(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_as_json(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else "Infinity" if value > 0.0 else "-Infinity"
    return value


def _missing(package: str) -> MissingExtraError:
    return MissingExtraError(f'this table needs {package}: pip install "cardan-dyn[study]"')
