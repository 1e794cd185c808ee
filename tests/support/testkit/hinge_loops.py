"""Loops of hinges given by their axes in the world, and their ranks by screws alone.

The only thing that a description takes from here are numbers: the oracle builds its matrix from the
same points and directions, but from no description, model or solver.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

Array = np.ndarray


class Hinge(NamedTuple):
    """A hinge in the world: a point on its axis `(3,)` [m], and the unit direction `(3,)`."""

    point: Array
    direction: Array

    @property
    def screw(self) -> Array:
        """Unit twist `(6,)` about the world's origin."""
        return np.concatenate([np.cross(self.point, self.direction), self.direction])

    @property
    def frame(self) -> Array:
        """Placement `(4, 4)` of a frame whose z axis is the hinge's, its x axis anywhere."""
        helper = np.eye(3)[np.argmin(np.abs(self.direction))]
        x = np.cross(helper, self.direction)
        x /= np.linalg.norm(x)
        frame = np.eye(4)
        frame[:3, :3] = np.stack([x, np.cross(self.direction, x), self.direction], axis=1)
        frame[:3, 3] = self.point
        # Turned a little, so that no angle between such frames is at the end of its range.
        return np.asarray(frame @ _step(0.4, 0.0, 0.0))


def hinge(point: object, direction: object) -> Hinge:
    direction = np.asarray(direction, dtype=float)
    return Hinge(np.asarray(point, dtype=float), direction / np.linalg.norm(direction))


def origin(frame: Array) -> str:
    """An <origin> with enough digits to close a loop to rounding."""
    angles = Rotation.from_matrix(frame[:3, :3]).as_euler("xyz").tolist()
    values = (" ".join(repr(value) for value in part) for part in (frame[:3, 3].tolist(), angles))
    return '<origin xyz="{}" rpy="{}"/>'.format(*values)


def description(hinges: list[Hinge], prefix: str = "", turned: Sequence[float] = ()) -> str:
    """Elements of a loop whose first link is the world and whose last hinge closes it.

    The hinges of the tree are where they belong at the angles `turned`, zero unless given: with
    other angles the loop is open at zero.
    """
    frames = [item.frame for item in hinges]
    angles = [*turned, *[0.0] * (len(hinges) - len(turned))]
    links, joints = [], []
    previous = np.eye(4)
    for index, frame in enumerate(frames):
        parent = f"{prefix}l{index}" if index else "ground"
        placed = origin(np.linalg.solve(previous, frame) @ _step(-angles[index], 0.0, 0.0))
        if index + 1 < len(frames):
            links.append(
                f'<link name="{prefix}l{index + 1}"><inertial><origin xyz="0.1 0.05 -0.02"/>'
                f'<mass value="{1.0 + 0.3 * index!r}"/><inertia ixx="0.02" iyy="0.03" izz="0.04" '
                'ixy="0" ixz="0" iyz="0"/></inertial></link>'
            )
            joints.append(
                f'<joint name="{prefix}h{index}" type="continuous"><parent link="{parent}"/>'
                f'<child link="{prefix}l{index + 1}"/>{placed}<axis xyz="0 0 1"/></joint>'
            )
            previous = frame
        else:
            joints.append(
                f'<loop name="{prefix}h{index}" type="continuous"><predecessor link="{parent}">'
                f'{placed}</predecessor><successor link="ground">{origin(frame)}</successor>'
                '<axis xyz="0 0 1"/></loop>'
            )
    return "".join((*links, *joints))


def robot(*elements: str) -> str:
    return f'<robot name="hinges"><link name="ground"/>{"".join(elements)}</robot>'


def rank(hinges: list[Hinge]) -> int:
    """How many of the loop's six closure equations are independent."""
    return int(np.linalg.matrix_rank(np.array([item.screw for item in hinges]), tol=1e-8))


def open_components(hinges: list[Hinge], at: Hinge) -> tuple[str, str]:
    """Components of force and moment at a hinge, in its frame, that self-stresses change."""
    screws = np.array([item.screw for item in hinges])
    _, values, right = np.linalg.svd(screws)
    # Wrenches (force, moment about the world's origin) that do no work on any hinge: a screw's
    # linear part stands beside the force.
    wrenches = right[int(np.sum(values > 1e-8)) :]
    axes = at.frame[:3, :3]
    force = wrenches[:, :3] @ axes
    moment = (wrenches[:, 3:] - np.cross(at.point, wrenches[:, :3])) @ axes
    names = (
        "".join(
            axis
            for axis, values in zip("xyz", part.T, strict=True)
            if np.max(np.abs(values), initial=0.0) > 1e-6
        )
        for part in (force, moment)
    )
    first, second = names
    return first, second


def bennett(alpha: float = 1.1, beta: float = 0.6, theta: float = 1.0) -> list[Hinge]:
    """Four hinges with a / sin α = b / sin β: Bennett (1903)."""
    a, b = 1.0, np.sin(beta) / np.sin(alpha)
    ratio = np.sin(0.5 * (beta + alpha)) / np.sin(0.5 * (beta - alpha))
    second = 2.0 * np.arctan(ratio / np.tan(0.5 * theta))
    rows = [(theta, a, alpha), (second, b, beta), (-theta, a, alpha), (-second, b, beta)]
    return _along(rows)


def bricard(turn: float = 1.9) -> list[Hinge]:
    """Six hinges at right angles with equal lengths, a trihedral linkage: Bricard (1927).

    Every other hinge turns alike, and cos θ + cos φ + cos θ cos φ = 0 closes the loop.
    """
    cosine = np.cos(turn)
    other = np.arccos(-cosine / (1.0 + cosine))
    rows = [(other if i % 2 else turn, 0.3, (-1.0) ** i * 0.5 * np.pi) for i in range(6)]
    frame = np.eye(4)
    for row in rows:
        frame = frame @ _step(*row)
    assert np.max(np.abs(frame - np.eye(4))) < 1e-14
    return _along(rows)


def sarrus() -> list[Hinge]:
    """Two planar chains of three parallel hinges each, in planes at right angles: Sarrus (1853)."""
    corners = ((1, 0, 0), (1.5, 0, 0.6), (1.1, 0, 1.2)), ((0, 1.2, 1.2), (0, 1.7, 0.5), (0, 0.9, 0))
    # Askew in the world, so that no angle of a frame is at the end of its range.
    askew = Rotation.from_rotvec([0.3, -0.4, 0.5]).as_matrix()
    return [
        hinge(askew @ np.array(point), askew @ np.array(axis))
        for points, axis in zip(corners, ((0.0, 1.0, 0.0), (1.0, 0.0, 0.0)), strict=True)
        for point in points
    ]


def planar() -> list[Hinge]:
    """Four parallel hinges."""
    points = ((0.0, 0.0, 0.0), (0.1, 0.4, 0.2), (1.2, 0.9, -0.1), (1.0, 0.0, 0.3))
    return [hinge(point, (0.0, 0.0, 1.0)) for point in points]


def spherical() -> list[Hinge]:
    """Four hinges whose axes meet in a point."""
    centre = np.array([0.3, -0.2, 0.5])
    directions = ((0, 0, 1), (0.3, 0.1, 1), (0.8, 0.7, 0.6), (0.7, -0.2, 0.6))
    return [
        hinge(centre + 0.4 * (k + 1) * np.array(item), item) for k, item in enumerate(directions)
    ]


def goldberg_5(alpha: float = 1.1, beta: float = 0.6, gamma: float = 0.8) -> list[Hinge]:
    """Five hinges: two Bennett loops that share a link, which is left out: Goldberg (1943)."""
    first = _bennett_frames(np.eye(4), alpha, beta, 1.0)
    second = _bennett_frames(first[1], beta, gamma, 0.7)
    one, _, three, four = map(_hinge_of, first)
    _, _, five, six = map(_hinge_of, second)
    # The links from hinge 2 to hinges 1 and 6 are one link now.
    return [one, six, five, three, four]


def goldberg_6(delta: float = 0.5) -> list[Hinge]:
    """Six hinges: a third Bennett loop shares a link of Goldberg's five-hinge loop."""
    first = _bennett_frames(np.eye(4), 1.1, 0.6, 1.0)
    second = _bennett_frames(first[1], 0.6, 0.8, 0.7)
    third = _bennett_frames(second[2], 0.6, delta, 1.3)
    one, _, three, four = map(_hinge_of, first)
    five, _, eight, seven = map(_hinge_of, third)
    return [one, eight, seven, five, three, four]


def line_symmetric(*three: Hinge) -> list[Hinge]:
    """Three hinges, and three more that a half turn about a line makes of them: Bricard (1927).

    The loop may stay symmetric about the line, which leaves it one motion more than the count.
    """
    chosen = three or (
        hinge((0.9, 0.1, -0.3), (0.2, 1.0, 0.5)),
        hinge((0.7, 0.8, 0.2), (1.0, -0.3, 0.6)),
        hinge((-0.2, 1.0, 0.5), (0.4, 0.5, 1.0)),
    )
    half_turn = np.diag([-1.0, -1.0, 1.0])
    return [
        *chosen,
        *(hinge(half_turn @ item.point, half_turn @ item.direction) for item in chosen),
    ]


def altmann() -> list[Hinge]:
    """Six hinges, every other link with axes that meet at right angles: Altmann (1954)."""
    corner = np.array([0.6, 0.5, 0.3])
    second, third = np.array([1.0, 2.0, -1.0]), np.array([3.0, -1.0, 1.0])
    return line_symmetric(
        hinge((1.0, -0.4, 0.2), (0.3, -0.2, 1.0)), hinge(corner, second), hinge(corner, third)
    )


def stretched_sarrus() -> list[Hinge]:
    """Sarrus's loop with both chains stretched: a singular configuration."""
    heights = (0.0, 0.6, 1.3)
    chains = (((1.0, 0.0), (0.0, 1.0, 0.0)), ((0.0, 1.2), (1.0, 0.0, 0.0)))
    askew = Rotation.from_rotvec([0.3, -0.4, 0.5]).as_matrix()
    first, second = (
        [hinge(askew @ np.array((*place, height)), askew @ np.array(axis)) for height in heights]
        for place, axis in chains
    )
    return [*first, *reversed(second)]


def flat_spherical() -> list[Hinge]:
    """Four hinges whose axes meet in a point and lie in a plane: a singular configuration."""
    angles = (0.1, 0.5, 1.6, 1.1)
    return [hinge((0, 0, 0), (np.cos(angle), np.sin(angle), 0.0)) for angle in angles]


def _bennett_frames(start: Array, alpha: float, beta: float, theta: float) -> list[Array]:
    """Frames `(4, 4)` of Bennett's four hinges, x along the link to the next one.

    Args:
        start: the first of them; its link has the twist `alpha`.
        alpha, beta: twists of the links, whose lengths are their sines.
        theta: turn of the second hinge.
    """
    ratio = np.sin(0.5 * (alpha + beta)) / np.sin(0.5 * (alpha - beta))
    other = 2.0 * np.arctan(ratio / np.tan(0.5 * theta))
    frame, frames = start, []
    for twist, turn in ((alpha, theta), (beta, other), (alpha, -theta), (beta, -other)):
        frames.append(frame)
        frame = frame @ _step(0.0, np.sin(twist), twist) @ _step(turn, 0.0, 0.0)
    assert np.max(np.abs(frame - start)) < 1e-9
    return frames


def _hinge_of(frame: Array) -> Hinge:
    return hinge(frame[:3, 3], frame[:3, 2])


def _step(turn: float, length: float, twist: float) -> Array:
    frame = np.eye(4)
    frame[:3, :3] = (Rotation.from_euler("z", turn) * Rotation.from_euler("x", twist)).as_matrix()
    frame[:3, 3] = length * np.array([np.cos(turn), np.sin(turn), 0.0])
    return frame


def _along(rows: list[tuple[float, float, float]]) -> list[Hinge]:
    """Hinges along a chain of (turn, length, twist), the first one at the world's z axis."""
    frame, hinges = np.eye(4), []
    for row in rows:
        hinges.append(hinge(frame[:3, 3], frame[:3, 2]))
        frame = frame @ _step(*row)
    assert np.max(np.abs(frame - np.eye(4))) < 1e-8
    return hinges
