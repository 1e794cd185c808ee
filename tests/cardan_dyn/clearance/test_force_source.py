"""Forces from sweeps and from responses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn import ArgumentError
from cardan_dyn.clearance import scan
from cardan_dyn.clearance.force_source import ForceSource
from cardan_dyn.dynamics.problem_solver import ProblemSolver

CONTACT: dict[str, Any] = {"clearance": 1e-4, "stiffness": 1e8, "damping_ratio": 0.25}
LOADED: dict[str, Any] = {"loads": {"piston_guide": -40.0}, "gravity": (0.0, -9.81, 0.0)}


@pytest.fixture(scope="module")
def drive() -> cd.Scene:
    return cd.Scene(cd.load("needle_drive"), drive="main_shaft")


@pytest.mark.parametrize("loaded", [False, True])
@pytest.mark.parametrize("speed", [300.0, -170.0])
def test_a_response_gives_the_numbers_of_a_sweep(
    drive: cd.Scene, speed: float, loaded: bool
) -> None:
    scene = drive
    if loaded:
        scene = cd.Scene(cd.load("slider_crank"), drive="crank_bearing", **LOADED)
    swept = scan(scene, speed, **CONTACT)
    found = scan(scene.response(), speed, **CONTACT)
    assert found.ranking == swept.ranking
    count = 0
    for name in swept:
        np.testing.assert_allclose(
            found[name].force, swept[name].force, rtol=0.0, atol=1e-10 * swept[name].rigid_peak
        )
        pairs = zip(found[name].reversals, swept[name].reversals, strict=True)
        for item, other in pairs:
            count += 1
            for key in ("position", "force_slope", "reduced_mass", "tau", "peak", "slope_growth"):
                expected = pytest.approx(getattr(other, key), rel=1e-10, nan_ok=True)
                assert getattr(item, key) == expected
            assert item.turn_through == pytest.approx(other.turn_through, abs=1e-10)
            np.testing.assert_allclose(item.exponents, other.exponents, rtol=1e-10)
    assert count >= 4


def test_scans_of_a_response_take_no_sweep(
    drive: cd.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    response, solved, closed = drive.response(), [], []
    solve, motion = ProblemSolver.solve, ProblemSolver.assembled_in_turn

    def counted(self: ProblemSolver, *arguments: Any, **options: Any) -> Any:
        solved.append(1)
        return solve(self, *arguments, **options)

    def placed(self: ProblemSolver, targets: Any, *arguments: Any) -> Any:
        closed.append(targets.size)
        return motion(self, targets, *arguments)

    monkeypatch.setattr(ProblemSolver, "solve", counted)
    monkeypatch.setattr(ProblemSolver, "assembled_in_turn", placed)
    scan(response, 300.0, **CONTACT)
    # Where joints are, once: no part of a response. After that only where forces swing round.
    assert not solved and max(closed) == 720
    closed.clear()
    scan(response, 150.0, **CONTACT)
    assert not solved and closed and max(closed) < 20
    scan(drive, 150.0, **CONTACT)
    assert len(solved) == 1


def test_what_acts_beside_inertia(drive: cd.Scene) -> None:
    assert ForceSource(drive).is_inertial
    crank = cd.load("slider_crank")
    for options in (
        {"loads": {"piston_guide": -40.0}},
        {"gravity": (0.0, -9.81, 0.0)},
        {"elements": [cd.JointSpring("piston_guide", 1e3)]},
    ):
        assert not ForceSource(cd.Scene(crank, drive="crank_bearing", **options)).is_inertial
    still = cd.Scene(crank, drive="crank_bearing", loads={"piston_guide": 0.0})
    assert ForceSource(still).is_inertial


def test_slopes_grow_with_the_speed_as_scans_at_other_speeds() -> None:
    scene = cd.Scene(cd.load("slider_crank"), drive="crank_bearing", **LOADED)
    response, step = scene.response(), 2e-4
    scans = [scan(response, 100.0 * np.exp(k * step), **CONTACT) for k in (-1, 0, 1)]
    seen = 0
    for name in scans[1]:
        for below, item, above in zip(*(found[name].reversals for found in scans), strict=True):
            expected = np.log(above.force_slope / below.force_slope) / (2.0 * step)
            assert item.slope_growth == pytest.approx(expected, rel=1e-5)
            seen += abs(expected - 3.0) > 0.01
    assert seen >= 2


def test_of_elements_no_power_of_the_speed_is_told() -> None:
    spring = cd.JointSpring("piston_guide", 100.0)
    scene = cd.Scene(cd.load("slider_crank"), drive="crank_bearing", elements=[spring])
    items = [item for pin in scan(scene, 300.0, **CONTACT).values() for item in pin.reversals]
    assert items and all(np.isnan(item.slope_growth) for item in items)
    assert all(np.isnan(item.exponents.speed) for item in items)


def test_a_response_that_ends_is_refused(drive: cd.Scene) -> None:
    with pytest.raises(ArgumentError, match="holds from 0 to 1 alone"):
        scan(drive.response(interval=(0.0, 1.0)), 300.0, **CONTACT)
    with pytest.raises(ArgumentError, match="scene is of type Sweep; expected a scene"):
        scan(drive.sweep([0.0]), 300.0, **CONTACT)


def test_rounding_is_no_force() -> None:
    """A double shaft with equal angles: its inner pins are loaded along their axes alone."""
    held = {"joint_angle_1": np.deg2rad(30.0), "joint_angle_2": np.deg2rad(30.0)}
    shaft = cd.Scene(
        cd.load("double_shaft_z"), drive="bearing_in", held=held, loads={"bearing_out": -100.0}
    )
    found = scan(shaft, 150.0, **CONTACT)
    axis = shaft.mechanism.joint("pin_2_in").parts[0].axis
    across = np.cross(shaft.sweep(np.linspace(0.0, 6.0, 50), 150.0)["pin_2_in"].force, axis)
    assert 0.0 < np.max(np.abs(across)) < 1e-8
    pin = found["pin_2_in"]
    assert pin.verdict == "no force, and so no impact"
    assert not pin.force.any() and pin.reversals == ()
    assert all(len(item.reversals) <= 8 for item in found.values())
    again = scan(shaft.response(), 150.0, **CONTACT)
    # Impacts without damping are chaotic: rounding decides how many there are.
    counts = [len(item.reversals) for item in found.values()]
    assert [len(again[name].reversals) for name in found] == counts
