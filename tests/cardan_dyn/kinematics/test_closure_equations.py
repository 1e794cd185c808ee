"""Closure equations: rows, errors, drift and wrenches of loops and couplings."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from testkit.linkages import LINK, carriage, coupling, gears, rack
from testkit.mixed_chain import MIXED, moved, rows
from testkit.planar_linkages import four_bar, solver

import cardan_dyn as cd
from cardan_dyn.kinematics.closing.batch_model import BatchModel, placed_by
from cardan_dyn.kinematics.closing.equations import ClosureEquations
from cardan_dyn.kinematics.loops.groups import Group

ORIGIN = np.array([0.3, -0.7, 1.1])
COUNT = 4
STEP = 1e-4
CARRIERS = {"ball": "turn", "cross": "turn", "bolt": None}
"""Per loop of the mixed chain, the joint of the body from which both of its sides hang."""


def equations_of(mechanism: cd.Mechanism, origin: np.ndarray = ORIGIN) -> ClosureEquations:
    """All loops and couplings of a mechanism, every joint of which may move."""
    bodies = list(range(mechanism.model.njoints - 1))
    group = Group(
        loops=tuple(range(len(mechanism.loops))),
        couplings=tuple(range(len(mechanism.couplings))),
        passives=np.arange(mechanism.model.nv),
        known=np.zeros(0, dtype=int),
        bodies=bodies,
        base=-1,
        inertial_bodies=set(bodies),
    )
    batch = BatchModel(mechanism, bodies, set(bodies), origin)
    return ClosureEquations(mechanism, batch, group)


def geometry(equations: ClosureEquations, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Actions and unit twists at rows of coordinates."""
    actions = equations.batch.actions(x)
    return actions, equations.unit_twists.of(actions)


def rates_of(mechanism: cd.Mechanism) -> np.ndarray:
    return np.random.default_rng(7).uniform(-2.0, 2.0, (COUNT, mechanism.model.nv))


def seen_from(frame: pinocchio.SE3) -> pinocchio.SE3:
    return pinocchio.SE3(frame.rotation, frame.translation - ORIGIN)


def difference_of_spatial_motions(
    mechanism: cd.Mechanism, x: np.ndarray, v: np.ndarray, kind: str
) -> np.ndarray:
    """Pinocchio's `(N, L, 6)` motions of predecessors less those of successors, about ORIGIN."""
    model, data = mechanism.model, mechanism.model.createData()
    result = np.zeros((len(x), len(mechanism.loops), 6))
    for sample, q in enumerate(mechanism.coordinates.configuration(x)):
        pinocchio.forwardKinematics(model, data, q, v[sample], np.zeros(model.nv))
        motions = getattr(data, kind)
        world = [seen_from(data.oMi[body]).act(motions[body]) for body in range(model.njoints)]
        for index, item in enumerate(mechanism.loops):
            result[sample, index] += world[item.predecessor].vector
            if item.successor:
                result[sample, index] -= world[item.successor].vector
    return result


@pytest.fixture(scope="module")
def mixed() -> cd.Mechanism:
    return cd.load(MIXED)


@pytest.mark.parametrize("index", range(3))
def test_rows_are_pinocchios_twists_of_the_ends_in_the_axes_of_the_carrier(
    mixed: cd.Mechanism, index: int
) -> None:
    equations, x, v = equations_of(mixed), rows(mixed, COUNT), rates_of(mixed)
    actions, twists = geometry(equations, x)
    matrix = equations.rows(twists, actions, equations.full())
    assert matrix.shape == (COUNT, mixed.model.nv, 18)
    computed = np.einsum("nmr,nm->nr", matrix, v)[:, 6 * index : 6 * index + 6]
    expected = difference_of_spatial_motions(mixed, x, v, "v")[:, index]
    loop = mixed.loops[index]
    carrier = CARRIERS[loop.joint]
    if carrier is not None:
        data = mixed.model.createData()
        body = mixed[carrier].id
        neutral = mixed.coordinates.configuration(mixed.coordinates.neutral()[None])[0]
        pinocchio.forwardKinematics(mixed.model, data, neutral)
        point = data.oMi[body].actInv(data.oMi[loop.predecessor]).translation.copy()
        for sample, q in enumerate(mixed.coordinates.configuration(x)):
            pinocchio.forwardKinematics(mixed.model, data, q)
            axes = seen_from(data.oMi[body]) * pinocchio.SE3(np.eye(3), point)
            expected[sample] = axes.actInv(pinocchio.Motion(expected[sample])).vector
    expected[:, :3] /= mixed.characteristic_length
    np.testing.assert_allclose(computed, expected, atol=1e-12)


def test_drift_is_pinocchios_acceleration_relative_to_the_carrier(mixed: cd.Mechanism) -> None:
    """A carrier turns the difference of the twists as well; it is zero in closed loops only."""
    equations, x, v = equations_of(mixed), rows(mixed, COUNT), rates_of(mixed)
    _, twists = geometry(equations, x)
    expected = difference_of_spatial_motions(mixed, x, v, "a")
    differences = difference_of_spatial_motions(mixed, x, v, "v")
    data = mixed.model.createData()
    for sample, q in enumerate(mixed.coordinates.configuration(x)):
        pinocchio.forwardKinematics(mixed.model, data, q, v[sample])
        for index, loop in enumerate(mixed.loops):
            carrier = CARRIERS[loop.joint]
            if carrier is not None:
                body = mixed[carrier].id
                twist = seen_from(data.oMi[body]).act(data.v[body])
                turning = twist.cross(pinocchio.Motion(differences[sample, index]))
                expected[sample, index] -= turning.vector
    np.testing.assert_allclose(equations.drift(twists, v), expected, atol=1e-11)
    assert np.min(np.max(np.abs(expected), axis=2)) > 0.01


@pytest.mark.parametrize(
    "name", ["universal_joint", "stewart_platform", "four_bar", "needle_drive"]
)
def test_rows_are_the_slope_of_the_error_at_closed_positions(name: str) -> None:
    mechanism = cd.load(name)
    equations, zero = equations_of(mechanism), mechanism.coordinates.neutral()[None]
    v = rates_of(mechanism)
    x = np.repeat(zero, COUNT, axis=0)
    actions, twists = geometry(equations, x)
    error, worst = equations.error(placed_by(actions))
    assert np.max(worst) < 1e-9
    later, earlier = (
        equations.error(placed_by(geometry(equations, moved(mechanism, x, v, 0.0 * v, t))[0]))[0]
        for t in (STEP, -STEP)
    )
    slope = (later - earlier) / (2.0 * STEP)
    full = equations.full()
    computed = np.einsum("nmr,nm->nr", equations.rows(twists, actions, full), v)
    count = 6 * len(mechanism.loops)
    expected = equations.project(slope, None, actions, full)[:, :count]
    scale = np.max(np.abs(expected))
    assert scale > 0.1
    np.testing.assert_allclose(computed[:, :count], expected, atol=1e-6 * scale)
    np.testing.assert_allclose(error, 0.0, atol=1e-9)


@pytest.mark.parametrize("name", ["four_bar", "stewart_platform"])
@pytest.mark.parametrize("position", [-0.1, 0.0, 0.2])
def test_drift_is_the_curvature_of_the_error_along_a_closed_motion(
    name: str, position: float
) -> None:
    mechanism = cd.load(name)
    drives = [f"leg_{leg}" for leg in range(1, 7)] if "platform" in name else ["crank_bearing"]
    kinematics, x = solver(mechanism, *drives)
    x[mechanism.coordinates.columns[drives[0]]] += position * mechanism.characteristic_length
    state = kinematics.close(x[None, :], most=60)
    assert state.residual[0] < 1e-12
    v = kinematics.rates(state, np.linspace(3.0, 0.3, len(drives))[None])
    equations = equations_of(mechanism)
    errors = [
        equations.error(
            placed_by(geometry(equations, moved(mechanism, state.x, v, 0.0 * v, t))[0])
        )[0]
        for t in (-STEP, 0.0, STEP)
    ]
    curvature = (errors[0] - 2.0 * errors[1] + errors[2]) / STEP**2
    _, twists = geometry(equations, state.x)
    computed = equations.drift(twists, v)
    assert np.max(np.abs(computed)) > 0.01 * mechanism.characteristic_length
    np.testing.assert_allclose(computed, curvature, atol=1e-5 * np.max(np.abs(computed)))


def test_the_error_is_the_twist_from_successor_to_predecessor() -> None:
    mechanism = cd.load("stewart_platform")
    equations = equations_of(mechanism)
    x = np.repeat(mechanism.coordinates.neutral()[None], COUNT, axis=0)
    x = moved(mechanism, x, rates_of(mechanism), np.zeros((COUNT, mechanism.model.nv)), 1e-3)
    computed, worst = equations.error(placed_by(geometry(equations, x)[0]))
    model, data = mechanism.model, mechanism.model.createData()
    for sample, q in enumerate(mechanism.coordinates.configuration(x)):
        pinocchio.forwardKinematics(model, data, q)
        deviations = []
        for index, loop in enumerate(mechanism.loops):
            first = seen_from(data.oMi[loop.predecessor]) * loop.predecessor_placement
            second = seen_from(data.oMi[loop.successor]) * loop.successor_placement
            expected = pinocchio.log6(first * second.inverse()).vector
            # Both agree to second order in the error, of some 1e-3.
            np.testing.assert_allclose(computed[sample, index], expected, atol=1e-7)
            gap = first.translation - second.translation
            deviations.append(np.linalg.norm(gap) / mechanism.characteristic_length)
            angle = np.linalg.norm(pinocchio.log3(first.rotation @ second.rotation.T))
            deviations.append(2.0 * np.sin(0.5 * angle))
        assert worst[sample] == pytest.approx(max(deviations), rel=1e-9)
    assert np.min(worst) > 1e-3


def test_a_loop_to_the_world_is_closed_about_any_origin() -> None:
    """An arm whose tip is held in the world."""
    mechanism = cd.load(
        '<robot name="arm"><link name="ground"/>'
        + LINK.format(name="arm", com="0 0 0", mass="1")
        + '<joint name="a" type="continuous"><parent link="ground"/><child link="arm"/>'
        '<axis xyz="0 0 1"/></joint><loop name="c" type="spherical"><predecessor link="arm">'
        '<origin xyz="0.5 0 0"/></predecessor><successor link="ground"><origin xyz="0.5 0 0"/>'
        "</successor></loop></robot>"
    )
    equations = equations_of(mechanism)
    x = mechanism.coordinates.neutral()[None]
    assert equations.error(placed_by(geometry(equations, x)[0]))[1][0] < 1e-15
    x[0, mechanism.coordinates.columns["a"]] = 0.1
    error, worst = equations.error(placed_by(geometry(equations, x)[0]))
    turn = 2.0 * np.sin(0.05)
    gap = 0.5 * np.array([np.cos(0.1) - 1.0, np.sin(0.1), 0.0])
    middle = np.array([0.5, 0.0, 0.0]) + 0.5 * gap - ORIGIN
    expected = gap - np.cross([0.0, 0.0, turn], middle)
    np.testing.assert_allclose(error[0, 0], [*expected, 0.0, 0.0, turn], atol=1e-15)
    length = mechanism.characteristic_length
    assert worst[0] == pytest.approx(max(turn, np.linalg.norm(gap) / length), rel=1e-12)


def test_a_planar_loop_reaches_the_rows_of_its_plane() -> None:
    mechanism = four_bar()
    equations = equations_of(mechanism)
    actions, twists = geometry(equations, rows(mechanism, 3))
    reduction = equations.reduction(twists, actions)
    np.testing.assert_array_equal(reduction.rows[0], np.eye(6)[:, [0, 1, 5]])
    np.testing.assert_array_equal(reduction.null[0], np.eye(6)[:, [2, 3, 4]])
    assert equations.rows(twists, actions, reduction).shape == (3, mechanism.model.nv, 3)


def test_a_planar_loop_on_a_turning_body_stays_planar_in_the_axes_of_that_body() -> None:
    """The mount turns about an axis that is not normal to the plane of the linkage."""
    names = ("mount", "crank", "coupler", "rocker")
    text = '<robot name="carried"><link name="ground"/>' + "".join(
        LINK.format(name=name, com="0.1 0 0", mass="1") for name in names
    )
    text += (
        '<joint name="m" type="continuous"><parent link="ground"/><child link="mount"/>'
        '<origin xyz="1 2 3" rpy="0.3 0.2 0.1"/><axis xyz="0.6 0 0.8"/></joint>'
    )
    for name, parent, child, at in (
        ("a", "mount", "crank", "0 0 0"),
        ("b", "crank", "coupler", "0 0.5 0"),
        ("d", "mount", "rocker", "2 0 0"),
    ):
        text += (
            f'<joint name="{name}" type="continuous"><parent link="{parent}"/>'
            f'<child link="{child}"/><origin xyz="{at}"/><axis xyz="0 0 1"/></joint>'
        )
    text += (
        '<loop name="c" type="continuous"><predecessor link="coupler"><origin xyz="2 2 0"/>'
        '</predecessor><successor link="rocker"><origin xyz="0 2.5 0"/></successor>'
        '<axis xyz="0 0 1"/></loop></robot>'
    )
    mechanism = cd.load(text)
    equations = equations_of(mechanism)
    x = rows(mechanism, 5)
    actions, twists = geometry(equations, x)
    reduction = equations.reduction(twists, actions)
    assert reduction.rows[0].shape == (6, 3)
    np.testing.assert_array_equal(reduction.rows[0], np.eye(6)[:, [0, 1, 5]])
    # The mount is on no loop: its motion has no component along any row.
    column = mechanism.coordinates.velocity_columns["m"].start
    assert not np.any(equations.rows(twists, actions, reduction)[:, column])


@pytest.mark.parametrize("length", [1e-12, 1.0, 1e12])
def test_reachable_rows_do_not_depend_on_the_unit_of_length(length: float) -> None:
    """A slide and a hinge on it: of both, only the slide counts in lengths."""
    mechanism = cd.load(carriage(length))
    equations = equations_of(mechanism, np.zeros(3))
    actions, twists = geometry(equations, mechanism.coordinates.neutral()[None])
    rows_of_loop = equations.reduction(twists, actions).rows[0]
    np.testing.assert_array_equal(rows_of_loop, np.eye(6)[:, [0, 4]])
    assert equations.weights.tolist() == [1.0 / mechanism.characteristic_length] * 3 + [1.0] * 3


def test_wrenches_do_the_power_of_their_multipliers(mixed: cd.Mechanism) -> None:
    equations, x = equations_of(mixed), rows(mixed, COUNT)
    actions, _ = geometry(equations, x)
    generator = np.random.default_rng(11)
    loop_twists = generator.uniform(-1.0, 1.0, (COUNT, len(mixed.loops), 6))
    components = equations.project(loop_twists, None, actions, equations.full())
    for index in range(len(mixed.loops)):
        for shape in ((6, 2), (COUNT, 6, 2)):
            combinations = generator.uniform(-1.0, 1.0, shape)
            wrenches = equations.wrench(equations.full().axes[index], actions, combinations)
            assert wrenches.shape == (COUNT, 6, 2)
            power = np.einsum("nik,ni->nk", wrenches, loop_twists[:, index])
            along = components[:, 6 * index : 6 * index + 6]
            expected = np.einsum(
                "...ik,ni->nk" if len(shape) == 2 else "nik,ni->nk", combinations, along
            )
            np.testing.assert_allclose(power, expected, atol=1e-12)


def test_bodies_between_the_ends_have_the_sign_of_their_side(mixed: cd.Mechanism) -> None:
    equations = equations_of(mixed)
    expected = {
        "ball": {"slide": 1.0, "swing": 1.0, "ball": 1.0, "hinge": -1.0},
        "cross": {"hinge": 1.0, "cross": 1.0, "slide": -1.0},
        "bolt": {"turn": 1.0, "slide": 1.0, "swing": 1.0},
    }
    velocities = mixed.coordinates.velocity_columns
    for index, loop in enumerate(mixed.loops):
        column_signs = np.zeros(mixed.model.nv)
        for name, sign in expected[loop.joint].items():
            column_signs[velocities[name]] = sign
        np.testing.assert_array_equal(equations.column_signs[index], column_signs)


def test_a_coupling_adds_the_row_of_its_ratio() -> None:
    train = coupling("ab", "a", "b", -2.0), coupling("bc", "b", "c", 0.25)
    mechanism = cd.load(gears(*train, third=True))
    equations = equations_of(mechanism)
    actions, twists = geometry(equations, rows(mechanism, 2))
    reduction = equations.full()
    assert reduction.rows == ()
    computed = equations.rows(twists, actions, reduction)
    a, b, c = (mechanism.coordinates.velocity_columns[name].start for name in "abc")
    expected = np.zeros((3, 2))
    expected[[a, b], 0] = [-2.0, -1.0]
    expected[[b, c], 1] = [0.25, -1.0]
    np.testing.assert_array_equal(computed, [expected, expected])
    np.testing.assert_array_equal(equations.slip_units, [1.0, 1.0])
    assert equations.coupled_columns.tolist() == [0, 1, 2]
    np.testing.assert_array_equal(equations.coupled_ratios, expected)
    no_loops = np.zeros((2, 0, 6))
    slips = np.array([[1.0, 2.0], [3.0, 4.0]])
    np.testing.assert_array_equal(equations.project(no_loops, slips, actions, reduction), slips)
    np.testing.assert_array_equal(
        equations.project(no_loops, None, actions, reduction), np.zeros((2, 2))
    )
    _, worst = equations.error(placed_by(actions))
    assert not np.any(worst)


@pytest.mark.parametrize(
    ("first", "second", "power_of_length", "factor"),
    [
        ("wheel", "rack", 1, 1.0),
        ("rack", "wheel", 0, 1.0),
        ("wheel", "ground", 0, 0.3),
        ("rack", "ground", 1, 0.3),
    ],
)
def test_slips_are_compared_with_a_radian_or_the_length(
    first: str, second: str, power_of_length: int, factor: float
) -> None:
    mechanism = cd.load(rack(first, second))
    length = mechanism.characteristic_length
    assert length != 1.0
    expected = factor * length**power_of_length
    np.testing.assert_allclose(equations_of(mechanism).slip_units, [expected], rtol=1e-15)


def test_a_group_without_loops_and_couplings_has_no_rows(mixed: cd.Mechanism) -> None:
    bodies = list(range(mixed.model.njoints - 1))
    none = np.zeros(0, dtype=int)
    group = Group((), (), none, none, bodies, -1, set(bodies))
    equations = ClosureEquations(mixed, BatchModel(mixed, bodies, set(), ORIGIN), group)
    actions, twists = geometry(equations, rows(mixed, 2))
    assert equations.rows(twists, actions, equations.full()).shape == (2, 0, 0)
    error, worst = equations.error(placed_by(actions))
    assert error.shape == (2, 0, 6)
    assert worst.tolist() == [0.0, 0.0]
    assert equations.project(error, None, actions, equations.full()).shape == (2, 0)
