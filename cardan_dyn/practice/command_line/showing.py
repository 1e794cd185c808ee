"""Showing: what commands do with a scene that they made, write it or serve it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from ..viewer.viewing import View


def export(shown: View, file: Path, *, aside: bool = False) -> None:
    """Write a scene as one HTML file.

    Args:
        shown: the scene.
        file: where to.
        aside: say so on standard error, where data are printed.

    Raises:
        ArgumentError: it cannot be written.
    """
    click.echo(f"Scene: {shown.export(file)}", err=aside)


def serve(shown: View, open_browser: bool, *, aside: bool = False) -> None:
    """Serve a scene until Ctrl-C; see `export`."""
    click.echo(f"Scene: {shown.url} (Ctrl-C ends it)", err=aside)
    if open_browser and not shown.open():
        click.echo("No browser has opened it here: open the address, or --export a file.", err=True)
    try:
        shown.serve()
    except KeyboardInterrupt:
        shown.close()


def present(shown: View, file: Path | None, open_browser: bool, *, aside: bool = False) -> None:
    """Write a scene where there is a file for it, else serve it; see `export`."""
    if file is not None:
        export(shown, file, aside=aside)
    else:
        serve(shown, open_browser, aside=aside)
