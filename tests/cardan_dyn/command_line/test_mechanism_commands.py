"""`cardan-dyn list`, `describe` and `check`: of bundled and other files, and what is wrong."""

from __future__ import annotations

import importlib.metadata
import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from testkit.ball_rods import as_balls
from testkit.planar_linkages import described, joint, link, loop

import cardan_dyn as cd
from cardan_dyn.drive_lines import examples
from cardan_dyn.practice.command_line import main
from cardan_dyn.practice.command_line.names import lines, mechanisms


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(item) for item in arguments], catch_exceptions=False)


def written(folder: Path, text: str) -> Path:
    path = folder / "mechanism.urdf"
    path.write_text(text, encoding="utf-8")
    return path


def triangle() -> str:
    return described(
        *(link(name) for name in "ac"),
        joint("A", "ground", "a"),
        joint("D", "ground", "c", (1.0, 0.0)),
        loop("a", "c", (0.5, 1.0), (-0.5, 1.0)),
    ).to_urdf()


def test_the_list_has_a_line_for_each(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    assert list(mechanisms()) == cd.bundled_names() and tuple(lines()) == examples()
    found = run("list").output.splitlines()
    assert len(found) == 2 + len(mechanisms()) + len(lines())
    assert max(map(len, found)) <= 80
    for name in (*mechanisms(), *lines()):
        (line,) = (line for line in found if line.split()[0] == name)
        assert len(line.split()) > 3
    told = json.loads(run("list", "--json").output)
    assert told["mechanisms"]["four_bar"] == "Four-bar linkage, a crank-rocker"
    assert set(told["drive lines"]) == set(examples())


def test_a_description_has_every_joint(tmp_path: Path) -> None:
    found = run("describe", "four_bar")
    assert found.exit_code == 0
    assert "mobility 1" in found.output and "rocker_pin" in found.output
    for path, word in ((written(tmp_path, as_balls()), "spherical"), ("stewart_platform", "loop")):
        found = run("describe", path)
        assert found.exit_code == 0 and word in found.output
        assert all(name in found.output for name in cd.load(path).joint_names)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["four_bar", "universal_joint", "slider_crank"])
def test_a_check_tells_drives_and_ranges(name: str) -> None:
    found = run("check", name)
    assert found.exit_code == 0, found.output
    assert "It can be swept" in found.output
    told = json.loads(run("check", name, "--json").output)
    drives = cd.describe(cd.load(name)).drives
    assert told["can_be_swept"] and tuple(told["default"]) == drives.default
    for item in told["drives"]:
        expected = drives[item["name"]]
        assert item["determines"] == expected.determines and item["turns"] == expected.turns
        if expected.range is not None and not expected.turns:
            assert item["range"] == pytest.approx(list(expected.range))


@pytest.mark.slow
def test_what_statics_leave_open_is_said_once_for_all_joints_alike() -> None:
    found = " ".join(run("check", "four_bar").output.split())
    assert "force z, moment xy at crank_bearing, crank_pin, rocker_bearing, rocker_pin" in found
    assert "motion and statics determine all wrenches" in run("check", "stewart_platform").output


@pytest.mark.slow
def test_ranges_are_in_degrees_and_metres() -> None:
    rocker = cd.describe(cd.load("four_bar")).drives["rocker_bearing"].range
    assert rocker is not None
    (line,) = (
        line for line in run("check", "four_bar").output.splitlines()
        if line.startswith("rocker_bearing ") and "°" in line
    )  # fmt: skip
    for end in np.rad2deg(rocker):
        assert f"{end:.4g}°" in line
    assert "-250 mm" in run("check", "stewart_platform").output


@pytest.mark.slow
def test_foreign_files_are_checked(tmp_path: Path) -> None:
    found = run("check", written(tmp_path, as_balls()))
    assert found.exit_code == 0, found.output
    assert "1 of idle rods, which need no drive" in found.output
    files = importlib.metadata.files("example-robot-data")
    assert files is not None
    panda = next(file for file in files if file.name == "panda.urdf")
    refused = run("check", panda.locate())
    assert refused.exit_code == 2 and "inertia" in refused.output
    found = run("check", panda.locate(), "--no-strict")
    assert found.exit_code == 0, found.output
    assert "warning:" in found.output and "panda_joint7" in found.output


@pytest.mark.slow
def test_what_cannot_be_swept_misses_the_check(tmp_path: Path) -> None:
    locked = run("check", written(tmp_path, triangle()))
    assert locked.exit_code == 1
    assert "It cannot be swept: nothing can move" in locked.output
    torn = (
        triangle()
        .replace('xyz="1.0 0.0 0.0"', 'xyz="9.0 0.0 0.0"')
        .replace('xyz="1.0 0 0"', 'xyz="9.0 0 0"')
    )
    assert torn != triangle()
    opened = run("check", written(tmp_path, torn))
    assert opened.exit_code == 1
    assert "cannot be closed" in " ".join(opened.output.split())
    told = json.loads(run("check", written(tmp_path, torn), "--json").output)
    assert not told["can_be_swept"] and "cannot be closed" in told["reason"]


@pytest.mark.parametrize("command", ["describe", "check"])
def test_files_that_cannot_be_read_are_no_missed_check(command: str, tmp_path: Path) -> None:
    for source in ("four_baz", tmp_path / "nothing.urdf", written(tmp_path, "<robot><link/>")):
        found = run(command, source)
        assert found.exit_code == 2
        assert found.output.startswith("Error: ") and "Traceback" not in found.output


def test_what_a_message_advises_is_an_option_of_the_command(tmp_path: Path) -> None:
    file = tmp_path / "flange.urdf"
    file.write_text(
        '<robot name="flange"><link name="base"/><link name="tool"><inertial><mass value="0"/>'
        '<inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        '<joint name="wrist" type="continuous"><parent link="base"/><child link="tool"/></joint>'
        "</robot>",
        encoding="utf-8",
    )
    refused = CliRunner().invoke(main, ["check", str(file)])
    assert refused.exit_code == 2
    assert "; --no-strict accepts it" in refused.output
    assert "strict=False" not in refused.output
    assert CliRunner().invoke(main, ["describe", str(file), "--no-strict"]).exit_code == 0
