"""Turns of designs: crank-rockers, drag links and rockers in one sweep, each as it turns itself."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.bars_of_lengths import four_bar_of_lengths

import cardan_dyn as cd

TURN = 2.0 * np.pi
CRANK_ROCKER, DRAG_LINK, ROCKER = 0.0, -0.37, 0.2
"""Changes of the frame of 0.4 m, between bars of 0.1, 0.35 and 0.3 m."""


@pytest.fixture(scope="module", params=[CRANK_ROCKER, DRAG_LINK])
def scene(request: pytest.FixtureRequest) -> cd.Scene:
    return scene_at(request.param)


def scene_at(frame: float) -> cd.Scene:
    start = {"drive": 0.5 * np.pi}
    return cd.Scene(four_bar_of_lengths(), drive="drive", held={"frame": frame}, near=start)


def turned(scene: cd.Scene, frames: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return how designs come back a turn later: positions less turns, and whole turns."""
    part = scene.solver.of_varied(("frame",)).assembly._guesses._parts[0]
    columns, (drive,) = part._drive_columns, part._driven
    own = np.repeat(part._start[None, columns], len(frames), axis=0)
    own[:, drive] += 1.25 * TURN
    own[:, part._held] = frames[:, None]
    turns = np.zeros((len(frames), part._start.size))
    part._take_turns_off(own, turns)
    return own[:, drive] - part._start[columns[drive]] - 0.25 * TURN, turns


def test_each_design_comes_back_as_grashof_says(scene: cd.Scene) -> None:
    left, turns = turned(scene, np.array([CRANK_ROCKER, DRAG_LINK, ROCKER]))
    np.testing.assert_allclose(left, [0.0, 0.0, TURN], atol=2e-15)
    column = scene.mechanism.coordinates.named["bearing"].column
    # The rocker swings, the drag link turns with the crank.
    np.testing.assert_array_equal(np.abs(turns[:, column]), [0.0, 1.0, 0.0])


@pytest.mark.slow
def test_many_designs_come_back_as_each_alone(
    scene: cd.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By tapes as by the general way, up to the borders at frames of 0.05 m and 0.55 m."""
    frames = np.linspace(-0.375, 0.19, 1200)
    found = turned(scene, frames)
    monkeypatch.setattr(
        "cardan_dyn.core.kinematics.following.taped_lines.TapedLines.ends",
        lambda self, positions: (
            np.tile(self._start * self._units, (len(positions), 1)),
            np.zeros(len(positions), dtype=bool),
        ),
    )
    for values, expected in zip(found, turned(scene, frames), strict=True):
        np.testing.assert_array_equal(values, expected)
    assert 0 < np.sum(found[0] > 1.0) < 600


@pytest.mark.parametrize("design", [CRANK_ROCKER, DRAG_LINK])
def test_motion_goes_on_over_whole_turns(scene: cd.Scene, design: float) -> None:
    position = np.array([1.0, TURN - 0.01, TURN + 0.01, TURN + 2.0, 40.0 * TURN + 1.0])
    turn = scene.sweep(position, held={"frame": np.full(5, design)})
    expected = scene_at(design).sweep(position)
    for name in ("bearing", "pin"):
        found = turn.motion.position(name)
        own = expected.motion.position(name)
        # Both count from their own start, which may be whole turns apart.
        offset = TURN * np.rint((found[0] - own[0]) / TURN)
        np.testing.assert_allclose(found - offset, own, atol=1e-10)
        assert abs(found[2] - found[1]) < 0.2


@pytest.mark.slow
def test_designs_that_do_not_turn_are_not_reached_a_turn_later(scene: cd.Scene) -> None:
    position = np.array([1.5, TURN + 1.5, 2.0 * TURN])
    mask = scene.reachable(position[:, None], held={"frame": [CRANK_ROCKER, ROCKER]})
    np.testing.assert_array_equal(mask, [[True, True], [True, False], [True, False]])


@pytest.mark.slow
@pytest.mark.parametrize("turns", [1.0, 3.0])
def test_dense_designs_near_the_border_of_the_kinds_turn_as_grashof_says(turns: float) -> None:
    """From a frame of 0.55 m on, the drive swings: none is reached a turn later, however dense."""
    rng, scene = np.random.default_rng(5), scene_at(0.12)
    frame = rng.uniform(0.1, 0.2, 4000)
    ahead = turns * rng.uniform(-TURN, TURN, 4000)
    is_there = scene.reachable(0.5 * np.pi + ahead, held={"frame": frame})
    np.testing.assert_array_equal(is_there[frame < 0.15], True)
    rockers = frame > 0.15
    assert not np.any(is_there[rockers & (np.abs(ahead) > TURN)])
    # Less than a quarter of a turn ahead the bars beyond the crank are in line, where it ends.
    assert not np.any(is_there[rockers & (ahead > np.pi)])
    assert np.mean(is_there[rockers & (np.abs(ahead) < 0.3)]) == 1.0


def test_designs_near_a_singular_one_turn_as_often_as_others(joint: cd.Mechanism) -> None:
    """At 90° the joint locks; tan φ₂ = tan φ₁ / cos β, and both have turned as often."""
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.5})
    rng = np.random.default_rng(0)
    phi = rng.uniform(0.0, 2000.0 * np.pi, 5000)
    beta = rng.uniform(0.0, np.deg2rad(85.0), 5000)
    turn = scene.sweep(phi, held={"joint_angle": beta})
    out = turn.motion.position("bearing_out")
    expected = np.arctan2(np.sin(phi), np.cos(beta) * np.cos(phi))
    expected += 2.0 * np.pi * np.rint((phi - expected) / (2.0 * np.pi))
    np.testing.assert_allclose(out, expected, atol=1e-9)
