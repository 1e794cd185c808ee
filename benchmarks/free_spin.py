"""What does a simulation cost, and how exact is it at its end, beside other engines?

Ten revolutions of a universal joint that spins freely, shafts of 1 kg m² and a cross of 1e-3 kg m²,
10 rad/s at the start, β = 30° and 80°. The error is |φ(T) - 20π| [rad], T by quadrature with 40
digits. Times are in R, one `pin.rnea` call from Python on the same model in the same run, and count
the processor: on an idle machine they are wall times. They contain the making of the scene, not
the loading of the mechanism, the making of other engines' models, nor what SymPy derives. What a
mechanism has learned of its motion from an earlier scene is forgotten before each run.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pinocchio as pin

import cardan_dyn as cd

from .engines.spinning import Spinner, spinners
from .pictures import write
from .records import Record, markdown, path, save
from .spin import SPEED, Spin, description, spin
from .timing import least_seconds, quick

NAME = "free_spin"
BETAS_DEG = (30.0, 80.0)
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
_CALLS = 1000
"""Calls of `pin.rnea` that are timed together."""
_LOST = 0.1
"""Error from which on the position is lost [rad]."""
_LEAST_DRAWN = 1e-15
"""Where errors of zero are drawn on a logarithmic scale: at the rounding of an angle."""


def _simulated(
    mechanism: cd.Mechanism, method: str, every: bool, spin: Spin, tolerance: float
) -> float:
    """Return the input's position at the end of a simulation, the scene included.

    Args:
        mechanism: loaded before.
        method: of `Scene.simulate`.
        every: compute the wrenches of all joints at all times as well.
        spin: what is simulated.
        tolerance: relative tolerance.
    """
    # Another engine computes each motion anew.
    mechanism.kept.forget("branch", "energy functions")
    scene = cd.Scene(mechanism, free="bearing_in", outputs=None if every else [])
    options = {"speed": SPEED, "method": method, "rtol": tolerance}
    trajectory = scene.simulate(spin.duration, **options)
    if every:
        assert trajectory["bearing_out"].moment.shape
    return float(trajectory.at(spin.duration).position[0])


def _library(method: str, every: bool = False) -> Spinner:
    def prepare(spin: Spin, tolerance: float) -> Callable[[], float]:
        mechanism = cd.load(description(spin.beta))
        return partial(_simulated, mechanism, method, every, spin, tolerance)

    exact = method == "quadrature"
    name = f"cardan_dyn {method}" + (", all wrenches" if every else "")
    settings = "scene included" + (", wrenches of all joints at 641 times" if every else "")
    return Spinner(name, cd.__version__, settings, (1e-10,) if exact else TOLERANCES, prepare)


def library() -> list[Spinner]:
    """Return the methods of the library."""
    rows = [_library(method) for method in ("quadrature", "response", "DOP853")]
    return [rows[0], _library("quadrature", every=True), *rows[1:]]


def _reference(beta: float) -> Callable[[], None]:
    """Return what calls `pin.rnea` many times."""
    model = cd.load(description(beta)).model
    data, q, rest = model.createData(), pin.neutral(model), np.zeros(model.nv)

    def run() -> None:
        for _ in range(_CALLS):
            pin.rnea(model, data, q, rest, rest)

    return run


def measure(fast: bool = False, candidates: list[Spinner] | None = None) -> list[Record]:
    """Return all records; `ratio` is the time in R.

    Args:
        fast: the coarsest and the finest level of each method, few repeats.
        candidates: methods; all that are installed if None.
    """
    methods = [*library(), *spinners()] if candidates is None else candidates
    records = []
    for beta_deg in BETAS_DEG:
        task = spin(float(np.deg2rad(beta_deg)))
        runs: dict[str, Callable[[], object]] = {"rnea": _reference(task.beta)}
        found: list[tuple[Spinner, float, float | None, str]] = []
        for method in methods:
            for level in quick(method.levels, fast):
                key = f"{method.name}, {method.labelled(level)}"
                try:
                    run = method.prepare(task, level)
                    error = abs(run() - task.end)
                except (cd.CardanError, ArithmeticError, RuntimeError) as problem:
                    found.append((method, level, None, str(problem)))
                    continue
                found.append((method, level, error if np.isfinite(error) else None, ""))
                runs[key] = run
        seconds = least_seconds(runs, 1 if fast else 9, clock=time.process_time)
        unit = seconds.pop("rnea") / _CALLS
        records += [_record(beta_deg, *entry, seconds, unit) for entry in found]
    return records


def _record(
    beta_deg: float,
    method: Spinner,
    level: float,
    error: float | None,
    failed: str,
    seconds: dict[str, float],
    unit: float,
) -> Record:
    label = method.labelled(level)
    least = seconds.get(f"{method.name}, {label}")
    parameters = {"beta_deg": beta_deg, "level": label, **({"failed": failed} if failed else {})}
    return Record(
        task=NAME,
        method=method.name,
        version=method.version,
        settings=method.settings,
        parameters=parameters,
        error=error,
        microseconds=None if least is None else least * 1e6,
        ratio=None if least is None else least / unit,
    )


def table(records: list[Record]) -> str:
    """Return errors and times in R as a Markdown table, a row for each method and angle."""
    keys = list(dict.fromkeys((r.parameters["beta_deg"], r.method) for r in records))
    rows = []
    for beta_deg, name in keys:
        of_method = [r for r in records if (r.parameters["beta_deg"], r.method) == (beta_deg, name)]
        cells = ", ".join(_cell(record) for record in of_method)
        label = f"{name} ({of_method[0].version})"
        rows.append([f"{beta_deg:g}°", label, cells, of_method[0].settings])
    return markdown(["β", "method", "error [rad] @ R, by level", "settings"], rows)


def _cell(record: Record) -> str:
    level = record.parameters["level"]
    if record.error is None:
        return f"{level}: fails"
    return f"{level}: {record.error:.1e} @ {record.ratio:.3g}"


def in_front(records: list[Record], ours: str = "cardan_dyn") -> list[str]:
    """Return a sentence for each row of others that no row of ours beats in both error and time.

    Errors of `_LOST` and more are no results.
    """
    sentences = []
    for record in records:
        if record.method.startswith(ours) or record.error is None or record.ratio is None:
            continue
        if record.error >= _LOST:
            continue
        beta_deg = record.parameters["beta_deg"]
        own = [
            r.ratio
            for r in records
            if r.method.startswith(ours) and r.parameters["beta_deg"] == beta_deg
            and r.error is not None and r.error <= record.error and r.ratio is not None
        ]  # fmt: skip
        best = min(own, default=float("inf"))
        if best > record.ratio:
            sentences.append(
                f"β = {beta_deg:g}°: {record.method} reaches {record.error:.1e} "
                f"{best / record.ratio:.2g} times faster ({record.parameters['level']})."
            )
    return sentences


def answer(records: list[Record]) -> str:
    """Return errors and times of the library, and where others are in front."""
    lines = [
        f"β = {r.parameters['beta_deg']:g}°: {r.method}, {r.parameters['level']}: error "
        f"{r.error:.1e} rad in {r.ratio:.3g} R."
        for r in records
        if r.method.startswith("cardan") and r.error is not None
    ]
    ahead = in_front(records)
    return "\n".join([*lines, *(ahead or ["No other engine is as exact in less time."])])


def picture(records: list[Record], path: Path) -> None:
    """Draw error against time, one line per method and one panel per angle."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    names = list(dict.fromkeys(record.method for record in records))
    betas = list(dict.fromkeys(record.parameters["beta_deg"] for record in records))
    markers, lines = "os^vD<>XhPp*", ("-", "--", ":", "-.")
    with mpl.rc_context({"font.size": 8}):
        figure = Figure(figsize=(8.8, 4.6), layout="constrained")
        axes = figure.subplots(1, len(betas), squeeze=False, sharey=True)[0]
        for axis, beta_deg in zip(axes, betas, strict=True):
            for index, name in enumerate(names):
                chosen = [
                    r for r in records
                    if r.method == name and r.parameters["beta_deg"] == beta_deg
                    and r.error is not None
                ]  # fmt: skip
                own = name.startswith("cardan")
                axis.loglog(
                    [r.ratio for r in chosen],
                    [max(r.error or 0.0, _LEAST_DRAWN) for r in chosen],
                    marker=markers[index % len(markers)], ls=lines[index % len(lines)],
                    color="k" if own else "0.45", mfc="k" if own else "white", ms=5, lw=1,
                    label=name,
                )  # fmt: skip
            axis.set_xlabel("time [R]")
            axis.set_title(f"Free spin, ten revolutions at β = {beta_deg:g}°")
            axis.grid(color="0.9", lw=0.5)
        axes[0].set_ylabel("error of the input's position [rad]")
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=7.5)
        write(figure, path)


def run(fast: bool = False) -> str:
    """Measure, write results, and return the Markdown text."""
    records = measure(fast)
    text = answer(records)
    save(NAME, [record.flat() for record in records], text)
    picture(records, path(f"{NAME}.png"))
    return f"{table(records)}\n\n![error against time]({NAME}.png)\n\n{text}"
