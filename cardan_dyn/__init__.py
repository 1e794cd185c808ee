"""Joint wrenches of closed-chain mechanisms, with Pinocchio."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from ._version import __version__
from .description.read import bundled_names
from .dynamics.problem_solver import AssembledPositions
from .elements.link_loads import Wrench
from .errors import (
    AccuracyError,
    ArgumentError,
    AssemblyError,
    CardanError,
    EquilibriumError,
    ImmutableError,
    IndeterminateError,
    MissingExtraError,
    MobilityError,
    ModelError,
    SimulationError,
    SingularConfigurationError,
    VibrationError,
)
from .mechanism.joints import Joint
from .mechanism.mechanism import Mechanism, load
from .results.motion import Motion
from .results.sweep import Sweep
from .results.wrench import JointWrench
from .scene.scene import Scene

if TYPE_CHECKING:
    from . import clearance, drive_lines, figures, vibration
    from .elements.bushing import Bushing
    from .elements.contact_laws import (
        HuntCrossley,
        ImpactFunction,
        LankaraniNikravesh,
        LinearContact,
    )
    from .elements.described import described_elements
    from .elements.joint_elements import Actuator, JointFriction, JointSpring
    from .elements.pin_contact import PinContact
    from .elements.point_spring import PointSpring
    from .mechanism.configuration import Configuration
    from .response.response import Response
    from .scene.assembling import assemble, write
    from .scene.branches import Branches
    from .scene.describe import describe
    from .scene.mechanism_report import MechanismReport
    from .scene.plan import Plan
    from .simulation.equilibrium import Equilibrium
    from .simulation.events import Event
    from .simulation.trajectory import Trajectory
    from .viewer.viewing import View, view

_IMPORTED_WHEN_USED = {
    "Actuator": ".elements.joint_elements",
    "Branches": ".scene.branches",
    "Bushing": ".elements.bushing",
    "Configuration": ".mechanism.configuration",
    "Equilibrium": ".simulation.equilibrium",
    "Event": ".simulation.events",
    "HuntCrossley": ".elements.contact_laws",
    "ImpactFunction": ".elements.contact_laws",
    "JointFriction": ".elements.joint_elements",
    "JointSpring": ".elements.joint_elements",
    "LankaraniNikravesh": ".elements.contact_laws",
    "LinearContact": ".elements.contact_laws",
    "MechanismReport": ".scene.mechanism_report",
    "Plan": ".scene.plan",
    "PinContact": ".elements.pin_contact",
    "PointSpring": ".elements.point_spring",
    "Response": ".response.response",
    "Trajectory": ".simulation.trajectory",
    "View": ".viewer.viewing",
    "assemble": ".scene.assembling",
    "describe": ".scene.describe",
    "described_elements": ".elements.described",
    "view": ".viewer.viewing",
    "write": ".scene.assembling",
}
"""What most scripts never ask for."""

__all__ = [
    "AccuracyError",
    "Actuator",
    "ArgumentError",
    "AssembledPositions",
    "AssemblyError",
    "Branches",
    "Bushing",
    "CardanError",
    "Configuration",
    "Equilibrium",
    "EquilibriumError",
    "Event",
    "HuntCrossley",
    "ImmutableError",
    "ImpactFunction",
    "IndeterminateError",
    "Joint",
    "JointFriction",
    "JointSpring",
    "JointWrench",
    "LankaraniNikravesh",
    "LinearContact",
    "Mechanism",
    "MechanismReport",
    "MissingExtraError",
    "MobilityError",
    "ModelError",
    "Motion",
    "PinContact",
    "Plan",
    "PointSpring",
    "Response",
    "Scene",
    "SimulationError",
    "SingularConfigurationError",
    "Sweep",
    "Trajectory",
    "VibrationError",
    "View",
    "Wrench",
    "__version__",
    "assemble",
    "bundled_names",
    "clearance",
    "describe",
    "described_elements",
    "drive_lines",
    "figures",
    "load",
    "vibration",
    "view",
    "write",
]


def __getattr__(name: str) -> object:
    if name in ("clearance", "drive_lines", "figures", "vibration"):
        return import_module(f".{name}", __name__)
    if name in _IMPORTED_WHEN_USED:
        return getattr(import_module(_IMPORTED_WHEN_USED[name], __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    modules = (name for name in globals() if name.startswith("__"))
    return sorted({*modules, *__all__})
