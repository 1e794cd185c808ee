"""Impact ranking: joints by their peaks, and what would make them milder."""

from __future__ import annotations

import numpy as np

from ....figures.style import Figure, Into, Size, in_look, line_style, plain, point_style, sheet
from ....kit.errors import ArgumentError
from ..scan_results import Scan


@in_look
def impact_ranking(
    scanned: Scan, *, title: str = "", ax: Into = None, figsize: Size | None = None
) -> Figure:
    """Draw joints by their peaks: forces with and without clearance, and what less would buy.

    On the left `JointScan.peak` with its interval, where one is known, and the greatest force
    without clearance; those first that are greatest. On the right by how much the two-mass peak of
    the worst reversal would change with 10 % less of speed, slope, clearance, mass or stiffness,
    where sides strike.

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
    # Joints are 1 apart.
    places, bar, less = np.arange(len(ranking)), 0.36, 0.1
    joints = [scanned[name] for name in ranking]
    size = (10.5, 2.2 + 0.55 * len(ranking))
    drawn = sheet(1, 2, size=size, ax=ax, figsize=figsize)
    forces, effects = drawn.panels
    rigid = [joint.rigid_peak for joint in joints]
    peaks = [joint.peak for joint in joints]
    solid, open_bar = line_style(0)["color"], line_style(1)["color"]
    forces.barh(places - bar / 2, peaks, bar, color=solid, label="with clearance: peak")
    ends = [joint.greatest for joint in joints]
    widths = [joint.greatest - joint.least for joint in joints]
    # The peak may lie above its interval: a force without clearance, or one that was simulated.
    interval = {"xerr": [widths, np.zeros(len(joints))], "fmt": "none", "ecolor": "0.3"}
    forces.errorbar(ends, places - bar / 2, **interval, capsize=3.0, label="its interval")
    forces.barh(
        places + bar / 2,
        rigid,
        bar,
        color="white",
        edgecolor=open_bar,
        hatch="///",
        label="without clearance: greatest force",
    )
    forces.set_xlabel("force [N]")
    forces.set_yticks(places, [plain(name) for name in ranking])
    worst = [joint.worst for joint in joints]
    bought = [item.effects(-less) if item is not None and item.strikes else None for item in worst]
    parameters = next((list(found) for found in bought if found is not None), [])
    for index, name in enumerate(parameters):
        values = [np.nan if found is None else 100.0 * found[name] for found in bought]
        beside = 0.6 * (index / (len(parameters) - 1) - 0.5)
        effects.plot(values, places + beside, **point_style(index), label=f"less {name}")
    effects.axvline(0.0, color="0.3", linewidth=0.9)
    effects.set_xlabel(f"change of the two-mass peak with {100.0 * less:g} % less [%]")
    effects.set_yticks(places, [""] * len(ranking))
    for axes in (forces, effects):
        axes.set_ylim(len(ranking) - 0.5, -0.5)
    return drawn.finish(title or f"Peaks with clearance at {scanned.speed:g} rad/s", 4)
