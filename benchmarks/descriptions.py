"""Descriptions with other lengths, masses and misalignments, and drive lines of any length."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from math import cos, sin
from pathlib import Path

import numpy as np

URDF = Path(__file__).parents[1] / "urdf"


def text(name: str) -> str:
    """Return a bundled description."""
    return (URDF / f"{name}.urdf").read_text(encoding="utf-8")


def mechanics(name: str) -> str:
    """Return a bundled description without visuals, materials, comments and adjustable joints."""
    urdf = re.sub(r"<!--.*?-->", "", text(name), flags=re.DOTALL)
    urdf = re.sub(r"\s*<visual.*?</visual>", "", urdf, flags=re.DOTALL)
    urdf = re.sub(r"\s*<material name=.*?</material>", "", urdf, flags=re.DOTALL)
    return _without_adjustable_joints(urdf)


def _without_adjustable_joints(urdf: str) -> str:
    """Return a description in which what hangs from adjustable joints hangs from their parents.

    They are shifted, not turned, and the links behind them have no mass.
    """
    robot = ElementTree.fromstring(urdf)
    for joint in [item for item in robot.findall("joint") if item.get("adjustable")]:
        parent, child, origin = (joint.find(tag) for tag in ("parent", "child", "origin"))
        assert parent is not None and child is not None and origin is not None
        shift = np.array(origin.get("xyz", "0 0 0").split(), dtype=float)
        for other in robot.findall("joint"):
            end, place = other.find("parent"), other.find("origin")
            if end is not None and end.get("link") == child.get("link"):
                assert place is not None
                moved = shift + np.array(place.get("xyz", "0 0 0").split(), dtype=float)
                place.set("xyz", " ".join(repr(float(value)) for value in moved))
                end.set("link", parent.get("link", ""))
        (link,) = (item for item in robot.findall("link") if item.get("name") == child.get("link"))
        robot.remove(joint)
        robot.remove(link)
    return ElementTree.tostring(robot, encoding="unicode").replace(" />", "/>")


def massless(urdf: str) -> str:
    """Return a description without inertia."""
    return re.sub(r"\s*<inertial>.*?</inertial>", "", urdf, flags=re.DOTALL)


def with_length(urdf: str, factor: float) -> str:
    """Return a description with all lengths times a factor, masses kept."""
    urdf = re.sub(r'(<origin xyz=")([^"]*)(")', lambda m: m[1] + _times(m[2], factor) + m[3], urdf)
    return _with_inertia(urdf, factor**2)


def with_mass(urdf: str, link: str, factor: float) -> str:
    """Return a description with one link's mass and inertia times a factor."""
    start = urdf.index(f'<link name="{link}">')
    end = urdf.index("</link>", start)
    element = re.sub(
        r'(<mass value=")([^"]*)(")', lambda m: m[1] + _times(m[2], factor) + m[3], urdf[start:end]
    )
    return urdf[:start] + _with_inertia(element, factor) + urdf[end:]


def with_miss(urdf: str, joint: str, miss: float) -> str:
    """Return a description in which a joint's axis misses where it was, along x of its parent."""
    start = urdf.index(f'name="{joint}"')
    return urdf[:start] + urdf[start:].replace('xyz="0 0 0"', f'xyz="{miss!r} 0 0"', 1)


def _times(numbers: str, factor: float) -> str:
    return " ".join(repr(float(number) * factor) for number in numbers.split())


def _with_inertia(urdf: str, factor: float) -> str:
    def scaled(entry: re.Match[str]) -> str:
        return entry[1] + _times(entry[2], factor) + entry[3]

    change: Callable[[re.Match[str]], str] = lambda m: re.sub(  # noqa: E731
        r'(i[xyz]{2}=")([^"]*)(")', scaled, m[0]
    )
    return re.sub(r"<inertia [^>]*>", change, urdf)


_SHAFT = (
    '<link name="{name}"><inertial><origin xyz="0.25 0 0"/><mass value="8"/><inertia ixx="0.02" '
    'iyy="0.2" izz="0.2" ixy="0" ixz="0" iyz="0"/></inertial></link>'
)
_CROSS = (
    '<link name="{name}"><inertial><origin xyz="0 0 0"/><mass value="1"/><inertia ixx="0.002" '
    'iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>'
)
_JOINT = (
    '<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>'
    '<origin xyz="{xyz}" rpy="0 0 {yaw!r}"/><axis xyz="{axis}"/></joint>'
)


def drive_line(count: int, beta: float = 0.26) -> str:
    """Return a line of universal joints, bent by beta and back, with a bearing at every shaft."""
    return f'<robot name="line">{_input()}{_line(count, "", beta)}</robot>'


def two_lines(count: int) -> str:
    """Return two lines on one input shaft; names of the second begin with `other_`."""
    lines = _line(count, "", 0.26) + _line(count, "other_", -0.2)
    return f'<robot name="two_lines">{_input()}{lines}</robot>'


def _input() -> str:
    bearing = _JOINT.format(
        name="bearing_0", parent="base", child="shaft_0", xyz="0 0 0", yaw=0.0, axis="1 0 0"
    )
    return '<link name="base"/>' + _SHAFT.format(name="shaft_0") + bearing


def _line(count: int, prefix: str, beta: float) -> str:
    urdf, heading, x, y = "", 0.0, 0.0, 0.0
    for k in range(1, count + 1):
        shaft, cross = f"{prefix}shaft_{k}", f"{prefix}cross_{k}"
        before = f"{prefix}shaft_{k - 1}" if k > 1 else "shaft_0"
        if k > 1:
            x, y = x + 0.5 * cos(heading), y + 0.5 * sin(heading)
        heading = beta if k % 2 else 0.0
        pins = ("0 1 0", "0 0 1") if k % 2 else ("0 0 1", "0 1 0")
        urdf += _SHAFT.format(name=shaft) + _CROSS.format(name=cross)
        urdf += _JOINT.format(
            name=f"{prefix}pin_{k}_in",
            parent=before,
            child=cross,
            xyz="0.5 0 0" if k > 1 else "0 0 0",
            yaw=0.0,
            axis=pins[0],
        )
        urdf += _JOINT.format(
            name=f"{prefix}bearing_{k}",
            parent="base",
            child=shaft,
            xyz=f"{x!r} {y!r} 0",
            yaw=heading,
            axis="1 0 0",
        )
        urdf += (
            f'<loop name="{prefix}pin_{k}_out" type="continuous"><predecessor link="{cross}"/>'
            f'<successor link="{shaft}"/><axis xyz="{pins[1]}"/></loop>'
        )
    return urdf


def design_line(count: int) -> str:
    """Return a line of joints whose angles, fork phases and lengths are joints to be held.

    `angle_k` bends joint k; behind it `phase_k` turns the rear fork of the shaft, and `length_k`
    moves the next joint, which a slide in the shaft (`slip_k`) follows.
    """

    def joint(name: str, kind: str, parent: str, child: str, axis: str, at: float = 0.0) -> str:
        limit = "" if kind == "continuous" else '<limit lower="-3" upper="3"/>'
        return (
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{at} 0 0"/><axis xyz="{axis}"/>{limit}</joint>'
        )

    x, y, z = "1 0 0", "0 1 0", "0 0 1"
    urdf, before, frame = _input(), "shaft_0", "base"
    for k in range(1, count + 1):
        urdf += _SHAFT.format(name=f"shaft_{k}") + _CROSS.format(name=f"cross_{k}")
        urdf += f'<link name="housing_{k}"/>'
        urdf += joint(f"pin_{k}_in", "continuous", before, f"cross_{k}", y)
        urdf += joint(f"angle_{k}", "revolute", frame, f"housing_{k}", z)
        urdf += joint(f"bearing_{k}", "continuous", f"housing_{k}", f"shaft_{k}", x)
        urdf += (
            f'<loop name="pin_{k}_out" type="continuous"><predecessor link="cross_{k}"/>'
            f'<successor link="shaft_{k}"/><axis xyz="{z}"/></loop>'
        )
        if k < count:
            before, frame = f"rear_{k}", f"frame_{k}"
            urdf += f'<link name="{frame}"/><link name="spline_{k}"/>' + _SHAFT.format(name=before)
            urdf += joint(f"length_{k}", "prismatic", f"housing_{k}", frame, x, 0.5)
            urdf += joint(f"phase_{k}", "revolute", f"shaft_{k}", f"spline_{k}", x, 0.5)
            urdf += joint(f"slip_{k}", "prismatic", f"spline_{k}", before, x)
    return f'<robot name="design_line">{urdf}</robot>'


def random_designs(count: int, designs: int) -> dict[str, np.ndarray]:
    """Return random angles, phases and lengths `(designs, 1)` of such lines."""
    rng = np.random.default_rng(0)
    behind = range(1, count)
    limits = {f"angle_{k}": (0.02, 0.5) for k in range(1, count + 1)}
    limits |= {f"phase_{k}": (0.0, np.pi) for k in behind}
    limits |= {f"length_{k}": (-0.05, 0.05) for k in behind}
    return {name: rng.uniform(*ends, size=(designs, 1)) for name, ends in limits.items()}
