"""The model of a description: joints, names, order and inertias."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from testkit.mixed_chain import MIXED, joint, link

import cardan_dyn as cd
from cardan_dyn.core.mechanism.tree import TreeBuilder, ancestors, se3


def test_parts_are_joints_of_the_model_and_the_last_has_the_name() -> None:
    mechanism = cd.load(MIXED)
    tree = TreeBuilder(mechanism.description)
    # Depth first, the joints on a link in the order of their names, then its loops.
    names = ["turn", "hinge", "cross:1", "cross", "slide", "swing", "ball"]
    assert list(tree.model.names)[1:] == names
    assert [part.kind for part in tree.parts["cross"]] == ["revolute", "revolute"]
    assert tree.parts["bolt"] == []
    assert {part.id for parts in tree.parts.values() for part in parts} == set(range(1, 8))


def test_joints_of_a_subtree_follow_each_other() -> None:
    for name in ("stewart_platform", "thoma_rig", "drive_line"):
        model = cd.load(name).model
        for index in range(1, model.njoints):
            assert list(model.subtrees[index]) == list(
                range(index, index + len(model.subtrees[index]))
            )


def test_the_parts_of_a_split_body_have_its_inertia_together() -> None:
    mechanism = cd.load(MIXED)
    whole = mechanism.model.inertias[mechanism["hinge"].id]
    share = mechanism.model.inertias[mechanism["ball"].id]
    loop = mechanism.loops[0]
    at_successor = loop.successor_placement.act(share)
    assert whole.mass == pytest.approx(1.5) and share.mass == pytest.approx(1.5)
    np.testing.assert_allclose(at_successor.lever, whole.lever, atol=1e-14)
    np.testing.assert_allclose(at_successor.inertia, whole.inertia, atol=1e-14)
    np.testing.assert_allclose(2.0 * whole.inertia[0], [3.0, 0.1, 0.0], atol=1e-14)


def test_links_at_fixed_joints_join_one_body() -> None:
    text = (
        '<robot name="joined"><link name="base"/>'
        + link("arm", 2.0)
        + joint("turn", "continuous", "base", "arm", "0 0 0", "0 0 1")
        + link("tool", 6.0)
        + '<joint name="bolt" type="fixed"><parent link="arm"/><child link="tool"/>'
        '<origin xyz="4 0 0"/></joint></robot>'
    )
    tree = TreeBuilder(cd.load(text).description)
    (body, placement) = tree.links["tool"]
    assert body == tree.links["arm"][0] == 1
    np.testing.assert_allclose(placement.translation, [4.0, 0.0, 0.0])
    inertia = tree.model.inertias[1]
    assert inertia.mass == pytest.approx(8.0)
    # Centres at (0.1, -0.2, 0.1) and (4.1, -0.2, 0.3).
    np.testing.assert_allclose(inertia.lever, [3.1, -0.2, 0.25], rtol=1e-14)


def test_oblique_axes_of_joints_that_turn_without_end() -> None:
    """A turn by an angle about the axis, as the exponential map gives it."""
    model = cd.load(MIXED).model
    q = pinocchio.neutral(model)
    start = model.idx_qs[1]
    q[start : start + 2] = np.cos(0.7), np.sin(0.7)
    data = model.createData()
    pinocchio.forwardKinematics(model, data, q)
    turn = pinocchio.exp3(0.7 * np.array([0.36, 0.48, 0.8]))
    expected = model.jointPlacements[1].rotation @ turn
    np.testing.assert_allclose(data.oMi[1].rotation, expected, atol=1e-14)


def test_ancestors_lead_from_the_root() -> None:
    model = cd.load(MIXED).model
    assert ancestors(model, 0) == []
    assert ancestors(model, model.getJointId("ball")) == [0, 4, 5, 6]
    assert ancestors(model, model.getJointId("hinge")) == [0, 1]


def test_se3_keeps_the_matrix() -> None:
    matrix = pinocchio.SE3.Random().homogeneous
    np.testing.assert_array_equal(se3(matrix).homogeneous, matrix)
