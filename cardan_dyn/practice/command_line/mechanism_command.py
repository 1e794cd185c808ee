"""What `cardan-dyn describe` and `check` do: say what a mechanism is and what it can do."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...core.mechanics.exact import load
from ...core.mechanism.mechanism import Mechanism
from ...core.mechanism.undescribed import REMEDY
from ...kit.errors import CardanError, as_text, choices
from ...kit.quantities import cleared
from ...scene.describe import describe
from ...scene.drives import Drives
from ...scene.mechanism_report import MechanismReport
from ...scene.usual_motion import slides
from ..report.described import drives_grid, links_of
from ..report.extremes import counted
from ..report.grids import place
from .tables import print_json, say, show


def describe_source(source: str, *, strict: bool) -> None:
    """Print what a mechanism is: joints, mobility, rank, and what statics leave open.

    Raises:
        CardanError: as `load` and `describe` do.
    """
    mechanism = load(source, strict=strict)
    report = describe(mechanism)
    for line in str(report).splitlines():
        say(line)
    loops = {loop.joint for loop in mechanism.loops}
    rows = []
    for item in mechanism.description.joints_and_loops:
        if item.name in mechanism.joints:
            kind = f"{item.type}, loop" if item.name in loops else item.type
            rows.append((item.name, kind, *links_of(item)))
    show(("joint", "type", "from", "to"), rows, texts=(0, 1, 2, 3))


def check_source(source: str, *, strict: bool, as_json: bool) -> bool:
    """Print what is wrong with a mechanism, what is determined, and how it can be driven.

    Returns:
        Whether it can be swept as it is.

    Raises:
        CardanError: as `load` does.
    """
    mechanism = load(source, strict=strict)
    report: MechanismReport | None = None
    drives: Drives | None = None
    reason = ""
    try:
        report = describe(mechanism)
        drives = report.drives
        if not drives.default:
            reason = drives.reason
    except CardanError as error:  # Loops that stay open, or a start that no scene accepts.
        reason = str(error)
    if as_json:
        print_json(_plain(mechanism, report, drives, reason))
    else:
        _print_check(mechanism, report, drives, reason)
    return not reason


def _print_check(
    mechanism: Mechanism,
    report: MechanismReport | None,
    drives: Drives | None,
    reason: str,
) -> None:
    joints, loops = len(mechanism.joints), len(mechanism.loops)
    say(f"{mechanism.name}: {counted(joints, 'joint')}, {counted(loops, 'loop')}")
    for text in mechanism.warnings if report is None else report.warnings:
        say(f"warning: {text}", "yellow")
    if report is not None:
        for line in _determined(report):
            say(line)
    if drives is not None and len(drives):
        found = drives_grid(drives)
        header, *rows = ((row[0], *row[3:]) for row in (found.header, *found.rows))
        show(header, rows, texts=(0, 3, 4))
    if reason:
        say(f"It cannot be swept: {reason}", "bold red")
        return
    assert drives is not None
    if drives.is_moved:
        say(
            "The description's zero is a singular configuration; ranges are those from beside it: "
            f"{_near(mechanism, drives)}"
        )
    say(f"It can be swept: {drives.reason}.", "green")


def _determined(report: MechanismReport) -> list[str]:
    """Return what the laws of motion decide, and what they leave open."""
    idle = len(report.idle_rods)
    mobility = f"mobility {report.mobility - idle}"
    if idle:
        mobility += f", and {idle} of idle rods, which need no drive"
    lines = [mobility]
    lines += report.silent
    if report.silent:
        lines.append(f"  {REMEDY}")
    if any(loop.indeterminate is None for loop in report.loops):
        lines.append("too large to tell which wrenches statics determine")
    elif not report.left_open:
        what = "motion and statics" if report.loops else "statics"
        if not report.silent:
            lines.append(f"{what} determine all wrenches")
    else:
        redundant = sum(component.self_stresses for component in report.components)
        lines.append(
            f"not determined by statics, {redundant} redundant closure equations; sweeps choose "
            "the least norm, or go by compliance="
        )
        lines += [f"  {what} at {choices(of)}" for what, of in report.left_open.items()]
    singular = [component for component in report.components if component.is_singular_at_zero]
    lines += [f"singular at zero: {component.names}" for component in singular]
    return lines


def _near(mechanism: Mechanism, drives: Drives) -> str:
    """Return where some joints are; of balls and universal joints the numbers of a row."""
    places = list(drives.start.positions.items())[:4]
    return ", ".join(
        f"{name} {place(cleared(float(value)), slides(mechanism, name))}"
        if name in mechanism.drivable
        else f"{name} {as_text(np.atleast_1d(value))}"
        for name, value in places
    )


def _plain(
    mechanism: Mechanism, report: MechanismReport | None, drives: Drives | None, reason: str
) -> dict[str, Any]:
    """Return all that is printed, in SI units and radians."""
    told: dict[str, Any] = {
        "mechanism": mechanism.name,
        "warnings": list(mechanism.warnings if report is None else report.warnings),
        "can_be_swept": not reason,
        "reason": reason or (drives.reason if drives is not None else ""),
    }
    if report is not None:
        told["mobility"] = report.mobility
        told["idle_rods"] = [list(rod) for rod in report.idle_rods]
        told["indeterminate"] = {loop.name: loop.indeterminate for loop in report.loops}
    if drives is not None:
        told["default"] = list(drives.default)
        told["held"] = dict(drives.held)
        told["drives"] = [
            {
                "name": item.name,
                "unit": mechanism.drivable[item.name].unit,
                "determines": item.determines,
                "range": item.range,
                "turns": item.turns,
                "limits": item.limits,
                "instead_of": list(item.instead_of),
                "ends": item.ends,
            }
            for item in drives.ranked
        ]
    return told
