"""Equilibria of pendulums and four-bars: closed forms and potential energies."""

from __future__ import annotations

import copy

import numpy as np
import pytest
from scipy.optimize import brentq
from testkit.linkages import four_bar, loop
from testkit.simulated import (
    ABOUT_PIN,
    GRAVITY,
    WEIGHT,
    link,
    parallelogram_law,
    parallelograms,
    pendulum,
)
from testkit.simulated import joint as pin

import cardan_dyn as cd
from cardan_dyn.core.dynamics.problem_solver import ProblemSolver
from cardan_dyn.core.problem.samples import Targets


@pytest.fixture(scope="module")
def hanging() -> cd.Scene:
    return cd.Scene(pendulum(), free="pin", gravity=GRAVITY)


def test_a_pendulum_hangs_and_stands(hanging: cd.Scene) -> None:
    low = hanging.equilibrium(0.9)
    assert low.position[0] == pytest.approx(0.0, abs=1e-14)
    assert low.stability == "stable"
    np.testing.assert_allclose(low.frequencies, [np.sqrt(WEIGHT / ABOUT_PIN)], rtol=1e-11)
    np.testing.assert_allclose(low.stiffness, [[WEIGHT]], rtol=1e-11)
    np.testing.assert_allclose(low.inertia, [[ABOUT_PIN]], rtol=1e-14)
    top = hanging.equilibrium(3.0)
    assert top.position[0] == pytest.approx(np.pi, abs=1e-14)
    assert top.stability == "unstable"
    assert top.frequencies.size == 0
    assert "unstable at pin 3.14159" in repr(top)
    assert np.max(np.abs(top.sweep["pin"].moment[..., 2])) < 1e-13


@pytest.mark.parametrize("torque", [1.0, 10.0])
def test_springs_and_loads_move_it(hanging: cd.Scene, torque: float) -> None:
    scene = hanging.replace(elements=[cd.JointSpring("pin", 6.0, damping=3.0, rest=0.5)])
    found = scene.equilibrium(loads={"pin": torque})

    def effort(phi: float) -> float:
        return torque - WEIGHT * np.sin(phi) - 6.0 * (phi - 0.5)

    place = brentq(effort, -1.0, 2.0, xtol=1e-15)
    assert found.position[0] == pytest.approx(place, abs=1e-13)
    square = (WEIGHT * np.cos(place) + 6.0) / ABOUT_PIN
    np.testing.assert_allclose(found.frequencies, [np.sqrt(square)], rtol=1e-10)
    assert scene.equilibrium(gravity=(0, 0, 0)).position[0] == pytest.approx(0.5, abs=1e-13)


def test_what_nothing_acts_on_is_indifferent(hanging: cd.Scene) -> None:
    found = hanging.equilibrium(0.4, gravity=(0.0, 0.0, -9.81))
    assert found.stability == "indifferent"
    assert found.position[0] == 0.4


def test_a_four_bar_rests_where_its_potential_is_least() -> None:
    scene = cd.Scene(cd.load(four_bar(loop("continuous"))), drive="a", gravity=GRAVITY)
    places = np.linspace(0.0, 2.0 * np.pi, 2001)
    turn = scene.sweep(places)
    # The work of the drive is the potential; its zeros with rising effort are stable.
    crossing = np.nonzero((turn.drive_effort[:-1] < 0.0) & (turn.drive_effort[1:] >= 0.0))[0]
    found = scene.replace(free=scene.drives).equilibrium(places[crossing[0]] + 0.2)
    assert found.stability == "stable"
    assert places[crossing[0]] <= found.position[0] % (2.0 * np.pi) <= places[crossing[0] + 1]


def test_frequencies_are_those_of_small_swings() -> None:
    inertia, weight = parallelogram_law(1)
    spring = cd.JointSpring("pin_0", 60.0)
    scene = cd.Scene(parallelograms(1), free="pin_0", gravity=GRAVITY, elements=[spring])
    found = scene.equilibrium(0.2)
    assert found.position[0] == pytest.approx(0.0, abs=1e-13)
    np.testing.assert_allclose(found.frequencies, [np.sqrt((60.0 - weight) / inertia)], rtol=1e-10)
    period = 2.0 * np.pi / found.frequencies[0]
    crossings = cd.Event(lambda t, p, s: p["pin_0"], direction=1)
    swing = scene.simulate(3.2 * period, position=1e-4, events=crossings, rtol=1e-11)
    times = [event.time for event in swing.events]
    # The period of a swing exceeds that of small ones by its square over some tens.
    assert (times[2] - times[0]) / 2.0 == pytest.approx(period, rel=1e-6)


def test_two_drives_have_two_frequencies() -> None:
    text = (
        '<robot name="two"><link name="base"/>{}{}<joint name="p" type="continuous">'
        '<parent link="base"/><child link="a"/><axis xyz="0 0 1"/></joint>'
        '<joint name="q" type="continuous"><parent link="a"/><child link="b"/>'
        '<origin xyz="0 -1 0"/><axis xyz="0 0 1"/></joint></robot>'
    )
    body = (
        '<link name="{}"><inertial><origin xyz="0 -1 0"/><mass value="1"/><inertia ixx="0.001" '
        'iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )
    mechanism = cd.load(text.format(body.format("a"), body.format("b")))
    found = cd.Scene(mechanism, free=["p", "q"], gravity=GRAVITY).equilibrium([0.1, -0.2])
    # q is relative: M of the double pendulum in relative angles.
    mass = np.array([[1.0 + 4.0, 2.0], [2.0, 1.0]]) + 0.001 * np.array([[2.0, 1.0], [1.0, 1.0]])
    mass[0, 0] = 1.0 + (1.0 + 1.0 + 2.0) + 0.002
    stiffness = 9.81 * np.array([[3.0, 1.0], [1.0, 1.0]])
    squares = np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real)
    np.testing.assert_allclose(found.stiffness, stiffness, rtol=1e-10)
    np.testing.assert_allclose(found.inertia, mass, rtol=1e-13)
    np.testing.assert_allclose(found.frequencies**2, squares, rtol=1e-10)
    assert copy.deepcopy(found).stability == "stable"


def test_none_is_told_apart_from_one(joint: cd.Mechanism) -> None:
    loaded = cd.Scene(
        joint, free="bearing_in", held={"joint_angle": 0.4}, loads={"bearing_out": 2.0}
    )
    with pytest.raises(cd.EquilibriumError, match="no equilibrium was found"):
        loaded.equilibrium(0.3)
    with pytest.raises(cd.ArgumentError, match="gravity"):
        loaded.equilibrium(0.3, gravity=9.81)
    with pytest.raises(cd.ArgumentError, match="position"):
        loaded.equilibrium([0.3, 1.0])


@pytest.mark.parametrize("part", [0.9, 0.999, 1.001, 1.1, 3.0])
def test_what_no_place_balances_is_no_equilibrium(part: float) -> None:
    """A crank whose torque is more than its weight holds anywhere, or less, from starts all round.

    Beside the place that holds most, steps become as short as those that end a search.
    """
    bar, turn = cd.load("four_bar"), np.linspace(-np.pi, np.pi, 4001)
    driven = cd.Scene(bar, drive="crank_bearing", gravity=GRAVITY)
    most = driven.sweep(turn).drive_effort.max()
    free = cd.Scene(
        bar, free="crank_bearing", gravity=GRAVITY, loads={"crank_bearing": part * most}
    )
    for start in np.linspace(-3.0, 3.0, 12):
        if part > 1.0:
            with pytest.raises(cd.EquilibriumError, match="no equilibrium was found"):
                free.equilibrium(start)
        else:
            (place,) = free.equilibrium(start).position
            held = driven.sweep([place]).drive_effort[0]
            assert held == pytest.approx(part * most, rel=1e-12)


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return how many positions each sweep is asked for."""
    sizes: list[int] = []
    assembled = ProblemSolver.assembled_in_turn

    def counted(self: ProblemSolver, targets: Targets) -> object:
        sizes.append(targets.size)
        return assembled(self, targets)

    monkeypatch.setattr(ProblemSolver, "assembled_in_turn", counted)
    return sizes


def test_a_search_for_what_is_not_there_ends(asked: list[int]) -> None:
    """Nothing holds legs under a platform, which grow for ever; they begin where they can be."""
    legs = [f"leg_{k}" for k in range(1, 7)]
    scene = cd.Scene(cd.load("stewart_platform"), free=legs, gravity=(0.0, 0.0, -9.81))
    with pytest.raises(cd.EquilibriumError, match="no equilibrium was found near the start; after"):
        scene.equilibrium([0.0, 0.01, 0.02, 0.03, 0.04, 0.05])
    assert len(asked) < 30
    asked.clear()
    with pytest.raises(cd.AssemblyError):
        scene.equilibrium([-0.68, -0.83, -0.69, -0.93, -0.81, -0.72])
    assert len(asked) == 1


def test_a_narrow_valley_is_followed_however_slowly(asked: list[int]) -> None:
    """Two bars on the end of a stiff spring; efforts hardly fall while these turn about it.

    Steps that are too long are known by one position, not by those of differences.
    """
    bar = (
        '<link name="{0}"><inertial><origin xyz="0.5 0 0"/><mass value="1"/>'
        '<inertia ixx="0.01" iyy="0.1" izz="0.1"/></inertial></link>'
    )
    arm = cd.load(
        f'<robot name="arm"><link name="ground"/>{bar.format("upper")}{bar.format("lower")}'
        '<joint name="shoulder" type="continuous"><parent link="ground"/><child link="upper"/>'
        '<axis xyz="0 1 0"/></joint><joint name="elbow" type="continuous"><parent link="upper"/>'
        '<child link="lower"/><origin xyz="1 0 0"/><axis xyz="0 1 0"/></joint></robot>'
    )
    spring = cd.PointSpring("ground", (1, 0, 0), "lower", (1, 0, 0), stiffness=1e7, length=1.0)
    found = cd.Scene(
        arm, free=["shoulder", "elbow"], gravity=(0.0, 0.0, -9.81), elements=[spring]
    ).equilibrium([1.0, 1.0])
    # The lower bar stands on the spring's foot, which gives way under half of both weights.
    assert found.position == pytest.approx([1.4715e-6, -np.pi / 2], abs=2e-6)
    assert sum(size > 1 for size in asked) < 150
    assert np.max(np.abs(found.sweep.drive_effort)) < 1e-8


@pytest.mark.parametrize("angle", [0.1, 0.5, 1.0])
def test_balanced_shafts_under_their_weight_are_indifferent(
    joint: cd.Mechanism, angle: float
) -> None:
    held = {"joint_angle": angle}
    found = cd.Scene(joint, free="bearing_in", held=held, gravity=GRAVITY).equilibrium(0.7)
    assert found.stability == "indifferent"
    assert found.frequencies.size == 0


@pytest.mark.parametrize(("push", "stability"), [(1.5, "stable"), (2.5, "unstable")])
def test_a_force_that_turns_with_its_link(push: float, stability: str) -> None:
    """Ziegler's column in relative angles: masses of 1 kg at the ends of links of 1 m."""
    bodies = link("a", (1.0, 0.0), 1.0, 1e-9) + link("b", (1.0, 0.0), 1.0, 1e-9)
    joints = pin("p", "base", "a") + pin("q", "a", "b", (1.0, 0.0))
    column = cd.load(f'<robot name="column"><link name="base"/>{bodies}{joints}</robot>')
    springs = [cd.JointSpring("p", 1.0), cd.JointSpring("q", 1.0)]
    load = {"b": cd.Wrench(force=(-push, 0.0, 0.0))}
    scene = cd.Scene(column, free=["p", "q"], elements=springs, loads=load)
    found = scene.equilibrium()
    assert found.stability == stability
    # Absolute angles: M = [[2, 1], [1, 1]], K = [[2 - P, P - 1], [-1, 1]].
    mass, stiffness = np.array([[2, 1], [1, 1]]), np.array([[2 - push, push - 1], [-1, 1]])
    squares = np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)))
    expected = np.sqrt(squares) if stability == "stable" else []
    np.testing.assert_allclose(found.frequencies, expected, rtol=1e-7)


def test_efforts_that_outputs_leave_out_are_asked_for() -> None:
    """What is not solved is not taken for nothing."""
    arm = (
        '<link name="{0}"><inertial><origin xyz="0 -1 0"/><mass value="1"/><inertia/></inertial>'
        "</link>"
        '<joint name="{0}_pin" type="continuous"><parent link="base"/><child link="{0}"/>'
        '<axis xyz="0 0 1"/></joint>'
    )
    text = f'<robot name="two_arms"><link name="base"/>{arm.format("a")}{arm.format("b")}</robot>'
    free = {"free": ["a_pin", "b_pin"], "gravity": (0.0, -9.81, 0.0)}
    scene = cd.Scene(cd.load(text), outputs=["a_pin"], **free)
    with pytest.raises(cd.ModelError, match="add their joints to the outputs, which are: a_pin"):
        scene.equilibrium([0.1, -0.2])
    every = scene.replace(outputs=None).equilibrium([0.1, -0.2])
    np.testing.assert_allclose(every.position, 0.0, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(every.inertia, np.eye(2), rtol=0.0, atol=1e-12)
