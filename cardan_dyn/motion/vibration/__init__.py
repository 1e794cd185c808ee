"""Vibration: periodic motions about a drive at constant speed, and what becomes of small ones.

`model` has the equation of the free coordinates: their efforts along a motion, and the exact
derivatives of these. `motions` finds periodic motions by harmonic balance, from rest and from
others, follows them over speed by continuation, holds them against sweeps and says which are
stable. `regions` tells stability between speeds at which it is known by polynomials, as far as
these are sure. `results` are what users get.
"""
