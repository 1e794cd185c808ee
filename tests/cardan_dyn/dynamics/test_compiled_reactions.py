"""Compiled reactions against those of NumPy, on all mechanisms and on what no mechanism is."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from testkit.ball_rods import as_a_floating_rod, as_balls
from testkit.calls import calls
from testkit.claims import SCENES
from testkit.compiled_functions import needs_kernel, without_kernel
from testkit.drive_lines import drive_line
from testkit.groups import overconstrained
from testkit.line_data import random_line
from testkit.linkages import coupling, gears
from testkit.many_drives import cranks, stacked, tree
from testkit.mixed_chain import MIXED, rows
from testkit.planar_linkages import solver as kinematics_of
from testkit.planar_linkages import three_cranks

import cardan_dyn as cd
from cardan_dyn import compiled
from cardan_dyn.dynamics.inverse_dynamics import InverseDynamics
from cardan_dyn.dynamics.open_tree import LoadCase
from cardan_dyn.dynamics.reactions import UNIQUE_TOLERANCE, Reactions, ReactionSolver
from cardan_dyn.elements.link_loads import LinkLoad
from cardan_dyn.kinematics.closing.all_groups import ClosedState, Kinematics
from cardan_dyn.kinematics.closing.equations import LoopAxes, Reduction

pytestmark = needs_kernel

COUNT = 5
GRAVITY = np.array([[1.0, -2.0, -9.81]])
TOLERANCE = 2e-12
"""Greatest difference, relative to the greatest wrench: rounding times condition numbers."""


def bundled(name: str) -> cd.Scene:
    mechanism = cd.load(name)
    arguments = cd.describe(mechanism).drives.arguments
    return cd.Scene(mechanism, **arguments)  # type: ignore[arg-type]


def gear_train(drive: str) -> cd.Scene:
    """Two couplings, of which the one farther from the drive loads the other."""
    couplings = coupling("g", "a", "b", -3.0), coupling("h", "b", "c", 0.5)
    return cd.Scene(cd.load(gears(*couplings, third=True)), drive=drive)


def closed_train() -> cd.Scene:
    """Two couplings between the same wheels: a self-stress that loads no joint."""
    couplings = coupling("g", "a", "b", 2.0), coupling("h", "a", "b", 2.0)
    return cd.Scene(cd.load(gears(*couplings)), drive="a")


def driven(mechanism: cd.Mechanism) -> cd.Scene:
    return cd.Scene(mechanism, drive=cranks(mechanism))


ALL_SCENES: dict[str, Callable[[], cd.Scene]] = {
    **{name: lambda name=name: bundled(name) for name in cd.bundled_names()},  # type: ignore[misc]
    **SCENES,
    "line": lambda: cd.Scene(cd.load(drive_line(3)), drive="bearing_0"),
    "random line": lambda: random_line(5, seed=3, bend=0.08, mass=True).scene(),
    "gear train": lambda: gear_train("a"),
    "gear train backwards": lambda: gear_train("c"),
    "closed train": closed_train,
    "three cranks": lambda: cd.Scene(three_cranks(), drive="A"),
    "overconstrained": lambda: cd.Scene(overconstrained(), drive="A"),
    "balls": lambda: cd.Scene(cd.load(as_balls()), drive="a"),
    "floating rod": lambda: cd.Scene(cd.load(as_a_floating_rod()), drive="a"),
    "stacked": lambda: driven(stacked(3)),
    "tree": lambda: driven(tree(4)),
}


@pytest.fixture(scope="module", params=ALL_SCENES)
def scene(request: pytest.FixtureRequest) -> cd.Scene:
    return ALL_SCENES[request.param]()


def closed(scene: cd.Scene, count: int = COUNT) -> ClosedState:
    """Return closed positions near the start, some of them far from each other."""
    columns = scene.mechanism.coordinates.columns_of(scene.drives)
    middle = scene.solver.assembly.start[columns]
    where = middle + 0.04 * np.sin(np.outer(np.arange(count), 1.0 + np.arange(len(columns))))
    (state,) = scene.assemble(where).blocks
    return state


def solver_of(mechanism: cd.Mechanism, kinematics: Kinematics) -> ReactionSolver:
    return ReactionSolver(mechanism, kinematics, set(range(len(kinematics.solvers))))


def solver(scene: cd.Scene) -> ReactionSolver:
    return solver_of(scene.mechanism, scene.solver.assembly.kinematics)


def load_cases(mechanism: cd.Mechanism, count: int, cases: int, seed: int = 1) -> list[LoadCase]:
    """Return load cases with motions, loads of each sample, and loads of all samples alike."""
    rng, nv = np.random.default_rng(seed), mechanism.model.nv
    found = []
    for case in range(cases):
        dynamics = (rng.normal(size=(count, nv)), rng.normal(size=(count, nv)))
        loads = rng.normal(size=(1 if case % 2 else count, nv))
        found.append(LoadCase(None if case == 2 else dynamics, loads, [], GRAVITY))
    return found


def assert_alike(
    found: Reactions, expected: Reactions, tolerance: float = TOLERANCE, exact: bool = True
) -> None:
    scale = max(
        float(np.max(np.abs(values), initial=1e-300))
        for values in (expected.wrenches, *expected.closure_forces)
    )
    pairs = [(found.wrenches, expected.wrenches)]
    pairs += zip(found.closure_forces, expected.closure_forces, strict=True)
    for actual, reference in pairs:
        assert actual.shape == reference.shape
        np.testing.assert_allclose(actual, reference, rtol=0.0, atol=tolerance * scale)
    np.testing.assert_allclose(found.influence, expected.influence, rtol=1e-11, atol=1e-13)
    if exact:
        unique = found.influence < UNIQUE_TOLERANCE
        np.testing.assert_array_equal(unique, expected.influence < UNIQUE_TOLERANCE)
    assert found.indeterminate_couplings == expected.indeterminate_couplings


def both(
    item: ReactionSolver, state: ClosedState, cases: list[LoadCase]
) -> Iterator[tuple[Reactions, Reactions]]:
    """Yield compiled reactions and NumPy's, case by case."""
    found = item.solve(state, cases)
    with without_kernel():
        expected = item.solve(state, cases)
    yield from zip(found, expected, strict=True)


@pytest.mark.parametrize("cases", [1, 2, 5])
def test_reactions_are_those_of_arrays(scene: cd.Scene, cases: int) -> None:
    state, item = closed(scene), solver(scene)
    condition = max(1.0, float(np.max(state.condition)))
    rng = load_cases(scene.mechanism, COUNT, cases)
    for found, expected in both(item, state, rng):
        assert_alike(found, expected, TOLERANCE * max(1.0, 1e-3 * condition))
        efforts = item.efforts(found)
        scale = np.max(np.abs(found.wrenches)) + 1e-300
        np.testing.assert_allclose(
            efforts, item.efforts(expected), rtol=0.0, atol=TOLERANCE * condition * scale
        )


def chosen(state: ClosedState, order: np.ndarray) -> ClosedState:
    """Return some of the samples of a state."""
    groups = [group.of(order) for group in state.groups]
    return ClosedState(state.x[order], groups, *(values[order] for values in state[2:]))


@pytest.mark.parametrize("order", [[], [2], [4, 2, 2], [4, 3, 2, 1, 0]])
def test_a_sample_is_the_same_wherever_it_is(scene: cd.Scene, order: list[int]) -> None:
    """To the last bit, in any order and alone; and there may be none."""
    state, item = closed(scene), solver(scene)
    cases = load_cases(scene.mechanism, COUNT, 2)
    wrenches = item._tree.wrenches(state, cases, item.size)
    samples = np.array(order, dtype=int)
    own = [
        case._replace(loads=case.loads if len(case.loads) == 1 else case.loads[samples])
        for case in cases
    ]
    part = wrenches[samples]
    found, influence, _ = item._closed_at_once(chosen(state, samples), own, part)
    expected, greatest, _ = item._closed_at_once(state, cases, wrenches)
    np.testing.assert_array_equal(part, wrenches[samples])
    for force, reference in zip(found, expected, strict=True):
        np.testing.assert_array_equal(force, reference[samples])
    assert influence.any() if order and greatest.any() else not influence.any()
    assert np.all(influence <= greatest)


def random_reduction(rng: np.random.Generator, kinematics: Kinematics) -> Kinematics:
    """Return the same with rows that no linkage has: oblique ones, in the axes of any bodies."""
    reductions = []
    for item in kinematics.solvers:
        loops, least = len(item.group.loops), item.group.passives.size
        kept = np.full(loops, 6)
        while loops and kept.sum() + len(item.group.couplings) > least and rng.random() < 0.8:
            kept[rng.integers(loops)] -= 1
        kept = np.maximum(kept, 1)
        rows, null, axes = [], [], []
        for size in kept.tolist():
            basis, _ = np.linalg.qr(rng.normal(size=(6, 6)))
            rows.append(basis[:, :size])
            null.append(basis[:, size:])
            axes.append(LoopAxes(int(rng.integers(-1, len(item.batch))), rng.normal(size=3)))
        reductions.append(Reduction(tuple(rows), tuple(null), tuple(axes)))
    return kinematics.with_reductions(reductions)


def bolted_to_a_body() -> cd.Mechanism:
    """The mixed chain, whose loop that is fixed ends at a body instead of the base."""
    first, second = (
        '<origin xyz="0.3 0 0" rpy="0.2 0 0.1"/>',
        '<origin xyz="0.7 1.5 2.5" rpy="0 0.3 0"/>',
    )
    before = (
        f'<predecessor link="left">{first}</predecessor><successor link="base">{second}</successor>'
    )
    after = (
        f'<predecessor link="base">{second}</predecessor><successor link="left">{first}</successor>'
    )
    assert before in MIXED
    return cd.load(MIXED.replace(before, after))


CHAINS: list[tuple[Callable[[], cd.Mechanism], tuple[str, ...]]] = [
    (lambda: cd.load(MIXED), ("turn",)),
    (bolted_to_a_body, ("turn",)),
    (lambda: stacked(2), ("crank_0", "crank_1")),
    (three_cranks, ("A",)),
    (overconstrained, ("A",)),
    (lambda: SCENES["gears"]().mechanism, ("in", "swing")),
]


@pytest.mark.parametrize("seed", range(36))
def test_random_chains(seed: int) -> None:
    """Loops need not even close: forces are linear in what is given, whatever that is.

    Balls, slides, oblique axes, loops that are fixed to the base or to a body, loops that moving
    bodies carry, rows of loops and of whole groups that are redundant.
    """
    rng = np.random.default_rng(seed)
    maker, drives = CHAINS[seed % len(CHAINS)]
    mechanism = maker()
    kinematics, _ = kinematics_of(mechanism, *drives)
    while True:
        reduced = random_reduction(rng, kinematics)
        state = reduced.evaluate(rows(mechanism, COUNT, int(rng.integers(1000))))
        if np.max(state.condition) < 1e4:
            break  # Elsewhere rounding decides.
    item = solver_of(mechanism, reduced)
    for found, expected in both(item, state, load_cases(mechanism, COUNT, 2, seed)):
        # The product with itself squares the condition of self-stresses.
        assert_alike(found, expected, 1e-8, exact=False)


def test_no_groups_and_no_loops() -> None:
    scene = SCENES["universal"]()
    kinematics, state = scene.solver.assembly.kinematics, closed(scene)
    item = ReactionSolver(scene.mechanism, kinematics, set())
    for found, expected in both(item, state, load_cases(scene.mechanism, COUNT, 2)):
        assert_alike(found, expected)
        assert not any(force.any() for force in found.closure_forces)


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e308, -1e300])
@pytest.mark.parametrize("name", ["universal", "gears", "three cranks", "line"])
def test_what_overflows_stays_where_it_is(name: str, bad: float) -> None:
    """Such a sample is refused later, and no other sample knows of it."""
    scene = ALL_SCENES[name]()
    state, item = closed(scene), solver(scene)
    (case,) = load_cases(scene.mechanism, COUNT, 1)
    (sound,) = item.solve(state, [case])
    loads = case.loads.copy()
    loads[2] = bad
    with np.errstate(all="ignore"):
        ((found, expected),) = both(item, state, [case._replace(loads=loads)])
    others = np.arange(COUNT) != 2
    for actual, reference, before in zip(
        (found.wrenches, *found.closure_forces),
        (expected.wrenches, *expected.closure_forces),
        (sound.wrenches, *sound.closure_forces),
        strict=True,
    ):
        np.testing.assert_array_equal(actual[others], before[others])
        assert np.isfinite(actual[2]).all() == np.isfinite(reference[2]).all()
    np.testing.assert_array_equal(found.influence, sound.influence)


def test_influence_that_is_no_number_stays_so() -> None:
    """It is no small one: what it belongs to is not unique."""
    scene = SCENES["universal"]()
    state, item = closed(scene), solver(scene)
    actions = state.groups[0].actions.copy()
    actions[1, 6:12] = np.nan
    broken = state._replace(groups=[state.groups[0]._replace(actions=actions), *state.groups[1:]])
    (case,) = load_cases(scene.mechanism, COUNT, 1)
    ((found, expected),) = both(item, broken, [case])
    assert np.isnan(found.influence[1]).any() and np.isnan(expected.influence[1]).any()
    assert not (found.influence[1] < UNIQUE_TOLERANCE)[np.isnan(expected.influence[1])].all()
    assert np.isfinite(np.delete(found.influence, 1, axis=0)).all()
    assert not np.isfinite(found.wrenches[1]).all()
    assert np.isfinite(np.delete(found.wrenches, 1, axis=0)).all()


def test_tiny_and_huge_lengths() -> None:
    """The same linkage in units of its own: amounts do not depend on them."""
    scene = SCENES["four-bar"]()
    state, item = closed(scene), solver(scene)
    (case,) = load_cases(scene.mechanism, COUNT, 1)
    for factor in (1e-150, 1e-20, 1e20, 1e140):
        scaled = case._replace(dynamics=None, loads=factor * case.loads)
        ((found, expected),) = both(item, state, [scaled])
        scale = np.max(np.abs(expected.wrenches))
        np.testing.assert_allclose(found.wrenches / scale, expected.wrenches / scale, atol=1e-11)


def test_other_redundant_rows_have_another_plan() -> None:
    scene = SCENES["four-bar"]()
    item, cases = solver(scene), load_cases(scene.mechanism, COUNT, 1)
    known = scene.solver.assembly.kinematics
    x = closed(scene).x
    full = known.with_reductions([own.equations.full() for own in known.solvers])
    for kinematics in (known, full, known):
        ((found, expected),) = both(item, kinematics.evaluate(x), cases)
        assert_alike(found, expected, 1e-9)


def test_a_copy_of_a_solver_does_the_same() -> None:
    scene = SCENES["gears"]()
    state, item = closed(scene), solver(scene)
    cases = load_cases(scene.mechanism, COUNT, 1)
    (before,) = item.solve(state, cases)
    plan = item._plan
    assert plan is not None
    item._plan = plan._replace(plan=pickle.loads(pickle.dumps(plan.plan)))
    (after,) = item.solve(state, cases)
    np.testing.assert_array_equal(after.wrenches, before.wrenches)


def test_arrays_that_do_not_fit_are_refused() -> None:
    scene = SCENES["universal"]()
    state, item = closed(scene), solver(scene)
    item.solve(state, load_cases(scene.mechanism, COUNT, 1))
    plan = item._plan
    assert plan is not None
    group, loops = state.groups[0], len(scene.mechanism.loops)
    right = [
        plan.plan.handle,
        np.zeros((COUNT, item.size, 6, 1)),
        np.zeros((COUNT, plan.rows, 1)),
        np.zeros((item.size, 6)),
        np.zeros(len(scene.mechanism.couplings)),
        np.zeros((1, scene.mechanism.model.nv)),
        *(group.actions, group.square, group.inverse),
    ]
    assert plan.rows == 6 * loops
    compiled.kernel.reactions(*right)
    for index, given in enumerate(right[1:], 1):
        for axis in range(given.ndim):  # type: ignore[union-attr]
            wrong = list(right)
            shape = list(given.shape)  # type: ignore[union-attr]
            shape[axis] += 1 if shape[axis] != 1 or index != 5 else 2
            wrong[index] = np.zeros(shape)
            with pytest.raises((ValueError, TypeError)):
                compiled.kernel.reactions(*wrong)
        wrong = list(right)
        wrong[index] = np.zeros(given.shape, dtype=np.float32)  # type: ignore[union-attr]
        with pytest.raises(TypeError):
            compiled.kernel.reactions(*wrong)
    with pytest.raises(TypeError):
        compiled.kernel.reactions(*right[:-1])
    with pytest.raises(ValueError, match="no plan of reactions"):
        compiled.kernel.reactions(compiled.Plan("moves", [[]] * 4, []).handle, *right[1:])
    with pytest.raises(ValueError, match="no plan of exerted"):
        compiled.kernel.exerted(plan.plan.handle, *right[1:4])
    read_only = right[1].copy()  # type: ignore[union-attr]
    read_only.flags.writeable = False
    with pytest.raises(ValueError, match="read-only"):
        compiled.kernel.reactions(right[0], read_only, *right[2:])


def test_arrays_with_gaps_are_as_good(scene: cd.Scene) -> None:
    """Of slices and transposes, results do not differ by a bit."""
    state, item = closed(scene), solver(scene)
    cases = load_cases(scene.mechanism, COUNT, 2)
    expected = item.solve(state, cases)

    def apart(values: np.ndarray) -> np.ndarray:
        return np.repeat(values.swapaxes(1, 2), 2, axis=0)[::2].swapaxes(1, 2)

    groups = [
        group._replace(
            actions=apart(group.actions),
            rows=apart(group.rows),
            inverse=apart(group.inverse),
            null=apart(group.null),
        )
        for group in state.groups
    ]
    for found, reference in zip(
        item.solve(state._replace(groups=groups), cases), expected, strict=True
    ):
        np.testing.assert_allclose(found.wrenches, reference.wrenches, rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("count", [0, 1, COUNT])
def test_loads_on_links(scene: cd.Scene, count: int) -> None:
    """In the axes of the link or the world, at a point of the link, alike at all samples or not."""
    state, item = chosen(closed(scene), np.arange(count)), solver(scene)
    if not count and item._tree._bases:
        return  # Arrays of no samples are not reshaped as those of some.
    rng, mechanism = np.random.default_rng(6), scene.mechanism
    loads = []
    for body in range(mechanism.model.njoints - 1):
        rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        translation, point = rng.normal(size=(2, 3))
        sizes = (count, 1) if body % 2 else (1, count)
        force, moment = (rng.normal(size=(size, 3)) for size in sizes)
        given = body, rotation, translation, force, moment, body % 3 == 0, point
        loads.append(LinkLoad(*given))
    (case,) = load_cases(mechanism, count, 1)
    for loaded in (case._replace(link_loads=loads), case._replace(dynamics=None, link_loads=loads)):
        found = item._tree.wrenches(state, [loaded], item.size)
        with without_kernel():
            expected = item._tree.wrenches(state, [loaded], item.size)
        scale = np.max(np.abs(expected), initial=1.0)
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-13 * scale)


def test_a_load_that_is_no_number_is_that_of_its_sample() -> None:
    scene = SCENES["universal"]()
    state, item = closed(scene), solver(scene)
    force = np.ones((COUNT, 3))
    force[3, 1] = np.nan
    load = LinkLoad(3, np.eye(3), np.zeros(3), force, np.ones((1, 3)), False)
    case = LoadCase(None, np.zeros((1, scene.mechanism.model.nv)), [load], GRAVITY)
    wrenches = item._tree.wrenches(state, [case], item.size)
    assert np.isfinite(wrenches[[0, 1, 2, 4]]).all()
    assert not np.isfinite(wrenches[3]).all()
    wrong = load.of_samples(slice(0, 2))
    with pytest.raises(ValueError, match="axis 0"):
        item._tree.wrenches(state, [case._replace(link_loads=[wrong])], item.size)


def dynamics(scene: cd.Scene) -> InverseDynamics:
    return scene.solver.inverse_dynamics


def test_what_is_exerted(scene: cd.Scene) -> None:
    """Along driven and held coordinates, couplings taken off."""
    state, item = closed(scene), dynamics(scene)
    rng, nv = np.random.default_rng(4), scene.mechanism.model.nv
    (case,) = load_cases(scene.mechanism, COUNT, 1)
    (reactions,) = item._reactions.solve(state, [case])
    ratios = rng.normal(size=(COUNT, nv, len(scene.drives)))
    for loads in (case.loads, np.ones((1, nv))):
        found = item._exerted(loads, ratios, reactions)
        with without_kernel():
            expected = item._exerted(loads, ratios, reactions)
        scale = np.max(np.abs(reactions.wrenches))
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-14 * scale)
        assert np.count_nonzero(found) <= found.shape[0] * scene.problem.prescribed_columns.size


def test_condition(scene: cd.Scene) -> None:
    state, item = closed(scene), dynamics(scene)
    shape = COUNT, scene.mechanism.model.nv, len(scene.drives)
    ratios = np.random.default_rng(5).normal(size=shape)
    ratios[0], ratios[1, -1, -1], ratios[2, 0, 0] = 1e-3, np.nan, np.inf
    found = item.condition(state, ratios)
    with without_kernel():
        expected = item.condition(state, ratios)
    np.testing.assert_allclose(found, expected, rtol=1e-15)
    assert np.isnan(found[1])


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_numbers_that_are_not_finite_are_found_anywhere(bad: float) -> None:
    finite = compiled.kernel.all_finite
    whole = np.full((3, 4, 5, 7), 1e308)
    assert finite() and finite(whole, whole[0], whole[0, 0, 0], np.zeros((0, 3)))
    views = [whole, whole[:, ::2, :, ::3], whole.T, whole[1], whole[..., 3], whole[0, 1, 2]]
    for index in np.ndindex(*whole.shape):
        given = whole.copy()
        given[index] = bad
        assert not finite(given)
    for view in views:
        assert finite(view)
        broken = np.full(whole.shape, bad)
        assert not finite(broken[:, ::2, :, ::3]) and not finite(broken.T)
    gaps = np.full((4, 6), bad)
    gaps[:, ::2] = 1.0
    assert finite(gaps[:, ::2]) and not finite(gaps)
    with pytest.raises(TypeError):
        finite(np.zeros(3, dtype=int))


def test_calls_of_one_sample() -> None:
    """From closed loops to reactions, with loads on links and inertia, and what follows of them."""
    scene = SCENES["universal"]()
    state, item, dynamic = chosen(closed(scene), np.arange(1)), solver(scene), dynamics(scene)
    (case,) = load_cases(scene.mechanism, 1, 1)
    load = LinkLoad(3, np.eye(3), np.zeros(3), np.ones((1, 3)), np.ones((1, 3)), False)
    loaded = case._replace(link_loads=[load])
    (reactions,) = item.solve(state, [loaded])
    assert calls(lambda: item.solve(state, [case])) < 28
    assert calls(lambda: item.solve(state, [loaded])) < 33
    ratios = np.ones((1, scene.mechanism.model.nv, 1))
    dynamic._exerted(case.loads, ratios, reactions)
    assert calls(lambda: dynamic._exerted(case.loads, ratios, reactions)) < 8
    assert calls(lambda: dynamic.condition(state, ratios)) < 7
