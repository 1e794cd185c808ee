"""Groups of loops: smallest, in order, and complete, for lines and rings of linkages."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.linkages import coupling, gears
from testkit.planar_linkages import described, joint, link

import cardan_dyn as cd
from cardan_dyn.core.kinematics.loops.groups import Group, partition
from cardan_dyn.core.kinematics.loops.structure import Structure


def loop(name: str, first: str, second: str, on_first: str, on_second: str) -> str:
    return (
        f'<loop name="{name}" type="continuous"><predecessor link="{first}">'
        f'<origin xyz="{on_first}"/></predecessor><successor link="{second}">'
        f'<origin xyz="{on_second}"/></successor><axis xyz="0 0 1"/></loop>'
    )


def line(count: int, *order: int) -> cd.Mechanism:
    """Four-bars in a line: each crank R_k drives the next rocker R_k+1 over a rod P_k.

    Args:
        count: of four-bars.
        order: in which the loops L_k are described; ascending if none is given.
    """
    names = [f"r{k}" for k in range(count + 1)] + [f"p{k}" for k in range(count)]
    parts = [link(name) for name in names]
    parts += [joint(f"R{k}", "ground", f"r{k}", (1.1 * k, 0.0)) for k in range(count + 1)]
    parts += [joint(f"P{k}", f"r{k}", f"p{k}", (0.0, 0.5)) for k in range(count)]
    parts += [
        loop(f"L{k}", f"p{k}", f"r{k + 1}", "1.1 0.1 0", "0 0.6 0") for k in order or range(count)
    ]
    return described(*parts)


def groups_of(
    mechanism: cd.Mechanism, *drives: str, held: tuple[str, ...] = (), together: bool = False
) -> list[Group]:
    velocities = mechanism.coordinates.velocity_columns
    columns = np.array([velocities[name].start for name in drives], dtype=int)
    resting = [velocities[name].start for name in held]
    passives = np.setdiff1d(np.arange(mechanism.model.nv), [*columns, *resting])
    x = mechanism.coordinates.neutral()
    return partition(Structure(mechanism), x, columns, passives, together)


def names_of(mechanism: cd.Mechanism, columns: np.ndarray) -> set[str]:
    velocities = mechanism.coordinates.velocity_columns
    return {name for name in velocities if velocities[name].start in columns}


def loops_of(mechanism: cd.Mechanism, groups: list[Group]) -> list[set[str]]:
    return [{mechanism.loops[index].joint for index in group.loops} for group in groups]


def check_complete(mechanism: cd.Mechanism, groups: list[Group], *known: str) -> None:
    """Every body's inertia counts once, every passive is decided once, and in order."""
    bodies = [body for group in groups for body in group.inertial_bodies]
    assert sorted(bodies) == list(range(mechanism.model.njoints - 1))
    decided = [name for group in groups for name in names_of(mechanism, group.passives)]
    assert len(decided) == len(set(decided))
    available = set(known)
    for group in groups:
        assert names_of(mechanism, group.known) <= available
        available |= names_of(mechanism, group.passives)
        assert group.inertial_bodies <= set(group.bodies)
        assert group.bodies == sorted(group.bodies)
        for body in group.bodies:
            parent = mechanism.model.parents[body + 1] - 1
            assert parent == group.base or parent in group.bodies


@pytest.mark.parametrize("order", [(), (3, 1, 0, 2)])
def test_a_line_is_solved_loop_by_loop_from_its_drive(order: tuple[int, ...]) -> None:
    mechanism = line(4, *order)
    groups = groups_of(mechanism, "R0")
    assert loops_of(mechanism, groups) == [{"L0"}, {"L1"}, {"L2"}, {"L3"}]
    for k, group in enumerate(groups):
        assert names_of(mechanism, group.passives) == {f"P{k}", f"L{k}", f"R{k + 1}"}
        assert names_of(mechanism, group.known) == {f"R{k}"}
        carried = {f"R{k}", f"P{k}", f"L{k}", f"R{k + 1}"}
        assert set(group.bodies) == {mechanism[name].id - 1 for name in carried}
    # The crank is accounted for by the first loop that carries it.
    assert mechanism["R1"].id - 1 in groups[0].inertial_bodies - groups[1].inertial_bodies
    check_complete(mechanism, groups, "R0")


def test_the_order_follows_the_drive() -> None:
    mechanism = line(4)
    groups = groups_of(mechanism, "R4")
    assert loops_of(mechanism, groups) == [{"L3"}, {"L2"}, {"L1"}, {"L0"}]
    check_complete(mechanism, groups, "R4")
    middle = groups_of(mechanism, "R2")
    order = loops_of(mechanism, middle)
    assert order.index({"L1"}) < order.index({"L0"})
    assert order.index({"L2"}) < order.index({"L3"})
    check_complete(mechanism, middle, "R2")


def test_a_second_drive_splits_nothing_but_makes_surplus_join() -> None:
    """With both ends driven, the mobility is exceeded: only all loops together can show it."""
    mechanism = line(3)
    groups = groups_of(mechanism, "R0", "R3")
    assert loops_of(mechanism, groups) == [{"L0", "L1", "L2"}]
    check_complete(mechanism, groups, "R0", "R3")


def test_loops_that_need_each_other_are_solved_together() -> None:
    """Two rods between the same crank and rocker: a parallelogram with a redundant rod."""
    mechanism = described(
        *(link(name) for name in "abcd"),
        joint("A", "ground", "a"),
        joint("D", "ground", "d", (2.0, 0.0)),
        joint("B", "a", "b", (0.0, 1.0)),
        joint("C", "a", "c", (0.0, 0.5)),
        loop("L", "b", "d", "2 0 0", "0 1 0"),
        loop("M", "c", "d", "2 0 0", "0 0.5 0"),
    )
    groups = groups_of(mechanism, "A")
    assert loops_of(mechanism, groups) == [{"L", "M"}]
    assert names_of(mechanism, groups[0].passives) == set("BCDLM")
    check_complete(mechanism, groups, "A")


def test_a_held_joint_is_neither_passive_nor_known() -> None:
    mechanism = line(2)
    groups = groups_of(mechanism, "R0", held=("R2",))
    touched = {name for group in groups for name in names_of(mechanism, group.passives)}
    touched |= {name for group in groups for name in names_of(mechanism, group.known)}
    assert touched == {"R0", "P0", "L0", "R1", "P1", "L1"}


def test_all_loops_may_be_solved_together() -> None:
    mechanism = line(3)
    (group,) = groups_of(mechanism, "R0", together=True)
    assert loops_of(mechanism, [group]) == [{"L0", "L1", "L2"}]
    assert len(group.passives) == 9
    check_complete(mechanism, [group], "R0")


def test_couplings_are_groups_of_their_own_where_they_suffice() -> None:
    train = (coupling("bc", "b", "c", 3.0), coupling("ab", "a", "b", 2.0))
    mechanism = cd.load(gears(*train, third=True))
    groups = groups_of(mechanism, "a")
    assert [group.couplings for group in groups] == [(1,), (0,)]
    assert [names_of(mechanism, group.passives) for group in groups] == [{"b"}, {"c"}]
    assert all(group.loops == () for group in groups)
    check_complete(mechanism, groups, "a")
    closed = cd.load(gears(*train, coupling("ca", "c", "a", 1.0 / 6.0), third=True))
    groups = groups_of(closed, "a")
    assert [sorted(group.couplings) for group in groups] == [[0, 1, 2]]
    check_complete(closed, groups, "a")


def test_couplings_are_counted_after_the_loops() -> None:
    wheel = (
        '<coupling name="mesh"><predecessor link="d"/><successor link="w"/><ratio value="2"/>'
        "</coupling>"
    )
    mechanism = described(
        *(link(name) for name in "abdw"),
        joint("A", "ground", "a"),
        joint("B", "a", "b", (0.0, 1.0)),
        joint("D", "ground", "d", (2.0, 0.0)),
        joint("W", "ground", "w", (3.0, 0.0)),
        loop("L", "b", "d", "2 0 0", "0 0.5 0"),
        wheel,
    )
    groups = groups_of(mechanism, "A")
    assert [(group.loops, group.couplings) for group in groups] == [((0,), ()), ((), (0,))]
    assert names_of(mechanism, groups[1].known) == {"D"}
    check_complete(mechanism, groups, "A")


def test_bodies_on_no_loop_stay_out_of_its_group() -> None:
    arm = link("s"), joint("S", "ground", "s", (5.0, 0.0))
    mechanism = described(
        *(link(name) for name in "abd"),
        joint("A", "ground", "a"),
        joint("B", "a", "b", (0.0, 1.0)),
        joint("D", "ground", "d", (2.0, 0.0)),
        loop("L", "b", "d", "2 0 0", "0 1 0"),
        *arm,
    )
    groups = groups_of(mechanism, "A", "S")
    assert [group.loops for group in groups] == [(0,), ()]
    # The arm is on no loop, so its drive is not among what the loop knows.
    assert names_of(mechanism, groups[0].known) == {"A"}
    check_complete(mechanism, groups, "A")


def star(arms: int, length: int) -> cd.Mechanism:
    """Open arms from the ground, each a chain of joints."""
    parts = []
    for arm in range(arms):
        names = [f"l{arm}_{index}" for index in range(length)]
        parts += list(map(link, names))
        parts += [
            joint(f"J{name}", parent, name, (0.0, 0.1))
            for parent, name in zip(["ground", *names], names, strict=False)
        ]
    return described(*parts)


def test_each_branch_of_bodies_on_no_loop_is_a_group() -> None:
    mechanism = star(3, 5)
    groups = groups_of(mechanism)
    assert all(group.loops == () and not group.passives.size for group in groups)
    assert [group.bodies for group in groups] == [
        list(range(first, first + 5)) for first in (0, 5, 10)
    ]
    assert {group.base for group in groups} == {-1}
    check_complete(mechanism, groups)


def test_a_branch_hangs_from_a_body_of_a_loop() -> None:
    tool = link("t"), joint("T", "b", "t"), link("u"), joint("U", "t", "u"), joint("V", "b", "v")
    mechanism = described(
        *(link(name) for name in "abdv"),
        joint("A", "ground", "a"),
        joint("B", "a", "b", (0.0, 1.0)),
        joint("D", "ground", "d", (2.0, 0.0)),
        loop("L", "b", "d", "2 0 0", "0 1 0"),
        *tool,
    )
    groups = groups_of(mechanism, "A", "T", "U", "V")
    body = {name: mechanism.joints[name].id - 1 for name in "BTUV"}
    branches = {(tuple(sorted(group.bodies)), group.base) for group in groups if not group.loops}
    assert branches == {
        (tuple(sorted((body["T"], body["U"]))), body["B"]),
        ((body["V"],), body["B"]),
    }
    check_complete(mechanism, groups, "A")
