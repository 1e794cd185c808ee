"""Report: the bundled mechanisms against the closed forms of the literature, and pages.

`report` has three subjects and one way to write a page (`page`, whose templates extend
`base.html`): `comparisons` of the bundled mechanisms with closed forms (`verdicts`, `report`); any
mechanism in a `case` (`findings` are what is told of it, `cases` of one or several side by
side, `reporting` the public `Report` and `Reports` of both, `plots` and `courses` their figure,
`extremes` over the whole range by `panels` that are halved until a measured error is small, or
uphill over the ranges of several drives, `described` and `grids` tables, `mechanism_page`); a drive
line (`drive_line_page` with `line_tables` and `line_figures`).
"""
