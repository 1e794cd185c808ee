"""File of a response: written once, and read only by the scene that it belongs to, undamaged."""

from __future__ import annotations

import hashlib
import io
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Array
from ..checks import described
from ..dynamics.problem_solver import ProblemSolver
from ..errors import ArgumentError, CardanError
from ..frozen import frozen
from ..problem.problem import Problem
from .columns import Column, Kind, Layout
from .data import Proof, ResponseData
from .identity import FORMAT, identity
from .sampling import layout_of
from .series import Series

_ARRAYS = ("values", "place", "periodic", "zero", "constant", "unique")


def write(path: str | os.PathLike[str], problem: Problem, data: ResponseData) -> None:
    """Write a response; see `Response.save`."""
    where = _path(path)
    series, layout = data.series, data.layout
    arrays: dict[str, Any] = {
        "values": series.values,
        "place": np.array([series.origin, series.length]),
        "periodic": np.array(series.periodic),
        "zero": data.zero,
        "constant": data.constant,
        "unique": data.unique,
    }
    header = {
        "format": FORMAT,
        "mechanism": problem.mechanism.name,
        "identity": identity(problem),
        "columns": [[column.kind.name, column.name] for column in layout.columns],
        "outputs": layout.outputs,
        "efforts": layout.efforts,
        "couplings": layout.couplings,
        "coupling_unique": dict(data.coupling_unique),
        "proof": vars(data.proof),
    }
    written = json.dumps(header)
    content = io.BytesIO()
    np.savez_compressed(
        content,
        header=np.array(written),
        checksum=np.array(_checksum(written, arrays)),
        **arrays,
    )
    try:
        where.write_bytes(content.getvalue())
    except (OSError, ValueError) as error:
        raise CardanError(f"{where}: cannot be written ({error})") from error


def read(path: str | os.PathLike[str], solver: ProblemSolver) -> ResponseData:
    """Read the response of a scene; see `Scene.load_response`."""
    where = _path(path)
    try:
        content = where.read_bytes()
    except (OSError, ValueError) as error:
        raise CardanError(f"{where}: cannot be read ({error})") from error
    try:
        header, arrays, intact = _parts(content)
        written = header["format"]
    except Exception as error:  # Zip, zlib, NumPy and JSON fail in ways of their own.
        raise CardanError(f"{where}: is not a saved response ({error})") from error
    if not intact:
        raise CardanError(f"{where}: is damaged or was changed; save the response again")
    if written != FORMAT:
        raise CardanError(
            f"{where}: is of format {written!r}, this version reads {FORMAT}; save it again"
        )
    try:
        saved, layout = dict(header["identity"]), _layout(header)
        own = identity(solver.problem)
        different = [name for name in own if saved.get(name) != own[name]]
        data = None if different else _data(solver, layout, header, arrays)
    except Exception as error:  # Written by other code than ours, since the checksum is right.
        raise CardanError(f"{where}: is not a saved response ({error})") from error
    if data is None:
        raise CardanError(
            f"{where}: is the response of another scene; different: {', '.join(different)}"
        )
    return data


def _path(path: object) -> Path:
    if not isinstance(path, (str, os.PathLike)):
        raise ArgumentError(f"path is {described(path)}, expected a string or a path")
    try:
        return Path(path)
    except Exception as error:  # A path of somebody's own making.
        raise ArgumentError(f"path is {described(path)}, expected a string or a path") from error


def _parts(content: bytes) -> tuple[dict[str, Any], dict[str, Array], bool]:
    """Return header and arrays of a file, and whether they are as they were written."""
    with np.load(io.BytesIO(content), allow_pickle=False) as file:
        written = str(file["header"])
        arrays = {name: file[name] for name in _ARRAYS}
        intact = str(file["checksum"]) == _checksum(written, arrays)
    return json.loads(written), arrays, intact


def _checksum(header: str, arrays: Mapping[str, Array]) -> str:
    found = hashlib.sha256(header.encode("utf-8", "surrogatepass"))
    for name in sorted(arrays):
        part = np.asarray(arrays[name])
        found.update(f"{name} {part.dtype.str} {part.shape}".encode())
        found.update(part.tobytes())
    return found.hexdigest()


def _layout(header: Mapping[str, Any]) -> Layout:
    columns = tuple(Column(Kind[kind], name) for kind, name in header["columns"])
    outputs, efforts, couplings = (
        tuple(map(str, header[name])) for name in ("outputs", "efforts", "couplings")
    )
    return Layout(columns, outputs, efforts, couplings)


def _data(
    solver: ProblemSolver, layout: Layout, header: Mapping[str, Any], arrays: Mapping[str, Array]
) -> ResponseData:
    """Return the functions that a file holds.

    Raises:
        ValueError: something has another type or shape than the scene asks for.
    """
    own = layout_of(solver)
    # The order of loads and outputs in the file is that of the scene that was saved.
    _expect("columns", sorted(map(repr, layout.columns)), sorted(map(repr, own.columns)))
    for name in ("outputs", "efforts", "couplings"):
        _expect(name, getattr(layout, name), getattr(own, name))
    count = arrays["values"].shape[-1] if arrays["values"].ndim else 0
    shapes = {
        "values": (float, (layout.count, count)),
        "place": (float, (2,)),
        "periodic": (bool, ()),
        "zero": (bool, (layout.count,)),
        "constant": (bool, (layout.count,)),
        "unique": (bool, (len(layout.outputs), 6)),
    }
    for name, (kind, shape) in shapes.items():
        _expect(f"type of {name}", arrays[name].dtype, np.dtype(kind))
        _expect(f"shape of {name}", arrays[name].shape, shape)
    origin, length = (float(value) for value in arrays["place"])
    finite = bool(np.all(np.isfinite(arrays["values"])) and np.isfinite(origin))
    _expect("finite values", finite and 0.0 < length < np.inf, True)
    _expect("samples", count >= 8 and count % 2 == (not arrays["periodic"]), True)
    sure = {name: bool(header["coupling_unique"][name]) for name in layout.couplings}
    numbers = dict(header["proof"])
    proof = Proof(
        unproven=tuple(map(str, numbers.pop("unproven"))),
        **{name: float(value) for name, value in numbers.items()},
    )
    series = Series(arrays["values"], origin, length, bool(arrays["periodic"]))
    zero, constant, unique = (arrays[name] for name in ("zero", "constant", "unique"))
    return ResponseData(layout, series, zero, constant, unique, frozen(sure), proof)


def _expect(what: str, found: object, expected: object) -> None:
    if found != expected:
        raise ValueError(f"{what}: {found!r}, expected {expected!r}")
