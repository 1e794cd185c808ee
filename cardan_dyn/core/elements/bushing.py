"""Bushing: an elastic joint of six directions between two links."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...kit.arrays import NOTHING, Array, inverse
from ...kit.checks import placement, semidefinite
from ...kit.errors import ArgumentError
from .element import Exerted, LinkElement, LinkWrench, Quantity
from .link_loads import WRENCH_COMPONENTS
from .link_motions import LinkMotion, LinkMotions
from .rotation_vectors import greatest_angle, left_jacobian_inverse_transposed
from .winding import GREATEST_ANGLE, Winding

if TYPE_CHECKING:
    from ..mechanism.mechanism import Mechanism
    from .one_state import OneState


class BushingForce(NamedTuple):
    """What a bushing exerts.

    Attributes:
        wrench: `(N, 6)` on `link_b`, force first, about the bushing's origin in `link_b`, in the
            axes of the bushing's frame in `link_a` [N, N·m]; on `link_a`, the opposite at the same
            point.
        deformation: `(N, 6)` position and rotation vector of the bushing's frame in `link_b`
            relative to that in `link_a`, in the axes of the latter [m, rad].
        energy: `(N,)` that it stores [J].
        dissipation: `(N,)` power that it turns into heat [W].
    """

    wrench: Array
    deformation: Array
    energy: Array
    dissipation: Array


@dataclass(frozen=True, eq=False)
class Bushing(LinkElement):
    """An elastic connection of two links in all six directions, such as a rubber bushing.

    A frame is fixed to each link. The deformation d is the position of the second in the axes of
    the first, then the rotation vector from the first to the second. The energy is ½ dᵀ K d, and
    the elastic wrench is exactly its gradient, at large rotations too. The damper exerts -C times
    the velocity of the second origin as seen from the first frame, then the relative angular
    velocity, in the same axes.

    It remembers how it was wound. Where all joints on a way from one link to the other turn about
    one direction, which both frames then share, their angles add up to the rotation, over any
    number of turns, as a `JointSpring` has it; from 3.1 rad on, the moment has to be along that
    direction. About axes that change, rotations by more than half a turn cannot be told from
    others: beyond 3.1 rad they are refused, as are those that leave half a turn on the straight
    line of joint angles from the description's zero. There it is turned by less than half a turn,
    wherever the angles of joints count from; one that is turned by 3.1 rad there is refused. Balls
    count no turns: where every way between the links leads over one, the rotation is the shortest.

    Attributes:
        link_a, link_b: names of the links, one of which may stand in the world.
        origin: `(3,)` or `(4, 4)` placement of the bushing's frame in `link_a` [m]; kept as
            `(4, 4)`.
        stiffness: `(6, 6)`, symmetric and without a negative direction, or its 6 diagonal values;
            translation first [N/m, N·m/rad]; kept as `(6, 6)`.
        damping: likewise [N·s/m, N·m·s/rad]; none if None.
        origin_b: placement of its frame in `link_b`, like `origin`; if None, the one that is
            without deformation where all joints are at the description's zero.
        name: by which results show it; may be empty.

    Raises:
        ArgumentError: a value is no finite number or of a wrong shape, a matrix is not symmetric or
            negative, a placement is not rigid, or both links are the same.
    """

    group = "bushing"
    quantities = (
        Quantity(
            "wrench",
            "element_wrench",
            "wrench of the bushing on its link_b, in the axes of its frame in link_a",
            ("N",) * 3 + ("N·m",) * 3,
            "wrench_component",
            WRENCH_COMPONENTS,
        ),
        Quantity(
            "deformation",
            "element_deformation",
            "position and rotation vector of the bushing's frame in link_b, in that of link_a",
            ("m",) * 3 + ("rad",) * 3,
            "deformation_component",
            ("x", "y", "z", "turn_x", "turn_y", "turn_z"),
        ),
    )
    link_a: str
    link_b: str
    origin: Array
    stiffness: Array
    damping: Array | None = None
    origin_b: Array | None = None
    name: str = ""

    def __post_init__(self) -> None:
        link_a, link_b = self._two_links()
        expected = "translation first [N/m, N·m/rad]"
        damping = np.zeros(6) if self.damping is None else self.damping
        origin_b = self.origin_b
        self._set(
            link_a=link_a,
            link_b=link_b,
            origin=placement("Bushing: origin", self.origin),
            stiffness=semidefinite("Bushing: stiffness", self.stiffness, expected),
            damping=semidefinite("Bushing: damping", damping, "translation first"),
            origin_b=None if origin_b is None else placement("Bushing: origin_b", origin_b),
            name=self._text("name"),
        )
        super().__post_init__()

    @property
    def conserves(self) -> bool:
        """Whether it has no damping."""
        return not self.damps

    @property
    def damps(self) -> bool:
        """Whether it has damping."""
        return bool(np.any(self.damping))

    def on(self, mechanism: Mechanism, label: str) -> _PlacedBushing:
        """See `Element.on`."""
        return _PlacedBushing(self, mechanism, label)

    def force(self, turn: Array, span: Array, rate: Array, label: str) -> BushingForce:
        """Return what it exerts.

        Args:
            turn: `(N, 3)` rotation vectors of the second frame relative to the first [rad], longer
                than 3.1 rad only where it is wound about an axis that does not change.
            span: `(N, 3)` from the first origin to the second, in the axes of the first [m].
            rate: `(N, 6)` velocity of the second origin as seen from the first frame, then relative
                angular velocity, in the same axes [m/s, rad/s].
            label: how messages call the element.

        Raises:
            ArgumentError: it is wound by more than 3.1 rad, and its stiffness is not symmetric
                about the axis.
        """
        deformation = np.concatenate([span, turn], axis=1)
        gradient = deformation @ self.stiffness
        elastic = gradient.copy()
        square = np.einsum("ni,ni->n", turn, turn)
        far = square > GREATEST_ANGLE**2
        if np.any(far):
            across = np.cross(turn[far], gradient[far, 3:])
            sizes = np.linalg.norm(turn[far], axis=1) * np.linalg.norm(gradient[far, 3:], axis=1)
            if np.any(np.linalg.norm(across, axis=1) > NOTHING * sizes):
                raise ArgumentError(
                    f"{label}: it is wound by {greatest_angle(turn):.4g} rad, and its moment then "
                    "is not along the axis about which it turns; beyond "
                    f"{GREATEST_ANGLE:g} rad, this axis has to be one of the principal axes of its "
                    "rotational stiffness, which nothing couples with translation"
                )
        # Along the axis, the rate of the rotation vector is the angular velocity.
        near = ~far
        elastic[near, 3:] = left_jacobian_inverse_transposed(turn[near], gradient[near, 3:])
        drag = rate @ self.damping
        return BushingForce(
            wrench=-elastic - drag,
            deformation=deformation,
            energy=0.5 * np.einsum("ni,ni->n", gradient, deformation),
            dissipation=np.einsum("ni,ni->n", drag, rate),
        )


class _PlacedBushing:
    """A bushing on a mechanism."""

    def __init__(self, element: Bushing, mechanism: Mechanism, label: str) -> None:
        self._element, self._label = element, label
        given = element.origin_b
        self._end = _without_deformation(mechanism, element) if given is None else given
        from ..mechanism.tree import se3  # Loaded with the mechanism.

        (body_a, frame_a), (body_b, frame_b) = (mechanism.link_frames[k] for k in element.links)
        self._bodies = body_a, body_b
        self._placements = frame_a * se3(np.asarray(element.origin)), frame_b * se3(self._end)
        first, second = (
            (body, place.rotation)
            for body, place in zip(self._bodies, self._placements, strict=True)
        )
        self._winding = Winding(mechanism, first, second)

    def _turns(self, x: Array, rotation: Array) -> Array:
        """Return its rotation vectors `(N, 3)`, whole turns counted.

        Args:
            x: `(N, size)` coordinates; angles count whole turns.
            rotation: `(N, 3, 3)` of its second frame relative to the first.

        Raises:
            ArgumentError: it is turned too far.
        """
        turn, lost = self._winding.turns(x, rotation)
        if np.any(lost):
            raise _too_far(self._label, greatest_angle(turn[lost]))
        return turn

    def at(self, x: Array, v: Array, time: Array, links: Mapping[str, LinkMotion]) -> Exerted:
        """See `Acting.at`."""
        element, count = self._element, len(x)
        at_a, at_b = links[element.link_a], links[element.link_b]
        first, second = at_a.placed(element.origin), at_b.placed(self._end)
        back = first.rotation.transpose(0, 2, 1)
        span = second.position - first.position
        # The velocity that is seen from the first frame, which turns.
        seen = second.velocity - first.velocity - np.cross(first.spin, span)
        rate = np.concatenate(
            [
                np.broadcast_to(np.einsum("nij,nj->ni", back, vector), (count, 3))
                for vector in np.broadcast_arrays(seen, second.spin - first.spin)
            ],
            axis=1,
        )
        span_seen = np.broadcast_to(np.einsum("nij,nj->ni", back, span), (count, 3))
        turn = self._turns(x, np.broadcast_to(back @ second.rotation, (count, 3, 3)))
        done = element.force(turn, span_seen, rate, self._label)
        force, moment = (
            np.einsum("nij,nj->ni", first.rotation, half)
            for half in (done.wrench[:, :3], done.wrench[:, 3:])
        )
        arm_a, arm_b = second.position - at_a.position, second.position - at_b.position
        wrenches = (
            LinkWrench(element.link_a, -force, -moment - np.cross(arm_a, force)),
            LinkWrench(element.link_b, force, moment + np.cross(arm_b, force)),
        )
        return Exerted(done, np.einsum("ni,ni->n", done.wrench, rate), wrenches=wrenches)

    def add(self, efforts: Array, state: OneState) -> None:
        """See `Acting`."""
        import pinocchio  # Only simulations need it.

        (first, second), oMi = self._bodies, state.data.oMi
        a, b = (oMi[body] * at for body, at in zip(self._bodies, self._placements, strict=True))
        seen, element = a.actInv(b), self._element
        if self._winding.is_short(state.x):
            turned = pinocchio.log3(seen.rotation)
            if turned @ turned > GREATEST_ANGLE**2:
                raise _too_far(self._label, float(np.linalg.norm(turned)))
            gradient = element.stiffness @ np.concatenate([seen.translation, turned])
            # The right Jacobian's inverse is the transposed inverse of the left one.
            gradient[3:] = pinocchio.Jlog3(seen.rotation) @ gradient[3:]
            if element.damps:
                gradient += element.damping @ self._rate(state, a, b)
            wrench = -gradient
        else:
            turn = self._turns(state.x[None], seen.rotation[None])
            rate = self._rate(state, a, b) if element.damps else np.zeros(6)
            span = seen.translation[None]
            wrench = element.force(turn, span, rate[None], self._label).wrench[0]
        force, moment = a.rotation @ wrench[:3], a.rotation @ wrench[3:]
        state.push(efforts, second, b.translation, force, moment)
        state.push(efforts, first, b.translation, -force, -moment)

    def _rate(self, state: OneState, a: Any, b: Any) -> Array:
        """Return the velocity `(6,)` of the second frame `b` as the first, `a`, sees it."""
        first, second = self._bodies
        # That of the point of the first body where the second frame's origin is.
        passing = state.velocity(second, b.translation) - state.velocity(first, b.translation)
        spin, back = state.spin(second) - state.spin(first), a.rotation.T
        return np.concatenate([back @ passing, back @ spin])


def _without_deformation(mechanism: Mechanism, element: Bushing) -> Array:
    """Return the `(4, 4)` placement in `link_b` of the frame in `link_a` at the zero."""
    row, rest = mechanism.zero[None], np.zeros((1, mechanism.model.nv))
    at_zero = LinkMotions(mechanism, element.links).at(row, rest)
    first, second = (_matrix(at_zero[link]) for link in element.links)
    return inverse(second) @ first @ element.origin


def _matrix(motion: LinkMotion) -> Array:
    """Return the placement of a frame at the first sample as `(4, 4)`."""
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = motion.rotation[0], motion.position[0]
    return result


def _too_far(label: str, angle: float) -> ArgumentError:
    """Return the error of a bushing that is turned too far, by an angle [rad]."""
    return ArgumentError(
        f"{label}: it is turned by {angle:.4g} rad, or was on the way there by more than half a "
        "turn, about axes that change, or is turned by half a turn at the description's zero "
        f"already, in one sense or the other; it may be turned by {GREATEST_ANGLE:g} rad, farther "
        "only where all joints between its links turn about one direction and keep it. Put it at "
        "a single joint, or use a JointSpring, which counts whole turns"
    )
