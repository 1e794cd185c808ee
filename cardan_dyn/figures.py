"""Figures: wrenches from Pinocchio as points over the closed forms as lines.

Needs the extra `viz` (matplotlib). Every function returns a matplotlib figure.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from analytic import grossmann, single_joint, thoma

from .comparisons import POSITIONS, TORQUE, thoma_moments
from .coordinates import Array
from .errors import MissingExtraError
from .sweep import Sweep

Figure = Any
"""A `matplotlib.figure.Figure`; matplotlib is imported only where a figure is drawn."""

_FINE = np.linspace(0.0, 2.0 * np.pi, 1441)
_POINTS = slice(None, None, 20)
# Line styles differ besides colours, so that a black-and-white print can be read.
_STYLES = (
    {"color": "#1b4f8a", "linestyle": "-"},
    {"color": "#c2571a", "linestyle": "--"},
    {"color": "#3a7d44", "linestyle": ":"},
)
_MARKERS = ("o", "s", "^")
_LOOK: Any = {
    "figure.figsize": (7.2, 4.8),
    "figure.constrained_layout.use": True,
    "font.size": 11,
    "axes.titlesize": 11,
    "axes.grid": True,
    "grid.color": "0.88",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "lines.linewidth": 1.6,
    "svg.fonttype": "none",
    "svg.hashsalt": "cardan-dyn",
}


def require_matplotlib() -> None:
    """Import matplotlib.

    Raises:
        MissingExtraError: it is not installed; the message names the install command.
    """
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise MissingExtraError('figures need matplotlib: pip install "cardan-dyn[viz]"') from error


def torque_ratio(turn: Sweep, beta: float) -> Figure:
    """Draw D₂/D₁ over the turn: Grossmann (1939), Abb. 3."""
    figure, axes = _axes("Torque ratio of the universal joint", beta, "D₂/D₁ [–]")
    found = -turn["bearing_out"].torsion / turn["bearing_in"].torsion
    _draw(axes, 0, "D₂/D₁", found, grossmann.moments(beta, _FINE).torsion_2)
    _legend(figure)
    return figure


def bending_polar(turn: Sweep, beta: float) -> Figure:
    """Draw B₁/D₁ over φ₁ and B₂/D₁ over φ₂ as polar diagrams: Grossmann (1939), Abb. 4."""
    figure, axes = _polar_axes(f"Bending moments referred to the input torque, β = {_deg(beta)}°")
    torque = turn["bearing_in"].torsion
    closed = grossmann.moments(beta, _FINE)
    phi_2 = turn.motion.position("bearing_out")
    for number, (label, angle, found, line_angle, line) in enumerate(
        (
            ("B₁/D₁ over φ₁", POSITIONS, turn["bearing_in"].bending, _FINE, closed.bending_1),
            (
                "B₂/D₁ over φ₂",
                phi_2,
                turn["bearing_out"].bending,
                single_joint.output_angle(beta, _FINE),
                closed.bending_2,
            ),
        )
    ):
        axes.plot(line_angle, line, **_STYLES[number], label=f"{label}, closed form")
        axes.plot(
            angle[_POINTS],
            (found / torque)[_POINTS],
            **_points(number),
            label=f"{label}, Pinocchio",
        )
    _legend(figure)
    return figure


def thoma_bending(turn: Sweep, beta: float) -> Figure:
    """Draw M_x/M_t and M_z/M_t over the turn: Thoma (1920), eqs 6 and 7."""
    figure, axes = _axes("Bending of the output shaft in fixed axes", beta, "$M/M_t$ [–]")
    closed = thoma.bending_moments(beta, _FINE)
    for number, (label, found) in enumerate(
        zip(("$M_x/M_t$ (6)", "$M_z/M_t$ (7)"), thoma_moments(turn), strict=True)
    ):
        _draw(axes, number, label, found / TORQUE, closed[number])
    _legend(figure)
    return figure


def speed_ratio(joint_turn: Sweep, shaft_turn: Sweep, beta: float) -> Figure:
    """Draw the speed ratio of the universal joint and of the double shaft over the turn."""
    figure, axes = _axes("Speed ratio, output to input", beta, "ω₂/ω₁ [–]")
    for number, (label, turn, line) in enumerate(
        (
            ("universal joint", joint_turn, single_joint.speed_ratio(beta, _FINE)),
            ("double shaft", shaft_turn, np.ones_like(_FINE)),
        )
    ):
        _draw(axes, number, label, turn.motion.ratio("bearing_out"), line)
    _legend(figure)
    return figure


def _draw(axes: Any, number: int, label: str, found: Array, line: Array) -> None:
    axes.plot(np.rad2deg(_FINE), line, **_STYLES[number], label=f"{label}, closed form")
    axes.plot(
        np.rad2deg(POSITIONS)[_POINTS],
        found[_POINTS],
        **_points(number),
        label=f"{label}, Pinocchio",
    )


def _points(number: int) -> dict[str, Any]:
    return {
        "linestyle": "none",
        "marker": _MARKERS[number],
        "markersize": 5,
        "markerfacecolor": "white",
        "color": _STYLES[number]["color"],
    }


def _axes(title: str, beta: float, label: str) -> tuple[Figure, Any]:
    figure, axes = _subplots()
    axes.set_title(f"{title}, β = {_deg(beta)}°")
    axes.set_xlabel("rotation of the input shaft φ₁ [°]")
    axes.set_ylabel(label)
    axes.set_xlim(0.0, 360.0)
    axes.set_xticks(range(0, 361, 45))
    return figure, axes


def _polar_axes(title: str) -> tuple[Figure, Any]:
    figure, axes = _subplots(projection="polar")
    figure.set_size_inches(6.4, 6.0)
    axes.set_title(title, pad=14)
    axes.set_rticks([0.4, 0.8, 1.2])
    axes.set_rlabel_position(67.5)
    for label in axes.get_yticklabels():
        label.set_bbox({"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0})
    return figure, axes


def _legend(figure: Figure) -> None:
    figure.legend(loc="outside lower center", ncols=2, frameon=False)


def _subplots(**projection: str) -> tuple[Figure, Any]:
    require_matplotlib()
    import matplotlib
    from matplotlib.figure import Figure as MatplotlibFigure

    with matplotlib.rc_context(_LOOK):
        figure = MatplotlibFigure()
        axes = figure.add_subplot(**projection)
    return figure, axes


def _deg(beta: float) -> str:
    return f"{np.rad2deg(beta):g}"
