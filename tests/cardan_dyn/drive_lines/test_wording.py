"""Wording: numbers, quantities and texts in both languages and systems of units."""

import ast
import datetime
import math
import re
from pathlib import Path

import pytest
from testkit.line_data import random_line

from cardan_dyn import ArgumentError
from cardan_dyn.analytic import limits
from cardan_dyn.analytic.rules import RULES
from cardan_dyn.drive_lines import DriveLine, examples
from cardan_dyn.practice.drive_lines import wording
from cardan_dyn.practice.drive_lines.wording import BY_UNIT, Wording

PLACES = re.compile(r"\{(\w+)\}")


@pytest.mark.parametrize(
    ("value", "digits", "english", "german"),
    [
        (0.0, 4, "0", "0"),
        (-0.0, 4, "0", "0"),
        (3e-16, 4, "0", "0"),
        (1.0, 4, "1.000", "1,000"),
        (-2.34567, 4, "−2.346", "−2,346"),
        (9.99996, 4, "10.00", "10,00"),
        (1234.4, 4, "1234", "1234"),
        (12345.0, 5, "12 345", "12 345"),
        (167648.0, 4, "167 600", "167 600"),
        (9999999.0, 3, "1.00 × 10⁷", "1,00 × 10⁷"),
        (0.000123456, 3, "0.000123", "0,000123"),
        (0.0000123456, 3, "1.23 × 10⁻⁵", "1,23 × 10⁻⁵"),
        (math.inf, 4, "∞", "∞"),
        (-math.inf, 4, "−∞", "−∞"),
        (math.nan, 4, "–", "–"),
    ],
)
def test_numbers(value: float, digits: int, english: str, german: str) -> None:
    thin = str.maketrans({" ": wording.THIN})
    assert Wording("en").number(value, digits) == english.translate(thin)
    assert Wording("de").number(value, digits) == german.translate(thin)


@pytest.mark.parametrize(
    ("value", "dimension", "si", "imperial"),
    [
        (0.0254, "length", "25.40 mm", "1.000 in"),
        (1.3558179483, "torque", "1.356 N·m", "1.000 lbf·ft"),
        (4.4482216153, "force", "4.448 N", "1.000 lbf"),
        (0.45359237, "mass", "0.4536 kg", "1.000 lb"),
        (0.0421401101, "inertia", "0.04214 kg·m²", "1.000 lb·ft²"),
        (6894757.2932, "stress", "6.895 MPa", "1.000 ksi"),
        (6894757293.2, "modulus", "6.895 GPa", "1.000 Mpsi"),
        (27679.9047, "density", "27 680 kg/m³", "1.000 lb/in³"),
        (175.126835, "rigidity", "0.1751 N/mm", "1.000 lbf/in"),
        (745.699872, "power", "0.7457 kW", "1.000 hp"),
        (7.2007788e-4, "unbalance", "720.1 g·mm", "1.000 oz·in"),
        (math.pi / 30.0, "speed", "1.000 1/min", "1.000 rpm"),
        (math.pi / 180.0, "angle", "1.000°", "1.000°"),
        (math.pi**2 / 5400.0, "n_beta", "1.000 °/min", "1.000 °/min"),
        (3600.0, "time", "1.000 h", "1.000 h"),
    ],
)
def test_quantities(value: float, dimension: str, si: str, imperial: str) -> None:
    for units, expected in (("si", si), ("imperial", imperial)):
        told = Wording("en", units).quantity(value, dimension)
        assert told == expected.replace("27 ", f"27{wording.THIN}").replace(" ", wording.SPACE)


def test_what_is_given_stays_as_it_was_given() -> None:
    words = Wording()
    assert words.given(2.25, "length") == "2250"
    assert words.given(0.1234567, "length") == "123.457"
    assert words.given(math.radians(15.0), "angle") == "15"
    assert words.given(-0.08) == "−0.08"
    assert words.given_quantity(math.radians(9.633333), "angle") == "9.633°"
    assert Wording("de").fixed(-1e-9, "angle") == "0,000"
    assert Wording("de").fixed(-0.5, "length") == "−500,0"


def test_days() -> None:
    day = datetime.date(2026, 1, 31)
    assert Wording("en").day(day) == "2026-01-31"
    assert Wording("de").day(day) == "31.01.2026"


def test_neither_other_languages_nor_other_units() -> None:
    with pytest.raises(ArgumentError, match="language is 'fr', expected"):
        Wording("fr")
    with pytest.raises(ArgumentError, match="units is 3, expected"):
        Wording("en", 3)


def test_quantities_within_sentences() -> None:
    text = "the table ends at 4489 1/min; free length 3400 mm"
    gap = wording.SPACE
    assert Wording().sentence(text) == f"the table ends at 4489{gap}1/min; free length 3400{gap}mm"
    german = Wording("de", "imperial").sentence(text)
    # 133.86 in, of which four digits were given: one less than that is shown.
    assert german == f"die Tabelle endet bei 4489{gap}rpm; freie Länge 134{gap}in"
    assert Wording("de").sentence("angle error ±0.0367°") == "Drehwinkelfehler ±0,0367°"
    power = Wording("de").sentence("1.676e+05 W; no service_factor: K = 1")
    assert power == f"167,6{gap}kW; kein Betriebsfaktor (service_factor): K = 1"
    # A name is no quantity, whatever it looks like.
    name = "spline of shaft 2.5 mm slides"
    assert Wording("de", "imperial").sentence(name) == "Schiebestück von shaft 2.5 mm gleitet"
    assert Wording("de").sentence("said by nobody: 2.5 mm") == "said by nobody: 2.5 mm"


def test_fields_of_files_have_words() -> None:
    german, english = Wording("de"), Wording()
    text = "give rated_torque of the joint"
    assert english.sentence(text) == text
    assert german.sentence(text) == "Nenndrehmoment T_D (rated_torque) des Gelenks angeben"
    assert "T_D" in german.sentence("B10 life by rated torque")
    asked = german.sentence("give largest_angle of the joint")
    assert asked == "größter Beugewinkel (largest_angle) des Gelenks angeben"
    assert german.sentence("PSS, CriticalSpeed; PTO practice").endswith("Zapfwellenpraxis")


def test_both_languages_have_the_same_places() -> None:
    for texts in wording.catalogue().values():
        for english, german in texts.items():
            found = PLACES.findall(english), PLACES.findall(german)
            assert sorted(found[0]) == sorted(found[1]), english
    for english, german in wording.catalogue()["verdict"].items():
        assert PLACES.findall(english) == PLACES.findall(german), english


PUT_TOGETHER = {
    "B10 life by rated torque",
    "B10 life by capacity",
    "bending moment before the joint",
    "bending moment behind the joint",
    "balancing needed: limit {quantity}",
    "balancing not needed: limit {quantity}",
    "give travel or profile of the spline of {name}",
    "give profile of the spline of {name}",
    "mass and inertia of the input shaft",
    "mass and inertia of the output shaft",
    "inertia of the input shaft",
    "inertia of the output shaft",
    "PSS, DriveshaftLayout, after AE-7 p. 50, normal",
    "Spicer driveline installation manual, greatest angles by speed",
    "Spicer driveline installation manual: equal within 1 degree",
    "Spicer driveline installation manual: rollers that do not turn wear the pins",
}
"""Texts of the catalogue whose words between places are put together from several of the source."""


@pytest.mark.slow
def test_every_text_of_the_catalogue_is_one_of_the_source() -> None:
    package = Path(wording.__file__).parents[1]
    closed_forms = Path(limits.__file__).parent
    modules = [
        path for room in ("drive_lines", "report") for path in (package / room).rglob("*.py")
    ]
    said = [
        node.value
        for path in [*modules, closed_forms / "limits.py"]
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    ]
    said += [path.read_text(encoding="utf-8") for path in (package / "report").rglob("*.html*")]
    said += [
        text for rule in RULES.values() for text in (rule.title, rule.source, *rule.assumptions)
    ]
    source = "\n".join([*said, *(text.replace("_", " ") for text in said)])
    stale = {
        english
        for texts in wording.catalogue().values()
        for english in texts
        if any(part.strip(" ,:") not in source for part in PLACES.split(english)[::2])
    }
    assert stale == PUT_TOGETHER


def literals(path: Path) -> set[str]:
    """Texts of more than a word in a module of rules that are neither docstrings nor errors."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    left_out: set[int] = set()
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        for item in body if isinstance(body, list) else []:
            if isinstance(item, ast.Expr) and isinstance(item.value, ast.Constant):
                left_out.add(id(item.value))
        if isinstance(node, ast.Raise):
            left_out |= {id(item) for item in ast.walk(node)}
        if isinstance(node, ast.JoinedStr):
            left_out |= {id(item) for part in node.values for item in ast.walk(part)}
    found = set()
    for node in ast.walk(tree):
        is_text = isinstance(node, ast.Constant) and isinstance(node.value, str)
        if is_text and id(node) not in left_out and re.search(r"[a-z]{3,} [a-z]", node.value):
            found.add(node.value)
    return found


def test_every_plain_text_of_the_rules_is_in_the_catalogue() -> None:
    rooms = Path(wording.__file__).parent / "verdict"
    german = Wording("de")
    unknown = {
        part
        for path in rooms.glob("*_rules.py")
        for text in literals(path)
        for part in text.rstrip(": ").split("; ")
        if german.clause(part.removeprefix("give ")) is None and german.clause(part) is None
    }
    # Parts of sentences that are put together.
    assert unknown == {
        "not needed",
        "travel or profile",
        "friction and radius of the spline",
    }


@pytest.mark.slow
def test_every_text_of_a_verdict_is_in_the_catalogue() -> None:
    german, unknown = Wording("de"), set()
    lines = [DriveLine.from_toml(name) for name in examples()]
    lines += [random_line(count, seed, mass=True) for count in (1, 2, 3, 5) for seed in range(2)]
    lines = [line if line.duty_cycle else line.replace(speed=90.0, torque=300.0) for line in lines]
    bare = random_line(2, 3)
    lines += [bare, bare.replace(torque=20.0), bare.replace(application="vehicle", speed=600.0)]
    for line in lines:
        for row in line.verdict():
            for text in (row.quantity, row.note, *row.broken, *(i.what for i in row.inverses)):
                unknown |= {part for part in text.split("; ") if german.clause(part) is None}
            assert BY_UNIT[row.unit]
            assert german(RULES[row.rule].title)
            assert all(german(text) for text in RULES[row.rule].assumptions)
    assert unknown <= {""}
