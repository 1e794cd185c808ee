"""Store: results of a study in Zarr, an array per variable, a chunk of each per chunk of cases.

The variable `state` says what is done, case by case. It is written last, and a chunk of it is one
object that appears at once: what it does not tell of does not count, and is computed again. Where
it is not there though all results of a chunk are, that is damage: it was lost, or almost written.

All else that a store holds follows from what its group says of the study: shapes, types and
attributes of the arrays, and the values of parameters. Chunks end with a checksum, and so does what
is said of the study. Hence `damage` can tell what was written and is no longer there, and `mend`
gives that up.
"""

from __future__ import annotations

import asyncio
import errno
import hashlib
import json
import math
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
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..._version import __version__
from ...kit.arrays import Array
from ...kit.errors import ArgumentError, CardanError, MissingExtraError
from .chunk import FAILED, Box, Computed
from .chunking import MOST_BYTES, boxes, slabs
from .fingerprint import differences
from .outcomes import Schema
from .parameters import Block, Parameters

if TYPE_CHECKING:
    import xarray

_MARK = "study_"
"""Beginning of the names of attributes that say what a study is: words, or JSON."""
_FORMAT = 2
_AT_ONCE = 1_000_000
"""Values of a parameter that are written in one go: some megabytes."""
_MOST_INDEXED = 10_000_000
"""Points of a dimension up to which a Dataset is opened with an index that finds values in it."""


class Damage(NamedTuple):
    """What was written to a store and is not there as it was written.

    Attributes:
        array: name of the array.
        box: span of each dimension whose cases are lost; None where nothing has to be computed.
        cases: number of these.
        message: what is wrong.
    """

    array: str
    box: Box | None
    cases: int
    message: str


class Store:
    """The results of a study, wherever they are.

    Args:
        place: a path, a URL (`s3://…`), a Zarr store, or None for memory.
        options: of the file system of a URL.

    Raises:
        ArgumentError: options are given, and the place is no URL.
    """

    def __init__(self, place: Any, options: Mapping[str, Any] | None = None) -> None:
        self.is_memory = place is None
        self.place = _zarr().storage.MemoryStore() if place is None else place
        if isinstance(self.place, os.PathLike):
            self.place = os.fspath(self.place)
        self.options = dict(options or {}) or None
        url = self.place if isinstance(self.place, str) and "://" in self.place else ""
        scheme, _, path = url.partition("://")
        if self.options is None and scheme in ("file", "local"):
            # As a path: the file system behind such a URL makes no folders, and no file at once.
            self.place = path
        if self.options is not None and not url:
            raise ArgumentError(
                f"storage_options are of the file system of a URL, and the store is {self}: leave "
                "them out"
            )
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

    def found(self) -> dict[str, Any] | None:
        """Return what is said of the study that is there, and open it; None if there is none.

        Raises:
            CardanError: something else is there, or it cannot be read.
        """
        with _advice(self, "read"):
            try:
                group = self._group("r")
            except FileNotFoundError:
                if self._is_taken:
                    raise CardanError(
                        f"{self}: there is something, but no study; name another store"
                    ) from None
                return None
            except (json.JSONDecodeError, UnicodeDecodeError) as error:
                raise self._unreadable from error
            said = {
                name.removeprefix(_MARK): item
                for name, item in group.attrs.items()
                if name.startswith(_MARK) and isinstance(item, str)
            }
        if "format" not in said:
            raise CardanError(f"{self}: this Zarr group is no study; name another store")
        if said["format"] != str(_FORMAT):
            raise CardanError(
                f"{self}: this study is of format {said['format']}, and this version reads "
                f"{_FORMAT}; use the version of cardan_dyn that wrote it"
            )
        if said.pop("digest", "") != _digest(said):
            raise self._unreadable
        told = {name: item if name in _WORDS else json.loads(item) for name, item in said.items()}
        # Where it was killed before everything was made, nothing was computed.
        if not told["made"]:
            return None
        self.open(told, writable=False)
        return told

    @property
    def _unreadable(self) -> CardanError:
        return CardanError(
            f"{self}: what is said there of the study is damaged; put a copy of its zarr.json "
            "back, or name another store"
        )

    def _group(self, mode: str, **more: Any) -> Any:
        return _zarr().open_group(
            self.place, mode=mode, storage_options=self.options, use_consolidated=False, **more
        )

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
        first = [(block, block.values(0, 1)) for block in parameters.blocks]
        told = {
            "format": _FORMAT,
            "made": False,
            "function": name,
            "parts": dict(prints),
            "descriptions": dict(descriptions),
            "parameters": _told(parameters),
            "chunk": list(chunk),
            "axes": {
                name: (min(block.count, _AT_ONCE), _kind(values))
                for block, columns in first
                for name, values in columns.items()
            },
            "schema": schema.to_json(),
            "versions": versions(),
            "machine": machine(),
        }
        with _advice(self, "written"):
            # What it is stands there from the first object on, so that it is known for a remnant.
            self._group("w", attributes=_said(told))
            self._write({**told, "made": True}, parameters, [0] * len(parameters.shape))

    def open(self, told: Mapping[str, Any], *, writable: bool) -> None:
        """Open a study that is there."""
        with _advice(self, "written" if writable else "read"):
            group = self._group("r+" if writable else "r")
            self._arrays = _arrays(told, group.store_path)

    def extend(self, told: Mapping[str, Any], parameters: Parameters) -> None:
        """Make room for what parameters have in addition; what is there is kept."""
        with _advice(self, "written"):
            self._write({**told, "parameters": _told(parameters)}, parameters, of_cases(told))

    def _write(
        self, told: Mapping[str, Any], parameters: Parameters, starts: Sequence[int]
    ) -> None:
        """Write what follows from the study, values of parameters from some indices on."""
        self.open(told, writable=True)
        for name, (_, values, _) in told["schema"]["coordinates"].items():
            self._arrays[name][...] = _plain(np.asarray(values))
        for block, start, stop in zip(parameters.blocks, starts, of_cases(told), strict=True):
            for first, last in pairwise([*range(start, stop, _AT_ONCE), stop]):
                for name, values in block.values(first, last).items():
                    self._arrays[name][first:last] = _plain(values)
        # Chunks are left alone. Until all is said, it is as it was before, once it is mended.
        for array in self._arrays.values():
            array.update_attributes(array.attrs.asdict())
        self._group("r+").attrs.update(_said(told))

    def damage(self, told: Mapping[str, Any]) -> list[Damage]:
        """Return what was written and is not there as it was: everything is read.

        Raises:
            CardanError: an array is another one, or the store cannot be read at all.
        """
        with _advice(self, "read"):
            return list(self._damaged(told))

    def _damaged(self, told: Mapping[str, Any]) -> Iterator[Damage]:
        schema, shape, chunk = Schema.from_json(told["schema"]), of_cases(told), told["chunk"]
        group = self._group("r")
        whole = _arrays(told, type(group.store_path)(_whole(group.store), group.path))
        for name, array in whole.items():
            if said := self._misdescribed(group, name, array):
                yield Damage(name, None, 0, said)
        for name in (*_units(told), *schema.coordinates):
            places = boxes(whole[name].shape, whole[name].chunks)
            said = next(filter(None, (_tried(whole[name], box)[1] for box in places)), "")
            if said:
                yield Damage(name, None, 0, said)
        for slab in slabs(shape, chunk, MOST_BYTES // schema.bytes_per_case):
            every = []
            together, is_torn = _tried(self._arrays["state"], slab)
            for box in boxes(shape, chunk, slab):
                states, said = together[within(box, slab)], ""
                if is_torn:
                    states, said = _tried(self._arrays["state"], box)
                if said:
                    yield Damage("state", box, states.size, said)
                else:
                    every.append((box, states))
            # States are written last: without one, results that are there do not count.
            blank = [box for box, states in every if not np.any(states)]
            blank = [box for box, is_there in _are_there(whole["state"], blank) if not is_there]
            for name in schema.variables:
                blank = [box for box, is_there in _are_there(whole[name], blank) if is_there]
            for box in blank:
                size = math.prod(span.stop - span.start for span in box)
                yield Damage("state", box, size, "it is missing, and results are there")
            for name in (*schema.variables, "failure"):
                least = FAILED if name == "failure" else 1
                # What does not count may be missing, and is read all the same: it would be shown.
                arrays = [
                    whole[name] if states.max() >= least else self._arrays[name]
                    for _, states in every
                ]
                # Many objects together are fetched at the same time.
                if len(set(map(id, arrays))) == 1 and not _tried(arrays[0], slab)[1]:
                    continue
                for array, (box, states) in zip(arrays, every, strict=True):
                    if said := _tried(array, box)[1]:
                        yield Damage(name, box, int(np.count_nonzero(states)), said)

    def _misdescribed(self, group: Any, name: str, expected: Any) -> str:
        """Return in what the description of an array is not what it was made with."""
        try:
            there = group[name]
            differs = there.dtype != expected.dtype or there.ndim != expected.ndim
        except OSError:
            raise
        except Exception as error:
            return f"its zarr.json cannot be read ({error})"
        if differs:
            raise CardanError(
                f"{self}: {name} holds {there.dtype} of shape {there.shape}, and the study "
                f"{expected.dtype} of {expected.shape}: something else has written it; name "
                "another store, or delete this one"
            )
        now, then = (item.metadata.to_dict() for item in (there, expected))
        # As text: what is no number equals itself.
        other = [key for key in then if str(now.get(key)) != str(then[key])]
        return f"its zarr.json has another {', '.join(other)}" if other else ""

    def mend(
        self, told: Mapping[str, Any], parameters: Parameters, damaged: Sequence[Damage]
    ) -> None:
        """Write anew what follows from the study, and count the other cases as not computed."""
        with _advice(self, "written"):
            self._write(told, parameters, [0] * len(parameters.shape))
            for item in damaged:
                if item.box is not None:
                    # Blank, since it would be in the way of whoever reads the others.
                    for array in (self._arrays["state"], self._arrays[item.array]):
                        array[item.box] = array.fill_value

    def states(self, slab: Box, damaged: Sequence[Damage] = ()) -> Array:
        """Return the states of a box of cases; what is damaged is as good as missing."""
        array, lost = self._arrays["state"], [item.box for item in damaged if item.box]
        with _advice(self, "read"):
            if not lost:
                return np.asarray(array[slab])
            states = np.zeros([span.stop - span.start for span in slab], np.int8)
            for box in boxes(array.shape, array.chunks, slab):
                if box not in lost:
                    states[within(box, slab)] = array[box]
            return states

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
            self._arrays["state"][box] = state

    def _put(self, name: str, box: Box, values: Array, new: Array) -> None:
        array = self._arrays[name]
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
            texts = np.asarray(self._arrays["failure"][box])
        return [(tuple(place), str(texts[tuple(place)])) for place in failed]

    def dataset(self, told: Mapping[str, Any]) -> xarray.Dataset:
        """Return everything as a Dataset, whose arrays are read when they are used."""
        import xarray

        schema = told["schema"]
        coordinates = [*_units(told), *schema["coordinates"]]
        small = max(of_cases(told)) <= _MOST_INDEXED
        with _advice(self, "read"):
            data = xarray.open_zarr(
                self.place,
                chunks=None,
                consolidated=False,
                storage_options=self.options,
                create_default_indexes=small,
                decode_times=False,  # Units are words, and make no dates.
            )
        data = data.set_coords(coordinates)
        # Zarr lists arrays in any order; coordinates that no result has are kept.
        ordered = data[[*schema["variables"], "state"]].assign_attrs(schema["attributes"])
        return ordered.assign_coords({name: data[name] for name in coordinates})


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
        if not found:
            for item, block in zip(before, parameters.blocks, strict=True):
                found += _other_values(told, item, block)
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


def _other_values(told: Mapping[str, Any], item: Mapping[str, Any], block: Block) -> Iterator[str]:
    """Iterate over parameters that were said alike, and are or would be others there."""
    scipy = told["versions"].get("scipy")
    for name, ends in _ends(block, item["count"]).items():
        if ends != item["ends"][name]:  # SciPy has changed its samples.
            there = " to ".join(map(str, item["ends"][name]))
            yield f"{name} goes from {there}, and it was begun with SciPy {scipy}: use that"
    for first, last in pairwise([*range(item["count"], block.count, _AT_ONCE), block.count]):
        for name, values in block.values(first, last).items():
            dtype = told["axes"][name][1]
            if dtype == "str" or np.can_cast(values.dtype, dtype, "safe"):
                continue
            with np.errstate(all="ignore"):
                cut = values.astype(dtype) != values
            if np.any(cut):
                yield (
                    f"{name} is of type {dtype}, which is not that of "
                    f"{values[int(np.argmax(cut))]}: give all values as they are meant, floats as "
                    "in [1.0, 2.0, 2.5]"
                )


def of_cases(told: Mapping[str, Any]) -> list[int]:
    """Return the number of points along each dimension of a store: fewer, before it is extended."""
    return [item["count"] for item in told["parameters"]]


def within(box: Box, slab: Box) -> Box:
    """Return where a box is in a slab."""
    return tuple(
        slice(span.start - of.start, span.stop - of.start)
        for span, of in zip(box, slab, strict=True)
    )


def _units(told: Mapping[str, Any]) -> dict[str, str]:
    """Return the parameters of a store and their units."""
    return {
        name: unit for item in told["parameters"] for name, unit in item["block"]["units"].items()
    }


def _digest(said: Mapping[str, str]) -> str:
    """Return the checksum of what is said of a study."""
    return hashlib.sha256(json.dumps(sorted(said.items())).encode()).hexdigest()


def _said(told: Mapping[str, Any]) -> dict[str, str]:
    """Return what is said of a study as attributes that any file can hold."""
    said = {
        name: item if name in _WORDS else json.dumps(item, ensure_ascii=False)
        for name, item in told.items()
    }
    said["digest"] = _digest(said)
    # What xarray takes as coordinates besides those named like their dimensions.
    coordinates = " ".join([*_units(told), *told["schema"]["coordinates"]])
    more = {"coordinates": coordinates, **told["schema"]["attributes"]}
    return more | {f"{_MARK}{name}": item for name, item in said.items()}


_WORDS = ("function",)
"""What is said in words; all else is JSON."""


def _arrays(told: Mapping[str, Any], place: Any) -> dict[str, Any]:
    """Return all arrays of a study as they were made, whatever is said of them where they are."""
    zarr, schema = _zarr(), Schema.from_json(told["schema"])
    shape, chunk = tuple(of_cases(told)), tuple(told["chunk"])
    dims = tuple(item["block"]["dim"] for item in told["parameters"])
    model = zarr.open_group(zarr.storage.MemoryStore(), mode="w")
    found = {}

    def add(name: str, size: Any, part: Any, dtype: str, along: Any, about: Any) -> None:
        kind = np.dtype(dtype).kind if dtype != "str" else "O"
        made = model.create_array(
            name,
            shape=size,
            # Chunks are not empty.
            chunks=tuple(max(1, length) for length in part),
            dtype=dtype,
            fill_value=np.nan if kind in "fc" else "" if kind == "O" else 0,
            compressors=(zarr.codecs.ZstdCodec(), zarr.codecs.Crc32cCodec()),
            dimension_names=along,
            attributes=about,
        )
        # A chunk without a number is written all the same: none there is one that was lost.
        config = {"write_empty_chunks": True}
        found[name] = zarr.Array(zarr.AsyncArray(made.metadata, place / name, config))

    for label, item in schema.variables.items():
        sizes = (*shape, *item.shape), (*chunk, *item.shape)
        add(label, *sizes, item.dtype, (*dims, *item.dims), item.attributes)
    about: dict[str, Any] = {"long_name": "state of the case", "units": "1"}
    about |= {"flag_values": [0, 1, 2], "flag_meanings": "missing done failed"}
    add("state", shape, chunk, "i1", dims, about)
    about = {"long_name": "type and message of the error that ended the case"}
    add("failure", shape, chunk, "str", dims, about)
    for label, (along, values, attributes) in schema.coordinates.items():
        array = np.asarray(values)
        add(label, array.shape, array.shape, _kind(array), along, attributes)
    for item in told["parameters"]:
        for label, unit in item["block"]["units"].items():
            size, kind = told["axes"][label]
            about = {"units": unit} if unit else {}
            add(label, (item["count"],), (size,), kind, (item["block"]["dim"],), about)
    return found


def _kind(values: Array) -> str:
    """Return the type in which values are stored."""
    return "str" if values.dtype.kind == "U" else values.dtype.str.replace("b1", "i1")


def _plain(values: Array) -> Array:
    return values.astype(object) if values.dtype.kind == "U" else values


def _whole(store: Any) -> Any:
    """Return a store in which a chunk that is not there is an error, and no blank."""
    from zarr.storage import WrapperStore

    class Whole(WrapperStore[Any]):
        async def get(self, key: str, prototype: Any, byte_range: Any = None) -> Any:
            found = await super().get(key, prototype, byte_range)
            if found is None:
                raise FileNotFoundError(key)
            return found

    return Whole(store)


def _are_there(array: Any, every: Sequence[Box]) -> list[tuple[Box, bool]]:
    """Return boxes of cases, each with whether there is a chunk of it; asked all together."""
    from zarr.core.sync import sync

    def key(box: Box) -> str:
        place = [span.start // size for span, size in zip(box, array.chunks, strict=False)]
        place += [0] * (array.ndim - len(place))  # What is of a case is never parted.
        return str(array.metadata.encode_chunk_key(tuple(place)))

    async def asked() -> list[bool]:
        return await asyncio.gather(*((array.store_path / key(box)).exists() for box in every))

    return list(zip(every, sync(asked()) if every else [], strict=True))


def _tried(array: Any, box: Box) -> tuple[Array, str]:
    """Return a part of an array, blank where it cannot be read, and why not."""
    try:
        return np.asarray(array[box]), ""
    except FileNotFoundError as error:
        said = f"{error} is missing"
    except OSError:  # Then it is the disk or the network, and says nothing of what is there.
        raise
    except Exception as error:
        said = f"cannot be read: {str(error).partition('. ')[0]}"
    return np.zeros([span.stop - span.start for span in box], np.int8), said


def _told(parameters: Parameters) -> list[dict[str, Any]]:
    """Return parameters as a store describes them."""
    return [
        {
            "count": block.count,
            "block": block.described(block.count),
            "ends": _ends(block, block.count),
        }
        for block in parameters.blocks
    ]


def _ends(block: Block, count: int) -> dict[str, list[Any]]:
    """Return the first and the last of a number of values of each parameter."""
    first, last = block.values(0, 1), block.values(count - 1, count)
    return {name: [first[name][0].item(), last[name][0].item()] for name in first}


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
    """Return the package, whose types are narrower than what it takes."""
    import zarr

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
        except ImportError as error:  # `__cause__` is that of the package.
            needed = getattr(error.__cause__, "name", None) or str(error)
            raise MissingExtraError(f"{store} needs {needed}: pip install {needed}") from error
        except Exception as error:  # Those of any file system.
            kind = getattr(error, "errno", None)
            advice = "check its path, and the right to write there"
            if kind in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
                advice = "make room, and run the study again: what is finished is kept"
            elif "read-only" in str(error).lower() or kind in (errno.EROFS, errno.EACCES):
                advice = "it is read-only: name another store, or copy it to where you may write"
            raise CardanError(f"{store} cannot be {done} ({error}); {advice}") from error
