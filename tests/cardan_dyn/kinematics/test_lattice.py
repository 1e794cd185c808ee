"""Lattices lead to what straight lines lead to, or leave a sample to its line."""

from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.kinematics.assembly import Assembly
from cardan_dyn.kinematics.following.joint_motion import JointMotion
from cardan_dyn.kinematics.following.lattice import (
    KeptLattices,
    _Points,
    different,
    near_lattice,
    spacing_for,
)
from cardan_dyn.kinematics.following.lines import along_lines
from cardan_dyn.problem.arguments import checked


def universal_joint() -> JointMotion:
    mechanism = cd.load("universal_joint")
    problem = checked(mechanism, drive=["bearing_in", "joint_angle"])
    (part,) = Assembly(problem)._cache._parts
    assert isinstance(part, JointMotion)
    return part


def near_lattice_of(
    part: JointMotion, positions: np.ndarray, spacing: float
) -> tuple[np.ndarray, np.ndarray]:
    x, every = np.full((len(positions), part._start.size), np.nan), np.arange(len(positions))
    common = part._kinematics, part._start, part._drive_columns, positions
    there = near_lattice(x, np.empty(len(x)), every, *common, np.full(2, spacing), [[0, 1]])
    assert np.array_equal(there, ~np.isnan(x[:, 0]))
    return x, there


@pytest.mark.parametrize("spacing", [0.05, 0.2, 0.4])
def test_they_lead_where_straight_lines_lead(spacing: float) -> None:
    part = universal_joint()
    kinematics, start, columns = part._kinematics, part._start, part._drive_columns
    rng = np.random.default_rng(1)
    positions = np.stack([rng.uniform(-6.3, 6.3, 400), rng.uniform(-1.5, 1.5, 400)], axis=1)
    near, there = near_lattice_of(part, positions, spacing)
    assert np.sum(there) > 250
    x = kinematics.close(near[there]).x
    lines = along_lines(kinematics, start[None], columns, positions[there])
    assert np.all(lines.is_there)
    np.testing.assert_allclose(x, lines.x, atol=1e-12)


def test_ways_round_singular_positions_are_those_of_the_lines() -> None:
    """At a joint angle of 90° and input angles of 0 and 180° the way on is not unique.

    Lines pass these points on either side and end with joints turned differently.
    """
    part = universal_joint()
    kinematics, start, columns = part._kinematics, part._start, part._drive_columns
    rng = np.random.default_rng(0)
    positions = np.stack([rng.uniform(-6.0, 6.0, 1000), rng.uniform(-2.9, 2.9, 1000)], axis=1)
    lines = along_lines(kinematics, start[None], columns, positions)
    assert np.all(lines.is_there)
    turned = lines.x[:, part._columns]
    assert np.ptp(turned - turned.mean(axis=0), axis=0).max() > np.pi
    for spacing in (0.1, 0.4):
        near, there = near_lattice_of(part, positions, spacing)
        assert 300 < np.sum(there) < 1000
        x = kinematics.close(near[there]).x
        np.testing.assert_allclose(x, lines.x[there], atol=1e-9)


def test_points_in_a_row_are_few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of one turn while the other drive hardly moves, a point takes the calls of many samples."""
    steps: list[int] = []
    close = _Points._close

    def counted(self: _Points, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        steps.append(len(second))
        return close(self, first, second)

    monkeypatch.setattr(_Points, "_close", counted)
    scene = cd.Scene(cd.load("universal_joint"), drive=["bearing_in", "joint_angle"])
    rng = np.random.default_rng(5)
    positions = np.stack([rng.uniform(0.0, 6.28, 1100), rng.uniform(-0.01, 0.01, 1100)], axis=1)
    scene.sweep(positions)
    assert 0 < len(steps) < 30


def scattered(seed: int, count: int = 2000) -> np.ndarray:
    """Positions of both drives of the joint."""
    rng = np.random.default_rng(seed)
    return np.stack([rng.uniform(-6.0, 6.0, count), rng.uniform(-0.8, 0.8, count)], axis=1)


def test_lattices_are_kept_for_later_calls(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of what is known no step is taken again, and others find what they would have found."""
    steps: list[int] = []
    close, agree = _Points._close, _Points._agree

    def counted(self: _Points, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        steps.append(len(second))
        return close(self, first, second)

    def agreed(self: _Points, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        steps.append(len(second))
        return agree(self, first, second)

    monkeypatch.setattr(_Points, "_close", counted)
    monkeypatch.setattr(_Points, "_agree", agreed)
    mechanism = cd.load("universal_joint")
    scene = cd.Scene(mechanism, drive=["bearing_in", "joint_angle"])
    first = scene.sweep(scattered(0)).motion.x
    assert sum(steps) > 100
    while steps:  # Until the lattice is as fine as pays.
        steps.clear()
        np.testing.assert_allclose(scene.sweep(scattered(0)).motion.x, first, atol=1e-14)
    for seed in (1, 2, 3):
        steps.clear()
        other = cd.Scene(mechanism, drive=["bearing_in", "joint_angle"]).sweep(scattered(seed))
        whole = sum(steps)
        steps.clear()
        found = scene.sweep(scattered(seed))
        assert sum(steps) < 0.5 * whole
        np.testing.assert_allclose(found.motion.x, other.motion.x, atol=1e-13)


def test_kept_lattices_lead_where_new_ones_do() -> None:
    """Towards the locked joint, where some steps are not safe and some points not known."""
    part, kept = universal_joint(), KeptLattices()
    common = part._kinematics, part._start, part._drive_columns
    rng, units = np.random.default_rng(2), np.full(2, 0.2)
    for _ in range(5):
        low, high = np.sort(rng.uniform(-1.5, 1.5, 2))
        phi, beta = rng.uniform(-6.3, 6.3, 300), rng.uniform(low, high, 300)
        positions = np.stack([phi, beta], axis=1)
        near, alone = np.full((2, 300, part._start.size), np.nan)
        given = np.empty(300), np.arange(300), *common, positions, units, [[0, 1]], None
        there, expected = near_lattice(near, *given, kept), near_lattice(alone, *given)
        # A point may be left out of either if it is closed from another one first.
        assert np.mean(there != expected) < 0.02
        both = there & expected
        np.testing.assert_allclose(near[both], alone[both], atol=1e-9)


def test_few_lattices_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    part, kept = universal_joint(), KeptLattices()
    common = part._kinematics, part._start, part._drive_columns
    for spacing in (0.1, 0.15, 0.2, 0.3, 0.1, 0.4, 0.1):
        x = np.full((300, part._start.size), np.nan)
        given = np.empty(300), np.arange(300), *common, 0.3 * scattered(4, 300)
        near_lattice(x, *given, np.full(2, spacing), [[0, 1]], None, kept)
    assert len(kept._lattices) == 4
    assert kept.of(np.full(2, 0.1)) is not None and kept.of(np.full(2, 0.15)) is None
    monkeypatch.setattr("cardan_dyn.kinematics.following.lattice._MOST_KEPT", 100)
    near_lattice(x, *given, np.full(2, spacing), [[0, 1]], None, KeptLattices())
    points = kept.of(np.full(2, 0.1))
    assert points is not None
    kept.keep(points, np.full(2, 0.1))
    assert kept.of(np.full(2, 0.1)) is None


@pytest.mark.parametrize("most", [0, 30, 10**15])
def test_different_numbers_are_found_as_numpy_does(most: int) -> None:
    keys = np.random.default_rng(0).integers(0, most + 1, 500)
    for some in (keys, keys[:1], keys[:0]):
        expected = np.unique(some, return_index=True, return_inverse=True)
        for values, other in zip(different(some), expected, strict=True):
            np.testing.assert_array_equal(values, other)


def test_samples_of_earlier_calls_pay_for_finer_lattices() -> None:
    some = scattered(0, 4000)
    first = spacing_for(some)
    assert first is not None
    assert spacing_for(some, before=10 * len(some)) == 0.5 * first
    # No finer than serves several samples of this call.
    assert spacing_for(some, before=10**9) == 0.5 * first


def test_spacing_suits_the_number_of_samples() -> None:
    grid = np.stack(np.meshgrid(*[np.linspace(0.0, 3.0, 100)] * 2), axis=-1).reshape(-1, 2)
    found = spacing_for(grid)
    assert found is not None
    assert 0.1 <= found <= 0.2
    assert spacing_for(grid, found) == 0.5 * found
    assert spacing_for(grid[::500]) is None
    # Where all samples are the same there are never too few, and there is an end all the same.
    assert 0.02 <= (spacing_for(np.zeros((30, 2))) or 0.0) < 0.05
    assert spacing_for(np.full((5000, 6), 1e9) * np.arange(5000)[:, None]) is None
