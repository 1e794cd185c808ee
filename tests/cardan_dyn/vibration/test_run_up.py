"""Run-ups through resonances."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from driven_shaft import DrivenShaft
from scipy.optimize import OptimizeResult
from testkit import elastic_rigs

import cardan_dyn as cd
from cardan_dyn import ArgumentError, VibrationError, vibration

pytestmark = pytest.mark.slow

BETA = np.radians(25.0)
TORQUE = 2e-5


def test_a_slow_run_up_follows_the_prediction() -> None:
    line = elastic_rigs.torsional_line(damping_in=0.2)
    found = vibration.run_up(elastic_rigs.scene(line, np.radians(10.0)), 0.35, 0.65, 2400.0)
    expected = np.interp(found.window, found.predicted_speed, found.predicted[:, 0])
    np.testing.assert_allclose(found.envelope[2:, 0], expected[2:], rtol=0.03)
    assert found.captured_by is None
    assert found.speed[-1] == pytest.approx(0.65)
    # Of the greatest swing, in a wide resonance, the averaged equation misses little.
    np.testing.assert_allclose(found.linear, found.predicted, rtol=0.05)
    frame = found.to_dataframe()
    assert len(frame) == len(found.window)
    assert found.plot().axes
    with pytest.raises(ArgumentError, match="'twist' is not free; free: twist_in"):
        found.plot("twist")
    assert pickle.loads(pickle.dumps(found)).free == ("twist_in",)
    assert "0.35 to 0.65" in repr(found)


def test_a_fast_run_up_stays_below_the_steady_resonance() -> None:
    line = elastic_rigs.torsional_line(damping_in=0.02)
    scene = elastic_rigs.scene(line, np.radians(5.0))
    found = vibration.run_up(scene, 0.4, 0.6, 150.0)
    assert np.max(found.envelope) < 0.8 * np.nanmax(found.predicted)
    late = found.window[np.argmax(found.envelope[:, 0])]
    assert late > found.predicted_speed[np.nanargmax(found.predicted[:, 0])]


@pytest.fixture(scope="module")
def scene() -> cd.Scene:
    return elastic_rigs.scene(elastic_rigs.elastic_rig(), BETA)


@pytest.fixture(scope="module")
def captured(scene: cd.Scene) -> vibration.RunUp:
    return vibration.run_up(scene, 0.5, 0.53, 2600.0, torque=TORQUE)


def late_speed(found: OptimizeResult) -> float:
    """Mean speed of the drive over the last fifth, in whole half turns."""
    ends = np.linspace(0.8 * found.t[-1], found.t[-1], 20001)
    turned = found.sol(ends)[0]
    marks = np.pi * np.arange(np.ceil(turned[0] / np.pi), turned[-1] / np.pi)
    return float(np.pi * (len(marks) - 1) / np.ptp(np.interp(marks[[0, -1]], turned, ends)))


def upright(speed: float) -> np.ndarray:
    return np.array([0.0, 0.0, 0.0, speed, 0.0, 0.0])


@pytest.fixture(scope="module")
def by_hand() -> OptimizeResult:
    return DrivenShaft(BETA, lambda speed: TORQUE).run(upright(0.5), 2600.0)


@pytest.mark.campaign
def test_a_weak_torque_is_captured_where_equations_by_hand_are(
    captured: vibration.RunUp, by_hand: OptimizeResult
) -> None:
    expected = late_speed(by_hand)
    assert captured.captured_speed == captured.settled_speed == pytest.approx(expected, rel=2e-5)
    by = captured.captured_by
    assert by is not None and by in captured.barriers
    assert (by.order, by.whirl, by.is_passed) == (2.0, "forward", False)
    assert by.holds == pytest.approx(expected, rel=2e-5)
    assert by.available == pytest.approx(TORQUE)
    assert expected < by.speed < 0.514
    assert captured.predicted_lack == pytest.approx(captured.predicted_torque - TORQUE)
    assert "captured at 0.5102 rad/s by order 2, mode 2 (forward)" in repr(captured)
    assert str(captured).count("\n") == len(captured.barriers)


@pytest.mark.campaign
@pytest.mark.parametrize(("factor", "passes"), [(0.98, False), (1.03, True)])
def test_the_barrier_parts_torques_of_equations_by_hand(
    captured: vibration.RunUp, by_hand: OptimizeResult, factor: float, passes: bool
) -> None:
    """The torque of a shaft that was captured is raised to beside the barrier."""
    by = captured.captured_by
    assert by is not None
    shaft = DrivenShaft(BETA, lambda speed: factor * by.torque)
    found = shaft.run(by_hand.y[:, -1], 5000.0, until=0.53, rtol=1e-8)
    assert bool(found.t[-1] < 5000.0) is passes
    if not passes:
        assert late_speed(found) < by.speed


@pytest.mark.campaign
def test_a_torque_beyond_the_barrier_ends_at_the_last_speed(scene: cd.Scene) -> None:
    found = vibration.run_up(scene, 0.5, 0.53, 9000.0, torque=4e-5)
    assert found.time[-1] < 9000.0
    assert found.window[-1] == pytest.approx(0.53, rel=5e-3)
    assert found.captured_by is None
    assert np.isnan(found.captured_speed) and np.isnan(found.settled_speed)
    (barrier,) = found.barriers
    assert barrier.is_passed and np.isnan(barrier.holds)


@pytest.mark.campaign
def test_a_motor_is_captured_on_its_line(scene: cd.Scene) -> None:
    def line(speed: float) -> float:
        return 1e-3 * (0.535 - speed)

    found = vibration.run_up(scene, 0.5, 0.53, 2000.0, torque=line)
    expected = late_speed(DrivenShaft(BETA, line).run(upright(0.5), 2000.0))
    assert found.captured_speed == pytest.approx(expected, rel=1e-5)
    by = found.captured_by
    assert by is not None and by.holds == pytest.approx(expected, rel=1e-5)
    # A falling line lacks most beyond the greatest torque.
    assert by.available == pytest.approx(line(by.speed), rel=1e-3)
    given = found.predicted_torque - found.predicted_lack
    assert given == pytest.approx([line(x) for x in found.predicted_speed], rel=1e-2)


@pytest.mark.campaign
def test_a_drive_too_weak_for_its_start_falls_back_to_where_it_is_held(
    scene: cd.Scene, captured: vibration.RunUp
) -> None:
    found = vibration.run_up(scene, 0.5125, 0.53, 2000.0, torque=TORQUE)
    assert found.captured_speed == pytest.approx(captured.captured_speed, rel=2e-5)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_torque_against_the_speed_brings_the_drive_to_rest(sense: float) -> None:
    """Shafts in line: at rest after J w / T."""
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(0.5, 0.5, damping_in=0.2), 0.0)
    inertia = 1.0 + 0.5 + 0.5  # The driven end, the fork and the flywheel.
    with pytest.raises(VibrationError, match="bearing_in comes to rest after") as caught:
        vibration.run_up(scene, 0.6 * sense, 0.9 * sense, 500.0, torque=-0.01 * sense)
    assert caught.value.speed == 0.6 * sense
    found = float(str(caught.value).split("after ")[1].split(" s")[0])
    assert found == pytest.approx(inertia * 0.6 / 0.01, rel=0.02)


@pytest.mark.campaign
def test_a_load_of_the_drive_counts(scene: cd.Scene, captured: vibration.RunUp) -> None:
    loaded = scene.replace(loads={"bearing_in": -0.5 * TORQUE})
    found = vibration.run_up(loaded, 0.5, 0.53, 100.0, torque=1.5 * TORQUE)
    (mine,), (other,) = found.barriers, captured.barriers
    assert mine.torque == pytest.approx(other.torque + 0.5 * TORQUE, rel=1e-7)
    assert mine.holds == pytest.approx(other.holds, rel=1e-8)
    turns = len(found.window)
    assert found.window == pytest.approx(captured.window[:turns], rel=1e-5)


@pytest.mark.campaign
def test_a_motor_that_reaches_its_own_speed_is_not_captured() -> None:
    """Far from any resonance its line and the losses decide."""
    line = elastic_rigs.torsional_line(damping_in=0.2)
    found = vibration.run_up(
        elastic_rigs.scene(line, np.radians(10.0)), 1.6, 2.5, 800.0, torque=lambda w: 0.1 * (2 - w)
    )
    assert found.settled_speed == pytest.approx(2.0, rel=1e-3)
    assert found.captured_by is None


def test_barriers_of_a_prescribed_run_say_what_torque_it_takes(captured: vibration.RunUp) -> None:
    found = vibration.run_up(captured.scene, 0.47, 0.53, 300.0)
    assert [(item.order, item.whirl) for item in found.barriers] == [
        (2.0, "backward"),
        (2.0, "forward"),
    ]
    assert all(item.is_passed and np.isnan(item.available) for item in found.barriers)
    assert np.isnan(found.settled_speed) and found.captured_by is None
    # At constant speed the drive cannot give way, so that the joint shakes more.
    assert found.barriers[1].torque > 1.15 * captured.barriers[0].torque


def test_results_of_a_captured_run(captured: vibration.RunUp, tmp_path: Path) -> None:
    (axes,) = captured.plot.torque().axes
    labels = [text.get_text() for text in axes.figure.legends[0].get_texts()]
    assert labels == ["absorbed", "of the drive", "barrier", "held"]
    by = captured.captured_by
    assert by is not None
    (held,) = (line for line in axes.lines if line.get_label() == "held")
    assert held.get_xdata()[0] == pytest.approx(by.holds * 30.0 / np.pi)
    # Within a turn the drive gives way, which its mean speed leaves out.
    late = captured.time > 0.9 * captured.time[-1]
    assert np.ptp(captured.speed[late]) > 0.008
    assert np.ptp(captured.mean_speed[late]) < 1e-5
    captured.save(tmp_path / "run.npz")
    stored = np.load(tmp_path / "run.npz")
    assert stored["settled_speed"] == captured.captured_speed
    assert stored["barriers.speed"] == pytest.approx([item.speed for item in captured.barriers])
    assert pickle.loads(pickle.dumps(captured)).captured_by == captured.captured_by


@pytest.mark.parametrize(
    "torque", ["much", np.nan, [1.0, 2.0], lambda speed: np.nan, lambda speed: 1 / 0]
)
def test_torques_that_are_none(scene: cd.Scene, torque: object) -> None:
    with pytest.raises(ArgumentError, match="torque"):
        vibration.run_up(scene, 0.5, 0.53, 10.0, torque=torque)  # type: ignore[arg-type]
