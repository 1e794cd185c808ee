"""Impact ranking: joints by the severity of their impacts, and what would make them milder."""

from __future__ import annotations

import numpy as np

from ...errors import ArgumentError
from ...figures.style import Figure, Into, Size, in_look, line_style, plain, point_style, sheet
from ..scan_results import Scan

_BAR = 0.26
"""Width of a bar, where joints are 1 apart."""
_LESS = -0.1
_ROW, _ROOM = 0.55, 2.2
"""Height of the figure per joint, and for all that surrounds them [inch]."""
_SPREAD = 0.6
"""Width over which the points of a joint are spread, where joints are 1 apart."""


@in_look
def impact_ranking(
    scanned: Scan, *, title: str = "", ax: Into = None, figsize: Size | None = None
) -> Figure:
    """Draw joints by severity: forces with and without clearance, and what less would buy.

    On the left the greatest force of each joint without clearance and that of its impacts, where
    the force vanishes and, in another bar, where it turns through; those first that are greatest;
    joints in which nothing strikes have no such bar. On the right by
    how much that peak would change with 10 % less of speed, slope, clearance, mass or stiffness.

    Args:
        scanned: from `clearance.scan`.
        title: of the figure.
        ax: two axes to be drawn into instead of a new figure.
        figsize: width and height of a new figure [inch].

    Raises:
        ArgumentError: no joint was scanned.
    """
    if not len(scanned):
        raise ArgumentError("no joint was scanned, so that there is no ranking")
    ranking = scanned.ranking
    places = np.arange(len(ranking))
    joints = [scanned[name] for name in ranking]
    size = (10.5, _ROOM + _ROW * len(ranking))
    drawn = sheet(1, 2, size=size, ax=ax, figsize=figsize)
    forces, effects = drawn.panels
    rigid = [joint.rigid_peak for joint in joints]
    peaks = [joint.severity for joint in joints]
    partial = [joint.partial_severity for joint in joints]
    solid, open_bar = line_style(0)["color"], line_style(1)["color"]
    forces.barh(places - _BAR, peaks, _BAR, color=solid, label="with clearance: peak of impacts")
    forces.barh(
        places,
        partial,
        _BAR,
        color=solid,
        alpha=0.4,
        label="with clearance: where the force turns through",
    )
    forces.barh(
        places + _BAR,
        rigid,
        _BAR,
        color="white",
        edgecolor=open_bar,
        hatch="///",
        label="without clearance: greatest force",
    )
    forces.set_xlabel("force [N]")
    forces.set_yticks(places, [plain(name) for name in ranking])
    bought = [None if joint.worst is None else joint.worst.effects(_LESS) for joint in joints]
    parameters = next((list(found) for found in bought if found is not None), [])
    for index, name in enumerate(parameters):
        values = [np.nan if found is None else 100.0 * found[name] for found in bought]
        beside = _SPREAD * (index / (len(parameters) - 1) - 0.5)
        effects.plot(values, places + beside, **point_style(index), label=f"less {name}")
    effects.axvline(0.0, color="0.3", linewidth=0.9)
    effects.set_xlabel(f"change of the peak with {-100.0 * _LESS:g} % less [%]")
    effects.set_yticks(places, [""] * len(ranking))
    for axes in (forces, effects):
        axes.set_ylim(len(ranking) - 0.5, -0.5)
    return drawn.finish(title or f"Impacts at {scanned.speed:g} rad/s", 4)
