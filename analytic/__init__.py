"""Closed forms of the universal joint, of drive lines and of joint clearance, on NumPy alone.

One module for each source or subject:

- `single_joint`: motion of one joint (Weisbach);
- `thoma`, `grossmann`: its torsion and bending moments;
- `joint_forms`: the ring in place of the cross, and Taylor's joint;
- `compound_angle`, `drive_line`, `uniformity`: shafts in series;
- `support_forces`, `shaft_design`: what the bearings of cardan shafts carry, and their design;
- `clearance`, `impact`, `peak_factor`, `peak_exponents`, `damped_impact`, `contact_stiffness`:
  joints with play (Dresig and Thuemmel);
- `design_torque`, `bending_speed`, `torsional_speed`, `installation`, `centred_double_joint`:
  rules by which makers and builders judge drive lines;
- `whirl`: critical speeds of a shaft on elastic bearings behind a joint (Thoma),
  `parametric_regions`: speeds at which elastic shafts at a joint are unstable;
- `limits`: their limits and makers' constants, `rules`: all of them with sources and assumptions;
- `errata`: errors found in the sources.
"""

from . import (
    bending_speed,
    centred_double_joint,
    clearance,
    compound_angle,
    contact_stiffness,
    damped_impact,
    design_torque,
    drive_line,
    errata,
    grossmann,
    impact,
    installation,
    joint_forms,
    limits,
    parametric_regions,
    peak_exponents,
    peak_factor,
    rules,
    shaft_design,
    single_joint,
    support_forces,
    thoma,
    torsional_speed,
    uniformity,
    whirl,
)

__all__ = [
    "bending_speed",
    "centred_double_joint",
    "clearance",
    "compound_angle",
    "contact_stiffness",
    "damped_impact",
    "design_torque",
    "drive_line",
    "errata",
    "grossmann",
    "impact",
    "installation",
    "joint_forms",
    "limits",
    "parametric_regions",
    "peak_exponents",
    "peak_factor",
    "rules",
    "shaft_design",
    "single_joint",
    "support_forces",
    "thoma",
    "torsional_speed",
    "uniformity",
    "whirl",
]
