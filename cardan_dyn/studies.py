"""Studies: functions of parameters over grids, points and samples, as one `xarray.Dataset`.

`cardan_dyn.study` makes one; what it varies, and what it wants of a scene, is made here. Needs the
extra `study`.
"""

from .practice.studies.looking import (
    SobolIndices,
    independent,
    plot_contours,
    plot_map,
    plot_parallel,
    plot_scatter,
    plot_tornado,
    sobol_indices,
)
from .practice.studies.parameters import Line, Parameters, points, samples, sobol_samples
from .practice.studies.plan import StudyPlan
from .practice.studies.study import Study
from .practice.studies.sweeps import Sweeps

__all__ = [
    "Line",
    "Parameters",
    "SobolIndices",
    "Study",
    "StudyPlan",
    "Sweeps",
    "independent",
    "plot_contours",
    "plot_map",
    "plot_parallel",
    "plot_scatter",
    "plot_tornado",
    "points",
    "samples",
    "sobol_indices",
    "sobol_samples",
]
