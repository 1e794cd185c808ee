"""MuJoCo spins: the open chain with its output axis in a `connect` constraint.

The output's centre of mass lies a little off the joint, where it does not move: if it were in the
centre, MuJoCo would scale the constraint by a compliance of zero and diverge.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import mujoco
import numpy as np

from ..spin import CROSS, SHAFT, Spin
from .spinning import Spinner

MODEL = """<mujoco>
<compiler angle="radian"/>
<option gravity="0 0 0" timestep="{step!r}" iterations="100" tolerance="1e-15"
  integrator="{integrator}"><flag contact="disable"/></option>
<worldbody>
  <site name="bearing" pos="{x!r} {y!r} 0"/>
  <body name="shaft_in">
    <joint name="bearing_in" axis="1 0 0"/>
    <inertial pos="0 0 0" mass="1" diaginertia="{shaft} {shaft} {shaft}"/>
    <body name="cross">
      <joint name="pin_in" axis="0 1 0"/>
      <inertial pos="0 0 0" mass="1" diaginertia="{cross} {cross} {cross}"/>
      <body name="shaft_out">
        <joint name="pin_out" axis="0 0 1"/>
        <inertial pos="0.1 0 0" mass="0.1" diaginertia="{shaft} {shaft} {shaft}"/>
        <site name="end" pos="1 0 0"/>
      </body>
    </body>
  </body>
</worldbody>
<equality><connect site1="end" site2="bearing" {soft}/></equality>
</mujoco>"""
_STIFF = 'solimp="0.9999 0.9999 0.001 0.5 2" solref="{time!r} 1"'


def model(spin: Spin, per_revolution: float, integrator: str, soft: float) -> mujoco.MjModel:
    """Return the model.

    Args:
        spin: the spin.
        per_revolution: steps.
        integrator: MuJoCo's name of it.
        soft: time constant of the constraint in steps; MuJoCo's default if 0.
    """
    step = spin.duration / round(per_revolution * spin.revolutions)
    xml = MODEL.format(
        step=step,
        integrator=integrator,
        x=float(np.cos(spin.beta)),
        y=float(np.sin(spin.beta)),
        shaft=SHAFT,
        cross=CROSS,
        soft=_STIFF.format(time=soft * step) if soft else "",
    )
    return mujoco.MjModel.from_xml_string(xml)


def start(model: mujoco.MjModel, data: mujoco.MjData, spin: Spin) -> None:
    """Set the state at the start."""
    mujoco.mj_resetData(model, data)
    data.qpos[:] = 0.0, 0.0, spin.beta
    data.qvel[:] = *spin.start_speeds[:2], 0.0


def _prepare(
    spin: Spin, per_revolution: float, integrator: str, soft: float
) -> Callable[[], float]:
    made = model(spin, per_revolution, integrator, soft)
    data = mujoco.MjData(made)
    count = round(per_revolution * spin.revolutions)

    def run() -> float:
        start(made, data, spin)
        mujoco.mj_step(made, data, count)
        return float(data.qpos[0])

    return run


def methods() -> list[Spinner]:
    """Return defaults, and the stiffest settings that are stable, of two integrators."""
    return [
        Spinner(
            f"MuJoCo {integrator}, {name}",
            mujoco.__version__,
            f"connect, {settings}; all steps in one call",
            levels,
            partial(_prepare, integrator=integrator, soft=soft),
        )
        for name, settings, soft in (
            ("defaults", "default solref and solimp", 0.0),
            ("stiff", "solref of 5 steps, solimp 0.9999", 5.0),
        )
        for integrator, levels in (
            ("Euler", (200.0, 600.0, 2000.0, 6000.0, 20_000.0)),
            ("RK4", (20.0, 60.0, 200.0, 600.0, 2000.0, 6000.0)),
        )
    ]
