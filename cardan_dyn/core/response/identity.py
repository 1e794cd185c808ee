"""Identity: hashes of what a response depends on, by which a file is matched with its scene."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from ..._version import __version__
from ..problem.problem import Problem

_NOT_MECHANICAL = {
    *("source", "notation", "warnings", "limits", "independent_joints"),
    *("damping", "friction", "added"),
}
"""Fields of a description that no response depends on: where it comes from, how it is written,
what it advises. The same mechanism from another file has the same responses."""
_MOVES = ("description", "drives", "held", "near", "near of balls", "branch")
"""What decides how a mechanism moves."""


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


def forces_identity(problem: Problem, **more: object) -> dict[str, str]:
    """Return what the forces of a scene depend on: the name of each argument to its hash.

    The values of efforts and gravity count. Functions, such as an actuator's, cannot be compared
    and are left out.

    Args:
        problem: of the scene.
        more: what they depend on besides.
    """
    acts = {
        "loads": [
            {name: effort for name, effort in problem.joint_loads.items() if np.any(effort)},
            _record(problem.link_loads),
        ],
        "gravity": problem.gravity,
        "elements": [_record(item) for item in problem.elements],
        **more,
    }
    moves = {name: hashed for name, hashed in identity(problem).items() if name in _MOVES}
    return {**moves, **{name: digest(value) for name, value in acts.items()}}


def _record(value: Any) -> Any:
    """Return all fields of a record by name, those of records in it as well."""
    if is_dataclass(value) and not isinstance(value, type):
        every = {field.name: _record(getattr(value, field.name)) for field in fields(value)}
        return [type(value).__name__, every]
    if isinstance(value, Mapping):
        return {name: _record(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_record(item) for item in value]
    return "a function" if callable(value) else value


def digest(value: object) -> str:
    """Return the hash of a value made of records, mappings, sequences, texts and numbers."""
    return hashlib.sha256(repr(_plain(value)).encode("utf-8", "surrogatepass")).hexdigest()


def _plain(value: object) -> object:
    """Return a value as tuples and numbers whose text no other value has."""
    if value is None or isinstance(value, (bool, int, str)):
        return value
    if isinstance(value, np.bool_):
        return bool(value)
    if isinstance(value, (float, np.ndarray)):
        array = np.asarray(value)
        kind = "?" if array.dtype.kind == "b" else "<f8"
        # Adding zero makes -0.0 a 0.0, which means the same but has other bytes.
        return kind, array.shape, (array.astype(kind) + np.zeros((), kind)).tobytes()
    if isinstance(value, (list, tuple)):
        return list(map(_plain, value))
    if isinstance(value, Mapping):
        return {key: _plain(value[key]) for key in sorted(value)}
    if is_dataclass(value):
        kept = [item.name for item in fields(value) if item.name not in _NOT_MECHANICAL]
        return {type(value).__name__}, {name: _plain(getattr(value, name)) for name in kept}
    raise TypeError(f"no canonical form for {type(value).__name__}")
