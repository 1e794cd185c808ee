"""Forced response: amplitudes of coordinates and joint wrenches by orders, over speed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ....core.results.plot import Plot, own_figure
from ....core.results.sweep import FRAMES
from ....core.results.table import Table
from ....kit.arrays import NOTHING, ROUNDED, Array
from ....kit.checks import names, number, numbers, text
from ....kit.errors import ArgumentError, choices
from ....kit.periodic import MOST_NODES, amplitudes, nodes, orders_of, resampled
from ..model.rotating_scene import speeds_of
from ..motions.harmonic_balance import Motions
from ..motions.linear import averaged_motions, linear_motions
from ..motions.residuals import residuals
from ..motions.search import MotionSearch
from .periodic_motion import missed_of, refuse_missed, search_of, states
from .result import VibrationResult, table_of, unit_of

if TYPE_CHECKING:
    from ....figures.style import Figure
    from ....scene.scene import Scene
    from .critical_speeds import CriticalSpeeds

COMPONENTS = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z")


class ForcedResponsePlot(Plot):
    """Draws amplitudes over speed."""

    @own_figure
    def __call__(
        self,
        *columns: Any,
        orders: Any = (1, 2, 4),
        critical: CriticalSpeeds | None = None,
        logarithmic: bool = True,
        **options: Any,
    ) -> Figure:
        """Draw amplitudes of the free coordinates over speed, a line for each order.

        Lines are those of one motion at each speed, mostly the smallest: where a resonance leans
        over, they pass below its peak.

        Args:
            columns: of the table instead, see `Plot`.
            orders: cycles per revolution of the drive `(K,)`; those without amplitudes are left
                out.
            critical: critical speeds of the scene, whose severities and jumps are drawn as points:
                along the branch of motions, what a mode alone gives the coordinate that it moves
                most. Lines have what other modes add or take away as well.
            logarithmic: amplitudes on a logarithmic scale.
            options: `title`, `ax` (one axes) and `figsize`.

        Raises:
            ArgumentError: the orders are no numbers, or as `Plot`.
        """
        from ....figures.critical_speeds import orders_over_speed

        found = self._result
        wanted = np.atleast_1d(numbers("orders", orders)).tolist()
        lines = {
            f"{name}, {order:g}×": np.abs(found.of(name, order))
            for name in found.free
            for order in wanted
            if found._wave(order) is not None
        }
        return orders_over_speed(
            found.speed,
            lines,
            unit=unit_of(found.scene),
            peaks=None if critical is None else critical.peaks(wanted),
            logarithmic=logarithmic,
            **options,
        )


@dataclass(frozen=True, eq=False)
class ForcedResponse(VibrationResult):
    """Amplitudes by orders at S speeds: K orders, n free coordinates, j joints.

    What excites is all in the scene: the joints' orders, unbalance of its links, weight and loads.
    Speeds without a periodic motion have NaN. Phases are those of complex amplitudes:
    q = Re Σ amplitude exp(i order φ), φ the drive's position.

    Attributes:
        scene: whose drive turns at constant speed.
        speed: of the drive `(S,)` [rad/s].
        order: `(K,)` cycles per revolution of the drive.
        amplitude: complex `(S, K, n)` of the free coordinates in the non-linear periodic motion.
        linear: complex `(S, K, n)` by the linear equation with periodic coefficients, about the
            mean of the motion.
        averaged: complex `(S, K, n)` by the linear equation with averaged coefficients.
        linear_error, averaged_error: `(S,)` greatest difference of these from the non-linear
            motion over a period, as a fraction of its greatest distance from its mean.
        residual: `(S,)` see `PeriodicMotion`.
        joints: names of the joints.
        wrench: complex `(S, K, j, 6)` force and moment exerted by each joint's parent on its child
            at the joint origin [N, N·m], in the non-linear motion.
        frame: axes of the wrenches, see `Sweep.wrench`.
        missed: speeds without a motion to the reason.
    """

    scene: Scene
    speed: Array
    order: Array
    amplitude: Array
    linear: Array
    averaged: Array
    linear_error: Array
    averaged_error: Array
    residual: Array
    joints: tuple[str, ...]
    wrench: Array
    frame: str
    missed: Mapping[float, str] = field(default_factory=dict)

    def of(self, name: str, order: float) -> Array:
        """Return the complex amplitude at an order, over speed.

        Args:
            name: of a free coordinate, `(S,)`; or of another joint, `(S, 6)`, see `wrench_of`.
            order: cycles per revolution of the drive.

        Raises:
            ArgumentError: no such name, or no such order.
        """
        if name in self.free:
            return self.amplitude[:, self._known_wave(order), self.free.index(name)]
        if name in self.joints:
            return self.wrench_of(name, order)
        raise ArgumentError(
            f"{name!r} has no amplitudes; {choices((*self.free, *self.joints), name)}"
        )

    def _known_wave(self, order: float) -> int:
        wave = self._wave(number("order", order))
        if wave is None:
            raise ArgumentError(f"order {order:g} is none of those up to {self.order[-1]:g}")
        return wave

    def _wave(self, order: float) -> int | None:
        """Return where an order is among those of the amplitudes, None if it is none of them."""
        found = np.nonzero(np.abs(self.order - order) < NOTHING)[0]
        return int(found[0]) if found.size else None

    def whirls(self, first: str, second: str, order: float) -> tuple[Array, Array]:
        """Return forward and backward circles `(S,)` of which an ellipse consists, by their radii.

        Args:
            first: a free coordinate.
            second: one normal to it; from the first to the second is forward.
            order: cycles per revolution of the drive.

        Raises:
            ArgumentError: no such coordinate or order.
        """
        if first not in self.free or second not in self.free:
            raise ArgumentError(f"{first!r}, {second!r}: free coordinates are {choices(self.free)}")
        along, across = self.of(first, order), self.of(second, order)
        return 0.5 * np.abs(along + 1j * across), 0.5 * np.abs(along - 1j * across)

    def wrench_of(self, joint: str, order: float) -> Array:
        """Return the complex amplitudes `(S, 6)` of a joint's wrench at an order, over speed.

        Args:
            joint: whose wrench is meant, also where a free coordinate has its name.
            order: cycles per revolution of the drive.

        Raises:
            ArgumentError: no such joint, or no such order.
        """
        if joint not in self.joints:
            raise ArgumentError(f"{joint!r} has no wrench; joints: {choices(self.joints, joint)}")
        return self.wrench[:, self._known_wave(order), self.joints.index(joint)]

    def table(self) -> Table:
        """Return a row for each speed, order, and coordinate or wrench component."""
        owners = [(name, "position") for name in self.free]
        owners += [(name, component) for name in self.joints for component in COMPONENTS]
        wrench = self.wrench.reshape(*self.amplitude.shape[:2], -1)
        values = np.moveaxis(np.concatenate([self.amplitude, wrench], axis=2), 2, 0)
        sizes, (names, quantities) = np.abs(values), np.array(owners).T[..., None, None]
        return table_of(
            {
                "speed": (self.speed[:, None], "rad/s"),
                "name": (names, ""),
                "quantity": (quantities, ""),
                "order": (self.order, "1/rev"),
                "amplitude": (sizes, "rad, m, N or N·m"),
                "phase": (np.angle(values), "rad"),
            },
            sizes > ROUNDED * np.nanmax(sizes, axis=(1, 2), initial=0.0, keepdims=True),
        )

    @property
    def plot(self) -> ForcedResponsePlot:
        """Figures: `response.plot()`, amplitudes of the free coordinates over speed by orders."""
        return ForcedResponsePlot(self)

    def __repr__(self) -> str:
        return (
            f"<ForcedResponse of {', '.join(self.free)} at {len(self.speed)} speeds"
            f"{self._without(len(self.missed))}, orders up to {self.order[-1]:g}>"
        )


def forced_response(
    scene: Scene,
    speed: Any,
    *,
    joints: str | Sequence[str] | None = None,
    frame: str = "parent",
    max_amplitude: float = 1.0,
) -> ForcedResponse:
    """Return amplitudes and phases by orders, of every free coordinate and joint wrench.

    Args:
        scene: with one drive and free coordinates.
        speed: of the drive, a number or `(S,)` [rad/s].
        joints: whose wrenches are wanted; the scene's outputs if None, none for an empty list.
        frame: axes of the wrenches, `parent`, `joint` or `world`.
        max_amplitude: see `periodic_motion`.

    Raises:
        CardanError: see `periodic_motion`; speeds without a motion are marked instead.
    """
    if text("frame", frame) not in FRAMES:
        raise ArgumentError(f"frame {frame!r} is unknown; frames: {choices(FRAMES)}")
    search = search_of(scene, max_amplitude)
    wanted = search.rotating.scene.outputs if joints is None else names("joints", joints)
    for name in wanted:
        search.rotating.scene.mechanism.joint(name)
        if name not in search.rotating.scene.outputs:
            raise ArgumentError(f"joint {name!r} is none of the scene's outputs")
    speeds, _ = speeds_of(speed)
    return response_of(search, speeds, tuple(wanted), frame)


def response_of(
    search: MotionSearch, speeds: Array, joints: tuple[str, ...], frame: str
) -> ForcedResponse:
    """Return the response that a search finds; see `forced_response`."""
    found, _ = search.smallest(speeds)
    refuse_missed(search, speeds)
    rotating, free = search.rotating, len(search.rotating.free)
    divisor = found[0].model.divisor
    most = max(motions.model.count for motions in found)
    size, waves = len(speeds), divisor * (most // 2) + 1
    # Wrenches may repeat after the mechanism's whole period alone, and have higher orders than the
    # motion, which are not to be taken for lower ones.
    count = 3 * waves | 1
    # Of the motion, of the linear one, and of the averaged one.
    spectra = np.full((3, size, waves, free), np.nan + 0j)
    errors = np.full((3, size), np.nan)
    wrench = np.full((size, waves, len(joints), 6), np.nan + 0j)
    for motions in found:
        q, index = motions.course.q, motions.index
        every = np.stack([q, linear_motions(motions), averaged_motions(motions)])
        spectrum = amplitudes(every, 2)
        spectra[:, index] = 0.0
        spectra[:, index, : divisor * spectrum.shape[2] : divisor] = spectrum
        # Between the nodes of a motion is more than at them.
        ways = every - np.stack([np.mean(q, axis=1, keepdims=True) + 0.0 * q, q, q])
        scale, *gaps = np.max(np.abs(resampled(ways, MOST_NODES, 2)), axis=(2, 3))
        scale = np.where(scale > 0.0, scale, 1.0)
        errors[:, index] = residuals(motions), *(gap / scale for gap in gaps)
        if joints:
            wrench[index] = _wrenches(search, motions, joints, frame, count)[:, :waves]
    return ForcedResponse(
        scene=rotating.scene,
        speed=speeds,
        order=orders_of(waves, rotating.period),
        amplitude=spectra[0],
        linear=spectra[1],
        averaged=spectra[2],
        linear_error=errors[1],
        averaged_error=errors[2],
        residual=errors[0],
        joints=joints,
        wrench=wrench,
        frame=frame,
        missed=missed_of(search, speeds),
    )


def _wrenches(
    search: MotionSearch, motions: Motions, joints: tuple[str, ...], frame: str, count: int
) -> Array:
    """Return complex amplitudes `(S, K, j, 6)` of wrenches over the mechanism's period."""
    rotating, speed = search.rotating, motions.course.speed
    position = nodes(count, rotating.period)
    waves = amplitudes(motions.course.q, 1)
    found = states(orders_of(waves.shape[1], motions.model.period), waves, speed, position)
    every = found.with_drive(position, speed)
    sweep = rotating.driven.sweep(*(item.reshape(-1, item.shape[2]) for item in every))
    wrenches = [sweep.wrench(name, frame) for name in joints]
    values = np.stack([np.hstack([item.force, item.moment]) for item in wrenches], axis=1)
    return amplitudes(values.reshape(len(speed), count, len(joints), 6), 1)
