from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import cardan_dyn as cd
from cardan_dyn.drive_lines.line.closed_chain import Robot, numbers, rpy

X, Y, Z = np.eye(3)


def test_numbers_keep_every_digit() -> None:
    values = np.random.default_rng(0).uniform(-1, 1, 50)
    assert [float(word) for word in numbers(values).split()] == values.tolist()
    assert numbers([0.0, -0.0, 2.0, 1e-20]) == "0 0 2 1e-20"


@pytest.mark.parametrize("pitch", [0.3, -1.2, np.pi / 2, -np.pi / 2])
def test_angles_about_fixed_axes(pitch: float) -> None:
    rotation = Rotation.from_euler("xyz", [0.7, pitch, -2.0]).as_matrix()
    again = Rotation.from_euler("xyz", rpy(rotation)).as_matrix()
    assert again == pytest.approx(rotation, abs=1e-9 if abs(pitch) > 1.5 else 1e-15)
    assert rpy(np.eye(3)) == (0.0, 0.0, 0.0)


def test_what_is_written_can_be_loaded() -> None:
    robot = Robot("crank")
    robot.link("base")
    robot.link("wheel", mass=2.0, centre=0.1, moments=(3.0, 2.0, 2.0))
    robot.link("rod")
    robot.joint("turn", "continuous", "base", "wheel", Z, xyz=(1.0, 0.0, 0.0))
    robot.adjustable("length", "prismatic", "wheel", "rod", X, rpy=(0.0, 0.0, 0.5))
    robot.loop("end", "spherical", ("base", (1, 0, 0), (0, 0, 0)), ("rod", (0, 0, 0), (0, 0, 0)))
    mechanism = cd.load(robot.text())
    assert dict(mechanism.adjustable) == {"length": "prismatic"}
    assert set(mechanism.joints) == {"turn", "end"}
    (wheel,) = [link for link in mechanism.description.links if link.name == "wheel"]
    assert (wheel.mass, wheel.centre.tolist()) == (2.0, [0.1, 0.0, 0.0])
    assert np.diag(wheel.inertia).tolist() == [3.0, 2.0, 2.0]
    limits = [element.tag for element in ElementTree.fromstring(robot.text()).iter("limit")]
    assert limits == ["limit"]
