"""Periodic motions under a torque, against integration of equations by hand."""

from __future__ import annotations

import numpy as np
import pytest
from driven_shaft import DrivenShaft
from testkit import elastic_rigs

import cardan_dyn as cd
from cardan_dyn import VibrationError
from cardan_dyn.core.elements.law import Law
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene
from cardan_dyn.motion.vibration.motions.driven import Driven, DrivenMotions, drive_torque
from cardan_dyn.motion.vibration.motions.harmonic_balance import Motions
from cardan_dyn.motion.vibration.motions.search import MotionSearch

BETA = np.radians(25.0)


def near(scene: cd.Scene, speeds: list[float], torque: Law | None) -> tuple[Driven, Motions]:
    search = MotionSearch(rotating_scene(scene))
    (motions,) = search.primary(np.array(speeds))
    return DrivenMotions(search, torque).of(motions), motions


@pytest.mark.slow
@pytest.mark.parametrize("slope", [0.0, 0.02])
def test_a_shaft_by_hand_comes_back_to_its_start(slope: float) -> None:
    """Under what the motion is said to absorb, after half a turn in the time of its mean speed."""

    def given(speed: np.ndarray) -> np.ndarray:
        return 1e-5 + slope * (0.5 - speed)

    scene = elastic_rigs.scene(elastic_rigs.elastic_rig(), BETA)
    found, _ = near(scene, [0.48, 0.512], drive_torque(given))
    for row, speed in enumerate(found.speed.tolist()):
        lack = float(found.lack[row])
        shaft = DrivenShaft(BETA, lambda w, lack=lack: given(w) + lack)  # type: ignore[misc]
        start = np.r_[0.0, found.position[row, 0], found.pace[row, 0], found.rate[row, 0]]
        end = shaft.run(start, np.pi / speed, rtol=1e-12).y[:, -1]
        np.testing.assert_allclose(end - start, [np.pi, 0, 0, 0, 0, 0], atol=2e-9)
        # The drive gives way, by some hundredths: the test would see it held at speed.
        assert np.ptp(found.pace[row]) > 0.01 * speed
        mean = np.mean(given(found.pace[row]))
        assert found.torque[row] == pytest.approx(mean + lack, rel=1e-6)


def test_a_drive_that_is_held_asks_for_the_mean_effort() -> None:
    scene = elastic_rigs.scene(elastic_rigs.elastic_rig(), BETA)
    found, motions = near(scene, [0.5], None)
    np.testing.assert_array_equal(found.pace, 0.5)
    np.testing.assert_array_equal(found.position, motions.course.q)
    np.testing.assert_allclose(found.rate, 0.5 * motions.course.rate, atol=1e-13)
    # Dampers turn all of its power into heat.
    power = 0.02 * np.mean(np.sum(found.rate**2, axis=2), axis=1)
    assert found.torque * 0.5 == pytest.approx(power, rel=1e-6)
    assert found.lack == pytest.approx(found.torque)


@pytest.mark.slow
def test_a_weight_on_the_input_shaft_asks_once_a_turn() -> None:
    """The efforts of the free coordinates repeat after half a turn, that of the drive does not."""
    heavy = '<link name="shaft_in"><inertial>'
    urdf = elastic_rigs.elastic_rig().replace(heavy, f'{heavy}<origin xyz="0 0.01 0"/>')
    scene = elastic_rigs.scene(urdf, BETA, gravity=[0.0, -1.0, 0.0])
    found, motions = near(scene, [0.55], drive_torque(0.0))
    assert motions.model.divisor == 2
    assert found.pace.shape[1] > 2 * motions.model.count
    run = scene.replace(free=scene.coordinates).simulate(
        2.0 * np.pi / 0.55,
        position=np.r_[0.0, found.position[0, 0]],
        speed=np.r_[found.pace[0, 0], found.rate[0, 0]],
        loads={"bearing_in": float(found.torque[0])},
    )
    end = run.at([run.time[-1]])
    np.testing.assert_allclose(end.position[0, 1:], found.position[0, 0], atol=1e-8)
    np.testing.assert_allclose(end.position[0, 0], 2.0 * np.pi, atol=1e-8)
    np.testing.assert_allclose(end.speed[0], np.r_[found.pace[0, 0], found.rate[0, 0]], atol=1e-8)
    orders = np.abs(np.fft.rfft(found.pace[0]))
    assert orders[1] > orders[2] > 10.0 * orders[3]


@pytest.mark.slow
def test_a_drive_that_stands_still_within_a_turn_is_refused() -> None:
    heavy = '<link name="shaft_in"><inertial>'
    urdf = elastic_rigs.elastic_rig().replace(heavy, f'{heavy}<origin xyz="0 1 0"/>')
    scene = elastic_rigs.scene(urdf, BETA, gravity=[0.0, -1.0, 0.0])
    with pytest.raises(VibrationError, match=r"mean speed of 0\.55 rad/s: its inertia may be"):
        near(scene, [0.55], drive_torque(0.0))
