"""Corners of the stress maps: errors are stated, residuals are honest, the rest is refused."""

from __future__ import annotations

import pytest

pytest.importorskip("mpmath")

import cardan_dyn as cd
from benchmarks import (
    stress_angle,
    stress_dead_point,
    stress_length,
    stress_mass,
    stress_misalignment,
    stress_speed,
    stress_turns,
)
from benchmarks.stress import BOUND, OPTIMISM, Point

pytestmark = pytest.mark.slow

REFUSALS = {
    name for name in cd.__all__
    if isinstance(error := getattr(cd, name), type) and issubclass(error, cd.CardanError)
}  # fmt: skip
CORNERS = {
    stress_angle: {"grid": (60.0, 1.0, 0.01)},
    stress_mass: {"grid": (1e-9, 1e9), "links": ("tube",)},
    stress_length: {"grid": (1e-6, 1e6)},
    stress_speed: {"grid": (30.0, 1e3, 1e5)},
    stress_turns: {"grid": (1e6,)},
    stress_dead_point: {"grid": (1e-1, 1e-6, 1e-8, 1e-9, 1e-12)},
    stress_misalignment: {"grid": (1e-12, 1e-3)},
}
MUST_BE_SOLVED = {
    "universal joint, quasi-static",
    "tube, gravity",
    "quasi-static",
    "this far from the origin",
    "four bar",
    "double shaft, quasi-static",
}


@pytest.fixture(scope="module", params=list(CORNERS), ids=lambda module: module.NAME)
def found(request: pytest.FixtureRequest) -> list[Point]:
    return request.param.points(**CORNERS[request.param])


@pytest.mark.campaign
def test_every_error_is_stated_or_refused(found: list[Point]) -> None:
    for point in found:
        if point.refused:
            assert point.refused in REFUSALS, point
        else:
            assert point.over_stated <= BOUND, point


def test_what_must_be_solved_is_solved(found: list[Point]) -> None:
    for point in found:
        if point.method == "sweep" and point.case in MUST_BE_SOLVED:
            assert not point.refused, point


def test_reported_closure_errors_are_honest(found: list[Point]) -> None:
    for point in found:
        if not point.refused:
            assert (point.loop_true or 0.0) <= OPTIMISM * max(point.loop or 0.0, 2.3e-16), point


def test_reported_balance_is_honest(found: list[Point]) -> None:
    for point in found:
        assert point.refused or point.optimism <= OPTIMISM, point


@pytest.mark.campaign
@pytest.mark.parametrize("distance", [4e-9, 1e-8, 2e-8])
def test_near_a_dead_point_nothing_is_refused_that_nearer_by_is_solved(distance: float) -> None:
    points = stress_dead_point.points((distance, 1e-9))
    assert not [point for point in points if point.method == "sweep" and point.refused]


def test_a_dead_point_is_refused_by_name() -> None:
    nearest = [p for p in stress_dead_point.points((1e-12,)) if p.method == "sweep"]
    assert {point.refused for point in nearest} <= {"", "SingularConfigurationError"}
