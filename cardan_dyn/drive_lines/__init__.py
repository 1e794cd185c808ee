"""Drive lines: shafts and universal joints as data, their closed-chain description and analysis."""

from . import arrangements
from .analysis import Analysis, LineForces
from .drive_line import DriveLine
from .geometry import Geometry
from .layout import Layout
from .parts import Bearing, Centring, DutyPoint, Shaft, ShaftJoint, Spline, Tube
from .phasing import Alternative, Phasing
from .toml_files import examples, toml_schema
from .variants import Variants
from .verdict import Verdict
from .verdict_rows import Inverse, VerdictRow

__all__ = [
    "Alternative",
    "Analysis",
    "Bearing",
    "Centring",
    "DriveLine",
    "DutyPoint",
    "Geometry",
    "Inverse",
    "Layout",
    "LineForces",
    "Phasing",
    "Shaft",
    "ShaftJoint",
    "Spline",
    "Tube",
    "Variants",
    "Verdict",
    "VerdictRow",
    "arrangements",
    "examples",
    "toml_schema",
]
