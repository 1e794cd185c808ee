"""Descriptions of drive lines of any length."""

from __future__ import annotations

import numpy as np

SHAFT = (
    '<link name="{name}"><inertial><origin xyz="0.25 0 0"/><mass value="8"/><inertia ixx="0.02" '
    'iyy="0.2" izz="0.2" ixy="0" ixz="0" iyz="0"/></inertial></link>'
)
CROSS = (
    '<link name="{name}"><inertial><origin xyz="0 0 0"/><mass value="1"/><inertia ixx="0.002" '
    'iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>'
)
AXES = ("0 1 0", "0 0 1")


def _line(count: int, prefix: str, first: str, beta: float) -> str:
    """Joints 1 … count after the link `first`; every shaft turns in a bearing on the base."""
    urdf, heading, position = "", 0.0, np.zeros(2)
    for k in range(1, count + 1):
        before = first if k == 1 else f"{prefix}shaft_{k - 1}"
        if k > 1:
            position = position + 0.5 * np.array([np.cos(heading), np.sin(heading)])
        heading = beta if k % 2 else 0.0
        pins = AXES if k % 2 else AXES[::-1]
        at = f"{float(position[0])!r} {float(position[1])!r} 0"
        bearing = f"{prefix}{k}" if prefix else f"bearing_{k}"
        urdf += SHAFT.format(name=f"{prefix}shaft_{k}") + CROSS.format(name=f"{prefix}cross_{k}")
        urdf += (
            f'<joint name="{prefix}pin_{k}_in" type="continuous"><parent link="{before}"/>'
            f'<child link="{prefix}cross_{k}"/><origin xyz="{"0.5" if k > 1 else "0"} 0 0"/>'
            f'<axis xyz="{pins[0]}"/></joint>'
            f'<joint name="{bearing}" type="continuous"><parent link="base"/>'
            f'<child link="{prefix}shaft_{k}"/><origin xyz="{at}" rpy="0 0 {heading!r}"/>'
            '<axis xyz="1 0 0"/></joint>'
            f'<loop name="{prefix}pin_{k}_out" type="continuous">'
            f'<predecessor link="{prefix}cross_{k}"/><successor link="{prefix}shaft_{k}"/>'
            f'<axis xyz="{pins[1]}"/></loop>'
        )
    return urdf


def _input() -> str:
    return (
        '<link name="base"/>'
        + SHAFT.format(name="shaft_0")
        + '<joint name="bearing_0" type="continuous"><parent link="base"/>'
        '<child link="shaft_0"/><axis xyz="1 0 0"/></joint>'
    )


def drive_line(count: int, beta: float = 0.26) -> str:
    """A line of universal joints, alternately bent by beta and back, a bearing at every shaft."""
    return f'<robot name="line">{_input()}{_line(count, "", "shaft_0", beta)}</robot>'


def two_lines(count: int) -> str:
    """Two lines on one input shaft."""
    left = _line(count, "left_", "shaft_0", 0.3)
    right = _line(count, "right_", "shaft_0", -0.2)
    return f'<robot name="two_lines">{_input()}{left}{right}</robot>'
