"""Prefixes of axes: what a label and its ticks say together is what was drawn."""

import pickle
from typing import Any

import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.ticker import ScalarFormatter

import cardan_dyn as cd
from cardan_dyn.figures.style import settle

SIZE = {"N": 1.0, "kN": 1e3, "mN": 1e-3, "kN·m": 1e3, "N·m": 1.0, "m": 1.0, "mm": 1e-3, "°": 1.0}


@pytest.fixture(autouse=True)
def _close() -> Any:
    yield
    plt.close("all")


def sweep_with(load: float) -> cd.Sweep:
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", loads={"rocker_bearing": load})
    return scene.sweep(np.linspace(0.0, 2.0 * np.pi, 25))


def told(panel: Any, name: str = "y") -> str:
    """Return the unit of an axis, whose ticks are asserted to stand where they say they do."""
    panel.figure.canvas.draw()
    axis = {"x": panel.xaxis, "y": panel.yaxis}[name]
    unit = axis.get_label_text().rpartition("[")[2].removesuffix("]")
    texts = axis.get_major_formatter().format_ticks(axis.get_major_locator()())
    numbers = [float(text.replace("\N{MINUS SIGN}", "-")) for text in texts]
    assert not axis.get_major_formatter().get_offset()
    np.testing.assert_allclose(
        np.array(numbers) * SIZE[unit], axis.get_major_locator()(), atol=1e-12
    )
    return str(unit)


@pytest.mark.parametrize(
    ("loads", "units"),
    [((-5e3, -5.0), ["kN", "kN"]), ((-5.0, -5e3), ["N", "kN"]), ((-5e-4, -5e3), ["mN", "kN"])],
)
def test_axes_drawn_into_twice_say_what_all_lines_are(
    loads: tuple[float, float], units: list[str]
) -> None:
    _, panel = plt.subplots()
    found = []
    for load in loads:
        sweep_with(load).plot("crank_pin", ax=panel)
        found.append(told(panel))
    assert found == units


def test_axes_that_share_an_ordinate_have_one_prefix() -> None:
    _, (left, right) = plt.subplots(1, 2, sharey=True)
    sweep_with(-5e3).plot("crank_pin.shear", ax=left)
    sweep_with(-5.0).plot("drive_effort", ax=right)
    assert (told(left), told(right)) == ("kN", "kN·m")


def test_another_quantity_in_the_same_axes_is_written_as_it_is() -> None:
    sweep = sweep_with(-5e3)
    _, panel = plt.subplots()
    sweep.plot("crank_pin", ax=panel)
    sweep.plot("rocker_bearing.position", ax=panel)
    assert told(panel) == "°"


def test_other_limits_bring_another_prefix_and_all_digits() -> None:
    (panel,) = sweep_with(-5e3).plot("crank_pin.shear").axes
    for limits, unit in (((0.0, 2e4), "kN"), ((2e4, 2e4 + 0.05), "kN"), ((0.01, 0.02), "mN")):
        panel.set_ylim(*limits)
        panel.yaxis.get_major_formatter().set_useMathText(False)
        assert told(panel) == unit


def test_a_logarithmic_scale_has_no_prefix() -> None:
    (panel,) = sweep_with(-5e3).plot("crank_pin.shear").axes
    label = panel.get_ylabel()
    assert label.endswith("[kN]")
    panel.set_yscale("log")
    assert panel.get_ylabel() == label.replace("kN", "N")
    panel.figure.canvas.draw()
    assert panel.get_ylabel() == label.replace("kN", "N")


def test_labels_of_others_are_kept_and_have_their_numbers() -> None:
    _, panel = plt.subplots()
    sweep_with(-5e3).plot("crank_pin", ax=panel)
    for label, unit in (("Kraft [kN]", "kN"), ("Kraft [N]", "kN")):
        panel.set_ylabel(label)
        assert told(panel) == unit
    panel.set_ylabel("Kraft")
    panel.figure.canvas.draw()
    assert panel.get_ylabel() == "Kraft"
    ticks = list(panel.get_yticks())
    shown = [float(text) for text in panel.yaxis.get_major_formatter().format_ticks(ticks)]
    np.testing.assert_allclose(shown, ticks)


def test_formatters_of_others_are_kept() -> None:
    class Ticks(ScalarFormatter):
        pass

    _, panel = plt.subplots()
    panel.plot([0.0, 1.0], [0.0, 5e3])
    panel.set_ylabel("force [N]")
    panel.yaxis.set_major_formatter(Ticks())
    settle(panel)
    assert type(panel.yaxis.get_major_formatter()) is Ticks and panel.get_ylabel() == "force [N]"


def test_figures_are_pickled_with_their_prefixes() -> None:
    figure, panel = plt.subplots()
    panel.plot([0.0, 0.02], [0.0, 5e3])
    panel.set(xlabel="way [m]", ylabel="force [N]")
    settle(panel)
    (again,) = pickle.loads(pickle.dumps(figure)).axes
    assert (told(again, "x"), told(again)) == ("mm", "kN")


@pytest.mark.parametrize("loads", [(-5e3, -5.0), (-5.0, -5e3)])
def test_diagrams_drawn_into_twice_show_both(loads: tuple[float, float]) -> None:
    _, panel = plt.subplots()
    for load in loads:
        sweep_with(load).plot.polar("crank_pin", ax=panel)
    assert (told(panel, "x"), told(panel)) == ("kN", "kN")
    drawn = np.concatenate([line.get_xydata() for line in panel.get_lines()])
    for values, limits in zip(drawn.T, (panel.get_xlim(), panel.get_ylim()), strict=True):
        assert limits[0] <= values.min() and values.max() <= limits[1]
