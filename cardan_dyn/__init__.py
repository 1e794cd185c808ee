"""Joint wrenches of closed-chain mechanisms, with Pinocchio."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from ._version import __version__

if TYPE_CHECKING:
    from . import analytic, clearance, drive_lines, figures, studies, vibration
    from .description.read import bundled_names
    from .dynamics.problem_solver import AssembledPositions
    from .elements.bushing import Bushing
    from .elements.contact_laws import (
        HuntCrossley,
        ImpactFunction,
        LankaraniNikravesh,
        LinearContact,
    )
    from .elements.described import described_elements
    from .elements.joint_elements import Actuator, JointFriction, JointSpring
    from .elements.link_loads import Wrench
    from .elements.pin_contact import PinContact
    from .elements.point_spring import PointSpring
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
    from .mechanics.exact import from_pinocchio, load
    from .mechanism.configuration import Configuration
    from .mechanism.joints import Joint
    from .mechanism.mechanism import Mechanism
    from .report.reporting import Report
    from .response.response import Response
    from .results.motion import Motion
    from .results.point_motion import PointMotion
    from .results.rods import RodForce
    from .results.sweep import Sweep
    from .results.wrench import BearingForces, JointWrench
    from .scene.assembling import assemble, write
    from .scene.branches import Branches
    from .scene.describe import describe
    from .scene.drives import Drive, Drives
    from .scene.mechanism_report import MechanismReport
    from .scene.plan import Plan
    from .scene.scene import Scene
    from .simulation.equilibrium import Equilibrium
    from .simulation.events import Event
    from .simulation.trajectory import Trajectory
    from .studies.study import study
    from .time_left import progress
    from .viewer.viewing import View, view

_MODULES = {
    "AccuracyError": ".errors",
    "Actuator": ".elements.joint_elements",
    "ArgumentError": ".errors",
    "AssembledPositions": ".dynamics.problem_solver",
    "AssemblyError": ".errors",
    "BearingForces": ".results.wrench",
    "Branches": ".scene.branches",
    "Bushing": ".elements.bushing",
    "CardanError": ".errors",
    "Configuration": ".mechanism.configuration",
    "Drive": ".scene.drives",
    "Drives": ".scene.drives",
    "Equilibrium": ".simulation.equilibrium",
    "EquilibriumError": ".errors",
    "Event": ".simulation.events",
    "HuntCrossley": ".elements.contact_laws",
    "ImmutableError": ".errors",
    "ImpactFunction": ".elements.contact_laws",
    "IndeterminateError": ".errors",
    "Joint": ".mechanism.joints",
    "JointFriction": ".elements.joint_elements",
    "JointSpring": ".elements.joint_elements",
    "JointWrench": ".results.wrench",
    "LankaraniNikravesh": ".elements.contact_laws",
    "LinearContact": ".elements.contact_laws",
    "Mechanism": ".mechanism.mechanism",
    "MechanismReport": ".scene.mechanism_report",
    "MissingExtraError": ".errors",
    "MobilityError": ".errors",
    "ModelError": ".errors",
    "Motion": ".results.motion",
    "PinContact": ".elements.pin_contact",
    "Plan": ".scene.plan",
    "PointMotion": ".results.point_motion",
    "PointSpring": ".elements.point_spring",
    "Report": ".report.reporting",
    "Response": ".response.response",
    "RodForce": ".results.rods",
    "Scene": ".scene.scene",
    "SimulationError": ".errors",
    "SingularConfigurationError": ".errors",
    "Sweep": ".results.sweep",
    "Trajectory": ".simulation.trajectory",
    "VibrationError": ".errors",
    "View": ".viewer.viewing",
    "Wrench": ".elements.link_loads",
    "assemble": ".scene.assembling",
    "bundled_names": ".description.read",
    "describe": ".scene.describe",
    "described_elements": ".elements.described",
    "from_pinocchio": ".mechanics.exact",
    "load": ".mechanics.exact",
    "progress": ".time_left",
    "study": ".studies.study",
    "view": ".viewer.viewing",
    "write": ".scene.assembling",
}
"""Where each public name comes from: imported when it is first asked for, so that commands which
print their help load neither Pinocchio nor NumPy, and scripts load what they use."""

__all__ = [
    "AccuracyError",
    "Actuator",
    "ArgumentError",
    "AssembledPositions",
    "AssemblyError",
    "BearingForces",
    "Branches",
    "Bushing",
    "CardanError",
    "Configuration",
    "Drive",
    "Drives",
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
    "PointMotion",
    "PointSpring",
    "Report",
    "Response",
    "RodForce",
    "Scene",
    "SimulationError",
    "SingularConfigurationError",
    "Sweep",
    "Trajectory",
    "VibrationError",
    "View",
    "Wrench",
    "__version__",
    "analytic",
    "assemble",
    "bundled_names",
    "clearance",
    "describe",
    "described_elements",
    "drive_lines",
    "figures",
    "from_pinocchio",
    "load",
    "progress",
    "studies",
    "study",
    "vibration",
    "view",
    "write",
]


def __getattr__(name: str) -> object:
    if name in ("analytic", "clearance", "drive_lines", "figures", "studies", "vibration"):
        return import_module(f".{name}", __name__)
    if name in _MODULES:
        value = globals()[name] = getattr(import_module(_MODULES[name], __name__), name)
        return value
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    modules = (name for name in globals() if name.startswith("__"))
    return sorted({*modules, *__all__})
