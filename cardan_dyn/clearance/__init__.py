"""Clearance: play in joints, from rigid forces to impact peaks."""

from .joint_scan import JointScan, Reversal
from .scan import Scan, scan

__all__ = ["JointScan", "Reversal", "Scan", "scan"]
