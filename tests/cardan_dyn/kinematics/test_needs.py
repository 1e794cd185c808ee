"""Needs: groups that wanted wrenches depend on, in a line of four-bars."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.linkages import coupling, gears
from testkit.planar_linkages import described, joint, link

import cardan_dyn as cd
from cardan_dyn.core.kinematics.loops.groups import Group, partition
from cardan_dyn.core.kinematics.loops.needs import (
    columns_of,
    needs,
    needs_of_finer,
    solved_couplings,
)
from cardan_dyn.core.kinematics.loops.structure import Structure

COUNT = 3


@pytest.fixture(scope="module")
def line() -> cd.Mechanism:
    """Four-bars in a line: R0 drives R1 over P0, R1 drives R2 over P1, and so on; S swings."""
    names = [f"r{k}" for k in range(COUNT + 1)] + [f"p{k}" for k in range(COUNT)]
    parts = [link(name) for name in (*names, "s")]
    parts += [joint(f"R{k}", "ground", f"r{k}", (1.1 * k, 0.0)) for k in range(COUNT + 1)]
    parts += [joint(f"P{k}", f"r{k}", f"p{k}", (0.0, 0.5)) for k in range(COUNT)]
    parts.append(joint("S", "ground", "s", (9.0, 0.0)))
    parts += [
        f'<loop name="L{k}" type="continuous"><predecessor link="p{k}"><origin xyz="1.1 0.1 0"/>'
        f'</predecessor><successor link="r{k + 1}"><origin xyz="0 0.6 0"/></successor>'
        '<axis xyz="0 0 1"/></loop>'
        for k in range(COUNT)
    ]
    return described(*parts)


def groups_of(mechanism: cd.Mechanism, drive: str) -> list[Group]:
    column = mechanism.coordinates.velocity_columns[drive].start
    passives = np.setdiff1d(np.arange(mechanism.model.nv), [column])
    x = mechanism.coordinates.neutral()
    return partition(Structure(mechanism), x, np.array([column]), passives)


def bodies_of(mechanism: cd.Mechanism, *names: str) -> set[int]:
    return {mechanism[name].id - 1 for name in names}


def test_all_wrenches_need_all_groups(line: cd.Mechanism) -> None:
    groups = groups_of(line, "R0")
    needed = needs(line, groups, None)
    every = list(range(len(groups)))
    assert (needed.motion, needed.forces) == (every, set(every))
    assert needed.known_bodies == set(range(line.model.njoints - 1))
    assert not needed.efforts_alone


def test_drive_efforts_need_the_motion_alone(line: cd.Mechanism) -> None:
    groups = groups_of(line, "R0")
    needed = needs(line, groups, set())
    assert needed.motion == list(range(len(groups)))
    assert (needed.forces, needed.known_bodies, needed.efforts_alone) == (set(), set(), True)


def test_a_wrench_needs_the_forces_of_all_later_loops_that_load_it(line: cd.Mechanism) -> None:
    """Forces pass from the last rocker back to the drive, motion from the drive to the last."""
    groups = groups_of(line, "R0")
    assert [group.loops for group in groups[:COUNT]] == [(0,), (1,), (2,)]
    for first, name in ((0, "P0"), (1, "P1"), (2, "P2"), (2, "R3"), (1, "R2")):
        needed = needs(line, groups, bodies_of(line, name))
        assert needed.forces == set(range(first, COUNT)), name
        assert needed.motion == list(range(COUNT)), name
        assert not needed.efforts_alone


def test_a_swing_beside_the_line_needs_its_own_group(line: cd.Mechanism) -> None:
    groups = groups_of(line, "R0")
    (swing,) = bodies_of(line, "S")
    needed = needs(line, groups, {swing})
    assert needed.forces == {COUNT}
    assert needed.motion == [COUNT]
    assert needed.known_bodies == {swing}


def test_wrenches_are_known_where_all_groups_that_load_a_body_are_solved(
    line: cd.Mechanism,
) -> None:
    groups = groups_of(line, "R0")
    needed = needs(line, groups, bodies_of(line, "P2"))
    assert needed.forces == {2}
    # The rocker R2 is loaded by the loop before it as well.
    assert needed.known_bodies == bodies_of(line, "P2", "R3", "L2")
    all_of_them = needs(line, groups, bodies_of(line, "R0"))
    assert all_of_them.known_bodies == set(range(line.model.njoints - 1)) - bodies_of(line, "S")


def test_couplings_of_the_solved_groups_are_solved() -> None:
    train = (coupling("bc", "b", "c", 3.0), coupling("ab", "a", "b", 2.0))
    mechanism = cd.load(gears(*train, third=True))
    groups = groups_of(mechanism, "a")
    last = needs(mechanism, groups, bodies_of(mechanism, "c"))
    assert solved_couplings(groups, last) == [0]
    both = needs(mechanism, groups, bodies_of(mechanism, "b"))
    assert solved_couplings(groups, both) == [0, 1]
    assert solved_couplings(groups, needs(mechanism, groups, set())) == []


def test_columns_of_several_groups_are_ascending(line: cd.Mechanism) -> None:
    groups = groups_of(line, "R0")
    driven = line.coordinates.velocity_columns["R0"].start
    swing = line.coordinates.velocity_columns["S"].start
    expected = sorted(set(range(line.model.nv)) - {driven, swing})
    assert columns_of(groups[::-1]).tolist() == expected
    assert columns_of([]).tolist() == []
    assert columns_of(groups[1:2]).tolist() == groups[1].passives.tolist()


def test_finer_groups_solve_the_closure_forces_that_are_solved_without(line: cd.Mechanism) -> None:
    """Least norms are over all joints that are solved, which may not become fewer."""
    column = line.coordinates.velocity_columns["R0"].start
    passives = np.setdiff1d(np.arange(line.model.nv), [column])
    x, structure = line.coordinates.neutral(), Structure(line)
    together = partition(structure, x, np.array([column]), passives, together=True)
    finer = groups_of(line, "R0")
    wanted = bodies_of(line, "P2")
    assert needs(line, finer, wanted).forces == {2}
    needed = needs(line, together, wanted)
    assert needs_of_finer(line, finer, together, needed, wanted).forces >= {0, 1, 2}
    nothing = needs(line, together, set())
    assert needs_of_finer(line, finer, together, nothing, set()).efforts_alone
    every = needs(line, together, None)
    assert needs_of_finer(line, finer, together, every, None) == needs(line, finer, None)
