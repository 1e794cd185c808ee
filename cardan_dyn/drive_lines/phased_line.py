"""Phased line: what can be chosen about a line, its forks and its layout."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .line_data import LineData

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from typing_extensions import Self

    from .layout import Layout
    from .phasing import Phasing


@dataclass(frozen=True, kw_only=True, repr=False)
class PhasedLine(LineData):
    """A line whose forks and layout can be put right; `DriveLine` is its public face."""

    def phasing(
        self,
        objective: str = "residual_angle",
        *,
        shafts: Sequence[str | int] | None = None,
        bearings: Sequence[str] | None = None,
        torque: float | None = None,
        teeth: int | Mapping[str | int, int] | None = None,
        fixed: Sequence[str | int] = (),
        count: int = 8,
    ) -> Phasing[Self]:
        """Return where the forks have to stand so that an objective is least.

        The least residual angle of free forks is known in closed form, and that of forks on
        splines is found by branch and bound; both are the global optimum, which `proven` says.
        Bearing forces are searched for, unless all forks stand on splines and are few enough to be
        all tried; on 60 random lines no other search found forces less by more than 0.02 %. A fork
        is the same after half a turn, so offsets are told between ±90°.

        Args:
            objective: `residual_angle`, the greatest of chosen shafts, or `bearing_force`, the
                greatest of chosen bearings over a revolution, quasi-static and without weight.
            shafts: names or numbers of the shafts whose residual angle counts; the output shaft
                unless given.
            bearings: names of the bearings whose forces count; all unless given.
            torque: of the input shaft, for bearing forces [N·m]; that of the line unless given.
            teeth: numbers of teeth of the splines on which forks can be turned, by shaft, or one
                for all intermediate shafts: offsets are the present one and steps of 360°/teeth
                from it. Forks of other shafts are free.
            fixed: names or numbers of the intermediate shafts whose forks stay as they are.
            count: number of alternatives that are told, if there are as many.

        Raises:
            ArgumentError: an argument does not go with the others or is out of its range.
            ModelError: there is no such shaft or bearing; for bearing forces, a line that is not
                held, or whose forces statics leaves open.
        """
        from .phasing import phasing

        return phasing(
            self,
            objective,
            shafts=shafts,
            bearings=bearings,
            torque=torque,
            teeth=teeth,
            fixed=fixed,
            count=count,
        )

    def layout(
        self,
        free: Mapping[str, Sequence[float]],
        objective: str = "residual_angle",
        **options: Any,
    ) -> Layout[Self]:
        """Return values of lengths, slopes and places that make an objective least, with the forks.

        Forks are put as `phasing` does, for every layout that is looked at. Layouts are searched
        for by differential evolution and a local search after it.

        Args:
            free: variables with their bounds [m or rad]: `SHAFT.length`, `SHAFT.slope_side`,
                `SHAFT.slope_plan`, `SHAFT.start_x` … `SHAFT.end_z` of shafts given by points, and
                `BEARING.distance`. Layouts that cannot be put together are left out.
            objective: as of `phasing`.
            options: others of `phasing`.

        Raises:
            ArgumentError: bounds that are none, and as `phasing` does.
            ModelError: there is no such variable, and as `phasing` does.
        """
        from .layout import layout  # Imported here: as above.

        return layout(self, free, objective, **options)
