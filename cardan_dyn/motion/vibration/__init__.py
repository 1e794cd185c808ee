"""Vibration: periodic motions about a drive at constant speed, and what becomes of small ones.

`model` samples the efforts of a rotating scene for a reduced model, polynomial in the free
coordinates and trigonometric in the drive's. `motions` finds periodic motions by harmonic balance,
follows them over speed by continuation, corrects them against the scene and says which are stable;
`models` have ranges as wide in each coordinate as motions are, small ones first. `regions` tells
stability between speeds at which it is known by polynomials, as far as these are sure. `results`
are what users get.
"""
