"""Case line: what a sweep or a trajectory is of, in one line for titles."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...kit.arrays import NOTHING, Array
from ...kit.quantities import span
from ..elements.link_loads import Wrench

_MOST = 2
"""Drives, and loads, that are told one by one."""


class Lead(NamedTuple):
    """What moves as given: a drive, or a row of a task.

    Attributes:
        name: of it.
        slides: whether it is a length [m]; else it is an angle [rad].
        position, speed: `(..., )` in the shape of the samples.
    """

    name: str
    slides: bool
    position: Array
    speed: Array


def case_line(turn: Any) -> str:
    """Return mechanism, what moved as given with its ranges and speeds, and loads of a result.

    Args:
        turn: a sweep over one dimension, or a trajectory.
    """
    loads = [_load(turn, name) for name in turn.loads]
    if hasattr(turn, "kinetic_energy"):
        drives = [_ends(turn.time, "s")]
    else:
        varied = [lead for lead in turn.leads if np.ptp(lead.position)]
        drives = [
            _lead(lead) for lead in (turn.leads if len(varied) > _MOST else varied or turn.leads)
        ]
    what = "rows" if hasattr(turn, "rows") else "drives"
    parts = (_counted(drives, what), _counted(loads, "loads"))
    return f"{turn.mechanism.name}: {', '.join(filter(None, parts))}".removesuffix(": ")


def _counted(texts: list[str], what: str) -> str:
    return ", ".join(texts) if len(texts) <= _MOST else f"{len(texts)} {what}"


def _lead(lead: Lead) -> str:
    """Return where and how fast it goes."""
    if lead.slides:
        way, fast = _ends(lead.position, "m"), _ends(lead.speed, "m/s")
    else:
        way = _ends(np.rad2deg(lead.position), "°")
        fast = _ends(30.0 / np.pi * lead.speed, "1/min")
    moves = np.any(np.abs(lead.speed) > NOTHING)  # What is less comes from rounding.
    return f"{lead.name} {way} at {fast}" if moves else f"{lead.name} {way}"


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
