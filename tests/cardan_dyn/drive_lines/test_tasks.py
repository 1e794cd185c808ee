import numpy as np
import pytest
from testkit.line_data import double_shaft

from cardan_dyn import ArgumentError

LINE = double_shaft((0.0, 0.2, 0.0)).replace(speed=300, torque=400)


def test_what_is_not_given_comes_from_the_line() -> None:
    found = LINE.analyse()
    assert found.speed == 300.0
    assert found.static.drive_torque == pytest.approx(np.full(360, 400.0))
    assert found.position == pytest.approx(np.radians(np.arange(360)))
    other = LINE.analyse(speed=1, torque=2, positions=0.5)
    assert (other.speed, other.shape) == (1.0, (1,))
    assert other.static.drive_torque == pytest.approx([2.0])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"speed": np.nan}, "speed is not finite"),
        ({"speed": [1, 2]}, r"speed has shape \(2,\), expected a number"),
        ({"torque": [1, 2]}, r"torque has shape \(2,\), expected a number or a value per position"),
        ({"torque": "much"}, "torque is not an array of real numbers"),
        ({"positions": []}, r"positions has shape \(0,\)"),
        ({"positions": np.ones((2, 2))}, r"positions has shape \(2, 2\)"),
        ({"torque_at": "middle"}, "torque_at is 'middle', expected 'input' or 'output'"),
        (
            {"torque_at": np.zeros(3)},
            "torque_at is an array of type float64, expected 'input' or 'output'",
        ),
        ({"slipping": "sideways"}, "slipping is 'sideways', expected 'in', 'out' or None"),
        ({"slipping": 1}, "slipping is 1"),
        ({"gravity": 9.81}, r"gravity has shape \(\), expected \(3,\)"),
        ({"variants": 3}, "variants is 3, expected what variants"),
        ({"workers": 0}, "workers is 0"),
        ({"acceleration": "x"}, "acceleration is not"),
    ],
)
def test_wrong_arguments(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        LINE.analyse(**arguments)


def test_variants_of_another_line() -> None:
    other = double_shaft((0.0, 0.3, 0.0)).variants(angles=[[0.1, 0.1]])
    with pytest.raises(ArgumentError, match="variants are those of another line"):
        LINE.analyse(variants=other)
    # Another speed makes no difference.
    assert LINE.replace(speed=1).analyse(variants=LINE.variants()).shape == (1, 72)


def test_what_is_given_nowhere() -> None:
    line = double_shaft((0.0, 0.2, 0.0))
    with pytest.raises(ArgumentError, match="torque is given neither here nor by the line"):
        line.analyse(speed=1)
    with pytest.raises(ArgumentError, match="speed is given neither here nor by the line"):
        line.analyse(torque=1)
