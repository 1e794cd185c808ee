"""Assembly modes: all that a four-bar has, by closed form, and their names."""

from __future__ import annotations

import re
from pathlib import Path

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
    np.testing.assert_allclose(
        mechanism.coordinates.apart(modes[0][None, :], first), 0.0, atol=1e-9
    )
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


def resized(name: str, factor: float) -> str:
    """Return a bundled mechanism with all lengths times a factor, on a base that is turned."""
    text = (Path(__file__).parents[3] / "urdf" / f"{name}.urdf").read_text()

    def longer(found: re.Match[str]) -> str:
        return found[1] + " ".join(repr(factor * float(part)) for part in found[2].split()) + '"'

    text = re.sub(r'(<origin xyz=")([^"]*)"', longer, text)
    (base,) = re.findall(r'<link name="(\w+)"', text)[:1]
    turned = (
        '<link name="floor"/><joint name="stand" type="fixed"><parent link="floor"/>'
        f'<child link="{base}"/><origin xyz="0 0 0" rpy="0.3 -0.7 1.1"/></joint></robot>'
    )
    return text.replace("</robot>", turned)


@pytest.mark.parametrize(
    "name", ["double_shaft_z", pytest.param("drive_line", marks=pytest.mark.slow)]
)
def test_names_do_not_depend_on_the_size_of_a_mechanism_nor_on_how_it_stands(name: str) -> None:
    """Many variants are as far off the first one: each pin of a cross may be flipped by itself."""
    held = {"double_shaft_z": (0.5, 0.5), "drive_line": (0.14, -0.21, 0.17)}[name]
    joints = {f"joint_angle_{k}": angle for k, angle in enumerate(held, 1)}

    def named(mechanism: cd.Mechanism) -> dict[str, np.ndarray]:
        scene = cd.Scene(mechanism, drive="bearing_in", held=joints)
        columns = mechanism.coordinates.angle_columns
        modes = scene.solver.assembly.modes.named()
        return {key: np.exp(1j * state[columns]) for key, state in modes.items()}

    expected = named(cd.load(name))
    assert len(expected) >= 8
    for factor in (1e-3, 0.3, 1e3):
        found = named(cd.load(resized(name, factor)))
        assert set(found) == set(expected)
        for key, angles in expected.items():
            np.testing.assert_allclose(found[key], angles, rtol=0.0, atol=1e-6, err_msg=key)
