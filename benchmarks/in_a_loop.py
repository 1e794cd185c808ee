"""Which call is cheap in a loop?

Every call asks for something new: another position, load, angle, length, spring. Processor times,
and calls of Python and C functions, which no busy machine changes, are multiples of those of one
position of a scene that knows its motion. The four-bar, and the universal joint where an angle is
held, or a line of three.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from itertools import count
from pathlib import Path

import numpy as np

import cardan_dyn as cd

from .records import Record, markdown, save
from .timing import least_seconds

NAME = "in_a_loop"
_CRANK, _ROCKER, _LENGTH = "crank_bearing", "rocker_bearing", "origin:rocker_pin.successor.x"
_FIRST = "sweep: another position"


def candidates(folder: Path) -> dict[str, Callable[[], object]]:
    """Return what is called, with all that it needs made and warm.

    Args:
        folder: for files.
    """
    bar, turn, numbers = cd.load("four_bar"), np.linspace(0.0, 2.0 * np.pi, 400), count(1)

    def new(first: float) -> float:
        return first * (1.0 + 1e-4 * next(numbers))

    def at() -> list[float]:
        return [new(0.3)]

    def springs() -> list[cd.JointSpring]:
        return [cd.JointSpring(_ROCKER, stiffness=new(3.0), rest=0.2, name="spring")]

    scene = cd.Scene(bar, drive=_CRANK, loads={_ROCKER: -5.0})
    longer, sprung = scene.replace(held={_LENGTH: 0.0}), scene.replace(elements=springs())
    joint = cd.Scene(cd.load("universal_joint"), drive="bearing_in", held={"joint_angle": 0.9})
    angles = {f"joint_angle_{k}": 0.1 * k for k in (1, 2, 3)}
    line = cd.Scene(cd.load("drive_line"), drive="bearing_in", held=angles)
    free = cd.Scene(bar, free=_CRANK, gravity=(0.0, -9.81, 0.0), elements=springs())
    for each in (scene, longer, sprung, joint, line):
        each.sweep(turn)
    response, one, many = scene.response(), scene.sweep([0.3]), scene.sweep(turn[:72])
    of_masses = (
        "mass:coupler",
        "mass:rocker",
        "centre:coupler.x",
        "centre:rocker.x",
        "load:crank_pin",
    )
    return {
        _FIRST: lambda: scene.sweep(at()),
        "… with speeds": lambda: scene.sweep(at(), speed=3.0),
        "… and a wrench read": lambda: scene.sweep(at())[_ROCKER].moment,
        "sweep(loads=)": lambda: scene.sweep(at(), loads={_ROCKER: new(5.0)}),
        "sweep(gravity=)": lambda: scene.sweep(at(), gravity=(0.0, 0.0, new(9.81))),
        "sweep(inertia=)": lambda: scene.sweep(at(), speed=3.0, inertia={"rocker": new(1.1)}),
        "sweep(held=), an angle": lambda: joint.sweep(at(), held={"joint_angle": new(0.9)}),
        "sweep(held=), a length": lambda: longer.sweep(at(), held={_LENGTH: new(0.01)}),
        "sweep, with a spring": lambda: sprung.sweep(at()),
        "response.sweep": lambda: response.sweep(at()),
        "replace(loads=), sweep": lambda: scene.replace(loads={_ROCKER: new(5.0)}).sweep(at()),
        "replace(elements=), sweep": lambda: scene.replace(elements=springs()).sweep(at()),
        "replace(held=), sweep": lambda: joint.replace(held={"joint_angle": new(0.9)}).sweep(at()),
        "replace(held=) of three, sweep": lambda: line.replace(
            held={name: new(value) for name, value in angles.items()}
        ).sweep(at()),
        "Scene(…), sweep": lambda: cd.Scene(bar, drive=_CRANK).sweep(at()),
        "branches(), again": scene.branches,
        "equilibrium": lambda: free.equilibrium(new(0.3)),
        "derivative by one": lambda: scene.sweep(at()).derivative("mass:coupler"),
        "derivative by five": lambda: scene.sweep(at()).derivative(*of_masses),
        "derivative by a held length": lambda: longer.sweep(at()).derivative(_LENGTH),
        "derivative by a spring's stiffness": lambda: sprung.sweep(at()).derivative(
            "stiffness:spring"
        ),
        "to_csv, one position": lambda: one.to_csv(folder / "one.csv"),
        "to_csv, 72 positions": lambda: many.to_csv(folder / "many.csv"),
        "to_dataframe, one position": one.to_dataframe,
    }


def calls(run: Callable[[], object]) -> int:
    """Return how many functions of Python and C are called."""
    counted = 0

    def tell(frame: object, event: str, argument: object) -> None:
        nonlocal counted
        counted += event in ("call", "c_call")

    sys.setprofile(tell)
    try:
        run()
    finally:
        sys.setprofile(None)
    return counted


def measure(fast: bool = False) -> list[Record]:
    """Return all records; `ratio` is the time over that of one position."""
    with tempfile.TemporaryDirectory() as folder:
        asked = candidates(Path(folder))
        counted = {}
        for name, run in asked.items():
            for _ in range(3):  # The first ones make what is kept.
                run()
            counted[name] = calls(run)
        seconds = least_seconds(asked, 2 if fast else 20, clock=time.process_time)
    return [
        Record(
            NAME,
            name,
            cd.__version__,
            parameters={"calls": counted[name], "times_calls": counted[name] / counted[_FIRST]},
            microseconds=least * 1e6,
            ratio=least / seconds[_FIRST],
        )
        for name, least in seconds.items()
    ]


def answer(records: list[Record]) -> str:
    """Return which calls take more than three times as long as one position."""
    dear = [f"{record.method} {record.ratio:.0f}" for record in records if record.ratio > 3.0]
    return f"Up to 3 times one position: all but {', '.join(dear)}."


def run(fast: bool = False) -> str:
    """Measure, write results, and return the Markdown text."""
    records = measure(fast)
    text = answer(records)
    save(NAME, [record.flat() for record in records], text)
    rows = [
        [
            record.method,
            f"{record.microseconds:.4g}",
            f"{record.ratio:.1f}",
            str(record.parameters["calls"]),
            f"{record.parameters['times_calls']:.1f}",
        ]
        for record in records
    ]
    return f"{markdown(['call', 'µs', 'times', 'calls', 'times'], rows)}\n\n{text}"
