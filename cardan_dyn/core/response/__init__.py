"""Response: wrenches as functions of the drive's position.

A `response` holds Fourier or Chebyshev `series` of everything that a wrench is proportional to,
sampled until they hold (`build`, `sampling`), of one design or of many that are built together, in
a shape of their own; `operating_points` evaluate it, design by design.
"""
