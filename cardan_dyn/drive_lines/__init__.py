"""Drive lines: shafts and universal joints as data, their closed-chain description and analysis."""

from . import arrangements
from .design.layout import Layout
from .design.phasing import Alternative, Phasing
from .drive_line import DriveLine, toml_schema
from .line.files import examples
from .line.geometry import Geometry
from .line.parts import Bearing, Centring, DutyPoint, Shaft, ShaftJoint, Spline, TitleBlock, Tube
from .verdict.analysis import Analysis, LineForces
from .verdict.rows import Inverse, VerdictRow
from .verdict.variants import Variants
from .verdict.verdict import Verdict

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
    "TitleBlock",
    "Tube",
    "Variants",
    "Verdict",
    "VerdictRow",
    "arrangements",
    "examples",
    "toml_schema",
]
