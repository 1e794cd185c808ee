"""`cardan-dyn study`: plans, runs and goes on with what a file describes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray
from click.testing import CliRunner, Result

import cardan_dyn as cd
from cardan_dyn.practice.command_line import main
from cardan_dyn.practice.command_line.study_command import read

TEXT = """
mechanism = "universal_joint"
store = "PLACE"

[scene]
drive = "bearing_in"
held = { joint_angle = "20 deg" }
loads = { bearing_out = "-100 N·m" }

[sweep]
position = { from = "0 deg", to = "360 deg", count = 37 }

[wanted]
peak = ["bearing_out.bending", "max"]

[parameters]
"held.joint_angle" = { values = ["10 deg", "20 deg", "30 deg"] }
speed = { from = "0 rpm", to = "1500 rpm", count = 2 }
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "study.toml"
    path.write_text(TEXT.replace("PLACE", str(tmp_path / "study.zarr")), encoding="utf-8")
    return path


def invoke(*words: str | Path) -> Result:
    return CliRunner().invoke(main, ["study", *map(str, words)])


def test_a_dry_run_tells_the_plan_and_writes_nothing(file: Path) -> None:
    result = invoke(file, "--dry-run", "--workers", 1)
    assert result.exit_code == 0, result.output
    assert "6: held.joint_angle 3 × speed 2" in result.output
    assert "one call of sweep" in result.output
    assert not (file.parent / "study.zarr").exists()


@pytest.mark.slow
def test_a_run_keeps_results_and_goes_on_only_when_asked(file: Path) -> None:
    assert invoke(file, "--workers", "1").exit_code == 0
    data = xarray.open_zarr(file.parent / "study.zarr", consolidated=False)
    angles = np.deg2rad([10.0, 20.0, 30.0])
    np.testing.assert_allclose(data["held.joint_angle"], angles)
    np.testing.assert_allclose(data.speed, [0.0, 50.0 * np.pi])
    np.testing.assert_allclose(data.peak[:, 0], 100.0 * np.tan(angles), rtol=1e-9)
    refused = invoke(file, "--workers", "1")
    assert refused.exit_code == 2
    assert "--resume goes on" in refused.output
    again = invoke(file, "--workers", "1", "--resume")
    assert again.exit_code == 0
    assert "nothing is left" in again.output
    other = invoke(file, "--workers", "1", "--store", file.parent / "other.zarr")
    assert other.exit_code == 0
    assert (file.parent / "other.zarr").is_dir()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"20 deg" }', "20 }", "expected a text like"),
        ('"-100 N·m"', '"-100 stone"', "is no number with a unit; write a text"),
        ("[wanted]", "[wantet]", "did you mean 'wanted'"),
        (", count = 2 }", " }", "from, to and count|count = 26"),
        ('"0 rpm"', '"0 deg"', "numbers are in rad, rad/s"),
        ('"held.joint_angle" =', '"angle" =', "no argument of a sweep"),
        ("mechanism", "# mechanism", "which mechanism"),
        ("values = [", "values = [[", "cannot be read"),
    ],
)
def test_what_a_file_says_wrongly_is_said(file: Path, old: str, new: str, said: str) -> None:
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new), encoding="utf-8")
    result = invoke(file, "--dry-run")
    assert result.exit_code == 2, result.output
    import re

    assert re.search(said, " ".join(result.output.split())), result.output


def test_samples_and_their_indices_come_from_a_file(file: Path) -> None:
    text = file.read_text(encoding="utf-8")
    start = text.index("[parameters]")
    more = """
[samples]
count = 8
seed = 3
indices = true
parameters = { "loads.bearing_out" = { normal = ["-100 N·m", "5 N·m"] } }
"""
    file.write_text(text[:start] + more, encoding="utf-8")
    result = invoke(file, "--workers", 1)
    assert result.exit_code == 0, result.output
    data = xarray.open_zarr(file.parent / "study.zarr", consolidated=False)
    np.testing.assert_allclose(
        data.peak, -np.tan(np.deg2rad(20.0)) * data["loads.bearing_out"], rtol=1e-9
    )


def test_help_imports_nothing_that_a_study_needs() -> None:
    code = (
        "import sys\nfrom cardan_dyn.practice.command_line import main\n"
        "try:\n    main(['study', '--help'])\nexcept SystemExit:\n    pass\n"
        "print(sorted({'dask', 'zarr', 'xarray', 'cardan_dyn.studies'} & set(sys.modules)))"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "--scheduler ADDRESS" in out.stdout
    assert out.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            'joint_angle = "20 deg"',
            'joint_angle = "20 mm"',
            "held.joint_angle is in m, and a sweep",
        ),
        ('"-100 N·m"', '"-100 mm"', "loads.bearing_out is in m, and a sweep takes it in N·m"),
        ("[sweep]", '[sweep]\nspeed = "20 N"', "speed is in N, and a sweep takes it in rad/s"),
        ('to = "360 deg"', 'to = "360 mm"', "position: numbers are in m, rad"),
        ('"0 deg", to = "360 deg"', '"0 mm", to = "36 mm"', "position is in m, and a sweep takes"),
        (
            'from = "0 rpm", to = "1500 rpm"',
            'from = "0 N", to = "1 N"',
            "speed is in N, and a sweep",
        ),
        ("[sweep]", "gravity = [0.0, 0.0, -9.81]\n[sweep]", "expected a text like '-9.81 m/s²'"),
        ("[sweep]", 'gravity = "-9.81 m/s²"\n[sweep]', "gravity: write"),
    ],
)
def test_numbers_of_another_kind_are_refused(file: Path, old: str, new: str, said: str) -> None:
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new), encoding="utf-8")
    result = invoke(file, "--dry-run", "--workers", 1)
    assert result.exit_code == 2
    assert said in " ".join(result.output.split())


def test_gravity_has_units(file: Path) -> None:
    text = file.read_text(encoding="utf-8")
    words = 'gravity = ["0 m/s²", "1000 mm/s²", "-9.81 m/s²"]\n[sweep]'
    file.write_text(text.replace("[sweep]", words), encoding="utf-8")
    text = file.read_text(encoding="utf-8").replace("bearing_out.bending", "bearing_out.force")
    file.write_text(text, encoding="utf-8")
    found = read(file, workers=1).run().dataset.peak[1, 0]
    scene = cd.Scene(
        cd.load("universal_joint"),
        drive="bearing_in",
        held={"joint_angle": np.deg2rad(20.0)},
        loads={"bearing_out": -100.0},
        gravity=(0.0, 1.0, -9.81),
    )
    force = scene.sweep(np.linspace(0.0, 2.0 * np.pi, 37))["bearing_out"].force
    assert float(found) > 1.0
    assert float(found) == pytest.approx(np.linalg.norm(force, axis=-1).max(), rel=1e-12)


@pytest.mark.slow
def test_a_store_is_verified(file: Path) -> None:
    nothing = invoke(file, "--verify", "--workers", "1")
    assert nothing.exit_code == 2
    assert "holds no results" in nothing.output
    assert invoke(file, "--workers", "1").exit_code == 0
    store = file.parent / "study.zarr"
    whole = invoke(file, "--verify", "--workers", "1")
    assert whole.exit_code == 0, whole.output
    assert "all that is there can be read: 6 of 6 cases" in whole.output
    before = {path: path.read_bytes() for path in store.rglob("*") if path.is_file()}
    chunk = next(path for path in before if path.parts[-4:-2] == ("peak", "c"))
    chunk.write_bytes(b"")
    damaged = invoke(file, "--verify", "--workers", "1")
    said = " ".join(damaged.output.split())
    assert damaged.exit_code == 1, damaged.output
    assert "6 cases are damaged; with --resume they are computed again" in said
    assert "peak" in said and "held.joint_angle 0 to 2, speed 0 to 1" in said
    assert chunk.read_bytes() == b""
    # A dry run and a run that goes on say so as well.
    assert "6 damaged" in invoke(file, "--dry-run", "--workers", "1").output
    again = invoke(file, "--resume", "--workers", "1")
    assert again.exit_code == 0
    assert "6 cases are damaged; they are computed again" in " ".join(again.output.split())
    assert {path: path.read_bytes() for path in before} == before
    # Without states, results do not count; without coordinates they do.
    for name, said, does in (
        ("state", "6 cases are damaged", "they are computed again"),
        ("speed", "no case is damaged with it", "it is written anew"),
    ):
        for path in (store / name / "c").rglob("*"):
            if path.is_file():
                path.unlink()
        lost = invoke(file, "--verify", "--workers", "1")
        assert lost.exit_code == 1, lost.output
        assert f"{said}; with --resume {does}" in " ".join(lost.output.split())
        again = invoke(file, "--resume", "--workers", "1")
        assert f"{said}; {does}" in " ".join(again.output.split())
        assert {path: path.read_bytes() for path in before} == before
    (store / "zarr.json").write_bytes(before[store / "zarr.json"][:-9])
    torn = invoke(file, "--verify", "--workers", "1")
    assert torn.exit_code == 2
    assert "put a copy of its zarr.json back, or name another" in " ".join(torn.output.split())


def test_the_table_of_results_counts_what_is_known(file: Path) -> None:
    """A shaft at 90° cannot turn: its cases fail, and are in no mean and no maximum."""
    text = file.read_text(encoding="utf-8").replace('"30 deg"', '"90 deg"')
    # As editors of Windows write it.
    file.write_text(text, encoding="utf-8-sig")
    result = invoke(file, "--workers", "1")
    assert result.exit_code == 0, result.output
    row = next(line for line in result.output.splitlines() if line.startswith("peak"))
    assert row.split()[-3:] == ["4", "of", "6"]
    assert "2 cases failed" in result.output


def test_the_table_of_results_marks_what_statics_leaves_open(tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    file.write_text(
        f'mechanism = "four_bar"\nstore = "{tmp_path / "study.zarr"}"\n'
        '[scene]\ndrive = "crank_bearing"\ngravity = ["0 m/s²", "-9.81 m/s²", "0 m/s²"]\n'
        '[wanted]\nopen = "rocker_pin.axial"\nknown = "rocker_pin.shear"\n'
        '[parameters]\nposition = { values = ["10 deg", "20 deg"] }\n',
        encoding="utf-8",
    )
    result = invoke(file, "--workers", "1")
    assert result.exit_code == 0, result.output
    assert "open [N] *" in result.output and "known [N] *" not in result.output
    assert "* not determined by statics, chosen by least norm" in result.output


def test_a_study_of_another_assembly(tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    text = (
        f'mechanism = "four_bar"\nstore = "{tmp_path / "study.zarr"}"\n[scene]\n'
        'drive = "crank_bearing"\nloads = { rocker_bearing = "-5 N·m" }\n'
        'near = { crank_pin = "-74 deg", rocker_bearing = "147 deg" }\n'
        '[wanted]\nshear = "rocker_pin.shear"\n'
        '[parameters]\nposition = { values = ["10 deg", "20 deg"] }\n'
    )
    file.write_text(text, encoding="utf-8")
    result = invoke(file, "--workers", "1")
    assert result.exit_code == 0, result.output
    scene = cd.Scene(
        cd.load("four_bar"),
        drive="crank_bearing",
        near={"crank_pin": -1.29, "rocker_bearing": 2.57},
        loads={"rocker_bearing": -5.0},
    )
    greatest = scene.sweep(np.radians([10.0, 20.0]))["rocker_pin"].shear.max()
    assert f"{greatest:.6g}" in result.output
    file.write_text(text.replace("-74 deg", "-1.29 N"), encoding="utf-8")
    refused = invoke(file, "--workers", "1")
    assert refused.exit_code == 2 and "near.crank_pin is in N" in refused.output
    file.write_text(text.replace('{ crank_pin = "-74 deg", rocker_bearing = "147 deg" }', '"home"'))
    assert "home" in invoke(file, "--workers", "1").output
