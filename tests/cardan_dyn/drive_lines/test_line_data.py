import copy
import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from cardan_dyn import ModelError
from cardan_dyn.drive_lines import (
    Bearing,
    DriveLine,
    DutyPoint,
    Shaft,
    ShaftJoint,
    Spline,
    Tube,
)


def double_shaft(**changes: object) -> DriveLine:
    middle = Shaft(length=0.9, slope_side=-0.1, spline=Spline(), fork_offset=0.2)
    fields = {"shafts": [Shaft(), middle, Shaft()], **changes}
    return DriveLine(**fields)


def test_defaults_and_names() -> None:
    line = double_shaft(joints=[ShaftJoint(), ShaftJoint(name="rear")])
    assert line.count == 2
    assert line.shaft_names == ("input", "shaft_1", "output")
    assert line.joint_names == ("joint_1", "rear")
    assert line.fork_offsets.tolist() == [0.2]
    assert line.joint_angles == pytest.approx([0.1, 0.1], rel=1e-14)
    assert double_shaft().joints == (ShaftJoint(), ShaftJoint())


def test_lines_are_values() -> None:
    line = double_shaft(speed=300, torque=400)
    line.geometry  # noqa: B018
    for other in (copy.copy(line), copy.deepcopy(line), pickle.loads(pickle.dumps(line))):
        assert other == line
        assert hash(other) == hash(line)
        assert other.geometry.joint_angles.tolist() == line.geometry.joint_angles.tolist()
    assert line != double_shaft(speed=301, torque=400)
    with pytest.raises(AttributeError):
        line.speed = 3
    with pytest.raises(ValueError, match="read-only"):
        line.geometry.centres[0] = 1.0


def test_lines_from_threads() -> None:
    line = double_shaft()
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda _: line.geometry.joint_angles.tolist(), range(64)))
    assert found == [found[0]] * 64


@pytest.mark.parametrize("offset", [-0.3, -100.0, 1000.0])
def test_fork_offsets_of_any_size(offset: float) -> None:
    middle = Shaft(length=0.9, spline=Spline(), fork_offset=offset)
    line = DriveLine(shafts=[Shaft(), middle, Shaft()])
    assert line.fork_phases[1] - line.fork_phases[0] == pytest.approx(np.pi / 2 + offset)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"shafts": []}, "there are 0; a line has two shafts at least"),
        ({"shafts": [Shaft()]}, "there are 1; a line has two shafts"),
        ({"joints": [ShaftJoint()]}, "there are 1 joints between 3 shafts; give 2"),
        ({"speed": "3"}, "speed of a DriveLine is '3'"),
        ({"torque": float("nan")}, "torque of a DriveLine is nan"),
        (
            {"duty_cycle": [DutyPoint(share=0.4, speed=1, torque=2)] * 2},
            "shares have the sum 0.8; it has to be 1",
        ),
        (
            {"shafts": [Shaft(fork_offset=0.1), Shaft()]},
            r"fork_offset of shafts\[0\]: only intermediate shafts",
        ),
        (
            {"shafts": [Shaft(), Shaft(spline=Spline(), name="axle")]},
            r"spline of shafts\[1\] \('axle'\): only intermediate",
        ),
        (
            {"shafts": [Shaft(tube=Tube(outer_diameter=0.1, wall=0.01)), Shaft()]},
            r"tube of shafts\[0\] needs a length",
        ),
        (
            {"shafts": [Shaft(), Shaft(length=1, bearings=[Bearing(distance=1.2)]), Shaft()]},
            r"distance = 1.2 m of bearings\[0\] of shafts\[1\] exceeds the shaft's length 1 m",
        ),
        (
            {"shafts": [Shaft(), Shaft(length=1, spline=Spline(distance=1.2)), Shaft()]},
            r"distance = 1.2 m of spline of shafts\[1\] exceeds",
        ),
        (
            {"shafts": [Shaft(bearings=[Bearing(distance=d, name="A") for d in (1, 2)]), Shaft()]},
            "bearings of a DriveLine: the name 'A' occurs twice",
        ),
        (
            {"shafts": [Shaft(bearings=[Bearing(distance=d) for d in (1, 2, 2)]), Shaft()]},
            r"distance = 2 m of bearings of shafts\[0\]: two of them are at one place",
        ),
    ],
)
def test_what_is_no_line(changes: dict[str, object], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        double_shaft(**changes)


def test_texts_of_lines_are_short() -> None:
    shafts = [Shaft(bearings=(Bearing(distance=0.1), Bearing(distance=0.3)))]
    shafts += [Shaft(length=1.0, slope_side=0.1 * (k % 2 + 1)) for k in range(8)]
    shafts.append(Shaft(bearings=(Bearing(distance=0.1), Bearing(distance=0.3))))
    text = repr(DriveLine(shafts=tuple(shafts), name="long"))
    assert text == (
        "<DriveLine 'long': 9 joints at 5.73°, 5.73°, 5.73°, 5.73°, 5.73°, 5.73°, …; 4 bearings>"
    )


def test_names_differ_from_those_of_parts_without_a_name() -> None:
    with pytest.raises(ModelError, match="shafts of a DriveLine: the name 'output' occurs twice"):
        DriveLine(shafts=[Shaft(name="output"), Shaft()])
    with pytest.raises(ModelError, match="joints of a DriveLine: the name 'joint_2' occurs twice"):
        DriveLine(
            shafts=[Shaft(), Shaft(length=1.0), Shaft()],
            joints=[ShaftJoint(name="joint_2"), ShaftJoint()],
        )


@pytest.mark.parametrize("name", ["a\nb", "\x00"])
def test_names_can_be_printed(name: str) -> None:
    with pytest.raises(ModelError, match="expected a text of one line that can be printed"):
        Shaft(name=name)


@pytest.mark.parametrize(
    ("part", "fields", "message"),
    [
        (Tube, {"outer_diameter": 80.0, "wall": 3.0}, r"80 m, but lines have .* 80 mm are 0.08 m"),
        (
            Tube,
            {"outer_diameter": 0.08, "wall": 3.0},
            r"is 3 m, .* 3 mm are 0.003 m",
        ),
        (Tube, {"outer_diameter": 8e-5, "wall": 3e-5}, "is 8e-05 m, .*is its unit right"),
        (Tube, {"outer_diameter": 0.1, "wall": 0.004, "modulus": 210e6}, "modulus of a Tube is"),
        (
            Tube,
            {"outer_diameter": 0.1, "wall": 0.004, "shear_limit": 60.0},
            "shear_limit of",
        ),
        (Shaft, {"length": 1200.0}, "length of a Shaft is 1200 m, .* 1200 mm are 1.2 m"),
        (Bearing, {"distance": 60.0}, "distance of a Bearing is 60 m"),
        (Spline, {"radius": 25.0}, "radius of a Spline is 25 m"),
        (ShaftJoint, {"pin_radius": 12.0}, "pin_radius of a ShaftJoint is 12 m"),
        (ShaftJoint, {"cross_span": 100.0}, "cross_span of a ShaftJoint is 100 m"),
        (ShaftJoint, {"torque_limit": 1e12}, r"torque_limit of a ShaftJoint is 1e\+12 N·m"),
        (DutyPoint, {"share": 1.0, "speed": 1e6, "torque": 1.0}, "speed of a DutyPoint is"),
    ],
)
def test_sizes_that_no_line_has_are_refused(
    part: type, fields: dict[str, float], message: str
) -> None:
    with pytest.raises(ModelError, match=message):
        part(**fields)


def test_sizes_between_points_are_refused_as_well() -> None:
    shafts = [Shaft(), Shaft(start=(0.0, 0.0, 0.0), end=(900.0, 0.0, 50.0)), Shaft()]
    with pytest.raises(ModelError, match=r"length of shafts\[1\] between its ends is 901"):
        DriveLine(shafts=shafts)
    far = [Shaft(), Shaft(start=(5e3, 0.0, 0.0), end=(5001.0, 0.0, 0.1)), Shaft()]
    assert DriveLine(shafts=far).count == 2  # Wherever it stands.
