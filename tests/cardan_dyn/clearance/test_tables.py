"""Tables of all results: the numbers of the results, with units, as both kinds and as files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from testkit.loose_needle_drive import JOINT, scanned, simulated
from testkit.pin_rigs import scene

from cardan_dyn.clearance import ComparedReversal, ScanComparison, influence, scan, scan_map

PINS: dict[str, Any] = {"radius": 0.05, "clearance": 1e-5, "stiffness": 1e8, "bearings": "pin_in"}


def results() -> dict[str, Any]:
    rig = scene("thoma_rig", 0.3)
    item = scanned()[JOINT].reversals[0]
    compared = ComparedReversal(JOINT, item, np.array([1.0, 2.0]))
    cross = scan(rig, 150.0, joints="cross", **PINS)
    return {
        "scan": scanned(),
        "joint": scanned()[JOINT],
        "cross": cross["cross"],
        "map": scan_map(rig, [100.0, 150.0], "cross", held={"joint_angle": [0.2, 0.3]}, **PINS),
        "influence": influence(scanned()[JOINT].reversals[0], "stiffness"),
        "simulation": simulated(),
        "contact": simulated()[JOINT],
        "comparison": ScanComparison([compared]),
    }


@pytest.fixture(scope="module")
def every() -> dict[str, Any]:
    return results()


@pytest.mark.slow
def test_every_variable_has_units_and_every_table_a_file(
    every: dict[str, Any], tmp_path: Path
) -> None:
    pytest.importorskip("xarray")
    for name, result in every.items():
        data = result.to_xarray()
        assert data.data_vars
        for one in data.data_vars.values():
            assert {"units", "long_name"} <= set(one.attrs)
        assert set(result.to_dataframe().attrs["units"]) == set(result.to_dataframe())
        for suffix in (".csv", ".json", ".nc"):
            assert result.save(tmp_path / f"{name}{suffix}").stat().st_size > 100


@pytest.mark.slow
def test_numbers_are_those_of_the_results(every: dict[str, Any]) -> None:
    pytest.importorskip("xarray")
    found = scanned()
    table = every["scan"].to_xarray()
    peaks = [item.peak for name in found.ranking for item in found[name].reversals]
    assert max(peaks) == found[found.ranking[0]].peak
    np.testing.assert_array_equal(table.peak, peaks)
    assert table.peak.attrs["units"] == "N" and table.attrs["speed"] == found.speed
    pin = found[JOINT]
    np.testing.assert_array_equal(every["joint"].to_xarray().force[:, 0], pin.force)
    assert f"{JOINT}.force_x" in every["joint"].to_dataframe()
    cross = every["cross"].to_xarray().force
    assert cross.bearing.values.tolist() == ["pin_in+", "pin_in-"]
    np.testing.assert_array_equal(cross, every["cross"].force)
    mapped = every["map"].to_xarray()
    np.testing.assert_array_equal(mapped.peak, every["map"].peak)
    assert mapped.peak.dims == ("design", "speed")
    assert mapped.joint_angle.attrs["units"] == "rad"
    touched = every["simulation"].to_xarray()
    impacts = simulated().impacts
    np.testing.assert_array_equal(touched.peak, [item.peak for item in impacts])
    np.testing.assert_array_equal(touched.direction, [item.direction for item in impacts])
    assert touched.speed.attrs["units"] == "m/s"
    course = every["contact"].to_xarray()
    np.testing.assert_array_equal(course.orbit, simulated()[JOINT].orbit)
    assert {"orbit_1", "offset_z"} <= set(every["contact"].to_dataframe())
    varied = every["influence"].to_xarray()
    assert varied.value.attrs["units"] == "N/m"
    np.testing.assert_array_equal(varied.peak, every["influence"].peak)


def test_nothing_that_swings_is_one_row_of_a_whole_turn() -> None:
    still = scan(scene("thoma_rig", 0.0, -5.0), 150.0, joints="cross", **PINS)
    (row,) = still.rows()
    assert row["peak"] == row["rigid_ahead"] == still["cross"].rigid_peak > 0.0
    assert still["cross"].verdict == row["verdict"]
