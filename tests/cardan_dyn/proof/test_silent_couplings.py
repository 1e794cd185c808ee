"""Couplings that state no forces, and teeth: false flags and false claims are refused."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.claims import RATES, bent, claimed, refused
from testkit.linkages import coupling, four_bar, gears, loop

import cardan_dyn as cd


def scene_of(stated: str) -> cd.Scene:
    text = gears(coupling("teeth", "a", "b", -2.5, stated))
    return cd.Scene(cd.load(text), drive="a", loads={"b": 7.0}, gravity=(1.0, -2.0, 3.0))


@pytest.mark.parametrize("stated", ["", 'forces="none"', 'forces="mesh"'])
def test_false_flags_are_refused(stated: str) -> None:
    scene = scene_of(stated)
    bodies, claim, _ = claimed(scene, **RATES)
    flags = np.full((2, 6), stated != "")
    assert np.array_equal(scene.sweep([0.0]).unique, flags)
    bodies.prove_flags(claim.x, flags)
    if stated:
        return
    for joint, component in np.ndindex(flags.shape):
        false = flags.copy()
        false[joint, component] = True
        with pytest.raises(cd.AccuracyError, match="flagged unique, but changes"):
            bodies.prove_flags(claim.x, false)


def test_false_claims_of_teeth_are_refused() -> None:
    bodies, claim, where = claimed(scene_of('forces="mesh" helix_angle="0.3"'), **RATES)
    assert not refused(bodies, claim, where)
    for joint, component in np.ndindex(2, 6):
        false = bent(claim.wrenches, (3, joint, component), 1e-6)
        assert refused(bodies, claim._replace(wrenches=false), where)
    assert refused(bodies, claim._replace(couplings=bent(claim.couplings, (3, 0), 1e-6)), where)


def test_forces_pass_around_the_loops_between_coupled_joints() -> None:
    """A wheel on the coupler of a four-bar that another one on the ground follows."""
    wheels = """<link name="near"/><link name="far"/><link name="beside"/>
      <joint name="w" type="continuous"><parent link="coupler"/><child link="near"/>
        <axis xyz="0 0 1"/></joint>
      <joint name="v" type="continuous"><parent link="ground"/><child link="far"/>
        <axis xyz="0 0 1"/><mimic joint="w"/></joint>
      <joint name="u" type="continuous"><parent link="rocker"/><child link="beside"/>
        <axis xyz="0 0 1"/></joint></robot>"""
    for kind in ("continuous", "spherical"):
        text = four_bar(loop(kind)).replace("</robot>", wheels)
        scene = cd.Scene(cd.load(text), drive=["a", "v", "u"], loads={"w": 1.0})
        turn = scene.sweep(np.zeros((1, 3)) + 0.1)
        for name in "abd":
            assert turn[name].unique.tolist() == [False] * 5 + [True], name
        closed = [False] * 5 + [True] if kind == "continuous" else [False] * 3 + [True] * 3
        (closing,) = [item.joint for item in scene.mechanism.loops]
        assert turn[closing].unique.tolist() == closed
        assert turn["u"].unique.all()
        assert not turn["w"].unique.any()
        assert not turn["v"].unique.any()
