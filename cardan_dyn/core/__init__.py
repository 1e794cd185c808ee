"""Core: what is given, what is asked, what is found, and whether it is right.

Rooms from the ground up: `tape` and `compiled`, `description`, `mechanism`, `elements` and
`mechanics`, `problem` and `proof`, `kinematics`, `dynamics`, `results`, `response`. Motion and
practice use of it what is public (`cardan_dyn.__all__`), and what it offers here.
"""

OFFERED = {
    "compiled": ("absent",),
    "description.description": ("JointDescription", "JointOrLoop", "LinkDescription", "TWO_AXES"),
    "description.elements": ("words",),
    "description.visual": ("Rgba", "Visual"),
    "description.visuals": ("visuals_of",),
    "description.write": ("to_urdf",),
    "dynamics.problem_solver": ("ProblemSolver",),
    "dynamics.velocity_ratios": ("VelocityRatios",),
    "elements.element": ("Element",),
    "elements.element_forces": ("labels",),
    "elements.joint_elements": ("JointElement",),
    "elements.link_motions": ("LinkMotion", "LinkMotions"),
    "mechanism.joints": ("Part",),
    "mechanism.undescribed": ("REMEDY",),
    "problem.arguments": ("by_coordinate",),
    "problem.element_arguments": ("elements_on", "listed"),
    "problem.samples": ("targets_of",),
    "results.axes": ("in_fixed_axes",),
    "results.left_open": ("named_components",),
    "results.lost_digits": ("WELL", "digits", "lost_part", "near_singular", "right"),
    "results.plot": ("Plot", "own_options"),
    "results.result": ("Result",),
    "results.table": ("Table", "Variable"),
    "results.wrench": ("WITHOUT_AXIS",),
}
"""Names that others than the core may import, by the modules that have them."""
