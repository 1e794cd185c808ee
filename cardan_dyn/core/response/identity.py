"""Identity: hashes of what a response depends on, by which a file is matched with its scene."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass

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
            problem.link_loads,
        ],
        "gravity": problem.gravity,
        "elements": problem.elements,
        **more,
    }
    moves = {name: hashed for name, hashed in identity(problem).items() if name in _MOVES}
    return {**moves, **{name: digest(value, True) for name, value in acts.items()}}


def digest(value: object, whole: bool = False) -> str:
    """Return the hash of a value made of records, mappings, sequences, texts and numbers.

    Args:
        value: that is hashed.
        whole: whether all fields of records count, functions as such, or those that are mechanical.
    """
    plain = repr(_plain(value, whole))
    return hashlib.sha256(plain.encode("utf-8", "surrogatepass")).hexdigest()


def _plain(value: object, whole: bool) -> object:
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
        return [_plain(item, whole) for item in value]
    if isinstance(value, Mapping):
        return {key: _plain(value[key], whole) for key in sorted(value)}
    if is_dataclass(value) and not isinstance(value, type):
        every = {
            field.name: _plain(getattr(value, field.name), whole)
            for field in fields(value)
            if whole or field.name not in _NOT_MECHANICAL
        }
        name = type(value).__name__
        return [name, dict(sorted(every.items()))] if whole else ({name}, every)
    if whole and callable(value):
        return "a function"
    raise TypeError(f"no canonical form for {type(value).__name__}")
