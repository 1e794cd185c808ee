"""Forces from sweeps and from responses, and where known ones swing round."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import cardan_dyn as cd
from cardan_dyn import ArgumentError
from cardan_dyn.clearance import scan
from cardan_dyn.core.dynamics.problem_solver import ProblemSolver
from cardan_dyn.motion.clearance.forces import ForceCourse, ForceSource

CONTACT: dict[str, Any] = {"clearance": 1e-4, "stiffness": 1e8, "damping_ratio": 0.25}
LOADED: dict[str, Any] = {"loads": {"piston_guide": -40.0}, "gravity": (0.0, -9.81, 0.0)}


@pytest.fixture(scope="module")
def drive() -> cd.Scene:
    return cd.Scene(cd.load("needle_drive"), drive="main_shaft")


@pytest.mark.slow
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
            for key in (
                "position",
                "force_slope",
                "reduced_mass",
                "tau",
                "two_mass_peak",
                "slope_growth",
            ):
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


PHI = 2.0 * np.pi / 720 * np.arange(720)


def course(x: np.ndarray, y: np.ndarray) -> ForceCourse:
    return ForceCourse(np.stack([x, y, 0.0 * x], axis=1)[:, None], 2.0 * np.pi)


def test_a_force_along_a_line_vanishes_twice() -> None:
    shift = 0.1234
    swings = course(3.0 * np.sin(PHI - shift), 4.0 * np.sin(PHI - shift)).swings(1.0)
    assert [item.position for item in swings] == pytest.approx([shift, np.pi + shift], abs=1e-12)
    assert [item.least for item in swings] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert [item.slope for item in swings] == pytest.approx([5.0, 5.0], rel=1e-12)
    np.testing.assert_allclose(swings[0].direction, [0.6, 0.8, 0.0], atol=1e-12)
    np.testing.assert_allclose(swings[1].direction, [-0.6, -0.8, 0.0], atol=1e-12)
    assert swings[0].way == pytest.approx(np.pi / 2, abs=0.01)


def test_the_sense_turns_directions_and_ways() -> None:
    x = np.sin(PHI) + 0.3 * np.sin(2.0 * PHI)
    forward, backward = (course(x, 0.0 * x).swings(sense)[0] for sense in (1.0, -1.0))
    np.testing.assert_allclose(forward.direction, -backward.direction, atol=1e-12)
    assert forward.position == pytest.approx(backward.position, abs=1e-12)
    # sin φ + 0.3 sin 2φ is greatest at 0.3333 π to either side of its zero at 0, least there at π.
    greatest = np.arccos((np.sqrt(1.0 + 8.0 * 0.36) - 1.0) / (4.0 * 0.6))
    assert (forward.way, backward.way) == pytest.approx((greatest, greatest), abs=0.01)
    shifted = course(np.sin(PHI) + 0.3 * np.sin(2.0 * PHI + 1.0), 0.0 * PHI)
    for sense in (1.0, -1.0):
        item = shifted.swings(sense)[0]
        sizes = np.abs(np.sin(turned := item.position + sense * PHI) + 0.3 * np.sin(2 * turned + 1))
        peak = PHI[1:-1][(sizes[1:-1] > sizes[:-2]) & (sizes[1:-1] > sizes[2:])][0]
        assert item.way == pytest.approx(peak, abs=0.02)


def test_an_ellipse_has_its_least_force_on_the_short_axis() -> None:
    swings = course(5.0 * np.cos(PHI), 0.2 * np.sin(PHI)).swings(1.0)
    assert [item.position for item in swings] == pytest.approx([np.pi / 2, 1.5 * np.pi], abs=1e-9)
    assert [item.least for item in swings] == pytest.approx([0.2, 0.2], rel=1e-12)
    assert swings[0].slope == pytest.approx(5.0, rel=1e-12)


def test_a_force_that_stays_has_none() -> None:
    assert course(2.0 + np.cos(PHI), 0.0 * PHI + 5.0).swings(1.0)[0].least > 5.0
    assert course(0.0 * PHI + 2.0, 0.0 * PHI).swings(1.0) == []


def test_the_tail_tells_of_corners() -> None:
    assert course(np.sin(PHI), np.cos(PHI)).tail < 1e-14
    assert course(np.abs(np.sin(PHI)), 0.0 * PHI).tail > 1e-6
    # A component that is mere rounding beside the others is no corner.
    noise = 1e-13 * np.random.default_rng(1).standard_normal(len(PHI))
    assert course(np.sin(PHI), noise).tail < 1e-12


def test_the_slope_grows_with_the_cube_of_the_speed_where_inertia_acts() -> None:
    assert course(np.sin(PHI), 0.1 * np.cos(PHI)).swings(1.0)[0].growth == 3.0


def test_the_growth_of_a_slope_beside_a_constant_force() -> None:
    """F = Ω² sin φ - C: zero at sin φ = C / Ω², of slope Ω³ cos φ."""
    still, zero = 0.4, 0.0 * PHI
    forces, inertial = (
        np.stack([x, zero, zero], axis=1)[:, None] for x in (np.sin(PHI) - still, np.sin(PHI))
    )
    found = ForceCourse(forces, 2.0 * np.pi, inertial).swings(1.0)
    # d ln(Ω √(Ω⁴ - C²)) / d ln Ω at Ω = 1.
    expected = 1.0 + 2.0 / (1.0 - still**2)
    assert [item.growth for item in found] == pytest.approx([expected, expected], rel=1e-10)
    assert found[0].position == pytest.approx(np.arcsin(still), abs=1e-10)


def test_the_growth_of_an_ellipse_beside_a_constant_force() -> None:
    """Against differences of the least of |Ω² (cos φ, b sin φ) + C| found on a fine grid."""
    constant = np.array([0.05, 0.02])

    def slope(speed: float) -> float:
        def force(phi: float) -> np.ndarray:
            return speed**2 * np.array([np.cos(phi), 0.2 * np.sin(phi)]) + constant

        best = minimize_scalar(
            lambda phi: float(force(phi) @ force(phi)), bounds=(1.0, 2.2), options={"xatol": 1e-12}
        ).x
        return float(speed**3 * np.hypot(np.sin(best), 0.2 * np.cos(best)))

    inertial = np.stack([np.cos(PHI), 0.2 * np.sin(PHI), 0.0 * PHI], axis=1)[:, None]
    whole = inertial + np.append(constant, 0.0)
    item = ForceCourse(whole, 2.0 * np.pi, inertial).swings(1.0)[0]
    step = 1e-3
    expected = np.log(slope(np.exp(step)) / slope(np.exp(-step))) / (2.0 * step)
    assert item.growth == pytest.approx(expected, rel=1e-5)


def test_dips_of_rounding_in_a_force_of_constant_size_are_no_swings() -> None:
    noise = 1e-13 * np.random.default_rng(2).standard_normal((2, len(PHI)))
    assert course(np.cos(PHI) + noise[0], np.sin(PHI) + noise[1]).swings(1.0) == []
    # Beside dips that are none of it.
    found = course(np.cos(PHI) + noise[0], 0.5 * np.sin(PHI) + noise[1]).swings(1.0)
    assert [item.position for item in found] == pytest.approx([0.5 * np.pi, 1.5 * np.pi], abs=1e-6)


def test_a_force_that_touches_zero_and_comes_back_has_no_swing() -> None:
    assert course(1.0 - np.cos(PHI - 0.2), 0.0 * PHI).swings(1.0) == []
    assert len(course(0.999 - np.cos(PHI - 0.2), 0.0 * PHI).swings(1.0)) == 2
