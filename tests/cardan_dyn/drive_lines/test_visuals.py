from xml.etree import ElementTree

import numpy as np
import pytest

from cardan_dyn.drive_lines import Bearing, DriveLine, Shaft, ShaftJoint, Spline, Tube
from cardan_dyn.practice.drive_lines.line.supports import spline_distance
from cardan_dyn.practice.drive_lines.line.visuals import cross_visuals, shaft_visuals
from cardan_dyn.practice.formats.visuals import visuals_of

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
    (first, *_), (middle, *_), (last, *_) = (shaft_visuals(LINE, index) for index in range(3))
    assert span(first) == (-0.345, -0.069)
    assert span(middle) == (0.08, 0.8)
    assert span(last) == (0.08, 0.4)
    assert middle.find("geometry/cylinder").get("radius") == "0.05"


def test_splines_have_sleeves() -> None:
    line = LINE.replace(
        shafts=[
            LINE.shafts[0],
            Shaft(length=0.9, tube=Tube(outer_diameter=0.1, wall=0.01), spline=Spline(profile=0.2)),
            LINE.shafts[2],
        ]
    )
    *_, sleeve = shaft_visuals(line, 1)
    assert sleeve.get("name") == "sleeve_1"
    low, high = span(sleeve)
    assert high - low == pytest.approx(0.2)
    assert spline_distance(line, 1) == pytest.approx((low + high) / 2)


def test_crosses_have_two_pins() -> None:
    lengths = [v.find("geometry/cylinder").get("length") for v in cross_visuals(LINE, 1)]
    assert lengths == ["0.12", "0.12"]
    assert len(cross_visuals(DriveLine(shafts=[Shaft(), Shaft()]), 1)) == 2


def inside(point: np.ndarray, sizes: tuple[float, ...], placement: np.ndarray) -> np.ndarray:
    """Whether points `(n, 3)` are in a box."""
    local = (point - placement[:3, 3]) @ placement[:3, :3]
    return np.all(np.abs(local) <= np.array(sizes) / 2.0 + 1e-9, axis=-1)


@pytest.mark.parametrize("name", ["truck", "rolling_mill"])
def test_forks_hold_the_ends_of_their_crosses_as_the_line_turns(name: str) -> None:
    line = DriveLine.from_toml(name)
    visuals, messages = visuals_of(line.mechanism.description)
    assert messages == []
    turn = line.scene().sweep(np.linspace(0.0, 5.0, 7))
    ears = [item for item in visuals if item.kind == "box"]
    crosses = [item for item in visuals if item.link.startswith("cross_")]
    assert len(ears) == 4 * line.count and len(crosses) == 2 * line.count
    for pin in crosses:
        for end in (-0.45, 0.45):
            at = turn.point(
                pin.link, pin.placement[:3, 3] + end * pin.size[1] * pin.placement[:3, 2]
            )
            holding = 0
            for ear in ears:
                origin = turn.point(ear.link).position
                rotation = turn.orientation(ear.link)
                local = np.einsum("nji,nj->ni", rotation, at.position - origin)
                is_inside = inside(local, ear.size, ear.placement)
                assert np.all(is_inside) or not np.any(is_inside)
                holding += bool(is_inside[0])
            assert holding == 1


def test_a_joint_of_constant_velocity_has_a_housing_in_place_of_forks() -> None:
    line = DriveLine(
        shafts=[Shaft(bearings=[Bearing(distance=0.3)]), Shaft(bearings=[Bearing(distance=0.3)])],
        joints=[ShaftJoint(kind="constant_velocity")],
    )
    visuals = [item for index in range(2) for item in shaft_visuals(line, index)]
    kinds = [item.find("geometry")[0].tag for item in visuals]
    assert sorted(kinds) == ["cylinder", "cylinder", "sphere"]
