"""Help, version and completion come at once: they load nothing that computes."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import cardan_dyn as cd
from cardan_dyn.practice.command_line import main
from cardan_dyn.practice.command_line.names import about, joints, lines, mechanisms

SCRIPT = """
import contextlib, io, json, os, sys
from cardan_dyn.practice.command_line import main
for arguments, variables in json.loads(sys.argv[1]):
    os.environ.update(variables)
    printed = io.TextIOWrapper(io.BytesIO(), "utf-8", write_through=True)
    try:
        with contextlib.redirect_stdout(printed):
            main(arguments, prog_name="cardan-dyn")
    except SystemExit as ended:
        assert not ended.code, (arguments, variables)
    for name in variables:
        del os.environ[name]
    packages = sorted({name.split(".")[0] for name in sys.modules})
    print(json.dumps([printed.buffer.getvalue().decode(), packages]))
"""
COMPUTES = {"numpy", "pinocchio", "scipy", "matplotlib", "meshcat", "rich", "yaml"}
COMPLETED = {
    "cardan-dyn vi": "vibration",
    "cardan-dyn view --hi": "--hide",
    "cardan-dyn sweep four": "four_bar",
    "cardan-dyn driveline tr": "truck",
    "cardan-dyn check some": "file",
    "cardan-dyn sweep four_bar --drive rocker": "rocker_pin",
    "cardan-dyn vibration thoma_rig --drive bear": "bearing_in",
    "cardan-dyn simulate needle_drive --held need": "needle_guide=",
}


def loaded(runs: list[tuple[list[str], dict[str, str]]]) -> list[tuple[str, set[str]]]:
    """Return what commands print, and the packages that are loaded at the end of each.

    Args:
        runs: arguments and variables of the environment, of commands that follow each other in one
            process: what one of them loads, those behind it have loaded as well.
    """
    ran = subprocess.run(
        [sys.executable, "-c", SCRIPT, json.dumps(runs)], capture_output=True, text=True, check=True
    )
    return [
        (printed, set(packages))
        for printed, packages in map(json.loads, ran.stdout.split("\n")[:-1])
    ]


def test_help_and_version_load_nothing_that_computes() -> None:
    commands = sorted(main.commands)
    runs = [[command, "--help"] for command in commands] + [["--help"], ["--version"]]
    found = loaded([(arguments, {}) for arguments in runs])
    for command, (printed, packages) in zip([*commands, "", ""], found, strict=True):
        assert f"cardan-dyn {command}".strip() in printed
        assert "click" in packages
        assert not packages & COMPUTES, command


def test_what_is_bundled_is_listed_without_what_computes() -> None:
    ((printed, packages),) = loaded([(["list"], {})])
    assert all(name in printed for name in (*mechanisms(), *lines()))
    assert not packages & (COMPUTES - {"rich"})


def test_completion_loads_nothing_that_computes() -> None:
    runs: list[tuple[list[str], dict[str, str]]] = [
        (
            [],
            {
                "_CARDAN_DYN_COMPLETE": "bash_complete",
                "COMP_WORDS": words,
                "COMP_CWORD": str(words.count(" ")),
            },
        )
        for words in COMPLETED
    ]
    for (words, found), (printed, packages) in zip(COMPLETED.items(), loaded(runs), strict=True):
        assert found in printed, words
        assert not packages & COMPUTES, words


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


def test_head_lines_of_bundled_files_say_what_they_are() -> None:
    for path in (*mechanisms().values(), *lines().values()):
        assert 10 < len(about(path)) < 150
