"""What notebooks compute, as tests see it."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

NOTEBOOKS = Path(__file__).parents[2] / "notebooks"


@cache
def tell(name: str) -> SimpleNamespace:
    """Return what all code of a notebook has named when it is done.

    The tests check these very values, so that nothing that a reader sees is computed twice.
    """
    nbformat = pytest.importorskip("nbformat", reason="reading notebooks needs nbformat")
    matplotlib = pytest.importorskip("matplotlib", reason="the notebooks draw figures")
    matplotlib.use("Agg")
    from matplotlib import pyplot

    named: dict[str, Any] = {}
    notebook = nbformat.read(NOTEBOOKS / f"{name}.ipynb", as_version=4)
    for number, cell in enumerate(notebook.cells):
        if cell.cell_type == "code":
            source = cell.source.replace("%matplotlib inline", "")
            exec(compile(source, f"{name}, cell {number}", "exec"), named)
            pyplot.close("all")
    return SimpleNamespace(**named)
