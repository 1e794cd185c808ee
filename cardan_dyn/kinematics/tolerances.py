"""Tolerances that several rooms of the kinematics share, each with its reason."""

RANK_TOLERANCE = 1e-9
"""Singular values below this fraction of the greatest count as zero in rank decisions."""
CLOSURE_TOLERANCE = 1e-10
"""Greatest closure error that counts as closed, as a fraction of the characteristic length."""
SINGULAR_CONDITION = 1e12
"""Condition number from which on a position counts as singular."""
SAFE_CORRECTION = 1e-2
"""Greatest error of a guess that cannot end in another assembly mode."""
