"""The command stands among the others, and lists its options without computing anything."""

from __future__ import annotations

import subprocess
import sys

from click.testing import CliRunner

from cardan_dyn.command_line import main


def test_help_lists_the_options() -> None:
    assert "vibration" in CliRunner().invoke(main, ["--help"]).output
    found = CliRunner().invoke(main, ["vibration", "--help"])
    assert found.exit_code == 0
    for option in ("--speed-rpm", "--order", "--free", "--figures", "--chart", "--mode", "--json"):
        assert option in found.output


def test_options_load_nothing_that_computes() -> None:
    code = (
        "import sys; import cardan_dyn.command_line; "
        "sys.exit(any(name.startswith('cardan_dyn.vibration') for name in sys.modules))"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
