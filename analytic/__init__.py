"""Closed forms of the universal joint, of drive lines and of joint clearance, on NumPy alone.

One module for each source or subject:

- `single_joint`: motion of one joint (Weisbach);
- `thoma`, `grossmann`: its torsion and bending moments;
- `joint_forms`: the ring in place of the cross, and Taylor's joint;
- `compound_angle`, `drive_line`, `drive_acceleration`: shafts in series;
- `support_forces`, `shaft_design`: what the bearings of a cardan shaft carry, and its limits;
- `clearance`, `impact`, `contact_stiffness`: joints with play (Dresig and Thuemmel);
- `errata`: errors found in the sources.
"""

from analytic import (
    clearance,
    compound_angle,
    contact_stiffness,
    drive_acceleration,
    drive_line,
    errata,
    grossmann,
    impact,
    joint_forms,
    shaft_design,
    single_joint,
    support_forces,
    thoma,
)

__all__ = [
    "clearance",
    "compound_angle",
    "contact_stiffness",
    "drive_acceleration",
    "drive_line",
    "errata",
    "grossmann",
    "impact",
    "joint_forms",
    "shaft_design",
    "single_joint",
    "support_forces",
    "thoma",
]
