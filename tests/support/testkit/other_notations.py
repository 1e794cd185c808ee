"""A four-bar whose loop is written in the ways of several programs, beside URDF+."""

from __future__ import annotations

from pathlib import Path

from .linkages import four_bar, loop

PLUS = four_bar(loop("revolute"))
"""In URDF+ notation."""
TREE = PLUS[: PLUS.index("<loop")] + "{}</robot>"
"""Without its loop, with room for something else."""
CLOSURES = """closures:
- {link_a: coupler, link_b: rocker, point: [2, 2.5, 0], axis: [0, 0, 3]}
dependent: [b, d]
independent: [a]
"""
"""As scikit-robot and sw2robot write `loop_closures.yaml`."""
PINS = """pin_loops:
  - name: knee
    parent: coupler
    child: rocker
    parent_xyz: [2.0, 2.0, 0.0]
    child_xyz: [0.0, 2.5, 0.0]
    axis: [0.0, 0.0, 2.0]
ball_upgrades: []
ball_limit_deg: 20.0
actuated_joints:
  - a
"""
"""As RoboNex has it."""
CONSTRAINT = """<constraint name="c" type="{kind}"><parent link="coupler"/>
<parent_origin xyz="2 2 0"/><parent_axis xyz="0 0 2"/><child link="rocker"/>
<child_origin xyz="0 2.5 0" rpy="0 0 0"/>{more}</constraint>"""
"""As it is proposed for ROS."""
FRAME = """<link name="{name}"><origin xyz="0 0 0" rpy="0 0 0"/><inertial><origin xyz="0 0 0"/>
<mass value="1e-9"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
<joint name="{name}_frame" type="fixed"><origin xyz="{xyz}" rpy="{rpy}"/><parent link="{body}"/>
<child link="{name}"/><axis xyz="0 0 0"/></joint>"""
"""A frame as onshape-to-robot exports it."""


def closing_frames(*, on_z: bool = True, name: str = "closing_pin", first: str = "2 2 0") -> str:
    """Return the frames by which onshape-to-robot closes the loop, a revolute mate if `on_z`."""
    x, y, z = map(float, first.split())
    frames = [("1", "coupler", (x, y, z)), ("2", "rocker", (0.0, 2.5, 0.0))]
    if on_z:
        frames += [(f"{side}_z", body, (x, y, z + 0.1)) for side, body, (x, y, z) in list(frames)]
    return "".join(
        FRAME.format(name=f"{name}_{side}", body=body, xyz=" ".join(map(repr, xyz)), rpy="0 0 0.7")
        for side, body, xyz in frames
    )


def written(folder: Path, yaml: str, urdf: str | None = None, inside: str = "") -> Path:
    """Write a URDF, and `loop_closures.yaml` in the same folder or in another one."""
    path = folder / "urdf" / "bars.urdf"
    path.parent.mkdir(exist_ok=True)
    path.write_text(TREE.format("") if urdf is None else urdf, encoding="utf-8")
    file = (path.parent if not inside else folder / inside) / "loop_closures.yaml"
    file.parent.mkdir(exist_ok=True)
    file.write_text(yaml, encoding="utf-8")
    return path
