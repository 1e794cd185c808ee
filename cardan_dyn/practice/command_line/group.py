"""Group: how commands end: their exit codes, errors without traceback, Ctrl-C, a closed pipe."""

from __future__ import annotations

import os
import sys
import warnings
from typing import Any

import click

from ...kit.errors import CardanError
from .options import DESCRIPTION

MISSED, FAILED, OPEN, INTERRUPTED, UNREAD = 1, 2, 3, 130, 141
"""Exit codes: a limit or check is missed; a bad file, bad usage, or no result; nothing is missed,
but nobody can tell of all; Ctrl-C; nobody reads the output any more, as of other programs that a
closed pipe ends."""
_LENIENT = "load(..., strict=False)", "--no-strict"
"""What messages advise in Python, and the option that does it here."""
EXIT_CODES = """\b
Exit codes:
  0    done
  1    done, and a limit or a check is missed
  2    a bad file, a wrong option, or no result; the message says why
  3    done, and no limit is missed, but rows of a verdict are open
  130  interrupted by Ctrl-C
"""


class Failure(click.ClickException):
    """No result: something in a file or among the options is wrong, or nothing was found."""

    exit_code = FAILED


class Interrupted(click.ClickException):
    """Ctrl-C; the message says what there is."""

    exit_code = INTERRUPTED

    def show(self, file: Any = None) -> None:
        """Print the message, on standard error."""
        click.echo(self.format_message(), file=file, err=file is None)


class Command(click.Command):
    """Takes a word instead of the three values of `--gravity`."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Take the word out before click counts values, where there is such an option."""
        has_gravity = any(option.name == "gravity" for option in self.params)
        for words in ([f"--gravity={DESCRIPTION}"], ["--gravity", DESCRIPTION]):
            for at in range(len(args)) if has_gravity else ():
                if args[at : at + len(words)] == words:
                    rest = self.parse_args(ctx, args[:at] + args[at + len(words) :])
                    ctx.params["gravity"] = DESCRIPTION
                    return rest
        return super().parse_args(ctx, args)


def end_by(missed: object) -> None:
    """End with `MISSED` if there is anything that is missed."""
    if missed:
        raise SystemExit(MISSED)


def _show_warning(message: Warning | str, *_where: object) -> None:
    """Print a warning on standard error, with options instead of arguments."""
    text = str(message).replace('gravity="description"', "--gravity description")
    click.echo(f"warning: {text.replace('gravity=(0, 0, 0)', '--gravity 0 0 0')}", err=True)


class Commands(click.Group):
    """Ends commands as `EXIT_CODES` says, without a traceback."""

    command_class = Command

    def invoke(self, ctx: click.Context) -> object:
        """Run a command; its errors become messages and exit codes."""
        try:
            with warnings.catch_warnings():
                warnings.showwarning = _show_warning  # type: ignore[assignment]
                result = super().invoke(ctx)
            sys.stdout.flush()  # Here, where a closed pipe is expected.
            return result
        except CardanError as error:
            raise Failure(str(error).replace(*_LENIENT)) from error
        except (KeyboardInterrupt, click.Abort) as error:
            raise Interrupted("interrupted") from error
        except OSError as error:
            if error.filename is not None:
                raise
            # What is still in the buffer would be written at the end of the process.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            if isinstance(error, BrokenPipeError):
                raise SystemExit(UNREAD) from None
            raise Failure(f"the output cannot be written: {error.strerror}") from error
