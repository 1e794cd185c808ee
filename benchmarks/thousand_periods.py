"""Is the energy of conservative closed chains kept over a thousand periods?

In all coordinates by DOP853, nothing scaled to the energy: Bennett's linkage (three redundant rows)
turning, the bundled four-bar turning under gravity, a spatial slider-crank likewise, and the
bundled Stewart platform swinging in six freedoms on springs in its legs (periods of the slowest).
Greatest change of energy at 2000 times, as a fraction of the greatest kinetic or potential one;
greatest closure error (angle, or gap over the characteristic length); processor time. The universal
joint is in `long_time`.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import cardan_dyn as cd

from .records import Record, markdown, save
from .spatial_chains import bennett, bennett_angles, slider_crank

NAME = "thousand_periods"
PERIODS, FAST = 1000, 5
TOLERANCES = (1e-11, 1e-13, 3e-14)
_TIMES = 2000
"""Times in all periods at which energy and closure are read; at least 200."""
_FALL = (0.0, -9.81, 0.0)
_LEGS = [f"leg_{k}" for k in range(1, 7)]


@dataclass(frozen=True)
class Chain:
    """A chain and how it starts.

    Attributes:
        label: what readers call it.
        scene: makes the scene.
        start: arguments of `Scene.simulate`.
        period: returns the period of the motion [s].
    """

    label: str
    scene: Callable[[], cd.Scene]
    start: dict[str, Any]
    period: Callable[[cd.Scene, dict[str, Any]], float]


def _turn(scene: cd.Scene, start: dict[str, Any]) -> float:
    """Return the time of a turn of the drive [s], by the energy integral."""
    begin = float(start.get("position", 0.0))
    passed = cd.Event(
        lambda _, position, __: position[scene.free[0]] - begin - 2.0 * np.pi, terminal=True
    )
    return float(scene.simulate(1e3, method="quadrature", events=passed, **start).time[-1])


def _slowest(scene: cd.Scene, _: dict[str, Any]) -> float:
    return float(2.0 * np.pi / np.min(scene.equilibrium().frequencies))


def _bennett() -> cd.Scene:
    return cd.Scene(cd.load(bennett()), free="hinge_1", near=bennett_angles(1.0), gravity=_FALL)


def _four_bar() -> cd.Scene:
    return cd.Scene(cd.load("four_bar"), free="crank_bearing", gravity=_FALL)


def _slider_crank() -> cd.Scene:
    return cd.Scene(cd.load(slider_crank()), free="crank_bearing", gravity=_FALL)


def _platform() -> cd.Scene:
    springs = [cd.JointSpring(leg, 4e5) for leg in _LEGS]
    mechanism = cd.load("stewart_platform")
    return cd.Scene(mechanism, free=_LEGS, elements=springs, gravity=(0.0, 0.0, -9.81))


CHAINS = (
    Chain("Bennett's linkage", _bennett, {"position": 1.0, "speed": 8.0}, _turn),
    Chain("four-bar", _four_bar, {"speed": 20.0}, _turn),
    Chain("spatial slider-crank", _slider_crank, {"speed": 8.0}, _turn),
    Chain(
        "Stewart platform on springs",
        _platform,
        {"position": [0.01, -0.012, 0.004, 0.009, -0.005, 0.006]},
        _slowest,
    ),
)


def measure(fast: bool = False) -> list[Record]:
    """Return all records.

    Args:
        fast: five periods instead of a thousand.
    """
    periods, records = FAST if fast else PERIODS, []
    for chain in CHAINS:
        scene = chain.scene()
        duration = periods * chain.period(scene, chain.start)
        for tolerance in TOLERANCES[:1] if fast else TOLERANCES:
            begin = time.process_time()
            trajectory = scene.simulate(duration, method="DOP853", rtol=tolerance, **chain.start)
            seconds = time.process_time() - begin
            sampled = trajectory.evenly(max(200, _TIMES * periods // PERIODS))
            values = {
                "rtol": tolerance,
                "periods": periods,
                "energy": float(sampled.energy_residual),
                "closure": float(sampled.loop_residual),
                "evaluations": trajectory.evaluations,
                "seconds": seconds,
            }
            records.append(Record(NAME, chain.label, cd.__version__, parameters=values))
    return records


def answer(records: list[Record]) -> str:
    """Return how well each chain keeps its energy."""
    return "\n".join(
        f"{r.method}, rtol {r.parameters['rtol']:g}: energy kept to "
        f"{r.parameters['energy']:.1e} over {r.parameters['periods']} periods in "
        f"{r.parameters['seconds']:.3g} s, closure {r.parameters['closure']:.1e}."
        for r in records
    )


def run(fast: bool = False) -> str:
    """Measure, write results, and return the Markdown text."""
    records = measure(fast)
    save(NAME, [record.flat() for record in records], answer(records))
    head = ["chain", "rtol", "periods", "energy", "closure", "evaluations", "s"]
    rows = []
    for r in records:
        p = r.parameters
        sizes = [f"{p['energy']:.1e}", f"{p['closure']:.1e}"]
        counts = [str(p["evaluations"]), f"{p['seconds']:.3g}"]
        rows.append([r.method, f"{p['rtol']:g}", str(p["periods"]), *sizes, *counts])
    return markdown(head, rows)
