"""MuJoCo: the open chain with its output axis in a `connect` constraint.

The input is held by an armature with so much inertia that nothing moves it: a soft equality on its
joint would add an error of its own. Where the mechanism settles, that equality holds it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import mujoco
import numpy as np

from .common import Method, pin_angles, split

MODEL = """<mujoco>
<compiler angle="radian"/>
<option gravity="0 0 0" timestep="0.001" iterations="200" tolerance="{tolerance}"
  integrator="implicitfast"/>
<worldbody>
  <site name="bearing" pos="{x} {y} 0"/>
  <body name="shaft_in">
    <joint name="bearing_in" axis="1 0 0" damping="{damping}" armature="{armature}"/>
    <inertial pos="-0.2 0 0" mass="1" diaginertia="0.01 0.02 0.02"/>
    <body name="cross">
      <joint name="pin_in" axis="0 1 0" damping="{damping}"/>
      <inertial pos="0 0 0" mass="0.1" diaginertia="0.001 0.001 0.001"/>
      <body name="shaft_out">
        <joint name="pin_out" axis="0 0 1" damping="{damping}"/>
        <inertial pos="0.2 0 0" mass="1" diaginertia="0.01 0.02 0.02"/>
        <site name="end" pos="1 0 0"/>
      </body>
    </body>
  </body>
</worldbody>
<equality>
  <connect site1="end" site2="bearing" {soft}/>
  {drive}
</equality>
</mujoco>"""
STIFF = 'solimp="0.9999 0.9999 0.001 0.5 2" solref="0.002 1"'


def _prepare(
    beta: float, phi: np.ndarray, soft: str, tolerance: float, settle: int
) -> Callable[[], np.ndarray]:
    xml = MODEL.format(
        x=repr(float(np.cos(beta))),
        y=repr(float(np.sin(beta))),
        soft=soft,
        tolerance=tolerance,
        damping=10.0 if settle else 0.0,
        armature=0.0 if settle else 1e6,
        drive=f'<joint name="drive" joint1="bearing_in" {soft}/>' if settle else "",
    )
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    axis = np.array([np.cos(beta), np.sin(beta), 0.0])
    bodies = [model.body(name).id for name in ("cross", "shaft_out")]
    root = model.body("shaft_in").id

    def run() -> np.ndarray:
        q = np.stack([phi, *pin_angles(beta, phi)], axis=1)
        wrenches = np.empty((len(phi), 2, 6))
        centres = np.empty((len(phi), 1, 3))
        for sample, row in enumerate(q):
            data.qpos[:] = row
            data.qvel[:] = 0.0
            data.qacc_warmstart[:] = 0.0
            if settle:
                model.equality("drive").data[0] = row[0]
            data.xfrc_applied[bodies[1], 3:] = -axis
            for _ in range(settle):
                mujoco.mj_step(model, data)
            mujoco.mj_forward(model, data)
            mujoco.mj_rnePostConstraint(model, data)
            # Moment first, about the centre of mass of the whole chain.
            wrenches[sample] = data.cfrc_int[bodies]
            centres[sample] = data.subtree_com[root]
        moments = wrenches[:, :, :3] + np.cross(centres, wrenches[:, :, 3:])
        return split(moments[:, 0], moments[:, 1], beta)

    return run


def methods() -> list[Method]:
    """Return default, stiff and settled settings."""
    version, by_hand = mujoco.__version__, "loop closed by the user"
    return [
        Method(
            "MuJoCo, defaults",
            version,
            f"connect, default solref and solimp; {by_hand}",
            partial(_prepare, soft="", tolerance=1e-8, settle=0),
        ),
        Method(
            "MuJoCo, stiff",
            version,
            f"connect, solimp 0.9999, tolerance 1e-15; {by_hand}",
            partial(_prepare, soft=STIFF, tolerance=1e-15, settle=0),
        ),
        Method(
            "MuJoCo, settled",
            version,
            f"as stiff, damped, 300 steps per position; {by_hand}",
            partial(_prepare, soft=STIFF, tolerance=1e-15, settle=300),
            samples=73,
        ),
    ]
