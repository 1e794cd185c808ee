"""Joint wrenches of closed-chain mechanisms, with Pinocchio."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .arguments import Wrench
from .errors import (
    AccuracyError,
    ArgumentError,
    AssemblyError,
    CardanError,
    ImmutableError,
    IndeterminateError,
    MissingExtraError,
    MobilityError,
    ModelError,
    SingularConfigurationError,
)
from .mechanism import Joint, Mechanism, load
from .motion import Motion
from .plan import Plan
from .read import bundled_names
from .results import ClosedPositions
from .scene import Scene
from .sweep import Sweep
from .wrench import JointWrench

if TYPE_CHECKING:
    from .response import Response
    from .viewer import View, view

__version__ = "0.1.0"

__all__ = [
    "AccuracyError",
    "ArgumentError",
    "AssemblyError",
    "CardanError",
    "ClosedPositions",
    "ImmutableError",
    "IndeterminateError",
    "Joint",
    "JointWrench",
    "Mechanism",
    "MissingExtraError",
    "MobilityError",
    "ModelError",
    "Motion",
    "Plan",
    "Response",
    "Scene",
    "SingularConfigurationError",
    "Sweep",
    "View",
    "Wrench",
    "bundled_names",
    "load",
    "view",
]


def __getattr__(name: str) -> object:
    """Import what most scripts never ask for when it is first asked for."""
    if name == "Response":
        from .response import Response

        return Response
    if name in ("View", "view"):
        from . import viewer

        return getattr(viewer, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
