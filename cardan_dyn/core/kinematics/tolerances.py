"""Tolerances that several modules of the kinematics share, each with its reason."""

from ...kit.arrays import NOTHING

RANK_TOLERANCE = NOTHING
"""Singular values below this fraction of the greatest one count as zero in decisions about rank.
It is far above rounding, and far below what positions away from singular configurations have."""
CLOSURE_TOLERANCE = 1e-10
"""Greatest closure error that counts as closed: an angle [rad], or a gap as a fraction of the
characteristic length. It is
far above the rounding that Newton's method reaches, and far below any clearance of a joint."""
SINGULAR_CONDITION = 1e12
"""Condition number of the closure equations from which on a position counts as singular: no more
than four digits of the joint rates would be left."""
SAFE_CORRECTION = 1e-2
"""Greatest error [rad] of a guess that is taken to end in the same assembly mode. Modes come that
near only where the condition number is about its reciprocal, 100, and there guesses are allowed
less, see `allowed_error`."""
MOVES = 1e-6
"""Component of a unit vector of free motion above which a joint counts as moving; and difference
[rad, or lengths of the mechanism] from which on closed configurations are not the same one. Joints
that the loops decide have components there as well, by rounding of about 1e-16."""
REGULAR_CONDITION = float(SINGULAR_CONDITION**0.5)
"""Condition number up to which a position leaves no doubt about the rank, half as many digits as
at singular ones: its smallest singular value is at least a thousand times what `RANK_TOLERANCE`
counts as zero."""
LONGEST_WAY = 1.0
"""Greatest displacement of a coordinate in a step [rad, or lengths of the mechanism], by each of
its first two derivatives where these are followed. Of longer steps some end by accident near other
solutions, often whole turns of a joint away."""
CONFIGURATIONS = 4
"""Configurations in which ranks are measured, of open loops and of closed ones: one alone may be
singular, and what is meant to be generic may happen to be special."""
AROUND = 0.05
"""How far from the first one the others start [rad, or lengths of the mechanism]: far enough to
leave a singular configuration, and near enough to be closed in the same assembly mode. What goes
wrong with even the fourth power of it is 6e-6, far from closed."""
