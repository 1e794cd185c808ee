"""Drive lines: shafts and universal joints as data, their closed-chain description and analysis."""

from .drive_line import DriveLine
from .geometry import Geometry
from .parts import Bearing, DutyPoint, Joint, Shaft, Spline, Tube
from .toml_schema import toml_schema

__all__ = [
    "Bearing",
    "DriveLine",
    "DutyPoint",
    "Geometry",
    "Joint",
    "Shaft",
    "Spline",
    "Tube",
    "toml_schema",
]
