"""Guesses are the same with compiled functions and without them."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.compiled_functions import needs_kernel, without_kernel
from testkit.many_drives import cranks, on_arms, tree
from testkit.mixed_chain import rows as mixed_rows

import cardan_dyn as cd
from cardan_dyn import compiled
from cardan_dyn.kinematics.assembly import Assembly
from cardan_dyn.kinematics.following.branch import TURN, TURN_PARTS, BranchTable
from cardan_dyn.kinematics.following.drive_motion import DriveMotion, turned_back
from cardan_dyn.kinematics.following.guess_cache import Guess
from cardan_dyn.kinematics.following.lines import Rows
from cardan_dyn.problem.samples import Targets, targets_of
from cardan_dyn.scene.usual_motion import usual_motion

pytestmark = needs_kernel
EPS = np.finfo(float).eps
REFUSED = r"plan|axis|rows|coordinates"


def both_ways(assembly: Assembly, targets: Targets) -> tuple[Guess, Guess]:
    """Return guesses by compiled functions, and by NumPy from the same nodes."""
    guess = assembly.guesses(targets)
    with without_kernel():
        other = assembly.guesses(targets)
    return guess, other


def agree(guess: Guess, other: Guess, accuracy: float = 40.0 * EPS) -> None:
    np.testing.assert_allclose(guess.x, other.x, rtol=0.0, atol=accuracy)
    np.testing.assert_array_equal(guess.turns, other.turns)
    assert guess.followed == other.followed


def usual(name: str, count: int) -> tuple[Assembly, np.ndarray]:
    """Return how a bundled mechanism is assembled for its usual motion, and its positions."""
    motion = usual_motion(cd.load(name), samples=count)
    return motion.scene.solver.assembly, motion.positions.reshape(count, -1)


@pytest.mark.parametrize("name", cd.bundled_names())
def test_all_bundled_mechanisms(name: str) -> None:
    assembly, positions = usual(name, 3000)
    # The first samples find the nodes, and their polynomials.
    for every in (positions, positions[:1], positions[:1], positions[:1]):
        assembly.guesses(Targets.of_positions(every))
    rng = np.random.default_rng(3)
    for count in (1, 2, 700, 2500):
        targets = Targets.of_positions(positions[rng.integers(0, 3000, count)])
        guess, other = both_ways(assembly, targets)
        if positions.shape[1] == 1:
            agree(guess, other)
            assert guess.kinematics is other.kinematics
            assert assembly._cache._known_guess(targets) is not None
        else:
            # Where drives meet, guesses are a Newton step from what is interpolated or followed.
            agree(guess, other, 1e-11)


@pytest.mark.parametrize("name", ["universal_joint", "double_shaft_z", "needle_drive"])
def test_whole_turns(name: str) -> None:
    scene = usual_motion(cd.load(name)).scene
    assembly = scene.solver.assembly
    for span in (20.0, 1.0, 1.0):
        assembly.guesses(Targets.of_positions(np.linspace(-span, span, 4000)[:, None]))
    part = assembly._cache._parts[0]
    assert isinstance(part, DriveMotion) and part.branch.period
    positions = np.concatenate(
        [np.random.default_rng(1).uniform(-6e4, 6e4, 500), [0.0, 1e9, TURN, -TURN, 1e-300]]
    )
    guess, other = both_ways(assembly, Targets.of_positions(positions[:, None]))
    agree(guess, other)
    assert np.any(guess.turns)
    drive = scene.mechanism.coordinates.named[scene.drives[0]].column
    np.testing.assert_array_equal(guess.x[:, drive], positions)


@pytest.mark.parametrize("make", [tree, on_arms])
def test_several_drives_that_do_not_meet(make: object) -> None:
    mechanism = make(3)  # type: ignore[operator]
    scene = cd.Scene(mechanism, drive=cranks(mechanism))
    assembly = scene.solver.assembly
    d = len(scene.drives)
    rng = np.random.default_rng(0)
    for count in (2000, 1, 1, 50):
        positions = rng.uniform(-0.1, 0.1, (count, d))
        agree(*both_ways(assembly, Targets.of_positions(positions)))
    # Those of the last call were known, so that it was the compiled function that answered.
    assert assembly._cache._known_guess(Targets.of_positions(positions)) is not None
    # Where one of them has to be followed farther, all are followed by the long way.
    positions[7, -1] = 0.2
    agree(*both_ways(assembly, Targets.of_positions(positions)))


def test_held_joints_that_vary() -> None:
    """A held joint whose designs move what no drive moves is a branch of its own, or one of two."""
    mechanism = cd.load("universal_joint")
    scene = cd.Scene(mechanism, drive="bearing_in", held={"joint_angle": 0.4})
    solver = scene.solver.of_varied(("joint_angle",))
    rng = np.random.default_rng(5)
    for count in (300, 1, 1, 40):
        held = {"joint_angle": rng.uniform(0.3, 0.5, (count, 1))}
        targets = targets_of(scene.problem, rng.uniform(-1.0, 1.0, 5), held)
        guess, other = both_ways(solver.assembly, targets)
        np.testing.assert_allclose(guess.x, other.x, rtol=0.0, atol=1e-12)


def test_results_far_and_near_are_the_same_bits() -> None:
    """A sample's guess does not depend on what stands beside it."""
    assembly, positions = usual("four_bar", 4000)
    for _ in range(3):
        whole = assembly.guesses(Targets.of_positions(positions))
    for index in (0, 1, 1777, 3999):
        alone = assembly.guesses(Targets.of_positions(positions[[index]]))
        np.testing.assert_array_equal(alone.x[0], whole.x[index])


def table_with_balls(nodes: int) -> BranchTable:
    layout = cd.load("stewart_platform").coordinates
    x, first, second = np.random.default_rng(3).uniform(0.1, 0.3, (3, nodes, layout.size))
    column = layout.columns["leg_1"].start
    x[:, column] = np.cumsum(x[:, column])
    return BranchTable(Rows(x, first, second), column, layout)


def plan_of(table: BranchTable, columns: np.ndarray, period: float = 0.0) -> compiled.Plan:
    windings = np.where(columns == table.drive_column, 0.0, 1.0 + np.arange(len(columns)))
    repeats = np.array([np.inf, period, np.rint(period / TURN), *TURN_PARTS])
    return table.plan(columns, windings, repeats)


def evaluated(
    plan: compiled.Plan, positions: np.ndarray, size: int
) -> tuple[bool, np.ndarray, np.ndarray]:
    x, turns = np.full((len(positions), size), 7.0), np.zeros((len(positions), size))
    return compiled.kernel.branch(plan.handle, positions, x, turns), x, turns


@pytest.mark.parametrize("nodes", [2, 3, 40])
@pytest.mark.parametrize("gaps", [False, True])
def test_tables_with_balls(nodes: int, gaps: bool) -> None:
    table, size = table_with_balls(nodes), cd.load("stewart_platform").coordinates.size
    layout, every = table.coordinates, np.arange(size)
    moved = np.setdiff1d(every, np.arange(size)[layout.columns["ball_2"]]) if gaps else every
    low, high = table.span
    # Nodes themselves, too.
    positions = np.concatenate([np.linspace(low, high, 33), table.positions])
    is_known, x, turns = evaluated(plan_of(table, moved), positions, size)
    assert is_known is True
    expected = table.guess(positions)
    np.testing.assert_allclose(x[:, moved], expected[:, moved], rtol=0.0, atol=4.0 * EPS)
    rest = np.setdiff1d(every, moved)
    np.testing.assert_array_equal(x[:, rest], 7.0)
    np.testing.assert_array_equal(turns, 0.0)
    np.testing.assert_array_equal(x[:, table.drive_column], positions)


def test_positions_that_are_not_known() -> None:
    table = table_with_balls(5)
    size, (low, high) = table.coordinates.size, table.span
    plan = plan_of(table, np.arange(size))
    for wrong in (np.nextafter(low, -9.0), np.nextafter(high, 9.0), np.nan, np.inf, -np.inf):
        assert evaluated(plan, np.array([low, wrong, high]), size)[0] is False
    assert evaluated(plan, np.array([]), size)[0] is True
    assert evaluated(plan, np.array([low, high]), size)[0] is True
    far = np.array([high - low, 0.0, 0.0, *TURN_PARTS])
    turning = table.plan(np.arange(size), np.zeros(size), far)
    assert evaluated(turning, np.array([low, high]), size)[0] is False
    # A drive that turns freely looks for a period beyond that distance from zero, too.
    far[0] = 0.5 * (low + high)
    turning = table.plan(np.arange(size), np.zeros(size), far)
    assert evaluated(turning, np.array([low]), size)[0] is True
    assert evaluated(turning, np.array([high]), size)[0] is False


def test_a_turn_in_all_is_as_far_as_one_from_zero() -> None:
    """Then a drive that turns freely looks for a period, whatever is known already."""
    table, half = table_with_balls(9), np.pi
    size = table.coordinates.size
    table.rows.x.setflags(write=True)
    table.rows.x[:, table.drive_column] = np.linspace(-3.0 * half, 3.0 * half, 9)

    def is_known(*positions: float) -> bool:
        far = np.array([TURN, 0.0, 0.0, *TURN_PARTS])
        plan = table.plan(np.arange(size), np.zeros(size), far)
        return evaluated(plan, np.array(positions), size)[0]

    assert is_known(TURN) and is_known(-TURN) and is_known(-half, 0.9 * half)
    assert not is_known(-half, half)
    assert not is_known(np.nextafter(TURN, 9.0)) and not is_known(np.nextafter(-TURN, -9.0))


def test_periods_and_windings() -> None:
    table = table_with_balls(60)
    size, low = table.coordinates.size, table.span[0]
    columns = np.arange(size)
    assert table.span[1] - low > TURN
    plan = plan_of(table, columns, TURN)
    periods = np.array([-3.0, -1.0, 0.0, 1.0, 1000.0])
    positions = low + 1.0 + TURN * periods
    is_known, x, turns = evaluated(plan, positions, size)
    assert is_known is True
    where = turned_back(positions, periods, TURN)
    expected = table.guess(where)
    expected[:, table.drive_column] = positions
    np.testing.assert_allclose(x, expected, rtol=0.0, atol=4.0 * EPS)
    windings = np.where(columns == table.drive_column, 0.0, 1.0 + columns)
    np.testing.assert_array_equal(turns, periods[:, None] * windings)
    for wrong in (np.nan, np.inf):
        assert evaluated(plan, np.array([wrong]), size)[0] is False


def test_arrays_with_gaps() -> None:
    table = table_with_balls(6)
    size, plan = table.coordinates.size, plan_of(table, np.arange(table.coordinates.size))
    positions = np.linspace(*table.span, 10)
    _, x, turns = evaluated(plan, positions, size)
    wide = np.zeros((size, 20))
    assert compiled.kernel.branch(plan.handle, positions[::-1], wide.T[::2], turns)
    np.testing.assert_array_equal(wide.T[::2], x[::-1])
    np.testing.assert_array_equal(wide.T[1::2], 0.0)


def test_wrong_arguments_of_branches() -> None:
    table, kernel = table_with_balls(4), compiled.kernel
    size = table.coordinates.size
    handle, x = plan_of(table, np.arange(size)).handle, np.zeros((2, size))
    positions = np.full(2, table.span[0])
    for arguments in (
        (handle, positions, x[:1], x),
        (handle, positions, x, x[:, :-1].copy()),
        (handle, positions, x[:, :-1].copy(), x[:, :-1].copy()),
        (table.coordinates.plan.handle, positions, x, x),
    ):
        with pytest.raises(ValueError, match=REFUSED):
            kernel.branch(*arguments)
    read_only = x.copy()
    read_only.setflags(write=False)
    for wrong in (read_only, x[0], x.astype(np.float32), None):
        with pytest.raises((TypeError, ValueError, BufferError)):
            kernel.branch(handle, positions, wrong, x)


@pytest.mark.parametrize("name", cd.bundled_names())
@pytest.mark.parametrize("size", [1.0, 1e150, 1e-150])
def test_derivatives_of_rows(name: str, size: float) -> None:
    mechanism = cd.load(name)
    layout = mechanism.coordinates
    x = mixed_rows(mechanism, 9)
    v, a = size * np.random.default_rng(4).normal(size=(2, 9, mechanism.model.nv))
    v[7], a[8] = np.nan, np.inf
    found = Rows.of_rates(layout, x, v, a)
    longest = found.longest(layout)
    one = Rows.of_rates(layout, x[:1], v[:1], a[:1])
    none = Rows.of_rates(layout, x[:0], v[:0], a[:0])
    transposed = Rows.of_rates(layout, x, v.T.copy().T, a[:, ::-1].copy()[:, ::-1])
    with np.errstate(all="ignore"), without_kernel():
        expected = Rows.of_rates(layout, x, v, a)
        far = found.longest(layout)
    for k, values in enumerate(found):
        scale = np.nanmax(np.abs(expected[k][:7]), initial=0.0)
        np.testing.assert_allclose(values, expected[k], rtol=8.0 * EPS, atol=8.0 * EPS * scale)
        np.testing.assert_array_equal(values[:1], one[k])
        np.testing.assert_array_equal(values, transposed[k])
        assert none[k].shape == (0, layout.size)
    np.testing.assert_allclose(longest, far, rtol=4.0 * EPS)
    np.testing.assert_array_equal(np.isnan(longest), np.isnan(far))


def test_how_far_rows_may_be_extrapolated() -> None:
    layout = cd.load("slider_crank").coordinates
    first, second = np.zeros((2, 5, layout.size))
    first[1, 0], second[1, 1] = 2.0, 9.0
    second[2] = np.nan
    first[3, -1] = np.nan
    first[4] = -np.inf
    rows = Rows(np.zeros_like(first), first, second)
    found = rows.longest(layout)
    with without_kernel():
        np.testing.assert_allclose(found, rows.longest(layout), rtol=2.0 * EPS)
    assert found[0] == np.inf and np.isnan(found[2]) and np.isnan(found[3]) and found[4] == 0.0


def test_wrong_arguments_of_rows() -> None:
    kernel, layout = compiled.kernel, cd.load("four_bar").coordinates
    handle, nv = layout.plan.handle, layout.model.nv
    x, v = np.zeros((2, layout.size)), np.zeros((2, nv))
    for arguments in (
        (handle, x[:, :-1].copy(), v, v, x, x),
        (handle, x, v[:, :-1].copy(), v, x, x),
        (handle, x, v[:1], v, x, x),
        (compiled.Plan("moves", [[]] * 4, []).handle, x, v, v, x, x),
    ):
        with pytest.raises(ValueError, match=REFUSED):
            kernel.rows(*arguments)
    with pytest.raises(ValueError, match=REFUSED):
        kernel.longest(handle, x, x[:1], 1.0, np.zeros(2))
    with pytest.raises(TypeError):
        kernel.longest(handle, x, x, "far", np.zeros(2))
