"""What `cardan-dyn study` does: a study from a TOML file, planned, run, and told about.

mechanism = "double_shaft_z"            # a bundled description, or a path beside this file
store = "forces.zarr"                   # where results are kept

[scene]
drive = "bearing_in"
held = { joint_angle_1 = "20 deg", joint_angle_2 = "20 deg" }
loads = { bearing_out = "-100 N·m" }
gravity = ["0 m/s²", "0 m/s²", "-9.81 m/s²"]

[sweep]                                 # of every case
position = { from = "0 deg", to = "360 deg", count = 73 }

[wanted]                                # names to columns, and what is taken over positions
peak = ["bearing_out.bending", "max"]

[parameters]                            # see cardan_dyn.studies.Sweeps for their names
"held.joint_angle_1" = { from = "5 deg", to = "30 deg", count = 26 }
speed = { values = ["0 rpm", "1500 rpm"] }

[samples]                               # if parameters follow distributions
count = 1024
seed = 1
parameters = { "loads.bearing_out" = { normal = ["-100 N·m", "10 N·m"] } }
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np
import tomlkit
from tomlkit.exceptions import TOMLKitError

from ...core.mechanics.exact import load
from ...figures.wrenches import MARK
from ...kit.checks import described, mapping, whole
from ...kit.errors import ArgumentError, choices
from ...kit.units import read_any
from ...scene.scene import Scene
from ..studies.parameters import Line, Parameters, checked_parameters, samples, sobol_samples
from ..studies.study import Study, study
from ..studies.sweeps import OPEN, Sweeps
from .group import MISSED, Failure, Interrupted
from .options import DESCRIPTION, Words
from .tables import say, show

if TYPE_CHECKING:
    from contextlib import ExitStack

_TABLES = ("mechanism", "parameters", "samples", "scene", "store", "sweep", "wanted")
_SCENE = ("drive", "gravity", "held", "loads", "near", "outputs")
_SWEEP = ("acceleration", "position", "response", "speed")
_AXIS = ("count", "from", "to", "values")
_SAMPLES = ("count", "indices", "method", "parameters", "seed")
_LAWS = ("normal", "uniform")
_EXAMPLES = {
    "loads": "-100 N·m",
    "gravity": "-9.81 m/s²",
    "speed": "1500 rpm",
    "acceleration": "10 rad/s²",
    "time": "0.1 s",
}
"""How numbers are written that are no angles."""


def run(
    file: Path,
    *,
    dry_run: bool,
    workers: int | None,
    scheduler: str | None,
    store: str | None,
    resume: bool,
    retry: bool,
    verify: bool,
) -> None:
    """Plan a study, run it, and say what came out; or read all that is there, and say what is not.

    Args:
        file: TOML file.
        dry_run: only tell the plan.
        workers: processes on this machine; None for one for each core.
        scheduler: address of a Dask scheduler that computes instead.
        store: where results are kept, instead of what the file says.
        resume: go on with what is there.
        retry: compute what failed, once more.
        verify: only read what is there, and end with `MISSED` where some of it is damaged.

    Raises:
        CardanError: as `study`, its plan and its run do, or the file says something else.
        Failure: something is there already, the file cannot be read.
        Interrupted: Ctrl-C; what is finished stays.
    """
    from contextlib import ExitStack

    with ExitStack() as stack:
        client = None if scheduler is None else _connected(scheduler, stack)
        made = read(file, store=store, client=client, workers=workers)
        is_begun = made.store.found() is not None
        if verify and not is_begun:
            raise Failure(f"{made.store} holds no results that could be read")
        if is_begun and not (resume or retry or dry_run or verify):
            raise Failure(
                f"{made.store} holds results: --resume goes on with it, --store names another one"
            )
        plan = made.plan()
        click.echo(str(plan))
        is_whole = made.damage.empty
        if not is_whole:
            show(tuple(made.damage), made.damage.astype(str).values.tolist(), texts=(0, 2, 3))
            goes_on = not (dry_run or verify)
            if plan.damaged:
                again = "they are" if goes_on and not retry else "with --resume they are"
                say(f"{plan.damaged:,} cases are damaged; {again} computed again")
            else:
                again = "it is" if goes_on else "with --resume it is"
                say(f"no case is damaged with it; {again} written anew")
        elif verify:
            say(f"all that is there can be read: {plan.done:,} of {plan.cases:,} cases")
        if verify and not is_whole:
            raise SystemExit(MISSED)
        if dry_run or verify:
            return
        try:
            with warnings.catch_warnings():
                warnings.filterwarnings("ignore", message=".*(again|anew)$")  # See above.
                made.run(retry=retry)
        except KeyboardInterrupt:
            raise Interrupted(
                f"stopped; what is finished is in {made.store}: --resume goes on"
            ) from None
        _tell(made)


def read(
    file: Path, *, store: str | None = None, client: Any = None, workers: int | None = None
) -> Study:
    """Return the study that a file describes.

    Args:
        file: TOML file, see the top of this module.
        store: see `run`.
        client: of Dask.
        workers: see `run`.

    Raises:
        ArgumentError: the file says something else, or a number has no unit.
        Failure: it cannot be read.
        CardanError: as `load`, `Scene` and `study` do.
    """
    try:
        told = tomlkit.parse(file.read_text(encoding="utf-8-sig")).unwrap()
    except (OSError, UnicodeDecodeError, TOMLKitError) as error:
        raise Failure(f"{file}: cannot be read ({error})") from error
    _refuse_unknown("the file", told, _TABLES)
    place = store or told.get("store")
    if not isinstance(place, str):
        raise ArgumentError('where are results kept? write store = "forces.zarr", or --store')
    return study(
        _function(told, file),
        _parameters(told),
        store=place if "://" in place else os.fspath(Path(place)),
        client=client,
        workers=workers,
    )


def _function(told: Mapping[str, Any], file: Path) -> Sweeps:
    """Return what is wanted of the scene that is described."""
    source = told.get("mechanism")
    if not isinstance(source, str):
        raise ArgumentError('which mechanism? write mechanism = "double_shaft_z", or a path')
    beside = file.parent / source
    given = _table(told, "scene", _SCENE)
    units: dict[str, str] = {}

    def number(name: str, value: object) -> float:
        found, units[name] = _number(name, value)
        return found

    kept = "drive", "near", "outputs"
    arguments: dict[str, Any] = {name: given[name] for name in kept if name in given}
    # `near` may be the name of a keyframe.
    for name in ("held", "loads", *["near"] * (not isinstance(given.get("near"), str))):
        told_of = mapping(f"scene.{name}", given.get(name))
        if values := {key: number(f"{name}.{key}", value) for key, value in told_of.items()}:
            arguments[name] = values
    if "gravity" in given:
        arguments["gravity"] = axes = given["gravity"]
        if axes != DESCRIPTION:
            if not isinstance(axes, list) or len(axes) != 3:
                raise ArgumentError('gravity: write ["0 m/s²", "0 m/s²", "-9.81 m/s²"]')
            pairs = zip("xyz", axes, strict=True)
            arguments["gravity"] = [number(f"gravity.{axis}", value) for axis, value in pairs]
    scene = Scene(load(beside if beside.exists() else source), **arguments)
    how = _table(told, "sweep", _SWEEP)
    rates = {name: number(name, how[name]) for name in ("speed", "acceleration") if name in how}
    position = None
    if "position" in how:
        position, units["position"] = _axis("position", how["position"])
    if isinstance(position, Line):
        position = position.values(0, position.count)
    response = how.get("response", False)
    found = Sweeps(scene, told.get("wanted", {}), position=position, response=response, **rates)
    found.refuse_units(units)
    return found


def _parameters(told: Mapping[str, Any]) -> Parameters:
    """Return what varies."""
    blocks: list[Any] = []
    grid = mapping("parameters", told.get("parameters"))
    if grid:
        blocks.append({name: _axis(name, axis) for name, axis in grid.items()})
    if "samples" in told:
        given = _table(told, "samples", _SAMPLES)
        laws = mapping("samples.parameters", given.get("parameters"))
        count, seed = whole("samples.count", given.get("count")), given.get("seed", 0)
        distributions = {name: _law(name, law) for name, law in laws.items()}
        if given.get("indices", False):
            blocks.append(sobol_samples(distributions, count, seed=seed))
        else:
            method = given.get("method", "sobol")
            blocks.append(samples(distributions, count, seed=seed, method=method))
    if not blocks:
        raise ArgumentError("what varies? the file needs [parameters] or [samples]")
    return checked_parameters(blocks)


def _axis(name: str, given: object) -> tuple[Any, str]:
    """Return the values of a parameter and their unit."""
    axis = mapping(name, given)
    _refuse_unknown(name, axis, _AXIS)
    if "values" in axis:
        values = axis["values"]
        if not isinstance(values, list) or not values or len(axis) > 1:
            raise ArgumentError(
                f'{name}: write values = ["5 deg", "10 deg"], or from, to and count'
            )
        found, unit = _numbers(name, values)
        return np.array(found), unit
    if set(axis) != {"from", "to", "count"}:
        raise ArgumentError(f'{name}: write {{ from = "5 deg", to = "30 deg", count = 26 }}')
    (first, last), unit = _numbers(name, [axis["from"], axis["to"]])
    return Line(first, last, whole(f"{name}.count", axis["count"], 2)), unit


def _law(name: str, given: object) -> tuple[Any, str]:
    """Return the distribution of a parameter and its unit."""
    from scipy import stats

    law = mapping(name, given)
    if len(law) != 1 or next(iter(law)) not in _LAWS:
        raise ArgumentError(
            f"{name}: write {{ normal = [mean, deviation] }} or {{ uniform = [least, most] }}, "
            "numbers with units"
        )
    kind, numbers = next(iter(law.items()))
    if not isinstance(numbers, list) or len(numbers) != 2:
        raise ArgumentError(f"{name}.{kind} is {described(numbers)}, expected two numbers")
    (first, second), unit = _numbers(f"{name}.{kind}", numbers)
    if second <= (0.0 if kind == "normal" else first):
        raise ArgumentError(f"{name}.{kind}: the second number is too small")
    law_of = stats.norm(first, second) if kind == "normal" else stats.uniform(first, second - first)
    return law_of, unit


def _number(name: str, given: object) -> tuple[float, str]:
    """Return a number with its unit, in SI units, and that unit."""
    is_factor = "inertia." in name
    if is_factor and isinstance(given, (int, float)) and not isinstance(given, bool):
        return float(given), "1"
    if not isinstance(given, str):
        example = _EXAMPLES.get(name.partition(".")[0], "20 deg")
        raise ArgumentError(f"{name} is {described(given)}, expected a text like {example!r}")
    return read_any(given, name)


def _numbers(name: str, given: list[object]) -> tuple[list[float], str]:
    """Return numbers with one unit, in SI units, and that unit."""
    numbers, units = zip(*(_number(name, item) for item in given), strict=True)
    if len(set(units)) > 1:
        raise ArgumentError(f"{name}: numbers are in {choices(units)}; give them in one kind")
    return list(numbers), units[0]


def _table(told: Mapping[str, Any], name: str, known: Words) -> dict[str, Any]:
    table = mapping(name, told.get(name))
    _refuse_unknown(f"[{name}]", table, known)
    return table


def _refuse_unknown(name: str, table: Mapping[str, Any], known: Words) -> None:
    if unknown := sorted(set(table) - set(known)):
        raise ArgumentError(f"{name} has no {unknown[0]!r}; it has {choices(known, unknown[0])}")


def _connected(address: str, stack: ExitStack) -> Any:
    """Return a client of a Dask scheduler."""
    try:
        from distributed import Client
    except ImportError as error:
        raise Failure('Dask is missing: pip install "cardan-dyn[study]"') from error
    try:
        return stack.enter_context(Client(address, timeout=20))
    except (OSError, ValueError) as error:
        raise Failure(f"no Dask scheduler answers at {address} ({error})") from error


def _tell(made: Study) -> None:
    """Print how results are spread, over how many of them, and what failed."""
    data, rows, caption = made.dataset, [], ""
    for name, item in data.data_vars.items():
        if name != "state":
            numbers = (float(item.min()), float(item.mean()), float(item.max()))
            unit = item.attrs.get("units", "")
            label = f"{name} [{unit}]" if unit else str(name)
            if OPEN in item.attrs:
                label += MARK
                caption = f"{MARK.strip()} not determined by statics, {item.attrs[OPEN]}"
            known = f"{int(item.count()):,} of {item.size:,}"
            rows.append((label, *(f"{number:.6g}" for number in numbers), known))
    show(("result", "least", "mean", "greatest", "known"), rows, caption=caption)
    failures = made.failures
    if len(failures):
        say(f"{len(failures)} cases failed; --retry computes them once more")
        for kind, group in failures.groupby("type"):
            say(f"{len(group)} × {kind}: {group.message.iloc[0]}")
    click.echo(f"Results: {made.store}")
