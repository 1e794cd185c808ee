"""Rates against differences of closed positions, efforts by virtual work."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.claims import SCENES, acting, four_bar, positions
from testkit.linkages import coupling, gears
from testkit.scenes import double

import cardan_dyn as cd
from cardan_dyn.core.dynamics.inverse_dynamics import Inputs, InverseDynamics, Solution
from cardan_dyn.core.kinematics.closing.all_groups import ClosedState
from cardan_dyn.core.problem.samples import Targets, acting_on, targets_of
from cardan_dyn.kit.frozen import frozen

COUNT = 4
SPEED, ACCELERATION = 1.5, -0.7
STEP = 1e-3
OFFSETS = STEP * np.arange(-3, 4)
FIRST = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / (60.0 * STEP)
SECOND = np.array([2.0, -27.0, 270.0, -490.0, 270.0, -27.0, 2.0]) / (180.0 * STEP**2)
"""Central differences of sixth order over seven samples."""


@pytest.fixture(scope="module", params=SCENES)
def scene(request: pytest.FixtureRequest) -> cd.Scene:
    return SCENES[request.param]()


def dynamics(scene: cd.Scene) -> InverseDynamics:
    return scene.solver.inverse_dynamics


def closed(scene: cd.Scene, where: np.ndarray | None = None) -> ClosedState:
    (state,) = scene.assemble(positions(scene)[:COUNT] if where is None else where).blocks
    return state


def inputs(scene: cd.Scene, state: ClosedState, speed: float, acceleration: float) -> Inputs:
    where = positions(scene)[: len(state.x)]
    rates = np.full_like(where, speed), np.full_like(where, acceleration)
    targets = Targets.of_positions(where)
    return Inputs.of(scene.problem, targets, acting(scene.solver, *rates), np.zeros_like(state.x))


def solution(scene: cd.Scene, speed: float = SPEED, acceleration: float = ACCELERATION) -> Solution:
    state = closed(scene)
    given = inputs(scene, state, speed, acceleration)
    return scene.solver.taped.solution(dynamics(scene), state.x, given, lambda samples: state)


@pytest.mark.parametrize("shape", [(), (1,), (COUNT,)])
def test_loads_at_joints_are_efforts_of_their_coordinates(shape: tuple[int, ...]) -> None:
    """Of all samples together, or of each of them where one load differs."""
    scene = SCENES["universal"]()
    problem, where = scene.problem, positions(scene)[:COUNT]
    varying = np.linspace(1.0, 2.0, COUNT).reshape(-1)[: max(1, *shape, 0)].reshape(shape)
    loads = {"bearing_out": -5.0, "pin_in": varying}
    acts = acting_on(problem, loads=loads).flat((COUNT,))
    targets = Targets.of_positions(where)
    given = Inputs.of(problem, targets, acts, np.zeros((COUNT, 1)))
    columns = scene.mechanism.coordinates.velocity_columns
    expected = np.zeros((COUNT if shape == (COUNT,) else 1, scene.mechanism.model.nv))
    expected[:, columns["bearing_out"].start] = -5.0
    expected[:, columns["pin_in"].start] = varying
    np.testing.assert_array_equal(given.loads, expected)
    assert list(given.link_loads) == ["shaft_out"]
    assert not given.has_rates
    none = acts._replace(joint_loads=frozen({}))
    np.testing.assert_array_equal(
        Inputs.of(problem, targets, none, np.zeros((COUNT, 1))).loads, np.zeros_like(expected[:1])
    )


def test_held_positions_are_those_of_the_scene_unless_they_vary() -> None:
    scene = SCENES["spatial"]()
    problem, turns = scene.problem, np.zeros((COUNT, 1))
    acts, where = acting_on(problem).flat((COUNT,)), np.linspace(0.0, 1.0, COUNT)
    angles = np.array([0.3, 0.2, 0.1, 0.0])
    plain = Inputs.of(problem, targets_of(problem, where), acts, turns)
    np.testing.assert_array_equal(plain.held, [list(problem.held.values())])
    for given in (angles, 0.7):
        targets = targets_of(problem, where, {"joint_angle_1_v": given})
        varied = Inputs.of(problem, targets, acts, turns).held
        for column, (name, angle) in enumerate(problem.held.items()):
            expected = given if name == "joint_angle_1_v" else angle
            np.testing.assert_array_equal(varied[:, column], np.broadcast_to(expected, COUNT))


def test_inputs_of_some_samples() -> None:
    """What is the same for all samples is so for some of them."""
    scene = SCENES["universal"]()
    problem, rng = scene.problem, np.random.default_rng(0)
    effort, gravity, factor = rng.normal(size=6), rng.normal(size=(6, 3)), rng.uniform(size=6)
    force, speed = rng.normal(size=(6, 3)), rng.normal(size=6)
    angles, turns = rng.uniform(size=6), rng.normal(size=(6, 5))
    acts = acting_on(
        problem,
        speed,
        0.0,
        {"bearing_out": effort, "cross": cd.Wrench(force)},
        gravity,
        {"cross": factor, "shaft_in": 2.0},
        np.arange(6.0),
    ).flat((6,), slice(2, 5))
    targets = targets_of(problem, np.arange(6.0), {"joint_angle": angles}).block(slice(2, 5))
    part = Inputs.of(problem, targets, acts, turns[2:5])
    column = scene.mechanism.coordinates.velocity_columns["bearing_out"].start
    for found, expected in (
        (part.positions, np.arange(2.0, 5.0)[:, None]),
        (part.speeds, speed[2:5, None]),
        (part.accelerations, np.zeros((3, 1))),
        (part.held, angles[2:5, None]),
        (part.loads[:, column], effort[2:5]),
        (part.link_loads["cross"].force, force[2:5]),
        (part.link_loads["cross"].moment, np.zeros((1, 3))),
        (part.gravity, gravity[2:5]),
        (part.inertia["cross"], factor[2:5]),
        (part.inertia["shaft_in"], [2.0]),
        (part.turns, turns[2:5]),
        (part.time, [2.0, 3.0, 4.0]),
    ):
        np.testing.assert_array_equal(found, expected)
    assert part.has_rates


def test_rates_are_differences_of_closed_positions(scene: cd.Scene) -> None:
    """All drives move from the same position with their speed and acceleration."""
    start = positions(scene)[COUNT]
    motion = SPEED * OFFSETS + 0.5 * ACCELERATION * OFFSETS**2
    x = closed(scene, start + motion[:, None]).x
    state, drives = closed(scene, start[None]), len(scene.drives)
    rates = dynamics(scene).joint_rates(
        state, np.full((1, drives), SPEED), np.full((1, drives), ACCELERATION)
    )
    coordinates = scene.mechanism.coordinates
    velocities = coordinates.derivative(state.x, rates.v)
    accelerations = coordinates.curvature(state.x, rates.v, rates.a)
    np.testing.assert_allclose((FIRST @ x)[None], velocities, atol=1e-9)
    np.testing.assert_allclose((SECOND @ x)[None], accelerations, atol=1e-6)


def test_velocity_ratios_are_those_of_each_drive_alone(scene: cd.Scene) -> None:
    state, drives = closed(scene), len(scene.drives)
    velocity_ratios, v, _, _ = dynamics(scene).joint_rates(
        state, np.tile(np.arange(2.0, 2.0 + drives), (COUNT, 1)), np.zeros((COUNT, drives))
    )
    for drive in range(drives):
        speeds = np.zeros((COUNT, drives))
        speeds[:, drive] = 5.0
        alone = dynamics(scene).joint_rates(state, speeds, np.zeros((COUNT, drives))).v
        np.testing.assert_allclose(alone, 5.0 * velocity_ratios[..., drive], rtol=1e-13)
    total = sum((2.0 + drive) * velocity_ratios[..., drive] for drive in range(drives))
    np.testing.assert_allclose(v, total, rtol=1e-12, atol=1e-12)


def test_accelerations_from_rest_have_the_ratios_of_velocities(scene: cd.Scene) -> None:
    state, shape = closed(scene), (COUNT, len(scene.drives))
    rates = dynamics(scene).joint_rates(state, np.zeros(shape), np.full(shape, 3.0))
    assert not np.any(rates.v)
    np.testing.assert_allclose(rates.a, 3.0 * rates.velocity_ratios.sum(axis=2), rtol=1e-13)
    resting = dynamics(scene).joint_rates(state, np.zeros(shape), np.zeros(shape))
    assert not np.any(resting.v)
    assert not np.any(resting.a)
    np.testing.assert_array_equal(resting.velocity_ratios, rates.velocity_ratios)


def test_rates_are_derivatives(shaft: cd.Mechanism) -> None:
    """Speeds and accelerations against differences of the positions themselves."""
    scene = double(shaft, 0.6, 0.4)
    for centre in (0.3, 1.2, 2.9):
        turn = scene.sweep(centre + OFFSETS, speed=1.0)
        for name in ("pin_1_in", "pin_1_out", "slip", "pin_2_in", "pin_2_out", "bearing_out"):
            values = turn.motion.position(name)
            assert FIRST @ values == pytest.approx(turn.motion.velocity(name)[3], abs=1e-11)
            assert SECOND @ values == pytest.approx(turn.motion.acceleration(name)[3], abs=1e-8)


@pytest.mark.parametrize("rates", [(0.0, 0.0), (SPEED, ACCELERATION)], ids=["at rest", "moving"])
def test_efforts_of_drives_alone_are_those_with_all_wrenches(rates: tuple[float, float]) -> None:
    """By virtual work, without closure forces; those of held joints are not known then."""
    for name in ("universal", "four-bar", "spatial"):
        whole = solution(SCENES[name](), *rates)
        scene = SCENES[name](outputs=[])
        alone = solution(scene, *rates)
        drives = len(scene.problem.independent)
        np.testing.assert_allclose(alone.efforts[:, :drives], whole.efforts[:, :drives], rtol=1e-9)
        assert not np.any(alone.efforts[:, drives:])


def test_efforts_are_zero_but_at_drives_and_held_joints(scene: cd.Scene) -> None:
    state = closed(scene)
    given = inputs(scene, state, SPEED, ACCELERATION)
    found, _, _ = scene.solver.taped.found(state.x, given, lambda samples: state)
    prescribed = scene.problem.prescribed_columns
    assert not np.any(np.delete(found.efforts, prescribed, axis=1))
    assert np.all(np.any(found.efforts[:, prescribed], axis=0))


def test_moments_of_couplings() -> None:
    mechanism = cd.load(gears(coupling("g", "a", "b", -3.0)))
    scene = cd.Scene(mechanism, drive="a", loads={"b": -5.0})
    item = solution(scene, 0.0, 0.0)
    np.testing.assert_allclose(item.coupling_moments, np.full((COUNT, 1), 5.0), rtol=1e-14)
    assert item.coupling_moments.shape == (COUNT, 1)
    assert solution(four_bar()).coupling_moments.shape == (COUNT, 0)


def test_mass_and_flags(scene: cd.Scene) -> None:
    assert dynamics(scene).has_mass
    massless = cd.Scene(cd.load(SLIDER), drive="guide")
    assert not dynamics(massless).has_mass
    item = solution(scene)
    assert item.unique.shape == item.influence.shape
    np.testing.assert_array_equal(item.unique, item.influence < 1e-9)


SLIDER = """<robot name="lift"><link name="base"/><link name="rack"/><link name="wheel"/>
  <joint name="guide" type="prismatic"><parent link="base"/><child link="rack"/>
    <axis xyz="1 0 0"/></joint>
  <joint name="axle" type="continuous"><parent link="base"/><child link="wheel"/>
    <origin xyz="0 3 1"/><axis xyz="0 0 1"/></joint>
  <coupling name="mesh"><predecessor link="rack"/><successor link="wheel"/>
    <ratio value="50"/></coupling></robot>"""


def test_condition_counts_slides_in_lengths() -> None:
    """A wheel that turns by 50 rad per metre turns by 50 times the length per length."""
    scene = cd.Scene(cd.load(SLIDER), drive="guide")
    item = dynamics(scene)
    state = closed(scene)._replace(condition=np.full(COUNT, 2.0))
    ratios = np.zeros((COUNT, 2, 1))
    columns = scene.mechanism.coordinates.velocity_columns
    ratios[:, columns["guide"], 0] = 1.0
    ratios[:, columns["axle"], 0] = -50.0
    length = scene.mechanism.characteristic_length
    assert abs(length - 1.0) > 0.1
    expected = 2.0 * max(1.0, 50.0 * length)
    np.testing.assert_allclose(item.condition(state, ratios), expected, rtol=1e-14)
    # It is at least that of the equations.
    np.testing.assert_array_equal(item.condition(state, 0.0 * ratios), state.condition)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("x", "positions of the joints"),
        ("v", "velocities of the joints"),
        ("a", "accelerations of the joints"),
        ("wrenches", "wrenches"),
        ("efforts", "efforts"),
    ],
)
def test_arrays_that_overflow_are_refused(name: str, words: str) -> None:
    scene = four_bar()
    item = solution(scene)
    array = getattr(item, name).copy()
    array[1, 0] = np.inf
    with pytest.raises(cd.AccuracyError, match=f"the {words} cannot be computed, since numbers"):
        item._replace(**{name: array}).prove(positions(scene)[:COUNT])


def test_residuals_above_the_tolerance_are_refused() -> None:
    scene = four_bar()
    item = solution(scene)
    error = np.zeros(COUNT)
    error[2] = 1e-3
    spoiled = item._replace(residuals=item.residuals._replace(rate_error=error))
    with pytest.raises(cd.AccuracyError, match="the rate residual is 1") as caught:
        spoiled.prove(positions(scene)[:COUNT])
    assert caught.value.position == positions(scene)[2, 0]


def test_false_flags_of_a_solution_are_refused() -> None:
    scene = four_bar()
    item = solution(scene)
    dynamics(scene).prove_flags(item)
    with pytest.raises(cd.AccuracyError, match="flagged unique, but changes"):
        dynamics(scene).prove_flags(item._replace(influence=np.zeros_like(item.influence)))
    nothing = four_bar(outputs=[])
    alone = solution(nothing)
    dynamics(nothing).prove_flags(alone._replace(influence=np.ones_like(alone.influence)))


def test_flags_are_proven_once_of_a_motion() -> None:
    scene = four_bar()
    item = solution(scene)
    # Coordinates that are not numbers cannot be decomposed: it shows where they are looked at.
    unknown = item._replace(x=np.full_like(item.x, np.nan))
    with pytest.raises((cd.AccuracyError, np.linalg.LinAlgError)):
        dynamics(scene).prove_flags(unknown)
    dynamics(scene).prove_flags(item)
    # The loop is solved as a whole, whatever is asked of it.
    again = cd.Scene(scene.mechanism, drive="crank_bearing")
    for alike in (again, scene.replace(outputs=["crank_pin"])):
        dynamics(alike).prove_flags(unknown)
    for other in (four_bar(), cd.Scene(scene.mechanism, drive="rocker_bearing")):
        with pytest.raises((cd.AccuracyError, np.linalg.LinAlgError)):
            dynamics(other).prove_flags(solution(other)._replace(x=unknown.x))


@pytest.mark.parametrize("speed", [0.0, 1000.0])
def test_open_flags_are_proven_at_any_speed(speed: float) -> None:
    """At speed the condition of the wrenches grows, but not that of the closure equations."""
    # Its own mechanism: orders of elimination that other scenes chose would count in conditions.
    joint = cd.load("universal_joint")
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.5})
    solver = scene.solver
    assembled = solver.assemble(Targets.of_positions(np.linspace(0.0, 3.0, 9)[:, None]))
    speeds = np.full((9, 1), speed)
    solution = solver.solve(assembled, acting(solver, speeds, np.zeros((9, 1))))
    assert np.max(solution.closure_condition) < 100.0
    unique = np.argwhere(solution.unique)
    influence = solution.influence.copy()
    influence[tuple(unique[0])] = 1.0
    with pytest.raises(cd.AccuracyError, match="flagged open, but does not change"):
        solver.inverse_dynamics.prove_flags(solution._replace(influence=influence))
