"""Integrated phases: against those in closed form, and free impacts of known restitution."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from cardan_dyn.clearance.two_mass_integration import IntegratedPhase, Units
from cardan_dyn.clearance.two_mass_phases import Begun, Flight, LinearTouch, Push
from cardan_dyn.elements.contact_laws import (
    ContactLaw,
    HuntCrossley,
    ImpactFunction,
    LankaraniNikravesh,
    LinearContact,
)

MASS, PLAY = 2.0, 1e-3
UNITS = Units(1e-3, 0.3, 0.1)
DAMPED = LinearContact(1e4, 50.0)


def phase(begun: Begun, is_contact: bool, law: ContactLaw, push: Push) -> IntegratedPhase:
    def force(time: float) -> float:
        return begun.side * (push.value + push.slope * (time - begun.time))

    return IntegratedPhase(begun, is_contact, law, MASS, force, UNITS)


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize(
    ("begun", "push"),
    [
        ((0.0, -0.1), Push(0.0, 6e3)),
        ((0.0, 0.0), Push(0.0, -3e3)),
        ((-4e-4, 0.1), Push(0.0, 0.0)),
        ((1e-4, -0.02), Push(0.0, 0.0)),
        ((1e-4, -0.02), Push(40.0, 0.0)),
    ],
)
def test_flights(side: int, begun: tuple[float, float], push: Push) -> None:
    start = Begun(0.3, side, *begun)
    exact = Flight(start, MASS, push)
    how = exact.rise(DAMPED, 5.0) if begun[0] > 0.0 else exact.fly(PLAY, 5.0)
    found = phase(start, False, DAMPED, push)
    assert found.run(PLAY, 5.0) == how
    assert found.end == pytest.approx(exact.end, rel=1e-13)
    assert found.last == pytest.approx(exact.last, abs=1e-13)
    assert (found.work, found.loss) == pytest.approx((exact.work, exact.loss), abs=1e-13)


@pytest.mark.parametrize("law", [LinearContact(1e4), DAMPED, LinearContact(1e4, 400.0)])
@pytest.mark.parametrize("push", [Push(0.0, 0.0), Push(3.0, 0.0), Push(0.0, 900.0)])
def test_contacts(law: LinearContact, push: Push) -> None:
    begun = Begun(0.0, -1, 0.0, 0.3, 0.3)
    exact = LinearTouch(begun, law, MASS, push)
    found = phase(begun, True, law, push)
    assert found.run(PLAY, 0.2) == exact.press(0.2)
    assert found.end == pytest.approx(exact.end, rel=1e-11)
    times = np.linspace(0.0, found.end, 40)
    for mine, wanted in zip(found.states(times), exact.states(times), strict=True):
        np.testing.assert_allclose(mine, wanted, atol=1e-10 * np.max(np.abs(wanted)))
    assert found.last == pytest.approx(exact.last, rel=1e-9, abs=1e-12)
    assert found.peak == pytest.approx(exact.peak, rel=1e-12)
    assert (found.work, found.loss) == pytest.approx((exact.work, exact.loss), rel=1e-11, abs=1e-15)


@pytest.mark.parametrize(
    "law",
    [
        DAMPED,
        HuntCrossley(3e6, 1.5, 0.8),
        HuntCrossley(3e6, 1.5, 0.05),
        HuntCrossley.of_factor(1e5, 1.1, factor=2.0),
        LankaraniNikravesh(3e6, 1.5, 0.3),
        ImpactFunction(3e6, 1.5, 300.0, 1e-3),
        ImpactFunction(1e5, 1.1, 900.0, 1e-3),
    ],
)
def test_free_impacts_have_the_restitution_of_the_law(law: ContactLaw) -> None:
    begun, rate = Begun(0.0, 1, 0.0, 0.3, 0.3), 0.0
    is_contact = True
    lost = 0.0
    for _ in range(6):
        part = phase(begun, is_contact, law, Push(0.0, 0.0))
        how = part.run(PLAY, 1e3)
        depth, rate = part.last
        lost += part.loss
        if depth <= 0.0:
            break
        begun, is_contact = Begun(part.end, 1, depth, rate, 0.3), how == "resumed"
    assert depth <= 0.0
    assert -rate / 0.3 == pytest.approx(law.restitution(0.3, MASS), abs=1e-10)
    assert lost == pytest.approx(0.5 * MASS * (0.3**2 - rate**2), rel=1e-11)


def test_copies_read_the_same() -> None:
    found = phase(Begun(0.0, 1, 0.0, 0.3, 0.3), True, HuntCrossley(3e6, 1.5, 0.8), Push(0.0, 0.0))
    assert found.run(PLAY, 1.0) == "parted"
    other = pickle.loads(pickle.dumps(found))
    times = np.linspace(0.0, found.end, 5)
    np.testing.assert_array_equal(other.states(times), found.states(times))
    assert other.last == found.last


def test_a_phase_that_ends_where_it_begins() -> None:
    found = phase(Begun(0.1, 1, 0.0, 0.0, 0.0), True, DAMPED, Push(-1.0, 0.0))
    assert found.run(PLAY, 1.0) == "parted"
    assert found.end == pytest.approx(0.1)
    assert found.last == pytest.approx((0.0, 0.0), abs=1e-12)
