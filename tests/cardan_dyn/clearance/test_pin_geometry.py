"""The stiffness of pins in bushes, against differences of the approach and Hertz."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cardan_dyn import ArgumentError
from cardan_dyn.analytic.contact_stiffness import contact_approach
from cardan_dyn.clearance import PinGeometry

PLAY = 1e-4
STEEL = PinGeometry(length=0.02, radius=0.01)
SEATED = PinGeometry(length=0.02, radius=0.01, seat_stiffness=2e7)


def test_a_steel_line_contact_of_20_mm_at_2_kn() -> None:
    assert float(STEEL.stiffness(np.array(2000.0), PLAY)) == pytest.approx(1.1e9, rel=0.01)


@pytest.mark.parametrize(
    "pin", [STEEL, SEATED, PinGeometry(0.03, 0.008, 1e8, 2.1e11, 1.1e11, 0.28, 0.34)]
)
def test_stiffness_is_the_slope_of_contact_and_seat_in_series(pin: PinGeometry) -> None:
    force = np.array([200.0, 2000.0, 20_000.0])

    def approach(at: np.ndarray) -> np.ndarray:
        moduli = ((pin.pin_modulus, pin.pin_poisson), (pin.bush_modulus, pin.bush_poisson))
        soft = sum((1.0 - nu**2) / (np.pi * modulus) for modulus, nu in moduli)
        seat = 0.0 if pin.seat_stiffness is None else at / pin.seat_stiffness
        return np.asarray(contact_approach(at, soft, pin.length, PLAY / 2) + seat)

    step = 1e-4 * force
    given = (approach(force + step) - approach(force - step)) / (2.0 * step)
    np.testing.assert_allclose(pin.stiffness(force, PLAY), 1.0 / given, rtol=1e-7)


@pytest.mark.parametrize("pin", [STEEL, SEATED])
def test_hardening_is_that_of_differences(pin: PinGeometry) -> None:
    force, step = np.array(3000.0), 1e-5

    def log(force_factor: float, play_factor: float) -> float:
        return float(np.log(pin.stiffness(force * force_factor, PLAY * play_factor)))

    up, down = np.exp(step), np.exp(-step)
    expected = (log(up, 1.0) - log(down, 1.0)) / (2.0 * step)
    assert float(pin.hardening(force, PLAY)) == pytest.approx(expected, rel=1e-7)
    by_clearance = (log(1.0, up) - log(1.0, down)) / (2.0 * step)
    assert by_clearance == pytest.approx(-expected, rel=1e-7)


def test_the_width_is_hertzs() -> None:
    """Half width √(4 F R / (π L E)) with 1/E of both bodies and R = r² / Δr."""
    reduced = 2.1e11 / (2.0 * (1.0 - 0.3**2))
    radius = STEEL.radius**2 / (PLAY / 2)
    half = np.sqrt(4.0 * 2000.0 * radius / (np.pi * STEEL.length * reduced))
    assert STEEL.spreads(2000.0, PLAY) == pytest.approx(half / STEEL.radius, rel=1e-12)
    assert STEEL.doubts(2000.0, PLAY) == (
        "a line contact alone is some hundred times too stiff: give seat_stiffness",
    )
    assert SEATED.doubts(2000.0, PLAY) == ()
    assert "wide to each side: no line" in SEATED.doubts(50_000.0, PLAY)[0]


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"length": 0.0}, "length is 0"),
        ({"radius": -1.0}, "radius is -1"),
        ({"seat_stiffness": 0.0}, "seat_stiffness is 0"),
        ({"length": [0.1, 0.2]}, "length has shape"),
        ({"pin_modulus": float("nan")}, "pin_modulus is not finite"),
        ({"bush_poisson": 0.6}, "bush_poisson is 0.6"),
    ],
)
def test_bad_input(change: dict[str, Any], match: str) -> None:
    with pytest.raises(ArgumentError, match=match):
        PinGeometry(**{"length": 0.02, "radius": 0.01, **change})


def test_what_the_formula_is_not_for() -> None:
    limit = STEEL.limit(PLAY)
    with pytest.raises(ArgumentError, match=r"beyond what a line contact of 0\.02 m"):
        STEEL.stiffness(np.array([1.0, limit]), PLAY)
    assert np.isfinite(STEEL.stiffness(np.array(0.99 * limit), PLAY))
    with pytest.raises(ArgumentError, match="nearly equal radii"):
        STEEL.limit(0.003)
