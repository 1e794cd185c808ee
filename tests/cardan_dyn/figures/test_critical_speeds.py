import numpy as np
import pytest

from cardan_dyn import ArgumentError
from cardan_dyn.figures.critical_speeds import (
    campbell,
    critical_speed_map,
    orders_over_speed,
    stability_chart,
)

SPEED = np.linspace(10.0, 100.0, 31)
PER_MINUTE = 30.0 / np.pi
ANGLE = np.radians([0.0, 10.0, 20.0])


def curves(axes: object) -> dict[str, object]:
    return {line.get_label(): line for line in axes.lines}  # type: ignore[attr-defined]


def test_campbell_has_modes_orders_and_critical_speeds() -> None:
    modes = np.stack([40.0 - 0.1 * SPEED, 40.0 + 0.1 * SPEED, 0.0 * SPEED], axis=1)
    whirl = np.stack([-1.0 + 0.0 * SPEED, 1.0 + 0.0 * SPEED, 0.0 * SPEED], axis=1)
    figure = campbell(SPEED, modes, whirl=whirl, critical=[(20.0, 40.0)], orders=(1, 2))
    (axes,) = figure.axes
    found = curves(axes)
    assert {"mode 1, backward", "mode 2, forward", "mode 3", "critical speed"} <= set(found)
    forward = found["mode 2, forward"]
    assert forward.get_xdata() == pytest.approx(SPEED * PER_MINUTE)
    assert forward.get_ydata() == pytest.approx(modes[:, 1] / (2.0 * np.pi))
    # A mode that does not swing is not drawn as one of frequency zero.
    assert np.all(np.isnan(found["mode 3"].get_ydata()))
    rays = [line for line in axes.lines if line.get_label().startswith("_")]
    slopes = [line.get_ydata()[-1] / line.get_xdata()[-1] for line in rays]
    # n× in Hz over 1/min is n / 60.
    assert slopes == pytest.approx([1.0 / 60.0, 2.0 / 60.0])
    assert [text.get_text() for text in axes.texts] == ["1×", "2×"]
    assert found["critical speed"].get_xdata() == pytest.approx([20.0 * PER_MINUTE])
    assert axes.get_xlabel() == "speed [1/min]" and axes.get_ylabel().endswith("[Hz]")


def test_orders_rise_with_the_speed_of_a_drive_that_turns_back() -> None:
    back, modes = -SPEED[::-1], np.full((31, 1), 80.0)
    (axes,) = campbell(back, modes, orders=(1, 2)).axes
    rays = [line for line in axes.lines if line.get_label().startswith("_")]
    for line, order, text in zip(rays, (1.0, 2.0), axes.texts, strict=True):
        assert line.get_ydata() == pytest.approx(-order / 60.0 * np.asarray(line.get_xdata()))
        # Their names stand on them, within the figure.
        assert text.xy[1] == pytest.approx(-order / 60.0 * text.xy[0])
        assert 0.0 < text.xy[1] <= axes.get_ylim()[1] * (1.0 + 1e-12)


def test_critical_speed_map_leaves_out_what_does_not_exist() -> None:
    stiffness = np.array([1e4, 1e5, 1e6])
    speeds = {"2× forward": [10.0, np.inf, 30.0], "2× backward": [5.0, 6.0, 7.0]}
    (axes,) = critical_speed_map(stiffness, speeds, operating=(8.0, 9.0)).axes
    line = curves(axes)["2× forward"]
    assert np.isnan(line.get_ydata()[1]) and line.get_ydata()[2] == pytest.approx(30.0 * PER_MINUTE)
    assert axes.get_xscale() == axes.get_yscale() == "log"
    assert "operating range" in axes.get_legend_handles_labels()[1]
    assert axes.get_xlabel() == "bearing stiffness [N/m]"


def test_points_beside_the_curves_of_orders() -> None:
    """Within the range of speeds; the axes reach up to them."""
    points = {"peak": [(50.0, 0.7), (200.0, 0.9)], "jump": [(500.0, 1.0)], "none": []}
    (axes,) = orders_over_speed(SPEED, {"2×": 1e-3 / SPEED}, unit="rad", peaks=points).axes
    found = curves(axes)
    assert set(found) == {"2×", "peak"}
    assert found["peak"].get_xdata() == pytest.approx([50.0 * PER_MINUTE])
    assert found["peak"].get_ydata() == pytest.approx([0.7])
    assert found["peak"].get_linestyle() == "None" and axes.get_ylim()[1] > 0.7


def test_orders_over_speed_with_phases() -> None:
    amplitudes = {"2×": 1e-3 / SPEED, "4×": 1e-12 * SPEED}
    phases = {"2×": np.linspace(0.0, 9.0, 31)}
    figure = orders_over_speed(
        SPEED, amplitudes, unit="rad", phases=phases, critical={"ωₙ/2": 50.0}
    )
    top, bottom = figure.axes
    assert curves(top)["2×"].get_ydata() == pytest.approx(1e-3 / SPEED)
    assert top.get_ylabel() == "amplitude [rad]" and top.get_yscale() == "log"
    # Rounding does not stretch the scale.
    assert top.get_ylim()[0] >= 1e-10
    assert bottom.lines[0].get_ydata() == pytest.approx(np.degrees(phases["2×"]))
    assert bottom.get_ylabel() == "phase [°]"
    assert [text.get_text() for text in top.texts] == ["ωₙ/2"]
    (only,) = orders_over_speed(SPEED, amplitudes, unit="m", logarithmic=False).axes
    assert only.get_yscale() == "linear"


def test_a_mode_that_no_order_reaches_leaves_the_others_their_scale() -> None:
    modes = np.stack([40.0 + SPEED, 1e5 + 0.0 * SPEED], axis=1)
    figure = campbell(SPEED, modes, orders=(1, 2))
    (axes,) = figure.axes
    assert axes.get_ylim()[1] == pytest.approx(1.15 * np.max(modes[:, 0]) / (2.0 * np.pi))
    told = figure.legends[0].get_title().get_text().replace("\n", " ")
    assert told == "above, where no order crosses: mode 2 at 15.92 kHz"
    # One alone is shown, wherever it is; one that an order crosses as well.
    (axes,) = campbell(SPEED, modes[:, 1:], orders=(1, 2)).axes
    assert axes.get_ylim()[1] > 1e5 / (2.0 * np.pi)
    (axes,) = campbell(SPEED, modes, orders=(1, 1e4)).axes
    assert axes.get_ylim()[1] > 1e5 / (2.0 * np.pi)


def test_campbell_of_a_drive_that_turns_back() -> None:
    modes = np.full((31, 1), 40.0)
    (axes,) = campbell(-SPEED[::-1], modes, orders=2).axes
    (ray,) = [line for line in axes.lines if line.get_label().startswith("_")]
    assert ray.get_ydata() == pytest.approx(2.0 * SPEED[::-1] / (2.0 * np.pi))
    (text,) = axes.texts
    # Where the line leaves the figure: 15 % above the mode.
    assert text.xy[0] == pytest.approx(-1.15 * 40.0 / 2.0 * PER_MINUTE)
    assert text.xy[1] == pytest.approx(1.15 * 40.0 / (2.0 * np.pi))


def test_rounding_has_no_name_in_a_legend() -> None:
    amplitudes = {"y, 1×": 1e-3 / SPEED, "y, 2×": 1e-12 * SPEED, "z, 1×": 2e-3 / SPEED}
    (axes,) = orders_over_speed(SPEED, amplitudes, unit="m").axes
    assert axes.get_legend_handles_labels()[1] == ["y, 1×", "z, 1×"]
    (axes,) = orders_over_speed(SPEED, amplitudes, unit="m", logarithmic=False).axes
    assert len(axes.lines) == 3


def chart(*intervals: list[tuple[float, float, str]], **options: object) -> object:
    (axes,) = stability_chart(ANGLE, intervals, ends=(SPEED[0], SPEED[-1]), **options).axes
    return axes


def test_a_chart_without_instability_says_so() -> None:
    axes = chart([], [], [], joint="offset", slides=True)
    assert [text.get_text() for text in axes.texts] == ["stable everywhere"]
    assert axes.get_ylabel() == "offset [mm]"
    assert axes.get_ylim() == pytest.approx((0.0, ANGLE[-1]))
    assert not chart([], [(20.0, 20.0, "fold")], []).texts


def test_stability_chart_draws_every_interval() -> None:
    """Half way to the angles beside it; the narrowest by its edges."""
    narrow = 50.0 + 1e-9
    axes = chart(
        [(20.0, 30.0, "instability")],
        [(18.0, 32.0, "instability"), (50.0, narrow, "combination")],
        [(10.0, 12.0, "no motion")],
    )
    assert axes.get_legend_handles_labels()[1] == ["instability", "combination", "no motion"]
    assert axes.get_ylim() == pytest.approx((0.0, 20.0))
    assert axes.get_xlim() == pytest.approx((SPEED[0] * PER_MINUTE, SPEED[-1] * PER_MINUTE))
    assert axes.get_ylabel() == "joint angle [°]"
    boxes = [item.get_paths()[0].get_extents() for item in axes.collections[::2]]
    expected = [(20.0, 30.0, 0.0, 5.0), (18.0, 32.0, 5.0, 15.0), (50.0, narrow, 5.0, 15.0)]
    for box, (lower, upper, low, high) in zip(boxes, expected, strict=False):
        assert (box.x0, box.x1) == pytest.approx((lower * PER_MINUTE, upper * PER_MINUTE))
        assert (box.y0, box.y1) == pytest.approx((low, high))
    edges = axes.collections[5].get_segments()
    assert [line[0][0] for line in edges] == pytest.approx([50.0 * PER_MINUTE] * 2)
    assert axes.collections[5].get_linewidth()[0] > 0.5


@pytest.mark.parametrize(
    ("draw", "message"),
    [
        (lambda: campbell(SPEED, SPEED), r"'frequency' has shape \(31,\)"),
        (
            lambda: campbell(SPEED, SPEED[:, None], whirl=[1.0]),
            "'whirl' has shape",
        ),
        (lambda: campbell([np.nan], [[1.0]]), "speed has shape"),
        (
            lambda: campbell(SPEED, SPEED[:, None], orders="2"),
            "orders is not an array",
        ),
        (lambda: critical_speed_map(SPEED, {"a": [1.0]}), "'a' has shape"),
        (
            lambda: orders_over_speed(SPEED, {"a": [1.0]}, unit="m"),
            "'a' has shape",
        ),
        (lambda: chart([], []), "3 angles, 2 lists of intervals"),
        (lambda: chart([], [(1.0, 2.0, "stable")], []), "'stable' is no kind of interval"),
        (
            lambda: stability_chart(ANGLE[:1], [[]], ends=(1.0, 2.0)),
            "needs two angles",
        ),
    ],
)
def test_shapes_that_do_not_match(draw: object, message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        draw()  # type: ignore[operator]
