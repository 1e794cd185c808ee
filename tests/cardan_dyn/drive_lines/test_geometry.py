"""Geometry against the catalogue, the formulas from projections, and rotations of all shafts."""

import itertools
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cardan_dyn import ModelError
from cardan_dyn.analytic import compound_angle
from cardan_dyn.drive_lines import Shaft
from cardan_dyn.kit.arrays import Array
from cardan_dyn.practice.drive_lines.line.geometry import Geometry, geometry


def line(*slopes: tuple[float, float], offsets: tuple[float, ...] = ()) -> list[Shaft]:
    """Shafts of 0.9 m with slopes in side and plan view [deg]."""
    forks = [0.0, *offsets, *[0.0] * (len(slopes) - 1 - len(offsets))]
    return [
        Shaft(length=0.9, slope_side=math.radians(v), slope_plan=math.radians(h), fork_offset=fork)
        for (v, h), fork in zip(slopes, forks, strict=True)
    ]


def compound_directions(found: Geometry) -> Array:
    """Bending planes at both ends of each intermediate shaft, `(n - 1, 2)` [rad].

    atan2(horizontal, vertical) of the bend seen along the shaft, from up to the left, as the
    catalogue counts them (chapter 6.3). Forks of a shaft stand in their planes together if its fork
    offset is that of the front minus that of the rear joint, up to half turns.
    """
    result = []
    for before, axis, behind in zip(*(found.directions[k:] for k in range(3)), strict=False):
        left = np.cross([0.0, 0.0, 1.0], axis)
        left /= np.linalg.norm(left)
        up = np.cross(axis, left)
        result.append([math.atan2(bend @ left, bend @ up) for bend in (-before, behind)])
    return np.array(result)


def test_the_catalogues_example() -> None:
    # Bild 19: bends of +15° and -11.5° in the side view, +7° and +12° in the plan view.
    found = geometry(line((-15, -7), (0, 0), (-11.5, 12)))
    assert np.degrees(found.joint_angles) == pytest.approx([16.4225, 16.3956], abs=5e-5)
    planes = compound_angle.bending_plane(*np.radians([[7, 12], [15, -11.5]]))
    assert np.degrees(compound_directions(found)[0]) == pytest.approx(np.degrees(planes), abs=1e-12)
    assert math.degrees(found.plane_offsets[1]) % 180 == pytest.approx(70.873, abs=5e-4)
    assert np.degrees(found.views) == pytest.approx(np.array([[7, 15], [12, -11.5]]), abs=1e-12)


def test_z_and_w_arrangements_are_exact() -> None:
    z = geometry(line((0, 0), (10, 0), (0, 0)))
    w = geometry(line((0, 0), (10, 0), (20, 0)))
    assert abs(z.plane_offsets[1]) == math.pi
    assert w.plane_offsets[1] == 0.0
    assert z.joint_angles == pytest.approx([math.radians(10)] * 2, rel=1e-15)


@pytest.mark.parametrize("beta", [0.0, 1e-9, 80.0, 89.999])
def test_extreme_joint_angles(beta: float) -> None:
    found = geometry(line((0, 0), (beta, 0)))
    assert found.joint_angles[0] == pytest.approx(math.radians(beta), rel=1e-9, abs=1e-24)


def test_collinear_shafts_have_no_planes() -> None:
    found = geometry(line(*[(13.7, -8.1)] * 5))
    assert not found.joint_angles.any()
    assert not found.plane_offsets.any()
    assert np.degrees(found.fork_phases) == pytest.approx([0, 90, 180, 270])
    points = np.linspace([0.1, 0.2, 0.3], [2.3, 4.2, -3.1], 6)
    along = geometry([Shaft(start=a, end=b) for a, b in itertools.pairwise(points)])
    assert not along.joint_angles.any()


def test_a_straight_joint_keeps_the_plane_before_it() -> None:
    found = geometry(line((0, 0), (5, 5), (5, 5), (1, 9)))
    without = geometry(line((0, 0), (5, 5), (1, 9)))
    assert found.joint_angles[1] == 0.0
    assert found.plane_offsets[2] == pytest.approx(without.plane_offsets[1], abs=1e-14)


def test_frames_are_chains_of_bends() -> None:
    rng = np.random.default_rng(1)
    found = geometry(line(*rng.uniform(-40, 40, (9, 2))))
    frame = found.frames[0]
    assert frame[2, 1] == 0.0  # y is horizontal
    for k in range(8):
        bend = Rotation.from_euler("XZ", [found.plane_offsets[k], found.joint_angles[k]])
        frame = frame @ bend.as_matrix()
        assert found.frames[k + 1] == pytest.approx(frame, abs=1e-14)
        assert found.frames[k + 1][:, 0] == pytest.approx(found.directions[k + 1], abs=1e-15)


def test_fork_offsets_from_the_compound_directions() -> None:
    rng = np.random.default_rng(2)
    slopes = rng.uniform(-30, 30, (7, 2))
    p = compound_directions(geometry(line(*slopes)))
    found = geometry(line(*slopes, offsets=tuple(p[:, 0] - p[:, 1])))
    steps = np.diff(found.fork_phases)
    assert np.mod(steps, math.pi) == pytest.approx(np.full(5, math.pi / 2), abs=1e-13)


def test_nothing_depends_on_where_the_line_lies() -> None:
    rng = np.random.default_rng(3)
    slopes = rng.uniform(-30, 30, (5, 2))
    found = geometry(line(*slopes))
    ends = np.cumsum(0.9 * found.directions, axis=0)
    turn = Rotation.from_euler("xyz", [0.1, 0.2, 0.3]).as_matrix()
    points = np.concatenate([np.zeros((1, 3)), ends]) @ turn.T + [1, 2, 3]
    moved = geometry([Shaft(start=a, end=b) for a, b in itertools.pairwise(points)])
    assert moved.joint_angles == pytest.approx(found.joint_angles, abs=1e-14)
    assert moved.plane_offsets[1:] == pytest.approx(found.plane_offsets[1:], abs=1e-13)
    assert moved.centres == pytest.approx(points[1:-1], abs=1e-14)
    assert found.centres[0] == pytest.approx(np.zeros(3))


def test_points_and_slopes_in_one_line() -> None:
    shafts = [
        Shaft(slope_side=0.1),
        Shaft(start=(0.3, 0, 0), end=(0.8, 0.1, 0.05)),
        Shaft(end=(1.3, 0, 0)),
        Shaft(length=0.4, slope_plan=0.2),
        Shaft(start=(1.3 + 0.4 * math.cos(0.2), 0.4 * math.sin(0.2), 0), end=(9, 0.3, 0)),
    ]
    found = geometry(shafts)
    assert found.centres[0] == pytest.approx([0.3, 0, 0], abs=1e-15)
    assert found.centres[3] == pytest.approx(shafts[4].start, abs=1e-15)
    assert math.isnan(found.lengths[0])


def test_a_vertical_line_and_one_that_runs_back() -> None:
    found = geometry([Shaft(start=(0, 0, 0), end=(0, 0, 1)), Shaft(end=(0.3, 0, 2))])
    assert found.joint_angles[0] == pytest.approx(math.atan(0.3), rel=1e-14)
    back = geometry([Shaft(start=(0, 0, 0), end=(-1, 0, 0)), Shaft(end=(-2, 0.3, 0))])
    assert back.joint_angles[0] == pytest.approx(math.atan(0.3), rel=1e-14)
    assert np.isnan(back.views).all()


@pytest.mark.parametrize(
    ("shafts", "message"),
    [
        ([Shaft(), Shaft(), Shaft()], r"shafts\[1\] has no length"),
        ([Shaft(end=(1, 0, 0)), Shaft()], r"end of shafts\[0\] is given, but not where it begins"),
        ([Shaft(start=(0, 0, 0), end=(0, 0, 0)), Shaft()], r"shafts\[0\] starts and ends"),
        (
            [Shaft(start=(0, 0, 0), end=(1, 0, 0), length=2, name="a"), Shaft()],
            r"length = 2 m of shafts\[0\] \('a'\) is not the distance 1 m",
        ),
        (
            [Shaft(start=(0, 0, 0), end=(1, 0, 0)), Shaft(start=(1, 0.01, 0), end=(2, 0, 0))],
            r"start = \(1\.0, 0\.01, 0\.0\) of shafts\[1\] is 0\.01 m from the centre of joint 1",
        ),
        (
            [Shaft(start=(0, 0, 0), end=(1, 0, 0)), Shaft(end=(1, 1, 0))],
            "joint 1 .* has an angle of 90°; a universal joint passes on no rotation at 90°",
        ),
        (line((60, 0), (-60, 0)), "joint 1 .* has an angle of 120°"),
    ],
)
def test_what_cannot_be_built(shafts: list[Shaft], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        geometry(shafts)
