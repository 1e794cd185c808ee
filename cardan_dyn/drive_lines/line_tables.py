"""Line tables: all results of an analysis as an xarray Dataset, with units.

The dimensions are

- `position`, of the input shaft [rad], and `design` where there are variants,
- `shaft`, `joint`, `bearing`, `spline` and `coupling_piece`, with their names,
- `component`: x, y, z of moments in axes of the shafts, and `bearing_component`: along, left, up.

`rotation`, `angle_error`, `ratio` and `acceleration` are those of every shaft. Moments, torsion and
bending have names that end in `_in` for the shaft before a joint, and in `_out` for the one behind
it. All forces are with inertia and weight; those without have names that begin with `static_`, and
are there where it makes a difference. The adjustable joints that differ from design to design are
coordinates.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .._version import __version__
from ..arrays import Array
from ..errors import MissingExtraError
from .analysis_data import AnalysisData
from .forces import LineForces

if TYPE_CHECKING:
    import xarray

_OF_JOINTS = {
    "torsion_in": "torque in the shaft before the joint",
    "torsion_out": "torque in the shaft behind the joint",
    "bending_in": "bending moment of the shaft before the joint",
    "bending_out": "bending moment of the shaft behind the joint",
    "holding_moment": "moment that keeps the joint angle",
}
_OF_BEARINGS = {
    "bearing_radial": "force across the shaft",
    "bearing_axial": "force of the bearing along the shaft",
}
_OF_SPLINES = {
    "spline_friction": ("friction force on the rear piece", "N"),
    "spline_torque": ("torque through the spline", "N·m"),
    "spline_bending": ("bending moment in the spline", "N·m"),
}
_VECTORS = {
    "moment_in": ("moment of the shaft before the joint on the cross", "joint", "component"),
    "moment_out": ("moment of the cross on the shaft behind the joint", "joint", "component"),
    "bearing_force": ("force of the bearing on its shaft", "bearing", "bearing_component"),
}

Variable = tuple[tuple[str, ...], Array, dict[str, str]]


def dataset(analysis: AnalysisData) -> xarray.Dataset:
    """Return an analysis as a Dataset; see `Analysis.to_xarray`.

    Raises:
        MissingExtraError: xarray is not installed.
    """
    try:
        import xarray
    except ImportError as error:
        raise MissingExtraError(
            'this table needs xarray: pip install "cardan-dyn[study]"'
        ) from error
    samples = ("design", "position")[-len(analysis.shape) :]
    variables = _motion(analysis, samples) | _forces(analysis.total, samples, "")
    if analysis.inertial is not None:
        variables |= _forces(analysis.static, samples, "static_")
    coordinates: dict[str, Any] = {
        "position": ("position", analysis.position, {"units": "rad"}),
        "shaft": list(analysis.shafts),
        "joint": list(analysis.joints),
        "bearing": list(analysis.bearings),
        "spline": list(analysis.splines),
        "coupling_piece": list(analysis.centrings),
        "component": list("xyz"),
        "bearing_component": ["along", "left", "up"],
    }
    for name, values in analysis.designs.items():
        slides = not name.startswith(("joint_", "fork_"))
        attributes = {"units": "m" if slides else "rad", "long_name": f"position of {name}"}
        coordinates[name] = ("design", values, attributes)
    return xarray.Dataset(
        variables,
        coordinates,
        {
            "line": analysis.name,
            "speed": analysis.speed,
            "indeterminate": "; ".join(analysis.indeterminate),
            "loop_residual": analysis.loop_residual,
            "balance_residual": analysis.balance_residual,
            "power_residual": analysis.power_residual,
            "cardan_dyn_version": __version__,
        },
    )


def _motion(analysis: AnalysisData, samples: tuple[str, ...]) -> dict[str, Variable]:
    """Return the motion of the shafts, and the slip of the splines."""
    of_shafts = (*samples, "shaft")
    listed = {
        "rotation": (analysis.rotation, "rad", "rotation about the axis"),
        "angle_error": (analysis.angle_error, "rad", "lead over the input, without its mean"),
        "ratio": (analysis.ratio, "1", "speed over that of the input shaft"),
        "acceleration": (analysis.acceleration, "rad/s²", "angular acceleration about the axis"),
    }
    found = {
        name: (of_shafts, np.array(values), {"units": unit, "long_name": text})
        for name, (values, unit, text) in listed.items()
    }
    drawn_out = {"units": "m", "long_name": "by how much the spline is drawn out"}
    return {**found, "slip": ((*samples, "spline"), np.array(analysis.slip), drawn_out)}


def _forces(forces: LineForces, samples: tuple[str, ...], prefix: str) -> dict[str, Variable]:
    """Return what acts along the line."""
    found: dict[str, Variable] = {}

    def add(name: str, dims: tuple[str, ...], unit: str, text: str) -> None:
        values = np.array(getattr(forces, name))
        found[prefix + name] = (*samples, *dims), values, {"units": unit, "long_name": text}

    for name, text in _OF_JOINTS.items():
        add(name, ("joint",), "N·m", text)
    for name, text in _OF_BEARINGS.items():
        add(name, ("bearing",), "N", text)
    for name, (text, unit) in _OF_SPLINES.items():
        add(name, ("spline",), unit, text)
    for name, (text, *dims) in _VECTORS.items():
        add(name, tuple(dims), "N" if name == "bearing_force" else "N·m", text)
    add("centring", ("coupling_piece",), "N", "force in the centring of a coupling piece")
    add("drive_torque", (), "N·m", "torque that drives the input shaft")
    add("load_torque", (), "N·m", "torque on the output shaft")
    return found
