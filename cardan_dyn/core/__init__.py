"""Core: what is given, what is asked, what is found, and whether it is right.

Rooms from the ground up: `tape` and `compiled`, `description`, `mechanism`, `elements` and
`mechanics`, `problem` and `proof`, `kinematics`, `dynamics`, `results`, `response` and
`transmission`. Motion and practice use of it what is public (`cardan_dyn.__all__`), and what it
offers here.
"""

OFFERED = {
    "compiled": ("absent",),
    "description.description": (
        "Description",
        "JointDescription",
        "JointOrLoop",
        "LinkDescription",
        "TWO_AXES",
    ),
    "description.elements": ("words",),
    "description.visual": ("Rgba", "Visual"),
    "description.visuals": ("visuals_of",),
    "description.write": ("to_urdf",),
    "dynamics.chain_tape": ("ChainTape", "ChainTapes"),
    "dynamics.open_tree": ("OpenTree",),
    "dynamics.problem_solver": ("ProblemSolver",),
    "dynamics.velocity_ratios": ("VelocityRatios",),
    "elements.contact_laws": ("ContactLaw",),
    "elements.element": ("Element",),
    "elements.element_efforts": ("ElementEfforts",),
    "elements.element_forces": ("labels",),
    "elements.joint_elements": ("JointElement",),
    "elements.link_loads": ("LinkLoad",),
    "elements.link_motions": ("LinkMotion", "LinkMotions"),
    "elements.pin_motion": ("PinPlace",),
    "elements.stepping": ("INSTANT", "ImplicitStepper", "Step", "Stepper", "Traced", "first_fall"),
    "kinematics.loops.idle_rods": ("rods_of",),
    "kinematics.tolerances": ("CLOSURE_TOLERANCE",),
    "mechanism.coordinates": ("Coordinates",),
    "mechanism.joints": ("Part",),
    "mechanism.undescribed": ("REMEDY",),
    "mechanism.welds": ("Loop",),
    "problem.acting": ("Acting",),
    "problem.arguments": ("by_coordinate", "split_loads"),
    "problem.coordinate_names": ("check_single",),
    "problem.element_arguments": ("elements_on", "listed"),
    "problem.problem": ("Problem",),
    "problem.samples": ("Targets", "acting_on", "targets_of"),
    "response.identity": ("forces_identity",),
    "results.axes": ("in_fixed_axes",),
    "results.derivative": ("efforts_by",),
    "results.collect": ("motion_at", "scattered", "sweep_of"),
    "results.element_results": ("ElementResults",),
    "results.inertia": ("mass_matrix_of",),
    "results.left_open": ("named_components",),
    "results.limits": ("efforts", "exceeded"),
    "results.lost_digits": ("WELL", "digits", "lost_part", "near_singular", "right"),
    "results.plot": ("Plot", "draws", "own_options"),
    "results.point_motion": ("Points",),
    "results.prescribed": ("MotionResult", "Prescribed"),
    "results.result": ("Result",),
    "results.sweep": ("FRAMES",),
    "results.table": ("SUFFIXES", "Table", "Variable"),
    "results.wrench": ("WITHOUT_AXIS",),
}
"""Names that others than the core may import, by the modules that have them."""
