"""Torque that motions absorb over speed, against dampers of equations by hand."""

from __future__ import annotations

import numpy as np
import pytest
from shooting import orders, periodic
from testkit import elastic_rigs
from tilting_shaft import TiltingShaft

from cardan_dyn import vibration
from cardan_dyn.core.elements.law import Law
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene
from cardan_dyn.motion.vibration.motions.driven import drive_torque
from cardan_dyn.motion.vibration.motions.search import MotionSearch
from cardan_dyn.motion.vibration.motions.steady_path import steady_path
from cardan_dyn.motion.vibration.results.torque_curve import TorqueCurve, half_swings

BETA = np.radians(20.0)


def curve(
    first: float, last: float, torque: Law | None = None, urdf: str | None = None
) -> TorqueCurve:
    scene = elastic_rigs.scene(urdf or elastic_rigs.elastic_rig(), BETA)
    search = MotionSearch(rotating_scene(scene))
    return TorqueCurve(search, steady_path(search, first, last), torque)


def heat(speed: float) -> float:
    """Power of the dampers over speed, d = 0.02, in the periodic motion by shooting."""
    system = TiltingShaft(BETA, speed)
    waves = orders(system, periodic(system, np.zeros(4)).start, 64)
    order = 2.0 * np.fft.fftfreq(64, 1.0 / 64)
    rates = speed * order[:, None] * np.abs(waves)
    return float(0.02 * np.sum(rates**2) / speed)


@pytest.mark.campaign
@pytest.mark.slow
def test_the_torque_is_what_dampers_turn_into_heat() -> None:
    held = curve(0.24, 0.26)
    found = held.predicted()
    for row in range(0, len(found.predicted_speed), 7):
        speed = float(found.predicted_speed[row])
        assert found.predicted_torque[row] == pytest.approx(heat(speed), rel=1e-6)
    np.testing.assert_array_equal(found.predicted_lack, found.predicted_torque)
    (barrier,) = held.barriers(found)
    assert (barrier.order, barrier.whirl, barrier.is_passed) == (4.0, "forward", True)
    # No speed beside it takes more.
    near = barrier.speed + 1e-4 * np.array([-1.0, 0.0, 1.0])
    below, top, above = (heat(float(speed)) for speed in near)
    assert barrier.torque == pytest.approx(top, rel=1e-6)
    assert top > max(below, above)


@pytest.mark.slow
def test_barriers_are_met_in_the_order_of_the_run() -> None:
    up, down = curve(0.47, 0.53), curve(0.53, 0.47)
    rising, falling = (item.barriers(item.predicted()) for item in (up, down))
    assert [item.whirl for item in rising] == ["backward", "forward"]
    assert [item.whirl for item in falling] == ["forward", "backward"]
    for one, other in zip(rising, reversed(falling), strict=True):
        assert one.speed == pytest.approx(other.speed, rel=1e-5)
        assert one.torque == pytest.approx(other.torque, rel=1e-7)
    # Whirl, mode and speed are those of the table of critical speeds.
    scene = elastic_rigs.scene(elastic_rigs.elastic_rig(), BETA)
    table = vibration.critical_speeds(scene, [0.47, 0.53], orders=[2], instabilities=False)
    for row, item in zip(table, rising, strict=True):
        assert (row.mode, row.whirl) == (item.mode, item.whirl)
        assert item.speed == pytest.approx(row.speed, rel=2e-3)


@pytest.mark.slow
def test_backwards_it_is_the_same_with_other_signs() -> None:
    torque = drive_torque(4e-6)
    ahead = curve(0.505, 0.52, torque)
    back = curve(-0.505, -0.52, drive_torque(-4e-6))
    (one,), (other,) = (item.barriers(item.predicted()) for item in (ahead, back))
    assert other.speed == pytest.approx(-one.speed, rel=1e-6)
    assert other.torque == pytest.approx(-one.torque, rel=1e-7)
    assert 0.505 < one.holds < one.speed
    assert other.holds == pytest.approx(-one.holds, rel=1e-7)
    assert (one.whirl, other.whirl) == ("forward", "forward")


@pytest.mark.slow
def test_a_drive_that_slows_down_is_held_nowhere() -> None:
    falling = curve(0.53, 0.505, drive_torque(5e-6))
    (barrier,) = falling.barriers(falling.predicted())
    assert not barrier.is_passed and np.isnan(barrier.holds)


@pytest.mark.slow
def test_without_dampers_nothing_is_absorbed() -> None:
    free = curve(0.40, 0.42, urdf=elastic_rigs.elastic_rig(damping_ratio=0.0))
    found = free.predicted()
    assert np.max(np.abs(found.predicted_torque)) < 1e-15
    assert np.min(found.predicted) > 1e-4


def test_half_swings_are_read_between_the_nodes() -> None:
    turn = 2.0 * np.pi * np.arange(9) / 9 + 0.2
    q = np.stack([3.0 + np.cos(turn), np.sin(2.0 * turn)], axis=1)[None]
    assert half_swings(q) == pytest.approx(np.ones((1, 2)), rel=2e-5)
    assert np.all(half_swings(q) > 0.5 * np.ptp(q, axis=1) + 1e-3)
