"""Options that several commands have in common, as decorators of their functions.

Every option says in which unit its numbers are; with another unit behind them they are taken so,
such as `--speed-rpm 300rad/s` or `--held joint_angle=0.5rad`.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

import click

from .. import units
from ..errors import CardanError

Decorator: TypeAlias = Callable[[Callable[..., Any]], Callable[..., Any]]


class Quantity(click.ParamType):  # type: ignore[type-arg, unused-ignore]
    """A number in the unit that the option says, or with another one behind it."""

    name = "value"

    def __init__(self, dimension: str, bare: str) -> None:
        """Keep what is read.

        Args:
            dimension: a key of `units.DIMENSIONS`.
            bare: spelling of the unit of a number without one; the help of the option says it.
        """
        self._dimension, self._bare = dimension, bare

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Return a text in SI units; a default is one already."""
        if isinstance(value, float):
            return value
        at = "the value" if param is None else param.opts[0]
        try:
            return units.read(str(value), self._dimension, at, self._bare)
        except CardanError as error:
            self.fail(str(error), param, ctx)


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


def speed(text: str, nargs: int = 1) -> Decorator:
    """Return the option of speeds of the drive [rad/s]; `text` is its help."""
    return click.option(
        "--speed-rpm", "speed", type=Quantity("speed", "rpm"), nargs=nargs, help=text
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
held = repeated("--held", "held", "JOINT=VALUE", "Joint that is held [°, slides: m]")
loads = repeated("--load", "loads", "JOINT=VALUE", "Effort on a joint [N·m, slides: N]")
gravity = click.option(
    "--gravity",
    type=Quantity("acceleration", "m/s²"),
    nargs=3,
    metavar="X Y Z",
    help="Free fall in world axes [m/s²].",
)
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
