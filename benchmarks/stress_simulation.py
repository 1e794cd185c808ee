"""Where do simulations lose digits, closure or energy?

Ten revolutions of free spin of a universal joint: β up to 89.9°, inertia of the output shaft from
1e-6 to 1e6 times that of the input, start speeds from 1e-3 to 1e5 rad/s at 30°; and a four-bar
linkage that swings under gravity with lengths from 1e-6 to 1e6 times those of the description. The
error [rad] is that of the input's position at the end, against quadrature with 40 digits; energy
is its greatest change as a fraction of it, closure as the trajectory reports it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np

import cardan_dyn as cd

from .descriptions import mechanics, with_length
from .pictures import write
from .records import Record, markdown, path, save
from .spin import SPEED, description, spin
from .timing import quick

NAME = "stress_simulation"
METHODS = (None, "DOP853")
"""The method that is chosen, and the general one."""
RTOL = 1e-10
_MILLION = tuple(10.0**power for power in range(-6, 7))
GRIDS: dict[str, tuple[float, ...]] = {
    "joint angle [°]": (0.5, 10.0, 30.0, 50.0, 70.0, 80.0, 85.0, 88.0, 89.0, 89.5, 89.9),
    "inertia ratio": _MILLION,
    "speed [rad/s]": (1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5),
    "length ratio": _MILLION,
}
_GRAVITY, _SWING = (0.0, -9.81, 0.0), 2.0
"""In the plane of the four-bar linkage; duration at the description's lengths [s]."""

Found = tuple[cd.Trajectory, "float | None"]


def _spun(beta: float, ratio: float, speed: float, method: str | None) -> Found:
    task = spin(beta, shaft=ratio)
    scene = cd.Scene(cd.load(description(beta, shaft=ratio)), free="bearing_in")
    duration = task.duration * (SPEED / speed)
    trajectory = scene.simulate(duration, speed=speed, method=method, rtol=RTOL)
    return trajectory, abs(float(trajectory.at(duration).position[0]) - task.end)


def _swung(factor: float, method: str | None) -> Found:
    linkage = cd.load(with_length(mechanics("four_bar"), factor))
    scene = cd.Scene(linkage, free="crank_bearing", gravity=_GRAVITY)
    duration = _SWING * float(np.sqrt(factor))
    return scene.simulate(duration, position=0.5, method=method, rtol=RTOL), None


def _cases(name: str) -> Callable[[float, str | None], Found]:
    """Return what simulates a point of a map."""
    angle = float(np.deg2rad(30.0))
    return {
        "joint angle [°]": lambda at, method: _spun(float(np.deg2rad(at)), 1.0, SPEED, method),
        "inertia ratio": lambda at, method: _spun(angle, at, SPEED, method),
        "speed [rad/s]": lambda at, method: _spun(angle, 1.0, at, method),
        "length ratio": _swung,
    }[name]


def _measured(name: str, at: float, method: str | None) -> Record:
    """Return one point of a map."""
    record = partial(Record, NAME, f"{method or 'chosen'}", cd.__version__)
    parameters = {"map": name, "parameter": at}
    try:
        trajectory, error = _cases(name)(at, method)
        found = {
            "used": trajectory.method,
            "closure": float(trajectory.loop_residual),
            "energy": float(trajectory.energy_residual),
        }
    except cd.CardanError as problem:
        refused = {"refused": type(problem).__name__, "message": str(problem)[:240]}
        return record(parameters={**parameters, **refused})
    return record(parameters={**parameters, **found}, error=error)


def points(grids: Mapping[str, Sequence[float]] = GRIDS) -> list[Record]:
    """Return all maps."""
    return list(_points(grids))


def _points(grids: Mapping[str, Sequence[float]]) -> Iterator[Record]:
    for name, grid in grids.items():
        for method in METHODS:
            for at in grid:
                yield _measured(name, at, method)


def answer(records: list[Record]) -> str:
    """Return the worst of every map, and what was refused."""
    lines = []
    for name in dict.fromkeys(r.parameters["map"] for r in records):
        for method in dict.fromkeys(r.method for r in records):
            chosen = [r for r in records if r.parameters["map"] == name and r.method == method]
            solved = [r for r in chosen if "refused" not in r.parameters]
            line = f"{name}, {method}: "
            for key in ("closure", "energy"):
                worst = max(solved, key=lambda r: r.parameters[key], default=None)
                if worst is not None:
                    value, at = worst.parameters[key], worst.parameters["parameter"]
                    line += f"{key} up to {value:.1e} (at {at:g}), "
            errors = [r.error for r in solved if r.error is not None]
            line += f"error up to {max(errors):.1e} rad, " if errors else ""
            refused = [f"{r.parameters['parameter']:g}" for r in chosen if r not in solved]
            lines.append(line + f"refused: {', '.join(refused) or 'none'}.")
    return "\n".join(lines)


def table(records: list[Record]) -> str:
    """Return the maps as a Markdown table."""
    rows = []
    for r in records:
        p = r.parameters
        start = [p["map"], f"{p['parameter']:g}", r.method]
        if "refused" in p:
            rows.append([*start, p["refused"], "", "", ""])
            continue
        error = "" if r.error is None else f"{r.error:.1e}"
        rows.append([*start, p["used"], error, f"{p['closure']:.1e}", f"{p['energy']:.1e}"])
    head = ["map", "at", "asked for", "method", "error [rad]", "closure", "energy"]
    return markdown(head, rows)


def picture(records: list[Record], path: Path) -> None:
    """Draw closure and energy over the parameter, one panel per map."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    names = list(dict.fromkeys(r.parameters["map"] for r in records))
    with mpl.rc_context({"font.size": 8}):
        figure = Figure(figsize=(8.8, 5.4), layout="constrained")
        axes = figure.subplots(2, 2, squeeze=False, sharey=True).flat
        for axis, name in zip(axes, names, strict=False):
            for method, colour in (("chosen", "k"), ("DOP853", "0.55")):
                for key, marker, line in (("closure", "o", "-"), ("energy", "v", "--")):
                    chosen = [
                        r.parameters for r in records
                        if r.parameters["map"] == name and r.method == method
                        and "refused" not in r.parameters
                    ]  # fmt: skip
                    at = [p["parameter"] for p in chosen]
                    at = [90.0 - value for value in at] if "angle" in name else at
                    values = [max(p[key], 1e-17) for p in chosen]
                    axis.loglog(
                        at, values, color=colour, marker=marker, ls=line, ms=4, mfc="white", lw=1,
                        label=f"{key}, {method}",
                    )  # fmt: skip
            axis.set_xlabel(f"90° - {name}" if "angle" in name else name)
            axis.grid(color="0.9", lw=0.5)
        handles, labels = figure.axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=7.5)
        write(figure, path)


def run(fast: bool = False) -> str:
    """Measure, write results, and return the Markdown text."""
    records = points({name: quick(grid, fast) for name, grid in GRIDS.items()})
    text = answer(records)
    save(NAME, [record.flat() for record in records], text)
    picture(records, path(f"{NAME}.png"))
    return f"{text}\n\n![closure and energy]({NAME}.png)\n\n{table(records)}"
