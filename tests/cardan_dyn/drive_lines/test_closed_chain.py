import numpy as np
import pinocchio as pin
import pytest
from testkit.line_data import double_shaft, end_bearings, random_line

import cardan_dyn as cd
from cardan_dyn.analytic import drive_line
from cardan_dyn.drive_lines import Bearing, DriveLine, Shaft, Spline
from cardan_dyn.practice.drive_lines.line.closed_chain import urdf

TURN = np.linspace(0.0, 2.0 * np.pi, 49)


def motion_error(line: DriveLine, positions: np.ndarray = TURN) -> float:
    """Error of the output's angle and speed ratio against the composed closed form."""
    scene = cd.Scene(cd.load(urdf(line)), drive="bearing_in", outputs=[])
    motion = scene.sweep(positions).motion
    joints = line.joint_angles, line.fork_phases
    exact = drive_line.output_angle(*joints, positions)
    angle = motion.position("bearing_out")
    drift = (angle - angle[0]) - (exact - exact[0])
    ratio = motion.ratio("bearing_out") / drive_line.speed_ratio(*joints, positions) - 1.0
    return float(max(np.abs(drift).max(), np.abs(ratio).max()))


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 2, 3, 4, 7, 16])
def test_motion_is_the_composed_closed_form(count: int) -> None:
    assert motion_error(random_line(count, seed=count)) < 1e-12


@pytest.mark.slow
def test_sixty_four_joints() -> None:
    assert motion_error(random_line(64, seed=0, bend=0.08)) < 1e-12


@pytest.mark.parametrize("beta", [0.0, 1e-9, np.radians(80.0)])
def test_extreme_joint_angles(beta: float) -> None:
    assert motion_error(double_shaft((0.0, beta, 0.0))) < 1e-12
    assert motion_error(DriveLine(shafts=[Shaft(), Shaft(slope_plan=beta)])) < 1e-12


@pytest.mark.parametrize("offset", [-0.3, -100.0, 1000.0])
def test_fork_offsets_of_any_size(offset: float) -> None:
    assert motion_error(double_shaft((0.0, 0.2, 0.1), fork_offset=offset)) < 1e-12


@pytest.mark.slow
def test_shafts_of_very_different_lengths() -> None:
    shafts = [Shaft(bearings=end_bearings(0)), *random_line(4, 1).shafts[1:4], Shaft()]
    shafts[1] = Shaft(length=20, slope_side=0.1, bearings=[Bearing(distance=19)])
    shafts[2] = Shaft(length=0.01, slope_side=-0.1, bearings=[Bearing(distance=0.008)])
    assert motion_error(DriveLine(shafts=shafts)) < 1e-12


def every_spline(count: int) -> DriveLine:
    """A line with a spline in every intermediate shaft, and bearings behind them."""
    line = random_line(count, seed=5)
    middle = [
        Shaft(
            length=1.0,
            slope_plan=shaft.slope_plan,
            fork_offset=0.1,
            spline=Spline(distance=0.5),
            bearings=[Bearing(distance=0.7)] if k < count - 2 else (),
        )
        for k, shaft in enumerate(line.shafts[1:-1])
    ]
    return line.replace(shafts=[line.shafts[0], *middle, line.shafts[-1]])


@pytest.mark.slow
def test_a_spline_in_every_shaft() -> None:
    line = every_spline(6)
    assert line.indeterminate == ()
    assert motion_error(line) < 1e-12
    scene = line.scene(loads={"bearing_out": -1.0})
    assert np.all(scene.sweep(TURN).unique)


def test_a_jackshaft_with_two_bearings_of_its_own() -> None:
    jack = Shaft(length=0.6, slope_side=0.1, bearings=[Bearing(distance=d) for d in (0.1, 0.5)])
    middle = [Shaft(length=0.7, slope_side=s, spline=Spline()) for s in (-0.1, 0.2)]
    line = DriveLine(shafts=[Shaft(), middle[0], jack, middle[1], Shaft()])
    assert line.indeterminate == ()
    assert motion_error(line) < 1e-12
    assert np.all(line.scene(loads={"bearing_out": -1.0}).sweep(TURN).unique)


@pytest.mark.parametrize("count", [2, 3, 5])
def test_what_is_determinate_is_so(count: int) -> None:
    line = random_line(count, seed=count, mass=True)
    assert line.indeterminate == ()
    sweep = cd.Scene(line.mechanism, strict=True, loads={"bearing_out": -1.0}).sweep(TURN, 100.0)
    assert np.all(sweep.unique)
    assert sweep.balance_residual < 1e-11


@pytest.mark.parametrize("count", [1, 2, 3, 6])
def test_all_loops_are_closed_at_zero(count: int) -> None:
    for line in (random_line(count, seed=count), every_spline(max(count, 2))):
        model = line.mechanism.model
        data = model.createData()
        pin.forwardKinematics(model, data, pin.neutral(model))
        for weld in line.mechanism.constraint_models:
            ends = (
                data.oMi[joint] * placement
                for joint, placement in (
                    (weld.joint1_id, weld.joint1_placement),
                    (weld.joint2_id, weld.joint2_placement),
                )
            )
            one, two = ends
            assert one.homogeneous == pytest.approx(two.homogeneous, abs=1e-14)


def test_the_text_is_read_by_itself() -> None:
    text = double_shaft((0.0, 0.2, 0.0)).to_urdf()
    mechanism = cd.load(text)
    assert mechanism.independent_joints == ("bearing_in",)
    (warning,) = mechanism.warnings
    assert "limits of" in warning
    assert set(mechanism.adjustable) >= {
        "joint_angle_1",
        "joint_plane_2",
        "fork_offset_1",
        "shaft_length_1",
        "offset_y_1",
        "offset_z_1",
        "support_A_y",
    }
    # It is closed at zero, and a scene needs nothing but a load.
    assert cd.Scene(mechanism, loads={"bearing_out": -1.0}).sweep(0.0).loop_residual < 1e-14


@pytest.mark.slow
def test_every_adjustable_joint_can_be_held() -> None:
    line = random_line(3, seed=2)
    for name, kind in line.mechanism.adjustable.items():
        held = {name: 0.01 if kind == "revolute" else 0.002}
        if name == "tube_length_1":
            held["shaft_length_1"] = 0.002
        sweep = line.scene(held=held, outputs=[]).sweep(TURN[:5])
        assert sweep.loop_residual < 1e-13, name


def test_the_input_forks_pin_is_horizontal_at_zero() -> None:
    line = random_line(3, seed=3)
    sweep = line.scene().sweep(np.array([0.0]))
    assert sweep.rotation("pin_1_in")[0, 2, 1] == pytest.approx(0.0, abs=1e-15)


def test_places_are_where_the_data_say() -> None:
    line = random_line(4, seed=4)
    sweep = line.scene().sweep(np.array([0.3]))
    for k, centre in enumerate(line.geometry.centres, 1):
        assert sweep.origin(f"pin_{k}_in")[0] == pytest.approx(centre, abs=1e-14)
    at = (
        line.geometry.centres[0]
        + line.shafts[1].bearings[0].distance * (line.geometry.directions[1])
    )
    assert sweep.origin("support_C1")[0] == pytest.approx(at, abs=1e-14)


def test_angles_of_upright_shafts() -> None:
    up = DriveLine(shafts=[Shaft(start=(0, 0, 0), end=(0, 0, 1)), Shaft(end=(0.1, 0.2, 2))])
    assert motion_error(up) < 1e-12
