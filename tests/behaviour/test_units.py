"""The unit of length and the axes of the world decide nothing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from testkit.bundled import EVERY_KIND
from testkit.linkages import four_bar, loop, tilted_slider_crank
from testkit.scaling import in_lengths

import cardan_dyn as cd
from cardan_dyn.scene.drives import drives_of
from cardan_dyn.scene.presets import PRESETS

pytestmark = pytest.mark.usefixtures("loaded_once")

POSITIONS = np.linspace(0.0, 6.0, 60)
JOINTS = ("crank_bearing", "crank_pin", "piston_pin", "guide")


@pytest.mark.parametrize("length", [1e-9, 1e-6, 1e-3, 1e3, 1e6])
@pytest.mark.parametrize("planar", [False, True], ids=["rail", "plane"])
def test_forces_do_not_depend_on_the_unit_of_length(length: float, planar: bool) -> None:
    def sweep(unit: float) -> cd.Sweep:
        loads = {"piston": cd.Wrench(force=[-3.0, 2.0, 1.0])}
        mechanism = cd.load(tilted_slider_crank(unit, planar))
        return cd.Scene(mechanism, drive="crank_bearing", loads=loads).sweep(POSITIONS)

    one, other = sweep(1.0), sweep(length)
    allowed = 20.0 * np.finfo(float).eps * np.max(one.condition)
    size = max(float(np.max(np.abs(one[name].force))) for name in JOINTS)
    for name in JOINTS:
        assert np.max(np.abs(one[name].force - other[name].force)) < allowed * size
        assert np.max(np.abs(one[name].moment - other[name].moment / length)) < allowed * size
        assert np.array_equal(one[name].unique, other[name].unique)
    assert np.max(other.condition) == pytest.approx(np.max(one.condition), rel=1e-6)


def in_size(name: str, length: float, gyration: float | None) -> cd.Scene:
    """Return the scene of a bundled mechanism of another size, under the same forces."""
    mechanism, preset = cd.load(in_lengths(cd.load(name), length, gyration)), PRESETS[name]
    slides = {name: item.slides for name, item in mechanism.drivable.items()}
    loads = {on: load * (1.0 if slides[on] else length) for on, load in preset.loads.items()}
    held = {joint: np.deg2rad(angle) for joint, angle in preset.held_deg.items()}
    return cd.Scene(mechanism, drive=list(preset.drive), held=held, loads=loads)


SIZES = pytest.mark.parametrize(
    ("length", "gyration"),
    [(1e-6, 1.0), (1e3, None), (1.0, 1e4)],
)
"""Sizes of mechanisms; and of how far masses are spread in them, which closes no loops."""


@SIZES
@pytest.mark.parametrize("name", EVERY_KIND)
def test_similar_mechanisms_have_similar_results(
    name: str, length: float, gyration: float | None
) -> None:
    one, other = in_size(name, 1.0, None), in_size(name, length, gyration)
    drives = len(PRESETS[name].drive)
    positions = POSITIONS[:42].reshape(-1, drives)
    if drives > 1:  # Legs.
        positions = 0.01 * np.sin(positions)
    first = one.sweep(positions)
    second = other.sweep(positions * length if drives > 1 else positions)
    np.testing.assert_allclose(second.condition, first.condition, rtol=1e-9)
    allowed = 100.0 * np.finfo(float).eps * np.max(first.condition)
    wrenches = [np.abs([first[joint].force, first[joint].moment]) for joint in first.outputs]
    size = float(np.max(wrenches))
    for joint in first.outputs:
        assert np.array_equal(first[joint].unique, second[joint].unique)
        assert np.max(np.abs(first[joint].force - second[joint].force)) <= allowed * size
        moment = second[joint].moment / length
        assert np.max(np.abs(first[joint].moment - moment)) <= allowed * size
    if drives == 1:
        assert other.motion_range() == one.motion_range()


@pytest.mark.slow
@SIZES
@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "universal_joint"])
def test_similar_mechanisms_have_similar_dead_points_and_assembly_modes(
    name: str, length: float, gyration: float | None
) -> None:
    one, other = in_size(name, 1.0, None), in_size(name, length, gyration)

    def unit(joint: str) -> float:
        return length if one.mechanism.drivable[joint].slides else 1.0

    assert list(one.branches()) == list(other.branches())
    for pose, positions in one.branches().items():
        for joint, position in positions.items():
            found = other.branches()[pose][joint] / unit(joint)
            assert found == pytest.approx(position, abs=1e-9), (pose, joint)
    first, second = drives_of(one.mechanism), drives_of(other.mechanism)
    for joint, drive in first.items():
        assert drive.problem == second[joint].problem
        if drive.reach is not None:
            reach = np.array(second[joint].reach) / unit(joint)
            np.testing.assert_allclose(reach, drive.reach, atol=1e-8, err_msg=joint)


@pytest.mark.parametrize("length", [1e-6, 1e-3, 1.0, 1e3, 1e6])
def test_modes_meet_at_the_same_angle_in_any_size(length: float) -> None:
    """With crank and rod of a length, the piston stands in the crank's bearing at a right angle."""
    scene = cd.Scene(
        cd.load(f"""<robot name="equal"><link name="base"/><link name="crank"/><link name="rod"/>
      <link name="piston"/>
      <joint name="a" type="continuous"><parent link="base"/><child link="crank"/>
        <axis xyz="0 0 1"/></joint>
      <joint name="b" type="continuous"><parent link="crank"/><child link="rod"/>
        <origin xyz="{length!r} 0 0"/><axis xyz="0 0 1"/></joint>
      <joint name="s" type="prismatic"><parent link="base"/><child link="piston"/>
        <origin xyz="{2.0 * length!r} 0 0"/><axis xyz="1 0 0"/></joint>
      <loop name="c" type="continuous"><predecessor link="rod"><origin xyz="{length!r} 0 0"/>
        </predecessor><successor link="piston"/><axis xyz="0 0 1"/></loop></robot>"""),
        drive="a",
    )
    right = 0.5 * np.pi
    np.testing.assert_allclose(scene.motion_range(), [-right, right], atol=1e-9)


@pytest.mark.parametrize("length", [1e-9, 1e-3, 1.0, 1e6, 1e9])
def test_slips_of_racks_do_not_depend_on_the_unit_of_length(length: float) -> None:
    text = f"""<robot name="rack"><link name="base"/><link name="pinion"/><link name="rack"/>
      <joint name="turn" type="continuous"><parent link="base"/><child link="pinion"/>
        <origin xyz="0 {0.3 * length!r} 0"/><axis xyz="0 0 1"/></joint>
      <joint name="slide" type="prismatic"><parent link="base"/><child link="rack"/>
        <origin xyz="{length!r} 0 0"/><axis xyz="1 0 0"/></joint>
      <coupling name="teeth"><predecessor link="pinion"/><successor link="rack"/>
        <ratio value="{0.3 * length!r}"/></coupling></robot>"""
    scene = cd.Scene(cd.load(text), drive="turn", loads={"slide": -2.0})
    swept = scene.sweep(POSITIONS, speed=1.0, acceleration=0.3)
    assert swept.drive_effort == pytest.approx(0.6 * length, rel=1e-14)
    assert swept.motion.position("slide") == pytest.approx(0.3 * length * POSITIONS, rel=1e-14)
    bodies, seen = scene.solver.inverse_dynamics.bodies, []
    check = bodies.check
    bodies.check = lambda claim: seen.append(claim) or check(claim)
    scene.sweep(POSITIONS)
    off = seen[0].x.copy()
    off[3, scene.mechanism.coordinates.columns["slide"].start] += 1e-6 * length
    with pytest.raises(cd.AccuracyError, match="loop residual"):
        check(seen[0]._replace(x=off)).prove(POSITIONS[:, None], np.ones(len(POSITIONS)))


@pytest.mark.parametrize("away", [0.0, 1e3, 2e6, 1e8])
def test_what_stands_in_the_world_may_be_heavy_and_far_away(away: float) -> None:
    """The mass of a pedestal far from the origin once counted as the size of the mechanism."""
    mass = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'

    def joint(name: str, kind: str, parent: str, child: str, x: float) -> str:
        return (
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{x!r} 0 0"/><axis xyz="0 0 1"/></joint>'
        )

    links = "".join(f'<link name="{name}">{mass}</link>' for name in ("ped", "l", "c", "r"))
    text = f"""<robot name="r"><link name="base"/>{links}
      {joint("foot", "fixed", "base", "ped", away + 0.5)}
      {joint("a", "continuous", "base", "l", away)}{joint("b", "continuous", "l", "c", 0.1)}
      {joint("d", "continuous", "ped", "r", 0.0)}
      <loop name="e" type="continuous"><predecessor link="c"><origin xyz="0.3 0.3 0"/></predecessor>
        <successor link="r"><origin xyz="-0.1 0.3 0"/></successor><axis xyz="0 0 1"/></loop>
      </robot>"""
    scene = cd.Scene(cd.load(text), drive="a", gravity=(0.0, -9.81, 0.0))
    swept = scene.sweep([0.05])
    # Of unit twists about the weld, in lengths of the coupler, 5.428; the fastest ratio is 1.255.
    assert swept.condition[0] == pytest.approx(6.81, rel=0.05)
    # Placements 1e8 m away are rounded to 1e-8 m in the description itself.
    assert swept.drive_effort[0] == pytest.approx(0.97977401, rel=1e-7)


def on_a_turntable() -> str:
    inside = four_bar(loop("continuous"))
    table = (
        '<link name="ground"/><joint name="table" type="continuous"><parent link="ground"/>'
        '<child link="base"/><origin xyz="1 2 3" rpy="0.3 0.4 0.5"/><axis xyz="0.6 0.8 0"/></joint>'
    )
    root = next(link for link in ("base", "ground", "world") if f'link name="{link}"' in inside)
    inside = inside.replace(f'"{root}"', '"base"')
    return inside.replace("</robot>", table + "</robot>")


def test_a_planar_loop_on_a_turntable_is_planar_to_all() -> None:
    """A plane that turns with the body which carries it is a plane nonetheless."""
    mechanism = cd.load(on_a_turntable())
    (report,) = cd.describe(mechanism).loops
    assert report.rank == 3
    still = cd.Scene(cd.load(four_bar(loop("continuous"))), drive="a", loads={"d": -3.0})
    expected = still.sweep(POSITIONS)
    flags = [expected[name].unique for name in "abcd"]
    scene = cd.Scene(mechanism, drive=["a", "table"], loads={"d": -3.0})
    for swivel in (0.0, 1e-6, 1e-4, 0.3, 2.0):
        positions = np.stack([POSITIONS[:20], np.linspace(0.0, swivel, 20)], axis=1)
        found = scene.sweep(positions)
        for name, unique in zip("abcd", flags, strict=True):
            assert np.array_equal(found[name].unique, unique)
            size = np.max(np.abs(expected[name].force))
            difference = found[name].force - expected[name].force[:20]
            assert np.max(np.abs(difference)) < 1e-12 * size
    idle = cd.Scene(mechanism, drive=["a", "table"]).sweep(positions)
    assert all(
        np.array_equal(idle[name].unique, unique)
        for name, unique in zip("abcd", flags, strict=True)
    )


def test_numbers_next_to_nothing_are_nothing() -> None:
    tilted = four_bar(loop("continuous"), axis="0 1e-320 1")
    expected = cd.Scene(cd.load(four_bar(loop("continuous"))), drive="a", loads={"d": -3.0})
    found = cd.Scene(cd.load(tilted), drive="a", loads={"d": -3.0}).sweep(POSITIONS)
    assert np.array_equal(found.drive_effort, expected.sweep(POSITIONS).drive_effort)


@pytest.mark.parametrize("size", [1e-40, 1e-17])
def test_a_mechanism_without_size_is_refused(size: float) -> None:
    with pytest.raises(cd.ModelError, match="the greatest length is"):
        cd.load(tilted_slider_crank(size, False))


def test_bars_without_size_do_not_hold_each_other() -> None:
    mechanism = cd.load(in_lengths(cd.load("four_bar"), 1e-20))
    assert any("greatest length" in line for line in mechanism.warnings)
    with pytest.raises(cd.MobilityError):
        cd.Scene(mechanism, drive="crank_bearing")


SPHERICAL = np.array([[0.0, 0.0, 1.0], [0.5, 0.0, 1.0], [0.6, 1.0, 0.8], [0.0, 1.2, 0.6]])
"""Axes of a spherical four-bar: crank bearing, crank pin, rocker pin, rocker bearing."""


def spherical_four_bar(offset: tuple[float, float, float]) -> str:
    """Without mass and lengths, but for what rounding leaves of zero."""
    words = [" ".join(map(repr, axis)) for axis in SPHERICAL.tolist()]
    x, y, z = offset
    links = "".join(f'<link name="{name}"/>' for name in ("ground", "a", "b", "c"))
    return f"""<robot name="sphere">{links}
      <joint name="A" type="continuous"><parent link="ground"/><child link="a"/>
        <axis xyz="{words[0]}"/></joint>
      <joint name="B" type="continuous"><parent link="a"/><child link="b"/>
        <origin xyz="{x!r} {y!r} {z!r}"/><axis xyz="{words[1]}"/></joint>
      <joint name="D" type="continuous"><parent link="ground"/><child link="c"/>
        <axis xyz="{words[3]}"/></joint>
      <loop name="C" type="continuous"><predecessor link="b"><origin xyz="{z!r} {x!r} 0"/>
        </predecessor><successor link="c"/><axis xyz="{words[2]}"/></loop></robot>"""


@pytest.mark.parametrize(
    "offset", [(0.0, 0.0, 0.0), (1e-17, 0.0, 0.0), (0.0, -6.1e-17, 2.2e-16), (5e-324, 0.0, 0.0)]
)
def test_rounding_is_no_length(tmp_path: Path, offset: tuple[float, float, float]) -> None:
    """Against the angle between both pins, which stays what it is (SciPy's root of it)."""
    mechanism = cd.load(spherical_four_bar(offset))
    crank = np.linspace(0.0, 0.5, 6)
    turn = cd.Scene(mechanism, drive="A", loads={"D": -1.0}).sweep(crank)
    a, b, c, d = SPHERICAL / np.linalg.norm(SPHERICAL, axis=1)[:, None]

    def missed(rocker: float, angle: float) -> float:
        pins = Rotation.from_rotvec(angle * a).apply(b), Rotation.from_rotvec(rocker * d).apply(c)
        return float(pins[0] @ pins[1] - b @ c)

    rocker = [0.0]
    for angle in crank[1:]:
        near = rocker[-1]
        rocker.append(brentq(missed, near - 0.05, near + 0.2, args=(angle,), xtol=1e-15))
    np.testing.assert_allclose(turn.motion.position("D"), rocker, atol=1e-13)
    np.testing.assert_allclose(turn.drive_effort, turn.motion.ratio("D"), rtol=1e-12)
    path = cd.write(mechanism, tmp_path / "sphere.urdf")
    assert path.read_text(encoding="utf-8") == mechanism.to_urdf()
    moved = {name: turn.motion.position(name)[3] for name in mechanism}
    assert cd.assemble(
        cd.load(cd.write(mechanism, tmp_path / "moved.urdf", at=moved))
    ).zero_residual < (1e-14)
