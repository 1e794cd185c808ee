"""Pin orbit: the way of a pin in the clearance of its bush, and where it touches the wall."""

from __future__ import annotations

import numpy as np

from ....figures.polar import columns_of
from ....figures.style import Figure, Into, Size, in_look, line_style, point_style, sheet
from ....kit.arrays import Array
from ....kit.errors import ArgumentError
from ..contact_simulation import ContactSimulation, JointContact, finely


@in_look
def pin_orbit(
    simulation: ContactSimulation,
    joint: str,
    *,
    plane: str | None = None,
    title: str = "",
    ax: Into = None,
    figsize: Size | None = None,
) -> Figure:
    """Draw the orbit of a pin as its bush sees it: free in the clearance, or pressed to the wall.

    The circle bounds the clearance: beyond it, the pin has entered the wall. Each impact begins
    at a point on it.

    Args:
        simulation: from `clearance.simulate`.
        joint: with clearance, or one of its bearings.
        plane: `xy`, `yz` or `zx` of the world, instead of the plane across the bush's axis.
        title: of the figure.
        ax: axes to be drawn into instead of a new figure.
        figsize: width and height of a new figure [inch].

    Raises:
        ModelError: no such joint has clearance.
        ArgumentError: unknown plane, or a single time.
    """
    times = simulation.time
    if len(times) < 2:
        raise ArgumentError("an orbit is drawn over several times, not over one")
    course = finely(simulation, joint)
    radius = float(np.median(np.linalg.norm(course.offset, axis=1) - course.depth))
    spans = [(item.start, item.end) for item in course.impacts]
    lines = _states(course, np.reshape(spans, (-1, 2)))
    drawn = sheet(size=(6.2, 6.6), ax=ax, figsize=figsize)
    (axes,) = drawn.panels
    turn = np.linspace(0.0, 2.0 * np.pi, 361)
    circle = 1e6 * radius * np.stack([np.cos(turn), np.sin(turn)])
    axes.plot(*circle, color="0.55", linewidth=3.0, label="bounds of the clearance")
    for index, (label, state) in enumerate(lines.items()):
        style = {**line_style(index), "linewidth": 0.9}
        axes.plot(*np.where(state[:, None], _drawn(course, plane), np.nan).T, **style, label=label)
    starts = [start for start, _ in spans if times[0] < start <= times[-1]]
    if starts:
        points = _drawn(simulation.at(starts)[joint], plane)
        axes.plot(*points.T, **point_style(2), label="impact begins")
    for letter, name in zip(plane or "12", ("x", "y"), strict=True):
        of = f"{letter} from the bush's axis, world axes" if plane else f"way {letter} in the bush"
        getattr(axes, f"set_{name}label")(f"{of} [µm]")
    axes.set_aspect("equal")
    return drawn.finish(title or f"Orbit of the pin in {joint}", 4)


def _states(course: JointContact, impacts: Array) -> dict[str, Array]:
    """Return which points `(N,)` belong to the line of each state; where it changes, to both."""
    middles = 0.5 * (course.time[1:] + course.time[:-1])
    begun, ended = (np.searchsorted(np.sort(column), middles) for column in impacts.T)
    pressed = begun > ended
    return {
        label: np.append(parts, False) | np.insert(parts, 0, False)
        for label, parts in (("pressed", pressed), ("free", ~pressed))
    }


def _drawn(course: JointContact, plane: str | None) -> Array:
    """Return the ways `(N, 2)` of a pin in a plane of the world, or in its bush if None [µm]."""
    return 1e6 * (course.orbit if plane is None else course.offset[:, columns_of(plane)])
