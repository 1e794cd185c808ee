"""The methods of a line lead to the functions behind them."""

import numpy as np
from testkit.line_data import random_line

from cardan_dyn.drive_lines import DriveLine
from cardan_dyn.drive_lines.layout import layout
from cardan_dyn.drive_lines.phasing import phasing


def test_phasing_and_layout() -> None:
    line = random_line(3, seed=4)
    for options in ({"teeth": 12}, {"fixed": ["shaft_1"]}, {"shafts": [2, 3], "count": 2}):
        method, function = line.phasing(**options), phasing(line, **options)
        assert isinstance(method.line, DriveLine)
        assert np.array_equal(method.fork_offsets, function.fork_offsets)
        assert method.value == function.value
    forces = {"objective": "bearing_force", "torque": 10.0, "bearings": ["E"], "teeth": 8}
    assert line.phasing(**forces).value == phasing(line, **forces).value
    free = {"shaft_1.slope_side": (0.0, 0.1)}
    assert line.layout(free, teeth=8).value == layout(line, free, teeth=8).value
