"""The proof reads `loop_closures.yaml` once more, by code of its own."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from testkit.other_notations import CLOSURES, PINS, TREE, written

from cardan_dyn.description.read import read
from cardan_dyn.description.second_reading_beside import reread_beside

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


def test_loops_that_the_file_does_not_state_are_left_alone(tmp_path: Path) -> None:
    description = read(written(tmp_path, CLOSURES))
    other = replace(description.loops[0], name="other")
    assert reread_beside([other], description.joints, CLOSURES) == {}
    assert reread_beside([other], description.joints, "closed_loop: [[a, b]]") == {}
