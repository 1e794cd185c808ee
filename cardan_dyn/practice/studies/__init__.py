"""Studies: functions of parameters over grids, points and samples, as one `xarray.Dataset`.

`parameters` are blocks (an axis, points, samples), one for each dimension; their product is the
table of cases, of which any box is computed from indices. A `chunk` is a box of cases of a fixed
shape (`chunking`), and one chunk of every Zarr array in the `store`. Data run so:

parameters → boxes, in order, without those whose `state` says that they are done → an engine
(`engines`: this process, an executor, Dask) computes the box by a fresh copy of the function, by
case or, where it broadcasts (`sweeps`, vectorized functions), in one call that is halved where it
fails → `outcomes` in the shape of the first case's → the client alone writes: results, failures,
and last, in one object that appears at once, the states → a Dataset, opened lazily.

What a store says of its study decides everything else in it but the results: arrays are made from
it (`store`), and not from what stands beside their chunks. So `damage` reads what counts as done,
where no object may be missing and every checksum has to hold, and a run `mend`s: it describes
arrays and writes coordinates anew, and counts cases of damaged chunks as not computed.

`fingerprint` takes a function apart so that a store can say what differs; `measuring` times a few
cases; `study` is the facade, `plan` and `progress` what it says before and meanwhile, `looking`
what a Dataset says and draws afterwards (functions: a Dataset is xarray's and has a `plot` of its
own), `preloaded` what local workers do first. Nothing holds a list of cases: engines hold three
chunks per worker.
"""
