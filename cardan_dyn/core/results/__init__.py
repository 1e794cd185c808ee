"""Results: motion and wrenches as their users read them.

A `sweep` keeps what was asked (the `Acting` of `problem`), and reads what was found from a `source`
when it is first asked for; `left_open` says what of it is not unique. `wrench` is what a joint
carries, in `axes` that are chosen and by two bearings, `rods` the force between two balls, a
`point_motion` where a point of a link is (`carried`, as `Configuration.point`). `result` is what
every result can do (`to_xarray`, `to_dataframe`, `to_csv`, `plot`, `save`), written once over a
`table`; `prescribed` what a scene and its results have in common. A `derivative` is how all of it
changes by `named_parameters`. `plot` draws any table; packages below let it draw their results in
their own way, by a `Plot` of theirs (`draws`).
"""
