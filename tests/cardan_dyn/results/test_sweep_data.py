"""Sweeps as mappings of their outputs, with wrenches in three frames, inputs and errors."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable

import numpy as np
import pytest
from testkit.drive_lines import two_lines
from testkit.scenes import text, universal

import cardan_dyn as cd

POSITIONS = np.linspace(0.1, 6.0, 40)
COPIES: dict[str, Callable[[cd.Sweep], cd.Sweep]] = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "pickle": lambda item: pickle.loads(pickle.dumps(item)),
}


@pytest.fixture(scope="module")
def turn(joint: cd.Mechanism) -> cd.Sweep:
    force = np.outer(POSITIONS, [1.0, 2.0, 3.0])
    return cd.Scene(
        joint,
        drive="bearing_in",
        held={"joint_angle": 0.5},
        loads={"bearing_out": -2.0, "shaft_out": cd.Wrench(force=force, frame="world")},
        gravity=(0.0, 0.0, -9.81),
        outputs=["pin_in", "bearing_out", "bearing_in"],
    ).sweep(POSITIONS, speed=3.0, acceleration=np.sin(POSITIONS))


def test_sweeps_are_mappings_of_their_outputs() -> None:
    turn = universal(cd.load(text("universal_joint")), 0.5, outputs=["bearing_out"]).sweep(
        POSITIONS
    )
    assert "bearing_out" in turn
    assert "pin_in" not in turn
    assert list(turn) == list(turn.keys()) == ["bearing_out"]
    assert {name: wrench.joint for name, wrench in turn.items()} == {"bearing_out": "bearing_out"}
    assert len(turn) == len(POSITIONS)


def test_outputs_keep_the_order_in_which_they_were_named(turn: cd.Sweep) -> None:
    names = ["pin_in", "bearing_out", "bearing_in"]
    assert list(turn) == [wrench.joint for wrench in turn.values()] == names
    assert [wrench.joint for _, wrench in turn.items()] == names
    for name, wrench in turn.items():
        np.testing.assert_array_equal(wrench.force, turn[name].force)
        np.testing.assert_array_equal(wrench.unique, turn.unique[names.index(name)])
    assert 3 not in turn
    assert None not in turn


def test_a_sweep_knows_what_was_given(turn: cd.Sweep) -> None:
    np.testing.assert_array_equal(turn.position, POSITIONS)
    np.testing.assert_array_equal(turn.speed, np.full(40, 3.0))
    np.testing.assert_array_equal(turn.acceleration, np.sin(POSITIONS))
    np.testing.assert_array_equal(turn.gravity, [0.0, 0.0, -9.81])
    assert turn.shape == (40,)
    assert list(turn.loads) == ["bearing_out", "shaft_out"]
    assert turn.loads["bearing_out"] == -2.0
    load = turn.loads["shaft_out"]
    assert load.frame == "world"
    np.testing.assert_array_equal(load.force, np.outer(POSITIONS, [1.0, 2.0, 3.0]))
    np.testing.assert_array_equal(load.moment, [0.0, 0.0, 0.0])
    with pytest.raises(cd.ImmutableError):
        turn.loads["bearing_out"] = 0.0


def test_wrenches_in_three_frames_are_turned_into_each_other(turn: cd.Sweep) -> None:
    for name in turn:
        joint, world = turn.wrench(name), turn.wrench(name, "world")
        parent = turn.wrench(name, "parent")
        assert (joint.frame, parent.frame, world.frame) == ("joint", "parent", "world")
        rotation = turn.rotation(name)
        np.testing.assert_allclose(
            np.einsum("nji,nj->ni", rotation, world.moment), joint.moment, atol=1e-12
        )
        for quantity in ("torsion", "bending", "axial", "shear"):
            expected = getattr(joint, quantity)
            for wrench in (parent, world):
                np.testing.assert_allclose(getattr(wrench, quantity), expected, atol=1e-11)
    # The bearing's parent is the base, whose axes are those of the world.
    fixed = turn.wrench("bearing_in", "parent").force
    np.testing.assert_allclose(fixed, turn.wrench("bearing_in", "world").force, atol=1e-12)


def test_rotations_are_orthogonal_and_origins_lie_on_the_cross(turn: cd.Sweep) -> None:
    rotation = turn.rotation("pin_in")
    assert rotation.shape == (40, 3, 3)
    products = rotation @ np.swapaxes(rotation, 1, 2)
    np.testing.assert_allclose(products, np.broadcast_to(np.eye(3), products.shape), atol=1e-15)
    np.testing.assert_allclose(np.linalg.det(rotation), 1.0, rtol=1e-14)
    # Both pins pass through the centre of the cross.
    np.testing.assert_allclose(turn.origin("pin_in"), turn.origin("pin_out"), atol=1e-15)
    assert turn.rotation("pin_in") is rotation


def test_unknown_names_are_refused(turn: cd.Sweep) -> None:
    with pytest.raises(cd.ModelError, match="no joint 'lever'; joints: bearing_in"):
        turn["lever"]
    with pytest.raises(cd.ModelError, match="no joint"):
        turn[3]  # type: ignore[index]
    with pytest.raises(
        cd.ModelError,
        match=r"wrench of 'pin_out' was not asked for; .* are: bearing_in, bearing_out, pin_in",
    ):
        turn["pin_out"]
    for frame in ("link", "", None, 3):
        with pytest.raises(cd.ArgumentError, match="is unknown; frames: joint, parent, world"):
            turn.wrench("pin_in", frame)  # type: ignore[arg-type]
    for method in (turn.rotation, turn.origin):
        with pytest.raises(cd.ModelError, match="no joint 'lever'"):
            method("lever")


def test_a_drive_effort_that_was_left_out_is_refused() -> None:
    lines = cd.load(two_lines(2))
    turn = cd.Scene(lines, drive="bearing_0", outputs=["left_2"]).sweep([0.0])
    with pytest.raises(cd.ModelError, match=r"add the driven joint to the outputs, .*: left_2"):
        _ = turn.drive_effort
    with pytest.raises(cd.ModelError, match="the outputs of the scene leave out joint 'right_2'"):
        turn.rotation("right_2")


def test_its_text_tells_samples_and_residuals(turn: cd.Sweep) -> None:
    assert repr(turn) == (
        "<Sweep of 'universal_joint': 40 samples, bearing_in 0.1 to 6 rad, residuals: "
        f"loop {turn.loop_residual:.1e}, "
        f"balance {turn.balance_residual:.1e}, power {turn.power_residual:.1e}; not determined by "
        "statics, chosen by least norm: pin_in, bearing_out, bearing_in>"
    )
    assert "not unique: force" in repr(turn["pin_in"])


def test_its_text_shows_that_degrees_were_meant(turn: cd.Sweep) -> None:
    scene = cd.Scene(turn.mechanism, drive="bearing_in", held={"joint_angle": 0.3})
    assert "3 samples, bearing_in 0 to 360 rad (57.3 turns), " in repr(scene.sweep([0, 180, 360]))
    assert "1 samples, nothing acts" in repr(scene.sweep(0.3))


@pytest.mark.parametrize("made", COPIES)
def test_copies_are_equal_and_as_closed_to_writing(turn: cd.Sweep, made: str) -> None:
    again = COPIES[made](turn)
    assert type(again) is cd.Sweep
    assert list(again) == list(turn)
    for name in turn:
        np.testing.assert_array_equal(again[name].force, turn[name].force)
        np.testing.assert_array_equal(again[name].unique, turn[name].unique)
    for name in ("position", "speed", "acceleration", "drive_effort", "condition", "gravity"):
        np.testing.assert_array_equal(getattr(again, name), getattr(turn, name))
        assert not getattr(again, name).flags.writeable
    for name in ("loop_residual", "balance_residual", "power_residual", "rate_residual"):
        assert getattr(again, name) == getattr(turn, name)
    assert again.unproven == turn.unproven
    with pytest.raises(cd.ImmutableError, match="loop_residual of a Sweep cannot be changed"):
        again.loop_residual = 0.0


def test_a_grid_of_a_response_has_the_shape_of_its_operating_points(joint: cd.Mechanism) -> None:
    response = universal(joint, 0.5, outputs=["bearing_out"]).response()
    grid = response.sweep(np.linspace(0.0, 6.0, 7), speed=np.array([[0.0], [1.0]]))
    assert grid.shape == (2, 7)
    assert grid.drive_effort.shape == grid["bearing_out"].torsion.shape == (2, 7)
    assert grid["bearing_out"].force.shape == (2, 7, 3)
    # Forces and moments of all samples are turned, their sizes along the axis are not.
    moments = grid["bearing_out"].moment
    turned = np.einsum("...ij,...j->...i", grid.rotation("bearing_out"), moments)
    np.testing.assert_allclose(grid.wrench("bearing_out", "world").moment, turned, atol=1e-12)
    for frame in ("parent", "world"):
        wrench = grid.wrench("bearing_out", frame)
        assert wrench.force.shape == (2, 7, 3)
        assert f"in {frame} axes" in repr(wrench) and "not unique" in repr(wrench)
        np.testing.assert_allclose(wrench.torsion, grid["bearing_out"].torsion, atol=1e-11)


def test_every_output_has_its_row_of_flags(turn: cd.Sweep) -> None:
    _, (kind, values, _) = turn.__reduce__()
    flags = np.arange(18).reshape(3, 6) % 4 == 0
    changed = kind(**{**values, "unique": flags})
    for row, name in zip(flags, turn, strict=True):
        np.testing.assert_array_equal(changed[name].unique, row)
