"""Clearance in joints: from rigid forces to impact peaks."""

from ..elements.contact_laws import (
    ContactLaw,
    HuntCrossley,
    ImpactFunction,
    LankaraniNikravesh,
    LinearContact,
)
from .compared import Compared, Comparison
from .comparison import compare
from .contact_simulation import ContactSimulation, JointContact, PinImpact
from .impact_model import ImpactModel
from .influence import Influence, influence
from .joint_scan import JointScan, Reversal
from .pin_bearings import scan_pins
from .pin_geometry import PinGeometry
from .pin_map import PinMap, map_pins
from .pin_scan import PinReversal, PinScan
from .scan import scan
from .scanned import Scan
from .simulate import simulate

__all__ = [
    "Compared",
    "Comparison",
    "ContactLaw",
    "ContactSimulation",
    "HuntCrossley",
    "ImpactFunction",
    "ImpactModel",
    "Influence",
    "JointContact",
    "JointScan",
    "LankaraniNikravesh",
    "LinearContact",
    "PinGeometry",
    "PinImpact",
    "PinMap",
    "PinReversal",
    "PinScan",
    "Reversal",
    "Scan",
    "compare",
    "influence",
    "map_pins",
    "scan",
    "scan_pins",
    "simulate",
]
