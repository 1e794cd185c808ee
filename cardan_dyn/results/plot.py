"""Plot: results draw themselves, by the figures that know nothing of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ..errors import ArgumentError, choices
from .table import Table

if TYPE_CHECKING:
    from ..figures.style import Figure


class Plot:
    """Draws a result: `result.plot("bearing_out.bending")`.

    Args:
        result: anything with a `table`.
    """

    def __init__(self, result: Any) -> None:
        self._result = result

    def __call__(self, *columns: str, over: str = "", title: str = "") -> Figure:
        """Draw columns of the table over one of them; those of one unit share their axes.

        Args:
            columns: names of columns, as in `to_dataframe`.
            over: name of the column that is the abscissa; what was given first, such as the
                position of the first drive, a speed or a time, if empty.
            title: of the figure.

        Raises:
            MissingExtraError: matplotlib is not installed.
            ArgumentError: there is no such column, none was named, or the result has several
                dimensions.
        """
        from ..figures.columns import over_column  # Imported here: it needs matplotlib.

        table: Table = self._result.table()
        if len(table.samples) > 1:
            raise ArgumentError(
                f"figures draw results over one dimension, not over {choices(table.samples)}; "
                "take one design at a time"
            )
        known = table.columns()
        over = over or table.abscissa
        for name in (*columns, over):
            if name not in known:
                raise ArgumentError(
                    f"no column {name!r}; columns: {choices(known, str(name))}"
                    if name
                    else "name the column that is the abscissa: over=…"
                )
        if not columns:
            raise ArgumentError(f"name what is drawn; columns: {choices(known)}")
        return over_column(over, known[over], {name: known[name] for name in columns}, title)


class MotionPlot(Plot):
    """Draws a sweep or a trajectory: `sweep.plot("bearing_out")`.

    Its methods are functions of `figures`, whose first argument is the result.
    """

    def __call__(self, *columns: str, over: str = "", title: str = "") -> Figure:
        """Draw torsion and bending of joints over the drive's position, or columns of the table.

        Args:
            columns: names of joints, or of columns of the table (see `Plot`), not of both.
            over: see `Plot`; of joints, the drive whose position is the abscissa.
            title: of the figure.

        Raises:
            MissingExtraError: matplotlib is not installed.
            ArgumentError: there is no such joint or column, or the result has several dimensions.
        """
        if columns and all(name in self._result.outputs for name in columns):
            from ..figures.over_angle import over_angle

            return over_angle(self._result, columns, drive=over or None, title=title)
        return super().__call__(*columns, over=over, title=title)

    def over_time(self, joints: str | Sequence[str], *arguments: Any, **options: Any) -> Figure:
        """Draw torsion and bending of joints over time, see `figures.over_time`."""
        from ..figures.over_time import over_time

        return over_time(self._result, joints, *arguments, **options)

    def polar(self, joints: str | Sequence[str], *, of: str = "moment", **options: Any) -> Figure:
        """Draw the curve of a joint's moment or force, see `figures.moment_polar`.

        Args:
            joints: one joint or several; each is a curve.
            of: `moment` or `force`.
            options: of `figures.moment_polar`.

        Raises:
            ArgumentError: `of` is neither.
        """
        from ..figures.polar import force_polar, moment_polar

        kinds = {"moment": moment_polar, "force": force_polar}
        if of not in kinds:
            raise ArgumentError(f"of is {of!r}; it is {choices(kinds)}")
        return kinds[of](self._result, joints, **options)

    def orders(self, *columns: str, **options: Any) -> Figure:
        """Draw the amplitudes of columns over the orders of revolution.

        Args:
            columns: names of columns of one unit, see `Plot`.
            options: of `figures.order_spectrum`, which draws them over the first drive.

        Raises:
            ArgumentError: there is no such column, they have several units, or the drive's
                positions are not whole turns in even steps.
        """
        from ..figures.orders import order_spectrum
        from ..figures.style import drive_of

        position = self._result.motion.position(drive_of(self._result, None))
        known = self._result.table().columns()
        for name in columns:
            if name not in known:
                raise ArgumentError(f"no column {name!r}; columns: {choices(known, name)}")
        units = {known[name][1] for name in columns}
        if len(units) != 1:
            raise ArgumentError(f"name columns of one unit, not of: {choices(sorted(units))}")
        values = {name: known[name][0] for name in columns}
        return order_spectrum(position, values, unit=units.pop(), **options)
