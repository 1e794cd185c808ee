"""Simulation: the motion of what is not prescribed, with the wrenches along the way.

Methods of `Scene.simulate`, of which the first that suits is taken:

- `quadrature`: one conservative free coordinate that turns through or swings. Its energy integral
  gives time as a function of position to rounding, over any number of turns.
- `response`: one free coordinate of a drive that turns through, under any forces: inertia, weight
  and velocity ratios are tabulated once, and one scalar equation is integrated by DOP853.
- `DOP853`: all else, in all coordinates by Pinocchio's constrained dynamics. Loops are closed again
  after each step. Where the equations turn out to be stiff, `Radau` takes over.
- `Radau`: the same by an implicit method from the start.
"""
