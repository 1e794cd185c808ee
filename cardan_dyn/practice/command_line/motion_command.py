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
from ...core.mechanics.exact import load
from ...core.mechanism.mechanism import Mechanism
from ...core.results.limits import briefly, exceeded
from ...core.results.wrench import JointWrench
from ...figures.wrenches import (
    MARK,
    PARTS,
    QUANTITIES,
    along,
    determined,
    known_part,
    values_of,
    whole_of,
)
from ...kit.arrays import NOTHING, Array
from ...kit.checks import writing
from ...kit.errors import ArgumentError, MissingExtraError, SimulationError, choices
from ...kit.quantities import cleared, column
from ...motion.simulation.progress import INTERRUPTED
from ...motion.simulation.trajectory import Trajectory
from ...scene.scene import Scene
from ...scene.usual_motion import (
    default_scene,
    driving,
    one_way,
    slides,
    usual_motion,
)
from ..report.extremes import with_extremes
from ..report.findings import acting, sentence, speed_text, ways
from ..report.grids import place, way
from .group import Interrupted, end_by
from .options import Words
from .quantities import by_coordinate, ends_of, of_scene, value_of
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

    @classmethod
    def taken(cls, given: dict[str, Any]) -> Outputs:
        """Take them out of options; what lacks a package is refused before anything is computed.

        Raises:
            MissingExtraError: a package is missing.
            ArgumentError: two files go to standard output.
        """
        self = cls(*(given.pop(name) for name in cls._fields))
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
        return self

    @property
    def printed(self) -> bool:
        """Whether data are printed, so that everything else goes to standard error."""
        return Path("-") in (self.csv, self.json)

    def write(self, result: Sweep | Trajectory, joints: Words) -> None:
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
    *,
    ends: tuple[str, str] | None,
    samples: int,
    speed: str | None,
    acceleration: str | None,
    joints: Words,
    strict: bool,
    **given: Any,
) -> None:
    """Sweep a mechanism, print the greatest wrenches and write files; see `motion_options`.

    Raises:
        CardanError: as `load`, `Scene` and `Scene.sweep` do, or an option has another form.
    """
    outputs, mechanism = Outputs.taken(given), load(source, strict=strict)
    one_ways: dict[str, tuple[float, int]] = {}
    asked = of_scene(mechanism, ways=one_ways, **given)
    if not given["loads"]:
        asked["loads"] = None
    motion = usual_motion(mechanism, samples=samples, **asked)
    scene, at, said = motion.scene, motion.positions, motion.said
    single, *others = scene.drives
    if others and (ends or speed or acceleration):
        raise ArgumentError(
            "--range, --speed and --acceleration are of a single drive, and "
            f"{choices(scene.drives)} are driven; hold all but one: "
            f"{' '.join(f'--held {name}=…' for name in others[:2])}"
        )
    if joints:
        scene = scene.replace(outputs=joints)
    if ends is not None:
        low, high = ends_of(mechanism, single, ends)
        at = np.linspace(low, high, samples)
        said = f"{single} from {way(low, high, slides(mechanism, single), ' to ')}"
    goes_on = motion.turns or ends is not None
    if (speed or acceleration) and not goes_on:
        raise ArgumentError(
            f"{single} goes there and back, which no constant speed does; say from where to "
            "where it moves: --range FROM TO"
        )
    rates = {"speed": motion.speed if goes_on else 0.0, "acceleration": 0.0}
    for what, text in (("speed", speed), ("acceleration", acceleration)):
        if text is not None:
            rates[what] = value_of(mechanism, single, what, text, f"--{what}")
    acting_one_way = one_way(scene, at, rates["speed"], one_ways)
    swept = scene.sweep(at, rates["speed"], rates["acceleration"], loads=acting_one_way)
    if not outputs.printed:
        pace = ", ".join(ways(swept)[0].pace) or "quasi-static"
        say(f"{mechanism.name}: {said}; {samples} positions, {pace}")
        say("; ".join(acting(swept, one_ways)) or "no load acts")
        for text in driving(swept) if asked["loads"] and motion.turns and ends is None else ():
            say(text, "yellow")
        if len(swept.drives) > 1:
            said = (
                f"and at which of {samples} samples on one way of {len(swept.drives)} drives; "
                "`cardan-dyn report` looks through all of their ranges"
            )
            _print_extremes(swept, np.arange(samples), "sample", said)
        else:
            over = along(swept, single)
            said = f"and at which of {samples} positions of {single} [{over.unit}]"
            _print_extremes(swept, over.values, over.unit, said)
    outputs.write(swept, joints)
    end_by(exceeded(swept))


def simulation_of(
    source: str,
    *,
    duration: float,
    free: Words,
    drive: Words,
    positions: Words,
    speeds: Words,
    elements: bool,
    rtol: float,
    joints: Words,
    strict: bool,
    **given: Any,
) -> None:
    """Simulate a mechanism, print what came out and write files; see `motion_options`.

    Raises:
        Interrupted: Ctrl-C; all was printed and written up to there.
        SimulationError: it could not go on; likewise.
        CardanError: as `load`, `Scene` and `Scene.simulate` do, or an option has another form.
    """
    outputs, mechanism = Outputs.taken(given), load(source, strict=strict)
    driven = _speeds(mechanism, drive, "--drive")
    scene, why = _free_scene(mechanism, free, driven, given)
    described = described_elements(mechanism) if elements else []
    scene = scene.replace(elements=described, **({"outputs": joints} if joints else {}))
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
    whole, unknown = with_extremes(found)
    swept = whole.sweep
    if not outputs.printed:
        say(
            f"{mechanism.name}: {', '.join(scene.free)} free{why}; "
            f"{found.time[-1]:.6g} s by {found.method}"
        )
        say("; ".join(acting(swept, {})) or "no load acts")
        for name in scene.free:
            say(f"{name}: {_course(swept, name)}")
        if np.isfinite(found.energy_residual):
            say(f"energy balance: {found.energy_residual:.1e} of what moves")
        for note in found.notes:
            say(note, "yellow")
        steps = f"and when [s], between its {len(found.time)} steps as well"
        _print_extremes(swept, whole.time, "s", steps)
        if unknown:
            say(sentence(unknown), "yellow")
    outputs.write(found, joints)
    if failure is not None:
        raise failure
    if found.reason == INTERRUPTED:
        raise Interrupted(f"interrupted at {found.time[-1]:.6g} s of {duration:g} s")
    end_by(exceeded(swept))


def _free_scene(
    mechanism: Mechanism,
    free: Words,
    driven: Mapping[str, float],
    given: Mapping[str, Any],
) -> tuple[Scene, str]:
    """Return a scene with free joints, and why they are free, in brackets."""
    asked = of_scene(mechanism, **given)
    if driven and not free:
        # What is driven excites what stands on springs.
        taken = {*driven, *asked["held"]}
        free = tuple(name for name in mechanism.joint_springs if name not in taken)
    scene = default_scene(mechanism, **asked | {"drive": (*driven, *free)})
    rest = free or tuple(name for name in scene.drives if name not in driven)
    why = "" if free or driven else " (what would be driven in a sweep)"
    return scene.replace(free=list(rest), drive=list(driven) or None), why


def _course(swept: Sweep, name: str) -> str:
    """Return where a coordinate begins and ends, and how fast it is then."""
    places, speeds = swept.motion.position(name), swept.motion.velocity(name)
    is_slide, size = slides(swept.mechanism, name), float(np.abs(places).max())
    first, last, least, most = (
        place(cleared(float(value), size), is_slide, size)
        for value in (places[0], places[-1], places.min(), places.max())
    )
    last_speed = cleared(float(speeds[-1]), float(np.abs(speeds).max()))
    rate = speed_text(np.array(last_speed), is_slide)
    return f"from {first} to {last}, between {least} and {most}; at last {rate}"


def _speeds(mechanism: Mechanism, pairs: Words, option: str) -> dict[str, float]:
    """Return speeds [rad/s or m/s] from `JOINT=SPEED`."""
    return by_coordinate(mechanism, "speed", pairs, option, "JOINT=SPEED, as crank=1500rpm")


def _print_extremes(swept: Sweep, places: Array, unit: str, said: str) -> None:
    """Print the greatest force and moment of every joint, and where they occur."""
    scale = whole_of(swept.values(), swept.mechanism.characteristic_length)
    # Positions at which an angle passes through zero miss it by rounding.
    places = np.where(np.abs(places) <= NOTHING * np.max(np.abs(places)), 0.0, places)
    columns, headings, told = [list(swept)], ["joint"], ""
    for quantity in ("force", "moment", "torsion", "bending"):
        nothing = NOTHING * scale[QUANTITIES[quantity]]
        found = [_greatest(wrench, quantity, nothing, places) for wrench in swept.values()]
        sizes, marks, at = zip(*found, strict=True)
        # A zero that was chosen is told below, once.
        silent = swept.left_open.silent
        marks = tuple(
            mark if size or joint in silent else ""
            for joint, size, mark in zip(swept, sizes, marks, strict=True)
        )
        texts, shown_unit = column(sizes, QUANTITIES[quantity])
        columns.append([text + mark for text, mark in zip(texts, marks, strict=True)])
        headings.append(f"{quantity}\n{shown_unit}")
        if quantity in PARTS:
            texts, shown_unit = column(at, unit, 1 if unit == "sample" else 3)
            columns.append(texts)
            headings.append(f"at\n{shown_unit}")
        told += "".join(marks)
    caption = f"Greatest that the parent exerts on the child, {said}."
    if told.replace(MARK, ""):
        caption += " Where statics leaves one open, its greatest part that is determined, by name."
    if opened := swept.left_open.text:
        caption += f" {'* ' * (MARK in told)}{sentence(opened)}"
    unknown = [np.isnan(values_of(of, quantity)) for of in swept.values() for quantity in PARTS]
    if missing := int(np.any(unknown, axis=0).sum()):
        caption += f" Not known at {missing} of {len(places)} places, close to singular ones."
    show(headings, list(zip(*columns, strict=True)), caption=caption)
    remarks = swept.near_singular(*swept.values()), swept.near_reach, *briefly(exceeded(swept))
    for text in filter(None, remarks):
        say(sentence(text), "yellow")
    efforts = np.reshape(swept.drive_effort, (len(places), -1)).T
    for name, course in zip(swept.drives, efforts, strict=False):
        ends = np.fmin.reduce(course), np.fmax.reduce(course)
        (low, high), unit = column(ends, swept.mechanism.drivable[name].effort_unit)
        say(f"drive {name}: {low} to {high} {unit}")
    # A dash where there is nothing to compare, as where nothing acts.
    residuals = (
        f"{name.removesuffix('_residual')} {'–' if np.isnan(value) else f'{value:.1e}'}"
        for name, value in swept.proven.residuals.items()
    )
    say(f"residuals: {', '.join(residuals)}")


def _greatest(
    wrench: JointWrench, quantity: str, nothing: float, places: Array
) -> tuple[float, str, float]:
    """Return the greatest of a quantity, or of the part of it that statics determines.

    Args:
        wrench: of the joint.
        quantity: `force`, `moment`, `torsion` or `bending`.
        nothing: size up to which it is rounding.
        places: `(N,)` of the samples.

    Returns:
        With its sign; the name of the part, and a star of what is open; where. NaN is not known.
    """
    if quantity not in PARTS and not wrench.has_axis:
        return np.nan, "", np.nan
    part = known_part(wrench, quantity) if quantity in PARTS else quantity
    values, whole = values_of(wrench, part), values_of(wrench, quantity)
    if np.any(whole > nothing) and not np.any(np.abs(values) > nothing):
        part, values = quantity, whole  # What statics leaves open of it is all there is.
    star, sizes = MARK * (not determined(wrench, part)), np.abs(values)
    most = float(np.nanmax(sizes, initial=0.0))
    if most <= nothing:
        return (np.nan if np.isnan(sizes).all() else 0.0), star, np.nan
    # The first that is as great but for rounding, among those that are known.
    worst = int(np.argmax(sizes >= most * (1.0 - NOTHING)))
    return float(values[worst]), f" {part}" * (part != quantity) + star, float(places[worst])
