"""Reporting: what an engineer files of a mechanism, in one case or in several side by side."""

from __future__ import annotations

import os
from abc import abstractmethod
from collections.abc import Iterable
from functools import cached_property
from pathlib import Path

from ...core.mechanism.mechanism import Mechanism
from ...core.results.plot import draws
from ...core.results.result import Result
from ...core.results.sweep import Sweep
from ...core.results.table import Table
from ...kit.checks import file_path, flag
from ...kit.errors import ArgumentError
from ...motion.simulation.trajectory import Trajectory
from .case import Case, case_of
from .cases import Cases, labels_of
from .extremes import Extreme
from .findings import Findings
from .plots import ReportPlot


class _Filed(Result):
    """What is filed: a page of its cases."""

    @property
    @abstractmethod
    def cases(self) -> Cases:
        """All of them."""

    def save(self, path: str | os.PathLike[str], *, scene: bool = True) -> Path:
        """Write the page, or the extremes alone; return the path.

        Its first sheet of paper tells the case, and what governs it; all else follows. The scene is
        that of the load case in which the first quantity of the headline is greatest.

        Args:
            path: its suffix decides: `.html`, one file that needs no network and prints, or what
                `Result.save` writes.
            scene: whether the moving scene is on the page, a megabyte.

        Raises:
            ArgumentError: no path, another suffix, or the file cannot be written.
            MissingExtraError: Matplotlib, Jinja or meshcat is not installed.
            CardanError: the mechanism cannot be described.
        """
        with_scene = flag("scene", scene)
        target = file_path("path", path)
        if target.suffix == ".pdf":
            raise ArgumentError(
                f"a report is written as HTML: save {target.with_suffix('.html')}, open it in a "
                "browser and print that into a PDF file"
            )
        if target.suffix != ".html":
            return super().save(target)
        from .mechanism_page import write  # Imported here: it draws.

        return write(self.cases, target, with_scene)


class Report(_Filed, Findings):
    """What an engineer files of a mechanism in one case; `print` shows it, `save` writes the page.

    The greatest and least wrenches of every joint with the drive positions where they occur, what
    statics determines and what was chosen, drive efforts, orders, residuals; on the page
    (`report.save("four_bar.html")`) the description, mobility and drives, figures and the moving
    scene as well. As a table (`to_dataframe`) it has a row per extreme.

    Args:
        case: the sweep, over one dimension; a trajectory; or a mechanism, which is moved as is
            usual: driven as `describe(mechanism).drives` says over the whole range, bundled ones as
            their presets say. One that cannot move is reported at rest.
        title: of the page; the mechanism's name if empty.
        project, author, revision: for the head of the page.
        date: likewise; that of SOURCE_DATE_EPOCH, or of today, if empty.

    Attributes:
        mechanism: as it was loaded.
        sweep: of the case; None if the mechanism cannot be moved.
        said: how the case was chosen.
        exceeded: where it goes beyond limits of the description, in words.

    Raises:
        ArgumentError: a sweep over several dimensions, or something else.
        CardanError: as `Scene.sweep`, between the samples.
    """

    def __init__(
        self,
        case: Sweep | Trajectory | Mechanism | Case,
        *,
        title: str = "",
        project: str = "",
        author: str = "",
        date: str = "",
        revision: str = "",
    ) -> None:
        if isinstance(case, Trajectory):
            case = Case(case.mechanism, case.sweep, trajectory=case)
        elif isinstance(case, Mechanism):
            case = case_of(case)
        elif isinstance(case, Sweep):
            if len(case.shape) != 1:
                raise ArgumentError(
                    f"a report is on a sweep over one dimension, not of shape {case.shape}; sweep "
                    "one design, or one load case, at a time"
                )
            case = Case(case.mechanism, case)
        elif not isinstance(case, Case):
            raise ArgumentError(
                f"a report is on a sweep, or on a mechanism from load(), not on a "
                f"{type(case).__name__}; several load cases go into cd.Reports([sweep, …])"
            )
        super().__init__(case, title, project, author, date, revision)

    @cached_property
    def cases(self) -> Cases:
        """The case alone."""
        return Cases((self,), ())

    @property
    def headline(self) -> list[Extreme]:
        """What a joint is sized by: of each quantity that statics determines the greatest.

        A torsion, or an axial force, that is the effort of a drive is told as that.
        """
        return [item for _, item in self.cases.governing]

    def table(self) -> Table:
        """Return the extremes as a table, a row each; positions are those of the first of several.

        Columns: `owner`, `quantity`, `unit`, `greatest`, `least`, `determined`, `error` (by how
        much the quantity may exceed them; NaN where that is not known), and for every drive
        `greatest_at_NAME` and `least_at_NAME` [rad or m]: NaN where it is constant.
        """
        return self.cases.table()


class Reports(_Filed, Cases):
    """Reports on a mechanism in several load cases, side by side: `print` and `save` as `Report`.

    They begin with the greatest of each quantity that statics determines, with its joint, its place
    and the load case, go on with every joint in all load cases, and end with each case by itself.
    As a table (`to_dataframe`) they have the rows of all reports, with the column `case`.

    Args:
        cases: sweeps of one mechanism, each over one dimension, trajectories, or reports on it.
        labels: how the load cases are called; by what tells them apart if there are none.
        title, project, author, date, revision: as of `Report`, for sweeps.

    Attributes:
        reports: a `Report` on each load case.
        labels: their names.

    Raises:
        ArgumentError: no case at all, cases of several mechanisms, or labels that are not as many
            or the same.
        CardanError: as `Report`.
    """

    def __init__(
        self,
        cases: Iterable[Sweep | Trajectory | Report],
        labels: Iterable[str] = (),
        **head: str,
    ) -> None:
        if isinstance(cases, Sweep | Trajectory | Report | Mechanism):
            raise ArgumentError("several load cases are a list of sweeps; one is that of a Report")
        reports = [case if isinstance(case, Report) else Report(case, **head) for case in cases]
        if not reports:
            raise ArgumentError("there is no load case to report on")
        if len({report.sha256 for report in reports}) > 1:
            raise ArgumentError("load cases are those of one mechanism, and there are several")
        super().__init__(reports, labels_of(reports, tuple(labels)))

    @property
    def cases(self) -> Cases:
        """All of them."""
        return self

    @property
    def headline(self) -> tuple[tuple[int, Extreme], ...]:
        """Of each quantity that statics determines the greatest, behind the index of its case."""
        return tuple(self.governing)


for _kind in (Report, Reports):
    draws(_kind)(ReportPlot)
