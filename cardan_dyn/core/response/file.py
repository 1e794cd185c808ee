"""File of a response: it is read only if undamaged, and only by the scene that it belongs to."""

from __future__ import annotations

import hashlib
import io
import json
import os
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ...kit.arrays import Array
from ...kit.checks import file_path, writing
from ...kit.errors import CardanError
from ...kit.frozen import frozen
from ..dynamics.problem_solver import ProblemSolver
from ..problem.problem import Problem
from .columns import Acts, Column, Layout
from .data import Proof, ResponseData
from .domain import Domain
from .identity import identity
from .sampling import layout_of
from .series import Series

_FORMAT = 3
"""Version of the files."""
_MARKS = ("zero", "constant", "unique")


def write(path: str | os.PathLike[str], problem: Problem, data: ResponseData) -> None:
    """Write a response; see `Response.save`."""
    target = file_path("path", path)
    header = {
        "format": _FORMAT,
        "mechanism": problem.mechanism.name,
        "identity": identity(problem),
        # Their order is that of the loads of the scene.
        "columns": [[column.kind.name, column.name] for column in data.layout.columns],
        "domain": data.series.domain,
        "coupling_unique": data.coupling_unique,
        "proof": vars(data.proof),
    }
    arrays = {name: getattr(data, name) for name in _MARKS}
    arrays |= {"values": data.series.values, "header": np.array(json.dumps(header))}
    content = io.BytesIO()
    np.savez_compressed(content, checksum=np.array(_checksum(arrays)), **arrays)
    with writing(target) as part:
        part.write_bytes(content.getvalue())


def read(path: str | os.PathLike[str], solver: ProblemSolver) -> ResponseData:
    """Read the response of a scene; see `Scene.load_response`."""
    source = file_path("path", path)
    try:
        content = source.read_bytes()
    except (OSError, ValueError) as error:
        raise CardanError(f"{source}: cannot be read ({error})") from error
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        checksum, told = str(arrays.pop("checksum")), json.loads(str(arrays["header"]))
        is_intact, file_format = checksum == _checksum(arrays), told["format"]
    except Exception as error:  # Zip, zlib, NumPy and JSON raise errors of many types.
        raise CardanError(f"{source}: is not a saved response ({error})") from error
    if not is_intact:
        raise CardanError(f"{source}: is damaged or was changed; save the response again")
    if file_format != _FORMAT:
        raise CardanError(
            f"{source}: is of format {file_format!r}, this version reads {_FORMAT}; save it again"
        )
    try:
        expected, saved = identity(solver.problem), told["identity"]
        different = [name for name in expected if saved.get(name) != expected[name]]
        data = None if different else _data(layout_of(solver), told, arrays)
    except Exception as error:  # The checksum is right: another program has written the file.
        raise CardanError(f"{source}: is not a saved response ({error})") from error
    if data is None:
        raise CardanError(
            f"{source}: is the response of another scene; different: {', '.join(different)}"
        )
    return data


def _data(layout: Layout, told: Mapping[str, Any], arrays: Mapping[str, Array]) -> ResponseData:
    """Return the functions that a file holds, of the layout that the scene has."""
    columns = tuple(Column(Acts[kind], name) for kind, name in told["columns"])
    values, series = arrays["values"], Series(arrays["values"], Domain(*told["domain"]))
    marks = zero, constant, unique = [arrays[name] for name in _MARKS]
    rows = layout.size * len(columns)
    shapes = [(rows,), (rows,), (len(layout.outputs), 6)]
    if not (
        set(columns) == set(layout.columns)
        and [item.shape for item in marks] == shapes
        and all(item.dtype == bool for item in marks)
        and values.dtype == float
        and len(values) == rows
        and values.shape[1] % 2 == (not series.domain.periodic)
        and values.shape[1] >= 8  # Decay is measured by eighths.
        and np.all(np.isfinite(values))
        and 0.0 < series.domain.length < np.inf
    ):
        raise ValueError("its arrays are not those of the scene")
    return ResponseData(
        replace(layout, columns=columns),
        series,
        zero,
        constant,
        unique,
        frozen({name: bool(told["coupling_unique"][name]) for name in layout.couplings}),
        Proof(**{**told["proof"], "unproven": tuple(told["proof"]["unproven"])}),
    )


def _checksum(arrays: Mapping[str, Array]) -> str:
    hashed = hashlib.sha256()
    for name, array in sorted(arrays.items()):
        hashed.update(f"{name} {array.dtype.str} {array.shape}".encode())
        hashed.update(array.tobytes())
    return hashed.hexdigest()
