"""Hinge balls: three hinges in a row that meet in one point, as a ball is often written.

More hinges than three that meet in one point are a spherical linkage, whose links have poses of
their own.
"""

from __future__ import annotations

import numpy as np
import pinocchio

from ..arrays import Array
from ..mechanism.mechanism import Mechanism
from .idle_rods import JointEdge, JointGraph, common_point


def hinges_in_balls(mechanism: Mechanism) -> set[int]:
    """Return the velocity coordinates of all hinges of which three make up a ball."""
    graph = JointGraph(mechanism, set(range(mechanism.model.nv)))
    centres = {
        body: centre
        for body, edges in graph.edges.items()
        if body != graph.world and (centre := _centre(edges, graph.tolerance)) is not None
    }
    result: set[int] = set()
    done: set[int] = set()
    for body in centres:
        if body not in done:
            links = _links_around(graph, centres, body)
            done |= links
            hinges = {edge.columns[0] for link in links for edge in graph.edges[link]}
            if (len(links), len(hinges)) == (2, 3):
                result |= hinges
    return result


def _centre(edges: list[JointEdge], tolerance: float) -> Array | None:
    """Return the point in which the axes of the two hinges of a link meet; None if they do not."""
    if [edge.kind for edge in edges] != ["revolute", "revolute"]:
        return None
    lines = [(edge.frame.translation, edge.frame.rotation @ edge.axis) for edge in edges]
    return common_point(lines, tolerance)


def _links_around(graph: JointGraph, centres: dict[int, Array], body: int) -> set[int]:
    """Return the links that follow a link and each other, and whose hinges meet in its centre."""
    links, waiting = {body}, [body]
    while waiting:
        link = waiting.pop()
        for edge in graph.edges[link]:
            if edge.other in centres and edge.other not in links:
                here = _in_joint(edge.frame, centres[link])
                there = _in_joint(edge.other_frame, centres[edge.other])
                # Both lie on the hinge's axis, so that the hinge's angle makes no difference.
                if np.linalg.norm(here - there) < graph.tolerance:
                    links.add(edge.other)
                    waiting.append(edge.other)
    return links


def _in_joint(frame: pinocchio.SE3, point: Array) -> Array:
    """Return a point `(3,)` of a body in the frame of one of its joints."""
    return np.asarray(frame.actInv(np.asarray(point)))
