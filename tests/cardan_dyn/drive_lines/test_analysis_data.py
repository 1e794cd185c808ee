import copy
import pickle

import numpy as np
import pytest
from testkit.line_data import double_shaft, random_line

from cardan_dyn.drive_lines import Analysis


def analysis() -> Analysis:
    return random_line(3, seed=0, mass=True).analyse(speed=80, torque=200)


def test_names_and_shapes() -> None:
    found = analysis()
    assert found.shape == (360,)
    assert len(found) == 360
    assert found.shafts == ("input", "shaft_1", "shaft_2", "output")
    assert found.joints == ("joint_1", "joint_2", "joint_3")
    assert found.bearings == ("B", "A", "C1", "E", "F")
    assert found.splines == ("shaft_2",)
    assert found.total.moment_in.shape == (360, 3, 3)
    assert found.total.bearing_force.shape == (360, 5, 3)
    assert "360 samples, 3 joints, 5 bearings" in repr(found)


def test_the_total_is_the_sum() -> None:
    found = analysis()
    assert found.inertial is not None
    assert found.total.bearing_force == pytest.approx(
        found.static.bearing_force + found.inertial.bearing_force
    )
    massless = double_shaft((0.0, 0.2, 0.0)).analyse(speed=80, torque=200)
    assert massless.inertial is None
    assert massless.total is massless.static


def test_the_angle_error_of_one_joint() -> None:
    # The greatest lead is asin κ, κ = tan²(β/2), on both sides of its mean, which is zero.
    found = double_shaft((0.0, 0.3, 0.0)).analyse(speed=0, torque=1)
    kappa = np.tan(0.15) ** 2
    assert found.angle_error[:, 1].max() == pytest.approx(np.arcsin(kappa), rel=1e-3)
    assert found.angle_error[:, 1].mean() == pytest.approx(0.0, abs=1e-16)
    assert np.abs(found.angle_error[:, 2]).max() < 1e-14


def test_residuals_prove_it() -> None:
    found = analysis()
    assert found.loop_residual < 1e-13
    assert found.balance_residual < 1e-12
    assert found.power_residual < 1e-12


def test_results_cannot_be_changed() -> None:
    found = analysis()
    with pytest.raises(ValueError, match="read-only"):
        found.static.bearing_force[0] = 0.0
    with pytest.raises(ValueError, match="read-only"):
        found.position[0] = 1.0
    with pytest.raises(AttributeError):
        found.speed = 1.0


def test_results_can_be_pickled() -> None:
    found = analysis()
    other = pickle.loads(pickle.dumps(found))
    assert np.array_equal(other.total.moment_out, found.total.moment_out)
    assert other.bearings == found.bearings
    for copied in (other, copy.deepcopy(found)):
        assert isinstance(copied, Analysis)
        for array in (copied.rotation, copied.mean_lead, copied.static.bearing_force):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 0.0
