"""Clemens's coupling (1869): two shafts and arms between them that meet in balls.

Everything on the second shaft is the mirror image of what is on the first, and the balls lie in
the plane of symmetry: so both shafts turn at the same rate, whatever their angle.
"""

from __future__ import annotations

import numpy as np

from .free_screws import Connection
from .hinge_loops import Hinge, hinge, origin

Array = np.ndarray

_PIN, _RADIUS, _ARM = 0.9, 0.3, 1.0
"""Distance of the pins from the shafts' intersection and axes, and length of the arms [m]."""
_ASKEW = (0.3, 0.5, 0.8)
"""Axis of the balls' frames: at no position is a component of their force zero by symmetry."""


class Clemens:
    """A coupling at one position.

    Attributes:
        shafts: both shafts' bearings.
        pins: for each arm, its pin on the first and on the second shaft.
        balls: `(n, 3)` where the arms meet.
    """

    def __init__(self, bend: float, turns: list[float]) -> None:
        """Make the coupling.

        Args:
            bend: angle between the shafts [rad].
            turns: angles of the arms about the first shaft [rad].
        """
        half = 0.5 * bend
        axis = np.array([np.cos(half), np.sin(half), 0.0])
        normal = np.array([1.0, 0.0, 0.0])
        mirror = np.diag([-1.0, 1.0, 1.0])
        across, up = np.array([-np.sin(half), np.cos(half), 0.0]), np.array([0.0, 0.0, 1.0])
        # Turns have the same sense in the mirror if the image of an axis is turned round.
        self.shafts = hinge(-axis, axis), hinge(-mirror @ axis, -mirror @ axis)
        self.pins: list[tuple[Hinge, Hinge]] = []
        balls = []
        for turn in turns:
            radial = np.cos(turn) * across + np.sin(turn) * up
            pin = hinge(-_PIN * axis + _RADIUS * radial, np.cross(axis, radial))
            image = hinge(mirror @ pin.point, mirror @ pin.direction)
            self.pins.append((pin, image))
            balls.append(_on_plane(pin.point, axis, radial, normal))
        self.balls = np.array(balls)

    def connections(self) -> tuple[int, list[Connection]]:
        """Return the number of bodies and their joints: shafts first, then the arms in pairs."""
        joints = [
            Connection(name, -1, body, shaft.screw[None], shaft.frame)
            for body, (name, shaft) in enumerate(zip(("in", "out"), self.shafts, strict=True))
        ]
        for index, (pins, ball) in enumerate(zip(self.pins, self.balls, strict=True)):
            arms = 2 + 2 * index, 3 + 2 * index
            joints += [
                Connection(f"{side}{index}", body, arm, pin.screw[None], pin.frame)
                for body, (side, arm, pin) in enumerate(zip("pq", arms, pins, strict=True))
            ]
            turns = np.array([hinge(ball, axis).screw for axis in np.eye(3)])
            frame = hinge(ball, _ASKEW).frame
            joints.append(Connection(f"ball{index}", *arms, turns, frame))
        return 2 + len(self.pins) * 2, joints

    def text(self, turned: float = 0.0) -> str:
        """Return its description; all hinges but the bearings are turned out of place at zero."""
        elements = ['<link name="ground"/>']
        for name, shaft in zip(("in", "out"), self.shafts, strict=True):
            elements += [_link(f"shaft_{name}"), _joint(name, "ground", np.eye(4), shaft, 0.0)]
        for index, (pins, ball) in enumerate(zip(self.pins, self.balls, strict=True)):
            ends = []
            at_ball = hinge(ball, _ASKEW).frame
            for side, name, shaft, pin in zip("pq", ("in", "out"), self.shafts, pins, strict=True):
                joint = f"{side}{index}"
                sign = 1.0 if side == "p" else -0.7
                elements += [_link(f"shaft_{joint}")]
                elements += [_joint(joint, f"shaft_{name}", shaft.frame, pin, sign * turned)]
                ends.append(origin(np.linalg.solve(pin.frame, at_ball)))
            elements.append(
                f'<loop name="ball{index}" type="spherical"><predecessor link="shaft_p{index}">'
                f'{ends[0]}</predecessor><successor link="shaft_q{index}">{ends[1]}</successor>'
                "</loop>"
            )
        return f'<robot name="clemens">{"".join(elements)}</robot>'


def _on_plane(pin: Array, axis: Array, radial: Array, normal: Array) -> Array:
    """Return where an arm that swings between two directions reaches a plane through the origin."""
    # normal · (pin + arm (axis cos δ + radial sin δ)) = 0, the solution that points ahead.
    cosine, sine = float(normal @ axis), float(normal @ radial)
    size, phase = np.hypot(cosine, sine), np.arctan2(sine, cosine)
    delta = phase + np.arccos(-float(normal @ pin) / (_ARM * size))
    return np.asarray(pin + _ARM * (np.cos(delta) * axis + np.sin(delta) * radial))


def _link(name: str) -> str:
    return (
        f'<link name="{name}"><inertial><origin xyz="0.1 0.05 -0.02"/><mass value="1.5"/><inertia '
        'ixx="0.02" iyy="0.03" izz="0.04" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


def _joint(name: str, parent: str, above: Array, item: Hinge, turned: float) -> str:
    """Return a hinge that is where it belongs at the angle `turned`."""
    back = np.eye(4)
    back[:2, :2] = [[np.cos(turned), np.sin(turned)], [-np.sin(turned), np.cos(turned)]]
    placed = origin(np.linalg.solve(above, item.frame) @ back)
    return (
        f'<joint name="{name}" type="continuous"><parent link="{parent}"/>'
        f'<child link="shaft_{name}"/>{placed}<axis xyz="0 0 1"/></joint>'
    )
