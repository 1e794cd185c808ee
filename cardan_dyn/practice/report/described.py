"""Described: what a description says, as tables of a page."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import fields

import numpy as np

from ...core.description.description import TWO_AXES, JointOrLoop, LoopDescription
from ...core.description.write import angles_of
from ...core.mechanism.mechanism import Mechanism
from ...core.results.sweep import Sweep
from ...core.results.wrench import WITHOUT_AXIS
from ...kit.arrays import Array
from ...kit.quantities import amount, number, span
from ...scene.drives import Drives
from ...scene.mechanism_report import MechanismReport
from .grids import Grid, place


def fingerprint(mechanism: Mechanism) -> str:
    """Return the SHA-256 of the text of a description, of the file beside it and of added loops.

    Of one that was not read from a text, that of the URDF text that says the same.
    """
    description = mechanism.base.description
    source = description.text
    if source is None:
        return hashlib.sha256(mechanism.base.to_urdf().encode("utf-8")).hexdigest()
    beside = source.beside
    more = beside.encode("utf-8") if isinstance(beside, str) else beside
    return hashlib.sha256((source.text + description.added).encode("utf-8") + more).hexdigest()


def described(mechanism: Mechanism) -> list[Grid]:
    """Return links, joints, rotors, couplings, and what rubs and springs, each if there are any."""
    description = mechanism.base.description
    links = Grid(
        "links",
        "Links: mass, centre of mass in the link's frame, and inertia about that in the link's "
        "axes. What has no mass carries forces alone.",
        (
            *("link", "mass [kg]", "centre x [m]", "centre y [m]", "centre z [m]"),
            *(f"I{pair} [kg·m²]" for pair in ("xx", "yy", "zz", "xy", "xz", "yz")),
        ),
        [
            (
                link.name,
                float(link.mass),
                *map(float, link.centre),
                *map(float, np.diag(link.inertia)),
                *map(float, link.inertia[[0, 0, 1], [1, 2, 2]]),
            )
            for link in description.links
        ],
    )
    joints = Grid(
        "joints",
        "Joints of the tree, at zero: origin in the parent's frame, axis in the joint's.",
        ("joint", "type", "parent", "child", "axis", "origin [m]", "turned [°]", "remarks"),
        [
            (
                joint.name,
                joint.type,
                joint.parent,
                joint.child,
                _axes(joint),
                _vector(joint.origin[:3, 3]),
                _angles(joint.origin[:3, :3]),
                "; ".join(_remarks(mechanism, joint)),
            )
            for joint in description.joints
        ],
    )
    loops = Grid(
        "loops",
        "Joints that close loops: where they are on both links.",
        (
            *("loop", "type", "predecessor", "successor", "axis"),
            *("on predecessor [m]", "on successor [m]"),
        ),
        [
            (
                loop.name,
                loop.type,
                loop.predecessor,
                loop.successor,
                _axes(loop),
                _vector(loop.predecessor_origin[:3, 3]),
                _vector(loop.successor_origin[:3, 3]),
            )
            for loop in description.loops
        ],
    )
    rotors = Grid(
        "rotors",
        "Armatures: inertia of rotors along each coordinate of a joint, which efforts accelerate.",
        ("joint", "armature [kg·m² or kg]"),
        [
            (item.name, _vector(np.array(item.armature)))
            for item in description.joints_and_loops
            if item.armature
        ],
    )
    couplings = Grid(
        "couplings",
        "Couplings: the motion of the successor is the ratio times that of the predecessor, plus "
        "the offset, plus higher coefficients times its square, its cube and so on.",
        ("coupling", "predecessor", "successor", "ratio", "offset [rad or m]", "higher"),
        [
            (
                item.name,
                item.predecessor,
                item.successor,
                float(item.ratio),
                float(item.offset),
                " ".join(f"{value:g}" for value in item.higher),
            )
            for item in description.couplings
        ],
    )
    names = dict.fromkeys((*mechanism.base.joint_dynamics, *mechanism.base.joint_springs))
    nothing = (0.0, 0.0)
    dynamics = Grid(
        "dynamics",
        "What the description says of damping, friction and springs of joints. It acts only where "
        "the case lists it among the elements.",
        ("coordinate", "damping [SI]", "friction [N·m or N]", "stiffness [SI]", "rest [rad or m]"),
        [
            (
                name,
                *mechanism.base.joint_dynamics.get(name, nothing),
                *mechanism.base.joint_springs.get(name, nothing),
            )
            for name in names
        ],
    )
    return [grid for grid in (links, joints, loops, rotors, couplings, dynamics) if grid.rows]


def elements_of(sweep: Sweep) -> Iterator[Grid]:
    """Yield the force elements of a case, with what they are told by."""
    rows = []
    for index, item in enumerate(sweep.elements):
        along = sweep.mechanism.drivable[item.joints[0]] if item.joints else None
        effort, at = (along.effort_unit, along.unit) if along else ("N", "m")
        units = {
            "stiffness": f"{effort}/{at}",
            "damping": f"{effort}·s/{at}",
            "effort": effort,
            "rest": at,
            "transition": f"{at}/s",
            "length": "m",
        }
        told = {field.name: getattr(item, field.name) for field in fields(item)}  # type: ignore[arg-type]
        data = (
            f"{name} {_datum(value, units.get(name, ''))}"
            for name, value in told.items()
            if name != "name" and value is not None and not (isinstance(value, float) and not value)
        )
        rows.append((item.name or f"elements[{index}]", type(item).__name__, "; ".join(data)))
    if rows:
        yield Grid("elements", "Force elements", ("element", "kind", "data"), rows)


def _datum(value: object, unit: str) -> str:
    """Return a field of an element as text: a number with its unit, arrays row by row in SI."""
    if isinstance(value, float):
        return amount(value, unit)
    if isinstance(value, np.ndarray):
        rows = np.atleast_2d(value)
        return " | ".join(", ".join(map(number, row.tolist())) for row in rows)
    return "a function" if callable(value) else str(value)


def mobility_grids(found: MechanismReport) -> list[Grid]:
    """Return what was found of loops, and of those that share joints."""
    loops = Grid(
        "ranks",
        "Closure equations of each loop by itself. Statics does not determine what it leaves open.",
        ("loop", "type", "rank of 6", "redundant", "leaves open"),
        [
            (loop.name, loop.type, loop.rank, loop.redundant, loop.leaves_open)
            for loop in found.loops
        ],
    )
    components = Grid(
        "components",
        "Sets of loops and couplings that have no joint in common.",
        ("loops and couplings", "coordinates", "equations", "mobility", "self-stresses"),
        [
            (item.names, item.coordinates, item.rank, item.mobility, item.self_stresses)
            for item in found.components
        ],
    )
    return [grid for grid in (loops, components) if grid.rows]


def drives_grid(drives: Drives, driven: Collection[str] = ()) -> Grid:
    """Return how a mechanism can be driven, over which range; what cases drive is told as that."""
    rows = []
    for item in drives.ranked:
        role = drives.role(item)
        if item.name in driven and role != "default":
            role = "driven"
        ends = item.range or (np.nan, np.nan)
        rows.append(
            (
                item.name,
                "slide" if item.slides else "angle",
                "yes" if item.is_grounded else "no",
                *(place(end, item.slides) if np.isfinite(end) else "" for end in ends),
                item.ends,
                role,
            )
        )
    caption = f"How it can be driven, from where it starts ({drives.reason})."
    header = ("coordinate", "kind", "at the ground", "from", "to", "what ends the range", "role")
    return Grid("drives", caption, header, rows)


def links_of(item: JointOrLoop) -> tuple[str, str]:
    """Return the two links between which a joint or a loop is."""
    if isinstance(item, LoopDescription):
        return item.predecessor, item.successor
    return item.parent, item.child


def _axes(joint: JointOrLoop) -> str:
    if joint.type in WITHOUT_AXIS:
        return ""
    if joint.type in TWO_AXES:
        return f"{_vector(joint.axis)} and {_vector(joint.axis_2)}"
    return _vector(joint.axis)


def _range(what: str, ends: Sequence[float], unit: str) -> Iterator[str]:
    """Yield between what, or on which side, something has limits; zeros alone are none."""
    low, high = ends
    if not any(ends):
        return
    if np.isfinite(ends).all():
        yield f"{what} {span(low, high, unit)}"
    elif np.isfinite(low):
        yield f"{what} from {amount(low, unit)}"
    elif np.isfinite(high):
        yield f"{what} up to {amount(high, unit)}"


def _remarks(mechanism: Mechanism, joint: JointOrLoop) -> Iterable[str]:
    if joint.name in mechanism.independent_joints:
        yield "driven by its author"
    limits, adjustable = getattr(joint, "limits", None), getattr(joint, "adjustable", "")
    if limits is not None:
        at, effort = ("m", "N") if joint.type == "prismatic" else ("°", "N·m")
        ends = (limits.lower, limits.upper)
        yield from _range("limits", np.degrees(ends).tolist() if at == "°" else ends, at)
        if 0.0 < limits.velocity < np.inf:
            yield f"speed up to {amount(limits.velocity, 'm/s' if at == 'm' else 'rad/s')}"
        yield from _range("efforts", limits.efforts, effort)
    if adjustable:
        yield f"adjustable: {adjustable}"


def _vector(values: Array) -> str:
    rounded = np.where(np.abs(values) < 1e-12, 0.0, values)
    return ", ".join(number(float(value), 6) for value in rounded)


def _angles(rotation: Array) -> str:
    """Return roll, pitch and yaw of a rotation [°]; nothing where it is none."""
    angles = np.round(np.degrees(angles_of(rotation)), 6)
    return _vector(angles) if angles.any() else ""
