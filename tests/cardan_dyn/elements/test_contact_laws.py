"""Contact laws: their forces against plain arithmetic, their restitution against integration."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cardan_dyn.core.elements.contact_laws import (
    ContactLaw,
    HuntCrossley,
    ImpactFunction,
    LankaraniNikravesh,
    LinearContact,
)
from cardan_dyn.kit.errors import ArgumentError

LAWS = [
    LinearContact(1e7),
    LinearContact(1e7, 2e3),
    HuntCrossley(3e9, 1.5, 0.7),
    HuntCrossley(2e7, 1.0, restitution=0.15),
    HuntCrossley(3e9, 1.5, factor=4.0),
    LankaraniNikravesh(3e9, 1.5, 0.5),
    ImpactFunction(3e9, 1.5, 3e3, 2e-5),
    ImpactFunction(1e12, 2.2, 3e4, 2e-5),
    ImpactFunction(1e8, 1.1, 2e4, 1e-4),
]


def name(law: ContactLaw) -> str:
    return f"{type(law).__name__}-{law.order:g}"


@pytest.mark.parametrize("law", LAWS, ids=name)
def test_laws_are_frozen_data(law: ContactLaw) -> None:
    for other in (copy.copy(law), copy.deepcopy(law), pickle.loads(pickle.dumps(law))):
        assert other == law
        assert other.force(1e-5, 0.1, 0.2) == law.force(1e-5, 0.1, 0.2)
    with pytest.raises(FrozenInstanceError):
        law.stiffness = 1.0  # type: ignore[misc]
    assert [law == other for other in LAWS].count(True) == 1


def test_forces() -> None:
    depth, rate, speed = 4e-6, -0.05, 0.2
    spring = 3e9 * depth**1.5
    assert LinearContact(1e7, 2e3).force(depth, rate) == pytest.approx(40.0 - 100.0)
    hunt = HuntCrossley(3e9, 1.5, factor=4.0)
    assert hunt.force(depth, rate) == pytest.approx(spring * 0.8)
    lankarani = LankaraniNikravesh(3e9, 1.5, 0.5)
    assert lankarani.force(depth, rate, speed) == pytest.approx(spring * (1.0 - 0.5625 * 0.25))
    impact = ImpactFunction(3e9, 1.5, 3e3, 2e-5)
    assert impact.force(depth, rate) == pytest.approx(spring - 3e3 * 0.104 * 0.05)
    assert impact.force(3e-5, rate) == pytest.approx(3e9 * 3e-5**1.5 - 150.0)
    assert impact.force(-depth, rate) == pytest.approx(-spring)


@pytest.mark.parametrize("law", LAWS, ids=name)
def test_springs_are_odd_and_store_their_work(law: ContactLaw) -> None:
    depths = np.linspace(-2e-5, 2e-5, 9)
    forces = law.force(depths, 0.0, 0.1)
    np.testing.assert_allclose(forces, -forces[::-1], rtol=1e-15, atol=0.0)
    assert law.force(depths[:, None], np.zeros(3), 0.1).shape == (9, 3)
    nodes, weights = np.polynomial.legendre.leggauss(200)
    work = 1e-5 * weights @ law.force(1e-5 * (1.0 + nodes), 0.0, 0.1)
    assert law.energy(2e-5) == pytest.approx(work, rel=1e-6)
    assert law.energy([-1e-5, 0.0]).tolist() == [0.0, 0.0]


def test_a_touch_at_rest_is_not_damped() -> None:
    law = HuntCrossley(3e9, 1.5, 0.7)
    assert law.needs_touch_speed
    np.testing.assert_array_equal(law.force(1e-5, 0.3, [0.0, -0.1]), law.force(1e-5, 0.0, 0.1))


def integrated(law: ContactLaw, speed: float, mass: float) -> float:
    """Return the restitution of an impact in time, by an implicit method, to some 1e-10.

    The law is clipped within the equations; the way back ends at the depth zero.
    """
    scale = speed / np.sqrt(mass)

    def rate(_: float, y: np.ndarray) -> list[float]:
        force = float(law.force(1e-6 * y[0], y[1], speed))
        return [1e6 * y[1], -max(force, 0.0) / mass if y[0] > 0.0 else 0.0]

    def out(_: float, y: np.ndarray) -> float:
        return float(y[0])

    out.terminal, out.direction = True, -1  # type: ignore[attr-defined]
    run = solve_ivp(
        rate,
        (0.0, 1.0),
        [0.0, speed],
        method="DOP853",
        events=out,
        rtol=1e-12,
        atol=1e-12 * scale,
        max_step=3e-6,
    )
    return float(-run.y[1, -1] / speed)


@pytest.mark.parametrize("law", LAWS, ids=name)
def test_restitution_is_that_of_an_integrated_impact(law: ContactLaw) -> None:
    for speed in (0.15, 0.35):
        wanted = integrated(law, speed, 3.6)
        assert law.restitution(speed, 3.6) == pytest.approx(wanted, abs=1e-9)


def test_restitution_does_not_depend_on_speed_or_mass_where_it_is_wanted() -> None:
    law = HuntCrossley(3e9, 1.5, 0.37)
    for speed, mass in ((1e-3, 1.0), (2.0, 50.0)):
        assert law.restitution(speed, mass) == pytest.approx(0.37, rel=1e-14)
    constant = HuntCrossley(3e9, factor=1.0)
    assert constant.restitution(0.1, 1.0) > constant.restitution(0.2, 1.0)


def test_what_lankarani_and_nikravesh_really_have() -> None:
    law = LankaraniNikravesh(3e9, 1.5, 0.5)
    h, e = 0.5625, law.true_restitution
    assert h * (1.0 + e) == pytest.approx(np.log((1.0 + h) / (1.0 - h * e)), rel=1e-14)
    assert e - law.wanted > 0.2
    assert abs(LankaraniNikravesh(3e9, 1.5, 0.99).true_restitution - 0.99) < 2e-4
    assert LankaraniNikravesh(3e9, 1.5, 1.0).true_restitution == 1.0


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: LinearContact(0.0), "stiffness is 0, expected a positive"),
        (lambda: LinearContact(np.inf), "not finite"),
        (lambda: LinearContact(1.0, -1.0), "damping is -1; it is not less than 0"),
        (lambda: LinearContact([1.0, 2.0]), "has shape"),  # type: ignore[arg-type]
        (lambda: LinearContact.of_ratio(1.0, 0.2, 0.0), "mass is 0"),
        (lambda: HuntCrossley(1.0), "give restitution="),
        (lambda: HuntCrossley(1.0, 1.5, 0.5, 1.0), "one of restitution and factor"),
        (lambda: HuntCrossley(1.0, 1.5, 0.0), "it lies from 0.001 to 1"),
        (lambda: HuntCrossley(1.0, 0.5, 0.5), "exponent is 0.5; it is not less than 1"),
        (lambda: HuntCrossley(1.0, factor=-1.0), "factor is -1"),
        (lambda: LankaraniNikravesh(1.0, 1.5, 1.2), "it lies from 0 to 1"),
        (lambda: ImpactFunction(1.0, 1.5, 1.0, 0.0), "full_depth is 0"),
        (lambda: LinearContact(1.0).restitution(0.0, 1.0), "touch_speed is 0"),
        (lambda: LinearContact(1.0).restitution(1.0, "a"), "mass"),  # type: ignore[arg-type]
    ],
)
def test_bad_values_are_refused(make: Callable[[], object], says: str) -> None:
    with pytest.raises(ArgumentError, match=says):
        make()
