"""Closed forms of the universal joint, of drive lines and of joint clearance, on NumPy alone.

One module for each source or subject:

- `single_joint`: motion of one joint (Weisbach);
- `thoma`, `grossmann`: its torsion and bending moments;
- `joint_forms`: the ring in place of the cross, and Taylor's joint;
- `compound_angle`, `drive_line`, `drive_acceleration`: shafts in series;
- `support_forces`, `shaft_design`: what the bearings of a cardan shaft carry, and its limits;
- `clearance`, `impact`, `peak_factor`, `peak_exponents`, `damped_impact`, `contact_stiffness`:
  joints with play (Dresig and Thuemmel);
- `design_torque`, `joint_rating`, `tube`, `bending_speed`, `torsional_speed`, `uniformity`,
  `fork_couples`, `line_forces`, `axial_force`, `installation`, `centred_double_joint`,
  `precision_joint`: rules by which makers and builders judge drive lines;
- `whirl`: critical speeds of a shaft on elastic bearings behind a joint (Thoma),
  `parametric_regions`: speeds at which elastic shafts at a joint are unstable;
- `limits`: their limits and makers' constants, `rules`: all of them with sources and assumptions;
- `errata`: errors found in the sources.
"""

from analytic import (
    axial_force,
    bending_speed,
    centred_double_joint,
    clearance,
    compound_angle,
    contact_stiffness,
    damped_impact,
    design_torque,
    drive_acceleration,
    drive_line,
    errata,
    fork_couples,
    grossmann,
    impact,
    installation,
    joint_forms,
    joint_rating,
    limits,
    line_forces,
    parametric_regions,
    peak_exponents,
    peak_factor,
    precision_joint,
    rules,
    shaft_design,
    single_joint,
    support_forces,
    thoma,
    torsional_speed,
    tube,
    uniformity,
    whirl,
)

__all__ = [
    "axial_force",
    "bending_speed",
    "centred_double_joint",
    "clearance",
    "compound_angle",
    "contact_stiffness",
    "damped_impact",
    "design_torque",
    "drive_acceleration",
    "drive_line",
    "errata",
    "fork_couples",
    "grossmann",
    "impact",
    "installation",
    "joint_forms",
    "joint_rating",
    "limits",
    "line_forces",
    "parametric_regions",
    "peak_exponents",
    "peak_factor",
    "precision_joint",
    "rules",
    "shaft_design",
    "single_joint",
    "support_forces",
    "thoma",
    "torsional_speed",
    "tube",
    "uniformity",
    "whirl",
]
