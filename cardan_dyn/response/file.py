"""File of a response: it is read only if undamaged, and only by the scene that it belongs to."""

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
from ..checks import file_path, writing
from ..dynamics.problem_solver import ProblemSolver
from ..errors import CardanError
from ..frozen import frozen
from ..problem.problem import Problem
from .columns import Column, Kind, Layout
from .data import Proof, ResponseData
from .domain import Domain
from .identity import FORMAT, identity
from .sampling import layout_of
from .series import Series

_ARRAYS = ("values", "place", "periodic", "zero", "constant", "unique")
"""Arrays of a file; `place` holds origin and length of the domain."""
_LEAST_SAMPLES = 8
"""Fewer samples are refused: no response has them, and decay is measured by eighths."""


def write(path: str | os.PathLike[str], problem: Problem, data: ResponseData) -> None:
    """Write a response; see `Response.save`."""
    target = file_path("path", path)
    domain, layout = data.series.domain, data.layout
    arrays: dict[str, Any] = {
        "values": data.series.values,
        "place": np.array([domain.origin, domain.length]),
        "periodic": np.array(domain.periodic),
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
    header_text = json.dumps(header)
    content = io.BytesIO()
    np.savez_compressed(
        content,
        header=np.array(header_text),
        checksum=np.array(_checksum(header_text, arrays)),
        **arrays,
    )
    with writing(target) as part:
        part.write_bytes(content.getvalue())


def read(path: str | os.PathLike[str], solver: ProblemSolver) -> ResponseData:
    """Read the response of a scene; see `Scene.load_response`."""
    source = file_path("path", path)
    try:
        content = source.read_bytes()
    except (OSError, ValueError) as error:
        raise CardanError(f"{source}: cannot be read ({error})") from error
    header, arrays = _intact(source, content)
    try:
        saved, layout = dict(header["identity"]), _layout(header)
        expected = identity(solver.problem)
        different = [name for name in expected if saved.get(name) != expected[name]]
        data = None if different else _data(solver, layout, header, arrays)
    except Exception as error:  # The checksum is right: another program has written the file.
        raise CardanError(f"{source}: is not a saved response ({error})") from error
    if data is None:
        raise CardanError(
            f"{source}: is the response of another scene; different: {', '.join(different)}"
        )
    return data


def _intact(source: Path, content: bytes) -> tuple[dict[str, Any], dict[str, Array]]:
    """Return header and arrays of a file that is undamaged and of the present format."""
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            header_text = str(file["header"])
            arrays = {name: file[name] for name in _ARRAYS}
            is_intact = str(file["checksum"]) == _checksum(header_text, arrays)
        header = json.loads(header_text)
        file_format = header["format"]
    except Exception as error:  # Zip, zlib, NumPy and JSON raise errors of many types.
        raise CardanError(f"{source}: is not a saved response ({error})") from error
    if not is_intact:
        raise CardanError(f"{source}: is damaged or was changed; save the response again")
    if file_format != FORMAT:
        raise CardanError(
            f"{source}: is of format {file_format!r}, this version reads {FORMAT}; save it again"
        )
    return header, arrays


def _checksum(header: str, arrays: Mapping[str, Array]) -> str:
    hashed = hashlib.sha256(header.encode("utf-8", "surrogatepass"))
    for name in sorted(arrays):
        array = np.asarray(arrays[name])
        hashed.update(f"{name} {array.dtype.str} {array.shape}".encode())
        hashed.update(array.tobytes())
    return hashed.hexdigest()


def _layout(header: Mapping[str, Any]) -> Layout:
    columns = tuple(Column(Kind[kind], name) for kind, name in header["columns"])
    outputs, efforts, couplings = (
        tuple(map(str, header[name])) for name in ("outputs", "efforts", "couplings")
    )
    return Layout(columns, outputs, efforts, couplings)


def _data(
    solver: ProblemSolver, layout: Layout, header: Mapping[str, Any], arrays: Mapping[str, Array]
) -> ResponseData:
    """Return the functions that a file holds."""
    expected = layout_of(solver)
    # The order of the columns in the file is that of the loads of the scene that was saved.
    _expect("columns", sorted(map(repr, layout.columns)), sorted(map(repr, expected.columns)))
    for name in ("outputs", "efforts", "couplings"):
        _expect(name, getattr(layout, name), getattr(expected, name))
    _check_arrays(layout, arrays)
    coupling_unique = {name: bool(header["coupling_unique"][name]) for name in layout.couplings}
    entries = dict(header["proof"])
    proof = Proof(
        unproven=tuple(map(str, entries.pop("unproven"))),
        **{name: float(value) for name, value in entries.items()},
    )
    origin, length = (float(value) for value in arrays["place"])
    series = Series(arrays["values"], Domain(origin, length, bool(arrays["periodic"])))
    zero, constant, unique = (arrays[name] for name in ("zero", "constant", "unique"))
    return ResponseData(layout, series, zero, constant, unique, frozen(coupling_unique), proof)


def _check_arrays(layout: Layout, arrays: Mapping[str, Array]) -> None:
    """Refuse arrays that cannot be those of a response."""
    sample_count = arrays["values"].shape[-1] if arrays["values"].ndim else 0
    expected = {
        "values": (float, (layout.count, sample_count)),
        "place": (float, (2,)),
        "periodic": (bool, ()),
        "zero": (bool, (layout.count,)),
        "constant": (bool, (layout.count,)),
        "unique": (bool, (len(layout.outputs), 6)),
    }
    for name, (kind, shape) in expected.items():
        _expect(f"type of {name}", arrays[name].dtype, np.dtype(kind))
        _expect(f"shape of {name}", arrays[name].shape, shape)
    origin, length = (float(value) for value in arrays["place"])
    is_finite = bool(np.all(np.isfinite(arrays["values"])) and np.isfinite(origin))
    _expect("finite values", is_finite and 0.0 < length < np.inf, True)
    # A period has an even number of samples; a range has one more.
    is_even = sample_count % 2 == (not arrays["periodic"])
    _expect("samples", sample_count >= _LEAST_SAMPLES and is_even, True)


def _expect(quantity: str, value: object, expected: object) -> None:
    if value != expected:
        raise ValueError(f"{quantity}: {value!r}, expected {expected!r}")
