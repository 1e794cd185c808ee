"""Gravity that a file states: taken where a scene asks for it, said where a scene leaves it out."""

from __future__ import annotations

import json
import warnings
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from click.testing import CliRunner

import cardan_dyn as cd
from cardan_dyn.practice.command_line.commands import main

LENGTH, MASS = 0.4, 1.5
"""Distance of the bob from the hinge [m] and its mass [kg]."""


def mjcf(option: str = "") -> str:
    return f"""<mujoco model="pendulum">{option}<worldbody><body name="arm">
      <joint name="hinge" axis="0 1 0"/>
      <inertial pos="{LENGTH} 0 0" mass="{MASS}" diaginertia="0.01 0.01 0.01"/>
    </body></worldbody></mujoco>"""


def sdf(world: str | None, version: str = "1.9") -> str:
    model = f"""<model name="pendulum"><link name="arm"><inertial><mass>{MASS}</mass>
      <pose>{LENGTH} 0 0 0 0 0</pose><inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz>
      <ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial></link>
      <joint name="hinge" type="revolute"><parent>world</parent><child>arm</child>
      <axis><xyz>0 1 0</xyz><limit><lower>-9</lower><upper>9</upper></limit></axis></joint>
      </model>"""
    inside = model if world is None else f'<world name="w">{world}{model}</world>'
    return f'<sdf version="{version}">{inside}</sdf>'


def pendulum(gravity: tuple[float, float, float]) -> pin.Model:
    model = pin.Model()
    model.name = "pendulum"
    joint = model.addJoint(0, pin.JointModelRY(), pin.SE3.Identity(), "hinge")
    lever = np.array([LENGTH, 0.0, 0.0])
    model.appendBodyToJoint(joint, pin.Inertia(MASS, lever, 0.01 * np.eye(3)), pin.SE3.Identity())
    model.gravity.linear = np.array(gravity)
    return model


MOON = (0.2, 0.1, -1.62)
MECHANISMS = [
    (lambda: cd.load(mjcf('<option gravity="0.2 0.1 -1.62"/>')), MOON, True),
    (lambda: cd.load(mjcf()), (0.0, 0.0, -9.81), False),
    (lambda: cd.load(mjcf('<option gravity="0 0 -9.81"/>')), (0.0, 0.0, -9.81), True),
    (lambda: cd.load(mjcf('<option><flag gravity="disable"/></option>')), (0.0, 0.0, 0.0), False),
    (lambda: cd.load(sdf("<gravity>0.2 0.1 -1.62</gravity>")), MOON, True),
    (lambda: cd.load(sdf("")), (0.0, 0.0, -9.8), False),
    (
        lambda: cd.load(sdf("<physics><gravity>0.2 0.1 -1.62</gravity></physics>", "1.5")),
        MOON,
        True,
    ),
    (lambda: cd.from_pinocchio(pendulum(MOON)), MOON, True),
]


def holding(gravity: tuple[float, float, float], angle: float) -> float:
    """Return the moment that holds the pendulum, about y: that of its weight turned back."""
    x, z = LENGTH * np.cos(angle), -LENGTH * np.sin(angle)
    return -MASS * (z * gravity[0] - x * gravity[2])


@pytest.mark.parametrize(("load", "expected", "is_stated"), MECHANISMS)
def test_it_is_taken_and_said(load, expected, is_stated) -> None:
    mechanism = load()
    assert mechanism.description.gravity.tolist() == list(expected)
    assert mechanism.description.states_gravity == is_stated
    scene = cd.Scene(mechanism, drive="hinge", gravity="description")
    assert scene.gravity.tolist() == list(expected)
    for effort in (
        scene.sweep(0.3).drive_effort[0],
        cd.Scene(mechanism, drive="hinge", gravity=(0, 0, 0))
        .sweep(0.3, gravity="description")
        .drive_effort[0],
        scene.response().sweep(0.3, gravity="description").drive_effort[0],
    ):
        np.testing.assert_allclose(effort, holding(expected, 0.3), rtol=1e-9, atol=1e-12)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        cd.describe(mechanism)
        cd.Scene(mechanism, drive="hinge", gravity=(0, 0, 0))
        assert not said
        for _ in range(2):
            assert not cd.Scene(mechanism, drive="hinge").gravity.any()
    assert len(said) == (is_stated and any(expected))
    for item in said:
        assert item.filename == __file__
        listed = ", ".join(f"{value:g}" for value in expected)
        assert f"pendulum: the description's gravity ({listed}) m/s² is left out" in str(
            item.message
        )


def test_a_pendulum_hangs_along_it() -> None:
    mechanism = cd.load(mjcf('<option gravity="3 0 -4"/>'))
    scene = cd.Scene(mechanism, free="hinge", gravity=(0, 0, -1))
    rest = scene.equilibrium(0.5, gravity="description")
    np.testing.assert_allclose(rest.position, np.arctan2(4, 3), rtol=1e-9)


@pytest.mark.parametrize(
    ("source", "name"), [(sdf(None), "hinge"), ("universal_joint", "bearing_in")]
)
def test_a_description_without_one_refuses(source: str, name: str) -> None:
    mechanism = cd.load(source)
    assert mechanism.description.gravity is None
    with pytest.raises(cd.CardanError, match="the description has none"):
        cd.Scene(mechanism, drive=name, gravity="description")


def test_it_is_written(tmp_path: Path) -> None:
    mechanism = cd.load(mjcf('<option gravity="0.2 0.1 -1.62"/>'))
    cd.write(mechanism, tmp_path / "again.xml")
    again = cd.load(tmp_path / "again.xml").description
    assert (again.gravity.tolist(), again.states_gravity) == (list(MOON), True)


def test_command_line(tmp_path: Path) -> None:
    path = tmp_path / "pendulum.xml"
    path.write_text(mjcf('<option gravity="0.2 0.1 -1.62"/>'))
    sweep = ["sweep", str(path), "--samples", "5", "--json", "-"]
    results = [
        CliRunner().invoke(main, [*sweep, *words])
        for words in (
            ["--gravity", "description"],
            ["--gravity=description"],
            ["--gravity", "0.2", "0.1", "-1.62"],
        )
    ]
    assert [item.exit_code for item in results] == [0, 0, 0], results[0].output
    first, *others = (json.loads(item.stdout) for item in results)
    assert all(item == first for item in others)
    mixed = CliRunner().invoke(main, [*sweep, "--gravity", "0", "description", "0"])
    assert mixed.exit_code == 2
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        left = CliRunner().invoke(main, sweep)
    assert "--gravity description takes it, --gravity 0 0 0 is none" in left.stderr
