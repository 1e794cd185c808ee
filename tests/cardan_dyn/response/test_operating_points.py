"""Operating points of a response whose functions are known waves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from testkit.linkages import coupling, gears
from testkit.scenes import universal

import cardan_dyn as cd
from cardan_dyn.core.dynamics.problem_solver import ProblemSolver
from cardan_dyn.core.problem.samples import acting_on
from cardan_dyn.core.proof.residuals import Proven
from cardan_dyn.core.response.columns import ACCELERATION, SPEED_SQUARED, Acts, Column, Layout
from cardan_dyn.core.response.data import Proof, ResponseData
from cardan_dyn.core.response.domain import Domain
from cardan_dyn.core.response.operating_points import (
    CouplingMoments,
    OfDesign,
    OperatingPoints,
    solved_motion,
)
from cardan_dyn.core.response.series import Series
from cardan_dyn.kit.frozen import frozen

LOAD = Column(Acts.JOINT_LOAD, "bearing_out")
COLUMNS = (SPEED_SQUARED, ACCELERATION, LOAD)
LAYOUT = Layout(COLUMNS, ("pin_in",), ("bearing_in", "joint_angle"), ("mesh", "train"))
ORIGIN = 0.3
PROOF = Proof(
    **vars(Proven(0.0, 0.0, 0.0, 0.0, ())),
    tolerance=1e-9,
    error=1e-10,
    condition=2.0,
    cancellation=3.0,
)
ZERO, CONSTANT = 3, 11
"""A function that vanishes, and one that does not change."""


def wave(row: int, x: np.ndarray) -> np.ndarray:
    """The known function of this index."""
    if row == ZERO:
        return np.zeros_like(x)
    if row == CONSTANT:
        return np.full_like(x, 2.5)
    return np.asarray(0.1 * row + np.cos((row % 5) * x) - 2.0 * np.sin(x))


@pytest.fixture(scope="module")
def solver(joint: cd.Mechanism) -> ProblemSolver:
    return universal(joint, 0.5).solver


@pytest.fixture(scope="module")
def data() -> ResponseData:
    domain = Domain(ORIGIN, 2.0 * np.pi, True)
    rows = range(LAYOUT.size * len(COLUMNS))
    values = np.stack([wave(row, domain.nodes(32)) for row in rows])
    # What vanishes is rounding, which is not to be evaluated.
    values[ZERO] = 1e-16 * np.cos(np.arange(32.0))
    return ResponseData(
        LAYOUT,
        Series(values, domain),
        np.array([row == ZERO for row in rows]),
        np.array([row == CONSTANT for row in rows]),
        np.ones((1, 6), dtype=bool),
        frozen({"mesh": True, "train": True}),
        PROOF,
    )


def points(
    solver: ProblemSolver,
    data: ResponseData,
    positions: np.ndarray | None,
    factors: dict[Column, np.ndarray],
    shape: tuple[int, ...],
    step_count: int | None = None,
) -> OperatingPoints:
    acting = acting_on(solver.problem)
    part = OfDesign(data, ..., positions, step_count, [*factors.items()])
    given = None if positions is None else positions[..., None]
    return OperatingPoints(solver, shape, [part], acting, {}, given)


X = np.array([0.0, 1.0, -7.0, 20.0])
FACTORS = {SPEED_SQUARED: np.array(9.0), LOAD: np.array([[1.0], [-4.0]])}


def expected(rows: dict[Column, int], x: np.ndarray) -> np.ndarray:
    terms = [FACTORS[column] * wave(row, x) for column, row in rows.items()]
    return np.broadcast_to(sum(terms), (2, 4))


def test_wrenches_are_sums_over_the_columns_that_act(
    solver: ProblemSolver, data: ResponseData
) -> None:
    """The first column has the rows 0 … 5, the load's 20 … 25."""
    wrench = points(solver, data, X, FACTORS, (2, 4)).wrench(0)
    for index in range(6):
        rows = {SPEED_SQUARED: index, LOAD: 20 + index}
        np.testing.assert_allclose(wrench.component(index), expected(rows, X), atol=1e-12)
        assert wrench.component(index) is wrench.component(index)
    np.testing.assert_array_equal(
        wrench.vector(3), np.stack([wrench.component(index) for index in (3, 4, 5)], axis=-1)
    )
    assert not any(wrench.vanishes(index) for index in range(6))


def test_a_component_vanishes_where_all_acting_columns_do(
    solver: ProblemSolver, data: ResponseData
) -> None:
    wrench = points(solver, data, X, {SPEED_SQUARED: np.array(2.0)}, (4,)).wrench(0)
    assert [wrench.vanishes(index) for index in range(6)] == [index == ZERO for index in range(6)]
    np.testing.assert_array_equal(wrench.component(ZERO), np.zeros(4))
    nothing = points(solver, data, X, {}, (4,)).wrench(0)
    assert all(nothing.vanishes(index) for index in range(6))
    np.testing.assert_array_equal(nothing.vector(0), np.zeros((4, 3)))


def test_constant_functions_take_the_shape_of_the_operating_points(
    solver: ProblemSolver, data: ResponseData
) -> None:
    wrench = points(solver, data, X, {ACCELERATION: np.array(2.0)}, (2, 4)).wrench(0)
    np.testing.assert_allclose(wrench.component(CONSTANT - 10), np.full((2, 4), 5.0), rtol=1e-15)


def test_efforts_and_moments_of_couplings(solver: ProblemSolver, data: ResponseData) -> None:
    """After six rows of a wrench every column has two efforts and two moments."""
    operating = points(solver, data, X, FACTORS, (2, 4))
    np.testing.assert_allclose(
        operating.drive_effort()[..., 0], expected({SPEED_SQUARED: 6, LOAD: 26}, X), atol=1e-12
    )
    held = operating.holding_effort()
    assert list(held) == ["joint_angle"]
    np.testing.assert_allclose(
        held["joint_angle"], expected({SPEED_SQUARED: 7, LOAD: 27}, X), atol=1e-12
    )
    moments = CouplingMoments(operating)
    assert list(moments) == ["mesh", "train"]
    assert len(moments) == 2
    np.testing.assert_allclose(
        moments["train"], expected({SPEED_SQUARED: 9, LOAD: 29}, X), atol=1e-12
    )
    assert moments["train"] is moments["train"]
    with pytest.raises(KeyError):
        moments["bearing_in"]


def test_efforts_that_the_outputs_leave_out_are_not_known(data: ResponseData) -> None:
    mechanism = cd.load("drive_line")
    held = {name: 0.2 for name in mechanism.joints if name.startswith("joint_angle")}
    scene = cd.Scene(mechanism, drive="bearing_in", held=held, outputs=["bearing_out"])
    operating = points(scene.solver, data, X, FACTORS, (2, 4))
    assert operating.drive_effort() is None
    assert "joint_angle_1" not in operating.holding_effort()


def test_equal_steps_are_evaluated_where_they_are_said_to_lie(
    solver: ProblemSolver, data: ResponseData
) -> None:
    operating = points(solver, data, None, FACTORS, (2, 4), step_count=4)
    steps = ORIGIN + 0.5 * np.pi * np.arange(4)
    np.testing.assert_allclose(operating.position[:, 0], steps, rtol=1e-15)
    np.testing.assert_allclose(
        operating.wrench(0).component(1), expected({SPEED_SQUARED: 1, LOAD: 21}, steps), atol=1e-12
    )


def test_evaluated_arrays_cannot_be_written_to(solver: ProblemSolver, data: ResponseData) -> None:
    operating = points(solver, data, X, FACTORS, (2, 4))
    for array in (operating.wrench(0).component(0), operating.drive_effort()):
        assert array is not None
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0.0
    # The factors stay the caller's.
    assert FACTORS[LOAD].flags.writeable


def test_too_many_operating_points_for_the_memory(
    solver: ProblemSolver, data: ResponseData, monkeypatch: pytest.MonkeyPatch
) -> None:
    def exhausted(*_: object) -> np.ndarray:
        raise MemoryError

    operating = points(solver, data, X, FACTORS, (1000, 4000))
    monkeypatch.setattr(OfDesign, "sum", exhausted)
    message = (
        r"not enough memory for operating points of shape \(1000, 4000\), 0\.032 GB per component"
    )
    with pytest.raises(cd.ArgumentError, match=message):
        operating.wrench(0).component(0)


def test_motions_have_the_shape_of_the_operating_points(
    solver: ProblemSolver, data: ResponseData
) -> None:
    speeds = np.array([[2.0], [5.0]])
    acting = acting_on(solver.problem, speeds)
    operating = replace(points(solver, data, X, {}, (2, 4)), acting=acting)
    motion = operating.motion()
    # The velocity ratio of a Cardan joint, bent by 0.5 rad.
    ratio = np.cos(0.5) / (1.0 - np.sin(0.5) ** 2 * np.cos(X) ** 2)
    np.testing.assert_allclose(np.abs(motion.velocity("bearing_out")), speeds * ratio)
    assert motion.shape == (2, 4)


@pytest.mark.parametrize("speed", [1e155, 1e160, 1e200, 1.7e308])
def test_motions_that_overflow_are_refused(solver: ProblemSolver, speed: float) -> None:
    """Accelerations grow with the square of the speed, beyond 1.8e308."""
    speeds, zeros = np.array([1.0, speed]), np.zeros(2)
    with pytest.raises(cd.ArgumentError, match="so great that numbers overflow"):
        solved_motion(solver, np.array([0.3, 0.3]), speeds, zeros)
    with pytest.raises(cd.ArgumentError, match="so great that numbers overflow"):
        solved_motion(solver, np.array([0.3, 0.3]), zeros, 1.7e308 * speeds[:1] * np.ones(2))


def test_joints_that_no_output_needs_are_no_overflow() -> None:
    """Of the two wheels that the first one drives, only the second one is an output."""
    train = gears(coupling("ab", "a", "b", -2.0), coupling("ac", "a", "c", -3.0), third=True)
    scene = cd.Scene(cd.load(train), drive="a", outputs=["b"])
    motion = solved_motion(scene.solver, X, np.ones(4), np.ones(4))
    np.testing.assert_array_equal(motion.velocity("b"), -2.0 * np.ones(4))
    for values in (motion.velocity("c"), motion.acceleration("c")):
        assert np.all(np.isnan(values))
