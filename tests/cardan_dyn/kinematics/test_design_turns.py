"""Turns of designs: crank-rockers, drag links and rockers in one sweep, each as it turns itself."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.bars_of_lengths import four_bar_of_lengths

import cardan_dyn as cd
from cardan_dyn.kinematics.following.joint_motion import DesignTurns, TurnSearch

TURN = 2.0 * np.pi
CRANK_ROCKER, DRAG_LINK, ROCKER = 0.0, -0.37, 0.2
"""Changes of the frame of 0.4 m, between bars of 0.1, 0.35 and 0.3 m."""


@pytest.fixture(scope="module", params=[CRANK_ROCKER, DRAG_LINK])
def scene(request: pytest.FixtureRequest) -> cd.Scene:
    return scene_at(request.param)


def scene_at(frame: float) -> cd.Scene:
    start = {"drive": 0.5 * np.pi}
    return cd.Scene(four_bar_of_lengths(), drive="drive", held={"frame": frame}, near=start)


def search(scene: cd.Scene) -> TurnSearch:
    return search_of(scene, "frame")


def search_of(scene: cd.Scene, varied: str) -> TurnSearch:
    part = scene.solver.of_varied((varied,)).assembly._cache._parts[0]
    kinematics, columns = part._kinematics, part._drive_columns
    return TurnSearch(kinematics, part._start, columns, part._held, part._driven[0], TURN, [])


def turns_of(finder: TurnSearch, rows: np.ndarray) -> DesignTurns:
    """Return how designs come back, each of a sample at the start of the drive."""
    positions = np.repeat(finder.start[None, finder.columns], len(rows), axis=0)
    positions[:, finder.held] = rows
    found, of, _ = finder.of_samples(positions, np.arange(len(rows)), closes=False)
    np.testing.assert_array_equal(of, np.arange(len(rows)))
    return found


def test_each_design_comes_back_as_grashof_says(scene: cd.Scene) -> None:
    rows = np.array([[CRANK_ROCKER], [DRAG_LINK], [ROCKER]])
    found = turns_of(search(scene), rows)
    np.testing.assert_array_equal(found.period, [TURN, TURN, 0.0])
    column = scene.mechanism.coordinates.named["bearing"].column
    # The rocker swings, the drag link turns with the crank.
    np.testing.assert_array_equal(np.abs(found.windings[:, column]), [0.0, 1.0, 0.0])


@pytest.mark.slow
def test_many_designs_come_back_as_each_alone(scene: cd.Scene) -> None:
    """Near the borders of the kinds, at frames of 0.05 m and 0.55 m, none stands for others."""
    rows = np.linspace(-0.375, 0.19, 2400)[:, None]
    finder = search(scene)
    together, alone = turns_of(finder, rows), finder._each(rows)[0]
    np.testing.assert_array_equal(together.period, alone.period)
    np.testing.assert_array_equal(together.windings, alone.windings)
    assert 0 < np.sum(together.period == 0.0) < 1200


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


def test_designs_that_do_not_turn_are_not_reached_a_turn_later(scene: cd.Scene) -> None:
    position = np.array([1.5, TURN + 1.5, 2.0 * TURN])
    mask = scene.reachable(position[:, None], held={"frame": [CRANK_ROCKER, ROCKER]})
    np.testing.assert_array_equal(mask, [[True, True], [True, False], [True, False]])


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


def test_designs_that_represent_others_are_kept(
    joint: cd.Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    followed = []
    each = TurnSearch._each

    def counted(finder: TurnSearch, rows: np.ndarray) -> object:
        followed.append(len(rows))
        return each(finder, rows)

    monkeypatch.setattr(TurnSearch, "_each", counted)
    options = {"drive": "bearing_in", "held": {"joint_angle": 0.5}}
    scene = cd.Scene(joint, **options)
    finder = search_of(scene, "joint_angle")
    rng, whole = np.random.default_rng(1), 0
    for seed in range(3):
        beta = rng.uniform(0.0, 1.4, 1000 if seed else 2000)
        phi = rng.uniform(-np.pi, np.pi, len(beta))
        positions = np.stack([phi, beta], axis=1)
        followed.clear()
        found, of, x = finder.of_samples(positions, np.arange(len(beta)), closes=True)
        whole = whole or sum(followed)
        assert seed == 0 or sum(followed) < 0.2 * whole
        new = finder._replace(kept=[])
        turns, others, expected = new.of_samples(positions, np.arange(len(beta)), closes=True)
        np.testing.assert_array_equal(of, others)
        np.testing.assert_array_equal(found.period, turns.period)
        np.testing.assert_array_equal(found.windings, turns.windings)
        np.testing.assert_allclose(x, expected, atol=1e-12)
        assert np.mean(np.isnan(x[:, 0])) < 0.1
    followed.clear()
    finder.of_samples(positions, np.arange(len(beta)), closes=True)
    assert sum(followed) <= 12  # Those that nothing else represents.
    monkeypatch.setattr("cardan_dyn.kinematics.following.joint_motion._MOST_KEPT", 3000)
    finder.of_samples(positions, np.arange(len(beta)), closes=True)
    assert not finder.kept


@pytest.mark.slow
def test_designs_near_a_singular_one_share_ways_as_others_do(
    joint: cd.Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At 90° the joint locks: towards it representatives stand closer, and not each for itself."""
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.5})
    followed = []
    each = TurnSearch._each

    def counted(finder: TurnSearch, rows: np.ndarray, *samples: np.ndarray) -> object:
        followed.append(len(rows))
        return each(finder, rows, *samples)

    monkeypatch.setattr(TurnSearch, "_each", counted)
    rng = np.random.default_rng(0)
    phi = rng.uniform(0.0, 2000.0 * np.pi, 10_000)
    beta = rng.uniform(0.0, np.deg2rad(85.0), 10_000)
    turn = scene.sweep(phi, held={"joint_angle": beta})
    assert sum(followed) < 180
    # tan φ₂ = tan φ₁ / cos β, and both have turned as often.
    out = turn.motion.position("bearing_out")
    expected = np.arctan2(np.sin(phi), np.cos(beta) * np.cos(phi))
    expected += 2.0 * np.pi * np.rint((phi - expected) / (2.0 * np.pi))
    np.testing.assert_allclose(out, expected, atol=1e-9)
