"""Clearance in joints: from rigid forces to impact peaks."""

from ..elements.contact_laws import (
    ContactLaw,
    HuntCrossley,
    ImpactFunction,
    LankaraniNikravesh,
    LinearContact,
)
from .comparing import compare
from .contact_simulation import ContactSimulation, JointContact, PinImpact
from .impact_model import ImpactModel
from .influences import Influence, influence
from .pin_geometry import PinGeometry
from .scan_maps import ScanMap, scan_map
from .scan_results import ComparedReversal, ForceReversal, JointScan, Scan, ScanComparison
from .scanning import scan
from .simulating import simulate

from . import plots  # isort: skip  # noqa: F401  Results draw themselves from here on.

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
