"""The options of `cardan-dyn vibration`; what it does is imported when it is called."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from . import options
from .group import Command
from .names import complete_joint
from .showing import export, serve


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
@options.held
@options.loads
@options.gravity
@options.speed("Range of speeds [1/min]; by the natural frequencies without.", nargs=2)
@click.option(
    "--order",
    "orders",
    type=float,
    multiple=True,
    help="Order to look at, cycles per revolution; may be repeated.",
)
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
@click.option("--open/--no-open", "open_browser", default=True, help="Open a browser to --mode.")
@options.as_json("Print the critical speeds as JSON.")
@options.strict
def vibration(
    source: str,
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
    """Find the critical speeds of a mechanism on springs.

    Resonances and instabilities, over a range of speed.

    NAME_OR_FILE is a bundled description or a file that states springs of joints, as
    elastic_thoma_rig does.
    """
    from .vibration_command import chart_of, found_speeds, mode_view, rig_scene
    from .vibration_command import run as show

    if chart is not None and directory is None:
        raise click.UsageError("--chart needs --figures")
    if file is not None and mode is None:
        raise click.UsageError("--export needs --mode")
    scene = rig_scene(source, **given)
    drawn = chart_of(scene, chart)
    found = found_speeds(scene, speed, orders)
    show(scene, found, directory, drawn, not as_json)
    if mode is not None:
        shown = mode_view(scene, mode, found.low)
        if file is not None:
            export(shown, file, aside=as_json)
        else:
            serve(shown, open_browser, aside=as_json)
