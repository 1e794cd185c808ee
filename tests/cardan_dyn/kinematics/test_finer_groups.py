"""Finer groups: what closed positions prove, and what only seems to be divisible at one of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from testkit.design_line import design_line, designs, nominal
from testkit.planar_linkages import described, four_bar, joint, link, solver
from testkit.scenes import relative

import cardan_dyn as cd
from cardan_dyn.core.kinematics.loop_system import (
    LoopSystem,
    finer_groups,
    follow_drives,
)
from cardan_dyn.core.kinematics.loops.groups import Group, partition
from cardan_dyn.core.kinematics.loops.structure import Structure
from cardan_dyn.core.kinematics.tolerances import REGULAR_CONDITION

TURN = 2.0 * np.pi


class Division(NamedTuple):
    """Groups from open loops, those from closed ones, and the closed ranks at the start."""

    coarse: list[Group]
    finer: list[Group]
    ranks: list[int]

    def loops(self) -> list[tuple[int, ...]]:
        return [group.loops for group in self.finer if group.loops]


def divided(
    mechanism: cd.Mechanism, *drives: str, x: np.ndarray | None = None, held: tuple[str, ...] = ()
) -> Division:
    """Divide all loops at closed coordinates, the zero of the description if none are given."""
    velocities, structure = mechanism.coordinates.velocity_columns, Structure(mechanism)
    columns = np.array([velocities[name].start for name in drives], dtype=int)
    resting = [velocities[name].start for name in held]
    passives = np.setdiff1d(np.arange(mechanism.model.nv), [*columns, *resting])
    x = mechanism.coordinates.neutral() if x is None else x
    coarse = partition(structure, x, columns, passives)
    finer = finer_groups(structure, coarse, range(len(coarse)), x, columns, passives)
    return Division(coarse, finer, structure.ranks_at(x, {*columns.tolist(), *passives.tolist()}))


def line_scene(count: int, **arguments: object) -> cd.Scene:
    settings: dict[str, object] = {
        "drive": "bearing_0",
        "held": nominal(count),
        "loads": {f"bearing_{count}": -100.0},
        "gravity": (0.0, 0.0, -9.81),
    }
    return cd.Scene(cd.load(design_line(count)), **(settings | arguments))


def sizes(scene: cd.Scene) -> list[tuple[tuple[int, ...], int]]:
    groups = scene.solver.assembly.groups
    return [(group.loops, len(group.passives)) for group in groups if group.loops]


def undivided(patch: pytest.MonkeyPatch) -> None:
    """Let scenes made from now on have the groups of open loops."""
    patch.setattr(LoopSystem, "finer", lambda self, groups, *_: groups)


def bars(middle: tuple[tuple[float, float], tuple[float, float], tuple[float, float]]) -> list[str]:
    """Three four-bars in a line, R0 to R3; `middle` holds pins of the second one.

    Args:
        middle: P1 on the rocker R1, the rod's other end on it, and L1 on the rocker R2.
    """
    first, end, last = middle
    pins = ((0.0, 0.5), first, (0.0, 0.5))
    ends = (((1.1, 0.1), (0.0, 0.6)), (end, last), ((1.1, 0.1), (0.0, 0.6)))
    parts = [link(name) for name in ("r0", "r1", "r2", "r3", "p0", "p1", "p2")]
    parts += [joint(f"R{k}", "ground", f"r{k}", (1.1 * k, 0.0)) for k in range(4)]
    for k, (pin, (on_first, on_second)) in enumerate(zip(pins, ends, strict=True)):
        parts.append(joint(f"P{k}", f"r{k}", f"p{k}", pin))
        parts.append(
            f'<loop name="L{k}" type="continuous"><predecessor link="p{k}">'
            f'<origin xyz="{on_first[0]!r} {on_first[1]!r} 0"/></predecessor>'
            f'<successor link="r{k + 1}"><origin xyz="{on_second[0]!r} {on_second[1]!r} 0"/>'
            '</successor><axis xyz="0 0 1"/></loop>'
        )
    return parts


FLAT = ((0.5, 0.0), (0.9, 0.0), (0.3, 0.0))
"""All four pivots of the second four-bar on one line, where it has two equations, not three."""


@pytest.mark.parametrize("count", [2, 5])
def test_a_line_with_slips_is_solved_joint_by_joint(count: int) -> None:
    """A slip's loop has six equations while it is open, and four when it is closed."""
    scene = line_scene(count)
    expected = [((0,), 3), *(((k,), 4) for k in range(1, count))]
    assert sizes(scene) == expected
    x = scene.solver.assembly.start
    division = divided(scene.mechanism, "bearing_0", x=x, held=tuple(nominal(count)))
    assert [group.loops for group in division.coarse] == [tuple(range(count))]
    assert division.ranks == [3] + [4] * (count - 1)
    bodies = sorted(body for group in division.finer for body in group.inertial_bodies)
    assert bodies == list(range(scene.mechanism.model.njoints - 1))


def test_the_order_follows_the_drive() -> None:
    assert [loops for loops, _ in sizes(line_scene(3, drive="bearing_3", loads={}))] == [
        (2,),
        (1,),
        (0,),
    ]


@pytest.mark.slow
def test_divided_and_undivided_lines_have_the_same_wrenches(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    position = np.linspace(0.0, 3.0 * TURN, 60)
    held = designs(4, (3, 1))
    fine = line_scene(4)
    undivided(monkeypatch)
    coarse = line_scene(4)
    assert len(sizes(fine)) == 4
    assert len(sizes(coarse)) == 1
    for other in ({}, held):
        found = fine.sweep(position, speed=9.0, acceleration=3.0, held=other)
        expected = coarse.sweep(position, speed=9.0, acceleration=3.0, held=other)
        for name in expected.outputs:
            assert relative(found[name].force, expected[name].force) < 1e-11
            assert relative(found[name].moment, expected[name].moment) < 1e-11
            np.testing.assert_array_equal(found[name].unique, expected[name].unique)


@pytest.mark.slow
@pytest.mark.parametrize("output", ["pin_2_in", "pin_4_in", "bearing_1"])
def test_indeterminate_forces_of_few_outputs_stay_as_they_are(
    output: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They are chosen over all joints that are solved, so that these have to be the same ones."""
    position = np.linspace(0.0, 1.0, 5)
    found = line_scene(4, outputs=[output]).sweep(position)
    undivided(monkeypatch)
    expected = line_scene(4, outputs=[output]).sweep(position)
    assert not np.all(expected[output].unique)
    assert relative(found[output].force, expected[output].force) < 1e-11


@pytest.mark.slow
def test_start_and_branches_are_those_of_the_undivided_line(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fine = line_scene(2)
    undivided(monkeypatch)
    coarse = line_scene(2)
    starts = [scene.solver.assembly.start for scene in (fine, coarse)]
    np.testing.assert_allclose(*starts, rtol=0.0, atol=1e-12)
    assert list(fine.branches()) == list(coarse.branches())


def test_two_drives_that_contradict_each_other_are_still_refused() -> None:
    with pytest.raises(cd.MobilityError):
        line_scene(3, drive=["bearing_0", "bearing_3"], loads={})


def test_a_position_with_fewer_equations_by_chance_divides_nothing() -> None:
    """The middle linkage can be shaken there, but its drives cannot move independently."""
    division = divided(described(*bars(FLAT)), "R0", "R3")
    assert division.ranks == [3, 2, 3]
    assert len(division.coarse) == 1
    assert division.finer is division.coarse
    with pytest.raises(cd.MobilityError):
        cd.Scene(described(*bars(FLAT)), drive=["R0", "R3"])


def test_a_singular_start_divides_nothing() -> None:
    """The crank of the flat linkage drives it: it decides nothing there."""
    rod = '<loop name="M" type="continuous"><predecessor link="q"><origin xyz="0.9 0 0"/>'
    rod += '</predecessor><successor link="r2"><origin xyz="0.3 0 0"/></successor>'
    rod += '<axis xyz="0 0 1"/></loop>'
    parts = [*bars(FLAT), link("q"), joint("Q", "r1", "q", (0.5, 0.0)), rod]
    division = divided(described(*parts), "R0")
    assert division.ranks[1] == division.ranks[3] == 2
    assert [group.loops for group in division.coarse] == [(0, 1, 3), (2,)]
    assert division.finer is division.coarse


def test_loops_that_are_not_closed_are_left_as_they_are() -> None:
    mechanism = cd.load(design_line(3))
    division = divided(mechanism, "bearing_0", held=tuple(nominal(3)))
    assert len(division.loops()) == 3
    structure = Structure(mechanism)
    passives = np.setdiff1d(np.arange(mechanism.model.nv), [0])
    none = finer_groups(
        structure, division.coarse, [], mechanism.coordinates.neutral(), np.array([0]), passives
    )
    assert none is division.coarse


def test_loops_with_all_their_equations_are_not_asked_for_more() -> None:
    """Planar linkages have three equations, open or closed."""
    upright = ((0.0, 0.5), (1.1, 0.1), (0.0, 0.6))
    division = divided(described(*bars(upright)), "R0", "R3")
    assert division.ranks == [3, 3, 3]
    assert division.finer is division.coarse


def test_proofs_need_a_regular_start_and_a_motion_around_it() -> None:
    """A parallelogram in line is singular there, and regular wherever its crank leads."""
    mechanism = four_bar(1.0, 1.0, 2.0)
    kinematics, upright = solver(mechanism, "A")
    in_line = upright.copy()
    for name, turn in (("A", 0.5), ("B", -0.5), ("D", 0.5), ("C", 0.5)):
        in_line[mechanism.coordinates.columns[name]] = turn * np.pi
    assert follow_drives(kinematics, [True], upright)
    assert not follow_drives(kinematics, [True], in_line)
    # A rocker that is to move beyond its reach does not move.
    rocker = four_bar(0.3, 0.8, 1.0)
    driven, start = solver(rocker, "D")
    dead = cd.Scene(rocker, drive="D").motion_range()[1]
    near = cd.Scene(rocker, drive="D", near={"D": dead - 1e-4}).solver.assembly.start
    assert follow_drives(driven, [True], start)
    assert driven.evaluate(near[None, :]).condition[0] < REGULAR_CONDITION
    assert not follow_drives(driven, [True], near)
