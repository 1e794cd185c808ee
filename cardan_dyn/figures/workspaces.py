"""Workspaces: regions of two coordinates, and curves by which they are bordered."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Unpack

from ..kit.arrays import Array
from .style import Figure, Onto, in_look, line_style, plain, sheet


@in_look
def regions(
    grid: tuple[Array, Array],
    labels: Sequence[str],
    panels: Sequence[tuple[str, Array, Sequence[tuple[str, Array]]]],
    **onto: Unpack[Onto],
) -> Figure:
    """Draw regions in grey and curves around them, in panels beside each other.

    Args:
        grid: positions of two coordinates.
        labels: of both, with their units.
        panels: of each what is written above it, `(S, S)` which positions belong to the region, and
            curves: what they are and their points `(k, 2)`.
        onto: `title`, `ax` to draw into and `figsize` [inch], see `style.Onto`;
            one axes for each panel.

    Raises:
        ArgumentError: other axes than are needed.
    """
    columns = min(len(panels), 3)
    rows = -(-len(panels) // columns)
    size = max(7.2, 1.2 + 4.2 * columns), 1.4 + 3.9 * rows
    drawn = sheet(rows, columns, count=len(panels), size=size, **onto)
    kinds = list(dict.fromkeys(kind for _, _, curves in panels for kind, _ in curves))
    for panel, (head, region, curves) in zip(drawn.panels, panels, strict=True):
        if region.any():
            panel.contourf(*grid, region.T, levels=[0.5, 1.5], colors=["0.9"])
        for kind, points in curves:
            marker = "o" if len(points) == 1 else ""
            panel.plot(*points.T, label=plain(kind), marker=marker, **line_style(kinds.index(kind)))
        panel.set(xlabel=plain(labels[0]), ylabel=plain(labels[1]), title=plain(head))
        panel.set(xlim=(grid[0][0], grid[0][-1]), ylim=(grid[1][0], grid[1][-1]))
        if labels[0].endswith("m]") == labels[1].endswith("m]"):
            panel.set_aspect("equal")
    return drawn.finish(columns=3)
