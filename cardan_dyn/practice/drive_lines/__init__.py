"""Drive lines: shafts and universal joints as data, their closed-chain description and analysis.

`line` says what a line is (fields and units, parts, geometry, supports, files, its description as a
closed chain), `design` how it is best (phasing and layout by the search for forks), `verdict` what
it does and whether it may (analysis, rules, rows). A `LineSolver` (`solving`) keeps the scenes of a
line, whose loops are closed from the `coordinates` that a closed form tells, over half of a turn
(`half_turn`); `extremes` are the greatest forces between positions. `drive_line` is the public
face, `drawing` its figures. `wording` says texts and quantities of its page in a language and a
system of units: English texts are the keys of `german.toml`.
"""
