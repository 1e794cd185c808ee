"""Datasets and data frames: layout, units, attributes, files, and what outputs leave out."""

from __future__ import annotations

import csv
import io
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pytest
import xarray
from testkit.drive_lines import two_lines
from testkit.linkages import coupling, gears
from testkit.planar_linkages import described, five_bar, link
from testkit.planar_linkages import joint as hinge
from testkit.scenes import universal

import cardan_dyn as cd

pytestmark = pytest.mark.usefixtures("loaded_once")

POSITIONS = np.linspace(0.0, 1.0, 4)
FORCE = np.arange(12.0).reshape(4, 3)
QUANTITIES = ("force", "moment", "torsion", "bending", "axial", "shear")


@pytest.fixture(scope="module")
def turn(joint: cd.Mechanism) -> cd.Sweep:
    loads = {
        "bearing_out": POSITIONS - 3.0,
        "shaft_out": cd.Wrench(force=FORCE, moment=(1.0, 2.0, 3.0), frame="world"),
        "pin_in": 0.25,
    }
    return cd.Scene(
        joint,
        drive="bearing_in",
        held={"joint_angle": 0.5},
        loads=loads,
        gravity=(0.0, 0.0, -9.81),
        outputs=["bearing_out", "joint_angle", "bearing_in"],
    ).sweep(POSITIONS, speed=3.0)


@pytest.fixture(scope="module")
def grid(joint: cd.Mechanism) -> cd.Sweep:
    response = universal(joint, 0.5, gravity=(0.0, 0.0, -9.81), outputs=["bearing_out"]).response()
    load = np.array([[[1.0]], [[2.0]], [[3.0]]])
    return response.sweep(POSITIONS, np.array([[4.0], [5.0]]), loads={"bearing_out": load})


@pytest.fixture(scope="module")
def five() -> cd.Sweep:
    positions = np.array([[0.0, 0.1], [0.2, 0.0], [0.1, 0.3]])
    scene = cd.Scene(five_bar(), drive=["D", "A"], loads={"D": -2.0, "A": -5.0})
    return scene.sweep(positions, speed=[1.0, 2.0])


def test_a_dataset_holds_wrenches_by_joint_and_component(turn: cd.Sweep) -> None:
    data = turn.to_xarray()
    assert data.force.dims == ("sample", "joint", "component")
    assert list(data.joint.values) == list(turn)
    for name in turn:
        for quantity in QUANTITIES:
            expected = getattr(turn[name], quantity)
            np.testing.assert_array_equal(data[quantity].sel(joint=name), expected)
        flags = data.unique.sel(joint=name)
        np.testing.assert_array_equal(flags, turn[name].unique)
    y = data.moment.sel(joint="bearing_out", component="y")
    np.testing.assert_array_equal(y, turn["bearing_out"].moment[:, 1])
    assert list(data.wrench_component.values)[1:4] == ["force y", "force z", "moment x"]
    np.testing.assert_array_equal(
        data.holding_effort.sel(held="joint_angle"), turn.holding_effort["joint_angle"]
    )
    angle = data.joint_position.sel(moving_joint="pin_in")
    np.testing.assert_array_equal(angle, turn.motion.position("pin_in"))


def test_every_variable_of_a_dataset_has_units_and_a_name(
    turn: cd.Sweep, grid: cd.Sweep, five: cd.Sweep
) -> None:
    for sweep in (turn, grid, five):
        data = sweep.to_xarray()
        for name in data.data_vars:
            assert data[name].attrs["units"], name
            assert data[name].attrs["long_name"], name
        for name in ("position", "speed", "acceleration"):
            assert name in data.coords
            assert data[name].attrs["units"].startswith("rad")


def test_coordinates_of_a_dataset_are_what_was_given(turn: cd.Sweep) -> None:
    data = turn.to_xarray()
    np.testing.assert_array_equal(data.coords["position"], POSITIONS)
    np.testing.assert_array_equal(data.coords["load_bearing_out"], POSITIONS - 3.0)
    np.testing.assert_array_equal(data.coords["load_shaft_out_force"], FORCE)
    assert list(data.held_unit.values) == ["N·m"]
    assert "drive_unit" not in data.coords
    assert "coupling_unit" not in data.coords
    assert set(data.unit.values) == {"rad"}


def test_attributes_are_numbers_and_texts(turn: cd.Sweep, grid: cd.Sweep) -> None:
    for table in (turn.to_xarray(), turn.to_dataframe()):
        attributes = table.attrs
        assert attributes["mechanism"] == "universal_joint"
        assert attributes["drives"] == "bearing_in"
        assert json.loads(attributes["held"]) == {"joint_angle": 0.5}
        assert json.loads(attributes["loads"]) == {
            "bearing_out": "see coordinate load_bearing_out",
            "pin_in": 0.25,
            "shaft_out": {
                "force": "see coordinate load_shaft_out_force",
                "moment": [1.0, 2.0, 3.0],
                "frame": "world",
                "point": [0.0, 0.0, 0.0],
            },
        }
        assert attributes["gravity"] == [0.0, 0.0, -9.81]
        for name in ("loop_residual", "balance_residual", "power_residual", "rate_residual"):
            assert attributes[name] == getattr(turn, name)
            assert type(attributes[name]) is float
        assert attributes["unproven"] == ", ".join(turn.unproven)
        assert attributes["cardan_dyn_version"] == cd.__version__
    assert json.loads(grid.to_xarray().attrs["loads"]) == {
        "bearing_out": "see coordinate load_bearing_out"
    }


def test_held_positions_that_vary_are_a_coordinate(joint: cd.Mechanism) -> None:
    angles = np.linspace(0.1, 0.9, 4)
    scene = universal(joint, 0.5, outputs=["bearing_out"])
    sweep = scene.sweep(POSITIONS, held={"joint_angle": angles}, inertia={"cross": angles})
    data, frame = sweep.to_xarray(), sweep.to_dataframe()
    for table in (data, frame):
        held = {"joint_angle": "see coordinate held_joint_angle"}
        assert json.loads(table.attrs["held"]) == held
    np.testing.assert_array_equal(data.held_joint_angle, angles)
    np.testing.assert_array_equal(frame["held_joint_angle"], angles)
    np.testing.assert_array_equal(frame["inertia_cross"], angles)
    assert frame.attrs["units"]["held_joint_angle"] == "rad"
    single = scene.sweep(POSITIONS, held={"joint_angle": 0.2}).to_xarray()
    assert json.loads(single.attrs["held"]) == {"joint_angle": 0.2}


def test_gravity_that_varies_is_a_coordinate(joint: cd.Mechanism) -> None:
    response = universal(joint, 0.5, gravity=(0.0, 0.0, -9.81), outputs=["bearing_out"]).response()
    pull = np.arange(12.0).reshape(4, 3)
    turn = response.sweep(POSITIONS, gravity=pull)
    data, frame = turn.to_xarray(motion=False), turn.to_dataframe(motion=False)
    assert data.attrs["gravity"] == frame.attrs["gravity"] == "see coordinate gravity"
    np.testing.assert_array_equal(data.gravity.transpose("sample", "component"), pull)
    np.testing.assert_array_equal(frame[["gravity_x", "gravity_y", "gravity_z"]], pull)
    assert frame.attrs["units"]["gravity_y"] == "m/s²"


def test_several_drives_have_a_dimension(five: cd.Sweep) -> None:
    data = five.to_xarray()
    assert list(data.drive.values) == ["D", "A"]
    assert list(data.drive_unit.values) == ["N·m", "N·m"]
    np.testing.assert_array_equal(data.drive_effort.sel(drive="A"), five.drive_effort[:, 1])
    frame = five.to_dataframe()
    for index, name in enumerate(("D", "A")):
        for quantity in ("position", "speed", "acceleration", "effort"):
            values = getattr(five, "drive_effort" if quantity == "effort" else quantity)
            np.testing.assert_array_equal(frame[f"{name}.drive_{quantity}"], values[:, index])
    # The joint's own position stands beside the drive's.
    np.testing.assert_allclose(frame["D.position"], frame["D.drive_position"], rtol=1e-14)
    assert "position" not in frame
    assert "drive_effort" not in frame
    assert frame.attrs["drives"] == "D, A"


def test_a_frame_has_a_column_per_value(turn: cd.Sweep) -> None:
    frame = turn.to_dataframe()
    assert frame.shape[0] == 4
    assert frame.index.name == "sample"
    for name in turn:
        wrench = turn[name]
        for quantity in ("force", "moment"):
            for index, axis in enumerate("xyz"):
                expected = getattr(wrench, quantity)[:, index]
                np.testing.assert_array_equal(frame[f"{name}.{quantity}_{axis}"], expected)
        for quantity in ("torsion", "bending", "axial", "shear"):
            np.testing.assert_array_equal(frame[f"{name}.{quantity}"], getattr(wrench, quantity))
    for name in ("position", "speed", "acceleration", "drive_effort", "condition"):
        np.testing.assert_array_equal(frame[name], getattr(turn, name))
    np.testing.assert_array_equal(frame["load_bearing_out"], POSITIONS - 3.0)
    np.testing.assert_array_equal(frame["load_shaft_out_force_y"], FORCE[:, 1])
    holding = turn.holding_effort["joint_angle"]
    np.testing.assert_array_equal(frame["joint_angle.holding_effort"], holding)
    for quantity in ("position", "velocity", "acceleration"):
        expected = getattr(turn.motion, quantity)("pin_out")
        np.testing.assert_array_equal(frame[f"pin_out.{quantity}"], expected)
    assert list(frame.filter(like=".bending")) == [f"{name}.bending" for name in turn]


def test_units_of_columns(turn: cd.Sweep) -> None:
    frame = turn.to_dataframe()
    units = frame.attrs["units"]
    assert list(units) == list(frame.columns)
    for column, unit in units.items():
        quantity = column.split(".")[-1]
        rotation = {"position": "rad", "velocity": "rad/s", "speed": "rad/s"}
        if quantity in rotation:
            assert unit == rotation[quantity]
        elif quantity == "acceleration":
            assert unit == "rad/s²"
        elif quantity == "condition":
            assert unit == "1"
        else:
            is_force = "force" in quantity or quantity in ("axial", "shear")
            assert unit == ("N" if is_force else "N·m"), column
    assert frame.attrs["unique"] == {name: turn[name].unique.tolist() for name in turn}


def test_units_of_columns_of_both_kinds() -> None:
    """Two drives, of which one turns and one slides."""
    chain = cd.load(
        '<robot name="r"><link name="base"/><link name="a"/><link name="b"/>'
        '<joint name="turn" type="continuous"><parent link="base"/><child link="a"/>'
        '<axis xyz="0 0 1"/></joint><joint name="slide" type="prismatic"><parent link="a"/>'
        '<child link="b"/><axis xyz="1 0 0"/></joint></robot>'
    )
    turn = cd.Scene(chain, drive=["slide", "turn"]).sweep([[0.1, 0.2]])
    units = turn.to_dataframe().attrs["units"]
    assert [units[f"slide.drive_{name}"] for name in ("position", "speed")] == ["m", "m/s"]
    assert [units[f"turn.drive_{name}"] for name in ("position", "speed")] == ["rad", "rad/s"]
    assert (units["slide.drive_effort"], units["turn.drive_effort"]) == ("N", "N·m")
    assert (units["slide.acceleration"], units["turn.acceleration"]) == ("m/s²", "rad/s²")
    data = turn.to_xarray()
    assert data.position.attrs["units"] == "m or rad"
    assert list(data.drive_unit.values) == ["N", "N·m"]
    assert data.unit.sel(moving_joint="slide") == "m"


def test_grids_have_a_dimension_each(grid: cd.Sweep) -> None:
    data = grid.to_xarray()
    assert data.sizes["sample_0"] == 3
    assert data.force.dims[:3] == ("sample_0", "sample_1", "sample_2")
    assert data.position.dims == ("sample_2",)
    assert data.load_bearing_out.dims == ("sample_0",)
    picked = data.torsion.isel(sample_0=2, sample_1=1, sample_2=3).sel(joint="bearing_out")
    assert picked == grid["bearing_out"].torsion[2, 1, 3]
    assert data.condition.dims == ()
    assert data.condition == grid.condition[0]


def test_frames_of_grids_have_a_row_per_operating_point(grid: cd.Sweep) -> None:
    frame = grid.to_dataframe()
    assert frame.index.names == ["sample_0", "sample_1", "sample_2"]
    assert len(frame) == 24
    for i, j, k in np.ndindex(3, 2, 4):
        row = frame.loc[(i, j, k)]
        assert row["position"] == POSITIONS[k]
        assert row["speed"] == [4.0, 5.0][j]
        assert row["load_bearing_out"] == [1.0, 2.0, 3.0][i]
        assert row["bearing_out.bending"] == grid["bearing_out"].bending[i, j, k]
        assert row["drive_effort"] == grid.drive_effort[i, j, k]
        assert row["bearing_in.velocity"] == pytest.approx([4.0, 5.0][j], rel=1e-14)
        assert row["condition"] == grid.condition[0]


def test_rows_of_a_grid_are_those_of_a_sweep(grid: cd.Sweep, joint: cd.Mechanism) -> None:
    """A row of the response's table against the direct solution of its operating point."""
    row = grid.to_dataframe().loc[(2, 1, 3)]
    scene = universal(joint, 0.5, load=3.0, gravity=(0.0, 0.0, -9.81), outputs=["bearing_out"])
    direct = scene.sweep([row["position"]], speed=[row["speed"]])["bearing_out"]
    expected = [*direct.force[0], *direct.moment[0]]
    columns = [f"bearing_out.{name}_{axis}" for name in ("force", "moment") for axis in "xyz"]
    np.testing.assert_allclose(row[columns], expected, atol=1e-10)


@pytest.mark.parametrize("motion", [False, True])
def test_the_motion_can_be_left_out(turn: cd.Sweep, motion: bool) -> None:
    assert ("joint_position" in turn.to_xarray(motion=motion)) == motion
    assert ("moving_joint" in turn.to_xarray(motion=motion).dims) == motion
    assert ("pin_in.velocity" in turn.to_dataframe(motion=motion)) == motion


def test_what_outputs_leave_out_is_missing_or_nan() -> None:
    lines = cd.load(two_lines(2))
    turn = cd.Scene(lines, drive="bearing_0", outputs=["left_2"]).sweep(POSITIONS, speed=1.0)
    data, frame = turn.to_xarray(), turn.to_dataframe()
    assert "drive_effort" not in data
    assert "drive_effort" not in frame
    assert list(data.joint.values) == ["left_2"]
    for quantity in ("position", "velocity", "acceleration"):
        right = data[f"joint_{quantity}"].sel(moving_joint="right_2")
        assert np.all(np.isnan(right))
        assert np.all(np.isfinite(data[f"joint_{quantity}"].sel(moving_joint="left_2")))
        assert frame[f"right_2.{quantity}"].isna().all()
        assert frame[f"left_2.{quantity}"].notna().all()
    assert not frame.filter(like="right_2.force").columns.size
    assert data.attrs["unproven"] == ", ".join(turn.unproven) != ""


def test_efforts_alone_make_tables_without_wrenches(joint: cd.Mechanism) -> None:
    turn = universal(joint, 0.5, outputs=[]).sweep(POSITIONS)
    data = turn.to_xarray(motion=False)
    assert set(data.data_vars) == {"drive_effort", "condition"}
    assert "joint" not in data.dims
    assert np.isnan(data.attrs["balance_residual"])
    columns = ["position", "speed", "acceleration", "drive_effort", "condition"]
    assert list(turn.to_dataframe(motion=False)) == columns


def test_couplings_have_a_dimension() -> None:
    train = coupling("ab", "a", "b", -2.0), coupling("bc", "b", "c", -3.0)
    mechanism = cd.load(gears(*train, coupling("ca", "c", "a", 1.0 / 6.0), third=True))
    turn = cd.Scene(mechanism, drive="a", loads={"c": -4.0}).sweep(POSITIONS)
    data, frame = turn.to_xarray(), turn.to_dataframe()
    assert list(data.coupling.values) == ["ab", "bc", "ca"]
    assert list(data.coupling_unit.values) == ["N·m"] * 3
    assert not np.any(data.coupling_unique)
    for name in ("ab", "bc", "ca"):
        np.testing.assert_array_equal(
            data.coupling_moment.sel(coupling=name), turn.coupling_moment[name]
        )
        np.testing.assert_array_equal(frame[f"{name}.coupling_moment"], turn.coupling_moment[name])
    assert frame.attrs["coupling_unique"] == {"ab": False, "bc": False, "ca": False}


def test_tables_may_be_written_to_and_change_no_sweep(joint: cd.Mechanism) -> None:
    turn = universal(joint, 0.5).sweep(POSITIONS)
    before = turn["bearing_out"].force.copy(), turn.unique.copy()
    data, frame = turn.to_xarray(), turn.to_dataframe()
    data.force[:], data.unique[:], data.position[:] = 7.0, False, 7.0
    frame.loc[:, :] = 7.0
    frame.attrs["unique"]["bearing_out"][0] = None
    np.testing.assert_array_equal(turn["bearing_out"].force, before[0])
    np.testing.assert_array_equal(turn.unique, before[1])
    np.testing.assert_array_equal(turn.position, POSITIONS)


@pytest.mark.parametrize("name", ["turn", "grid", "five"])
def test_datasets_come_back_from_netcdf(
    name: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    """SciPy writes netCDF; numbers, texts, flags and attributes come back as they were."""
    data = request.getfixturevalue(name).to_xarray()
    data.to_netcdf(tmp_path / "sweep.nc", engine="scipy")
    again = xarray.load_dataset(tmp_path / "sweep.nc", engine="scipy")
    xarray.testing.assert_identical(again, data)
    assert again.unique.dtype == bool
    assert list(again.unit.values) == list(data.unit.values)
    assert again.attrs["held"] == data.attrs["held"]


def read_exactly(file: Any, like: pandas.DataFrame) -> pandas.DataFrame:
    """Read columns as texts, since readers of numbers of older pandas round; the index is first."""
    read = pandas.read_csv(file, dtype=str)
    for name, kind in zip(read.columns, [like.index.dtype, *like.dtypes], strict=True):
        column = read[name] == "True" if kind.kind == "b" else read[name].astype(kind)
        read[name] = column
    return read


def test_half_a_text_file_does_not_stay(
    turn: cd.Sweep, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Interrupted:
        def __init__(self, file: Any, **_: Any) -> None:
            self.file = file

        def writerow(self, row: list[str]) -> None:
            self.file.write(",".join(row))

        def writerows(self, _: Any) -> None:
            self.file.write("0,0.0")
            raise KeyboardInterrupt

    monkeypatch.setattr(csv, "writer", Interrupted)
    with pytest.raises(KeyboardInterrupt):
        turn.save(tmp_path / "turn.csv")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("shape", [(5,), (4, 3)])
def test_text_files_are_what_pandas_would_write(
    turn: cd.Sweep, tmp_path: Path, shape: tuple[int, ...]
) -> None:
    """To the byte: numbers by the fewest digits that say them, nothing for what is missing."""
    scene = cd.Scene(turn.mechanism, drive=turn.coordinates, held=dict.fromkeys(turn.held, 0.3))
    swept = scene.sweep(np.linspace(0.1, 2.0, int(np.prod(shape))).reshape(shape), speed=3.0)
    frame, path = swept.to_dataframe(), swept.save(tmp_path / "turn.csv")
    units = frame.attrs["units"]
    shown = {name: f"{name} [{units[name]}]" if units[name] else name for name in frame}
    expected = frame.rename(columns=shown).to_csv(lineterminator="\n")
    assert path.read_text(encoding="utf-8") == expected


def test_frames_come_back_from_text_files(turn: cd.Sweep) -> None:
    frame = turn.to_dataframe()
    text = frame.to_csv()
    again = read_exactly(io.StringIO(text), frame).set_index("sample")
    pandas.testing.assert_frame_equal(again, frame, check_index_type=False, check_exact=True)
    # Attributes go through any format that keeps JSON.
    assert json.loads(json.dumps(frame.attrs)) == frame.attrs


@pytest.mark.parametrize("package", ["xarray", "pandas"])
def test_a_missing_package_is_named(
    turn: cd.Sweep, package: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    method = {"xarray": turn.to_xarray, "pandas": turn.to_dataframe}[package]
    with pytest.raises(cd.MissingExtraError, match=rf"needs {package}: pip install .*\[study\]"):
        method()


def test_loads_of_the_same_name_are_refused() -> None:
    """Link `a` with a wrench and joint `a_force` with an effort would both be `load_a_force`."""
    mechanism = described(
        *(link(name) for name in "ab"), hinge("A", "ground", "a"), hinge("a_force", "a", "b")
    )
    loads = {"a": np.ones((2, 6)), "a_force": [5.0, 6.0]}
    turn = cd.Scene(mechanism, drive=["A", "a_force"], loads=loads).sweep([[0.0, 0.0], [0.1, 0.1]])
    with pytest.raises(cd.ModelError, match="two variables of the name load_a_force"):
        turn.to_xarray()


def test_files_give_back_what_was_saved(turn: cd.Sweep, tmp_path: Path) -> None:
    frame = turn.to_dataframe()
    read = read_exactly(turn.save(tmp_path / "turn.csv"), frame).iloc[:, 1:]
    assert "bearing_out.bending [N·m]" in read
    assert len(read.columns) == len(frame.columns)
    np.testing.assert_array_equal(read.to_numpy(), frame.to_numpy())
    told = json.loads(turn.save(tmp_path / "turn.json").read_text(encoding="utf-8"))
    assert told["columns"]["bearing_out.bending"] == frame["bearing_out.bending"].tolist()
    assert told["units"]["drive_effort"] == "N·m"
    with xarray.open_dataset(turn.save(str(tmp_path / "turn.nc")), engine="scipy") as data:
        np.testing.assert_array_equal(data.moment, turn.to_xarray().moment)
        assert data.moment.attrs["units"] == "N·m"
        assert data.attrs["balance_residual"] == turn.balance_residual
    with pytest.raises(cd.ArgumentError, match=r"its suffix says what is written: .*\.csv"):
        turn.save(tmp_path / "turn.xlsx")
