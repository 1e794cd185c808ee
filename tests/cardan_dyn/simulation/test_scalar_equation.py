"""The scalar equation against inverse dynamics of the scene."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.linkages import coupling, four_bar, gears, loop

import cardan_dyn as cd
from cardan_dyn.motion.simulation.energy_functions import energy_functions
from cardan_dyn.motion.simulation.forces import Forces, state_function
from cardan_dyn.motion.simulation.scalar_equation import ScalarEquation


def equation_of(scene: cd.Scene, functions: dict[str, object]) -> ScalarEquation:
    mechanism, solver = scene.mechanism, scene.solver
    prepared = {name: state_function(name, value) for name, value in functions.items()}
    forces = Forces(mechanism, {}, {}, prepared, scene.problem.elements)
    return ScalarEquation(solver, energy_functions(solver), forces)


@pytest.fixture(scope="module")
def equation() -> ScalarEquation:
    bars = cd.load(four_bar(loop("continuous")))
    scene = cd.Scene(
        bars,
        drive="a",
        gravity=(1.0, -9.81, 0.0),
        elements=[cd.JointSpring("d", 30.0, damping=4.0)],
    )
    return equation_of(scene, {"b": lambda t, x, v: t - 2.0 * x["d"] * v["b"]})


@pytest.mark.parametrize("position", [-2.0, 0.4, 9.0])
def test_the_drive_needs_no_effort(equation: ScalarEquation, position: float) -> None:
    bars = equation._forces._mechanism
    y = equation.wrap(np.array([position, 3.0]))
    assert abs(y[0]) < 3.2
    speed, acceleration = equation.derivative(1.5, y)
    assert speed == 3.0
    scene = cd.Scene(
        bars,
        drive="a",
        gravity=(1.0, -9.81, 0.0),
        elements=[cd.JointSpring("d", 30.0, damping=4.0)],
    )
    motion = scene.sweep([position], 3.0).motion
    load = 1.5 - 2.0 * motion.position("d")[0] * motion.velocity("b")[0]
    needed = scene.sweep([position, position], 3.0, [acceleration, 0.0], loads={"b": load})
    # Series to 20 eps of the condition number; efforts are of the size of the second one.
    assert abs(needed.drive_effort[0]) < 1e-12 * abs(needed.drive_effort[1])
    found = equation.named(y, equation.turns)
    for name in "abd":
        assert found[0][name] == pytest.approx(motion.position(name)[0], abs=1e-12)
        assert found[1][name] == pytest.approx(motion.velocity(name)[0], abs=1e-12)
    equation.turns = np.zeros(2)


def test_it_obeys_no_constraints(equation: ScalarEquation) -> None:
    y = np.array([0.4, 3.0])
    assert equation.restored(0.0, y) is y
    assert equation.wrap(y) is y


def test_gears_turn_at_their_ratio() -> None:
    wheels = cd.load(gears(coupling("m", "a", "b", -0.5)))
    equation = equation_of(cd.Scene(wheels, drive="a"), {"b": lambda t: 1.0})
    _, acceleration = equation.derivative(0.0, np.array([0.4, 3.0]))
    assert acceleration == pytest.approx(-0.5 / (0.025 * 1.25), rel=1e-12)
    positions, _ = equation.named(np.array([0.4, 3.0]), np.array([100.0, 0.0]))
    assert positions["b"] == pytest.approx(-0.2 - 100.0 * np.pi, rel=1e-13)
