"""Forced responses by orders."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from testkit import elastic_rigs

import cardan_dyn as cd
from cardan_dyn import ArgumentError, ModelError, vibration
from cardan_dyn.analytic.whirl import (
    critical_speed,
    moments_of_input_torque,
    moments_of_output_torque,
    tilts,
)
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


@pytest.mark.slow
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


@pytest.mark.slow
def test_fourth_order_is_forward_alone() -> None:
    forward = response([0.2532], joints=[]).whirls("tilt_y", "tilt_z", 4)[0]
    backward = response(np.linspace(0.245, 0.249, 9), joints=[]).whirls("tilt_y", "tilt_z", 4)[1]
    assert np.max(backward) < 0.01 * forward[0]


def greatest(order: int, sense: int, beta: float) -> float:
    """Greatest amplitude of an order over the speed; sense 0 is forward, 1 backward."""
    at = float(critical_speed(1.0, order, 0.1, forward=not sense))
    for width in (6e-3, 6e-4):
        places = at * (1.0 + width * np.linspace(-1.0, 1.0, 11))
        found = response(places, beta, joints=[]).whirls("tilt_y", "tilt_z", order)[sense]
        at, size = peak(places, found)
    return size


# Of the moments' series 1 + c β²: 2 forward, 2 backward, 4 forward; growth from 5° to 20°.
GROWTH = [(2, 0, 0.0, 63.80), (2, 1, 0.75, 69.90), (4, 0, 1.0, 71.54)]


@pytest.mark.slow
@pytest.mark.parametrize(("order", "sense", "share", "steep"), GROWTH)
def test_peaks_grow_with_the_cube_of_small_angles(
    order: int, sense: int, share: float, steep: float
) -> None:
    """To 64 times from 1° to 4° but for 15 c β²; from 5° to 20° that is up to 12 % more."""
    small, four, five, twenty = (
        greatest(order, sense, float(np.radians(beta))) for beta in (1.0, 4.0, 5.0, 20.0)
    )
    assert four / small == pytest.approx(
        64.0 * (1.0 + 15.0 * share * np.radians(1.0) ** 2), rel=3e-4
    )
    assert twenty / five == pytest.approx(steep, rel=5e-4)


def test_linear_and_averaged_beside_the_motion() -> None:
    found = response([0.36, 0.51303, 0.8], joints=[])
    assert found.linear_error[0] < 1e-6
    assert found.linear_error[2] < 1e-6
    assert found.linear_error[1] < 1e-3
    assert np.all(found.averaged_error > found.linear_error)
    assert np.all(found.averaged_error < 0.05)
    np.testing.assert_allclose(found.linear, found.amplitude, atol=1e-7)


def test_errors_are_the_greatest_at_any_position() -> None:
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(damping_in=0.05), np.radians(20.0))
    found = vibration.forced_response(scene, [0.4, 0.46], joints=[])
    waves = np.exp(1j * np.outer(np.linspace(0.0, np.pi, 20001), found.order))
    motion, linear, averaged = (
        (waves @ of[:, :, 0].T).real for of in (found.amplitude, found.linear, found.averaged)
    )
    size = np.max(np.abs(motion - found.amplitude[:, 0, 0].real), axis=0)
    for error, of in ((found.linear_error, linear), (found.averaged_error, averaged)):
        np.testing.assert_allclose(error, np.max(np.abs(of - motion), axis=0) / size, rtol=2e-4)


def test_wrenches_of_a_stiff_rig_are_those_of_a_rigid_one() -> None:
    speeds = [2.0, 1.3]
    stiff = elastic_rigs.elastic_rig(0.1, 1.0, 1e9, 0.0)
    found = response(speeds, urdf=stiff, joints="bearing_out")
    assert np.all((found.residual > 0.0) & (found.residual < 1e-8))
    phi = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)
    rigid = np.column_stack([phi, 0.0 * phi, 0.0 * phi])
    for row, speed in enumerate(speeds):
        sweep = found.scene.replace(drive=found.scene.coordinates).sweep(rigid, [speed, 0.0, 0.0])
        exact = sweep.wrench("bearing_out", "parent").moment
        for order in (2, 4):
            expected = 2.0 * np.exp(-1j * order * phi) @ exact / 64.0
            np.testing.assert_allclose(found.of("bearing_out", order)[row, 3:], expected, atol=1e-9)


def test_a_constant_input_torque_has_no_fourth_order() -> None:
    """A load over the rotation of shaft 2, such that shaft 1 carries the same torque throughout."""
    beta, torque, speed = np.radians(20.0), 1e-6, 0.4
    # Far less inertia than load.
    urdf = elastic_rigs.elastic_rig(polar=1e-12)
    ratio = np.tan(beta) ** 2

    def even_input(turn: Any) -> Any:
        return -torque / (np.cos(beta) * (1.0 + ratio * np.cos(turn) ** 2))

    rig = elastic_rigs.scene(urdf, beta)
    even = rig.replace(
        elements=[*rig.elements, cd.Actuator("bearing_out", even_input, of="position")]
    )
    for scene, moments in (
        (even, moments_of_input_torque),
        (rig.replace(loads={"bearing_out": -torque}), moments_of_output_torque),
    ):
        found = vibration.forced_response(scene, [speed], joints=[])
        for order in (2, 4, 6):
            expected = tilts(moments(beta, order, torque), order, speed, 0.0, 1.0, 1.0, 0.02)
            for circle, part in zip(found.whirls("tilt_y", "tilt_z", order), expected, strict=True):
                assert circle[0] == pytest.approx(abs(part), abs=3e-12)
    # What the tilt itself changes is of the square of the torque.
    assert 1e-4 * torque * np.tan(beta) > 3e-12


@pytest.mark.slow
@pytest.mark.parametrize(
    ("urdf", "beta", "waves"),
    # At 45° the stiffness has a 44th order of 2.8e-13: 45 nodes of half a turn do not resolve it.
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


@pytest.mark.slow
def test_tables_figures_and_copies() -> None:
    found = response([0.3, 0.4])
    frame = found.to_dataframe()
    assert {"tilt_y", "bearing_out"} <= set(frame.name)
    is_tilt = (frame.name == "tilt_y") & (frame.quantity == "position")
    row = frame[is_tilt & (frame.order == 2.0) & (frame.speed == 0.3)]
    assert row.amplitude.item() == pytest.approx(abs(found.of("tilt_y", 2)[0]))
    lines = frame[is_tilt & (frame.speed == 0.4)]
    motion = vibration.periodic_motion(found.scene, 0.4).at(0.7).position[0]
    summed = np.sum(lines.amplitude * np.cos(0.7 * lines.order + lines.phase))
    assert summed == pytest.approx(motion[0, found.free.index("tilt_y")], rel=1e-9)
    assert found.plot().axes
    assert pickle.loads(pickle.dumps(found)).joints == found.joints
    assert "2 speeds" in repr(found)


def test_what_is_asked_for_wrongly() -> None:
    found = response([0.3], joints=[])
    with pytest.raises(ArgumentError, match="order 99 is none"):
        found.of("tilt_y", 99)
    with pytest.raises(ArgumentError, match="order is not an array of real numbers"):
        found.of("tilt_y", "second")  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match="frame is 3"):
        response([0.3], frame=3)
    with pytest.raises(ArgumentError, match="orders is not an array"):
        found.plot(orders="second")
    with pytest.raises(ArgumentError, match="'bearing_out' has no amplitudes"):
        found.of("bearing_out", 2)
    with pytest.raises(ArgumentError, match="free coordinates are"):
        found.whirls("tilt_y", "bearing_in", 2)
    with pytest.raises(ArgumentError, match="frame 'shaft' is unknown"):
        response([0.3], frame="shaft")
    with pytest.raises(ModelError, match="no joint 'bearing'"):
        response([0.3], joints="bearing")


@pytest.mark.slow
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


def test_unbalance_of_a_rotor_between_springs() -> None:
    """Laval's rotor: e r²/((1 - r²) + 2iζr), r = Ω/ω_n, forward alone."""
    mass, offset, stiffness, damping = 20.0, 1e-4, 2e6, 250.0
    scene = elastic_rigs.scene(elastic_rigs.rotor(mass, offset, (stiffness,) * 2, damping), 0.0)
    natural = np.sqrt(stiffness / mass)
    speed = natural * np.array([0.2, 0.9, 1.0, 1.5])
    found = vibration.forced_response(scene, speed)
    swing = offset * mass * speed**2 / (stiffness - mass * speed**2 + 1j * damping * speed)
    np.testing.assert_allclose(found.of("y", 1), swing, rtol=1e-11)
    # The disc turns from y to z: z follows a quarter of a turn behind.
    np.testing.assert_allclose(found.of("z", 1), -1j * swing, rtol=1e-11)
    forward, backward = found.whirls("y", "z", 1)
    np.testing.assert_allclose(forward, np.abs(swing), rtol=1e-11)
    assert np.max(backward) < 1e-11 * np.max(forward)
    # The spring's frame carries all of the disc's acceleration.
    carried = found.wrench[:, 1, found.joints.index("y"), 1]
    np.testing.assert_allclose(carried, -(stiffness + 1j * damping * speed) * swing, rtol=1e-9)


def test_wrench_of_a_joint_that_is_a_free_coordinate() -> None:
    scene = elastic_rigs.scene(elastic_rigs.rotor(), 0.0)
    found = vibration.forced_response(scene, [50.0, 60.0])
    assert found.of("y", 1).shape == (2,)
    wave = int(np.nonzero(found.order == 1.0)[0][0])
    expected = found.wrench[:, wave, found.joints.index("y")]
    np.testing.assert_array_equal(found.wrench_of("y", 1), expected)
    np.testing.assert_array_equal(found.wrench_of("bearing_in", 1), found.of("bearing_in", 1))
    for joint, order, message in (
        ("x", 1, "'x' has no wrench; joints: bearing_in, y, z"),
        ("y", 0.5, "order 0.5 is none of those"),
        ("y", "1", "order is not an array of real numbers"),
    ):
        with pytest.raises(ArgumentError, match=message):
            found.wrench_of(joint, order)  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match=r"'x' has no amplitudes; bearing_in, y, z$"):
        found.of("x", 1)
