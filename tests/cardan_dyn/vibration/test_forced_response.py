"""Forced responses by orders."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from testkit import elastic_rigs

from analytic.whirl import moments_of_output_torque, tilts
from cardan_dyn import ArgumentError, ModelError, vibration
from cardan_dyn.vibration import ForcedResponse

BETA = np.radians(5.0)
RIG = elastic_rigs.elastic_rig()


def response(speed: object, beta: float = BETA, urdf: str = RIG, **options: Any) -> ForcedResponse:
    return vibration.forced_response(elastic_rigs.scene(urdf, beta), speed, **options)


def peak(speed: np.ndarray, size: np.ndarray) -> tuple[float, float]:
    """Return where a parabola through the three greatest values is greatest, and that value."""
    top = int(np.argmax(size))
    near = slice(top - 1, top + 2)
    a, b, c = np.polyfit(speed[near] - speed[top], size[near], 2)
    return float(speed[top] - b / (2.0 * a)), float(c - b**2 / (4.0 * a))


@pytest.mark.parametrize(
    ("order", "sense", "speed", "amplitude"),
    [
        (2, 0, 0.51303, 2.13018e-4),
        (2, 1, 0.48789, 2.03884e-4),
        (4, 0, 0.25320, 5.2991e-5),
    ],
)
def test_peaks_of_the_tilting_shaft(order: int, sense: int, speed: float, amplitude: float) -> None:
    """Ω = ω_n/√(n² ∓ n Θ/A), a shaft of A = c = 1, Θ = 0.1, ζ = 0.01."""
    places = speed + np.linspace(-8e-4, 8e-4, 17)
    found = response(places, joints=[])
    where, size = peak(places, found.whirls("tilt_y", "tilt_z", order)[sense])
    assert where == pytest.approx(speed, abs=1e-5)
    assert size == pytest.approx(amplitude, rel=1e-5)
    critical = 1.0 / np.sqrt(order**2 + (order if sense else -order) * 0.1)
    assert where == pytest.approx(critical, rel=1e-3)


def test_fourth_order_is_forward_alone() -> None:
    forward = response([0.2532], joints=[]).whirls("tilt_y", "tilt_z", 4)[0]
    backward = response(np.linspace(0.245, 0.249, 9), joints=[]).whirls("tilt_y", "tilt_z", 4)[1]
    assert np.max(backward) < 0.01 * forward[0]


def test_peaks_grow_with_the_cube_of_the_angle() -> None:
    """From 5° to 20°: 64 times, of the second order forwards."""
    sizes = []
    for beta in (5.0, 20.0):
        places = 0.5130 + np.linspace(-4e-3, 4e-3, 17) * (1.0 if beta < 6.0 else 2.0)
        found = response(places, np.radians(beta), joints=[])
        sizes.append(peak(places, found.whirls("tilt_y", "tilt_z", 2)[0])[1])
    assert sizes[1] / sizes[0] == pytest.approx(64.0, rel=0.01)


def test_linear_and_averaged_beside_the_motion() -> None:
    found = response([0.36, 0.51303, 0.8], joints=[])
    assert found.linear_error[0] < 1e-6
    assert found.linear_error[2] < 1e-6
    assert found.linear_error[1] < 1e-3
    assert np.all(found.averaged_error > found.linear_error)
    assert np.all(found.averaged_error < 0.05)
    np.testing.assert_allclose(found.linear, found.amplitude, atol=1e-7)


def test_wrenches_of_a_stiff_rig_are_those_of_a_rigid_one() -> None:
    speed, polar = 2.0, 0.1
    stiff = elastic_rigs.elastic_rig(polar, 1.0, 1e9, 0.0)
    found = response([speed], urdf=stiff, joints="bearing_out")
    phi = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)
    sweep = found.scene.sweep(np.column_stack([phi, 0.0 * phi, 0.0 * phi]), [speed, 0.0, 0.0])
    exact = sweep.wrench("bearing_out", "parent").moment
    for order in (2, 4):
        expected = 2.0 * np.exp(-1j * order * phi) @ exact / 64.0
        np.testing.assert_allclose(found.of("bearing_out", order)[0, 3:], expected, atol=1e-9)


@pytest.mark.parametrize(
    ("urdf", "beta", "waves"),
    [(elastic_rigs.torsional_line(damping_in=0.1), 0.1, 9), (RIG, 20.0, 31), (RIG, 45.0, 63)],
)
def test_orders_of_a_wrench_add_up_to_it(urdf: str, beta: float, waves: int) -> None:
    found = response([0.3], np.radians(beta), urdf, joints="bearing_out")
    assert len(found.order) == waves
    phi = np.array([0.3, 1.7, 4.0])
    motion = vibration.periodic_motion(found.scene, 0.3)
    wrench = motion.sweep(position=phi).wrench("bearing_out", "parent")
    exact = np.column_stack([wrench.force, wrench.moment])
    total = (np.exp(1j * np.outer(phi, found.order)) @ found.wrench[0, :, 0]).real
    np.testing.assert_allclose(total, exact, atol=1e-9 * np.max(np.abs(exact)))


def test_unbalance_is_the_first_order() -> None:
    """A mass beside the axis: e m L Ω² /|c - (A - Θ) Ω² + i d Ω| at small angles."""
    heavy, offset, arm = '<link name="shaft_out"><inertial>', 1e-3, 0.5
    urdf = RIG.replace(heavy, f'{heavy}<origin xyz="{arm} {offset} 0"/>')
    speed = 0.8
    found = response([speed], np.radians(0.2), urdf)
    diametral = 1.0 + arm**2
    reach = abs(1.0 - (diametral - 0.1) * speed**2 + 0.02j * speed)
    forward, backward = found.whirls("tilt_y", "tilt_z", 1)
    assert forward[0] == pytest.approx(offset * arm * speed**2 / reach, rel=2e-3)
    assert backward[0] < 1e-3 * forward[0]
    assert found.order[1] == 1.0


def test_tables_figures_and_copies() -> None:
    found = response([0.3, 0.4])
    frame = found.to_dataframe()
    assert {"tilt_y", "bearing_out"} <= set(frame.name)
    is_tilt = (frame.name == "tilt_y") & (frame.quantity == "position")
    row = frame[is_tilt & (frame.order == 2.0) & (frame.speed == 0.3)]
    assert row.amplitude.item() == pytest.approx(abs(found.of("tilt_y", 2)[0]))
    assert found.plot().axes
    assert pickle.loads(pickle.dumps(found)).joints == found.joints
    assert "2 speeds" in repr(found)


def test_what_is_asked_for_wrongly() -> None:
    found = response([0.3], joints=[])
    with pytest.raises(ArgumentError, match="order 99 is none"):
        found.of("tilt_y", 99)
    with pytest.raises(ArgumentError, match="order is not an array"):
        found.of("tilt_y", "second")  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match="frame is 3"):
        response([0.3], frame=3)
    with pytest.raises(ArgumentError, match="orders is not an array"):
        found.plot("second")
    with pytest.raises(ArgumentError, match="'bearing_out' has no amplitudes"):
        found.of("bearing_out", 2)
    with pytest.raises(ArgumentError, match="free coordinates are"):
        found.whirls("tilt_y", "bearing_in", 2)
    with pytest.raises(ArgumentError, match="frame 'shaft' is unknown"):
        response([0.3], frame="shaft")
    with pytest.raises(ModelError, match="no joint 'bearing'"):
        response([0.3], joints="bearing")


@pytest.mark.parametrize("beta", [5.0, 20.0])
def test_a_constant_output_torque_whirls_forwards_alone(beta: float) -> None:
    """Orders 2 and 4 by a steady load instead of inertia: forwards, tan²(β/2) times each other."""
    torque, angle = 1e-5, np.radians(beta)
    urdf = elastic_rigs.elastic_rig(polar=1e-9, damping_ratio=0.05)
    scene = elastic_rigs.scene(urdf, angle, loads={"shaft_out": [0.0, 0.0, 0.0, -torque, 0.0, 0.0]})
    speed = 0.1
    found = vibration.forced_response(scene, [speed], joints=[])
    still = []
    for order in (2, 4):
        forward, backward = (side[0] for side in found.whirls("tilt_y", "tilt_z", order))
        moments = moments_of_output_torque(angle, order, torque)
        expected = tilts(moments, order, speed, 1e-9, 1.0, 1.0, 0.1).forward
        assert forward == pytest.approx(abs(complex(expected)), rel=1e-3)
        assert backward < 1e-3 * forward
        still.append(forward * abs(1.0 - (order * speed) ** 2 + 0.1j * order * speed))
    ratio = {5.0: 0.0019, 20.0: 0.031}[beta]
    assert still[1] / still[0] == pytest.approx(ratio, rel=0.01)
