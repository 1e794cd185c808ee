"""Report: the comparisons as a table, figures, turning scenes and one HTML page."""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from .. import figures
from .._version import __version__
from ..errors import MissingExtraError
from ..mechanism.mechanism import load
from ..validation.comparisons import (
    BETAS_DEG,
    TORQUE,
    Comparison,
    double_shaft_turn,
    universal_joint_turn,
)
from ..viewer.viewing import view

FIGURE_BETA_DEG = 50.0
"""Joint angle of the figures, Grossmann's."""


def as_json(comparisons: Sequence[Comparison]) -> str:
    """Return the comparisons as JSON text."""
    return json.dumps(
        {
            "version": __version__,
            "passed": all(comparison.passed for comparison in comparisons),
            "comparisons": [
                {**asdict(comparison), "passed": comparison.passed} for comparison in comparisons
            ],
        },
        ensure_ascii=False,
        indent=1,
    )


def rows(comparisons: Sequence[Comparison]) -> list[dict[str, Any]]:
    """Group comparisons of one quantity at all joint angles.

    Returns:
        One mapping per quantity: `scene`, `quantity`, `source`, `errors` in the order of
        `BETAS_DEG`, `worst`, `tolerance` and `passed`.
    """
    grouped: dict[tuple[str, str, str], list[Comparison]] = {}
    for comparison in comparisons:
        key = (comparison.scene, comparison.quantity, comparison.source)
        grouped.setdefault(key, []).append(comparison)
    # By scene, each in the order of its own comparisons.
    order = {"universal joint": 0, "double shaft": 1}
    return [
        {
            "scene": scene,
            "quantity": quantity,
            "source": source,
            "errors": [item.error for item in items],
            "worst": max(item.error for item in items),
            "tolerance": items[0].tolerance,
            "passed": all(item.passed for item in items),
        }
        for (scene, quantity, source), items in sorted(
            grouped.items(), key=lambda entry: order[entry[0][0]]
        )
    ]


def write(comparisons: Sequence[Comparison], directory: Path) -> Path:
    """Write the figures as SVG and PNG, the scenes as HTML, and one page that shows all of them.

    Args:
        comparisons: from `comparisons.run`.
        directory: made if it does not exist.

    Returns:
        Path of the page.

    Raises:
        MissingExtraError: matplotlib, meshcat or Jinja is not installed.
        OSError: the directory cannot be written.
    """
    figures.require_matplotlib()
    try:
        from jinja2 import Environment, PackageLoader
    except ImportError as error:
        raise MissingExtraError(
            'the report page needs Jinja: pip install "cardan-dyn[viz]"'
        ) from error
    directory.mkdir(parents=True, exist_ok=True)
    beta = float(np.deg2rad(FIGURE_BETA_DEG))
    joint_turn = universal_joint_turn(load("universal_joint"), beta)
    shaft_turn = double_shaft_turn(load("double_shaft_z"), beta)
    drawn = {
        "grossmann_abb_3": (
            "Torque ratio of the universal joint (Grossmann 1939, Abb. 3)",
            figures.torque_ratio(joint_turn, beta),
        ),
        "grossmann_abb_4": (
            "Bending moments of both shafts (Grossmann 1939, Abb. 4)",
            figures.bending_polar(joint_turn, beta),
        ),
        "thoma_6_7": (
            "Bending of the output shaft in fixed axes (Thoma 1920, eqs 6 and 7)",
            figures.thoma_bending(joint_turn, beta),
        ),
        "speed_ratio": (
            "Speed ratio of the universal joint and of the double shaft",
            figures.speed_ratio(joint_turn, shaft_turn, beta),
        ),
    }
    shown = []
    for name, (caption, figure) in drawn.items():
        vector, _ = figures.save(figure, directory / name)
        shown.append((caption, base64.b64encode(vector.read_bytes()).decode("ascii")))
    scenes = []
    for name, caption, turn in (
        ("scene_universal_joint", "Universal joint", joint_turn),
        ("scene_double_shaft", "Double shaft", shaft_turn),
    ):
        title = f"{caption}, β = {FIGURE_BETA_DEG:g}°, load {TORQUE:g} N·m"
        scene = view(turn, title=title)
        scene.export(directory / f"{name}.html")
        scenes.append((title, scene.embedded()))
    environment = Environment(loader=PackageLoader("cardan_dyn.report"), autoescape=True)
    page = environment.get_template("report.html").render(
        version=__version__,
        betas=BETAS_DEG,
        rows=rows(comparisons),
        passed=all(comparison.passed for comparison in comparisons),
        figures=shown,
        scenes=scenes,
    )
    path = directory / "index.html"
    path.write_text(page, encoding="utf-8")
    return path
