"""Mechanics: the equations of one sample of a mechanism, as arithmetic on scalars and 3-vectors.

The equations of one sample, written once as functions of scalars and 3-vectors (`vectors`) with the
numbers that textbooks give them: `bodies` are the mechanism as plain numbers, read from Pinocchio's
model; `placements` puts them where they are and says how they move, `closure` what loops and
couplings demand, `reactions` what joints carry and how indeterminate forces are chosen (least norm,
or least elastic energy first), `spins` and `spinning` place and turn rods that spin idly, `teeth`
press on gears, `elimination` solves sparse equations in an order that was chosen at samples seen
before. `sample` is all of it in order: a step of Newton's method, rates, wrenches; `following` is a
step along a line; `constrained` what forces move, in independent coordinates; `exact` loads a
description, and makes its geometry exact where only rounded numbers keep loops from closing. The
same text runs on floats, on arrays, and on variables of a trace.
"""
