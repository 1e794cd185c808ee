"""Case line: what a sweep or a trajectory is of, in one line for titles."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...kit.quantities import span
from ..elements.link_loads import Wrench

_MOST = 2
"""Drives, and loads, that are told one by one."""


def case_line(turn: Any) -> str:
    """Return mechanism, drives with their ranges, speeds and loads of a result.

    Args:
        turn: a sweep over one dimension, or a trajectory.
    """
    loads = [_load(turn, name) for name in turn.loads]
    if hasattr(turn, "kinetic_energy"):
        drives = [_ends(turn.time, "s")]
    else:
        drives = [_drive(turn, *item) for item in enumerate(turn.coordinates)]
    parts = (_counted(drives, "drives"), _counted(loads, "loads"))
    return f"{turn.mechanism.name}: {', '.join(filter(None, parts))}".removesuffix(": ")


def _counted(texts: list[str], what: str) -> str:
    return ", ".join(texts) if len(texts) <= _MOST else f"{len(texts)} {what}"


def _drive(turn: Any, column: int, name: str) -> str:
    """Return where and how fast a drive goes."""
    position, speed = (
        np.reshape(values, (len(turn), -1))[:, column] for values in (turn.position, turn.speed)
    )
    if turn.mechanism.drivable[name].slides:
        way, fast = _ends(position, "m"), _ends(speed, "m/s")
    else:
        way, fast = _ends(np.rad2deg(position), "°"), _ends(30.0 / np.pi * speed, "1/min")
    return f"{name} {way} at {fast}" if np.any(speed) else f"{name} {way}"


def _load(turn: Any, name: str) -> str:
    """Return a load on a joint, or the greatest force or moment on a link."""
    load = turn.loads[name]
    if not isinstance(load, Wrench):
        return f"load {name} {_ends(load, turn.mechanism.drivable[name].effort_unit)}"
    units = ((load.force, "N"), (load.moment, "N·m"))
    sizes = [(np.linalg.norm(vectors, axis=-1), unit) for vectors, unit in units]
    texts = [_ends(size, unit) for size, unit in sizes if np.any(size)]
    return f"load {name} {', '.join(texts)}"


def _ends(values: Any, unit: str) -> str:
    every = np.asarray(values, dtype=float)
    return span(float(np.min(every)), float(np.max(every)), unit).replace("-", "−")
