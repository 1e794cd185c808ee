"""Simulation: the motion of what is not prescribed, with the wrenches along the way.

Methods of `Scene.simulate`, of which the first that suits is taken:

- `quadrature`: one conservative free coordinate that turns through or swings. Its energy integral
  gives time as a function of position to rounding, over any number of turns.
- `response`: one free coordinate of a drive that turns through, under any forces: inertia, weight
  and velocity ratios are tabulated once, and one scalar equation is integrated by DOP853.
- `DOP853`: all else, in all coordinates by Pinocchio's constrained dynamics. Loops are closed again
  after each step. Where the equations turn out to be stiff, `Radau` takes over.
- `Radau`: the same by an implicit method from the start.

`simulate` chooses a method for a checked `setup`: `energy_integral` (time as an integral),
`scalar_equation`, or `system` in all coordinates over the `constrained_model`; `methods` runs it,
one loop follows `integration` with its `events` and contacts (`contact_following`). A `trajectory`
computes wrenches where they are asked for.

A model has chains, and a chain has tapes (`dynamics.chain_tape`): rates of a state, and what closes
its loops, as two programs of `mechanics.constrained`. A tape judges itself (ratios of rates,
strength of closure equations, inertia that is left): where other coordinates should be independent,
another tape is chosen by that state alone, so that results do not depend on what was asked before;
where closures are weak, or nothing has mass, `closed_directions` solve by singular values. Programs
are kept with the mechanism. Where nothing acts, compiled steps run them by themselves (`Traced`).
"""
