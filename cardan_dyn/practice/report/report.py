"""Report: the comparisons as a table, figures, turning scenes and one HTML page."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

import numpy as np

from ... import figures
from ..._version import __version__
from ...core.mechanics.exact import load
from ...core.results.sweep import Sweep
from ...figures.style import (
    Figure,
    axes_grid,
    legend,
    line_style,
    point_style,
    require_matplotlib,
    thinned,
)
from ...kit.checks import writing
from ..viewer.viewing import view
from . import page
from .comparisons import BETAS_DEG, POSITIONS, TORQUE, Pair, of_joint, of_shaft, turn_of
from .verdicts import Comparisons


def plain(comparisons: Comparisons) -> dict[str, Any]:
    """Return the comparisons as plain data."""
    return {
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
    }


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
    page.template("report.html")  # A missing extra is reported before anything is computed.
    with writing(directory):
        directory.mkdir(parents=True, exist_ok=True)
    beta_deg = 50.0  # Grossmann's.
    beta = float(np.deg2rad(beta_deg))
    joint_turn, shaft_turn = (
        turn_of(load(name), beta) for name in ("universal_joint", "double_shaft_z")
    )
    shown = []
    for name, (caption, figure) in drawn(joint_turn, shaft_turn).items():
        vector, _ = figures.save(figure, directory / name)
        shown.append((caption, base64.b64encode(vector.read_bytes()).decode("ascii")))
    return page.write(
        directory / "index.html",
        "report.html",
        title="cardan_dyn: comparison with Thoma and Grossmann",
        betas=BETAS_DEG,
        rows=comparisons,
        passed=comparisons.passed,
        figures=shown,
        scenes=_write_scenes(joint_turn, shaft_turn, beta_deg, directory),
    )


def drawn(joint_turn: Sweep, shaft_turn: Sweep) -> dict[str, tuple[str, Figure]]:
    """Return names, captions and figures of closed forms as lines, and turns as points.

    Args:
        joint_turn: of the universal joint, see `turn_of`.
        shaft_turn: of the double shaft at the same angle.
    """
    joint, shaft = of_joint(joint_turn), of_shaft(shaft_turn)
    told: dict[str, tuple[str, str, dict[str, Pair]]] = {
        "grossmann_abb_3": (
            "Torque ratio of the universal joint (Grossmann 1939, Abb. 3)",
            "D₂/D₁ [–]",
            {"D₂/D₁": joint["torque ratio D₂/D₁"]},
        ),
        "grossmann_abb_4": (
            "Bending moments of both shafts (Grossmann 1939, Abb. 4)",
            "",
            {
                "B₁/D₁ over φ₁": joint["bending, input shaft B₁/D₁"],
                "B₂/D₁ over φ₂": joint["bending, output shaft B₂/D₁"],
            },
        ),
        "thoma_6_7": (
            "Bending of the output shaft in fixed axes (Thoma 1920, eqs 6 and 7)",
            "$M/M_t$ [–]",
            {
                "$M_x/M_t$ (6)": joint["bending M_x/M_t"],
                "$M_z/M_t$ (7)": joint["bending M_z/M_t"],
            },
        ),
        "speed_ratio": (
            "Speed ratio of the universal joint and of the double shaft",
            "ω₂/ω₁ [–]",
            {
                "universal joint": joint["speed ratio dφ₂/dφ₁"],
                "double shaft": shaft["speed ratio = 1"],
            },
        ),
    }
    beta = np.rad2deg(float(np.max(joint_turn.held["joint_angle"])))
    found = {}
    for name, (caption, quantity, pairs) in told.items():
        title = f"{caption.partition(' (')[0]}, β = {beta:g}°"
        if quantity:
            computed, closed = ({key: pair[of] for key, pair in pairs.items()} for of in (1, 2))
            figure = figures.compared(POSITIONS, computed, closed, quantity=quantity, title=title)
        else:
            figure = _polar(title, pairs, joint["output angle φ₂"])
        found[name] = caption, figure
    return found


def _polar(title: str, pairs: dict[str, Pair], output: Pair) -> Figure:
    """Draw sizes over the angle of the input shaft, and of the output shaft."""
    figure, axes = axes_grid(size=(6.4, 6.0), projection="polar")
    axes.set_title(title, pad=14)
    axes.set_rlabel_position(67.5)
    for label in axes.get_yticklabels():
        label.set_bbox({"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0})
    angles = Pair("", POSITIONS, POSITIONS), output
    shown = thinned(len(POSITIONS))
    for index, ((label, pair), at) in enumerate(zip(pairs.items(), angles, strict=True)):
        axes.plot(at.closed, pair.closed, **line_style(index), label=f"{label}, closed form")
        points = at.computed[shown], pair.computed[shown]
        axes.plot(*points, **point_style(index), label=f"{label}, Pinocchio")
    legend(figure)
    return figure


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
