"""Looking at studies: figures of what is there, and Sobol indices against their closed form."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm, uniform

import cardan_dyn as cd
from cardan_dyn import studies

A, B = 7.0, 0.1


def ishigami(x1: float, x2: float, x3: float) -> float:
    return np.sin(x1) + A * np.sin(x2) ** 2 + B * x3**4 * np.sin(x1)


@pytest.fixture(scope="module")
def sampled() -> studies.Study:
    law = uniform(-np.pi, 2.0 * np.pi)
    parameters = studies.sobol_samples({"x1": law, "x2": law, "x3": law}, 1024, seed=0)
    return cd.study(ishigami, parameters, vectorized=True, workers=1, chunk=1000).run()


def test_sobol_indices_are_those_of_the_closed_form(sampled: studies.Study) -> None:
    found = studies.sobol_indices(sampled.dataset, "value")
    # Ishigami and Homma (1990).
    v1 = 0.5 * (1.0 + B * np.pi**4 / 5.0) ** 2
    v2, v13 = A**2 / 8.0, B**2 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    total = v1 + v2 + v13
    expected = {"x1": v1 / total, "x2": v2 / total, "x3": 0.0}
    # As far as 1024 samples tell: halved by four times as many.
    assert found.first_order == pytest.approx(expected, abs=0.03)
    expected = {"x1": (v1 + v13) / total, "x2": v2 / total, "x3": v13 / total}
    assert found.total == pytest.approx(expected, abs=0.03)


@pytest.mark.slow
def test_intervals_of_sobol_indices_hold_what_they_are_for() -> None:
    """A sum of three normal numbers: the part of each is its variance's, also in total."""
    weights = np.array([1.0, 2.0, 3.0])
    laws = {f"x{index}": norm(0.0, weight) for index, weight in enumerate(weights)}
    expected = weights**2 / np.sum(weights**2)

    def intervals(count: int, seed: int) -> np.ndarray:
        given = studies.sobol_samples(laws, count, seed=seed)
        study = cd.study(lambda x0, x1, x2: x0 + x1 + x2, given, vectorized=True, workers=1).run()
        found = studies.sobol_indices(study.dataset, "value")
        if seed == 0:
            assert found == studies.sobol_indices(study.dataset, "value")
        parts = found.first_order_interval, found.total_interval
        return np.array([list(part.values()) for part in parts])

    few = np.array([intervals(32, seed) for seed in range(12)])
    holds = (few[..., 0] <= expected) & (expected <= few[..., 1])
    assert np.mean(holds) > 0.9
    # As wide as the root of the number of samples says.
    widths = np.ptp(few, axis=-1).mean(axis=0) / np.ptp(intervals(2048, 1), axis=-1)
    assert np.all((widths > 4.0) & (widths < 16.0))


def test_sobol_indices_of_what_does_not_vary_are_refused() -> None:
    given = studies.sobol_samples({"x": norm(0.0, 1.0)}, 8, seed=1)
    study = cd.study(lambda x: 2.0, given, workers=1).run()
    with pytest.raises(cd.ArgumentError, match="same in all cases"):
        studies.sobol_indices(study.dataset, "value")


def test_independent_samples_are_two_of_each(sampled: studies.Study) -> None:
    plain = studies.independent(sampled.dataset)
    assert plain.sizes == {"sample": 2048}
    assert float(plain.value.mean()) == pytest.approx(A / 2.0, abs=0.1)
    assert len(np.unique(plain.x1)) == 2048


def test_sobol_indices_of_other_studies_are_refused() -> None:
    grid = cd.study(squares, {"x": [1.0, 2.0]}, workers=1).run()
    with pytest.raises(cd.ArgumentError, match="sobol_samples"):
        studies.sobol_indices(grid.dataset, "value")


def squares(x: float) -> float:
    return x**2


def bowl(angle: float, length: float, count: float) -> dict[str, float]:
    if angle > 0.4 and length > 2.5:
        raise ValueError("out of reach")
    return {"force": angle**2 + length * count, "curve": np.array([1.0, angle])}


@pytest.fixture(scope="module")
def grid() -> studies.Study:
    parameters = {
        "angle": (np.linspace(0.0, 0.5, 6), "rad"),
        "length": (np.linspace(1.0, 3.0, 5), "m"),
        "count": np.array([1.0, 2.0, 3.0]),
    }
    return cd.study(bowl, parameters, units={"force": "N"}, workers=1).run()


def test_maps_and_contours_show_what_is_there(grid: studies.Study) -> None:
    figure = studies.plot_map(grid.dataset, "force", x="angle", y="length", count=2.2, limit=3.0)
    axes, colours = figure.axes
    assert axes.get_xlabel() == "angle [°]"
    assert axes.get_ylabel() == "length [m]"
    assert colours.get_ylabel() == "force [N]"
    cells = np.ma.filled(axes.collections[0].get_array(), np.nan).reshape(5, 6)
    expected = grid.dataset.force.sel(count=2.0).values.T
    np.testing.assert_array_equal(cells, expected)
    assert np.isnan(cells[-1, -1])
    assert "count = 2" in figure.axes[0].get_title()
    # Grey is a case that failed: the legend says so, and of how many.
    (legend,) = figure.legends
    missing = int(np.isnan(expected).sum())
    assert [text.get_text() for text in legend.get_texts()] == [f"no result: {missing} of 30"]
    assert legend.get_patches()[0].get_facecolor() == axes.get_facecolor()
    # The first dimensions that are not given are those of the map.
    plain = studies.plot_map(grid.dataset, "force", count=2.2, title="bowl", figsize=(5.0, 4.0))
    assert plain.axes[0].get_xlabel() == "angle [°]"
    assert plain.axes[0].get_title() == "bowl, count = 2"
    contours = studies.plot_contours(
        grid.dataset, "force", x="length", y="count", angle=0.0, limit=4.0
    )
    limit = contours.axes[0].collections[-2]
    vertices = np.concatenate([path.vertices for path in limit.get_paths()])
    assert np.abs(vertices[:, 0] * vertices[:, 1] - 4.0).max() < 0.3  # Between two points of 0.5.


@pytest.mark.slow
def test_tornado_bars_reach_from_end_to_end(grid: studies.Study, sampled: studies.Study) -> None:
    axes = studies.plot_tornado(grid.dataset, "force").axes[0]
    middle = 0.3**2 + 2.0 * 2.0
    ends = {bar.get_x() + bar.get_width() for bar in axes.patches}
    for value in (0.09 + 1.0 * 2.0, 0.09 + 3.0 * 2.0, 0.09 + 2.0, 0.09 + 6.0, 4.0, 4.25):
        assert min(abs(value - end) for end in ends) < 1e-12
    assert axes.lines[0].get_xdata()[0] == pytest.approx(middle)
    assert len(studies.plot_tornado(sampled.dataset, "value").axes[0].patches) == 6


def test_points_and_lines_show_all_cases(grid: studies.Study, sampled: studies.Study) -> None:
    figure = studies.plot_scatter(sampled.dataset, "value", limit=10.0)
    assert [axes.get_xlabel() for axes in figure.axes] == ["x1", "x2", "x3"]
    assert len(figure.axes[0].lines[0].get_xdata()) == 2048
    figure = studies.plot_parallel(grid.dataset, "force", limit=5.0)
    there = int(grid.dataset.force.notnull().sum())
    lines = [line for line in figure.axes[0].lines if len(line.get_xdata()) == 4]
    assert len(lines) == there
    beyond = int((grid.dataset.force > 5.0).sum())
    assert sum(line.get_linestyle() == "--" for line in lines) == beyond


def test_what_cannot_be_drawn_is_said(grid: studies.Study) -> None:
    data = grid.dataset
    with pytest.raises(cd.ArgumentError, match="say at which value of count"):
        studies.plot_map(data, "force", x="angle", y="length")
    with pytest.raises(cd.ArgumentError, match="did you mean 'force'"):
        studies.plot_map(data, "forse", x="angle", y="length")
    with pytest.raises(cd.ArgumentError, match="no dimension 'speed'"):
        studies.plot_contours(data, "force", x="angle", y="speed")
    with pytest.raises(cd.ArgumentError, match="curve_index besides the parameters"):
        studies.plot_scatter(data, "curve")
    with pytest.raises(cd.ArgumentError, match="name results"):
        studies.plot_parallel(data)


def test_figures_say_what_they_show_and_where(grid: studies.Study) -> None:
    data = grid.dataset
    figure = studies.plot_contours(data, "force", x="length", y="count", angle=0.3, limit=4.0)
    assert figure.axes[0].get_title() == "force [N], angle = 17.19°, limit 4 N"
    figure = studies.plot_map(data, "force", x="angle", y="count", length=1.4)
    assert figure.axes[0].get_title() == "length = 1.5 m"
    labels = [
        text.get_text() for text in studies.plot_tornado(data, "force").axes[0].get_yticklabels()
    ]
    assert set(labels) == {"angle\n0 … 28.6°", "length\n1 … 3 m", "count\n1 … 3"}
    figure = studies.plot_scatter(data, "force")
    assert [axes.get_xlabel() for axes in figure.axes] == ["angle [°]", "length [m]", "count"]
    assert figure.axes[0].lines[0].get_xdata().max() == pytest.approx(np.rad2deg(0.5))


@pytest.mark.slow
def test_limits_beyond_all_values_are_said_and_hatched(grid: studies.Study) -> None:
    def hatched(limit: float) -> tuple[float, str]:
        figure = studies.plot_contours(
            grid.dataset, "force", x="length", y="count", angle=0.0, limit=limit
        )
        filled = [item for item in figure.axes[0].collections if getattr(item, "filled", False)]
        corners = [path.get_extents() for item in filled for path in item.get_paths()]
        return sum(box.width * box.height for box in corners), figure.axes[0].get_title()

    area = 2.0 * 2.0
    assert hatched(0.5) == (
        pytest.approx(area),
        "force [N], angle = 0°, limit 0.5 N exceeded everywhere",
    )
    assert hatched(100.0) == (0.0, "force [N], angle = 0°, limit 100 N nowhere exceeded")
    part, title = hatched(4.0)
    assert 0.0 < part < area
    assert title == "force [N], angle = 0°, limit 4 N"


def test_dimensions_whose_names_are_no_arguments_are_named_as_they_are_given() -> None:
    def result(**given: float) -> float:
        return sum(given.values())

    names = ("held.a", "held.b", "held.c")
    data = cd.study(result, {name: [1.0, 2.0] for name in names}, workers=1).run().dataset
    with pytest.raises(cd.ArgumentError, match=r'\*\*\{"held\.c": …\}'):
        studies.plot_contours(data, "value", x="held.a", y="held.b")


def test_studies_draw_themselves(grid: studies.Study, sampled: studies.Study) -> None:
    axes, colours = grid.plot().axes
    # Over the first two parameters, the third one in its middle.
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("angle [°]", "length [m]")
    assert colours.get_ylabel() == "force [N]" and "count = 2" in axes.get_title()
    axes, _ = grid.plot("force", x="count", y="length", angle=0.3).axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("count", "length [m]")
    axes, _ = grid.plot("force", y="angle").axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("length [m]", "angle [°]")
    assert [axes.get_xlabel() for axes in sampled.plot("value").axes] == ["x1", "x2", "x3"]
    tornado = studies.plot_tornado(grid.dataset, "force").axes[0]
    widths = [bar.get_width() for bar in grid.plot.tornado("force").axes[0].patches]
    assert widths == [bar.get_width() for bar in tornado.patches]
    assert "plot.parallel" in repr(grid.plot)


def test_one_parameter_is_a_line() -> None:
    def growth(angle: float) -> dict[str, float]:
        return {"force": angle**2}

    values = np.linspace(0.0, 0.5, 6)
    found = cd.study(growth, {"angle": (values, "rad")}, units={"force": "N"}, workers=1).run()
    (axes,) = found.plot().axes
    np.testing.assert_allclose(axes.lines[0].get_xdata(), np.rad2deg(values))
    np.testing.assert_allclose(axes.lines[0].get_ydata(), values**2)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("angle [°]", "[N]")


def humped(x: float, y: float) -> float:
    """Greatest in the middle of x, as great at one end as at the other; y matters little."""
    if x == 2.0 and y == 3.0:
        raise ValueError("out of reach")
    return 10.0 - (x - 3.0) ** 2 + 0.1 * y


@pytest.mark.slow
def test_tornado_lines_span_all_that_is_known_and_rank_parameters() -> None:
    """A result that is the same at both ends of a parameter has a bar of no width."""
    axes = {"y": np.arange(5.0), "x": np.arange(7.0)}
    data = cd.study(humped, axes, workers=1).run().dataset
    drawn = studies.plot_tornado(data, "value", title="hump").axes[0]
    assert drawn.get_title() == "hump, no result: 1 of 35"
    (lines,) = drawn.collections
    spans = [segment[:, 0].tolist() for segment in lines.get_segments()]
    # The widest last, on top: x from 1.2 to 10.2, though all bars of y are wider than its own.
    np.testing.assert_allclose(spans, [[10.0, 10.4], [1.2, 10.2]])
    assert [text.get_text().split("\n")[0] for text in drawn.get_yticklabels()] == ["y", "x"]
    gone = data.assign(value=data["value"].where((data.x != 3.0) | (data.y != 2.0)))
    with pytest.raises(cd.ArgumentError, match="the case in the middle of all has no result"):
        studies.plot_tornado(gone, "value")


@pytest.mark.slow
def test_tornado_lines_of_samples_span_the_means_of_all_tenths() -> None:
    given = studies.samples({"x": uniform(0.0, 6.0), "y": uniform(0.0, 1.0)}, 400, seed=1)
    data = cd.study(humped, given, vectorized=False, workers=1).run().dataset
    (lines,) = studies.plot_tornado(data, "value").axes[0].collections
    values, order = data["value"].values, np.argsort(data.x.values)
    means = [values[part].mean() for part in np.array_split(order, 10)]
    widest = lines.get_segments()[-1][:, 0]
    np.testing.assert_allclose(widest, [min(means), max(means)], rtol=0.02)
    assert widest[1] > 9.9 and abs(means[0] - means[-1]) < 1.0


def test_cases_without_a_result_are_counted_in_every_figure(grid: studies.Study) -> None:
    data = grid.dataset
    missing = int(data.force.isnull().sum())
    assert missing == 3
    said = f"no result: {missing} of {data.force.size}"
    assert studies.plot_scatter(data, "force", title="bowl").get_suptitle() == f"bowl, {said}"
    assert studies.plot_parallel(data, "force").axes[0].get_title() == said
    assert said in studies.plot_tornado(data, "force").axes[0].get_title()
    line = cd.study(lambda x: 1.0 / x if x else np.nan, {"x": [0.0, 1.0, 2.0]}, workers=1).run()
    assert line.plot(title="1/x").axes[0].get_title() == "1/x, no result: 1 of 3"
    # Some cells have none: nobody knows whether these exceed a limit.
    for limit, words in ((0.5, "exceeded everywhere"), (100.0, "nowhere exceeded")):
        figure = studies.plot_map(data, "force", x="angle", y="length", count=2.0, limit=limit)
        assert f"limit {limit:g} N {words} where there is a result" in figure.axes[0].get_title()


def test_sobol_indices_are_refused_where_a_case_is_missing() -> None:
    def number(x: float) -> float:
        if x > 1.5:
            raise ValueError("too great")
        return x

    given = studies.sobol_samples({"x": norm(0.0, 1.0)}, 16, seed=1)
    study = cd.study(number, given, workers=1).run()
    count = len(study.failures)
    assert count > 0
    with pytest.raises(cd.ArgumentError, match=f"value is missing in {count} cases"):
        studies.sobol_indices(study.dataset, "value")
