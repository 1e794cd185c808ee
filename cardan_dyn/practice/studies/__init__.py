"""Studies: functions of parameters over grids, points and samples, as one `xarray.Dataset`."""
