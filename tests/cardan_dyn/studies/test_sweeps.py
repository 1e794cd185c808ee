"""Sweeps as functions of studies: chunks of one call hold what single sweeps say."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn import studies
from cardan_dyn.practice.studies.chunking import chunk_shape

pytestmark = pytest.mark.usefixtures("loaded_once")

TURN = np.linspace(0.0, 2.0 * np.pi, 13)


def scene_of(name: str = "thoma_rig", **options: Any) -> cd.Scene:
    given = {"drive": "bearing_in", "held": {"joint_angle": 0.3}, "loads": {"bearing_out": -10.0}}
    return cd.Scene(cd.load(name), **{**given, **options})


def each(data: Any) -> Any:
    """Iterate over the cases of a dataset: their indices and parameters."""
    names = [str(name) for name in data.state.dims]
    for index in product(*(range(data.sizes[name]) for name in names)):
        place = dict(zip(names, index, strict=True))
        yield place, {name: float(data[name][place[name]]) for name in names}


@pytest.mark.slow
def test_all_that_a_sweep_broadcasts_goes_into_one_call() -> None:
    scene = scene_of()
    wanted = {"bending": "bearing_out.bending", "moment": ("bearing_out.moment", "max")}
    parameters = {
        "held.joint_angle": [0.1, 0.3],
        "loads.bearing_out": [-10.0, 20.0],
        "inertia.shaft_out": [1.0, 2.0],
        "gravity.z": [0.0, -9.81],
        "speed": [0.0, 100.0],
    }
    function = studies.Sweeps(scene, wanted, position=TURN, acceleration=3.0)
    study = cd.study(function, parameters, workers=1, chunk=32).run()
    assert study.failures.empty
    for place, case in each(study.dataset):
        swept = scene.sweep(
            TURN,
            case["speed"],
            3.0,
            held={"joint_angle": case["held.joint_angle"]},
            loads={"bearing_out": case["loads.bearing_out"]},
            inertia={"shaft_out": case["inertia.shaft_out"]},
            gravity=(0.0, 0.0, case["gravity.z"]),
        )
        found = study.dataset.isel(place)
        size = np.abs(swept["bearing_out"].moment).max()
        np.testing.assert_allclose(
            found.bending, swept["bearing_out"].bending, rtol=0.0, atol=1e-11 * size
        )
        moment = np.linalg.norm(swept["bearing_out"].moment, axis=-1).max()
        np.testing.assert_allclose(found.moment, moment, rtol=1e-10)


def made(angle: float, torque: float) -> cd.Scene:
    return scene_of(held={"joint_angle": angle}, loads={"bearing_out": torque})


def test_other_parameters_make_scenes(monkeypatch: pytest.MonkeyPatch) -> None:
    function = studies.Sweeps(made, {"effort": "drive_effort"}, position=TURN)
    axes = {"angle": [0.1, 0.2, 0.3], "speed": [0.0, 50.0], "torque": [-10.0, 5.0]}
    study = cd.study(function, axes, workers=1, chunk={"angle": 2, "speed": 2, "torque": 2})
    plan = study.plan()
    assert (
        "4 calls of sweep, which broadcasts speed; a scene is made for each angle, torque"
        in plan.how
    )
    data = study.run().dataset
    assert data.effort.dims == ("angle", "speed", "torque", "position")
    for place, case in each(data):
        expected = made(case["angle"], case["torque"]).sweep(TURN, case["speed"]).drive_effort
        np.testing.assert_allclose(
            data.effort.isel(place), expected, rtol=0.0, atol=1e-10 * np.abs(expected).max()
        )


def test_chunks_are_filled_along_what_one_call_takes() -> None:
    # A millisecond each, so that 1024 of 4000 cases are a chunk: all of the second dimension first.
    assert chunk_shape((10, 40, 10), 1e-3, 8) == (2, 40, 10)
    assert chunk_shape((10, 40, 10), 1e-3, 8, first=(1,)) == (2, 40, 10)
    assert chunk_shape((3, 40, 100), 1e-3, 8, first=(1,)) == (1, 40, 25)
    assert chunk_shape((10**6,), 1e-6, 8) == (2**18,)  # As many as are looked for a failure in.
    assert chunk_shape((10**6,), 1e-6, 10**6) == (32,)  # As much as is held at a time.
    assert chunk_shape((10, 10), 100.0, 8) == (1, 1)


@pytest.mark.slow
def test_responses_hold_what_sweeps_do() -> None:
    scene = scene_of()
    axes = {"held.joint_angle": [0.1, 0.2], "speed": [0.0, 30.0, 60.0]}
    by_sweeps, by_responses = (
        cd.study(
            studies.Sweeps(scene, "bearing_out.bending", position=TURN, response=response),
            axes,
            workers=1,
        )
        .run()
        .dataset["bearing_out.bending"]
        for response in (False, True)
    )
    assert by_responses.dims == by_sweeps.dims
    np.testing.assert_allclose(
        by_responses, by_sweeps, rtol=0.0, atol=1e-10 * float(np.abs(by_sweeps).max())
    )


@pytest.mark.slow
def test_positions_of_several_drives_are_parameters() -> None:
    legs = [f"leg_{index}" for index in range(1, 7)]
    robot = cd.Scene(cd.load("stewart_platform"), drive=legs, gravity=(0.0, 0.0, -9.81))
    lengths = {f"position.{leg}": ([0.0, 0.01 * index], "m") for index, leg in enumerate(legs)}
    function = studies.Sweeps(robot, ["leg_3.drive_effort", "leg_1.position"])
    study = cd.study(function, studies.points(lengths), workers=1).run()
    positions = np.stack([np.zeros(6), 0.01 * np.arange(6.0)])
    expected = robot.sweep(positions).drive_effort[:, 2]
    np.testing.assert_allclose(study.dataset["leg_3.drive_effort"], expected, rtol=1e-9)
    assert study.dataset["leg_3.drive_effort"].attrs["units"] == "N"
    assert study.dataset["leg_1.position"].attrs["units"] == "m"
    with pytest.raises(cd.CardanError, match="no column 'drive_effort'"):
        cd.study(studies.Sweeps(robot, "drive_effort"), studies.points(lengths), workers=1).plan()


@pytest.mark.slow
def test_a_long_sweep_is_computed_in_parts() -> None:
    scene = scene_of()
    line = studies.Line(0.0, 20.0, 5000)
    function = studies.Sweeps(scene, ["drive_effort", "pin_in.position"])
    study = cd.study(function, {"position": (line, "rad")}, workers=1, chunk=700).run()
    expected = scene.sweep(np.linspace(0.0, 20.0, 5000))
    np.testing.assert_allclose(study.dataset.drive_effort, expected.drive_effort, rtol=1e-10)
    moved = expected.motion.position("pin_in")
    np.testing.assert_allclose(study.dataset["pin_in.position"], moved, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize(
    ("arguments", "options", "said"),
    [
        ((3, "drive_effort"), {}, "expected a Scene"),
        ((scene_of, []), {}, "nothing is wanted"),
        ((scene_of, {"a": ("drive_effort", "maximum")}), {"position": TURN}, "none of greatest"),
        ((scene_of, {"a": ("drive_effort", "max")}), {}, "nothing to take the max over"),
        ((scene_of, {"a": 3}), {}, "expected a column or a pair"),
        ((scene_of, "drive_effort"), {"position": np.zeros((0,))}, "expected"),
    ],
)
def test_what_is_wanted_wrongly_is_said(arguments: Any, options: Any, said: str) -> None:
    with pytest.raises(cd.ArgumentError, match=said):
        studies.Sweeps(*arguments, **options)


def test_parameters_that_no_sweep_takes_are_refused() -> None:
    with pytest.raises(cd.ArgumentError, match="length: no argument of a sweep"):
        cd.study(studies.Sweeps(scene_of(), "drive_effort"), {"length": [1.0], "position": [0.0]})
    with pytest.raises(cd.CardanError, match="no position is given"):
        cd.study(studies.Sweeps(scene_of(), "drive_effort"), {"speed": [1.0]}, workers=1).plan()


@pytest.mark.parametrize(
    ("name", "unit", "taken"),
    [
        ("held.joint_angle", "deg", "rad"),
        ("held.joint_angle", "m", "rad"),
        ("speed", "rpm", "rad/s"),
        ("loads.bearing_out", "kN·m", "N·m"),
        ("inertia.cross", "kg·m²", "1"),
        ("gravity.z", "mm/s²", "m/s²"),
        ("time", "h", "s"),
    ],
)
def test_units_that_a_sweep_does_not_take_are_refused(name: str, unit: str, taken: str) -> None:
    function = studies.Sweeps(scene_of(), ["drive_effort"], position=TURN)
    with pytest.raises(cd.ArgumentError, match=f"{name} is in {unit}, .* takes it in {taken}: "):
        cd.study(function, {name: ([1.0, 2.0], unit)})
    cd.study(function, {name: ([1.0, 2.0], taken)})


def test_units_are_those_of_either_kind_of_joint_where_scenes_are_made() -> None:
    function = studies.Sweeps(lambda: scene_of(), ["drive_effort"], position=TURN)
    for unit in ("rad", "m", ""):
        cd.study(function, {"held.joint_angle": ([0.1], unit)})
    cd.study(function, {"loads.bearing_out": ([0.1], "Nm"), "gravity.z": ([0.1], "m/s^2")})
    with pytest.raises(cd.ArgumentError, match="rad or m"):
        cd.study(function, {"held.joint_angle": ([0.1], "°")})


def test_what_statics_leaves_open_is_marked() -> None:
    """In a plane loop, statics knows forces in the plane alone: three of each pin's components."""
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", gravity=(0.0, -9.81, 0.0))
    known = {"rocker_pin.force_x", "rocker_pin.shear", "rocker_pin.torsion", "drive_effort"}
    opened = {"rocker_pin.force", "rocker_pin.force_z", "rocker_pin.axial", "rocker_pin.bending"}
    wanted = studies.Sweeps(scene, sorted(known | opened))
    data = cd.study(wanted, {"position": [0.1, 0.2]}, workers=1).run().dataset
    marked = {name for name, item in data.data_vars.items() if "not_determined" in item.attrs}
    assert marked == opened
    assert data["rocker_pin.force"].attrs["not_determined"] == "chosen by least norm"
    label = "rocker_pin.force [N] *"
    assert studies.plot_scatter(data, "rocker_pin.force").axes[0].get_ylabel() == label
    assert studies.plot_scatter(data, "rocker_pin.shear").axes[0].get_ylabel()[-3:] == "[N]"


@pytest.mark.slow
def test_every_column_of_a_table_can_be_wanted() -> None:
    elements = [
        cd.Bushing("coupler", "base", (0.1, 0.0, 0.0), [3e3] * 3 + [5.0] * 3, name="rubber"),
        cd.PointSpring("crank", (0.05, 0.0, 0.0), "rocker", (0.1, 0.1, 0.0), 500.0),
    ]
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", elements=elements)
    positions = [0.1, 0.2, 0.5]
    columns = scene.sweep(positions, speed=3.0).table().columns()
    wanted = studies.Sweeps(scene, {f"found {name}": name for name in columns}, speed=3.0)
    data = cd.study(wanted, {"position": positions}, workers=1).run().dataset
    for name, (values, unit) in columns.items():
        found = data[f"found {name}"]
        np.testing.assert_allclose(found, values, rtol=1e-9, atol=1e-9, err_msg=name)
        assert found.attrs["units"] == unit
