"""Statics of one sample on plain numbers: closure forces, and how indeterminate ones are chosen."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest
from testkit.linkages import coupling, gears

import cardan_dyn as cd
from cardan_dyn.core.kinematics.loops.closure_blocks import closure_blocks
from cardan_dyn.core.mechanics import closure
from cardan_dyn.core.mechanics.bodies import Tree, tree_of
from cardan_dyn.core.mechanics.elimination import Eliminated, eliminated
from cardan_dyn.core.mechanics.placements import Placed, placed
from cardan_dyn.core.mechanics.reactions import (
    Closed,
    Compliance,
    SelfStresses,
    Statics,
    Wrenches,
    closed,
)
from cardan_dyn.core.mechanics.sample import Roles, passive_rows
from cardan_dyn.core.mechanics.vectors import seen
from cardan_dyn.scene.usual_motion import usual_motion

NAMES = ["four_bar", "universal_joint", "thoma_rig"]


class Case(NamedTuple):
    """A closed chain with random wrenches of its open tree and random loads."""

    tree: Tree
    at: Placed
    factors: Eliminated
    open_tree: Wrenches
    loads: dict[int, float]
    statics: Statics


def case(mechanism: cd.Mechanism, scene: cd.Scene, position: Any, seed: int = 0) -> Case:
    assembly, problem = scene.solver.assembly, scene.problem
    rng, coordinates = np.random.default_rng(seed), mechanism.coordinates
    x = scene.assemble(np.atleast_2d(position)).blocks[0].x[0]
    tree = tree_of(mechanism)
    roles = Roles(
        tuple(coordinates.rates_of(problem.independent)),
        tuple(coordinates.rates_of(problem.held)),
        closure_blocks([(group, True) for group in assembly.groups]),
        tuple(sorted(mechanism.wrench_indices.values())),
    )
    values = dict(enumerate((x / tree.coordinate_units(len(x))).tolist()))
    at = placed(tree, values)
    rows = passive_rows(closure.rows(tree, at, roles.passives), roles)
    ((order, _),) = roles.orders(tree, (x / tree.coordinate_units(len(x)))[:, None], 1e-12)
    factors = eliminated(rows, order)
    vectors = rng.normal(size=(2, len(tree.bodies), 3)).tolist()
    pushed = Wrenches(*([tuple(vector) for vector in of] for of in vectors)).passed_on(tree, at)
    loads = dict(enumerate(rng.normal(size=len(tree.units)).tolist()))
    return Case(tree, at, factors, pushed, loads, roles.statics)


def usual_case(name: str, seed: int = 0) -> Case:
    usual = usual_motion(cd.load(name), samples=11)
    return case(usual.scene.mechanism, usual.scene, usual.positions[4], seed)


def vector(item: Case, of: Closed) -> np.ndarray:
    """Return all components that a norm counts, forces times the length."""
    result = []
    for index in item.statics.counted:
        found = of.counted(item.tree, item.at, index)
        _, force, moment = found or (None, np.zeros(3), np.zeros(3))
        result.append([*np.array(force) * item.tree.norm_length, *moment])
    return np.array(result, dtype=float).ravel()


def stresses(item: Case) -> np.ndarray:
    found = SelfStresses.of(item.tree, item.at, item.factors, item.statics)
    return np.array([vector(item, of) for of in found.items])


def solved(item: Case, **options: Any) -> Closed:
    statics = item.statics._replace(**options)
    return closed(item.tree, item.at, item.factors, item.open_tree, item.loads, statics)


@pytest.mark.parametrize("name", NAMES)
def test_passive_joints_pass_their_loads_alone(name: str) -> None:
    item = usual_case(name)
    found = solved(item)
    every = [found.wrenches[index] for index in range(len(item.tree.bodies))]
    wrenches = Wrenches([force for force, _ in every], [moment for _, moment in every])
    along = wrenches.along(item.tree, item.statics.passives)
    size = np.abs(vector(item, found)).max()
    for rate, effort in along.items():
        assert abs(effort - item.loads[rate]) < 1e-11 * size


@pytest.mark.parametrize("name", NAMES)
def test_the_least_norm_is_orthogonal_to_every_self_stress(name: str) -> None:
    """Otherwise some amount of one of them would make the norm smaller."""
    item = usual_case(name)
    every, found = stresses(item), vector(item, solved(item))
    assert len(every)
    sizes = np.linalg.norm(every, axis=1) * np.linalg.norm(found)
    assert np.max(np.abs(every @ found) / sizes) < 1e-11


def joint_forms(item: Case, compliances: list[Compliance]) -> np.ndarray:
    """Return the matrix of energy `(6 b, 6 b)` in components as a norm counts them."""
    counted, tree = list(item.statics.counted), item.tree
    result = np.zeros((6 * len(counted),) * 2)
    scale = np.repeat([1.0 / tree.norm_length, 1.0], 3)
    for index, first, matrix in compliances:
        place = 6 * counted.index(index)
        zero, body = (
            np.array(of) for of in (item.at.at_zero(tree, first), item.at.rotations[index])
        )
        turn = np.zeros((6, 6))
        turn[:3, :3] = turn[3:, 3:] = zero @ body.T
        own = turn.T @ np.array(matrix) @ turn
        result[place : place + 6, place : place + 6] = scale[:, None] * own * scale
    return result


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("ranks", [(6, 6, 6), (2, 1), (0,)])
def test_energy_decides_before_the_norm(name: str, ranks: tuple[int, ...]) -> None:
    """Beside dense least squares: least energy, and of all that store it the least norm."""
    item, rng = usual_case(name), np.random.default_rng(3)
    parts = [index for index in item.statics.counted if index < len(item.tree.bodies)]
    compliances = []
    for index, rank in zip(rng.permutation(parts).tolist(), ranks, strict=False):
        root = rng.normal(size=(6, rank))
        compliances.append(Compliance(index, index, tuple(map(tuple, (root @ root.T).tolist()))))
    every, plain = stresses(item), vector(item, solved(item))
    energy = joint_forms(item, compliances)
    form, right = every @ energy @ every.T, -every @ energy @ plain
    values, vectors = np.linalg.eigh(form)
    is_stiff = values > 1e-10 * max(values[-1], 1e-300)
    strong, silent = vectors[:, is_stiff], vectors[:, ~is_stiff]
    amounts = strong @ ((strong.T @ right) / values[is_stiff])
    left = every.T @ silent
    rest = np.linalg.lstsq(left, -(plain + every.T @ amounts), rcond=None)[0]
    expected = plain + every.T @ amounts + left @ rest
    found = vector(item, solved(item, compliances=compliances))
    assert np.abs(found - expected).max() < 1e-7 * np.abs(expected).max()


def test_moments_that_close_a_train_are_the_least() -> None:
    text = gears(coupling("g", "a", "b", 2.0), coupling("h", "a", "b", 2.0))
    mechanism = cd.load(text)
    item = case(mechanism, cd.Scene(mechanism, drive="a"), 0.3)
    moments = solved(item).couplings
    assert moments[0] == pytest.approx(moments[1])
    found = SelfStresses.of(item.tree, item.at, item.factors, item.statics)
    assert not found.items
    _, open_ones = found.influence(item.tree, item.at, item.statics.counted)
    assert set(open_ones) == {0, 1}


@pytest.mark.parametrize("name", NAMES)
def test_influence_is_that_of_dense_least_squares(name: str) -> None:
    item = usual_case(name)
    found = SelfStresses.of(item.tree, item.at, item.factors, item.statics)
    wrenches, _ = found.influence(item.tree, item.at, item.statics.counted)
    turned = []
    for of in found.items:
        own = []
        for index in item.statics.counted:
            rotation, force, moment = of.counted(item.tree, item.at, index) or (None, 0, 0)
            if rotation is None:
                own.append(np.zeros(6))
            else:
                scaled = np.array(seen(rotation, force)) * item.tree.norm_length
                own.append(np.array([*scaled, *seen(rotation, moment)]))
        turned.append(np.concatenate(own))
    every = np.array(turned, dtype=float)
    projector = every.T @ np.linalg.pinv(every @ every.T) @ every
    shares = np.diag(projector).reshape(-1, 6)
    for index, share in zip(item.statics.counted, shares, strict=True):
        np.testing.assert_allclose(wrenches.get(index, [0.0] * 6), share, atol=1e-9)
