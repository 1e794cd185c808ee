"""Placements of joints and wrenches in other axes, against Pinocchio's forward kinematics."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
from testkit.mixed_chain import MIXED, joint, link, rows

import cardan_dyn as cd
from cardan_dyn.core.dynamics.velocity_ratios import VelocityRatios
from cardan_dyn.core.results.axes import turned
from cardan_dyn.core.results.motion import Motion
from cardan_dyn.core.results.wrench import StoredComponents

COUNT = 5
TYPES = ("continuous", "prismatic", "planar", "cylindrical", "spherical", "universal", "floating")
TURNING = ("spherical", "universal", "floating")
SECOND_AXIS = '<axis2 xyz="1 0 0"/></joint>'


def every_type() -> cd.Mechanism:
    """An open chain with a joint of each type, about oblique axes."""
    chain = '<robot name="chain"><link name="base"/>'
    parent = "base"
    for kind in TYPES:
        axis = "0 0.6 0.8" if kind == "universal" else "0.36 0.48 0.8"
        element = joint(kind, kind, parent, f"{kind}_link", "0.3 -0.2 0.5", axis)
        if kind == "universal":
            element = element.replace("</joint>", SECOND_AXIS)
        chain += link(f"{kind}_link", 1.0) + element
        parent = f"{kind}_link"
    return cd.load(chain + "</robot>")


def motion_of(
    mechanism: cd.Mechanism, x: np.ndarray, shape: tuple[int, ...] | None = None
) -> Motion:
    rates = np.zeros((len(x), mechanism.model.nv))
    ratios = VelocityRatios.of(rates[:, :, None])
    return Motion(mechanism, (), x, np.zeros_like(x), (rates, rates, ratios), shape)


def rotations(mechanism: cd.Mechanism, x: np.ndarray, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return Pinocchio's rotations and origins of a joint of the tree in the world."""
    data = mechanism.model.createData()
    placements = []
    for q in mechanism.coordinates.configuration(x):
        pin.forwardKinematics(mechanism.model, data, q)
        placements.append(data.oMi[mechanism.joints[name].id].copy())
    return (
        np.array([placement.rotation for placement in placements]),
        np.array([placement.translation for placement in placements]),
    )


def at_zero(mechanism: cd.Mechanism, x: np.ndarray, name: str) -> np.ndarray:
    """Return coordinates in which one joint is at zero."""
    columns = mechanism.coordinates.columns[name]
    x = x.copy()
    x[:, columns] = mechanism.coordinates.neutral()[columns]
    return x


def swept(motion: Motion) -> SimpleNamespace:
    """Stands for a sweep with this motion."""
    item = SimpleNamespace(mechanism=motion.mechanism, motion=motion, _placements={})
    item.rotation = lambda name: solved_placement(motion, name)[0]
    return item


def solved_placement(motion: Motion, name: str) -> tuple[np.ndarray, np.ndarray]:
    return cd.Sweep._placement(swept(motion), name)  # type: ignore[arg-type]


def random_wrenches() -> tuple[np.ndarray, StoredComponents]:
    values = np.random.default_rng(1).normal(size=(COUNT, 6))
    return values, StoredComponents(values)


def turned_by(
    joint: str, frame: str, components: StoredComponents, motion: Motion
) -> tuple[StoredComponents, np.ndarray]:
    return turned(swept(motion), joint, frame, components)


@pytest.mark.parametrize("name", TYPES)
def test_placements_are_those_of_pinocchio(name: str) -> None:
    mechanism = every_type()
    x = rows(mechanism, COUNT)
    rotation, origin = solved_placement(motion_of(mechanism, x), name)
    expected = rotations(mechanism, x, name)
    np.testing.assert_allclose(rotation, expected[0], atol=1e-14)
    np.testing.assert_allclose(origin, expected[1], atol=1e-14)
    assert not rotation.flags.writeable
    assert not origin.flags.writeable


@pytest.mark.parametrize("name", TYPES)
def test_wrenches_in_world_axes(name: str) -> None:
    mechanism = every_type()
    x = rows(mechanism, COUNT)
    values, components = random_wrenches()
    item, axis = turned_by(name, "world", components, motion_of(mechanism, x))
    rotation = rotations(mechanism, x, name)[0]
    for first in (0, 3):
        expected = np.einsum("nij,nj->ni", rotation, values[:, first : first + 3])
        np.testing.assert_allclose(item.vector(first), expected, atol=1e-14)
    np.testing.assert_allclose(axis, rotation @ mechanism.joints[name].axis, atol=1e-14)


@pytest.mark.parametrize("name", TYPES)
def test_wrenches_in_the_axes_of_the_parent(name: str) -> None:
    """They are those of the joint's frame where its own coordinates are zero."""
    mechanism = every_type()
    x = rows(mechanism, COUNT)
    values, components = random_wrenches()
    item, axis = turned_by(name, "parent", components, motion_of(mechanism, x))
    fixed = rotations(mechanism, at_zero(mechanism, x, name), name)[0]
    relative = np.swapaxes(fixed, 1, 2) @ rotations(mechanism, x, name)[0]
    for first in (0, 3):
        expected = np.einsum("nij,nj->ni", relative, values[:, first : first + 3])
        np.testing.assert_allclose(item.vector(first), expected, atol=1e-14)
    along = np.broadcast_to(axis, (COUNT, 3))
    np.testing.assert_allclose(along, relative @ mechanism.joints[name].axis, atol=1e-14)
    # One axis serves all samples unless it turns relative to the parent.
    assert axis.ndim == (2 if name in TURNING else 1)


@pytest.mark.parametrize("name", ["ball", "cross"])
def test_loops_have_axes_of_their_predecessor(name: str) -> None:
    mechanism = cd.load(MIXED)
    x = rows(mechanism, COUNT)
    values, components = random_wrenches()
    motion = motion_of(mechanism, x)
    item, axis = turned_by(name, "parent", components, motion)
    fixed = rotations(mechanism, at_zero(mechanism, x, name), name)[0]
    relative = np.swapaxes(fixed, 1, 2) @ rotations(mechanism, x, name)[0]
    expected = np.einsum("nij,nj->ni", relative, values[:, 3:])
    np.testing.assert_allclose(item.vector(3), expected, atol=1e-14)
    np.testing.assert_allclose(axis, relative @ mechanism.joints[name].axis, atol=1e-14)


def test_the_axes_of_a_fixed_loop_are_those_of_its_parent() -> None:
    mechanism = cd.load(MIXED)
    motion = motion_of(mechanism, rows(mechanism, COUNT))
    values, components = random_wrenches()
    item, axis = turned_by("bolt", "parent", components, motion)
    np.testing.assert_array_equal(item.values, values)
    np.testing.assert_array_equal(axis, mechanism.joints["bolt"].axis)
    in_world, _ = turned_by("bolt", "world", components, motion)
    rotation = solved_placement(motion, "bolt")[0]
    expected = np.einsum("nij,nj->ni", rotation, values[:, :3])
    np.testing.assert_allclose(in_world.vector(0), expected, atol=1e-15)


@pytest.mark.parametrize("frame", ["parent", "world"])
@pytest.mark.parametrize("name", TYPES)
def test_wrenches_of_a_grid_are_turned_as_those_in_a_row(name: str, frame: str) -> None:
    mechanism = every_type()
    x = rows(mechanism, 6)
    values = np.random.default_rng(1).normal(size=(6, 6))
    row, row_axis = turned_by(name, frame, StoredComponents(values), motion_of(mechanism, x))
    components = StoredComponents(values.reshape(2, 3, 6))
    grid, axis = turned_by(name, frame, components, motion_of(mechanism, x, (2, 3)))
    for first in (0, 3):
        vectors = grid.vector(first)
        assert vectors.shape == (2, 3, 3)
        np.testing.assert_allclose(vectors.reshape(6, 3), row.vector(first), atol=1e-15)
    assert axis.shape == ((3,) if row_axis.ndim == 1 else (2, 3, 3))
    np.testing.assert_allclose(axis.reshape(row_axis.shape), row_axis, atol=1e-15)


@pytest.mark.parametrize("column", ["continuous", "planar"])
def test_motions_that_were_not_solved_have_no_placement(column: str) -> None:
    mechanism = every_type()
    x = rows(mechanism, COUNT)
    x[2, mechanism.coordinates.columns[column]] = np.nan
    motion = motion_of(mechanism, x)
    with pytest.raises(cd.ModelError, match="leave out joint 'planar'; name it among the outputs"):
        solved_placement(motion, "planar")
    with pytest.raises(cd.ModelError, match="no joint 'lever'"):
        solved_placement(motion, "lever")
