"""Wrenches of the open tree against Pinocchio's inverse dynamics with external forces."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from testkit.claims import SCENES
from testkit.drive_lines import two_lines
from testkit.mixed_chain import rows
from testkit.scaling import moving, scaled

import cardan_dyn as cd
from cardan_dyn.dynamics.open_tree import Along, LoadCase, OpenTree
from cardan_dyn.elements.link_loads import LinkLoad

COUNT = 3
GRAVITY = np.array([[1.0, -2.0, -9.81]])


@pytest.fixture(scope="module", params=SCENES)
def scene(request: pytest.FixtureRequest) -> cd.Scene:
    return SCENES[request.param]()


def open_tree(scene: cd.Scene, active: set[int] | None = None) -> OpenTree:
    kinematics = scene.solver.assembly.kinematics
    groups = set(range(len(kinematics.solvers))) if active is None else active
    return OpenTree(scene.mechanism, kinematics, groups)


def rates(mechanism: cd.Mechanism) -> tuple[np.ndarray, np.ndarray]:
    v, a = np.random.default_rng(3).uniform(-2.0, 2.0, (2, COUNT, mechanism.model.nv))
    return v, a


def case(mechanism: cd.Mechanism, *loads: LinkLoad, moving: bool = True) -> LoadCase:
    zero = np.zeros((1, mechanism.model.nv))
    return LoadCase(rates(mechanism) if moving else None, zero, loads, GRAVITY)


def link_load(mechanism: cd.Mechanism, link: str, in_world: bool, count: int = 1) -> LinkLoad:
    """Return a load on a link that lies askew in its body."""
    joint, _ = mechanism.links[link]
    turn, translation = np.array([0.3, -0.8, 0.5]), np.array([0.2, 0.7, -0.4])
    force, moment = np.random.default_rng(4).normal(size=(2, count, 3))
    return LinkLoad(joint - 1, pinocchio.exp3(turn), translation, force, moment, in_world)


def reference(mechanism: cd.Mechanism, x: np.ndarray, item: LoadCase) -> np.ndarray:
    """Return Pinocchio's joint wrenches `(N, n, 6)` without the bodies that only carry loops."""
    model = mechanism.model.copy()
    (model.gravity.linear,) = item.gravity
    for index in mechanism.auxiliary_bodies:
        model.inertias[index] = pinocchio.Inertia.Zero()
    if item.dynamics is None:
        for index in range(model.njoints):
            model.inertias[index] = pinocchio.Inertia.Zero()
    v, a = item.dynamics or np.zeros((2, len(x), model.nv))
    data, result = model.createData(), np.empty((len(x), model.njoints - 1, 6))
    for sample, q in enumerate(mechanism.coordinates.configuration(x)):
        pinocchio.forwardKinematics(model, data, q)
        external = [pinocchio.Force.Zero() for _ in range(model.njoints)]
        for load in item.link_loads:
            force, moment = (
                values[sample if len(values) > 1 else 0] for values in (load.force, load.moment)
            )
            placement = pinocchio.SE3(load.rotation, load.translation)
            wrench = pinocchio.Force(force, moment)
            if load.in_world:
                turned = (data.oMi[load.body + 1] * placement).rotation.T
                wrench = pinocchio.Force(turned @ force, turned @ moment)
            external[load.body + 1] += placement.act(wrench)
        forces = pinocchio.StdVec_Force()
        forces.extend(external)
        pinocchio.rnea(model, data, q, v[sample], a[sample], forces)
        result[sample] = [data.f[index].vector for index in range(1, model.njoints)]
    return result


def assert_same(actual: np.ndarray, expected: np.ndarray) -> None:
    scale = np.max(np.abs(expected))
    assert scale > 0.0
    np.testing.assert_allclose(actual, expected, rtol=0.0, atol=1e-12 * scale)


def test_wrenches_of_inertia_and_weight(scene: cd.Scene) -> None:
    mechanism, tree = scene.mechanism, open_tree(scene)
    x, item = rows(mechanism, COUNT), case(mechanism)
    state = scene.solver.assembly.kinematics.evaluate(x)
    size = tree.bodies + 2
    wrenches = tree.wrenches(state, [item], size)
    assert wrenches.shape == (COUNT, size, 6, 1)
    assert tree.bodies == mechanism.model.njoints - 1
    assert_same(wrenches[:, : tree.bodies, :, 0], reference(mechanism, x, item))
    assert not np.any(wrenches[:, tree.bodies :])


@pytest.mark.parametrize("in_world", [False, True])
@pytest.mark.parametrize("count", [1, COUNT])
def test_wrenches_of_loads_on_every_link(scene: cd.Scene, in_world: bool, count: int) -> None:
    mechanism, tree, x = scene.mechanism, open_tree(scene), rows(scene.mechanism, COUNT)
    state = scene.solver.assembly.kinematics.evaluate(x)
    for link, (joint, _) in mechanism.links.items():
        if not joint:
            continue
        item = case(mechanism, link_load(mechanism, link, in_world, count), moving=False)
        wrenches = tree.wrenches(state, [item], tree.bodies)[..., 0]
        assert_same(wrenches, reference(mechanism, x, item))


def test_load_cases_are_computed_together(scene: cd.Scene) -> None:
    mechanism, tree, x = scene.mechanism, open_tree(scene), rows(scene.mechanism, COUNT)
    state = scene.solver.assembly.kinematics.evaluate(x)
    link = next(name for name, (joint, _) in mechanism.links.items() if joint)
    load = link_load(mechanism, link, in_world=True)
    cases = [case(mechanism), case(mechanism, load, load), case(mechanism, load, moving=False)]
    together = tree.wrenches(state, cases, tree.bodies)
    for index, item in enumerate(cases):
        alone = tree.wrenches(state, [item], tree.bodies)
        np.testing.assert_array_equal(together[..., [index]], alone)
    assert_same(together[..., 1] - together[..., 0], 2.0 * together[..., 2])


def test_gravity_may_differ_from_sample_to_sample(scene: cd.Scene) -> None:
    mechanism, tree, x = scene.mechanism, open_tree(scene), rows(scene.mechanism, COUNT)
    kinematics, item = scene.solver.assembly.kinematics, case(scene.mechanism)
    assert item.dynamics is not None
    gravity = np.random.default_rng(6).uniform(-9.0, 9.0, (COUNT, 3))
    together = tree.wrenches(kinematics.evaluate(x), [item._replace(gravity=gravity)], tree.bodies)[
        ..., 0
    ]
    for sample in range(COUNT):
        part = slice(sample, sample + 1)
        v, a = (values[part] for values in item.dynamics)
        alone = item._replace(dynamics=(v, a), gravity=gravity[part])
        assert_same(together[part], reference(mechanism, x[part], alone))


@pytest.mark.parametrize("count", [1, COUNT])
def test_factors_on_inertia_add_what_moves_the_links(scene: cd.Scene, count: int) -> None:
    """Of links that no loop cuts: what is cut carries half of its mass on either side."""
    mechanism, tree, x = scene.mechanism, open_tree(scene), rows(scene.mechanism, COUNT)
    state = scene.solver.assembly.kinematics.evaluate(x)
    cut = {body for loop in mechanism.loops for body in (loop.predecessor, loop.successor)}
    links = [link for link in moving(mechanism) if mechanism.link(link)[0] not in cut]
    factors = np.random.default_rng(7).uniform(0.1, 3.0, (len(links), count))
    inertia = dict(zip(links, factors, strict=True))
    item = case(mechanism)
    found = tree.wrenches(state, [item._replace(inertia=inertia)], tree.bodies)[..., 0]
    for sample in range(COUNT):
        own = {link: float(factor[sample % count]) for link, factor in inertia.items()}
        assert_same(found[sample], reference(scaled(mechanism, own), x, item)[sample])
    resting = case(mechanism, moving=False)._replace(inertia=inertia)
    assert not np.any(tree.wrenches(state, [resting], tree.bodies))


@pytest.mark.parametrize("are_aligned", [True, False])
def test_efforts_are_components_along_unit_twists(are_aligned: bool) -> None:
    rng = np.random.default_rng(4)
    owners, columns = np.array([0, 0, 2, 3, 1]), np.array([4, 1, 2])
    subspace = rng.normal(size=(5, 6))
    if are_aligned:
        subspace = np.eye(6)[[1, 5, 3, 0, 4]] * np.array([1.0, -1.0, 1.0, -1.0, 0.0])[:, None]
    wrenches = rng.normal(size=(7, 4, 6, 2))
    found = Along(owners, subspace).efforts(wrenches, columns)
    for row, column in enumerate(columns):
        expected = subspace[column] @ wrenches[:, owners[column]]
        np.testing.assert_allclose(found[:, row], expected, atol=1e-14)


def test_only_solved_groups_have_inertia_unless_none_is_solved() -> None:
    """Where none is solved, virtual work gives the drive efforts, which all inertia adds to."""
    scene = cd.Scene(cd.load(two_lines(2)), drive="bearing_0")
    mechanism, x = scene.mechanism, rows(scene.mechanism, COUNT)
    kinematics = scene.solver.assembly.kinematics
    state, item, size = kinematics.evaluate(x), case(mechanism), mechanism.model.njoints - 1
    massive = [index for index, solver in enumerate(kinematics.solvers) if solver.batch.has_mass]
    assert len(massive) > 1
    whole = open_tree(scene).wrenches(state, [item], size)
    assert_same(whole[..., 0], reference(mechanism, x, item))
    np.testing.assert_array_equal(open_tree(scene, set()).wrenches(state, [item], size), whole)
    alone = [open_tree(scene, {index}).wrenches(state, [item], size) for index in massive]
    assert all(np.any(wrenches) for wrenches in alone)
    assert_same(sum(alone), whole)


def test_loads_on_bodies_of_no_solved_group_are_left_out() -> None:
    mechanism = SCENES["universal"]().mechanism
    scene = SCENES["universal"](outputs=["bearing_in"])
    tree, x = open_tree(scene), rows(mechanism, COUNT)
    outside = LinkLoad(99, np.eye(3), np.zeros(3), np.ones((1, 3)), np.ones((1, 3)), True)
    state = scene.solver.assembly.kinematics.evaluate(x)
    item = case(mechanism, outside, moving=False)
    assert not np.any(tree.wrenches(state, [item], tree.bodies))
