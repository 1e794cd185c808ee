"""Descriptions with few digits: loops that close all along their motion only with exact numbers."""

from __future__ import annotations

import copy
import pickle
import re
from collections.abc import Iterable
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from testkit import hinge_loops
from testkit.linkages import neck

import cardan_dyn as cd

LOOPS = {
    name: hinge_loops.robot(hinge_loops.description(getattr(hinge_loops, name)()))
    for name in (
        "bennett",
        "sarrus",
        "planar",
        "spherical",
        "goldberg_5",
        "goldberg_6",
        "line_symmetric",
        "altmann",
        "bricard",
    )
}
SIX_HINGES = ("goldberg_6", "line_symmetric", "altmann", "bricard")
GRAVITY = (0.3, -0.2, -9.81)
CAMPAIGN = (pytest.mark.slow, pytest.mark.campaign)


def rounded(text: str, digits: int) -> str:
    """The same with all lengths and angles of joints to some decimals."""

    def shorter(match: re.Match[str]) -> str:
        values = (f"{float(word):.{digits}f}" for word in match[2].split())
        return f'{match[1]}="{" ".join(values)}"'

    parts = re.split(r"(<inertial>.*?</inertial>)", text, flags=re.S)
    return "".join(
        part if part.startswith("<inertial>") else re.sub(r'(xyz|rpy)="([^"]*)"', shorter, part)
        for part in parts
    )


def swept(mechanism: cd.Mechanism) -> cd.Sweep:
    return cd.Scene(mechanism, drive="h0", gravity=GRAVITY).sweep([-0.04, 0.03, 0.05], 2.0)


def told(mechanism: cd.Mechanism, words: str = "rounded numbers made exact") -> list[str]:
    return [warning for warning in mechanism.warnings if words in warning]


@cache
def of_exact_numbers(name: str) -> tuple[Any, cd.Sweep]:
    exact = cd.load(LOOPS[name])
    return cd.describe(exact), swept(exact)


@pytest.mark.parametrize(
    "digits",
    [4, 14, *(pytest.param(digits, marks=CAMPAIGN) for digits in (5, 6, 8, 10))],
)
@pytest.mark.parametrize(
    "name",
    [
        # Six hinges in space take longest, and five are in space as well.
        pytest.param(name, marks=[pytest.mark.slow] * (name in SIX_HINGES))
        for name in LOOPS
    ],
)
def test_what_only_dimensions_let_move_moves_with_few_digits(name: str, digits: int) -> None:
    """Ranks, flags and forces are those of the exact numbers, as far as digits tell."""
    wanted, expected = of_exact_numbers(name)
    mechanism = cd.load(rounded(LOOPS[name], digits))
    described = cd.describe(mechanism)
    assert (described.mobility, described.rank) == (wanted.mobility, wanted.rank)
    found = swept(mechanism)
    assert found.loop_residual < 1e-10  # What counts as closed.
    assert not np.any(found.unique & ~expected.unique)
    off = np.max(np.abs(found.drive_effort - expected.drive_effort))
    assert off < 100.0 * max(10.0**-digits, 1e-12) * np.max(np.abs(expected.drive_effort))
    # Digits that rounding takes for those of exact numbers are left alone.
    if digits <= 10 and name != "planar":
        (warning,) = told(mechanism)
        sizes = [float(word) for word in re.findall(r"by ([0-9.e-]+) (?:rad|m)", warning)]
        assert 0.0 < max(sizes) < 2.0 * 10.0**-digits
    else:
        assert not told(mechanism)


def test_without_a_tolerance_numbers_stay_as_they_are() -> None:
    text = rounded(LOOPS["bennett"], 5)
    mechanism = cd.load(text, closure_tolerance=0)
    assert not told(mechanism)
    assert not mechanism.description.displacements
    with pytest.raises(cd.CardanError):
        swept(mechanism)
    with pytest.raises(cd.ArgumentError, match="closure_tolerance"):
        cd.load(text, closure_tolerance=-1.0)


def four_bar(gap: float) -> str:
    """Own four-bar linkage whose closing pin lies off along the hinges' axes."""
    inertial = (
        '<inertial><origin xyz=".1 0 0"/><mass value="1"/>'
        '<inertia ixx=".01" iyy=".01" izz=".01"/></inertial>'
    )
    links = "".join(f'<link name="{name}">{inertial}</link>' for name in "abd")

    def joint(name: str, parent: str, child: str, xyz: str) -> str:
        return (
            f'<joint name="{name}" type="continuous"><parent link="{parent}"/>'
            f'<child link="{child}"/><origin xyz="{xyz}"/><axis xyz="0 0 1"/></joint>'
        )

    return (
        f'<robot name="f"><link name="g"/>{links}{joint("A", "g", "a", "0 0 0")}'
        f"{joint('B', 'a', 'b', '0 .1 0')}{joint('D', 'g', 'd', '.3 0 0')}"
        f'<loop name="C" type="continuous"><predecessor link="b"><origin xyz=".3 .15 {gap!r}"/>'
        '</predecessor><successor link="d"><origin xyz="0 .25 0"/></successor>'
        '<axis xyz="0 0 1"/></loop></robot>'
    )


def effort(mechanism: cd.Mechanism) -> float:
    scene = cd.Scene(mechanism, drive="A", gravity=(0.0, -9.81, 0.0))
    return float(scene.sweep([0.3]).drive_effort[0])


@pytest.mark.parametrize("gap", [1e-12, 1e-10, 1e-9, 1e-8, 1e-7])
def test_gaps_of_single_precision_are_closed(gap: float) -> None:
    mechanism = cd.load(four_bar(gap))
    assert effort(mechanism) == pytest.approx(effort(cd.load(four_bar(0.0))), rel=1e-6)
    assert bool(told(mechanism)) == (gap > 1e-12)


def test_what_is_more_than_rounding_is_said_with_what_would_accept_it() -> None:
    mechanism = cd.load(four_bar(1e-4))
    (warning,) = told(mechanism, "loops would close all along their motion")
    assert "C on its successor " in warning
    with pytest.raises(cd.AssemblyError, match="loops would close all along their motion"):
        effort(mechanism)
    (tolerance,) = re.findall(r"closure_tolerance=([0-9.e-]+)", warning)
    accepted = cd.load(four_bar(1e-4), closure_tolerance=float(tolerance))
    assert effort(accepted) == pytest.approx(effort(cd.load(four_bar(0.0))), rel=1e-3)


def test_what_is_locked_by_more_than_rounding_is_told_what_would_free_it() -> None:
    mechanism = cd.load(rounded(LOOPS["spherical"], 2))
    assert told(mechanism, "loops would close all along their motion")
    with pytest.raises(cd.CardanError, match="closure_tolerance="):
        swept(mechanism)


def doubled(digits: int) -> str:
    """A four-bar of MJCF in frames that are askew, whose hinge is two `connect`s on its axis."""
    turns = {
        name: Rotation.from_rotvec(vector)
        for name, vector in {
            "car": (0.31, -0.52, 0.43),
            "crank": (0.2, 0.7, -0.4),
            "rod": (-0.5, 0.3, 0.1),
            "rocker": (0.9, -0.3, 0.4),
        }.items()
    }
    at = {"crank": (0.0, 0.0, 0.0), "rod": (0.05, 0.12, 0.02), "rocker": (0.3, 0.0, 0.01)}

    def listed(values: Iterable[float]) -> str:
        return " ".join(f"{value:.{digits}f}" for value in values)

    def body(name: str, inside: str = "", before: str = "") -> str:
        turn = turns[name]
        place = np.array(at[name]) - at.get(before, (0.0, 0.0, 0.0))
        if before:
            place, turn = turns[before].inv().apply(place), turns[before].inv() * turn
        axis = turns[name].inv().apply((0.0, 0.0, 1.0))
        quaternion = np.roll(turn.as_quat(), 1)
        return (
            f'<body name="{name}" pos="{listed(place)}" quat="{listed(quaternion)}">'
            f'<joint name="{name}" axis="{listed(axis)}"/><inertial pos="0.05 0.02 -0.01" '
            f'mass="1.3" diaginertia="0.02 0.03 0.04"/>{inside}</body>'
        )

    ends = [np.array([0.28, 0.13, -0.03 + side]) for side in (-0.05, 0.05)]
    equalities = "".join(
        f'<connect name="c{count}" body1="rod" body2="rocker" '
        f'anchor="{listed(turns["rod"].inv().apply(end))}"/>'
        for count, end in enumerate(ends)
    )
    quaternion = listed(np.roll(turns["car"].as_quat(), 1))
    return (
        f'<mujoco><worldbody><body name="car" pos="0.123 0.0457 0.311" quat="{quaternion}">'
        f"{body('crank', body('rod', before='crank'))}{body('rocker')}</body></worldbody>"
        f"<equality>{equalities}</equality></mujoco>"
    )


@pytest.mark.parametrize(
    "digits", [4, 9, *(pytest.param(digits, marks=CAMPAIGN) for digits in (5, 6))]
)
def test_two_connects_on_one_axis_are_a_hinge(digits: int) -> None:
    found, expected = (
        cd.Scene(cd.load(doubled(count)), drive="crank", gravity=GRAVITY).sweep(
            [0.1, -0.2], speed=1.3, acceleration=0.7
        )
        for count in (digits, 17)
    )
    assert np.array_equal(found.unique, expected.unique)
    size = np.max(np.abs(expected.drive_effort))
    np.testing.assert_allclose(
        found.drive_effort, expected.drive_effort, rtol=0.0, atol=10.0 * 10.0**-digits * size
    )


@pytest.mark.parametrize("tilt", ["0.001", "0.0012345", "0.000012345"])
def test_what_a_tilted_hinge_locks_is_told_what_would_free_it(tilt: str) -> None:
    """By more than its digits leave open, and where something else moves: it is on a turntable."""
    text = (
        four_bar(0.0)
        .replace('<axis xyz="0 0 1"/>', f'<axis xyz="{tilt} 0 1"/>', 1)
        .replace(
            '<link name="g"/>',
            '<link name="hall"/><link name="g"/><joint name="turntable" type="continuous">'
            '<parent link="hall"/><child link="g"/></joint>',
        )
    )
    mechanism = cd.load(text)
    assert cd.describe(mechanism).mobility == 1
    (warning,) = told(mechanism, "loops would close all along their motion")
    with pytest.raises(cd.MobilityError, match="A cannot move: ") as caught:
        cd.Scene(mechanism, drive=["turntable", "A"])
    assert str(caught.value).endswith(warning.partition(": ")[2])
    (tolerance,) = re.findall(r"closure_tolerance=([0-9.e-]+)", warning)
    assert float(tolerance) < 1.2 * float(tilt)
    accepted = cd.load(text, closure_tolerance=float(tolerance))
    assert cd.describe(accepted).mobility == 2


def test_angles_that_stand_for_right_ones_are_known_by_their_digits() -> None:
    """Hinges turned by 1.57 and by 1.5708, each for a right angle."""
    turned = four_bar(0.0)
    for name, angle in (("A", "1.57"), ("D", "1.5708")):
        turned = re.sub(
            rf'(<joint name="{name}".*?<origin xyz="[^"]*")', rf'\1 rpy="{angle} 0 0"', turned
        )
    mechanism = cd.load(turned)
    assert told(mechanism)
    scene = cd.Scene(mechanism, drive="A", gravity=(0.0, 0.0, -9.81))
    found = float(scene.sweep([0.3]).drive_effort[0])
    assert found == pytest.approx(effort(cd.load(four_bar(0.0))), rel=1e-3)


def test_what_was_made_exact_stays_so() -> None:
    """In copies and texts, and for the proof, which reads the text again."""
    mechanism = cd.load(rounded(LOOPS["spherical"], 6))
    expected = swept(mechanism).drive_effort
    for other in (copy.deepcopy(mechanism), pickle.loads(pickle.dumps(mechanism))):
        np.testing.assert_allclose(swept(other).drive_effort, expected, rtol=1e-12)
    written = cd.load(mechanism.to_urdf())
    assert not told(written)
    np.testing.assert_allclose(swept(written).drive_effort, expected, rtol=1e-9)
    raw = {joint.name: joint.origin for joint in mechanism.description.undisplaced().joints}
    moved = {joint.name: joint.origin for joint in mechanism.second_reading.joints}
    used = {joint.name: joint.origin for joint in mechanism.description.joints}
    for name, origin in used.items():
        np.testing.assert_allclose(moved[name], origin, atol=1e-15)
        assert 0.0 <= np.max(np.abs(raw[name] - origin)) < 1e-6
    assert any(np.max(np.abs(raw[name] - origin)) > 1e-9 for name, origin in used.items())


def test_parts_that_are_exact_stay_beside_others_that_are_not() -> None:
    """Two loops on one frame, of which one has few digits."""
    few = rounded(hinge_loops.description(hinge_loops.bennett(), "b_"), 6)
    both = hinge_loops.robot(hinge_loops.description(hinge_loops.planar(), "p_"), few)
    mechanism = cd.load(both)
    assert cd.describe(mechanism).mobility == 2
    assert {item.joint[:2] for item in mechanism.description.displacements} == {"b_"}


def test_loops_that_need_no_exact_numbers_are_left_alone() -> None:
    for name in cd.bundled_names():
        assert not told(cd.load(name), "loops")


def test_a_base_that_moves_changes_nothing() -> None:
    text = rounded(LOOPS["bennett"], 6).replace(
        '<link name="ground"/>',
        '<link name="world_frame"/><link name="ground"/><joint name="base" type="floating">'
        '<parent link="world_frame"/><child link="ground"/></joint>',
    )
    mechanism = cd.load(text)
    assert cd.describe(mechanism).mobility == 7
    assert told(mechanism)


def test_bars_that_are_far_apart_are_no_matter_of_rounding() -> None:
    mechanism = cd.load(four_bar(0.0).replace(".3 .15", ".9 .15"))
    assert not told(mechanism, "exact")
    with pytest.raises(cd.AssemblyError, match="check the origins"):
        effort(mechanism)


@pytest.mark.parametrize(
    ("tilt", "length", "said"), [("1e-6", 0.5, 1), ("1e-6", 1.0, 0), ("0", 0.5, 0), ("0", 1.0, 0)]
)
def test_loops_that_last_digits_may_lock_are_named(tilt: str, length: float, said: int) -> None:
    """A plate on three parallel rods; where one is shorter, no geometry nearby lets it move."""
    hinge = '<axis xyz="0 0 1"/>'
    text = "".join(
        f'<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{place}"/>{hinge}</joint>'
        for name, parent, child, place in (
            ("a", "ground", "one", "0 0 0"),
            ("b", "one", "plate", "0 1 0"),
            ("c", "ground", "two", "1 0 0"),
            ("d", "ground", "three", f"2 {1.0 - length} 0"),
        )
    ) + "".join(
        f'<loop name="{name}" type="continuous"><predecessor link="plate" xyz="{on_plate}"/>'
        f'<successor link="{rod}" xyz="{on_rod}"/>{hinge}</loop>'
        for name, rod, on_plate, on_rod in (
            ("e", "two", "1 0 0", "0 1 0"),
            ("f", "three", f"{2.0 + float(tilt)!r} 0 0", f"{tilt} {length} 0"),
        )
    )
    links = "".join(f'<link name="{name}"/>' for name in ("ground", "one", "plate", "two", "three"))
    mechanism = cd.load(f'<robot name="plate">{links}{text}</robot>')
    warnings = [warning for warning in mechanism.warnings if "last digits" in warning]
    assert len(warnings) == said
    for warning in warnings:
        assert "all that keeps e, f from moving" in warning
    assert cd.describe(mechanism).mobility == (length == 1.0)


@pytest.mark.slow
@pytest.mark.parametrize(("longer", "said"), [(1e-6, False), (2.5e-5, True)])
def test_rods_of_two_lengths_are_made_one_or_told_what_would(longer: float, said: bool) -> None:
    """Their closing frames close at zero whatever the lengths are."""
    mechanism = cd.load(neck(longer))
    if said:
        assert cd.describe(mechanism).mobility == 0
        (warning,) = told(mechanism, "loops would close all along their motion")
        (tolerance,) = re.findall(r"closure_tolerance=([0-9.e-]+)", warning)
        mechanism = cd.load(neck(longer), closure_tolerance=float(tolerance))
    assert cd.describe(mechanism).mobility == 1
    scenes = [
        cd.Scene(item, drive="arm", gravity=GRAVITY) for item in (mechanism, cd.load(neck(0)))
    ]
    found, expected = (scene.sweep([-0.2, 0.1, 0.3], 2.0) for scene in scenes)
    np.testing.assert_allclose(found.drive_effort, expected.drive_effort, rtol=100 * longer)
    shifts = [item.matrix[:3, 3] for item in mechanism.description.displacements]
    assert 0.5 * longer < np.linalg.norm(shifts) < 2 * longer
