"""Clearance: play in joints, from rigid forces to impact peaks."""

from ..elements.contact_laws import (
    ContactLaw,
    HuntCrossley,
    ImpactFunction,
    LankaraniNikravesh,
    LinearContact,
)
from .joint_scan import JointScan, Reversal
from .scan import Scan, scan
from .two_mass_motion import Energies, Impact, TwoMassMotion, TwoMassState
from .two_masses import two_masses

__all__ = [
    "ContactLaw",
    "Energies",
    "HuntCrossley",
    "Impact",
    "ImpactFunction",
    "JointScan",
    "LankaraniNikravesh",
    "LinearContact",
    "Reversal",
    "Scan",
    "TwoMassMotion",
    "TwoMassState",
    "scan",
    "two_masses",
]
