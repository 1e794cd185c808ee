"""The 50-digit reference against closed forms, so that the maps rest on firm ground."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("mpmath")

from mpmath import mp, mpf

import cardan_dyn as cd
from benchmarks import universal_joint
from benchmarks.descriptions import massless, mechanics, text, with_length, with_mass, with_miss
from benchmarks.exact import Exact
from benchmarks.stress_dead_point import dead_point
from cardan_dyn.analytic import single_joint


def joint_state(beta: float, phi: float, speed: float = 0.0) -> tuple[Exact, object]:
    exact = Exact(mechanics("universal_joint"))
    guess = {"pin_in": 0.0, "bearing_out": phi}
    state = exact.at(
        guess,
        {"bearing_in": phi, "joint_angle": beta},
        {"bearing_in": speed},
        loads={"bearing_out": -1.0},
    )
    return exact, state


@pytest.mark.parametrize("beta_deg", [8.5, 50.0, 89.0])
def test_reference_is_grossmann_to_many_digits(beta_deg: float) -> None:
    beta, phi = float(np.deg2rad(beta_deg)), 0.7
    _, state = joint_state(beta, phi)
    mp.dps = 60
    sine, cosine = mp.sin(mpf(beta)), mp.cos(mpf(beta))
    square = cosine**2 + (sine * mp.sin(mpf(phi))) ** 2
    torsion = cosine / square
    bending = sine / square * mp.cos(mpf(phi)) * mp.sqrt(square)
    first, last = state.wrenches["bearing_in"], state.wrenches["bearing_out"]
    assert abs(first[3] - torsion) < mpf("1e-50")
    assert abs(mp.hypot(first[4], first[5]) - sine / square * mp.sin(mpf(phi))) < mpf("1e-50")
    assert abs(mp.hypot(last[4], last[5]) - bending) < mpf("1e-50")
    # Forces through the centre are open between fixed bearings.
    assert first[:3] == [None] * 3
    rounded = universal_joint.exact(beta, np.array([phi]))[0]
    expected = [torsion, mp.hypot(*first[4:]), 1, bending]
    np.testing.assert_allclose(rounded, np.array(expected, dtype=float), rtol=1e-15)


def test_reference_rates_are_those_of_the_closed_form() -> None:
    beta, phi, speed = 0.9, 0.7, 30.0
    _, state = joint_state(beta, phi, speed)
    ratio = single_joint.speed_ratio(beta, phi)
    assert float(state.velocities["bearing_out"]) == pytest.approx(speed * ratio, rel=1e-14)


def test_reference_closes_a_spatial_loop_exactly() -> None:
    exact = Exact(with_miss(mechanics("double_shaft_z"), "pin_1_out", 1e-3))
    names = [joint.name for joint in exact.joints]
    driven = {"bearing_in": 0.3, "joint_angle_1": 0.4, "joint_angle_2": 0.3}
    state = exact.at(dict.fromkeys(names, 0.0), driven)
    assert max(abs(x) for error in exact.errors(state.positions) for x in error) < mpf("1e-70")
    # A shaft with a spline is determinate, wherever its axes meet.
    assert all(None not in wrench for wrench in state.wrenches.values())


def test_dead_point_is_where_crank_and_coupler_are_in_line() -> None:
    low, high = cd.Scene(cd.load("four_bar"), drive="rocker_bearing").motion_range()
    assert float(dead_point(1)) == pytest.approx(low, abs=1e-8)
    assert float(dead_point(-1)) == pytest.approx(high, abs=1e-8)


def test_changed_descriptions_load_as_they_should() -> None:
    whole = cd.load("double_shaft_z")
    changed = cd.load(with_length(with_mass(mechanics("double_shaft_z"), "tube", 10.0), 2.0))
    index = whole.joints["pin_1_out"].id
    first, second = whole.model.inertias[index], changed.model.inertias[index]
    assert second.mass == pytest.approx(10.0 * first.mass)
    np.testing.assert_allclose(second.lever, 2.0 * first.lever)
    np.testing.assert_allclose(second.inertia, 40.0 * first.inertia, atol=1e-12)
    assert changed.characteristic_length == pytest.approx(2.0 * whole.characteristic_length)
    assert "<inertial>" not in massless(text("four_bar"))
    assert "<visual" not in mechanics("four_bar")
