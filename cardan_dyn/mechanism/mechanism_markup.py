"""Mechanism markup: what a notebook shows of a mechanism."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..markup import table
from .couplings import shown

if TYPE_CHECKING:
    from .mechanism import Mechanism


def html_of(mechanism: Mechanism) -> str:
    """Return a mechanism as an HTML table of its properties."""
    joints = (f"{joint.name}: {joint.type}" for joint in mechanism.joints.values())
    rows = [
        ("notation", mechanism.notation),
        ("characteristic length", f"{mechanism.characteristic_length:.4g} m"),
        ("joints", "\n".join(joints)),
        ("loops", ", ".join(loop.joint for loop in mechanism.loops) or "none"),
        ("couplings", "\n".join(map(shown, mechanism.couplings)) or "none"),
        ("warnings", "\n".join(mechanism.warnings) or "none"),
    ]
    return table(("property", "value"), rows, caption=mechanism.name)
