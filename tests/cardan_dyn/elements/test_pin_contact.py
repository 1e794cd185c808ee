"""Pins with clearance: their law by hand, where they act, and what they refuse."""

from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.core.elements.pin_contact import ContactMotion

ORIGIN, Z = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
LAW = cd.LinearContact(1e5, damping=10.0)


def contact(**changes: object) -> cd.PinContact:
    given = {"clearance": 2e-3, "law": LAW, **changes}
    return cd.PinContact("a", ORIGIN, Z, "b", ORIGIN, **given)  # type: ignore[arg-type]


def at(offset: tuple[float, ...], rate: tuple[float, ...], spin: float = 0.0) -> ContactMotion:
    return ContactMotion(np.array([Z]), np.array([offset]), np.array([rate]), np.array([spin]))


def test_a_wall_pushes_back_along_the_offset_and_rubs_across_it() -> None:
    element = contact(friction=0.3, radius=0.02, transition=0.5)
    force = element.force(at((3e-3, 4e-3, 0.0), (0.1, 0.2, 0.0), 7.0), np.zeros(1))
    away, along = np.array([0.6, 0.8, 0.0]), np.array([-0.8, 0.6, 0.0])
    pressure = 1e5 * 4e-3 + 10.0 * (0.6 * 0.1 + 0.8 * 0.2)
    slide = -0.8 * 0.1 + 0.6 * 0.2 + 0.02 * 7.0
    rubbing = -0.3 * pressure * slide / np.hypot(slide, 0.5)
    assert force.depth == pytest.approx(4e-3)
    assert force.pressure == pytest.approx(pressure)
    assert force.friction == pytest.approx(rubbing)
    np.testing.assert_allclose(force.force[0], rubbing * along - pressure * away, rtol=1e-14)
    assert force.energy == pytest.approx(0.5 * 1e5 * 4e-3**2)
    assert force.dissipation == pytest.approx(10.0 * 0.22**2 - rubbing * slide)


@pytest.mark.parametrize("offset", [(0.0, 0.0, 0.0), (9e-4, 0.0, 0.0)])
def test_nothing_acts_within_the_play(offset: tuple[float, ...]) -> None:
    force = contact(friction=0.3).force(at(offset, (5.0, 5.0, 0.0)), np.zeros(1))
    assert np.all(force.force == 0.0) and force.energy == 0.0 and force.dissipation == 0.0
    assert force.depth == pytest.approx(offset[0] - 1e-3)


def test_a_wall_never_pulls_and_what_it_does_not_give_back_is_lost() -> None:
    leaving = at((2e-3, 0.0, 0.0), (-50.0, 0.0, 0.0))
    force = contact().force(leaving, np.zeros(1))
    assert force.pressure == 0.0 and np.all(force.force == 0.0)
    assert force.dissipation == pytest.approx(1e5 * 1e-3 * 50.0)


def test_axes_of_any_length_are_directions() -> None:
    given = cd.PinContact("a", ORIGIN, (0.0, 3.0, 4.0), "b", ORIGIN, 1e-3, LAW)
    np.testing.assert_allclose(given.axis_a, [0.0, 0.6, 0.8])


def test_laws_that_need_the_speed_of_touch_are_refused_outside_simulations() -> None:
    element = contact(law=cd.HuntCrossley(1e9, restitution=0.5))
    with pytest.raises(cd.ArgumentError, match="only simulations know"):
        element.force(at((2e-3, 0.0, 0.0), (0.0, 0.0, 0.0)), np.zeros(1))
    assert np.all(element.force(at(ORIGIN, ORIGIN), np.zeros(1)).force == 0.0)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"clearance": 0.0}, "clearance is 0, expected a positive number"),
        ({"clearance": -1e-3}, "clearance is -0.001"),
        ({"clearance": np.nan}, "clearance"),
        ({"law": 1e8}, "law is 1e\\+08|law is 100000000.0|expected a contact law"),
        ({"friction": -0.1}, "friction is -0.1"),
        ({"radius": -0.1}, "radius is -0.1"),
        ({"transition": 0.0}, "transition is 0"),
        ({"name": 3}, "name"),
    ],
)
def test_bad_values_are_refused(changes: dict[str, object], message: str) -> None:
    with pytest.raises(cd.ArgumentError, match=message):
        contact(**changes)


def test_bad_links_and_axes_are_refused() -> None:
    with pytest.raises(cd.ArgumentError, match="both ends are on link 'a'"):
        cd.PinContact("a", ORIGIN, Z, "a", ORIGIN, 1e-3, LAW)
    with pytest.raises(cd.ArgumentError, match="axis_a is zero"):
        cd.PinContact("a", ORIGIN, ORIGIN, "b", ORIGIN, 1e-3, LAW)
