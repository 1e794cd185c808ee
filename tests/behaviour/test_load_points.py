"""Wrenches on links with a point of application, against the same wrench about the origin."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import cardan_dyn as cd

TURN = np.linspace(0.0, 6.0, 9)
FORCE, MOMENT = np.array([30.0, -20.0, 5.0]), np.array([1.0, -2.0, 0.5])
POINT = np.array([0.2, -0.1, 0.05])


def four_bar(load: Any, **options: Any) -> cd.Scene:
    given = {"drive": "crank_bearing", "loads": {"coupler": load}, **options}
    return cd.Scene(cd.load("four_bar"), **given)


def same(one: cd.Sweep | cd.Trajectory, other: cd.Sweep | cd.Trajectory) -> None:
    np.testing.assert_allclose(one.drive_effort, other.drive_effort, atol=1e-11)
    for name in one.outputs:
        np.testing.assert_allclose(one[name].force, other[name].force, atol=1e-10)
        np.testing.assert_allclose(one[name].moment, other[name].moment, atol=1e-10)


def test_a_force_at_a_point_of_the_link_is_one_about_its_origin_with_a_moment() -> None:
    at_point = four_bar(cd.Wrench(FORCE, MOMENT, point=POINT)).sweep(TURN, speed=3.0)
    about_origin = four_bar(cd.Wrench(FORCE, MOMENT + np.cross(POINT, FORCE)))
    same(at_point, about_origin.sweep(TURN, speed=3.0))
    assert at_point.balance_residual < 1e-13


def test_a_force_in_world_axes_moves_with_its_point() -> None:
    """Its moment about the link's origin turns with the link; its power is force times velocity."""
    scene = four_bar(cd.Wrench(FORCE, MOMENT, "world", POINT))
    turn = scene.sweep(TURN, speed=3.0)
    bare = four_bar(cd.Wrench()).sweep(TURN, speed=3.0)
    arm = turn.orientation("coupler") @ POINT
    moments = MOMENT + np.cross(arm, FORCE)
    given = four_bar(cd.Wrench(np.repeat(FORCE[None], len(TURN), 0), moments, "world"))
    same(turn, given.sweep(TURN, speed=3.0))
    point = turn.point("coupler", POINT)
    power = point.velocity @ FORCE + point.angular_velocity @ MOMENT
    np.testing.assert_allclose(3.0 * (bare.drive_effort - turn.drive_effort), power, atol=1e-11)
    assert turn.balance_residual < 1e-13


@pytest.mark.slow
def test_responses_and_simulations_know_the_point() -> None:
    at_point = four_bar(cd.Wrench(FORCE, MOMENT, "world", POINT))
    same(at_point.response().sweep(TURN, speed=3.0), at_point.sweep(TURN, speed=3.0))
    load = cd.Wrench(FORCE, MOMENT, point=POINT)
    moved = cd.Wrench(FORCE, MOMENT + np.cross(POINT, FORCE))
    times = [0.05, 0.1]
    paths = [
        four_bar(given, drive=(), free="crank_bearing").simulate(
            0.1, position=0.3, speed=5.0, loads=loads
        )
        for given, loads in (
            (load, None),
            (moved, None),
            (cd.Wrench(), {"coupler": lambda time: load}),
        )
    ]
    for path in paths[1:]:
        np.testing.assert_allclose(path.at(times).position, paths[0].at(times).position, atol=1e-8)
        assert path.energy_residual < 1e-8
    scene = four_bar(cd.Wrench(), drive=(), free="crank_bearing")
    wandering = {"coupler": lambda time: cd.Wrench(FORCE, point=(time, 0.0, 0.0))}
    path = scene.simulate(0.01, position=0.3, loads=wandering)
    with pytest.raises(cd.ArgumentError, match="returned wrenches at several points"):
        _ = path.drive_effort


def test_scenes_and_tables_tell_the_point() -> None:
    scene = four_bar(cd.Wrench(FORCE, MOMENT, "world", POINT))
    load = scene.loads["coupler"]
    assert isinstance(load, cd.Wrench)
    np.testing.assert_array_equal(load.point, POINT)
    again = scene.replace(gravity=(0.0, 0.0, -9.81)).loads["coupler"]
    np.testing.assert_array_equal(again.point, POINT)  # type: ignore[union-attr]
    assert '"point": [0.2, -0.1, 0.05]' in scene.sweep(TURN).table().attributes["loads"]
    for wrong in ((0.0, 1.0), "tip", np.nan):
        with pytest.raises(cd.ArgumentError, match=r"loads\['coupler'\]\.point"):
            four_bar(cd.Wrench(FORCE, point=wrong))
