"""Closed forms as lines, wrenches from Pinocchio as points."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from analytic import grossmann, single_joint, thoma

from ..comparisons import POSITIONS, TORQUE, thoma_moments
from ..coordinates import Array
from ..sweep import Sweep
from .style import Axes, Figure, angle_axis, axes_grid, legend, line_style, point_style

INPUT_LABEL = "rotation of the input shaft φ₁ [°]"
_FINE = np.linspace(0.0, 2.0 * np.pi, 1441)


def torque_ratio(turn: Sweep, beta: float) -> Figure:
    """Draw D₂/D₁ over the turn: Grossmann (1939), Abb. 3."""
    figure, axes = _axes("Torque ratio of the universal joint", beta, "D₂/D₁ [–]")
    found = -turn["bearing_out"].torsion / turn["bearing_in"].torsion
    _draw(axes, 0, "D₂/D₁", found, grossmann.moments(beta, _FINE).torsion_2)
    legend(figure)
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
        axes.plot(line_angle, line, **line_style(number), label=f"{label}, closed form")
        axes.plot(
            angle[::20],
            (found / torque)[::20],
            **point_style(number),
            label=f"{label}, Pinocchio",
        )
    legend(figure)
    return figure


def thoma_bending(turn: Sweep, beta: float) -> Figure:
    """Draw M_x/M_t and M_z/M_t over the turn: Thoma (1920), eqs 6 and 7."""
    figure, axes = _axes("Bending of the output shaft in fixed axes", beta, "$M/M_t$ [–]")
    closed = thoma.bending_moments(beta, _FINE)
    for number, (label, found) in enumerate(
        zip(("$M_x/M_t$ (6)", "$M_z/M_t$ (7)"), thoma_moments(turn), strict=True)
    ):
        _draw(axes, number, label, found / TORQUE, closed[number])
    legend(figure)
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
    legend(figure)
    return figure


def compared(
    position: ArrayLike,
    found: Mapping[str, ArrayLike],
    closed: Mapping[str, ArrayLike],
    *,
    quantity: str,
    title: str = "",
    over: str = INPUT_LABEL,
    points: int = 36,
) -> Figure:
    """Draw results as points over closed forms as lines.

    Args:
        position: `(N,)` angles [rad], the abscissa of all values.
        found: label to computed values `(N,)`, drawn as points.
        closed: label to values of a formula `(N,)`, drawn as lines. A label that both have is
            drawn in one colour.
        quantity: label of the ordinate, with its unit.
        title: of the figure.
        over: label of the abscissa, with its unit.
        points: about how many points are drawn of each result.
    """
    angle = np.asarray(position, dtype=float)
    every = slice(None, None, max(1, (len(angle) - 1) // points))
    numbers = {label: number for number, label in enumerate({**found, **closed})}
    figure, axes = axes_grid()
    for label, values in closed.items():
        name = f"{label}, closed form" if label in found else label
        axes.plot(np.rad2deg(angle), np.asarray(values), **line_style(numbers[label]), label=name)
    for label, values in found.items():
        shown = np.asarray(values)[every]
        style = point_style(numbers[label])
        axes.plot(np.rad2deg(angle)[every], shown, **style, label=f"{label}, Pinocchio")
    axes.set_title(title)
    axes.set_ylabel(quantity)
    angle_axis(axes, over, angle)
    legend(figure, 3 if len(found) + len(closed) > 6 else 2)
    return figure


def _draw(axes: Axes, number: int, label: str, found: Array, line: Array) -> None:
    axes.plot(np.rad2deg(_FINE), line, **line_style(number), label=f"{label}, closed form")
    axes.plot(
        np.rad2deg(POSITIONS)[::20],
        found[::20],
        **point_style(number),
        label=f"{label}, Pinocchio",
    )


def _axes(title: str, beta: float, label: str) -> tuple[Figure, Axes]:
    figure, axes = axes_grid()
    axes.set_title(f"{title}, β = {_deg(beta)}°")
    axes.set_ylabel(label)
    angle_axis(axes, INPUT_LABEL, POSITIONS)
    return figure, axes


def _polar_axes(title: str) -> tuple[Figure, Axes]:
    figure, axes = axes_grid(size=(6.4, 6.0), projection="polar")
    axes.set_title(title, pad=14)
    axes.set_rticks([0.4, 0.8, 1.2])
    axes.set_rlabel_position(67.5)
    for label in axes.get_yticklabels():
        label.set_bbox({"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0})
    return figure, axes


def _deg(beta: float) -> str:
    return f"{np.rad2deg(beta):g}"
