"""Help, version and completion come at once: they load nothing that computes."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from cardan_dyn.command_line import main

SCRIPT = """
import sys
from cardan_dyn.command_line import main
try:
    main(prog_name="cardan-dyn")
finally:
    print(*sorted({name.split(".")[0] for name in sys.modules}), file=sys.stderr)
"""
COMPUTES = {"analytic", "numpy", "pinocchio", "scipy", "matplotlib", "meshcat", "rich", "yaml"}


def loaded(*arguments: str, **variables: str) -> tuple[str, set[str]]:
    """Return what a command prints, and the packages that are loaded at its end."""
    ran = subprocess.run(
        [sys.executable, "-c", SCRIPT, *arguments],
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        check=True,
    )
    return ran.stdout, set(ran.stderr.split())


@pytest.mark.parametrize("command", sorted(main.commands))
def test_help_of_a_command_loads_nothing_that_computes(command: str) -> None:
    printed, packages = loaded(command, "--help")
    assert f"cardan-dyn {command}" in printed
    assert "click" in packages
    assert not packages & COMPUTES


@pytest.mark.parametrize("option", ["--help", "--version"])
def test_help_and_version_load_nothing_that_computes(option: str) -> None:
    printed, packages = loaded(option)
    assert "cardan-dyn" in printed
    assert not packages & COMPUTES


@pytest.mark.parametrize(
    ("words", "found"), [("cardan-dyn vi", "vibration"), ("cardan-dyn view --hi", "--hide")]
)
def test_completion_loads_nothing_that_computes(words: str, found: str) -> None:
    printed, packages = loaded(
        _CARDAN_DYN_COMPLETE="bash_complete",
        COMP_WORDS=words,
        COMP_CWORD=str(words.count(" ")),
    )
    assert found in printed
    assert not packages & COMPUTES
