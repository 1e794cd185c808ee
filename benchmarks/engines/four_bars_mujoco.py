"""MuJoCo: parallelograms in a row with a stiff `connect` per loop."""

from __future__ import annotations

import mujoco

_ROD = (
    '<body name="{name}" pos="{at}"><joint name="{joint}" axis="0 0 1"/><inertial pos="{centre}" '
    'mass="1" diaginertia="{inertia}"/>{inside}</body>'
)
_LONG, _THIN = "0.083333333333333333", "1e-3"


def made(count: int, duration: float, steps: int) -> tuple[mujoco.MjModel, int]:
    """Return the model, whose first coordinate is a crank's, and its number of steps."""
    bodies = connects = ""
    for k in range(count + 1):
        inside = f'<site name="tip_{k}" pos="0 -1 0"/>'
        if k < count:
            inside += _ROD.format(
                name=f"coupler_{k}",
                joint=f"pin_{k}",
                at="0 -1 0",
                centre="0.5 0 0",
                inertia=f"{_THIN} {_LONG} {_LONG}",
                inside=f'<site name="end_{k}" pos="1 0 0"/>',
            )
            connects += f'<connect site1="end_{k}" site2="tip_{k + 1}" {_stiff(duration / steps)}/>'
        bodies += _ROD.format(
            name=f"crank_{k}",
            joint=f"pivot_{k}",
            at=f"{k} 0 0",
            centre="0 -0.5 0",
            inertia=f"{_LONG} {_THIN} {_LONG}",
            inside=inside,
        )
    xml = (
        f'<mujoco><option gravity="0 -9.81 0" timestep="{duration / steps!r}" integrator="RK4" '
        'iterations="100" tolerance="1e-15"><flag contact="disable" energy="enable"/></option>'
        f"<worldbody>{bodies}</worldbody><equality>{connects}</equality></mujoco>"
    )
    return mujoco.MjModel.from_xml_string(xml), steps


def _stiff(step: float) -> str:
    return f'solimp="0.9999 0.9999 0.001 0.5 2" solref="{5.0 * step!r} 1"'


def started(model: mujoco.MjModel, data: mujoco.MjData, angle: float) -> None:
    """Set cranks to an angle, couplers level, at rest."""
    mujoco.mj_resetData(model, data)
    for index in range(model.njnt):
        sign = 1.0 if model.joint(index).name.startswith("pivot") else -1.0
        data.qpos[model.jnt_qposadr[index]] = sign * angle
