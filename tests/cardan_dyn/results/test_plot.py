"""Results plot themselves: right numbers over the right abscissa, and errors that name names."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.scenes import universal

import cardan_dyn as cd

pytest.importorskip("matplotlib", reason="figures need matplotlib")

POSITIONS = np.linspace(0.0, 2.0 * np.pi, 73)


@pytest.fixture(scope="module")
def turn(joint: cd.Mechanism) -> cd.Sweep:
    return universal(joint, 0.5, load=-2.0).sweep(POSITIONS, speed=3.0)


def test_joints_are_drawn_by_torsion_and_bending(turn: cd.Sweep) -> None:
    torsion, bending = turn.plot("bearing_out", "bearing_in").axes
    assert [line.get_label() for line in bending.lines] == ["bearing_out", "bearing_in"]
    np.testing.assert_array_equal(bending.lines[0].get_ydata(), turn["bearing_out"].bending)
    np.testing.assert_allclose(torsion.lines[0].get_xdata(), np.rad2deg(POSITIONS))


def test_columns_of_one_unit_share_their_axes(turn: cd.Sweep) -> None:
    names = ("bearing_out.bending", "pin_in.velocity", "drive_effort")
    moments, rates = turn.plot(*names, title="three").axes
    assert [line.get_label() for line in moments.lines] == [names[0], names[2]]
    np.testing.assert_array_equal(rates.lines[0].get_ydata(), turn.motion.velocity("pin_in"))
    assert (moments.get_ylabel(), rates.get_ylabel()) == ("[N·m]", "[rad/s]")
    assert rates.get_xlabel() == "bearing_in [°]"
    (over,) = turn.plot("drive_effort", x="bearing_out.position").axes
    at = turn.motion.position("bearing_out")
    np.testing.assert_allclose(over.lines[0].get_xdata(), np.rad2deg(at))


def test_orders_and_polar_diagrams_are_those_of_figures(turn: cd.Sweep) -> None:
    (axes,) = turn.plot.orders("drive_effort", highest=4).axes
    orders, sizes = cd.figures.order_amplitudes(POSITIONS, turn.drive_effort)
    heights = [bar.get_height() for bar in axes.patches]
    assert heights == pytest.approx(sizes[np.isin(orders, range(5))])
    # Of a size those of the vector, in the axes of the bearing, which stand still.
    (axes,) = turn.plot.orders("bearing_out.bending", highest=4).axes
    moment = turn.wrench("bearing_out", "parent").moment
    amplitudes = [cd.figures.order_amplitudes(POSITIONS, moment[:, k])[1] for k in (1, 2)]
    expected = np.concatenate([sizes[np.isin(orders, range(5))] for sizes in amplitudes])
    assert [bar.get_height() for bar in axes.patches] == pytest.approx(expected)
    names = [text.get_text() for text in axes.figure.legends[0].get_texts()]
    assert names == ["bearing_out moment y", "bearing_out moment z"]
    assert len(turn.plot.polar(["bearing_out", "pin_in"], of="force").axes) == 2


def test_trajectories_are_drawn_over_time(joint: cd.Mechanism) -> None:
    free = cd.Scene(joint, free="bearing_in", held={"joint_angle": 0.5})
    trajectory = free.simulate(0.1, speed=5.0)
    assert trajectory.plot("bearing_out", quantities="bending").axes[0].get_xlabel() == "time [s]"
    assert len(trajectory.plot.energy().axes) == 2
    (axes,) = trajectory.plot("kinetic_energy").axes
    np.testing.assert_array_equal(axes.lines[0].get_xdata(), trajectory.time)
    assert axes.get_xlabel() == "time [s]"


def test_anything_is_an_abscissa(turn: cd.Sweep) -> None:
    height = np.cos(POSITIONS)
    (axes,) = turn.plot("bearing_out", x=height, quantities="bending", xlabel="height [m]").axes
    np.testing.assert_array_equal(axes.lines[0].get_xdata(), height)
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), turn["bearing_out"].bending)
    assert axes.get_xlabel() == "height [m]"
    (axes,) = turn.plot("drive_effort", x="pin_in").axes
    np.testing.assert_allclose(
        axes.lines[0].get_xdata(), np.rad2deg(turn.motion.position("pin_in"))
    )
    assert axes.get_xlabel() == "pin_in [°]"
    (axes,) = turn.plot(height, label="height", ylabel="height [m]").axes
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), height)
    assert (axes.get_ylabel(), axes.lines[0].get_label()) == ("height [m]", "height")


def test_arrays_of_xarray_tell_their_names_and_units(turn: cd.Sweep) -> None:
    pytest.importorskip("xarray")
    data = turn.to_xarray()
    (axes,) = turn.plot(data["drive_effort"], x=data["position"]).axes
    assert axes.get_ylabel() == "[N·m]"
    assert axes.get_xlabel() == "position of the drive bearing_in [°]"
    np.testing.assert_allclose(axes.lines[0].get_xdata(), np.rad2deg(POSITIONS))
    assert axes.lines[0].get_label() == data["drive_effort"].attrs["long_name"]


def test_without_wrenches_only_efforts_that_act_are_drawn() -> None:
    four_bar = cd.load("four_bar")
    driven = cd.Scene(four_bar, drive="crank_bearing", outputs=()).sweep(POSITIONS, speed=3.0)
    assert [line.get_label() for line in driven.plot().axes[0].lines] == ["drive_effort"]
    coasting = cd.Scene(four_bar, free="crank_bearing", outputs=()).simulate(0.1, speed=1.0)
    # Nothing drives it: what is drawn is no line of zeros.
    lines = [line for axes in coasting.plot().axes for line in axes.lines]
    assert lines
    assert all(np.any(line.get_ydata()) for line in lines)


def test_without_a_name_bearings_and_loads_are_drawn(turn: cd.Sweep) -> None:
    effort, torsion, bending = turn.plot().axes
    np.testing.assert_array_equal(effort.get_lines()[0].get_ydata(), turn.drive_effort)
    # The joint angle is held, and neither driven nor loaded.
    assert [line.get_label() for line in bending.lines] == ["bearing_in", "bearing_out"]
    # The shafts carry no forces: rounding alone is no quantity.
    assert [axes.get_ylabel() for axes in (torsion, bending)] == ["torsion [N·m]", "bending [N·m]"]
    assert len(turn.plot.polar().axes) == 2
    assert len(turn.plot.orders().axes[0].patches) == 2 * 2 * 9
    ratio, _ = turn.plot.ratio("bearing_out").axes
    np.testing.assert_array_equal(ratio.lines[0].get_ydata(), turn.motion.ratio("bearing_out"))


def test_constants_and_rounding_have_no_offset(turn: cd.Sweep) -> None:
    (axes,) = turn.plot("bearing_out", quantities="torsion").axes
    assert axes.lines[0].get_ydata() == pytest.approx(-2.0)
    assert axes.get_ylim() == pytest.approx((-2.3, 0.0))
    axes.figure.draw_without_rendering()
    assert axes.yaxis.get_offset_text().get_text() == ""
    (axes,) = turn.plot("bearing_out", quantities="shear").axes
    low, high = axes.get_ylim()
    # Beside a moment of 2 N·m, forces of some 1e-16 N are none.
    assert high == -low > 1.0 and not axes.texts
    (axes,) = turn.plot("bearing_out.shear").axes
    assert axes.get_ylim() == (-axes.get_ylim()[1], axes.get_ylim()[1])


def test_figures_are_drawn_into_given_axes(turn: cd.Sweep, joint: cd.Mechanism) -> None:
    from matplotlib.figure import Figure

    own = Figure()
    axes = own.subplots()
    other = universal(joint, 0.2, load=-2.0).sweep(POSITIONS, speed=3.0)
    assert turn.plot("bearing_out.bending", ax=axes, label="0.5 rad") is own
    other.plot("bearing_out.bending", ax=axes, label="0.2 rad", linewidth=3.0, title="Two angles")
    assert [line.get_label() for line in axes.lines] == ["0.5 rad", "0.2 rad"]
    first, second = axes.lines
    assert first.get_linestyle() != second.get_linestyle() and second.get_linewidth() == 3.0
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["0.5 rad", "0.2 rad"]
    assert axes.get_title() == "Two angles" and not own.legends
    both = Figure().subplots(2)
    turn.plot("bearing_out", ax=both)
    assert both[1].get_xlabel() == "bearing_in [°]"
    assert tuple(turn.plot("drive_effort", figsize=(3.0, 2.0)).get_size_inches()) == (3.0, 2.0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"ax": 1}, "ax is 1, expected axes of matplotlib"),
        ({"ax": "two"}, "ax has 2 axes, and 1 are drawn"),
        ({"ax": "polar"}, "projection 'polar', expected 'rectilinear'"),
        ({"ax": "one", "figsize": (3, 2)}, "give either it or ax"),
        ({"figsize": (3, 0)}, "expected width and height in inches"),
        ({"figsize": 3}, "expected width and height in inches"),
        ({"over": "time"}, "no option 'over' of a plot: the abscissa is x="),
        ({"of": "shear"}, "no option 'of' of a plot: name the column first, as .*'joint.shear'"),
        ({"colour": "red"}, "no option 'colour' of a plot; options: .*color"),
        ({"x": "angle"}, "no column 'angle'"),
        ({"x": np.zeros(5)}, r"x has shape \(5,\), expected \(73,\)"),
        ({"x": np.zeros((73, 3))}, r"take one of its columns, as in values\[:, 2\]"),
        ({"x": None}, "x has shape|x is None, expected a name or an array"),
        ({"x": np.full(73, np.nan)}, "x has values that are no numbers"),
        ({"label": ["a", "b"]}, "label has 2 names for 1 lines"),
    ],
)
def test_wrong_options_are_refused(
    turn: cd.Sweep, options: dict[str, object], message: str
) -> None:
    from matplotlib.figure import Figure

    kinds = {
        "one": Figure().subplots(),
        "two": Figure().subplots(2),
        "polar": Figure().subplots(subplot_kw={"projection": "polar"}),
    }
    if isinstance(options.get("ax"), str):
        options = {**options, "ax": kinds[str(options["ax"])]}
    with pytest.raises(cd.ArgumentError, match=message):
        turn.plot("drive_effort", **options)


def test_what_was_not_asked_for_is_said(joint: cd.Mechanism, turn: cd.Sweep) -> None:
    held = {"joint_angle": 0.5}
    scene = cd.Scene(joint, drive="bearing_in", held=held, outputs=["bearing_in"])
    part = scene.sweep(POSITIONS)
    with pytest.raises(cd.ModelError, match="'bearing_out' was not asked for"):
        part.plot("bearing_out")
    with pytest.raises(cd.ArgumentError, match=r"joints: .*did you mean 'bearing_out'"):
        turn.plot("bearing_ot")
    with pytest.raises(cd.ArgumentError, match="name a joint and axes"):
        cd.figures.moment_polar(turn, [])


def test_what_is_no_column_is_refused(turn: cd.Sweep) -> None:
    with pytest.raises(cd.ArgumentError, match="no column 'bending'; columns: "):
        turn.plot("bending")
    with pytest.raises(cd.ArgumentError, match=r'joints and columns .*"bearing_out\.bending"'):
        turn.plot("bearing_out", "drive_effort")
    with pytest.raises(cd.ArgumentError, match="label is that of one joint"):
        turn.plot("bearing_out", "bearing_in", label="both")
    with pytest.raises(cd.ArgumentError, match="of is 'torque'; it is force, moment"):
        turn.plot.polar("bearing_out", of="torque")
    with pytest.raises(cd.ArgumentError, match="columns of one unit, not of: N, N·m"):
        turn.plot.orders("bearing_out.bending", "bearing_out.shear")
    with pytest.raises(AttributeError, match="no figure 'spectrum'; figures of a Sweep: "):
        turn.plot.spectrum  # noqa: B018
    assert "plot.orders" in repr(turn.plot)


@pytest.mark.slow
def test_stars_mark_what_statics_leaves_open(turn: cd.Sweep) -> None:
    # Both bearings of the needle drive could be bent against each other; shear is determined.
    drive = cd.Scene(cd.load("needle_drive"), drive="main_shaft").sweep(POSITIONS, speed=200.0)
    figure = drive.plot("main_shaft", quantities=["bending", "shear"])
    assert [axes.get_ylabel() for axes in figure.axes] == ["bending * [N·m]", "shear [kN]"]
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["main_shaft *"]
    told = legend.get_title().get_text().replace("\n", " ")
    assert told.startswith("what the parent link exerts on the child link")
    assert "* not determined by statics: chosen by least norm" in told
    (legend,) = drive.plot("main_shaft.bending", "main_shaft.torsion").legends
    assert [text.get_text() for text in legend.get_texts()] == [
        "main_shaft.bending *",
        "main_shaft.torsion",
    ]
    (legend,) = drive.plot("main_shaft.force_magnitude", "main_shaft.force_x").legends
    assert [text.get_text() for text in legend.get_texts()] == [
        "main_shaft.force_magnitude *",
        "main_shaft.force_x",
    ]
    (legend,) = turn.plot("bearing_out").legends
    assert "*" not in legend.get_title().get_text()


def test_peaks_tell_value_and_place(turn: cd.Sweep) -> None:
    (axes,) = turn.plot("bearing_out", quantities="bending").axes
    bending = turn["bearing_out"].bending
    (text,) = axes.texts
    place = POSITIONS[np.flatnonzero(np.isclose(bending, bending.max(), rtol=1e-9))[0]]
    assert text.get_text() == f"{bending.max():.4g} N·m at {np.rad2deg(place):.4g}°"
    assert not turn.plot("bearing_out", quantities="bending", peaks=False).axes[0].texts
    # Only few lines are labelled without being asked for.
    four = ["bearing_in.bending", "bearing_out.bending", "pin_in.bending", "pin_out.bending"]
    assert not turn.plot(*four).axes[0].texts
    (axes,) = turn.plot("pin_in.velocity", peaks=True).axes
    velocity = turn.motion.velocity("pin_in")
    found = [text.get_text() for text in axes.texts]
    assert [item.split(" rad")[0].replace("\N{MINUS SIGN}", "-") for item in found] == [
        f"{velocity.max():.4g}",
        f"{velocity.min():.4g}",
    ]


def test_grids_are_no_lines(joint: cd.Mechanism) -> None:
    grid = universal(joint, 0.5).sweep(POSITIONS, speed=[[1.0], [2.0]])
    with pytest.raises(cd.ArgumentError, match="over one dimension, not over sample_0, sample_1"):
        grid.plot("drive_effort")
