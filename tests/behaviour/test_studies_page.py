"""The examples of docs/studies.md run as they stand, and say what they should."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

PAGE = Path(__file__).parents[2] / "docs" / "studies.md"


@pytest.fixture(scope="module")
def blocks() -> dict[str, str]:
    text = PAGE.read_text(encoding="utf-8")
    examples = text[text.index("## Examples") :]
    parts = re.split(r"^### (.*)$", examples, flags=re.M)[1:]
    return {
        title: "\n".join(re.findall(r"```python\n(.*?)```", body, flags=re.S))
        for title, body in zip(parts[::2], parts[1::2], strict=True)
    }


def test_the_first_example_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {"__name__": "studies_page"}
    code = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.S)[0]
    exec(compile(code, str(PAGE), "exec"), names)
    found = names["study"].dataset.bending
    np.testing.assert_allclose(found, np.outer(np.tan(found.angle), found.torque), rtol=1e-12)


@pytest.mark.campaign
@pytest.mark.slow
def test_examples_run_one_after_the_other(blocks: dict[str, str], capsys: Any) -> None:
    names: dict[str, Any] = {"__name__": "studies_page"}
    found = {}
    for title, code in blocks.items():
        assert code, title
        exec(compile(code, str(PAGE), "exec"), names)
        found[title.split()[0]] = names["data"]
    assert "one call of sweep" in capsys.readouterr().out
    # In line but for one joint, the shaft passes on its torque times the tangent of the angle.
    forces = found["Bearing"]
    last = forces.bending.sel({"held.fork_phase": 0.0})
    expected = 100.0 * np.tan(forces["held.joint_angle_1"])
    diagonal = [float(last[index, index]) for index in range(last.shape[0])]
    np.testing.assert_allclose(diagonal, expected, rtol=1e-6)
    errors = found["Assembly"]
    assert errors.sizes["sample"] == 64 * 7
    assert 0.0 < float(errors.residual_angle.median()) < np.deg2rad(10.0)
    platform = found["Workspace"]
    assert 0.0 < float((platform.state == 2).mean()) < 0.9
    # The legs bring the platform to where it should be.
    place, balls = np.array([0.1, -0.1, 0.1]), names["balls"]
    lengths = np.linalg.norm(balls + place - names["feet"], axis=1) - names["rest"]
    moved = names["robot"].sweep(lengths[None])
    for index in range(2, 7):
        np.testing.assert_allclose(
            moved.origin(f"ball_{index}")[0], balls[index - 1] + place, atol=1e-8
        )
    there = platform.force.sel(x=0.1, y=-0.1, z=0.1, method="nearest")
    np.testing.assert_allclose(there, np.abs(moved.drive_effort).max(), rtol=1e-9)
    # Speeds go with the root of the stiffness; damping and whirl change that by little.
    speeds = found["Critical"].speed
    ratio = np.sqrt(found["Critical"].stiffness / found["Critical"].stiffness[0])
    np.testing.assert_allclose(speeds[:, 0] / speeds[0, 0], ratio, rtol=0.01)
    assert found["A"]["bearing_out.bending"].shape == (300_000,)
