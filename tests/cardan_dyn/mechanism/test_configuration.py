"""Configurations against Pinocchio's placements."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pinocchio
import pytest
from testkit import compound_joints as parts
from testkit.mixed_chain import MIXED, rows

import cardan_dyn as cd


def configuration() -> cd.Configuration:
    mechanism = cd.load(MIXED)
    return cd.Configuration(mechanism, rows(mechanism, 1)[0], 0.25, 0.5, "B")


def test_joints_are_where_pinocchio_places_them() -> None:
    item = configuration()
    mechanism = item.mechanism
    data = mechanism.model.createData()
    pinocchio.forwardKinematics(mechanism.model, data, item.q)
    for name, joint in mechanism.joints.items():
        if joint.parts:
            np.testing.assert_allclose(
                item.origin(name), data.oMi[joint.id].translation, atol=1e-14
            )
            np.testing.assert_allclose(item.rotation(name), data.oMi[joint.id].rotation, atol=1e-14)
    with pytest.raises(cd.ModelError, match="no joint 'lever'"):
        item.origin("lever")


def test_positions_are_the_coordinates() -> None:
    item = configuration()
    columns = item.mechanism.coordinates.columns
    assert set(item.positions) == set(columns)
    for name, value in item.positions.items():
        np.testing.assert_array_equal(value, np.squeeze(item.x[columns[name]]))
    assert isinstance(item.positions["turn"], float)
    assert item.positions["ball"].shape == (4,)


def test_it_shows_itself() -> None:
    item = configuration()
    assert repr(item) == (
        "<Configuration of 'mixed' in branch B: closed to 2.5e-01 (at zero 5.0e-01)>"
    )
    first, *lines = str(item).splitlines()
    assert first == repr(item)[1:-1]
    assert len(lines) == len(item.positions)
    assert lines[0].split() == ["turn", f"{item.positions['turn']:.6g}"]


@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda item: pickle.loads(pickle.dumps(item))]
)
def test_it_cannot_be_changed_and_can_be_copied(copied: object) -> None:
    item = configuration()
    again = copied(item)  # type: ignore[operator]
    np.testing.assert_array_equal(again.x, item.x)
    assert (again.loop_residual, again.zero_residual, again.branch) == (0.25, 0.5, "B")
    for same in (item, again):
        with pytest.raises(ValueError, match="read-only"):
            same.x[0] = 1.0
        with pytest.raises(ValueError, match="read-only"):
            same.positions["ball"][0] = 1.0
        with pytest.raises(cd.ImmutableError):
            same.branch = "A"


def test_it_is_a_mapping_of_positions() -> None:
    item = configuration()
    assert list(item) == list(item.keys()) == list(item.positions)
    assert len(item) == len(item.positions) == len(item.items())
    for name, value in item.items():
        assert name in item
        np.testing.assert_array_equal(item[name], value)
        np.testing.assert_array_equal(item.get(name), item.positions[name])
    assert "lever" not in item and item.get("lever") is None
    with pytest.raises(cd.ModelError, match="no joint 'lever'"):
        item["lever"]
    assert item == item and item != configuration() and len({item, item}) == 1


def test_fixed_loops_have_no_position() -> None:
    ends = "ground a"
    hinge = parts.joint("hinge", "revolute", ends, "", (parts.Y,))
    bolt = parts.loop("bolt", "fixed", ends)
    mechanism = cd.load(parts.robot(parts.body("a", 1.0), hinge, bolt))
    item = cd.Configuration(mechanism, mechanism.zero, 0.0, 0.0)
    assert list(item) == ["hinge"] and "bolt" not in item
    with pytest.raises(cd.ModelError, match="joint 'bolt' is fixed, it has no position; joints"):
        item["bolt"]
