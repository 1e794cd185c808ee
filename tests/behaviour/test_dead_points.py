"""Dead points: what is said of them is the same, whatever was asked before."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable

import numpy as np
import pytest

import cardan_dyn as cd

DRIVES = (
    ("four_bar", "rocker_bearing"),
    ("needle_drive", "rocker_bearing"),
    ("needle_drive", "needle_guide"),
)
BEFORE: dict[str, Callable[[cd.Scene, float], object]] = {
    "near": lambda scene, end: scene.sweep([0.9 * end]),
    "at": lambda scene, end: scene.sweep([end]),
    "beyond": lambda scene, end: scene.sweep([1.1 * end]),
    "elsewhere": lambda scene, end: scene.sweep([-3.0 * end]),
    "a turn": lambda scene, end: scene.sweep(np.linspace(0.0, 2.0 * np.pi, 73)),
    "range": lambda scene, end: scene.motion_range(),
}


def said(scene: cd.Scene, position: float) -> tuple[type, str] | None:
    try:
        scene.sweep([position])
    except cd.CardanError as error:
        return type(error), str(error)
    return None


def assert_told_alike(
    make: Callable[[], cd.Scene], end: float, shares: tuple[float, ...], before: Iterable[str]
) -> None:
    for share in shares:
        expected = said(make(), share * end)
        assert (expected is None) == (share < 1.0 - 1e-7)
        for name in before:
            used = make()
            with contextlib.suppress(cd.CardanError):
                BEFORE[name](used, end)
            assert said(used, share * end) == expected, (share, name)


@pytest.mark.slow
def test_a_dead_point_is_told_alike_after_what_lies_beyond_it() -> None:
    end = 0.5953805756157337
    shares = (1.0, 1.0 + 1e-9, 1.0 - 1e-6)
    assert_told_alike(
        lambda: cd.Scene(cd.load("four_bar"), drive="rocker_bearing"), end, shares, ("beyond",)
    )


@pytest.mark.slow
@pytest.mark.campaign
@pytest.mark.parametrize(("name", "drive"), DRIVES)
def test_a_dead_point_is_told_alike_whatever_was_asked_before(name: str, drive: str) -> None:
    def make() -> cd.Scene:
        return cd.Scene(cd.load(name), drive=drive)

    # Those 1e-9 before an end, the digits in which it is known, may be answered or not.
    shares = (1.0, 1.0 + 1e-9, 1.0 + 1e-6, 1.5, 1.0 - 1e-6)
    for end in make().motion_range():
        assert_told_alike(make, end, shares, BEFORE)
