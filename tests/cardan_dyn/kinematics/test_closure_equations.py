"""Closure equations: rows, errors and drift of loops and couplings."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from testkit.linkages import LINK, carriage, coupling, gears, rack
from testkit.mixed_chain import MIXED, moved, rows
from testkit.planar_linkages import four_bar, solver

import cardan_dyn as cd
from cardan_dyn.core.kinematics.closing.equations import ClosureEquations
from cardan_dyn.core.kinematics.loops.groups import Group
from cardan_dyn.core.mechanics import closure
from cardan_dyn.core.mechanics.bodies import End, Loop, tree_of
from cardan_dyn.core.mechanics.placements import Placed
from cardan_dyn.core.mechanics.vectors import ZERO

COUNT = 4
STEP = 1e-4
CARRIERS = {"ball": "turn", "cross": "turn", "bolt": None}
"""Per loop of the mixed chain, the joint of the body from which both of its sides hang."""


def equations_of(mechanism: cd.Mechanism) -> ClosureEquations:
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
    return ClosureEquations(mechanism, group)


def rates_of(mechanism: cd.Mechanism) -> np.ndarray:
    return np.random.default_rng(7).uniform(-2.0, 2.0, (COUNT, mechanism.model.nv))


def seen_in(equations: ClosureEquations) -> pinocchio.SE3:
    """Where the tree is in the world."""
    return pinocchio.SE3(equations.tree.axes, equations.origin)


def difference_of_velocities(
    mechanism: cd.Mechanism, x: np.ndarray, v: np.ndarray, frame: pinocchio.SE3
) -> np.ndarray:
    """Pinocchio's `(N, L, 6)` twists of predecessors less those of successors, in a frame."""
    model, data = mechanism.model, mechanism.model.createData()
    result = np.zeros((len(x), len(mechanism.loops), 6))
    for sample, q in enumerate(mechanism.coordinates.configuration(x)):
        pinocchio.forwardKinematics(model, data, q, v[sample])
        seen = [frame.actInv(data.oMi[k].act(data.v[k])) for k in range(model.njoints)]
        for index, item in enumerate(mechanism.loops):
            result[sample, index] += seen[item.predecessor].vector
            if item.successor:
                result[sample, index] -= seen[item.successor].vector
    return result


def errors_after(
    equations: ClosureEquations, mechanism: cd.Mechanism, x: np.ndarray, v: np.ndarray, t: float
) -> np.ndarray:
    return equations.at(moved(mechanism, x, v, 0.0 * v, t), equations.full)[1]


@pytest.fixture(scope="module")
def mixed() -> cd.Mechanism:
    return cd.load(MIXED)


@pytest.mark.parametrize("index", range(3))
def test_rows_are_pinocchios_twists_of_the_ends_in_the_axes_of_the_carrier(
    mixed: cd.Mechanism, index: int
) -> None:
    equations, x, v = equations_of(mixed), rows(mixed, COUNT), rates_of(mixed)
    matrix = equations.at(x, equations.full)[0]
    assert matrix.shape == (COUNT, mixed.model.nv, 18)
    computed = np.einsum("nmr,nm->nr", matrix, v)[:, 6 * index : 6 * index + 6]
    frame, loop = seen_in(equations), mixed.loops[index]
    expected = difference_of_velocities(mixed, x, v, frame)[:, index]
    carrier = CARRIERS[loop.joint]
    if carrier is not None:
        data = mixed.model.createData()
        body = mixed[carrier].id
        neutral = mixed.coordinates.configuration(mixed.coordinates.neutral()[None])[0]
        pinocchio.forwardKinematics(mixed.model, data, neutral)
        point = data.oMi[body].actInv(data.oMi[loop.predecessor]).translation.copy()
        for sample, q in enumerate(mixed.coordinates.configuration(x)):
            pinocchio.forwardKinematics(mixed.model, data, q)
            axes = frame.actInv(data.oMi[body] * pinocchio.SE3(np.eye(3), point))
            expected[sample] = axes.actInv(pinocchio.Motion(expected[sample])).vector
    expected[:, :3] /= mixed.characteristic_length
    np.testing.assert_allclose(computed, expected, atol=1e-12)


@pytest.mark.parametrize(
    "name", ["universal_joint", "stewart_platform", "four_bar", "needle_drive"]
)
def test_rows_are_the_slope_of_the_error_at_closed_positions(name: str) -> None:
    mechanism = cd.load(name)
    equations, zero = equations_of(mechanism), mechanism.coordinates.neutral()[None]
    v = rates_of(mechanism)
    x = np.repeat(zero, COUNT, axis=0)
    matrix, error, worst = equations.at(x, equations.full)
    assert np.max(worst) < 1e-9
    later, earlier = (errors_after(equations, mechanism, x, v, t) for t in (STEP, -STEP))
    expected = (later - earlier) / (2.0 * STEP)
    computed = np.einsum("nmr,nm->nr", matrix, v)
    scale = np.max(np.abs(expected))
    assert scale > 0.1
    np.testing.assert_allclose(computed, expected, atol=1e-6 * scale)
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
    errors = [errors_after(equations, mechanism, state.x, v, t) for t in (-STEP, 0.0, STEP)]
    curvature = (errors[0] - 2.0 * errors[1] + errors[2]) / STEP**2
    computed = equations.drift(state.x, v, equations.full)
    assert np.max(np.abs(computed)) > 0.01
    np.testing.assert_allclose(computed, curvature, atol=1e-5 * np.max(np.abs(computed)))


def test_the_error_is_the_twist_from_successor_to_predecessor() -> None:
    mechanism = cd.load("stewart_platform")
    equations = equations_of(mechanism)
    x = np.repeat(mechanism.coordinates.neutral()[None], COUNT, axis=0)
    x = moved(mechanism, x, rates_of(mechanism), np.zeros((COUNT, mechanism.model.nv)), 1e-3)
    _, computed, worst = equations.at(x, equations.full)
    computed = computed.reshape(COUNT, -1, 6)
    computed[:, :, :3] *= mechanism.characteristic_length
    frame = seen_in(equations)
    model, data = mechanism.model, mechanism.model.createData()
    for sample, q in enumerate(mechanism.coordinates.configuration(x)):
        pinocchio.forwardKinematics(model, data, q)
        deviations = []
        for index, loop in enumerate(mechanism.loops):
            first = frame.actInv(data.oMi[loop.predecessor] * loop.predecessor_placement)
            second = frame.actInv(data.oMi[loop.successor] * loop.successor_placement)
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
    assert equations.at(x, equations.full)[2][0] < 1e-15
    x[0, mechanism.coordinates.columns["a"]] = 0.1
    _, error, worst = equations.at(x, equations.full)
    turn = 2.0 * np.sin(0.05)
    gap = 0.5 * np.array([np.cos(0.1) - 1.0, np.sin(0.1), 0.0])
    middle = np.array([0.5, 0.0, 0.0]) + 0.5 * gap - equations.origin
    length = mechanism.characteristic_length
    expected = (gap - np.cross([0.0, 0.0, turn], middle)) / length
    np.testing.assert_allclose(error[0], [*expected, 0.0, 0.0, turn], atol=1e-15)
    assert worst[0] == pytest.approx(max(turn, np.linalg.norm(gap) / length), rel=1e-12)


def test_a_planar_loop_reaches_the_rows_of_its_plane() -> None:
    mechanism = four_bar()
    equations = equations_of(mechanism)
    x = rows(mechanism, 3)
    reduction = equations.reduction(x, np.arange(mechanism.model.nv))
    np.testing.assert_array_equal(reduction.rows[0], np.eye(6)[:, [0, 1, 5]])
    assert equations.at(x, reduction)[0].shape == (3, mechanism.model.nv, 3)


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
    reduction = equations.reduction(x, np.arange(mechanism.model.nv))
    assert reduction.rows[0].shape == (6, 3)
    np.testing.assert_array_equal(reduction.rows[0], np.eye(6)[:, [0, 1, 5]])
    # The mount is on no loop: its motion has no component along any row.
    column = mechanism.coordinates.velocity_columns["m"].start
    assert not np.any(equations.at(x, reduction)[0][:, column])


@pytest.mark.parametrize("length", [1e-12, 1.0, 1e12])
def test_reachable_rows_do_not_depend_on_the_unit_of_length(length: float) -> None:
    """A slide and a hinge on it: of both, only the slide counts in lengths."""
    mechanism = cd.load(carriage(length))
    equations, zero = equations_of(mechanism), mechanism.coordinates.neutral()[None]
    reduction = equations.reduction(zero, np.arange(mechanism.model.nv))
    np.testing.assert_array_equal(reduction.rows[0], np.eye(6)[:, [0, 4]])
    np.testing.assert_allclose(
        equations.at(zero, reduction)[0][0, 0] * mechanism.characteristic_length, [1.0, 0.0]
    )


def test_a_coupling_adds_the_row_of_its_ratio() -> None:
    train = coupling("ab", "a", "b", -2.0), coupling("bc", "b", "c", 0.25)
    mechanism = cd.load(gears(*train, third=True))
    equations, x = equations_of(mechanism), rows(mechanism, 2)
    assert equations.full.rows == ()
    computed, slips, worst = equations.at(x, equations.full)
    columns, velocities = mechanism.coordinates.columns, mechanism.coordinates.velocity_columns
    a, b, c = (velocities[name].start for name in "abc")
    expected = np.zeros((3, 2))
    expected[[a, b], 0] = [-2.0, -1.0]
    expected[[b, c], 1] = [0.25, -1.0]
    np.testing.assert_array_equal(computed, [expected, expected])
    np.testing.assert_array_equal(equations.slip_units, [1.0, 1.0])
    a, b, c = (x[:, columns[name].start] for name in "abc")
    np.testing.assert_allclose(slips.T, [-2.0 * a - b, 0.25 * b - c], rtol=1e-15)
    np.testing.assert_array_equal(worst, np.max(np.abs(slips), axis=1))
    turns = np.zeros_like(x)
    turns[:, columns["b"]] = 1.0
    turned = equations.at(x, equations.full, turns)[1]
    np.testing.assert_allclose(turned - slips, [2.0 * np.pi * np.array([-1.0, 0.25])] * 2)


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
    equations = ClosureEquations(mixed, group)
    matrix, error, worst = equations.at(rows(mixed, 2), equations.full)
    assert matrix.shape == (2, mixed.model.nv, 0)
    assert error.shape == (2, 0)
    assert worst.tolist() == [0.0, 0.0]


AXES = np.array([[1, 0, 0], [0, -1, 0], [0, 0, 1], [0.6, 0, -0.8], [0.36, 0.48, 0.8]], dtype=float)
ANGLES = [0.0, 1e-9, 1e-3, 0.7, 2.0, 3.1, np.pi - 1e-5, np.pi - 1e-8, np.pi]


def turns_between(first: list[np.ndarray], second: list[np.ndarray]) -> np.ndarray:
    """Rotations `(N, 3)` between the ends of a loop on the world, turned like this."""
    ends = [End(-1, np.array(rotations).transpose(2, 1, 0), ZERO) for rotations in (first, second)]
    tree = tree_of(four_bar())._replace(bodies=(), loops=(Loop(*ends, -1),))
    (turn,) = closure.turns(tree, Placed([], [], {}, {}))
    return np.array(turn).T


@pytest.mark.parametrize("angle", ANGLES)
def test_rotations_are_axes_times_twice_the_sine_of_half_the_angle(angle: float) -> None:
    rng = np.random.default_rng(5)
    second = [pinocchio.exp3(rng.normal(size=3)) for _ in AXES]
    first = [pinocchio.exp3(angle * axis) @ frame for axis, frame in zip(AXES, second, strict=True)]
    found = turns_between(first, second)
    expected = 2.0 * np.sin(0.5 * angle) * AXES
    if np.pi - angle < 1e-7:
        # Either direction of the axis of a half turn is right.
        signs = np.sign(np.sum(found * expected, axis=1, keepdims=True))
        expected = signs * expected
    # Towards a half turn the trace plus one, 4 cos² of half the angle, is as small as 1e-10 and
    # keeps an error of about ten roundings: 1e-5 of its root.
    np.testing.assert_allclose(found, expected, atol=1e-14 if angle < 3.0 else 1e-5)


@pytest.mark.parametrize("fixed", ["first", "second"])
def test_one_end_may_be_fixed_and_only_some_samples_half_turns(fixed: str) -> None:
    turns = [pinocchio.exp3(np.array([0.0, 0.0, angle])) for angle in (0.2, np.pi, -1.0)]
    still = [np.eye(3)] * 3
    found = turns_between(*((still, turns) if fixed == "first" else (turns, still))).T
    sign = -1.0 if fixed == "first" else 1.0
    np.testing.assert_allclose(found[:2], 0.0, atol=1e-15)
    expected = 2.0 * np.sin([0.1, 0.5 * np.pi, -0.5])
    np.testing.assert_allclose(found[2, [0, 2]], sign * expected[[0, 2]], rtol=1e-14)
    assert abs(found[2, 1]) == pytest.approx(2.0)
