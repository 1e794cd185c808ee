"""Sweep: the result of a scene over drive positions, with the residuals that prove it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .sweep_data import SweepData

if TYPE_CHECKING:
    import pandas
    import xarray


class Sweep(SweepData):
    """Joint wrenches, drive efforts and motion of a scene over N samples.

    `sweep["bearing_out"]` is the `JointWrench` of a joint in its own frame; `wrench(name, frame)`
    gives it in other axes. A sweep of a `Response` may have operating points in several
    dimensions: then `(N,)` stands for their shape. Nothing in it can be changed.

    Attributes:
        unique: `(k, 6)` see `JointWrench.unique`, a row per output.
        coupling_moment: coupling to the moment or force `(N,)` [N·m or N] that it exerts on its
            successor's joint.
        coupling_unique: coupling to whether its moment follows from the laws of motion alone.
        condition: `(N,)` condition number of the wrenches: that of the closure equations, times
            the greatest velocity ratio if that exceeds 1, times by how much inertial terms
            exceed what is left of them. Errors are some eps times it. One value, the greatest of
            its samples, if it comes from a `Response`.
        loop_residual: worst closure error: angle [rad], or gap as a fraction of
            `Mechanism.characteristic_length`; couplings, drives and held joints count as well.
        balance_residual: worst Newton-Euler imbalance over all bodies, relative to the greatest
            wrench of all samples (to inertial terms where wrenches are mere rounding of them).
            It proves what is unique. Of what the laws of motion leave open it proves that the
            choice is in balance, not that it is the least. NaN if only the drive efforts were
            asked for, and where nothing acts, so that there is nothing to compare.
        rate_residual: worst violation of the loops, couplings and drives by speeds and
            accelerations, relative to the greatest ones.
        power_residual: worst imbalance of drive, load, weight and inertia power, relative to the
            power that flows and to the greatest wrench times the greatest joint speed. NaN where
            the outputs leave part of that flow out, and where nothing acts.
        unproven: links that `balance_residual` leaves out, since not all that acts on them is
            among the outputs.
    """

    def _repr_html_(self) -> str:
        from .sweep_markup import sweep_markup  # Imported here: only notebooks show it.

        return sweep_markup(self)

    def to_xarray(self, *, motion: bool = True) -> xarray.Dataset:
        """Return all results as a dataset with units; `results.tables` lists what it holds.

        Args:
            motion: whether to include the motion of the joints. A `Response` solves it directly,
                which may take longer than all the rest.

        Raises:
            MissingExtraError: xarray is not installed.
        """
        from .tables import dataset  # Imported here: few scripts need tables.

        return dataset(self, motion=motion)

    def to_dataframe(self, *, motion: bool = True) -> pandas.DataFrame:
        """Return all results, a row per sample and a column per value; see `results.tables`.

        Columns are called `drive_effort`, `bearing_out.bending`, `bearing_out.force_x` and so on.
        `frame.attrs["units"]` maps them to their units.

        Args:
            motion: see `to_xarray`.

        Raises:
            MissingExtraError: pandas is not installed.
        """
        from .tables import dataframe  # Imported here: few scripts need tables.

        return dataframe(self, motion=motion)
