"""Chains: what hangs together without the world, against mechanisms put together by hand."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.linkages import coupling, four_bar, gears, loop
from testkit.many import in_one

import cardan_dyn as cd
from cardan_dyn.motion.simulation.constrained_model import Chain, chains_of


def joints_of(mechanism: cd.Mechanism, chain: Chain) -> set[str]:
    return {
        name
        for name, joint in mechanism.joints.items()
        if any(part.id in chain.bodies for part in joint.parts)
    }


def test_small_ones_are_taken_together_and_great_ones_are_not() -> None:
    one = four_bar(loop("continuous"))
    assert len(chains_of(cd.load(one))) == 1
    # A four-bar has four joints, so that four of them are sixteen coordinates.
    for count, expected in ((4, [16]), (5, [16, 4]), (9, [16, 16, 4])):
        chains = chains_of(cd.load(in_one(one, count)))
        assert [len(chain.rates) for chain in chains] == expected
        assert [len(chain.loops) for chain in chains] == [size // 4 for size in expected]


def test_every_coordinate_is_in_one_chain() -> None:
    mechanism = cd.load(in_one(four_bar(loop("continuous")), 7))
    chains = chains_of(mechanism)
    columns = np.concatenate([chain.columns for chain in chains])
    rates = np.concatenate([chain.rates for chain in chains])
    assert sorted(columns.tolist()) == list(range(mechanism.coordinates.size))
    assert sorted(rates.tolist()) == list(range(mechanism.model.nv))


@pytest.mark.parametrize("name", ["a", "c"])
def test_loops_and_couplings_hold_chains_together(name: str) -> None:
    """Gears that only couplings connect, in a row of copies that are each too great to share."""
    three = gears(coupling("m", "a", "b", -0.5), coupling("n", "b", "c", 3.0), third=1)
    mechanism = cd.load(in_one(three, 12))
    chains = chains_of(mechanism)
    assert len(chains) > 1
    for chain in chains:
        held = joints_of(mechanism, chain)
        for index in range(12):
            together = {f"{joint}_{index}" in held for joint in "abc"}
            assert len(together) == 1
        assert len(chain.couplings) == 2 * sum(f"{name}_{index}" in held for index in range(12))


def test_balls_keep_their_four_columns() -> None:
    text = """<robot name="b"><link name="ground"/><link name="bob"><inertial><mass value="1"/>
      <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <joint name="ball" type="spherical"><parent link="ground"/><child link="bob"/></joint>
      </robot>"""
    mechanism = cd.load(in_one(text, 7))
    chains = chains_of(mechanism)
    assert [(chain.columns.size, chain.rates.size) for chain in chains] == [(20, 15), (8, 6)]
    assert chains[1].columns.tolist() == list(range(20, 28))
