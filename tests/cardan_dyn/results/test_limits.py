"""Limits of descriptions: what a sweep says where joints or efforts go beyond them."""

from __future__ import annotations

import math

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.core.results.limits import briefly, exceeded

ARM = """<robot name="arm"><link name="base"/>
<link name="upper"><inertial><origin xyz="0.5 0 0"/><mass value="4"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial></link><link name="tip"/>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
<axis xyz="0 -1 0"/><limit lower="-1" upper="1.5" effort="15" velocity="0"/></joint>
<joint name="boom" type="prismatic"><parent link="upper"/><child link="tip"/>
<axis xyz="1 0 0"/><limit lower="-0.2" upper="0.3" effort="0" velocity="0"/></joint></robot>"""
BAR = """<robot name="bar"><link name="base"/><link name="crank"/>
<link name="rod"/><link name="rocker"/>
<joint name="motor" type="continuous"><parent link="base"/><child link="crank"/>
<axis xyz="0 0 1"/></joint>
<joint name="pin" type="continuous"><parent link="crank"/><child link="rod"/>
<origin xyz="0.2 0 0"/><axis xyz="0 0 1"/></joint>
<joint name="wrist" type="revolute"><parent link="base"/><child link="rocker"/>
<origin xyz="0.8 0 0"/><axis xyz="0 0 1"/><limit lower="-2.2" upper="-1.5" effort="1" velocity="1"/>
</joint>
<loop name="end" type="continuous"><predecessor link="rod"><origin xyz="0.8 0 0"/></predecessor>
<successor link="rocker"><origin xyz="0.5 0 0"/></successor><axis xyz="0 0 1"/></loop></robot>"""


def swept(positions: list[list[float]]) -> str:
    scene = cd.Scene(cd.load(ARM), drive=["shoulder", "boom"], gravity=(0.0, 0.0, -9.81))
    return repr(scene.sweep(np.array(positions)))


def test_strokes_and_efforts_are_held_against_the_file() -> None:
    """The weight's moment is 4 · 9.81 · 0.5 cos φ; zero as a limit of efforts means none."""
    text = swept([[0.0, 0.0], [1.6, -0.25]])
    assert "exceeds limit of shoulder (85.94°): 91.67° at sample 1" in text
    assert "exceeds limit of boom (-200 mm): -250 mm at sample 1" in text
    moment = 4 * 9.81 * 0.5
    told = f"exceeds effort limit of shoulder (15 N·m): {moment:.4g} N·m at sample 0"
    assert told in text and "effort limit of boom" not in text
    steep = math.acos(14.9 / moment)
    assert "exceeds" not in swept([[steep, -0.2], [1.5, 0.3]])


def test_an_angle_is_the_same_after_a_turn() -> None:
    assert "limit of shoulder" not in swept([[1.0 + 2.0 * np.pi, 0.0], [1.0 - 4.0 * np.pi, 0.0]])


def rocker(angle: float) -> float:
    """Return where the rocker stands, by the law of cosines, in the mode below the ground."""
    x, y = 0.2 * math.cos(angle) - 0.8, 0.2 * math.sin(angle)
    far = math.hypot(x, y)
    beside = math.acos((0.5**2 + far**2 - 0.8**2) / (2 * 0.5 * far))
    return math.atan2(y, x) + beside - 2.0 * math.pi * (y >= 0.0)


def test_a_joint_that_follows_is_judged_as_well() -> None:
    scene = cd.Scene(cd.load(BAR), drive="motor", near={"wrist": -1.444, "pin": -0.239})
    turn = np.linspace(0.0, 2.0 * np.pi, 73)
    told = repr(scene.sweep(turn))
    angles = np.array([rocker(angle) for angle in turn])
    over = np.maximum(angles + 1.5, -2.2 - angles)
    worst = int(over.argmax())
    limit = math.degrees(-1.5 if angles[worst] > -1.5 else -2.2)
    assert over[worst] > 0.01
    assert (
        f"exceeds limit of wrist ({limit:.4g}°): {math.degrees(angles[worst]):.4g}° at "
        f"motor {math.degrees(turn[worst]):.4g}°"
    ) in told
    inside = turn[over < -1e-3]
    assert len(inside) > 5 and "exceeds" not in repr(scene.sweep(inside))


def test_ranges_of_drives_say_whose_limits_they_leave() -> None:
    found = cd.describe(cd.load(BAR)).drives
    assert "exceeds limit of wrist" in found["motor"].ends
    assert "exceeds" not in cd.describe(cd.load("four_bar")).drives["crank_bearing"].ends


@pytest.mark.parametrize("outputs", [["shoulder"], []])
def test_what_outputs_leave_out_is_not_judged(outputs: list[str]) -> None:
    scene = cd.Scene(cd.load(ARM), drive=["shoulder", "boom"], outputs=outputs)
    assert "exceeds limit of boom" in repr(scene.sweep([[0.0, 0.5]]))


def test_speeds_are_held_against_the_file() -> None:
    """The rocker's speed by difference of the law of cosines; zero is no limit."""
    scene = cd.Scene(cd.load(BAR), drive="motor", near={"wrist": -1.444, "pin": -0.239})
    turn, speed, step = np.linspace(0.0, 2.0 * np.pi, 73), 12.0, 1e-5
    rates = [speed * (rocker(a + step) - rocker(a - step)) / (2.0 * step) for a in turn[1:-1]]
    worst = 1 + int(np.abs(rates).argmax())
    most = rates[worst - 1]
    told = repr(scene.sweep(turn, speed=speed))
    assert (
        f"exceeds speed limit of wrist ({math.copysign(1.0, most):g} rad/s): {most:.4g} rad/s "
        f"at motor {math.degrees(turn[worst]):.4g}°"
    ) in told
    assert "speed limit" not in repr(scene.sweep(turn, speed=0.99 * speed / abs(most)))
    arm = cd.Scene(cd.load(ARM), drive=["shoulder", "boom"])
    assert "speed limit" not in repr(arm.sweep([[0.0, 0.0]], speed=[[9.0, 9.0]]))


def test_trajectories_tell_what_their_motion_exceeds() -> None:
    """Of a pendulum of energy m g l from rest at the side: ω² = 2 m g l sin φ / I."""
    arm = cd.load(ARM.replace('velocity="0"', 'velocity="2"').replace('effort="15"', 'effort="0"'))
    scene = cd.Scene(arm, free="shoulder", held={"boom": 0.0}, gravity=(0.0, 0.0, -9.81))
    falling = scene.simulate(0.4)
    end = falling.position[-1]
    speed = -math.sqrt(2.0 * 4 * 9.81 * 0.5 * math.sin(-end) / (0.1 + 4 * 0.5**2))
    for told in (repr(falling), str(falling)):
        assert f"exceeds speed limit of shoulder (-2 rad/s): {speed:.4g} rad/s" in told
        assert f"exceeds limit of shoulder (-57.3°): {math.degrees(end):.4g}°" in told
    assert "exceeds" not in repr(falling.at(falling.time[falling.time < 0.1]))


def test_of_many_limits_the_farthest_are_told_and_the_others_counted() -> None:
    """Hinges side by side that are allowed less and less, all of them at 40°."""
    hinges = "".join(
        f'<link name="l{index}"/><joint name="j{index}" type="revolute"><parent link="base"/>'
        f'<child link="l{index}"/><axis xyz="0 0 1"/>'
        f'<limit lower="-{0.1 * index}" upper="{0.1 * index}" effort="0" velocity="0"/></joint>'
        for index in (4, 2, 5, 3, 1)
    )
    fan = cd.load(f'<robot name="fan"><link name="base"/>{hinges}</robot>')
    swept = cd.Scene(fan, drive=list(fan.joints)).sweep(np.full((1, 5), np.radians(40.0)))
    found = exceeded(swept)
    assert [text.split()[3] for text in found] == ["j1", "j2", "j3", "j4", "j5"]
    assert briefly(found) == [*found[:3], "exceeds 2 more limits by less"]
    # A single one takes no more room than its count.
    assert briefly(found[:4]) == list(found[:4]) and briefly(()) == []
    pages = cd.Report(swept)
    assert pages.exceeded == found and len(pages.beware) - len(pages.doubts) == 4
