"""Small mechanisms that vibrate: a universal joint with elastic shafts or elastic bearings.

World: the joint's centre is the origin, x points along the driven shaft, z is normal to the plane
of both shafts; at rotation zero the driving pin (y) lies in that plane.
"""

from __future__ import annotations

import numpy as np

import cardan_dyn as cd

_INERTIA = (
    '<inertial><origin xyz="{x} {y} 0"/><mass value="{mass}"/>'
    '<inertia ixx="{polar}" iyy="{across}" izz="{across}" ixy="0" ixz="0" iyz="0"/></inertial>'
)


def link(
    name: str, polar: float = 0.0, across: float | None = None, *, x: float = 0.0, y: float = 0.0
) -> str:
    """Return a link; without a polar inertia [kg m²], one without mass."""
    if not polar:
        return f'<link name="{name}"/>'
    inner = _INERTIA.format(
        x=x, y=y, mass=1.0, polar=polar, across=polar if across is None else across
    )
    return f'<link name="{name}">{inner}</link>'


def joint(name: str, parent: str, child: str, axis: str) -> str:
    """Return a joint at the origin of its parent that turns about x, y or z."""
    vector = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}[axis]
    return (
        f'<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>'
        f'<axis xyz="{vector}"/></joint>'
    )


def loop(name: str, predecessor: str, successor: str, axis: str) -> str:
    """Return a loop of a pin about y or z through the origins of both links."""
    vector = {"y": "0 1 0", "z": "0 0 1"}[axis]
    return (
        f'<loop name="{name}" type="continuous"><predecessor link="{predecessor}"/>'
        f'<successor link="{successor}"/><axis xyz="{vector}"/></loop>'
    )


def robot(*parts: str) -> cd.Mechanism:
    """Return the mechanism of some links, joints and loops."""
    return cd.load(f'<robot name="vibrating">{"".join(parts)}</robot>')


def torsional_line(
    beta: float,
    share: float,
    *,
    stiffness: float = 1.0,
    damping: float = 0.0,
    side: str = "input",
    behind: float = 1.0,
) -> cd.Scene:
    """Return a line with an elastic shaft, driven at `motor`.

    The inertias are 1 - share before and share behind the joint, so that the mean inertia and,
    with stiffness 1, the natural frequency are about 1.

    Args:
        beta: joint angle [rad].
        share: a = J₂/(J₁ + J₂).
        stiffness: of the shaft [N·m/rad].
        damping: of the shaft [N·m·s/rad].
        side: "input": the shaft connects motor and joint; "output": joint and flywheel; "both".
        behind: stiffness of the second shaft, with "both".
    """
    parts = [link("base"), link("motor", 1.0), joint("motor", "base", "motor", "x")]
    drives, springs = ["motor"], []
    before = "motor"
    if side in ("input", "both"):
        parts += [link("shaft_in", 1.0 - share), joint("twist_in", "motor", "shaft_in", "x")]
        springs.append(cd.JointSpring("twist_in", stiffness, damping))
        drives.append("twist_in")
        before = "shaft_in"
    parts += [link("cross"), joint("pin_in", before, "cross", "y"), link("housing")]
    parts += [joint("joint_angle", "base", "housing", "z")]
    output = share if side == "input" else 1e-30
    parts += [link("shaft_out", output), joint("bearing_out", "housing", "shaft_out", "x")]
    if side in ("output", "both"):
        parts += [link("flywheel", share), joint("twist_out", "shaft_out", "flywheel", "x")]
        springs.append(
            cd.JointSpring("twist_out", stiffness if side == "output" else behind, damping)
        )
        drives.append("twist_out")
    parts.append(loop("pin_out", "cross", "shaft_out", "z"))
    return cd.Scene(robot(*parts), drive=drives, held={"joint_angle": beta}, elements=springs)


def elastic_rig(
    beta: float,
    polar: float = 0.1,
    *,
    damping_ratio: float = 0.01,
    across: float = 1.0,
    stiffness: float = 1.0,
    unbalance: float = 0.0,
    load: float = 0.0,
) -> cd.Scene:
    """Return Thoma's rig whose shaft 2 tilts about the joint's centre on springs.

    Args:
        beta: joint angle [rad].
        polar: Θ of shaft 2 [kg m²].
        damping_ratio: of both tilts.
        across: A, about the joint's centre [kg m²].
        stiffness: c of both tilts [N·m/rad].
        unbalance: place of shaft 2's centre of gravity (1 kg) beside its axis, 0.5 m along it [m].
        load: torque along shaft 2 [N·m].
    """
    damping = 2.0 * damping_ratio * np.sqrt(stiffness * across)
    shaft = link("shaft_out", polar, across)
    if unbalance:
        shaft = link("shaft_out", polar, across - 0.25, x=0.5, y=unbalance)
    mechanism = robot(
        link("base"),
        link("shaft_in", 1.0),
        joint("bearing_in", "base", "shaft_in", "x"),
        link("cross"),
        joint("pin_in", "shaft_in", "cross", "y"),
        link("housing"),
        joint("joint_angle", "base", "housing", "z"),
        link("gimbal"),
        joint("tilt_y", "housing", "gimbal", "y"),
        link("carrier"),
        joint("tilt_z", "gimbal", "carrier", "z"),
        shaft,
        joint("bearing_out", "carrier", "shaft_out", "x"),
        loop("pin_out", "cross", "shaft_out", "z"),
    )
    return cd.Scene(
        mechanism,
        drive=["bearing_in", "tilt_y", "tilt_z"],
        held={"joint_angle": beta},
        loads={"bearing_out": load} if load else None,
        elements=[cd.JointSpring(name, stiffness, damping) for name in ("tilt_y", "tilt_z")],
    )
