"""Problem: what is to be solved, checked against the mechanism, as frozen data.

`arguments` checks what a user hands to a scene; the frozen `problem` is what every later step
reads, with what is `acting` unless a sweep says otherwise. `samples` broadcasts what a sweep asks
for.
"""
