"""Tapes of chains against Pinocchio's own constrained dynamics, wherever they choose."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin
import pytest
from testkit.bundled import EVERY_KIND
from testkit.constrained import accelerations
from testkit.linkages import four_bar, loop
from testkit.rows_of_loops import parallelograms, spatial, tower

import cardan_dyn as cd
from cardan_dyn.motion.simulation.constrained_model import ConstrainedModel
from cardan_dyn.motion.simulation.system import System
from cardan_dyn.motion.simulation.turning_model import turning_model

Array = np.ndarray
GRAVITY = np.array([0.3, -9.81, 0.2])
EXACT = 1e-12


def by_pinocchio(
    mechanism: cd.Mechanism, x: Array, v: Array, efforts: Array, told: dict[int, float]
) -> Array:
    """Accelerations by Pinocchio; what is told is made immovable but for its own effort."""
    model = turning_model(mechanism, GRAVITY)
    for body in mechanism.auxiliary_bodies:
        model.inertias[body] = pin.Inertia.Zero()
    heavy, efforts = np.zeros(model.nv), efforts.copy()
    for rate, acceleration in told.items():
        heavy[rate], efforts[rate] = 1e15, 1e15 * acceleration
    model.armature = heavy
    data = model.createData()
    datas = pin.StdVec_RigidConstraintData()
    for item in mechanism.constraint_models:
        datas.append(item.createData())
    pin.initConstraintDynamics(model, data, mechanism.constraint_models, datas)
    settings = pin.ProximalSettings(1e-15, 1e-8, 50)
    given = model, data, x, v, efforts, mechanism.constraint_models, datas, settings
    return np.array(pin.constraintDynamics(*given))


def states(
    mechanism: cd.Mechanism, model: ConstrainedModel, x: Array, count: int, size: float
) -> list[tuple[Array, Array, Array]]:
    """Closed states about coordinates, and efforts."""
    random, plain = np.random.default_rng(3), turning_model(mechanism)
    result = []
    for _ in range(count):
        way, v, efforts = random.normal(size=(3, mechanism.model.nv))
        way[model.prescribed] = 0.0
        closed, v = model.closed(pin.integrate(plain, x, size * way), v)
        result.append((*model.closed(closed, v), efforts))
    return result


@pytest.mark.parametrize("name", EVERY_KIND)
def test_bundled_mechanisms(name: str) -> None:
    mechanism = cd.load(name)
    closed = mechanism.coordinates.neutral()
    model = ConstrainedModel(mechanism, [], GRAVITY, closed)
    for x, v, efforts in states(mechanism, model, closed, 5, 0.02):
        expected = by_pinocchio(mechanism, x, v, efforts, {})
        found = accelerations(model, x, v, efforts)
        assert np.max(np.abs(found - expected)) < EXACT * np.max(np.abs(expected))


@pytest.mark.parametrize(
    ("name", "drive"),
    [
        ("drive_line", "bearing_in"),
        ("slider_crank", "crank_bearing"),
        ("stewart_platform", "leg_1"),
    ],
)
def test_prescribed_coordinates(name: str, drive: str) -> None:
    mechanism = cd.load(name)
    closed = mechanism.coordinates.neutral()
    told = mechanism.coordinates.rates_of([drive])
    model = ConstrainedModel(mechanism, told, GRAVITY, closed)
    for x, v, efforts in states(mechanism, model, closed, 3, 0.02):
        expected = by_pinocchio(mechanism, x, v, efforts, {told[0]: 2.5})
        found = accelerations(model, x, v, efforts, np.array([2.5]))
        assert np.max(np.abs(found - expected)) < 10.0 * EXACT * np.max(np.abs(expected))


@pytest.mark.slow
@pytest.mark.parametrize("made", [parallelograms, spatial, tower])
def test_many_loops(made: Callable[[int], cd.Mechanism]) -> None:
    """As exact as few, and of instructions in proportion to them unless all move by themselves."""
    lengths = []
    for count in (8, 16):
        mechanism = made(count)
        levels = [f"left_joint_{k}" for k in range(count)]
        drives = levels if made is tower else ["pivot_0"]
        angles = 0.3 * np.cos(np.pi * np.arange(len(drives))) + 0.1
        turn = cd.Scene(mechanism, drive=drives, outputs=[]).sweep(angles[None, :])
        closed = turn.motion.x[0]
        model = ConstrainedModel(mechanism, [], GRAVITY, closed)
        x, v, efforts = states(mechanism, model, closed, 1, 1e-3)[0]
        expected = by_pinocchio(mechanism, x, v, efforts, {})
        found = accelerations(model, x, v, efforts)
        assert np.max(np.abs(found - expected)) < 1e-11 * np.max(np.abs(expected))
        (tape,) = model.chains[0]._tapes.made.values()
        lengths.append(len(tape._program.code.body))
    assert lengths[1] < (2.1 if len(drives) == 1 else 4.5) * lengths[0]


def test_other_coordinates_are_independent_where_the_first_ones_do_not_decide() -> None:
    """A four-bar whose output turns back: beside there the input is no function of it."""
    mechanism = cd.load(four_bar(loop("continuous")))
    output = mechanism.coordinates.rates_of(["d"])
    turn = cd.Scene(mechanism, drive="a", outputs=[]).sweep(np.linspace(0.0, 2.0 * np.pi, 721))
    model = ConstrainedModel(mechanism, [], GRAVITY, turn.motion.x[0], output)
    (chain,) = model.chains
    random = np.random.default_rng(4)
    for x in turn.motion.x:
        x, v = model.closed(x, random.normal(size=4))
        expected = by_pinocchio(mechanism, x, v, np.zeros(4), {})
        found = accelerations(model, x, v)
        assert np.max(np.abs(found - expected)) < 1e-11 * np.max(np.abs(expected))
    assert 2 <= len(chain._tapes.made) <= 3
    assert not chain.was_weak


def test_states_beyond_all_numbers_give_none() -> None:
    mechanism = cd.load("four_bar")
    closed = mechanism.coordinates.neutral()
    model = ConstrainedModel(mechanism, [], GRAVITY, closed)
    beyond = np.full(4, np.nan)
    assert np.all(np.isnan(accelerations(model, beyond, closed)))
    assert np.all(np.isnan(accelerations(model, closed, beyond)))


@pytest.mark.slow
def test_free_motion_of_many_loops_needs_no_effort() -> None:
    scene = cd.Scene(parallelograms(16), free="pivot_0", gravity=(0, -9.81, 0))
    trajectory = scene.simulate(0.5, position=0.4, method="DOP853", rtol=1e-10)
    assert trajectory.effort_residual < 1e-12
    assert trajectory.energy_residual < 1e-9
    assert np.max(trajectory.loop_residual) < 1e-12


def test_nothing_moves_where_nothing_acts() -> None:
    scene = cd.Scene(parallelograms(13), free="pivot_0", outputs=[])
    still = scene.simulate(1.0, position=0.4, method="DOP853")
    np.testing.assert_array_equal(still.speed, 0.0)
    # Rounding of the start is a gap, which is closed.
    np.testing.assert_allclose(still.position, 0.4, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("name", ["universal_joint", "stewart_platform"])
def test_steps_by_programs_are_those_by_functions(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """To the last bit, and as many rates are counted; balls are among them."""
    is_joint = name == "universal_joint"
    held = {"joint_angle": 0.1} if is_joint else {f"leg_{k}": 0.0 for k in range(2, 7)}
    free = "bearing_in" if is_joint else "leg_1"
    scene = cd.Scene(cd.load(name), free=free, held=held, gravity=GRAVITY, outputs=[])
    runs = []
    for by_program in (True, False):
        if not by_program:
            monkeypatch.setattr(System, "traced", lambda _: None)
        runs.append(scene.simulate(0.05, position=0.01, method="DOP853", rtol=1e-8))
    np.testing.assert_array_equal(runs[0].position, runs[1].position)
    np.testing.assert_array_equal(runs[0].speed, runs[1].speed)
    assert runs[0].evaluations == runs[1].evaluations
