"""Forces of elements against slopes of their energy, Pinocchio's virtual work and statics."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from testkit.element_work import energy_of, generalised, slopes
from testkit.mixed_chain import MIXED, moved, rows

import cardan_dyn as cd
from cardan_dyn.core.elements.element_forces import ElementForces

RNG = np.random.default_rng(5)
ROOT = RNG.uniform(-1.0, 1.0, (6, 6))
STIFFNESS = ROOT @ ROOT.T
NEAR = pinocchio.SE3(pinocchio.rpy.rpyToMatrix(0.1, 0.3, 0.5), np.array([0.2, 0.1, 0.1]))
PLACED = pinocchio.SE3(pinocchio.rpy.rpyToMatrix(0.4, -0.7, 0.2), np.array([0.1, 0.3, -0.2]))
ELEMENTS = {
    "joint": cd.JointSpring("swing", 7.0, damping=2.0, rest=0.3),
    "slide": cd.JointSpring("slide", 40.0, damping=5.0),
    "points": cd.PointSpring("left", (0.1, 0.2, 0.3), "right", (-0.2, 0.1, 0.5), 30.0, 4.0, 0.4),
    "world": cd.PointSpring("base", (1.0, 2.0, 4.0), "slider", (0.1, 0.0, 0.2), 30.0, 4.0, 0.4),
    "zero length": cd.PointSpring("left", (0.1, 0.2, 0.3), "platform", (0, 0, 0.1), 9.0, 1.5),
    "bushing": cd.Bushing("platform", "left", PLACED.homogeneous, STIFFNESS, 0.3 * STIFFNESS),
    "bushing on the world": cd.Bushing("right", "base", (0.1, 0.2, 0.3), np.arange(1.0, 7.0)),
    "two frames": cd.Bushing(
        "left", "right", PLACED.homogeneous, STIFFNESS, origin_b=NEAR.homogeneous
    ),
}


@pytest.fixture(scope="module")
def mechanism() -> cd.Mechanism:
    return cd.load(MIXED)


@pytest.mark.parametrize("name", ELEMENTS)
def test_forces_at_rest_are_the_slopes_of_the_energy(mechanism: cd.Mechanism, name: str) -> None:
    forces = ElementForces(mechanism, [ELEMENTS[name]])
    x = rows(mechanism, 20, seed=1)
    acted = forces.at(x, np.zeros((20, mechanism.model.nv)))
    found = generalised(mechanism, x, acted)
    expected = -slopes(mechanism, energy_of(forces, mechanism), x)
    assert np.max(np.abs(expected)) > 1.0
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.max(np.abs(expected)))
    assert np.all(acted.dissipation == 0.0)
    assert np.all(acted.power == 0.0)


@pytest.mark.parametrize("name", ELEMENTS)
def test_power_is_what_the_energy_loses_and_dampers_take(
    mechanism: cd.Mechanism, name: str
) -> None:
    forces = ElementForces(mechanism, [ELEMENTS[name]])
    x = rows(mechanism, 20, seed=2)
    v = np.random.default_rng(3).uniform(-2.0, 2.0, (20, mechanism.model.nv))
    acted = forces.at(x, v)
    by_pinocchio = np.einsum("ni,ni->n", generalised(mechanism, x, acted), v)
    scale = np.max(np.abs(by_pinocchio))
    np.testing.assert_allclose(acted.power, by_pinocchio, atol=1e-13 * scale)
    energy, step = energy_of(forces, mechanism), 1e-3
    none = np.zeros_like(v)
    rates = [
        (
            energy(moved(mechanism, x, v, none, k * step))
            - energy(moved(mechanism, x, v, none, -k * step))
        )
        / (2.0 * k * step)
        for k in (1.0, 2.0, 3.0)
    ]
    lost = -(1.5 * rates[0] - 0.6 * rates[1] + 0.1 * rates[2])
    np.testing.assert_allclose(acted.power + acted.dissipation, lost, atol=1e-9 * scale)
    assert np.all(acted.dissipation >= 0.0)
    assert np.any(acted.dissipation > 0.1) == ("bushing on" not in name and name != "two frames")


@pytest.mark.parametrize("name", ["points", "zero length", "bushing", "two frames"])
def test_wrenches_on_both_links_are_in_balance(mechanism: cd.Mechanism, name: str) -> None:
    forces = ElementForces(mechanism, [ELEMENTS[name]])
    x = rows(mechanism, 5, seed=4)
    v = np.random.default_rng(5).uniform(-2.0, 2.0, (5, mechanism.model.nv))
    first, second = forces.at(x, v).wrenches
    assert {first.link, second.link} == set(ELEMENTS[name].links)
    np.testing.assert_allclose(first.force, -second.force, atol=1e-12)
    moments = []
    for wrench in (first, second):
        body, placement = mechanism.links[wrench.link]
        for sample, q in enumerate(mechanism.coordinates.configuration(x)):
            data = mechanism.model.createData()
            pinocchio.forwardKinematics(mechanism.model, data, q)
            origin = (data.oMi[body] * placement).translation
            moments.append(wrench.moment[sample] + np.cross(origin, wrench.force[sample]))
    np.testing.assert_allclose(moments[:5], -np.array(moments[5:]), atol=1e-11)
    assert np.max(np.abs(moments)) > 0.1


def test_a_bushing_is_without_force_at_the_zero(mechanism: cd.Mechanism) -> None:
    forces = ElementForces(mechanism, [ELEMENTS["bushing"]])
    acted = forces.at(mechanism.zero[None], np.zeros((1, mechanism.model.nv)))
    assert np.max(np.abs([wrench.force for wrench in acted.wrenches])) < 1e-14
    assert acted.potential_energy < 1e-28


def test_friction_and_actuators_act_along_their_coordinate(mechanism: cd.Mechanism) -> None:
    elements = [
        cd.JointFriction("slide", 3.0, transition=1e-2),
        cd.Actuator("slide", 2.0),
        cd.Actuator("swing", lambda t: np.sin(t)),
    ]
    forces = ElementForces(mechanism, elements)
    x = rows(mechanism, 3)
    v = np.zeros((3, mechanism.model.nv))
    slide, swing = (mechanism.coordinates.named[name].rate for name in ("slide", "swing"))
    v[:, slide] = [-1.0, 0.0, 1e-2]
    v[:, swing] = 2.0
    time = np.array([0.0, 0.5, 1.0])
    acted = forces.at(x, v, time)
    rubbing = np.array([3.0 / np.sqrt(1.0001), 0.0, -3.0 / np.sqrt(2.0)])
    np.testing.assert_allclose(acted.efforts[:, slide], 2.0 + rubbing, rtol=1e-14)
    np.testing.assert_allclose(acted.efforts[:, swing], np.sin(time), rtol=1e-14)
    np.testing.assert_allclose(acted.dissipation, -rubbing * v[:, slide], rtol=1e-14)
    power = (2.0 + rubbing) * v[:, slide] + 2.0 * np.sin(time)
    np.testing.assert_allclose(acted.power, power, rtol=1e-14)


def test_coincident_points_are_refused(mechanism: cd.Mechanism) -> None:
    # Both points are on the joint between the links, at zero.
    element = cd.PointSpring("platform", (0.5, 0.0, 0.1), "slider", (0, 0, 0), 1.0, length=0.1)
    x, v = mechanism.zero[None], np.zeros((1, mechanism.model.nv))
    with pytest.raises(cd.CardanError, match=r"elements\[0\] \(PointSpring\): its points coincide"):
        ElementForces(mechanism, [element]).at(x, v)
    loose = cd.PointSpring("platform", (0.5, 0.0, 0.1), "slider", (0, 0, 0), 1.0, 3.0)
    v[0, mechanism.coordinates.named["slide"].rate] = 2.0
    acted = ElementForces(mechanism, [loose]).at(x, v)
    assert acted.dissipation == pytest.approx(3.0 * 2.0**2)
    assert acted.power == pytest.approx(-12.0)


def test_each_element_is_shown_by_itself(mechanism: cd.Mechanism) -> None:
    forces = ElementForces(mechanism, list(ELEMENTS.values()))
    x, v = rows(mechanism, 4, seed=7), np.zeros((4, mechanism.model.nv))
    every = forces.each(x, v)
    total = forces.at(x, v)
    np.testing.assert_allclose(sum(item.energy for item in every), total.potential_energy)
    assert [item.energy.shape for item in every] == [(4,)] * len(ELEMENTS)
