"""Mechanism: Pinocchio's model of the tree, a weld per loop, and the layout of coordinates.

`joints`, `tree` (Pinocchio's model), `welds` (loops and couplings), `coordinates` (layout),
`configuration` (closed coordinates), `frames` (bodies and motions in plain numbers, for the proof),
`carried` (links and what is fixed in them: where they are, how they move), `rezero`, `teeth` of
gears and what couplings leave `undescribed`, and the `mechanism` that joins them. A loop is an
ordinary joint of the tree plus one weld. What scenes find out about it and others can use stays
with the mechanism (`kept`).
"""
