"""Variables of tables: names, dimensions, units and values of all that a sweep holds."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.drive_lines import two_lines
from testkit.linkages import coupling, gears, slider_crank
from testkit.planar_linkages import five_bar
from testkit.scenes import universal

import cardan_dyn as cd
from cardan_dyn.core.results.table import Variable

pytestmark = pytest.mark.usefixtures("loaded_once")

POSITIONS = np.linspace(0.0, 1.0, 4)
RACK = """<robot name="rack"><link name="base"/><link name="pinion"/><link name="rack"/>
  <joint name="turn" type="continuous"><parent link="base"/><child link="pinion"/>
    <origin xyz="0 0.3 0"/><axis xyz="0 0 1"/></joint>
  <joint name="slide" type="prismatic"><parent link="base"/><child link="rack"/>
    <origin xyz="1 0 0"/><axis xyz="1 0 0"/></joint>
  <coupling name="teeth"><predecessor link="PREDECESSOR"/><successor link="SUCCESSOR"/>
    <ratio value="RATIO"/></coupling></robot>"""


def rack(predecessor: str, successor: str, ratio: float) -> cd.Mechanism:
    text = RACK.replace("PREDECESSOR", predecessor).replace("SUCCESSOR", successor)
    return cd.load(text.replace("RATIO", repr(ratio)))


def variables(sweep: cd.Sweep, motion: bool = True) -> dict[str, Variable]:
    named = sweep.table(motion=motion).variables
    assert len(dict(named)) == len(named)
    return dict(named)


def test_values_are_those_of_the_sweep(joint: cd.Mechanism) -> None:
    scene = universal(joint, 0.5, load=-2.0, gravity=(0.0, 0.0, -9.81))
    turn = scene.sweep(POSITIONS, speed=3.0, acceleration=POSITIONS)
    item = variables(turn)
    for index, name in enumerate(turn):
        for quantity in ("force", "moment"):
            np.testing.assert_array_equal(
                item[quantity].values[:, index], getattr(turn[name], quantity)
            )
        for quantity in ("torsion", "bending", "axial", "shear"):
            np.testing.assert_array_equal(
                item[quantity].values[:, index], getattr(turn[name], quantity)
            )
    moving = turn.table().labels["moving_joint"]
    assert set(moving) == set(joint.joint_names)
    for index, name in enumerate(moving):
        for quantity in ("position", "velocity", "acceleration"):
            expected = getattr(turn.motion, quantity)(name)
            np.testing.assert_array_equal(item[f"joint_{quantity}"].values[:, index], expected)
    for name in ("position", "speed", "acceleration", "drive_effort", "condition"):
        np.testing.assert_array_equal(item[name].values, getattr(turn, name))
    np.testing.assert_array_equal(
        item["holding_effort"].values[:, 0], turn.holding_effort["joint_angle"]
    )
    dims = {name: variable.dims for name, variable in item.items()}
    assert dims["force"] == dims["moment"] == ("sample", "joint", "component")
    assert dims["torsion"] == dims["shear"] == ("sample", "joint")
    assert dims["holding_effort"] == ("sample", "held")
    assert dims["joint_velocity"] == ("sample", "moving_joint")
    assert dims["condition"] == dims["drive_effort"] == ("sample",)
    coordinates = [name for name, variable in item.items() if variable.is_coordinate]
    assert coordinates == ["position", "speed", "acceleration"]


def test_units_of_a_rotating_drive(joint: cd.Mechanism) -> None:
    item = variables(universal(joint, 0.5).sweep(POSITIONS))
    units = {name: variable.unit for name, variable in item.items()}
    assert units == {
        **{"position": "rad", "speed": "rad/s", "acceleration": "rad/s²"},
        **{"force": "N", "axial": "N", "shear": "N", "force_magnitude": "N"},
        **{"moment": "N·m", "torsion": "N·m", "bending": "N·m", "moment_magnitude": "N·m"},
        **{"drive_effort": "N·m", "holding_effort": "N·m", "condition": "1"},
        **{"joint_position": "rad", "joint_velocity": "rad/s", "joint_acceleration": "rad/s²"},
    }


def test_units_of_a_sliding_drive() -> None:
    """The slide of a slider-crank is driven; the angle of its crank stands beside it."""
    mechanism = cd.load(slider_crank(None))
    turn = cd.Scene(mechanism, drive="d", loads={"a": [1.0, 2.0]}).sweep([0.0, 0.01])
    item = variables(turn)
    rates = [item[name].unit for name in ("position", "speed", "acceleration")]
    assert rates == ["m", "m/s", "m/s²"]
    assert item["drive_effort"].unit == "N"
    assert item["load_a"].unit == "N·m"
    joints = turn.table().labels["moving_joint"]
    expected = tuple("m" if name == "d" else "rad" for name in joints)
    assert item["joint_position"].units == expected
    assert item["joint_acceleration"].units == tuple(f"{unit}/s²" for unit in expected)
    assert item["joint_position"].unit == "rad or m"
    assert turn.table().units["unit"][1] == list(expected)


def test_several_drives_have_a_dimension() -> None:
    loads = {"D": -2.0, "A": -5.0}
    positions = np.array([[0.0, 0.1], [0.2, 0.0], [0.1, 0.3]])
    turn = cd.Scene(five_bar(), drive=["D", "A"], loads=loads).sweep(positions, speed=[1.0, 2.0])
    item = variables(turn)
    for name in ("position", "speed", "acceleration", "drive_effort"):
        assert item[name].dims == ("sample", "drive")
    np.testing.assert_array_equal(item["position"].values, positions)
    np.testing.assert_array_equal(item["speed"].values, np.tile([1.0, 2.0], (3, 1)))
    assert turn.table().labels["drive"] == ("D", "A")
    assert item["position"].long_name == "position of the drive"


def test_drives_of_both_kinds_have_a_unit_each() -> None:
    text = RACK[: RACK.index("<coupling")] + "</robot>"
    turn = cd.Scene(cd.load(text), drive=["slide", "turn"]).sweep(np.zeros((2, 2)))
    item = variables(turn)
    assert item["position"].units == ("m", "rad")
    assert item["speed"].units == ("m/s", "rad/s")
    assert item["drive_effort"].units == ("N", "N·m")
    assert item["drive_effort"].unit == "N or N·m"
    assert turn.table().units["drive_unit"] == ("drive", ["N", "N·m"])


@pytest.mark.parametrize(
    ("predecessor", "successor", "ratio", "drive", "unit"),
    [("pinion", "rack", 0.3, "turn", "N"), ("rack", "pinion", 1.0 / 0.3, "slide", "N·m")],
)
def test_a_coupling_has_the_unit_of_its_successor(
    predecessor: str, successor: str, ratio: float, drive: str, unit: str
) -> None:
    load = {"turn": ("slide", -2.0), "slide": ("turn", -0.6)}[drive]
    scene = cd.Scene(rack(predecessor, successor, ratio), drive=drive, loads=dict([load]))
    turn = scene.sweep([0.0, 0.1])
    item = variables(turn)["coupling_moment"]
    assert item.dims == ("sample", "coupling")
    assert item.unit == unit
    # It holds the load on its successor: 2 N on the rack, or 0.6 N·m on the pinion.
    np.testing.assert_allclose(item.values, [[-load[1]]] * 2, rtol=1e-13)
    assert turn.table().units["coupling_unit"] == ("coupling", [unit])


def test_a_coupling_whose_successor_carries_its_predecessor() -> None:
    text = gears(coupling("mesh", "a", "b", 2.0)).replace(
        '<joint name="b" type="continuous"><parent link="ground"/>',
        '<joint name="b" type="continuous"><parent link="wheel_a"/>',
    )
    text = text.replace('<predecessor link="wheel_a"/><successor link="wheel_b"/>', "ENDS")
    text = text.replace("ENDS", '<predecessor link="wheel_b"/><successor link="wheel_a"/>')
    turn = cd.Scene(cd.load(text), drive="a", loads={"b": -3.0}).sweep([0.0])
    item = variables(turn)["coupling_moment"]
    assert item.unit == "N·m"
    assert list(turn.motion.velocity("b")) == [0.0]


def test_loads_and_gravity_that_vary_are_coordinates(joint: cd.Mechanism) -> None:
    force = np.arange(12.0).reshape(4, 3)
    loads = {
        "bearing_out": POSITIONS - 3.0,
        "shaft_out": cd.Wrench(force=force, moment=(1.0, 2.0, 3.0), frame="world"),
    }
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.5}, loads=loads)
    item = variables(scene.sweep(POSITIONS))
    assert item["load_bearing_out"].is_coordinate
    np.testing.assert_array_equal(item["load_bearing_out"].values, POSITIONS - 3.0)
    assert item["load_shaft_out_force"].dims == ("sample", "component")
    assert item["load_shaft_out_force"].unit == "N"
    assert item["load_shaft_out_force"].long_name == "force on link shaft_out, in world axes"
    np.testing.assert_array_equal(item["load_shaft_out_force"].values, force)
    # What holds for all samples is an attribute of the table.
    assert "load_shaft_out_moment" not in item
    assert "gravity" not in item


def test_grids_give_each_coordinate_the_dimensions_along_which_it_varies(
    joint: cd.Mechanism,
) -> None:
    response = universal(joint, 0.5, gravity=(0.0, 0.0, -9.81)).response()
    load, speed = np.array([[[1.0]], [[2.0]], [[3.0]]]), np.array([[4.0], [5.0]])
    pull = np.arange(9.0).reshape(3, 1, 1, 3)
    grid = response.sweep(POSITIONS, speed, loads={"bearing_out": load}, gravity=pull)
    item = variables(grid)
    dims = {name: item[name].dims for name in item}
    assert tuple(grid.table().samples) == ("sample_0", "sample_1", "sample_2")
    assert dims["position"] == ("sample_2",)
    assert dims["speed"] == ("sample_1",)
    assert dims["acceleration"] == dims["condition"] == ()
    assert dims["load_bearing_out"] == ("sample_0",)
    assert dims["gravity"] == ("sample_0", "component")
    assert item["gravity"].unit == "m/s²"
    np.testing.assert_array_equal(item["gravity"].values, np.arange(9.0).reshape(3, 3))
    np.testing.assert_array_equal(item["speed"].values, [4.0, 5.0])
    assert item["torsion"].values.shape == item["joint_velocity"].values.shape == (3, 2, 4, 5)
    # The motion is that of the positions and speeds of its samples.
    crank = grid.table().labels["moving_joint"].index("bearing_in")
    expected = np.broadcast_to(speed, (3, 2, 4))
    np.testing.assert_allclose(item["joint_velocity"].values[..., crank], expected, rtol=1e-14)


def test_what_is_given_to_a_grid_has_the_dimensions_along_which_it_varies(
    joint: cd.Mechanism,
) -> None:
    angle, factor = np.array([[0.1], [0.5], [0.9]]), np.array([1.0, 2.0, 3.0, 4.0])
    forces, moments = np.arange(9.0).reshape(3, 1, 3), np.arange(12.0).reshape(4, 3)
    scene = universal(joint, 0.5, load=-2.0, gravity=(0.0, 0.0, -9.81))
    sweep = scene.sweep(
        POSITIONS,
        held={"joint_angle": angle},
        loads={"bearing_out": POSITIONS, "cross": cd.Wrench(forces, moments)},
        inertia={"cross": factor, "shaft_in": 2.0},
    )
    item = variables(sweep)
    for name, dims, unit, values in (
        ("held_joint_angle", ("sample_0",), "rad", angle[:, 0]),
        ("inertia_cross", ("sample_1",), "1", factor),
        ("inertia_shaft_in", (), "1", 2.0),
        ("load_bearing_out", ("sample_1",), "N·m", POSITIONS),
        ("load_cross_force", ("sample_0", "component"), "N", forces[:, 0]),
        ("load_cross_moment", ("sample_1", "component"), "N·m", moments),
    ):
        assert item[name].is_coordinate
        assert (item[name].dims, item[name].unit) == (dims, unit)
        np.testing.assert_array_equal(item[name].values, values)
    assert item["held_joint_angle"].long_name == "position at which joint_angle is held"
    assert item["inertia_cross"].long_name == "factor on mass and inertia of link cross"
    assert "gravity" not in item
    samples = ("sample_0", "sample_1")
    assert item["force"].dims == (*samples, "joint", "component")
    assert item["condition"].dims == item["drive_effort"].dims == samples
    for index, name in enumerate(sweep.table().labels["moving_joint"]):
        values = item["joint_position"].values[..., index]
        np.testing.assert_array_equal(values, sweep.motion.position(name))


def test_flat_sweeps_of_a_response_have_all_coordinates_along_their_samples(
    joint: cd.Mechanism,
) -> None:
    response = universal(joint, 0.5, gravity=(0.0, 0.0, -9.81)).response()
    turn = response.sweep(POSITIONS, 2.0, loads={"bearing_out": [-3.0]}, gravity=[[1.0, 2.0, 3.0]])
    item = variables(turn)
    for name, value in (("speed", 2.0), ("acceleration", 0.0), ("load_bearing_out", -3.0)):
        assert item[name].dims == ("sample",)
        np.testing.assert_array_equal(item[name].values, np.full(4, value))
    np.testing.assert_array_equal(item["gravity"].values, np.tile([1.0, 2.0, 3.0], (4, 1)))
    assert item["condition"].dims == ()


def test_what_outputs_leave_out_is_missing_or_nan() -> None:
    lines = cd.load(two_lines(2))
    turn = cd.Scene(lines, drive="bearing_0", outputs=["left_2"]).sweep(POSITIONS)
    item = variables(turn)
    assert "drive_effort" not in item
    assert "holding_effort" not in item
    joints = turn.table().labels["moving_joint"]
    for quantity in ("position", "velocity", "acceleration"):
        is_nan = np.all(np.isnan(item[f"joint_{quantity}"].values), axis=0)
        left_out = [name.startswith("right_") for name in joints]
        np.testing.assert_array_equal(is_nan, left_out)
    assert turn.table().labels["joint"] == ("left_2",)


def test_efforts_alone_have_no_wrenches(joint: cd.Mechanism) -> None:
    item = variables(universal(joint, 0.5, outputs=[]).sweep(POSITIONS), motion=False)
    assert list(item) == ["position", "speed", "acceleration", "drive_effort", "condition"]


def test_joints_with_several_coordinates_have_no_column_of_motion() -> None:
    mechanism = cd.load("stewart_platform")
    legs = [f"leg_{index}" for index in range(1, 7)]
    turn = cd.Scene(mechanism, drive=legs, outputs=[]).sweep(np.zeros((1, 6)))
    moving = turn.table().labels["moving_joint"]
    assert moving == tuple(name for name, item in mechanism.joints.items() if item.nv == 1)
    assert set(moving) < set(mechanism.joint_names)
