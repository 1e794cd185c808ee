"""Wrenches: torsion, bending and forces of joints over anything, an axes per quantity."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ..kit.arrays import NOTHING, ROUNDED, Array
from ..kit.errors import ArgumentError, choices
from ..kit.quantities import amount
from .panels import Panel, stacked
from .style import SIGN, Abscissa, Figure, Swept, over

UNITS = {"torsion": "N·m", "bending": "N·m", "axial": "N", "shear": "N"}
"""Quantities of a `JointWrench` that are drawn as lines, and their units."""
_SIZES = {"force": "N", "moment": "N·m"}
"""Vectors of a `JointWrench` whose sizes are drawn, also of joints without an axis."""
QUANTITIES = {**UNITS, **_SIZES}
"""Both, and their units."""
_UNSEEN = 0.01
"""Part of what acts below which a quantity is not drawn unless it is named: a line is as wide."""
MARK = " *"
"""What follows the name of something that statics leaves open."""
PARTS = {"force": ("axial", "shear"), "moment": ("torsion", "bending")}
"""Quantities to their parts along and across the axis of a joint."""


def wrench_panels(
    turn: Swept,
    joints: Sequence[str],
    at: Abscissa,
    quantities: Sequence[str],
    *,
    others: Collection[str] = (),
    above: Sequence[Panel] = (),
    **options: Any,
) -> Figure:
    """Draw wrenches over an abscissa: an axes per quantity, a line per joint.

    Where statics leaves a quantity of a joint open, both have a star. What is rounding beside the
    whole force or moment in the joints appears as zero.

    Args:
        turn: the sweep, or a trajectory.
        joints: whose wrenches are drawn.
        at: the abscissa.
        quantities: of `UNITS`, or `force` and `moment` for the sizes of the whole; those that are
            not small beside the whole if there are none, the others in a note.
        others: joints that were left out because none was named, which a note says.
        above: panels above those of joints.
        options: of `stacked`.

    Raises:
        ModelError: a joint is unknown, none of the outputs, or has no axis.
        ArgumentError: unknown quantity, or other axes than are needed.
    """
    for quantity in quantities:
        if quantity not in QUANTITIES:
            raise ArgumentError(
                f"quantity {quantity!r} is unknown; quantities: {choices(QUANTITIES, quantity)}"
            )
    wrenches = [turn[name] for name in joints]
    # A part of a wrench is rounding beside its whole, of which a moment is a force by a length.
    whole = whole_of(wrenches, turn.mechanism.characteristic_length)
    shown, small = (quantities, []) if quantities else _acting(wrenches, whole)
    opened = {(w.joint, name) for w in wrenches for name in shown if not determined(w, name)}
    # A joint has one name in all axes: its star and that of the quantity belong together.
    marked = {joint for joint, _ in opened}
    line = dict(options.pop("line", None) or {})
    label = line.pop("label", "")
    names = {w.joint: (label or w.joint) + MARK * (w.joint in marked) for w in wrenches}
    panels = [*above]
    for quantity in shown:
        star = MARK * any(name == quantity for _, name in opened)
        curves = {wrench.joint: values_of(wrench, quantity) for wrench in wrenches}
        unit = QUANTITIES[quantity]
        panels.append(Panel(f"{quantity}{star} [{unit}]", unit, whole[unit], curves, {}))
    notes = [sign_note(turn, marked)]
    crosses = [name for name in joints if turn.mechanism.joint(name).type == "universal"]
    if crosses and not set(shown) <= set(_SIZES):
        straight = "turns with the child, and is across both pins where the joint is straight"
        notes.append(f"the axis of {choices(crosses, most=3)} {straight}")
    left_out = [choices(others, most=3)] * bool(others) + small
    notes += [f"not drawn: {'; '.join(left_out)}"] if left_out else []
    return stacked(at, panels, note="; ".join(notes), line=line, labels=names, **options)


def sign_note(turn: Swept, opened: Collection[str]) -> str:
    """Return whose wrenches are drawn, and what a star means at those of the `opened`."""
    if not opened:
        return SIGN
    found = turn.left_open if hasattr(turn, "left_open") else turn.sweep.left_open
    return f"{SIGN}; * not determined by statics: {found.why(*opened)}"


def determined(wrench: Any, quantity: str, components: Sequence[int] = (0, 1, 2)) -> bool:
    """Return whether a quantity of a `JointWrench` follows from the laws of motion alone.

    Components that statics leaves open count as far as they carry something: where loads lie in the
    plane of a planar mechanism, what acts in it is all there is, and what acts across it is none.

    Args:
        wrench: of the joint.
        quantity: of `UNITS`, or `force` or `moment`.
        components: of the force or moment that are meant.
    """
    is_moment = quantity in ("torsion", "bending", "moment")
    unique = wrench.unique[3:] if is_moment else wrench.unique[:3]
    if np.all(unique):
        return True
    meant = np.isin(np.arange(3), components)
    if quantity not in ("force", "moment"):
        axes = np.abs(np.reshape(wrench.axis, (-1, 3)))
        # A component counts unless it is across the axis, or else along it, at all positions.
        far = axes < 1.0 - ROUNDED if quantity in ("bending", "shear") else axes > ROUNDED
        meant &= np.any(far, axis=0)
    vectors = wrench.moment if is_moment else wrench.force
    known, opened = (_greatest([vectors[..., meant & of]]) for of in (unique, ~unique))
    return not np.any(meant & ~unique) or opened < NOTHING * known


def known_part(wrench: Any, quantity: str) -> str:
    """Return `force` or `moment` itself, or its greatest part if statics determines that alone."""
    if determined(wrench, quantity) or not wrench.has_axis:
        return quantity
    known = [name for name in PARTS[quantity] if determined(wrench, name)]
    return max(known, key=lambda name: _greatest([values_of(wrench, name)]), default=quantity)


def together(force: float, moment: float, length: float) -> dict[str, float]:
    """Return units to the sizes beside which forces and moments are rounding.

    Args:
        force: the greatest [N].
        moment: the greatest [N·m].
        length: at which forces act [m].
    """
    return {"N": max(force, moment / length), "N·m": max(moment, force * length)}


def whole_of(wrenches: Iterable[Any], length: float) -> dict[str, float]:
    """Return what `together` does of the greatest force and moment of wrenches."""
    every = list(wrenches)
    force, moment = (_greatest(getattr(of, name) for of in every) for name in PARTS)
    return together(force, moment, length)


def values_of(wrench: Any, quantity: str) -> Array:
    """Return a quantity of `QUANTITIES`: a signed component, or the size of a vector."""
    values = getattr(wrench, quantity)
    return np.asarray(np.linalg.norm(values, axis=-1) if quantity in _SIZES else values)


def _acting(wrenches: Sequence[Any], whole: Mapping[str, float]) -> tuple[list[str], list[str]]:
    """Return the quantities that are seen beside the whole, and in words those that are not.

    Where nothing acts, these are the quantities of moments.
    """
    units = UNITS if all(item.has_axis for item in wrenches) else _SIZES
    sizes = {name: _greatest(values_of(item, name) for item in wrenches) for name in units}
    found = [name for name, unit in units.items() if sizes[name] > _UNSEEN * whole[unit]]
    small = [
        f"{name}, at most {amount(size, units[name], 2)}"
        for name, size in sizes.items()
        if name not in found and size > NOTHING * whole[units[name]]
    ]
    return found or [name for name, unit in units.items() if unit == "N·m"], small


def _greatest(arrays: Any) -> float:
    return max((float(np.nanmax(np.abs(item), initial=0.0)) for item in arrays), default=0.0)


def along(turn: Swept, drive: str) -> Abscissa:
    """Return the position of a drive, or of any joint, to be drawn over."""
    unit = getattr(turn.mechanism.drivable.get(drive), "unit", "rad")
    return over(drive, turn.motion.position(drive), unit)
