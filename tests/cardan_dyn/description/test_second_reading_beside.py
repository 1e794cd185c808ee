"""The proof reads `loop_closures.yaml` once more, by code of its own."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from testkit.other_notations import CLOSURES, PINS, TREE, written

import cardan_dyn as cd
from cardan_dyn.core.description.read import read
from cardan_dyn.core.description.second_reading import reread_beside

TURNED = TREE.format("").replace('<origin xyz="2 0 0"/>', '<origin xyz="2 0 0" rpy="0.3 0.2 0.1"/>')
BALLS = PINS.replace("pin_loops", "ball_loops").replace("    axis: [0.0, 0.0, 2.0]\n", "")


@pytest.mark.parametrize(
    ("yaml", "urdf"), [(CLOSURES, TURNED), (CLOSURES, None), (PINS, None), (BALLS, TURNED)]
)
def test_numbers_come_from_the_text(yaml: str, urdf: str | None, tmp_path: Path) -> None:
    """It starts from loops whose numbers are all wrong."""
    description = read(written(tmp_path, yaml, urdf))
    (loop,) = description.loops
    wrong = np.full((4, 4), 7.0)
    axis = loop.axis if yaml is BALLS else np.full(3, 7.0)
    disturbed = replace(
        loop, predecessor_origin=wrong, successor_origin=wrong, axis=axis, axis_2=axis
    )
    found = reread_beside([disturbed], description.joints, yaml)
    assert found.keys() == {loop.name}
    assert found[loop.name].agrees(loop, 1e-15)


def test_loops_that_the_second_reading_misses_are_no_proof(tmp_path: Path) -> None:
    description = read(written(tmp_path, CLOSURES))
    other = replace(description.loops[0], name="other")
    with pytest.raises(cd.ModelError, match="loop 'other' is not found by the second reading"):
        reread_beside([other], description.joints, CLOSURES)
    assert reread_beside([other], description.joints, "closed_loop: [[a, b]]") == {}


@pytest.mark.parametrize("name", ['name: "", ', "name: null, ", ""])
def test_loops_without_a_name_are_found_again(name: str, tmp_path: Path) -> None:
    text = CLOSURES.replace("{link_a", f"{{{name}link_a")
    description = read(written(tmp_path, text))
    (loop,) = description.loops
    disturbed = replace(loop, predecessor_origin=np.full((4, 4), 7.0))
    found = reread_beside([disturbed], description.joints, text)
    assert found[loop.name].agrees(loop, 1e-15)
