"""Outcomes: what a function returns for a case, as named arrays of the shapes of the first case."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...kit.arrays import Array
from ...kit.checks import described
from ...kit.errors import ArgumentError, choices
from .parameters import LARGEST_WHOLE, name_of_array


class Outcome(NamedTuple):
    """One variable of what a function returned.

    Attributes:
        dims: names of its dimensions; none of a number.
        values: of these.
        attributes: its units and whatever else is said of it.
    """

    dims: tuple[str, ...]
    values: Array
    attributes: dict[str, Any]


@dataclass(frozen=True)
class Variable:
    """A variable of the results of a study, without the dimensions of the cases.

    Attributes:
        dims: of the results of one case.
        shape: of these.
        dtype: as it is stored: real numbers as doubles, so that NaN can say that there is none.
        attributes: units and others.
    """

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    dtype: str
    attributes: dict[str, Any]


@dataclass(frozen=True)
class Schema:
    """What every case of a study returns; the first case decides.

    Attributes:
        variables: by name.
        coordinates: of the dimensions of the results: name to dimensions, values as lists and
            attributes.
        attributes: of the whole Dataset.
    """

    variables: dict[str, Variable]
    coordinates: dict[str, tuple[tuple[str, ...], list[Any], dict[str, Any]]]
    attributes: dict[str, Any]

    @property
    def bytes_per_case(self) -> int:
        """Size of the results of a case, before they are compressed, and of its state."""
        sizes = (
            int(np.prod(variable.shape, dtype=np.int64)) * np.dtype(variable.dtype).itemsize
            for variable in self.variables.values()
        )
        return 1 + sum(sizes)

    def to_json(self) -> dict[str, Any]:
        """Return it as JSON takes it; `from_json` reads it back."""
        return {
            "variables": {
                name: {
                    "dims": list(item.dims),
                    "shape": list(item.shape),
                    "dtype": item.dtype,
                    "attributes": item.attributes,
                }
                for name, item in self.variables.items()
            },
            "coordinates": {
                name: [list(dims), values, attributes]
                for name, (dims, values, attributes) in self.coordinates.items()
            },
            "attributes": self.attributes,
        }

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Schema:
        """Return what `to_json` wrote."""
        variables = {
            name: Variable(
                tuple(item["dims"]), tuple(item["shape"]), item["dtype"], item["attributes"]
            )
            for name, item in data["variables"].items()
        }
        coordinates = {
            name: (tuple(dims), values, attributes)
            for name, (dims, values, attributes) in data["coordinates"].items()
        }
        return cls(variables, coordinates, data["attributes"])

    def empty(self, shape: tuple[int, ...]) -> dict[str, Array]:
        """Return arrays for the results of cases of a shape, in which nothing is known yet."""
        return {
            name: np.full((*shape, *item.shape), np.nan, item.dtype)
            for name, item in self.variables.items()
        }

    def put(self, arrays: dict[str, Array], place: Any, found: Mapping[str, Outcome]) -> None:
        """Write what a case, or a box of cases, returned into arrays.

        Args:
            arrays: from `empty`.
            place: where in the dimensions of the cases.
            found: what was returned; `schema_of` says of what shape.

        Raises:
            ArgumentError: it is not what the first case returned.
        """
        if found.keys() != self.variables.keys():
            raise ArgumentError(
                f"this case returned {choices(found)}; the first one {choices(self.variables)}. "
                "Return the same names for every case, NaN where there is nothing"
            )
        # All is checked before anything is written.
        for name, item in self.variables.items():
            values, target = found[name].values, arrays[name][place]
            if values.shape != target.shape or not np.can_cast(values.dtype, item.dtype, "safe"):
                first = values.shape[: values.ndim - len(item.shape)]
                raise ArgumentError(
                    f"{name} has shape {values.shape} and type {values.dtype} in this case, "
                    f"expected {(*target.shape[: target.ndim - len(item.shape)], *item.shape)} and "
                    f"{item.dtype} as in the first one"
                    + ("" if first == () else "; a box of cases has the cases' axes first")
                )
        for name in self.variables:
            arrays[name][place] = found[name].values

    def refuse_other_axes(self, found: Outcomes) -> None:
        """Refuse results of a case along other dimensions, or coordinates, than the first one's.

        Raises:
            ArgumentError: they are others, so that numbers would not be where they belong.
        """
        for name, item in found.variables.items():
            if name in self.variables and item.dims != self.variables[name].dims:
                raise ArgumentError(
                    f"{name} has the dimensions {item.dims} in this case, and "
                    f"{self.variables[name].dims} in the first one: return them in one order"
                )
        for name in {*self.coordinates, *found.more.coordinates}:
            here, there = (
                item.get(name, ((), [], {})) for item in (found.more.coordinates, self.coordinates)
            )
            if here[0] != there[0] or not np.array_equal(here[1], there[1]):
                raise ArgumentError(
                    f"the coordinate {name} is another one in this case than in the first: return "
                    "results at the same places for all cases, or return it as a result"
                )


class Outcomes(NamedTuple):
    """What functions of this package return: variables, and the coordinates of their dimensions."""

    variables: dict[str, Outcome]
    more: Schema


def outcomes_of(returned: object, units: Mapping[str, str]) -> Outcomes:
    """Return what a function returned as variables, and the coordinates that it said besides.

    Args:
        returned: a number or an array (then called `value`), a mapping of names to these or to
            DataArrays, a DataArray, a Dataset, or anything with `to_xarray`.
        units: of variables whose units are not said otherwise.

    Raises:
        ArgumentError: it is anything else.
    """
    if isinstance(returned, Outcomes):
        return returned
    if type(returned) is dict and returned:
        plain = _plain(returned)
        if plain is not None:
            found = {
                name: Outcome(_dims_of(name, array), array, {"units": units.get(name, "")})
                for name, array in plain.items()
            }
            return Outcomes(found, _NOTHING_MORE)
    return _from_xarray(_as_dataset(returned), units)


def schema_of(first: Outcomes, leading: int = 0) -> Schema:
    """Return what every case is expected to return.

    Args:
        first: what the first case returned.
        leading: number of axes that are those of the cases.

    Raises:
        ArgumentError: a variable has not as many, or they are not those of one case.
    """
    variables = {}
    for name, item in first.variables.items():
        shape = item.values.shape
        if len(shape) < leading or any(size != 1 for size in shape[:leading]):  # Of one case.
            raise ArgumentError(
                f"{name} has shape {shape}, where the parameters of one case have "
                f"{(1,) * leading}: a vectorized function returns arrays whose shapes begin so"
            )
        dims = item.dims
        if len(dims) != len(shape) - leading:
            dims = _dims_of(name, item.values[(0,) * leading])
        variables[name] = Variable(dims, shape[leading:], item.values.dtype.str, item.attributes)
    return Schema(variables, first.more.coordinates, first.more.attributes)


_NOTHING_MORE = Schema({}, {}, {})


def _plain(returned: dict[Any, Any]) -> dict[str, Array] | None:
    """Return a mapping of names to plain numbers and arrays; None if it holds anything else."""
    found = {}
    for name, value in returned.items():
        if not isinstance(value, (int, float, complex, np.ndarray, np.generic, list, tuple)):
            return None
        found[name_of_array("a result", name)] = _stored(name, value)
    return found


def _as_dataset(returned: object) -> Any:
    """Return what a function returned as a Dataset."""
    import xarray

    if isinstance(returned, xarray.Dataset):
        return returned
    if isinstance(returned, xarray.DataArray):
        return returned.to_dataset(name="value" if returned.name is None else str(returned.name))
    if hasattr(returned, "to_xarray"):
        return _as_dataset(returned.to_xarray())
    if isinstance(returned, Mapping):
        parts = {}
        for name, value in returned.items():
            label, is_named = name_of_array("a result", name), isinstance(value, xarray.DataArray)
            array = value if is_named else _stored(label, value)
            parts[label] = (
                array if is_named else xarray.DataArray(array, dims=_dims_of(label, array))
            )
        return xarray.Dataset(parts)
    array = _stored("value", returned)
    return xarray.Dataset({"value": (_dims_of("value", array), array)})


def _from_xarray(data: Any, units: Mapping[str, str]) -> Outcomes:
    """Return the variables and coordinates of a Dataset."""
    found = {}
    for name, item in data.data_vars.items():
        label = name_of_array("a result", name)
        attributes = _attributes(item.attrs)
        if name in units or "units" not in attributes:
            attributes["units"] = units.get(label, "")
        dims = tuple(name_of_array("a dimension of results", dim) for dim in item.dims)
        found[label] = Outcome(dims, _stored(label, item.values), attributes)
    if not found:
        raise ArgumentError("the function returned nothing: a study needs a number at least")
    coordinates = {
        name_of_array("a coordinate", name): (
            tuple(map(str, item.dims)),
            item.values.tolist(),
            _attributes(item.attrs),
        )
        for name, item in data.coords.items()
        # What has no dimension is of one case, and no longer a coordinate of all.
        if item.dims and item.dtype.kind in "biufU"
    }
    return Outcomes(found, Schema({}, coordinates, _attributes(data.attrs)))


def _dims_of(name: object, array: Array) -> tuple[str, ...]:
    if array.ndim <= 1:
        return (f"{name}_index",) * array.ndim
    return tuple(f"{name}_index_{axis}" for axis in range(array.ndim))


def _stored(name: object, value: object) -> Array:
    """Return values in the type in which they are stored."""
    try:
        array = np.asarray(value)
    except Exception as error:
        raise ArgumentError(f"{name}: no array can be made of {described(value)}") from error
    if array.dtype.kind == "f" and array.dtype.itemsize <= 8:
        return array.astype(float, copy=False)
    if array.dtype.kind == "c" and array.dtype.itemsize <= 16:
        return array.astype(complex, copy=False)
    if array.dtype.kind not in "biu":
        raise ArgumentError(
            f"the function returned {described(value)} for {name}; a study keeps numbers, arrays "
            "of them, mappings of names to these, and xarray's Datasets"
        )
    if array.dtype.kind != "b" and array.size and np.abs(array).max() > LARGEST_WHOLE:
        raise ArgumentError(f"{name} holds a whole number beyond 2**53, which no double is")
    return array.astype(float)


_OF_FILES = ("_FillValue", "add_offset", "missing_value", "scale_factor")
"""Attributes by which whoever reads a file makes other numbers of those that are there."""


def _attributes(given: Mapping[Any, Any]) -> dict[str, Any]:
    """Return those attributes that any file can hold, and that make no other numbers of these."""
    kept = {}
    for name, value in given.items():
        if name in _OF_FILES:
            continue
        plain = value.item() if isinstance(value, np.generic) else value
        if isinstance(plain, (str, bool, int)) or (isinstance(plain, float) and np.isfinite(plain)):
            kept[str(name)] = plain
    return kept
