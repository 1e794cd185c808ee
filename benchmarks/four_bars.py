"""What does a linkage of many loops cost to simulate?

N parallelograms in a row, as between the wheels of a locomotive: N + 1 cranks and N couplers, rods
of 1 m and 1 kg, one freedom, N loops with three redundant rows each. They swing under gravity from
60° at rest for five periods and a quarter; their mass matrix does not change, so that the exact
motion is that of a pendulum, by an elliptic integral. The error is that of the crank's position at
the end [rad], where it is zero; energy is its change as a fraction of the greatest kinetic energy.
MuJoCo with a `connect` per loop, RK4. Times in R of the same model, processor time.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import pinocchio as pin
from mpmath import mp, mpf

import cardan_dyn as cd

from .records import Record, markdown, save
from .timing import least_seconds

NAME = "four_bars"
COUNTS = (1, 2, 4, 8, 16, 40)
START = float(np.pi / 3.0)
GRAVITY = 9.81
_PERIODS = 5.25
_CALLS = 200
METHODS = (("quadrature", 1e-10), ("DOP853", 1e-6), ("DOP853", 1e-10))
STEPS = (100, 1000)
"""Steps of MuJoCo per period."""
_ROD = (
    '<link name="{name}"><inertial><origin xyz="{centre}"/><mass value="1"/><inertia ixx="{x}" '
    'iyy="{y}" izz="0.083333333333333333" ixy="0" ixz="0" iyz="0"/></inertial></link>'
)


def description(count: int) -> str:
    """Return the linkage as a URDF, cranks hanging down, turning about z."""
    thick, thin = "0.083333333333333333", "1e-3"
    urdf = '<link name="base"/>'
    for k in range(count + 1):
        urdf += _ROD.format(name=f"crank_{k}", centre="0 -0.5 0", x=thick, y=thin)
        urdf += _joint(f"pivot_{k}", "base", f"crank_{k}", f"{k} 0 0")
    for k in range(count):
        urdf += _ROD.format(name=f"coupler_{k}", centre="0.5 0 0", x=thin, y=thick)
        urdf += _joint(f"pin_{k}", f"crank_{k}", f"coupler_{k}", "0 -1 0")
        urdf += (
            f'<loop name="loop_{k}" type="continuous"><predecessor link="coupler_{k}">'
            f'<origin xyz="1 0 0"/></predecessor><successor link="crank_{k + 1}">'
            '<origin xyz="0 -1 0"/></successor><axis xyz="0 0 1"/></loop>'
        )
    return f'<robot name="four_bars">{urdf}</robot>'


def _joint(name: str, parent: str, child: str, at: str) -> str:
    return (
        f'<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at}"/><axis xyz="0 0 1"/></joint>'
    )


def duration(count: int) -> float:
    """Return the time of five periods and a quarter [s], after which the cranks hang down."""
    with mp.workdps(40):
        inertia = mpf(count + 1) / 3 + count
        moment = mpf(GRAVITY) * (mpf(count + 1) / 2 + count)
        quarter = mp.sqrt(inertia / moment) * mp.ellipk(mp.sin(mpf(START) / 2) ** 2)
        return float(mpf(4 * _PERIODS) * quarter)


def _library(count: int, method: str, tolerance: float) -> Callable[[], cd.Trajectory]:
    mechanism, end = cd.load(description(count)), duration(count)
    gravity = (0.0, -GRAVITY, 0.0)

    def run() -> cd.Trajectory:
        scene = cd.Scene(mechanism, free="pivot_0", gravity=gravity, outputs=[])
        return scene.simulate(end, position=START, method=method, rtol=tolerance)

    return run


def _judged(trajectory: cd.Trajectory) -> tuple[float, float]:
    """Return position at the end [rad], and the change of energy."""
    end = trajectory.at(trajectory.time[-1])
    return abs(float(end.position[0])), float(trajectory.energy_residual)


def _mujoco(count: int, per_period: int) -> tuple[Callable[[], object], Callable[[], tuple]]:
    """Return what simulates, and what judges afterwards; see `_judged`."""
    import mujoco

    from .engines.four_bars_mujoco import made, started

    model, steps = made(count, duration(count), round(per_period * _PERIODS))
    data = mujoco.MjData(model)

    def run() -> None:
        started(model, data, START)
        mujoco.mj_step(model, data, steps)

    def judge() -> tuple[float, float]:
        started(model, data, START)
        mujoco.mj_forward(model, data)
        before = float(np.sum(data.energy))
        kinetic = change = 0.0
        for _ in range(steps):
            mujoco.mj_step(model, data)
            # Energies are those of the start of a step.
            kinetic = max(kinetic, float(data.energy[1]))
            change = max(change, abs(float(np.sum(data.energy)) - before))
        return abs(float(data.qpos[0])), change / kinetic

    return run, judge


def _reference(count: int) -> Callable[[], None]:
    model = cd.load(description(count)).model
    data, q, rest = model.createData(), pin.neutral(model), np.zeros(model.nv)

    def run() -> None:
        for _ in range(_CALLS):
            pin.rnea(model, data, q, rest, rest)

    return run


def _candidates(count: int, others: bool) -> dict[str, tuple[Callable, Callable]]:
    """Return what simulates and what judges, by method."""
    found: dict[str, tuple[Callable, Callable]] = {}
    for method, tolerance in METHODS:
        run = _library(count, method, tolerance)
        label = f"cardan_dyn {method}" + (f", rtol {tolerance:g}" if method == "DOP853" else "")
        found[label] = run, lambda run=run: _judged(run())
    if others:
        try:
            for steps in STEPS:
                found[f"MuJoCo RK4, stiff, {steps} steps/period"] = _mujoco(count, steps)
        except ImportError as error:
            print(f"MuJoCo is skipped: {error}")
    return found


def measure(fast: bool = False, others: bool = True) -> list[Record]:
    """Return all records; `ratio` is the time in R of the same model.

    Args:
        fast: up to four loops, one repeat.
        others: whether to measure MuJoCo, where it is installed.
    """
    records = []
    for count in COUNTS[:3] if fast else COUNTS:
        runs: dict[str, Callable[[], object]] = {"rnea": _reference(count)}
        judged: dict[str, tuple[float, float] | str] = {}
        for name, (run, judge) in _candidates(count, others).items():
            try:
                judged[name] = judge()
                runs[name] = run
            except cd.CardanError as error:
                judged[name] = str(error)
        seconds = least_seconds(runs, 1 if fast else 5, 20.0, clock=time.process_time)
        unit = seconds.pop("rnea") / _CALLS
        for name, result in judged.items():
            parameters = {"loops": count}
            if isinstance(result, str):
                records.append(Record(NAME, name, parameters={**parameters, "failed": result}))
                continue
            records.append(
                Record(
                    NAME,
                    name,
                    parameters={**parameters, "energy": result[1]},
                    error=result[0],
                    microseconds=seconds[name] * 1e6,
                    ratio=seconds[name] / unit,
                )
            )
    return records


def answer(records: list[Record]) -> str:
    """Return how time grows with the number of loops."""
    lines = []
    for name in dict.fromkeys(record.method for record in records):
        solved = [r for r in records if r.method == name and r.microseconds]
        failed = [
            str(r.parameters["loops"]) for r in records if r.method == name and r.error is None
        ]
        if solved:
            first, last = solved[0], solved[-1]
            lines.append(
                f"{name}: {first.microseconds / 1e3:.3g} ms for {first.parameters['loops']} loops, "
                f"{last.microseconds / 1e3:.3g} ms for {last.parameters['loops']}; error up to "
                f"{max(r.error for r in solved):.1e} rad, energy up to "
                f"{max(r.parameters['energy'] for r in solved):.1e}."
            )
        if failed:
            lines.append(f"{name}: refused with {', '.join(failed)} loops.")
    return "\n".join(lines)


def run(fast: bool = False) -> str:
    """Measure, write results, and return the Markdown text."""
    records = measure(fast)
    text = answer(records)
    save(NAME, [record.flat() for record in records], text)
    rows = []
    for r in records:
        start = [str(r.parameters["loops"]), r.method]
        if r.microseconds is None:
            rows.append([*start, "refused", "", "", ""])
            continue
        numbers = f"{r.error:.1e}", f"{r.parameters['energy']:.1e}"
        rows.append([*start, *numbers, f"{r.microseconds / 1e3:.3g}", f"{r.ratio:.3g}"])
    head = ["loops", "method", "error [rad]", "energy", "ms", "R"]
    return f"{markdown(head, rows)}\n\n{text}"
