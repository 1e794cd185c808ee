"""Dynamics: wrenches and efforts of closed positions, and what statics leaves open.

`problem_solver` solves blocks of samples, and decides what fits into memory. `taped` solves them: a
`tape` is the text of `mechanics` traced for the scene, run for all samples of a block side by side.
It considers the numbers that were not zero when it was traced, and says so by a result where
another one is not. Each sample judges itself (growth of the elimination, last Newton step, closure
errors); what fails goes to a second tape with another order of elimination. Where none holds,
`kinematics` closes the loops, or says why it cannot; tapes are asked again there, and at last each
sample has a tape of the order that is chosen at itself. What elements exert follows from a tape of
the motion alone. All are proven alike.

By `parameters`, closed samples are `differentiated` where they are traced, forwards for all results
or backwards for a weighted sum; what is solved there changes as its equations say (`implicit`); a
`pushing` tells how what elements exert changes.

What is simulated has programs as well, for one state after the other: a `chain_tape` gives rates of
a chain's state, and what closes its loops; an `open_tree` energies, and efforts without loops.
"""
