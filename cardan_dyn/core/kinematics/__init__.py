"""Kinematics: loops closed for many samples at once, followed from where the scene starts.

Four rooms, each importing from those before: `loops` (what depends on what: graph, smallest groups,
idle rods, what outputs need), `closing` (Newton's method for one group
and for all; its `equations` are programs of `mechanics`, traced once for all groups of the same
loops, and only factors, ranks and conditions are dense linear algebra there; `far` searches where
Newton's method leads nowhere), `diagnosis` (what errors say, loaded when one is raised: why drives
do not decide the motion, which joints lose their freedom, what can be reached) and `following`
(from a closed configuration to others: `lines` is the one follower, a `branch` two lines that lead
on, whose nodes follow from the mechanism alone; `joint_motion` follows a line to each sample of
several drives, on tapes, as `taped_lines`; `scouts` are closed configurations all over the motion,
at which `orders` of elimination are chosen and redundant rows found; `guesses` keeps what is known
all over the motion). On top, the `loop_system` groups loops for any drives, a `division` says which
rows of a scene's groups are independent, `start` follows the mechanism from the description's zero
to where the scene starts and searches where that way ends, `assembly_modes` finds the other modes,
and `assembly` is what a scene asks.
"""
