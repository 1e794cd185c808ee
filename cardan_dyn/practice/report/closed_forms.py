"""Closed forms as lines, wrenches from Pinocchio as points."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from cardan_dyn.analytic import grossmann, single_joint, thoma

from ...core.results.sweep import Sweep
from ...figures.compared import INPUT_LABEL
from ...figures.style import (
    Axes,
    Figure,
    angle_axis,
    axes_grid,
    legend,
    line_style,
    point_style,
    refuse_grid,
    thinned,
)
from ...kit.arrays import Array
from ...kit.errors import ArgumentError, choices
from .comparisons import POSITIONS, thoma_moments

_INPUT, _OUTPUT, _BEND = "bearing_in", "bearing_out", "joint_angle"


def torque_ratio(turn: Sweep) -> Figure:
    """Draw D₂/D₁ over the input angle: Grossmann (1939), Abb. 3.

    Args:
        turn: sweep of a universal joint with the joints of the bundled one, its `joint_angle`
            held, at any positions and under any load on its output.

    Raises:
        ModelError: the sweep lacks `bearing_in` or `bearing_out`.
        ArgumentError: `joint_angle` is not held, or no torque passes through the joint.
    """
    beta = _held_angle(turn)
    computed = _ratio(-turn[_OUTPUT].torsion, turn[_INPUT].torsion)
    curve = _Curve("D₂/D₁", turn, computed, lambda at: grossmann.moments(beta, at).torsion_2)
    return _figure("Torque ratio of the universal joint", beta, "D₂/D₁ [–]", curve)


def bending_polar(turn: Sweep) -> Figure:
    """Draw B₁/D₁ over φ₁ and B₂/D₁ over φ₂ as polar diagrams: Grossmann (1939), Abb. 4.

    Arguments and errors are those of `torque_ratio`. The lines are drawn over one turn.
    """
    beta = _held_angle(turn)
    closed = grossmann.moments(beta, POSITIONS)
    title = f"Bending moments referred to the input torque, β = {_deg(beta)}°"
    figure, axes = _polar_axes(title)
    torque = np.abs(turn[_INPUT].torsion)
    for index, (label, joint, line_angle, line) in enumerate(
        (
            ("B₁/D₁ over φ₁", _INPUT, POSITIONS, closed.bending_1),
            (
                "B₂/D₁ over φ₂",
                _OUTPUT,
                single_joint.output_angle(beta, POSITIONS),
                closed.bending_2,
            ),
        )
    ):
        shown = thinned(len(turn))
        angle = turn.motion.position(joint)[shown]
        computed = _ratio(turn[joint].bending, torque)[shown]
        axes.plot(line_angle, line, **line_style(index), label=f"{label}, closed form")
        axes.plot(angle, computed, **point_style(index), label=f"{label}, Pinocchio")
    legend(figure)
    return figure


def thoma_bending(turn: Sweep) -> Figure:
    """Draw M_x/M_t and M_z/M_t over the input angle: Thoma (1920), eqs 6 and 7.

    Arguments and errors are those of `torque_ratio`.
    """
    beta = _held_angle(turn)
    torque, (m_x, m_z) = -turn[_OUTPUT].torsion, thoma_moments(turn)
    return _figure(
        "Bending of the output shaft in fixed axes",
        beta,
        "$M/M_t$ [–]",
        _Curve(
            "$M_x/M_t$ (6)",
            turn,
            _ratio(m_x, torque),
            lambda at: thoma.bending_moments(beta, at)[0],
        ),
        _Curve(
            "$M_z/M_t$ (7)",
            turn,
            _ratio(m_z, torque),
            lambda at: thoma.bending_moments(beta, at)[1],
        ),
    )


def speed_ratio(joint_turn: Sweep, shaft_turn: Sweep) -> Figure:
    """Draw the speed ratio of the universal joint and of the double shaft over the input angle.

    Args:
        joint_turn: sweep of a universal joint, its `joint_angle` held, at any positions.
        shaft_turn: sweep of a double shaft with equal joint angles, at any positions.

    Raises:
        ModelError: a sweep lacks `bearing_in` or `bearing_out`.
        ArgumentError: `joint_angle` of the universal joint is not held.
    """
    beta = _held_angle(joint_turn)
    one, both = (turn.motion.ratio(_OUTPUT) for turn in (joint_turn, shaft_turn))
    return _figure(
        "Speed ratio, output to input",
        beta,
        "ω₂/ω₁ [–]",
        _Curve("universal joint", joint_turn, one, partial(single_joint.speed_ratio, beta)),
        _Curve("double shaft", shaft_turn, both, np.ones_like),
    )


class _Curve(NamedTuple):
    """Values of a sweep, and the closed form of its input angle."""

    label: str
    turn: Sweep
    computed: Array
    closed: Callable[[Array], Array]


def _held_angle(turn: Sweep) -> float:
    """Return the joint angle at which a universal joint is held [rad]."""
    if _BEND not in turn.held:
        raise ArgumentError(
            f"the closed forms need a universal joint whose {_BEND!r} is held; held: "
            f"{choices(turn.held)}"
        )
    beta = turn.held[_BEND]
    if np.ndim(beta):
        raise ArgumentError(f"the closed forms need one {_BEND!r}; draw one design at a time")
    return float(beta)


def _figure(title: str, beta: float, label: str, *curves: _Curve) -> Figure:
    """Draw closed forms over the input angles of sweeps, and values of the sweeps."""
    for curve in curves:
        refuse_grid(curve.turn)
    angle = np.concatenate([curve.turn.motion.position(_INPUT) for curve in curves])
    low, high = float(np.min(angle)), float(np.max(angle))
    if low == high:
        # A single position spans no range; the whole turn around it is drawn.
        low = 2.0 * np.pi * np.floor(low / (2.0 * np.pi))
        high = low + 2.0 * np.pi
    count = math.ceil((high - low) / (2.0 * np.pi))
    line = np.linspace(low, high, count * len(POSITIONS))
    figure, axes = axes_grid()
    axes.set_title(f"{title}, β = {_deg(beta)}°")
    axes.set_ylabel(label)
    angle_axis(axes, INPUT_LABEL, line)
    for index, (name, turn, computed, closed) in enumerate(curves):
        form = f"{name}, closed form"
        axes.plot(np.rad2deg(line), closed(line), **line_style(index), label=form)
        shown = thinned(len(computed))
        places = np.rad2deg(turn.motion.position(_INPUT))[shown]
        points = f"{name}, Pinocchio"
        axes.plot(places, computed[shown], **point_style(index), label=points)
    legend(figure)
    return figure


def _ratio(moment: Array, torque: Array) -> Array:
    """Return a moment per torque; NaN at samples where no torque passes through."""
    if not np.any(torque):
        raise ArgumentError(
            f"no torque passes through the joint at any sample; load {_OUTPUT!r} in the scene"
        )
    return np.divide(moment, torque, out=np.full(np.shape(moment), np.nan), where=torque != 0.0)


def _polar_axes(title: str) -> tuple[Figure, Axes]:
    """Return polar axes, whose circles are labelled beside the curves."""
    figure, axes = axes_grid(size=(6.4, 6.0), projection="polar")
    axes.set_title(title, pad=14)
    axes.set_rlabel_position(67.5)
    for label in axes.get_yticklabels():
        label.set_bbox({"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0})
    return figure, axes


def _deg(beta: float) -> str:
    return f"{np.rad2deg(beta):g}"
