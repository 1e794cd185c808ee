"""The command `report`: what it prints and writes, and how wrong options end."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

import cardan_dyn as cd
from cardan_dyn.practice.command_line.commands import main


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, ["report", *map(str, arguments)])


def test_numbers_are_printed_and_saved(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    file = tmp_path / "extremes.csv"
    found = run("four_bar", "--range", "90", "3.0rad", "--samples", 40, "--out", file)
    assert found.exit_code == 0, found.output
    assert "As asked: crank_bearing from 90° to 171.9°." in found.output
    assert "\nnot determined by statics" in found.output
    frame = pandas.read_csv(file)
    row = frame[(frame.owner == "rocker_pin") & (frame.quantity == "shear")].iloc[0]
    told = f"rocker_pin shear N {row.greatest:.4g} 171.9°"
    assert told in " ".join(found.output.split())


def test_another_assembly_is_reported_where_it_is_named(tmp_path: Path) -> None:
    """Of the crossed four-bar, as a scene near it has it."""
    file = tmp_path / "extremes.json"
    acting = ("--load", "rocker_bearing=-5", "--speed", 60, "--samples", 91, "--out", file)
    told = {}
    for near in (("crank_pin=0",), ("crank_pin=-74", "rocker_bearing=147")):
        chosen = [word for item in near for word in ("--near", item)]
        found = run("four_bar", *chosen, *acting)
        assert found.exit_code == 0, found.output
        table = json.loads(file.read_text("utf-8"))["columns"]
        columns = (table[name] for name in ("owner", "quantity", "greatest"))
        told[len(near)] = {(owner, what): most for owner, what, most in zip(*columns, strict=True)}
    assert told[1] != told[2]
    scene = cd.Scene(
        cd.load("four_bar"),
        drive="crank_bearing",
        near={"crank_pin": -1.29, "rocker_bearing": 2.57},
        loads={"rocker_bearing": -5.0},
    )
    report = cd.Report(scene.sweep(np.linspace(0.0, 2.0 * np.pi, 91), speed=2.0 * np.pi))
    assert told[2] == pytest.approx(
        {(item.owner, item.quantity): item.greatest for item in report.extremes}, rel=1e-6
    )


@pytest.mark.slow
def test_page_has_what_was_given(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("matplotlib", reason="the page has figures")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("cardan_dyn.practice.report.page.image", lambda figure: "data:,")
    head = ("--project", "P 7", "--author", "A. B.", "--date", "2026-02-03", "--revision", "C")
    case = ("--speed", "600rpm", "--gravity", 0, 0, -9.81, "--load", "rocker_bearing=-5")
    found = run("four_bar", "--no-scene", "--samples", 91, *head, *case)
    assert found.exit_code == 0, found.output
    text = (tmp_path / "four_bar_report.html").read_text("utf-8")
    for part in ("P 7", "A. B.", "2026-02-03", "600 1/min", "(0, 0, −9.81) m/s²", "−5 N·m"):
        assert part in text
    assert "<iframe" not in text


def test_slides_are_in_metres(tmp_path: Path) -> None:
    found = run(
        *("slider_crank", "--drive", "piston_guide", "--out", tmp_path / "x.csv"),
        *("--range", "-0.02", "-5mm", "--speed", "2"),
    )
    assert found.exit_code == 2 and "dead point" in found.output


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("four_bar", "--range", "3", "1"), "from 3° to 1° is empty"),
        (("four_bar", "--range", "1m", "2m"), "unit"),
        (("four_bar", "--drive", "crank"), "crank"),
        (("four_bar", "--out", "/nowhere/x.html"), "/nowhere"),
        (("four_bar", "--out", "x.pdf"), ".html"),
        (("stewart_platform", "--range", "0", "0.1"), "single drive"),
        (("nothing",), "no description"),
    ],
)
def test_errors_are_messages(
    arguments: tuple[str, ...], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    found = run(*arguments)
    assert found.exit_code == 2
    assert said in found.output and "Traceback" not in found.output
    assert not list(tmp_path.iterdir())


def test_several_speeds_and_loads_are_load_cases(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    file = tmp_path / "cases.csv"
    found = run(
        *("four_bar", "--speed", "100,200rad/s", "--load", "rocker_bearing=-5,-10,5"),
        *("--samples", 40, "--out", file),
    )
    assert found.exit_code == 0, found.output
    assert "four_bar: 6 load cases" in found.output
    assert "100 1/min, -10 N·m at rocker_bearing" in found.output
    frame = pandas.read_csv(file)
    assert frame.case.nunique() == 6
    rows = frame[(frame.owner == "rocker_bearing") & (frame.quantity == "torsion")]
    assert sorted(set(rows.greatest.round(9))) == [-10.0, -5.0, 5.0]


@pytest.mark.parametrize(
    ("text", "is_said"),
    [("0,5", True), ("12,5", True), ("40,60", False), ("1rpm,2rpm", False), ("7", False)],
)
def test_a_comma_that_may_be_a_decimal_is_told(text: str, is_said: bool, tmp_path: Path) -> None:
    found = run("four_bar", "--speed", text, "--samples", 9, "--out", tmp_path / "x.csv")
    assert found.exit_code == 0, found.output
    told = f"is read as two load cases, {text.replace(',', ' and ')}"
    assert (told in found.stderr) == is_said
    assert (f"has a point: {text.replace(',', '.')}" in found.stderr) == is_said


def test_a_limit_that_is_missed_ends_with_1(tmp_path: Path) -> None:
    """A bar of 1 kg that is held level takes 4.905 N·m, of which its motor gives 4."""
    bar = tmp_path / "bar.urdf"
    text = (
        '<robot name="bar"><link name="ground"/><link name="arm"><inertial><origin xyz="0.5 0 0"/>'
        '<mass value="1"/><inertia ixx="0" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>'
        '</link><joint name="motor" type="revolute"><parent link="ground"/><child link="arm"/>'
        '<axis xyz="0 1 0"/><limit lower="-0.5" upper="0.5" effort="{}" velocity="1"/></joint>'
        "</robot>"
    )
    for effort, code in ((4, 1), (5, 0)):
        bar.write_text(text.format(effort), encoding="utf-8")
        acting = (bar, "--gravity", 0, 0, -9.81, "--samples", 9)
        assert run(*acting, "--out", tmp_path / "x.csv").exit_code == code
        found = CliRunner().invoke(main, ["sweep", *map(str, acting)])
        assert found.exit_code == code, found.output
        assert (
            "Exceeds effort limit of motor (-4 N·m): -4.905 N·m" in " ".join(found.output.split())
        ) == bool(code)


def test_a_report_of_a_swing_goes_both_ways_where_a_load_acts_one_way(tmp_path: Path) -> None:
    """At rest the crank lifts its load on the way forward, and nothing on the way back."""
    pandas = pytest.importorskip("pandas")
    file = tmp_path / "extremes.csv"
    text = "four_bar", "--drive", "rocker_bearing", "--out", file
    found = run(*text, "--load", "crank_bearing=-3@forward,-3@backward")
    assert found.exit_code == 0, found.output
    assert "2 load cases" in found.output
    frame = pandas.read_csv(file)
    of = frame[(frame.owner == "rocker_bearing") & (frame.quantity == "drive effort")]
    (up, back) = of[["greatest", "least"]].to_numpy()
    # One load on the two ways of the same swing: the same lever on both of them.
    assert 0.0 in up and 0.0 in back
    assert abs(up).max() == pytest.approx(abs(back).max(), rel=1e-9)
