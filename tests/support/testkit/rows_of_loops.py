"""Rows of closed loops, each of which shares a link with the next."""

from __future__ import annotations

import cardan_dyn as cd

_ROD = (
    '<link name="{name}"><inertial><origin xyz="{centre}"/><mass value="1"/><inertia ixx="0.09" '
    'iyy="0.08" izz="0.1" ixy="0.01" ixz="0" iyz="0"/></inertial></link>'
)


def parallelograms(count: int) -> cd.Mechanism:
    """Cranks of 1 m in one plane, joined by couplers as wheels of a locomotive; one freedom.

    All stand along y where `pivot_0` is zero, and couplers lie in line where it is a right angle.
    """
    return _row(count, coupler="continuous", loop="continuous", tilts=[0.0])


def spatial(count: int) -> cd.Mechanism:
    """The same by balls and universal joints, cranks about axes that are skew to each other."""
    return _row(count, coupler="spherical", loop="universal", tilts=[0.0, 0.2, -0.1])


def tower(count: int) -> cd.Mechanism:
    """Parallelograms one on the other: the coupler of each carries the next; `count` freedoms."""
    urdf, below = '<link name="base"/>', "base"
    for k in range(count):
        for name, at in (("left", "0 0 0"), ("right", "1 0 0")):
            urdf += _ROD.format(name=f"{name}_{k}", centre="0 0.5 0")
            urdf += joint_element("continuous", f"{name}_joint_{k}", below, f"{name}_{k}", at)
        urdf += _ROD.format(name=f"top_{k}", centre="0.5 0 0")
        urdf += joint_element("continuous", f"top_joint_{k}", f"left_{k}", f"top_{k}", "0 1 0")
        urdf += loop_element(
            "continuous", f"loop_{k}", (f"top_{k}", "1 0 0"), (f"right_{k}", "0 1 0")
        )
        below = f"top_{k}"
    return cd.load(f'<robot name="tower">{urdf}</robot>')


def _row(count: int, *, coupler: str, loop: str, tilts: list[float]) -> cd.Mechanism:
    urdf = '<link name="base"/>'
    for k in range(count + 1):
        urdf += _ROD.format(name=f"crank_{k}", centre="0 0.5 0")
        tilt = tilts[k % len(tilts)]
        axis = f"{tilt} 0 1"
        urdf += joint_element("continuous", f"pivot_{k}", "base", f"crank_{k}", f"{k} 0 0", axis)
    for k in range(count):
        urdf += _ROD.format(name=f"coupler_{k}", centre="0.5 0 0")
        urdf += joint_element(coupler, f"pin_{k}", f"crank_{k}", f"coupler_{k}", "0 1 0")
        ends = (f"coupler_{k}", "1 0 0"), (f"crank_{k + 1}", "0 1 0")
        urdf += loop_element(loop, f"loop_{k}", *ends)
    return cd.load(f'<robot name="row">{urdf}</robot>')


def joint_element(
    kind: str, name: str, parent: str, child: str, at: str, axis: str = "0 0 1"
) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at}"/><axis xyz="{axis}"/></joint>'
    )


def loop_element(kind: str, name: str, first: tuple[str, str], second: tuple[str, str]) -> str:
    # Across the coupler, so that this does not spin.
    across = '<axis2 xyz="0 1 0"/>' if kind == "universal" else ""
    return (
        f'<loop name="{name}" type="{kind}"><predecessor link="{first[0]}"><origin '
        f'xyz="{first[1]}"/></predecessor><successor link="{second[0]}"><origin '
        f'xyz="{second[1]}"/></successor><axis xyz="0 0 1"/>{across}</loop>'
    )
