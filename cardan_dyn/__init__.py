"""Joint wrenches of closed-chain mechanisms, with Pinocchio."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from ._version import __version__

if TYPE_CHECKING:
    from . import analytic, figures
    from .core.description.read import bundled_names
    from .core.dynamics.problem_solver import AssembledPositions
    from .core.elements.bushing import Bushing
    from .core.elements.contact_laws import (
        HuntCrossley,
        ImpactFunction,
        LankaraniNikravesh,
        LinearContact,
    )
    from .core.elements.described import described_elements
    from .core.elements.joint_elements import Actuator, JointFriction, JointSpring
    from .core.elements.link_loads import Wrench
    from .core.elements.pin_contact import PinContact
    from .core.elements.point_actuator import PointActuator
    from .core.elements.point_spring import PointSpring
    from .core.mechanics.exact import load
    from .core.mechanism.configuration import Configuration
    from .core.mechanism.joints import Joint
    from .core.mechanism.mechanism import Mechanism
    from .core.response.response import Response
    from .core.results.derivative import Derivative
    from .core.results.jacobian import Jacobian
    from .core.results.motion import Motion
    from .core.results.point_motion import PointMotion
    from .core.results.regressor import BaseParameters, Regressor
    from .core.results.rods import RodForce
    from .core.results.sweep import Sweep
    from .core.results.wrench import BearingForces, JointWrench
    from .core.transmission.borders import Border
    from .core.transmission.fitted import FittedTransmission
    from .core.transmission.reduced import ReducedTree
    from .core.transmission.transmission import Transmission
    from .core.transmission.workspace import BorderCurve, Workspace
    from .kit.errors import (
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
    from .kit.time_left import progress
    from .motion import clearance, vibration
    from .motion.simulation.equilibrium import Equilibrium
    from .motion.simulation.events import Event
    from .motion.simulation.trajectory import Trajectory
    from .practice import drive_lines, studies
    from .practice.formats.pinocchio.reader import from_pinocchio
    from .practice.report.reporting import Report, Reports
    from .practice.studies.study import study
    from .practice.viewer.viewing import View, view
    from .scene.assembling import assemble, write
    from .scene.branches import Branches
    from .scene.closing import close, couple
    from .scene.describe import describe
    from .scene.design_variables import DesignVariables
    from .scene.drives import Drive, Drives
    from .scene.linear_model import LinearModel
    from .scene.mechanism_report import MechanismReport
    from .scene.plan import Plan
    from .scene.scene import Scene, TaskScene
    from .scene.task_simulation import TaskTrajectory
    from .scene.task_sweep import TaskSweep
    from .scene.tasks import AngleTask, DirectionTask, DistanceTask, PointTask, PoseTask

_MODULES = {
    "AccuracyError": ".kit.errors",
    "Actuator": ".core.elements.joint_elements",
    "AngleTask": ".scene.tasks",
    "DirectionTask": ".scene.tasks",
    "DistanceTask": ".scene.tasks",
    "ArgumentError": ".kit.errors",
    "AssembledPositions": ".core.dynamics.problem_solver",
    "AssemblyError": ".kit.errors",
    "BaseParameters": ".core.results.regressor",
    "BearingForces": ".core.results.wrench",
    "Border": ".core.transmission.borders",
    "BorderCurve": ".core.transmission.workspace",
    "Branches": ".scene.branches",
    "Bushing": ".core.elements.bushing",
    "CardanError": ".kit.errors",
    "Configuration": ".core.mechanism.configuration",
    "DesignVariables": ".scene.design_variables",
    "Drive": ".scene.drives",
    "Drives": ".scene.drives",
    "Equilibrium": ".motion.simulation.equilibrium",
    "EquilibriumError": ".kit.errors",
    "Event": ".motion.simulation.events",
    "FittedTransmission": ".core.transmission.fitted",
    "HuntCrossley": ".core.elements.contact_laws",
    "ImmutableError": ".kit.errors",
    "ImpactFunction": ".core.elements.contact_laws",
    "IndeterminateError": ".kit.errors",
    "Jacobian": ".core.results.jacobian",
    "Joint": ".core.mechanism.joints",
    "JointFriction": ".core.elements.joint_elements",
    "JointSpring": ".core.elements.joint_elements",
    "JointWrench": ".core.results.wrench",
    "LankaraniNikravesh": ".core.elements.contact_laws",
    "LinearContact": ".core.elements.contact_laws",
    "LinearModel": ".scene.linear_model",
    "Mechanism": ".core.mechanism.mechanism",
    "MechanismReport": ".scene.mechanism_report",
    "MissingExtraError": ".kit.errors",
    "MobilityError": ".kit.errors",
    "ModelError": ".kit.errors",
    "Motion": ".core.results.motion",
    "PinContact": ".core.elements.pin_contact",
    "Plan": ".scene.plan",
    "Derivative": ".core.results.derivative",
    "PointMotion": ".core.results.point_motion",
    "PointActuator": ".core.elements.point_actuator",
    "PointSpring": ".core.elements.point_spring",
    "ReducedTree": ".core.transmission.reduced",
    "Regressor": ".core.results.regressor",
    "PointTask": ".scene.tasks",
    "PoseTask": ".scene.tasks",
    "Report": ".practice.report.reporting",
    "Reports": ".practice.report.reporting",
    "Response": ".core.response.response",
    "RodForce": ".core.results.rods",
    "Scene": ".scene.scene",
    "SimulationError": ".kit.errors",
    "SingularConfigurationError": ".kit.errors",
    "Sweep": ".core.results.sweep",
    "TaskScene": ".scene.scene",
    "TaskSweep": ".scene.task_sweep",
    "TaskTrajectory": ".scene.task_simulation",
    "Trajectory": ".motion.simulation.trajectory",
    "Transmission": ".core.transmission.transmission",
    "VibrationError": ".kit.errors",
    "View": ".practice.viewer.viewing",
    "Workspace": ".core.transmission.workspace",
    "Wrench": ".core.elements.link_loads",
    "assemble": ".scene.assembling",
    "bundled_names": ".core.description.read",
    "close": ".scene.closing",
    "couple": ".scene.closing",
    "describe": ".scene.describe",
    "described_elements": ".core.elements.described",
    "from_pinocchio": ".practice.formats.pinocchio.reader",
    "load": ".core.mechanics.exact",
    "progress": ".kit.time_left",
    "study": ".practice.studies.study",
    "view": ".practice.viewer.viewing",
    "write": ".scene.assembling",
}
"""Where each public name comes from: imported when it is first asked for, so that commands which
print their help load neither Pinocchio nor NumPy, and scripts load what they use."""

__all__ = [
    "AccuracyError",
    "Actuator",
    "AngleTask",
    "ArgumentError",
    "AssembledPositions",
    "AssemblyError",
    "BaseParameters",
    "BearingForces",
    "Border",
    "BorderCurve",
    "Branches",
    "Bushing",
    "CardanError",
    "Configuration",
    "Derivative",
    "DesignVariables",
    "DirectionTask",
    "DistanceTask",
    "Drive",
    "Drives",
    "Equilibrium",
    "EquilibriumError",
    "Event",
    "FittedTransmission",
    "HuntCrossley",
    "ImmutableError",
    "ImpactFunction",
    "IndeterminateError",
    "Jacobian",
    "Joint",
    "JointFriction",
    "JointSpring",
    "JointWrench",
    "LankaraniNikravesh",
    "LinearContact",
    "LinearModel",
    "Mechanism",
    "MechanismReport",
    "MissingExtraError",
    "MobilityError",
    "ModelError",
    "Motion",
    "PinContact",
    "Plan",
    "PointActuator",
    "PointMotion",
    "PointSpring",
    "PointTask",
    "PoseTask",
    "ReducedTree",
    "Regressor",
    "Report",
    "Reports",
    "Response",
    "RodForce",
    "Scene",
    "SimulationError",
    "SingularConfigurationError",
    "Sweep",
    "TaskScene",
    "TaskSweep",
    "TaskTrajectory",
    "Trajectory",
    "Transmission",
    "VibrationError",
    "View",
    "Workspace",
    "Wrench",
    "__version__",
    "analytic",
    "assemble",
    "bundled_names",
    "clearance",
    "close",
    "couple",
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
