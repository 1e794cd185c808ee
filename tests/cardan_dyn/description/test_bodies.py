"""Links that fixed joints make one body."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from cardan_dyn.core.description.bodies import bodies_of
from cardan_dyn.core.description.read import read

LINK = """<link name="{}"><inertial><mass value="{}"/><inertia ixx="1" iyy="1" izz="1"/></inertial>
</link>"""
JOINT = """<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/>
<origin xyz="1 2 3" rpy="0.4 0.5 0.6"/><axis xyz="0 0 1"/></joint>"""


def test_bodies() -> None:
    """`arm` on `base`, with `hand` and `tip` fixed in a row and `finger` on the tip, and a lid."""
    parts = [
        '<link name="base"/><link name="tip"/>',
        *(LINK.format(*of) for of in (("arm", 2), ("hand", 1), ("lid", 4), ("finger", 8))),
        JOINT.format("f2", "fixed", "hand", "tip"),
        JOINT.format("j", "continuous", "base", "arm"),
        JOINT.format("k", "prismatic", "tip", "finger"),
        JOINT.format("f1", "fixed", "arm", "hand"),
        JOINT.format("f3", "fixed", "base", "lid"),
        '<loop name="arm" type="spherical"><predecessor link="tip"/><successor link="lid"/></loop>',
    ]
    description = read(f'<robot name="r">{"".join(parts)}</robot>')
    bodies = bodies_of(description)
    step = pin.SE3(pin.rpy.rpyToMatrix(0.4, 0.5, 0.6), np.array([1.0, 2.0, 3.0]))
    arm, finger, ground = bodies["arm"], bodies["finger"], bodies["base"]
    assert arm is bodies["hand"] is bodies["tip"]
    assert ground is bodies["lid"]
    assert [link.name for link, _ in arm.links] == ["arm", "hand", "tip"]
    assert (arm.mass, finger.mass, ground.mass) == (3.0, 8.0, 4.0)
    for name, expected in (("arm", pin.SE3.Identity()), ("hand", step), ("tip", step * step)):
        np.testing.assert_allclose(arm.at(name), expected.homogeneous, atol=1e-14)
    np.testing.assert_allclose(finger.placement, (step * step * step).homogeneous, atol=1e-14)
    np.testing.assert_array_equal(finger.at("finger"), np.eye(4))
    assert [*finger.path()] == [finger, arm]
    assert [*ground.path()] == []
    assert (ground.children, arm.children) == ([arm], [finger])
    assert [body.joint and body.joint.name for body in (ground, arm, finger)] == [None, "j", "k"]
    assert (arm.loops, ground.loops) == ([*description.loops], [])
