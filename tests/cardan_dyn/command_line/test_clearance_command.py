"""The command `clearance`: table, JSON, figures, options and messages."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

import cardan_dyn as cd
from cardan_dyn.clearance import PinGeometry, scan
from cardan_dyn.practice.command_line import commands as cli

CONTACT = ("--clearance", "1e-4", "--stiffness", "1e8")


def run(*arguments: str) -> Result:
    return CliRunner().invoke(cli.main, ["clearance", *arguments], catch_exceptions=False)


@pytest.fixture
def wide(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "180")


@pytest.mark.slow
@pytest.mark.usefixtures("wide")
def test_prints_joints_by_their_peaks_doubts_and_what_was_not_scanned() -> None:
    result = run("needle_drive", "--speed", "3000", *CONTACT, "--damping-ratio", "0.25")
    assert result.exit_code == 0
    drive = cd.Scene(cd.load("needle_drive"), drive="main_shaft")
    speed = 100.0 * math.pi
    found = scan(drive, speed, clearance=1e-4, stiffness=1e8, damping_ratio=0.25)
    places = [result.output.index(f"\n{name} ") for name in found.ranking]
    assert places == sorted(places)
    lines = result.output.splitlines()
    (first,) = (line for line in lines if line.startswith("rocker_bearing "))
    worst = found["rocker_bearing"].worst
    assert worst is not None
    joint = found["rocker_bearing"]
    assert f"{joint.peak / 1e3:.3f}" in first and f"{joint.least / 1e3:.3f}" in first
    assert f"{worst.tau:.2f}" in first and f"{np.degrees(joint.peak_position):.1f}" in first
    assert "3000 1/min" in result.output
    assert "main_shaft: no impact: the pin slides round along its wall" in result.output
    # What strikes nothing has neither the speed of a strike nor the power of one.
    calm = [name for name in found.ranking if not found[name].impacts and found[name].worst]
    cells = {line.split()[0]: line.split() for line in lines if line.split()}
    assert calm and all(cells[name][-3:] == ["–", "0", "–"] for name in calm)
    assert joint.impacts and float(cells["rocker_bearing"][-1]) == pytest.approx(
        joint.impact_power, abs=0.005
    )
    assert "needle_guide: not scanned, it has no pin" in result.output


@pytest.mark.slow
@pytest.mark.usefixtures("wide")
def test_says_where_nothing_strikes() -> None:
    options = ("--speed", "100rad/s", *CONTACT, "--load", "piston_guide=-1000")
    result = run("slider_crank", *options)
    assert "no reversal: the force turns through" in result.output
    # What is known of it stands in the table all the same.
    crank = cd.Scene(
        cd.load("slider_crank"), drive="crank_bearing", loads={"piston_guide": -1000.0}
    )
    pin = scan(crank, 100.0, joints="piston_pin", clearance=1e-4, stiffness=1e8)["piston_pin"]
    (row,) = (line for line in result.output.splitlines() if line.startswith("piston_pin "))
    assert f"{pin.peak / 1e3:.3f}" in row and f"{pin.least / 1e3:.3f}" in row
    assert pin.peak > pin.rigid_peak


def test_json_of_numbers_and_geometries() -> None:
    options = (
        "--speed",
        "300rad/s",
        "--clearance",
        "crank_pin=1e-4",
        "--joint",
        "crank_pin",
        "--rotor",
        "2",
    )
    pin = ("--pin", "0.02", "0.01", "--seat-stiffness", "5e7", "--damping-ratio", "0.2")
    content = json.loads(run("slider_crank", *options, *pin, "--json").output)
    scene = cd.Scene(cd.load("slider_crank"), drive="crank_bearing")
    geometry = PinGeometry(0.02, 0.01, seat_stiffness=5e7)
    expected = scan(
        scene,
        300.0,
        clearance=1e-4,
        stiffness=geometry,
        joints="crank_pin",
        damping_ratio=0.2,
        rotor=2.0,
    )["crank_pin"]
    (joint,) = content["joints"]
    assert content["speed"] == 300.0 and content["notes"] == [] and content["left_out"] == {}
    assert joint["verdict"] == expected.verdict
    assert joint["rigid_peak"] == pytest.approx(expected.rigid_peak)
    assert joint["peak"] == pytest.approx(expected.peak) and joint["least"] is None
    assert joint["doubts"] == list(expected.doubts)
    assert len(joint["reversals"]) == len(expected.reversals) > 0
    for row, item in zip(joint["reversals"], expected.reversals, strict=True):
        assert row["peak"] == pytest.approx(item.peak)
        assert row["exponent_clearance"] == pytest.approx(float(item.exponents.clearance))


@pytest.mark.slow
def test_what_is_no_number_is_null_in_json() -> None:
    soft = ("--speed", "300rad/s", "--clearance", "1e-5", "--stiffness", "1e6")
    content = json.loads(run("needle_drive", *soft, "--json").output)
    peaks = [row["two_mass_peak"] for joint in content["joints"] for row in joint["reversals"]]
    assert peaks and set(peaks) == {None}


@pytest.mark.slow
def test_figures(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="figures need matplotlib")
    options = (
        "--speed",
        "300rad/s",
        *CONTACT,
        "--joint",
        "coupler_pin",
        "--figures",
        str(tmp_path),
    )
    result = run("needle_drive", *options, "--json")
    assert result.exit_code == 0 and f"Figures: {tmp_path}" in result.stderr
    json.loads(result.stdout)
    names = {"force_reversals", "impact_ranking", "peak_factor", "peak_influence"}
    assert {path.stem for path in tmp_path.iterdir()} == names
    file = tmp_path / "file"
    file.touch()
    assert run("needle_drive", *options[:-1], str(file / "x")).exit_code == 2


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (CONTACT, "give the speed of the drive: --speed"),
        (("--speed", "300rad/s", "--clearance", "1e-4"), "either by --stiffness or by --pin"),
        (
            ("--speed", "300rad/s", *CONTACT, "--pin", "0.1", "0.1"),
            "either by --stiffness or by --pin",
        ),
        (
            ("--speed", "300rad/s", *CONTACT, "--seat-stiffness", "1"),
            "--seat-stiffness goes with --pin",
        ),
        (
            ("--speed", "300rad/s", "--clearance", "x", "--stiffness", "1e8"),
            "--clearance is 'x', not a number with a unit",
        ),
        (
            ("--speed", "300rad/s", "--clearance", "coupler_pin=x", "--stiffness", "1e8"),
            "--clearance coupler_pin is 'x'",
        ),
        (
            ("--speed", "300rad/s", *CONTACT, "--clearance", "coupler=1e-4"),
            "did you mean 'coupler_pin'",
        ),
        (
            ("--speed", "300rad/s", *CONTACT, "--clearance", "2e-4"),
            "--clearance is 1e-4 and 2e-4",
        ),
        (("--speed", "0rad/s", *CONTACT), "speed is 0"),
        (("--speed", "300rad/s", *CONTACT, "--joint", "needle_guide"), "has no pin"),
        (("--speed", "300rad/s", "--clearance", "-1", "--stiffness", "1e8"), "clearance is -1"),
    ],
)
def test_messages(options: tuple[str, ...], message: str) -> None:
    result = run("needle_drive", *options)
    assert result.exit_code == 2
    assert message in " ".join(result.stderr.split())


@pytest.mark.slow
def test_one_joint_may_differ_from_all_others() -> None:
    options = ("--speed", "300rad/s", *CONTACT, "--damping-ratio", "0.25", "--json")
    result = run("needle_drive", *options, "--clearance", "coupler_pin=2e-4")
    found = {item["joint"]: item["peak"] for item in json.loads(result.output)["joints"]}
    drive = cd.Scene(cd.load("needle_drive"), drive="main_shaft")
    for name, clearance in (("coupler_pin", 2e-4), ("needle_pin", 1e-4)):
        expected = scan(drive, 300.0, clearance=clearance, stiffness=1e8, damping_ratio=0.25)[
            name
        ].peak
        assert found[name] == pytest.approx(expected, rel=1e-6)


@pytest.mark.slow
def test_verification_is_part_of_the_output() -> None:
    options = (
        "--speed",
        "300rad/s",
        *CONTACT,
        "--damping-ratio",
        "0.25",
        "--joint",
        "needle_pin",
    )
    content = json.loads(run("needle_drive", *options, "--verify", "--json").output)
    assert [row["joint"] for row in content["verified"]] == ["needle_pin"] * 2
    for row in content["verified"]:
        assert row["least"] < row["simulated"] < row["greatest"]
    assert "verified" not in json.loads(run("needle_drive", *options, "--json").output)


@pytest.mark.slow
def test_bearings_of_a_universal_joint(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="figures need matplotlib")
    options = ("--speed", "150rad/s", *CONTACT, "--held", "joint_angle=20", "--joint", "cross")
    options = (*options, "--radius", "0.05", "--bearing", "pin_in", "--json")
    result = run("thoma_rig", *options, "--figures", str(tmp_path))
    assert result.exit_code == 0, result.output
    assert (tmp_path / "force_reversals.svg").exists()
    (joint,) = json.loads(result.stdout)["joints"]
    rig = cd.Scene(
        cd.load("thoma_rig"), drive="bearing_in", held={"joint_angle": math.radians(20.0)}
    )
    given = {"clearance": 1e-4, "stiffness": 1e8, "radius": 0.05, "bearings": "pin_in"}
    found = scan(rig, 150.0, joints="cross", **given)["cross"]  # type: ignore[arg-type]
    assert joint["joint"] == "cross"
    assert joint["rigid_peak"] == pytest.approx(found.rigid_peak, rel=1e-9)
    assert len(joint["reversals"]) == len(found.reversals) == 4


@pytest.mark.slow
def test_ctrl_c_while_joints_are_simulated_is_told_by_the_exit_code(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def press(progress: object, time: float) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("cardan_dyn.motion.simulation.progress.Progress.step", press)
    found = run("needle_drive", "--speed", "3000", *CONTACT, "--verify")
    assert found.exit_code == 130
    assert "Clearance at" in found.output and "interrupted; not simulated: " in found.output
