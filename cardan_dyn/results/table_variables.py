"""Table variables: all results of a sweep with names for their dimensions, and units.

`tables` makes a Dataset or a DataFrame of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import ModelError
from ..forces.link_loads import Wrench
from .element_variables import effort_units, element_labels, element_variables
from .sweep_data import SweepData
from .variable import Variable
from .wrench import WITHOUT_AXIS

AXES = ("x", "y", "z")
VECTORS = {"force": ("N", "force"), "moment": ("N·m", "moment")}
_SCALARS = {
    "torsion": ("N·m", "moment along the joint axis; nan where a joint has none"),
    "bending": ("N·m", "size of the moment across the joint axis; nan where a joint has none"),
    "axial": ("N", "force along the joint axis; nan where a joint has none"),
    "shear": ("N", "size of the force across the joint axis; nan where a joint has none"),
}
_RATES = {"position": "", "speed": "/s", "acceleration": "/s²"}
_MOTIONS = {"position": "", "velocity": "/s", "acceleration": "/s²"}


def variables_of(sweep: SweepData, motion: bool) -> Iterator[tuple[str, Variable]]:
    """Return all variables of a sweep with their names, coordinates first."""
    yield from _rates(sweep)
    yield from _loads(sweep)
    yield from _wrenches(sweep)
    yield from _efforts(sweep)
    yield from element_variables(sweep, sample_dims(sweep))
    if motion:
        yield from _motion(sweep)
    over_samples = sweep.condition.shape == sweep.shape
    dims = sample_dims(sweep) if over_samples else ()
    condition = sweep.condition if over_samples else sweep.condition[0]
    yield "condition", Variable(dims, condition, "1", "condition number of the wrenches")


def _rates(sweep: SweepData) -> Iterator[tuple[str, Variable]]:
    """Return position, speed and acceleration of the drives."""
    units = [_unit(sweep, name) for name in sweep.coordinates]
    several = len(units) > 1
    drive = "drive" if several else f"drive {sweep.coordinates[0]}"
    for name, per_time in _RATES.items():
        values = getattr(sweep, name)
        if several:
            dims: tuple[str, ...] = (*sample_dims(sweep), "drive")
            unit: str | tuple[str, ...] = tuple(unit + per_time for unit in units)
        else:
            dims, values = _varying_dims(values, sweep)
            unit = units[0] + per_time
        yield name, Variable(dims, values, unit, f"{name} of the {drive}", True)


def _loads(sweep: SweepData) -> Iterator[tuple[str, Variable]]:
    """Return times, loads, held positions, factors on inertia and gravity that vary."""
    if sweep.time.ndim:
        dims, values = _varying_dims(sweep.time, sweep)
        yield "time", Variable(dims, values, "s", "time", True)
    for name, load in sweep.loads.items():
        if isinstance(load, Wrench):
            for quantity, (unit, _) in VECTORS.items():
                vectors = np.asarray(getattr(load, quantity))
                if vectors.ndim > 1:
                    dims, vectors = _varying_dims(vectors, sweep, trailing=1)
                    dims = (*dims, "component")
                    label = f"{quantity} on link {name}, in {load.frame} axes"
                    yield f"load_{name}_{quantity}", Variable(dims, vectors, unit, label, True)
        elif load.ndim:
            dims, values = _varying_dims(load, sweep)
            unit = _effort_unit(sweep, name)
            yield f"load_{name}", Variable(dims, values, unit, f"load on joint {name}", True)
    for name, position in sweep.held.items():
        if np.ndim(position):
            dims, values = _varying_dims(np.asarray(position), sweep)
            label = f"position at which {name} is held"
            yield f"held_{name}", Variable(dims, values, _unit(sweep, name), label, True)
    for name, factor in sweep.inertia.items():
        dims, values = _varying_dims(factor, sweep)
        label = f"factor on mass and inertia of link {name}"
        yield f"inertia_{name}", Variable(dims, values, "1", label, True)
    if sweep.gravity.ndim > 1:
        dims, values = _varying_dims(sweep.gravity, sweep, trailing=1)
        label = "acceleration of free fall, in world axes"
        yield "gravity", Variable((*dims, "component"), values, "m/s²", label, True)


def _wrenches(sweep: SweepData) -> Iterator[tuple[str, Variable]]:
    """Return the wrenches of the outputs in their joints' axes."""
    if not sweep.outputs:
        return
    dims, wrenches = sample_dims(sweep), [wrench for _, wrench in sweep.items()]
    for name, (unit, label) in VECTORS.items():
        vectors = np.stack([getattr(wrench, name) for wrench in wrenches], axis=-2)
        long_name = f"{label} of the parent on the child, in the joint's axes"
        yield name, Variable((*dims, "joint", "component"), vectors, unit, long_name)
    for name, (unit, label) in _SCALARS.items():
        values = np.stack(
            [
                np.full(sweep.shape, np.nan)
                if sweep.mechanism.joints[wrench.joint].type in WITHOUT_AXIS
                else getattr(wrench, name)
                for wrench in wrenches
            ],
            axis=-1,
        )
        yield name, Variable((*dims, "joint"), values, unit, label)


def _efforts(sweep: SweepData) -> Iterator[tuple[str, Variable]]:
    """Return what drives, held joints and couplings exert, as far as it was solved."""
    dims = sample_dims(sweep)
    units = tuple(_effort_unit(sweep, name) for name in sweep.coordinates)
    try:
        effort = sweep.drive_effort
    except ModelError:  # The outputs leave it out.
        effort = None
    if effort is not None and len(units) > 1:
        yield "drive_effort", Variable((*dims, "drive"), effort, units, "effort of the drives")
    elif effort is not None:
        yield "drive_effort", Variable(dims, effort, units[0], f"effort of {sweep.coordinates[0]}")
    if sweep.holding_effort:
        values = np.stack(list(sweep.holding_effort.values()), axis=-1)
        units = tuple(_effort_unit(sweep, name) for name in sweep.holding_effort)
        yield "holding_effort", Variable((*dims, "held"), values, units, "effort that holds it")
    if len(sweep.coupling_moment):
        values = np.stack(list(sweep.coupling_moment.values()), axis=-1)
        units = tuple(_coupling_unit(sweep, name) for name in sweep.coupling_moment)
        label = "effort on the joint of the coupling's successor"
        yield "coupling_moment", Variable((*dims, "coupling"), values, units, label)


def _motion(sweep: SweepData) -> Iterator[tuple[str, Variable]]:
    """Return the motion of all coordinates that turn or slide."""
    joints = _moving_joints(sweep)
    for name, per_time in _MOTIONS.items():
        values = [getattr(sweep.motion, name)(joint) for joint in joints]
        units = tuple(_unit(sweep, joint) + per_time for joint in joints)
        dims = (*sample_dims(sweep), "moving_joint")
        long_name = f"{name} of the joint's coordinate"
        yield f"joint_{name}", Variable(dims, np.stack(values, axis=-1), units, long_name)


def sample_dims(sweep: SweepData) -> tuple[str, ...]:
    """Return the names of the dimensions of the operating points."""
    count = len(sweep.shape)
    return ("sample",) if count == 1 else tuple(f"sample_{index}" for index in range(count))


def _varying_dims(
    values: Array, sweep: SweepData, trailing: int = 0
) -> tuple[tuple[str, ...], Array]:
    """Return the dimensions along which something was given, and the values along these.

    In a sweep over one dimension all coordinates have it. On a grid each has only the dimensions
    along which it varies, since otherwise it would be as large as the grid.

    Args:
        values: `(..., trailing)`, to be broadcast with the operating points.
        sweep: of the operating points.
        trailing: number of dimensions that are not those of the operating points.
    """
    names, rest = sample_dims(sweep), values.shape[values.ndim - trailing :]
    if len(names) == 1:
        return names, np.broadcast_to(values, (*sweep.shape, *rest))
    missing = len(names) + trailing - values.ndim
    padded = values.reshape((1,) * missing + values.shape)
    # Along an axis without stride, all values are the same one.
    once: Any = tuple(
        slice(None) if size > 1 and stride else slice(0, 1)
        for size, stride in zip(padded.shape, padded.strides, strict=True)
    )
    padded = padded[(*once[: len(names)], ...)]
    kept = [axis for axis, size in enumerate(padded.shape[: len(names)]) if size > 1]
    dims = tuple(names[axis] for axis in kept)
    return dims, padded.reshape([*(padded.shape[axis] for axis in kept), *rest])


def labels_of(sweep: SweepData) -> dict[str, Sequence[str]]:
    """Return the names along each dimension that is not one of the operating points."""
    return {
        "joint": sweep.outputs,
        "component": AXES,
        "drive": sweep.coordinates,
        "held": tuple(sweep.holding_effort),
        "coupling": tuple(sweep.coupling_moment),
        "moving_joint": _moving_joints(sweep),
        **element_labels(sweep),
    }


def unit_labels(sweep: SweepData) -> list[tuple[str, str, list[str]]]:
    """Return coordinates of units: name, dimension and the units along it."""
    return [
        ("drive_unit", "drive", [_effort_unit(sweep, name) for name in sweep.coordinates]),
        ("held_unit", "held", [_effort_unit(sweep, name) for name in sweep.holding_effort]),
        (
            "coupling_unit",
            "coupling",
            [_coupling_unit(sweep, name) for name in sweep.coupling_moment],
        ),
        ("effort_unit", "joint_element", list(effort_units(sweep))),
        ("unit", "moving_joint", [_unit(sweep, name) for name in _moving_joints(sweep)]),
    ]


def _moving_joints(sweep: SweepData) -> tuple[str, ...]:
    """Return the names of the coordinates that turn or slide: of all joints but balls."""
    return tuple(sweep.mechanism.coordinates.named)


def _unit(sweep: SweepData, joint: str) -> str:
    """Return the unit of a coordinate."""
    return "m" if sweep.mechanism.drivable[joint].slides else "rad"


def _effort_unit(sweep: SweepData, joint: str) -> str:
    """Return the unit of an effort along a coordinate."""
    return "N" if _unit(sweep, joint) == "m" else "N·m"


def _coupling_unit(sweep: SweepData, name: str) -> str:
    """Return the unit of what a coupling exerts on its successor's joint, a slide or a rotation."""
    mechanism = sweep.mechanism
    (coupling,) = (item for item in mechanism.couplings if item.name == name)
    # No joint moves a successor that carries the predecessor: the ratio is taken as a plain number.
    column = (coupling.successor_columns or coupling.predecessor_columns)[0]
    named = mechanism.coordinates.named
    (joint,) = (name for name, coordinate in named.items() if coordinate.rate == column)
    return _effort_unit(sweep, joint)
