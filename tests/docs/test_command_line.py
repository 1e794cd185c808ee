"""The page on the command line lists what there is."""

from __future__ import annotations

import re
from pathlib import Path

import click
from click.shell_completion import get_completion_class

from cardan_dyn.practice.command_line.commands import main

PAGE = (Path(__file__).parents[2] / "docs" / "command_line.md").read_text(encoding="utf-8")


def test_every_command_is_on_the_page() -> None:
    told = re.findall(r"^\| `cardan-dyn (\w+)", PAGE, flags=re.MULTILINE)
    assert isinstance(main, click.Group)
    assert sorted(told) == sorted(main.list_commands(click.Context(main)))


def test_the_shells_of_the_page_are_completed() -> None:
    shells = set(re.findall(r"(\w+)_source", PAGE))
    assert shells == {"bash", "zsh", "fish"}
    for name in shells:
        assert get_completion_class(name) is not None, name
