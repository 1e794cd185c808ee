"""What results have in common."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Mapping
from dataclasses import FrozenInstanceError, dataclass
from pathlib import Path

import numpy as np
import pytest
from testkit import elastic_rigs

from cardan_dyn import ArgumentError, CardanError, vibration
from cardan_dyn.core.results.table import Table
from cardan_dyn.motion.vibration.results.result import VibrationResult


@dataclass(frozen=True, eq=False)
class Some(VibrationResult):
    values: np.ndarray
    speed: float
    count: int
    names: tuple[str, ...]
    held: Mapping[str, np.ndarray]
    other: object = None


@pytest.fixture
def some() -> Some:
    return Some(np.arange(3.0), 2.5, 7, ("a", "b"), {"angle": np.ones(2)}, object)


@pytest.mark.slow
def test_headlines_count_speeds_without_a_motion() -> None:
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(damping_in=0.01), np.radians(10.0))
    for find in (vibration.campbell, vibration.forced_response, vibration.periodic_motion):
        some, every = (find(scene, [0.5, 0.8], max_amplitude=most) for most in (0.02, 1.0))
        assert "2 speeds, 1 of them without a motion" in repr(some)
        assert "2 speeds" in repr(every) and "without" not in repr(every)


def test_nothing_can_be_changed(some: Some) -> None:
    with pytest.raises(FrozenInstanceError):
        some.speed = 1.0  # type: ignore[misc]
    for twin in (some, copy.deepcopy(some), copy.copy(some), pickle.loads(pickle.dumps(some))):
        with pytest.raises(ValueError, match="read-only"):
            twin.values[0] = 1.0


def test_files(some: Some, tmp_path: Path) -> None:
    some.save(tmp_path / "some.npz")
    with np.load(tmp_path / "some.npz") as stored:
        assert set(stored) == {"values", "speed", "count", "names", "held.angle"}
        assert stored["speed"] == 2.5
        assert stored["count"] == 7
    with pytest.raises(CardanError, match="cannot be written"):
        some.save(tmp_path / "missing" / "some.npz")
    with pytest.raises(ArgumentError, match="expected a path"):
        some.save(3)  # type: ignore[arg-type]


def test_tables_of_rows(some: Some, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    units = {"speed": "rad/s", "kind": ""}
    full = Table.of_rows([{"speed": 1.0, "kind": "a"}], units)
    frame = full.to_dataframe()
    assert frame.attrs["units"] == units
    assert frame.speed.tolist() == [1.0]
    assert full.to_xarray().kind.values.tolist() == ["a"]
    assert list(Table.of_rows([], units).to_dataframe().columns) == ["speed", "kind"]
    monkeypatch.setattr(Some, "table", lambda self: full)
    assert "speed [rad/s]" in some.save(tmp_path / "some.csv").read_text(encoding="utf-8")
