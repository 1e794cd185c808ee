"""Tables of critical speeds."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from testkit import elastic_rigs

from cardan_dyn import ArgumentError, vibration
from cardan_dyn.vibration import CriticalSpeeds
from cardan_dyn.vibration.critical_speeds import _crossings


@pytest.fixture(scope="module")
def rig() -> CriticalSpeeds:
    scene = elastic_rigs.scene(elastic_rigs.elastic_rig(), np.radians(5.0))
    return vibration.critical_speeds(scene, [0.2, 0.6], instabilities=False)


def test_orders_two_and_four_of_thomas_rig(rig: CriticalSpeeds) -> None:
    rows = {(row.order, row.whirl): row for row in rig}
    for order, whirl, speed, size in (
        (2.0, "forward", 0.51303, 2.13018e-4),
        (2.0, "backward", 0.48789, 2.03884e-4),
        (4.0, "forward", 0.25320, 5.2991e-5),
    ):
        row = rows[order, whirl]
        assert row.speed == pytest.approx(speed, rel=1e-3)
        assert row.severity == pytest.approx(size, rel=5e-3)
        assert row.amplification == pytest.approx(50.0, rel=1e-2)
        assert row.frequency == pytest.approx(order * row.speed, rel=1e-3)
    assert rows[4.0, "backward"].severity < 0.01 * rows[4.0, "forward"].severity


@pytest.mark.parametrize("polar", [0.01])
def test_half_and_quarter_of_the_natural_frequency(polar: float) -> None:
    """Thoma's conclusion, where the shaft has hardly a gyroscopic effect."""
    scene = elastic_rigs.scene(elastic_rigs.elastic_rig(polar), np.radians(5.0))
    found = vibration.critical_speeds(scene, [0.2, 0.6], orders=(2, 4), instabilities=False)
    strong = [row for row in found if row.severity > 1e-8]
    assert {row.order for row in strong} == {2.0, 4.0}
    for row in strong:
        assert row.speed == pytest.approx(1.0 / row.order, rel=0.01)


def test_instabilities_stand_beside_resonances() -> None:
    line = elastic_rigs.torsional_line(damping_in=0.004)
    scene = elastic_rigs.scene(line, np.radians(15.0))
    found = vibration.critical_speeds(scene, [0.4, 1.2])
    kinds = {row.kind: row for row in found}
    assert kinds["instability"].lower == pytest.approx(0.9912, abs=1e-3)
    assert kinds["instability"].upper == pytest.approx(1.0085, abs=1e-3)
    assert kinds["resonance"].order == 2.0
    assert kinds["resonance"].speed == pytest.approx(0.5, abs=5e-3)


def test_undamped_resonances_have_no_bound() -> None:
    line = elastic_rigs.torsional_line(stiffness_in=None, stiffness_out=0.5)
    found = vibration.critical_speeds(
        elastic_rigs.scene(line, 0.1), [0.4, 0.6], orders=2, instabilities=False
    )
    (row,) = found
    assert row.speed == pytest.approx(0.5, abs=1e-6)
    assert row.severity == np.inf


def test_tables_figures_and_copies(rig: CriticalSpeeds, tmp_path: Path) -> None:
    frame = rig.to_dataframe()
    assert len(frame) == len(rig)
    assert np.all(np.diff(frame.speed) >= 0.0)
    assert "order 2 meets mode" in str(rig)
    assert rig.plot().axes
    for twin in (copy.deepcopy(rig), pickle.loads(pickle.dumps(rig))):
        assert twin.rows == rig.rows
    np.testing.assert_array_equal(rig.table["speed"], frame.speed)
    rig.save(tmp_path / "speeds.npz")
    with np.load(tmp_path / "speeds.npz") as stored:
        np.testing.assert_array_equal(stored["table.speed"], frame.speed)
        assert stored["orders"].tolist() == list(rig.orders)
        assert stored["drives"].tolist() == ["bearing_in", "tilt_z", "tilt_y"]
        np.testing.assert_array_equal(stored["campbell.frequency"], rig.campbell.frequency)


def test_what_is_asked_for_wrongly(rig: CriticalSpeeds) -> None:
    with pytest.raises(ArgumentError, match="two or more ascending"):
        vibration.critical_speeds(rig.scene, [0.6, 0.2])
    with pytest.raises(ArgumentError, match="orders is"):
        vibration.critical_speeds(rig.scene, [0.2, 0.6], orders=-1)


def test_half_power_of_a_whirl_that_runs_along_with_its_order() -> None:
    """Θ/A = 1.5, order 2 forwards: Ω = 1, p' = 1.2, so that it is 2 ζ wide to either side."""
    scene = elastic_rigs.scene(elastic_rigs.elastic_rig(1.5), np.radians(2.0))
    found = vibration.critical_speeds(scene, [0.8, 1.2], orders=2, instabilities=False)
    (row,) = found
    assert row.whirl == "forward"
    assert row.upper - row.lower == pytest.approx(0.04, rel=0.01)
    places = np.linspace(0.95, 1.05, 401)
    response = vibration.forced_response(scene, places, joints=[])
    # What drives it grows with the square of the speed.
    size = response.whirls("tilt_y", "tilt_z", 2)[0] / places**2
    inside = places[size > np.max(size) / np.sqrt(2.0)]
    assert inside[0] == pytest.approx(row.lower, abs=1.5e-3)
    assert inside[-1] == pytest.approx(row.upper, abs=1.5e-3)


def test_a_crossing_at_one_of_the_speeds_is_one() -> None:
    speed = np.array([0.4, 0.5, 0.6])
    ones = np.ones((3, 1))
    course = SimpleNamespace(speed=speed, frequency=ones)
    assert _crossings(course, 2.0, 0) == [(0.5, 2.0)]
    for part, count in ((slice(2), 1), (slice(1, None), 1), (slice(1), 0)):
        course = SimpleNamespace(speed=speed[part], frequency=ones[part])
        assert len(_crossings(course, 2.0, 0)) == count
