"""Dead points of free coordinates: what is found there is what other coordinates find."""

from __future__ import annotations

import numpy as np
import pytest
from testkit import task_machines as machines
from testkit.linkages import LINK, four_bar, loop, slider_crank

import cardan_dyn as cd
from cardan_dyn.kit.arrays import Array

WEIGHT = (0.0, -9.81, 0.0)
BESIDE = np.array([-1e-3, -1e-6, -1e-10, 0.0, 1e-12, 1e-8, 1e-4])
"""Times beside a dead point [s]."""


def passing(scene: cd.Scene, other: str, dead: cd.Event, **start: object) -> list[cd.Trajectory]:
    """The same simulation by `other` instead of the first free coordinate, at its dead points."""
    by_other = scene.replace(free=[other, *scene.free[1:]])
    duration = start.pop("duration", 1.0)
    runs = [item.simulate(duration, rtol=1e-12, **start) for item in (scene, by_other)]
    times = [event.time for event in by_other.simulate(duration, events=dead, **start).events]
    assert times
    at = np.add.outer(times, BESIDE).ravel()
    return [run.at(np.append(at, 0.4 * times[0])) for run in runs]


def assert_alike(found: cd.Trajectory, expected: cd.Trajectory) -> None:
    """All but what is said of the free coordinates themselves."""
    assert not np.any(found.singular) and not np.any(expected.singular)
    greatest = max(float(np.abs(expected[name].force).max()) for name in expected)
    for name in found:
        for part in ("force", "moment"):
            values, known = getattr(found[name], part), getattr(expected[name], part)
            np.testing.assert_allclose(values, known, rtol=0.0, atol=1e-9 * greatest)
    for rate in ("v", "a"):
        values, known = getattr(found.motion, rate), getattr(expected.motion, rate)
        np.testing.assert_allclose(values, known, rtol=0.0, atol=1e-9 * np.abs(known).max())
    assert found.effort_residual < 1e-12 and found.balance_residual < 1e-12
    assert np.max(found.condition) < 1e7  # Some ten digits, beside dead points as well.
    np.testing.assert_array_equal(found.unique, expected.unique)


def straight(joint: str, at: float = 0.0) -> cd.Event:
    return cd.Event(lambda time, position, speed: np.sin(position[joint] - at))


def test_a_piston_passes_its_dead_points() -> None:
    start = {"crank_bearing": 1.0}
    scene = cd.Scene(cd.load("slider_crank"), free="piston_guide", near=start, gravity=WEIGHT)
    given = {"position": start, "speed": {"crank_bearing": 20.0}, "duration": 0.5}
    found, expected = passing(scene, "crank_bearing", straight("crank_bearing"), **given)
    assert_alike(found, expected)
    # Nothing but the piston's own ratios and what it would have to exert has no value there.
    ratio = found.motion.ratio("crank_bearing", "piston_guide")
    assert np.isnan(ratio[3]) and np.isfinite(ratio[-1])
    assert not np.any(found.drive_effort)
    assert np.max(np.abs(found["piston_guide"].axial)) < 1e-10
    with pytest.raises(cd.SingularConfigurationError, match="do not decide the motion at sample"):
        found.sweep.derivative("piston_guide")
    # A dead point alone is one as well.
    alone, known = found.at(found.time[3]), expected.at(found.time[3])
    assert_alike(alone, known)
    assert found.to_dataframe().notna()["crank_pin.shear"].all()


def test_a_rocker_passes_its_dead_points() -> None:
    """Where crank and coupler are in line."""
    scene = cd.Scene(cd.load(four_bar(loop("continuous"))), free="d", gravity=WEIGHT)
    given = {"position": {"a": 0.3}, "speed": {"a": 9.0}, "duration": 2.0}
    scene = scene.replace(near={"a": 0.3})
    assert_alike(*passing(scene, "a", straight("b", 0.25 * np.pi), **given))


def hung(description: str, link: str) -> cd.Mechanism:
    bob = LINK.format(name="bob", com="0 -0.2 0", mass="0.5")
    bob += machines.joint("swing", "continuous", link, "bob", np.zeros(3), np.eye(3)[2])
    return cd.load(description.replace("</robot>", f"{bob}</robot>"))


@pytest.mark.parametrize("driven", [False, True])
def test_a_pendulum_hangs_from_the_piston(driven: bool) -> None:
    """It is free as well, or driven, and then its torque is known at the dead points."""
    scene = cd.Scene(
        hung(slider_crank(None), "slider"),
        free=["d"] if driven else ["d", "swing"],
        drive=["swing"] if driven else (),
        gravity=WEIGHT,
        near={"a": -0.5},
        outputs=["a", "b", "swing"],
    )
    given: dict[str, object] = {"position": {"a": -0.5}, "speed": {"a": 9.0}}
    if driven:
        given["motion"] = {"swing": lambda t: (t**3, 3.0 * t**2, 6.0 * t)}
    found, expected = passing(scene, "a", straight("a", 0.5 * np.pi), **given)
    assert_alike(found, expected)
    efforts = [item.drive_effort[:, item.coordinates.index("swing")] for item in (found, expected)]
    np.testing.assert_allclose(*efforts, atol=1e-9 * max(np.abs(efforts[1]).max(), 1.0))
    assert np.any(efforts[0]) == driven


def test_work_is_integrated_over_dead_points() -> None:
    """Times are chosen so that one of Gauss's nodes before them, where power is read, is one."""
    by_piston, by_crank = (
        cd.Scene(
            hung(slider_crank(None), "slider"),
            free=free,
            drive="swing",
            gravity=WEIGHT,
            near={"a": -0.5},
        ).simulate(
            0.3,
            position={"a": -0.5},
            speed={"a": 9.0},
            motion={"swing": lambda t: (t**3, 3.0 * t**2, 6.0 * t)},
            events=straight("a", 0.5 * np.pi),
            rtol=1e-12,
        )
        for free in ("d", "a")
    )
    dead = by_piston.events[0].time
    index = int(np.searchsorted(by_piston.steps, dead))
    begun, end = by_piston.steps[index - 1 : index + 1]
    nodes, _ = np.polynomial.legendre.leggauss(8)
    times = begun + 2.0 * (dead - begun) / (1.0 + nodes)
    found = by_piston.at(times[times < end])
    assert len(found) and found.energy_residual < 1e-9
    np.testing.assert_allclose(found.work, by_crank.at(found.time).work, rtol=1e-9)


def test_a_task_moves_the_pendulum() -> None:
    """What its actuated joint exerts is known where the piston stands."""
    scene = cd.Scene(
        hung(slider_crank(None), "slider"),
        task=cd.PointTask("bob", (0.0, -0.2, 0.0), axes="y"),
        actuated="swing",
        free="d",
        gravity=WEIGHT,
        near={"a": -0.5, "swing": 0.8},
    )
    given = {"position": {"a": -0.5}, "speed": {"a": 9.0}}
    given["motion"] = {scene.rows[0]: 0.05}
    found, expected = passing(scene, "a", straight("a", 0.5 * np.pi), **given)
    assert_alike(found, expected)
    known: Array = expected.actuated_effort["swing"]
    off = np.abs(found.actuated_effort["swing"] - known)
    assert np.max(off) < 1e-9 * np.abs(known).max()
