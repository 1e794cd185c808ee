"""The commands `report` and `view`: output, files, messages and exit codes."""

from __future__ import annotations

import builtins
import dataclasses
import json
import re
import subprocess
import sys
import urllib.error
import urllib.request
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from testkit.bundled import EVERY_KIND

pytest.importorskip("matplotlib", reason="the report has figures")
pytest.importorskip("meshcat", reason="the viewer needs meshcat")

import cardan_dyn as cd
from cardan_dyn.core import compiled
from cardan_dyn.practice.command_line import commands as cli
from cardan_dyn.practice.report import comparisons
from cardan_dyn.practice.viewer.commands import meshcat
from cardan_dyn.practice.viewer.viewing import View


def invoke(*arguments: str) -> Result:
    return CliRunner().invoke(cli.main, arguments, catch_exceptions=False)


def compare(*arguments: str) -> Result:
    return invoke("compare", *arguments)


def view(*arguments: str) -> Result:
    return invoke("view", *arguments)


@pytest.fixture(scope="module")
def made() -> comparisons.Comparisons:
    return comparisons.run()


@pytest.mark.slow
def test_compare_writes_table_figures_and_page(tmp_path: Path) -> None:
    result = compare("--out", str(tmp_path / "new" / "comparison"))
    assert result.exit_code == 0
    assert "universal joint" in result.output
    assert "double shaft" in result.output
    assert "Thoma (6)" in result.output
    assert "FAIL" not in result.output
    directory = tmp_path / "new" / "comparison"
    names = ["grossmann_abb_3", "grossmann_abb_4", "speed_ratio", "thoma_6_7"]
    for suffix in ("png", "svg"):
        assert sorted(path.stem for path in directory.glob(f"*.{suffix}")) == names
        assert all(path.stat().st_size > 10_000 for path in directory.glob(f"*.{suffix}"))
    page = (directory / "index.html").read_text(encoding="utf-8")
    assert page.count("data:image/svg+xml;base64,") == 4
    assert "http" not in page.replace("http-equiv", "")
    assert page.count('<td class="pass">pass</td>') == 17


@pytest.mark.slow
def test_json_is_nothing_but_json(tmp_path: Path) -> None:
    result = compare("--json", "--out", str(tmp_path))
    data = json.loads(result.stdout)
    assert data["passed"] is True
    assert len(data["comparisons"]) == 85
    assert (tmp_path / "index.html").exists()


@pytest.mark.slow
def test_a_comparison_that_falls_short_fails_the_command(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, made: comparisons.Comparisons
) -> None:
    spoiled = comparisons.Comparisons(
        [dataclasses.replace(made[0], errors={30.0: 2e-13}), *made[1:]]
    )
    monkeypatch.setattr(comparisons, "run", lambda: spoiled)
    result = compare("--out", str(tmp_path))
    assert result.exit_code == 1
    assert "FAIL" in result.output
    assert "A comparison falls short." in (tmp_path / "index.html").read_text(encoding="utf-8")
    nan = dataclasses.replace(made[0], errors={30.0: 0.0, 50.0: float("nan")})
    broken = comparisons.Comparisons([nan, *made[1:]])
    monkeypatch.setattr(comparisons, "run", lambda: broken)
    assert compare("--no-figures").exit_code == 1


@pytest.mark.slow
def test_without_matplotlib_the_install_command_is_named(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    real: Callable[..., object] = builtins.__import__

    def without(name: str, *rest: object, **more: object) -> object:
        if name.split(".")[0] == "matplotlib":
            raise ImportError(name)
        return real(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    result = compare("--out", str(tmp_path))
    assert result.exit_code == 2
    assert 'pip install "cardan-dyn[viz]"' in result.output
    assert compare("--no-figures").exit_code == 0


def test_a_directory_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("", encoding="utf-8")
    result = compare("--out", str(tmp_path / "taken" / "comparison"))
    assert result.exit_code == 2
    assert "cannot be written" in result.output


@pytest.mark.parametrize("name", EVERY_KIND)
def test_bundled_descriptions_can_be_watched(name: str, tmp_path: Path) -> None:
    file = tmp_path / f"{name}.html"
    result = view(name, "--samples", "25", "--export", str(file))
    assert result.exit_code == 0, result.output
    assert name in file.read_text(encoding="utf-8")


def test_options_of_view(tmp_path: Path) -> None:
    file = tmp_path / "scene.html"
    options = ("--drive", "bearing_in", "--held", "joint_angle=20", "--load", "bearing_out=-5")
    result = view("universal_joint", *options, "--joint", "bearing_out", "--export", str(file))
    assert result.exit_code == 0, result.output
    page = file.read_text(encoding="utf-8")
    # The longest arrow is as long whatever the moments are.
    (scale,) = re.findall(r'"kind": "moment"[^}]*"per_metre": ([0-9.]+)', page)
    lighter = tmp_path / "lighter.html"
    half = (*options[:-1], "bearing_out=-2.5", "--joint", "bearing_out", "--export", str(lighter))
    assert view("universal_joint", *half).exit_code == 0
    (other,) = re.findall(
        r'"kind": "moment"[^}]*"per_metre": ([0-9.]+)', lighter.read_text(encoding="utf-8")
    )
    assert float(scale) == pytest.approx(2.0 * float(other))
    assert "pin_in" not in page
    for wrong, message in (
        (("--held", "joint_angle"), "JOINT=VALUE"),
        (("--held", "elbow=3"), "no joint 'elbow'"),
        (("--joint", "elbow"), "no joint 'elbow'"),
    ):
        result = view("universal_joint", *wrong, "--export", str(file))
        assert result.exit_code == 2
        assert message in result.output
    result = view("universal_joint", "--export", str(tmp_path / "none" / "scene.html"))
    assert result.exit_code == 2
    assert "cannot be written" in result.output


@pytest.mark.slow
def test_command_prints_its_address_and_ends_with_its_process(tmp_path: Path) -> None:
    environment = {"PATH": "/usr/bin:/bin", "PYTHONUNBUFFERED": "1"}
    with subprocess.Popen(
        [
            sys.executable,
            "-c",
            "from cardan_dyn.practice.command_line.commands import main; main()",
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


def test_version_and_help() -> None:
    version, functions = invoke("--version").output.splitlines()
    assert version == f"cardan-dyn, version {cd.__version__}"
    assert functions.startswith("compiled functions: " + ("yes" if compiled.kernel else "no, "))
    shown = invoke("-h").output
    assert "compare" in shown and "view" in shown
    assert "Joint wrenches of closed-chain mechanisms" in shown


def test_printed_table_has_a_line_per_quantity(
    monkeypatch: pytest.MonkeyPatch, made: comparisons.Comparisons, tmp_path: Path
) -> None:
    monkeypatch.setattr(comparisons, "run", lambda: made)
    monkeypatch.setenv("COLUMNS", "160")
    monkeypatch.chdir(tmp_path)
    result = compare("--no-figures")
    assert result.exit_code == 0
    for row in made:
        (line,) = (
            line
            for line in result.output.splitlines()
            if row.quantity in line and f" {row.worst:.1e} " in line and row.source in line
        )
        assert line.rstrip().endswith("pass")
    assert list(tmp_path.iterdir()) == []


def test_json_goes_to_the_output_and_paths_beside_it(
    monkeypatch: pytest.MonkeyPatch, made: comparisons.Comparisons, tmp_path: Path
) -> None:
    from cardan_dyn.practice.report import report as reporting

    monkeypatch.setattr(comparisons, "run", lambda: made)
    monkeypatch.setattr(reporting, "write", lambda compared, directory: directory / "page")
    result = compare("--json", "--out", str(tmp_path))
    assert json.loads(result.stdout) == reporting.plain(made)
    assert "φ₂" in result.stdout  # Symbols stay legible.
    assert result.stderr == f"Figures and page: {tmp_path / 'page'}\n"


def test_errors_of_the_package_are_messages() -> None:
    for arguments, message in (
        (("no_such_mechanism",), "no_such_mechanism"),
        (("four_bar", "--samples", "1"), "1 is not in the range x>=2"),
        (("four_bar", "--hide", "shadows"), "'shadows' is not one of"),
        (("four_bar", "--load", "=3"), "--load '=3' is not JOINT=VALUE"),
        (("four_bar", "--duration", "0"), "duration is 0, expected a positive number"),
    ):
        result = view(*arguments)
        assert result.exit_code in (1, 2)
        assert result.output.splitlines()[-1].startswith("Error: ")
        assert message in result.output


def test_hidden_parts_are_not_in_the_page(tmp_path: Path) -> None:
    kinds = ("visuals", "moments", "forces", "axes", "traces", "labels")
    pages = {}
    for shown in ("nothing", "visuals", "labels"):
        file = tmp_path / f"{shown}.html"
        hidden = [word for kind in kinds if kind != shown for word in ("--hide", kind)]
        result = view("four_bar", "--samples", "3", *hidden, "--export", str(file))
        assert result.exit_code == 0 and result.stdout == f"Scene: {file}\n"
        pages[shown] = file.read_text(encoding="utf-8")
    # Links whose visuals are hidden are made up from their joints, with bearings.
    assert '"/mechanism/crank"' in pages["visuals"]
    assert "/bearings/" not in pages["visuals"] and "/bearings/" in pages["nothing"]
    assert "/labels/crank_bearing" in pages["labels"]
    assert "/labels/crank_bearing" not in pages["visuals"] + pages["nothing"]


def test_inconsistent_inertias_are_shown_if_asked_for(tmp_path: Path) -> None:
    """A link without mass, but with a moment of inertia."""
    file = tmp_path / "odd.urdf"
    file.write_text(
        '<robot name="odd"><link name="a"/><link name="b"><inertial><mass value="0"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        '<joint name="j" type="continuous"><parent link="a"/><child link="b"/>'
        '<axis xyz="0 0 1"/></joint></robot>',
        encoding="utf-8",
    )
    arguments = (str(file), "--drive", "j", "--samples", "3", "--export", str(tmp_path / "o.html"))
    refused = view(*arguments)
    assert refused.exit_code == 2 and "inertia" in refused.output
    assert view(*arguments, "--no-strict").exit_code == 0


@pytest.mark.slow
@pytest.mark.parametrize("browser", [True, False])
def test_serving_tells_its_address_and_ends_with_ctrl_c(
    browser: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[str] = []

    def serve(shown: View) -> None:
        calls.append("serve")
        raise KeyboardInterrupt

    def opened(shown: View) -> bool:
        calls.append("open")
        return browser

    monkeypatch.setattr(View, "open", opened)
    monkeypatch.setattr(View, "serve", serve)
    result = view("four_bar", "--samples", "3")
    assert result.exit_code == 0 and calls == ["open", "serve"]
    assert re.fullmatch(r"Scene: http://127\.0\.0\.1:\d+/ \(Ctrl-C ends it\)\n", result.stdout)
    assert ("No browser has opened it here" in result.stderr) is not browser
    url = result.stdout.split()[1]
    with pytest.raises(urllib.error.URLError):
        urllib.request.urlopen(url, timeout=2)
    calls.clear()
    assert view("four_bar", "--samples", "3", "--no-open").exit_code == 0
    assert calls == ["serve"]


def test_without_meshcat_the_install_command_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    real: Callable[..., object] = builtins.__import__

    def without(name: str, *rest: object, **more: object) -> object:
        if name.split(".")[0] == "meshcat":
            raise ImportError(name)
        return real(name, *rest, **more)

    meshcat.cache_clear()
    monkeypatch.setattr(builtins, "__import__", without)
    result = view("universal_joint")
    assert result.exit_code == 2
    assert 'pip install "cardan-dyn[viz]"' in result.output


def test_a_speed_of_what_swings_is_refused(tmp_path: Path) -> None:
    """A speed that nothing takes would leave the inertia out without a word."""
    words = ("four_bar", "--drive", "rocker_bearing", "--speed", "100rpm")
    result = view(*words, "--export", str(tmp_path / "a.html"))
    assert result.exit_code == 2 and "--speed is of a drive that turns" in result.output
