"""What `cardan-dyn sweep` and `simulate` do: wrenches over a motion, as a table and files."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click
import numpy as np

from ...core.elements.described import described_elements
from ...core.elements.link_loads import Wrench
from ...core.mechanics.exact import load
from ...core.mechanism.mechanism import Mechanism
from ...core.results.wrench import JointWrench
from ...figures.wrenches import MARK, QUANTITIES, determined, known_part, together, values_of
from ...kit.arrays import NOTHING, Array
from ...kit.checks import writing
from ...kit.errors import ArgumentError, MissingExtraError, SimulationError
from ...kit.quantities import column
from ...motion.simulation.progress import INTERRUPTED
from ...motion.simulation.trajectory import Trajectory
from ...scene.scene import Scene
from ...scene.usual_motion import UsualMotion, default_scene, slides, usual_motion
from .group import Interrupted
from .quantities import by_coordinate, efforts, ends_of, shown, value_of
from .quantities import near as near_of
from .quantities import positions as positions_of
from .tables import say, show

if TYPE_CHECKING:
    from ...core.results.sweep import Sweep


class Outputs(NamedTuple):
    """Files that are written; None for those that are not, `-` for standard output."""

    csv: Path | None = None
    json: Path | None = None
    parquet: Path | None = None
    plot: Path | None = None

    def check(self) -> None:
        """Refuse what lacks a package, before anything is computed.

        Raises:
            MissingExtraError: a package is missing.
            ArgumentError: two files go to standard output.
        """
        if self.csv == self.json == Path("-"):
            raise ArgumentError(
                "--csv - and --json - would be printed into each other; name a file"
            )
        if (self.csv or self.json or self.parquet) and find_spec("pandas") is None:
            raise MissingExtraError('pandas is missing: pip install "cardan-dyn[study]"')
        if self.parquet and find_spec("pyarrow") is None:
            raise MissingExtraError("Parquet files need pyarrow: pip install pyarrow")
        if self.plot is not None:
            from ...figures.style import require_matplotlib

            require_matplotlib()

    @property
    def printed(self) -> bool:
        """Whether data are printed, so that everything else goes to standard error."""
        return Path("-") in (self.csv, self.json)

    def write(self, result: Sweep | Trajectory, joints: tuple[str, ...]) -> None:
        """Write the files of a result; those joints are drawn, or what is asked of it first.

        Raises:
            ArgumentError: one cannot be written.
            MissingExtraError: an extra is not installed.
        """
        files = (self.csv, ".csv"), (self.json, ".json"), (self.parquet, ".parquet")
        for path, suffix in files:
            if path == Path("-"):
                with tempfile.TemporaryDirectory() as folder:
                    file = result.save(Path(folder) / f"result{suffix}")
                    click.echo(file.read_text(encoding="utf-8"), nl=False)
            elif path is not None:
                click.echo(f"Written: {result.save(path)}", err=self.printed)
        if self.plot is not None:
            figure = result.plot(*joints)
            with writing(self.plot) as part:
                figure.savefig(part)
            click.echo(f"Drawn: {self.plot}", err=self.printed)


def sweep_of(
    source: str,
    outputs: Outputs,
    *,
    drive: tuple[str, ...],
    ends: tuple[str, str] | None,
    samples: int,
    speed: str | None,
    acceleration: str | None,
    held: tuple[str, ...],
    near: tuple[str, ...],
    loads: tuple[str, ...],
    gravity: tuple[float, float, float] | str | None,
    joints: tuple[str, ...],
    strict: bool,
) -> None:
    """Sweep a mechanism, print the greatest wrenches and write files; see `motion_options`.

    Raises:
        CardanError: as `load`, `Scene` and `Scene.sweep` do, or an option has another form.
    """
    outputs.check()
    mechanism = load(source, strict=strict)
    motion = usual_motion(
        mechanism,
        drive=drive,
        held=positions_of(mechanism, held),
        near=near_of(mechanism, near),
        loads=efforts(mechanism, loads) if loads else None,
        gravity=gravity,
        samples=samples,
    )
    scene, at, said = motion.scene, motion.positions, motion.said
    if joints:
        scene = scene.replace(outputs=joints)
    if ends is not None:
        at, said = _between(motion, ends, samples)
    rates = _rates(motion, speed, acceleration, ends is not None)
    swept = scene.sweep(at, rates["speed"], rates["acceleration"])
    if not outputs.printed:
        say(f"{mechanism.name}: {said}; {samples} positions, {_how_fast(motion, rates)}")
        _say_what_acts(scene)
        name = swept.drives[0]
        place = swept.motion.position(name)
        if slides(swept.mechanism, name):
            _print_extremes(swept, place, f"{name} [m]")
        else:
            _print_extremes(swept, np.rad2deg(place), f"{name} [°]")
    outputs.write(swept, joints)


def simulation_of(
    source: str,
    outputs: Outputs,
    *,
    duration: float,
    free: tuple[str, ...],
    drive: tuple[str, ...],
    positions: tuple[str, ...],
    speeds: tuple[str, ...],
    held: tuple[str, ...],
    near: tuple[str, ...],
    loads: tuple[str, ...],
    gravity: tuple[float, float, float] | str | None,
    elements: bool,
    rtol: float,
    joints: tuple[str, ...],
    strict: bool,
) -> None:
    """Simulate a mechanism, print what came out and write files; see `motion_options`.

    Raises:
        Interrupted: Ctrl-C; all was printed and written up to there.
        SimulationError: it could not go on; likewise.
        CardanError: as `load`, `Scene` and `Scene.simulate` do, or an option has another form.
    """
    outputs.check()
    mechanism = load(source, strict=strict)
    driven = _speeds(mechanism, drive, "--drive")
    scene, why = _free_scene(mechanism, free, driven, held, near, loads, gravity)
    acting = described_elements(mechanism) if elements else []
    scene = scene.replace(elements=acting, **({"outputs": joints} if joints else {}))
    options: dict[str, Any] = {"motion": driven} if driven else {}
    if positions:
        options["position"] = positions_of(mechanism, positions, "--at")
    if speeds:
        options["speed"] = _speeds(mechanism, speeds, "--initial")
    failure = None
    try:
        found = scene.simulate(duration, rtol=rtol, **options)
    except SimulationError as error:
        if not isinstance(error.trajectory, Trajectory):
            raise
        found, failure = error.trajectory, error
    if not outputs.printed:
        swept = found.sweep
        with_elements = f", with {len(acting)} springs, dampers or brakes" if acting else ""
        say(
            f"{mechanism.name}: {', '.join(scene.free)} free{why}{with_elements}; "
            f"{found.time[-1]:.6g} s by {found.method}"
        )
        _say_what_acts(scene)
        for name in scene.free:
            say(f"{name}: {_course(swept, name)}")
        if np.isfinite(found.energy_residual):
            say(f"energy balance: {found.energy_residual:.1e} of what moves")
        for note in found.notes:
            say(note, "yellow")
        _print_extremes(swept, found.time, "time [s]")
    outputs.write(found, joints)
    if failure is not None:
        raise failure
    if found.reason == INTERRUPTED:
        raise Interrupted(f"interrupted at {found.time[-1]:.6g} s of {duration:g} s")


def _free_scene(
    mechanism: Mechanism,
    free: tuple[str, ...],
    driven: Mapping[str, float],
    held: tuple[str, ...],
    near: tuple[str, ...],
    loads: tuple[str, ...],
    gravity: tuple[float, float, float] | str | None,
) -> tuple[Scene, str]:
    """Return a scene with free joints, and why they are free, in brackets."""
    at = positions_of(mechanism, held)
    if driven and not free:
        # What is driven excites what stands on springs.
        free = tuple(
            name for name in mechanism.joint_springs if name not in driven and name not in at
        )
    scene = default_scene(
        mechanism,
        drive=(*driven, *free),
        held=at,
        near=near_of(mechanism, near),
        loads=efforts(mechanism, loads),
        gravity=gravity,
    )
    rest = free or tuple(name for name in scene.drives if name not in driven)
    why = "" if free or driven else " (what would be driven in a sweep)"
    return scene.replace(free=list(rest), drive=list(driven) or None), why


def _course(swept: Sweep, name: str) -> str:
    """Return where a coordinate begins and ends, and how fast it is then."""
    places, speeds = swept.motion.position(name), swept.motion.velocity(name)
    first, last, least, most = (
        shown(swept.mechanism, name, "position", value)
        for value in (places[0], places[-1], places.min(), places.max())
    )
    rate = shown(swept.mechanism, name, "speed", speeds[-1])
    return f"from {first} to {last}, between {least} and {most}; at last {rate}"


def _between(motion: UsualMotion, ends: tuple[str, str], samples: int) -> tuple[Array, str]:
    """Return positions of a single drive between two ends, and what is said of them."""
    drives = motion.scene.drives
    if len(drives) > 1:
        raise ArgumentError(
            f"--range is of a single drive, and {', '.join(drives)} are driven; hold all but one: "
            f"{' '.join(f'--held {name}=…' for name in drives[1:3])}"
        )
    of_drive = motion.scene.mechanism, drives[0], "position"
    low, high = ends_of(*of_drive[:2], ends)
    said = f"{drives[0]} from {shown(*of_drive, low)} to {shown(*of_drive, high)}"
    return np.linspace(low, high, samples), said


def _rates(
    motion: UsualMotion, speed: str | None, acceleration: str | None, has_range: bool
) -> dict[str, float]:
    """Return speed and acceleration of the drive [rad/s or m/s, rad/s² or m/s²]."""
    drives = motion.scene.drives
    if len(drives) > 1 and (speed or acceleration):
        raise ArgumentError(
            "--speed and --acceleration are of a single drive; hold all but one: --held JOINT=VALUE"
        )
    if (speed or acceleration) and not (motion.turns or has_range):
        raise ArgumentError(
            f"{drives[0]} goes there and back, which no constant speed does; say from where to "
            "where it moves: --range FROM TO"
        )
    rates = {"speed": motion.speed if motion.turns or has_range else 0.0, "acceleration": 0.0}
    for what, text in (("speed", speed), ("acceleration", acceleration)):
        if text is not None:
            rates[what] = value_of(motion.scene.mechanism, drives[0], what, text, f"--{what}")
    return rates


def _how_fast(motion: UsualMotion, rates: Mapping[str, float]) -> str:
    """Return in words how fast the drive moves."""
    if not any(rates.values()):
        return "quasi-static"
    drive = motion.scene.mechanism, motion.scene.drives[0]
    told = [shown(*drive, what, rate) for what, rate in rates.items() if rate or what == "speed"]
    return f"at {', '.join(told)}"


def _say_what_acts(scene: Scene) -> None:
    """Print what holds and loads a scene, which may be that of a preset."""
    texts = []
    for name, value in scene.held.items():
        texts.append(f"{name} held at {shown(scene.mechanism, name, 'position', value)}")
    for name, effort in scene.loads.items():
        if name in scene.mechanism.drivable:
            amount = shown(scene.mechanism, name, "effort", float(np.asarray(effort)))
            texts.append(f"{amount} at {name}")
        elif isinstance(effort, Wrench):
            texts.append(f"a wrench on {name}")
    if np.any(scene.gravity):
        texts.append(f"gravity {' '.join(f'{value:g}' for value in scene.gravity)} m/s²")
    if texts:
        say("; ".join(texts))


def _speeds(mechanism: Mechanism, pairs: tuple[str, ...], option: str) -> dict[str, float]:
    """Return speeds [rad/s or m/s] from `JOINT=SPEED`."""
    return by_coordinate(mechanism, "speed", pairs, option, "JOINT=SPEED, as crank=1500rpm")


def _print_extremes(swept: Sweep, places: Array, over: str) -> None:
    """Print the greatest force and moment of every joint, and where they occur."""
    unit = over.partition("[")[2].rstrip("]")
    quantities = ("force", "moment", "torsion", "bending")
    sizes: dict[str, list[float]] = {name: [] for name in quantities}
    marks: dict[str, list[str]] = {name: [] for name in quantities}
    found_at: dict[str, list[float]] = {name: [] for name in quantities}
    missing = np.zeros(len(places), dtype=bool)
    force, moment = (
        max(
            (np.nanmax(np.abs(getattr(swept[name], what)), initial=0.0) for name in swept.outputs),
            default=0.0,
        )
        for what in ("force", "moment")
    )
    scale = together(force, moment, swept.mechanism.characteristic_length)

    def acting(wrench: JointWrench, part: str) -> bool:
        """Return whether a part of a wrench is more than rounding."""
        size = np.nanmax(np.abs(values_of(wrench, part)), initial=0.0)
        return bool(size > NOTHING * scale[QUANTITIES[part]])

    # Positions at which an angle passes through zero miss it by rounding.
    places = np.where(np.abs(places) <= NOTHING * np.max(np.abs(places)), 0.0, places)
    for name in swept.outputs:
        wrench = swept[name]
        for quantity in quantities:
            if quantity in ("torsion", "bending"):
                part = quantity if wrench.has_axis else ""
            else:
                part = known_part(wrench, quantity)
                missing |= np.isnan(values_of(wrench, quantity))
                if not acting(wrench, part) and acting(wrench, quantity):
                    part = quantity  # What statics leaves open of it is all there is.
            values = values_of(wrench, part) if part else np.full(len(places), np.nan)
            worst = _greatest(np.abs(values))
            acts = bool(part) and acting(wrench, part)
            # What is but rounding has no place.
            found_at[quantity].append(float(places[worst]) if acts else np.nan)
            size = values[worst] if part == "torsion" else abs(values[worst])
            sizes[quantity].append(size if acts or np.isnan(size) else 0.0)
            told = f" {part}" if acts and part and part != quantity else ""
            marks[quantity].append(told + (_star(wrench, part) if part else ""))
    has_parts = any(text.strip(MARK) for texts in marks.values() for text in texts)
    columns: list[list[str]] = [list(swept.outputs)]
    headings = ["joint"]
    for quantity, unit_of in zip(quantities, ("N", "N·m", "N·m", "N·m"), strict=True):
        texts, shown_unit = column(sizes[quantity], unit_of)
        columns.append([text + mark for text, mark in zip(texts, marks[quantity], strict=True)])
        headings.append(f"{quantity}\n{shown_unit}")
        if quantity in ("force", "moment"):
            texts, shown_unit = column(found_at[quantity], unit, 3)
            columns.append(texts)
            headings.append(f"at\n{shown_unit}")
    rows = list(zip(*columns, strict=True))
    caption = (
        f"Greatest of {len(places)} values that the parent exerts on the child, and where: {over}."
    )
    if has_parts:
        caption += " Where statics leaves one open, its greatest part that is determined, by name."
    if opened := swept.left_open.text:
        caption += f" * {opened[0].upper()}{opened[1:]}."
    if missing.any():
        caption += f" Not known at {missing.sum()} of {len(places)} places, close to singular ones."
    show(headings, rows, caption=caption)
    singular = swept.near_singular(*swept.values())
    if singular:
        say(f"{singular[0].upper()}{singular[1:]}.", "yellow")
    efforts = np.asarray(swept.drive_effort).reshape(len(places), -1)
    for index, name in enumerate(swept.drives):
        values = efforts[:, index]
        values = values[~np.isnan(values)] if not np.isnan(values).all() else values
        unit = swept.mechanism.drivable[name].effort_unit
        (low, high), shown_unit = column([values.min(), values.max()], unit)
        say(f"drive {name}: {low} to {high} {shown_unit}")
    residuals = {
        "loops": swept.loop_residual,
        "balance": swept.balance_residual,
        "power": swept.power_residual,
    }
    # A dash where there is nothing to compare, as where nothing acts.
    shown = (f"{name} {'–' if np.isnan(of) else f'{of:.1e}'}" for name, of in residuals.items())
    say(f"residuals: {', '.join(shown)}")


def _star(wrench: JointWrench, quantity: str) -> str:
    """Return the mark of a quantity of which statics leaves a part open."""
    return "" if determined(wrench, quantity) else MARK


def _greatest(sizes: Array) -> int:
    """Return where sizes are greatest first but for rounding, among those that are known."""
    return int(np.argmax(sizes >= np.nanmax(sizes, initial=0.0) * (1.0 - NOTHING)))
