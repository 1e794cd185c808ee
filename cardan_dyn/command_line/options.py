"""Options that several commands have in common, as decorators of their functions."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

import click

Decorator: TypeAlias = Callable[[Callable[..., Any]], Callable[..., Any]]


def repeated(flag: str, name: str, metavar: str, text: str) -> Decorator:
    """Return an option that may be given several times.

    Args:
        flag: of the option, with its dashes.
        name: of the argument that gets the tuple of texts.
        metavar: form of one of them, for the help.
        text: of the help, without a full stop.
    """
    return click.option(
        flag, name, multiple=True, metavar=metavar, help=f"{text}; may be repeated."
    )


def written(flag: str, name: str, text: str) -> Decorator:
    """Return an option that takes the path of a file to be written.

    Args:
        flag: of the option, with its dashes.
        name: of the argument that gets the path; None if it is not given.
        text: of the help.
    """
    return click.option(flag, name, type=click.Path(dir_okay=False, path_type=Path), help=text)


source = click.argument("source", metavar="NAME_OR_FILE")
held = repeated("--held", "held", "JOINT=VALUE", "Joint that is held, in degrees (slides: metres)")
loads = repeated("--load", "loads", "JOINT=VALUE", "Effort on a joint [N·m, slides: N]")
gravity = click.option("--gravity", type=float, nargs=3, help="Free fall in world axes [m/s²].")
strict = click.option(
    "--strict/--no-strict",
    default=True,
    help="Refuse inertias that no body has, and misspelled words.",
)
figures = click.option(
    "--figures",
    "directory",
    type=click.Path(file_okay=False, path_type=Path),
    help="Directory for the figures as SVG and PNG.",
)
