"""Kit: what every storey uses, and nothing of mechanics.

`errors` (one base class, numbers and valid names inside), `arrays` (operations that several
packages need, and what counts as rounding), `checks` (single arguments, paths to be written),
`units` (texts with units, of files and the command line), `frozen`, `time_left` and `markup` (HTML
for notebooks). Whatever may take long says so by a `Task` of `time_left`, which shows it where
somebody looks; no caller passes anything on, and `cd.progress` switches it. `threads` says how many
cores there are and does pieces of work on them beside each other: the blocks of a sweep, from the
guess to what is kept, lines from a start, and branches that are read at many positions. For the
same bits on any number of cores, all read what is known when they begin; a block that lacks a tape
says `in_turn`, and is begun again alone. `roots` are where many functions pass through zero, side
by side and to rounding; or one, by SciPy. `periodic` is what values at equal steps of a
period tell of a function: amplitudes of its orders, its values elsewhere, derivatives; a `Fourier`
is summed at any place. `extremes` are where functions are greatest: periodic ones, those known by
values and rates, and one with a peak between two places; `differences` are derivatives of functions
of which only values are known. There are three ways in which nothing changes: a `Record` is a
frozen dataclass whose arrays are read-only, a `Value` one that is compared by its contents;
`Frozen` is the base of objects that compute; `FrozenDict` a mapping.
"""
