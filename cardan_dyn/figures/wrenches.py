"""Wrenches: torsion, bending and forces of joints over anything, an axes per quantity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import ArgumentError, choices
from .peaks import label_peaks
from .style import SIGN, Abscissa, Figure, Into, Size, Swept, curve_style, settle, sheet

UNITS = {"torsion": "N·m", "bending": "N·m", "axial": "N", "shear": "N"}
"""Quantities of a `JointWrench` that are drawn as lines, and their units."""
_ROUNDING = 1e-9
"""Part of the greatest moment or force in the joints below which a component of it is rounding."""
_PARALLEL = 1e-12
"""Component of a unit vector that counts as none: rounding of rotations."""
MARK = " *"
"""What follows the name of something that statics leaves open."""


def wrench_panels(
    turn: Swept,
    joints: Sequence[str],
    at: Abscissa,
    quantities: Sequence[str],
    *,
    title: str = "",
    peaks: bool | None = None,
    ax: Into = None,
    figsize: Size | None = None,
    line: Mapping[str, Any] | None = None,
) -> Figure:
    """Draw wrenches over an abscissa: an axes per quantity, a line per joint.

    What statics leaves open is marked by a star. What is rounding beside the whole force or moment
    in the joints appears as zero.

    Args:
        turn: the sweep, or a trajectory.
        joints: whose wrenches are drawn.
        at: the abscissa.
        quantities: of `UNITS`; those that are not all but zero if there are none.
        title: of the figure.
        peaks: see `label_peaks`.
        ax: see `sheet`.
        figsize: likewise.
        line: properties of the lines, for `Axes.plot`.

    Raises:
        ModelError: a joint is unknown, none of the outputs, or has no axis.
        ArgumentError: unknown quantity, or other axes than are needed.
    """
    for quantity in quantities:
        if quantity not in UNITS:
            raise ArgumentError(
                f"quantity {quantity!r} is unknown; quantities: {choices(UNITS, quantity)}"
            )
    wrenches = [turn[name] for name in joints]
    # The whole force or moment is that beside which a part of it is rounding.
    whole = {
        "N·m": _greatest(w.moment for w in wrenches),
        "N": _greatest(w.force for w in wrenches),
    }
    shown = quantities or _acting(wrenches, whole)
    drawn = sheet(
        len(shown), size=(7.2, 1.4 + 2.6 * len(shown)), share_x=True, ax=ax, figsize=figsize
    )
    opened = False
    for row, (quantity, panel) in enumerate(zip(shown, drawn.panels, strict=True)):
        first, curves = drawn.drawn(row), []
        for index, wrench in enumerate(wrenches):
            values = getattr(wrench, quantity)
            chosen = not determined(wrench, quantity)
            opened |= chosen
            label = f"{wrench.joint}{MARK if chosen else ''}"
            style = {**curve_style(first + index, len(at.values)), "label": label, **(line or {})}
            if chosen and not style["label"].endswith(MARK):
                style["label"] += MARK
            curves += panel.plot(at.values, values, **style)
        panel.set_ylabel(f"{quantity} [{UNITS[quantity]}]")
        settle(panel, whole[UNITS[quantity]])
        if _greatest(curve.get_ydata() for curve in curves) > _ROUNDING * whole[UNITS[quantity]]:
            label_peaks(panel, curves, UNITS[quantity], at.unit, peaks)
    at.name(drawn.panels[-1])
    return drawn.finish(title, 4, sign_note(turn, opened))


def sign_note(turn: Swept, opened: bool) -> str:
    """Return whose wrenches are drawn, and what a star means if there is one."""
    if not opened:
        return SIGN
    rule = getattr(turn, "rule", "") or turn.sweep.rule
    return f"{SIGN}; * not determined by statics, chosen by {rule}"


def determined(wrench: Any, quantity: str, components: Sequence[int] = (0, 1, 2)) -> bool:
    """Return whether a quantity of a `JointWrench` follows from the laws of motion alone.

    Args:
        wrench: of the joint.
        quantity: of `UNITS`, or `force` or `moment`.
        components: of the force or moment that are meant.
    """
    unique = (
        wrench.unique[3:] if quantity in ("torsion", "bending", "moment") else wrench.unique[:3]
    )
    if quantity in ("force", "moment") or np.all(unique):
        return bool(np.all(unique[list(components)]))
    axes = np.abs(np.atleast_2d(wrench.axis))
    # A component counts unless it is across the axis, or else along it, at all positions.
    far = axes < 1.0 - _PARALLEL if quantity in ("bending", "shear") else axes > _PARALLEL
    return bool(np.all(unique[np.any(far, axis=0)]))


def _acting(wrenches: Sequence[Any], whole: Mapping[str, float]) -> list[str]:
    """Return the quantities that are not all but zero; torsion and bending if nothing acts."""
    sizes = {name: _greatest(getattr(item, name) for item in wrenches) for name in UNITS}
    found = [name for name, unit in UNITS.items() if sizes[name] > _ROUNDING * whole[unit]]
    return found or ["torsion", "bending"]


def _greatest(arrays: Any) -> float:
    return max((float(np.max(np.abs(item), initial=0.0)) for item in arrays), default=0.0)


def along(turn: Swept, drive: str) -> Abscissa:
    """Return the position of a drive, or of any joint, to be drawn over."""
    position: Array = turn.motion.position(drive)
    coordinate = turn.mechanism.drivable.get(drive)
    if coordinate is not None and coordinate.slides:
        return Abscissa(position, f"{drive} [m]", "range")
    return Abscissa(np.rad2deg(position), f"{drive} [°]", "angle")
