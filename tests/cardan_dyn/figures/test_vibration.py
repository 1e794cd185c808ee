import numpy as np
import pytest

from cardan_dyn import ArgumentError
from cardan_dyn.figures import vibration
from cardan_dyn.figures.vibration import orbits, over_revolution, run_up

SPEED = np.linspace(10.0, 100.0, 31)


def curves(axes: object) -> dict[str, object]:
    return {line.get_label(): line for line in axes.lines}  # type: ignore[attr-defined]


def test_orbits_have_equal_scales() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 50)
    path = np.stack([2.0 * np.cos(turn), np.sin(turn)], axis=1)
    (axes,) = orbits({"at 50 rad/s": path}, labels=("a [rad]", "b [rad]")).axes
    assert axes.get_aspect() == 1.0
    assert axes.lines[0].get_xydata() == pytest.approx(path)
    assert axes.lines[1].get_xydata() == pytest.approx(path[:1])


def test_run_up_draws_predictions_to_both_sides() -> None:
    predicted = {"linear": (SPEED[:3], [1.0, 2.0, 3.0])}
    (axes,) = run_up(SPEED, np.sin(SPEED), unit="rad", predicted=predicted).axes
    assert curves(axes)["simulated"].get_ydata() == pytest.approx(np.sin(SPEED))
    assert [line.get_ydata()[2] for line in axes.lines[1:]] == [3.0, -3.0]


def test_torque_over_speed_marks_barriers_and_where_a_drive_is_held() -> None:
    torque = np.sin(SPEED)
    (axes,) = vibration.torque_over_speed(
        SPEED, torque, available=0.5 + 0.0 * SPEED, barriers=[(2.0, 1.0), (3.0, 0.7)], held=1.5
    ).axes
    found = curves(axes)
    assert found["absorbed"].get_ydata() == pytest.approx(torque)
    assert set(found["of the drive"].get_ydata()) == {0.5}
    assert found["barrier"].get_xdata()[0] == pytest.approx(2.0 * 30.0 / np.pi)
    assert found["held"].get_xdata() == pytest.approx([1.5 * 30.0 / np.pi] * 2)
    (plain,) = vibration.torque_over_speed(SPEED, torque).axes
    assert list(curves(plain)) == ["absorbed"]


def test_coordinates_and_coefficients_over_a_revolution() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 37)
    values = np.stack([np.sin(turn), np.cos(turn)], axis=1)
    (axes,) = over_revolution(turn, values, ("tilt_z", "tilt_y")).axes
    assert list(curves(axes)) == ["tilt_z", "tilt_y"]
    assert axes.lines[1].get_ydata() == pytest.approx(np.cos(turn))
    assert axes.get_ylabel() == "free coordinates [rad, m]"
    (axes,) = over_revolution(turn, values, ("y", "z"), unit="m").axes
    assert axes.get_ylabel() == "free coordinates [m]"
    matrices = {"mass": np.ones((37, 2, 2)), "stiffness": np.zeros((37, 2, 2))}
    mass, stiffness = vibration.coefficients(turn, matrices, ("tilt_z", "tilt_y")).axes
    assert [line.get_label() for line in mass.lines] == [
        "tilt_z",
        "tilt_z, tilt_y",
        "tilt_y, tilt_z",
        "tilt_y",
    ]
    assert stiffness.get_ylabel() == "stiffness"
    uneven = {"damping": np.broadcast_to([[1.0, 2.0], [3.0, 4.0]], (37, 2, 2))}
    (damping,) = vibration.coefficients(turn, uneven, ("tilt_z", "tilt_y")).axes
    assert [line.get_ydata()[0] for line in damping.lines] == [1.0, 2.0, 3.0, 4.0]
    # What is zero beside the rest has no line, and no name in the legend.
    assert not stiffness.lines
    matrices["mass"][:, 0, 1] = 1e-12
    mass, _ = vibration.coefficients(turn, matrices, ("tilt_z", "tilt_y")).axes
    assert "tilt_z, tilt_y" not in [line.get_label() for line in mass.lines]


def test_multipliers_over_speed() -> None:
    sizes = np.column_stack([SPEED, 1.0 / SPEED])
    (axes,) = vibration.multipliers(SPEED, sizes, title="growth").axes
    assert axes.lines[1].get_ydata() == pytest.approx(1.0 / SPEED)
    assert axes.get_title() == "growth"
    # From one on, motions grow.
    assert set(axes.lines[2].get_ydata()) == {1.0}


def test_multipliers_stand_before_the_intervals_between_their_speeds() -> None:
    sizes = np.ones((len(SPEED), 1))
    spans = [(20.0, 20.0 + 1e-9, "fold"), (30.0, 31.0, "fold")]
    (axes,) = vibration.multipliers(SPEED, sizes, intervals=spans).axes
    assert axes.get_legend_handles_labels()[1] == ["multiplier 1", "fold"]
    edges = [line.get_xdata()[0] for line in axes.lines[1:5]]
    assert edges == pytest.approx([at * 30.0 / np.pi for span in spans for at in span[:2]])


@pytest.mark.parametrize(
    ("draw", "message"),
    [
        (lambda: orbits({"a": SPEED}, labels=("", "")), "'a' has shape"),
        (lambda: run_up(SPEED, [1.0], unit="m"), "'values' has shape"),
        (lambda: over_revolution(SPEED, SPEED, ("a",)), "'values' has shape"),
        (lambda: vibration.coefficients(SPEED, {"mass": SPEED}, ("a",)), "'mass' has shape"),
        (lambda: vibration.multipliers(SPEED, SPEED), "'sizes' has shape"),
        (lambda: vibration.torque_over_speed(SPEED, [1.0]), "'torque' has shape"),
    ],
)
def test_shapes_that_do_not_match(draw: object, message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        draw()  # type: ignore[operator]
