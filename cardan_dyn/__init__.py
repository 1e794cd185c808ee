"""Joint wrenches of closed-chain mechanisms, with Pinocchio."""

from .arguments import Wrench
from .errors import (
    AccuracyError,
    ArgumentError,
    AssemblyError,
    CardanError,
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
from .response import Response
from .scene import Scene
from .sweep import Sweep
from .wrench import JointWrench

__version__ = "0.1.0"

__all__ = [
    "AccuracyError",
    "ArgumentError",
    "AssemblyError",
    "CardanError",
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
    "Wrench",
    "bundled_names",
    "load",
]
