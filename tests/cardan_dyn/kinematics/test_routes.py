"""Routes across closed loops: lazy tongs whose loops all reach down to the foot."""

from __future__ import annotations

import re

import numpy as np
import pytest
from testkit import tongs

import cardan_dyn as cd
from cardan_dyn.core.kinematics.closing.all_groups import Kinematics
from cardan_dyn.core.kinematics.loop_system import LoopSystem
from cardan_dyn.core.kinematics.loops.groups import Group, partition
from cardan_dyn.core.kinematics.loops.needs import needs
from cardan_dyn.core.kinematics.loops.structure import Structure

COUNTS = (5, 10, 20, 40)


def groups_of(mechanism: cd.Mechanism, drive: str = "slide", together: bool = False) -> list[Group]:
    column = mechanism.coordinates.velocity_columns[drive].start
    passives = np.setdiff1d(np.arange(mechanism.model.nv), [column])
    x = mechanism.coordinates.neutral()
    return partition(Structure(mechanism), x, np.array([column]), passives, together)


def kinematics(mechanism: cd.Mechanism, drive: str = "slide") -> Kinematics:
    groups = groups_of(mechanism, drive)
    found = LoopSystem(mechanism, {}).kinematics((drive,), groups)
    return found.with_open_reductions(mechanism.coordinates.neutral())


def closed(found: Kinematics, positions: np.ndarray) -> np.ndarray:
    """Return closed coordinates, each from the one before."""
    x = found.coordinates.neutral()[None].copy()
    column, rows = found.coordinates.column_of(found.drives)[0], []
    for position in positions:
        x[0, column] = position
        x = found.close(x).x.copy()
        rows.append(x[0].copy())
    return np.array(rows)


def names(mechanism: cd.Mechanism, bodies: list[int]) -> list[str]:
    return [mechanism.model.names[body + 1] for body in bodies]


def test_the_way_leads_around_one_pair_of_arms() -> None:
    mechanism = tongs.two_chains(6)
    groups = groups_of(mechanism)
    for k, group in enumerate(groups[:6]):
        decided = set(names(mechanism, group.passives.tolist()))
        assert decided == {f"ja{k}", f"jb{k}", f"p{k}"}
        if k >= 2:
            assert names(mechanism, group.bodies) == [f"ja{k}", f"p{k}", f"p{k - 1}", f"jb{k}"]
            assert names(mechanism, group.known.tolist()) == [f"p{k - 1}"]
            assert mechanism.model.names[group.base + 1] == f"ja{k - 1}"
            assert group.crossed_loops == [k - 1]
        else:
            assert not group.crossed


def test_pairs_are_solved_one_by_one_wherever_the_drive_is() -> None:
    """Along the tree, all loops below a driven pair would need each other."""
    mechanism = tongs.two_chains(9)
    for drive in ("ja8", "p4", "jb6"):
        groups = [group for group in groups_of(mechanism, drive) if group.loops]
        # The way along the tree around the second pair is not twice as long as the short one.
        assert [group.loops for group in groups if len(group.loops) > 1] == [(0, 1)]
        for group in groups:
            if len(group.loops) == 1:
                assert len(group.bodies) == 4 and len(group.known) == 1


def test_loops_that_need_each_other_share_their_ways() -> None:
    """A cylinder between two pairs needs the loop of the upper pair, and that one needs it."""
    mechanism = tongs.two_chains(9, cylinder=4)
    groups = [group for group in groups_of(mechanism, "cylinder") if len(group.loops) > 1]
    loops = [[mechanism.loops[loop].joint for loop in group.loops] for group in groups]
    assert loops == [["p5", "head"], ["p0", "p1"]]
    upper = set(names(mechanism, groups[0].bodies))
    assert upper == {"ja5", "p5", "p4", "jb5", "foot", "cylinder", "head"}


def test_the_inertia_of_every_body_counts_once_along_the_tree() -> None:
    mechanism = tongs.two_chains(9)
    groups = groups_of(mechanism)
    counted = [body for group in groups for body in group.inertial_bodies]
    assert sorted(counted) == list(range(mechanism.model.njoints - 1))
    for group in groups:
        if group.inertial_bodies:
            parents = [mechanism.model.parents[body + 1] - 1 for body in group.bodies]
            assert set(parents) <= {group.base, *group.bodies}


@pytest.mark.slow
@pytest.mark.parametrize("drive", ["slide", "ja0", "p4", "ja{last}"])
def test_rows_and_placed_bodies_grow_linearly(drive: str) -> None:
    """Entries of all closure matrices, and bodies that are placed."""
    entries, placed = [], []
    for count in COUNTS:
        solved = kinematics(tongs.two_chains(count), drive.format(last=count - 1))
        state = solved.evaluate(solved.coordinates.neutral()[None])
        entries.append(sum(item.known_rows.size + item.passive_rows.size for item in state.groups))
        placed.append(sum(len(solver.group.bodies) for solver in solved.solvers))
    # Of each pair, one pin that is known and three joints, by three rows.
    assert np.all(np.diff(entries) == 12 * np.diff(COUNTS))
    # Four around each loop, and three for inertia with few between them and their base.
    assert np.all(np.diff(placed) <= 9 * np.diff(COUNTS))


@pytest.mark.parametrize("drive", ["slide", "ja0", "p2"])
def test_rates_are_those_of_all_loops_of_the_description_together(drive: str) -> None:
    """The motion around short ways, against all loops along the tree in one system."""
    mechanism = tongs.two_chains(7)
    x = closed(kinematics(mechanism), np.array([0.1, 0.3, 0.5]))
    rates = []
    for together in (False, True):
        groups = groups_of(mechanism, drive, together)
        assert any(group.crossed for group in groups) != together
        found = LoopSystem(mechanism, {}).kinematics((drive,), groups)
        found = found.with_open_reductions(mechanism.coordinates.neutral())
        state = found.evaluate(x)
        assert np.max(state.residual) < 1e-14
        v = found.rates(state, np.full((3, 1), 0.7))
        rates.append((v, found.accelerations(state, v, np.full((3, 1), 0.2))))
    for short, whole in zip(*rates, strict=True):
        np.testing.assert_allclose(short, whole, rtol=1e-11, atol=1e-11)


def test_what_is_crossed_has_to_be_solved() -> None:
    """A pin is placed by all pairs below it, though only its own pair and the next load it."""
    mechanism = tongs.two_chains(6)
    groups = groups_of(mechanism)
    needed = needs(mechanism, groups, {mechanism["p4"].id - 1})
    assert {0, 1, 2, 3, 4, 5} <= set(needed.motion)
    assert needed.forces.isdisjoint({0, 1, 2, 3}) and {4, 5} <= needed.forces


def test_welds_of_fixed_loops_are_not_crossed() -> None:
    """Their wrenches would change with what crosses them."""
    text = tongs.two_chains(6).description.source.text
    pin = text.index('<loop name="p3" type="continuous">')
    welded = text[:pin] + text[pin:].replace('type="continuous"', 'type="fixed"', 1)
    mechanism = cd.load(welded)
    fixed = [index for index, loop in enumerate(mechanism.loops) if loop.is_fixed]
    assert fixed == [3]
    for group in groups_of(mechanism):
        assert 3 not in group.crossed_loops


def test_no_way_leads_outwards_across_the_world() -> None:
    """The world would hang from an arm: around p7, only the last arm and the lowest would be."""
    text = re.sub(r'<loop name="p[0-5]".*?</loop>', "", tongs.two_chains(8).description.source.text)
    for pin, arm, other in (("p6", "b6", "frame"), ("p7", "b7", "b0")):
        before, loop = text.split(f'<loop name="{pin}"')
        text = before + f'<loop name="{pin}"' + loop.replace(f'"{arm}"', f'"{other}"', 1)
    mechanism = cd.load(text)
    assert mechanism.loops[0].successor == 0
    assert not any(group.crossed for group in groups_of(mechanism))


def test_short_chains_keep_their_tree() -> None:
    assert not any(group.crossed for group in groups_of(tongs.two_chains(2)))
    assert not any(group.crossed for group in groups_of(tongs.pair_by_pair(6)))
