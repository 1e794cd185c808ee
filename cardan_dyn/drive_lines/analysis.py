"""Analysis: the result of a drive line over positions of its input shaft, or of many designs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from .analysis_data import AnalysisData

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, eq=False, repr=False)
class Analysis(AnalysisData):
    """Motion of a line of n joints, and what acts along it.

    `(…)` stands for `(P,)` positions, or `(D, P)` for D designs. Arrays cannot be written to.

    Attributes:
        name: of the line.
        shafts: names of its n + 1 shafts.
        joints: names of its n joints.
        bearings: names of its m bearings; `bearing_in` and `bearing_out` are those at the joints
            of end shafts without bearings of their own.
        splines: names of the s shafts that have a spline.
        centrings: names of the c coupling pieces of centred double joints.
        speed: of the input shaft [rad/s].
        position: `(P,)` of the input shaft [rad], 0 where its fork's pin is horizontal.
        designs: adjustable joints to their positions `(D,)` in each design [rad or m]; empty
            without variants.
        rotation: `(…, n + 1)` rotation of each shaft about its axis [rad]. All count from where
            they would be if the joints were straight, from shaft to shaft by the shortest swing.
        ratio: `(…, n + 1)` speed of each shaft over that of the input shaft.
        acceleration: `(…, n + 1)` angular acceleration of each shaft about its axis [rad/s²].
        static: forces without inertia and weight: from the torque, and the friction of splines.
        inertial: forces of inertia and weight alone; None if there are none.
        slip: `(…, s)` by how much each spline is drawn out against the data [m].
        mean_lead: `(n + 1,)`, or `(D, n + 1)` of designs: mean of each shaft's rotation minus that
            of the input shaft, over a turn of this [rad].
        indeterminate: what statics leaves open; forces there are the ones of least norm.
        loop_residual: worst closure error; see `Sweep`.
        balance_residual: worst imbalance of a body; see `Sweep`. NaN where nothing acts.
        power_residual: worst imbalance of power; see `Sweep`.
    """

    def to_xarray(self) -> xarray.Dataset:
        """Return all results as a dataset with units and names; `line_tables` lists what it holds.

        Raises:
            MissingExtraError: xarray is not installed.
        """
        from .line_tables import dataset  # Imported here: few scripts need tables.

        return dataset(self)
