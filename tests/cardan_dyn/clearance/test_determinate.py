"""Whether forces across pins are known, in mechanisms that other joints hold twice."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn import IndeterminateError, clearance
from cardan_dyn.motion.clearance.opened_joint import what_is_open

CONTACT: dict[str, Any] = {"clearance": 1e-4, "stiffness": 1e8, "damping_ratio": 0.25}
URDF = Path(__file__).parents[3] / "urdf" / "slider_crank.urdf"
LINK = (
    '<link name="{}"><inertial><origin xyz="{} 0 0"/><mass value="1"/><inertia ixx="0.01" '
    'iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>'
)
TURN = '<joint name="{}" type="continuous"><parent link="{}"/><child link="{}"/>{}</joint>'
LOOP = (
    '<loop name="{0}" type="continuous"><predecessor link="bar"><origin xyz="{1}"/></predecessor>'
    '<successor link="{2}"><origin xyz="0.1 0 0"/></successor><axis xyz="0 0 1"/></loop>'
)
AXIS = '<axis xyz="0 0 1"/>'


def oblique() -> cd.Mechanism:
    """The slider-crank; the frame of its piston pin is turned about x, its axis is as it was."""
    head, tail = URDF.read_text(encoding="utf-8").split('<loop name="piston_pin"')
    for place in ("0.15 0 0", "0 0 0"):
        tail = tail.replace(f'<origin xyz="{place}"/>', f'<origin xyz="{place}" rpy="0.5 0 0"/>')
    axis = f'<axis xyz="0 {float(np.sin(0.5))!r} {float(np.cos(0.5))!r}"/>'
    return cd.load(head + '<loop name="piston_pin"' + tail.replace(AXIS, axis))


def parallel_cranks() -> cd.Mechanism:
    """A bar on three equal cranks: how two of them share its force along the cranks is open."""
    text = [LINK.format(name, 0.05) for name in ("one", "two", "three")]
    text += ['<link name="base"/>', LINK.format("bar", 0.2)]
    for name, place in (("one", "0 0 0"), ("two", "0.2 0 0"), ("three", "0.4 0.1 0")):
        text.append(TURN.format(f"at_{name}", "base", name, f'<origin xyz="{place}"/>' + AXIS))
    text.append(TURN.format("pin_one", "one", "bar", '<origin xyz="0.1 0 0"/>' + AXIS))
    text += [
        LOOP.format("pin_two", "0.2 0 0", "two"),
        LOOP.format("pin_three", "0.4 0.1 0", "three"),
    ]
    return cd.load(f'<robot name="parallel_cranks">{"".join(text)}</robot>')


@pytest.mark.slow
def test_frames_oblique_to_the_pin_change_nothing() -> None:
    """Forces along pins are open in any planar linkage, and so is each component of this frame."""
    plain = cd.Scene(cd.load("slider_crank"), drive="crank_bearing")
    turned = cd.Scene(oblique(), drive="crank_bearing")
    wanted, found = (clearance.scan(scene, 150.0, **CONTACT) for scene in (plain, turned))
    responded = clearance.scan(turned.response(), 150.0, **CONTACT)
    for name in wanted:
        for other in (found[name], responded[name]):
            for one, two in zip(wanted[name].reversals, other.reversals, strict=True):
                assert two.peak == pytest.approx(one.peak, rel=1e-9)
                assert two.position == pytest.approx(one.position, abs=1e-9)
    assert wanted["piston_pin"].reversals
    started = clearance.simulate(turned, 150.0, joints="piston_pin", turns=0.01, **CONTACT)
    assert np.isnan(started.impacts[0].speed)  # Pressed, as it is where the force is known.


def test_what_rigid_links_leave_open_stays_refused_whatever_the_compliance() -> None:
    compliance = {
        name: [1e-7] * 3 + [1e-4] * 3
        for name in ("at_one", "at_two", "at_three", "pin_one", "pin_two", "pin_three")
    }
    for given in (None, compliance):
        scene = cd.Scene(parallel_cranks(), drive="at_one", compliance=given)
        sweep = scene.sweep(np.linspace(0.3, 2.8, 5), 100.0)
        assert "force x" in what_is_open(scene.solver, sweep, "pin_two")
        with pytest.raises(IndeterminateError, match="what holds it twice"):
            clearance.scan(scene, 100.0, joints="pin_two", **CONTACT)


@pytest.mark.slow
def test_no_damping_ratio_without_a_mass() -> None:
    scene = cd.Scene(parallel_cranks(), drive="at_one")
    with pytest.raises(IndeterminateError, match=r"damping_ratio of joint 'pin_two'.*give law="):
        clearance.simulate(scene, 100.0, joints="pin_two", **CONTACT)
    law = clearance.LinearContact(1e7, damping=1e3)
    found = clearance.simulate(scene, 100.0, joints="pin_two", clearance=1e-4, law=law, turns=0.01)
    assert found["pin_two"].depth[0] < 0.0
