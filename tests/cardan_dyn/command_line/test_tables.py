"""Tables at any width: no word is broken, none lost, and nothing is wider than the terminal."""

from __future__ import annotations

from functools import cache

import pytest
from click.testing import CliRunner
from rich.cells import cell_len

from cardan_dyn.practice.command_line import main
from cardan_dyn.practice.command_line.tables import show

HEADINGS = ("joint", "force\nN", "ends at")
ROWS = [
    "first",
    ("crank_bearing", "12345.6", "a dead point far away"),
    ("rocker_pin", "7", "its limit"),
]


@pytest.mark.parametrize("width", [20, 26, 32, 40, 60, 80])
def test_words_stay_whole(
    width: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", str(width))
    show(HEADINGS, ROWS, title="title", caption="caption", texts=(0, 2))
    printed = capsys.readouterr().out
    words = {word for row in ROWS[1:] for cell in row for word in cell.split()}
    assert words <= set(printed.split())
    assert all(cell_len(line) <= width for line in printed.splitlines())


def test_a_row_is_a_line_where_there_is_room(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    show(HEADINGS, ROWS, texts=(0, 2))
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[:2] for line in lines[-2:]] == [
        ["crank_bearing", "12345.6"], ["rocker_pin", "7"]
    ]  # fmt: skip


@cache
def told(arguments: tuple[str, ...]) -> frozenset[str]:
    """Return all words that a command prints where there is room."""
    return frozenset(CliRunner(env={"COLUMNS": "400"}).invoke(main, arguments).output.split())


@pytest.mark.slow
@pytest.mark.parametrize("width", [60, 80])
@pytest.mark.parametrize(
    "arguments",
    [
        ("check", "four_bar"),
        ("describe", "universal_joint"),
        ("sweep", "four_bar", "--samples", "9"),
        ("driveline", "truck"),
        ("clearance", "needle_drive", "--speed", "3000", "--clearance", "0.1mm", "--stiffness",
         "1e8"),
    ],
)  # fmt: skip
def test_commands_fit_the_terminal(
    arguments: tuple[str, ...], width: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", str(width))
    found = CliRunner().invoke(main, arguments)
    assert found.exit_code == 0, found.output
    assert max(map(cell_len, found.output.splitlines())) <= width
    # Whatever is a word of a wide table is one of the narrow table as well; records need no heading
    # for what they begin with.
    shown = set(found.output.split())
    broken = {word for word in told(arguments) - shown if not set(word) <= set("─")}
    broken -= {"quantity,", "where,", "at", "joint"}
    assert not broken
