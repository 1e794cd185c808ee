"""Transmission: what motors and the joints that they move through loops have to do with each other.

A `way` takes coordinates of one side to those of the other, with all first derivatives: solved by
sweeps, one of the scene that the actuated drive and one of that which the joints drive, or within
ranges by `newton`, which takes a microsecond and is `printed` as C. `maps` make of both ways what
is asked of them, whoever computes them: rates and efforts by virtual work, limits, singular values.
`transmission` is the one that a scene gives, with its inertia, `fitted` that within ranges. A
`chart` follows one side to wherever it leads, and says where it turns back: `borders` on a line,
and the `workspace` of two coordinates, of tasks as well. `reduced` is the tree that is left of a
mechanism without motors and loops.
"""
