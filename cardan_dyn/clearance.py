"""Clearance in joints: from rigid forces to impact peaks."""

from .core.elements.contact_laws import (
    ContactLaw,
    HuntCrossley,
    ImpactFunction,
    LankaraniNikravesh,
    LinearContact,
)
from .motion.clearance import drawing as drawing
from .motion.clearance.comparing import compare
from .motion.clearance.contact_simulation import ContactSimulation, JointContact, PinImpact
from .motion.clearance.impact_model import ImpactModel
from .motion.clearance.influences import Influence, influence
from .motion.clearance.pin_geometry import PinGeometry
from .motion.clearance.scan_maps import ScanMap, scan_map
from .motion.clearance.scan_results import (
    ComparedReversal,
    ForceReversal,
    JointScan,
    Scan,
    ScanComparison,
)
from .motion.clearance.scanning import scan
from .motion.clearance.simulating import simulate

__all__ = [
    "ComparedReversal",
    "ContactLaw",
    "ContactSimulation",
    "ForceReversal",
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
    "Scan",
    "ScanComparison",
    "ScanMap",
    "compare",
    "influence",
    "scan",
    "scan_map",
    "simulate",
]
