"""Energy functions against the universal joint's kinetic energy and a parallelogram-free weight."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from testkit.linkages import four_bar, loop
from testkit.scenes import universal
from testkit.simulated import GRAVITY, WEIGHT, SpinningJoint, pendulum

import cardan_dyn as cd
from cardan_dyn.core.kinematics.closing.group_solver import GroupSolver
from cardan_dyn.motion.simulation.energy_functions import NotSuitableError, energy_functions
from cardan_dyn.motion.simulation.forces import Forces

POINTS = np.linspace(-5.0, 9.0, 60)


def forces_of(scene: cd.Scene) -> Forces:
    problem = scene.problem
    return Forces(
        scene.mechanism, problem.joint_loads, problem.link_loads, {}, elements=problem.elements
    )


@pytest.mark.parametrize("beta", [0.1, 0.9, 1.4])
def test_inertia_of_the_universal_joint(joint: cd.Mechanism, beta: float) -> None:
    functions = energy_functions(universal(joint, beta).solver)
    expected = SpinningJoint(beta).inertia(POINTS)
    error = np.max(np.abs(functions.inertia(POINTS)[0] - expected))
    # As many coefficients as there are may err by what is stated for each of them.
    assert error < 64.0 * functions.error * np.max(expected)
    assert functions.error < 1e-10


def test_loads_turn_with_the_velocity_ratio(joint: cd.Mechanism) -> None:
    scene = universal(joint, 0.7, load=-3.0)
    loaded = energy_functions(scene.solver, forces_of(scene))
    np.testing.assert_allclose(
        loaded.force(POINTS)[0], -3.0 * SpinningJoint(0.7).ratio(POINTS), rtol=1e-12
    )
    assert not np.any(energy_functions(scene.solver).force(POINTS))


def test_weight_and_springs_of_a_pendulum() -> None:
    spring = cd.PointSpring("base", (1.0, 0.0, 0.0), "bob", (0.0, -0.5, 0.0), 40.0)
    scene = cd.Scene(pendulum(), drive="pin", gravity=GRAVITY, elements=[spring])
    weight = energy_functions(scene.solver)
    np.testing.assert_allclose(weight.force(POINTS)[0], -WEIGHT * np.sin(POINTS), atol=1e-12)
    # |span|² / 2 = 1.25 / 2 - 0.5 sin φ.
    both = energy_functions(scene.solver, forces_of(scene))
    expected = -WEIGHT * np.sin(POINTS) + 40.0 * 0.5 * np.cos(POINTS)
    np.testing.assert_allclose(both.force(POINTS)[0], expected, atol=1e-12)


@pytest.mark.parametrize("rocker", ["a", "d"])
def test_drives_that_do_not_turn_through_are_refused(rocker: str) -> None:
    scene = cd.Scene(cd.load(four_bar(loop("continuous"))), drive=rocker)
    if rocker == "a":
        assert energy_functions(scene.solver).inertia.frequency == pytest.approx(1.0)
    else:
        with pytest.raises(NotSuitableError):
            energy_functions(scene.solver)


def test_springs_that_wind_up_are_refused() -> None:
    scene = cd.Scene(pendulum(), drive="pin", elements=[cd.JointSpring("pin", 3.0)])
    with pytest.raises(NotSuitableError, match="wind up"):
        energy_functions(scene.solver, forces_of(scene))


def counted_samples(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return a list that gets the number of samples whenever loops are evaluated."""
    counted, evaluate = [], GroupSolver.evaluate

    def counting(solver: GroupSolver, x: np.ndarray, *given: object) -> object:
        counted.append(len(x))
        return evaluate(solver, x, *given)

    monkeypatch.setattr(GroupSolver, "evaluate", counting)
    return counted


def test_what_repeats_within_a_turn_is_sampled_over_a_part_of_it(
    joint: cd.Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    solver = universal(joint, 1.4).solver
    counted = counted_samples(monkeypatch)
    inertia = energy_functions(solver).inertia
    assert sum(counted) < 1200
    assert not np.any(inertia.coefficients[:, 1::2])
    assert inertia.coefficients.shape[1] > 100


def test_what_only_seems_to_repeat_within_a_turn(
    joint: cd.Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Waves that vanish at the first 64 positions."""
    drive = joint.coordinates.named["bearing_in"].column

    def inertia(x: np.ndarray) -> np.ndarray:
        return 3.0 + 1.0 / (1.1 - np.cos(2.0 * x)) + 0.1 * np.sin(x) * np.sin(32.0 * x)

    def energy(model: object, data: object, q: np.ndarray, v: np.ndarray) -> float:
        return 0.5 * float(inertia(q[drive]))

    monkeypatch.setattr(pinocchio, "computeKineticEnergy", energy)
    found = energy_functions(universal(joint, 0.3).solver).inertia(POINTS)[0]
    np.testing.assert_allclose(found, inertia(POINTS), rtol=1e-11)


def test_scenes_that_move_alike_share_their_energy_functions(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A simulation in a new scene of a known mechanism closes loops at its start alone."""
    counted = counted_samples(monkeypatch)
    seen = cd.load("universal_joint")

    def simulated(mechanism: cd.Mechanism, speed: float) -> np.ndarray:
        counted.clear()
        held = {"joint_angle": 0.9}
        scene = cd.Scene(mechanism, free="bearing_in", held=held, outputs=[], gravity=GRAVITY)
        return scene.simulate(2.0, speed=speed, method="quadrature").at([0.7, 2.0]).position

    simulated(seen, 3.0)
    assert sum(counted) > 100
    again = simulated(seen, 2.0)
    assert sum(counted) < 10
    np.testing.assert_array_equal(again, simulated(cd.load("universal_joint"), 2.0))


@pytest.mark.parametrize(
    "other",
    [
        {"gravity": (0.3, -9.0, 2.5)},
        {"held": {"joint_angle": 0.75}},
        {"drive": "bearing_out"},
        {"near": {"bearing_in": 0.4}},
    ],
    ids=lambda other: next(iter(other)),
)
def test_energy_functions_of_other_scenes_are_their_own(other: dict[str, object]) -> None:
    given = {"drive": "bearing_in", "held": {"joint_angle": 0.7}, "gravity": (0.3, -9.0, 2.0)}
    seen = cd.load("universal_joint")
    first = energy_functions(cd.Scene(seen, **given).solver)
    assert energy_functions(cd.Scene(seen, **given).solver) is first
    ours, own = (
        energy_functions(cd.Scene(mechanism, **{**given, **other}).solver)
        for mechanism in (seen, cd.load("universal_joint"))
    )
    for found, expected in zip(ours[:2], own[:2], strict=True):
        np.testing.assert_array_equal(found.coefficients, expected.coefficients)
    # What is kept is that of the weight alone.
    loaded = cd.Scene(seen, loads={"bearing_out": -1.0}, **given)
    assert np.any(energy_functions(loaded.solver, forces_of(loaded)).force(POINTS) < -0.5)
    with pytest.raises(ValueError, match="read-only"):
        first.inertia.coefficients[0, 0] = 1.0
