"""The options of `cardan-dyn vibration`; what it does is imported when it is called."""

from __future__ import annotations

from typing import Any

import click

from . import options
from .group import Command
from .names import complete_joint


@click.command(cls=Command)
@options.source
@click.option(
    "--drive",
    metavar="JOINT",
    help="Joint that turns at constant speed.",
    shell_complete=complete_joint,
)
@options.repeated(
    "--free", "free", "JOINT", "Free coordinate, those with springs in the description without"
)
@options.near
@options.held
@options.loads
@options.gravity
@options.speed("Range of speeds [1/min]; by the natural frequencies without.", nargs=2)
@options.repeated("--order", "orders", None, "Order to look at, cycles per revolution", type=float)
@options.figures
@click.option(
    "--chart",
    metavar="JOINT=VALUE",
    shell_complete=complete_joint,
    help="With --figures: a chart of stability up to this position of a held joint [°, slides: m].",
)
@click.option(
    "--mode", type=click.IntRange(1), help="Watch the mode of this number, larger than life."
)
@options.written("--export", "file", "With --mode: write it as one HTML file instead.")
@options.opens("Open a browser to --mode.")
@options.as_json("Print the critical speeds as JSON.")
@options.strict
def vibration(source: str, **given: Any) -> None:
    """Find the critical speeds of a mechanism on springs.

    Resonances and instabilities, over a range of speed.

    NAME_OR_FILE is a bundled description or a file that states springs of joints, as
    elastic_thoma_rig does.
    """
    from .vibration_command import run

    run(source, **given)
