import copy
import pickle
import sys

import numpy as np
import pytest
from testkit.line_data import double_shaft, random_line

from cardan_dyn import MissingExtraError
from cardan_dyn.drive_lines import Analysis, LineForces

LINE = random_line(3, seed=0, mass=True)


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


@pytest.mark.slow
def test_every_result_with_its_unit() -> None:
    found = LINE.analyse(speed=80, torque=200)
    table = found.to_xarray()
    assert table.sizes["position"] == 360
    assert table["bearing_radial"].sel(bearing="C1").values == pytest.approx(
        found.total.bearing_radial[:, 2]
    )
    assert table["static_bending_out"].values == pytest.approx(found.static.bending_out)
    assert table["ratio"].sel(shaft="output").dims == ("position",)
    for name, variable in table.data_vars.items():
        assert variable.attrs["units"] and variable.attrs["long_name"], name
        assert np.all(np.isfinite(variable)), name
    assert table.attrs["line"] == "drive_line"


def test_designs_are_a_dimension() -> None:
    designs = LINE.variants(angles=np.full((4, 3), 0.2), misalignments={"offset_y_1": 0.001})
    table = LINE.analyse(speed=0, torque=200, positions=[0, 1], variants=designs).to_xarray()
    assert dict(table["torsion_in"].sizes) == {"design": 4, "position": 2, "joint": 3}
    assert table["joint_angle_2"].attrs["units"] == "rad"
    assert table["offset_y_1"].attrs["units"] == "m"
    assert table["offset_y_1"].values.tolist() == [0.001] * 4
    assert "static_torsion_in" not in table


def test_frames_have_a_row_per_sample() -> None:
    designs = LINE.variants(angles=np.full((4, 3), 0.2))
    found = LINE.analyse(speed=0, torque=200, positions=[0, 1], variants=designs)
    frame = found.to_dataframe()
    assert frame.index.names == ["design", "position"]
    forces = found.total.bearing_force
    assert np.array_equal(frame["C1.bearing_force_up"], forces[..., 2, 2].ravel())
    assert frame["joint_angle_2"].tolist() == np.repeat(found.designs["joint_angle_2"], 2).tolist()
    assert frame.attrs["units"]["C1.bearing_force_up"] == "N"


def test_without_xarray(monkeypatch: pytest.MonkeyPatch) -> None:
    found = LINE.analyse(speed=0, torque=200, positions=0.0)
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(MissingExtraError, match="study"):
        found.to_xarray()


def random_forces(seed: int = 0, shape: tuple[int, ...] = (4, 5)) -> LineForces:
    rng = np.random.default_rng(seed)
    sizes = [(2, 3), (2, 3), (3, 3), (1, 3), (1, 3), (2, 3), (2,), (), ()]
    return LineForces(*(rng.uniform(-1, 1, (*shape, *size)) for size in sizes))


def test_components() -> None:
    found = random_forces()
    for side in ("in", "out"):
        moment = getattr(found, f"moment_{side}")
        torsion, bending = getattr(found, f"torsion_{side}"), getattr(found, f"bending_{side}")
        assert torsion**2 + bending**2 == pytest.approx(np.sum(moment**2, axis=-1))
    squares = found.bearing_axial**2 + found.bearing_radial**2
    assert squares == pytest.approx(np.sum(found.bearing_force**2, axis=-1))
    assert found.spline_friction.shape == found.spline_torque.shape == (4, 5, 1)
    squares = found.spline_torque**2 + found.spline_bending**2
    assert squares == pytest.approx(np.sum(found.spline_moment**2, axis=-1))
    assert found.centring**2 == pytest.approx(np.sum(found.centring_force**2, axis=-1))


def test_forces_are_linear() -> None:
    one, two = random_forces(0), random_forces(1)
    factor = np.random.default_rng(2).uniform(-1, 1, (4, 5))
    both = one.times(factor).plus(two)
    for name in LineForces._fields:
        first, second, found = (getattr(item, name) for item in (one, two, both))
        for index in np.ndindex(4, 5):
            assert found[index] == pytest.approx(factor[index] * first[index] + second[index])
