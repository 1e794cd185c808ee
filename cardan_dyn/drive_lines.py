"""Drive lines: shafts and universal joints as data, their closed-chain description and analysis."""

from .practice.drive_lines import arrangements
from .practice.drive_lines.design.layout import Layout
from .practice.drive_lines.design.phasing import Alternative, Phasing
from .practice.drive_lines.drive_line import DriveLine, toml_schema
from .practice.drive_lines.line.files import examples
from .practice.drive_lines.line.geometry import Geometry
from .practice.drive_lines.line.parts import (
    Bearing,
    Centring,
    DutyPoint,
    Shaft,
    ShaftJoint,
    Spline,
    TitleBlock,
    Tube,
)
from .practice.drive_lines.verdict.analysis import Analysis, LineForces
from .practice.drive_lines.verdict.rows import Inverse, VerdictRow
from .practice.drive_lines.verdict.variants import Variants
from .practice.drive_lines.verdict.verdict import Verdict

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
