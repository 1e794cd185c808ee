import datetime
import math

import pytest
from scipy.integrate import quad

from cardan_dyn import ModelError
from cardan_dyn.drive_lines import Bearing, DutyPoint, Shaft, ShaftJoint, Spline, TitleBlock, Tube


def test_a_tube_by_integration() -> None:
    tube = Tube(outer_diameter=0.1, wall=0.006)
    area = quad(lambda r: 2 * math.pi * r, 0.044, 0.05)[0]
    polar = quad(lambda r: 2 * math.pi * r**3, 0.044, 0.05)[0]
    assert tube.inner_diameter == pytest.approx(0.088, rel=1e-15)
    assert tube.area == pytest.approx(area, rel=1e-13)
    assert tube.polar_moment == pytest.approx(polar, rel=1e-13)
    assert tube.torsional_stiffness(0.5) == pytest.approx(8.08e10 * polar / 0.5, rel=1e-13)


def test_a_solid_shaft_has_a_wall_of_half_its_diameter() -> None:
    solid = Tube(outer_diameter=0.07, wall=0.035)
    assert solid.inner_diameter == 0.0
    assert solid.polar_moment == pytest.approx(math.pi * 0.07**4 / 32, rel=1e-14)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Tube(outer_diameter=0.1, wall=0.06), "wall = 0.06 .* exceeds half .* 0.1 m"),
        (lambda: Spline(friction=0.1), "friction = 0.1 .* needs the mean radius"),
        (lambda: Spline(friction=-0.1), "friction of a Spline is -0.1, expected .* at least 0"),
        (lambda: Bearing(distance=0), "distance of a Bearing is 0, expected .* greater than 0"),
        (lambda: ShaftJoint(largest_angle=2.0), "largest_angle of a ShaftJoint is 2.0"),
        (lambda: Shaft(slope_side=math.pi / 2), "slope_side of a Shaft is 1.57.* less than 1.5708"),
        (lambda: Shaft(slope_side=0.1, end=(1, 0, 0)), "slope_side = 0.1 .* goes with a length"),
        (lambda: Shaft(start=(1, 0, 0)), "start of a Shaft needs the other end"),
        (lambda: Shaft(inertia=2.0), "inertia = 2 .* needs a mass"),
        (
            lambda: Shaft(mass=1, inertia=2.0, transverse_inertia=0.9),
            "transverse_inertia = 0.9 of a Shaft is less than half the inertia .* 1 kg",
        ),
        (lambda: DutyPoint(share=1.5, speed=1, torque=1), "share of a DutyPoint is 1.5"),
        (lambda: TitleBlock(date="2026-02-29"), "date of a TitleBlock .* such as 2026-01-31"),
        (lambda: TitleBlock(date="20260228"), "date of a TitleBlock .* such as 2026-01-31"),
        (lambda: TitleBlock(date=datetime.datetime(2026, 2, 28)), "date of a TitleBlock"),
        (lambda: TitleBlock(author=3), "author of a TitleBlock is 3"),
    ],
)
def test_what_no_part_can_be(make: object, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        make()


def test_zero_masses_are_valid() -> None:
    assert Shaft(mass=0).mass == 0.0
    assert ShaftJoint(cross_mass=0).cross_mass == 0.0
