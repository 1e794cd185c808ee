"""Models in MJCF: single bodies, and the four-bar of `linkages`, whose loop is an equality."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

import cardan_dyn as cd

from .linkages import POSITIONS, RATES, four_bar, loop
from .scenes import relative

BODY = '<mujoco>{head}<worldbody><body name="b">{body}</body></worldbody>{tail}</mujoco>'
INERTIAL = '<inertial pos="0 0 0" mass="1" diaginertia="{}"/>'
HALVES = """<mujoco model="four_bar"><compiler angle="radian"/><worldbody>
<body name="crank"><inertial pos="0 0.25 0" mass="1" diaginertia="0.02 0.03 0.025"/>
  <joint name="a" axis="0 0 1"/><body name="coupler" pos="0 0.5 0"><site name="s_1" pos="2 2 0"/>
    <inertial pos="1 1 0" mass="2" diaginertia="0.02 0.03 0.025"/><joint name="b"/></body></body>
{rocker}</worldbody>{more}</mujoco>"""
ROCKER = """<body name="rocker" pos="2 0 0"><joint name="d" axis="0 0 1"/>
<inertial pos="0 1.25 0" mass="3" diaginertia="0.02 0.03 0.025"/>
<site name="s_2" pos="0 2.5 0" euler="0.3 0 0.4"/></body>"""
CONNECTS = {
    "bodies": '<connect name="c" body1="coupler" body2="rocker" anchor="2 2 0"/>',
    "swapped": '<connect name="c" body1="rocker" body2="coupler" anchor="0 2.5 0"/>',
    "sites": '<connect name="c" site1="s_1" site2="s_2"/>',
}


def of_body(body: str, head: str = "", tail: str = "") -> str:
    return BODY.format(body=body, head=head, tail=tail)


def placed(mechanism: cd.Mechanism, coordinates: dict[str, float]) -> dict[str, pin.SE3]:
    """Return the placements of all links in the world."""
    model = mechanism.model
    step = np.zeros(model.nv)
    for name, value in coordinates.items():
        step[model.idx_vs[mechanism.joints[name].id]] = value
    data = model.createData()
    pin.forwardKinematics(model, data, pin.integrate(model, pin.neutral(model), step))
    return {name: data.oMi[body] * placement for name, (body, placement) in mechanism.links.items()}


def same_as_urdf(mechanism: cd.Mechanism, sign: float = 1.0, kind: str = "spherical") -> None:
    found, reference = (
        cd.Scene(item, drive="a", loads={"d": -3.0}).sweep(POSITIONS, **RATES)
        for item in (mechanism, cd.load(four_bar(loop(kind))))
    )
    assert relative(found.drive_effort, reference.drive_effort) < 1e-12
    for name in "abcd":
        force = reference.wrench(name, "world").force[:, :2] * (sign if name == "c" else 1.0)
        assert relative(found.wrench(name, "world").force[:, :2], force) < 1e-11
