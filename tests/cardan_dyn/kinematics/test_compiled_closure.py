"""Compiled closure equations, Newton steps and rates against what NumPy finds."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext, suppress
from pathlib import Path

import numpy as np
import pytest
from scenes import draw
from testkit.ball_rods import WAYS, hinge
from testkit.calls import calls
from testkit.compiled_functions import needs_kernel, without_kernel
from testkit.linkages import carriage, coupling, gears, rack
from testkit.mimicking import finger, mimic
from testkit.mixed_chain import MIXED
from testkit.planar_linkages import four_bar, geared
from testkit.planar_linkages import solver as solver_of_linkage
from testkit.rows_of_loops import parallelograms, spatial, tower
from testkit.tongs import two_chains
from testkit.urdf_reader import URDF

import cardan_dyn as cd
from benchmarks.robots import delta
from cardan_dyn import compiled
from cardan_dyn.elements import stepping
from cardan_dyn.kinematics.closing.all_groups import Kinematics
from cardan_dyn.kinematics.closing.equations import LoopAxes, Reduction
from cardan_dyn.kinematics.closing.group_solver import GroupSolver, GroupState
from cardan_dyn.kinematics.closing.stacked import refined
from cardan_dyn.kinematics.loops.groups import Group

pytestmark = needs_kernel

COUNT = 5
LEGS = [f"leg_{k}" for k in range(1, 7)]
BUNDLED = sorted(path.stem for path in Path(URDF).glob("*.urdf"))


def carried_rod() -> str:
    """An idle rod that hangs from the world, while what its balls are on turns as a whole."""
    world = '<link name="world"/>' + hinge("turn", "world", "ground", "0.1 0 0", "0.6 0 0.8")
    text = WAYS["floating"]().replace('<parent link="ground"/><child link="rod"/>', RODS_JOINT)
    return text.replace('<robot name="floating">', f'<robot name="carried">{world}')


RODS_JOINT = '<parent link="world"/><child link="rod"/>'
OTHERS = {
    "carried rod": lambda: cd.load(carried_rod()),
    "finger": lambda: cd.load(finger(mimic("knuckle", 0.5, 0.3), mimic("middle", -0.2, 0.1))),
    "mixed": lambda: cd.load(MIXED),
    "delta": lambda: cd.load(delta(balls=True)),
    "hinged delta": lambda: cd.load(delta(balls=False)),
    "gears": lambda: cd.load(gears(coupling("g", "a", "b", -0.7))),
    "rack": lambda: cd.load(rack("wheel", "rack")),
    "carriage": lambda: cd.load(carriage(0.3)),
    "geared": lambda: geared(-2.5),
    "parallelograms": lambda: parallelograms(3),
    "spatial": lambda: spatial(3),
    "tower": lambda: tower(3),
    "tongs": lambda: two_chains(3),
} | {way: (lambda text=text: cd.load(text())) for way, text in WAYS.items()}


def mechanism_of(name: str) -> cd.Mechanism:
    return OTHERS[name]() if name in OTHERS else cd.load(name)


def whole(mechanism: cd.Mechanism, known: int = 2) -> GroupSolver:
    """All loops and couplings at once; all joints may move, some turns or slides are known."""
    bodies = list(range(mechanism.model.njoints - 1))
    scalars = np.sort(mechanism.coordinates.scalars.velocities)[:known]
    group = Group(
        loops=tuple(range(len(mechanism.loops))),
        couplings=tuple(range(len(mechanism.couplings))),
        passives=np.setdiff1d(np.arange(mechanism.model.nv), scalars),
        known=scalars,
        bodies=bodies,
        base=-1,
        inertial_bodies=set(bodies),
    )
    return GroupSolver(mechanism, group)


def anywhere(mechanism: cd.Mechanism, count: int, far: float = 1.0) -> np.ndarray:
    """Coordinates whose loops are open."""
    rng = np.random.default_rng(5)
    x = mechanism.zero + far * rng.uniform(-1.0, 1.0, (count, mechanism.coordinates.size))
    return mechanism.coordinates.normalised(x)


def oblique(solver: GroupSolver) -> Reduction:
    """Combinations of rows without a pattern, in axes of bodies anywhere; none of some loops."""
    rng = np.random.default_rng(2)
    rows, null, axes = [], [], []
    for index in range(len(solver.equations.loops)):
        basis, count = np.linalg.qr(rng.normal(size=(6, 6)))[0], (5, 3, 0, 6)[index % 4]
        rows.append(basis[:, :count])
        null.append(basis[:, count:])
        body = int(rng.integers(-1, len(solver.batch)))
        axes.append(LoopAxes(body, rng.normal(size=3)))
    return Reduction(tuple(rows), tuple(null), tuple(axes))


def near(found: np.ndarray, expected: np.ndarray, digits: float = 1e-13) -> None:
    assert found.shape == expected.shape
    assert found.dtype == expected.dtype
    scale = float(np.max(np.abs(expected[np.isfinite(expected)]), initial=1e-300))
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=digits * scale)


def compare(
    solver: GroupSolver, reduction: Reduction, x: np.ndarray, turns: np.ndarray | None = None
) -> tuple[GroupState, GroupState]:
    """Compare all that is found at some coordinates; return it as compiled, and by NumPy."""
    found, error = solver.evaluate(x, reduction, turns)
    with_state(found)
    with without_kernel():
        expected, its_error = solver.evaluate(x, reduction, turns)
    for name in ("actions", "twists", "rows"):
        near(getattr(found, name), getattr(expected, name))
    # Of closed loops it is rounding; near half a turn rounding shows.
    np.testing.assert_allclose(found.residual, expected.residual, rtol=1e-11, atol=1e-14)
    np.testing.assert_allclose(
        error, its_error, rtol=1e-11, atol=1e-12 * max(1.0, np.abs(its_error).max(initial=0.0))
    )
    assert found.null.shape == expected.null.shape
    condition = expected.condition[np.isfinite(expected.condition)]
    worst = 1e-15 * max(1.0, float(np.max(condition, initial=1.0)))
    if worst < 1e-6:
        near(found.inverse, expected.inverse, max(100.0 * worst, 1e-13))
        near(found.condition, expected.condition, max(100.0 * worst, 1e-13))
    return found, expected


def with_state(state: GroupState) -> None:
    """Every array of a state may be written into, as samples are put back."""
    for values in state[2:]:
        assert values.flags.writeable
        assert len(values) == len(state.x)


def compare_motion(state: GroupState) -> None:
    """Compare steps, rates and accelerations from the same state."""
    solver, rng = state.solver, np.random.default_rng(11)
    mechanism = solver.coordinates
    count, nv = len(state.x), mechanism.model.nv
    for size in (1e-12, 1e-3, 0.03, 1.0, 1e3):
        step = size * rng.normal(size=(count, len(solver.group.passives)))
        error = -np.einsum("npr,np->nr", state.passive_rows, step)
        for longest in (0.5, np.inf):
            found = solver._steps(state, error, longest)
            with without_kernel():
                expected = solver._steps(state, error, longest)
                left = solver._bend(state, expected, longest)
            near(found.sizes, expected.sizes)
            near(found.step, expected.step, 1e-12)
            near(found.left, left, 1e-9)
        x, other = state.x.copy(), state.x.copy()
        solver._move(x, expected.step)
        with without_kernel():
            solver._move(other, expected.step)
        # The sine of a large angle is as rounded as that is.
        near(x, other, 1e-13 * max(1.0, 10.0 * size))
    v, a = rng.normal(size=(2, count, nv))
    rates = rng.normal(size=(count, nv, 3))
    # A state of one sample may serve several.
    for item in (state, state.of(np.array([0]))):
        found_rates, found = rates.copy(), a.copy()
        item.set_rates(found_rates)
        item.set_accelerations(v, found)
        with without_kernel():
            its_rates, expected = rates.copy(), a.copy()
            item.set_rates(its_rates)
            item.set_accelerations(v, expected)
        near(found_rates, its_rates, 1e-11)
        near(found, expected, 1e-11)
        np.testing.assert_array_equal(
            np.delete(found, solver.group.passives, 1), np.delete(a, solver.group.passives, 1)
        )
    efforts = rng.normal(size=(count, len(solver.group.passives), 4))
    right = rng.normal(size=(count, state.rows.shape[2], 2))
    found = state.solve_transposed(efforts), state.solve(right)
    with without_kernel():
        expected = state.solve_transposed(efforts), state.solve(right)
    for own, other in zip(found, expected, strict=True):
        near(own, other, 1e-11)


@pytest.mark.parametrize("name", [*BUNDLED, *OTHERS])
@pytest.mark.parametrize("known", [0, 2])
def test_equations_of_open_loops(name: str, known: int) -> None:
    mechanism = mechanism_of(name)
    solver, x = whole(mechanism, known), anywhere(mechanism, COUNT)
    turns = np.random.default_rng(1).integers(-3, 4, x.shape).astype(float)
    for reduction in (solver.equations.full(), solver.open_reduction(x[0]), oblique(solver)):
        for given in (None, turns):
            state, _ = compare(solver, reduction, x, given)
        # With any inverse: of these many matrices few are square.
        rng = np.random.default_rng(3)
        state = state._replace(inverse=rng.normal(size=state.inverse.shape))
        if len(solver.group.passives):
            compare_motion(state)


SCENES = {
    "universal_joint": {"drive": "bearing_in", "held": {"joint_angle": 0.4}},
    "double_shaft_z": {"drive": "bearing_in", "held": {"joint_angle_1": 0.4, "joint_angle_2": 0.3}},
    "ring_joint": {"drive": "bearing_in", "held": {"joint_angle": 0.3}},
    "thoma_rig": {"drive": "bearing_in", "held": {"joint_angle": 0.3}},
    "four_bar": {"drive": "crank_bearing"},
    "slider_crank": {"drive": "crank_bearing"},
    "needle_drive": {"drive": "main_shaft"},
    "stewart_platform": {"drive": LEGS},
    "delta": {"drive": [f"arm_{k}" for k in range(1, 4)]},
    "balls": {"drive": "a"},
    "carried rod": {"drive": ["a", "turn"]},
    "finger": {"drive": "knuckle"},
    "floating": {"drive": "a"},
    "hinges": {"drive": "a"},
    "rack": {"drive": "a"},
    "geared": {"drive": "A"},
    "parallelograms": {"drive": "pivot_0"},
    "spatial": {"drive": "pivot_0"},
}


def kinematics_of(name: str) -> tuple[Kinematics, np.ndarray]:
    """The kinematics of a scene, and coordinates of closed loops."""
    scene = cd.Scene(mechanism_of(name), **SCENES[name])
    shape = (COUNT, len(scene.drives))
    positions = np.squeeze(np.random.default_rng(8).uniform(0.01, 0.1, shape))
    with without_kernel():
        block = scene.assemble(positions).blocks[0]
    return scene.solver.assembly.kinematics, block.x


@pytest.mark.parametrize("name", SCENES)
def test_scenes_with_as_many_equations_as_unknowns(name: str) -> None:
    kinematics, closed = kinematics_of(name)
    rng = np.random.default_rng(4)
    for solver, reduction in zip(kinematics.solvers, kinematics.reductions, strict=True):
        if not solver.group.passives.size:
            continue
        for far in (0.0, 1e-8, 1e-3, 0.05):
            step = far * rng.normal(size=(COUNT, len(solver.group.passives)))
            x = solver.moved(closed, step)
            for given in (reduction, solver.equations.full()):
                state, _ = compare(solver, given, x)
                compare_motion(state)


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("options", [{}, {"settles": True}, {"leaves": 1e-12}])
def test_loops_close_alike(name: str, options: dict[str, float]) -> None:
    kinematics, closed = kinematics_of(name)
    rng = np.random.default_rng(4)
    passives = [solver.group.passives for solver in kinematics.solvers]
    moves = kinematics.coordinates.moves(np.concatenate(passives))
    for far in (0.0, 1e-9, 1e-3, 0.05):
        x = closed.copy()
        step = far * rng.normal(size=(COUNT, moves.columns.size + 3 * len(moves.quaternions)))
        step[0] = 0.0  # One that is closed beside others.
        moves.apply(x, step)
        found = kinematics.close(x, **options)
        with without_kernel():
            expected = kinematics.close(x, **options)
        condition = float(np.max(expected.condition))
        near(found.x, expected.x, 1e-15 * max(100.0, 10.0 * condition))
        assert np.max(found.residual) < 1e-12
        for name in ("rates", "ratios"):
            if name == "rates":
                given = rng.normal(size=(COUNT, len(kinematics.drives)))
                own = kinematics.rates(found, given)
                with without_kernel():
                    other = kinematics.rates(expected, given)
            else:
                own = kinematics.velocity_ratios(found)
                with without_kernel():
                    other = kinematics.velocity_ratios(expected)
            near(own, other, 1e-14 * max(100.0, condition**2))


@pytest.mark.parametrize("name", SCENES)
def test_samples_do_not_depend_on_those_beside_them(name: str) -> None:
    kinematics, closed = kinematics_of(name)
    drives = np.random.default_rng(4).normal(size=(COUNT, len(kinematics.drives)))
    together = kinematics.evaluate(closed)
    rates = kinematics.rates(together, drives)
    accelerations = kinematics.accelerations(together, rates, drives)
    for index in range(COUNT):
        own = [index]
        alone = kinematics.evaluate(closed[own])
        for one, other in zip(alone.groups, together.groups, strict=True):
            if one.is_square and one.rows.shape[2] <= 16:
                for values, all_values in zip(one[2:], other[2:], strict=True):
                    np.testing.assert_array_equal(values[0], all_values[index])
        if all(state.is_square and state.rows.shape[2] <= 16 for state in alone.groups):
            v = kinematics.rates(alone, drives[own])
            np.testing.assert_array_equal(v[0], rates[index])
            a = kinematics.accelerations(alone, v, drives[own])
            np.testing.assert_array_equal(a[0], accelerations[index])


@pytest.mark.parametrize("name", ["universal_joint", "four_bar", "stewart_platform", "geared"])
def test_what_is_not_finite_shows(name: str) -> None:
    """It spoils its own sample, and no other one."""
    kinematics, closed = kinematics_of(name)
    for solver, reduction in zip(kinematics.solvers, kinematics.reductions, strict=True):
        if not solver.group.passives.size:
            continue
        good, error = solver.evaluate(closed, reduction)
        for value in (np.nan, np.inf):
            x = closed.copy()
            x[2, solver._moves.columns] = value
            found, its_error = solver.evaluate(x, reduction)
            assert not found.residual[2] < np.inf
            # The rows of couplings are the same everywhere.
            assert name == "geared" or not found.condition[2] < 1e300
            for index in (0, 1, 3, 4):
                np.testing.assert_array_equal(found.inverse[index], good.inverse[index])
                np.testing.assert_array_equal(its_error[index], error[index])
            steps = solver._steps(found, its_error, 0.5)
            assert not steps.sizes[2] < np.inf
            assert not steps.left[2] < np.inf
            state = solver.newton(x, reduction)
            assert not state.residual[2] < np.inf
            assert np.all(state.residual[[0, 1, 3, 4]] < 1e-14)


@pytest.mark.parametrize("way", [nullcontext, without_kernel])
@pytest.mark.parametrize("name", ["delta", "geared", "spatial", "universal_joint"])
def test_no_samples(name: str, way: Callable[[], AbstractContextManager[None]]) -> None:
    kinematics, closed = kinematics_of(name)
    with way():
        for options in ({}, {"leaves": 1e-12}, {"left": np.zeros(0)}):
            state = kinematics.close(closed[:0], **options)
            assert len(state.x) == 0
            for group in state.groups:
                assert [len(values) for values in group[2:]] == [0] * 10
        v, nv = np.zeros((0, len(kinematics.drives))), kinematics.coordinates.model.nv
        assert kinematics.rates(state, v).shape == (0, nv)
        assert kinematics.velocity_ratios(state).shape == (0, nv, len(kinematics.drives))
        assert kinematics.accelerations(state, np.zeros((0, nv)), v).shape == (0, nv)


def test_half_turns_show_their_axis() -> None:
    """The ends of a loop with balls are half a turn apart, about any axis."""
    mechanism = cd.load(WAYS["balls"]())
    solver = whole(mechanism)
    x = np.repeat(mechanism.zero[None], 7, axis=0)
    axes = np.random.default_rng(3).normal(size=(7, 3))
    axes[:3] = np.eye(3)
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    ball = mechanism.coordinates.balls.columns[0]
    x[:, ball : ball + 4] = 0.0
    x[:, ball : ball + 3] = axes
    x[6, ball : ball + 4] = [0.0, 0.0, np.sin(0.5), np.cos(0.5)]  # Beside one that is none.
    found, expected = compare(solver, solver.equations.full(), x)
    assert np.all(found.residual[:6] > 1.9)
    np.testing.assert_allclose(found.residual, expected.residual, rtol=1e-14)


def in_line(apart: float) -> tuple[GroupSolver, Reduction]:
    """A four-bar all pins of which are in line at zero, but for the ground's, which are apart."""
    kinematics, _ = solver_of_linkage(four_bar(base=apart), "A")
    (item,), (reduction,) = kinematics.solvers, kinematics.reductions
    assert item.group.passives.size == 3
    return item, reduction


def test_exactly_singular_positions_have_pseudoinverses() -> None:
    """Of all samples of a block, as NumPy's have."""
    item, reduction = in_line(0.0)
    x = np.zeros((3, item.coordinates.size))
    x[1:] += np.array([0.2, -0.1, 0.3, 0.4])
    found, expected = compare(item, reduction, x)
    assert np.isinf(expected.condition[0]) or expected.condition[0] > 1e15
    assert found.condition[0] > 1e15
    np.testing.assert_allclose(found.inverse, expected.inverse, rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(found.condition[1:], expected.condition[1:], rtol=1e-11)


@pytest.mark.parametrize("apart", [1e-3, 1e-6, 1e-9])
def test_positions_near_singular_ones(apart: float) -> None:
    item, reduction = in_line(apart)
    x = np.zeros((3, item.coordinates.size))
    x[1] += apart
    found, error = item.evaluate(x, reduction)
    with without_kernel():
        expected, its_error = item.evaluate(x, reduction)
    condition = float(np.max(expected.condition))
    assert condition > 0.1 / apart
    near(found.inverse, expected.inverse, 1e-15 * condition)
    near(found.condition, expected.condition, 1e-15 * condition)
    # Refined, solutions have the rounding of eliminations.
    right = np.random.default_rng(1).normal(size=(3, 3, 2))
    own = found.solve(right)
    left = np.einsum("npr,npc->nrc", found.passive_rows, own) - right
    assert np.max(np.abs(left)) < 1e-14 * np.max(np.abs(own))
    near(error, its_error, 1e-12)


@pytest.mark.parametrize("seed", range(24))
def test_random_chains(seed: int) -> None:
    mechanism = cd.load(draw(seed).chain.text)
    solver, x = whole(mechanism), anywhere(mechanism, COUNT)
    for reduction in (solver.equations.full(), oblique(solver)):
        state, _ = compare(solver, reduction, x)
        state = state._replace(inverse=np.random.default_rng(3).normal(size=state.inverse.shape))
        if len(solver.group.passives):
            compare_motion(state)


@pytest.mark.parametrize("shape", [(1, 1), (3, 5), (6, 6), (0, 3), (3, 0)])
def test_refined_solutions_of_views(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(1)
    rows, columns = shape
    matrices, inverses = (
        rng.normal(size=(COUNT, rows, columns)),
        rng.normal(size=(COUNT, columns, rows)),
    )
    right = rng.normal(size=(COUNT, rows, 4))
    for view in (
        lambda item: item,
        lambda item: np.asfortranarray(item),
        lambda item: np.repeat(item, 2, axis=0)[::2],
        lambda item: item[:1],
    ):
        given = view(matrices), view(inverses), right
        found = refined(*given)
        with without_kernel():
            expected = refined(*given)
        near(found, expected)


def test_single_samples_take_few_calls() -> None:
    kinematics, closed = kinematics_of("universal_joint")
    x, left, rest = closed[:1], np.zeros(1), np.zeros((1, 1))
    state = kinematics.close(x, left=left)
    v = kinematics.rates(state, rest)
    for run, most in (
        (lambda: kinematics.close(x, left=left), 30),
        (lambda: kinematics.close(x, leaves=1e-12), 48),
        (lambda: kinematics.velocity_ratios(state), 9),
        (lambda: kinematics.accelerations(state, v, rest), 9),
    ):
        run()
        assert calls(run) <= most


def arguments_of() -> dict[str, list[object]]:
    """Good arguments of the compiled functions."""
    kinematics, closed = kinematics_of("slider_crank")
    (solver,), (reduction,) = kinematics.solvers, kinematics.reductions
    plan, x = solver.plan(reduction), closed.copy()
    state, error = solver.evaluate(x, reduction)
    placed, p, nv = solver.batch.placed(x), len(solver._scale), kinematics.coordinates.model.nv
    of_state = state.actions, state.twists, state.rows, error
    rates = [plan.plan.handle, state.rows, state.inverse]
    return {
        "closure": [
            *(plan.plan.handle, placed, x, np.zeros(x.shape), *of_state),
            *(np.empty((4, COUNT)), state.inverse),
        ],
        "newton_step": [
            *(plan.plan.handle, state.inverse, error, state.twists, state.actions),
            *(0.5, np.empty((COUNT, p)), np.empty((2, COUNT))),
        ],
        "passive_rates": [*rates, np.zeros((COUNT, nv, 2))],
        "passive_accelerations": [
            *(*rates, state.twists, state.actions),
            *np.zeros((2, COUNT, nv)),
        ],
        "moved": [solver._moves_plan.handle, x, np.zeros((COUNT, p))],
        "refined": [
            state.rows[:, 1:],
            state.inverse,
            np.zeros((COUNT, p, 2)),
            np.zeros((COUNT, p, 2)),
        ],
        "same_side": [state.rows[:, 1:], state.inverse, np.zeros(COUNT)],
    }


@pytest.mark.parametrize("name", arguments_of() if compiled.kernel is not None else [])
def test_other_arguments_are_refused(name: str) -> None:
    """Whatever comes in, nothing beyond its arrays is read or written."""
    function, good = getattr(compiled.kernel, name), arguments_of()[name]
    function(*good)
    other_plan = stepping._plan().handle
    refused = (TypeError, ValueError)
    for place, argument in enumerate(good):
        if isinstance(argument, float):
            bad = ["0.5", None]
        elif isinstance(argument, np.ndarray):
            bad = [argument.astype(np.float32), argument[..., None], argument.tolist(), 1.0]
            for axis in range(argument.ndim):
                span = [slice(None)] * argument.ndim
                span[axis] = slice(argument.shape[axis] - 1)
                bad.append(argument[tuple(span)].copy())
                bad.append(np.concatenate([argument, argument], axis=axis))
        else:
            bad = [other_plan, None, 3]
        for item in bad:
            given = [*good[:place], item, *good[place + 1 :]]
            of_any_size = (name, place) in MAY_DIFFER and isinstance(item, np.ndarray)
            with suppress(*refused) if of_any_size else pytest.raises(refused):
                function(*given)
    with pytest.raises(TypeError):
        function(*good[:-1])
    # Results that may not be written into.
    place = 1 if name == "moved" else len(good) - 1
    result = good[place].copy()
    result.setflags(write=False)
    with pytest.raises((*refused, BufferError)):
        function(*good[:place], result, *good[place + 1 :])


MAY_DIFFER = {("passive_rates", 3), ("moved", 1), ("moved", 2)}
"""Rows that may have more columns than are asked for, or more cases."""
