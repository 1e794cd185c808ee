"""Verdicts on random lines, recomputed by a program of its own."""

from __future__ import annotations

import pytest
import verdicts

from cardan_dyn.drive_lines import DriveLine, examples


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 2])  # The first has joints of constant velocity.
def test_what_fails_a_line_is_what_its_forces_and_limits_say(seed: int) -> None:
    line, worst = verdicts.draw(seed)
    own = verdicts.judged(line, worst)
    assert list(verdicts.differences(line, own, worst)) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", examples())
def test_lines_of_the_package_by_hand(name: str) -> None:
    line = DriveLine.from_toml(name)
    worst = verdicts.worst_forces(line)
    own = verdicts.judged(line, worst)
    assert own.failed == set()
    assert list(verdicts.differences(line, own, worst)) == []
