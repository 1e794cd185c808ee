from xml.etree import ElementTree

from cardan_dyn.drive_lines import Bearing, DriveLine, Shaft, ShaftJoint, Spline, Tube
from cardan_dyn.drive_lines.line.closed_chain import cross_visuals, shaft_visuals

LINE = DriveLine(
    shafts=[
        Shaft(bearings=[Bearing(distance=0.1), Bearing(distance=0.3)]),
        Shaft(length=0.9, tube=Tube(outer_diameter=0.1, wall=0.01), spline=Spline()),
        Shaft(length=0.4),
    ],
    joints=[ShaftJoint(cross_span=0.12), ShaftJoint()],
)


def span(visual: ElementTree.Element) -> tuple[float, float]:
    """Where a cylinder along x begins and ends."""
    x = float(visual.find("origin").get("xyz").split()[0])
    half = float(visual.find("geometry/cylinder").get("length")) / 2
    return round(x - half, 12), round(x + half, 12)


def test_shafts_lie_between_their_joints() -> None:
    (first,), (middle,), (last,) = (shaft_visuals(LINE, index) for index in range(3))
    assert span(first) == (-0.3, -0.06)
    assert span(middle) == (0.1, 0.8)
    assert span(last) == (0.08, 0.4)
    assert middle.find("geometry/cylinder").get("radius") == "0.05"


def test_crosses_have_two_pins() -> None:
    lengths = [v.find("geometry/cylinder").get("length") for v in cross_visuals(LINE, 1)]
    assert lengths == ["0.12", "0.12"]
    assert len(cross_visuals(DriveLine(shafts=[Shaft(), Shaft()]), 1)) == 2
