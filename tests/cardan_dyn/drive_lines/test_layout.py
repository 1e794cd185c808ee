"""Layouts against grids, and against what is known to be best."""

import math

import numpy as np
import pytest
from testkit.line_data import double_shaft, random_line

from cardan_dyn import ArgumentError, ModelError
from cardan_dyn.drive_lines import Bearing, DriveLine, Shaft, Spline


def test_slopes_that_make_a_line_turn_evenly() -> None:
    # Of 0, s and 0.05 the joint angles are equal at s = 0.025.
    found = double_shaft((0.0, 0.2, 0.05)).layout({"shaft_1.slope_side": (0.0, 0.3)})
    assert found.values["shaft_1.slope_side"] == pytest.approx(0.025, abs=1e-7)
    assert found.value == pytest.approx(0.0, abs=1e-4)
    assert found.at_bounds == ()
    assert found.given_value > found.value
    assert found.line.shafts[1].slope_side == found.values["shaft_1.slope_side"]
    assert found.line is found.phasing.line


def test_variables_without_influence_are_named_and_stay() -> None:
    # Angles of joints go by slopes alone, which lengths and bearings do not change.
    line = double_shaft((0.0, 0.2, 0.05))
    bounds = {"shaft_1.length": (0.5, 2.0), "B.distance": (0.01, 0.02)}
    found = line.layout({**bounds, "shaft_1.slope_side": (0.0, 0.3)})
    assert found.idle == ("shaft_1.length", "B.distance")
    assert found.at_bounds == ()
    assert found.values["shaft_1.length"] == line.shafts[1].length
    assert found.values["B.distance"] == 0.02 < line.shafts[0].bearings[-1].distance
    assert found.values["shaft_1.slope_side"] == pytest.approx(0.025, abs=1e-7)
    assert "without influence: shaft_1.length, B.distance" in repr(found)
    assert line.layout({"shaft_1.slope_side": (0.0, 0.3)}).idle == ()


@pytest.mark.slow
def test_a_joint_that_may_be_moved() -> None:
    # Joint 2 where both joint angles are equal: halfway, for shafts that are parallel.
    line = DriveLine(
        shafts=[
            Shaft(start=(-1, 0, 0), end=(0, 0, 0)),
            Shaft(end=(1, 0, 0.2)),
            Shaft(end=(2, 0, 0.5)),
            Shaft(end=(3, 0, 0.5)),
        ]
    )
    found = line.layout({"shaft_1.end_z": (0.0, 0.5)})
    assert found.value == pytest.approx(0.0, abs=1e-6)
    outside = line.layout({"shaft_1.end_z": (-0.5, -0.4)})
    assert outside.at_bounds == ("shaft_1.end_z",)
    assert outside.values["shaft_1.end_z"] == pytest.approx(-0.4)


@pytest.mark.slow
def test_far_bearings_carry_least() -> None:
    # T tan β / a of a Z arrangement falls with the distance of its bearings.
    line = double_shaft((0.0, 0.3, 0.0))
    found = line.layout(
        {"A.distance": (0.15, 0.5), "F.distance": (0.15, 0.6)},
        "bearing_force",
        torque=100.0,
        fixed=["shaft_1"],
    )
    assert "A.distance" in found.at_bounds  # F carries less than A where A is as far as it may be.
    expected = 100.0 * math.tan(0.3) / 0.44
    assert found.value == pytest.approx(expected, rel=1e-6)
    assert found.value < found.given_phased_value
    assert found.given_value == pytest.approx(100.0 * math.tan(0.3) / 0.12, rel=1e-6)


@pytest.mark.slow
def test_a_centre_bearing_against_a_grid() -> None:
    line = random_line(3, seed=1)
    free = {"C1.distance": (0.1, 0.4)}
    found = line.layout(free, "bearing_force", torque=100.0, teeth=12)

    def with_bearing(distance: float) -> DriveLine:
        shaft = line.shafts[1]
        moved = Shaft(
            **{field: getattr(shaft, field) for field in ("length", "slope_side", "slope_plan")},
            fork_offset=shaft.fork_offset,
            spline=shaft.spline,
            bearings=(Bearing(distance=distance),),
        )
        return line.replace(shafts=(line.shafts[0], moved, *line.shafts[2:]))

    grid = [
        with_bearing(distance).phasing("bearing_force", torque=100.0, teeth=12).value
        for distance in np.linspace(0.1, 0.4, 61)
    ]
    assert found.value <= min(grid) * (1 + 1e-4)
    again = with_bearing(found.values["C1.distance"])
    assert found.value == pytest.approx(
        again.phasing("bearing_force", torque=100.0, teeth=12).value, rel=1e-9
    )


@pytest.mark.slow
def test_forks_on_teeth_and_slopes() -> None:
    line = random_line(3, seed=2)
    found = line.layout({"shaft_1.slope_side": (-0.1, 0.1)}, teeth=8)
    slopes = np.linspace(-0.1, 0.1, 201)
    grid = []
    for slope in slopes:
        fields = {"length": 0.8, "slope_plan": line.shafts[1].slope_plan, "slope_side": slope}
        shaft = Shaft(**fields, fork_offset=line.shafts[1].fork_offset, spline=Spline())
        varied = line.replace(shafts=(line.shafts[0], shaft, *line.shafts[2:]))
        grid.append(varied.phasing(teeth=8).value)
    assert found.value <= min(grid) + 1e-6


@pytest.mark.parametrize(
    ("free", "error", "message"),
    [
        ({}, ArgumentError, "expected names of variables with their bounds"),
        ({"shaft_1.width": (0, 1)}, ModelError, "no variable 'shaft_1.width'"),
        ({"shaft_1.length": (1.0, 0.5)}, ArgumentError, "bounds of shaft_1.length: 1 to 0"),
        ({"shaft_1.length": 0.5}, ArgumentError, "bounds of shaft_1.length has shape"),
        ({"shaft_1.end_z": (0, 1)}, ModelError, "no variable 'shaft_1.end_z'"),
    ],
)
def test_what_cannot_vary(free: dict[str, object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        double_shaft((0.0, 0.2, 0.05)).layout(free)  # type: ignore[arg-type]
