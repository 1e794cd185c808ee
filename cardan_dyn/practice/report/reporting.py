"""Reporting: what an engineer files of a mechanism in one case."""

from __future__ import annotations

import os
from pathlib import Path

from ...core.mechanism.mechanism import Mechanism
from ...core.results.plot import draws
from ...core.results.sweep import Sweep
from ...kit.checks import file_path, flag
from ...kit.errors import ArgumentError
from .case import Case, case_of
from .findings import Findings
from .plots import ReportPlot


class Report(Findings):
    """What an engineer files of a mechanism in one case; `print` shows it, `save` writes the page.

    The greatest and least wrenches of every joint with the drive positions where they occur, what
    statics determines and what was chosen, drive efforts, orders, residuals; on the page
    (`report.save("four_bar.html")`) the description, mobility and drives, figures and the moving
    scene as well. As a table (`to_dataframe`) it has a row per extreme.

    Args:
        case: the sweep, over one dimension; or a mechanism, which is moved as is usual: driven as
            `describe(mechanism).drives` says over the whole range, bundled ones as their presets
            say. One that cannot move is reported at rest.
        title: of the page; the mechanism's name if empty.
        project, author, revision: for the head of the page.
        date: likewise; that of SOURCE_DATE_EPOCH, or of today, if empty.

    Attributes:
        mechanism: as it was loaded.
        sweep: of the case; None if the mechanism cannot be moved.
        said: how the case was chosen.

    Raises:
        ArgumentError: a sweep over several dimensions, or something else.
        CardanError: as `Scene.sweep`, between the samples.
    """

    def __init__(
        self,
        case: Sweep | Mechanism,
        *,
        title: str = "",
        project: str = "",
        author: str = "",
        date: str = "",
        revision: str = "",
    ) -> None:
        if isinstance(case, Mechanism):
            mechanism, found = case, case_of(case)
        elif isinstance(case, Sweep):
            if len(case.shape) != 1:
                raise ArgumentError(
                    f"a report is on a sweep over one dimension, not of shape {case.shape}; sweep "
                    "one design, or one load case, at a time"
                )
            mechanism, found = case.mechanism, Case(case, ())
        else:
            raise ArgumentError(
                f"a report is on a sweep, or on a mechanism from load(), not on a "
                f"{type(case).__name__}; several load cases go into cd.Reports([sweep, …])"
            )
        self._take(mechanism, found, title, project, author, date, revision)

    @classmethod
    def of_case(
        cls,
        mechanism: Mechanism,
        case: Case,
        *,
        title: str = "",
        project: str = "",
        author: str = "",
        date: str = "",
        revision: str = "",
    ) -> Report:
        """Return the report of a case that was chosen before: for the command line."""
        report = cls.__new__(cls)
        report._take(mechanism, case, title, project, author, date, revision)
        return report

    def save(self, path: str | os.PathLike[str], *, scene: bool = True) -> Path:
        """Write the page, or the extremes alone; return the path.

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
        if target.suffix != ".html":
            return super().save(target)
        from .mechanism_page import write  # Imported here: it draws.

        return write([self], [], target, with_scene)


draws(Report)(ReportPlot)
