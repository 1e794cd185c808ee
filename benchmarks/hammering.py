"""How long do clearance's estimate and its simulation take, and how exact are simulated peaks?

The scan of all joints of the bundled needle drive (a six-bar) at 720 positions, and the bundled
slider-crank at 300 rad/s with a clearance of 0.2 mm in its crank pin or its piston pin, a contact
of 1e8 N/m and a damping ratio of 0.25: processor time, and the greatest error of the force's peaks
over the second turn against rtol 1e-12. R is one `pin.rnea` call from Python on the model.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

import cardan_dyn as cd
from cardan_dyn import clearance

from .records import Record, markdown, save
from .timing import least_seconds, quick, rnea_seconds

NAME = "hammering"
TURNS, FAST_TURNS = 100, 2
TOLERANCES = (1e-6, 1e-7, 1e-8, 1e-10)
PINS = ("crank_pin", "piston_pin")
_CONTACT = {"clearance": 2e-4, "stiffness": 1e8, "damping_ratio": 0.25}
_SPEED = 300.0
_WITHIN = (1.05, 1.95)
"""Turns over which peaks are compared, after the start has died away."""


def _scan(fast: bool) -> Record:
    scene = cd.Scene(cd.load("needle_drive"), drive="main_shaft")

    def scan() -> None:
        clearance.scan(scene, _SPEED, **_CONTACT)  # type: ignore[arg-type]

    seconds = least_seconds({"scan": scan}, repeats=3 if fast else 30)["scan"]
    unit = rnea_seconds(scene.mechanism)
    values = {"turns": 1, "seconds": seconds, "R": unit}
    return Record(NAME, "scan of a six-bar", cd.__version__, "", values, None, None, seconds / unit)


def _peaks(simulation: clearance.ContactSimulation, pin: str) -> tuple[Any, Any]:
    """Return the local maxima of a pin's force within the second turn, and when [s]."""
    turn = 2.0 * np.pi / _SPEED
    times = turn * np.linspace(*_WITHIN, 2_001)
    force = simulation.at(times)[pin].force
    inner = (force[1:-1] > force[:-2]) & (force[1:-1] >= force[2:]) & (force[1:-1] > 0.0)
    return force[1:-1][inner], times[1:-1][inner]


def _simulations(pin: str, fast: bool) -> list[Record]:
    scene = cd.Scene(cd.load("slider_crank"), drive="crank_bearing")
    given: dict[str, Any] = {"joints": pin, **_CONTACT}
    exact, _ = _peaks(clearance.simulate(scene, _SPEED, turns=2.0, rtol=1e-12, **given), pin)
    unit, records = rnea_seconds(scene.mechanism), []
    turns = FAST_TURNS if fast else TURNS
    for rtol in quick(TOLERANCES, fast):
        begin = time.process_time()
        simulation = clearance.simulate(scene, _SPEED, turns=turns, rtol=rtol, **given)
        seconds = time.process_time() - begin
        peaks, _ = _peaks(simulation, pin)
        error = np.inf
        if len(peaks) == len(exact):
            error = float(np.max(np.abs(peaks - exact)) / np.max(exact))
        values = {
            "turns": turns,
            "rtol": rtol,
            "seconds": seconds,
            "R": unit,
            "steps": len(simulation.time),
            "impacts": len(simulation[pin].struck),
        }
        ratio = seconds / unit
        records.append(
            Record(NAME, f"{pin}, simulated", cd.__version__, "", values, error, None, ratio)
        )
    return records


def measure(fast: bool = False) -> list[Record]:
    """Return all records.

    Args:
        fast: few turns and repeats.
    """
    pins = PINS[-1:] if fast else PINS
    return [_scan(fast), *(record for pin in pins for record in _simulations(pin, fast))]


def answer(records: list[Record]) -> str:
    """Return in words what was measured."""
    scan, *simulated = records
    lines = [f"{scan.method}: {1e3 * scan.parameters['seconds']:.3g} ms, {scan.ratio:.3g} R."]
    lines += [
        f"{r.method}, rtol {r.parameters['rtol']:g}: {r.parameters['turns']} turns in "
        f"{r.parameters['seconds']:.3g} s, {r.ratio:.3g} R; peaks within {r.error:.1e}."
        for r in simulated
    ]
    return "\n".join(lines)


def run(fast: bool = False) -> str:
    """Measure, write results, and return the Markdown text."""
    records = measure(fast)
    save(NAME, [record.flat() for record in records], answer(records))
    head = ["", "turns", "rtol", "s", "R", "peaks within"]
    rows = [
        [
            r.method,
            str(r.parameters["turns"]),
            f"{r.parameters['rtol']:g}" if "rtol" in r.parameters else "",
            f"{r.parameters['seconds']:.3g}",
            f"{r.ratio:.3g}",
            "" if r.error is None else f"{r.error:.1e}",
        ]
        for r in records
    ]
    return markdown(head, rows)
