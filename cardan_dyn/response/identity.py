"""Identity: hashes of what a response depends on, by which a file is matched with its scene."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass

import numpy as np

from .._version import __version__
from ..problem.problem import Problem

FORMAT = 2
"""Version of the files that hold responses."""
_NOT_MECHANICAL = {
    *("source", "notation", "warnings", "limits", "independent_joints"),
    *("damping", "friction"),
}
"""Fields of a description that no response depends on: where it comes from, how it is written,
what it advises. The same mechanism from another file has the same responses."""


def identity(problem: Problem) -> dict[str, str]:
    """Return what a scene's response depends on: the name of each argument to its hash.

    The values of efforts and gravity are left out, since a response holds for any. The order of
    held and started joints matters: they are brought to their positions one after the other.
    """
    arguments: dict[str, object] = {
        "version of the package": __version__,
        "description": problem.mechanism.description,
        "drives": problem.independent,
        "held": list(problem.held.items()),
        "near": list(problem.near.items()),
        "near of balls": {name: ball.tolist() for name, ball in problem.near_balls.items()},
        "branch": problem.branch,
        "outputs": problem.outputs,
        "joint loads": sorted(problem.joint_loads),
        "link loads": problem.link_loads,
        "gravity": bool(np.any(problem.gravity)),
        "compliance": problem.compliance,
        "strict": problem.strict,
    }
    return {name: digest(value) for name, value in arguments.items()}


def digest(value: object) -> str:
    """Return the hash of a value made of records, mappings, sequences, texts and numbers."""
    hashed = hashlib.sha256()
    for chunk in _serial(value):
        hashed.update(chunk)
    return hashed.hexdigest()


def _serial(value: object) -> Iterator[bytes]:
    """Return a value as bytes that no other has: type and size come before its content."""
    if value is None or isinstance(value, (bool, np.bool_)):
        yield f"{value};".encode()
    elif isinstance(value, int):
        yield f"i{value};".encode()
    elif isinstance(value, str):
        content = value.encode("utf-8", "surrogatepass")
        yield f"s{len(content)};".encode()
        yield content
    elif isinstance(value, (float, np.ndarray)):
        array = np.asarray(value)
        kind = "?" if array.dtype.kind == "b" else "<f8"
        yield f"a{kind}{array.shape};".encode()
        # Adding zero makes -0.0 a 0.0, which means the same but has other bytes.
        yield (array.astype(kind) + np.zeros((), kind)).tobytes()
    elif isinstance(value, (list, tuple)):
        yield f"l{len(value)};".encode()
        for item in value:
            yield from _serial(item)
    elif isinstance(value, Mapping):
        yield f"m{len(value)};".encode()
        for key in sorted(value):
            yield from _serial(key)
            yield from _serial(value[key])
    elif is_dataclass(value):
        kept = [field.name for field in fields(value) if field.name not in _NOT_MECHANICAL]
        yield f"d{type(value).__name__}{len(kept)};".encode()
        for name in kept:
            yield from _serial(name)
            yield from _serial(getattr(value, name))
    else:
        raise TypeError(f"no canonical form for {type(value).__name__}")
