"""Arrangements against the catalogue, and the catalogue's example on the mechanism itself."""

import math

import numpy as np
import pytest

from cardan_dyn import ArgumentError
from cardan_dyn.analytic import compound_angle, drive_line, support_forces
from cardan_dyn.drive_lines import DriveLine, arrangements

EXAMPLE = tuple(np.radians([15.0, 7.0, -11.5, 12.0]))
"""Bild 19: bends of joints 1 and 2 in the side and the plan view [rad]."""


def residual(line: DriveLine) -> float:
    """Residual angle of a line [deg]."""
    return math.degrees(drive_line.residual_angle(line.joint_angles, line.fork_phases))


def residual_of_mechanism(line: DriveLine) -> float:
    """The same from the speed ratio of the mechanism, whose extremes are cos and 1/cos [deg]."""
    ratio = line.analyse(speed=0.0, torque=1.0, positions=np.linspace(0, np.pi, 361)).ratio[:, -1]
    return math.degrees(math.acos(math.sqrt(ratio.min() / ratio.max())))


def test_the_graphical_method() -> None:
    found = arrangements.graphical_method(*EXAMPLE)
    assert np.degrees(found.joint_angles) == pytest.approx([16.42, 16.40], abs=5e-3)
    assert np.degrees(found.drawn_angles) == pytest.approx([16.55, 16.62], abs=5e-3)
    # 71 degrees against the clock.
    assert math.degrees(found.fork_offset) == pytest.approx(-70.87, abs=5e-3)
    assert found.directions[0] == pytest.approx(
        compound_angle.bending_plane(EXAMPLE[1], EXAMPLE[0])
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("parallel", "offset", "best", "printed", "wrong"),
    [
        # Best, printed and wrong: residual angles with the exact offset, the printed one, and the
        # printed one the other way round. Joint angles of 16.42, 16.40; 16.42, 16.55; 16.14, 16.40.
        ("common", -70.87, 0.95, 0.95, 18.23),
        ("input", -72.30, 2.11, 3.79, 18.03),
        ("output", -73.39, 2.90, 5.00, 17.57),
    ],
)
def test_the_catalogues_example(
    parallel: str, offset: float, best: float, printed: float, wrong: float
) -> None:
    recipe = arrangements.graphical_method(*EXAMPLE).fork_offset
    spans = (0.12, 0.06, 0.07, 0.15)
    exact, by_recipe, mistaken = (
        arrangements.spatial_arrangement(
            *EXAMPLE, 1.0, parallel=parallel, fork_offset=forks, spans=spans
        )
        for forks in (None, recipe, -recipe)
    )
    assert math.degrees(exact.fork_offsets[0]) == pytest.approx(offset, abs=5e-3)
    for line, expected in ((exact, best), (by_recipe, printed), (mistaken, wrong)):
        assert residual(line) == pytest.approx(expected, abs=5e-3)
        assert residual_of_mechanism(line) == pytest.approx(residual(line), abs=1e-3)
    # What is left with the exact offset is that of unequal joint angles.
    small, great = np.sort(np.cos(exact.joint_angles))
    assert math.cos(math.radians(residual(exact))) == pytest.approx(small / great, rel=1e-14)


def test_offsets_are_those_of_the_directions() -> None:
    rng = np.random.default_rng(0)
    for bends in rng.uniform(-0.4, 0.4, (10, 4)):
        for parallel in arrangements.PARALLEL:
            line = arrangements.spatial_arrangement(*bends, 1.0, parallel=parallel)
            expected = compound_angle.offset_between(*line.geometry.directions)
            assert math.tan(line.fork_offsets[0]) == pytest.approx(math.tan(expected), rel=1e-9)


@pytest.mark.parametrize("beta", [0.0, 0.1, -0.3, 1.2])
def test_z_and_w(beta: float) -> None:
    z, w = arrangements.z_arrangement(beta, 0.8), arrangements.w_arrangement(beta, 0.8)
    for line in (z, w):
        assert line.joint_angles == pytest.approx([abs(beta)] * 2, abs=1e-15)
        assert line.fork_offsets == [0.0]
        assert residual(line) == 0.0
    assert z.geometry.directions[0] == pytest.approx(z.geometry.directions[2])
    assert w.geometry.directions[0] @ w.geometry.directions[2] == pytest.approx(math.cos(2 * beta))


def test_bearings_stand_where_the_catalogue_has_them() -> None:
    spans = (0.12, 0.06, 0.07, 0.15)
    line = arrangements.w_arrangement(0.2, 0.8, beta_2=0.3, spans=spans, torque=100.0)
    analysis = line.analyse(speed=0.0, positions=np.array([0.0, np.pi / 2]))
    closed = support_forces.planar_support_forces(
        0.2, 0.3, 100.0, 0.8, support_forces.Spans(*spans), "W"
    )
    for k, name in enumerate(analysis.bearings):
        # The input pin is horizontal at 0, normal to the plane of the shafts.
        expected = [getattr(closed[1], name), getattr(closed[0], name)]
        assert analysis.total.bearing_radial[:, k] == pytest.approx(expected, rel=1e-9)


def test_centred_double_joints() -> None:
    line = arrangements.centred_double_joint(0.6, 0.06)
    assert line.joint_angles == pytest.approx([0.3, 0.3])
    for angle, expected in ((20, 3.6), (35, 0.0), (45, 8.4)):
        made = arrangements.centred_double_joint(
            math.radians(angle), 0.06, equal_at=math.radians(35)
        )
        assert sum(made.joint_angles) == pytest.approx(math.radians(angle))
        assert residual(made) == pytest.approx(expected, abs=0.05)
        # Where the shafts' axes meet, by the points of the joints: 60 mm / cos 17.5° from joint 2.
        first, last = made.geometry.directions[0], made.geometry.directions[2]
        between = made.geometry.centres[1] - made.geometry.centres[0]
        along = np.linalg.lstsq(np.stack([first, -last], axis=1), between, rcond=None)[0]
        assert -along[1] * -1 == pytest.approx(-0.06 / math.cos(math.radians(17.5)), rel=1e-9)


def test_a_centre_bearing() -> None:
    slopes = np.radians([0.0, 3.0, 6.0, 1.0])
    line = arrangements.centre_bearing_line(
        slopes, [0.9, 1.1], 0.7, spans=(0.12, 0.06, 0.07, 0.15), torque=100.0
    )
    # 5° is more than 3° and 3° can make up for.
    cosines = np.cos(np.radians([3.0, 3.0, 5.0]))
    expected = math.degrees(math.acos(cosines[2] / (cosines[0] * cosines[1])))
    assert residual(line) == pytest.approx(expected, rel=1e-9)
    assert line.analyse(speed=0.0).bearings == ("A", "B", "C1", "E", "F")
    given = arrangements.centre_bearing_line(slopes, [0.9, 1.1], 0.7, fork_offsets=[0.1, 0.2])
    assert given.fork_offsets == pytest.approx([0.1, 0.2])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: arrangements.z_arrangement(2.0, 1.0), "beta_1 is 2.0, expected a finite number"),
        (lambda: arrangements.w_arrangement(0.1, 1.0, spans=(1, 2)), "spans has shape"),
        (lambda: arrangements.w_arrangement(0.1, 1.0, spans=(1, 2, 0, 1)), "e of spans is 0"),
        (
            lambda: arrangements.spatial_arrangement(*EXAMPLE, 1.0, parallel="inputs"),
            "parallel = 'inputs' is unknown; .*did you mean 'input'",
        ),
        (
            lambda: arrangements.centred_double_joint(1.7, 0.06, equal_at=2.2),
            "is out of the reach of a centring made for 126",
        ),
        (lambda: arrangements.graphical_method(0.1, math.nan, 0.1, 0.1), "beta_h1 is nan"),
    ],
)
def test_what_cannot_be_built(make: object, message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        make()  # type: ignore[operator]
