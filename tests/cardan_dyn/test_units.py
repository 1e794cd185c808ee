import math

import pytest

from cardan_dyn import ModelError
from cardan_dyn.kit import units


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("900 mm", "length", 0.9),
        ("1.2 m", "length", 1.2),
        (" 4 in ", "length", 0.1016),
        ("5 deg", "angle", math.pi / 36),
        ("-5°", "angle", -math.pi / 36),
        ("400 N·m", "torque", 400.0),
        ("400N m", "torque", 400.0),
        ("0.4 kN*m", "torque", 400.0),
        ("100 lbf ft", "torque", 135.5817948331400),
        ("3e3 rpm", "speed", 100.0 * math.pi),
        ("3000 1/min", "speed", 100.0 * math.pi),
        ("2 kg·m²", "inertia", 2.0),
        ("20 kg mm^2", "inertia", 2e-5),
        ("1 N·m/deg", "stiffness", 180.0 / math.pi),
        ("7.85 g/cm³", "density", 7850.0),
        ("210 GPa", "modulus", 2.1e11),
        ('46"', "length", 1.1684),
        ("6 ft", "length", 1.8288),
        ("100 lb in", "torque", 11.29848290276167),
        ("1 lb·in²", "inertia", 2.926396534292e-4),
        ("1 lbf·ft/rad", "stiffness", 1.3558179483314003),
        ("0.284 lb/in³", "density", 7861.0929376976865),
        ("29 Mpsi", "modulus", 199947961501.88248),
        ("30 ksi", "modulus", 206842718.79505083),
        ("1000 lbf/in", "rigidity", 175126.83524647637),
    ],
)
def test_texts_with_units(text: str, dimension: str, value: float) -> None:
    assert units.read(text, dimension, "field") == pytest.approx(value, rel=4e-16)


@pytest.mark.parametrize("text", ["900", "mm", "900 mn", "900 nm", "9,5 mm", "", "nan mm", "1 Mm"])
def test_units_are_never_guessed(text: str) -> None:
    with pytest.raises(ModelError, match=r"field.*\"1\.5 mm\".*units: \", cm, ft, in, inch, m, mm"):
        units.read(text, "length", "field")


def test_degrees_are_those_of_the_standard_library() -> None:
    for angle in range(-180, 180):
        assert units.read(f"{angle} deg", "angle", "") == math.radians(angle)


@pytest.mark.parametrize("dimension", [name for name, of in units.DIMENSIONS.items() if of])
def test_what_is_written_reads_back_exactly(dimension: str) -> None:
    for number in range(1, 400):
        for unit in units.DIMENSIONS[dimension]:
            value = unit.to_si(number / 7)
            key, (shown,) = units.written("x", [value], dimension)
            assert units.keys("x", dimension)[key].to_si(shown) == value


def test_round_numbers_are_written_as_such() -> None:
    assert units.written("length", [0.9], "length") == ("length_mm", [900.0])
    assert units.written("slope", [math.radians(-11.5)], "angle") == ("slope_deg", [-11.5])
    assert units.written("speed", [units.read("2950 rpm", "speed", "")], "speed") == (
        "speed_rpm",
        [2950.0],
    )
    # 10 in in a file of millimetres stay 254; 40 lb are no number of kilograms.
    assert units.written("length", [0.254], "length") == ("length_mm", [254.0])
    assert units.written("length", [0.254], "length", of_usa=True) == ("length_in", [10.0])
    heavy = units.read("40 lb", "mass", "")
    assert units.written("mass", [heavy], "mass") == ("mass_lb", [40.0])
