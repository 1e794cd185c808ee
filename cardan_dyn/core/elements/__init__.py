"""Elements: springs, dampers, bushings, friction and actuators, and the forces that they exert.

A kind of force element is a class in a file of its own: its data, its law, what it is like
(conserves, damps, jumps, follows time), what results show of it. `element` says what that is,
`element_forces` asks all elements of a scene. `link_loads` are wrenches on links; `contact_laws`
press pins, whose places `pin_motion` tells; `element_efforts` are those of a simulation, which asks
all elements at `one_state`;
`stepping` takes the steps of an integrator and locates where something ends them.
"""
