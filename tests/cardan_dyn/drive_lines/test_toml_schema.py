import jsonschema
import pytest
import tomlkit

from cardan_dyn.drive_lines import DriveLine, Shaft, toml_schema

GOOD = """
speed = "3000 1/min"
torque_nm = 400
[[shafts]]
slope_side_deg = -15
[[shafts]]
length_mm = 900
tube = { outer_diameter = "100 mm", wall_mm = 6, density = "7.85 g/cm³" }
spline = {}
inertia = "3 kg·m²"
[[shafts]]
end = ["1 m", "0 mm", "-2 cm"]
start_mm = [900, 0, 0]
"""


def errors(text: str) -> list[str]:
    """What a validator of JSON schemas finds wrong with a file."""
    validator = jsonschema.Draft202012Validator(toml_schema())
    return [error.message for error in validator.iter_errors(tomlkit.parse(text).unwrap())]


def test_it_is_a_schema() -> None:
    jsonschema.Draft202012Validator.check_schema(toml_schema())


def test_it_accepts_what_the_reader_does() -> None:
    assert errors(GOOD) == []
    assert errors(DriveLine.from_toml(GOOD).to_toml()) == []


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("length_mm = 900", "length = 900"),
        ("length_mm = 900", 'length = "900"'),
        ("length_mm = 900", 'length = "900 kg"'),
        ("length_mm = 900", "length_mm = -900"),
        ("length_mm = 900", "length_mm = 900\nlength_m = 0.9"),
        ("length_mm", "lenght_mm"),
        ("slope_side_deg = -15", "slope_side_deg = -95"),
        ("[900, 0, 0]", "[900, 0]"),
        (", wall_mm = 6", ""),
        ("spline = {}", "spline = 3"),
        ("spline = {}", 'centring = { kind = "disk" }'),
        ("[[shafts]]", "[[shaft]]"),
    ],
)
def test_it_refuses_what_the_reader_does(old: str, new: str) -> None:
    assert old in GOOD
    assert errors(GOOD.replace(old, new))


def test_every_field_is_explained() -> None:
    definitions = toml_schema()["$defs"]
    parts = {"Shaft", "ShaftJoint", "Tube", "Spline", "Bearing", "Centring", "DutyPoint"}
    parts |= {"TitleBlock"}
    assert set(definitions) == parts
    for definition in definitions.values():
        for key, value in definition["properties"].items():
            assert value["description"], key


def test_a_line_without_shafts_is_refused() -> None:
    assert errors("name = 'x'")
    assert errors(DriveLine(shafts=[Shaft(), Shaft()]).to_toml()) == []
