"""Drive lines: shafts and universal joints as data, their closed-chain description and analysis."""

from .analysis import Analysis
from .drive_line import DriveLine
from .forces import LineForces
from .geometry import Geometry
from .parts import Bearing, DutyPoint, Joint, Shaft, Spline, Tube
from .toml_schema import toml_schema
from .variants import Variants

__all__ = [
    "Analysis",
    "Bearing",
    "DriveLine",
    "DutyPoint",
    "Geometry",
    "Joint",
    "LineForces",
    "Shaft",
    "Spline",
    "Tube",
    "Variants",
    "toml_schema",
]
