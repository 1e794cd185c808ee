"""What do calls cost that compute little: one position, a scene, a response?

The universal joint at β = 50° with a load, one call at a time, in R: one `pin.rnea` call from
Python on the same model. The stack overhead of Python and NumPy is nearly all of it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin

import cardan_dyn as cd

from .records import Record, markdown, save
from .timing import least_seconds

NAME = "short_calls"
_CALLS = 1000
"""Calls of `pin.rnea` that are timed together."""


def measure(fast: bool = False) -> list[Record]:
    """Return all records; `ratio` is the time in R."""
    joint = cd.load("universal_joint")
    model, data = joint.model, joint.model.createData()
    q, rest = pin.neutral(model), np.zeros(model.nv)

    def scene() -> cd.Scene:
        held = {"joint_angle": np.deg2rad(50.0)}
        return cd.Scene(joint, drive="bearing_in", held=held, loads={"bearing_out": -1.0})

    def followed() -> object:
        """Build a response whose motion has still to be followed."""
        joint.kept.forget("branch")
        return scene().response()

    def reference() -> None:
        for _ in range(_CALLS):
            pin.rnea(model, data, q, rest, rest)

    known = scene()
    known.sweep(np.linspace(0.0, 2.0 * np.pi, 2000))
    response = known.response()
    designs = {"joint_angle": np.linspace(0.1, 1.0, 20)}
    candidates: dict[str, Callable[[], object]] = {
        "rnea": reference,
        "one position": lambda: known.sweep([0.3])["bearing_out"].bending,
        "one position of a response": lambda: response.sweep([0.3])["bearing_out"].bending,
        "scene": scene,
        "load": lambda: cd.load("universal_joint"),
        "response, scene included": followed,
        "response of a known motion": known.response,
        "20 responses of designs": lambda: known.responses(designs),
    }
    seconds = least_seconds(candidates, 3 if fast else 20)
    unit = seconds.pop("rnea") / _CALLS
    return [
        Record(NAME, name, cd.__version__, microseconds=least * 1e6, ratio=least / unit)
        for name, least in seconds.items()
    ]


def answer(records: list[Record]) -> str:
    """Return what the calls cost."""
    return "; ".join(f"{record.method}: {record.ratio:.0f} R" for record in records) + "."


def run(fast: bool = False) -> str:
    """Measure, write results, and return the Markdown text."""
    records = measure(fast)
    text = answer(records)
    save(NAME, [record.flat() for record in records], text)
    rows = [
        [record.method, f"{record.microseconds:.4g}", f"{record.ratio:.0f}"] for record in records
    ]
    return f"{markdown(['call', 'µs', 'R'], rows)}\n\n{text}"
