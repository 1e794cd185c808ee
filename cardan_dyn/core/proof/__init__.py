"""Proof: a result checked from the description alone, by nothing that took part in solving it.

`proof` knows nothing of how a result was found. What has to hold is written once, as arithmetic of
one sample on scalars and `vectors`: `placing` puts the frames of the description where they are,
`screws` move them, `constraints` and `effort_balance` look at rates, `momentum`, `tooth_forces` and
`element_loads` at bodies, all of which `free_bodies` cuts free. `samples` turn a claim into
scalars: floats of one sample, arrays of several side by side. `traced` makes a program of the text
for each kind of claim, and hands it the claim's arrays as they are: it tells itself whether what it
leaves out is zero, and is made anew with what acts now if it is not. `self_stress` and
`silent_couplings` say what is unique, `residuals` how far off a result is, `derived` how far its
derivatives are.
"""
