"""How commands end: exit codes, Ctrl-C, pipes that are closed, in processes of their own."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

import cardan_dyn as cd
from cardan_dyn.practice.command_line import main
from cardan_dyn.practice.command_line.group import Commands

COMMAND = [sys.executable, "-c", "from cardan_dyn.practice.command_line import main; main()"]


@click.group(cls=Commands)
def group() -> None:
    """Commands that end in every way."""


@group.command()
def missed() -> None:
    raise SystemExit(1)


@group.command()
def wrong() -> None:
    raise cd.ModelError("no such file")


@group.command()
def interrupted() -> None:
    raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("command", "code", "said"),
    [
        ("missed", 1, ""),
        ("wrong", 2, "Error: no such file\n"),
        ("interrupted", 130, "interrupted\n"),
        ("nonsense", 2, "No such command"),
    ],
)
def test_exit_codes(command: str, code: int, said: str) -> None:
    found = CliRunner().invoke(group, [command])
    assert found.exit_code == code
    assert said in found.output and "Traceback" not in found.output


def test_help_says_exit_codes() -> None:
    shown = CliRunner().invoke(main, ["--help"]).output
    for line in ("1    done, and a limit or a check is missed", "130  interrupted by Ctrl-C"):
        assert line in shown


@pytest.mark.slow
def test_a_missed_limit_is_told_from_a_bad_file(tmp_path: Path) -> None:
    limit = ("driveline", "truck", "--check", "--limit", "residual_angle=0.001deg")
    assert CliRunner().invoke(main, limit).exit_code == 1
    assert CliRunner().invoke(main, ["driveline", str(tmp_path / "no.toml")]).exit_code == 2
    bare = CliRunner().invoke(main, ["driveline", "truck", "--limit", "residual_angle=3"])
    assert bare.exit_code == 2 and "no unit" in bare.output


@pytest.mark.slow
@pytest.mark.parametrize(
    "arguments", [("list",), ("check", "four_bar"), ("sweep", "four_bar", "--csv", "-")]
)
def test_a_closed_pipe_ends_quietly(arguments: tuple[str, ...]) -> None:
    read, write = os.pipe()
    os.close(read)  # Nobody will ever read.
    with os.fdopen(write, "w") as nowhere:
        ended = subprocess.run(
            [*COMMAND, *arguments], stdout=nowhere, stderr=subprocess.PIPE, text=True, check=False
        )
    assert ended.returncode == 141
    assert ended.stderr == ""


@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is full")
@pytest.mark.parametrize("arguments", [("list",), ("sweep", "four_bar", "--csv", "-")])
def test_a_full_disk_behind_the_output_is_no_missed_limit(arguments: tuple[str, ...]) -> None:
    with Path("/dev/full").open("w", encoding="utf-8") as full:
        ended = subprocess.run(
            [*COMMAND, *arguments], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert ended.returncode == 2
    assert ended.stderr.splitlines()[-1].startswith("Error: the output cannot be written: ")
    assert "Traceback" not in ended.stderr


@pytest.mark.slow
def test_ctrl_c_ends_in_one_line(tmp_path: Path) -> None:
    file = tmp_path / "out.csv"
    rig = ("simulate", "elastic_thoma_rig", "--drive", "bearing_in=1000rpm", "--rtol", "1e-13")
    arguments = (*rig, "--time", "1h", "--joint", "tilt_z")
    with subprocess.Popen(
        [*COMMAND, *arguments, "--csv", str(file)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # Tests in the background of a shell ignore Ctrl-C, and so would what they start.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    ) as process:
        time.sleep(2.5)  # It is among its steps, or still loads.
        process.send_signal(signal.SIGINT)
        try:
            printed, said = process.communicate(timeout=120)
        finally:
            process.kill()
    assert process.returncode == 130, said
    assert "Traceback" not in said and "interrupted" in said
    assert file.exists() == bool(printed)
