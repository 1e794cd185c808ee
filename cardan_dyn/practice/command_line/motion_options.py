"""The options of `cardan-dyn sweep` and `simulate`; what they do is imported when it is called."""

from __future__ import annotations

from typing import Any

import click

from . import options
from .group import Command


@click.command(cls=Command)
@options.source
@options.drive
@options.between
@options.samples(361)
@options.rate
@click.option("--acceleration", metavar="VALUE", help="Of the drive [rad/s², slides: m/s²].")
@options.near
@options.held
@options.loads
@options.gravity
@options.outputs
@options.strict
def sweep(source: str, **given: Any) -> None:
    """Sweep the drive: forces and moments of all joints.

    NAME_OR_FILE is a bundled description or a URDF, MJCF or SDF file. Prints the greatest values of
    every joint and where they occur, of what the parent exerts on the child.
    """
    from .motion_command import sweep_of

    sweep_of(source, **given)


@click.command(cls=Command)
@options.source
@click.option(
    "--time", "duration", type=options.Quantity("time", "s"), required=True, help="Duration [s]."
)
@options.repeated("--free", "free", "JOINT", "Joint whose motion is found, a sensible one without")
@options.repeated(
    "--drive", "drive", "JOINT=SPEED", "Joint that is driven at constant speed [1/min, slides: m/s]"
)
@options.repeated("--at", "positions", "JOINT=VALUE", "Position at the start [°, slides: m]")
@options.repeated(
    "--initial", "speeds", "JOINT=SPEED", "Speed of a free joint at the start [1/min, slides: m/s]"
)
@options.near
@options.held
@options.loads
@options.gravity
@options.elements(True)
@click.option(
    "--rtol",
    type=float,
    default=1e-10,
    show_default=True,
    help="Relative tolerance of steps, a number.",
)
@options.outputs
@options.strict
def simulate(source: str, **given: Any) -> None:
    """Simulate how free joints move: forces and moments.

    NAME_OR_FILE is a bundled description or a URDF, MJCF or SDF file. Ctrl-C ends the simulation;
    what was found so far is printed and written.
    """
    from .motion_command import simulation_of

    simulation_of(source, **given)
