"""Sampled functions against sweeps of scenes in which one column acts alone."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.claims import acting
from testkit.linkages import LINK, coupling, four_bar, gears, loop
from testkit.scenes import double

import cardan_dyn as cd
from cardan_dyn.core.problem.samples import Targets
from cardan_dyn.core.response.columns import (
    ACCELERATION,
    GRAVITY,
    SPEED_SQUARED,
    Acts,
    Column,
    Layout,
)
from cardan_dyn.core.response.sampling import FunctionSampler, Sampled, layout_of

POSITIONS = np.array([0.0, 0.4, 1.0, 2.9, -5.0])
PUSH = cd.Wrench(force=(0.0, 3.0, 10.0), moment=(1.0, 0.0, 0.0))
LOAD, WRENCH = Column(Acts.JOINT_LOAD, "bearing_out"), Column(Acts.LINK_LOAD, "shaft_out")


def scene(joint: cd.Mechanism, **changes: object) -> cd.Scene:
    arguments: dict[str, object] = {
        "drive": "bearing_in",
        "held": {"joint_angle": 0.4},
        "loads": {"shaft_out": PUSH, "bearing_out": -2.0},
        "gravity": (0.0, 0.0, -9.81),
    }
    return cd.Scene(joint, **{**arguments, **changes})


def answer(sampler: FunctionSampler, positions: np.ndarray, proven: bool = False) -> Sampled:
    targets = Targets.of_positions(positions[:, None])
    (found,) = sampler.samples(targets, [len(positions)], proven)
    return found


def layout(joint: cd.Mechanism, **changes: object) -> Layout:
    return layout_of(scene(joint, **changes).solver)


def test_columns_are_listed_in_one_order_whatever_the_order_of_the_loads(
    joint: cd.Mechanism,
) -> None:
    complete = layout(joint)
    assert complete.columns == (SPEED_SQUARED, ACCELERATION, LOAD, WRENCH, *GRAVITY)
    assert complete.outputs == tuple(joint.joint_names)
    assert complete.efforts == ("bearing_in", "joint_angle")
    assert complete.couplings == ()
    assert layout(joint, gravity=None, loads=None).columns == (SPEED_SQUARED, ACCELERATION)
    assert layout(joint, outputs=["pin_in"]).outputs == ("pin_in",)


def test_without_masses_there_are_loads_alone() -> None:
    urdf = """<robot name="massless"><link name="ground"/><link name="wheel"/>
      <joint name="a" type="continuous"><parent link="ground"/><child link="wheel"/>
      <axis xyz="0 0 1"/></joint></robot>"""
    mechanism = cd.load(urdf)
    loaded = cd.Scene(mechanism, drive="a", loads={"a": 2.0}, gravity=(0.0, 0.0, -9.81))
    assert layout_of(loaded.solver).columns == (Column(Acts.JOINT_LOAD, "a"),)
    idle = cd.Scene(mechanism, drive="a").solver
    samples = answer(FunctionSampler(idle), POSITIONS)
    assert samples.values.shape == (0, len(POSITIONS))
    assert samples.condition == 1.0


@pytest.mark.parametrize(
    ("column", "loads", "gravity", "speed", "acceleration"),
    [
        (SPEED_SQUARED, {}, None, 1.0, 0.0),
        (ACCELERATION, {}, None, 0.0, 1.0),
        (LOAD, {"bearing_out": 1.0}, None, 0.0, 0.0),
        (WRENCH, {"shaft_out": PUSH}, None, 0.0, 0.0),
        (GRAVITY[0], {}, (1.0, 0.0, 0.0), 0.0, 0.0),
        (GRAVITY[2], {}, (0.0, 0.0, 1.0), 0.0, 0.0),
    ],
    ids=["speed", "acceleration", "load", "wrench", "gravity x", "gravity z"],
)
def test_a_column_is_what_a_sweep_gives_where_it_acts_alone(
    joint: cd.Mechanism,
    column: Column,
    loads: dict[str, object],
    gravity: object,
    speed: float,
    acceleration: float,
) -> None:
    sampler = FunctionSampler(scene(joint).solver)
    values = answer(sampler, POSITIONS).values
    alone = scene(joint, loads=loads, gravity=gravity)
    sweep = alone.sweep(POSITIONS, speed, acceleration)
    scale = max(float(np.max(np.abs(sweep[name].moment))) for name in joint.joint_names)
    for output, name in enumerate(sampler.layout.outputs):
        expected = np.concatenate([sweep[name].force, sweep[name].moment], axis=1).T
        first = sampler.layout.row(column, 6 * output)
        rows = list(range(first, first + 6))
        np.testing.assert_allclose(values[rows], expected, atol=1e-12 * scale)
    efforts = [sweep.drive_effort, sweep.holding_effort["joint_angle"]]
    for index, expected in enumerate(efforts):
        row = values[sampler.layout.row(column, sampler.layout.wrenches + index)]
        np.testing.assert_allclose(row, expected, atol=1e-12 * scale)


def test_moments_of_couplings_and_efforts_of_two_wheels() -> None:
    """The second wheel of 0.025 kg·m² turns at -2.5 times the speed of the first."""
    wheels = cd.load(gears(coupling("mesh", "a", "b", -2.5)))
    for options in ({}, {"outputs": []}):
        sampler = FunctionSampler(cd.Scene(wheels, drive="a", loads={"b": 7.0}, **options).solver)
        samples = answer(sampler, POSITIONS)
        for column, effort, moment in (
            (ACCELERATION, 0.025 * (1.0 + 2.5**2), -2.5 * 0.025),
            (Column(Acts.JOINT_LOAD, "b"), 2.5, -1.0),
            (SPEED_SQUARED, 0.0, 0.0),
        ):
            row = samples.values[sampler.layout.row(column, sampler.layout.wrenches)]
            np.testing.assert_allclose(row, effort, atol=1e-14)
            if sampler.layout.couplings:
                row = samples.values[sampler.layout.row(column, sampler.layout.moments)]
                np.testing.assert_allclose(row, moment, atol=1e-14)
        assert samples.indeterminate_couplings == frozenset()


def test_moments_of_couplings_beside_a_loop() -> None:
    """The crank of a four-bar drives a wheel of 0.025 kg·m² at -2 times its own speed."""
    wheel = LINK.format(name="wheel", com="0 0 0", mass="1")
    urdf = four_bar(loop("continuous")).replace(
        "</robot>",
        f"""{wheel}<joint name="w" type="continuous"><parent link="ground"/><child link="wheel"/>
        <origin xyz="-1 0 0"/><axis xyz="0 0 1"/></joint><coupling name="mesh">
        <predecessor link="crank"/><successor link="wheel"/><ratio value="-2"/></coupling>
        </robot>""",
    )
    sampler = FunctionSampler(cd.Scene(cd.load(urdf), drive="a", loads={"w": 7.0}).solver)
    values = answer(sampler, POSITIONS).values
    for column, moment in (
        (SPEED_SQUARED, 0.0),
        (ACCELERATION, -2.0 * 0.025),
        (Column(Acts.JOINT_LOAD, "w"), -1.0),
    ):
        row = values[sampler.layout.row(column, sampler.layout.moments)]
        np.testing.assert_allclose(row, moment, atol=1e-13)


def test_proven_samples_are_those_that_are_solved(joint: cd.Mechanism) -> None:
    example = scene(joint)
    sampler = FunctionSampler(example.solver)
    samples = answer(sampler, POSITIONS, True)
    residuals, loop_error = samples.proven, samples.loop_error
    alone = answer(sampler, POSITIONS)
    np.testing.assert_allclose(samples.values, alone.values, atol=1e-12)
    assert alone.loop_error is alone.proven is None
    # What is proven is the scene itself at unit speed and acceleration.
    solver, ones = example.solver, np.ones((len(POSITIONS), 1))
    closed = solver.assemble(Targets.of_positions(POSITIONS[:, None]))
    solution = solver.solve(closed, acting(solver, ones, ones))
    assert residuals is not None
    for name in ("wrench", "applied", "inertia", "power_scale", "speed_scale"):
        expected = getattr(solution.residuals, name)
        np.testing.assert_allclose(getattr(residuals, name), expected, rtol=1e-11, atol=1e-12)
    assert residuals.balance < 1e-13
    assert np.max(loop_error) < 1e-14
    np.testing.assert_allclose(
        samples.condition,
        np.max(solver.magnification_at(closed, solution.x) * solution.residuals.cancellation),
        rtol=0.1,
    )


def test_answers_to_several_spans_are_those_to_each() -> None:
    example = double(cd.load("double_shaft_z"), 0.5, 0.4, load=-10.0)
    sampler = FunctionSampler(example.solver)
    position = np.linspace(0.0, 6.0, 1000)
    spans = [slice(0, 300), slice(300, 310), slice(310, 900), slice(900, 1000)]
    counts = [300, 10, 590, 100]
    together = sampler.samples(Targets.of_positions(position[:, None]), counts, True)
    for span, found in zip(spans, together, strict=True):
        alone = answer(sampler, position[span], True)
        np.testing.assert_allclose(found.values, alone.values, atol=1e-10)
        np.testing.assert_allclose(found.condition, alone.condition, rtol=1e-9)
        assert found.proven is not None
        assert len(found.proven.wrench) == span.stop - span.start


def test_samples_of_a_scene_with_a_load_per_sample_are_proven_with_a_constant_load(
    joint: cd.Mechanism,
) -> None:
    changing = scene(joint, loads={"bearing_out": np.linspace(-1.0, -2.0, 40), "shaft_out": PUSH})
    found = answer(FunctionSampler(changing.solver), POSITIONS, True)
    constant = answer(FunctionSampler(scene(joint).solver), POSITIONS)
    np.testing.assert_allclose(found.values, constant.values, atol=1e-12)
    assert found.proven is not None
    assert found.proven.balance < 1e-13


def sampled(values: list[float], condition: float, influence: float, open_coupling: int) -> Sampled:
    return Sampled(
        np.array([values]), condition, np.full((1, 6), influence), frozenset({open_coupling})
    )


def test_interleaved_samples_alternate_and_keep_the_worst() -> None:
    first, between = sampled([1.0, 3.0], 5.0, 1e-15, 0), sampled([2.0, 4.0], 4.0, 1e-3, 2)
    both = first.interleaved(between)
    np.testing.assert_array_equal(both.values, [[1.0, 2.0, 3.0, 4.0]])
    assert both.condition == between.interleaved(first).condition == 5.0
    assert both.indeterminate_couplings == {0, 2}
    np.testing.assert_array_equal(both.influence, between.influence)
    assert first.unique.all()
    assert not both.unique.any()
    # A range has one sample more than there are gaps.
    np.testing.assert_array_equal(
        sampled([1.0, 3.0, 5.0], 1.0, 0.0, 0).interleaved(between).values, [[1, 2, 3, 4, 5]]
    )
