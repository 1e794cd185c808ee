"""Positions of several drives mean one configuration each."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.planar_linkages import five_bar

import cardan_dyn as cd
from cardan_dyn.core.kinematics.closing.group_solver import GroupSolver


@pytest.fixture(scope="module")
def scene() -> cd.Scene:
    return cd.Scene(
        cd.load("universal_joint"),
        drive=["bearing_in", "joint_angle"],
        loads={"bearing_out": -100.0},
    )


def positions(count: int, turns: float = 1000.0) -> np.ndarray:
    rng = np.random.default_rng(0)
    angle = rng.uniform(-turns * np.pi, turns * np.pi, count)
    return np.stack([angle, rng.uniform(0.0, np.deg2rad(85.0), count)], axis=1)


def test_any_number_of_turns_at_any_joint_angle(scene: cd.Scene) -> None:
    """The ratio of Cardan's joint at every sample, to the rounding of the angles given."""
    at = positions(3000)
    sweep = scene.sweep(at)
    phi, beta = at.T
    ratio = np.cos(beta) / (1.0 - np.sin(beta) ** 2 * np.cos(phi) ** 2)
    np.testing.assert_allclose(np.abs(sweep.drive_effort[:, 0]), 100.0 * ratio, rtol=1e-11)
    output = sweep.motion.position("bearing_out")
    # The output is never a quarter of a turn away from the input.
    assert np.max(np.abs(np.abs(output) - np.abs(phi))) < 0.5 * np.pi


def test_order_and_number_make_no_difference(scene: cd.Scene) -> None:
    at = positions(500, 2.0)
    q = scene.sweep(at).motion.q
    order = np.random.default_rng(1).permutation(len(at))
    np.testing.assert_allclose(scene.sweep(at[order]).motion.q, q[order], atol=1e-12)
    parts = [scene.sweep(part).motion.q for part in np.array_split(at, 7)]
    np.testing.assert_allclose(np.concatenate(parts), q, atol=1e-12)
    for index in (0, 77, 499):
        np.testing.assert_allclose(scene.sweep(at[[index]]).motion.q[0], q[index], atol=1e-12)


def test_a_path_leads_to_the_same(scene: cd.Scene) -> None:
    turn = np.linspace(0.0, 4.0 * np.pi, 300)
    path = np.stack([turn, 0.5 * np.sin(turn)], axis=1)
    followed = scene.sweep(path, along_path=True)
    straight = scene.sweep(path)
    np.testing.assert_allclose(followed.motion.q, straight.motion.q, atol=1e-12)
    assembled = scene.assemble(path, along_path=True)
    np.testing.assert_allclose(
        scene.sweep(assembled, along_path=True).drive_effort, straight.drive_effort, atol=1e-9
    )
    with pytest.raises(cd.ArgumentError, match="assembled along straight lines"):
        scene.sweep(scene.assemble(path), along_path=True)


@pytest.mark.slow
def test_one_sample_beyond_reach_is_named() -> None:
    """The pins of a five-bar move apart until its arms are in line."""
    at = np.random.default_rng(2).uniform(-0.3, 0.3, (200, 2))
    at[123] = 1.5, -1.5
    with pytest.raises(cd.AssemblyError, match=r"1\.5, -1\.5 \(sample 123 of 200\)") as caught:
        cd.Scene(five_bar(), drive=["A", "D"]).sweep(at)
    assert caught.value.sample == 123
    assert "other" not in str(caught.value)
    at[150:152] = 1.5, -1.5
    with pytest.raises(cd.AssemblyError, match="2 other samples are out of reach too"):
        cd.Scene(five_bar(), drive=["A", "D"]).sweep(at)


@pytest.mark.parametrize("is_held", [True, False])
def test_many_samples_take_hardly_an_evaluation(
    is_held: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All but the scouts are followed and solved on tapes, and right a thousand turns away."""
    at = positions(10_000)
    joint = cd.load("universal_joint")
    if is_held:
        scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.8})
        run = lambda: scene.sweep(at[:, 0], held={"joint_angle": at[:, 1]})  # noqa: E731
    else:
        scene = cd.Scene(joint, drive=["bearing_in", "joint_angle"])
        run = lambda: scene.sweep(at)  # noqa: E731
    run()
    counted, evaluate = [], GroupSolver.evaluate

    def counting(self: GroupSolver, x: np.ndarray, *rest: object) -> object:
        counted.append(len(x))
        return evaluate(self, x, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(GroupSolver, "evaluate", counting)
    found = run()
    assert sum(counted) < 0.05 * len(at)
    phi, beta = at.T
    expected = np.arctan2(np.sin(phi), np.cos(beta) * np.cos(phi))
    expected += 2.0 * np.pi * np.rint((phi - expected) / (2.0 * np.pi))
    np.testing.assert_allclose(found.motion.position("bearing_out"), expected, atol=1e-11)


@pytest.mark.slow
def test_positions_one_by_one_are_those_of_straight_lines() -> None:
    """Round where the arms of a five-bar do not meet: lines pass it on either side, or end there.

    Positions one by one are what all of them at once are: every other one on the way round, the
    others on the way back.
    """
    mechanism = five_bar()
    angle = np.arange(0.0, 2.0 * np.pi, 0.045 / 1.6)
    circle = 1.6 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    scene = cd.Scene(mechanism, drive=["A", "D"])
    is_there = scene.reachable(circle)
    assert 20 < np.sum(~is_there) < 60
    expected = np.full((len(circle), mechanism.model.nq), np.nan)
    expected[is_there] = scene.sweep(circle[is_there]).motion.q
    for order in (np.arange(0, len(circle), 2), np.arange(1, len(circle), 2)[::-1]):
        alone = cd.Scene(mechanism, drive=["A", "D"])
        for index in order:
            if is_there[index]:
                q = alone.sweep(circle[index]).motion.q
                np.testing.assert_allclose(q, expected[[index]], atol=1e-11)
            else:
                with pytest.raises(cd.AssemblyError):
                    alone.sweep(circle[index])
