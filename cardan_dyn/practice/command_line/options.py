"""Options that several commands have in common, as decorators of their functions.

Every option says in which unit its numbers are; with another unit behind them they are taken so,
such as `--speed 300rad/s` or `--held joint_angle=0.5rad`.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

import click
from click.shell_completion import CompletionItem

from ...kit import units
from ...kit.errors import CardanError
from . import names

DESCRIPTION = "description"
"""Stands for the three values of `--gravity`: that of the description."""
HIDDEN = ("visuals", "moments", "forces", "axes", "traces", "labels")
"""What `view` may leave out."""
Words: TypeAlias = tuple[str, ...]
"""What an option that may be given several times was given, or names."""
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


class Written(click.ParamType):  # type: ignore[type-arg, unused-ignore]
    """The path of a file or directory to be written, which is refused before all computing."""

    name = "path"

    def __init__(
        self, *, directory: bool = False, suffixes: Words = (), dash: bool = False
    ) -> None:
        """Keep what is written.

        Args:
            directory: a directory, which is made with those above it, instead of a file.
            suffixes: of the names that a file may have; any if empty.
            dash: whether `-` stands for standard output.
        """
        self._directory, self._suffixes, self._dash = directory, suffixes, dash

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> Path:
        """Return the path."""
        path = Path(str(value))
        if self._dash and str(value) == "-":
            return path
        if problem := self._problem(path):
            self.fail(f"{path}: cannot be written: {problem}", param, ctx)
        return path

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Let the shell complete paths."""
        return [CompletionItem(incomplete, type="dir" if self._directory else "file")]

    def _problem(self, path: Path) -> str:
        """Return what keeps a path from being written, as far as can be told beforehand."""
        try:
            if self._suffixes and path.suffix.lower() not in self._suffixes:
                return f"its name ends in none of {', '.join(self._suffixes)}"
            if path.exists() and path.is_dir() != self._directory:
                return "it is a directory" if path.is_dir() else "it is a file"
            if path.exists():
                return "" if os.access(path, os.W_OK) else "it may not be changed"
            above = path.parent
            while self._directory and not above.exists() and above != above.parent:
                above = above.parent
            if not above.is_dir():
                missing = "is not a directory" if above.exists() else "does not exist"
                return f"{above} {missing}"
            return "" if os.access(above, os.W_OK) else f"nothing may be written to {above}"
        except (OSError, ValueError) as error:  # Characters that no name of a file has, for one.
            return str(error)


def repeated(flag: str, name: str, metavar: str | None, text: str, **more: Any) -> Decorator:
    """Return an option that may be given several times; names of joints are completed.

    Args:
        flag: of the option, with its dashes.
        name: of the argument that gets the tuple of texts.
        metavar: form of one of them, for the help; that of its type if None.
        text: of the help, without a full stop.
        more: of `click.option`.
    """
    return click.option(
        flag,
        name,
        multiple=True,
        metavar=metavar,
        help=f"{text}; may be repeated.",
        shell_complete=names.complete_joint if "JOINT" in (metavar or "") else None,
        **more,
    )


def speed(text: str, nargs: int = 1) -> Decorator:
    """Return the option of speeds of the drive [rad/s]; `text` is its help."""
    return click.option("--speed", "speed", type=Quantity("speed", "1/min"), nargs=nargs, help=text)


def written(flag: str, name: str, text: str, *suffixes: str, dash: bool = False) -> Decorator:
    """Return an option that takes the path of a file to be written.

    Args:
        flag: of the option, with its dashes.
        name: of the argument that gets the path; None if it is not given.
        text: of the help.
        suffixes: that the file may have, in lower case; any without.
        dash: whether `-` stands for standard output.
    """
    return click.option(
        flag, name, type=Written(suffixes=suffixes, dash=dash), metavar="FILE", help=text
    )


def directory(flag: str, name: str, text: str, default: Path | None = None) -> Decorator:
    """Return an option that takes a directory to write to; arguments as of `written`."""
    return click.option(
        flag,
        name,
        type=Written(directory=True),
        metavar="DIRECTORY",
        default=default,
        show_default=default is not None,
        help=text,
    )


def flag(text: str, *names: str) -> Decorator:
    """Return an option without a value, by its names; `text` is its help."""
    return click.option(*names, is_flag=True, help=text)


def as_json(text: str) -> Decorator:
    """Return the flag that prints JSON; `text` is its help."""
    return flag(text, "--json", "as_json")


def opens(text: str) -> Decorator:
    """Return the flag by which a browser opens; `text` is its help."""
    return click.option("--open/--no-open", "open_browser", default=True, help=text)


def samples(default: int) -> Decorator:
    """Return the option of how many positions a motion is looked at."""
    return click.option(
        "--samples",
        type=click.IntRange(2),
        default=default,
        show_default=True,
        help="Count of positions.",
    )


def elements(default: bool) -> Decorator:
    """Return the flag by which springs of the description act."""
    return click.option(
        "--elements/--no-elements",
        default=default,
        help="With the springs, damping and friction that the description states for joints.",
    )


def outputs(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of what is written of a motion; they are fields of `Outputs`."""
    drawn = ".png", ".svg", ".pdf"
    for decorator in (
        written("--plot", "plot", "Draw the joints: .png, .svg or .pdf.", *drawn),
        written("--parquet", "parquet", "Write a Parquet file.", ".parquet"),
        written("--json", "json", "Write JSON; - prints it.", ".json", dash=True),
        written("--csv", "csv", "Write a CSV file; - prints it.", ".csv", dash=True),
    ):
        command = decorator(command)
    return repeated("--joint", "joints", "JOINT", "Take only this joint")(command)


def head(*names: str) -> Decorator:
    """Return the options of what stands at the head of a page."""

    def add(command: Callable[..., Any]) -> Callable[..., Any]:
        for name in reversed(names):
            text = f"At the head of the page{'; today without' * (name == 'date')}."
            command = click.option(f"--{name}", metavar="TEXT", help=text)(command)
        return command

    return add


source = click.argument(
    "source", metavar="NAME_OR_FILE", shell_complete=names.complete_source(names.mechanisms)
)
line = click.argument(
    "source",
    metavar="NAME_OR_FILE",
    required=False,
    shell_complete=names.complete_source(names.lines),
)
drive = repeated("--drive", "drive", "JOINT", "Driven joint, the sensible one without")
between = click.option(
    "--range",
    "ends",
    nargs=2,
    metavar="FROM TO",
    help="Positions of a single drive [°, slides: m]; its whole range without.",
)
rate = click.option(
    "--speed",
    metavar="VALUE",
    help="Of a single drive [1/min, slides: m/s]; quasi-static without.",
)
held = repeated("--held", "held", "JOINT=VALUE", "Joint that is held [°, slides: m]")
near = repeated(
    "--near",
    "near",
    "JOINT=VALUE",
    "Where loops are closed first [°, slides: m]; or the name of a keyframe",
)
loads = repeated(
    "--load",
    "loads",
    "JOINT=VALUE",
    'Effort on a joint [N·m, slides: N]; on a link or fixed joint, as "LINK=X Y Z", a force [N] in '
    'its axes, as "LINK=X Y Z world" in those of the world',
)
gravity = click.option(
    "--gravity",
    type=Quantity("acceleration", "m/s²"),
    nargs=3,
    metavar="X Y Z",
    help="Free fall in world axes [m/s²]; `description` instead of three values takes the file's.",
)
strict = click.option(
    "--strict/--no-strict",
    default=True,
    help="Refuse inertias that no body has, and misspelled words.",
)
figures = directory("--figures", "directory", "Directory for the figures as SVG and PNG.")
