"""Structure: what loops and couplings depend on, and the ranks of open loops."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.design_line import design_line, nominal
from testkit.linkages import LINK, carriage, coupling, four_bar, gears, loop, tilted_slider_crank
from testkit.mixed_chain import MIXED
from testkit.planar_linkages import four_bar as four_bar_of

import cardan_dyn as cd
from cardan_dyn.core.kinematics.loops.structure import Structure


def ranks_of(mechanism: cd.Mechanism, *resting: str) -> list[int]:
    """Ranks of the loops while some joints rest at zero."""
    velocities = mechanism.coordinates.velocity_columns
    moving = set(range(mechanism.model.nv))
    for name in resting:
        moving -= set(range(velocities[name].start, velocities[name].stop))
    return Structure(mechanism).ranks(mechanism.coordinates.neutral(), moving)


def test_paths_lead_between_the_ends_over_the_body_that_both_hang_from() -> None:
    mechanism = cd.load(MIXED)
    structure = Structure(mechanism)
    bodies = {name: mechanism[name].id - 1 for name in mechanism}
    cross = [part.id - 1 for part in mechanism["cross"].parts]
    paths = {
        "ball": [bodies[name] for name in ("slide", "swing", "ball", "hinge")],
        "cross": [bodies["hinge"], *cross, bodies["slide"]],
        "bolt": [bodies[name] for name in ("turn", "slide", "swing")],
    }
    velocities = mechanism.coordinates.velocity_columns
    for index, item in enumerate(mechanism.loops):
        path = paths[item.joint]
        assert structure.paths[index] == sorted(path)
        assert structure.bases[index] == (-1 if item.joint == "bolt" else bodies["turn"])
        names = [name for name in mechanism if name != "bolt" and bodies[name] in path]
        expected = {column for name in names for column in np.r_[velocities[name]].tolist()}
        assert set(structure.coordinates_on(index)) == expected
    assert len(cross) == 2


def test_couplings_come_after_the_loops() -> None:
    mechanism = cd.load(
        gears(coupling("ab", "a", "b", 2.0), coupling("bc", "b", "c", 3.0), third=True)
    )
    structure = Structure(mechanism)
    bodies = {name: mechanism[name].id - 1 for name in "abc"}
    assert structure.paths == [[bodies["a"], bodies["b"]], [bodies["b"], bodies["c"]]]
    assert set(structure.bases) == {-1}
    assert structure.ranks(mechanism.coordinates.neutral(), {0, 1, 2}) == []


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        # Planar, spherical, and spatial chains.
        ("four_bar", [3]),
        ("slider_crank", [3]),
        ("universal_joint", [3]),
        ("stewart_platform", [6] * 5),
    ],
)
def test_ranks_of_open_chains(name: str, expected: list[int]) -> None:
    assert ranks_of(cd.load(name)) == expected


@pytest.mark.parametrize("length", [1e-9, 1.0, 1e9])
@pytest.mark.parametrize("planar", [False, True])
def test_ranks_do_not_depend_on_the_unit_of_length(length: float, planar: bool) -> None:
    """A piston on a rail is welded to it: both of its joints slide along the same axis."""
    expected = {False: {"piston_pin": 3}, True: {"piston_pin": 3, "bolt": 3}}[planar]
    mechanism = cd.load(tilted_slider_crank(length, planar))
    ranks = dict(zip((item.joint for item in mechanism.loops), ranks_of(mechanism), strict=True))
    assert ranks == expected


@pytest.mark.parametrize("length", [1e-12, 1.0, 1e12])
def test_a_slide_counts_in_lengths(length: float) -> None:
    mechanism = cd.load(carriage(length))
    assert ranks_of(mechanism, "s") == [1]
    assert ranks_of(mechanism, "h") == [1]
    # At different positions of the carriage, turns of the arm differ by a motion along z.
    assert ranks_of(mechanism) == [3]


def test_loops_far_from_the_body_that_carries_them_keep_their_rank() -> None:
    text = four_bar(loop("continuous"))
    for at in ("0 0 0", "2 0 0"):
        x, y, z = map(float, at.split())
        text = text.replace(
            f'<parent link="ground"/><child link="{"crank" if x == 0.0 else "rocker"}"/>\n'
            f'  <origin xyz="{at}"/>',
            f'<parent link="ground"/><child link="{"crank" if x == 0.0 else "rocker"}"/>\n'
            f'  <origin xyz="{x + 1e7!r} {y - 1e7!r} {z + 1e7!r}"/>',
        )
    assert text.count("10000002.0") == 1
    assert ranks_of(cd.load(text)) == [3]


def test_joints_that_rest_take_their_motion_from_the_rank() -> None:
    mechanism = cd.load(four_bar(loop("continuous")))
    assert ranks_of(mechanism, "a") == [3]
    assert ranks_of(mechanism, "a", "b") == [2]
    assert ranks_of(mechanism, "a", "b", "c", "d") == [0]


def wrist(bend: float) -> tuple[cd.Mechanism, np.ndarray]:
    """Hinges about x, y and x that meet in a point; the middle one is to rest at an angle."""
    names = ("first", "second", "third")
    text = '<robot name="wrist"><link name="ground"/>' + "".join(
        LINK.format(name=name, com="0 0 0.1", mass="1") for name in names
    )
    for parent, child, axis in zip(
        ("ground", *names), names, ("1 0 0", "0 1 0", "1 0 0"), strict=False
    ):
        text += (
            f'<joint name="to_{child}" type="continuous"><parent link="{parent}"/>'
            f'<child link="{child}"/><axis xyz="{axis}"/></joint>'
        )
    text += (
        '<loop name="c" type="fixed"><predecessor link="third"><origin xyz="0 0 1"/></predecessor>'
        '<successor link="ground"><origin xyz="0 0 1"/></successor></loop></robot>'
    )
    mechanism = cd.load(text)
    x = mechanism.coordinates.neutral()
    x[mechanism.coordinates.columns["to_second"]] = bend
    return mechanism, x


@pytest.mark.parametrize(("bend", "rank"), [(0.0, 1), (0.3, 3), (np.pi, 1)])
def test_joints_that_rest_count_with_their_positions(bend: float, rank: int) -> None:
    """With the middle hinge straight or folded, the axes of the other two stay in line.

    Otherwise the last axis moves on a cone; all configurations together span every rotation.
    """
    mechanism, x = wrist(bend)
    resting = mechanism.coordinates.velocity_columns["to_second"].start
    assert Structure(mechanism).ranks(x, {0, 1, 2} - {resting}) == [rank]
    assert Structure(mechanism).ranks(x, {0, 1, 2}) == [3]


def test_closed_loops_may_have_fewer_equations_than_open_ones() -> None:
    """Of the six equations of a loop with a slip, four are left between two universal joints."""
    mechanism = cd.load(design_line(2))
    velocities = mechanism.coordinates.velocity_columns
    moving = set(range(mechanism.model.nv)) - {velocities[name].start for name in nominal(2)}
    structure, x = Structure(mechanism), mechanism.coordinates.neutral()
    assert structure.ranks(x, moving) == [3, 6]
    assert structure.ranks_at(x, moving) == [3, 4]
    # Open, it has as many as it has moving joints at a single position.
    x[mechanism.coordinates.columns["angle_2"]] = 0.3
    x[mechanism.coordinates.columns["slip_1"]] = 0.1
    assert structure.ranks_at(x, moving) == [3, 5]


def test_dead_points_have_fewer_equations_than_the_motion() -> None:
    mechanism = four_bar_of(1.0, 1.0, 2.0)
    x = mechanism.coordinates.neutral()
    assert Structure(mechanism).ranks_at(x, set(range(4))) == [3]
    for name, turn in (("A", 0.5), ("B", -0.5), ("D", 0.5), ("C", 0.5)):
        x[mechanism.coordinates.columns[name]] = turn * np.pi
    assert Structure(mechanism).ranks_at(x, set(range(4))) == [2]
