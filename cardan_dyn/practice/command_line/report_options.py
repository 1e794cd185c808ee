"""The options of `cardan-dyn report`; what it does is imported when it is called."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from . import options
from .group import Command


@click.command(cls=Command)
@options.source
@options.written("--out", "file", "The page; NAME_report.html without.", ".html", ".csv", ".json")
@options.drive
@options.between
@options.rate
@options.near
@options.held
@options.loads
@options.gravity
@options.elements(False)
@options.samples(721)
@click.option("--scene/--no-scene", default=True, help="Put the moving scene on the page.")
@options.head("title", "project", "author", "date", "revision")
@options.strict
def report(source: str, file: Path | None, scene: bool, **given: Any) -> None:
    """Report on a mechanism: the page that is filed.

    NAME_OR_FILE is a bundled description or a URDF, MJCF or SDF file. Prints the greatest and least
    wrenches of every joint, located between the samples, and writes a page with all of it: the
    description, mobility and drives, figures, orders, the moving scene, residuals, versions. A name
    that ends in .csv or .json takes the extremes alone.

    Several values with commas between them, as --speed 500,1000 --load JOINT=-5,-10, are load
    cases: each speed with each load, side by side in one report.
    """
    from .report_command import run

    run(source, file, with_scene=scene, **given)
