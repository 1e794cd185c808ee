"""Polar diagrams: curves against known circles and the sweep's own forces, labels and scales."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cardan_dyn as cd

pytest.importorskip("matplotlib", reason="figures need matplotlib")

from testkit.drawings import check_units_and_files

from cardan_dyn import figures


@pytest.mark.slow
def test_figures_have_units(joint_turn: cd.Sweep, needle_turn: cd.Sweep, tmp_path: Path) -> None:
    for figure in (
        figures.moment_polar(joint_turn, "bearing_out", ["parent", "joint"]),
        figures.force_polar(needle_turn, needle_turn.outputs[:5], "world", plane="xy"),
        figures.forces_in_place(
            needle_turn, ["rocker_pin"], [["rocker_pin", "rocker_bearing"]], size=0.05
        ),
    ):
        check_units_and_files(figure, tmp_path)


def test_moment_polar_is_thomas_circle(joint_turn: cd.Sweep) -> None:
    """In fixed axes a circle through the origin, of diameter T tan β; in turning axes a line."""
    fixed, turning = figures.moment_polar(joint_turn, "bearing_out", ["parent", "joint"]).axes
    y, z = fixed.get_lines()[0].get_data()
    radius = 50.0 * np.tan(joint_turn.held["joint_angle"])
    np.testing.assert_allclose(np.hypot(y - radius, z), radius, rtol=1e-12)
    y, z = turning.get_lines()[0].get_data()
    np.testing.assert_allclose(z, 0.0, atol=1e-11)
    assert np.ptp(y) == pytest.approx(4.0 * radius)
    assert fixed.get_xlabel() == "$M_y$ [N·m]" and fixed.get_ylabel() == "$M_z$ [N·m]"
    assert {text.get_text() for text in fixed.texts} == {"0°, 180°", "90°, 270°"}
    assert fixed.get_aspect() == turning.get_aspect() == 1.0


def test_forces_are_drawn_in_their_plane_about_the_origin(needle_turn: cd.Sweep) -> None:
    figure = figures.force_polar(needle_turn, "rocker_bearing", "world", plane="yz", title="forces")
    (axes,) = figure.axes
    curve, origin, marks = axes.get_lines()
    force = needle_turn.wrench("rocker_bearing", "world").force
    np.testing.assert_array_equal(curve.get_xydata(), force[:, 1:])
    np.testing.assert_array_equal(origin.get_xydata(), [[0.0, 0.0]])
    # A position every half degree: the quarter turns are the samples 0, 180, 360 and 540.
    np.testing.assert_array_equal(marks.get_xydata(), force[[0, 180, 360, 540], 1:])
    # Statics leaves open what acts across the plane of the mechanism: a star says so.
    assert axes.get_title() == "rocker_bearing *\nworld axes"
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("$F_y$ [kN]", "$F_z$ [kN]")
    assert figure.get_suptitle() == "forces"
    # Curve and origin are within the axes, with room for labels around them.
    low, high = np.array([axes.get_xlim(), axes.get_ylim()]).T
    assert np.all(low < np.minimum(force[:, 1:].min(axis=0), 0.0))
    assert np.all(high > np.maximum(force[:, 1:].max(axis=0), 0.0))
    assert np.ptp(axes.get_xlim()) == pytest.approx(np.ptp(axes.get_ylim()))


@pytest.mark.parametrize(
    ("start", "labels"),
    [
        (-180.0, {"-90°, 90°", "0°, 180°"}),
        (700.0, {"720°, 900°", "810°, 990°"}),
        (-1440.0, {"-1260°, -1080°", "-1350°, -1170°"}),
    ],
)
def test_quarters_are_those_that_are_gone_through(start: float, labels: set[str]) -> None:
    scene = cd.Scene(cd.load("universal_joint"), drive="bearing_in", held={"joint_angle": 0.3})
    turn = scene.sweep(np.deg2rad(start + np.arange(361.0)), loads={"bearing_out": -100.0})
    (axes,) = figures.moment_polar(turn, "bearing_in", "world").axes
    assert {text.get_text() for text in axes.texts} == labels


def test_plane_is_across_the_joints_axis(needle_turn: cd.Sweep) -> None:
    """All axes of the needle drive but that of its needle are parallel to z."""
    (axes,) = figures.force_polar(needle_turn, "rocker_bearing", "world").axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("$F_x$ [kN]", "$F_y$ [kN]")


@pytest.mark.slow
def test_each_joint_and_frame_has_its_diagram(needle_turn: cd.Sweep) -> None:
    joints = needle_turn.outputs[:5]
    axes = figures.force_polar(needle_turn, joints, "world", plane="xy").axes
    # Five diagrams in two rows of three: the sixth place is empty.
    assert [panel.get_title().split("\n")[0] for panel in axes] == list(joints)
    both = figures.force_polar(needle_turn, joints[:2], ["parent", "joint"]).axes
    assert [panel.get_title() for panel in both] == [
        f"{name}\naxes fixed in the {body}" for name in joints[:2] for body in ("parent", "child")
    ]


def test_only_quarter_turns_that_are_sampled_are_labelled(joint: cd.Mechanism) -> None:
    scene = cd.Scene(
        joint, drive="bearing_in", held={"joint_angle": 0.5}, loads={"bearing_out": -1.0}
    )
    turn = scene.sweep(np.deg2rad([0.0, 40.0, 88.0, 130.0, 184.0, 230.0]))
    (axes,) = figures.moment_polar(turn, "bearing_out").axes
    assert {text.get_text() for text in axes.texts} == {"0°", "90°"}


def test_labels_stand_outside_their_curve(needle_turn: cd.Sweep) -> None:
    """From the middle of the curve, a label lies further out than the point that it names."""
    (axes,) = figures.force_polar(needle_turn, "rocker_bearing", "world").axes
    curve = axes.get_lines()[0].get_xydata()
    middle = 0.5 * (np.min(curve, axis=0) + np.max(curve, axis=0))
    assert len(axes.texts) >= 3
    for text in axes.texts:
        assert np.linalg.norm(text.get_position()) == pytest.approx(10.0)
        assert np.dot(text.get_position(), text.xy - middle) >= 0.0


def test_a_single_sample_is_drawn(one_position: cd.Sweep, tmp_path: Path) -> None:
    """A line of one point would not be seen."""
    figure = figures.moment_polar(one_position, "bearing_out")
    figures.save(figure, tmp_path / "one")
    assert all(axes.get_lines()[0].get_marker() == "o" for axes in figure.axes)


def test_polars_in_place_share_a_scale(needle_turn: cd.Sweep) -> None:
    joints = ["rocker_bearing", "needle_pin"]
    figure = figures.forces_in_place(needle_turn, joints, [], size=0.06)
    forces = {name: needle_turn.wrench(name, "world").force[:, :2] for name in joints}
    greatest = np.max(np.linalg.norm(forces["rocker_bearing"], axis=1))
    curves = {line.get_label(): line for line in figure.axes[0].get_lines()}
    for name in joints:
        from_joint = curves[name].get_xydata() / 1e3 - needle_turn.origin(name)[0, :2]
        np.testing.assert_allclose(from_joint, 0.06 * forces[name] / greatest, atol=1e-12)


@pytest.mark.parametrize("speed", [30.0, 45.0, 60.0, 75.0])
def test_scale_bar_shows_a_round_force_to_the_same_scale(speed: float) -> None:
    """Forces of inertia grow with the square of the speed; the bar is 1, 2 or 5 of a decade."""
    scene = cd.Scene(cd.load("needle_drive"), drive="main_shaft")
    turn = scene.sweep(np.linspace(0.0, 6.0, 13), speed=speed)
    (axes,) = figures.forces_in_place(turn, ["rocker_bearing"], [], size=0.06).axes
    force = turn.wrench("rocker_bearing", "world").force[:, :2]
    greatest = float(np.max(np.linalg.norm(force, axis=1)))
    (text,) = (text.get_text() for text in axes.texts)
    shown = float(text.removesuffix(" N"))
    decade = 10.0 ** np.floor(np.log10(shown) + 1e-9)
    assert text == f"{shown:g} N" and round(shown / decade, 9) in (1.0, 2.0, 5.0)
    assert 0.2 * greatest <= shown <= 0.5 * greatest
    bar = axes.get_lines()[-1].get_xdata()
    assert np.ptp(bar) == pytest.approx(60.0 * shown / greatest)


def test_links_are_lines_through_joints_and_fixed_points(needle_turn: cd.Sweep) -> None:
    figure = figures.forces_in_place(
        needle_turn,
        ["rocker_pin"],
        [["rocker_pin", (0.1, 0.2, 0.3)]],
        size=0.05,
        plane="zx",
        sample=100,
        title="drive",
    )
    (axes,) = figure.axes
    expected = np.array([needle_turn.origin("rocker_pin")[100], (0.1, 0.2, 0.3)])[:, [2, 0]]
    np.testing.assert_allclose(axes.get_lines()[0].get_xydata(), 1e3 * expected)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("z [mm]", "x [mm]")
    assert axes.get_title() == "drive"


@pytest.mark.slow
def test_a_mechanism_without_forces_is_drawn(joint_without_load: cd.Sweep, tmp_path: Path) -> None:
    """A torque alone passes through the joint, or nothing at all."""
    figure = figures.forces_in_place(joint_without_load, ["bearing_in"], [], size=0.1)
    figures.save(figure, tmp_path / "figure")
    (axes,) = figure.axes
    origin = 1e3 * joint_without_load.origin("bearing_in")[0, :2]
    for line in axes.get_lines():
        np.testing.assert_allclose(line.get_xydata(), np.tile(origin, (len(line.get_xdata()), 1)))
    assert len(axes.texts) == 0
    (polar,) = figures.force_polar(joint_without_load, "bearing_in").axes
    np.testing.assert_array_equal(polar.get_lines()[0].get_xydata(), 0.0)
    without_diagram = figures.forces_in_place(
        joint_without_load, [], [["bearing_in", (1.0, 0.0, 0.0)]], size=0.1
    )
    assert len(without_diagram.axes[0].get_lines()) == 1


def test_wrong_names_are_refused(joint_turn: cd.Sweep) -> None:
    with pytest.raises(cd.ArgumentError, match="frame 'fixed' is unknown"):
        figures.moment_polar(joint_turn, "bearing_in", "fixed")
    with pytest.raises(cd.ArgumentError, match="frames is 3, expected a name"):
        figures.moment_polar(joint_turn, "bearing_in", 3)  # type: ignore[arg-type]
    with pytest.raises(
        cd.ArgumentError, match="plane 'xx' is unknown; planes: xy, xz, yx, yz, zx, zy"
    ):
        figures.moment_polar(joint_turn, "bearing_in", plane="xx")
    with pytest.raises(cd.ArgumentError, match="plane 'xx' is unknown"):
        figures.forces_in_place(joint_turn, ["bearing_in"], [], size=0.1, plane="xx")
    with pytest.raises(cd.ModelError, match="bearing_on"):
        figures.force_polar(joint_turn, "bearing_on")


def test_a_trajectory_has_polar_diagrams(joint: cd.Mechanism) -> None:
    scene = cd.Scene(joint, free="bearing_in", held={"joint_angle": 0.6})
    spin = scene.simulate(0.8, speed=10.0).evenly(200)
    (axes,) = figures.moment_polar(spin, "bearing_out").axes
    moment = spin.wrench("bearing_out", "parent").moment
    plane = ["xyz".index(axes.get_xlabel()[3]), "xyz".index(axes.get_ylabel()[3])]
    np.testing.assert_array_equal(np.transpose(axes.get_lines()[0].get_data()), moment[:, plane])


def test_diagrams_of_one_figure_have_one_scale(joint_turn: cd.Sweep) -> None:
    first, second = figures.moment_polar(joint_turn, "bearing_out", ["parent", "joint"]).axes
    widths = [np.ptp([panel.get_xlim(), panel.get_ylim()], axis=1) for panel in (first, second)]
    np.testing.assert_allclose(widths, widths[0][0])


def test_rounding_is_a_point(joint_turn: cd.Sweep) -> None:
    # The shafts carry moments of some 100 N·m alone; what they have of forces is rounding.
    force = joint_turn.wrench("bearing_out", "parent").force
    assert np.abs(force).max() < 1e-10
    (panel,) = figures.force_polar(joint_turn, "bearing_out").axes
    assert not np.any(panel.get_lines()[0].get_xydata())
    assert np.ptp(panel.get_xlim()) > 1.0
    # All quarters are one point, and have one label.
    assert len(panel.texts) == 1


def test_positions_of_slides_are_no_angles() -> None:
    platform = cd.load("stewart_platform")
    legs = [f"leg_{k}" for k in range(1, 7)]
    scene = cd.Scene(platform, drive=legs)
    turn = scene.sweep(np.linspace(-0.02, 0.02, 5)[:, None] * np.ones(6))
    (panel,) = figures.moment_polar(turn, "leg_1").axes
    told = {part for text in panel.texts for part in text.get_text().split(", ")}
    assert told == {"-20 mm", "20 mm"}
    # What is rounding beside the other end is nothing.
    turn = scene.sweep(np.linspace(4e-12, 0.02, 5)[:, None] * np.ones(6))
    (panel,) = figures.moment_polar(turn, "leg_1").axes
    told = {part for text in panel.texts for part in text.get_text().split(", ")}
    assert told == {"0 mm", "20 mm"}
