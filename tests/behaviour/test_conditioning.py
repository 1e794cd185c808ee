"""What a result says about its own accuracy: units, overflow, rounding of inertial terms."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest
from testkit.scenes import double, text, universal

import cardan_dyn as cd

pytestmark = pytest.mark.usefixtures("loaded_once")

POSITIONS = np.linspace(0.1, 6.2, 9)


def in_units(description: str, length: float) -> str:
    """Return a description with all lengths multiplied, inertia left out."""
    root = ElementTree.fromstring(description)
    for link in root.iter("link"):
        for part in list(link):
            link.remove(part)
    for origin in root.iter("origin"):
        xyz = [float(word) * length for word in origin.get("xyz", "0 0 0").split()]
        origin.set("xyz", " ".join(map(repr, xyz)))
    for limit in root.iter("limit"):
        limit.set("lower", "-1e30")
        limit.set("upper", "1e30")
    return ElementTree.tostring(root, encoding="unicode")


def crank_sweep(length: float) -> cd.Sweep:
    mechanism = cd.load(in_units(text("slider_crank"), length))
    scene = cd.Scene(mechanism, drive="crank_bearing", loads={"piston_guide": -1.0})
    return scene.sweep(POSITIONS)


@pytest.mark.parametrize("length", [1e-6, 1e-3, 1e3, 1e6])
def test_condition_does_not_depend_on_the_unit_of_length(length: float) -> None:
    in_metres, in_lengths = crank_sweep(1.0), crank_sweep(length)
    assert in_lengths.condition == pytest.approx(in_metres.condition, rel=1e-9)
    assert in_lengths.drive_effort == pytest.approx(length * in_metres.drive_effort, rel=1e-12)
    assert in_lengths.balance_residual < 1e-14


@pytest.mark.parametrize("load", [1e-250, 1e-160, 1e160, 1e250])
def test_loads_of_any_size_are_proved(load: float) -> None:
    scene, one = (universal(cd.load("universal_joint"), 0.7, -size) for size in (load, 1.0))
    found, unit = scene.sweep(POSITIONS), one.sweep(POSITIONS)
    assert found.drive_effort / load == pytest.approx(unit.drive_effort, rel=1e-13)
    assert max(found.balance_residual, found.power_residual) < 1e-14


@pytest.mark.filterwarnings("ignore:overflow", "ignore:invalid value", "ignore:divide by zero")
@pytest.mark.parametrize("speed", [1e156, 1e160])
@pytest.mark.parametrize("outputs", [None, ["bearing_out"], []])
def test_what_overflows_is_refused(outputs: list[str] | None, speed: float) -> None:
    scene = universal(cd.load("universal_joint"), 0.7, outputs=outputs)
    with pytest.raises(cd.AccuracyError, match="overflow"):
        scene.sweep(POSITIONS, speed)
    with pytest.raises(cd.ArgumentError, match="overflow"):
        scene.response().sweep(POSITIONS, speed)


def test_balance_at_speed_is_relative_to_wrenches_and_condition_says_why() -> None:
    scene = double(cd.load("double_shaft_z"), 0.4, 0.3, load=-10.0)
    slow, fast = scene.sweep(POSITIONS, speed=1e-3), scene.sweep(POSITIONS, speed=1e3)
    assert fast.balance_residual <= 1e-11
    assert np.min(fast.condition / slow.condition) > 1e3


@pytest.mark.parametrize("angles", [(0.4, 0.3), (0.2, 0.1), (0.7, 0.5), (1.0, 0.9)])
def test_the_default_tolerance_suits_every_double_shaft(angles: tuple[float, float]) -> None:
    scene = double(cd.load("double_shaft_z"), *angles, load=-10.0)
    response = scene.response()
    direct, found = scene.sweep(POSITIONS, 50.0), response.sweep(POSITIONS, 50.0)
    size = max(np.max(np.abs(direct[name].moment)) for name in direct.outputs)
    for name in direct.outputs:
        error = np.max(np.abs(found[name].moment - direct[name].moment)) / size
        assert error <= 10.0 * response.error
