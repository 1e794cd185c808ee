"""The command stands among the others, and lists its options without computing anything."""

from __future__ import annotations

from click.testing import CliRunner

from cardan_dyn.practice.command_line import main


def test_help_lists_the_options() -> None:
    assert "vibration" in CliRunner().invoke(main, ["--help"]).output
    found = CliRunner().invoke(main, ["vibration", "--help"])
    assert found.exit_code == 0
    for option in ("--speed", "--order", "--free", "--figures", "--chart", "--mode", "--json"):
        assert option in found.output
