"""`cardan-dyn sweep` and `simulate`: what they print and write, of bundled and other files."""

from __future__ import annotations

import builtins
import io
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pytest
from click.testing import CliRunner, Result
from testkit.ball_rods import as_balls
from testkit.linkages import coupling, gears
from testkit.planar_linkages import five_bar

import cardan_dyn as cd
from cardan_dyn.practice.command_line import main, motion_command


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(item) for item in arguments], catch_exceptions=False)


@pytest.fixture
def foreign(tmp_path: Path) -> Path:
    path = tmp_path / "rods.urdf"
    path.write_text(as_balls(), encoding="utf-8")
    return path


def test_a_sweep_prints_where_wrenches_are_greatest(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    found = run("sweep", "slider_crank", "--samples", 73)
    assert found.exit_code == 0, found.output
    expected = cd.Scene(
        cd.load("slider_crank"), drive="crank_bearing", loads={"piston_guide": -1000.0}
    ).sweep(np.linspace(0.0, 2.0 * np.pi, 73))
    assert "crank_bearing turns once; 73 positions, quasi-static" in found.output
    assert "-1 kN at piston_guide" in found.output
    # What is along the pins is open and nothing, what is across them is the force: without a star.
    force = expected["crank_pin"].shear
    (line,) = (line for line in found.output.splitlines() if line.startswith("crank_pin"))
    cells = line.split()
    assert "kN" in found.output
    assert float(cells[1]) == pytest.approx(force.max() / 1e3, rel=5e-4)
    assert float(cells[2]) == pytest.approx(5.0 * int(np.argmax(force)), abs=0.05)
    low, high = expected.drive_effort.min(), expected.drive_effort.max()
    assert f"drive crank_bearing: {low:.4g} to {high:.4g} N·m" in found.output


def test_a_star_stands_at_what_statics_leaves_open_and_nowhere_else(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    told = "Not determined by statics, chosen by least norm: bearing_in, pin_in, joint_angle, "
    # Fixed bearings of both shafts leave the forces open, and the moments not.
    pushed = ("--load", "shaft_out=50 0 0", "--load", "bearing_out=-100")
    found = run("sweep", "universal_joint", "--samples", 5, *pushed)
    assert found.exit_code == 0, found.output
    (line,) = (line for line in found.output.splitlines() if line.startswith("bearing_out"))
    assert line.count("*") == 1
    assert re.match(r"bearing_out +30\.00 \* ", line)
    assert f"* {told}" in found.output
    # Forces that are chosen to be zero are told once.
    found = run("sweep", "universal_joint", "--samples", 5)
    assert "*" not in found.output and told in found.output


def test_units_of_every_value(tmp_path: Path) -> None:
    file = tmp_path / "out.csv"
    options = ("--range", "0.1rad", 30, "--samples", 3, "--speed", "100rad/s", "--csv", file)
    assert run("sweep", "slider_crank", *options, "--load", "piston_guide=-1kN").exit_code == 0
    frame = pandas.read_csv(file)
    ends = [0.1, (0.1 + np.pi / 6.0) / 2.0, np.pi / 6.0]
    np.testing.assert_allclose(frame["position [rad]"], ends)
    np.testing.assert_allclose(frame["speed [rad/s]"], 100.0)
    assert (
        run("sweep", "slider_crank", "--range", 0, 90, "--speed", 955, "--csv", file).exit_code == 0
    )
    np.testing.assert_allclose(pandas.read_csv(file)["speed [rad/s]"], 955.0 * np.pi / 30.0)
    held = ("--drive", "piston_guide", "--range", "-10mm", -0.02, "--speed", 1.5)
    refused = run("sweep", "slider_crank", *held)
    assert refused.exit_code == 2 and "dead point" in refused.output


def test_data_go_to_the_output_alone() -> None:
    found = run("sweep", "four_bar", "--samples", 5, "--joint", "crank_pin", "--csv", "-")
    frame = pandas.read_csv(io.StringIO(found.stdout))
    assert len(frame) == 5 and "crank_pin.force_x [N]" in frame
    assert "rocker_pin.force_x [N]" not in frame
    told = json.loads(run("sweep", "four_bar", "--samples", 5, "--json", "-").stdout)
    assert len(told["columns"]["drive_effort"]) == 5
    both = run("sweep", "four_bar", "--json", "-", "--csv", "-")
    assert both.exit_code == 2 and "into each other" in both.output


@pytest.mark.slow
def test_files_of_every_kind(tmp_path: Path) -> None:
    files = {f"--{name}": tmp_path / f"out.{name}" for name in ("csv", "json")}
    files["--plot"] = tmp_path / "out.png"
    options = [item for pair in files.items() for item in pair]
    found = run("sweep", "universal_joint", "--samples", 9, *options)
    assert found.exit_code == 0, found.output
    assert all(path.stat().st_size > 500 for path in files.values())
    assert "joint_angle held at 35°" in found.output


def test_parquet_files_hold_what_csv_files_hold(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    csv, parquet = tmp_path / "out.csv", tmp_path / "out.parquet"
    found = run("sweep", "four_bar", "--samples", 5, "--csv", csv, "--parquet", parquet)
    assert found.exit_code == 0, found.output
    efforts = pandas.read_csv(csv).filter(like="drive_effort").to_numpy()
    np.testing.assert_allclose(pandas.read_parquet(parquet).filter(like="drive_effort"), efforts)


def test_where_nothing_acts_there_is_neither_a_place_nor_a_residual() -> None:
    found = run("sweep", "four_bar", "--samples", 9, "--load", "rocker_bearing=0")
    assert found.exit_code == 0, found.output
    assert "nan" not in found.output
    assert "balance –, power –" in found.output
    (row,) = (line.split() for line in found.output.splitlines() if line.startswith("crank_pin"))
    assert [cell for cell in row if cell != "*"][1:5] == ["0", "–", "0", "–"]


def test_the_greatest_wrenches_are_those_that_are_known(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", gravity=(0.0, -9.81, 0.0))
    turn = scene.sweep(np.radians([10.0, 20.0, 30.0]))
    for name in turn.outputs:  # As trajectories have them at times that `singular` marks.
        for vectors in (turn[name].force, turn[name].moment):
            vectors.setflags(write=True)
            vectors[1] = np.nan
    motion_command._print_extremes(turn, np.array([10.0, 20.0, 30.0]), "°", "there")
    printed = " ".join(capsys.readouterr().out.split())
    assert "nan" not in printed
    assert "Not known at 1 of 3 places" in printed


@pytest.mark.slow
def test_a_foreign_file_chooses_its_drive(foreign: Path, tmp_path: Path) -> None:
    found = run("sweep", foreign, "--samples", 9, "--gravity", 0, 0, -9.81)
    assert found.exit_code == 0, found.output
    assert "driven at a joint at the ground" in " ".join(found.output.split())
    assert "residuals: loop " in found.output


def test_several_drives_swing_or_are_held(tmp_path: Path) -> None:
    path = tmp_path / "five_bar.urdf"
    path.write_text(five_bar().to_urdf(), encoding="utf-8")
    found = run("sweep", path, "--drive", "A", "--drive", "D", "--samples", 9)
    assert found.exit_code == 0 and "A, D move there and back" in found.output
    refused = run("sweep", path, "--drive", "A", "--drive", "D", "--range", 0, 10)
    assert refused.exit_code == 2 and "--held D=…" in refused.output
    assert "single drive" in run("sweep", path, "--drive", "A", "--drive", "D", "--speed", 5).output
    held = run("sweep", path, "--drive", "A", "--held", "D=0", "--range", -5, 5, "--samples", 5)
    assert held.exit_code == 0, held.output


@pytest.mark.parametrize("command", ["sweep", "simulate"])
def test_outputs_that_cannot_be_written_are_refused_before_anything_is_read(
    command: str, tmp_path: Path
) -> None:
    taken = tmp_path / "taken"
    taken.write_text("", encoding="utf-8")
    options = ("--time", "1") if command == "simulate" else ()
    for flag, path, said in (
        ("--csv", taken / "out.csv", "is not a directory"),
        ("--csv", tmp_path / "missing" / "out.csv", "does not exist"),
        ("--csv", tmp_path / "out.txt", ".csv"),
        ("--json", tmp_path, ".json"),
        ("--plot", tmp_path / "out.bmp", ".png"),
    ):
        found = run(command, "no such mechanism", *options, flag, path)
        assert found.exit_code == 2
        assert said in " ".join(found.output.split()), found.output


def test_what_a_file_needs_is_asked_for_before_anything_is_read(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(
        "cardan_dyn.practice.command_line.motion_command.find_spec", lambda name: None
    )
    found = run("sweep", "no such mechanism", "--parquet", tmp_path / "out.parquet")
    assert found.exit_code == 2 and "pandas is missing" in found.output
    real = builtins.__import__

    def without(name: str, *rest: Any, **more: Any) -> Any:
        if name.startswith("matplotlib"):
            raise ImportError(name)
        return real(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    found = run("sweep", "no such mechanism", "--plot", tmp_path / "out.png")
    assert found.exit_code == 2 and "figures need matplotlib" in found.output


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("nonsense",), "nonsense"),
        (("four_bar", "--drive", "crank"), "crank_bearing"),
        (("four_bar", "--speed", "fast"), "not a number with a unit"),
        (("four_bar", "--speed", "3 stone"), "stone"),
        (("four_bar", "--range", "0", "x"), "not a number"),
        (("four_bar", "--load", "crank_pin"), "JOINT=VALUE"),
        (("four_bar", "--drive", "rocker_bearing", "--speed", "3"), "there and back"),
        (("slider_crank", "--drive", "piston_guide"), "dead point"),
        (("universal_joint", "--held", "joint_angle=90"), "joint_angle"),
        (("four_bar", "--samples", "1"), "x>=2"),
    ],
)
def test_errors_are_messages(arguments: tuple[str, ...], said: str) -> None:
    found = run("sweep", *arguments)
    assert found.exit_code == 2
    assert said in found.output and "Traceback" not in found.output


@pytest.mark.slow
def test_a_simulation_prints_and_writes_its_course(tmp_path: Path) -> None:
    file, picture = tmp_path / "out.csv", tmp_path / "out.svg"
    options = ("--time", "0.2s", "--at", "crank_bearing=90", "--gravity", 0, -9.81, 0)
    found = run("simulate", "four_bar", *options, "--csv", file, "--plot", picture)
    assert found.exit_code == 0, found.output
    expected = cd.Scene(
        cd.load("four_bar"), free="crank_bearing", gravity=[0.0, -9.81, 0.0]
    ).simulate(0.2, position=np.pi / 2.0)
    frame = pandas.read_csv(file)
    assert frame["position [rad]"].iloc[-1] == pytest.approx(expected.position[-1], rel=1e-9)
    assert f"to {np.rad2deg(expected.position[-1]):.4g}°" in found.output
    assert picture.stat().st_size > 1000


@pytest.mark.slow
def test_initial_speeds_and_driven_joints() -> None:
    found = run("simulate", "four_bar", "--time", 0.05, "--initial", "crank_bearing=60rpm")
    assert found.exit_code == 0, found.output
    rig = ("simulate", "elastic_thoma_rig", "--time", 0.02, "--drive", "bearing_in=1000rpm")
    found = run(*rig)
    assert found.exit_code == 0, found.output
    assert "4 elements" in found.output
    assert "elements" not in run(*rig, "--no-elements").output


@pytest.mark.slow
def test_foreign_files_are_simulated_and_drawn(foreign: Path, tmp_path: Path) -> None:
    """Some of its joints are balls, which have no torsion or bending to be drawn."""
    picture = tmp_path / "out.svg"
    options = ("--time", 0.1, "--gravity", 0, 0, -9.81, "--plot", picture)
    found = run("simulate", foreign, *options)
    assert found.exit_code == 0, found.output
    assert "energy balance" in found.output
    assert "time [s]" in picture.read_text(encoding="utf-8")


def test_a_simulation_that_is_interrupted_prints_and_writes_what_it_found(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The third step is where Ctrl-C comes."""
    from cardan_dyn.motion.simulation.progress import Progress

    count = 0

    def press(progress: Progress, time: float) -> None:
        nonlocal count
        count += 1
        if count == 3:
            raise KeyboardInterrupt

    monkeypatch.setattr(Progress, "step", press)
    file = tmp_path / "out.csv"
    rig = ("simulate", "elastic_thoma_rig", "--time", 5, "--drive", "bearing_in=1000")
    found = run(*rig, "--csv", file)
    assert found.exit_code == 130
    assert "interrupted at" in found.output and "Traceback" not in found.output
    assert 3 <= len(pandas.read_csv(file)) < 20


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((), "--time"),
        (("--time", "3 stone"), "stone"),
        (("--time", "-1"), "duration"),
        (("--time", "1", "--free", "elbow"), "elbow"),
        (("--time", "1", "--initial", "crank_bearing"), "JOINT=SPEED"),
        (("--time", "1", "--drive", "crank_bearing=1"), "free"),
    ],
)
def test_errors_of_simulations_are_messages(arguments: tuple[str, ...], said: str) -> None:
    found = run("simulate", "four_bar", *arguments)
    assert found.exit_code == 2
    assert said in found.output and "Traceback" not in found.output


def test_couplings_that_state_no_forces_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "400")
    told = "how 'teeth', which couples a and b, presses on their bearings is not described"
    for stated, opened in (("", True), ('forces="none"', False), ('forces="mesh"', False)):
        file = tmp_path / "pair.urdf"
        file.write_text(gears(coupling("teeth", "a", "b", -2.5, stated)), encoding="utf-8")
        checked = run("check", file).output
        assert (told in checked) == opened
        assert checked.count('write forces="mesh" and pressure_angle in it') == opened
        assert ("statics determine all wrenches" in checked) != opened
        swept = run("sweep", file, "--drive", "a", "--samples", 3, "--load", "b=5").output
        assert (f"* {told[0].upper()}{told[1:]}: a, b (" in swept) == opened
        assert "chosen by" not in swept


MJCF = """<mujoco><compiler angle="radian"/><worldbody>
<body name="crank"><joint name="a" axis="0 0 1"/>{0}<body name="coupler" pos="0.1 0 0">
<joint name="b" axis="0 0 1"/>{0}</body></body><body name="rocker" pos="0.4 0 0">
<joint name="d" axis="0 0 1"/>{0}</body></worldbody><equality>
<connect name="c" body1="coupler" body2="rocker" anchor="0.3 0.2 0"/></equality>
<keyframe><key name="up" qpos="0.4 -0.527 -0.075"/></keyframe></mujoco>""".format(
    '<inertial pos="0.1 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>'
)


ARM = """<robot name="arm"><link name="ground"/>
<link name="upper"><inertial><origin xyz="0.3 0 0"/><mass value="2"/>
  <inertia ixx="0.01" iyy="0.01" izz="0.01"/></inertial></link>
<link name="lower"><inertial><origin xyz="0.3 0 0"/><mass value="1"/>
  <inertia ixx="0.01" iyy="0.01" izz="0.01"/></inertial></link>
<joint name="shoulder" type="continuous"><parent link="ground"/><child link="upper"/>
  <axis xyz="0 1 0"/></joint>
<joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
  <origin xyz="0.6 0 0"/><axis xyz="0 1 0"/></joint></robot>"""


def test_places_are_told_without_rounding(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text(ARM, encoding="utf-8")
    found = run("sweep", path, "--samples", 361, "--gravity", 0, 0, -9.81)
    cells = {line.split()[0]: line.split() for line in found.output.splitlines() if line.strip()}
    # The weight is the same everywhere, and so is greatest where the sweep begins; of two drives
    # the sample is told, as the position of one of them is no place.
    assert cells["shoulder"][2] == "0" and "way of 2 drives" in " ".join(found.output.split())
    one = run("sweep", path, "--held", "elbow=0", "--samples", 361, "--gravity", 0, 0, -9.81)
    rows = (line.split() for line in one.output.splitlines())
    cells = {row[0]: row for row in rows if len(row) == 7}
    assert {float(cells[name][4]) for name in ("shoulder", "elbow")} <= {-180.0, 0.0, 180.0, 360.0}


def test_a_force_whose_open_part_is_nothing_has_no_star() -> None:
    weight = ("--load", "piston_guide=0", "--gravity", 0, -9.81, 0)
    found = run("sweep", "slider_crank", "--samples", 25, *weight)
    (line,) = (row for row in found.output.splitlines() if row.startswith("piston_guide"))
    expected = cd.Scene(
        cd.load("slider_crank"), drive="crank_bearing", gravity=(0.0, -9.81, 0.0)
    ).sweep(np.linspace(0.0, 2.0 * np.pi, 25))["piston_guide"]
    # The weight of the piston is across the guide, and nothing is along it.
    assert np.abs(expected.axial).max() < 1e-12 < expected.shear.min()
    _, size, place, *_ = line.split()
    assert place != "*" and float(size) == pytest.approx(expected.shear.max(), rel=5e-3)


@pytest.mark.parametrize(
    ("options", "near"),
    [(["up"], "up"), (["a=0.4rad"], {"a": 0.4}), (["b=-20", "d=-0.02rad"], None)],
)
def test_loops_are_closed_near_a_keyframe_or_positions(
    options: list[str], near: object, tmp_path: Path
) -> None:
    path = tmp_path / "bar.xml"
    path.write_text(MJCF, encoding="utf-8")
    given = [word for item in options for word in ("--near", item)]
    begun = run("simulate", path, "--free", "a", *given, "--time", 0.01)
    if near is None:
        # No position of the bar has both.
        swept = run("sweep", path, *given)
        for found in (begun, swept):
            assert found.exit_code == 2 and "(b: -0.349066, d: -0.02)" in found.output
        return
    assert begun.exit_code == 0, begun.output
    at = cd.Scene(cd.load(path), free="a", near=near).configuration()["a"]
    assert f"a: from {np.rad2deg(at):.4g}°" in begun.output and at > 0.39
    for command in (("sweep",), ("simulate", "--time", 0.01)):
        refused = run(*command, path, "--near", "upp")
        assert refused.exit_code == 2 and "did you mean 'up'?" in refused.output


@pytest.mark.parametrize("speed", [[], ["--speed", "60"], ["--speed=-60"]])
def test_a_load_acts_while_its_joint_moves_one_way(speed: list[str], tmp_path: Path) -> None:
    """Held against the slider-crank's own formula: x = r cos θ + √(l² - r² sin² θ)."""
    load = "--load", "piston_guide=-60kN@forward", "--gravity", 0, 0, 0
    found = run("sweep", "slider_crank", *load, *speed, "--csv", tmp_path / "x.csv")
    assert found.exit_code == 0, found.output
    assert "-60 kN at piston_guide moving forward" in found.output
    frame = pandas.read_csv(tmp_path / "x.csv")
    x, r, rod = frame["position [rad]"].to_numpy(), 0.045, 0.15
    lever = -r * np.sin(x) - r * r * np.sin(x) * np.cos(x) / np.sqrt(rod**2 - (r * np.sin(x)) ** 2)
    sense = -1.0 if speed == ["--speed=-60"] else 1.0
    effort = np.where(sense * lever > 1e-12, 60e3 * lever, 0.0)
    # What inertia takes at this speed is the difference to a sweep without the load.
    idle = cd.Scene(cd.load("slider_crank"), drive="crank_bearing").sweep(
        x, speed=sense * 2.0 * np.pi * bool(speed)
    )
    efforts = frame["drive_effort [N·m]"]
    np.testing.assert_allclose(efforts - idle.drive_effort, effort, rtol=0, atol=1e-8)
    # At both dead points the piston stands, whatever its speed is rounded to.
    if not speed:
        standing = run("sweep", "slider_crank", *load, "--samples", 2).output
        assert "crank_pin 0 – 0 –" in " ".join(standing.split())


def test_a_load_that_drives_over_a_part_of_a_turn_is_named(tmp_path: Path) -> None:
    said = "The load at piston_guide drives it on one of its ways"
    way_out = "--load piston_guide=…@"
    for amount, sense in (("-60kN", "forward"), ("60kN", "backward")):
        for command in (["sweep"], ["report", "--out", tmp_path / "x.csv"]):
            found = " ".join(
                run(*command, "slider_crank", "--load", f"piston_guide={amount}").output.split()
            )
            assert said in found and way_out + sense in found
    # One that turns, one that acts against the motion alone, and one of a preset are as meant.
    for load in (["--load", "piston_guide=-60kN@forward"], []):
        assert said not in " ".join(run("sweep", "slider_crank", *load).output.split())
    turning = "universal_joint", "--held", "joint_angle=20", "--load", "bearing_out=-100"
    assert "drives it on" not in run("sweep", *turning).output


def test_one_way_is_said_of_sweeps_and_reports_alone() -> None:
    for text in (
        "view",
        "simulate --time 1",
        "clearance --speed 60 --clearance 1e-4 --stiffness 1e8",
    ):
        found = run(*text.split(), "slider_crank", "--load", "piston_guide=-60@forward")
        assert found.exit_code == 2 and "loads of sweep and report" in found.output
    found = run("sweep", "slider_crank", "--load", "piston_guide=-60@upwards")
    assert found.exit_code == 2 and "@forward or @backward" in found.output
