"""What Thoma's notebook shows: his directions, his bending moments, and the error of his forms."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from stories import tell

from cardan_dyn import figures
from cardan_dyn.analytic import single_joint, thoma


@pytest.fixture(scope="module")
def story() -> SimpleNamespace:
    return tell("thoma")


def test_the_main_positions(story: SimpleNamespace) -> None:
    alpha, torque = story.alpha, story.torque
    # Arms have two ends: which one is O P is a matter of drawing.
    for his, ours in zip(story.his_arms, story.arms, strict=True):
        np.testing.assert_allclose(np.abs(np.sum(his * ours, axis=1)), 1.0, atol=1e-13)
    np.testing.assert_allclose(
        story.moment, story.his_moment / row_norm(story.his_moment), atol=1e-12
    )
    np.testing.assert_allclose(story.moment, thoma.moment_cosines(alpha, story.phi), atol=1e-12)
    for arm in story.arms:
        np.testing.assert_allclose(np.sum(arm * story.moment, axis=1), 0.0, atol=1e-12)
    # Hauptlage A: M_b = M_t tg α. Hauptlage B: pure torsion.
    bending = story.turn["bearing_out"].bending
    np.testing.assert_allclose(bending[0], torque * np.tan(alpha), rtol=1e-13)
    np.testing.assert_allclose(bending[180], 0.0, atol=1e-12)
    # The moment is inclined by at least α/2 to one of the shafts (his first page).
    shafts = np.array([[-np.sin(alpha), -np.cos(alpha), 0.0], [0.0, -1.0, 0.0]])
    to_shafts = story.moment @ shafts.T
    assert np.all(np.min(to_shafts, axis=1) <= np.cos(0.5 * alpha) + 1e-14)


def row_norm(vectors: np.ndarray) -> np.ndarray:
    return np.linalg.norm(vectors, axis=1, keepdims=True)


def test_the_rotation_of_shaft_2(story: SimpleNamespace) -> None:
    psi = story.turn.motion.position("bearing_out")
    phi, alpha = story.phi, story.alpha
    np.testing.assert_allclose(
        np.sin(psi) * np.cos(phi) * np.cos(alpha), np.cos(psi) * np.sin(phi), atol=1e-14
    )


def test_the_bending_moments(story: SimpleNamespace) -> None:
    closed_x, closed_z = thoma.bending_moments(story.alpha, story.phi)
    np.testing.assert_allclose(story.found_x, closed_x, atol=1e-13)
    np.testing.assert_allclose(story.found_z, closed_z, atol=1e-13)
    printed = slice(1, 180)  # away from tg 90°
    np.testing.assert_allclose(story.found_x[printed], story.his_x[printed], rtol=1e-9)
    np.testing.assert_allclose(story.found_z[printed], story.his_z[printed], rtol=1e-9)
    radius = 0.5 * np.tan(story.alpha)
    np.testing.assert_allclose(np.hypot(story.found_x - radius, story.found_z), radius, rtol=1e-12)
    np.testing.assert_allclose(np.abs(story.holding), story.torque * np.abs(closed_z), atol=1e-11)
    assert round(np.max(np.abs(story.holding)), 1) == 59.6


@pytest.mark.parametrize("degrees", [8.5, 20.0])
def test_the_rig(story: SimpleNamespace, degrees: float) -> None:
    alpha = np.deg2rad(degrees)
    exact = story.rig_moments(alpha)
    closed = thoma.rig_moments(alpha, story.phi, story.flywheel, story.speed)
    for ours, expected in zip(exact.values(), closed, strict=True):
        np.testing.assert_allclose(ours, expected, atol=1e-12 * np.max(np.abs(expected)))
    np.testing.assert_allclose(
        exact["$M_t$"],
        story.flywheel * story.speed**2 * single_joint.acceleration_ratio(alpha, story.phi),
        atol=1e-12 * np.max(exact["$M_t$"]),
    )
    his = thoma.rig_moments_small_angle(alpha, story.phi, story.flywheel, story.speed)
    for drawn, expected in zip(story.his_moments(alpha).values(), his, strict=True):
        np.testing.assert_allclose(drawn, expected, atol=1e-12 * np.max(np.abs(expected)))


def test_the_error_of_his_forms(story: SimpleNamespace) -> None:
    rounded = {degrees: np.round(errors, 1).tolist() for degrees, errors in story.percent.items()}
    assert rounded == {8.5: [1.5, 2.7, 2.5], 20.0: [8.6, 14.5, 13.7]}


def test_the_orders(story: SimpleNamespace) -> None:
    fields = {"$M_t$": "torsion", "$M_x$": "bending_x", "$M_z$": "bending_z"}
    greatest = {}
    for name, values in story.orders.items():
        orders, amplitudes = figures.order_amplitudes(story.phi, values)
        np.testing.assert_array_equal(orders[:3], [0, 1, 2])
        peak = np.max(amplitudes)
        np.testing.assert_allclose(amplitudes[1:40:2], 0.0, atol=1e-12 * peak)
        harmonics = [
            thoma.rig_harmonics(np.deg2rad(20.0), order, story.flywheel, story.speed)
            for order in (2, 4, 6)
        ]
        closed = np.abs([getattr(harmonic, fields[name]) for harmonic in harmonics])
        np.testing.assert_allclose(amplitudes[[2, 4, 6]], closed, atol=1e-11 * peak)
        greatest[name] = int(np.argmax(amplitudes[1:])) + 1
    assert greatest == {"$M_t$": 2, "$M_x$": 2, "$M_z$": 4}
