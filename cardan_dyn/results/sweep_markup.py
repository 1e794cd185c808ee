"""Markup of a sweep: its greatest wrenches and its residuals as HTML for notebooks."""

from __future__ import annotations

import math

import numpy as np

from ..arrays import Array
from ..markup import element, table
from .sweep_data import SweepData
from .wrench import WITHOUT_AXIS, named_components

_MOST_EVALUATED = 100_000
"""Operating points above which a notebook shows no wrenches: a response evaluates them when they
are read, and a grid of millions would take seconds for a cell that only names it."""


def sweep_markup(sweep: SweepData) -> str:
    """Return the greatest wrenches of a sweep, then its residuals."""
    shape = " × ".join(str(size) for size in sweep.shape)
    title = element("p", f"Sweep of {sweep.mechanism.name}: {shape} samples")
    if math.prod(sweep.shape) > _MOST_EVALUATED:
        wrenches = element("p", "Wrenches are not evaluated for a table of so many samples.")
    else:
        header = ("joint", "force [N]", "torsion [N·m]", "bending [N·m]", "unique")
        wrenches = table(header, (_wrench_row(sweep, joint) for joint in sweep.outputs))
    residuals = table(
        ("residual", "value"),
        (
            ("loop", f"{sweep.loop_residual:.1e}"),
            ("balance", f"{sweep.balance_residual:.1e}"),
            ("power", f"{sweep.power_residual:.1e}"),
            ("rate", f"{sweep.rate_residual:.1e}"),
        ),
    )
    return f"<div>{title}{wrenches}{residuals}</div>"


def _wrench_row(sweep: SweepData, joint: str) -> tuple[str, ...]:
    """Return the greatest force, torsion and bending of a joint, and whether they are unique."""
    wrench = sweep[joint]
    shown = [np.linalg.norm(wrench.force, axis=-1)]
    has_axis = sweep.mechanism.joints[joint].type not in WITHOUT_AXIS
    if has_axis:
        shown += [wrench.torsion, wrench.bending]
    greatest = [f"{float(np.max(np.abs(values), initial=0.0)):.4g}" for values in shown]
    parts = greatest if has_axis else [*greatest, "no axis", "no axis"]
    return (joint, *parts, _uniqueness(wrench.unique))


def _uniqueness(unique: Array) -> str:
    """Return `yes`, or the components that are not unique, for example `not force xy`."""
    return "yes" if np.all(unique) else f"not {named_components(~unique)}"
