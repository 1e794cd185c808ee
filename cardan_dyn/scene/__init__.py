"""Scene: what a user asks for, checked and handed on.

`scene` is the facade: arguments in, results out, no arithmetic. `plan`, `branches`, `describe` and
`assembling` answer what does not need drive positions; `drives` finds which coordinates can drive a
mechanism and how far, `usual_motion` moves it where nobody says how (`presets` of the bundled
ones). `design_variables` hands what varies, and its gradients, to SciPy's solvers. `tasks` says
what moves as given other than coordinates, `task_motion` how the actuated joints follow it, and
`task_sweep` is what comes out.
"""
