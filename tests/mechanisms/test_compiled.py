"""Compiled functions: the same results as by NumPy alone, of every mechanism, but for rounding."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from compare import sweep_of
from scenes import draw
from testkit.compiled_functions import needs_kernel, without_kernel

import cardan_dyn as cd
from cardan_dyn.scene.usual_motion import usual_motion

pytestmark = needs_kernel
ROUNDING = 2e-14
"""Relative errors stay below this times the condition, as the guide says of any result."""


def both_ways(swept: Callable[[], cd.Sweep]) -> list[cd.Sweep]:
    """Return a sweep of a mechanism that is made anew, by compiled functions and by NumPy."""
    with_kernel = swept()
    with without_kernel():
        return [with_kernel, swept()]


def assert_same(first: cd.Sweep, second: cd.Sweep) -> None:
    allowed = ROUNDING * np.maximum(first.condition, second.condition)
    names = list(first.outputs)
    assert names == list(second.outputs)
    for rate in ("q", "v", "a"):
        one, other = (getattr(sweep.motion, rate) for sweep in (first, second))
        size = np.max(np.abs(one), axis=-1) + 1.0
        assert np.all(np.max(np.abs(one - other), axis=-1) <= allowed * size), rate
    wrenches = [
        np.concatenate([[sweep[name].force, sweep[name].moment] for name in names])
        for sweep in (first, second)
    ]
    size = np.max(np.abs(wrenches[0]), axis=(0, -1))
    apart = np.max(np.abs(wrenches[0] - wrenches[1]), axis=(0, -1))
    assert np.all(apart <= allowed * size + 1e-300)
    for name in names:
        assert np.array_equal(first[name].unique, second[name].unique), name
    for residual in ("loop_residual", "balance_residual", "power_residual", "rate_residual"):
        one, other = getattr(first, residual), getattr(second, residual)
        assert np.isnan(one) == np.isnan(other), residual
        assert np.isnan(one) or abs(one - other) <= np.max(allowed), residual


@pytest.mark.slow
@pytest.mark.parametrize("name", cd.bundled_names())
def test_bundled_mechanisms(name: str) -> None:
    at_rest, at_speed = (
        both_ways(lambda speed=speed: usual_motion(cd.load(name)).sweep(speed))
        for speed in (0.0, None)
    )
    assert_same(*at_rest)
    assert_same(*at_speed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(30))
def test_random_chains(seed: int) -> None:
    assert_same(*both_ways(lambda: sweep_of(draw(seed))))


@pytest.mark.parametrize("name", sorted({*cd.bundled_names()} - {"stewart_platform"}))
def test_a_position_comes_out_alike_whatever_is_asked_beside_it(name: str) -> None:
    """To the last bit: of several drives, guesses come from the positions around."""
    usual = usual_motion(cd.load(name), samples=301)
    positions = usual.positions
    usual.scene.sweep(positions)  # A branch is made finer by what is asked of it.
    known = usual.scene.sweep(positions)
    chosen = np.random.default_rng(0).permutation(len(positions))[:200]
    mixed = usual.scene.sweep(positions[chosen])
    assert np.array_equal(mixed.motion.q, known.motion.q[chosen])
    for joint in known.outputs:
        assert np.array_equal(mixed[joint].force, known[joint].force[chosen]), joint
        assert np.array_equal(mixed[joint].moment, known[joint].moment[chosen]), joint
