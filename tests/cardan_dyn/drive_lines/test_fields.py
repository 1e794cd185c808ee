from dataclasses import dataclass

import numpy as np
import pytest

from cardan_dyn import ModelError
from cardan_dyn.kit.units import DIMENSIONS
from cardan_dyn.practice.drive_lines.line import fields


@dataclass(frozen=True, kw_only=True)
class Inner:
    size: float = fields.quantity("number", least=0.0, most=2.0)

    def __post_init__(self) -> None:
        fields.settle(self)


@dataclass(frozen=True, kw_only=True)
class Outer:
    angle: float = fields.quantity("angle", 0.0, above=-1.0, below=1.0)
    place: tuple[float, float, float] | None = fields.point()
    name: str = fields.text()
    loose: bool | None = fields.flag()
    one: Inner | None = fields.part(Inner)
    many: tuple[Inner, ...] = fields.parts(Inner)

    def __post_init__(self) -> None:
        fields.settle(self)


def test_values_become_plain() -> None:
    made = Outer(
        angle=np.float32(0.5), place=np.array([1, 2, 3]), loose=np.True_, many=[Inner(size=1)]
    )
    assert type(made.angle) is float
    assert made.place == (1.0, 2.0, 3.0)
    assert all(type(item) is float for item in made.place)
    assert made.loose is True
    assert made.many == (Inner(size=1.0),)
    assert hash(made) == hash(Outer(angle=0.5, place=[1, 2, 3], loose=True, many=(Inner(size=1),)))


@pytest.mark.parametrize("value", [1.0, -1.0, 7, float("nan"), float("inf"), 10**400])
def test_numbers_out_of_their_limits(value: float) -> None:
    with pytest.raises(ModelError, match=r"angle of a Outer is .*greater than -1 and less than 1"):
        Outer(angle=value)


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("angle", True, "angle of a Outer is True"),
        ("angle", "5", "angle of a Outer is '5'"),
        ("angle", np.timedelta64(1, "s"), "angle of a Outer"),
        ("place", (1, 2), "has 2 numbers, expected three"),
        ("place", "abc", "expected three numbers"),
        ("place", (0, 0, np.nan), r"place of a Outer\[2\] is nan"),
        ("name", 3, "expected a text"),
        ("loose", 1, "expected True or False"),
        ("one", 3, "expected a Inner"),
        ("many", 3, "expected a sequence of Inner"),
        ("many", [Inner(size=1), 3], r"many of a Outer\[1\] is 3, expected a Inner"),
    ],
)
def test_other_values(field: str, value: object, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        Outer(**{field: value})


def test_limits_in_the_unit_of_a_file() -> None:
    entry = fields.entries(Outer)["angle"][1]
    assert entry.allowed(DIMENSIONS["angle"][0]).endswith(
        "greater than -57.2958 and less than 57.2958 [deg]"
    )
    assert fields.entries(Inner)["size"][1].allowed() == (
        "a finite number at least 0 and at most 2"
    )
