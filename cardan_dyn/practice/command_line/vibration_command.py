"""What `cardan-dyn vibration` does with its options: critical speeds of a rig that has springs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from ...core.elements.described import described_elements
from ...core.mechanics.exact import load
from ...figures.style import PER_MINUTE
from ...kit.errors import ArgumentError, choices
from ...motion.vibration.results.campbell import campbell
from ...motion.vibration.results.critical_speeds import (
    CriticalSpeeds,
    critical_speeds,
)
from ...motion.vibration.results.floquet import floquet
from ...motion.vibration.results.forced_response import forced_response
from ...motion.vibration.results.periodic_motion import search_of
from ...motion.vibration.results.resonance import CriticalSpeed, numbered_campbell
from ...scene.presets import Preset, preset_of
from ...scene.scene import Scene
from .options import Words
from .quantities import of_scene, positions
from .showing import present
from .tables import print_json, say, show

if TYPE_CHECKING:
    from ..viewer.viewing import View


def rig_scene(
    source: str,
    *,
    drive: str | None = None,
    free: Words = (),
    held: Words = (),
    strict: bool = True,
    **acting: Any,
) -> Scene:
    """Return the scene of a rig: its drive first, then its free coordinates, with its springs.

    Args:
        source: name of a bundled description, or a path.
        drive: joint that turns at constant speed; that of the preset if None.
        free: free coordinates; all that have a spring in the description if empty.
        held: held joints and positions, as `quantities.positions` reads them.
        strict: refuse physically inconsistent inertias.
        acting: where loops are closed, loads and gravity, see `quantities.of_scene`.

    Raises:
        ArgumentError: nothing is free, or nothing turns.
        CardanError: as `load` and `Scene` do.
    """
    mechanism = load(source, strict=strict)
    preset = preset_of(mechanism) or Preset(mechanism.independent_coordinates)
    told = of_scene(mechanism, held=held, **acting)
    given = told["held"]
    taken = {*given, drive}
    free = free or tuple(name for name in mechanism.joint_springs if name not in taken)
    if not free:
        raise ArgumentError(
            f"{mechanism.name} has no free coordinate: none of its joints has a spring, unless it "
            'is driven or held; state one as <dynamics spring_stiffness="..." damping="..."/> of '
            "a joint"
        )
    drive = drive or next((name for name in preset.drive if name not in free), None)
    if drive is None:
        left = [name for name in mechanism.drivable if name not in (*free, *given)]
        if len(left) != 1:
            raise ArgumentError(f"nothing says what turns: give --drive, one of {choices(left)}")
        (drive,) = left
    rest = {**{name: float(np.deg2rad(angle)) for name, angle in preset.held_deg.items()}, **given}
    return Scene(
        mechanism,
        drive=drive,
        free=free,
        held={name: value for name, value in rest.items() if name not in (drive, *free)},
        near=told["near"],
        loads=told["loads"],
        gravity=told["gravity"],
        elements=described_elements(mechanism),
    )


def found_speeds(
    scene: Scene, speed: tuple[float, float] | None, orders: tuple[float, ...] = ()
) -> CriticalSpeeds:
    """Return the critical speeds of a rig.

    Args:
        scene: see `rig_scene`.
        speed: ends of the range [rad/s]; unless given, from below a quarter of the lowest
            natural frequency to above the greatest.
        orders: that are looked at; those that excite if empty.

    Raises:
        CardanError: as `critical_speeds` does.
    """
    if speed is None:
        # The first speed only says how slow is slow: gyroscopic terms change modes by about a
        # thousandth then, which is nothing for a range.
        scale = float(np.nanmax(campbell(scene, np.array([1.0])).frequency, initial=0.0))
        at_rest = campbell(scene, np.array([1e-3 * (scale or 1.0)])).frequency[0]
        swings = np.sort(at_rest[np.isfinite(at_rest) & (at_rest > 0.0)])
        if not len(swings):
            raise ArgumentError("no mode swings near rest: give the range of speeds, --speed")
        # From a little below a quarter of the lowest, up to above what unbalance excites.
        speed = 0.2 * swings[0], 1.25 * swings[-1]
    return critical_speeds(scene, np.array(speed), orders=orders or None)


def run(
    source: str,
    *,
    speed: tuple[float, float] | None,
    orders: tuple[float, ...],
    directory: Path | None,
    chart: str | None,
    mode: int | None,
    file: Path | None,
    open_browser: bool,
    as_json: bool,
    **given: Any,
) -> None:
    """Print critical speeds, draw and show what is wanted; see `vibration_options`.

    Raises:
        MissingExtraError: an extra is not installed.
        ArgumentError: a figure cannot be written.
        CardanError: as `rig_scene`, `found_speeds`, `forced_response` and `floquet` do.
    """
    if chart is not None and directory is None:
        raise click.UsageError("--chart needs --figures")
    if file is not None and mode is None:
        raise click.UsageError("--export needs --mode")
    scene = rig_scene(source, **given)
    drawn = chart_of(scene, chart)
    found = found_speeds(scene, speed, orders)
    if as_json:
        print_json(plain(found))
    else:
        print_table(found)
    if directory is not None:
        save_figures(scene, found, directory, drawn)
        click.echo(f"Figures: {directory}", err=as_json)
    if mode is not None:
        present(mode_view(scene, mode, found.low), file, open_browser, aside=as_json)


def save_figures(
    scene: Scene, found: CriticalSpeeds, directory: Path, chart: tuple[str, float] | None = None
) -> list[Path]:
    """Write the Campbell diagram, amplitudes by orders, multipliers and a chart that is wanted.

    Args:
        scene: see `rig_scene`.
        found: its critical speeds, over whose range all is drawn.
        directory: where to; it is created if missing.
        chart: joint and greatest angle [rad] of a chart of stability.

    Returns:
        Paths of the files.

    Raises:
        ArgumentError: they cannot be written.
    """
    from ...figures import save

    speeds = np.linspace(found.low, found.high, 241)
    plots = {
        "campbell": found.plot(),
        "orders": forced_response(scene, speeds, joints=()).plot(
            orders=found.orders, critical=found
        ),
        "multipliers": floquet(scene, speeds).plot(),
    }
    if chart is not None:
        joint, greatest = chart
        angles = np.linspace(0.0, greatest, 25)
        plots["chart"] = floquet(scene, speeds[::4], held={joint: angles}).plot()
    return [path for name, plot in plots.items() for path in save(plot, directory / name)]


def mode_view(scene: Scene, number: int, speed: float) -> View:
    """Return a mode of a rig as a moving scene, larger than life.

    Args:
        scene: see `rig_scene`.
        number: of the mode, from 1, as the table has it: by frequency at next to no speed.
        speed: of the drive at which it is taken [rad/s].

    Raises:
        ArgumentError: no such mode.
        MissingExtraError: meshcat is not installed.
    """
    from ..viewer.mode_shapes import mode_sweep
    from ..viewer.viewing import view

    found = numbered_campbell(search_of(scene, 1.0), np.array([speed]))[0]
    count = found.frequency.shape[1]
    if not 1 <= number <= count:
        raise ArgumentError(f"--mode {number} does not exist; modes: 1 to {count}")
    mode = number - 1
    hertz = found.frequency[0, mode] / (2.0 * np.pi)
    title = (
        f"{scene.mechanism.name}: mode {number}, {hertz:.4g} Hz at {PER_MINUTE * speed:.4g} 1/min"
    )
    swing = mode_sweep(scene, found.shape[0][:, mode])
    return view(
        swing,
        moments=False,
        forces=False,
        traces=False,
        swings=scene.free,
        duration=4.0,
        title=title,
    )


def print_table(found: CriticalSpeeds) -> None:
    """Print critical speeds, ascending."""
    ends = f"{PER_MINUTE * found.low:.4g} to {PER_MINUTE * found.high:.4g} 1/min"
    name = found.scene.mechanism.name
    if not len(found):
        say(f"{name}: no critical speed from {ends}")
        for remark in found.remarks:
            say(remark)
        return
    headings = ("1/min", "critical by", "Hz", "Q", "severity", "from", "to 1/min")
    show(
        headings,
        [_cells(row) for row in found],
        title=f"{name}: critical speeds from {ends}",
        texts=(1,),
    )
    texts = [f"{_name(row)} {jumps}" for row in found if (jumps := row.jumps("1/min", PER_MINUTE))]
    texts += found.remarks
    texts.append(
        "severity: greatest amplitude of the mode alone [rad, of slides m], without what other "
        "modes add or take away; growth of an instability; from, to: half power of a resonance, or "
        "the fold before it at which it jumps; edges of an instability"
    )
    for text in texts:
        say(text)


def plain(found: CriticalSpeeds) -> dict[str, Any]:
    """Return critical speeds as plain data, in SI units and radians."""
    return {
        "mechanism": found.scene.mechanism.name,
        "drive": found.scene.drives[0],
        "free": list(found.scene.free),
        "low": found.low,
        "high": found.high,
        "orders": list(found.orders),
        "critical_speeds": [row._asdict() for row in found],
        "remarks": list(found.remarks),
    }


def chart_of(scene: Scene, text: str | None) -> tuple[str, float] | None:
    """Return joint and greatest angle [rad], of a slide position [m], of a chart.

    Args:
        scene: see `rig_scene`.
        text: `JOINT=VALUE`, as `quantities.positions` reads it; no chart if None.

    Raises:
        ArgumentError: it has another form, or the scene does not hold the joint.
    """
    if text is None:
        return None
    ((joint, value),) = positions(scene.mechanism, [text], "--chart").items()
    if joint not in scene.held:
        raise ArgumentError(
            f"--chart {joint!r} is not held; held: {choices(scene.held, joint) or '(none)'}"
        )
    if not value:
        raise ArgumentError("--chart ends at 0, where it begins; give another angle")
    return joint, value


def _name(row: CriticalSpeed) -> str:
    return f"{row.order:g}× mode {row.mode}"


def _cells(row: CriticalSpeed) -> Words:
    """Return a row of the table."""
    speed, lower, upper = (
        "" if np.isnan(value) else f"{PER_MINUTE * value:.5g}"
        for value in (row.speed, row.lower, row.upper)
    )
    if row.kind != "resonance":
        return speed, row.kind, "", "", f"{row.severity_text} 1/s", lower, upper
    whirl = "" if row.whirl == "planar" else f" {row.whirl}"
    what = f"{_name(row)}{whirl}"
    quality = f"{row.amplification:.3g}"
    hertz = f"{row.frequency / (2.0 * np.pi):.4g}"
    return speed, what, hertz, quality, row.severity_text, lower, upper
