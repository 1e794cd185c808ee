"""Floquet multipliers over speed and design."""

from __future__ import annotations

import os
import pickle
import sys
from pathlib import Path

import numpy as np
import pytest
from shooting import periodic
from testkit import elastic_rigs
from vibrating_lines import SpringInFront

import cardan_dyn as cd
from cardan_dyn import ArgumentError, VibrationError, vibration
from cardan_dyn.vibration import Floquet


@pytest.fixture(scope="module")
def chart() -> Floquet:
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(), 0.1)
    angles = np.radians([5.0, 20.0, 40.0])
    return vibration.floquet(scene, np.linspace(0.8, 1.2, 9), held={"joint_angle": angles})


@pytest.mark.slow
def test_the_unstable_wedge_of_a_chart(chart: Floquet) -> None:
    assert chart.kind.shape == (3, 9)
    assert chart.multipliers.shape == (3, 9, 2)
    counts = np.sum(chart.kind == "instability", axis=1)
    # 1 ± a β²/4, in steps of 0.05.
    assert counts.tolist() == [1, 1, 3]
    assert np.all(chart.is_stable == (chart.kind == "stable"))
    assert np.max(np.abs(chart.determinant - 1.0)) < 1e-11
    assert np.max(np.abs(chart.trace[chart.is_stable])) <= 2.0 + 1e-10
    assert chart.growth[2, 4] > chart.growth[1, 4] > 1e-3
    assert chart.period == pytest.approx(np.pi)


@pytest.mark.slow
def test_a_design_of_a_chart_is_the_scene_that_holds_it(chart: Floquet) -> None:
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(), np.radians(20.0))
    alone = vibration.floquet(scene, chart.speed)
    np.testing.assert_allclose(alone.trace, chart.trace[1], atol=1e-11)


@pytest.mark.slow
def test_workers_change_nothing(chart: Floquet) -> None:
    held = {"joint_angle": np.radians([5.0, 20.0, 40.0, 10.0, 11.0, 12.0, 13.0, 14.0])}
    alone, shared = (
        vibration.floquet(chart.scene, chart.speed[:3], held=held, workers=workers)
        for workers in (1, 2)
    )
    np.testing.assert_array_equal(shared.trace, alone.trace)
    np.testing.assert_allclose(shared.trace[:3], chart.trace[:, :3], atol=1e-12)


@pytest.mark.skipif(sys.platform in ("darwin", "win32"), reason="nothing is forked here")
def test_a_lost_worker_is_reported(chart: Floquet, monkeypatch: pytest.MonkeyPatch) -> None:
    here = os.getpid()

    def dying(*given: object) -> None:
        assert os.getpid() != here
        os._exit(9)

    module = sys.modules[Floquet.__module__]
    monkeypatch.setattr(module, "MotionSearch", dying)
    with pytest.raises(cd.CardanError, match="a worker process was lost"):
        vibration.floquet(chart.scene, 1.0, held={"joint_angle": [0.1, 0.2]}, workers=2)


@pytest.mark.slow
def test_growth_is_that_of_the_fastest_disturbance() -> None:
    """ln|λ| over the time π/Ω of half a turn; forwards and backwards alike."""
    beta, speed = np.radians(20.0), 1.0
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(), beta)
    shot = periodic(SpringInFront(beta, speed), np.zeros(2))
    expected = np.log(np.max(np.abs(shot.multipliers))) * speed / np.pi
    assert vibration.floquet(scene, speed).growth == pytest.approx([expected], rel=1e-8)
    assert vibration.floquet(scene, -speed).growth == pytest.approx([expected], rel=1e-8)


def test_a_damped_line_is_stable_in_both_senses() -> None:
    line = elastic_rigs.torsional_line(damping_in=0.1)
    found = vibration.floquet(elastic_rigs.scene(line, 0.3), [0.7, -0.7])
    assert found.kind.tolist() == ["stable", "stable"]
    np.testing.assert_allclose(found.trace[1], found.trace[0], rtol=1e-10)
    np.testing.assert_allclose(found.determinant, found.liouville, rtol=1e-11)
    # The determinant is exp(-∮ d/J dt), below one.
    assert np.all(found.determinant < 0.9)


@pytest.mark.slow
def test_further_motions_are_counted() -> None:
    """Below a half of the natural frequency its resonance is bent: several motions coexist."""
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(), np.radians(15.0))
    found = vibration.floquet(scene, [0.4975, 1.2])
    every = vibration.periodic_motion(scene, [0.4975, 1.2])
    counts = [int(np.sum(every.speed == speed)) - 1 for speed in found.speed]
    assert found.coexisting.tolist() == counts
    assert counts[0] > 0 == counts[1]
    # Of a well resolved integration, and never nothing.
    assert 0.0 < found.change < 1e-11


def test_designs_of_different_periods_are_not_compared() -> None:
    """A weight beside the axis, which acts along it where both shafts are in line."""
    urdf = elastic_rigs.torsional_line(stiffness_in=None, stiffness_out=0.5)
    plain = '<link name="flywheel"><inertial>'
    heavy = urdf.replace(plain, f'{plain}<origin xyz="0 0.1 0"/>')
    assert heavy != urdf
    scene = elastic_rigs.scene(heavy, 0.3, gravity=(0.5, 0.0, 0.0))
    for angle, period in ((0.0, np.pi), (0.3, 2.0 * np.pi)):
        found = vibration.floquet(scene, 0.7, held={"joint_angle": [angle]})
        assert found.period == pytest.approx(period)
    with pytest.raises(ArgumentError, match="some designs repeat after half a revolution"):
        vibration.floquet(scene, 0.7, held={"joint_angle": [0.0, 0.3]})


@pytest.mark.slow
def test_a_chart_may_begin_without_an_angle_at_a_resonance() -> None:
    """Undamped, order 2 meets the frequency 1; nothing excites it at the angle 0."""
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(), 0.0)
    found = vibration.floquet(scene, 0.5, held={"joint_angle": [0.0, 0.2]})
    np.testing.assert_allclose(found.multipliers[0, 0], [1.0, 1.0], atol=1e-7)


@pytest.mark.slow
def test_null_test_with_the_spring_behind() -> None:
    """Multipliers e^{±iπ/r}, never unstable."""
    line = elastic_rigs.torsional_line(stiffness_in=None, stiffness_out=0.5, inertia_out=0.5)
    scene = elastic_rigs.scene(line, np.radians(40.0))
    speed = np.array([0.3, 0.45, 0.62, 0.97, 1.03, 1.9])
    found = vibration.floquet(scene, speed, edges=True)
    np.testing.assert_allclose(found.trace, 2.0 * np.cos(np.pi / speed), atol=1e-11)
    assert found.regions == ()


def test_springs_on_both_sides_have_a_combined_region() -> None:
    line = elastic_rigs.torsional_line(0.5, 0.5, 1.0, 1.0)
    scene = elastic_rigs.scene(line, np.radians(15.0))
    found = vibration.floquet(scene, np.linspace(1.4, 1.8, 9), edges=True)
    (region,) = found.regions
    # ω² = 3 ∓ √5 in units of k/(2 J).
    frequencies = np.sqrt(3.0 + np.array([-1.0, 1.0]) * np.sqrt(5.0))
    assert region.kind == "combination"
    assert region.lower < np.mean(frequencies) < region.upper


def test_a_uniform_double_joint_is_unstable_all_the_same(tmp_path: Path) -> None:
    scene = elastic_rigs.scene(elastic_rigs.double_joint(), np.radians(20.0))
    found = vibration.floquet(scene, np.linspace(0.9, 1.1, 9), edges=True)
    (region,) = found.regions
    found.save(tmp_path / "regions.npz")
    with np.load(tmp_path / "regions.npz") as stored:
        assert stored["region.lower"].tolist() == [region.lower]
        assert stored["region.kind"].tolist() == ["instability"]
        assert stored["region.design"].tolist() == [0]
    assert region.lower == pytest.approx(0.9696, abs=5e-5)
    assert region.upper == pytest.approx(1.0318, abs=5e-5)


@pytest.mark.slow
def test_flutter_under_a_load_along_the_shaft() -> None:
    """From about T_L = 4 ζ c on."""
    urdf = elastic_rigs.elastic_rig(damping_ratio=0.02)
    kinds = []
    for load in (0.07, 0.09):
        options = {"loads": {"shaft_out": [0.0, 0.0, 0.0, -load, 0.0, 0.0]}}
        scene = elastic_rigs.scene(urdf, np.radians(5.0), **options)
        kinds.append(vibration.floquet(scene, [0.31, 0.7]).kind.tolist())
    assert kinds == [["stable", "stable"], ["flutter", "flutter"]]


def test_tables_figures_and_files(chart: Floquet, tmp_path: Path) -> None:
    frame = chart.to_dataframe()
    assert len(frame) == 27
    assert set(frame.columns) >= {"joint_angle", "speed", "kind", "growth"}
    assert chart.plot().axes
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(), 0.3)
    assert vibration.floquet(scene, [0.6, 0.7, 0.8]).plot().axes
    chart.save(tmp_path / "chart.npz")
    with np.load(tmp_path / "chart.npz") as stored:
        np.testing.assert_array_equal(stored["trace"], chart.trace)
        assert stored["held.joint_angle"].shape == (3,)
        assert "region.lower" not in stored
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(chart)).trace, chart.trace)
    assert "27 points" in repr(chart)


def test_what_is_asked_for_wrongly(chart: Floquet) -> None:
    with pytest.raises(ArgumentError, match="regions were not asked for"):
        _ = vibration.floquet(chart.scene, 0.7).regions
    with pytest.raises(ArgumentError, match="ascending speeds"):
        vibration.floquet(chart.scene, [1.0, 0.9], edges=True)
    with pytest.raises(ArgumentError, match="'twist_in' is not held by the scene"):
        vibration.floquet(chart.scene, 1.0, held={"twist_in": [0.3]})
    with pytest.raises(ArgumentError, match="has shape"):
        vibration.floquet(chart.scene, 1.0, held={"joint_angle": [[0.3]]})


def test_one_position_is_one_design(chart: Floquet) -> None:
    one, alone = (
        vibration.floquet(scene, 0.7, held=held)
        for scene, held in (
            (chart.scene, {"joint_angle": 0.3}),
            (chart.scene.replace(held={"joint_angle": 0.3}), None),
        )
    )
    assert one.kind.shape == (1, 1)
    np.testing.assert_array_equal(one.multipliers[0], alone.multipliers)


def boxes(axes: object) -> list[tuple[float, float, float]]:
    """Lower and upper speed [rad/s] and lower ordinate of what a chart fills."""
    found = [item.get_paths()[0].get_extents() for item in axes.collections[::2]]
    return [(box.x0 * np.pi / 30.0, box.x1 * np.pi / 30.0, box.y0) for box in found]


@pytest.mark.slow
def test_a_chart_draws_the_regions_that_its_object_holds() -> None:
    """Two of the three lie between its speeds, where no sample is unstable."""
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(), 0.1)
    angles, speeds = np.radians([30.0, 5.0, 12.0]), [0.9, 0.97, 1.03, 1.1]
    found = vibration.floquet(scene, speeds, held={"joint_angle": angles}, edges=True)
    assert np.sum(found.kind != "stable", axis=1).tolist() == [2, 0, 0]
    assert "12 points, 2 of them unstable, 3 unstable intervals" in repr(found)
    (axes,) = found.plot().axes
    regions = [found.region[design][0] for design in (1, 2, 0)]
    lows = [5.0, 8.5, 21.0]
    expected = [(row.lower, row.upper, low) for row, low in zip(regions, lows, strict=True)]
    np.testing.assert_allclose(boxes(axes), expected)
    # Without edges, unstable speeds stand for what is half way to their neighbours.
    (axes,) = vibration.floquet(scene, speeds, held={"joint_angle": angles}).plot().axes
    np.testing.assert_allclose(boxes(axes), [(0.935, 1.065, 21.0)])
    # Those of a single design lie beside the lines of its multipliers.
    one = vibration.floquet(scene, speeds, held={"joint_angle": angles[1:2]}, edges=True)
    (axes,) = one.plot().axes
    (row,) = one.region[0]
    edges = {line.get_xdata()[0] * np.pi / 30.0 for line in axes.lines[2:4]}
    assert sorted(edges) == pytest.approx([row.lower, row.upper])


@pytest.mark.slow
def test_speeds_without_a_motion_are_drawn_and_counted() -> None:
    line = elastic_rigs.torsional_line(damping_in=0.01)
    scene = elastic_rigs.scene(line, 0.1)
    held = {"joint_angle": np.radians([10.0, 12.0])}
    found = vibration.floquet(scene, [0.4, 0.5, 0.6], held=held, edges=True, max_amplitude=0.05)
    assert found.kind[:, 1].tolist() == ["no motion"] * 2
    assert "0 of them unstable, 2 without a motion, 0 unstable intervals" in repr(found)
    (axes,) = found.plot().axes
    np.testing.assert_allclose([box[:2] for box in boxes(axes)], [(0.45, 0.55)] * 2)
    assert axes.get_legend_handles_labels()[1] == ["no motion"]


@pytest.mark.slow
def test_charts_of_several_joints_slides_and_single_designs() -> None:
    scene = elastic_rigs.scene(elastic_rigs.double_joint(), 0.1)
    equal, angles = [0.1, 0.1, 0.1], np.array([0.3, 0.1, 0.2])
    held = {"joint_angle_1": equal, "joint_angle_2": angles}
    (axes,) = vibration.floquet(scene, [0.9, 0.7, 0.8], held=held).plot().axes
    assert axes.get_ylabel() == "joint_angle_2 with joint_angle_1 [°]"
    assert axes.get_ylim() == pytest.approx(np.degrees([0.1, 0.3]))
    assert axes.get_xlim() == pytest.approx(np.array([0.7, 0.9]) * 30.0 / np.pi)
    single = vibration.floquet(scene, [0.7, 0.8], held={"joint_angle_1": [0.2]})
    assert single.plot().axes[0].get_ylabel() == "size of multipliers"
    alike = vibration.floquet(scene, [0.7, 0.8], held={"joint_angle_1": equal})
    with pytest.raises(ArgumentError, match="whose positions all differ, not joint_angle_1"):
        alike.plot()


def test_a_chart_over_a_slide_has_millimetres() -> None:
    urdf = elastic_rigs.torsional_line().replace(
        '<joint name="joint_angle"',
        '<link name="table"/><joint name="way" type="prismatic"><parent link="base"/>'
        '<child link="table"/><axis xyz="1 0 0"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint><joint name="joint_angle"',
    )
    rig, held = cd.load(urdf), {"joint_angle": 0.3, "way": 0.0}
    elements = cd.described_elements(rig)
    scene = cd.Scene(rig, drive="bearing_in", free="twist_in", held=held, elements=elements)
    (axes,) = vibration.floquet(scene, [0.7, 0.8], held={"way": [0.0, 0.5]}).plot().axes
    assert axes.get_ylabel() == "way [mm]"
    assert axes.get_ylim() == pytest.approx((0.0, 0.5))


def test_next_to_no_speed_is_refused() -> None:
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(damping_in=0.1), 0.1)
    assert np.all(vibration.floquet(scene, [1e-3]).is_stable)
    with pytest.raises(VibrationError, match="too often to be integrated: choose a greater speed"):
        vibration.floquet(scene, 1e-9)
