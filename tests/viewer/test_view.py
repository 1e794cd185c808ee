"""The viewer without a browser: what a page contains, what it costs, and what it refuses."""

from __future__ import annotations

import builtins
import re
import subprocess
import sys
import urllib.request
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import cardan_dyn as cd
from cardan_dyn.command_line import commands as cli
from cardan_dyn.command_line.presets import PRESETS, default_sweep
from cardan_dyn.viewer import commands
from cardan_dyn.viewer import shapes as forms
from cardan_dyn.viewer.visuals import shapes


def run(*arguments: str):
    return CliRunner().invoke(cli.main, ["view", *arguments], catch_exceptions=False)


def test_a_720_frame_double_shaft_stays_small(shaft_turn: cd.Sweep, tmp_path: Path) -> None:
    file = cd.view(shaft_turn, frames=720).export(tmp_path / "scene.html")
    assert file.stat().st_size < 8_000_000


def test_page_loads_nothing(joint_turn: cd.Sweep) -> None:
    page = cd.view(joint_turn).html
    assert re.findall(r"<(?:script|img|iframe)[^>]*\ssrc=", page) == []
    assert re.findall(r'<link[^>]*href="(?!data:)', page) == []


def test_standing_bodies_have_no_tracks(joint_turn: cd.Sweep) -> None:
    every = len(cd.view(joint_turn, moments=False, forces=False, traces=False).html)
    bare = len(
        cd.view(
            joint_turn, moments=False, forces=False, traces=False, axes=False, labels=False
        ).html
    )
    # Three bodies turn: 721 quaternions of 4 floats and their times, in base64.
    tracks = 3 * 721 * 5 * 4 * 4 / 3
    fixed = len(commands.meshcat().script)
    assert tracks < bare - fixed < tracks + 60_000
    assert every > bare


@pytest.mark.parametrize("name", sorted(PRESETS))
def test_every_bundled_description_can_be_watched(name: str, tmp_path: Path) -> None:
    file = tmp_path / f"{name}.html"
    result = run(name, "--samples", "25", "--export", str(file))
    assert result.exit_code == 0, result.output
    assert name in file.read_text(encoding="utf-8")
    assert shapes(cd.load(name))


def test_bundled_descriptions_all_have_a_preset() -> None:
    assert set(cd.bundled_names()) <= set(PRESETS)


def test_options_of_the_command(tmp_path: Path) -> None:
    file = tmp_path / "scene.html"
    options = ("--drive", "bearing_in", "--held", "joint_angle=20", "--load", "bearing_out=-5")
    result = run("universal_joint", *options, "--joint", "bearing_out", "--export", str(file))
    assert result.exit_code == 0, result.output
    page = file.read_text(encoding="utf-8")
    assert f"greatest {5.0 / np.cos(np.deg2rad(20.0)):.4g} N·m" in page
    assert "pin_in" not in page
    for wrong, told in (
        (("--held", "joint_angle"), "JOINT=VALUE"),
        (("--held", "elbow=3"), "no joint 'elbow'"),
        (("--joint", "elbow"), "no joint 'elbow'"),
    ):
        result = run("universal_joint", *wrong, "--export", str(file))
        assert result.exit_code == 1
        assert told in result.output
    result = run("universal_joint", "--export", str(tmp_path / "none" / "scene.html"))
    assert result.exit_code == 1
    assert "cannot be written" in result.output


def test_command_prints_its_address_and_ends_with_its_process(tmp_path: Path) -> None:
    environment = {"PATH": "/usr/bin:/bin", "PYTHONUNBUFFERED": "1"}
    with subprocess.Popen(
        [
            sys.executable,
            "-c",
            "from cardan_dyn.command_line.commands import main; main()",
            "view",
            "four_bar",
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        stdin=subprocess.DEVNULL,
        text=True,
        env=environment,
    ) as process:
        line = process.stdout.readline()
        url = re.search(r"http://127\.0\.0\.1:\d+/", line).group()
        with urllib.request.urlopen(url, timeout=10) as answer:
            assert "four_bar" in answer.read().decode("utf-8")
        process.terminate()
        process.wait(timeout=10)
        process.stdout.close()
        process.stderr.close()
    with pytest.raises(OSError):
        urllib.request.urlopen(url, timeout=2)


def test_library_prints_nothing_and_hangs_nowhere(
    joint_turn: cd.Sweep, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    shown = cd.view(joint_turn)
    assert shown.url.startswith("http://127.0.0.1:")
    assert shown.open() is False
    with urllib.request.urlopen(shown.url, timeout=10) as answer:
        assert answer.read().decode("utf-8") == shown.html
    shown.close()
    assert capfd.readouterr() == ("", "")


def test_notebooks_show_it_as_it_is(joint_turn: cd.Sweep) -> None:
    element = cd.view(joint_turn)._repr_html_()
    assert element.startswith("<iframe srcdoc=")
    assert "http" not in element


def test_without_the_extra_the_install_command_is_named(
    monkeypatch: pytest.MonkeyPatch, joint_turn: cd.Sweep
) -> None:
    real = builtins.__import__

    def without(name: str, *rest: object, **more: object):
        if name.split(".")[0] == "meshcat":
            raise ImportError(name)
        return real(name, *rest, **more)

    commands.meshcat.cache_clear()
    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(cd.MissingExtraError, match=re.escape('pip install "cardan-dyn[viz]"')):
        cd.view(joint_turn)
    result = run("universal_joint")
    assert result.exit_code == 1
    assert 'pip install "cardan-dyn[viz]"' in result.output


def test_importing_the_package_loads_no_viewer() -> None:
    script = (
        "import sys, cardan_dyn\n"
        "assert not {'meshcat', 'jinja2', 'cardan_dyn.viewer'} & set(sys.modules)\n"
        "cardan_dyn.view\n"
        "assert 'meshcat' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", script], check=True)
    with pytest.raises(AttributeError, match="no attribute 'viewers'"):
        _ = cd.viewers


def test_wrong_arguments_are_refused(joint_turn: cd.Sweep) -> None:
    for wrong in ({"duration": 0.0}, {"duration": np.nan}, {"frames": 0}):
        with pytest.raises(cd.ArgumentError):
            cd.view(joint_turn, **wrong)
    with pytest.raises(cd.ArgumentError, match="sweep"):
        cd.view("universal_joint")
    with pytest.raises(cd.ModelError, match="elbow"):
        cd.view(joint_turn, joints=["elbow"])


def test_a_pruned_sweep_and_a_single_sample_are_shown() -> None:
    mechanism = cd.load("double_shaft_z")
    scene = cd.Scene(
        mechanism,
        drive="bearing_in",
        held={"joint_angle_1": 0.3, "joint_angle_2": 0.3},
        loads={"bearing_out": -1.0},
        outputs=["bearing_in"],
    )
    assert "bearing_in" in cd.view(scene.sweep([0.0, 0.5])).html
    assert "bearing_in" in cd.view(scene.sweep([0.2])).html


def test_meshes_are_shown_if_their_files_exist(tmp_path: Path) -> None:
    triangle = "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
    (tmp_path / "part.stl").write_text(triangle + "endloop\nendfacet\nendsolid t\n")
    visual = '<visual><geometry><mesh filename="{}"/></geometry></visual>'
    names = ("part.stl", "gone.stl", f"package://{tmp_path.name}/part.stl")
    text = (
        '<robot name="r"><link name="a"/><link name="b">'
        + "".join(visual.format(name) for name in names)
        + '</link><joint name="j" type="continuous"><parent link="a"/><child link="b"/>'
        '<axis xyz="0 0 1"/></joint></robot>'
    )
    file = tmp_path / "robot.urdf"
    file.write_text(text)
    mechanism = cd.load(file)
    found = shapes(mechanism)
    assert [(shape.kind, len(shape.vertices), len(shape.faces)) for shape in found] == [
        ("mesh", 3, 1),
        ("mesh", 3, 1),
    ]
    turn = cd.Scene(mechanism, drive="j", gravity=(0, 0, -9.81)).sweep([0.0, 1.0])
    assert "robot" not in cd.view(turn, title="mesh").html.split("</title>")[0]


def test_directions_are_those_asked_for_and_stay_neighbours() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 400)
    for tilt in (0.0, 0.7, np.pi / 2):
        directions = np.stack(
            [np.cos(turn), np.sin(turn) * np.cos(tilt), np.sin(turn) * np.sin(tilt)], axis=1
        )
        found = forms.towards(directions)
        x, y, z, w = found.T
        turned = np.stack(
            [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=1
        )
        np.testing.assert_allclose(turned, directions, atol=1e-14)
        neighbours = np.abs(np.sum(found[1:] * found[:-1], axis=1))
        assert np.min(neighbours) > 0.99


def test_round_scales() -> None:
    for value, expected in ((1.0, 1.0), (1.99, 1.0), (7.0, 5.0), (0.0321, 0.02), (155.6, 100.0)):
        assert forms.rounded(value) == pytest.approx(expected)
    assert len(default_sweep(cd.load("four_bar"), samples=3)) == 3
