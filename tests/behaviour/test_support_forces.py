"""Rods, bearings and wrenches about other points: statics and power, written out."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from testkit import claims
from testkit.ball_rods import ALONG, as_a_floating_rod, as_balls, as_hinges

import cardan_dyn as cd
from cardan_dyn.analytic.support_forces import Spans, shaft_axes, support_forces

pytestmark = pytest.mark.usefixtures("loaded_once")

TURN = np.linspace(0.0, 2.0 * np.pi, 13)
G = np.array([0.0, 0.0, -9.81])


def universal(**options: Any) -> cd.Sweep:
    given = {"drive": "bearing_in", "held": {"joint_angle": 0.5}, "loads": {"bearing_out": -100.0}}
    return cd.Scene(cd.load("universal_joint"), **{**given, **options}).sweep(TURN)


def compliant() -> cd.Sweep:
    """All of it determined by compliances, a force through the joint and a bending moment."""
    wrench = cd.Wrench([30.0, -20.0, 50.0], [1.0, 2.0, -3.0], "world")
    return universal(loads={"bearing_out": -100.0, "shaft_out": wrench}, gravity=G)


# Rods


@pytest.mark.slow
@pytest.mark.parametrize("text", [as_balls, as_a_floating_rod])
def test_a_massless_rod_carries_what_the_moment_about_the_rocker_asks_for(text: Any) -> None:
    urdf = text().replace('<mass value="1.5"/>', '<mass value="0"/>')
    rod_at = urdf.index('<link name="rod">')
    end = urdf.index("</link>", rod_at)
    urdf = urdf[:rod_at] + '<link name="rod">' + urdf[end:]
    turn = cd.Scene(cd.load(urdf), drive="a", loads={"d": -3.0}).sweep(np.linspace(-1, 1, 9))
    rod = turn.rod_force("rod")
    assert rod.joints[1] == "c"
    assert rod.unique
    assert any("c" in joints for joints in turn.idle_rods)
    tip = turn.point("crank", (0.3, 0.0, 0.0)).position
    pin = turn.point("rocker", (0.0, 0.0, 0.6)).position
    # In tension, the rod pulls the rocker's pin towards the crank, against the load of -3 N·m.
    towards = (tip - pin) / np.linalg.norm(tip - pin, axis=1)[:, None]
    arm = np.cross(pin - [1.0, 0.2, 0.1], towards)[:, 1]
    np.testing.assert_allclose(rod.tension * arm, 3.0, rtol=1e-11)
    np.testing.assert_allclose(rod.ends, np.stack([rod.tension] * 2, axis=1), rtol=1e-10)
    np.testing.assert_allclose(rod.length, np.linalg.norm(ALONG), rtol=1e-14)


@pytest.mark.slow
def test_the_ends_of_a_heavy_rod_differ_by_its_inertia_and_weight() -> None:
    scene = cd.Scene(cd.load(as_balls()), drive="a", loads={"d": -3.0}, gravity=G)
    turn = scene.sweep(np.linspace(-1.0, 1.0, 9), speed=5.0, acceleration=2.0)
    rod = turn.rod_force("rod")
    centre = turn.point("rod", 0.5 * ALONG).acceleration
    line = turn.point("rod", ALONG).position - turn.point("rod").position
    along = np.sum((centre - G) * line, axis=1) / np.linalg.norm(line, axis=1)
    np.testing.assert_allclose(rod.ends[:, 1] - rod.ends[:, 0], 1.5 * along, rtol=1e-11)
    np.testing.assert_allclose(rod.tension, np.mean(rod.ends, axis=1))
    assert "tension positive" in repr(rod)


@pytest.mark.slow
def test_what_is_no_rod_is_refused() -> None:
    turn = cd.Scene(cd.load(as_hinges()), drive="a").sweep(0.1)
    with pytest.raises(cd.ModelError, match=r"'rod' is no rod between two balls; its joints: b3"):
        turn.rod_force("rod")
    with pytest.raises(cd.ModelError, match="did you mean 'rod'"):
        turn.rod_force("rood")
    with pytest.raises(cd.ModelError, match="is no rod"):
        turn.rod_force("ground")


# Bearings


@pytest.mark.parametrize("frame", ["joint", "parent", "world", "housing_out"])
@pytest.mark.parametrize("places", [(0.05, 0.25), (-0.1, 0.3), (0.4, 0.0)])
def test_bearings_make_up_the_wrench_of_their_joint(
    frame: str, places: tuple[float, float]
) -> None:
    turn = compliant()
    wrench = turn.wrench("bearing_out", frame)
    assert np.max(np.abs(wrench.force)) > 1.0
    forces = wrench.bearing_forces(places)
    axis = np.broadcast_to(wrench.axis, wrench.force.shape)
    assert np.max(np.abs(np.sum(forces.force_a * axis, axis=1))) < 1e-10
    assert np.max(np.abs(np.sum(forces.force_b * axis, axis=1))) < 1e-10
    total = forces.force_a + forces.force_b + forces.axial[:, None] * axis
    np.testing.assert_allclose(total, wrench.force, atol=1e-10)
    moment = sum(
        np.cross(place * axis, force)
        for place, force in zip(places, (forces.force_a, forces.force_b), strict=True)
    )
    moment = moment + forces.torsion[:, None] * axis
    np.testing.assert_allclose(moment, wrench.moment, atol=1e-10)
    np.testing.assert_allclose(forces.radial_a, np.linalg.norm(forces.force_a, axis=1))
    assert forces.positions == places
    assert not forces.force_a.flags.writeable


def test_bearings_of_a_double_shaft_are_those_of_the_catalogues() -> None:
    """The input shaft in two bearings, against the closed form over a turn."""
    beta = 0.3, 0.2
    scene = cd.Scene(
        cd.load("double_shaft_z"),
        drive="bearing_in",
        held={"joint_angle_1": beta[0], "joint_angle_2": beta[1]},
        loads={"bearing_out": -100.0},
    )
    turn = scene.sweep(TURN)
    wrench = turn.wrench("bearing_in", "parent")
    joints = [turn.origin(name)[0] for name in ("pin_1_in", "pin_2_in")]
    length = float(np.linalg.norm(joints[1] - joints[0]))
    spans = Spans(a=0.2, b=0.1, e=0.1, f=0.2)
    closed = support_forces(shaft_axes(*beta), TURN, turn.drive_effort, length, spans)
    # The shaft stands in front of its joint: its bearings have negative places.
    forces = wrench.bearing_forces((-0.3, -0.1))
    for found, expected in ((forces.radial_a, closed.A), (forces.radial_b, closed.B)):
        np.testing.assert_allclose(found, np.linalg.norm(expected, axis=1), rtol=1e-9)


def test_what_statics_leaves_open_of_bearings_is_marked() -> None:
    """Forces through the joint are open, moments about it are not."""
    wrench = universal().wrench("bearing_out", "parent")
    assert wrench.unique.tolist() == [False] * 3 + [True] * 3
    at_centre = wrench.bearing_forces((0.0, 0.25))
    # A bearing in the centre takes any force; the other one alone makes up for the moment.
    across = ~np.isclose(np.abs(wrench.axis), 1.0)
    assert not np.any(at_centre.unique_a[across])
    assert np.all(at_centre.unique_b)
    assert not at_centre.unique_axial
    away = wrench.bearing_forces((0.05, 0.25))
    assert not np.any(away.unique_a[across])
    assert not np.any(away.unique_b[across])
    assert "(not unique)" in repr(away)
    determined = cd.Scene(
        cd.load("slider_crank"), drive="crank_bearing", loads={"piston_guide": -1000.0}
    ).sweep(TURN)
    crank = determined.wrench("crank_bearing", "parent")
    assert crank.unique.tolist() == [True, True, False, False, False, True]
    # Four parallel hinges leave open how the mechanism is bent out of its plane, and with it which
    # bearing of a pair carries how much; across the axis there is no third component.
    forces = crank.bearing_forces((-0.1, 0.1))
    assert forces.unique_a.tolist() == forces.unique_b.tolist() == [False, False, True]


@pytest.mark.slow
def test_bearings_at_one_place_or_without_axis_are_refused() -> None:
    wrench = universal()["bearing_out"]
    with pytest.raises(cd.ArgumentError, match=r"both at 0\.1 m"):
        wrench.bearing_forces((0.1, 0.1))
    for wrong in (0.1, (0.1,), (0.1, np.inf), "ab"):
        with pytest.raises(cd.ArgumentError, match="bearings"):
            wrench.bearing_forces(wrong)  # type: ignore[arg-type]
    ball = cd.Scene(cd.load(as_balls()), drive="a").sweep(0.1)["b"]
    with pytest.raises(cd.ModelError, match="no axis"):
        ball.bearing_forces((0.0, 0.1))


# Wrenches about other points and in the axes of links


def test_the_power_of_a_wrench_is_the_same_about_any_point() -> None:
    """The sum of wrench · twist of all joints on a body is the power of what moves it."""
    scene = claims.spatial()
    turn = scene.sweep(np.linspace(0.2, 1.4, 7), speed=3.0, acceleration=2.0)
    mechanism = turn.mechanism
    for name, joint in mechanism.joints.items():
        described = next(
            item for item in mechanism.description.joints_and_loops if item.name == name
        )
        child = getattr(described, "child", None) or described.successor
        parent = getattr(described, "parent", None) or described.predecessor
        if joint.nv != 1:
            continue
        powers = []
        for xyz in ((0.0, 0.0, 0.0), (0.3, -0.2, 0.5)):
            moving = turn.point(child, xyz)
            # The parent's body at the same place.
            arm = moving.position - turn.point(parent).position
            on_parent = turn.point(parent)
            velocity = on_parent.velocity + np.cross(on_parent.angular_velocity, arm)
            wrench = turn.wrench(name, "world").at(moving)
            powers.append(
                np.sum(wrench.force * (moving.velocity - velocity), axis=1)
                + np.sum(
                    wrench.moment * (moving.angular_velocity - on_parent.angular_velocity), axis=1
                )
            )
        np.testing.assert_allclose(powers[0], powers[1], atol=1e-11)
        effort = turn[name].torsion if not mechanism.drivable[name].slides else turn[name].axial
        expected = effort * turn.motion.velocity(name)
        np.testing.assert_allclose(powers[0], expected, atol=1e-10)


@pytest.mark.parametrize("frame", ["joint", "parent", "world", "shaft_in"])
def test_a_wrench_about_another_point_is_the_same_wrench(frame: str) -> None:
    turn = compliant()
    wrench, arm = turn.wrench("bearing_out", frame), np.array([0.1, -0.2, 0.3])
    moved = wrench.at(arm)
    np.testing.assert_array_equal(moved.force, wrench.force)
    expected = wrench.moment - np.cross(arm, wrench.force)
    np.testing.assert_allclose(moved.moment, expected, atol=1e-12)
    np.testing.assert_allclose(moved.at((0.0, 0.0, 0.0)).moment, wrench.moment, atol=1e-12)
    point = turn.point("shaft_out", (0.4, 0.1, 0.2))
    there = turn.wrench("bearing_out", "world").at(point)
    here = wrench.at(point)
    rotation = {
        "joint": turn.rotation("bearing_out"),
        "world": np.eye(3),
        "shaft_in": turn.orientation("shaft_in"),
        "parent": turn.orientation("housing_out"),
    }[frame]
    if frame != "parent":
        turned = np.einsum("...ij,...j->...i", rotation, here.moment)
        np.testing.assert_allclose(turned, there.moment, atol=1e-11)
    np.testing.assert_allclose(here.magnitude.moment, there.magnitude.moment, atol=1e-11)
    arm = point.position - turn.origin("bearing_out")
    world = turn.wrench("bearing_out", "world")
    np.testing.assert_allclose(there.moment, world.moment - np.cross(arm, world.force), atol=1e-11)


def test_flags_follow_a_wrench_to_another_point() -> None:
    wrench = universal().wrench("bearing_out", "parent")
    along = wrench.at(0.2 * wrench.axis)
    # Forces that are open give moments about points beside their line, but none about the axis.
    axis = np.isclose(np.abs(wrench.axis), 1.0)
    assert along.unique[3:].tolist() == axis.tolist()
    assert wrench.at((0.0, 0.0, 0.0)).unique.tolist() == wrench.unique.tolist()
    assert not np.any(along.unique[:3])


@pytest.mark.slow
@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda item: pickle.loads(pickle.dumps(item))]
)
def test_copies_are_the_same_wrenches(copied: Any) -> None:
    turn = universal()
    wrench = turn.wrench("bearing_out", "parent").at((0.1, 0.2, 0.3))
    again = copied(wrench)
    np.testing.assert_array_equal(again.moment, wrench.moment)
    np.testing.assert_array_equal(again.unique, wrench.unique)
    assert repr(again) == repr(wrench)
    forces = wrench.bearing_forces((0.1, 0.2))
    np.testing.assert_array_equal(copied(forces).force_a, forces.force_a)
    rod = cd.Scene(cd.load(as_balls()), drive="a", loads={"d": -3.0}).sweep(0.1).rod_force("rod")
    np.testing.assert_array_equal(copied(rod).tension, rod.tension)


def test_other_points_are_refused() -> None:
    turn = universal()
    wrench = turn["bearing_out"]
    with pytest.raises(cd.ArgumentError, match=r"point has shape \(2,\), expected \(3,\) or"):
        wrench.at((0.0, 1.0))
    fewer = cd.Scene(
        cd.load("universal_joint"), drive="bearing_in", held={"joint_angle": 0.5}
    ).sweep(0.1)
    with pytest.raises(cd.ArgumentError, match="take it of the same sweep"):
        wrench.at(fewer.point("cross"))
    with pytest.raises(cd.ArgumentError, match="frames: joint, parent, world; or those of a link"):
        turn.wrench("bearing_out", "shaft_inn")


def test_magnitudes_are_lengths_of_the_vectors() -> None:
    wrench = compliant()["bearing_out"]
    np.testing.assert_allclose(wrench.magnitude.force, np.linalg.norm(wrench.force, axis=1))
    np.testing.assert_allclose(wrench.magnitude.moment, np.linalg.norm(wrench.moment, axis=1))


# What is shown


def test_summaries_tell_signs_choices_and_that_nothing_acts() -> None:
    turn = universal()
    told = repr(turn["bearing_out"])
    assert "of the parent on the child" in told
    assert "not unique: force xyz, chosen by least norm" in told
    idle = universal(loads={})
    assert "nothing acts" in repr(idle)
    assert "nan" not in repr(idle)
    assert "force up to 0 N" in repr(idle["bearing_in"])  # What statics leaves open may act.
    efforts = universal(outputs=[])
    assert "drive efforts alone" in repr(efforts)
    assert "nan" not in repr(efforts)


def test_notebooks_tell_signs_choices_and_that_nothing_acts() -> None:
    shown = universal()._repr_html_()
    assert "exerted by the parent link on the child link" in shown
    assert "chosen by least norm: bearing_in, pin_in, joint_angle," in shown
    idle = universal(loads={})._repr_html_()
    assert "<td>nothing acts</td>" in idle
    assert "nan" not in idle
    efforts = universal(outputs=[])._repr_html_()
    assert "<td>not computed</td>" in efforts
    assert "nan" not in efforts


# Files


def test_text_files_hold_units_signs_and_what_is_not_unique(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    turn = universal()
    frame = turn.to_dataframe()
    text = turn.to_csv(tmp_path / "turn.txt").read_text(encoding="utf-8")
    lines = text.splitlines()
    header = [line for line in lines if line.startswith("# ")]
    assert lines[: len(header)] == header
    assert "# mechanism: universal_joint" in header
    assert any(line.startswith("# wrenches: exerted by the parent link on") for line in header)
    (chosen,) = (line for line in header if line.startswith("# not_unique: "))
    assert (
        "chosen by least norm: bearing_in, pin_in, joint_angle, bearing_out, pin_out (force xyz)"
        in chosen
    )
    assert not any(line.startswith("# unproven") for line in header)
    # As texts: readers of numbers of older pandas round once more.
    read = pandas.read_csv(tmp_path / "turn.txt", comment="#", index_col=0, dtype=str)
    units = frame.attrs["units"]
    assert list(read) == [f"{name} [{units[name]}]" for name in frame]
    np.testing.assert_array_equal(read.to_numpy().astype(float), frame.to_numpy())
    bare = turn.to_csv(tmp_path / "bare.csv", header=False).read_bytes()
    assert bare == turn.save(tmp_path / "turn.csv").read_bytes()
    assert bare.decode() == "".join(f"{line}\n" for line in lines[len(header) :])
    with pytest.raises(cd.ArgumentError, match="cannot be written"):
        turn.to_csv(tmp_path / "missing" / "turn.csv")


def test_parquet_files_hold_the_same_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pandas = pytest.importorskip("pandas")
    turn = universal()

    def without(*_: object, **__: object) -> None:
        raise ImportError("no engine")

    with monkeypatch.context() as patched:
        patched.setattr(pandas.DataFrame, "to_parquet", without)
        with pytest.raises(cd.MissingExtraError, match="pip install pyarrow"):
            turn.save(tmp_path / "turn.parquet")
    pytest.importorskip("pyarrow")
    read = pandas.read_parquet(turn.save(tmp_path / "turn.parquet"))
    pandas.testing.assert_frame_equal(read, turn.to_dataframe(), check_exact=True)
    assert read.attrs["units"]["bearing_out.force_x"] == "N"
    assert read.attrs["unique"]["bearing_out"] == [False] * 3 + [True] * 3
    assert "parent link on the child link" in read.attrs["wrenches"]


@pytest.mark.slow
def test_tables_have_magnitudes_of_joints_without_an_axis() -> None:
    pytest.importorskip("pandas")
    turn = cd.Scene(cd.load(as_balls()), drive="a", loads={"d": -3.0}).sweep([0.1, 0.2])
    frame = turn.to_dataframe()
    sizes = np.linalg.norm(turn["b"].force, axis=1)
    np.testing.assert_allclose(frame["b.force_magnitude"], sizes, rtol=1e-14)
    np.testing.assert_allclose(frame["b.moment_magnitude"], turn["b"].magnitude.moment)
    assert np.all(np.isnan(frame["b.shear"]))
