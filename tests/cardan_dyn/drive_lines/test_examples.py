"""Examples: each line that comes with the package loads, is held, and gets a verdict."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from cardan_dyn.drive_lines import DriveLine, examples
from cardan_dyn.kit.errors import ModelError

FAILED = {
    "paper_machine": set(),
    "pto": set(),
    "rolling_mill": set(),
    "truck": set(),
}
"""Rules and places at which each line misses a limit."""


def test_names() -> None:
    assert set(examples()) == set(FAILED)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(FAILED))
def test_verdict(name: str) -> None:
    line = DriveLine.from_toml(name)
    assert line.name == name
    assert line.indeterminate == ()
    found = line.verdict()
    assert {(row.rule, row.where) for row in found.failed} == FAILED[name]
    assert sum(row.status == "pass" for row in found) >= 15
    assert {"bearing_forces", "uniformity", "accelerations"} <= {row.rule for row in found}
    # The closed form is that of the shock torque alone, without friction, inertia and weight.
    hardest = max([abs(p.torque) for p in line.duty_cycle] + [abs(line.torque or 0.0)])
    shock = line.analyse(speed=0.0, torque=hardest * (line.service_factor or 1.0))
    at_rest = dict(zip(shock.bearings, shock.static.bearing_radial.max(axis=0), strict=True))
    for row in found:
        if row.rule == "bearing_forces" and row.rule_value:
            assert at_rest[row.where] == pytest.approx(row.rule_value, rel=3e-4)
            assert row.value > row.rule_value


@pytest.mark.parametrize("name", sorted(FAILED))
def test_analysis_proves_itself(name: str) -> None:
    line = DriveLine.from_toml(name)
    found = line.analyse(speed=50.0, torque=1000.0)
    assert found.balance_residual < 1e-9
    assert found.loop_residual < 1e-9
    assert DriveLine.from_toml(line.to_toml()) == line


@pytest.mark.slow
def test_the_paper_machine_is_a_spatial_z() -> None:
    line = DriveLine.from_toml("paper_machine")
    steep = math.atan(math.hypot(math.tan(math.radians(3.5)), math.tan(math.radians(4.0))))
    assert line.joint_angles == pytest.approx([steep, steep], rel=1e-12)
    assert line.verdict().rows  # Equal angles in one plane, however it stands:
    residual = next(row for row in line.verdict() if row.quantity == "residual angle")
    assert residual.value == pytest.approx(0.0, abs=1e-9)
    assert residual.broken == ()


def test_files_come_first_and_unknown_names_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(ModelError, match="did you mean 'truck'"):
        DriveLine.from_toml("truk")
    monkeypatch.chdir(tmp_path)
    Path("truck").write_text("[[shafts]]\n[[shafts]]\n", encoding="utf-8")
    assert DriveLine.from_toml("truck").name == "drive_line"
