"""`cardan-dyn vibration`: critical speeds, figures and modes of rigs on springs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from testkit import elastic_rigs

import cardan_dyn as cd
from cardan_dyn.practice.command_line import main, vibration_command
from cardan_dyn.practice.command_line.vibration_command import (
    chart_of,
    found_speeds,
    mode_view,
    rig_scene,
    save_figures,
)
from cardan_dyn.vibration import Floquet, floquet

PER_MINUTE = 30.0 / np.pi
NATURAL, DAMPING_RATIO = 20.0, 0.05
KAPPA = np.tan(np.radians(5.0) / 2.0) ** 2


@pytest.fixture
def rig(tmp_path: Path) -> Path:
    """A flywheel behind a joint: linear, J = 1, ω_n = 20 rad/s."""
    path = tmp_path / "line.urdf"
    damping = 2.0 * DAMPING_RATIO * NATURAL
    text = elastic_rigs.torsional_line(0.4, 1.0, None, NATURAL**2, damping_out=damping)
    path.write_text(text, encoding="utf-8")
    return path


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, ["vibration", *map(str, arguments)])


def test_resonance_of_a_linear_line(rig: Path) -> None:
    """ω_n/2 by the second order; the amplitude there is κ/(2ζ), a little more at its peak."""
    ends = 8.0 * PER_MINUTE, 12.0 * PER_MINUTE
    found = run(
        *(rig, "--drive", "bearing_in", "--held", "joint_angle=5", "--speed", *ends, "--json")
    )
    assert found.exit_code == 0, found.output
    content = json.loads(found.stdout)
    assert (content["drive"], content["free"]) == ("bearing_in", ["twist_out"])
    (row,) = content["critical_speeds"]
    assert (row["kind"], row["order"], row["mode"]) == ("resonance", 2.0, 1)
    assert row["speed"] == pytest.approx(NATURAL / 2.0, rel=0.01)
    assert row["severity"] == pytest.approx(KAPPA / (2.0 * DAMPING_RATIO), rel=0.01)
    assert row["amplification"] == pytest.approx(1.0 / (2.0 * DAMPING_RATIO), rel=1e-3)
    # Numbers that JSON does not have, as the frequency of an instability, are null.
    assert "NaN" not in found.stdout and "Infinity" not in found.stdout


@pytest.mark.slow
def test_table_figures_and_mode(rig: Path, tmp_path: Path) -> None:
    ends = 9.0 * PER_MINUTE, 11.0 * PER_MINUTE
    directory, page = tmp_path / "figures", tmp_path / "mode.html"
    found = run(
        *(rig, "--drive", "bearing_in", "--held", "joint_angle=5", "--speed", *ends),
        *("--figures", directory, "--mode", 1, "--export", page),
    )
    assert found.exit_code == 0, found.output
    assert "2× mode 1" in found.output and "[rad, of slides m]" in found.output
    names = {"campbell", "orders", "multipliers"}
    assert {path.stem for path in directory.glob("*.png")} == names
    assert "torsional_line: mode 1, 3.179 Hz" in page.read_text(encoding="utf-8")


def test_nothing_critical_is_said(rig: Path) -> None:
    found = run(rig, "--drive", "bearing_in", "--held", "joint_angle=5", "--speed", 10, 20)
    assert found.exit_code == 0, found.output
    assert "torsional_line: no critical speed from 10 to 20 1/min" in found.output


def test_scene_of_a_bundled_rig() -> None:
    """Presets hold the bend angle; springs make the free coordinates."""
    scene = rig_scene("elastic_thoma_rig")
    assert (scene.drives, scene.free) == (("bearing_in",), ("tilt_z", "tilt_y"))
    assert scene.held == {"joint_angle": pytest.approx(np.radians(8.5))}
    assert len(scene.elements) == 4
    other = rig_scene("torsional_line_both", held=("joint_angle=3", "twist_out=1"))
    assert other.coordinates == ("bearing_in", "twist_in")
    assert other.held == {
        "joint_angle": pytest.approx(np.radians(3.0)),
        "twist_out": pytest.approx(np.radians(1.0)),
    }
    assert chart_of(scene, "joint_angle=30") == ("joint_angle", pytest.approx(np.pi / 6.0))
    assert chart_of(scene, None) is None
    loaded = rig_scene("elastic_thoma_rig", loads=("bearing_out=-3",))
    assert loaded.loads == {"bearing_out": -3.0}


@pytest.mark.slow
def test_a_chart_spans_the_range_and_the_angles(
    rig: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    def recorded(scene: cd.Scene, speed: np.ndarray, **options: Any) -> Floquet:
        asked.append((speed, options))
        few = {name: {of: at[::12] for of, at in held.items()} for name, held in options.items()}
        return floquet(scene, speed[::20], **few)

    monkeypatch.setattr(vibration_command, "floquet", recorded)
    scene = rig_scene(str(rig), drive="bearing_in", held=("joint_angle=5",))
    found = found_speeds(scene, (9.0, 11.0))
    paths = save_figures(scene, found, tmp_path, ("joint_angle", 0.2))
    assert {path.stem for path in paths} == {"campbell", "orders", "multipliers", "chart"}
    (speed, options) = asked[-1]
    np.testing.assert_allclose(speed[[0, -1]], [9.0, 11.0])
    angles = options["held"]["joint_angle"]
    assert (angles[0], angles[-1]) == (0.0, 0.2) and np.ptp(np.diff(angles)) < 1e-15


def test_range_by_the_natural_frequencies(rig: Path) -> None:
    scene = rig_scene(str(rig), drive="bearing_in", held=("joint_angle=2",))
    found = found_speeds(scene, None, (2.0,))
    damped = NATURAL * np.sqrt(1.0 - DAMPING_RATIO**2)
    assert (found.low, found.high) == pytest.approx((0.2 * damped, 1.25 * damped), rel=1e-3)
    assert [row.order for row in found] == [2.0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("universal_joint",), "has no free coordinate: none of its joints has a spring"),
        (("elastic_thoma_rig", "--chart", "joint_angle=30"), "--chart needs --figures"),
        (("elastic_thoma_rig", "--export", "a.html"), "--export needs --mode"),
        (("elastic_thoma_rig", "--held", "joint_angle"), "--held 'joint_angle' is not"),
        (
            ("elastic_thoma_rig", "--chart", "tilt_z=3", "--figures", "there"),
            "--chart 'tilt_z' is not held; held: joint_angle",
        ),
    ],
)
def test_refused(arguments: tuple[str, ...], message: str) -> None:
    found = run(*arguments)
    assert found.exit_code != 0
    assert message in " ".join(found.output.split())


@pytest.mark.slow
def test_modes_are_numbered_as_in_the_table(rig: Path) -> None:
    scene = rig_scene("elastic_thoma_rig")
    found = found_speeds(scene, None, (2.0,))
    hertz = found.campbell.frequency[0] / (2.0 * np.pi)
    for number in (1, 2):
        page = mode_view(scene, number, found.low).html
        assert f"mode {number}, {hertz[number - 1]:.4g} Hz" in page
    with pytest.raises(cd.ArgumentError, match="--mode 3 does not exist; modes: 1 to 2"):
        mode_view(scene, 3, found.low)


def test_what_turns_has_to_be_known(rig: Path) -> None:
    with pytest.raises(cd.ArgumentError, match="nothing says what turns: give --drive"):
        rig_scene(str(rig), held=("joint_angle=5",))


def test_what_turns_is_known_where_one_joint_is_left(tmp_path: Path) -> None:
    file = tmp_path / "rotor.urdf"
    file.write_text(elastic_rigs.rotor(), encoding="utf-8")
    assert rig_scene(str(file)).coordinates == ("bearing_in", "y", "z")
    held = rig_scene(str(file), held=("z=0.001",))
    assert (held.coordinates, held.held) == (("bearing_in", "y"), {"z": 0.001})
    with pytest.raises(cd.ArgumentError, match="a spring, unless it is driven or held"):
        rig_scene(str(file), held=("y=0", "z=0"))
    # What is driven is not free besides.
    other = rig_scene(str(file), drive="y", held=("bearing_in=0",))
    assert (other.drives, other.free) == (("y",), ("z",))


def test_charts_of_slides_have_metres(tmp_path: Path) -> None:
    file = tmp_path / "rotor.urdf"
    file.write_text(elastic_rigs.rotor(), encoding="utf-8")
    scene = rig_scene(str(file), held=("z=0",))
    assert chart_of(scene, "z=0.002") == ("z", 0.002)
    with pytest.raises(cd.ArgumentError, match="--chart ends at 0, where it begins"):
        chart_of(scene, "z=0")


def test_data_stand_alone_on_standard_output(rig: Path, tmp_path: Path) -> None:
    page = tmp_path / "mode.html"
    found = run(
        *(rig, "--drive", "bearing_in", "--held", "joint_angle=5", "--speed", 10, 20, "--json"),
        *("--mode", 1, "--export", page),
    )
    assert found.exit_code == 0, found.output
    assert json.loads(found.stdout)["critical_speeds"] == []
    assert f"Scene: {page}" in found.stderr


@pytest.mark.slow
def test_jumps_and_remarks_stand_below_the_table() -> None:
    """In 1/min, as the table; as JSON in rad/s."""
    arguments = ("torsional_line_front", "--held", "joint_angle=20", "--order", 2)
    shown = run(*arguments, "--speed", 1060, 1066)
    assert shown.exit_code == 0, shown.output
    text = " ".join(shown.output.split())
    assert "2× mode 1 jumps at 1070.67 1/min while the speed rises (from 0.666), at 1057.0" in text
    assert "twist_in moves from -0.732 to 0.747 rad, beyond its limits -0.2 to 0.2" in text
    assert "fold" not in text.partition("severity:")[0]
    content = json.loads(run(*arguments, "--speed", 1055, 1075, "--json").stdout)
    (row,) = content["critical_speeds"]
    assert row["speed"] * PER_MINUTE == pytest.approx(1063.2, abs=0.05)
    assert row["rising"] * PER_MINUTE == pytest.approx(1070.67, abs=0.01)
    assert row["severity"] == pytest.approx(0.740, abs=5e-4)
    assert any("beyond its limits" in remark for remark in content["remarks"])
