import itertools
from pathlib import Path

import numpy as np
import pytest
import tomlkit

from cardan_dyn import ArgumentError
from cardan_dyn.drive_lines import (
    Bearing,
    DriveLine,
    DutyPoint,
    Shaft,
    ShaftJoint,
    Spline,
    TitleBlock,
    Tube,
)


def random_line(seed: int) -> DriveLine:
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 9))
    shafts = [
        Shaft(
            name=f'shaft {index} "quoted"' if rng.random() < 0.5 else "",
            length=rng.uniform(0.1, 2),
            slope_side=rng.uniform(-0.4, 0.4),
            slope_plan=rng.uniform(-0.4, 0.4),
            fork_offset=rng.uniform(-9, 9) if 0 < index < count else 0.0,
            tube=Tube(outer_diameter=rng.uniform(0.05, 0.1), wall=rng.uniform(0.001, 0.02)),
            spline=Spline(friction=0.1, radius=rng.uniform(0.01, 0.1))
            if 0 < index < count and rng.random() < 0.5
            else None,
            bearings=[Bearing(distance=rng.uniform(0.01, 0.1), locating=bool(rng.random() < 0.5))],
        )
        for index in range(count + 1)
    ]
    joints = [ShaftJoint(cross_mass=rng.uniform(0, 2), size="0.109") for _ in range(count)]
    duty = [DutyPoint(share=0.5, speed=rng.uniform(0, 400), torque=rng.uniform(0, 900))] * 2
    return DriveLine(shafts=shafts, joints=joints, duty_cycle=duty, speed=rng.uniform(1, 400))


@pytest.mark.parametrize("seed", range(12))
def test_lines_come_back_equal(seed: int) -> None:
    line = random_line(seed)
    assert DriveLine.from_toml(line.to_toml()) == line


def test_points_come_back_equal(tmp_path: Path) -> None:
    points = np.random.default_rng(0).uniform(-1, 1, (4, 3)) + 4.0 * np.arange(4)[:, None]
    line = DriveLine(shafts=[Shaft(start=a, end=b) for a, b in itertools.pairwise(points)])
    text = line.to_toml(tmp_path / "line.toml")
    assert (tmp_path / "line.toml").read_text(encoding="utf-8") == text
    assert DriveLine.from_toml(tmp_path / "line.toml") == line


def test_only_what_was_said_is_written() -> None:
    line = DriveLine(shafts=[Shaft(), Shaft(slope_side=np.radians(5.0))], speed=100.0)
    assert tomlkit.parse(line.to_toml()).unwrap() == {
        "speed_rad_s": 100.0,
        "shafts": [{}, {"slope_side_deg": 5.0}],
    }


def test_files_that_cannot_be_written(tmp_path: Path) -> None:
    line = DriveLine(shafts=[Shaft(), Shaft()])
    with pytest.raises(ArgumentError, match="cannot be written"):
        line.to_toml(tmp_path / "none" / "line.toml")


def test_a_title_block_comes_back_equal() -> None:
    block = TitleBlock(project="Mill 3", customer='"A" & Söhne', revision="B", date="2026-02-28")
    line = DriveLine(shafts=[Shaft(), Shaft()], report=block)
    assert DriveLine.from_toml(line.to_toml()) == line
    plain = line.to_toml().replace('"2026-02-28"', "2026-02-28")  # A date of TOML itself.
    assert plain != line.to_toml() and DriveLine.from_toml(plain) == line


def test_units_of_the_usa_come_back_as_they_were_given() -> None:
    text = """
torque_lbft = 600.0

[[shafts]]
mass_lb = 40.0

[[shafts]]
length_in = 46.0
tube = {outer_diameter_in = 4.0, wall_in = 0.134, shear_limit_ksi = 20.0}

[[shafts.bearings]]
distance_in = 42.0
stiffness_lbf_in = 2500.0

[[shafts]]
"""
    line = DriveLine.from_toml(text)
    assert tomlkit.parse(line.to_toml()).unwrap() == tomlkit.parse(text).unwrap()
    told = str(line.verdict())
    assert "lbf·ft" in told and "N·m" not in told and "mm" not in told
