"""Loops that move by their dimensions alone: ranks, self-stresses and sweeps against screws."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from testkit.hinge_loops import (
    Hinge,
    bennett,
    bricard,
    description,
    hinge,
    open_components,
    planar,
    rank,
    robot,
    sarrus,
    spherical,
)

import cardan_dyn as cd

LOOPS = {"bennett": 3, "bricard": 5, "sarrus": 5, "planar": 3, "spherical": 3}
MAKERS: dict[str, Callable[[], list[Hinge]]] = {
    "bennett": bennett,
    "bricard": bricard,
    "sarrus": sarrus,
    "planar": planar,
    "spherical": spherical,
}


@pytest.mark.parametrize("name", LOOPS)
def test_ranks_are_those_of_the_screws(name: str) -> None:
    hinges = MAKERS[name]()
    assert rank(hinges) == LOOPS[name]
    report = cd.describe(cd.load(robot(description(hinges))))
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
        words = dict(
            part.split() for part in loop.indeterminate.get(f"h{index}", "").split(", ") if part
        )
        # The report covers configurations nearby, in which more components are open.
        assert set(force) <= set(words.get("force", ""))
        assert set(moment) <= set(words.get("moment", ""))
        assert "z" not in words.get("moment", "")


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


def test_mechanisms_in_one_file_are_described_separately() -> None:
    mechanism = cd.load(robot(description(bennett(), "b_"), description(planar(), "p_")))
    report = cd.describe(mechanism)
    assert (report.coordinates, report.rank, report.mobility) == (8, 6, 2)
    found = {item.loops: (item.rank, item.self_stresses) for item in report.components}
    assert found == {("b_h3",): (3, 3), ("p_h3",): (3, 3)}
    assert "component b_h3: mobility 1 of 4 coordinates, 3 independent equations" in str(report)
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
