import pytest

from cardan_dyn import ModelError
from cardan_dyn.drive_lines import Bearing, DriveLine, Shaft, Spline
from cardan_dyn.practice.drive_lines.line.supports import spline_distance, supports

ENDS = [Bearing(distance=0.1), Bearing(distance=0.3)]


def line(*middle: Shaft, ends: tuple[list[Bearing], list[Bearing]] = (ENDS, ENDS)) -> DriveLine:
    return DriveLine(shafts=[Shaft(bearings=ends[0]), *middle, Shaft(bearings=ends[1])])


def shaft(*bearings: float | Bearing, spline: float | None = None) -> Shaft:
    """A shaft of 1 m."""
    held = [b if isinstance(b, Bearing) else Bearing(distance=b) for b in bearings]
    return Shaft(
        length=1, bearings=held, spline=None if spline is None else Spline(distance=spline)
    )


def test_names_along_the_power_flow() -> None:
    found = supports(line(shaft(0.8), shaft(spline=0.5)))
    assert [item.name for item in found.bearings] == ["B", "A", "C1", "E", "F"]
    assert [item.name for item in found.bearings if item.locating] == ["B", "E"]
    assert found.indeterminate == ()


@pytest.mark.parametrize("count", [2, 3, 5, 64])
def test_usual_lines_are_determinate(count: int) -> None:
    middle = [shaft(0.8) for _ in range(count - 2)]
    assert supports(line(*middle, shaft(spline=0.5))).indeterminate == ()
    assert supports(line(shaft(spline=0.5), *middle)).indeterminate == ()
    every = [shaft(0.8, spline=0.1) for _ in range(count - 2)]
    found = supports(line(*every, shaft(spline=0.5)))
    assert found.indeterminate == ()
    # Between two splines something has to hold the line along its axis.
    centre = [item.locating for item in found.bearings if item.shaft not in (0, count)]
    assert centre == [True] * (count - 2)


def test_no_bearings_at_an_end_stand_for_one_at_its_joint() -> None:
    assert supports(line(shaft(spline=0.5), ends=([], []))).indeterminate == ()
    assert supports(line(shaft(spline=0.5), ends=([], []))).bearings == ()


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (line(), ["output is held across its axis at 3", "held along its axis by 2 bearings; an"]),
        (line(shaft()), ["the line is held along its axis by 2 bearings; an intermediate shaft"]),
        (line(shaft(0.5, spline=0.6)), ["output is held across its axis at 3"]),
        (
            line(shaft(spline=0.5), ends=([*ENDS, Bearing(distance=0.2)], ENDS)),
            ["input is held across its axis at 3 places"],
        ),
        (
            line(shaft(Bearing(distance=0.5, locating=True)), shaft(spline=0.5)),
            ["what lies before the spline of shaft_2 is held along its axis by 2"],
        ),
    ],
)
def test_what_statics_leaves_open(made: DriveLine, words: list[str]) -> None:
    found = supports(made).indeterminate
    assert len(found) == len(words)
    for text, expected in zip(found, words, strict=True):
        assert expected in text


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (line(shaft(), shaft(spline=0.5)), "nothing holds joint 2 between shaft_1 and shaft_2"),
        (line(shaft(spline=0.5), ends=(ENDS[:1], ENDS)), "nothing holds joint 1 between input"),
        (line(shaft(spline=0.5), ends=(ENDS, ENDS[:1])), "output is not held .* it has 1"),
        (
            line(shaft(spline=0.1), shaft(Bearing(distance=0.5, locating=False), spline=0.9)),
            "nothing holds what lies between the splines of shaft_1 and shaft_2 along its axis",
        ),
        (
            line(
                shaft(spline=0.5),
                ends=([Bearing(distance=d, locating=False) for d in (1, 2)], ENDS),
            ),
            "nothing holds what lies before the spline of shaft_1 along its axis; make one",
        ),
        (
            line(shaft(spline=0.5), ends=([Bearing(distance=1, name="E"), *ENDS[:1]], ENDS)),
            "the name 'E' is given to one bearing and is the plain one of another",
        ),
    ],
)
def test_what_is_missing(made: DriveLine, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        supports(made)


def test_bearings_behind_a_spline() -> None:
    found = supports(line(shaft(0.6, spline=0.5), shaft(spline=0.5)))
    assert [item.behind for item in found.bearings] == [False, False, True, False, False]
    assert spline_distance(line(Shaft(length=3, spline=Spline())), 1) == 1.5


def test_said_to_be_locating_or_not() -> None:
    far = [Bearing(distance=0.1, locating=False), Bearing(distance=0.3)]
    found = supports(line(shaft(spline=0.5), ends=(far, ENDS)))
    assert [item.name for item in found.bearings if item.locating] == ["A", "E"]


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (("A", "A_y"), "the name 'A_y' is that of an adjustable joint or link of the bearing 'A'"),
        (("bearing_out", ""), "the name 'bearing_out' is that of the bearing of an end shaft"),
    ],
)
def test_names_that_others_have(names: tuple[str, str], message: str) -> None:
    bearings = [Bearing(distance=x, name=name) for x, name in zip((0.1, 0.2), names, strict=True)]
    line = DriveLine(shafts=[Shaft(bearings=bearings), Shaft(slope_side=0.1)])
    with pytest.raises(ModelError, match=message):
        line.to_urdf()
