"""What the notebook on Thoma's critical speeds shows: orders, peaks, captures and instabilities."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from stories import tell

from cardan_dyn.analytic import parametric_regions, thoma, whirl

pytestmark = [pytest.mark.slow, pytest.mark.campaign]


@pytest.fixture(scope="module")
def story() -> SimpleNamespace:
    return tell("thoma_critical_speeds")


def test_the_orders_of_the_bending(story: SimpleNamespace) -> None:
    for order in (2, 4, 6):
        moment = whirl.moments_of_flywheel(story.beta, order, story.flywheel, story.speed)
        np.testing.assert_allclose(story.effort[order], moment.forward, rtol=1e-9)
        np.testing.assert_allclose(story.effort[-order], moment.backward, rtol=1e-7)
    # Order 2 turns both ways alike, order 4 forwards alone.
    two, four = (whirl.moments_of_flywheel(story.beta, order) for order in (2, 4))
    assert abs(two.backward / two.forward + 1.0) < 0.01
    assert abs(four.backward / four.forward) < 0.01
    assert abs(abs(story.effort[4]) / story.his_size - 1.0) < 0.01
    # Thoma's series once more: the exact orders behind his small angles.
    _, bend_x, bend_z = thoma.rig_harmonics(story.beta, [2, 4])
    np.testing.assert_allclose(bend_x[1] / bend_x[0], 0.5, rtol=0.01)
    np.testing.assert_allclose(bend_z[1], -bend_x[1], rtol=0.01)


def test_the_frequencies_part(story: SimpleNamespace) -> None:
    speeds = np.linspace(20.0, 330.0, 26)
    ahead, behind = whirl.whirl_frequencies(speeds, story.natural, story.ratio)
    # The damped rig at 5° beside the undamped shaft in line: a difference of the order of β²/8.
    closed = np.stack([behind, ahead], axis=1)
    np.testing.assert_allclose(story.frequencies, closed, rtol=story.beta**2 / 8.0)
    for (order, forward), at in story.critical.items():
        meets = np.interp(at, speeds, story.frequencies[:, int(forward)])
        np.testing.assert_allclose(order * at, meets, rtol=2e-3)


def test_the_response(story: SimpleNamespace) -> None:
    for (order, forward), (at, amplitude, height) in story.peaks.items():
        assert abs(at / story.critical[order, forward] - 1.0) < 3e-3
        assert abs(amplitude / height - 1.0) < 0.01
    # Where it does not resonate the linear forms agree as well as the angle is small.
    away = np.abs(story.speeds / story.critical[2, True] - 1.0) > 0.1
    ours, closed = story.orders[2, True][away], story.closed[2, True][away]
    np.testing.assert_allclose(ours, closed, rtol=5e-3)
    assert np.max(story.orders[4, False]) < 0.01 * np.max(story.orders[4, True])
    # His peaks are as high and elsewhere.
    for order, values in story.his_orders.items():
        top = story.speeds[np.argmax(values)]
        assert abs(top / (story.natural / order) - 1.0) < 3e-3


def test_orders_under_a_load(story: SimpleNamespace) -> None:
    closed = whirl.moments_of_output_torque(np.deg2rad(20.0), [2, 4], 100.0).forward
    np.testing.assert_allclose(story.series[[2, 4]], closed, rtol=1e-10)
    np.testing.assert_allclose(story.series[[-2, -4]], 0.0, atol=1e-10)
    for angle, share in ((5.0, 0.0019), (20.0, 0.0311)):
        two, four = whirl.moments_of_output_torque(np.deg2rad(angle), [2, 4]).forward
        assert abs(abs(four / two) - share) < 5e-5
    # Loads of shaft II that ask for the same torque of shaft I everywhere: by virtual work from
    # the rig's own motion, at many angles at once. Order 2 as above, and no fourth.
    assert whirl.moments_of_input_torque(np.deg2rad(40.0), 4) == (0.0, 0.0)
    betas = np.deg2rad([[5.0], [20.0], [60.0]])
    driven, positions = story.driven, story.held_upright
    many = driven.sweep(positions, held={"joint_angle": betas})
    even = {"bearing_out": -100.0 / many.motion.ratio("bearing_out")}
    turned = driven.sweep(positions, held={"joint_angle": betas}, loads=even)
    np.testing.assert_allclose(turned.drive_effort[..., 0], 100.0, rtol=1e-12)
    moment = turned.wrench("pin_out", "world").moment
    bend_x = moment[..., 0] * np.sin(betas) - moment[..., 1] * np.cos(betas)
    phi, scale = positions[:, 0], 100.0 * np.tan(betas)
    closed_x = 50.0 * np.sin(betas) * (1.0 + np.cos(2.0 * phi))
    np.testing.assert_allclose(bend_x / scale, closed_x / scale, atol=1e-12)
    closed_z = 0.5 * scale * np.sin(2.0 * phi)
    np.testing.assert_allclose(-moment[..., 2] / scale, closed_z / scale, atol=1e-12)


def test_a_weak_drive_is_captured(story: SimpleNamespace) -> None:
    barrier = story.weak.captured_by
    assert (barrier.order, barrier.whirl, round(barrier.torque, 2)) == (2.0, "forward", 0.30)
    assert abs(story.weak.captured_speed / barrier.holds - 1.0) < 2e-3


def test_flutter(story: SimpleNamespace) -> None:
    assert story.growth[0.98] < 1.0 < story.growth[1.02]


def test_the_shaft_in_front_of_the_joint(story: SimpleNamespace) -> None:
    region, zone, torsional = story.region, story.zone, story.torsional
    assert region.kind == "instability"
    # To the next order in β², and the inertia of the cross, 1 % of all.
    half = zone.damping * torsional
    assert abs(region.lower - zone.least * torsional) < 0.1 * half
    assert abs(region.upper - zone.greatest * torsional) < 0.1 * half
    # An elastic middle shaft of two joints: the full equation has 0.9696 to 1.0318 at 20°.
    low, high = parametric_regions.middle_shaft_region(np.deg2rad(20.0))
    assert abs(low - 0.9696) < 3e-4 and abs(high - 1.0318) < 3e-4
