"""Clearance: play in joints, from rigid forces to impact peaks."""

from ..elements.contact_laws import (
    ContactLaw,
    HuntCrossley,
    ImpactFunction,
    LankaraniNikravesh,
    LinearContact,
)
from .impact_model import ImpactModel
from .influence import Influence, influence
from .joint_scan import JointScan, Reversal
from .pin_geometry import PinGeometry
from .scan import Scan, scan
from .two_mass_motion import Energies, Impact, TwoMassMotion, TwoMassState
from .two_masses import two_masses

__all__ = [
    "ContactLaw",
    "Energies",
    "HuntCrossley",
    "Impact",
    "ImpactFunction",
    "ImpactModel",
    "Influence",
    "JointScan",
    "LankaraniNikravesh",
    "LinearContact",
    "PinGeometry",
    "Reversal",
    "Scan",
    "TwoMassMotion",
    "TwoMassState",
    "influence",
    "scan",
    "two_masses",
]
