"""How much time is saved if fewer outputs are computed?

Quasi-static instead of at speed, the drive effort alone instead of all wrenches, and one of two
drive lines on a common input shaft instead of both. 721 samples, times relative to asking for all.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

import cardan_dyn as cd

from .descriptions import two_lines
from .records import Record, markdown, save
from .timing import least_seconds

NAME = "skipping"
SAMPLES = 721
HELD = {"joint_angle_1": 0.4, "joint_angle_2": 0.3}


def _cases() -> dict[str, dict[str, Callable[[], object]]]:
    positions = np.linspace(0.0, 2.0 * np.pi, SAMPLES)
    shaft = cd.load("double_shaft_z")
    options = {"drive": "bearing_in", "held": HELD, "loads": {"bearing_out": -1.0}}
    whole, effort = cd.Scene(shaft, **options), cd.Scene(shaft, **options, outputs=[])
    lines = cd.load(two_lines(8))
    loads = {"bearing_8": -1.0, "other_bearing_8": -1.0}
    names = [name for name in lines.joint_names if not name.startswith("other_")]
    both = cd.Scene(lines, drive="bearing_0", loads=loads)
    single = cd.Scene(
        lines, drive="bearing_0", loads=loads, outputs=[n for n in names if n != "bearing_0"]
    )
    end = cd.Scene(lines, drive="bearing_0", loads=loads, outputs=["bearing_8"])
    return {
        "double shaft": {
            "all wrenches at speed": partial(whole.sweep, positions, 100.0),
            "all wrenches, quasi-static": partial(whole.sweep, positions),
            "drive effort at speed": partial(effort.sweep, positions, 100.0),
            "drive effort, quasi-static": partial(effort.sweep, positions),
        },
        "two lines of 8 joints": {
            "all wrenches at speed": partial(both.sweep, positions, 100.0),
            "all wrenches, quasi-static": partial(both.sweep, positions),
            "one line at speed": partial(single.sweep, positions, 100.0),
            "its last bearing at speed": partial(end.sweep, positions, 100.0),
        },
    }


def measure(fast: bool = False) -> list[Record]:
    """Return all records."""
    records = []
    for mechanism, runs in _cases().items():
        seconds = least_seconds(runs, 2 if fast else 9)
        whole = next(iter(seconds.values()))
        records += [
            Record(
                task=NAME,
                method=name,
                version=cd.__version__,
                parameters={"mechanism": mechanism, "samples": SAMPLES},
                microseconds=value / SAMPLES * 1e6,
                ratio=value / whole,
            )
            for name, value in seconds.items()
        ]
    return records


def answer(records: list[Record]) -> str:
    """Return what is saved."""
    return "\n".join(
        f"{r.parameters['mechanism']}, {r.method}: {r.ratio:.0%} of the time." for r in records
    )


def run(fast: bool = False) -> str:
    """Measure, write results, and return the Markdown text."""
    records = measure(fast)
    text = answer(records)
    save(NAME, [record.flat() for record in records], text)
    rows = [
        [r.parameters["mechanism"], r.method, f"{r.microseconds:.3g}", f"{r.ratio:.2f}"]
        for r in records
    ]
    return f"{markdown(['mechanism', 'computed', 'µs/sample', 'ratio'], rows)}\n\n{text}"
