"""Positions of more joints than decide where a mechanism is mean the assembly nearest to them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import cardan_dyn as cd

pytestmark = pytest.mark.usefixtures("loaded_once")

CRANK = "crank_bearing"
OTHERS = ("crank_pin", "rocker_bearing", "rocker_pin")


@pytest.fixture(scope="module")
def bar() -> cd.Mechanism:
    return cd.load("four_bar")


def least(scene: cd.Scene, near: dict[str, float], around: float) -> float:
    """Return the drive position at which a sweep is least off, by bracketing it."""

    def off(position: float) -> float:
        motion = scene.sweep([position]).motion
        # Whole turns aside.
        gaps = (2.0 * np.sin(0.5 * (motion.position(name)[0] - near[name])) for name in near)
        return float(sum(gap**2 for gap in gaps))

    bounds = around - 0.1, around + 0.1
    return float(minimize_scalar(off, bounds=bounds, method="bounded", options={"xatol": 1e-9}).x)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("branch", "names"),
    [("A", OTHERS[:2]), ("B", OTHERS[:2]), ("B", OTHERS), ("A", (CRANK, *OTHERS))],
)
def test_rounded_positions(bar: cd.Mechanism, branch: str, names: tuple[str, ...]) -> None:
    exact = cd.Scene(bar, drive=CRANK, near={CRANK: 0.8}, branch=branch)
    there = exact.configuration()
    near = {name: round(there[name], 2) for name in names}
    expected = least(exact, near, 0.8)
    for found in (
        cd.Scene(bar, drive=CRANK, near=near).configuration(),
        cd.Scene(bar, drive=OTHERS[0], near=near).configuration(),
        cd.assemble(bar, near=near),
    ):
        assert found.loop_residual < 1e-12
        assert found[CRANK] == pytest.approx(expected, abs=1e-6)
        assert found["rocker_bearing"] == pytest.approx(there["rocker_bearing"], abs=0.02)


def test_held_joints_stay(bar: cd.Mechanism) -> None:
    shaft = cd.load("universal_joint")
    exact = cd.Scene(shaft, drive="bearing_in", held={"joint_angle": 0.5}, near={"bearing_in": 0.7})
    there = exact.configuration()
    near = {name: round(there[name], 2) for name in ("bearing_in", "bearing_out", "pin_in")}
    found = cd.Scene(shaft, drive="bearing_in", held={"joint_angle": 0.5}, near=near)
    assert found.configuration()["joint_angle"] == 0.5
    assert found.configuration()["bearing_in"] == pytest.approx(least(exact, near, 0.7), abs=1e-6)


def test_what_nothing_is_near_to_is_refused_with_the_distance(bar: cd.Mechanism) -> None:
    there = cd.Scene(bar, drive=CRANK, near={CRANK: 0.8}).configuration()
    near = {CRANK: 0.8, "rocker_bearing": there["rocker_bearing"] + 0.2}
    for make in (lambda: cd.Scene(bar, drive=CRANK, near=near), lambda: cd.assemble(bar, near)):
        with pytest.raises(cd.AssemblyError, match=r"nearest closed .* crank_bearing: .* away"):
            make()


def test_one_position_that_cannot_be_reached_is_refused(bar: cd.Mechanism) -> None:
    """It is no matter of rounding: a position less would decide the motion no more."""
    low, _ = cd.Scene(bar, drive="rocker_bearing").motion_range()
    with pytest.raises(cd.AssemblyError, match="cannot be brought to"):
        cd.Scene(bar, drive=CRANK, near={"rocker_bearing": low - 0.01})
