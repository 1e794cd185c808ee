import math
from pathlib import Path

import pytest

from cardan_dyn import ModelError
from cardan_dyn.drive_lines import Bearing, DriveLine, DutyPoint, Shaft, ShaftJoint, Spline, Tube

TEXT = """
name = "rear axle"            # any text
speed_rpm = 3000
torque = "0.4 kN·m"

[[shafts]]
name = "gearbox"
slope_side_deg = -15
slope_plan = "-7 deg"
bearings = [{ distance_mm = 60 }, { distance = "180 mm", name = "front", locating = true }]

[[shafts]]
length_mm = 900
fork_offset_deg = 71
tube = { outer_diameter_mm = 100, wall_mm = 6 }
spline = { friction = 0.1, radius_mm = 30 }

[[shafts]]
start_mm = [900, 0, 0]
end = ["1 m", "0 mm", "-2 cm"]

[[joints]]
rated_torque_knm = 2

[[joints]]
largest_angle_deg = 25

[[duty_cycle]]
share = 1
speed_rpm = 1200
torque_nm = 500
"""


def test_every_kind_of_field() -> None:
    line = DriveLine.from_toml(TEXT)
    gearbox = Shaft(
        name="gearbox",
        slope_side=math.radians(-15),
        slope_plan=math.radians(-7),
        bearings=(Bearing(distance=0.06), Bearing(distance=0.18, name="front", locating=True)),
    )
    tube = Shaft(
        length=0.9,
        fork_offset=math.radians(71),
        tube=Tube(outer_diameter=0.1, wall=0.006),
        spline=Spline(friction=0.1, radius=0.03),
    )
    rear = Shaft(start=(0.9, 0.0, 0.0), end=(1.0, 0.0, -0.02))
    assert line == DriveLine(
        name="rear axle",
        speed=3000 * (2 * math.pi / 60),
        torque=400,
        shafts=[gearbox, tube, rear],
        joints=[ShaftJoint(rated_torque=2000), ShaftJoint(largest_angle=math.radians(25))],
        duty_cycle=[DutyPoint(share=1, speed=1200 * (2 * math.pi / 60), torque=500)],
    )


def test_a_path_and_a_text_say_the_same(tmp_path: Path) -> None:
    path = tmp_path / "line.toml"
    path.write_text(TEXT, encoding="utf-8-sig")
    assert DriveLine.from_toml(path) == DriveLine.from_toml(str(path)) == DriveLine.from_toml(TEXT)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("length_mm", "lenght_mm", r"shafts\[1\]\.lenght_mm is no field .* mean 'length_mm'"),
        ("[[duty_cycle]]", "[[dutycycle]]", "dutycycle is no field .* mean 'duty_cycle'"),
        ("length_mm = 900", "length = 900", r"shafts\[1\]\.length = 900 has no unit; .*length_mm"),
        ("length_mm = 900", 'length = "900"', r"length = '900' has no unit"),
        ("length_mm = 900", 'length = "9 kg"', r"has the unit 'kg', which is none of length"),
        ("length_mm = 900", 'length = "0,9 m"', r"'0,9 m': decimals stand behind a point"),
        ("length_mm = 900", 'length = "-9 m"', r"length is '-9 m', expected .* greater than 0"),
        ("length_mm = 900", "length_mm = true", r"length_mm is True, expected .*\[mm\]"),
        ("length_mm = 900", 'length_mm = "900"', r"length_mm is '900', expected .*\[mm\]"),
        ("length_mm = 900", "length_mm = nan", r"length_mm is nan, expected a finite number"),
        ("length_mm = 900", "length_mm = -1", r"length_mm is -1, expected .* greater than 0"),
        ("length_mm = 900", "length_mm = []", r"length_mm is a list of 0"),
        ("length_mm = 900", "length_mm = {}", r"length_mm is a table"),
        ("length_mm = 900", "length_mm = 900\nlength_m = 1", "length_m says the same as length_mm"),
        ("length_mm = 900", "", r"shafts\[1\] has no length"),
        ("side_deg = -15", "side_deg = 95", "is 95, .* greater than -90 and less than 90 .deg."),
        ("wall_mm = 6", "wall_mm = 66", r"shafts\[1\]\.tube: wall = 0\.066 of a Tube exceeds half"),
        (", wall_mm = 6", "", r"shafts\[1\]\.tube\.wall is missing: thickness of the wall"),
        ("[900, 0, 0]", "[900, 0]", r"start_mm has 2 entries, expected three"),
        ("[900, 0, 0]", "7", r"start_mm is 7, expected three lengths"),
        ("[900, 0, 0]", '[900, 0, "x"]', r"start_mm\[2\] is 'x'"),
        ('"-2 cm"]', '"-2 cm"]\nlength_mm = 102.5', "is not the distance 0.10198039 m"),
        ('"gearbox"', "3", r"shafts\[0\]\.name is 3, expected a text"),
        (
            "locating = true",
            "locating = 1",
            r"bearings\[1\]\.locating is 1, expected true",
        ),
        ("share = 1", "share = 0.9", "shares have the sum 0.9"),
        ("share = 1", "share = 2", r"duty_cycle\[0\]\.share is 2, expected .* at most 1"),
        ("share = 1", "share = 1.0.0", "is no TOML"),
    ],
)
def test_bad_files(old: str, new: str, message: str) -> None:
    assert old in TEXT
    with pytest.raises(ModelError, match=f"the text.*{message}"):
        DriveLine.from_toml(TEXT.replace(old, new, 1))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty; a drive line needs shafts"),
        ("# nothing\n", "is empty"),
        ("name = 'x'", "shafts is missing: shafts along the power flow"),
        ("shafts = 3", r"shafts is 3, expected tables \[\[shafts\]\]"),
        ("shafts = [1]", r"shafts\[0\] is 1, expected a table"),
        ("shafts = {}", "shafts is a table, expected tables"),
    ],
)
def test_hardly_a_file(text: str, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        DriveLine.from_toml(text)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"none\.toml cannot be read"):
        DriveLine.from_toml(tmp_path / "none.toml")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ModelError, match="cannot be read"):
        DriveLine.from_toml(tmp_path / "bytes.toml")
    with pytest.raises(ModelError, match="expected a path or TOML text"):
        DriveLine.from_toml(3)


@pytest.mark.parametrize("unit", ["lb-ft", "ft-lb", "ft-lbf", "lbf·ft"])
def test_torques_as_engineers_of_the_usa_write_them(unit: str) -> None:
    line = DriveLine.from_toml(f'torque = "600 {unit}"\n[[shafts]]\n[[shafts]]\n')
    assert line.torque == pytest.approx(600 * 4.4482216152605 * 0.3048, rel=1e-15)


def test_a_unit_that_is_spelled_otherwise_is_named() -> None:
    with pytest.raises(
        ModelError, match="torque_ftlb is no field of a DriveLine; write torque_lbft"
    ):
        DriveLine.from_toml("torque_ftlb = 600\n[[shafts]]\n[[shafts]]\n")
