"""What `cardan-dyn clearance` does with its options: a scan, as tables, JSON and figures."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import click
import numpy as np

from ...clearance import PinGeometry, Scan, scan
from ...core.mechanics.exact import load
from ...kit.errors import ArgumentError
from ...kit.quantities import NONE, column, number
from ...motion.clearance import drawing
from ...motion.simulation.progress import INTERRUPTED
from ...scene.usual_motion import default_scene
from .group import Interrupted
from .options import Words
from .quantities import by_joint, of_scene
from .tables import print_json, say, show

_LENGTH = "length", "m"
_TOLD = (
    *("verdict", "rigid_peak", "peak", "peak_position", "least", "greatest", "doubts"),
    *("impacts_per_turn", "impact_power", "turning"),
)
"""What JSON tells of a joint, as `JointScan` calls it."""


def scanned_by(
    source: str,
    *,
    speed: float | None,
    clearances: Words,
    stiffnesses: Words,
    radii: Words,
    pin: tuple[float, float] | None,
    seat_stiffness: float | None,
    strict: bool,
    joints: Words,
    bearings: Words,
    given: dict[str, Any],
    **rest: Any,
) -> Scan:
    """Return the scan that the options of the command ask for.

    `given` is what drives and acts, see `quantities.of_scene`, and `rest` are arguments of `scan`.
    """
    if speed is None:
        raise ArgumentError("give the speed of the drive: --speed")
    mechanism = load(source, strict=strict)
    if bool(stiffnesses) == (pin is not None):
        raise ArgumentError("give the stiffness of contacts either by --stiffness or by --pin")
    if pin is None and seat_stiffness is not None:
        raise ArgumentError("--seat-stiffness goes with --pin; --stiffness is that of the whole")
    stiffness: Any = by_joint(stiffnesses, "--stiffness", ("rigidity", "N/m"), mechanism)
    if pin is not None:
        stiffness = PinGeometry(*pin, seat_stiffness=seat_stiffness)
    scene = default_scene(mechanism, **of_scene(mechanism, **given))
    return scan(
        scene,
        speed,
        clearance=by_joint(clearances, "--clearance", _LENGTH, mechanism),
        stiffness=stiffness,
        radius=by_joint(radii, "--radius", _LENGTH, mechanism) if radii else None,
        joints=joints or None,
        bearings=bearings or None,
        **rest,
    )


def run(directory: Path | None, as_json: bool, **options: Any) -> None:
    """Print a scan, and write its figures.

    Args:
        directory: of the figures; None for none.
        as_json: print JSON instead of tables.
        options: of the command, see `scanned_by`.

    Raises:
        MissingExtraError: figures are wanted and matplotlib is not installed.
        ArgumentError: a file cannot be written.
        CardanError: options do not fit each other, or as `load`, `Scene` and `clearance.scan`.
        Interrupted: Ctrl-C while joints were simulated; all was printed and written up to there.
    """
    given = {name: options.pop(name) for name in ("drive", "near", "held", "loads", "gravity")}
    scanned = scanned_by(given=given, **options)
    if as_json:
        print_json(plain(scanned))
    else:
        print_scan(scanned)
    if directory is not None:
        save_figures(scanned, directory)
        click.echo(f"Figures: {directory}", err=as_json)
    if waiting := [name for name, why in scanned.unverified.items() if why == INTERRUPTED]:
        raise Interrupted(f"interrupted; not simulated: {', '.join(waiting)}")


def print_scan(scanned: Scan) -> None:
    """Print joints by their peaks, what speaks against these, and what was not scanned."""
    joints = [scanned[name] for name in scanned.ranking]
    # Of joints that turn through at all, and of what strikes: what only brushes along its wall has
    # a speed and a power, and strikes nothing.
    worst = [joint.worst for joint in joints]
    strikes = [item.strike_speed if item and item.strikes else math.nan for item in worst]
    powers = [
        joint.impact_power if item and joint.impacts else math.nan
        for joint, item in zip(joints, worst, strict=True)
    ]
    forces = np.array([(joint.rigid_peak, joint.peak, joint.least) for joint in joints])
    told, force = column(forces.ravel(), "N")
    of_forces = np.reshape(told, forces.shape).T.tolist()
    speeds, speed = column(strikes, "m/s", 3)
    watts, power = column(powers, "W", 3)
    columns = {
        "joint": scanned.ranking,
        **{f"{name}\n{force}": of_forces[k] for k, name in enumerate(("rigid", "peak", "least"))},
        "at\n°": column([math.degrees(joint.peak_position) for joint in joints])[0],
        "ρ\n–": [f"{item.turn_through:.2f}" if item else NONE for item in worst],
        "τ\n–": [f"{item.tau:.2f}" if item else NONE for item in worst],
        f"speed\n{speed}": speeds,
        "hits\n1/turn": [
            f"{joint.impacts_per_turn:g}" if item else NONE
            for joint, item in zip(joints, worst, strict=True)
        ],
        f"power\n{power}": watts,
    }
    headings, rows = list(columns), list(zip(*columns.values(), strict=True))
    title = f"Clearance at {number(np.rad2deg(scanned.speed) / 6.0, 6)} 1/min"
    caption = "peak: greatest force of all that is known; least: lower end of its interval"
    show(headings, rows, title=title, caption=caption)
    said = {name: (scanned[name].verdict, *scanned[name].doubts) for name in scanned.ranking}
    lines = [f"{name}: {'; '.join(words)}" for name, words in said.items()]
    lines += str(scanned.verified).splitlines() if scanned.verified is not None else []
    lines += [f"{name}: not scanned, {reason}" for name, reason in scanned.left_out.items()]
    for line in lines:
        say(line)
    for note in scanned.notes:
        say(note, "yellow")


def plain(scanned: Scan) -> dict[str, Any]:
    """Return a scan as plain data, in SI units and radians."""
    verified = () if scanned.verified is None else scanned.verified
    return {
        "speed": scanned.speed,
        "joints": [
            {
                "joint": joint.name,
                **{name: getattr(joint, name) for name in _TOLD},
                "reversals": [item.row() for item in joint.reversals],
            }
            for joint in map(scanned.__getitem__, scanned.ranking)
        ],
        **({"verified": [item.row() for item in verified]} if verified != () else {}),
        "left_out": dict(scanned.left_out),
        "notes": list(scanned.notes),
    }


def save_figures(scanned: Scan, directory: Path) -> None:
    """Write the figures of a scan.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ArgumentError: they cannot be written.
    """
    from ... import figures

    figures.save(drawing.force_reversals(scanned), directory / "force_reversals")
    figures.save(drawing.impact_ranking(scanned), directory / "impact_ranking")
    figures.save(drawing.peak_factor(scanned), directory / "peak_factor")
    if worst := scanned.worst:
        inertial = all(item.slope_growth == 3.0 for item in worst.values())
        parameters = ("speed",) * inertial + ("slope", "clearance", "mass", "stiffness")
        figures.save(drawing.peak_influence(worst, parameters), directory / "peak_influence")
