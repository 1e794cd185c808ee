"""A drive line whose joint angles, fork phases and lengths are held joints, of any length."""

from __future__ import annotations

import numpy as np

from testkit.drive_lines import CROSS

_SHAFT = (
    '<link name="{name}"><inertial><origin xyz="0.2 0.01 0"/><mass value="4"/><inertia ixx="0.01" '
    'iyy="0.11" izz="0.12" ixy="0" ixz="0" iyz="0"/></inertial></link>'
)
_LENGTH = 0.5


def _joint(
    name: str, kind: str, parent: str, child: str, axis: str = "1 0 0", at: str = "0 0 0"
) -> str:
    limit = '<limit lower="-3" upper="3" effort="1" velocity="1"/>'
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at}"/><axis xyz="{axis}"/>{"" if kind == "continuous" else limit}</joint>'
    )


def design_line(count: int) -> str:
    """Return a line of joints: `angle_k` bends joint k, behind it `phase_k` and `length_k`.

    A slide (`slip_k`) in the shaft behind joint k follows its length.
    """
    urdf = '<link name="base"/>' + _SHAFT.format(name="front_0")
    urdf += _joint("bearing_0", "continuous", "base", "front_0")
    before, carrier = "front_0", "base"
    for k in range(1, count + 1):
        urdf += CROSS.format(name=f"cross_{k}") + _SHAFT.format(name=f"front_{k}")
        urdf += f'<link name="housing_{k}"/>'
        urdf += _joint(f"pin_{k}_in", "continuous", before, f"cross_{k}", "0 1 0")
        urdf += _joint(f"angle_{k}", "revolute", carrier, f"housing_{k}", "0 0 1")
        urdf += _joint(f"bearing_{k}", "continuous", f"housing_{k}", f"front_{k}")
        urdf += (
            f'<loop name="pin_{k}_out" type="continuous"><predecessor link="cross_{k}"/>'
            f'<successor link="front_{k}"/><axis xyz="0 0 1"/></loop>'
        )
        if k == count:
            break
        urdf += f'<link name="carrier_{k}"/><link name="spline_{k}"/>'
        urdf += _SHAFT.format(name=f"rear_{k}")
        at = f"{_LENGTH} 0 0"
        urdf += _joint(f"length_{k}", "prismatic", f"housing_{k}", f"carrier_{k}", at=at)
        urdf += _joint(f"phase_{k}", "revolute", f"front_{k}", f"spline_{k}", at=at)
        urdf += _joint(f"slip_{k}", "prismatic", f"spline_{k}", f"rear_{k}")
        before, carrier = f"rear_{k}", f"carrier_{k}"
    return f'<robot name="design_line">{urdf}</robot>'


def nominal(count: int) -> dict[str, float]:
    """Return the held joints of the line: bent by 15° to and fro, forks of each shaft in line."""
    angles = {f"angle_{k}": 0.26 * (-1.0) ** k for k in range(1, count + 1)}
    behind = range(1, count)
    phases = {f"phase_{k}": 0.5 * np.pi for k in behind}
    return angles | phases | {f"length_{k}": 0.0 for k in behind}


def designs(count: int, shape: tuple[int, ...], seed: int = 0) -> dict[str, np.ndarray]:
    """Return random angles, phases and lengths of lines, each of a shape."""
    rng = np.random.default_rng(seed)
    limits = {"angle": (0.02, 0.5), "phase": (0.0, np.pi), "length": (-0.05, 0.05)}
    return {
        name: rng.uniform(*limits[name.partition("_")[0]], size=shape) for name in nominal(count)
    }
