"""Element loads of the proof agree with those of the solution, and false ones are refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio
import pytest
from testkit.claims import claimed, four_bar, refused, spatial
from testkit.mixed_chain import MIXED, rows

import cardan_dyn as cd
from cardan_dyn.core.description.second_reading import reread
from cardan_dyn.core.elements.element import Element
from cardan_dyn.core.elements.element_forces import ElementForces
from cardan_dyn.core.mechanism.frames import Frames
from cardan_dyn.core.proof.element_loads import ProvenElements
from cardan_dyn.core.proof.placing import stacked
from cardan_dyn.core.proof.screws import Screws

ROOT = np.random.default_rng(8).uniform(-1.0, 1.0, (6, 6))
K = ROOT @ ROOT.T
PLACED = pinocchio.SE3(pinocchio.rpy.rpyToMatrix(0.4, -0.7, 0.2), np.array([0.1, 0.3, -0.2]))
ELEMENTS: list[Element] = [
    cd.JointSpring("swing", 7.0, damping=2.0, rest=0.3),
    cd.JointFriction("slide", 5.0, transition=0.5),
    cd.Actuator("hinge", np.cos),
    cd.PointSpring("left", (0.1, 0.2, 0.3), "right", (-0.2, 0.1, 0.5), 30.0, 4.0, 0.4),
    cd.PointSpring("base", (1.0, 2.0, 4.0), "slider", (0.1, 0.0, 0.2), 30.0, 4.0, 0.4),
    cd.PointSpring("left", (0.1, 0.2, 0.3), "platform", (0.0, 0.0, 0.1), 9.0, 1.5),
    cd.PointActuator(
        *("left", (0.1, 0.2, 0.3), "slider", (0.1, 0.0, 0.2)),
        lambda length, rate: 5.0 - 3.0 * length - 2.0 * rate,
        of=("length", "rate"),
    ),
    cd.Bushing("platform", "left", PLACED.homogeneous, K, 0.3 * K),
    cd.Bushing("right", "base", (0.1, 0.2, 0.3), K, 0.2 * K),
    cd.Bushing("base", "right", (0.1, 0.2, 0.3), K, origin_b=np.eye(4)),
]


@pytest.fixture(scope="module")
def mixed() -> tuple[cd.Mechanism, Frames, Screws]:
    mechanism = cd.load(MIXED)
    frames = Frames(reread(mechanism.description), mechanism.coordinates)
    return mechanism, frames, Screws(frames)


@pytest.mark.parametrize("element", ELEMENTS, ids=lambda item: type(item).__name__)
@pytest.mark.parametrize("moving", [False, True])
def test_both_computations_agree(
    element: Element, moving: bool, mixed: tuple[cd.Mechanism, Frames, Screws]
) -> None:
    mechanism, frames, screws = mixed
    x, count = rows(mechanism, 12, seed=6), 12
    v = np.random.default_rng(7).uniform(-2.0, 2.0, (count, mechanism.model.nv)) * moving
    time = np.linspace(0.0, 2.0, count)
    acted = ElementForces(mechanism, [element]).at(x, v, time)
    placed, velocities = screws.placing.placed(list(x.T)), None
    if moving:
        velocities = screws.absolute(screws.relative(screws.units(placed), list(v.T)))
    proven = ProvenElements(screws, [element], mechanism.zero, 1.0)
    loads = proven.on(placed, velocities, x, v, time)
    np.testing.assert_allclose(loads.efforts.T, acted.efforts, atol=1e-12)
    # Wrenches about the corner against those about the origins of the links.
    found = np.zeros((frames.tree, 2, 3, count))
    for body, wrench in loads.wrenches:
        found[body] += wrench
    expected = np.zeros_like(found)
    for link, force, moment in acted.wrenches:
        body, placement = frames.links[link]
        axes, corner = placed[frames.last[body]]
        origin = np.einsum("c,cin->ni", placement[:, 3], stacked([*axes, corner], count))
        expected[body, 0] += force.T
        expected[body, 1] += (moment + np.cross(origin, force)).T
    scale = max(1.0, float(np.max(np.abs(expected))))
    np.testing.assert_allclose(found, expected, atol=1e-12 * scale)
    sizes = [np.max(np.abs(acted.efforts))] + [np.max(np.abs(w.force)) for w in acted.wrenches]
    if moving or not isinstance(element, cd.JointFriction):
        assert np.max(sizes) > 0.1
    assert np.max(loads.terms) >= 0.5 * np.max(sizes)


def on_four_bar(**changes: float) -> list[Element]:
    given = {"stiffness": 500.0, "damping": 30.0, "length": 0.2, **changes}
    return [
        cd.PointSpring("crank", (0.05, 0.02, 0.0), "rocker", (0.1, 0.1, 0.0), **given),
        cd.JointSpring("rocker_bearing", 5.0, 3.0, 0.2),
        cd.Bushing("coupler", "base", (0.1, 0.0, 0.0), 50.0 * K, 5.0 * K),
    ]


@pytest.mark.parametrize(
    "false",
    [
        lambda elements: on_four_bar(stiffness=500.001),
        lambda elements: on_four_bar(damping=30.0001),
        lambda elements: on_four_bar(length=0.200001),
        lambda elements: [elements[0], replace(elements[1], rest=0.20001), elements[2]],
        lambda elements: [elements[0], replace(elements[1], damping=3.0001), elements[2]],
        lambda elements: [*elements[:2], replace(elements[2], stiffness=50.001 * K)],
        lambda elements: [*elements[:2], replace(elements[2], damping=5.0001 * K)],
        lambda elements: [*elements[:2], replace(elements[2], origin=np.array([0.1, 1e-6, 0]))],
        lambda elements: elements[:2],
    ],
)
def test_forces_of_other_elements_are_refused(false: object) -> None:
    """The claim of a sweep, judged with slightly different elements."""
    elements = on_four_bar()
    scene = four_bar(elements=elements)
    bodies, claim, where = claimed(scene, speed=3.0, acceleration=1.0)
    assert not refused(bodies, claim, where)
    others = false(elements)  # type: ignore[operator]
    mechanism = scene.mechanism
    bodies._elements = ProvenElements(
        bodies._screws, others, mechanism.zero, mechanism.characteristic_length
    )
    assert refused(bodies, claim, where)


def test_wrong_times_are_refused() -> None:
    scene = four_bar(elements=[cd.Actuator("rocker_bearing", lambda t: 3.0 + t)])
    bodies, claim, where = claimed(scene, time=2.0)
    assert not refused(bodies, claim, where)
    assert refused(bodies, claim._replace(time=np.array([2.0001])), where)


def test_stiff_elements_are_proven_down_to_the_rounding_of_their_terms() -> None:
    """A bushing that carries the weight of a shaft, of a stiffness far beyond what it needs."""
    stiff = cd.Bushing("tube", "base", (0.0, 0.0, 0.0), np.full(6, 1e9))
    free = spatial(loads=None)
    link = free.mechanism.link_names
    stiff = replace(stiff, link_a=link[0], link_b=link[-1])
    turn = free.replace(elements=[stiff]).sweep(np.linspace(0.0, 0.3, 20))
    assert turn.balance_residual < 1e-8
    assert turn.condition.max() > free.sweep([0.0]).condition.max()


def test_elements_at_rest_need_no_twists() -> None:
    scene = four_bar(elements=on_four_bar(), gravity=None, loads=None)
    rest, moving = scene.sweep([0.3]), scene.sweep([0.3], speed=1e-12)
    assert rest.balance_residual < 1e-13
    np.testing.assert_allclose(rest.drive_effort, moving.drive_effort, rtol=1e-9)
