"""What a sweep costs, as counts, which no busy machine can change."""

from __future__ import annotations

import sys
import tracemalloc
from collections.abc import Callable

import numpy as np
from testkit.scenes import double

import cardan_dyn as cd


def calls(run: Callable[[], object]) -> int:
    """Count calls of Python and C functions."""
    counted = 0

    def count(frame: object, event: str, argument: object) -> None:
        nonlocal counted
        counted += event in ("call", "c_call")

    sys.setprofile(count)
    try:
        run()
    finally:
        sys.setprofile(None)
    return counted


def known(shaft: cd.Mechanism) -> cd.Scene:
    """Return a scene whose motion is known to rounding."""
    scene = double(shaft, 0.5, 0.4)
    for _ in range(3):
        scene.sweep(np.linspace(0.0, 2.0 * np.pi, 20_000))
    return scene


def test_a_block_takes_as_many_calls_whatever_its_samples(shaft: cd.Mechanism) -> None:
    """Arrays are worked on as a whole: no Python per sample but the calls into Pinocchio."""
    scene = known(shaft)
    counts = []
    for samples in (64, 128, 512):
        positions = np.linspace(0.1, 6.0, samples)
        for rates in ({}, {"speed": 9.0}):
            scene.sweep(positions, **rates)
        counts.append(calls(lambda positions=positions: scene.sweep(positions, speed=9.0)))
    # Pinocchio's functions are no C functions of Python's, so they do not count. Some 700 of them
    # are the proof, which places joint after joint by itself.
    assert max(counts) == min(counts) < 2000


def test_memory_of_a_sweep(shaft: cd.Mechanism) -> None:
    """What is kept per sample is the result; what is needed in between is one block's."""
    scene = known(shaft)
    peaks = []
    for samples in (5_000, 20_000):
        positions = np.linspace(0.0, 2.0 * np.pi, samples)
        tracemalloc.start()
        turn = scene.sweep(positions, speed=9.0)
        kept, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert len(turn["slip"].moment) == samples
        assert kept < 1000 * samples
        peaks.append(peak)
    per_sample = (peaks[1] - peaks[0]) / 15_000
    # Not more than the result itself; beside it, the arrays of one block.
    assert per_sample < 1000
    assert peaks[0] - 5_000 * per_sample < 12e6
