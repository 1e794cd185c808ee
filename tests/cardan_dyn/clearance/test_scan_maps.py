"""Maps over speed and bend angle, against single scans."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from testkit.pin_rigs import scene

from cardan_dyn import ArgumentError
from cardan_dyn.clearance import ScanMap, scan, scan_map

GIVEN: dict[str, Any] = {
    "radius": 0.018,
    "clearance": 2e-5,
    "stiffness": 2e8,
    "bearings": "pin_in",
    "damping_ratio": 0.2,
}
SPEEDS, ANGLES = [100.0, 200.0], np.radians([10.0, 0.0, 30.0])


@pytest.fixture(scope="module")
def found() -> ScanMap:
    return scan_map(scene("thoma_rig", 0.1), SPEEDS, "cross", held={"joint_angle": ANGLES}, **GIVEN)


@pytest.mark.slow
def test_every_cell_is_a_scan(found: ScanMap) -> None:
    assert found.peak.shape == (3, 2)
    for row, beta in enumerate(ANGLES):
        for column, speed in enumerate(SPEEDS):
            one = scan(scene("thoma_rig", float(beta)), speed, joints="cross", **GIVEN)["cross"]
            assert found.peak[row, column] == pytest.approx(one.peak, rel=1e-9, abs=1e-9)
            assert found.rigid_peak[row, column] == pytest.approx(one.rigid_peak, abs=1e-9)
            assert found.impacts[row, column] == pytest.approx(one.impacts_per_turn)
            assert found.impact_power[row, column] == pytest.approx(one.impact_power, rel=1e-9)
    np.testing.assert_allclose(found.impacts, [[4.0, 4.0], [0.0, 0.0], [4.0, 4.0]])
    assert len(list(found)) == 6


@pytest.mark.slow
def test_rigid_forces_grow_with_the_square_of_the_speed(found: ScanMap) -> None:
    np.testing.assert_allclose(found.rigid_peak[[0, 2], 1], 4.0 * found.rigid_peak[[0, 2], 0])
    assert np.all(found.peak[[0, 2]] > found.rigid_peak[[0, 2]])


def test_table_and_text(found: ScanMap) -> None:
    frame = found.to_dataframe()
    assert len(frame) == 6
    np.testing.assert_allclose(frame["joint_angle"], np.repeat(ANGLES, 2))
    np.testing.assert_allclose(frame["speed"], np.tile(SPEEDS, 3))
    np.testing.assert_allclose(frame["peak"], found.peak.ravel())
    assert frame["tau"].isna().sum() == 2
    assert str(found).startswith("clearance in cross\n- joint_angle")
    assert found.units == {"joint_angle": "rad"}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"speed": []}, "speed has shape"),
        ({"speed": [100.0, 0.0]}, "speed is 0"),
        ({"held": {}}, "held gives no positions"),
        ({"held": {"joint_angle": [[0.1]]}}, "has shape"),
        ({"held": {"bearing_out": [0.1]}}, "'bearing_out' is not held"),
        ({"held": {"joint_angle": [0.1, 0.2], "slip": [0.1]}}, "different numbers"),
    ],
)
def test_bad_input(changes: dict[str, Any], message: str) -> None:
    given = {"speed": SPEEDS, "held": {"joint_angle": ANGLES}, **GIVEN, **changes}
    with pytest.raises(ArgumentError, match=message):
        scan_map(scene("thoma_rig", 0.1), given.pop("speed"), "cross", **given)
