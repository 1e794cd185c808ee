"""Help, version and completion come at once: they load nothing that computes."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import cardan_dyn as cd
from cardan_dyn.practice.command_line import main
from cardan_dyn.practice.command_line.names import about, joints, limits, lines, mechanisms
from cardan_dyn.practice.drive_lines.verdict.case import KNOWN

SCRIPT = """
import sys
from cardan_dyn.practice.command_line import main
try:
    main(prog_name="cardan-dyn")
finally:
    print(*sorted({name.split(".")[0] for name in sys.modules}), file=sys.stderr)
"""
COMPUTES = {"numpy", "pinocchio", "scipy", "matplotlib", "meshcat", "rich", "yaml"}


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


def test_what_is_bundled_is_listed_without_what_computes() -> None:
    printed, packages = loaded("list")
    assert all(name in printed for name in (*mechanisms(), *lines()))
    assert not packages & (COMPUTES - {"rich"})


@pytest.mark.parametrize("option", ["--help", "--version"])
def test_help_and_version_load_nothing_that_computes(option: str) -> None:
    printed, packages = loaded(option)
    assert "cardan-dyn" in printed
    assert not packages & COMPUTES


@pytest.mark.parametrize(
    ("words", "found"),
    [
        ("cardan-dyn vi", "vibration"),
        ("cardan-dyn view --hi", "--hide"),
        ("cardan-dyn sweep four", "four_bar"),
        ("cardan-dyn driveline tr", "truck"),
        ("cardan-dyn check some", "file"),
        ("cardan-dyn sweep four_bar --drive rocker", "rocker_pin"),
        ("cardan-dyn vibration thoma_rig --drive bear", "bearing_in"),
        ("cardan-dyn simulate needle_drive --held need", "needle_guide="),
        ("cardan-dyn driveline truck --limit resid", "residual_angle="),
    ],
)
def test_completion_loads_nothing_that_computes(words: str, found: str) -> None:
    printed, packages = loaded(
        _CARDAN_DYN_COMPLETE="bash_complete",
        COMP_WORDS=words,
        COMP_CWORD=str(words.count(" ")),
    )
    assert found in printed
    assert not packages & COMPUTES


def test_joints_of_other_files_are_completed_in_all_notations(tmp_path: Path) -> None:
    path = tmp_path / "robot.xml"
    path.write_text(
        '<mujoco><worldbody><body><joint type="hinge" name="elbow"/></body></worldbody></mujoco>',
        encoding="utf-8",
    )
    assert joints(str(path)) == ["elbow"]
    assert joints(str(tmp_path)) == joints("nothing") == []
    for name in mechanisms():
        assert set(cd.load(name).joint_names) <= set(joints(name))


def test_limits_that_are_completed_are_those_that_there_are() -> None:
    assert set(limits()) == set(KNOWN)


def test_head_lines_of_bundled_files_say_what_they_are() -> None:
    for path in (*mechanisms().values(), *lines().values()):
        assert 10 < len(about(path)) < 150
