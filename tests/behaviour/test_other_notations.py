"""The same mechanism in the notations of several programs has the same wrenches, and is proven."""

from __future__ import annotations

import copy
import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from testkit.linkages import POSITIONS, RATES
from testkit.other_notations import (
    CLOSURES,
    CONSTRAINT,
    PINS,
    PLUS,
    TREE,
    closing_frames,
    written,
)
from testkit.scenes import relative

import cardan_dyn as cd
from cardan_dyn.core.description.second_reading import reread

NOTATIONS = ("constraint", "closures", "pins", "closing frames")


def load(notation: str, folder: Path) -> cd.Mechanism:
    """Return the four-bar, written in a notation."""
    if notation == "constraint":
        return cd.load(TREE.format(CONSTRAINT.format(kind="revolute_joint", more="")))
    if notation == "closures":
        return cd.load(written(folder, CLOSURES))
    if notation == "pins":
        return cd.load(written(folder, PINS, inside="."))
    return cd.load(TREE.format(closing_frames()))


def sweep(mechanism: cd.Mechanism) -> cd.Sweep:
    scene = cd.Scene(mechanism, drive="a", loads={"d": 5.0}, gravity=(0.0, -9.81, 0.0))
    return scene.sweep(POSITIONS, **RATES)


@pytest.mark.parametrize("notation", NOTATIONS)
def test_wrenches_are_those_of_the_loop_in_urdf_plus(notation: str, tmp_path: Path) -> None:
    mechanism = load(notation, tmp_path)
    (loop,) = mechanism.loops
    assert mechanism.joints[loop.joint].type == "revolute"
    found, expected = sweep(mechanism), sweep(cd.load(PLUS))
    names = {"a": "a", "b": "b", "d": "d", loop.joint: "c"}
    # The masses of frames are 1e-9 kg, those of the bars some kilograms.
    tolerance = 1e-8 if notation == "closing frames" else 1e-11
    for name, reference in names.items():
        assert (
            relative(found.wrench(name, "world").force, expected.wrench(reference, "world").force)
            < tolerance
        )
    assert relative(found.drive_effort, expected.drive_effort) < tolerance
    assert max(found.loop_residual, found.balance_residual, found.power_residual) < 1e-11


def test_balls_are_those_of_urdf_plus(tmp_path: Path) -> None:
    """The coupler ends in a ball, and its joint with the crank, a hinge of the URDF, is another."""
    yaml = PINS.replace("pin_loops", "ball_loops").replace("    axis: [0.0, 0.0, 2.0]\n", "")
    found = cd.load(written(tmp_path, yaml.replace("upgrades: []", "upgrades: [b]"), inside="."))
    plus = PLUS.replace('name="c" type="revolute"', 'name="c" type="spherical"')
    plus = plus.replace('name="b" type="continuous"', 'name="b" type="spherical"')
    first, second = sweep(found), sweep(cd.load(plus))
    assert relative(first.drive_effort, second.drive_effort) < 1e-11
    assert relative(first["knee"].force, second["c"].force) < 1e-11
    assert found.independent_joints == ("a",)
    assert first.balance_residual < 1e-11


@pytest.mark.parametrize("notation", NOTATIONS)
def test_they_can_be_written_copied_and_pickled(notation: str, tmp_path: Path) -> None:
    mechanism = load(notation, tmp_path)
    again = cd.load(mechanism.to_urdf())
    assert again.description.agrees(mechanism.description, 1e-15)
    for twin in (copy.deepcopy(mechanism), pickle.loads(pickle.dumps(mechanism))):
        assert twin.description == mechanism.description
        # The proof reads the text of the file again, wherever the file is by now.
        assert reread(twin.description).agrees(reread(mechanism.description))
        assert sweep(twin).balance_residual < 1e-11


@pytest.mark.parametrize("notation", ["constraint", "closures", "pins"])
@pytest.mark.parametrize("field", ["predecessor_origin", "successor_origin"])
def test_the_proof_reads_the_places_of_loops_by_itself(
    notation: str, field: str, tmp_path: Path
) -> None:
    """The first reader was wrong by little: the second one sees it in the text."""
    mechanism = load(notation, tmp_path)
    (loop,) = mechanism.description.loops
    moved = getattr(loop, field).copy()
    moved[0, 3] += 1e-5
    wrong = replace(mechanism.description, loops=(replace(loop, **{field: moved}),))
    with pytest.raises(cd.AccuracyError):
        sweep(cd.Mechanism(wrong))


def test_drives_come_from_the_file(tmp_path: Path) -> None:
    assert load("closures", tmp_path).independent_joints == ("a",)
    mechanism = load("pins", tmp_path)
    assert mechanism.independent_joints == ("a",)
    assert mechanism.notation == "loop_closures.yaml"
    np.testing.assert_array_equal(reread(mechanism.description).loops[0].axis, [0.0, 0.0, 1.0])
