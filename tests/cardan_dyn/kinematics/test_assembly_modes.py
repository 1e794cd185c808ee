"""Assembly modes: all that a four-bar has, by closed form, and their names."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.ball_rods import WAYS
from testkit.planar_linkages import BASE, COUPLER, CRANK, ROCKER, four_bar, geared, solver, values

import cardan_dyn as cd
from cardan_dyn.core.kinematics import assembly_modes as module
from cardan_dyn.core.kinematics.assembly_modes import assembly_modes, mode_name


def passives_of(mechanism: object, drive: str) -> np.ndarray:
    velocities = mechanism.coordinates.velocity_columns
    return np.setdiff1d(np.arange(mechanism.model.nv), [velocities[drive].start])


def rocker_positions(crank: float) -> np.ndarray:
    """Both positions of D for one of A: the pin lies on two circles."""
    pin = CRANK * np.array([-np.sin(crank), np.cos(crank)])
    away = np.array([BASE, 0.0]) - pin
    distance = np.linalg.norm(away)
    along = (COUPLER**2 - ROCKER**2 + distance**2) / (2.0 * distance)
    across = np.sqrt(COUPLER**2 - along**2) * np.array([1.0, -1.0])
    direction = away / distance
    tips = pin[:, None] + direction[:, None] * along
    tips = tips + np.array([[-direction[1]], [direction[0]]]) * across
    return np.arctan2(-(tips[0] - BASE), tips[1])


@pytest.mark.parametrize("crank", [0.0, 0.7, -2.0])
def test_a_four_bar_has_two_modes(crank: float) -> None:
    mechanism = four_bar()
    kinematics, first = solver(mechanism, "A")
    first[mechanism.coordinates.columns["A"]] = crank
    first = kinematics.close(first[None, :], most=60).x[0]
    found_modes = assembly_modes(mechanism, kinematics, passives_of(mechanism, "A"), first)
    assert [len(variants) for variants in found_modes.poses] == [1, 1]
    assert found_modes.is_complete
    modes = list(found_modes.named().values())
    angles = np.array([values(mechanism, mode, "D") for mode in modes])
    found = np.sort(np.mod(angles, 2.0 * np.pi))
    expected = np.sort(np.mod(rocker_positions(crank), 2.0 * np.pi))
    np.testing.assert_allclose(found, expected, atol=1e-9)
    # The first mode is the one that was given; the drive stays where it is in all of them.
    shapes = mechanism.coordinates.shape(np.array([first, modes[0]]))
    np.testing.assert_allclose(shapes[0], shapes[1], atol=1e-9)
    assert [values(mechanism, mode, "A") for mode in modes] == [crank] * 2


def test_modes_are_the_same_at_every_call() -> None:
    mechanism = four_bar()
    kinematics, first = solver(mechanism, "D")
    arguments = mechanism, kinematics, passives_of(mechanism, "D"), first
    once, again = (assembly_modes(*arguments).named() for _ in range(2))
    assert list(once) == list(again) == ["A", "B"]
    for name, state in once.items():
        np.testing.assert_array_equal(state, again[name])


def test_whole_turns_of_a_wheel_are_no_modes() -> None:
    mechanism = geared(1.0)
    kinematics, first = solver(mechanism, "A")
    modes = assembly_modes(mechanism, kinematics, passives_of(mechanism, "A"), first)
    np.testing.assert_array_equal(modes.poses, [[first]])
    assert (modes.starts, modes.last_new) == (400, 100)


def test_a_search_may_end_before_it_is_complete(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every round of starts that finds a new pose makes the search three times as long."""
    mechanism = four_bar()
    kinematics, first = solver(mechanism, "A")
    monkeypatch.setattr(module, "_MOST_ROUNDS", 2)
    modes = assembly_modes(mechanism, kinematics, passives_of(mechanism, "A"), first)
    assert (modes.starts, modes.is_complete) == (200, False)
    assert len(modes.poses) == 2


def test_names() -> None:
    names = {0: "A", 1: "B", 25: "Z", 26: "AA", 51: "AZ", 52: "BA", 701: "ZZ", 702: "AAA"}
    assert {index: mode_name(index) for index in names} == names
    assert [mode_name(2, variant) for variant in range(3)] == ["C", "C2", "C3"]
    listed = [mode_name(pose, variant) for pose in range(100) for variant in range(5)]
    assert len(set(listed)) == 500


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
def test_spins_of_idle_rods_make_no_modes(way: str) -> None:
    """Crank and rocker of a spatial four-bar with balls have two positions, as in a plane."""
    scene = cd.Scene(cd.load(WAYS[way]()), drive="a")
    modes = scene.branches()
    assert len(modes) == 2
    assert abs(modes["A"]["d"] - modes["B"]["d"]) > 0.5
