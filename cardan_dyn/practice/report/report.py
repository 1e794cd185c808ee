"""Report: the comparisons as a table, figures, turning scenes and one HTML page."""

from __future__ import annotations

import base64
import json
from pathlib import Path

import numpy as np

from ... import figures
from ..._version import __version__
from ...core.mechanics.exact import load
from ...core.results.sweep import Sweep
from ...figures.style import require_matplotlib
from ...kit.checks import writing
from ..viewer.viewing import view
from . import closed_forms
from .comparisons import BETAS_DEG, TORQUE, double_shaft_turn, universal_joint_turn
from .page import template
from .verdicts import Comparisons


def as_json(comparisons: Comparisons) -> str:
    """Return the comparisons as JSON text."""
    return json.dumps(
        {
            "version": __version__,
            "passed": comparisons.passed,
            "comparisons": [
                {
                    "scene": item.scene,
                    "quantity": item.quantity,
                    "source": item.source,
                    "beta_deg": beta_deg,
                    "error": error,
                    "tolerance": item.tolerance,
                    "passed": error <= item.tolerance,
                }
                for item in comparisons
                for beta_deg, error in item.errors.items()
            ],
        },
        ensure_ascii=False,
        indent=1,
    )


def write(comparisons: Comparisons, directory: Path) -> Path:
    """Write the figures as SVG and PNG, the scenes as HTML, and one page that shows all of them.

    Args:
        comparisons: from `comparisons.run`.
        directory: made if it does not exist.

    Returns:
        Path of the page.

    Raises:
        MissingExtraError: matplotlib, meshcat or Jinja is not installed.
        ArgumentError: the directory cannot be written.
    """
    require_matplotlib()
    page_template = template("report.html")
    with writing(directory):
        directory.mkdir(parents=True, exist_ok=True)
    beta_deg = 50.0  # Grossmann's.
    beta = float(np.deg2rad(beta_deg))
    joint_turn = universal_joint_turn(load("universal_joint"), beta)
    shaft_turn = double_shaft_turn(load("double_shaft_z"), beta)
    page = page_template.render(
        version=__version__,
        betas=BETAS_DEG,
        rows=comparisons,
        passed=comparisons.passed,
        figures=_write_figures(joint_turn, shaft_turn, directory),
        scenes=_write_scenes(joint_turn, shaft_turn, beta_deg, directory),
    )
    path = directory / "index.html"
    with writing(path) as part:
        part.write_text(page, encoding="utf-8")
    return path


def _write_figures(joint_turn: Sweep, shaft_turn: Sweep, directory: Path) -> list[tuple[str, str]]:
    """Write the figures; return their captions and their SVG texts in base64."""
    drawn = {
        "grossmann_abb_3": (
            "Torque ratio of the universal joint (Grossmann 1939, Abb. 3)",
            closed_forms.torque_ratio(joint_turn),
        ),
        "grossmann_abb_4": (
            "Bending moments of both shafts (Grossmann 1939, Abb. 4)",
            closed_forms.bending_polar(joint_turn),
        ),
        "thoma_6_7": (
            "Bending of the output shaft in fixed axes (Thoma 1920, eqs 6 and 7)",
            closed_forms.thoma_bending(joint_turn),
        ),
        "speed_ratio": (
            "Speed ratio of the universal joint and of the double shaft",
            closed_forms.speed_ratio(joint_turn, shaft_turn),
        ),
    }
    shown = []
    for name, (caption, figure) in drawn.items():
        vector, _ = figures.save(figure, directory / name)
        shown.append((caption, base64.b64encode(vector.read_bytes()).decode("ascii")))
    return shown


def _write_scenes(
    joint_turn: Sweep, shaft_turn: Sweep, beta_deg: float, directory: Path
) -> list[tuple[str, str]]:
    """Write the turning scenes; return their titles and HTML elements that contain them."""
    shown = []
    for name, caption, turn in (
        ("scene_universal_joint", "Universal joint", joint_turn),
        ("scene_double_shaft", "Double shaft", shaft_turn),
    ):
        title = f"{caption}, β = {beta_deg:g}°, load {TORQUE:g} N·m"
        scene = view(turn, title=title)
        scene.export(directory / f"{name}.html")
        shown.append((title, scene.embedded(title=title)))
    return shown
