"""The rows of `analytic.rules.RULES`, in the order of the fields of a `Rule`."""

from __future__ import annotations

Row = tuple[
    str, str, str, tuple[str, ...], tuple[str, ...], str, tuple[str, ...], str, tuple[str, ...]
]

_RIGID = "Massless crosses and shafts, no friction."
_STEADY = "The input turns at constant speed."

ROWS: tuple[Row, ...] = (
    (
        "design_torque",
        "Design torque",
        "T = 9550 P/n K; LGT = T TLGR TE SR TCR C; WST = 0.71 W RR / (11.4 AR) in lb and in",
        (
            "design_torque.power_torque",
            "design_torque.low_gear_torque",
            "design_torque.wheel_slip_torque",
            "design_torque.vehicle_torque",
        ),
        ("adhesion", "axle_efficiency"),
        "Spicer driveline installation manual p. 2; AISCO; JW Winco; PSS",
        (
            "The lesser of LGT and WST counts on the road only; off the road LGT alone.",
            "Spicer goes at most one size below the one that LGT asks for.",
            "The service factor is that of the load and not of one maker's table.",
        ),
        "JW Winco: 0.65 kW at 230/min are 27 N m, 5.5 kW at 2300/min 23 N m; Spicer's and AISCO's "
        "forms in their units",
        (
            "test_design_torque.py::test_examples_of_jw_winco",
            "test_design_torque.py::test_power_in_the_units_of_aisco",
            "test_design_torque.py::test_wheel_slip_in_the_units_of_spicer",
        ),
    ),
    (
        "static_ratings",
        "Static ratings",
        "T <= elastic limit; T K <= T_CS; T K <= T_DSch pulsating, T_DW reversing; n <= n_max",
        ("design_torque.static_utilisation",),
        (),
        "PSS, ConditionAnalyzer; Dana's data sheets; AISCO (T_cs, T_e)",
        (
            "The ratings are those of the maker of this joint.",
            "The torque keeps its sense where the pulsating rating is used.",
        ),
        "arithmetic of ratios only; two sources state the same comparisons",
        ("test_design_torque.py::test_static_utilisation",),
    ),
    (
        "selection_torque",
        "Equivalent torque of a maker's table",
        "T_e = T K_1 K_2 K_3",
        ("design_torque.selection_torque",),
        (),
        "PSS, EquivalentTorque; IMS",
        ("Factors and rating are of the same table; T_e is neither T_D nor L_C.",),
        "two sources state the same product",
        ("test_design_torque.py::test_selection_torque_is_none_of_the_other_ratings",),
    ),
    (
        "tube",
        "Tube",
        "tau = 16 T D / (pi (D^4 - d^4)); c = pi G (D^4 - d^4) / (32 L)",
        ("tube.shear_stress", "tube.torsional_stiffness"),
        (),
        "PSS, Tube; textbooks",
        ("Elastic; no notches, no buckling of thin walls.", "Forks and splines count as rigid."),
        "integrals of stress and moment over the section",
        ("test_tube.py::test_stress_and_stiffness_are_those_of_the_section",),
    ),
    (
        "joint_life",
        "Life of the bearings of a joint",
        "L_h = 1.5e6/(n beta K) (T_D/T)^(10/3); T_D = T (L_h n beta K/1.5e6)^0.3; "
        "L_h = L_C 1e10/(n beta T^(10/3) K); mean life 5 L_h",
        (
            "shaft_design.joint_life",
            "shaft_design.joint_life_from_capacity",
            "joint_rating.required_rated_torque",
            "joint_rating.required_capacity",
            "joint_rating.mean_life",
        ),
        ("least_life_angle", "mean_life_factor"),
        "AISCO, II; GWB and Elbe catalogues; PSS, B10Life",
        (
            "Angles below 3 degrees count as 3 degrees.",
            "Rollers are lubricated and fail by fatigue; 90 % of the joints reach the life.",
            "T_D is the torque of 5000 h at n beta = 300 degrees/min; L_C is for T in kN m.",
        ),
        "AISCO rates at 5000 h, 100/min and 3 degrees; 1000 N m, 1450/min, 7 degrees and 2000 h "
        "ask for T_D = 2185 N m",
        (
            "test_joint_rating.py::test_rating_at_the_makers_reference",
            "test_joint_rating.py::test_kleins_case_by_three_ratings",
            "test_shaft_design.py::test_joint_life",
        ),
    ),
    (
        "duty_cycle",
        "Duty cycle",
        "1/L = sum q_i/L_i; T_eq = (sum q n beta T^(10/3) / sum q n beta)^0.3",
        ("shaft_design.duty_cycle_life", "joint_rating.equivalent_duty"),
        ("least_life_angle",),
        "AE-7 p. 31 (by PSS); AISCO, III; T_eq from the linear damage rule",
        (
            "Damage adds up linearly, whatever the order of the loads.",
            "Rows of idling and rest do no damage; coasting loads the same rollers as driving.",
        ),
        "own derivation of T_eq: its life is that of the cycle, for random cycles",
        (
            "test_joint_rating.py::test_equivalent_duty_has_the_life_of_the_cycle",
            "test_joint_rating.py::test_idle_and_coast_rows",
        ),
    ),
    (
        "uniformity",
        "Residual angle and non-uniformity",
        "beta_E = sqrt(|sum +-beta_k^2|) <= 3 degrees; U = 1/cos beta - cos beta; "
        "U = |sum +-U_k|; cos beta = (sqrt(U^2 + 4) - U)/2",
        (
            "drive_line.residual_angle",
            "drive_line.residual_angle_approximate",
            "single_joint.non_uniformity",
            "uniformity.added_non_uniformity",
            "uniformity.angle_of_non_uniformity",
        ),
        ("residual_angle", "non_uniformity"),
        "catalogue chapter 6 (Klein), 6.4 and 6.5; Elbe, technical annex 3",
        (
            _STEADY,
            "Shafts are rigid in torsion.",
            "Sums with signs hold for planar lines with forks at 0 or 90 degrees, to first order.",
        ),
        "12 against 10 degrees leave 6.633 degrees, exactly 6.667; U(3 degrees) = 0.0027428",
        (
            "test_drive_line.py::test_product_formula_of_both_fork_positions",
            "test_errata.py::test_numbers",
            "test_uniformity.py::test_limit_of_the_catalogue",
            "test_uniformity.py::test_added_non_uniformity",
        ),
    ),
    (
        "joint_angles",
        "Joint angles",
        "1/2 degree <= beta <= 6 degrees and the angle of the table by speed; difference of both "
        "<= 1 degree (engineersedge: 1.5)",
        (
            "compound_angle.compound_angle",
            "installation.joint_angles_from_slopes",
            "installation.greatest_joint_angle",
        ),
        (
            "joint_angle",
            "least_joint_angle",
            "speed_angle_share",
            "angle_difference",
            "angle_difference_edge",
        ),
        "Spicer driveline installation manual; engineersedge.com, vehicle driveline design",
        (
            "Road vehicles at usual speeds; slow drives bear more.",
            "The difference is that of a shaft whose two joints compensate each other.",
            "The least angle is that of joints with rollers.",
        ),
        "Spicer's table: 3.2 degrees at 5000/min, 5.0 at 3500/min; angles from slopes by spherical "
        "trigonometry",
        (
            "test_installation.py::test_greatest_angles_as_printed",
            "test_installation.py::test_compound_angles_from_slopes",
        ),
    ),
    (
        "accelerations",
        "Torsional and inertia acceleration",
        "theta^2 = |sum s_k beta_k^2|, inertia |sum (n-k) s_k beta_k^2|; epsilon = omega^2 sin^2 "
        "theta; beta_2^2 = beta_1^2 -+ epsilon/omega^2",
        (
            "drive_acceleration.torsional_angle",
            "drive_acceleration.inertia_drive_angle",
            "drive_acceleration.inertia_coast_angle",
            "drive_acceleration.angular_acceleration",
            "uniformity.allowed_angle",
            "uniformity.allowed_second_angle",
        ),
        (
            "torsional_acceleration",
            "torsional_acceleration_greatest",
            "torsional_acceleration_edge",
            "inertia_acceleration",
            "inertia_acceleration_greatest",
        ),
        "SAE AE-7 p. 50 (by PSS); engineersedge.com",
        (
            _STEADY,
            "Of first order in the squares of the angles: 1.5 % too small at 10 degrees.",
            "All intermediate shafts count alike in the inertia angles, whatever their inertia.",
        ),
        "PSS: 5, 4, 3, 2 degrees at 2500/min, first shaft crossed: 9.90, 3.16, 6.00 degrees and "
        "2026, 209, 749 rad/s^2; the table of second angles for 400 rad/s^2",
        (
            "test_drive_acceleration.py::test_example_of_pss",
            "test_uniformity.py::test_printed_angles_of_the_second_joint",
        ),
    ),
    (
        "n_beta",
        "Speed times angle",
        "n <= n_max, n beta <= (n beta)_perm per size; epsilon = 3.3405e-6 (n beta)^2; "
        "M = J_2 epsilon",
        (
            "drive_acceleration.n_beta_acceleration",
            "drive_acceleration.greatest_speed",
            "drive_acceleration.mass_acceleration_moment",
        ),
        (),
        "Dana commercial drive shafts catalogue, influence of speed and deflection angle; Dana "
        "industrial p. 41",
        (
            "The middle part has the inertia of a shaft of some 1.5 m.",
            "Makers call the values guidance; slightly higher ones are possible.",
        ),
        "27 000 and 17 000 degrees/min are 2435 and 965 rad/s^2; joint 2040 at 10 degrees may "
        "turn at 2000/min",
        (
            "test_limits.py::test_accelerations_behind_the_sizes_of_joints",
            "test_drive_acceleration.py::test_greatest_speed_of_a_size",
        ),
    ),
    (
        "bending_speed",
        "Critical bending speed",
        "n_cr = C sqrt(D^2 + d^2)/L^2; n <= 0.65 ... 0.75 n_cr and not within 0.42 ... 0.58 n_cr; "
        "L_max = sqrt(share C sqrt(D^2 + d^2)/n)",
        (
            "shaft_design.critical_speed",
            "bending_speed.critical_speed_by_constant",
            "shaft_design.speed_is_permissible",
            "bending_speed.greatest_length",
            "bending_speed.line_bending",
        ),
        (
            "bending_speed_share",
            "bending_speed_share_industrial",
            "bending_speed_share_automotive",
            "half_critical_from",
            "half_critical_to",
            "second_order_angle",
        ),
        "AE-7 p. 267 (by PSS); Elbe; IMS; Cardan India; Dana industrial p. 43",
        (
            "The constant: a steel tube of constant section, on rigid supports close to its "
            "joints; the beam of a line counts with joints, neighbours and bearings instead.",
            "The half-critical speed counts from joint angles of some 3 degrees on.",
        ),
        "PSS: 3.5 x 0.120 in, 60 in: 6251/min; calcady.com: 3.5 x 0.083 in, 45 in: 11 390/min "
        "(0.1 % of it by rounded intermediate values)",
        (
            "test_bending_speed.py::test_example_of_pss",
            "test_bending_speed.py::test_example_of_calcady",
            "test_bending_speed.py::test_greatest_length",
            "test_bending_speed.py::test_overhung_mass_and_hinged_shafts_in_closed_form",
            "test_bending_speed.py::test_line_lies_between_dunkerley_and_rayleigh",
        ),
    ),
    (
        "elastic_bearing",
        "Elastic centre bearing",
        "z^3 (coth z - cot z) = 2 k L^3/(E I), omega/omega_rigid = (z/pi)^2",
        ("bending_speed.elastic_bearing_factor", "bending_speed.on_elastic_bearing"),
        (),
        "own derivation (Euler-Bernoulli beam); Dana industrial p. 43 states the effect",
        (
            "One end on a rigid support, the other on a spring without mass.",
            "The neighbouring shaft neither loads nor stiffens the bearing.",
        ),
        "finite elements of the same beam, 2e-5, over eight decades of stiffness",
        ("test_bending_speed.py::test_elastic_bearing_is_that_of_finite_elements",),
    ),
    (
        "torsional_speed",
        "Torsional critical speeds",
        "f = sqrt(c (J_1 + J_2)/(J_1 J_2))/(2 pi); avoid 60 f/2, 60 f/4, and Omega = omega_n/k, "
        "the first within 1 -+ a beta^2/4",
        (
            "torsional_speed.two_inertia_frequency",
            "torsional_speed.critical_speeds",
            "torsional_speed.parametric_speed",
            "torsional_speed.parametric_zone",
        ),
        (),
        "Dana industrial p. 43; Mazzei and Scott 1999; Zajicek and Dupal 2014; own derivation of "
        "the width",
        (
            "Two inertias stand for the drive; the others are far from them in frequency.",
            "The zone is that of a spring in front of the joint; behind it there is none.",
            "Widths are of first order in beta^2 and without damping.",
        ),
        "own derivation against the monodromy matrix of the full equation: at 15 degrees and "
        "a = 1/2 0.99116 to 1.00850",
        (
            "test_torsional_speed.py::test_two_inertias_are_an_eigenvalue",
            "test_torsional_speed.py::test_first_zone_is_that_of_the_full_equation",
        ),
    ),
    (
        "fork_couples",
        "Fork couples",
        "T sin beta on the driven shaft, pin in the plane; T tan beta on the driving, pin normal",
        ("fork_couples.fork_couples",),
        (),
        "Klein chapter 7; Elbe, technical annex 2",
        (_RIGID, "Above 45 degrees the driven shaft is bent more in between."),
        "Thoma's Hauptlage A, M_b = M_t tan alpha; Grossmann (6) and (8)",
        ("test_fork_couples.py::test_positions_are_those_of_grossmann_and_thoma",),
    ),
    (
        "bearing_forces",
        "Bearing forces",
        "P = T cos beta_1 (tan beta_1 -+ tan beta_2)/L; A = P b/a ...; "
        "C = [l_1 Q - (M_1 - M_2) x e_2]/c, Q = (M_2 - M_3) x e_3/l_2",
        (
            "support_forces.planar_support_forces",
            "support_forces.support_forces",
            "line_forces.line_moments",
            "line_forces.line_support_forces",
        ),
        (),
        "Klein 7.1 and 7.2; Dana industrial p. 48; Spicer DSAG-0200 p. 18; for three and more "
        "joints own derivation",
        (
            _RIGID,
            "No axial force in the spline; centre bearings float along their shafts.",
            "One centre bearing on each intermediate shaft but the last.",
            "The greatest of a turn need not be at one of both printed positions.",
        ),
        "own derivation against the equilibrium of all shafts, solved as one linear system, for "
        "random lines of 2 to 6 joints, and against Pinocchio's reactions of the drive line in "
        "urdf/",
        (
            "test_line_forces.py::test_random_lines_are_in_equilibrium",
            "test_line_forces.py::test_three_joints_by_the_printed_formula",
            "test_support_forces.py::test_catalogue_formulas",
        ),
    ),
    (
        "axial_force",
        "Axial force",
        "F = T mu cos beta/r_m + p A; across the end shafts F sin beta",
        ("shaft_design.slip_force", "axial_force.axial_force", "axial_force.axial_support_forces"),
        ("lubrication_pressure",),
        "Dana industrial p. 47; Klein 7.3",
        ("The spline slides under full torque.", "Friction and pressure act in the same sense."),
        "statics of the end shafts; 15 bar on 20 cm^2 are 3 kN",
        (
            "test_axial_force.py::test_friction_and_pressure",
            "test_axial_force.py::test_bearings_carry_the_force_across_the_end_shafts",
        ),
    ),
    (
        "lengths",
        "Length and telescope",
        "L_B = L_z + L_a/3, L_Bmax = L_z + L_a; travel left when shortest, overlap when longest",
        ("installation.operating_lengths", "installation.telescope_margins"),
        (
            "telescope_travel_left",
            "telescope_travel_left_befco",
            "telescope_overlap",
            "pto_angle",
            "wide_angle_from",
        ),
        "Dana commercial and industrial catalogues, length dimensions; Befco; PTO practice",
        ("Lengths are those between joint centres over the whole travel of the suspension.",),
        "two catalogues print the same rule",
        (
            "test_installation.py::test_operating_lengths",
            "test_installation.py::test_telescope_margins",
        ),
    ),
    (
        "slopes",
        "Compound angles from slopes",
        "joint angle between the directions (slope, heading) of neighbouring shafts",
        ("installation.shaft_directions", "installation.joint_angles_from_slopes"),
        (),
        "Spicer torsional analysis calculator; Spicer driveline installation manual p. 10",
        ("Slopes are measured along the shafts, all of them against the same horizontal.",),
        "law of cosines on the sphere; in one plane the differences of the slopes",
        (
            "test_installation.py::test_joint_angles_in_one_plane_are_differences_of_slopes",
            "test_installation.py::test_compound_angles_from_slopes",
        ),
    ),
    (
        "centred_double_joint",
        "Centred double joint",
        "X = a (1/cos(beta_x/2) - 1); sin beta_1 = (a + X) sin beta/(2 a), beta_2 = beta - beta_1; "
        "e = sqrt(4 a^2 - (a + X)^2 sin^2 beta) - (a + X) cos beta - (a - X)",
        ("centred_double_joint.centre_offset", "centred_double_joint.centred_joint"),
        ("residual_angle",),
        "own derivation; Elbe, technical annex 7 and SOREM treat the same joint",
        (
            "One shaft slides, the swivel axis is fixed to the other.",
            "Both forks stand in line.",
            "A disc in the middle plane of the piece instead of a ball: both angles are equal.",
        ),
        "own derivation against points in the plane at 15 digits; a = 60 mm, 35 degrees: "
        "X = 2.91 mm, residual 3.6 degrees at 20 and 8.4 at 45",
        (
            "test_centred_double_joint.py::test_angles_and_slip_are_those_of_the_points",
            "test_centred_double_joint.py::test_numbers_of_the_usual_joint",
        ),
    ),
    (
        "balancing",
        "Balancing",
        "U = 9549 G m/n in g mm; needed above 300 to 500/min",
        ("installation.residual_unbalance",),
        (
            "balancing_speed",
            "balancing_speed_least",
            "balance_grade_maker",
            "balance_grade_check",
            "balance_grade_iso",
        ),
        "ISO 21940-11 (by Erbessd); Dana industrial p. 49; Cardan India",
        ("The shaft is rigid: it runs well below its critical speed.",),
        "G16, 20 kg, 3000/min: 1018.6 g mm by the printed form",
        ("test_installation.py::test_unbalance_in_the_units_of_the_standard",),
    ),
    (
        "precision_joint",
        "Precision joints",
        "T k <= rated torque, k by the angle; a double joint bears 90 %",
        ("precision_joint.angle_factor", "precision_joint.required_torque"),
        ("din_808_plain_speed", "din_808_needle_speed", "din_808_double_share"),
        "DIN 808 (by vibdoc); JW Winco",
        (
            "Uniform speed and load; not for joints of stainless steel.",
            "Charts of makers differ from the table between its angles, by up to 20 %.",
        ),
        "JW Winco: 27 N m at 30 degrees are 61 N m; 23 N m at 18 degrees, needle, 33 N m",
        (
            "test_precision_joint.py::test_example_of_jw_winco_with_plain_bearings",
            "test_precision_joint.py::test_chart_and_table_of_needle_bearings_disagree",
        ),
    ),
    (
        "efficiency",
        "Efficiency",
        "eta = 1 - (4/pi) mu (r/R) beta",
        ("installation.joint_efficiency",),
        (),
        "own derivation; SAE 150013 measured near 100 %",
        ("Coulomb friction in the pin bearings alone.", "Small angles and losses."),
        "own derivation against friction work integrated over the turn",
        ("test_installation.py::test_loss_by_integration_over_the_turn",),
    ),
)
