import math

import pytest

from cardan_dyn.drive_lines import Bearing, DriveLine, Shaft, ShaftJoint, Spline, Tube
from cardan_dyn.practice.drive_lines.line.closed_chain import cross_inertia, shaft_bodies

TUBE = Tube(outer_diameter=0.1, wall=0.006)


def line(**fields: object) -> DriveLine:
    return DriveLine(shafts=[Shaft(), Shaft(length=0.9, **fields), Shaft()])


def test_a_tube_as_a_difference_of_cylinders() -> None:
    body, behind = shaft_bodies(line(tube=TUBE), 1)
    outer, inner = (7850 * math.pi / 4 * d**2 * 0.9 for d in (0.1, 0.088))
    assert behind is None
    assert body.mass == pytest.approx(outer - inner, rel=1e-13)
    assert body.inertia == pytest.approx((outer * 0.1**2 - inner * 0.088**2) / 8, rel=1e-13)
    transverse = [m * (3 * d**2 / 4 + 0.9**2) / 12 for m, d in ((outer, 0.1), (inner, 0.088))]
    assert body.transverse == pytest.approx(transverse[0] - transverse[1], rel=1e-13)
    assert body.centre == 0.45


def test_a_spline_divides_a_shaft_and_keeps_its_inertia() -> None:
    whole, _ = shaft_bodies(line(tube=TUBE), 1)
    front, rear = shaft_bodies(line(tube=TUBE, spline=Spline(distance=0.3)), 1)
    assert front.mass + rear.mass == pytest.approx(whole.mass, rel=1e-15)
    assert front.inertia + rear.inertia == pytest.approx(whole.inertia, rel=1e-15)
    steiner = sum(body.transverse + body.mass * (body.centre - 0.45) ** 2 for body in (front, rear))
    assert steiner == pytest.approx(whole.transverse, rel=1e-14)
    at_end = shaft_bodies(line(tube=TUBE, spline=Spline(distance=0.9)), 1)
    assert at_end[0].mass == pytest.approx(whole.mass, rel=1e-15)
    assert at_end[1] is None


def test_what_is_given_counts() -> None:
    fields = {"mass": 20, "inertia": 3, "transverse_inertia": 2, "centre": 0.2}
    front, rear = shaft_bodies(line(spline=Spline(), tube=TUBE, **fields), 1)
    assert tuple(front) == (20.0, 0.2, 3.0, 2.0)
    assert rear is None


def test_a_flywheel_and_a_point_on_an_end_shaft() -> None:
    heavy = DriveLine(shafts=[Shaft(mass=500, inertia=80), Shaft(mass=5, centre=0.1)])
    wheel, _ = shaft_bodies(heavy, 0)
    assert tuple(wheel) == (500.0, 0.0, 80.0, 40.0)
    point, _ = shaft_bodies(heavy, 1)
    assert tuple(point) == (5.0, 0.1, 0.0, 0.0)


def test_the_input_shaft_lies_before_its_joint() -> None:
    ends = DriveLine(shafts=[Shaft(length=0.4, tube=TUBE), Shaft(length=0.4, tube=TUBE)])
    assert [shaft_bodies(ends, index)[0].centre for index in (0, 1)] == [-0.2, 0.2]


def test_nothing_weighs_nothing() -> None:
    massless = DriveLine(shafts=[Shaft(), Shaft(mass=0, bearings=[Bearing(distance=1)])])
    assert shaft_bodies(massless, 0) == shaft_bodies(massless, 1) == (None, None)


def test_a_cross_of_two_rods() -> None:
    pin, normal = cross_inertia(ShaftJoint(cross_mass=1.2, cross_span=0.1))
    rod = 0.6 * 0.1**2 / 12
    assert (pin, normal) == pytest.approx((rod, 2 * rod), rel=1e-14)
