"""Motions that leave a solver's beaten track: far steps, slow gears, dead points, loose bodies."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.drive_lines import drive_line
from testkit.linkages import tilted_slider_crank

import cardan_dyn as cd

pytestmark = pytest.mark.usefixtures("loaded_once")

INERTIA = '<inertia ixx="1" iyy="1" izz="1"/>'
MASS = '<inertial><origin xyz="{x} 0 0"/><mass value="2"/>' + INERTIA + "</inertial>"


def five_bar(rod: float) -> cd.Mechanism:
    """Two cranks of 1 m, 2 m apart, whose rods meet: two ways to assemble them everywhere."""
    half = float(np.sqrt(rod**2 - 1.0))
    text = f"""<robot name="five_bar"><link name="ground"/><link name="l"/><link name="r"/>
      <link name="p"/><link name="q"/>
      <joint name="left" type="continuous"><parent link="ground"/><child link="l"/>
        <axis xyz="0 0 1"/></joint>
      <joint name="right" type="continuous"><parent link="ground"/><child link="r"/>
        <origin xyz="2 0 0"/><axis xyz="0 0 1"/></joint>
      <joint name="elbow_l" type="continuous"><parent link="l"/><child link="p"/>
        <origin xyz="0 1 0"/><axis xyz="0 0 1"/></joint>
      <joint name="elbow_r" type="continuous"><parent link="r"/><child link="q"/>
        <origin xyz="0 1 0"/><axis xyz="0 0 1"/></joint>
      <loop name="tip" type="continuous"><predecessor link="p"><origin xyz="1 {half!r} 0"/>
        </predecessor><successor link="q"><origin xyz="-1 {half!r} 0"/></successor>
        <axis xyz="0 0 1"/></loop></robot>"""
    return cd.load(text)


def tip(rod: float, left: float, right: float) -> np.ndarray:
    """Return the tip on the side on which it is at zero, above the line of both elbows."""
    one = np.array([-np.sin(left), np.cos(left)])
    other = np.array([2.0 - np.sin(right), np.cos(right)])
    along = other - one
    reach = np.linalg.norm(along)
    across = np.array([-along[1], along[0]]) / reach
    return 0.5 * (one + other) + np.sqrt(rod**2 - 0.25 * reach**2) * across


def test_far_steps_of_several_drives_stay_on_their_way_of_assembling() -> None:
    rng = np.random.default_rng(3)
    # Elbows are at most 3.9 m apart, so that the rods never lie in line.
    targets = rng.uniform(-1.2, 1.2, (60, 2))
    for positions in (targets, targets[::-1], np.repeat(targets, 2, axis=0)[1:]):
        scene = cd.Scene(five_bar(2.2), drive=["left", "right"])
        found = scene.sweep(positions).origin("tip")[:, :2]
        expected = np.array([tip(2.2, *target) for target in positions])
        assert np.max(np.abs(found - expected)) < 1e-12


@pytest.mark.parametrize("rod", [1.6182, 1.619, 1.625, 1.65])
@pytest.mark.parametrize("step", [0.05, 0.1, 0.2, 0.4])
def test_a_step_past_rods_almost_in_line_does_not_end_on_the_other_side(
    rod: float, step: float
) -> None:
    """At 2.034 rad elbows are 3.236 m apart. There both ways almost meet, and straight on leads
    from one to the other."""
    scene = cd.Scene(five_bar(rod), drive=["left", "right"])
    nearest = np.pi - np.arctan(2.0)
    path = np.concatenate([np.linspace(0.0, nearest - step, 40), [nearest + step]])
    positions = np.stack([path, np.zeros_like(path)], axis=1)
    for order in (positions, positions[-1:], np.concatenate([positions, positions[::-1]])):
        found = scene.sweep(order).origin("tip")[:, :2]
        expected = np.array([tip(rod, *target) for target in order])
        assert np.max(np.abs(found - expected)) < 1e-10


@pytest.mark.parametrize("ratio", [0.5, 1.0 / 3.0])
def test_responses_of_gears_repeat_after_several_turns(ratio: float) -> None:
    text = f"""<robot name="gears"><link name="base"/><link name="first"/>
      <link name="second">{MASS.format(x=0.5)}</link>
      <joint name="in" type="continuous"><parent link="base"/><child link="first"/>
        <axis xyz="0 0 1"/></joint>
      <joint name="out" type="continuous"><parent link="base"/><child link="second"/>
        <origin xyz="1 0 0"/><axis xyz="0 0 1"/></joint>
      <coupling name="gear"><predecessor link="first"/><successor link="second"/>
        <ratio value="{ratio!r}"/></coupling></robot>"""
    scene = cd.Scene(cd.load(text), drive="in", gravity=(0.0, -9.81, 0.0))
    response = scene.response()
    assert response._data[0].series.domain.length == pytest.approx(2.0 * np.pi / ratio)
    positions = np.concatenate([np.linspace(-40.0, 40.0, 401), [2e5 * np.pi + 0.7, -1e4 * np.pi]])
    # The weight of 2 kg at 0.5 m turns with the second wheel, whose moment the gear passes on.
    exact = ratio * 2.0 * 9.81 * 0.5 * np.cos(ratio * positions)
    swept = scene.sweep(positions).drive_effort
    assert np.max(np.abs(swept - exact)) < 1e-9
    assert np.max(np.abs(response.sweep(positions).drive_effort - exact)) < 1e-9
    assert np.max(np.abs(swept[:401] - exact[:401])) < 1e-12
    turn = response.uniform(64).drive_effort
    angle = 2.0 * np.pi / ratio * np.arange(64) / 64
    assert np.max(np.abs(turn - ratio * 9.81 * np.cos(ratio * angle))) < 1e-12


@pytest.mark.parametrize("length", [1e-6, 1e-3, 1.0, 1e3])
def test_dead_points_of_slides_do_not_depend_on_the_unit_of_length(length: float) -> None:
    """Crank 1, rod from (1, 0) to (3, 0.2): dead points where both lie in line."""
    mechanism = cd.load(tilted_slider_crank(length, planar=False))
    scene = cd.Scene(mechanism, drive="guide", near={"crank_bearing": 1.0})
    rod = np.hypot(2.0, 0.2)
    exact = [np.sqrt((rod + sign) ** 2 - 0.2**2) - 3.0 for sign in (-1.0, 1.0)]
    low, high = (end / length for end in scene.motion_range())
    assert low == pytest.approx(exact[0], abs=1e-8)
    assert high == pytest.approx(exact[1], abs=1e-8)
    with pytest.raises(cd.AssemblyError) as caught:
        scene.sweep([length * (exact[1] + 0.1)])
    assert caught.value.nearest / length == pytest.approx(exact[1], abs=1e-8)


@pytest.mark.parametrize("count", [1, 9, 40])
def test_loose_bodies_hang_on_lines_of_many_groups(count: int) -> None:
    """A chain of driven links hangs on the shaft behind three loops; all of it is balanced."""
    line = drive_line(3)
    mechanism = cd.load(line)
    last = next(reversed(mechanism.links))
    chain = "".join(
        f'<link name="c{k}">{MASS.format(x=0.25)}</link><joint name="j{k}" type="continuous">'
        f'<parent link="{last if k == 0 else f"c{k - 1}"}"/><child link="c{k}"/>'
        '<origin xyz="0.5 0 0"/><axis xyz="0 1 0"/></joint>'
        for k in range(count)
    )
    mechanism = cd.load(line.replace("</robot>", chain + "</robot>"))
    drives = [next(iter(mechanism.joints)), *(f"j{k}" for k in range(count))]
    scene = cd.Scene(mechanism, drive=drives, gravity=(0.0, 0.0, -9.81))
    positions = 0.3 * np.sin(np.arange(6.0 * len(drives))).reshape(6, -1)
    swept = scene.sweep(positions, speed=0.5, acceleration=0.2)
    assert swept.unproven == ()
    assert swept.balance_residual < 1e-13
    still = scene.sweep(np.zeros((1, len(drives))))
    force = still.wrench("j0", "world").force[0]
    assert force == pytest.approx([0.0, 0.0, 2.0 * 9.81 * count], abs=1e-9)
