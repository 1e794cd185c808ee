"""Store: results of a study in Zarr, an array per variable, a chunk of each per chunk of cases.

The variable `state` says what is done, case by case. It is written last, and a chunk of it is one
object that appears at once: what it does not tell of does not count, and is computed again.
"""

from __future__ import annotations

import errno
import json
import os
import platform
import shutil
import sys
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import metadata
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._version import __version__
from ..arrays import Array
from ..errors import CardanError
from .chunk import FAILED, Box, Computed, missing
from .fingerprint import differences
from .outcomes import Schema
from .parameters import Block, Parameters

if TYPE_CHECKING:
    import xarray

_MARK = "study_"
"""Beginning of the names of attributes that say what a study is: words, or JSON."""
_FORMAT = 1
_AT_ONCE = 1_000_000
"""Values of a parameter that are written in one go: some megabytes."""
_MOST_INDEXED = 10_000_000
"""Points of a dimension up to which a Dataset is opened with an index that finds values in it."""


class Store:
    """The results of a study, wherever they are.

    Args:
        place: a path, a URL (`s3://…`), a Zarr store, or None for memory.
        options: of the file system of a URL.
    """

    def __init__(self, place: Any, options: Mapping[str, Any] | None = None) -> None:
        zarr = _zarr()
        self.is_memory = place is None
        self.place = zarr.storage.MemoryStore() if place is None else place
        if isinstance(self.place, os.PathLike):
            self.place = os.fspath(self.place)
        self.options = dict(options or {}) or None
        self._group: Any = None
        self._arrays: dict[str, Any] = {}

    def __str__(self) -> str:
        return "memory" if self.is_memory else str(self.place)

    @property
    def free(self) -> float:
        """Bytes that are free where it is; inf where that is not known."""
        path = self._path
        if path is None:
            return float("inf")
        while not path.exists():
            path = path.parent
        return float(shutil.disk_usage(path).free)

    @property
    def _path(self) -> Path | None:
        """Path of a store on this machine."""
        if isinstance(self.place, str) and "://" not in self.place:
            return Path(self.place).absolute()
        root = getattr(self.place, "root", None)
        return Path(root).absolute() if isinstance(root, Path) else None

    @property
    def _is_taken(self) -> bool:
        """Whether something is on this machine where the store would be."""
        path = self._path
        if path is None or not path.exists():
            return False
        # What is partial, a killed process has left.
        return path.is_file() or any(item.suffix != ".partial" for item in path.iterdir())

    def forget(self) -> None:
        """Read everything anew that is asked for from now on."""
        self._group, self._arrays = None, {}

    def found(self) -> dict[str, Any] | None:
        """Return what is said of the study that is there; None if there is none.

        Raises:
            CardanError: something else is there, or it cannot be read.
        """
        zarr = _zarr()
        with _advice(self, "read"):
            try:
                group = zarr.open_group(
                    self.place, mode="r", storage_options=self.options, use_consolidated=False
                )
            except FileNotFoundError:
                if self._is_taken:
                    raise CardanError(
                        f"{self}: there is something, but no study; name another store"
                    ) from None
                return None
            told = _read_attributes(dict(group.attrs))
        if "format" not in told:
            raise CardanError(f"{self}: this Zarr group is no study; name another store")
        if told["format"] != _FORMAT:
            raise CardanError(
                f"{self}: this study was written by cardan_dyn {told['versions']['cardan_dyn']} in "
                f"format {told['format']}, this version reads {_FORMAT}; use that version"
            )
        # Where it was killed before everything was made, nothing was computed.
        return told if told["made"] else None

    def make(
        self,
        name: str,
        parameters: Parameters,
        schema: Schema,
        chunk: tuple[int, ...],
        prints: Mapping[str, str],
        descriptions: Mapping[str, str],
    ) -> None:
        """Make arrays for a new study."""
        told = {
            "format": _FORMAT,
            "made": False,
            "function": name,
            "parts": dict(prints),
            "descriptions": dict(descriptions),
            "parameters": _told(parameters),
            "chunk": list(chunk),
            "schema": schema.to_json(),
            "versions": versions(),
            "machine": machine(),
        }
        zarr = _zarr()
        with _advice(self, "written"):
            # What it is stands there from the first object on, so that it is known for a remnant.
            self._group = zarr.open_group(
                self.place,
                mode="w",
                storage_options=self.options,
                attributes={**schema.attributes, **_attributes(told)},
            )
            self._arrays = {}
            for label, item in schema.variables.items():
                self._make(
                    label,
                    (*parameters.shape, *item.shape),
                    (*chunk, *item.shape),
                    item.dtype,
                    (*parameters.dims, *item.dims),
                    item.attributes,
                )
            about: dict[str, Any] = {"long_name": "state of the case", "units": "1"}
            about |= {"flag_values": [0, 1, 2], "flag_meanings": "missing done failed"}
            self._make("state", parameters.shape, chunk, "i1", parameters.dims, about)
            about = {"long_name": "type and message of the error that ended the case"}
            self._make("failure", parameters.shape, chunk, "str", parameters.dims, about)
            for label, (dims, values, attributes) in schema.coordinates.items():
                array = np.asarray(values)
                kind = "str" if array.dtype.kind == "U" else array.dtype.str
                made = self._make(label, array.shape, array.shape, kind, dims, attributes)
                made[...] = array.astype(object) if kind == "str" else array
            coordinates = [*parameters.units, *schema.coordinates]
            for block in parameters.blocks:
                self._write_parameters(block, 0)
            # What xarray takes as coordinates besides those named like their dimensions.
            extra = " ".join(coordinates)
            self._group.attrs.update({"coordinates": extra, **_attributes({"made": True})})

    def open(self, writable: bool) -> None:
        """Open a study that is there."""
        zarr = _zarr()
        with _advice(self, "written" if writable else "read"):
            self._group = zarr.open_group(
                self.place,
                mode="r+" if writable else "r",
                storage_options=self.options,
                use_consolidated=False,
            )
            self._arrays = {}

    def fits(self, told: Mapping[str, Any], parameters: Parameters) -> bool:
        """Return whether all arrays have room for parameters, and for no more of them."""
        with _advice(self, "read"):
            shapes = _shapes(told, parameters).items()
            return all(self._array(name).shape == shape for name, shape in shapes)

    def extend(self, told: Mapping[str, Any], parameters: Parameters) -> None:
        """Make room for what parameters have in addition; what is there is kept."""
        with _advice(self, "written"):
            for item, block in zip(told["parameters"], parameters.blocks, strict=True):
                self._write_parameters(block, item["count"])
            # The states last, then what is said: until then, it is extended once more.
            for name, shape in _shapes(told, parameters).items():
                self._resize(name, shape)
            now = _told(parameters)
            if told["parameters"] != json.loads(json.dumps(now)):
                self._group.attrs.update(_attributes({"parameters": now}))

    def refuse_other_values(self, told: Mapping[str, Any], parameters: Parameters) -> None:
        """Refuse parameters that were said alike and are others: SciPy has changed its samples.

        Raises:
            CardanError: the first or the last value that is there is another one.
        """
        for item, block in zip(told["parameters"], parameters.blocks, strict=True):
            for start in (0, item["count"] - 1):
                for name, values in block.values(start, start + 1).items():
                    with _advice(self, "read"):
                        there = np.asarray(self._array(name)[start : start + 1])
                    if there.tolist() != values.tolist():
                        raise CardanError(
                            f"{self}: {name} is {there[0]} there at index {start} and {values[0]} "
                            f"here; it was begun with SciPy {told['versions'].get('scipy')}: use "
                            "that, or name another store"
                        )

            self._refuse_cut(item["count"], block)

    def _refuse_cut(self, start: int, block: Block) -> None:
        """Refuse new values that the type of those which are there cannot say.

        Raises:
            CardanError: one of them would be written as another number.
        """
        for first, last in pairwise([*range(start, block.count, _AT_ONCE), block.count]):
            for name, values in block.values(first, last).items():
                with _advice(self, "read"):
                    dtype = self._array(name).dtype
                if values.dtype.kind == "U" or np.can_cast(values.dtype, dtype, "safe"):
                    continue
                with np.errstate(all="ignore"):
                    cut = values.astype(dtype) != values
                if np.any(cut):
                    raise CardanError(
                        f"{self}: {name} is of type {dtype} there, which is not that of "
                        f"{values[int(np.argmax(cut))]}: name another store, and give all values "
                        "as they are meant, floats as in [1.0, 2.0, 2.5]"
                    )

    def states(self, box: Box) -> Array:
        """Return the states of a box of cases."""
        with _advice(self, "read"):
            return np.asarray(self._array("state")[box])

    def put(self, box: Box, computed: Computed) -> None:
        """Write the results of a box of cases, those that are new; the states last."""
        new = computed.state > 0
        if not new.any():
            return
        with _advice(self, "written"):
            before = None if new.all() else self.states(box)
            for name, values in computed.arrays.items():
                self._put(name, box, values, new)
            texts = np.full(new.shape, "", dtype=object)
            for index, text in computed.failures:
                texts.flat[index] = text
            if computed.failures or (before is not None and np.any(before == FAILED)):
                self._put("failure", box, texts, new)
            state = computed.state if before is None else np.where(new, computed.state, before)
            self._array("state")[box] = state

    def _put(self, name: str, box: Box, values: Array, new: Array) -> None:
        array = self._array(name)
        if not new.all():
            kept = np.array(array[box])
            kept[new] = values[new]
            values = kept
        array[box] = values

    def failures(self, box: Box, states: Array) -> list[tuple[tuple[int, ...], str]]:
        """Return the places in a box of the cases that failed, and what was said."""
        failed = np.argwhere(states == FAILED).tolist()
        if not failed:
            return []
        with _advice(self, "read"):
            texts = np.asarray(self._array("failure")[box])
        return [(tuple(place), str(texts[tuple(place)])) for place in failed]

    def dataset(self, coordinates: Sequence[str]) -> xarray.Dataset:
        """Return everything as a Dataset, whose arrays are read when they are used.

        Args:
            coordinates: names of the variables that are some.
        """
        import xarray

        told = self.found() or {}
        small = all(item["count"] <= _MOST_INDEXED for item in told["parameters"])
        with _advice(self, "read"):
            data = xarray.open_zarr(
                self.place,
                chunks=None,
                consolidated=False,
                storage_options=self.options,
                create_default_indexes=small,
            )
        data = data.set_coords(list(coordinates))
        # Zarr lists arrays in any order; coordinates that no result has are kept.
        ordered = data[[*told.get("schema", {}).get("variables", ()), "state"]]
        return ordered.assign_coords({name: data[name] for name in coordinates})

    def _array(self, name: str) -> Any:
        if name not in self._arrays:
            if self._group is None:
                self.open(writable=False)
            self._arrays[name] = self._group[name]
        return self._arrays[name]

    def _make(
        self,
        name: str,
        shape: tuple[int, ...],
        chunk: tuple[int, ...],
        dtype: str,
        dims: tuple[str, ...],
        attributes: Mapping[str, Any],
    ) -> Any:
        """Make an array; chunks are no greater than it, and not empty."""
        kind = np.dtype(dtype).kind if dtype != "str" else "O"
        array = self._group.create_array(
            name,
            shape=shape,
            chunks=tuple(max(1, size) for size in chunk),
            dtype=dtype,
            fill_value=np.nan if kind in "fc" else "" if kind == "O" else 0,
            dimension_names=dims,
            attributes=dict(attributes),
        )
        self._arrays[name] = array
        return array

    def _resize(self, name: str, shape: tuple[int, ...]) -> None:
        array = self._array(name)
        if array.shape != shape:
            array.resize(shape)

    def _write_parameters(self, block: Block, start: int) -> None:
        """Write the values of parameters from an index on, in parts that fit into memory."""
        for name, values in block.values(0, 1).items():
            is_text = values.dtype.kind == "U"
            if name not in self._group:
                about = {"units": block.units[name]} if block.units[name] else {}
                size = min(block.count, _AT_ONCE)
                kind = "str" if is_text else values.dtype.str.replace("b1", "i1")
                self._make(name, (block.count,), (size,), kind, (block.dim,), about)
            self._resize(name, (block.count,))
        for first, last in pairwise([*range(start, block.count, _AT_ONCE), block.count]):
            for name, values in block.values(first, last).items():
                plain = values.astype(object) if values.dtype.kind == "U" else values
                self._array(name)[first:last] = plain


def refuse_different(
    told: Mapping[str, Any],
    function: str,
    prints: Mapping[str, str],
    parameters: Parameters,
    at: object,
) -> None:
    """Refuse to go on with the study of another function or other parameters.

    Raises:
        CardanError: it differs in more than that its parameters go on; the message says in what.
    """
    found = [f"{name} differs" for name in differences(told["parts"], prints)]
    if found and told["function"] != function:  # Then all that belongs to it differs.
        found = [f"it is one of {told['function']}, and not of {function}"]
    before = told["parameters"]
    if [item["block"]["dim"] for item in before] != list(parameters.dims):
        there = ", ".join(item["block"]["dim"] for item in before)
        found.append(f"its dimensions are {there}, and not {', '.join(parameters.dims)}")
    else:
        for item, block in zip(before, parameters.blocks, strict=True):
            found += _difference(item, block)
    if told["versions"]["cardan_dyn"] != __version__:
        found.append(f"it was computed by cardan_dyn {told['versions']['cardan_dyn']}")
    if found:
        raise CardanError(
            f"{at} holds another study: {'; '.join(found)}. Name another store, or delete this one",
            differences=tuple(found),
        )


def _difference(item: Mapping[str, Any], block: Block) -> list[str]:
    """Return in what a block differs from the one in a store, unless it only goes on."""
    name, count = f"parameter {block.dim}", item["count"]
    if block.count < count:
        return [f"{name} has {count} points there and {block.count} here: give all of them"]
    told, now = item["block"], json.loads(json.dumps(block.described(count)))
    keys = [key for key in {**told, **now} if told.get(key) != now.get(key)]
    more = "; new ones come after those that are there" if "values" in keys else ""
    return [f"{key} of {name} differ{more}" for key in keys]


def _shapes(told: Mapping[str, Any], parameters: Parameters) -> dict[str, tuple[int, ...]]:
    """Return the shapes of all arrays of a study, that of the states last."""
    shapes = {name: (block.count,) for block in parameters.blocks for name in block.units}
    rest = {name: item.shape for name, item in Schema.from_json(told["schema"]).variables.items()}
    whole = {**rest, "failure": (), "state": ()}
    return shapes | {name: (*parameters.shape, *own) for name, own in whole.items()}


def _attributes(told: Mapping[str, Any]) -> dict[str, str]:
    """Return what is said of a study as attributes that any file can hold."""
    return {
        f"{_MARK}{name}": item if isinstance(item, str) else json.dumps(item, ensure_ascii=False)
        for name, item in told.items()
    }


def _read_attributes(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Return what `_attributes` wrote."""
    told = {
        name.removeprefix(_MARK): item
        for name, item in attributes.items()
        if name.startswith(_MARK) and isinstance(item, str)
    }
    return {name: item if name in _WORDS else json.loads(item) for name, item in told.items()}


_WORDS = ("function",)


def _told(parameters: Parameters) -> list[dict[str, Any]]:
    """Return parameters as a store describes them."""
    return [
        {"count": block.count, "block": block.described(block.count)} for block in parameters.blocks
    ]


def versions() -> dict[str, str]:
    """Return the versions on which results depend."""
    found = {"cardan_dyn": __version__, "python": platform.python_version()}
    for name in ("numpy", "scipy", "pin", "zarr"):
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return found


def machine() -> dict[str, str]:
    """Return where the study was begun."""
    return {
        "name": platform.node(),
        "processor": platform.machine(),
        "system": platform.platform(),
        "executable": sys.executable,
    }


def _zarr() -> Any:
    try:
        import zarr
    except ImportError as error:
        raise missing("zarr") from error
    return zarr


@contextmanager
def _advice(store: Store, done: str) -> Iterator[None]:
    """Say what to do where a store fails."""
    with warnings.catch_warnings():
        # fsspec's file systems without asynchronous functions work, and say that they are slower.
        warnings.filterwarnings("ignore", message=".*async.*")
        try:
            yield
        except CardanError:
            raise
        except (OSError, ValueError) as error:
            kind = getattr(error, "errno", None)
            advice = "check its path, and the right to write there"
            if kind in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
                advice = "make room, and run the study again: what is finished is kept"
            elif "read-only" in str(error).lower() or kind in (errno.EROFS, errno.EACCES):
                advice = "it is read-only: name another store, or copy it to where you may write"
            raise CardanError(f"{store} cannot be {done} ({error}); {advice}") from error
