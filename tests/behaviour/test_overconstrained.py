"""Loops that move by their dimensions alone: ranks, self-stresses and sweeps against screws."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from testkit.clemens import Clemens
from testkit.free_screws import Connection, FreeBodies, free_bodies
from testkit.hinge_loops import (
    Hinge,
    altmann,
    bennett,
    bricard,
    description,
    flat_spherical,
    goldberg_5,
    goldberg_6,
    hinge,
    line_symmetric,
    open_components,
    planar,
    rank,
    robot,
    sarrus,
    spherical,
    stretched_sarrus,
)

import cardan_dyn as cd

pytestmark = pytest.mark.usefixtures("loaded_once")

LOOPS = {
    "bennett": 3,
    "goldberg_5": 4,
    "goldberg_6": 5,
    "bricard": 5,
    "line_symmetric": 5,
    "altmann": 5,
    "sarrus": 5,
    "planar": 3,
    "spherical": 3,
}
MAKERS: dict[str, Callable[[], list[Hinge]]] = {
    "bennett": bennett,
    "goldberg_5": goldberg_5,
    "goldberg_6": goldberg_6,
    "bricard": bricard,
    "line_symmetric": line_symmetric,
    "altmann": altmann,
    "sarrus": sarrus,
    "planar": planar,
    "spherical": spherical,
}
SINGULAR: dict[str, tuple[Callable[[], list[Hinge]], int, int]] = {
    "sarrus": (stretched_sarrus, 4, 5),
    "spherical": (flat_spherical, 2, 3),
}
"""Loops in singular configurations, with their rank there and elsewhere."""
ARMS = {"two": [0.3, 2.2], "three": [0.3, 2.4, 4.5], "unequal": [0.3, 1.0, 3.7, 5.1]}
"""Angles of a Clemens coupling's arms about its first shaft [rad]."""


def on_free_bodies(hinges: list[Hinge]) -> FreeBodies:
    """What screws on free bodies say of a loop whose first link is the world."""
    count = len(hinges)
    joints = [
        Connection(f"h{index}", index - 1, index % (count - 1) if index else 0, *_of(item))
        for index, item in enumerate(hinges)
    ]
    joints[-1] = joints[-1]._replace(second=-1)
    return free_bodies(count - 1, joints)


def _of(item: Hinge) -> tuple[np.ndarray, np.ndarray]:
    return item.screw[None], item.frame


def parted(words: str) -> tuple[str, str]:
    """Letters of force and moment that a report calls open."""
    found = dict(part.split() for part in words.split(", ") if part)
    return found.get("force", ""), found.get("moment", "")


@pytest.mark.parametrize("turned", [0.0, 0.02, 0.1], ids=["closed", "nearly", "open"])
@pytest.mark.parametrize("name", LOOPS)
def test_ranks_are_those_of_the_screws(name: str, turned: float) -> None:
    hinges = MAKERS[name]()
    assert rank(hinges) == LOOPS[name]
    free = on_free_bodies(hinges)
    assert (free.mobility, free.self_stresses) == (1, 6 - LOOPS[name])
    angles = [turned * (-1.0) ** index / (1.0 + index) for index in range(len(hinges) - 1)]
    report = cd.describe(cd.load(robot(description(hinges, turned=angles))))
    assert (report.coordinates, report.rank) == (len(hinges), LOOPS[name])
    assert report.mobility == 1
    (component,) = report.components
    assert component.self_stresses == 6 - LOOPS[name]
    assert not component.is_singular_at_zero
    (loop,) = report.loops
    assert (loop.rank, loop.redundant) == (LOOPS[name], 6 - LOOPS[name])


@pytest.mark.parametrize("name", LOOPS)
def test_open_components_are_those_of_wrenches_without_work(name: str) -> None:
    hinges = MAKERS[name]()
    (loop,) = cd.describe(cd.load(robot(description(hinges)))).loops
    assert loop.indeterminate is not None
    for index, item in enumerate(hinges):
        force, moment = open_components(hinges, item)
        assert parted(loop.indeterminate.get(f"h{index}", "")) == (force, moment)
        assert "z" not in moment


@pytest.mark.parametrize("name", LOOPS)
def test_sweeps_agree_with_the_description(name: str) -> None:
    hinges = MAKERS[name]()
    mechanism = cd.load(robot(description(hinges)))
    turn = cd.Scene(mechanism, drive="h0", gravity=[0.0, 0.0, -9.81]).sweep(
        np.linspace(-0.05, 0.05, 7), speed=2.0
    )
    assert turn.loop_residual < 1e-12
    assert turn.balance_residual < 1e-10
    (loop,) = cd.describe(mechanism).loops
    for joint in mechanism.joint_names:
        words = dict(
            part.split() for part in (loop.indeterminate or {}).get(joint, "").split(", ") if part
        )
        unique = turn[joint].unique
        for offset, vector in ((0, "force"), (3, "moment")):
            is_open = [axis in words.get(vector, "") for axis in "xyz"]
            np.testing.assert_array_equal(~unique[offset : offset + 3], is_open)


@pytest.mark.parametrize("name", LOOPS)
def test_both_ways_to_find_open_components_agree(name: str) -> None:
    """Self-stresses of free bodies, and wrenches that do no work on any hinge of the loop."""
    hinges = MAKERS[name]()
    free = on_free_bodies(hinges)
    for index, item in enumerate(hinges):
        assert free.open[f"h{index}"] == open_components(hinges, item)


@pytest.mark.parametrize("name", SINGULAR)
def test_singular_zeros_have_the_rank_of_their_screws(name: str) -> None:
    make, at_zero, elsewhere = SINGULAR[name]
    hinges = make()
    assert rank(hinges) == at_zero
    (component,) = cd.describe(cd.load(robot(description(hinges)))).components
    assert (component.rank_at_zero, component.rank) == (at_zero, elsewhere)
    assert component.is_singular_at_zero


@pytest.mark.parametrize("bend", [0.0, 0.6])
@pytest.mark.parametrize("turned", [0.0, 0.1, 0.3], ids=["closed", "open", "wide open"])
@pytest.mark.parametrize("arms", ARMS)
def test_clemens_couplings_are_those_of_free_bodies(arms: str, turned: float, bend: float) -> None:
    turns = ARMS[arms]
    free = free_bodies(*Clemens(bend, turns).connections())
    # Grübler: every pair of arms beyond the first takes a freedom too many.
    assert (free.mobility, free.self_stresses) == (1, len(turns) - 1)
    report = cd.describe(cd.load(Clemens(bend, turns).text(turned)))
    (component,) = report.components
    assert (report.mobility, component.self_stresses) == (1, len(turns) - 1)
    assert not component.is_singular_at_zero
    found: dict[str, tuple[str, str]] = {}
    for item in report.loops:
        found |= {name: parted(words) for name, words in (item.indeterminate or {}).items()}
    assert found == free.open
    # What no loop has by itself is said of all of them together.
    text = str(report)
    alone = sum(item.redundant for item in report.loops)
    is_said = f"{free.self_stresses} self-stresses" in text
    assert is_said == (" redundant by itself" in text) == (free.self_stresses > alone)


@pytest.mark.parametrize("arms", ARMS)
def test_clemens_couplings_turn_both_shafts_alike(arms: str) -> None:
    mechanism = cd.load(Clemens(0.6, ARMS[arms]).text())
    turn = cd.Scene(mechanism, drive="in", loads={"out": -3.0}, gravity=[0.0, -9.81, 0.0]).sweep(
        np.linspace(0.0, 2.0 * np.pi, 25), speed=5.0
    )
    np.testing.assert_allclose(turn.motion.position("out"), turn.position, atol=1e-11)
    assert turn.loop_residual < 1e-12
    assert turn.balance_residual < 1e-11
    assert turn.power_residual < 1e-11
    free = free_bodies(*Clemens(0.6, ARMS[arms]).connections())
    for joint in mechanism.joint_names:
        unique = ["".join(np.array(list("xyz"))[~part]) for part in np.split(turn[joint].unique, 2)]
        assert tuple(unique) == free.open[joint]


def test_mechanisms_in_one_file_are_described_separately() -> None:
    mechanism = cd.load(robot(description(bennett(), "b_"), description(planar(), "p_")))
    report = cd.describe(mechanism)
    assert (report.coordinates, report.rank, report.mobility) == (8, 6, 2)
    found = {item.loops: (item.rank, item.self_stresses) for item in report.components}
    assert found == {("b_h3",): (3, 3), ("p_h3",): (3, 3)}
    assert "2 components b_h3, p_h3: mobility 1 of 4 coordinates, 3 independent" in str(report)
    for loop in report.loops:
        prefix = loop.name[:2]
        assert loop.indeterminate is not None
        assert {name[:2] for name in loop.indeterminate} == {prefix}


def test_singular_zeros_are_named() -> None:
    """All hinges of a planar linkage in one plane with its links in line: a change point."""
    hinges = [hinge((x, 0.0, 0.0), (0.0, 0.0, 1.0)) for x in (0.0, 1.0, 3.0, 2.0)]
    assert rank(hinges) == 2
    report = cd.describe(cd.load(robot(description(hinges))))
    (component,) = report.components
    assert (component.rank, component.rank_at_zero) == (3, 2)
    assert component.is_singular_at_zero
    assert "the description's zero is a singular configuration of h3: only 2 of 3" in str(report)
    assert "singular configuration" in report._repr_html_()
