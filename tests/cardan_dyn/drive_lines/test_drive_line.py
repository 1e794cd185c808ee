import pytest

from cardan_dyn import ModelError
from cardan_dyn.drive_lines import DriveLine, Shaft, Spline

LINE = DriveLine(shafts=[Shaft(), Shaft(length=0.9, slope_side=-0.1, spline=Spline()), Shaft()])


def test_replace_makes_another_line() -> None:
    other = LINE.replace(speed=300)
    assert type(other) is DriveLine
    assert (other.speed, other.shafts) == (300.0, LINE.shafts)
    assert LINE.speed is None


def test_replace_knows_its_fields() -> None:
    with pytest.raises(ModelError, match=r"no field 'sped'; fields: .*did you mean 'speed'"):
        LINE.replace(sped=3)
    with pytest.raises(ModelError, match="speed of a DriveLine is nan"):
        LINE.replace(speed=float("nan"))


def test_text_and_back() -> None:
    assert DriveLine.from_toml(LINE.to_toml()) == LINE
