"""Clearance: play in joints, from rigid forces to impact peaks."""

from .impact_model import ImpactModel
from .influence import Influence, influence
from .joint_scan import JointScan, Reversal
from .pin_geometry import PinGeometry
from .scan import Scan, scan

__all__ = [
    "ImpactModel",
    "Influence",
    "JointScan",
    "PinGeometry",
    "Reversal",
    "Scan",
    "influence",
    "scan",
]
