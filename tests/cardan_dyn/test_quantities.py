"""Quantities as texts: prefixes, digits, what is nothing or not known."""

import math

import numpy as np
import pytest

from cardan_dyn.kit.quantities import NONE, amount, column, number, prefix, span


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (140_200.0, "N", "140.2 kN"),
        (0.00026, "m", "0.26 mm"),
        (3e-6, "m", "3 µm"),
        (0.25, "N", "0.25 N"),
        (0.025, "N", "25 mN"),
        (0.25, "m", "250 mm"),
        (71.6e9, "Pa", "71.6 GPa"),
        (-999.96, "N·m", "-1 kN·m"),
        (999.94, "N·m", "999.9 N·m"),
        (0.1751, "N/mm", "0.1751 N/mm"),
        (2500.0, "N·m/rad", "2.5 kN·m/rad"),
        (12_345.6, "kg", "12346 kg"),
        (123_456.0, "rad/s", "123456 rad/s"),
        (30.25, "°", "30.25°"),
        (0.0, "N", "0 N"),
        (1.5, "", "1.5"),
        (math.nan, "N", f"{NONE} N"),
        (1e30, "N", "1e+30 N"),
    ],
)
def test_amounts(value: float, unit: str, text: str) -> None:
    assert amount(value, unit) == text


def test_a_column_has_one_unit_and_as_many_decimals() -> None:
    texts, unit = column([140_200.0, -2.5, 0.0, math.nan, -63_250.0, 1e-10], "N")
    assert (texts, unit) == (["140.2", "0.0", "0", NONE, "-63.2", "0"], "kN")
    assert column([], "N") == ([], "N")
    assert column([math.nan, math.inf], "N") == ([NONE, NONE], "N")


def test_no_value_moves_by_more_than_half_of_its_last_digit() -> None:
    rng = np.random.default_rng(3)
    for value in rng.choice([-1.0, 1.0], 500) * 10.0 ** rng.uniform(-11.0, 14.0, 500):
        for unit in ("N", "m", "kg"):
            scale, _ = prefix(abs(value), unit)
            told = float(amount(value, unit).split()[0]) * scale
            assert told == pytest.approx(value, rel=5.0001e-4)
            if unit == "N" and 1e-9 < abs(value) < 1e14:
                assert 0.1 <= abs(told / scale) < 1000.0
    assert number(1e7 / 3.0) == "3.333e+06"


@pytest.mark.parametrize(
    ("ends", "unit", "text"),
    [
        ((0.0, 8e-5), "m", "0 … 0.08 mm"),
        ((-7.5, 7.5), "m", "-7.5 … 7.5 m"),
        ((-1e-15, 180.0), "°", "0° … 180°"),
        ((-2e3, 5.0), "N", "-2 … 0.005 kN"),
        ((5.0, 5.0), "N", "5 N"),
        ((0.5, 2.0), "", "0.5 … 2"),
    ],
)
def test_spans_have_one_unit(ends: tuple[float, float], unit: str, text: str) -> None:
    assert span(*ends, unit) == text
