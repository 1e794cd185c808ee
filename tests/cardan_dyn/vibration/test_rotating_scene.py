"""Scenes that rotate, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from testkit import elastic_rigs

import cardan_dyn as cd
from cardan_dyn import ArgumentError, MobilityError, ModelError, VibrationError, vibration
from cardan_dyn.motion.vibration.model.rotating_scene import rotating_scene, speeds_of

LINE = elastic_rigs.torsional_line()


@pytest.fixture(scope="module")
def line() -> cd.Scene:
    return elastic_rigs.scene(LINE, 0.3)


def test_the_period_is_a_revolution(line: cd.Scene) -> None:
    rotating = rotating_scene(line)
    assert (rotating.drive, rotating.free) == ("bearing_in", ("twist_in",))
    assert rotating.period == 2.0 * np.pi
    assert rotating.units.tolist() == [1.0]
    assert rotating.damping == []


def test_units_of_slides_are_characteristic_lengths() -> None:
    rig = cd.load(elastic_rigs.sliding_rotor())
    scene = cd.Scene(rig, drive="turn", free=["y", "yaw"], held={"x": 0.0, "z": 0.0})
    assert rig.characteristic_length not in (1.0, 2.0)
    assert rotating_scene(scene).units.tolist() == [rig.characteristic_length, 1.0]


@pytest.mark.parametrize(
    ("element", "is_damped"),
    [
        (cd.JointSpring("twist_in", 1.0, damping=0.1), True),
        (cd.PointSpring("base", (0, 1, 0), "shaft_in", (0, 1, 1), 1.0, damping=0.1), True),
        (cd.Bushing("base", "shaft_in", (0, 0, 0), [1.0] * 6, [0, 0, 0, 0.1, 0, 0]), True),
        (cd.PointSpring("base", (0, 1, 0), "shaft_in", (0, 1, 1), 1.0), False),
        (cd.Bushing("base", "shaft_in", (0, 0, 0), [1.0] * 6), False),
        (cd.Actuator("twist_in", 2.0), False),
    ],
)
def test_what_damps(line: cd.Scene, element: Any, is_damped: bool) -> None:
    with_it = line.replace(elements=[*line.elements, element])
    assert rotating_scene(with_it).damping == ([element] if is_damped else [])


def test_start_is_where_the_scene_starts(line: cd.Scene) -> None:
    moved = rotating_scene(line.replace(near={"bearing_in": 0.0, "twist_in": 0.2}))
    assert moved.start == pytest.approx([0.0, 0.2], abs=1e-12)


def test_nothing_free_is_refused() -> None:
    scene = cd.Scene(cd.load("universal_joint"), drive="bearing_in", held={"joint_angle": 0.3})
    with pytest.raises(MobilityError, match="nothing is free to vibrate; driven: bearing_in"):
        vibration.periodic_motion(scene, 10.0)


def test_there_is_one_drive(line: cd.Scene) -> None:
    both = line.replace(drive=[*line.drives, "joint_angle"])
    alone = line.replace(free=line.coordinates)
    for scene, driven in ((both, "bearing_in, joint_angle"), (alone, "none")):
        with pytest.raises(MobilityError, match=f"takes one drive, .*; driven: {driven}; free: "):
            vibration.floquet(scene, 1.0)


@pytest.mark.parametrize(
    ("element", "message"),
    [
        (cd.JointFriction("twist_in", 0.1), "dry friction at 'twist_in'"),
        (
            cd.Actuator("twist_in", np.sin),
            "effort of the actuator at 'twist_in' is a function of time",
        ),
        (
            cd.PinContact(
                "base", (0, 0, 0), (1, 0, 0), "shaft_in", (0, 0, 0), 1e-4, cd.LinearContact(1e8)
            ),
            "has clearance in its bush",
        ),
    ],
)
def test_what_is_not_smooth_or_periodic_is_refused(
    line: cd.Scene, element: Any, message: str
) -> None:
    with pytest.raises(ArgumentError, match=message):
        vibration.periodic_motion(line.replace(elements=[*line.elements, element]), 0.7)


def test_a_spring_that_winds_up_is_refused(line: cd.Scene) -> None:
    # On the output, which turns on and on.
    wound = line.replace(elements=[*line.elements, cd.JointSpring("bearing_out", 0.1)])
    with pytest.raises(ArgumentError, match="does a spring wind up"):
        vibration.periodic_motion(wound, 0.7)


SLIDE = """<robot name="slide"><link name="base"/><link name="cart"/><link name="arm"><inertial>
<mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="slide" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="1 0 0"/>
<limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
<joint name="turn" type="continuous"><parent link="cart"/><child link="arm"/><axis xyz="0 0 1"/>
</joint></robot>"""


def test_a_drive_that_does_not_come_back_is_refused() -> None:
    scene = cd.Scene(cd.load(SLIDE), drive="slide", free="turn")
    with pytest.raises(ArgumentError, match="'slide' does not come back to itself"):
        rotating_scene(scene)


def test_a_motion_that_is_not_isolated_is_refused(line: cd.Scene) -> None:
    # Driven by its own twist, the shaft as a whole is without a spring: it may start anywhere.
    with pytest.raises(VibrationError, match="not isolated"):
        vibration.periodic_motion(line.replace(drive="twist_in", free="bearing_in"), 0.7)


@pytest.mark.slow
@pytest.mark.parametrize("calculation", ["campbell", "floquet", "linearise", "forced_response"])
@pytest.mark.parametrize(
    ("behind", "free"), [(None, ["twist_in"]), (1.0, ["twist_out", "twist_in"])]
)
def test_a_coordinate_that_nothing_holds_is_refused(
    calculation: str, behind: float | None, free: list[str]
) -> None:
    loose = elastic_rigs.torsional_line(stiffness_in=0.0, stiffness_out=behind)
    scene = elastic_rigs.scene(loose, 0.3, free)
    with pytest.raises(VibrationError, match="nothing holds a free coordinate"):
        getattr(vibration, calculation)(scene, 0.7)


@pytest.mark.parametrize(
    ("inertias", "message"),
    [
        ((0.5, 0.0, 0.1), "no mass moves with the free coordinate 'twist_out' alone"),
        ((0.0, 0.5, 0.0), "twist_in, twist_out can move together so that no mass moves"),
    ],
)
@pytest.mark.parametrize("calculation", ["campbell", "floquet", "periodic_motion"])
def test_coordinates_that_move_no_mass_are_refused(
    calculation: str, inertias: tuple[float, float, float], message: str
) -> None:
    front, flywheel, fork = inertias
    line = elastic_rigs.torsional_line(front, flywheel, 1.0, 1.0, fork_inertia=fork)
    with pytest.raises(ModelError, match=message):
        getattr(vibration, calculation)(elastic_rigs.scene(line, 0.3), 0.7)


def test_massless_mechanisms_are_refused() -> None:
    text = LINE.replace("<inertial>", "<!--").replace("</inertial>", "-->")
    with pytest.raises(ModelError, match="no body has mass"):
        vibration.periodic_motion(elastic_rigs.scene(text, 0.3), 1.0)


def test_what_is_no_scene_is_refused() -> None:
    mechanism = cd.load(LINE)
    for given in (mechanism, None, "elastic_thoma_rig"):
        with pytest.raises(ArgumentError, match="expected a Scene that says what turns"):
            vibration.campbell(given, 1.0)  # type: ignore[arg-type]


@pytest.mark.parametrize("speed", [0.0, [1.0, 0.0], np.ones((2, 2)), [], np.nan, "fast", np.sin])
def test_speeds_that_are_none(speed: Any) -> None:
    with pytest.raises(ArgumentError, match="speed"):
        speeds_of(speed)


def test_an_actuator_that_follows_the_position_is_admitted_if_it_repeats(line: cd.Scene) -> None:
    def pumped(turns: float) -> cd.Scene:
        load = cd.Actuator("bearing_out", lambda x: -1e-3 * np.cos(turns * x), of="position")
        return line.replace(elements=[*line.elements, load])

    found = vibration.forced_response(pumped(3.0), [2.0], joints=[])
    assert abs(found.of("twist_in", 3.0)[0]) > 1e-6
    with pytest.raises(ArgumentError, match="after a period of bearing_in"):
        vibration.forced_response(pumped(2.5), [2.0], joints=[])
