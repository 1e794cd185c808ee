"""Options that several commands have in common: the same words and the same kinds of values."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import pytest
from click.testing import CliRunner

from cardan_dyn.practice.command_line import main, options


@click.command()
@options.source
@options.held
@options.loads
@options.gravity
@options.strict
@options.figures
@options.written("--page", "page", "One page.")
def echo(**given: Any) -> None:
    click.echo(repr(dict(sorted(given.items()))))


def test_values_come_as_texts_numbers_and_paths(tmp_path: Path) -> None:
    given = ("a.urdf", "--held", "a=1", "--held", "b=2", "--gravity", "0", "0", "-9.81")
    found = CliRunner().invoke(echo, [*given, "--no-strict", "--figures", str(tmp_path)])
    assert found.exit_code == 0, found.output
    assert "'held': ('a=1', 'b=2'), 'loads': (), 'page': None" in found.output
    assert f"'directory': {tmp_path!r}, 'gravity': (0.0, 0.0, -9.81)" in found.output
    assert "'source': 'a.urdf', 'strict': False" in found.output


def test_files_are_no_directories_and_the_other_way_round(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("", encoding="utf-8")
    for flag, path in (("--page", tmp_path), ("--figures", file)):
        found = CliRunner().invoke(echo, ["a.urdf", flag, str(path)])
        assert found.exit_code == 2
        assert flag in found.output


@pytest.mark.parametrize("command", ["view", "clearance", "vibration"])
def test_commands_say_the_same_of_them(command: str) -> None:
    words = CliRunner().invoke(echo, ["--help"]).output.split()
    shown = " ".join(CliRunner().invoke(main, [command, "--help"]).output.split())
    start, end = words.index("--held"), words.index("--gravity")
    assert " ".join(words[start:end]) in shown
