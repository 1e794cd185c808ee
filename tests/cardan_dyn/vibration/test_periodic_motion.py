"""Periodic motions as users get them."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest
from shooting import orders, periodic
from testkit import elastic_rigs
from tilting_shaft import TiltingShaft

import cardan_dyn as cd
from cardan_dyn import ArgumentError, VibrationError, vibration
from cardan_dyn.motion.vibration.results.periodic_motion import _collected, search_of
from cardan_dyn.vibration import PeriodicMotion

SPEED = 0.51303
LINE = elastic_rigs.torsional_line(damping_in=0.1)


@pytest.fixture(scope="module")
def rig() -> cd.Scene:
    return elastic_rigs.scene(elastic_rigs.elastic_rig(), np.radians(5.0))


@pytest.fixture(scope="module")
def found(rig: cd.Scene) -> PeriodicMotion:
    return vibration.periodic_motion(rig, [SPEED, 0.9])


@pytest.mark.slow
def test_amplitudes_against_shooting(found: PeriodicMotion) -> None:
    system = TiltingShaft(np.radians(5.0), SPEED)
    state = found.at(0.0)
    start = np.r_[state.position[0, 0], state.velocity[0, 0] / SPEED]
    shot = periodic(system, start)
    np.testing.assert_allclose(shot.start, start, atol=1e-13)
    expected = orders(system, shot.start)
    for wave, order in enumerate(found.order[:8]):
        factor = 2.0 if wave else 1.0
        assert order == 2.0 * wave
        np.testing.assert_allclose(found.amplitude[0, wave], factor * expected[wave], atol=1e-12)
    assert np.max(found.residual) < 1e-11
    assert found.branch.tolist() == [0, 0]
    assert found.index.tolist() == [1, 1]


@pytest.mark.slow
def test_steady_part_of_a_simulation() -> None:
    scene = elastic_rigs.scene(LINE, np.radians(20.0))
    speed, turns = 0.7, 40
    duration = 2.0 * np.pi / speed * (turns + 1)
    motion = vibration.periodic_motion(scene, speed)
    begin = motion.at(0.0)
    run = scene.simulate(
        duration,
        position={"twist_in": begin.position[0, 0, 0] + 1e-3},
        speed={"twist_in": begin.velocity[0, 0, 0]},
        motion={"bearing_in": speed},
        rtol=1e-12,
    )
    late = np.linspace(duration * turns / (turns + 1), duration, 50)
    steady = run.at(late)
    # Damping has reduced the disturbance by e^-18.
    np.testing.assert_allclose(
        np.asarray(steady.position)[:, 1], motion.at(speed * late).position[0, :, 0], atol=1e-8
    )


def test_sweep_needs_no_effort_along_free_coordinates(found: PeriodicMotion) -> None:
    turn = found.sweep(1)
    assert np.max(np.abs(turn.drive_effort[:, 1:])) < 1e-14
    assert turn.balance_residual < 1e-10
    assert turn.speed[0, 0] == 0.9


@pytest.mark.slow
def test_several_motions_are_rows_of_one_speed() -> None:
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(), np.radians(15.0))
    found = vibration.periodic_motion(scene, [0.4975, 1.2])
    assert found.speed.tolist() == [0.4975] * 4 + [1.2]
    assert found.branch.tolist() == [0, 1, 2, 3, 0]
    swings = np.max(np.abs(found.at(np.linspace(0.0, np.pi, 100)).position), axis=(1, 2))
    assert np.all(np.diff(swings[:4]) > -1e-9)
    assert "5 motions at 2 speeds" in repr(found)


@pytest.mark.slow
def test_motions_that_were_not_found_are_said_to_exist() -> None:
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(damping_in=0.04), np.radians(45.0))
    every = vibration.periodic_motion(scene, [0.505, 0.8])
    assert every.speed.tolist() == [0.505] * 3 + [0.8]
    assert every.incomplete.tolist() == []
    assert "not found" not in repr(every)
    # The largest swings by 0.72 rad; without it, the indices do not add up.
    some = vibration.periodic_motion(scene, [0.505, 0.8], max_amplitude=0.6)
    assert some.incomplete.tolist() == [0.505]
    assert "others exist at 1 of them that were not found" in repr(some)


@pytest.mark.slow
def test_rows_of_a_speed_are_sorted_by_size() -> None:
    """However they were found."""
    scene = elastic_rigs.scene(elastic_rigs.torsional_line(), np.radians(15.0))
    search, speeds = search_of(scene, 1.0), np.array([0.4975])
    found = _collected(search, speeds, [*reversed(search.every(speeds))])
    assert found.branch.tolist() == [0, 1, 2, 3]
    places = np.linspace(0.0, np.pi, 100)
    assert np.all(np.diff(np.ptp(found.at(places).position, axis=(1, 2))) > 0.0)


@pytest.mark.slow
def test_linear_resonance_without_damping_is_refused() -> None:
    # A spring behind the joint: the equation is linear, its resonance has no periodic motion.
    line = elastic_rigs.torsional_line(stiffness_in=None, stiffness_out=2.0)
    scene = elastic_rigs.scene(line, np.radians(15.0))
    with pytest.raises(
        VibrationError, match=r"no periodic motion was .* greater max_amplitude="
    ) as caught:
        vibration.periodic_motion(scene, 1.0)
    assert caught.value.speed == 1.0
    found = vibration.periodic_motion(scene, [0.8, 1.0])
    assert found.speed.tolist() == [0.8]
    assert list(found.missed) == [1.0]


def test_orbits_and_tables(found: PeriodicMotion) -> None:
    orbit = found.orbit("tilt_y", "tilt_z")
    assert orbit.shape == (361, 2)
    np.testing.assert_allclose(orbit[0], orbit[-1], atol=1e-17)
    # Its area, from y to z, is that of circles forwards less those backwards, n times each.
    middle, way = 0.5 * (orbit[1:] + orbit[:-1]), np.diff(orbit, axis=0)
    area = 0.5 * np.sum(middle[:, 0] * way[:, 1] - middle[:, 1] * way[:, 0])
    y, z = (found.amplitude[0, :, found.free.index(name)] for name in ("tilt_y", "tilt_z"))
    circles = 0.25 * (np.abs(y + 1j * z) ** 2 - np.abs(y - 1j * z) ** 2)
    assert area == pytest.approx(np.pi * found.order @ circles, rel=1e-3)
    assert area > 0.0
    frame = found.to_dataframe()
    first = frame[(frame.speed == SPEED) & (frame.coordinate == "tilt_y") & (frame.order == 2.0)]
    column = found.free.index("tilt_y")
    assert first.amplitude.item() == pytest.approx(abs(found.amplitude[0, 1, column]))
    lines = frame[(frame.speed == 0.9) & (frame.coordinate == "tilt_y")]
    summed = np.sum(lines.amplitude * np.cos(0.7 * lines.order + lines.phase))
    assert summed == pytest.approx(found.at(0.7).position[1, 0, column], rel=1e-9)
    assert frame.attrs["units"]["speed"] == "rad/s"
    with pytest.raises(ArgumentError, match="'bearing_in' is not free"):
        found.orbit("bearing_in", "tilt_z")


def test_copies_and_files(found: PeriodicMotion, tmp_path: Path) -> None:
    for twin in (copy.deepcopy(found), pickle.loads(pickle.dumps(found))):
        np.testing.assert_array_equal(twin.amplitude, found.amplitude)
        assert not twin.amplitude.flags.writeable
    found.save(tmp_path / "motion.npz")
    with np.load(tmp_path / "motion.npz") as stored:
        np.testing.assert_array_equal(stored["amplitude"], found.amplitude)
    assert found.plot().axes
    (axes,) = found.plot.orbit().axes
    path = found.orbit(*found.free[:2], count=361)
    np.testing.assert_array_equal(axes.lines[0].get_xydata(), path)


def test_rows_that_do_not_exist_are_refused(found: PeriodicMotion) -> None:
    for call in (
        found.sweep,
        lambda row: found.plot(row=row),
        lambda row: found.orbit("tilt_y", "tilt_z", row),
    ):
        with pytest.raises(ArgumentError, match="row 2 does not exist; motions: 0 to 1"):
            call(2)
        with pytest.raises(ArgumentError, match="row is -1"):
            call(-1)
    with pytest.raises(ArgumentError, match="count is 0"):
        found.orbit("tilt_y", "tilt_z", count=0)


def test_positions_are_a_row(found: PeriodicMotion) -> None:
    with pytest.raises(ArgumentError, match="position has shape"):
        found.at([[0.0, 1.0]])


@pytest.mark.parametrize("max_amplitude", [0.0, -1.0, [1.0, 2.0], "far"])
def test_ranges_are_positive_numbers(rig: cd.Scene, max_amplitude: object) -> None:
    with pytest.raises(ArgumentError, match="max_amplitude"):
        vibration.periodic_motion(rig, 1.0, max_amplitude=max_amplitude)  # type: ignore[arg-type]


@pytest.mark.parametrize("row", [2, -1, "first"])
def test_rows_that_are_none(found: PeriodicMotion, row: object) -> None:
    for ask in (
        found.sweep,
        lambda row: found.plot(row=row),
        lambda row: found.orbit("tilt_y", "tilt_z", row),
    ):
        with pytest.raises(ArgumentError, match="row"):
            ask(row)  # type: ignore[operator]


@pytest.mark.parametrize(("mass", "length"), [(1e-6, 1e-4), (1e4, 30.0)])
def test_slides_beside_tilts_in_any_units(mass: float, length: float) -> None:
    """Metres and radians differ by the length of the rig, what is left of its motion does not."""
    plain = vibration.periodic_motion(elastic_rigs.unbalanced_scene(), 2.3)
    scaled = vibration.periodic_motion(elastic_rigs.unbalanced_scene(mass, length), 2.3)
    assert plain.period == pytest.approx(2.0 * np.pi)
    assert np.max(np.abs(plain.amplitude[0, 1])) > 1e-4
    for order in (0, 1, 2):
        found = scaled.amplitude[0, order] / [length, 1.0]
        np.testing.assert_allclose(found, plain.amplitude[0, order], atol=1e-12)
