"""What a scene solves for its outputs, and what that costs; dead points of drives."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.drive_lines import drive_line, two_lines
from testkit.linkages import POSITIONS, RATES
from testkit.scenes import relative, text, universal

import cardan_dyn as cd


def operations(mechanism: cd.Mechanism) -> int:
    """Return how many operations the last tape of a mechanism has."""
    tapes = [*mechanism.kept._values["tapes"].values()]
    return len(tapes[-1][0]._program.graph.operations)


def test_a_line_solved_in_groups_equals_the_line_solved_at_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from cardan_dyn.core.kinematics import loop_system

    mechanism = cd.load(drive_line(4))
    options = {
        "drive": "bearing_0",
        "loads": {"bearing_4": -20.0, "bearing_2": 3.0},
        "gravity": (0.0, -1.0, -9.81),
    }
    parts = cd.Scene(mechanism, **options).sweep(POSITIONS, **RATES)
    real = loop_system.partition
    monkeypatch.setattr(
        loop_system, "partition", lambda *given, **more: real(*given, **{**more, "together": True})
    )
    # Another mechanism, since groups are kept with the one that they were found of.
    scene = cd.Scene(cd.load(drive_line(4)), **options)
    assert len([step for step in scene.plan().steps if step.startswith("close")]) == 1
    whole = scene.sweep(POSITIONS, **RATES)
    assert relative(parts.drive_effort, whole.drive_effort) < 1e-12
    for name in mechanism.joint_names:
        scale = np.max(np.abs(whole[name].moment)) + np.max(np.abs(whole[name].force))
        assert np.max(np.abs(parts[name].force - whole[name].force)) < 1e-12 * scale
        assert np.max(np.abs(parts[name].moment - whole[name].moment)) < 1e-12 * scale
        np.testing.assert_array_equal(parts[name].unique, whole[name].unique)


def test_outputs_of_one_line_leave_the_other_out() -> None:
    """Two lines on one input: what is not asked for costs nothing, and nothing changes."""
    both = cd.load(two_lines(3))
    options = {"drive": "bearing_0", "loads": {"left_3": -5.0, "right_3": -7.0}}
    whole = cd.Scene(both, **options).sweep(POSITIONS, **RATES)
    all_of_them = operations(both)
    scene = cd.Scene(both, **options, outputs=["left_1", "left_3", "left_pin_2_in"])
    some = scene.sweep(POSITIONS, **RATES)
    assert operations(both) < 0.7 * all_of_them
    for name in ("left_1", "left_3", "left_pin_2_in"):
        # What is not unique is chosen among the joints that are solved.
        np.testing.assert_array_equal(some[name].unique, whole[name].unique)
        assert some[name].unique[3]
        for quantity, rows in (("force", slice(3)), ("moment", slice(3, 6))):
            vectors, reference = getattr(some[name], quantity), getattr(whole[name], quantity)
            unique = some[name].unique[rows]
            np.testing.assert_allclose(vectors[:, unique], reference[:, unique], atol=1e-11)
    assert np.isnan(some.power_residual)
    assert some.balance_residual < 1e-13
    with pytest.raises(cd.ModelError, match="the drive effort was not asked for"):
        _ = some.drive_effort
    with pytest.raises(cd.ModelError, match="the wrench of 'right_1' was not asked for"):
        some["right_1"]
    assert np.all(np.isnan(some.motion.position("right_3")))
    np.testing.assert_allclose(
        some.motion.position("left_3"), whole.motion.position("left_3"), atol=1e-13
    )
    skipped = "\n".join(scene.plan().skipped)
    assert "right_pin_1_out" in skipped
    assert "left" not in skipped
    # The shared input needs both lines again.
    with_input = cd.Scene(both, **options, outputs=["bearing_0"]).sweep(POSITIONS, **RATES)
    assert relative(with_input.drive_effort, whole.drive_effort) < 1e-13


def test_drive_effort_alone_comes_from_virtual_work(
    shaft: cd.Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    held = {"joint_angle_1": 0.5, "joint_angle_2": 0.3}
    options = {
        "drive": "bearing_in",
        "held": held,
        "gravity": (0.0, 3.0, -9.81),
        "loads": {
            "bearing_out": -50.0,
            "tube": cd.Wrench(force=(1.0, 20.0, -300.0), frame="world"),
        },
    }
    whole = cd.Scene(shaft, **options).sweep(POSITIONS, speed=50.0, acceleration=8.0)
    alone = cd.Scene(shaft, **options, outputs=[])
    effort = alone.sweep(POSITIONS, speed=50.0, acceleration=8.0)
    assert relative(effort.drive_effort, whole.drive_effort) < 1e-12
    assert effort.outputs == ()
    assert effort.holding_effort == {}
    assert np.isnan(effort.balance_residual)
    assert "drive efforts by virtual work" in alone.plan().steps


def test_terms_that_are_zero_are_not_computed() -> None:
    joint = cd.load("universal_joint")  # One of its own: other tests trace tapes of the shared one.
    scene = universal(joint, 0.5)
    scene.sweep(POSITIONS)
    quasi_static = operations(joint)
    scene.sweep(POSITIONS, speed=3.0)
    moving = operations(joint)
    assert quasi_static < 0.8 * moving
    massless = text("universal_joint")
    while "<inertial>" in massless:
        start = massless.index("<inertial>")
        massless = massless[:start] + massless[massless.index("</inertial>") + 11 :]
    light = universal(cd.load(massless), 0.5, gravity=(0.0, 0.0, -9.81))
    light.sweep(POSITIONS, speed=3.0)
    assert operations(light.mechanism) < 0.9 * moving
    assert "inverse dynamics: no body has mass" in light.plan().skipped


def test_long_lines_take_small_models() -> None:
    """The largest model decides Pinocchio's memory: it must not grow with the line."""
    sizes = []
    for count in (3, 12):
        scene = cd.Scene(cd.load(drive_line(count)), drive="bearing_0")
        solvers = scene.solver.assembly.kinematics.solvers
        assert len(solvers) == count
        sizes.append(6 * max(len(solver.group.bodies) for solver in solvers))
    assert sizes[0] == sizes[1] <= 30


@pytest.mark.slow
@pytest.mark.parametrize("name", ["drive_line", "needle_drive", "stewart_platform"])
def test_each_output_alone_equals_the_full_result(name: str) -> None:
    mechanism = cd.load(name)
    options: dict[str, object] = {
        "drive_line": {
            "drive": "bearing_in",
            "held": {f"joint_angle_{k}": 0.2 for k in (1, 2, 3)},
            "loads": {"bearing_out": -10.0},
        },
        "needle_drive": {"drive": "main_shaft", "gravity": (0.0, -9.81, 0.0)},
        "stewart_platform": {"drive": [f"leg_{k}" for k in range(1, 7)]},
    }[name]
    position = 0.3 if name != "stewart_platform" else [[0.01, -0.02, 0.0, 0.01, 0.02, 0.0]]
    whole = cd.Scene(mechanism, **options).sweep(position, speed=2.0)
    scale = max(np.max(np.abs(whole[joint].moment)) for joint in mechanism.joint_names)
    for joint in mechanism.joint_names:
        alone = cd.Scene(mechanism, **options, outputs=[joint]).sweep(position, speed=2.0)
        assert np.array_equal(alone[joint].unique, whole[joint].unique)
        for quantity, rows in (("force", slice(3)), ("moment", slice(3, 6))):
            difference = getattr(alone[joint], quantity) - getattr(whole[joint], quantity)
            unique = whole[joint].unique[rows]
            assert np.max(np.abs(difference[:, unique]), initial=0.0) < 1e-9 * scale


def test_a_zero_that_is_a_dead_point() -> None:
    """The slider-crank is drawn at its outer dead centre: the piston cannot start it."""
    mechanism = cd.load("slider_crank")
    with pytest.raises(cd.SingularConfigurationError, match=r"is a dead point: .*Give near="):
        cd.Scene(mechanism, drive="piston_guide")
    scene = cd.Scene(mechanism, drive="piston_guide", near={"crank_bearing": 1.0})
    low, high = scene.motion_range()
    assert high - low == pytest.approx(0.09, abs=1e-9)
    crank = cd.Scene(mechanism, drive="crank_bearing").sweep([1.0, 1.2])
    back = scene.sweep(crank.motion.position("piston_guide"))
    np.testing.assert_allclose(back.motion.position("crank_bearing"), [1.0, 1.2], rtol=1e-12)
