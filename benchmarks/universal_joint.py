"""How exactly and how fast do engines compute the reactions of a universal joint?

Unit torque at the output, quasi-static, over one revolution at β = 8.5, 30, 50, 80, 89 and 89.99°.
The error is the greatest |x − exact| / max |exact| over the revolution, the worst of D₁, B₁, D₂
and B₂; exact is Grossmann's closed form with 50 digits. Times are per sample, without what is done
once (building models, deriving expressions, building the response).
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from mpmath import mp, mpf

import cardan_dyn as cd
from cardan_dyn.analytic import grossmann

from .engines.common import Method, engines
from .methods import methods, prepared
from .pictures import write
from .records import Record, markdown, path, save
from .timing import least_seconds, quick

NAME = "universal_joint"
BETAS_DEG = (8.5, 30.0, 50.0, 80.0, 89.0, 89.99)
COUNTS = (721, 10_000)
_LEAST_DRAWN = 1e-16
"""Where errors of zero are drawn on a logarithmic scale: below the rounding of doubles."""
MANY = 100_000  # For what evaluates whole arrays.
REFERENCE = "cardan_dyn sweep, N = 721"


def exact(beta: float, phi: np.ndarray) -> np.ndarray:
    """Return D₁, B₁, D₂, B₂ `(N, 4)` for unit D₂, from 50 digits."""
    with mp.workdps(50):
        sine, cosine = mp.sin(mpf(beta)), mp.cos(mpf(beta))
        rows = []
        for angle in phi:
            s, c = mp.sin(mpf(float(angle))), mp.cos(mpf(float(angle)))
            square = cosine**2 + (sine * s) ** 2
            torsion = cosine / square
            bending = torsion * sine / cosine
            rows.append([torsion, bending * abs(s), 1, bending * abs(c) * mp.sqrt(square)])
        return np.array(rows, dtype=float)


def error(values: np.ndarray, reference: np.ndarray) -> float:
    """Return the worst of the four channels' errors."""
    scale = np.max(np.abs(reference), axis=0)
    return float(np.max(np.abs(np.abs(values) - reference) / scale))


def _library(count: int, method: str) -> Method:
    joint = cd.load("universal_joint")

    def prepare(beta: float, phi: np.ndarray) -> Callable[[], np.ndarray]:
        scene = cd.Scene(
            joint,
            drive="bearing_in",
            held={"joint_angle": beta},
            loads={"bearing_out": -1.0},
            outputs=["bearing_in", "bearing_out"],
        )
        ready = prepared(scene, method.split(",")[0])

        def run() -> np.ndarray:
            turn = ready.uniform(len(phi)) if "FFT" in method else ready.sweep(phi)
            first, last = turn["bearing_in"], turn["bearing_out"]
            return np.stack([first.torsion, first.bending, last.torsion, last.bending], axis=1)

        return run

    what = "loops closed, residuals checked" if method == "sweep" else "built beforehand"
    return Method(f"cardan_dyn {method}, N = {count}", cd.__version__, what, prepare, count)


def _analytic(count: int) -> Method:
    def prepare(beta: float, phi: np.ndarray) -> Callable[[], np.ndarray]:
        def run() -> np.ndarray:
            ratio = grossmann.moments(beta, phi)
            return np.stack(np.broadcast_arrays(*ratio), axis=1) / ratio.torsion_2[:, None]

        return run

    return Method(f"analytic, N = {count}", cd.__version__, "closed form in NumPy", prepare, count)


def _all() -> list[Method]:
    library = [_library(count, "sweep") for count in COUNTS]
    if "response" in methods():
        responses = ("response", "response, FFT")
        library += [_library(count, method) for method in responses for count in (*COUNTS, MANY)]
    return library + [_analytic(count) for count in (*COUNTS, MANY)] + list(engines())


def _checked(values: np.ndarray) -> np.ndarray:
    """Return the values at which the error is measured: all of them, or 10 000 of more."""
    return values[:: max(1, len(values) // COUNTS[-1])]


def measure(fast: bool = False) -> list[Record]:
    """Return all records."""
    candidates = [method for method in _all() if not (fast and method.once)]
    records = []
    for beta_deg in quick(BETAS_DEG, fast):
        beta = float(np.deg2rad(beta_deg))
        runs: dict[str, Callable[[], np.ndarray]] = {}
        errors: dict[str, float] = {}
        failed: dict[str, str] = {}
        positions = {
            count: 2.0 * np.pi * np.arange(count) / count
            for count in {method.samples for method in candidates}
        }
        references = {count: exact(beta, _checked(phi)) for count, phi in positions.items()}
        setup: dict[str, float] = {}
        for method in candidates:
            try:
                start = time.perf_counter()
                run = method.prepare(beta, positions[method.samples])
                setup[method.name] = time.perf_counter() - start
                errors[method.name] = error(_checked(run()), references[method.samples])
                runs[method.name] = run
            except (cd.CardanError, ArithmeticError, RuntimeError) as problem:
                failed[method.name] = f"{type(problem).__name__}: {problem}"
        seconds = least_seconds(runs, 2 if fast else 7)
        per_sample = {
            method.name: seconds[method.name] / method.samples * 1e6
            for method in candidates
            if method.name in runs
        }
        records += [
            Record(
                task=NAME,
                method=method.name,
                version=method.version,
                settings=method.settings,
                parameters={
                    "beta_deg": beta_deg,
                    "samples": method.samples,
                    "setup_ms": setup.get(method.name, 0.0) * 1e3,
                    **({"failed": failed[method.name]} if method.name in failed else {}),
                },
                error=errors.get(method.name),
                microseconds=per_sample.get(method.name),
                ratio=per_sample[method.name] / per_sample[REFERENCE]
                if method.name in per_sample
                else None,
            )
            for method in candidates
        ]
    return records


def table(records: list[Record]) -> str:
    """Return errors by joint angle and times as a Markdown table."""
    names = list(dict.fromkeys(record.method for record in records))
    betas = list(dict.fromkeys(record.parameters["beta_deg"] for record in records))
    head = ["method", *(f"β = {beta:g}°" for beta in betas), "µs/sample", "ratio", "settings"]
    rows = []
    for name in names:
        of_method = [record for record in records if record.method == name]
        cells = ["fails" if record.error is None else f"{record.error:.1e}" for record in of_method]
        times = [record.microseconds for record in of_method if record.microseconds is not None]
        ratios = [record.ratio for record in of_method if record.ratio is not None]
        middle = sorted(range(len(times)), key=times.__getitem__)[len(times) // 2]
        label = f"{name} ({of_method[0].version})" if of_method[0].version else name
        rows.append(
            [label, *cells, f"{times[middle]:.3g}", f"{ratios[middle]:.3g}", of_method[0].settings]
        )
    return markdown(head, rows)


def picture(records: list[Record], path: Path) -> None:
    """Draw error against time, one line per method, readable without colours."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    names = list(dict.fromkeys(record.method for record in records))
    with mpl.rc_context({"font.size": 8}):
        figure = Figure(figsize=(8.6, 4.8), layout="constrained")
        axis = figure.subplots()
        markers = "os^vD<>XhPp*x+1dHs^o"
        lines = ("-", "--", ":", "-.")
        for index, name in enumerate(names):
            of_method = [r for r in records if r.method == name and r.error is not None]
            axis.loglog(
                [r.microseconds for r in of_method],
                [max(r.error or 0.0, _LEAST_DRAWN) for r in of_method],
                marker=markers[index % len(markers)],
                ls=lines[index % len(lines)],
                color="k" if name.startswith(("cardan", "analytic")) else "0.45",
                mfc="k" if name.startswith("cardan") else "white",
                mew=1.2,
                ms=6,
                lw=1,
                label=name,
            )
        axis.set_xlabel("time per sample [µs]")
        axis.set_ylabel("greatest relative error of D₁, B₁, D₂, B₂")
        axis.set_title("Universal joint: each line from β = 8.5° (below) to 89.99° (above)")
        axis.grid(color="0.9", lw=0.5)
        figure.legend(loc="outside right upper", fontsize=7.5)
        write(figure, path)


def answer(records: list[Record]) -> str:
    """Return errors and times of the methods in words."""
    lines = []
    shared = [r for r in records if r.parameters["beta_deg"] == 50.0] or records
    sweep = next(r for r in shared if r.method == REFERENCE)
    lines.append(
        f"At β = {shared[0].parameters['beta_deg']:g}° the sweep takes {sweep.microseconds:.2g} µs "
        f"per sample with an error of {sweep.error:.1e}, loops closed and residuals checked."
    )
    for record in shared:
        if record.method == REFERENCE or record.microseconds is None:
            continue
        lines.append(
            f"{record.method}: {record.ratio:.3g} times the time, error {record.error:.1e}."
        )
    refused = [r for r in records if r.error is None]
    if refused:
        lines.append(
            "No result: "
            + "; ".join(f"{r.method} at {r.parameters['beta_deg']:g}°" for r in refused)
            + "."
        )
    return "\n".join(lines)


def run(fast: bool = False) -> str:
    """Measure, write results, and return the Markdown text."""
    records = measure(fast)
    text = answer(records)
    save(NAME, [record.flat() for record in records], text)
    picture(records, path(f"{NAME}.png"))
    return f"{table(records)}\n\n![error against time]({NAME}.png)\n\n{text}"
