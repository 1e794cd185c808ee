"""The benchmarks run, and their records have the fields that tables and plots need."""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mpmath")

from benchmarks import records, run, skipping, timing, universal_joint
from benchmarks.engines import common
from benchmarks.maps import picture, table, verdict
from benchmarks.stress import Point

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
FILES = sorted((ROOT / "benchmarks").glob("**/*.py"))
PHI = np.linspace(0.0, 2.0 * np.pi, 25)


@pytest.mark.filterwarnings("ignore")  # Other packages' warnings are theirs.
def test_engines_that_are_installed_agree_with_the_exact_moments() -> None:
    bounds = {"MuJoCo, defaults": 1e-2, "Drake, SAP": 1e-2, "MuJoCo, stiff": 1e-4}
    reference = universal_joint.exact(0.6, PHI)
    for method in common.engines():
        if method.once or "settled" in method.name:
            continue  # Takes too long for a test.
        found = method.prepare(0.6, PHI)()
        assert universal_joint.error(found, reference) < bounds.get(method.name, 1e-12), method.name


MEASURED = {
    "four_bars", "hammering", "long_time", "many_designs", "short_calls", "skipping",
    "stability_charts",
}  # fmt: skip
"""Tasks that other tests run in their short form, and look at what they measure."""


@pytest.mark.campaign
@pytest.mark.filterwarnings("ignore")  # Other packages' warnings are theirs.
@pytest.mark.parametrize("task", sorted(set(run.TASKS) - MEASURED))
def test_every_task_runs_as_a_command(
    task: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    """In its short form, with a table of numbers, and files where they are asked for."""
    monkeypatch.setattr(records, "RESULTS", records.RESULTS)
    run.main(["--fast", "--results", str(tmp_path), task])
    written = (tmp_path / f"{task}.md").read_text(encoding="utf-8")
    rows = [line.split("|")[1:-1] for line in written.splitlines() if line.startswith("| ")]
    assert len(rows) > 1
    assert any(re.search(r"\d(\.\d+)?(e[+-]\d+)?$", cell.strip()) for cell in rows[-1])
    out = capsys.readouterr().out
    assert out and "nan" not in out.lower().split()
    for found in tmp_path.glob("*.png"):
        assert found.stat().st_size > 5000


def test_skipping_has_complete_records() -> None:
    for record in skipping.measure(fast=True):
        assert record.microseconds and record.ratio and record.flat()["samples"] == 721


def test_candidates_take_turns_until_patience_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    """Short ones run several times in a turn, impatience ends a long one's turns."""
    clock = [0.0]
    monkeypatch.setattr(timing.time, "perf_counter", lambda: clock[0])
    calls: list[str] = []

    def candidate(name: str, seconds: float) -> None:
        calls.append(name)
        clock[0] += seconds

    costs = {"a": 0.004, "b": 1.0}
    runs = {name: partial(candidate, name, cost) for name, cost in costs.items()}
    found = timing.least_seconds(runs, repeats=4, patience=1.5)
    assert "".join(calls) == "aab" * 2 + "aa" * 2
    assert found == pytest.approx(costs)


def test_records_are_written_with_their_answer(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(records, "RESULTS", tmp_path)
    records.save("x", [records.Record("x", "y", error=1.0 / 3.0).flat()], "An answer.")
    text = (tmp_path / "x.json").read_text(encoding="utf-8")
    assert '"error": 0.3333' in text and '"answer": "An answer."' in text


def test_maps_say_what_is_beyond_its_bound(tmp_path: Path) -> None:
    good = Point("m", "c", 1.0, 1e-16, 1.0, 1e-16, 1e-16, 1e-16, 1e-16, 0.5)
    bad = Point("m", "c", 2.0, 1e-10, 1.0, 1e-16, 1e-16, 1e-16, 1e-10, 4e5)
    refused = Point("m", "c", 3.0, refused="AssemblyError")
    text = verdict([good, bad, refused], "Here.")
    assert "1 refused" in text and text.count("1 points") == 2 and "(c: 2)." in text
    assert "AssemblyError" in table([refused])
    picture([good, bad, refused], tmp_path / "m.png", "x")
    assert (tmp_path / "m.png").stat().st_size < 150_000


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_file_opens_with_its_question_or_purpose(path: Path) -> None:
    source = path.read_text(encoding="utf-8")
    assert source.startswith('"""')
    if path.stem.startswith("stress_") or path.stem in ("universal_joint", "double_shaft"):
        assert "?" in source.split("\n\n")[0]
