"""Force reversals: polar diagrams of joint forces with the positions at which they swing round."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....figures.polar import across, columns_of, diagram, reach
from ....figures.style import (
    SIGN,
    SMALL,
    Axes,
    Figure,
    Into,
    Size,
    in_look,
    line_style,
    plain,
    sheet,
    wrapped,
)
from ....kit.arrays import Array
from ....kit.checks import names
from ....kit.errors import ArgumentError
from ..scan_results import ForceReversal, JointScan, Scan


@in_look
def force_reversals(
    scanned: Scan,
    joints: str | Sequence[str] | None = None,
    *,
    plane: str | None = None,
    title: str = "",
    ax: Into = None,
    figsize: Size | None = None,
) -> Figure:
    """Draw the force across each pin as a polar diagram, in world axes, with its reversals.

    The curve joins the ends of the forces on the child link over a period of the drive. An arrow
    from the origin shows which way the force grows where it swings round, and at which position of
    the drive; it is dashed where the sides would not strike. All diagrams have one scale.

    Args:
        scanned: from `clearance.scan`.
        joints: one or several of it, of universal joints each bearing; all in the order of their
            peaks if None.
        plane: the axes across and up, such as `zx`, instead of `xy`, `yz` or `xz`, which is most
            nearly across each pin.
        title: of the figure.
        ax: axes to be drawn into instead of a new figure, one for each bearing.
        figsize: width and height of a new figure [inch].

    Raises:
        ModelError: a joint was not scanned.
        ArgumentError: unknown plane, or another number of axes.

    Source:
        Dresig and Thümmel, Bild 1.
    """
    wanted = scanned.ranking if joints is None else names("joints", joints)
    shown = [item for name in wanted for item in scanned[name].by_bearing().values()]
    columns = min(len(shown), 3 if len(shown) > 4 else 2) or 1
    rows = -(-len(shown) // columns) or 1
    if not shown:
        raise ArgumentError("no joint was scanned, so that there is no force to be drawn")
    drawn = sheet(
        rows,
        columns,
        count=len(shown),
        size=(1.2 + 3.6 * columns, 0.8 + 3.7 * rows),
        ax=ax,
        figsize=figsize,
    )
    planes = [plane or across(_axis(joint.force)) for joint in shown]
    half = max(
        reach(joint.force[:, columns_of(item)]) for joint, item in zip(shown, planes, strict=True)
    )
    width = drawn.figure.get_figwidth() / columns - 0.4
    for panel, joint, drawn_in in zip(drawn.panels, shown, planes, strict=True):
        _draw(panel, joint, columns_of(drawn_in), half)
        panel.set_title(wrapped(f"{plain(joint.name)}\nworld axes", width))
        panel.set_xlabel(f"$F_{drawn_in[0]}$ [N]")
        panel.set_ylabel(f"$F_{drawn_in[1]}$ [N]")
    return drawn.finish(title, note=f"{SIGN}, without clearance")


def _draw(axes: Axes, joint: JointScan, columns: list[int], half: float) -> None:
    """Draw a joint's force and its reversals, in a plane."""
    ends = joint.force[:, columns]
    # The period's end is its beginning.
    closed = np.concatenate([ends, ends[:1]])
    diagram(axes, joint.position, closed, half)
    length = 0.35 * float(np.max(np.linalg.norm(ends, axis=1)))
    for item in joint.reversals:
        _arrow(axes, item, length * item.direction[columns])


def _arrow(axes: Axes, item: ForceReversal, tip: Array) -> None:
    """Draw a reversal as an arrow from the origin, labelled with the drive's position."""
    color = line_style(1)["color"]
    dashes = "-" if item.strikes else "--"
    look = {"arrowstyle": "-|>", "color": color, "linewidth": 1.4, "linestyle": dashes}
    axes.annotate("", tip, (0.0, 0.0), arrowprops={**look, "shrinkA": 0.0, "shrinkB": 0.0})
    aside = np.array([tip[1], -tip[0]])
    aside = 16.0 * aside / (float(np.linalg.norm(aside)) or 1.0)
    axes.annotate(
        f"{np.rad2deg(item.position):.0f}°",
        tip,
        aside,
        textcoords="offset points",
        ha="center",
        va="center",
        color=color,
        fontsize=SMALL,
        bbox={"boxstyle": "round,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.7},
    )


def _axis(force: Array) -> Array:
    """Return the direction across the plane of forces `(N, 3)`."""
    scale = float(np.max(np.abs(force))) or 1.0
    return np.asarray(np.linalg.svd(force / scale, full_matrices=True)[2][2])
