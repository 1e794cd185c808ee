"""Parameters: what a study varies, computed from the index of a case and never listed.

A study has a dimension for each block of parameters: an axis of a grid, a list of points, or
samples. Its cases are the product of all blocks. A block computes its values over any span of its
dimension, so that a million samples are a seed and a number.
"""

from __future__ import annotations

import hashlib
import json
import math
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ...kit.arrays import Array
from ...kit.checks import described, mapping, number, text, whole
from ...kit.errors import ArgumentError, choices
from ...kit.frozen import Frozen, FrozenDict, frozen, read_only

METHODS = ("sobol", "halton", "latin", "random")
_RESERVED = ("failure", "state", "zarr.json")
"""What a store has besides: arrays of every study, and a file."""
_LONGEST_NAME = 200
"""Bytes of the longest name: file systems take 255, and an array adds to its own."""
LARGEST_WHOLE = 2**53
"""From this whole number on, doubles are not all of them."""
_QUANTILES = np.linspace(0.0, 1.0, 67)[1:-1]
"""Probabilities at which a distribution is looked at that nothing else describes."""


class Block(Frozen):
    """Parameters that vary along one dimension.

    Attributes:
        dim: name of the dimension.
        count: of its points.
        units: names of the parameters to their units.
    """

    dim: str
    count: int
    units: FrozenDict[str, str]

    @abstractmethod
    def values(self, start: int, stop: int) -> dict[str, Array]:
        """Return the values `(stop - start,)` of every parameter at points of the dimension."""

    @abstractmethod
    def described(self, count: int) -> dict[str, Any]:
        """Return what decides the first `count` points, as JSON takes it: longer ones agree."""

    def __len__(self) -> int:
        return self.count

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {choices(self.units)}: {self.count} along {self.dim!r}>"


class Line(Frozen):
    """Evenly spaced values, computed where they are needed: an axis of any length.

    Args:
        start: first value.
        stop: last value.
        count: of the values, at least 2.

    Raises:
        ArgumentError: not finite, or fewer than two.
    """

    def __init__(self, start: float, stop: float, count: int) -> None:
        first, last = number("start", start), number("stop", stop)
        size = whole("count", count, 2)
        self._freeze(start=first, stop=last, count=size, step=(last - first) / (size - 1))

    start: float
    stop: float
    count: int
    step: float

    def __len__(self) -> int:
        return self.count

    def values(self, start: int, stop: int) -> Array:
        """Return the values `(stop - start,)` of some indices."""
        return self.start + self.step * np.arange(start, stop, dtype=float)


class Points(Block):
    """Parameters that vary together, or one by itself: an axis; `points` makes it."""

    def __init__(
        self, columns: Mapping[str, Line | Array], units: Mapping[str, str], dim: str
    ) -> None:
        count = len(next(iter(columns.values())))
        self._freeze(dim=dim, count=count, units=frozen(units), _columns=frozen(columns))

    _columns: FrozenDict[str, Line | Array]

    def values(self, start: int, stop: int) -> dict[str, Array]:
        """Return the values of the parameters; see `Block`."""
        return {
            name: column.values(start, stop) if isinstance(column, Line) else column[start:stop]
            for name, column in self._columns.items()
        }

    def described(self, count: int) -> dict[str, Any]:
        """Return names, units and values, the latter by their hash; see `Block`."""
        values = {
            name: [column.start, column.step] if isinstance(column, Line) else _hash(column[:count])
            for name, column in self._columns.items()
        }
        return {"kind": "points", "dim": self.dim, "units": dict(self.units), "values": values}


class Samples(Block):
    """Parameters that follow distributions; `samples` and `sobol_samples` make it.

    Attributes:
        matrices: of each sample, 1, or k + 2 for the Sobol indices of k parameters: those of the
            sample in A and in B, and in A with one parameter at a time taken from B.
    """

    matrices: int

    def __init__(
        self,
        distributions: Mapping[str, Any],
        units: Mapping[str, str],
        count: int,
        *,
        seed: int,
        method: str,
        dim: str,
        for_indices: bool = False,
    ) -> None:
        matrices = len(distributions) + 2 if for_indices else 1
        self._freeze(
            dim=dim,
            count=count * matrices,
            units=frozen(units),
            matrices=matrices,
            _distributions=dict(distributions),
            _seed=seed,
            _method=method,
        )

    _distributions: dict[str, Any]
    _seed: int
    _method: str

    def values(self, start: int, stop: int) -> dict[str, Array]:
        """Return the values of the parameters; see `Block`."""
        first, last = start // self.matrices, -(-stop // self.matrices)
        if last == first:
            return {name: np.empty(0) for name in self._distributions}
        unit_cube = self._uniform(first, last)
        wanted = slice(start - first * self.matrices, stop - first * self.matrices)
        columns = {}
        for index, (name, distribution) in enumerate(self._distributions.items()):
            quantile = getattr(distribution, "ppf", None) or distribution.icdf
            values = np.asarray(quantile(self._column(unit_cube, index)), dtype=float)
            columns[name] = values.ravel()[wanted]
        return columns

    def _column(self, cube: Array, index: int) -> Array:
        """Return what a parameter is made of, `(n, matrices)`, from `(n, k or 2 k)` in [0, 1)."""
        if self.matrices == 1:
            return cube[:, index, None]
        count = len(self._distributions)
        columns = np.repeat(cube[:, index, None], self.matrices, axis=1)
        columns[:, [1, 2 + index]] = cube[:, count + index, None]
        return columns

    def _uniform(self, start: int, stop: int) -> Array:
        """Return samples of the unit cube, `(stop - start, k)`, 2 k of them for Sobol indices."""
        size = len(self._distributions) * (2 if self.matrices > 1 else 1)
        if self._method == "random":
            # Its generator jumps: a number of the stream is taken for every entry.
            stream = np.random.PCG64(self._seed).advance(start * size)
            return np.random.Generator(stream).random((stop - start, size))
        if self._method == "latin":
            return self._latin[start:stop]
        from scipy.stats import qmc

        kinds = {"sobol": qmc.Sobol, "halton": qmc.Halton}
        # Not `rng=`, which older versions of SciPy do not know: the same numbers in all of them.
        engine = kinds[self._method](size, scramble=True, seed=np.random.default_rng(self._seed))
        if start:
            engine.fast_forward(start)
        return np.asarray(_drawn(engine, stop - start))

    @cached_property
    def _latin(self) -> Array:
        """The whole hypercube, of which no part can be made without the others."""
        from scipy.stats import qmc

        size = len(self._distributions)
        engine = qmc.LatinHypercube(size, seed=np.random.default_rng(self._seed))
        return np.asarray(engine.random(self.count))

    def described(self, count: int) -> dict[str, Any]:
        """Return distributions, method and seed; see `Block`."""
        told = {
            "kind": "samples",
            "dim": self.dim,
            "units": dict(self.units),
            "distributions": {name: _law(item) for name, item in self._distributions.items()},
            "method": self._method,
            "seed": self._seed,
            "matrices": self.matrices,
        }
        # Every row of a hypercube depends on how many there are.
        return told | ({"count": self.count} if self._method == "latin" else {})


def points(parameters: Mapping[str, Any], *, dim: str = "point") -> Points:
    """Return parameters that vary together: a list of points, along one dimension.

    Args:
        parameters: names to values `(N,)`, or to pairs of these and a unit.
        dim: name of the dimension.

    Raises:
        ArgumentError: none, nothing in them, of different lengths, or not finite.

    >>> points({"angle": ([0.1, 0.2], "rad"), "speed": ([10.0, 30.0], "rad/s")})
    <Points of angle, speed: 2 along 'point'>
    """
    given = _named(parameters)
    columns, units = {}, {}
    for name, value in given.items():
        values, units[name] = _with_unit(value)
        columns[name] = values if isinstance(values, Line) else read_only(_column(name, values))
    lengths = {name: len(column) for name, column in columns.items()}
    if len(set(lengths.values())) != 1:
        raise ArgumentError(f"points need values of one length, not {lengths}")
    return Points(columns, units, _dim(dim))


def samples(
    parameters: Mapping[str, Any],
    count: int,
    *,
    seed: int,
    method: str = "sobol",
    dim: str = "sample",
) -> Samples:
    """Return samples of parameters that follow distributions.

    Args:
        parameters: names to distributions of `scipy.stats` with their arguments
            (`norm(0.0, 0.01)`), or to pairs of these and a unit. They are independent.
        count: of the samples; of Sobol's sequence a power of 2 is best.
        seed: which samples; the same ones for the same seed.
        method: `sobol` or `halton`, whose sequences (scrambled) fill space more evenly than
            `random` numbers; these three can be extended. `latin` is a hypercube, which cannot.
        dim: name of the dimension.

    Raises:
        ArgumentError: none, a distribution without quantiles, or an unknown method.
    """
    distributions, units = _distributions(parameters)
    if text("method", method) not in METHODS:
        raise ArgumentError(f"method is {method!r}; methods: {choices(METHODS, method)}")
    size, start = whole("count", count), whole("seed", seed, 0)
    return Samples(distributions, units, size, seed=start, method=method, dim=_dim(dim))


def sobol_samples(
    parameters: Mapping[str, Any], count: int, *, seed: int, dim: str = "sample"
) -> Samples:
    """Return the samples from which `sobol_indices` tells what each parameter contributes.

    They are `count` times the number of parameters plus 2, after Saltelli: a study of them can be
    read as one of `2 count` plain samples (`independent`), and be extended.

    Args:
        parameters: see `samples`.
        count: of the samples, a power of 2.
        seed: which samples.
        dim: name of the dimension.

    Raises:
        ArgumentError: as `samples`, or no power of 2.

    Source:
        Saltelli et al., Variance based sensitivity analysis of model output, Computer Physics
        Communications 181 (2010), estimators and layout as in `scipy.stats.sobol_indices`.
    """
    distributions, units = _distributions(parameters)
    size = whole("count", count)
    if size & (size - 1):
        raise ArgumentError(f"count is {size}; Sobol indices need a power of 2, such as 1024")
    seed = whole("seed", seed, 0)
    name = _dim(dim)
    return Samples(
        distributions, units, size, seed=seed, method="sobol", dim=name, for_indices=True
    )


class Parameters(Frozen):
    """All that a study varies: blocks, whose product the cases are.

    Attributes:
        blocks: in the order of the dimensions.
        shape: number of points of each.
        units: names of all parameters to their units.
    """

    blocks: tuple[Block, ...]
    shape: tuple[int, ...]
    units: FrozenDict[str, str]

    def __init__(self, blocks: Sequence[Block]) -> None:
        shape = tuple(block.count for block in blocks)
        units = {name: unit for block in blocks for name, unit in block.units.items()}
        self._freeze(blocks=tuple(blocks), shape=shape, units=frozen(units))

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions."""
        return tuple(block.dim for block in self.blocks)

    @property
    def count(self) -> int:
        """Number of cases."""
        return math.prod(self.shape)

    def mesh(self, box: Sequence[slice]) -> dict[str, Array]:
        """Return the values in a box of cases, with axes along which they broadcast.

        Args:
            box: a span of each dimension, with both ends.
        """
        found = {}
        for index, (block, span) in enumerate(zip(self.blocks, box, strict=True)):
            shape = [1] * len(self.blocks)
            shape[index] = span.stop - span.start
            for name, values in block.values(span.start, span.stop).items():
                found[name] = values.reshape(shape)
        return found

    def case(self, index: Sequence[int]) -> dict[str, Any]:
        """Return the parameters of a case by its index in each dimension, as plain numbers."""
        mesh = self.mesh([slice(place, place + 1) for place in index])
        return {name: values.item() for name, values in mesh.items()}

    def __repr__(self) -> str:
        sizes = " × ".join(f"{block.dim} {block.count}" for block in self.blocks)
        return f"<Parameters: {sizes} = {self.count} cases>"


def checked_parameters(given: object) -> Parameters:
    """Return what a user gave as parameters of a study.

    Args:
        given: `Parameters`, a block, a mapping of names to values (a grid), or a sequence of these.

    Raises:
        ArgumentError: it is anything else, empty, or a name occurs twice.
    """
    if isinstance(given, Parameters):
        return given
    listed: list[Any] = [given] if isinstance(given, (Block, Mapping)) else _sequence(given)
    blocks: list[Block] = []
    for item in listed:
        if isinstance(item, Block):
            blocks.append(item)
        else:
            blocks += [points({name: values}, dim=name) for name, values in _named(item).items()]
    names = [name for block in blocks for name in block.units]
    dims = [block.dim for block in blocks]
    for kind, every in (("parameter", names), ("dimension", dims)):
        repeated = {name for name in every if every.count(name) > 1}
        if repeated:
            raise ArgumentError(f"{kind} {choices(repeated)} occurs twice; name each one once")
    columns = {"type", "message", *(f"{dim}_index" for dim in dims)}
    if clash := columns & set(names):
        raise ArgumentError(
            f"{choices(clash)} is a parameter, and a column of what failed: give it another name"
        )
    if clash := {block.dim for block in blocks if block.dim not in block.units} & set(names):
        raise ArgumentError(
            f"{choices(clash)} is a parameter and a dimension; name the dimension: dim=…"
        )
    return Parameters(blocks)


def _sequence(given: object) -> list[Any]:
    if isinstance(given, (list, tuple)) and given:
        return list(given)
    raise ArgumentError(
        f"parameters is {described(given)}, expected a mapping of names to values, points(…), "
        "samples(…) or a list of these"
    )


def _named(given: object) -> dict[str, Any]:
    """Return a mapping of names to parameters that is not empty."""
    found = mapping("parameters", given)
    if not found:
        raise ArgumentError(
            'parameters are empty; give names and values: {"angle": (values, "rad")}'
        )
    return {name_of_array("a parameter", name): value for name, value in found.items()}


def _dim(name: str) -> str:
    return name_of_array("a dimension", text("dim", name))


def name_of_array(what: str, name: object) -> str:
    """Return a name, which becomes that of an array of the store, and so of a folder.

    Raises:
        ArgumentError: it cannot be one.
    """
    is_word = isinstance(name, str) and name.strip() and name.isprintable()
    if (
        not isinstance(name, str)
        or not is_word
        or set(name) & {"/", "\\"}
        or name in (".", "..", *_RESERVED)
        or len(name.encode()) > _LONGEST_NAME
    ):
        raise ArgumentError(
            f"{what} is called {described(name)}: names are words of at most {_LONGEST_NAME} "
            f"letters, without a slash, and none of {choices(_RESERVED)}, which every study has"
        )
    return name


def _with_unit(given: object) -> tuple[Any, str]:
    """Return what was given for a parameter, and its unit."""
    if isinstance(given, tuple) and len(given) == 2:
        values, unit = given
        if isinstance(unit, str) and not isinstance(values, str):  # And not two words.
            return values, unit
    return given, ""


def _column(name: str, given: object) -> Array:
    """Return values of a parameter `(N,)`: finite numbers, truth values or words."""
    try:
        values = np.array(given)
    except Exception as error:
        raise ArgumentError(f"{name}: no array can be made of {described(given)}") from error
    if np.ma.is_masked(given):
        raise ArgumentError(f"{name} is masked in places; leave such values out")
    values = np.atleast_1d(values)
    if values.dtype.kind == "U" and not isinstance(given, (str, np.ndarray)):
        other = next(
            (item for item in np.array(given, dtype=object).ravel() if not isinstance(item, str)),
            None,
        )
        if other is not None:
            raise ArgumentError(
                f"{name} is words and {described(other)}, which would be a word: give one kind"
            )
    if values.ndim != 1 or values.dtype.kind not in "biufU":
        raise ArgumentError(
            f"{name} is {described(given)} of shape {values.shape}, expected values (N,), or a "
            "pair of these and a unit"
        )
    if not len(values):
        raise ArgumentError(f"{name} is empty: a study needs a value of every parameter")
    if values.dtype.kind == "f" and not np.all(np.isfinite(values)):
        index = int(np.argmin(np.isfinite(values)))
        raise ArgumentError(f"{name} is not finite at index {index}; leave such values out")
    return values


def _distributions(given: object) -> tuple[dict[str, Any], dict[str, str]]:
    """Return distributions by name, and their units."""
    found, units = {}, {}
    for name, value in _named(given).items():
        found[name], units[name] = _with_unit(value)
        if not (hasattr(found[name], "ppf") or hasattr(found[name], "icdf")):
            raise ArgumentError(
                f"{name} is {described(found[name])}, expected a distribution such as "
                "scipy.stats.norm(0.0, 0.01)"
            )
        _refuse_without_quantiles(name, found[name])
    return found, units


def _refuse_without_quantiles(name: str, distribution: Any) -> None:
    """Refuse a distribution whose arguments are wrong: its quantiles are not numbers."""
    quantile = getattr(distribution, "ppf", None) or distribution.icdf
    try:
        middle = np.asarray(quantile(np.array([0.25, 0.75])), dtype=float)
    except Exception as error:
        raise ArgumentError(f"{name}: its distribution fails ({error})") from error
    if middle.shape != (2,) or not np.all(np.isfinite(middle)):
        raise ArgumentError(
            f"{name}: quantiles of its distribution are not finite; check its arguments"
        )


def _law(distribution: Any) -> str:
    """Return what tells a distribution from others as a text, the same in all processes."""
    from scipy import stats

    family = getattr(distribution, "dist", distribution)
    name = getattr(family, "name", None)
    if isinstance(name, str) and type(getattr(stats, name, None)) is type(family):
        if family is distribution:
            return f"{name}()[]"
        return f"{name}{distribution.args!r}{sorted(distribution.kwds.items())!r}"
    if hasattr(distribution, "icdf"):
        return repr(distribution)
    # Histograms and classes of users have no name that says all: then by what it returns.
    quantiles = np.asarray(distribution.ppf(_QUANTILES), dtype=float)
    return f"{type(family).__qualname__} {_hash(quantiles)}"


def _drawn(engine: Any, count: int) -> Array:
    """Return points of a sequence, of which any number may be asked for, without a warning."""
    import warnings

    with warnings.catch_warnings():
        # A part of the sequence need not be a power of two; the whole is what should be.
        warnings.filterwarnings("ignore", message="The balance properties", category=UserWarning)
        return np.asarray(engine.random(count))


def _hash(values: Array) -> str:
    """Return the hash of values of an axis, by what they are rather than how they are stored."""
    if values.dtype.kind == "U":
        return hashlib.sha256(json.dumps(values.tolist()).encode()).hexdigest()
    plain = np.ascontiguousarray(values, dtype="<f8")
    if values.dtype.kind in "iu" and np.any(np.abs(plain) >= LARGEST_WHOLE):  # Such as seeds.
        return hashlib.sha256(json.dumps(values.tolist()).encode()).hexdigest()
    return hashlib.sha256(plain.tobytes()).hexdigest()
