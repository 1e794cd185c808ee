"""Do a thousand revolutions drift?

The free spin of a universal joint, 30° and 80°, as in `free_spin`: error of the input's position,
greatest closure error (gap over the length of 1 m, or angle) and greatest change of energy as a
fraction of it, at 2000 times. MuJoCo as far as it can be set: a stiff `connect`, RK4.
"""

from __future__ import annotations

import time

import numpy as np

import cardan_dyn as cd

from .records import Record, markdown, save
from .spin import SPEED, Spin, description, spin

NAME = "long_time"
BETAS_DEG = (30.0, 80.0)
REVOLUTIONS, FAST = 1000, 10
TOLERANCES = (1e-8, 1e-11, 3e-14)
_TIMES = 2000
"""Times in a thousand revolutions at which closure and energy are read; at least 200 of less."""
STEPS = (60.0, 200.0)
"""Steps of MuJoCo per revolution."""


def _library(task: Spin, method: str, tolerance: float) -> Record:
    mechanism = cd.load(description(task.beta))
    start = time.process_time()
    scene = cd.Scene(mechanism, free="bearing_in")
    options = {"speed": SPEED, "method": method, "rtol": tolerance}
    trajectory = scene.simulate(task.duration, **options)
    seconds = time.process_time() - start
    sampled = trajectory.evenly(max(200, _TIMES * task.revolutions // REVOLUTIONS))
    return Record(
        task=NAME,
        method=f"cardan_dyn {method}" + ("" if method == "quadrature" else f", rtol {tolerance:g}"),
        version=cd.__version__,
        parameters={
            "closure": float(sampled.loop_residual),
            "energy": float(sampled.energy_residual),
            "seconds": seconds,
        },
        error=abs(float(trajectory.at(task.duration).position[0]) - task.end),
    )


def _mujoco(task: Spin, per_revolution: float) -> Record:
    import mujoco

    from .engines import spin_mujoco

    model = spin_mujoco.model(task, per_revolution, "RK4", 5.0)
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    data = mujoco.MjData(model)
    spin_mujoco.start(model, data, task)
    mujoco.mj_forward(model, data)
    before, gap, change = float(np.sum(data.energy)), 0.0, 0.0
    ends = [model.site(name).id for name in ("end", "bearing")]
    start = time.process_time()
    for _ in range(task.revolutions):
        mujoco.mj_step(model, data, round(per_revolution))
        mujoco.mj_forward(model, data)
        gap = max(gap, float(np.linalg.norm(data.site_xpos[ends[0]] - data.site_xpos[ends[1]])))
        change = max(change, abs(float(np.sum(data.energy)) / before - 1.0))
    return Record(
        task=NAME,
        method=f"MuJoCo RK4, stiff, {per_revolution:g} steps/rev",
        version=mujoco.__version__,
        parameters={"closure": gap, "energy": change, "seconds": time.process_time() - start},
        error=abs(float(data.qpos[0]) - task.end),
    )


def measure(fast: bool = False, others: bool = True) -> list[Record]:
    """Return all records.

    Args:
        fast: ten revolutions instead of a thousand.
        others: whether to measure MuJoCo, where it is installed.
    """
    records = []
    for beta_deg in BETAS_DEG:
        task = spin(float(np.deg2rad(beta_deg)), FAST if fast else REVOLUTIONS)
        found = [_library(task, "quadrature", 1e-10)]
        found += [_library(task, "DOP853", tolerance) for tolerance in TOLERANCES]
        if others:
            try:
                found += [_mujoco(task, steps) for steps in STEPS]
            except ImportError as error:
                print(f"MuJoCo is skipped: {error}")
        for record in found:
            record.parameters.update(beta_deg=beta_deg, revolutions=task.revolutions)
        records += found
    return records


def answer(records: list[Record]) -> str:
    """Return what drifts."""
    return "\n".join(
        f"β = {r.parameters['beta_deg']:g}°, {r.method}: after {r.parameters['revolutions']} "
        f"revolutions {r.error:.1e} rad off, closure {r.parameters['closure']:.1e}, energy "
        f"{r.parameters['energy']:.1e}."
        for r in records
    )


def run(fast: bool = False) -> str:
    """Measure, write results, and return the Markdown text."""
    records = measure(fast)
    text = answer(records)
    save(NAME, [record.flat() for record in records], text)
    head = ["β", "method", "revolutions", "error [rad]", "closure", "energy", "s"]
    rows = []
    for r in records:
        p = r.parameters
        numbers = [f"{r.error:.1e}", f"{p['closure']:.1e}", f"{p['energy']:.1e}"]
        angle, turns = f"{p['beta_deg']:g}°", str(p["revolutions"])
        rows.append([angle, r.method, turns, *numbers, f"{p['seconds']:.3g}"])
    return f"{markdown(head, rows)}\n\n{text}"
