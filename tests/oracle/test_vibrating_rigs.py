"""Equations of elastic rigs written down by hand against scenes, multiple precision and theory."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from driven_shaft import DrivenShaft
from shooting import Acceleration, edge, orders, periodic
from testkit import elastic_rigs
from tilting_shaft import TiltingShaft
from vibrating_lines import ElasticMiddleShaft, SpringBehind, SpringInFront, SpringsOnBothSides

SPEED = 0.8
BETA = np.radians(20.0)
FRONT = np.radians(15.0)
LOAD = 0.07

RIGS: dict[str, tuple[str, Acceleration, dict[str, object]]] = {
    "tilting": (
        elastic_rigs.elastic_rig(0.3, 1.2, 1.5, 0.02),
        TiltingShaft(BETA, SPEED, 0.3, 1.2, 1.5, 0.02),
        {},
    ),
    "tilting under load": (
        elastic_rigs.elastic_rig(0.3, 1.2, 1.5, 0.02),
        TiltingShaft(BETA, SPEED, 0.3, 1.2, 1.5, 0.02, LOAD),
        {"loads": {"shaft_out": [0.0, 0.0, 0.0, -LOAD, 0.0, 0.0]}},
    ),
    "spring in front": (
        elastic_rigs.torsional_line(0.4, 0.6, 1.0, damping_in=0.1),
        SpringInFront(BETA, SPEED, 0.6, 0.05),
        {},
    ),
    "spring behind": (
        elastic_rigs.torsional_line(0.4, 1.0, None, 1.0, damping_out=0.1),
        SpringBehind(BETA, SPEED, 0.05),
        {},
    ),
    "springs on both sides": (
        elastic_rigs.torsional_line(0.4, 0.7, 1.3, 0.9, 0.1, 0.2, 0.15),
        SpringsOnBothSides(BETA, SPEED, (0.4, 0.15, 0.7), (1.3, 0.9), (0.1, 0.2)),
        {},
    ),
    "elastic middle shaft": (
        elastic_rigs.double_joint(1.0, 1.0, 0.1, 0.3),
        ElasticMiddleShaft(BETA, SPEED, 0.15, 0.05),
        {},
    ),
}


@pytest.mark.parametrize("name", RIGS)
def test_accelerations_by_hand_need_no_effort(name: str) -> None:
    """A scene that moves as the equation says is in balance along its free coordinates."""
    urdf, system, options = RIGS[name]
    scene = elastic_rigs.scene(urdf, BETA, **options)
    driven = scene.replace(drive=scene.coordinates)
    random = np.random.default_rng(3)
    free = len(scene.free)
    for _ in range(4):
        phi, q = random.uniform(0.0, 6.0), 0.2 * random.standard_normal(free)
        rate = 0.3 * random.standard_normal(free)
        second = system(phi, q, rate)
        turn = driven.sweep(
            np.r_[phi, q],
            speed=SPEED * np.r_[1.0, rate],
            acceleration=SPEED**2 * np.r_[0.0, second],
        )
        assert np.max(np.abs(turn.drive_effort[..., 1:])) < 2e-15
        # The test can fail: a hundredth more acceleration is seen.
        other = driven.sweep(
            np.r_[phi, q],
            speed=SPEED * np.r_[1.0, rate],
            acceleration=SPEED**2 * np.r_[0.0, second + 0.01],
        )
        assert np.max(np.abs(other.drive_effort[..., 1:])) > 1e-4


def test_a_driven_shaft_by_hand_needs_its_torque_alone() -> None:
    """Newton and Euler with the moment of the cross, for any motion of drive and tilts."""
    shaft = DrivenShaft(BETA, lambda speed: 0.3 - 0.1 * speed, 0.7, 0.3, 1.2, 1.5, 0.02)
    urdf = elastic_rigs.elastic_rig(0.3, 1.2, 1.5, 0.02)
    inertia = 'ixx="1.0" iyy="1.0" izz="1.0"'
    assert inertia in urdf
    scene = elastic_rigs.scene(urdf.replace(inertia, inertia.replace("1.0", "0.7")), BETA)
    driven = scene.replace(drive=scene.coordinates)
    random = np.random.default_rng(5)
    for _ in range(4):
        position = np.r_[random.uniform(0.0, 6.0), 0.2 * random.standard_normal(2)]
        speed = 0.5 * random.standard_normal(3)
        rise = shaft.accelerations(position, speed)
        turn = driven.sweep(position, speed=speed, acceleration=rise)
        expected = [0.3 - 0.1 * speed[0], 0.0, 0.0]
        np.testing.assert_allclose(np.ravel(turn.drive_effort), expected, atol=5e-15)
        other = driven.sweep(position, speed=speed, acceleration=rise + 0.01)
        assert np.max(np.abs(other.drive_effort - expected)) > 1e-3


def trace_plus_2(system: type, beta: float) -> object:
    return lambda speed: periodic(system(beta, speed), np.zeros(2)).trace + 2.0


@pytest.mark.slow
def test_first_unstable_region_of_a_spring_in_front() -> None:
    """15°, a = 1/2: 0.9911629395 … 1.0084989812."""
    measure = trace_plus_2(SpringInFront, FRONT)
    assert edge(measure, 0.9911, 0.9912) == pytest.approx(0.9911629395, abs=1e-10)
    assert edge(measure, 1.0084, 1.0085) == pytest.approx(1.0084989812, abs=1e-10)


@pytest.mark.slow
def test_unstable_region_of_an_elastic_middle_shaft() -> None:
    """20°: 0.9696 … 1.0318, although the phased joint turns its output uniformly."""
    measure = trace_plus_2(ElasticMiddleShaft, BETA)
    assert edge(measure, 0.969, 0.970) == pytest.approx(0.9696, abs=5e-5)
    assert edge(measure, 1.031, 1.033) == pytest.approx(1.0318, abs=5e-5)
    assert np.max(np.abs(periodic(ElasticMiddleShaft(BETA, 1.0), np.zeros(2)).start)) < 1e-13


@pytest.mark.slow
def test_springs_on_both_sides_have_a_combined_region() -> None:
    """About (ω₁ + ω₂)/2 = √2.5, as wide as β² makes it, between positive discriminants."""
    widths = []
    for beta in (BETA, BETA / 2.0):
        ratio = 1.0 + 0.01 * np.array([-1.0, 0.0, 1.0]) * float(beta / BETA) ** 2
        measured = [
            periodic(SpringsOnBothSides(float(beta), speed), np.zeros(4))
            for speed in np.sqrt(2.5) * ratio
        ]
        outside, inside, other = (motion.discriminant for motion in measured)
        assert inside < 0.0 < min(outside, other)
        widths.append(np.ptp(np.roots(np.polyfit(ratio - 1.0, [outside, inside, other], 2))))
        multipliers = measured[1].multipliers
        assert np.max(np.abs(multipliers)) > 1.0 + 0.015 * (beta / BETA) ** 2
        assert np.all(np.abs(multipliers.imag) > 0.1)
    assert widths[0] / widths[1] == pytest.approx(4.0, rel=0.03)


@pytest.mark.parametrize("speed", [0.3, 0.7, 1.0, 2.5])
def test_a_spring_behind_the_joint_is_never_unstable(speed: float) -> None:
    """Multipliers e^{±iπ/r}."""
    found = periodic(SpringBehind(np.radians(40.0), speed), np.zeros(2))
    assert found.trace == pytest.approx(2.0 * np.cos(np.pi / speed), abs=1e-12)
    assert found.determinant == pytest.approx(1.0, abs=1e-12)


@pytest.mark.slow
def test_trace_against_multiple_precision() -> None:
    """Taylor series with 25 digits of the variational equation about the same motion."""
    system = SpringInFront(FRONT, 0.95)
    found = periodic(system, np.zeros(2))
    with mpmath.workdps(25):
        beta, r = mpmath.radians(15), mpmath.mpf("0.95")
        cosine, square = mpmath.cos(beta), mpmath.sin(beta) ** 2

        def parts(theta: mpmath.mpf) -> tuple[mpmath.mpf, mpmath.mpf, mpmath.mpf]:
            """Η, its derivative and its second derivative by θ."""
            sine_2, cosine_2 = mpmath.sin(2 * theta), mpmath.cos(2 * theta)
            nominal = 1 - square * mpmath.cos(theta) ** 2
            first = -cosine * square * sine_2 / nominal**2
            second = -cosine * square * (2 * cosine_2 / nominal**2)
            second += 2 * cosine * square**2 * sine_2**2 / nominal**3
            return cosine / nominal, first, second

        def rate(phi: mpmath.mpf, y: list[mpmath.mpf]) -> list[mpmath.mpf]:
            eta, eta_1, eta_2 = parts(phi + y[0])
            inertia, turning = (1 + eta**2) / 2, (1 + y[1]) ** 2
            second = -(eta * eta_1 * turning / 2 + y[0] / r**2) / inertia
            by_q = (eta_1**2 + eta * eta_2) / 2 * turning + 1 / r**2 + eta * eta_1 * second
            by_rate = eta * eta_1 * (1 + y[1])
            pairs = [(y[2], y[3]), (y[4], y[5])]
            return [
                y[1],
                second,
                *(x for q, v in pairs for x in (v, -(by_q * q + by_rate * v) / inertia)),
            ]

        start = [mpmath.mpf(float(value)) for value in found.start]
        end = mpmath.odefun(rate, 0, [*start, 1, 0, 0, 1], tol=mpmath.mpf(10) ** -18)(mpmath.pi)
        assert abs(end[0] - start[0]) < 1e-13 and abs(end[1] - start[1]) < 1e-13
        assert abs(float(end[2] + end[5]) - found.trace) < 1e-11
        assert abs(float(end[2] * end[5] - end[3] * end[4]) - 1.0) < 1e-13
    assert abs(found.determinant - 1.0) < 1e-11


@pytest.mark.slow
@pytest.mark.parametrize(
    ("speed", "order", "amplitude"),
    [(0.51303, 2, 2.13018e-4), (0.48789, -2, 2.03884e-4), (0.25320, 4, 5.2991e-5)],
)
def test_peaks_of_the_tilting_shaft(speed: float, order: int, amplitude: float) -> None:
    """A = c = 1, Θ = 0.1, ζ = 0.01, β = 5°: where its shaft whirls forwards and backwards."""
    system = TiltingShaft(np.radians(5.0), speed)
    coefficients = orders(system, periodic(system, np.zeros(4)).start, 32)
    # The tip moves by a in the plane of the shafts and by -b normal to it.
    whirl = coefficients[:, 0] - 1j * coefficients[:, 1]
    assert abs(whirl[order // 2]) == pytest.approx(amplitude, abs=6e-10)
